//! Cells of a step that wait for the structure, where all others go ahead ([`super::collide_ahead`]).

use super::parameters::StepParameters;

/// Values of [`StepParameters::part`], as in `shaders/step_parameters.wgsl`; 0 are all cells.
pub(super) const OUTSIDE_BOX: u32 = 1;
pub(super) const IN_BOX: u32 = 2;

/// Cells between the box and the faces of the air, at least: what enters through the faces is worked out with the first part.
const LEAST_GAP: i32 = 3;

/// Largest share of all cells that may wait: beyond, little is left to go ahead with.
const LARGEST_SHARE: f64 = 0.25;

/// A box of cells that wait.
#[derive(Debug, Clone, Copy)]
pub(super) struct Awaited {
    pub(super) first: [u32; 3],
    pub(super) size: [u32; 3],
}

impl Awaited {
    /// From one cell to before another; `None` where it comes too near to the faces of air of so many cells, or holds too many of them.
    pub(super) fn new([first, end]: [[i32; 3]; 2], cells: [usize; 3]) -> Option<Self> {
        let fits = |a: usize| {
            first[a] >= LEAST_GAP && first[a] < end[a] && end[a] + LEAST_GAP <= cells[a] as i32
        };
        let share = |a: usize| f64::from(end[a] - first[a]) / cells[a] as f64;
        let few = (0..3).map(share).product::<f64>() <= LARGEST_SHARE;
        ((0..3).all(fits) && few).then(|| Self {
            first: first.map(|place| place as u32),
            size: std::array::from_fn(|a| (end[a] - first[a]) as u32),
        })
    }

    pub(super) fn put(&self, part: u32, parameters: &mut StepParameters) {
        parameters.box_first[..3].copy_from_slice(&self.first);
        parameters.box_size[..3].copy_from_slice(&self.size);
        parameters.part = part;
    }
}
