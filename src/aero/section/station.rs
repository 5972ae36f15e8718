//! Stations of boundary layers: what is known at each of them, as numbers and with derivatives.

use super::closure::{Regime, Relations};
use super::dual::Dual;

/// State of a boundary layer at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Momentum thickness θ [chords].
    pub theta: f64,
    /// Displacement thickness δ*, with the dead air [chords].
    pub displacement: f64,
    /// Root of the shear stress coefficient, or the waves' amplification exponent n where the layer is laminar.
    pub shear: f64,
    /// Speed at the edge over the stream's.
    pub speed: f64,
    /// Distance from the stagnation point [chords].
    pub place: f64,
    /// Thickness of the dead air in a wake [chords].
    pub dead_air: f64,
}

/// What the layers need to know of the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// Reynolds number of the chord.
    pub reynolds: f64,
    /// Exponent n at which a layer turns turbulent.
    pub critical: f64,
}

/// A station's state as independent or interpolated quantities.
#[derive(Debug, Clone, Copy)]
pub struct State {
    pub theta: Dual,
    /// With the dead air.
    pub displacement: Dual,
    pub shear: Dual,
    pub speed: Dual,
    pub place: Dual,
    pub dead_air: f64,
}

impl State {
    /// Independent quantities whose derivatives begin at an index: θ, δ*, s, u, ξ.
    pub fn variable(station: &Station, first: usize) -> Self {
        Self {
            theta: Dual::variable(station.theta, first),
            displacement: Dual::variable(station.displacement, first + 1),
            shear: Dual::variable(station.shear, first + 2),
            speed: Dual::variable(station.speed, first + 3),
            place: Dual::variable(station.place, first + 4),
            dead_air: station.dead_air,
        }
    }

    /// Between two stations, linearly, at a place; s is left as at `self`.
    pub fn between(&self, other: &Self, place: Dual) -> Self {
        let share = (place - self.place) / (other.place - self.place);
        let mix = |a: Dual, b: Dual| a + (b - a) * share;
        Self {
            theta: mix(self.theta, other.theta),
            displacement: mix(self.displacement, other.displacement),
            speed: mix(self.speed, other.speed),
            place,
            ..*self
        }
    }

    pub fn momentum_reynolds(&self, air: &Air) -> Dual {
        self.theta * self.speed * air.reynolds
    }

    /// H with the dead air.
    pub fn whole_shape(&self) -> Dual {
        self.displacement / self.theta
    }

    pub fn relations(&self, regime: Regime, air: &Air) -> Relations {
        let re = self.momentum_reynolds(air);
        Relations::new(
            regime,
            self.theta,
            self.displacement - self.dead_air,
            self.shear,
            re,
        )
    }
}
