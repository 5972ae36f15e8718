//! Runs of planes, split off all arrays with safe borrows: each array is touched at one fixed shift in a step.

use super::stored::Stored;
use crate::lattice::grid::{Grid, LINE_BYTES};
use crate::lattice::{DIRECTION_COUNT, opposite};

/// For each direction the part of its array that some planes touch.
pub(super) type Arrays<'a, P> = [&'a mut [P]; DIRECTION_COUNT];

/// Elements before the first cell of a row in a slab, one block. So the ghost cells at both ends of a row lie in its slab, and rows begin
/// with a whole vector.
pub(super) const fn lead<P>() -> usize {
    LINE_BYTES / size_of::<P>()
}

/// Splits off runs of so many `planes` each, one after the other, by the direction that reads an array in a step of the given parity. A row begins
/// [`lead`] elements behind its planes' and rows' strides.
pub(super) fn split<'a, P: Stored>(
    arrays: Arrays<'a, P>,
    grid: &Grid,
    odd: bool,
    planes: impl Iterator<Item = usize> + Clone,
) -> Vec<Arrays<'a, P>> {
    let mut slabs: Vec<Arrays<'a, P>> = (planes.clone())
        .map(|_| std::array::from_fn(|_| Default::default()))
        .collect();
    for (array, data) in arrays.into_iter().enumerate() {
        // 'Local' slots are read by the first of a pair.
        let direction = if array == 0 || odd {
            array
        } else {
            opposite(array)
        };
        let shift = if direction % 2 == 0 && direction > 0 {
            grid.pair_shifts()[direction / 2 - 1]
        } else {
            0
        };
        let first = (grid.index([0, 0, 0]) - lead::<P>()).wrapping_add_signed(shift);
        let mut rest = data.split_at_mut(first).1;
        for (slab, planes) in slabs.iter_mut().zip(planes.clone()) {
            let length = (planes * grid.stride_z).min(rest.len());
            let (head, tail) = rest.split_at_mut(length);
            slab[direction] = head;
            rest = tail;
        }
    }
    slabs
}
