//! What comes back along a cut link.

use super::search::CutLink;

/// Sides of a link: that of cell A, and that of B.
pub const SIDES: [usize; 2] = [0, 1];

/// What the air of one side gets back: share · out + further − strength · 6 w d·v; shifted populations.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Return {
    /// The population that left.
    pub out: f64,
    /// s.
    pub share: f64,
    /// e.
    pub further: f64,
    /// κ.
    pub strength: f64,
}

/// Which further population a side needs beside the one that left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// None: half-way bounce-back.
    HalfWay,
    /// The cut is near: what arrives at the cell along the direction of leaving.
    Near,
    /// The cut is far: what arrives behind the cell, coming back.
    Far,
}

impl CutLink {
    /// What a side needs to know.
    #[must_use]
    pub fn side(&self, side: usize) -> Side {
        if self.blocked[side] {
            Side::HalfWay
        } else if self.distance(side) < 0.5 {
            Side::Near
        } else {
            Side::Far
        }
    }

    /// What comes back to a side, from what left and the further population that [`CutLink::side`] asks for.
    #[must_use]
    pub fn returned(&self, side: usize, out: f64, further: f64) -> Return {
        let q = self.distance(side);
        match self.side(side) {
            Side::HalfWay => Return {
                out,
                share: 1.0,
                further: 0.0,
                strength: 1.0,
            },
            Side::Near => Return {
                out,
                share: 2.0 * q,
                further: (1.0 - 2.0 * q) * further,
                strength: 1.0,
            },
            Side::Far => {
                let share = 0.5 / q;
                Return {
                    out,
                    share,
                    further: (1.0 - share) * further,
                    strength: share,
                }
            }
        }
    }
}

impl Return {
    /// A share of it, and half-way bounce-back for the rest of 1; more than 1 goes beyond it, away from bounce-back.
    pub fn blend(&mut self, share: f64) {
        let rest = 1.0 - share;
        self.share = rest + share * self.share;
        self.further *= share;
        self.strength = rest + share * self.strength;
    }

    /// r, where the sheet moves with d·v along the direction d of leaving, of weight w.
    #[must_use]
    pub fn back(&self, weight: f64, along: f64) -> f64 {
        self.share * self.out + self.further - 6.0 * weight * self.strength * along
    }

    /// f + r of a sheet at rest: what it is pushed with along d.
    #[must_use]
    pub fn push(&self) -> f64 {
        (1.0 + self.share) * self.out + self.further
    }
}
