//! Cloths known by name: what a designer orders, with the constants that a membrane needs.
//!
//! Weights and permeabilities are those of the specifications. Stiffness is not specified: it is that of the parachute fabric in "Effect of Shear
//! Modulus on the Inflation Deformation of Parachutes" (thickness 0.1 mm, E 431 MPa, Poisson's ratio 0.14: 43.1 kN/m), in proportion to the weight.

use super::permeability::{NAMED_FABRICS, NamedFabric};

/// kg/m² of one ounce per square yard.
const OUNCE_PER_SQUARE_YARD_KG_M2: f64 = 0.028_349_523 / (0.9144 * 0.9144);

/// Weight of the fabric whose stiffness is known [oz/yd²].
const KNOWN_WEIGHT_OZ_YD2: f64 = 1.2;

/// Its stiffness, E times thickness [N/m].
const KNOWN_STIFFNESS_N_M: f64 = 4.31e8 * 1e-4;

/// Thickness that a woven cloth of this weight has [m per kg/m²]: 0.08 mm at 40 g/m².
const THICKNESS_M_PER_KG_M2: f64 = 8e-5 / 0.04;

/// A cloth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cloth {
    /// Name in case files.
    pub name: &'static str,
    /// Weight as specified [oz/yd²].
    pub weight_oz_yd2: f64,
    /// Name of its specification, as in [`NAMED_FABRICS`].
    pub specification: &'static str,
}

/// Cloths known by name.
pub const CLOTHS: [Cloth; 4] = [
    Cloth {
        name: "ripstop 40 g/m²",
        weight_oz_yd2: 1.2,
        specification: "pia_c_44378_type_4",
    },
    Cloth {
        name: "ripstop 38 g/m², low permeability",
        weight_oz_yd2: 1.12,
        specification: "pia_c_44378_type_2",
    },
    Cloth {
        name: "ripstop 37 g/m², permeable",
        weight_oz_yd2: 1.1,
        specification: "mil_c_7020_type_1",
    },
    Cloth {
        name: "ripstop 54 g/m², permeable",
        weight_oz_yd2: 1.6,
        specification: "mil_c_7020_type_3",
    },
];

impl Cloth {
    /// Poisson's ratio.
    pub const POISSON_RATIO: f64 = 0.14;

    /// Mass per area [kg/m²].
    #[must_use]
    pub fn areal_density_kg_m2(&self) -> f64 {
        self.weight_oz_yd2 * OUNCE_PER_SQUARE_YARD_KG_M2
    }

    /// Thickness [m].
    #[must_use]
    pub fn thickness_m(&self) -> f64 {
        self.areal_density_kg_m2() * THICKNESS_M_PER_KG_M2
    }

    /// Young's modulus [Pa].
    #[must_use]
    pub fn youngs_modulus_pa(&self) -> f64 {
        self.weight_oz_yd2 / KNOWN_WEIGHT_OZ_YD2 * KNOWN_STIFFNESS_N_M / self.thickness_m()
    }

    /// Where weight and permeability are from.
    #[must_use]
    pub fn source(&self) -> &'static str {
        let known = NAMED_FABRICS.iter().find(|f| f.name == self.specification);
        known.map_or("", |NamedFabric { source, .. }| source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_the_weight_and_stiffness_is_that_of_the_paper() {
        for cloth in CLOTHS {
            let grams = format!("{:.0} g/m²", 1e3 * cloth.areal_density_kg_m2());
            // 1.2 oz/yd² are 40.7 g/m², which the trade calls 40.
            assert!(
                cloth.name.contains(&grams) || cloth.name == "ripstop 40 g/m²",
                "{}: {grams}",
                cloth.name
            );
            assert!(!cloth.source().is_empty());
        }
        let stiffness = CLOTHS[0].youngs_modulus_pa() * CLOTHS[0].thickness_m();
        assert!((stiffness / 43_100.0 - 1.0).abs() < 1e-12);
    }
}
