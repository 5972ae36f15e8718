//! What passes between a lattice and a box of finer cells in it. *Restrict* goes from the fine cells to the coarse band, *fill* into the fine shell from the
//! coarse source ([`crate::lattice::nest`], [`crate::lattice::level_state`]).
//!
//! Work goes by planes of coarse cells, within a plane by lines of cells, along x where there are long ones, else along y. A line is a
//! run of vectors. Fine lines along y pass through the ends of rows, which the sweeps read and write (`exchanged_ends`).

mod fill;
mod lines;
mod restrict;

use super::exchanged_ends::ExchangedEnds;
use super::{Fluid, Stored};
use crate::lattice::Real;
use crate::lattice::level_state::STATE_NUMBERS;
use crate::lattice::nest::{Nest, Planes, SHELL, SOURCE, band};

/// A box of finer cells, and the cells that tie it to the lattice around it.
#[derive(Debug, Clone)]
pub struct Tie<T> {
    nest: Nest,
    source: Planes,
    shell: Planes,
    band: Planes,
    /// States of the coarse cells in and around the box, in fine units where they are of the source: by planes, then numbers of the state, rows, cells.
    states: Vec<T>,
}

impl<T: Real> Tie<T> {
    /// Of a box in a lattice.
    #[must_use]
    pub fn new(nest: Nest, coarse: &Fluid<impl Stored<Real = T>>) -> Self {
        let [x, y, z] = nest.cells.map(|n| n + 2);
        Self {
            source: nest.cells_of(&SOURCE),
            shell: nest.cells_of(&SHELL),
            band: nest.cells_of(&band(coarse.setup.eddy_viscosity)),
            states: vec![T::default(); STATE_NUMBERS * x * y * z],
            nest,
        }
    }

    /// Where the box lies.
    #[must_use]
    pub const fn nest(&self) -> &Nest {
        &self.nest
    }

    /// Restricts, then fills: both lattices stand at one time.
    pub fn exchange<P: Stored<Real = T>>(&mut self, coarse: &mut Fluid<P>, fine: &mut Fluid<P>) {
        take_down_ends(&self.nest, fine);
        let planes = [&self.band, &self.source];
        restrict::restrict_and_read(&self.nest, planes, coarse, fine, &mut self.states);
        fill::fill(&self.nest, &self.shell, &self.states, fine);
    }
}

/// What left for the band at the ends of rows, as the box stands.
pub(super) fn take_down_ends<P: Stored>(nest: &Nest, fine: &mut Fluid<P>) {
    let ends = (fine.exchanged_ends.take()).or_else(|| ExchangedEnds::new(nest));
    fine.exchanged_ends = ends.map(|mut ends| {
        ends.take_down_from(|cell| fine.gather(cell));
        ends
    });
}
