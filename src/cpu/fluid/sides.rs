//! Which runs of populations are copied through the sides, and through walls at the ends.

use crate::lattice::links::{Boundaries, Run};

/// Arrays that reflection at walls exchanges only among themselves: directions alike but for their signs.
pub(super) const FAMILIES: [&[usize]; 6] = [
    &[1, 2],
    &[3, 4],
    &[5, 6],
    &[7, 8, 13, 14],
    &[9, 10, 15, 16],
    &[11, 12, 17, 18],
];

/// Copies through the sides, and through walls at the ends.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// For even and odd steps, by family.
    pub(super) runs: [[Vec<Run>; FAMILIES.len()]; 2],
}

impl Sides {
    pub(super) fn new(links: &Boundaries) -> Self {
        let runs = links.copies.each_ref().map(|runs| {
            FAMILIES.map(|family| {
                let mine = |run: &&Run| family.contains(&usize::from(run.to_array));
                runs.iter().filter(mine).copied().collect()
            })
        });
        Self { runs }
    }
}
