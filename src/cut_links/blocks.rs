//! Blocks of cells along a wall where the air slides. The sides of links in one hold their energy together ([`super::energy`]), and share what they lose ([`super::reflections`]).

use std::ops::Range;

use rustc_hash::FxHashMap;

/// Edge of the blocks of cells whose links share among them what they lose beyond what passes along a plane, and which give the air as much energy as along one [cells].
///
/// A link that gets its own loss back is rough, the whole wall is too far off. Of a section of 24 cells lift was 7, 4, 2 % too low with blocks of 1, 2, 4 cells
/// before energy was held; it had a thrust of 0.000, 0.004 and 0.010 (docs/results/2026-11-27-thrust-of-sliding-walls.md).
const BLOCK: i32 = 4;

/// Cut links of a cell from which on it shares with no other, half of all: in tight folds it would fill up (docs/results/2026-11-26-sliding-in-creases.md).
const CROWDED: u32 = 9;

/// Sides that one task works on, or more.
const SIDES_AT_ONCE: usize = 1024;

/// What tells blocks apart: the space that their sides look at, whether they are one crowded cell, and where they lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Key {
    space: u32,
    crowded: bool,
    place: [i32; 3],
}

impl Key {
    /// Of a side that looks at a space, and whose cell has so many links that are cut.
    pub fn new(space: u32, cell: [i32; 3], cut: u32) -> Self {
        let crowded = cut >= CROWDED;
        Self {
            space,
            crowded,
            place: if crowded {
                cell
            } else {
                cell.map(|place| place.div_euclid(BLOCK))
            },
        }
    }
}

/// Blocks, and which sides are in them; sides are numbered block by block.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks {
    numbers: FxHashMap<Key, u32>,
    /// Where the sides of each begin; one more at the end.
    starts: Vec<u32>,
    /// The space that each looks at.
    spaces: Vec<u32>,
    /// Sum of the weights of its sides, and of those of all sides that look at a space.
    weights: Vec<f64>,
    weights_of_spaces: Vec<f64>,
    /// Blocks that one task works on.
    tasks: Vec<Range<usize>>,
}

impl Blocks {
    /// Lays them out for sides with these keys and weights; into `order` goes which of them is the next, block by block. Returns the place of each side in that order, and its block.
    pub fn lay(
        &mut self,
        sides: impl Iterator<Item = (Key, f64)>,
        order: &mut Vec<u32>,
    ) -> Vec<[u32; 2]> {
        self.numbers.clear();
        self.spaces.clear();
        self.weights.clear();
        self.starts.clear();
        self.starts.push(0);
        // Links that follow each other are mostly in the same blocks, one on either side.
        let mut last: [Option<(Key, u32)>; 2] = [None; 2];
        let mut placed: Vec<[u32; 2]> = sides
            .map(|(key, weight)| {
                let held = last.into_iter().flatten().find(|(held, _)| *held == key);
                let block = if let Some((_, block)) = held {
                    block
                } else {
                    *self.numbers.entry(key).or_insert_with(|| {
                        self.spaces.push(key.space);
                        self.weights.push(0.0);
                        self.starts.push(0);
                        self.spaces.len() as u32 - 1
                    })
                };
                if held.is_none() {
                    last = [last[1], Some((key, block))];
                }
                self.weights[block as usize] += weight;
                self.starts[block as usize + 1] += 1;
                [0, block]
            })
            .collect();
        for block in 0..self.count() {
            self.starts[block + 1] += self.starts[block];
        }
        order.clear();
        order.resize(placed.len(), 0);
        let mut next = self.starts.clone();
        for (side, [place, block]) in (0..).zip(&mut placed) {
            let next = &mut next[*block as usize];
            *place = *next;
            order[*next as usize] = side;
            *next += 1;
        }
        let spaces = self.spaces.iter().max().map_or(0, |most| most + 1);
        self.weights_of_spaces.clear();
        self.weights_of_spaces.resize(spaces as usize, 0.0);
        for (space, weight) in self.spaces.iter().zip(&self.weights) {
            self.weights_of_spaces[*space as usize] += weight;
        }
        self.lay_tasks();
        placed
    }

    fn lay_tasks(&mut self) {
        self.tasks.clear();
        let mut first = 0;
        for block in 0..self.count() {
            let sides = self.starts[block + 1] - self.starts[first];
            if sides as usize >= SIDES_AT_ONCE || block + 1 == self.count() {
                self.tasks.push(first..block + 1);
                first = block + 1;
            }
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.spaces.len()
    }

    /// How many tasks work on them.
    #[cfg(test)]
    pub fn task_count(&self) -> usize {
        self.tasks.len()
    }

    /// Blocks by tasks, and what is by block and by side split as they are.
    pub fn tasks<'a, B, S>(
        &'a self,
        by_block: &'a mut [B],
        by_side: &'a mut [S],
    ) -> Vec<(Range<usize>, &'a mut [B], &'a mut [S])> {
        assert_eq!(by_block.len(), self.count(), "one for each block");
        let (mut blocks, mut sides) = (by_block, by_side);
        let split = |task: &Range<usize>| {
            let of_task = self.starts[task.end] - self.starts[task.start];
            (
                task.clone(),
                blocks.split_off_mut(..task.len()).unwrap_or_default(),
                sides.split_off_mut(..of_task as usize).unwrap_or_default(),
            )
        };
        self.tasks.iter().map(split).collect()
    }

    /// Numbers of the sides in a block.
    pub fn sides(&self, block: usize) -> Range<usize> {
        self.starts[block] as usize..self.starts[block + 1] as usize
    }

    /// The space that a block looks at.
    pub fn space(&self, block: usize) -> u32 {
        self.spaces[block]
    }

    /// Sum of the weights of its sides.
    pub fn weight(&self, block: usize) -> f64 {
        self.weights[block]
    }

    /// Sums of the weights of all sides that look at each space.
    pub fn weights_of_spaces(&self) -> &[f64] {
        &self.weights_of_spaces
    }

    /// What every side of each block gets by its weight. What passes along planes goes in equal parts to all sides that look at the same space, what is lost beyond it to those of the block.
    /// Returns what passes along planes in all spaces, loss and gain alike.
    pub fn share(&self, losses: &[LossOfBlock], given: &mut Vec<f64>) -> f64 {
        let mut along = vec![0.0; self.weights_of_spaces.len()];
        for (space, loss) in self.spaces.iter().zip(losses) {
            along[*space as usize] += loss.along;
        }
        let of_all = along.iter().map(|lost: &f64| lost.abs()).sum();
        for (lost, weight) in along.iter_mut().zip(&self.weights_of_spaces) {
            *lost /= weight.max(f64::MIN_POSITIVE);
        }
        given.clear();
        let blocks = (self.spaces.iter().zip(&self.weights)).zip(losses);
        given.extend(blocks.map(|((space, weight), loss)| {
            along[*space as usize] + loss.beyond / weight.max(f64::MIN_POSITIVE)
        }));
        of_all
    }
}

/// What the sides of a block lose.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LossOfBlock {
    /// Along a plane.
    pub along: f64,
    /// Beyond that.
    pub beyond: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sides of two spaces in one place, and of a crowded cell, share each by themselves; all that is lost is given back.
    #[test]
    fn what_is_lost_is_given_back() {
        let keys = [
            Key::new(0, [1, 2, 3], 4),
            Key::new(1, [2, 2, 3], 4),
            Key::new(0, [3, 3, 3], 5),
            Key::new(0, [3, 3, 3], CROWDED),
            Key::new(1, [-1, 2, 3], 4),
            Key::new(0, [0, 0, 0], 1),
        ];
        let weights = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        let (mut blocks, mut order) = (Blocks::default(), Vec::new());
        let placed = blocks.lay(keys.into_iter().zip(weights), &mut order);
        assert_eq!(order, [0, 2, 5, 1, 3, 4]);
        assert_eq!(placed, [[0, 0], [3, 1], [1, 0], [4, 2], [5, 3], [2, 0]]);
        assert_eq!(blocks.count(), 4);
        assert_eq!(blocks.sides(0), 0..3);
        let losses = [0.7, -0.4, 0.1, 0.1].map(|along| LossOfBlock {
            along,
            beyond: 0.5 - along * along,
        });
        let mut given = Vec::new();
        let of_all = blocks.share(&losses, &mut given);
        // 0.8 in the first space, −0.3 in the other.
        assert!((of_all - 1.1).abs() < 1e-15, "{of_all}");
        let of_spaces = [0.8 / 1.4, -0.3 / 0.7];
        let of_blocks = [(0, 1.0), (1, 0.2), (0, 0.4), (1, 0.5)];
        for ((given, loss), (space, weight)) in given.iter().zip(losses).zip(of_blocks) {
            let expected = of_spaces[space] + loss.beyond / weight;
            assert!((given - expected).abs() < 1e-14, "{given} {expected}");
        }
        let back: f64 = (0..4)
            .flat_map(|block| blocks.sides(block).map(move |side| (block, side)))
            .map(|(block, side)| given[block] * weights[order[side] as usize])
            .sum();
        let lost: f64 = losses.iter().map(|loss| loss.along + loss.beyond).sum();
        assert!((back - lost).abs() < 1e-14, "{back} {lost}");
    }
}
