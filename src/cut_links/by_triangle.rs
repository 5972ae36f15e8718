//! Cuts in the order of triangles.

use std::ops::Range;

use rayon::prelude::*;

use super::bounce::SIDES;
use super::search::{CutLink, CutLinks};

/// Links that one task works on.
const LINKS_AT_ONCE: usize = 4096;

/// Link and side.
type OnLink = (u32, u8);

/// Where the cuts of each of some triangles begin, and the cuts, in the order of links. `cut` are the triangles at the two sides of every link.
fn cuts_of(cut: &[[u32; 2]], some: Range<usize>) -> (Vec<u32>, Vec<OnLink>) {
    let of = |triangle: u32| {
        let triangle = triangle as usize;
        some.contains(&triangle).then(|| triangle - some.start)
    };
    let mut starts = vec![0; some.len() + 1];
    for triangle in cut.iter().flatten().filter_map(|triangle| of(*triangle)) {
        starts[triangle + 1] += 1;
    }
    for triangle in 0..some.len() {
        starts[triangle + 1] += starts[triangle];
    }
    let mut cuts = vec![OnLink::default(); starts[some.len()] as usize];
    // Every start moves to the next one while its cuts are laid down.
    for (number, triangles) in cut.iter().enumerate() {
        for side in SIDES {
            if let Some(triangle) = of(triangles[side]) {
                let place = &mut starts[triangle];
                cuts[*place as usize] = (number as u32, side as u8);
                *place += 1;
            }
        }
    }
    starts.rotate_right(1);
    starts[0] = 0;
    starts.truncate(some.len());
    (starts, cuts)
}

/// The cuts of every triangle, in the order of links.
#[derive(Debug, Clone, Default)]
pub struct CutsByTriangle {
    /// Where those of a triangle begin; one more at the end.
    starts: Vec<u32>,
    cuts: Vec<OnLink>,
    /// Triangles with cuts.
    triangles: Vec<u32>,
    /// Number of the search for the links, and how many triangles.
    made_of: (u64, usize),
}

impl CutsByTriangle {
    /// Sorts the cuts of the first `count` triangles, anew where the links are others.
    pub fn sort(&mut self, links: &CutLinks, count: usize) {
        if self.made_of != (links.search(), count) {
            self.sort_anew(links.links(), count);
            self.made_of = (links.search(), count);
        }
    }

    fn sort_anew(&mut self, links: &[CutLink], count: usize) {
        let cut = |link: &CutLink| SIDES.map(|side| link.cuts[side].triangle);
        let triangles: Vec<[u32; 2]> = (links.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(cut)
            .collect();
        // Every task goes through all links, and takes those of its triangles.
        let tasks = (links.len() / LINKS_AT_ONCE).clamp(1, rayon::current_num_threads());
        let of_a_task = count.div_ceil(tasks).max(1);
        let parts: Vec<_> = (0..count.div_ceil(of_a_task))
            .into_par_iter()
            .map(|task| {
                let first = task * of_a_task;
                cuts_of(&triangles, first..(first + of_a_task).min(count))
            })
            .collect();
        self.starts.clear();
        self.cuts.clear();
        for (starts, cuts) in parts {
            let before = self.cuts.len() as u32;
            self.starts
                .extend(starts.iter().map(|start| before + start));
            self.cuts.extend(cuts);
        }
        self.starts.push(self.cuts.len() as u32);
        self.triangles.clear();
        let is_cut = |triangle: &usize| self.starts[*triangle] < self.starts[*triangle + 1];
        let all = (0..count).filter(is_cut);
        self.triangles.extend(all.map(|triangle| triangle as u32));
    }

    /// Triangles that are cut.
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Links and sides of the cuts of a triangle.
    #[must_use]
    pub fn of(&self, triangle: u32) -> &[OnLink] {
        let [first, end] = [0, 1].map(|k| self.starts[triangle as usize + k] as usize);
        &self.cuts[first..end]
    }
}
