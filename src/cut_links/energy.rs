//! Energy that a wall along which the air slides gives the air ([`super::slide`]).
//!
//! The energy of a population f of weight w is f²/6w. In a cell that sums to ρu²/2 and the energy of pressure. What a link gives in a step is the energy of what comes back, less that of what left.
//!
//! A uniform stream comes back from a plane as it left. All its links together gain nothing, though single ones do. So a wall may give what its images would give if the air at the wall were
//! as it is at the image. Energies are taken in the frame of the wall, since one that moves may do work. Mass that is given back (`src/simulation/sliding.rs`) is not in it.

/// Energy that a side gives the air, by the share y of what slides that comes back; of the rest comes what left.
///
/// It gives a y + b y². As along a plane it would give c y.
#[derive(Debug, Clone, Copy, Default)]
pub struct Energy {
    /// c − a.
    pub free: f64,
    /// b.
    pub square: f64,
}

impl Energy {
    /// Where what is `back` comes for what went `out`, and of the image `came` back and `went`; all in the frame of the wall, along a direction of six weights.
    #[must_use]
    pub fn new(six_weights: f64, (out, back): (f64, f64), (went, came): (f64, f64)) -> Self {
        let more = back - out;
        Self {
            free: (came * came - went * went - 2.0 * out * more) / six_weights,
            square: more * more / six_weights,
        }
    }

    /// The largest y, 1 at most, with which no more is given than along a plane: (c − a)/b.
    #[must_use]
    pub fn share(self) -> f64 {
        if self.free >= self.square {
            return 1.0;
        }
        (self.free / self.square).max(0.0)
    }
}

impl std::ops::AddAssign for Energy {
    fn add_assign(&mut self, other: Self) {
        self.free += other.free;
        self.square += other.square;
    }
}
