//! Growth of Tollmien-Schlichting waves in laminar layers, and where a layer turns turbulent.
//!
//! The envelope method: the exponent n of the most amplified wave grows at a rate that depends on H, θ and Re_θ, from a critical Re_θ on
//! (Drela & Giles 1987; Drela 1989). A layer turns turbulent at n = n_crit. The rate sets in over a decade of 0.16 in Re_θ. Near n_crit a small
//! rate is added, so that a transition is always found where n comes close (Fidkowski 2022).

use super::closure::{Regime, least_shape};
use super::dual::{Dual, WIDTH};
use super::station::{Air, State, Station};

/// Half the width of the onset, in log₁₀ Re_θ.
const ONSET: f64 = 0.08;

/// dn/dξ [1/chord] of a layer with a shape and thickness.
pub fn rate(h: Dual, theta: Dual, re: Dual) -> Dual {
    let inverse = 1.0 / (h - 1.0);
    let critical = 2.492 * inverse.powf(0.43) + 0.7 * ((14.0 * inverse - 9.24).tanh() + 1.0);
    let decades = re.ln() / std::f64::consts::LN_10;
    let past = (decades - critical + ONSET) / (2.0 * ONSET);
    if past.value <= 0.0 {
        return Dual::constant(0.0);
    }
    let onset = if past.value < 1.0 {
        past.square() * (3.0 - 2.0 * past)
    } else {
        Dual::constant(1.0)
    };
    let bump = (-(3.87 * inverse - 2.52).square()).exp();
    let per_re = 0.028 * (h - 1.0) - 0.0345 * bump;
    let re_per_length = -0.05 + 2.7 * inverse - 5.5 * inverse.square()
        + 3.0 * inverse.square() * inverse
        + 0.1 * (-20.0 * inverse).exp();
    re_per_length * per_re / theta * onset
}

fn rate_of(state: &State, air: &Air) -> Dual {
    let h = (state.displacement / state.theta).at_least(least_shape(Regime::Laminar));
    rate(h, state.theta, state.momentum_reynolds(air))
}

/// Root mean square of the rates of two states.
fn mean_of([rate_a, rate_b]: [Dual; 2]) -> Dual {
    let square = 0.5 * (rate_a.square() + rate_b.square());
    if square.value > 0.0 {
        square.sqrt()
    } else {
        square
    }
}

/// Mean rate between two states, from their rates and exponents.
fn mean_rate(a: &State, b: &State, rates: [Dual; 2], n: [Dual; 2], air: &Air) -> Dual {
    let mean = mean_of(rates);
    let left = 20.0 * (air.critical - 0.5 * (n[0] + n[1]));
    let near = if left.value <= 0.0 {
        Dual::constant(1.0)
    } else {
        (-left).at_least(-50.0).exp()
    };
    mean + near * 0.002 / (a.theta + b.theta)
}

/// Residual of the amplification's equation between two stations.
pub fn residual(a: &State, b: &State, air: &Air) -> Dual {
    let rates = [rate_of(a, air), rate_of(b, air)];
    let rate = mean_rate(a, b, rates, [a.shear, b.shear], air);
    b.shear - a.shear - rate * (b.place - a.place)
}

/// Excess of n over n_crit at a place between two stations, if n is n_crit there.
fn excess(a: &State, b: &State, place: Dual, air: &Air) -> Dual {
    let cut = a.between(b, place);
    let rates = [rate_of(a, air), rate_of(&cut, air)];
    let n = [a.shear, Dual::constant(air.critical)];
    a.shear + mean_rate(a, &cut, rates, n, air) * (place - a.place) - air.critical
}

/// Place between two stations at which n reaches n_crit, with its derivatives.
pub fn transition_place(a: &State, b: &State, air: &Air) -> Dual {
    let at = |share: f64| a.place.value + share * (b.place.value - a.place.value);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        if excess(a, b, Dual::constant(at(middle)), air).value < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Implicit differentiation, by a last step of Newton's method that keeps the derivatives.
    let share = (0.5 * (low + high)).clamp(1e-6, 1.0 - 1e-6);
    let place = Dual::variable(at(share), WIDTH - 1);
    let rest = excess(a, b, place, air);
    let slope = rest.slopes[WIDTH - 1];
    let mut result = Dual::constant(place.value);
    if slope > 0.0 {
        for k in 0..WIDTH - 1 {
            result.slopes[k] = -rest.slopes[k] / slope;
        }
    }
    result
}

/// What becomes of n over an interval that begins laminar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Growth {
    /// n at the end, below n_crit.
    Laminar(f64),
    /// n reaches n_crit at this share of the interval.
    Transition(f64),
}

/// Follows n from one station to the next.
pub fn follow(from: &Station, to: &Station, air: &Air) -> Growth {
    let (a, b) = (State::variable(from, 0), State::variable(to, 5));
    if excess(&a, &b, b.place, air).value >= 0.0 {
        let place = transition_place(&a, &b, air).value;
        return Growth::Transition((place - from.place) / (to.place - from.place));
    }
    // The mean rate without derivatives.
    let mean = mean_of([rate_of(&a, air), rate_of(&b, air)]).value;
    let per_thickness = 1.0 / (from.theta + to.theta);
    let rate = |n: f64| {
        let left = 20.0 * (air.critical - 0.5 * (from.shear + n));
        mean + (-left).clamp(-50.0, 0.0).exp() * 0.002 * per_thickness
    };
    let (mut low, mut high) = (from.shear, air.critical);
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        let grown = from.shear + rate(middle) * (to.place - from.place);
        if grown > middle {
            low = middle;
        } else {
            high = middle;
        }
    }
    Growth::Laminar(0.5 * (low + high))
}
