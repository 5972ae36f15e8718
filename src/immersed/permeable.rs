//! Air through a permeable surface at a marker, in any consistent units.
//!
//! A permeable marker gives the air the velocity V + v n instead of its own velocity V: v is the velocity through the surface along its
//! normal n, and follows from the marker's own pressure difference, the normal force over the area A,
//!
//! A Δp(v) = K (w − v),  Δp(v) = r v + s v|v|,  w = (u* − V)·n,
//!
//! with K the immersed-boundary stiffness. With α = A r/K and β = A s/K this is v + α v + β v|v| = w, a quadratic of either sign of w; it is
//! solved with the force, not lagged behind it. K (w − v) is the derivative of
//!
//! ψ(w) = min_v ½ K (w − v)² + A (½ r v² + ⅓ s |v|³),
//!
//! which is convex: K and the fabric's resistance act in series. The tangential part keeps K |V − u*|²/2.

/// How much a marker resists air that passes it, relative to its immersed-boundary stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resistance {
    /// α = A r/K [1].
    pub viscous: f64,
    /// β = A s/K [one over the unit of velocity].
    pub inertial: f64,
}

impl Resistance {
    /// v for the normal slip w = (u* − V)·n.
    #[must_use]
    pub fn through_velocity(&self, slip: f64) -> f64 {
        let linear = 1.0 + self.viscous;
        let root = (linear * linear + 4.0 * self.inertial * slip.abs()).sqrt();
        // Never a difference of two large numbers, whatever α and β are.
        2.0 * slip / (linear + root)
    }

    /// dv/dw, between 0 and 1, where the velocity through the marker is `through`.
    #[must_use]
    pub fn slope(&self, through: f64) -> f64 {
        1.0 / (1.0 + self.viscous + 2.0 * self.inertial * through.abs())
    }

    /// A (½ r v² + ⅓ s |v|³) / K: work per time that the surface takes from the air, over K.
    #[must_use]
    pub fn potential(&self, through: f64) -> f64 {
        let square = through * through;
        (0.5 * self.viscous + self.inertial * through.abs() / 3.0) * square
    }
}

/// A marker of a permeable surface during one step: its normal stays that of the step's start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permeable {
    /// Unit normal; its sign does not matter.
    pub normal: [f64; 3],
    /// Resistance to air along it.
    pub resistance: Resistance,
}

impl Permeable {
    /// Velocity of the air through the surface, a vector along the normal, for a marker of velocity V in air of velocity u*.
    #[must_use]
    pub fn through(&self, own: [f64; 3], air: [f64; 3]) -> [f64; 3] {
        let n = self.normal;
        let slip = (0..3).map(|a| (air[a] - own[a]) * n[a]).sum();
        n.map(|n| n * self.resistance.through_velocity(slip))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESISTANCES: [Resistance; 5] = [
        Resistance {
            viscous: 0.0,
            inertial: 0.0,
        },
        Resistance {
            viscous: 3.0,
            inertial: 0.0,
        },
        Resistance {
            viscous: 0.0,
            inertial: 40.0,
        },
        Resistance {
            viscous: 1e9,
            inertial: 2.0,
        },
        Resistance {
            viscous: 0.5,
            inertial: 1e6,
        },
    ];

    /// v + α v + β v|v| = w for either sign; the force is the derivative of a convex potential.
    #[test]
    fn force_follows_from_a_convex_potential() {
        for r in RESISTANCES {
            for slip in [-2.0, -1e-3, -1e-9, 1e-9, 0.04, 7.0] {
                let v = r.through_velocity(slip);
                let back = v + r.viscous * v + r.inertial * v * v.abs();
                assert!((back / slip - 1.0).abs() < 1e-12, "{r:?} {slip}: {back}");
                let psi = |w: f64| {
                    let v = r.through_velocity(w);
                    0.5 * (w - v).powi(2) + r.potential(v)
                };
                let h = 1e-4 * slip.abs();
                let force = (psi(slip + h) - psi(slip - h)) / (2.0 * h);
                let scale = slip.abs();
                assert!((force - (slip - v)).abs() < 1e-7 * scale, "{r:?} {slip}");
                let slope =
                    (r.through_velocity(slip + h) - r.through_velocity(slip - h)) / (2.0 * h);
                assert!((slope - r.slope(v)).abs() < 1e-6, "{r:?} {slip}");
                assert!((0.0..=1.0).contains(&r.slope(v)));
            }
            assert_eq!(r.through_velocity(0.0), 0.0);
        }
    }
}
