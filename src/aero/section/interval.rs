//! The boundary layers' equations between two neighbouring stations.
//!
//! Momentum and energy shape, Drela & Giles (1987), over logarithms; lag of the turbulent shear stress, or amplification of laminar waves:
//!
//! ```text
//! d ln θ  = c_f/2 · dξ/θ − (H + 2) d ln u
//! d ln H* = (2 C_D/H* − c_f/2) dξ/θ − (1 − H) d ln u
//! 2 δ d ln s = K (s_eq − s) dξ + 2 δ ((1/u du/dξ)_eq dξ − d ln u),   s = √C_τ
//! dn = (dn/dξ) dξ
//! ```
//!
//! Differences are centred, except that rates shift to the downstream station where H changes quickly. An interval with transition is cut in two
//! there, its equations added (Drela & Giles, section on transition); the state at the cut is interpolated and the cut solves the amplification's
//! equation. At the first station the layer is that of a stagnation point: u ∝ ξ, θ and H constant.
//!
//! Departure: from the first station to the second, 2 (b − a)/(a + b) stands for ln(b/a) of u and ξ. It is as exact where u ∝ ξ, and stays finite
//! when the stagnation point comes to lie on a node, where Fidkowski (2022) extrapolates a state at the stagnation point instead.

use super::amplification;
use super::closure::{self, Regime, Relations};
use super::dual::Dual;
use super::station::{Air, State, Station};

/// What lies between two stations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The stagnation point, before the first station; the station behind is all there is.
    Stagnation,
    /// A laminar layer just behind the first station.
    Start,
    /// A laminar layer.
    Laminar,
    /// A layer that turns turbulent, by itself or at a fixed share of the interval.
    Transition(Option<f64>),
    /// A turbulent layer.
    Turbulent,
    /// A wake.
    Wake,
}

/// Residuals of momentum, energy shape, and shear stress or amplification.
pub fn residuals(kind: Kind, from: &Station, to: &Station, air: &Air) -> [Dual; 3] {
    let (a, b) = (State::variable(from, 0), State::variable(to, 5));
    match kind {
        Kind::Stagnation => stagnation(&b, air),
        Kind::Laminar | Kind::Start => {
            let [momentum, shape] = balances(Regime::Laminar, &a, &b, air, kind == Kind::Start);
            [momentum, shape, amplification::residual(&a, &b, air)]
        }
        Kind::Turbulent | Kind::Wake => {
            let regime = if kind == Kind::Wake {
                Regime::Wake
            } else {
                Regime::Turbulent
            };
            let [momentum, shape] = balances(regime, &a, &b, air, false);
            [momentum, shape, lag(regime, &a, &b, air)]
        }
        Kind::Transition(forced) => {
            let place = match forced {
                Some(share) => a.place + (b.place - a.place) * share,
                None => amplification::transition_place(&a, &b, air),
            };
            let mut cut = a.between(&b, place);
            let before = balances(Regime::Laminar, &a, &cut, air, false);
            cut.shear = cut.relations(Regime::Turbulent, air).shear_at_transition();
            let after = balances(Regime::Turbulent, &cut, &b, air, false);
            [
                before[0] + after[0],
                before[1] + after[1],
                lag(Regime::Turbulent, &cut, &b, air),
            ]
        }
    }
}

fn stagnation(b: &State, air: &Air) -> [Dual; 3] {
    let r = b.relations(Regime::Laminar, air);
    let scale = b.place / b.theta;
    let shape = b.whole_shape();
    [
        shape + 2.0 - 0.5 * scale * r.friction,
        1.0 - shape + scale * (0.5 * r.friction - r.dissipation),
        b.shear,
    ]
}

/// Residuals of momentum and energy shape; near the stagnation point without logarithms of u and ξ, which have no bound there.
fn balances(regime: Regime, a: &State, b: &State, air: &Air, is_start: bool) -> [Dual; 2] {
    let (ra, rb) = (a.relations(regime, air), b.relations(regime, air));
    let change = |a: Dual, b: Dual| {
        if is_start {
            2.0 * (b - a) / (a + b)
        } else {
            (b / a).ln()
        }
    };
    let log_speed = change(a.speed, b.speed);
    let log_place = change(a.place, b.place);
    let shape = 0.5 * (a.whole_shape() + b.whole_shape());
    let (scale_a, scale_b) = (a.place / a.theta, b.place / b.theta);
    // Friction of the mean state and both ends', as momentum needs more than two values where the layer is thin.
    let middle = Relations::friction_at(regime, 0.5 * (ra.h + rb.h), 0.5 * (ra.re + rb.re));
    let middle_scale = (a.place + b.place) / (a.theta + b.theta);
    let friction =
        0.5 * middle * middle_scale + 0.25 * (ra.friction * scale_a + rb.friction * scale_b);
    let momentum =
        (b.theta / a.theta).ln() + (shape + 2.0) * log_speed - 0.5 * log_place * friction;
    let weight = downstream_weight(regime, &ra, &rb);
    let rate = |r: &Relations, scale: Dual| scale * (0.5 * r.friction - r.dissipation);
    let rates = mix(weight, rate(&ra, scale_a), rate(&rb, scale_b));
    let energy =
        (rb.energy_shape / ra.energy_shape).ln() + (1.0 - shape) * log_speed + log_place * rates;
    [momentum, energy]
}

/// Residual of the shear stress's lag, over the thickness.
fn lag(regime: Regime, a: &State, b: &State, air: &Air) -> Dual {
    let (ra, rb) = (a.relations(regime, air), b.relations(regime, air));
    let weight = downstream_weight(regime, &ra, &rb);
    let step = b.place - a.place;
    let displacement = 0.5 * (a.displacement + b.displacement - (a.dead_air + b.dead_air));
    let gradient = closure::equilibrium_gradient(
        regime,
        mix(weight, ra.h, rb.h),
        0.5 * (ra.re + rb.re),
        mix(weight, ra.friction, rb.friction),
        displacement,
    );
    let departure = mix(weight, ra.equilibrium, rb.equilibrium)
        - mix(weight, a.shear, b.shear) * closure::length_factor(regime);
    let factor = closure::lag_factor(0.5 * (ra.slip + rb.slip));
    factor * departure * step / (ra.thickness + rb.thickness) - (b.shear / a.shear).ln()
        + gradient * step
        - (b.speed / a.speed).ln()
}

/// Weight of the downstream station: one half, more where H changes quickly.
fn downstream_weight(regime: Regime, a: &Relations, b: &Relations) -> Dual {
    let factor = if regime == Regime::Wake { 1.0 } else { 5.0 };
    let change = ((b.h - 1.0) / (a.h - 1.0)).ln();
    1.0 - 0.5
        * (-factor * change.square() / b.h.square())
            .at_least(-50.0)
            .exp()
}

fn mix(weight: Dual, a: Dual, b: Dual) -> Dual {
    a + weight * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind of interval against central differences, the place of free transition included.
    #[test]
    fn jacobians_are_those_of_the_residuals() {
        let air = Air {
            reynolds: 1e6,
            critical: 9.0,
        };
        let turbulent = [
            [0.002, 0.0034, 0.05, 1.1, 0.5],
            [0.0022, 0.0038, 0.052, 1.08, 0.53],
        ];
        let laminar = [
            [0.0006, 0.0019, 8.5, 1.2, 0.4],
            [0.00063, 0.0021, 8.9, 1.18, 0.42],
        ];
        let turns = [laminar[0], [0.0007, 0.0017, 0.06, 1.17, 0.45]];
        let first = [
            [5e-5, 1.1e-4, 0.0, 0.2, 0.004],
            [5.2e-5, 1.2e-4, 0.1, 0.5, 0.011],
        ];
        for (kind, states, dead_air) in [
            (Kind::Stagnation, first, 0.0),
            (Kind::Start, first, 0.0),
            (Kind::Laminar, laminar, 0.0),
            (Kind::Transition(None), turns, 0.0),
            (Kind::Transition(Some(0.3)), turns, 0.0),
            (Kind::Turbulent, turbulent, 0.0),
            (Kind::Wake, turbulent, 0.0003),
        ] {
            let station = |x: [f64; 5]| Station {
                theta: x[0],
                displacement: x[1],
                shear: x[2],
                speed: x[3],
                place: x[4],
                dead_air,
            };
            let at = |x: [[f64; 5]; 2]| residuals(kind, &station(x[0]), &station(x[1]), &air);
            let exact = at(states);
            for end in 0..2 {
                for k in 0..5 {
                    let h = 1e-6 * states[end][k].max(1e-3);
                    let mut shifted = [states, states];
                    shifted[0][end][k] -= h;
                    shifted[1][end][k] += h;
                    let [low, high] = shifted.map(at);
                    for row in 0..3 {
                        let difference = (high[row].value - low[row].value) / (2.0 * h);
                        let slope = exact[row].slopes[5 * end + k];
                        assert!(
                            (difference - slope).abs() < 2e-5 * (1.0 + slope.abs().max(1e-4 / h)),
                            "{kind:?} {end} {k} {row}: {difference} {slope}"
                        );
                    }
                }
            }
        }
    }

    /// u = k ξ with the thickness of a plane stagnation point (Hiemenz): θ = 0.292 √(ν/k), H = 2.22, also at the second station.
    #[test]
    fn stagnation_point_is_that_of_hiemenz() {
        let air = Air {
            reynolds: 1e6,
            critical: 9.0,
        };
        let theta = 0.292 * (1.0f64 / (50.0 * air.reynolds)).sqrt();
        let at = |place: f64| Station {
            theta,
            displacement: 2.22 * theta,
            shear: 0.0,
            speed: 50.0 * place,
            place,
            dead_air: 0.0,
        };
        for kind in [Kind::Stagnation, Kind::Start] {
            let r = residuals(kind, &at(1e-6), &at(0.004), &air);
            assert!(
                r[0].value.abs() < 0.12 && r[1].value.abs() < 0.09,
                "{kind:?} {r:?}"
            );
        }
    }
}
