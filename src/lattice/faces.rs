//! Faces that let sound out: the inlet, and sides that keep the mean flow in.
//!
//! A plane wave that leaves through a face brings the populations of one direction of the face's normal with it, and their sum, over the mean,
//! is all that has to be known: for a wave of density δ that leaves at the angle θ to the normal, at rest, u_n = c_s cos θ δ, and the five
//! populations that leave carry g = δ/6 + u_n/2. The face answers with the flow v = κ δ, κ = [`IMPEDANCE`] for c_s: no wave comes back
//! at cos θ = κ/c_s, and (cos θ − κ/c_s)/(cos θ + κ/c_s) of it at others. The mean of g, over many periods of the longest wave between two faces,
//! is taken off, so that nothing flows through a side, and the wind through the inlet, in the mean: for what is slower, faces are as solid as
//! ever, and a tunnel's blockage stays what it is.
//!
//! * Sides reflect first, without friction ([`super::links`]); then a share φ = v/(1/6 + g) of every population that came back is taken away, which
//!   takes the tangential momentum of the air that leaves with it.
//! * The inlet sends the equilibrium of density δρ̄ + δ and velocity U − v, with δρ̄ the mean of what the leaving populations tell of the
//!   density at U. A wave at an angle moves the air along the face, too: the share [`INLET_TANGENTIAL`] of that of the first cell, over its running
//!   mean, goes with the wind. (With the mean the wind would turn; held to zero, the wave makes vorticity, and 6 % of it comes back.)
//!
//! Sources: one-dimensional characteristic faces (Thompson 1987, doi:10.1016/0021-9991(87)90041-6; Poinsot & Lele 1992); that they take a cosine less
//! than one for waves at an angle is Engquist & Majda's second remark (1977, doi:10.1090/S0025-5718-1977-0436612-4). *Our own*: wave and flow
//! are read off the populations in flight, not off density and velocity of cells, so that no half step or half cell is lost, and a running
//! mean stands for the far field.

use super::grid::{Faces, Grid, Setup, Sides, StreamwiseEnds, Wall};
use super::operators::bare_moments;
use super::start::Start;
use super::{DIRECTIONS, DOWNSTREAM, Operator, SOUND_SPEED_SQUARED, opposite};

/// Flow through a face over the density of a wave that leaves [cells per step]. Waves at 0° and 30° to the normal come back alike, by 4 %
/// (`ripstop validate acoustic-pulse`).
pub const IMPEDANCE: f64 = 0.535;

/// The same at the inlet: there at most 4.9 % comes back.
pub const INLET_IMPEDANCE: f64 = 0.53;

/// Share of the tangential momentum of the first cell, over its running mean, that the inlet has.
pub const INLET_TANGENTIAL: f64 = 0.95;

/// That share with an operator. None with two relaxation times, which break down at the inlet with it sooner than they do without.
#[must_use]
pub const fn inlet_tangential(operator: Operator) -> f64 {
    match operator {
        Operator::TwoRelaxationTimes => 0.0,
        _ => INLET_TANGENTIAL,
    }
}

/// Running means of a cell at the inlet: density excess as the leaving populations tell of it, and tangential momenta along y and z.
pub const INLET_MEANS: usize = 3;

/// Flow out of a side over the populations that meet it: κ/(1/6 + κ/2).
pub const SIDE_FLOW: f64 = IMPEDANCE / (1.0 / 6.0 + 0.5 * IMPEDANCE);

/// Section of a checkpoint with the running means.
pub const FACE_MEANS: &str = "face_means";

/// Passages of sound over the longest side of the box that the running means are over.
const PASSAGES: f64 = 16.0;

/// Share of the present that the running means take in a step.
#[must_use]
pub fn present_share(cells: [usize; 3]) -> f64 {
    let longest = cells.into_iter().max().unwrap_or(1) as f64;
    SOUND_SPEED_SQUARED.sqrt() / (PASSAGES * longest)
}

/// Density and velocity along x of the inlet's ghost, from the populations that leave there.
#[derive(Debug, Clone, Copy)]
pub struct InletAnswer {
    /// 1/(1 − 3U + 3U² + (3 − 6U) κ): density of the wave over six times its populations.
    pub wave: f64,
    /// 3U − 3U²: what the wind takes off six times the populations that leave.
    pub of_wind: f64,
}

impl InletAnswer {
    /// For the wind `speed` along x [cells per step].
    #[must_use]
    pub fn new(speed: f64) -> Self {
        let square = 3.0 * speed * speed;
        Self {
            wave: 1.0 / (1.0 - 3.0 * speed + square + (3.0 - 6.0 * speed) * INLET_IMPEDANCE),
            of_wind: 3.0 * speed - square,
        }
    }
}

/// A side that lets sound out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AbsorbingSide {
    /// Axis of its normal, 1 or 2.
    pub axis: usize,
    /// At the upper end of the axis.
    pub upper: bool,
}

impl AbsorbingSide {
    /// All of a set-up, those of y first.
    #[must_use]
    pub fn all(setup: &Setup) -> Vec<Self> {
        let Sides::Each(faces) = setup.sides else {
            return Vec::new();
        };
        let mut sides = Vec::new();
        for (faces, axis) in faces.into_iter().zip([1, 2]) {
            let Faces::Walls(walls) = faces else {
                continue;
            };
            for (wall, upper) in walls.into_iter().zip([false, true]) {
                if wall == Wall::Absorbing {
                    sides.push(Self { axis, upper });
                }
            }
        }
        sides
    }

    /// Axis of its rows of cells along x.
    const fn other_axis(self) -> usize {
        3 - self.axis
    }

    /// Rows of cells along x.
    #[must_use]
    pub const fn rows(self, cells: [usize; 3]) -> usize {
        cells[self.other_axis()]
    }

    /// Elements from row to row.
    #[must_use]
    pub const fn row_stride(self, grid: &Grid) -> usize {
        if self.axis == 1 {
            grid.stride_z
        } else {
            grid.stride_y
        }
    }

    /// The cell at `x` of a row.
    #[must_use]
    pub const fn cell(self, cells: [usize; 3], x: usize, row: usize) -> [usize; 3] {
        let mut cell = [x, row, row];
        cell[self.axis] = if self.upper { cells[self.axis] - 1 } else { 0 };
        cell
    }

    /// The directions that enter through it: along the normal first.
    #[must_use]
    pub fn entering(self) -> [usize; 5] {
        let inwards = if self.upper { -1 } else { 1 };
        let mut found = [0; 5];
        let mut count = 0;
        for (direction, c) in DIRECTIONS.iter().enumerate() {
            if c[self.axis] == inwards {
                found[count] = direction;
                count += 1;
            }
        }
        found
    }

    /// Array and element of the first cell of the first row for each entering direction, in a step of the given parity.
    #[must_use]
    pub fn slots(self, grid: &Grid, odd: bool) -> [(usize, usize); 5] {
        let first = grid.index(self.cell(grid.cells, 0, 0).map(|c| c as i64));
        self.entering()
            .map(|direction| grid.slot(first, direction, odd))
    }
}

/// Running means of all absorbing faces: those of the inlet's cells, z slowest, then the populations that meet each side, by rows.
#[derive(Debug, Clone, Default)]
pub struct FaceMeans {
    /// Of the inlet, `[ny · nz · 3]`; empty without one. See [`INLET_MEANS`].
    pub inlet: Vec<f32>,
    /// Of each side, `[rows · nx]`.
    pub sides: Vec<Vec<f32>>,
}

impl FaceMeans {
    /// Of air at rest.
    #[must_use]
    pub fn at_rest(setup: &Setup) -> Self {
        let [nx, ny, nz] = setup.cells;
        let inlet = match setup.ends {
            StreamwiseEnds::InletOutlet => vec![0.0; INLET_MEANS * ny * nz],
            _ => Vec::new(),
        };
        let sides = AbsorbingSide::all(setup)
            .into_iter()
            .map(|side| vec![0.0; nx * side.rows(setup.cells)])
            .collect();
        Self { inlet, sides }
    }

    /// Of a start, whose state counts as the mean.
    #[must_use]
    pub fn of_start(setup: &Setup, start: &Start) -> Self {
        let mut means = Self::at_rest(setup);
        let [nx, ny, _] = setup.cells;
        let (cells, _) = means.inlet.as_chunks_mut::<INLET_MEANS>();
        for (i, [excess, y, z]) in cells.iter_mut().enumerate() {
            let cell = [0, i % ny, i / ny];
            *excess = start.density_excess(cell) as f32;
            let (_, momentum) = bare_moments(&start.populations(cell));
            [*y, *z] = [momentum[1], momentum[2]].map(|j| j as f32);
        }
        for (side, means) in AbsorbingSide::all(setup).into_iter().zip(&mut means.sides) {
            for (i, mean) in means.iter_mut().enumerate() {
                let populations = start.populations(side.cell(setup.cells, i % nx, i / nx));
                let leaving = side.entering().map(|d| populations[opposite(d)]);
                *mean = leaving.iter().sum::<f64>() as f32;
            }
        }
        means
    }

    /// All of them, one after the other.
    #[must_use]
    pub fn joined(&self) -> Vec<f32> {
        let mut all = self.inlet.clone();
        for side in &self.sides {
            all.extend_from_slice(side);
        }
        all
    }

    /// Number of means.
    #[must_use]
    pub fn count(&self) -> usize {
        self.inlet.len() + self.sides.iter().map(Vec::len).sum::<usize>()
    }

    /// Takes them from what [`FaceMeans::joined`] made, of the same length.
    pub fn take(&mut self, joined: &[f32]) {
        let mut rest = joined;
        for means in std::iter::once(&mut self.inlet).chain(&mut self.sides) {
            let (own, others) = rest.split_at(means.len());
            means.copy_from_slice(own);
            rest = others;
        }
    }
}

/// Directions that carry momentum along the inlet.
pub const ALONG_INLET: [usize; 16] = {
    let mut along = [0; 16];
    let (mut direction, mut count) = (0, 0);
    while direction < DIRECTIONS.len() {
        let [_, y, z] = DIRECTIONS[direction];
        if y != 0 || z != 0 {
            along[count] = direction;
            count += 1;
        }
        direction += 1;
    }
    along
};

/// Directions that leave through the inlet, in the order of [`DOWNSTREAM`].
pub const LEAVING_INLET: [usize; 5] = {
    let mut leaving = [0; 5];
    let mut i = 0;
    while i < 5 {
        leaving[i] = opposite(DOWNSTREAM[i]);
        i += 1;
    }
    leaving
};

#[cfg(test)]
mod tests {
    use super::super::{WEIGHTS, equilibrium};
    use super::*;

    /// The five populations through a face carry δ/6 + u_n/2 of a wave at rest, to first order.
    #[test]
    fn leaving_populations_tell_of_the_wave() {
        for side in [
            AbsorbingSide {
                axis: 1,
                upper: false,
            },
            AbsorbingSide {
                axis: 2,
                upper: true,
            },
        ] {
            let (excess, speed) = (1e-7, 0.4e-7);
            let mut velocity = [0.3e-7; 3];
            velocity[side.axis] = if side.upper { speed } else { -speed };
            let leaving: f64 = side
                .entering()
                .map(|d| equilibrium(opposite(d), excess, velocity))
                .iter()
                .sum();
            assert!((leaving - excess / 6.0 - speed / 2.0).abs() < 1e-13);
            let weight: f64 = side.entering().map(|d| WEIGHTS[d]).iter().sum();
            assert!((weight - 1.0 / 6.0).abs() < 1e-15);
        }
    }

    /// What the inlet reads off the populations that leave is the density, at any wind.
    #[test]
    fn the_inlet_reads_its_density() {
        for wind in [0.0, 0.05, 0.12] {
            let answer = InletAnswer::new(wind);
            let sixfold = |excess: f64, u: [f64; 3]| {
                6.0 * LEAVING_INLET
                    .map(|d| equilibrium(d, excess, u))
                    .iter()
                    .sum::<f64>()
            };
            assert!((sixfold(0.0, [wind, 0.0, 0.0]) + answer.of_wind).abs() < 1e-14);
            let wave = 1e-7;
            let there = sixfold(wave, [wind - INLET_IMPEDANCE * wave, 0.0, 0.0]) + answer.of_wind;
            assert!((there * answer.wave - wave).abs() < 1e-12, "{wind}");
        }
    }

    #[test]
    fn means_are_kept_in_one_list() {
        let setup = Setup {
            cells: [5, 4, 3],
            ends: StreamwiseEnds::InletOutlet,
            sides: Sides::Each([
                Faces::Walls([Wall::FreeSlip, Wall::Absorbing]),
                Faces::Walls([Wall::Absorbing; 2]),
            ]),
            relaxation_time: 0.8,
            inlet_profile: None,
            sponge_cells: None,
            idle: None,
            operator: crate::lattice::Operator::TwoRelaxationTimes,
            eddy_viscosity: None,
        };
        let mut means = FaceMeans::at_rest(&setup);
        assert_eq!(means.count(), 3 * 12 + 15 + 2 * 20);
        let list: Vec<f32> = (0..means.count()).map(|i| i as f32).collect();
        means.take(&list);
        assert_eq!(means.joined(), list);
        assert_eq!(means.sides[1][0], 51.0);
    }
}
