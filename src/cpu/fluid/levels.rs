//! A lattice with boxes of finer cells in it, which may hold further ones.
//!
//! All follows from the steps of the finest lattice of the first boxes: two of its steps, then one of the lattice around it, then both exchange
//! what they know of each other ([`super::transfer`]); and so on outwards. After the exchange both stand at one time, and every cell is whole; in
//! between, shells are spoilt.

use super::transfer::Tie;
use super::{BodyForce, Fluid};
use crate::lattice::Real;
use crate::lattice::nest::Nest;

/// A lattice and the boxes in it.
#[derive(Debug, Clone)]
pub struct Levels<T: Real> {
    /// The lattice.
    fluid: Fluid<T>,
    /// Boxes in it; all that acts on the air lies in the first.
    boxes: Vec<(Tie<T>, Self)>,
    /// Uniform acceleration of the steps of the first box since this lattice's last.
    gained: Option<[f64; 3]>,
}

impl<T: Real> Levels<T> {
    /// A lattice without boxes.
    #[must_use]
    pub const fn new(fluid: Fluid<T>) -> Self {
        Self {
            fluid,
            boxes: Vec::new(),
            gained: None,
        }
    }

    /// The same with a box of finer cells, which must fit ([`Nest::fits`]) and have a set-up of half the cells' size.
    #[must_use]
    pub fn with(mut self, nest: Nest, inner: Self) -> Self {
        let mut tie = Tie::new(nest);
        let mut inner = inner;
        tie.exchange(&mut self.fluid, &mut inner.fluid);
        self.boxes.push((tie, inner));
        self
    }

    /// The lattice itself.
    #[must_use]
    pub const fn fluid(&self) -> &Fluid<T> {
        &self.fluid
    }

    /// The lattice itself.
    pub const fn fluid_mut(&mut self) -> &mut Fluid<T> {
        &mut self.fluid
    }

    /// Boxes, and what is in them.
    pub fn boxes(&self) -> impl Iterator<Item = (&Nest, &Self)> {
        self.boxes.iter().map(|(tie, inner)| (tie.nest(), inner))
    }

    /// The finest lattice of the first boxes.
    #[must_use]
    pub fn finest(&self) -> &Fluid<T> {
        self.boxes
            .first()
            .map_or(&self.fluid, |(_, inner)| inner.finest())
    }

    /// One step of that lattice under `body_force`, and of those around it what is due. True if this one has made a step, too: then all of its
    /// boxes stand at its time.
    pub fn collide_stream(&mut self, body_force: &BodyForce) -> bool {
        let mut boxes = self.boxes.iter_mut();
        let Some((_, first)) = boxes.next() else {
            self.fluid.collide_stream(body_force);
            return true;
        };
        let stepped = first.collide_stream(body_force);
        if let Some(acceleration) = body_force.acceleration {
            let gained = self.gained.get_or_insert_default();
            for (sum, a) in gained.iter_mut().zip(acceleration) {
                *sum += a;
            }
        }
        if !stepped || first.fluid.is_odd() {
            return false;
        }
        let gained = self.gained.take();
        let acceleration = |times: f64| gained.map(|gained| gained.map(|a| a / times));
        for (_, other) in boxes {
            for _ in 0..2 {
                other.whole_step(acceleration(2.0));
            }
        }
        self.fluid.collide_stream(&BodyForce {
            acceleration: gained,
            ..BodyForce::default()
        });
        for (tie, inner) in &mut self.boxes {
            tie.exchange(&mut self.fluid, &mut inner.fluid);
        }
        true
    }

    /// A step of this lattice, and all steps in its boxes, under an acceleration per own step.
    pub fn whole_step(&mut self, acceleration: Option<[f64; 3]>) {
        let times = 2f64.powi(self.depth());
        let body_force = BodyForce {
            acceleration: acceleration.map(|a| a.map(|a| a / times)),
            ..BodyForce::default()
        };
        while !self.collide_stream(&body_force) {}
    }

    /// Levels of the first boxes below this one.
    fn depth(&self) -> i32 {
        self.boxes.first().map_or(0, |(_, inner)| 1 + inner.depth())
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
