//! The air on CPU threads: D3Q19 streamed in place by *esoteric pull* (Lehmann 2022, doi:10.3390/computation10060092).
//!
//! One array per direction holds all populations. In a step of even or odd parity, cell n and direction pair
//! (i, i+1) own the two slots
//!
//! | parity | local slot | slot at n + c_i |
//! |---|---|---|
//! | even | i + 1 | i |
//! | odd  | i | i + 1 |
//!
//! From the local slot comes f_i, from the other f_{i+1}; after the collision f_i goes to the other slot and
//! f_{i+1} to the local one, which is exactly where the next step, of the other parity, expects them.
//! No two cells touch the same slot in a step, and each array is touched at one fixed shift, so slabs of planes
//! are split off each array with safe borrows.
//! Arrays carry one layer of ghost cells; [`boundaries`] fills in after each step what flows in from there.

pub mod boundaries;
pub mod collide_stream;
pub mod control_volume;
mod macroscopic;

use crate::checkpoint::{CheckpointError, Reader, Writer};
pub use crate::lattice::Operator;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real, equilibrium, operators};
use boundaries::Boundaries;
pub use boundaries::{Sides, StreamwiseEnds};
pub use collide_stream::{BodyForce, ForcedCells};
pub use macroscopic::Breakdown;

/// All that defines the air, in lattice units.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// What lies upstream and downstream.
    pub ends: StreamwiseEnds,
    /// What lies beside, below and above.
    pub sides: Sides,
    /// Relaxation time τ; ν = (τ − ½)/3.
    pub relaxation_time: f64,
    /// Length of the viscous sponge before the outlet [cells]; `None` without one.
    pub sponge_cells: Option<f64>,
    /// Collision operator.
    pub operator: Operator,
    /// Smagorinsky constant C_s; `None` switches the eddy viscosity off.
    pub smagorinsky_constant: Option<f64>,
}

/// Relaxation time at the very end of the sponge (ν = 1/6).
pub const SPONGE_RELAXATION_TIME: f64 = 1.0;

/// The air: populations, boundaries and the parity of the next step.
#[derive(Debug, Clone)]
pub struct Fluid<T: Real> {
    setup: Setup,
    grid: Grid,
    /// One array per direction, shifted populations, ghost layer included.
    populations: Vec<Vec<T>>,
    boundaries: Boundaries,
    /// Relaxation time per x [cells]; `None` without a sponge.
    relaxation_profile: Option<Vec<T>>,
    inlet_velocity: [f64; 3],
    odd: bool,
    steps: u64,
}

/// Index arithmetic on the grid with its ghost layer.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Cells along x, y, z without ghosts.
    pub cells: [usize; 3],
    stride_y: usize,
    stride_z: usize,
    total: usize,
    /// Index shifts of the first directions of the nine pairs.
    pair_shifts: [isize; 9],
}

impl Grid {
    /// Grid of `cells` with one ghost layer around it.
    #[must_use]
    pub const fn new(cells: [usize; 3]) -> Self {
        let stride_y = cells[0] + 2;
        let stride_z = stride_y * (cells[1] + 2);
        let mut pair_shifts = [0; 9];
        let mut pair = 0;
        while pair < 9 {
            let [x, y, z] = DIRECTIONS[2 * pair + 1];
            pair_shifts[pair] =
                x as isize + y as isize * stride_y as isize + z as isize * stride_z as isize;
            pair += 1;
        }
        Self {
            cells,
            stride_y,
            stride_z,
            total: stride_z * (cells[2] + 2),
            pair_shifts,
        }
    }

    /// Cells without ghosts.
    #[must_use]
    pub const fn cell_count(&self) -> usize {
        self.cells[0] * self.cells[1] * self.cells[2]
    }

    /// Array index of a cell; −1 and `cells` address the ghost layer.
    #[inline(always)]
    fn index(&self, cell: [i64; 3]) -> usize {
        let [x, y, z] = cell.map(|c| (c + 1) as usize);
        x + y * self.stride_y + z * self.stride_z
    }

    /// Array and element that hold the population of `direction` about to be read by the cell at array index
    /// `index` in a step of the given parity.
    #[inline(always)]
    fn slot(&self, index: usize, direction: usize, odd: bool) -> (usize, usize) {
        if direction == 0 {
            return (0, index);
        }
        let first = if direction % 2 == 1 {
            direction
        } else {
            direction - 1
        };
        if direction == first {
            (if odd { first } else { first + 1 }, index)
        } else {
            (
                if odd { first + 1 } else { first },
                index.wrapping_add_signed(self.pair_shifts[first / 2]),
            )
        }
    }
}

impl<T: Real> Fluid<T> {
    /// Air at equilibrium with the given density excess and velocity, `initial(cell) = (δρ, u)` in lattice units.
    #[must_use]
    pub fn new(setup: Setup, initial: impl Fn([usize; 3]) -> (f64, [f64; 3])) -> Self {
        let grid = Grid::new(setup.cells);
        let mut populations = vec![vec![T::default(); grid.total]; DIRECTION_COUNT];
        let [nx, ny, nz] = setup.cells;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let (density_excess, velocity) = initial([x, y, z]);
                    let index = grid.index([x as i64, y as i64, z as i64]);
                    for direction in 0..DIRECTION_COUNT {
                        let (array, element) = grid.slot(index, direction, false);
                        populations[array][element] =
                            T::of(equilibrium(direction, density_excess, velocity));
                    }
                }
            }
        }
        let relaxation_profile = setup.sponge_cells.map(|length| {
            (0..nx)
                .map(|x| {
                    let from_outlet = nx as f64 - (x as f64 + 0.5);
                    let depth = (1.0 - from_outlet / length).clamp(0.0, 1.0);
                    let added = (SPONGE_RELAXATION_TIME - setup.relaxation_time).max(0.0);
                    T::of(setup.relaxation_time + added * depth * depth)
                })
                .collect()
        });
        Self {
            grid,
            populations,
            boundaries: Boundaries::new(&grid, setup.ends, setup.sides),
            relaxation_profile,
            inlet_velocity: [0.0; 3],
            odd: false,
            steps: 0,
            setup,
        }
    }

    /// What the air was built from.
    #[must_use]
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Velocity at the inlet in the steps to come [cells per step].
    pub const fn set_inlet_velocity(&mut self, velocity: [f64; 3]) {
        self.inlet_velocity = velocity;
    }

    /// Streamed populations of one cell, about to be collided.
    #[inline(always)]
    fn gather(&self, index: usize) -> operators::Populations<T> {
        let mut f = [T::default(); DIRECTION_COUNT];
        f[0] = self.populations[0][index];
        let odd = usize::from(self.odd);
        for (pair, shift) in self.grid.pair_shifts.into_iter().enumerate() {
            let first = 2 * pair + 1;
            f[first] = self.populations[first + 1 - odd][index];
            f[first + 1] = self.populations[first + odd][index.wrapping_add_signed(shift)];
        }
        f
    }
}

impl<T: Real> Fluid<T> {
    /// Writes populations, parity and step count.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("air_steps", &[self.steps, u64::from(self.odd)])?;
        out.put("inlet_velocity", &self.inlet_velocity)?;
        for (array, data) in self.populations.iter().enumerate() {
            out.put(&format!("populations_{array:02}"), data)?;
        }
        Ok(())
    }

    /// Takes them from a checkpoint of the same grid and precision.
    pub fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let counters: Vec<u64> = from.take_exactly("air_steps", 2)?;
        self.steps = counters[0];
        self.odd = counters[1] == 1;
        self.inlet_velocity
            .copy_from_slice(&from.take_exactly::<f64>("inlet_velocity", 3)?);
        for (array, data) in self.populations.iter_mut().enumerate() {
            *data = from.take_exactly(&format!("populations_{array:02}"), data.len())?;
        }
        Ok(())
    }
}
