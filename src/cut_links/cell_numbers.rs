//! Numbers of some cells of a box, looked up at once.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::cell_box::CellBox;

/// Not numbered, and to be numbered.
const NONE: u32 = u32::MAX;
const MARKED: u32 = NONE - 1;

/// Rows of cells that one task numbers.
const ROWS_AT_ONCE: usize = 64;

/// Numbers of cells, in the order of memory.
#[derive(Debug, Default)]
pub(super) struct CellNumbers {
    cells: CellBox,
    /// Empty before the first is numbered.
    numbers: Vec<AtomicU32>,
}

impl CellNumbers {
    /// For cells of a box, none of them numbered.
    pub(super) fn lay(&mut self, cells: CellBox) {
        self.cells = cells;
        self.numbers.clear();
    }

    /// Place of a cell in the box; that of none outside.
    #[inline]
    pub(super) fn place(&self, cell: [i32; 3]) -> u32 {
        self.cells.place(cell).map_or(NONE, |place| place as u32)
    }

    /// Number of the cell at a place, which has one.
    #[inline]
    pub(super) fn at(&self, place: u32) -> u32 {
        let number =
            (self.numbers.get(place as usize)).map(|number| number.load(Ordering::Relaxed));
        debug_assert!(
            number.is_some_and(|number| number < MARKED),
            "{place} has no number"
        );
        number.unwrap_or_default()
    }

    /// Numbers the cells at `places` that have no number, in the order of memory, and lists them behind those that `listed` holds.
    pub(super) fn number(
        &mut self,
        places: impl ParallelIterator<Item = u32>,
        listed: &mut Vec<[i32; 3]>,
    ) {
        if self.numbers.is_empty() {
            (self.numbers).resize_with(self.cells.count(), || AtomicU32::new(NONE));
        }
        let numbers = &self.numbers;
        // All tasks write the same.
        places.for_each(|place| {
            if let Some(number) = numbers.get(place as usize)
                && number.load(Ordering::Relaxed) == NONE
            {
                number.store(MARKED, Ordering::Relaxed);
            }
        });
        let length = self.cells.row_length().max(1);
        let is_marked = |number: &&AtomicU32| number.load(Ordering::Relaxed) == MARKED;
        let parts = || self.numbers.par_chunks(ROWS_AT_ONCE * length);
        let counts: Vec<usize> = parts()
            .map(|part| part.iter().filter(is_marked).count())
            .collect();
        let before = listed.len();
        let firsts: Vec<usize> = (counts.iter())
            .scan(before, |next, count| {
                *next += count;
                Some(*next - count)
            })
            .collect();
        let of_parts: Vec<Vec<[i32; 3]>> = (parts().zip(firsts).zip(counts).enumerate())
            .map(|(part, ((numbers, first), count))| {
                let mut cells = Vec::with_capacity(count);
                for (row, numbers) in numbers.chunks(length).enumerate() {
                    for (x, number) in numbers.iter().enumerate() {
                        if is_marked(&number) {
                            number.store((first + cells.len()) as u32, Ordering::Relaxed);
                            cells.push(self.cells.cell(part * ROWS_AT_ONCE + row, x));
                        }
                    }
                }
                cells
            })
            .collect();
        listed.extend(of_parts.into_iter().flatten());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each once, along x first, those that are numbered later behind the others; cells outside and such as were not named have none.
    #[test]
    fn cells_are_numbered_in_the_order_of_memory() {
        let first = [[3, 1, 2], [1, 2, 1], [2, 1, 1], [3, 1, 2]];
        let later = [[2, 1, 1], [1, 1, 1], [2, 3, 2]];
        let mut numbers = CellNumbers::default();
        numbers.lay(CellBox::around(first.into_iter().chain(later)));
        let mut listed = Vec::new();
        for (cells, wanted) in [
            (&first[..], &[[2, 1, 1], [1, 2, 1], [3, 1, 2]][..]),
            (&later, &[[1, 1, 1], [2, 3, 2]]),
        ] {
            let before = listed.len();
            let places: Vec<u32> = cells.iter().map(|cell| numbers.place(*cell)).collect();
            numbers.number(places.into_par_iter(), &mut listed);
            assert_eq!(listed[before..], *wanted);
        }
        for (number, cell) in listed.iter().enumerate() {
            assert_eq!(numbers.at(numbers.place(*cell)), number as u32);
        }
        let unnamed = numbers.place([3, 3, 1]) as usize;
        assert_eq!(numbers.numbers[unnamed].load(Ordering::Relaxed), NONE);
        for cell in [[3, 4, 1], [0, 1, 1], [1, 1, 9]] {
            assert_eq!(numbers.place(cell), NONE);
        }
        numbers.lay(CellBox::default());
        numbers.number([NONE].into_par_iter(), &mut listed);
        assert_eq!(listed.len(), 5);
    }

    /// More rows than one task numbers.
    #[test]
    fn numbers_go_on_from_task_to_task() {
        let cells: Vec<[i32; 3]> = (0..20)
            .flat_map(|z| (0..20).map(move |y| [(y + z) % 3, y, z]))
            .collect();
        let mut numbers = CellNumbers::default();
        numbers.lay(CellBox::around(cells.iter().copied()));
        let mut listed = Vec::new();
        let places: Vec<u32> = cells
            .iter()
            .rev()
            .map(|cell| numbers.place(*cell))
            .collect();
        numbers.number(places.into_par_iter(), &mut listed);
        assert_eq!(listed, cells);
        for (number, cell) in cells.iter().enumerate() {
            assert_eq!(numbers.at(numbers.place(*cell)), number as u32);
        }
    }
}
