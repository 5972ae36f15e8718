//! Permeability: the velocity of air through a surface against the pressure difference across it.
//!
//! Δp = r v + s v|v|, with r = e a, s = e b for a sheet of thickness e under Ergun's law Δp/e = a v + b v|v| (Ergun 1952, Chem. Eng. Prog.
//! 48:89; a viscous, b inertial). Laboratories state the velocity at one pressure, half an inch of water (ASTM D737, FED-STD-191 method
//! 5450: the Frazier test, in ft³/min per ft²). *One measured point* cannot tell viscous from inertial flow: it is taken as inertial, a
//! constant effective porosity v/√(2Δp/ρ), as in Knacke's recovery-systems manual. Two points give both coefficients.

/// Half an inch of water [Pa].
pub const HALF_INCH_OF_WATER_PA: f64 = 124.54;

/// m/s of one ft³/min per ft².
pub const CUBIC_FOOT_PER_MINUTE_AND_SQUARE_FOOT_M_S: f64 = 0.3048 / 60.0;

/// Resistance of a surface to air that passes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permeability {
    /// r [Pa·s/m].
    pub viscous_pa_s_m: f64,
    /// s [kg/m³].
    pub inertial_kg_m3: f64,
}

/// A fabric known by name: its specification and the range of velocities that it allows at half an inch of water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedFabric {
    /// Name in case files.
    pub name: &'static str,
    /// Where the range stands.
    pub source: &'static str,
    /// Least and largest velocity [ft³/min per ft²]; the middle is taken.
    pub range_ft_min: [f64; 2],
}

/// Fabrics known by name.
pub const NAMED_FABRICS: [NamedFabric; 4] = [
    NamedFabric {
        name: "mil_c_7020_type_1",
        source: "MIL-C-7020, 1.1 oz/yd2 ripstop nylon",
        range_ft_min: [80.0, 120.0],
    },
    NamedFabric {
        name: "mil_c_7020_type_3",
        source: "MIL-C-7020, 1.6 oz/yd2 ripstop nylon",
        range_ft_min: [100.0, 160.0],
    },
    NamedFabric {
        name: "pia_c_44378_type_2",
        source: "PIA-C-44378, 1.12 oz/yd2 low-permeability ripstop nylon",
        range_ft_min: [30.0, 50.0],
    },
    NamedFabric {
        name: "pia_c_44378_type_4",
        source: "PIA-C-44378, 1.2 oz/yd2 low-permeability ripstop nylon",
        range_ft_min: [0.5, 3.0],
    },
];

impl NamedFabric {
    /// The middle of its range, as a measured point.
    #[must_use]
    pub fn permeability(&self) -> Permeability {
        let [least, most] = self.range_ft_min;
        let speed = 0.5 * (least + most) * CUBIC_FOOT_PER_MINUTE_AND_SQUARE_FOOT_M_S;
        Permeability::from_point([HALF_INCH_OF_WATER_PA, speed])
    }
}

impl Permeability {
    /// Ergun's law of a sheet of `thickness_m`: a [Pa·s/m²], b [kg/m⁴].
    #[must_use]
    pub fn ergun(thickness_m: f64, viscous_pa_s_m2: f64, inertial_kg_m4: f64) -> Self {
        Self {
            viscous_pa_s_m: thickness_m * viscous_pa_s_m2,
            inertial_kg_m3: thickness_m * inertial_kg_m4,
        }
    }

    /// From one measured point [Pa, m/s], taken as inertial.
    #[must_use]
    pub fn from_point([pressure_pa, speed_m_s]: [f64; 2]) -> Self {
        Self {
            viscous_pa_s_m: 0.0,
            inertial_kg_m3: pressure_pa / (speed_m_s * speed_m_s),
        }
    }

    /// Through two measured points [Pa, m/s]; `None` if no law with r, s ≥ 0 goes through both.
    #[must_use]
    pub fn from_points([[p1, v1], [p2, v2]]: [[f64; 2]; 2]) -> Option<Self> {
        let [q1, q2] = [p1 / v1, p2 / v2];
        let found = Self {
            viscous_pa_s_m: (q1 * v2 - q2 * v1) / (v2 - v1),
            inertial_kg_m3: (q2 - q1) / (v2 - v1),
        };
        (found.viscous_pa_s_m >= 0.0 && found.inertial_kg_m3 >= 0.0).then_some(found)
    }

    /// An opening (vent, gap, slot) that cells do not resolve, as a panel of Δp = ½ ρ (v/C_d)².
    #[must_use]
    pub fn opening(density_kg_m3: f64, discharge_coefficient: f64) -> Self {
        Self {
            viscous_pa_s_m: 0.0,
            inertial_kg_m3: 0.5 * density_kg_m3 / (discharge_coefficient * discharge_coefficient),
        }
    }

    /// Pressure difference at a velocity [Pa].
    #[must_use]
    pub fn pressure_pa(&self, speed_m_s: f64) -> f64 {
        (self.viscous_pa_s_m + self.inertial_kg_m3 * speed_m_s.abs()) * speed_m_s
    }

    /// Velocity at a pressure difference [m/s]: 2Δp/(r + √(r² + 4 s |Δp|)).
    #[must_use]
    pub fn through_velocity_m_s(&self, pressure_pa: f64) -> f64 {
        let r = self.viscous_pa_s_m;
        2.0 * pressure_pa / (r + (r * r + 4.0 * self.inertial_kg_m3 * pressure_pa.abs()).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_go_through_their_points() {
        let ergun = Permeability::ergun(1e-4, 1.6e6, 4.8e5);
        let points = [20.0, 500.0].map(|p| [p, ergun.through_velocity_m_s(p)]);
        let found = Permeability::from_points(points).unwrap();
        assert!((found.viscous_pa_s_m / ergun.viscous_pa_s_m - 1.0).abs() < 1e-12);
        assert!((found.inertial_kg_m3 / ergun.inertial_kg_m3 - 1.0).abs() < 1e-12);
        for v in [-0.7, 1e-6, 0.5, 30.0] {
            let back = ergun.through_velocity_m_s(ergun.pressure_pa(v));
            assert!((back / v - 1.0).abs() < 1e-12, "{v}: {back}");
        }
        let opening = Permeability::opening(1.2, 0.6);
        assert!((opening.pressure_pa(6.0) - 0.5 * 1.2 * 100.0).abs() < 1e-12);
        // Faster than in proportion to the pressure: no such law.
        assert!(Permeability::from_points([[100.0, 0.5], [200.0, 1.5]]).is_none());
        let named = NAMED_FABRICS[0].permeability();
        assert!((named.through_velocity_m_s(HALF_INCH_OF_WATER_PA) - 0.508).abs() < 1e-6);
    }
}
