//! What closes the two integral equations of a boundary layer: relations between shape, friction, dissipation and shear stress.
//!
//! Drela & Giles, AIAA J. 25 (1987) 1347, with the later coefficients that Drela (Low Reynolds Number Aerodynamics, Springer LNE 54, 1989) and
//! Fidkowski (AIAA J. 60, 2022, 2961) publish, for incompressible flow. Lengths are in chords, speeds in those of the stream; H = δ*/θ and
//! Re_θ = u θ/ν. The layers' equations use 2 C_D/H* in place of the dissipation coefficient C_D.
//!
//! Departure: where XFOIL's slip speed jumps from 0.95 to 0.98, ours is only limited, so that Newton's method meets no jump.

use super::dual::Dual;

/// What kind of layer there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// On the surface, before transition.
    Laminar,
    /// On the surface, behind transition.
    Turbulent,
    /// Behind the trailing edge, always turbulent.
    Wake,
}

/// Least shape parameter H, which keeps the relations finite.
pub const fn least_shape(regime: Regime) -> f64 {
    match regime {
        Regime::Wake => 1.000_05,
        _ => 1.05,
    }
}

/// A and B of the equilibrium locus G² = A² (1 + B β), and the wall's term C in it.
const LOCUS: [f64; 3] = [6.7, 0.75, 18.0];

/// Dissipation length of a wake over that of a layer.
const WAKE_LENGTH: f64 = 0.9;

/// Factor K of the lag of the shear stress.
const LAG: f64 = 5.6 * 1.333;

/// Energy shape parameter H* of laminar layers (Falkner-Skan profiles).
pub fn laminar_energy_shape(h: Dual) -> Dual {
    let d = h - 4.35;
    if h.value < 4.35 {
        0.0111 * d.square() / (h + 1.0) - 0.0278 * d.square() * d / (h + 1.0) + 1.528
            - 0.0002 * (d * h).square()
    } else {
        0.015 * d.square() / h + 1.528
    }
}

/// Energy shape parameter H* of turbulent layers.
pub fn turbulent_energy_shape(h: Dual, re: Dual) -> Dual {
    let re = re.at_least(200.0);
    let least = 1.5 + 4.0 / re;
    let turning = if re.value > 400.0 {
        3.0 + 400.0 / re
    } else {
        Dual::constant(4.0)
    };
    if h.value < turning.value {
        let ratio = (turning - h) / (turning - 1.0);
        (2.0 - least) * ratio.square() * 1.5 / (h + 0.5) + least
    } else {
        let log = re.ln();
        let d = h - turning;
        let shifted = d + 4.0 / log;
        d.square() * (0.007 * log / shifted.square() + 0.015 / h) + least
    }
}

/// Skin friction coefficient 2 τ/(ρ u²) of laminar layers.
pub fn laminar_friction(h: Dual, re: Dual) -> Dual {
    let scaled = if h.value < 5.5 {
        let d = 5.5 - h;
        0.0727 * d.square() * d / (h + 1.0) - 0.07
    } else {
        0.015 * (1.0 - 1.0 / (h - 4.5)).square() - 0.07
    };
    scaled / re
}

/// Skin friction coefficient 2 τ/(ρ u²) of turbulent layers (Swafford 1983).
pub fn turbulent_friction(h: Dual, re: Dual) -> Dual {
    let log = re.ln().at_least(3.0);
    let decades = log / std::f64::consts::LN_10;
    let exponent = -1.74 - 0.31 * h;
    0.3 * (-1.33 * h).at_least(-20.0).exp() * (exponent * decades.ln()).exp()
        + 1.1e-4 * ((4.0 - h / 0.875).tanh() - 1.0)
}

/// 2 C_D/H* of laminar layers.
pub fn laminar_dissipation(h: Dual, re: Dual) -> Dual {
    let d = h - 4.0;
    let scaled = if h.value < 4.0 {
        0.00205 * (4.0 - h).powf(5.5) + 0.207
    } else {
        -0.0016 * d.square() / (1.0 + 0.02 * d.square()) + 0.207
    };
    scaled / re
}

/// 2 C_D/H* of laminar wakes, one half.
fn laminar_wake_dissipation(h: Dual, re: Dual) -> Dual {
    let inverse = 1.0 / h;
    2.2 * (1.0 - inverse).square() * inverse / (laminar_energy_shape(h) * re)
}

/// Everything that follows from a station's state.
#[derive(Debug, Clone, Copy)]
pub struct Relations {
    /// Shape parameter H, limited from below.
    pub h: Dual,
    /// Re_θ.
    pub re: Dual,
    /// Energy shape parameter H*.
    pub energy_shape: Dual,
    /// Slip speed over the edge's.
    pub slip: Dual,
    /// Skin friction coefficient.
    pub friction: Dual,
    /// 2 C_D/H*.
    pub dissipation: Dual,
    /// Root of the shear stress coefficient in equilibrium.
    pub equilibrium: Dual,
    /// Thickness of the layer [chords].
    pub thickness: Dual,
}

impl Relations {
    /// From momentum and displacement thickness, root of the shear stress coefficient (not used where laminar) and Re_θ.
    pub fn new(regime: Regime, theta: Dual, displacement: Dual, shear: Dual, re: Dual) -> Self {
        let h = (displacement / theta).at_least(least_shape(regime));
        let energy_shape = match regime {
            Regime::Laminar => laminar_energy_shape(h),
            _ => turbulent_energy_shape(h, re),
        };
        let slip = (0.5 * energy_shape * (1.0 - (h - 1.0) / (LOCUS[1] * h))).at_most(
            if regime == Regime::Wake {
                0.99995
            } else {
                0.98
            },
        );
        let friction = Self::friction_at(regime, h, re);
        let dissipation = match regime {
            Regime::Laminar => laminar_dissipation(h, re),
            Regime::Turbulent => (wall_dissipation(h, re, energy_shape, slip)
                + outer_dissipation(shear, re, energy_shape, slip))
            .max(laminar_dissipation(h, re)),
            // Both halves of a wake dissipate.
            Regime::Wake => {
                2.0 * outer_dissipation(shear, re, energy_shape, slip)
                    .max(laminar_wake_dissipation(h, re))
            }
        };
        let inner = inner_shape(regime, h, re);
        let factor = 0.5 / (LOCUS[0] * LOCUS[0] * LOCUS[1]);
        let equilibrium = (factor * energy_shape * (h - 1.0) * inner.square()
            / ((1.0 - slip) * h.square() * h))
            .sqrt();
        let thickness = (3.15 + 1.72 / (h - 1.0)) * theta + displacement;
        let most = 12.0 * theta;
        let thickness = if thickness.value > most.value {
            most
        } else {
            thickness
        };
        Self {
            h,
            re,
            energy_shape,
            slip,
            friction,
            dissipation,
            equilibrium,
            thickness,
        }
    }

    /// Skin friction coefficient.
    pub fn friction_at(regime: Regime, h: Dual, re: Dual) -> Dual {
        match regime {
            Regime::Laminar => laminar_friction(h, re),
            Regime::Turbulent => turbulent_friction(h, re).max(laminar_friction(h, re)),
            Regime::Wake => Dual::constant(0.0),
        }
    }

    /// Root of the shear stress coefficient where a layer turns turbulent.
    pub fn shear_at_transition(&self) -> Dual {
        1.8 * (-3.3 / (self.h - 1.0)).exp() * self.equilibrium
    }
}

/// H − 1 less what the wall's layer takes.
fn inner_shape(regime: Regime, h: Dual, re: Dual) -> Dual {
    if regime == Regime::Wake {
        h - 1.0
    } else {
        (h - 1.0 - LOCUS[2] / re).at_least(0.01)
    }
}

/// 2 C_D/H* of the wall's layer.
fn wall_dissipation(h: Dual, re: Dual, energy_shape: Dual, slip: Dual) -> Dual {
    let least = 2.1 / re.ln();
    let low_re = 0.5 + 0.5 * ((h - 1.0) / least).tanh();
    turbulent_friction(h, re) * slip / energy_shape * low_re
}

/// 2 C_D/H* of the outer layer: turbulent stress, and laminar stress there.
fn outer_dissipation(shear: Dual, re: Dual, energy_shape: Dual, slip: Dual) -> Dual {
    let defect = 0.995 - slip;
    (shear.square() * defect + 0.15 * defect.square() / re) * 2.0 / energy_shape
}

/// Velocity gradient (1/u) du/dξ at which the shear stress would stay in equilibrium [1/chord].
pub fn equilibrium_gradient(
    regime: Regime,
    h: Dual,
    re: Dual,
    friction: Dual,
    displacement: Dual,
) -> Dual {
    let ratio = inner_shape(regime, h, re) / (LOCUS[0] * length_factor(regime) * h);
    (0.5 * friction - ratio.square()) / (LOCUS[1] * displacement)
}

/// Factor on the departure from equilibrium in the lag equation.
pub fn lag_factor(slip: Dual) -> Dual {
    LAG / (1.0 + slip)
}

/// Dissipation length over that of a layer on a wall.
pub fn length_factor(regime: Regime) -> f64 {
    if regime == Regime::Wake {
        WAKE_LENGTH
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All relations, at states on both sides of their switches, against central differences.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let list = |regime: Regime, x: [Dual; 4]| -> [Dual; 9] {
            let r = Relations::new(regime, x[0], x[0] * x[1], x[2], x[3]);
            let gradient = equilibrium_gradient(regime, r.h, r.re, r.friction, x[0] * x[1]);
            [
                r.energy_shape,
                r.slip,
                r.friction,
                r.dissipation,
                r.equilibrium,
                r.thickness,
                r.shear_at_transition(),
                gradient,
                lag_factor(r.slip),
            ]
        };
        let mut checked = 0;
        for regime in [Regime::Laminar, Regime::Turbulent, Regime::Wake] {
            for h in [1.3, 1.6, 2.6, 3.9, 4.2, 5.2, 7.0] {
                for re in [150.0, 350.0, 900.0, 2e4] {
                    let x = [0.003, h, 0.06, re];
                    let exact = list(regime, std::array::from_fn(|k| Dual::variable(x[k], k)));
                    for k in 0..4 {
                        let at = |step: f64| {
                            let mut x = x;
                            x[k] *= 1.0 + step;
                            list(regime, x.map(Dual::constant))
                        };
                        let (low, high) = (at(-1e-6), at(1e-6));
                        for q in 0..9 {
                            let difference = (high[q].value - low[q].value) / (2e-6 * x[k]);
                            let slope = exact[q].slopes[k];
                            let scale =
                                1e-4 * slope.abs() + 1e-8 * exact[q].value.abs().max(1e-3) / x[k];
                            assert!(
                                (difference - slope).abs() <= scale + 1e-7,
                                "{regime:?} {h} {re} {k} {q}: {difference} {slope}"
                            );
                            checked += usize::from(slope != 0.0);
                        }
                    }
                }
            }
        }
        assert!(checked > 1000, "{checked}");
    }

    /// Blasius, within the fits' few per cent: H = 2.59, H* = 1.572, c_f Re_θ = 0.441, and 2 C_D/H* = c_f/2 as H* stays constant.
    #[test]
    fn blasius_profile_has_its_coefficients() {
        let (h, re) = (Dual::constant(2.591), Dual::constant(1.0));
        assert!((laminar_energy_shape(h).value - 1.5726).abs() < 0.005);
        assert!((laminar_friction(h, re).value / 0.441 - 1.0).abs() < 0.035);
        assert!((2.0 * laminar_dissipation(h, re).value / 0.441 - 1.0).abs() < 0.035);
    }
}
