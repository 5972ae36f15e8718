//! What is read of all the air, from the finest cells that each place has.
//!
//! Cells under a box of finer ones do not count, nor does the shell of a box ([`crate::lattice::nest`]) before the lattices stand at one time.

use super::Levels;
use super::air::AirEngine;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::gpu::DeviceError;
use crate::lattice::grid::{CellState, Extremes};
use crate::lattice::nest::{Level, Nest};

/// Fine cells at the faces of a box that a step spoils.
const SHELL_CELLS: usize = 2;

/// Cells from `first` to before `end`.
type Block = ([usize; 3], [usize; 3]);

/// The parts of blocks that lie outside a box of a lattice.
fn outside(blocks: Vec<Block>, nest: &Nest) -> Vec<Block> {
    let hole: Block = (
        nest.first,
        std::array::from_fn(|a| nest.first[a] + nest.cells[a]),
    );
    let mut parts = Vec::new();
    for (first, end) in blocks {
        let cut: Block = (
            std::array::from_fn(|a| first[a].max(hole.0[a])),
            std::array::from_fn(|a| end[a].min(hole.1[a])),
        );
        if (0..3).any(|a| cut.0[a] >= cut.1[a]) {
            parts.push((first, end));
            continue;
        }
        // Below and above the cut along z, then y, then x.
        let (mut low, mut high) = (first, end);
        for a in [2, 1, 0] {
            let (mut below, mut above) = ((low, high), (low, high));
            below.1[a] = cut.0[a];
            above.0[a] = cut.1[a];
            for (first, end) in [below, above] {
                if first[a] < end[a] {
                    parts.push((first, end));
                }
            }
            (low[a], high[a]) = (cut.0[a], cut.1[a]);
        }
    }
    parts
}

/// The farther and the faster of two finds.
fn more_extreme(a: Extremes, b: Extremes) -> Extremes {
    let speed = |state: &CellState| state.speed;
    let fastest = [a.fastest, b.fastest].into_iter().flatten();
    let excess = |state: &CellState| state.density_excess.abs();
    let farther = !b.farthest.is_finite() || excess(&b.farthest) > excess(&a.farthest);
    Extremes {
        fastest: fastest.max_by(|a, b| speed(a).total_cmp(&speed(b))),
        farthest: if a.farthest.is_finite() && farther {
            b.farthest
        } else {
            a.farthest
        },
    }
}

impl Levels {
    /// Lattices in the order of [`crate::case::scene::Air::levels`].
    pub fn engines(&self) -> Vec<&AirEngine> {
        let inner = self.boxes().flat_map(|(_, inner)| inner.engines());
        std::iter::once(self.engine()).chain(inner).collect()
    }

    fn lattices(&self) -> Vec<&Self> {
        let inner = self.boxes().flat_map(|(_, inner)| inner.lattices());
        std::iter::once(self).chain(inner).collect()
    }

    fn save_within(&self, out: &mut Writer, number: &mut usize) -> std::io::Result<()> {
        match *number {
            0 => self.engine().save(out)?,
            box_number => self.engine().save(&mut out.within(&section(box_number)))?,
        }
        *number += 1;
        self.boxes()
            .try_for_each(|(_, inner)| inner.save_within(out, number))
    }

    /// All lattices, which stand at one time.
    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        if !self.stand_together() {
            return Err(std::io::Error::other(
                "boxes of finer cells are ahead of the air around them",
            ));
        }
        self.save_within(out, &mut 0)
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        self.each_engine(&mut 0, &mut |number, engine| match number {
            0 => engine.restore(from),
            box_number => engine.restore(&from.within(&section(box_number))),
        })
    }

    /// What stands out among all cells that count, whose places are in cells of the size around the structure; `levels` are those of the scene.
    pub fn extremes(&self, levels: &[Level]) -> Result<Option<Extremes>, DeviceError> {
        let finest = levels.iter().map(|level| level.depth).max().unwrap_or(0);
        let mut found: Option<Extremes> = None;
        for (lattice, level) in self.lattices().into_iter().zip(levels) {
            let margin: [usize; 3] = level.spans.map(|spans| match level.depth > 0 && !spans {
                true => SHELL_CELLS,
                false => 0,
            });
            let whole = (margin, std::array::from_fn(|a| level.cells[a] - margin[a]));
            let blocks = lattice
                .boxes()
                .fold(vec![whole], |blocks, (nest, _)| outside(blocks, nest));
            let size = 1 << (finest - level.depth);
            let placed = |state: CellState| CellState {
                cell: std::array::from_fn(|a| level.corner[a] + size * state.cell[a] + size / 2),
                ..state
            };
            for (first, end) in blocks {
                if let Some(here) = lattice.engine().extremes(first, end)? {
                    let here = Extremes {
                        fastest: here.fastest.map(placed),
                        farthest: placed(here.farthest),
                    };
                    found = Some(match found {
                        Some(before) => more_extreme(before, here),
                        None => here,
                    });
                }
            }
        }
        Ok(found)
    }

    /// Σ δρ and Σ ½ ρ u² over all cells that count, in cells of the outermost lattice.
    pub fn mass_and_energy(&self) -> Result<(f64, f64), DeviceError> {
        if self.boxes().next().is_none() {
            return self.engine().mass_and_energy();
        }
        let [nx, ny, _] = self.engine().grid().cells;
        let (mut mass, mut energy) = (0.0, 0.0);
        for (i, (excess, u)) in self.engine().macroscopic()?.into_iter().enumerate() {
            let cell = [i % nx, i / nx % ny, i / nx / ny];
            if !self.boxes().any(|(nest, _)| nest.covers(cell)) {
                let excess = f64::from(excess);
                let square: f64 = u.iter().map(|u| f64::from(*u).powi(2)).sum();
                mass += excess;
                energy += 0.5 * (1.0 + excess) * square;
            }
        }
        for (_, inner) in self.boxes() {
            let (own_mass, own_energy) = inner.mass_and_energy()?;
            mass += own_mass / 8.0;
            energy += own_energy / 8.0;
        }
        Ok((mass, energy))
    }

    /// Density excess and velocity of single places, in cells of the size around the structure: those of the finest cell there.
    pub fn states_of(
        &self,
        levels: &[Level],
        places: &[[usize; 3]],
    ) -> Result<Vec<(f64, [f64; 3])>, DeviceError> {
        let finest = levels.iter().map(|level| level.depth).max().unwrap_or(0);
        let holder = |place: &[usize; 3]| {
            let holds = |level: &Level| {
                let size = 1 << (finest - level.depth);
                (0..3).all(|a| {
                    let reach = level.corner[a]..level.corner[a] + size * level.cells[a];
                    reach.contains(&place[a])
                })
            };
            levels.iter().rposition(holds).unwrap_or(0)
        };
        let mut found = vec![(0.0, [0.0; 3]); places.len()];
        for (number, (engine, level)) in self.engines().into_iter().zip(levels).enumerate() {
            let (own, cells): (Vec<usize>, Vec<[usize; 3]>) = (places.iter().enumerate())
                .filter(|(_, place)| holder(place) == number)
                .map(|(i, place)| {
                    let size = 1 << (finest - level.depth);
                    let cell = std::array::from_fn(|a| (place[a] - level.corner[a]) / size);
                    (i, cell)
                })
                .unzip();
            if cells.is_empty() {
                continue;
            }
            for (i, state) in own.into_iter().zip(engine.states_of(&cells)?) {
                found[i] = state;
            }
        }
        Ok(found)
    }
}

fn section(box_number: usize) -> String {
    format!("box_{box_number}/")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks outside two boxes hold every other cell once.
    #[test]
    fn blocks_hold_what_is_outside_once() {
        let nests = [([3, 4, 3], [6, 5, 7]), ([14, 3, 4], [5, 9, 5])].map(|(first, cells)| Nest {
            first,
            cells,
            spans: [false; 3],
        });
        let whole = ([0; 3], [24, 16, 14]);
        let blocks = nests.iter().fold(vec![whole], outside);
        for z in 0..14 {
            for y in 0..16 {
                for x in 0..24 {
                    let cell = [x, y, z];
                    let held = |(first, end): &&Block| {
                        (0..3).all(|a| (first[a]..end[a]).contains(&cell[a]))
                    };
                    let times = blocks.iter().filter(held).count();
                    let covered = nests.iter().any(|nest| nest.covers(cell));
                    assert_eq!(times, usize::from(!covered), "{cell:?}");
                }
            }
        }
    }
}
