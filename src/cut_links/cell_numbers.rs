//! Numbers of some cells of a box, looked up at once.

use super::cell_box::CellBox;

/// Not numbered.
const NONE: u32 = u32::MAX;

/// Numbers of cells, in the order of memory.
#[derive(Debug, Clone, Default)]
pub struct CellNumbers {
    cells: CellBox,
    numbers: Vec<u32>,
}

impl CellNumbers {
    /// Over the box that holds all of some cells, none of them numbered.
    pub fn lay(&mut self, cells: impl Iterator<Item = [i32; 3]>) {
        self.cells = CellBox::around(cells);
        self.numbers.clear();
        self.numbers.resize(self.cells.count(), NONE);
    }

    /// Number of a cell; `None` where it has none.
    #[must_use]
    pub fn get(&self, cell: [i32; 3]) -> Option<u32> {
        let number = self.numbers[self.cells.place(cell)?];
        (number != NONE).then_some(number)
    }

    /// What is noted of a cell, to be changed; `None` outside the box.
    fn entry(&mut self, cell: [i32; 3]) -> Option<&mut u32> {
        let place = self.cells.place(cell)?;
        Some(&mut self.numbers[place])
    }

    /// Numbers `cells` that have no number, in the order of memory, and lists them behind those that `listed` holds.
    pub fn number(&mut self, cells: impl Iterator<Item = [i32; 3]>, listed: &mut Vec<[i32; 3]>) {
        const MARKED: u32 = NONE - 1;
        for cell in cells {
            if let Some(entry) = self.entry(cell)
                && *entry == NONE
            {
                *entry = MARKED;
            }
        }
        let length = self.cells.row_length().max(1);
        for (row, numbers) in self.numbers.chunks_mut(length).enumerate() {
            for (x, number) in numbers.iter_mut().enumerate() {
                if *number == MARKED {
                    *number = listed.len() as u32;
                    listed.push(self.cells.cell(row, x));
                }
            }
        }
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
        numbers.lay(first.into_iter().chain(later));
        let mut listed = Vec::new();
        numbers.number(first.into_iter(), &mut listed);
        assert_eq!(listed, [[2, 1, 1], [1, 2, 1], [3, 1, 2]]);
        numbers.number(later.into_iter(), &mut listed);
        assert_eq!(listed[3..], [[1, 1, 1], [2, 3, 2]]);
        for (number, cell) in listed.iter().enumerate() {
            assert_eq!(numbers.get(*cell), Some(number as u32));
        }
        for cell in [[3, 3, 1], [0, 1, 1], [1, 1, 9]] {
            assert_eq!(numbers.get(cell), None);
        }
        numbers.lay(std::iter::empty());
        assert_eq!(numbers.get([2, 1, 1]), None);
    }
}
