//! The air on CPU threads: D3Q19 streamed in place (see [`crate::lattice::grid`] for the slots).
//!
//! Each array is touched at one fixed shift in a step, so slabs of planes are split off each array with safe borrows.
//! Arrays carry one layer of ghost cells; [`boundaries`] fills in after each step what flows in from there. Rows begin on a cache line
//! (`storage`).

pub mod boundaries;
pub mod collide_stream;
pub mod control_volume;
pub mod cut_links;
pub mod eddy_viscosity;
mod exchanged_ends;
mod extremes;
mod held_eddy_viscosity;
mod link_places;
mod macroscopic;
mod prefetch;
mod sides;
mod sixteen_bits;
mod slabs;
mod storage;
mod stored;
pub mod transfer;

use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::lattice::faces::{AbsorbingSide, FACE_MEANS, FaceMeans};
use crate::lattice::grid::{Grid, Initial, LINE_BYTES, Setup, StreamwiseEnds};
use crate::lattice::links::Boundaries;
use crate::lattice::start::Start;
use crate::lattice::{DIRECTION_COUNT, Real, operators};
pub use collide_stream::{BodyForce, ForcedCells};
use exchanged_ends::ExchangedEnds;
use held_eddy_viscosity::HeldEddyViscosity;
use link_places::LinkPlaces;
use sides::Sides;
use storage::Storage;
pub use stored::Stored;

/// The air: populations, boundaries and the parity of the next step.
#[derive(Debug, Clone)]
pub struct Fluid<P: Stored> {
    setup: Setup,
    grid: Grid,
    /// One array per direction, shifted populations, ghost layer included. Those of a box's ends of rows may wait in `exchanged_ends`.
    populations: Storage<P>,
    sides: Sides,
    /// Sides that let sound out; empty where none does.
    absorbing_sides: Vec<AbsorbingSide>,
    face_means: FaceMeans,
    /// Relaxation time per x, with that of the sponge, to the end of a row's last block.
    relaxation_times: Vec<P::Real>,
    /// `None` where no model needs the velocity gradient.
    held_eddy_viscosity: Option<HeldEddyViscosity<P::Real>>,
    /// `None` but in boxes of finer cells.
    exchanged_ends: Option<ExchangedEnds<P>>,
    /// Of the links that were read last.
    link_places: LinkPlaces,
    inlet_velocity: [f64; 3],
    /// Uniform acceleration of the last step.
    last_acceleration: [f64; 3],
    odd: bool,
    steps: u64,
    /// Vector instructions of this CPU.
    instructions: pulp::Arch,
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Air that begins with the given density excess and velocity, `initial(cell) = (δρ, u)` in lattice units
    /// ([`crate::lattice::start`]); at rest where it is `None`.
    #[must_use]
    pub fn new(setup: Setup, initial: Option<&Initial>) -> Self {
        let block = LINE_BYTES / size_of::<P>();
        let grid = Grid::aligned(setup.cells, block);
        let mut relaxation_times = setup
            .relaxation_profile()
            .unwrap_or_else(|| vec![setup.relaxation_time; setup.cells[0]]);
        let last = (relaxation_times.last().copied()).unwrap_or(setup.relaxation_time);
        relaxation_times.resize(setup.cells[0].next_multiple_of(block), last);
        let mut fluid = Self {
            grid,
            // Populations of air at rest are zero, as they are made.
            populations: Storage::<P>::new(grid.total),
            // The ends of rows are filled in while a row is at hand, in periodic scenes too.
            sides: Sides::new(&Boundaries::new(
                &grid,
                match setup.ends {
                    StreamwiseEnds::Periodic | StreamwiseEnds::InletOutlet => {
                        StreamwiseEnds::InletOutlet
                    }
                    walls @ StreamwiseEnds::Walls(_) => walls,
                },
                setup.sides,
            )),
            absorbing_sides: AbsorbingSide::all(&setup),
            face_means: FaceMeans::at_rest(&setup),
            relaxation_times: relaxation_times.into_iter().map(T::of).collect(),
            held_eddy_viscosity: HeldEddyViscosity::new(&setup),
            exchanged_ends: None,
            link_places: LinkPlaces::default(),
            inlet_velocity: [0.0; 3],
            last_acceleration: [0.0; 3],
            odd: false,
            steps: 0,
            instructions: pulp::Arch::new(),
            setup,
        };
        if let Some(initial) = initial {
            fluid.fill(&Start::new(&fluid.setup, initial));
        }
        fluid
    }

    /// Takes the populations of a start, before the first step.
    pub fn fill(&mut self, start: &Start) {
        self.face_means = FaceMeans::of_start(&self.setup, start);
        if let Some(ends) = &mut self.exchanged_ends {
            ends.forget();
        }
        let [nx, ny, nz] = self.setup.cells;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let cell = [x, y, z];
                    let index = self.grid.index(cell.map(|c| c as i64));
                    for (direction, population) in start.populations(cell).into_iter().enumerate() {
                        let (array, element) = self.grid.slot(index, direction, false);
                        self.populations[array][element] = P::packed(T::of(population));
                    }
                    if x + 1 == nx {
                        // An outlet's ghost remembers the density excess of the last cell.
                        self.populations[0][index + 1] =
                            P::packed(T::of(start.density_excess(cell)));
                    }
                }
            }
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

    /// True after an odd number of steps.
    #[must_use]
    pub const fn is_odd(&self) -> bool {
        self.odd
    }

    /// Velocity at the inlet in the steps to come [cells per step].
    pub const fn set_inlet_velocity(&mut self, velocity: [f64; 3]) {
        self.inlet_velocity = velocity;
    }

    /// Streamed populations of one cell, about to be collided.
    #[inline(always)]
    fn gather(&self, cell: [usize; 3]) -> operators::Populations<T> {
        let waiting = |ends: &ExchangedEnds<P>| ends.waiting_at(cell);
        if let Some(populations) = self.exchanged_ends.as_ref().and_then(waiting) {
            return populations;
        }
        let index = self.grid.index(cell.map(|c| c as i64));
        let mut f = [T::default(); DIRECTION_COUNT];
        f[0] = self.populations[0][index].unpacked();
        let odd = usize::from(self.odd);
        for (pair, shift) in self.grid.pair_shifts().into_iter().enumerate() {
            let first = 2 * pair + 1;
            f[first] = self.populations[first + 1 - odd][index].unpacked();
            f[first + 1] =
                self.populations[first + odd][index.wrapping_add_signed(shift)].unpacked();
        }
        f
    }
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Writes populations, parity and step count; arrays without the padding of rows, as every engine does.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("air_steps", &[self.steps, u64::from(self.odd)])?;
        out.put("inlet_velocity", &self.inlet_velocity)?;
        let packed_grid = Grid::new(self.setup.cells);
        let mut packed = Vec::with_capacity(packed_grid.total);
        for array in 0..DIRECTION_COUNT {
            packed.clear();
            for row in self.grid.rows() {
                packed.extend_from_slice(&self.populations[array][row]);
            }
            let waiting = self.exchanged_ends.iter();
            for cell in waiting.flat_map(ExchangedEnds::waiting_cells) {
                let index = packed_grid.index(cell.map(|c| c as i64));
                for (direction, population) in self.gather(cell).into_iter().enumerate() {
                    let (its_array, element) = packed_grid.slot(index, direction, self.odd);
                    if its_array == array {
                        packed[element] = P::packed(population);
                    }
                }
            }
            out.put(&format!("populations_{array:02}"), &packed)?;
        }
        if self.face_means.count() > 0 {
            out.put(FACE_MEANS, &self.face_means.joined())?;
        }
        if let Some(held) = &self.held_eddy_viscosity {
            out.put("eddy_relaxation_times", &held.relaxation_times)?;
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
        if let Some(ends) = &mut self.exchanged_ends {
            ends.forget();
        }
        let packed_grid = Grid::new(self.setup.cells);
        for array in 0..DIRECTION_COUNT {
            let packed: Vec<P> =
                from.take_exactly(&format!("populations_{array:02}"), packed_grid.total)?;
            for (row, packed_row) in self.grid.rows().zip(packed_grid.rows()) {
                self.populations[array][row].copy_from_slice(&packed[packed_row]);
            }
        }
        let means = self.face_means.count();
        if means > 0 {
            self.face_means.take(&from.take_exactly(FACE_MEANS, means)?);
        }
        if let Some(held) = &mut self.held_eddy_viscosity {
            held.restore(from.take_exactly("eddy_relaxation_times", self.grid.cell_count())?);
        }
        Ok(())
    }
}
