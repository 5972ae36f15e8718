//! Energy that a wall along which the air slides gives the air ([`super::slide`]).
//!
//! The energy of a population f of weight w is f²/6w. In a cell that sums to ρu²/2 and the energy of pressure. What a link gives in a step is the energy of what comes back, less that of what left.
//!
//! A uniform stream comes back from a plane as it left. All its links together gain nothing, though single ones do. So a wall gives what its images would give if the air at the wall were
//! as it is at the image, as far as bounds allow. Less comes back of what slides where it would give more, and more where it would give less. Energies are taken in the frame of the wall, since one that moves may do
//! work. Mass that is given back ([`super::reflections`]) is not in it.

/// Largest share of what slides that comes back: what left comes back less a quarter of itself.
///
/// *Measured, not derived*: with 1.5 a ram-air wing of 48 cells breaks down as it starts, with 2 sections do. Closed wings of 24 cells differ by 1 % of lift and 5 % of drag between 1.2 and 1.5
/// (docs/results/2026-11-28-walls-that-take-no-energy.md).
pub const LARGEST_SHARE: f64 = 1.25;

/// Energy that a side gives the air, by the share y of what slides that comes back; of the rest, 1 − y, comes what left.
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
        let (more, per_weights) = (back - out, six_weights.recip());
        Self {
            free: (came * came - went * went - 2.0 * out * more) * per_weights,
            square: more * more * per_weights,
        }
    }

    /// The y with which as much is given as along a plane, (c − a)/b, within its bounds.
    #[must_use]
    pub fn share(self) -> f64 {
        if self.square > 0.0 {
            (self.free / self.square).clamp(0.0, LARGEST_SHARE)
        } else {
            1.0
        }
    }
}

impl std::ops::AddAssign for Energy {
    fn add_assign(&mut self, other: Self) {
        self.free += other.free;
        self.square += other.square;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_keep_their_bounds() {
        for (free, square, share) in [
            (0.3, 0.6, 0.5),
            (1.2, 1.0, 1.2),
            (3.0, 1.0, LARGEST_SHARE),
            (-1.0, 1.0, 0.0),
            (0.0, 0.0, 1.0),
        ] {
            assert_eq!(Energy { free, square }.share(), share);
        }
    }
}
