//! The grid: sizes, slots of populations, and what is set up on it. Shared by all engines.
//!
//! Streaming in place by *esoteric pull* (Lehmann 2022, doi:10.3390/computation10060092): one array per direction holds all
//! populations. In a step of even or odd parity, cell n and direction pair (i, i+1) own the two slots
//!
//! | parity | local slot | slot at n + c_i |
//! |---|---|---|
//! | even | i + 1 | i |
//! | odd  | i | i + 1 |
//!
//! From the local slot comes f_i, from the other f_{i+1}; after the collision f_i goes to the other slot and
//! f_{i+1} to the local one, which is exactly where the next step, of the other parity, expects them.
//! No two cells touch the same slot in a step. Arrays carry one layer of ghost cells.

use std::sync::Arc;

use super::eddy_viscosity::EddyViscosity;
use super::nest::IdleCells;
use super::{DIRECTIONS, Operator};

/// Density excess and velocity of every cell at the start, in lattice units.
pub type Initial<'a> = dyn Fn([usize; 3]) -> (f64, [f64; 3]) + Sync + 'a;

/// What lies upstream (−x) and downstream (+x).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StreamwiseEnds {
    /// The domain repeats along x.
    Periodic,
    /// Velocity inlet at −x, pressure outlet at +x; both let sound out.
    InletOutlet,
    /// A wall at −x and one at +x.
    Walls([Wall; 2]),
}

/// What lies beside (±y), below and above (±z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sides {
    /// The domain repeats along y and z.
    Periodic,
    /// Frictionless impermeable walls.
    FreeSlip,
    /// Each of y and z by itself.
    Each([Faces; 2]),
}

impl Sides {
    /// True of y and z if the domain repeats along them.
    #[must_use]
    pub const fn repeat(&self) -> [bool; 2] {
        match self {
            Self::Periodic => [true; 2],
            Self::FreeSlip => [false; 2],
            Self::Each([y, z]) => [matches!(y, Faces::Periodic), matches!(z, Faces::Periodic)],
        }
    }

    /// What lies at the ends of y and z, in the order lower y, upper y, lower z, upper z.
    #[must_use]
    pub fn in_words(&self) -> String {
        let faces = match self {
            Self::Periodic => [Faces::Periodic; 2],
            Self::FreeSlip => [Faces::Walls([Wall::FreeSlip; 2]); 2],
            Self::Each(faces) => *faces,
        };
        let words: Vec<&str> = faces
            .into_iter()
            .flat_map(|faces| match faces {
                Faces::Periodic => ["periodic"; 2],
                Faces::Walls(walls) => walls.map(Wall::in_words),
            })
            .collect();
        if words.iter().all(|word| *word == words[0]) {
            return words[0].to_owned();
        }
        format!("y {}, {}; z {}, {}", words[0], words[1], words[2], words[3])
    }
}

/// What lies at both ends of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Faces {
    /// The domain repeats.
    Periodic,
    /// Walls at the lower and the upper end.
    Walls([Wall; 2]),
}

/// An impermeable wall midway between the outermost cells and their ghosts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wall {
    /// Frictionless.
    FreeSlip,
    /// Frictionless, and lets sound out ([`super::faces`]); along x as [`Wall::FreeSlip`].
    Absorbing,
    /// The face of a box of finer cells. Nothing is copied through it: what cells there find, which they sent themselves two steps before, reaches no cell that counts.
    /// The velocity goes on beyond it.
    OfBox,
    /// The air sticks to it.
    NoSlip {
        /// Velocity of the wall, in its own plane [cells per step].
        velocity: [f64; 3],
    },
}

impl Wall {
    /// A wall at rest to which the air sticks.
    pub const AT_REST: Self = Self::NoSlip { velocity: [0.0; 3] };

    const fn in_words(self) -> &'static str {
        match self {
            Self::FreeSlip => "frictionless",
            Self::Absorbing => "absorbing",
            Self::OfBox => "of a box",
            Self::NoSlip { .. } => "no slip",
        }
    }

    /// True if the air slides along it.
    #[must_use]
    pub const fn is_frictionless(self) -> bool {
        matches!(self, Self::FreeSlip | Self::Absorbing | Self::OfBox)
    }
}

/// Wind at the inlet that is not the same everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct InletProfile {
    /// Of every cell, y fastest, `[ny · nz]`.
    rows: Arc<[ProfileRow]>,
    /// Cells along y and z.
    section: [usize; 2],
}

/// The wind at one cell of the inlet, over the inlet's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileRow {
    /// Its speed.
    pub ratio: f64,
    /// Rates of change of the speed along y and z [1/cell].
    pub shear: [f64; 2],
}

impl InletProfile {
    /// With the ratio `of` a cell's y and z, for a section of so many cells.
    pub fn new([_, ny, nz]: [usize; 3], of: impl Fn(usize, usize) -> f64) -> Self {
        // Central differences, one-sided at the sides.
        let between = |i: usize, n: usize| (i.saturating_sub(1), (i + 1).min(n - 1));
        let rows = (0..ny * nz)
            .map(|i| {
                let (y, z) = (i % ny, i / ny);
                let ((south, north), (below, above)) = (between(y, ny), between(z, nz));
                let rate = |rise: f64, cells: usize| rise / cells.max(1) as f64;
                ProfileRow {
                    ratio: of(y, z),
                    shear: [
                        rate(of(north, z) - of(south, z), north - south),
                        rate(of(y, above) - of(y, below), above - below),
                    ],
                }
            })
            .collect();
        Self {
            rows,
            section: [ny, nz],
        }
    }

    /// Speed over the inlet's in the cell at these shares of the section's width and height; outside, that of the nearest cell.
    #[must_use]
    pub fn ratio_at(&self, shares: [f64; 2]) -> f64 {
        let cell = |axis: usize| {
            let cells = self.section[axis];
            // Below 0 and not a number: cell 0.
            ((shares[axis] * cells as f64) as usize).min(cells - 1)
        };
        self.rows[cell(0) + cell(1) * self.section[0]].ratio
    }

    /// Of every cell, y fastest.
    #[must_use]
    pub fn rows(&self) -> &[ProfileRow] {
        &self.rows
    }

    /// Their mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.rows.iter().map(|row| row.ratio).sum::<f64>() / self.rows.len() as f64
    }

    /// The largest of them.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.rows.iter().map(|row| row.ratio).fold(0.0, f64::max)
    }
}

/// All that defines the air, in lattice units.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// What lies upstream and downstream.
    pub ends: StreamwiseEnds,
    /// Where the wind is not the same everywhere at the inlet.
    pub inlet_profile: Option<InletProfile>,
    /// What lies beside, below and above.
    pub sides: Sides,
    /// Relaxation time τ; ν = (τ − ½)/3.
    pub relaxation_time: f64,
    /// Length of the viscous sponge before the outlet [cells]; `None` without one.
    pub sponge_cells: Option<f64>,
    /// Cells that steps leave out, as far as it saves time; `None` without boxes of finer cells.
    pub idle: Option<IdleCells>,
    /// Collision operator.
    pub operator: Operator,
    /// Eddy viscosity; `None` without one.
    pub eddy_viscosity: Option<EddyViscosity>,
}

impl Setup {
    /// A box that repeats along all axes, without a model of its eddies.
    #[must_use]
    pub const fn periodic(cells: [usize; 3], relaxation_time: f64, operator: Operator) -> Self {
        Self {
            cells,
            ends: StreamwiseEnds::Periodic,
            sides: Sides::Periodic,
            relaxation_time,
            inlet_profile: None,
            sponge_cells: None,
            idle: None,
            operator,
            eddy_viscosity: None,
        }
    }

    /// Axes along which the domain repeats.
    #[must_use]
    pub const fn repeats(&self) -> [bool; 3] {
        let [y, z] = self.sides.repeat();
        [matches!(self.ends, StreamwiseEnds::Periodic), y, z]
    }

    /// Relaxation time of every x [cells]; `None` without a sponge.
    #[must_use]
    pub fn relaxation_profile(&self) -> Option<Vec<f64>> {
        let length = self.sponge_cells?;
        let nx = self.cells[0];
        let added = (SPONGE_RELAXATION_TIME - self.relaxation_time).max(0.0);
        let depth = |x: usize| {
            let from_outlet = nx as f64 - (x as f64 + 0.5);
            (1.0 - from_outlet / length).clamp(0.0, 1.0)
        };
        Some(
            (0..nx)
                .map(|x| self.relaxation_time + added * depth(x) * depth(x))
                .collect(),
        )
    }
}

/// Bytes of a cache line, on which rows begin on the CPU.
pub const LINE_BYTES: usize = 64;

/// Relaxation time at the very end of the sponge (ν = 1/6).
pub const SPONGE_RELAXATION_TIME: f64 = 1.0;

/// Share of its density excess that an outlet loses per step, times the cells between inlet and outlet (see
/// [`crate::cpu::fluid::boundaries`]).
pub const OUTLET_RELAXATION: f64 = 0.4;

/// Delay of sound between the last cell and the ghost of an outlet [steps]. A wave needs 1/(c_s + U) = 1.5 to 1.7; the rest makes up for the
/// viscous stress of the wave, which a ghost at equilibrium lacks. Found by `ripstop validate acoustic-pulse` for the regularised
/// operator at small viscosity.
pub const OUTLET_DELAY: f64 = 0.65;

/// Change of velocity over that of density, in units of c_s, of a wave that leaves through an outlet: cos θ between those of waves at 0° and
/// 30° to its normal, which come back alike.
pub const OUTLET_COSINE: f64 = 0.93;

/// A cell with its density and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellState {
    /// The cell.
    pub cell: [usize; 3],
    /// Its density excess δρ.
    pub density_excess: f64,
    /// Its bare speed |u*| [cells per step].
    pub speed: f64,
}

impl CellState {
    /// Largest |δρ| of a sound cell.
    pub const DENSITY_LIMIT: f64 = 0.5;

    /// True if density and speed are finite.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.density_excess.is_finite() && self.speed.is_finite()
    }

    /// True if the cell is finite, slower than `speed_limit` [cells per step], and its density no farther off than the limit.
    #[must_use]
    pub fn is_sound(&self, speed_limit: f64) -> bool {
        self.speed < speed_limit && self.density_excess.abs() < Self::DENSITY_LIMIT
    }
}

/// The cells of a box that stand out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// The fastest cell among those that are finite; `None` where no cell is.
    pub fastest: Option<CellState>,
    /// The first cell that is not finite; where all are, the cell with the largest |δρ|.
    pub farthest: CellState,
}

impl Extremes {
    /// The same in cells that are counted from elsewhere.
    #[must_use]
    pub fn moved_by(self, corner: [usize; 3]) -> Self {
        let moved = |state: CellState| CellState {
            cell: std::array::from_fn(|a| state.cell[a] + corner[a]),
            ..state
        };
        Self {
            fastest: self.fastest.map(moved),
            farthest: moved(self.farthest),
        }
    }

    /// A cell that is not sound, if there is one: the fastest finite one first, then that with the largest |δρ|.
    #[must_use]
    pub fn breakdown(&self, speed_limit: f64) -> Option<CellState> {
        let found = [self.fastest, Some(self.farthest)];
        let mut unsound = found.into_iter().flatten();
        unsound.find(|state| !state.is_sound(speed_limit))
    }
}

/// Index arithmetic on the grid with its ghost layer.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Cells along x, y, z without ghosts.
    pub cells: [usize; 3],
    /// Elements from row to row.
    pub stride_y: usize,
    /// Elements from plane to plane.
    pub stride_z: usize,
    /// Elements of an array, ghost layer included.
    pub total: usize,
    /// Elements before the first ghost cell.
    lead: usize,
    pair_shifts: [isize; 9],
}

/// Elements to a multiple of which a device's planes, or rows, are padded.
pub const PADDED_ELEMENTS: usize = 32;

impl Grid {
    /// Grid of `cells` with one ghost layer around it, without gaps: the layout of checkpoints.
    #[must_use]
    pub const fn new(cells: [usize; 3]) -> Self {
        Self::aligned(cells, 1)
    }

    /// The same grid with rows padded, so that the element of the first cell (x = 0) of every row is a multiple of `alignment`, and so many elements
    /// lie behind every row.
    #[must_use]
    pub const fn aligned(cells: [usize; 3], alignment: usize) -> Self {
        let grid = Self::with_strides(cells, [alignment, 1], alignment - 1);
        Self {
            total: grid.total + alignment - 1,
            ..grid
        }
    }

    /// The same grid with rows and planes padded to multiples of so many elements each, from the first ghost cell on.
    #[must_use]
    pub const fn padded(cells: [usize; 3], multiples: [usize; 2]) -> Self {
        Self::with_strides(cells, multiples, 0)
    }

    const fn with_strides(cells: [usize; 3], [rows, planes]: [usize; 2], lead: usize) -> Self {
        let stride_y = (cells[0] + 2).next_multiple_of(rows);
        let stride_z = (stride_y * (cells[1] + 2)).next_multiple_of(planes);
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
            total: lead + stride_z * (cells[2] + 2),
            lead,
            pair_shifts,
        }
    }

    /// Elements of every row, ghost cells at its ends included, row after row.
    pub fn rows(&self) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let Self {
            cells,
            stride_y,
            stride_z,
            lead,
            ..
        } = *self;
        (0..cells[2] + 2).flat_map(move |z| {
            (0..cells[1] + 2).map(move |y| {
                let first = lead + y * stride_y + z * stride_z;
                first..first + cells[0] + 2
            })
        })
    }

    /// Shifts of elements along the first directions of the nine pairs.
    #[inline(always)]
    #[must_use]
    pub const fn pair_shifts(&self) -> [isize; 9] {
        self.pair_shifts
    }

    /// Cells without ghosts.
    #[must_use]
    pub const fn cell_count(&self) -> usize {
        self.cells[0] * self.cells[1] * self.cells[2]
    }

    /// Array index of a cell; −1 and `cells` address the ghost layer.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, cell: [i64; 3]) -> usize {
        let [x, y, z] = cell.map(|c| (c + 1) as usize);
        self.lead + x + y * self.stride_y + z * self.stride_z
    }

    /// Array and element that hold the population of `direction` about to be read by the cell at array index
    /// `index` in a step of the given parity.
    #[inline(always)]
    #[must_use]
    pub const fn slot(&self, index: usize, direction: usize, odd: bool) -> (usize, usize) {
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

/// Velocity of the cell beyond a face, as the boundary condition makes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beyond {
    /// That of the cell at the opposite face.
    Periodic,
    /// factor · u + offset, component by component, of the last cell before the face.
    Ghost {
        /// −1 for what a wall turns round, 1 for what it keeps or an outlet repeats, 0 for an inlet.
        factor: [f64; 3],
        /// Velocity of the inlet, or twice that of a wall [cells per step].
        offset: [f64; 3],
    },
    /// The straight line through the last two cells before the face.
    Extrapolated,
}

/// Lower and upper face of every axis.
#[must_use]
pub fn beyond(setup: &Setup, inlet_velocity: [f64; 3]) -> [[Beyond; 2]; 3] {
    let wall = |axis: usize, wall: Wall| match wall {
        Wall::FreeSlip | Wall::Absorbing => {
            let mut factor = [1.0; 3];
            factor[axis] = -1.0;
            Beyond::Ghost {
                factor,
                offset: [0.0; 3],
            }
        }
        Wall::OfBox => Beyond::Extrapolated,
        Wall::NoSlip { velocity } => Beyond::Ghost {
            factor: [-1.0; 3],
            offset: velocity.map(|u| 2.0 * u),
        },
    };
    let faces = |axis: usize, faces: Faces| match faces {
        Faces::Periodic => [Beyond::Periodic; 2],
        Faces::Walls(walls) => walls.map(|w| wall(axis, w)),
    };
    let x = match setup.ends {
        StreamwiseEnds::Periodic => [Beyond::Periodic; 2],
        StreamwiseEnds::InletOutlet => [
            // A profile differs from cell to cell: the first cell stands for the ghost before it.
            match setup.inlet_profile {
                None => Beyond::Ghost {
                    factor: [0.0; 3],
                    offset: inlet_velocity,
                },
                Some(_) => Beyond::Ghost {
                    factor: [1.0; 3],
                    offset: [0.0; 3],
                },
            },
            Beyond::Ghost {
                factor: [1.0; 3],
                offset: [0.0; 3],
            },
        ],
        StreamwiseEnds::Walls(walls) => walls.map(|w| wall(0, w)),
    };
    let [y, z] = match setup.sides {
        Sides::Periodic => [Faces::Periodic; 2],
        Sides::FreeSlip => [Faces::Walls([Wall::FreeSlip; 2]); 2],
        Sides::Each(faces) => faces,
    };
    [x, faces(1, y), faces(2, z)]
}
