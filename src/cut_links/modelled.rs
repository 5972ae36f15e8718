//! What images know for a model of the boundary layer, laid out by faces of the surface.

use glam::DVec3;

use super::boundary_layer::{Face, Seen};

/// What an image knows for a model of the boundary layer. While it is found, cells are named by their places in boxes, and the image has no number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Off {
    /// The face that gives the stress.
    pub(super) face: u32,
    /// Number of the image.
    pub(super) image: u32,
    /// Its link and side.
    pub(super) link: u32,
    pub(super) side: u8,
    /// The cells off the wall from which velocities are taken, and their distances from the wall [cells].
    pub(super) cells: [u32; 2],
    pub(super) heights: [f64; 2],
}

/// Of all images where a layer is modelled, in the order of faces.
#[derive(Debug, Clone, Default)]
pub(super) struct Modelled {
    off: Vec<Off>,
    /// Where those of each face begin, and their end.
    starts: Vec<u32>,
}

impl Modelled {
    /// Lays them out; `found` may be in any order, which those of a face keep.
    pub(super) fn lay(&mut self, found: &[Off]) {
        let faces = found.iter().map(|off| off.face + 1).max().unwrap_or(0);
        self.starts.clear();
        self.starts.resize(faces as usize + 1, 0);
        for off in found {
            self.starts[off.face as usize + 1] += 1;
        }
        for face in 1..self.starts.len() {
            self.starts[face] += self.starts[face - 1];
        }
        let mut next = self.starts.clone();
        self.off.clear();
        let Some(first) = found.first() else { return };
        self.off.resize(found.len(), *first);
        for off in found {
            let place = &mut next[off.face as usize];
            self.off[*place as usize] = *off;
            *place += 1;
        }
    }

    pub(super) fn all(&self) -> &[Off] {
        &self.off
    }

    /// Means of what the images of a face see; `velocities` tells those of one. `None` where it has no image.
    pub(super) fn seen(&self, face: Face, velocities: impl Fn(&Off) -> [DVec3; 2]) -> Option<Seen> {
        let range = self.starts.get(face..face + 2)?;
        let off = &self.off[range[0] as usize..range[1] as usize];
        let mut sum = Seen::default();
        for off in off {
            let velocities = velocities(off);
            for k in 0..2 {
                sum.velocities[k] += velocities[k];
                sum.heights[k] += off.heights[k];
            }
        }
        let of_one = 1.0 / off.len() as f64;
        (!off.is_empty()).then(|| Seen {
            velocities: sum.velocities.map(|velocity| velocity * of_one),
            heights: sum.heights.map(|height| height * of_one),
        })
    }
}
