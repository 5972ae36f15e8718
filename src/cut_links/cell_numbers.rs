//! Numbers of some cells of a box, looked up at once.

/// Not numbered.
const NONE: u32 = u32::MAX;

/// Numbers of cells, in the order of memory.
#[derive(Debug, Clone, Default)]
pub struct CellNumbers {
    first: [i32; 3],
    size: [usize; 3],
    numbers: Vec<u32>,
}

impl CellNumbers {
    /// Over the box that holds all of some cells, none of them numbered.
    pub fn lay(&mut self, cells: impl Iterator<Item = [i32; 3]>) {
        let mut bounds = [[i32::MAX; 3], [i32::MIN; 3]];
        for cell in cells {
            for a in 0..3 {
                bounds[0][a] = bounds[0][a].min(cell[a]);
                bounds[1][a] = bounds[1][a].max(cell[a]);
            }
        }
        let [first, last] = bounds;
        self.first = first;
        self.size = std::array::from_fn(|a| {
            usize::try_from(i64::from(last[a]) - i64::from(first[a]) + 1).unwrap_or(0)
        });
        self.numbers.clear();
        self.numbers.resize(self.size.iter().product(), NONE);
    }

    fn place(&self, cell: [i32; 3]) -> Option<usize> {
        let mut from = [0; 3];
        for a in 0..3 {
            from[a] = usize::try_from(cell[a].wrapping_sub(self.first[a])).ok()?;
            if from[a] >= self.size[a] {
                return None;
            }
        }
        Some(from[0] + self.size[0] * (from[1] + self.size[1] * from[2]))
    }

    /// Number of a cell; `None` where it has none.
    #[must_use]
    pub fn get(&self, cell: [i32; 3]) -> Option<u32> {
        let number = self.numbers[self.place(cell)?];
        (number != NONE).then_some(number)
    }

    /// What is noted of a cell, to be changed; `None` outside the box.
    pub fn entry(&mut self, cell: [i32; 3]) -> Option<&mut u32> {
        let place = self.place(cell)?;
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
        let [nx, ny, _] = self.size;
        for (row, numbers) in self.numbers.chunks_mut(nx.max(1)).enumerate() {
            let [y, z] = [row % ny.max(1), row / ny.max(1)];
            for (x, number) in numbers.iter_mut().enumerate() {
                if *number == MARKED {
                    *number = listed.len() as u32;
                    let from = [x, y, z];
                    listed.push(std::array::from_fn(|a| self.first[a] + from[a] as i32));
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
