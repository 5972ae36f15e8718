//! Cuts in the order of triangles.

use super::bounce::SIDES;
use super::search::CutLink;

/// The cuts of every triangle, in the order of links.
#[derive(Debug, Clone, Default)]
pub struct CutsByTriangle {
    /// Where those of a triangle begin; one more at the end.
    starts: Vec<u32>,
    /// Link and side.
    cuts: Vec<(u32, u8)>,
    /// Triangles with cuts.
    triangles: Vec<u32>,
}

impl CutsByTriangle {
    /// Sorts the cuts of the first `count` triangles anew.
    pub fn sort(&mut self, links: &[CutLink], count: usize) {
        let of = |link: &CutLink, side: usize| {
            let triangle = link.cuts[side].triangle as usize;
            (triangle < count).then_some(triangle)
        };
        self.starts.clear();
        self.starts.resize(count + 1, 0);
        for link in links {
            for triangle in SIDES.iter().filter_map(|side| of(link, *side)) {
                self.starts[triangle + 1] += 1;
            }
        }
        self.triangles.clear();
        for triangle in 0..count {
            if self.starts[triangle + 1] > 0 {
                self.triangles.push(triangle as u32);
            }
            self.starts[triangle + 1] += self.starts[triangle];
        }
        self.cuts.clear();
        self.cuts
            .resize(self.starts[count] as usize, Default::default());
        // Every start moves to the next one while its cuts are laid down.
        for (number, link) in links.iter().enumerate() {
            for side in SIDES {
                if let Some(triangle) = of(link, side) {
                    let place = &mut self.starts[triangle];
                    self.cuts[*place as usize] = (number as u32, side as u8);
                    *place += 1;
                }
            }
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// Triangles that are cut.
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Links and sides of the cuts of a triangle.
    #[must_use]
    pub fn of(&self, triangle: u32) -> &[(u32, u8)] {
        let [first, end] = [0, 1].map(|k| self.starts[triangle as usize + k] as usize);
        &self.cuts[first..end]
    }
}
