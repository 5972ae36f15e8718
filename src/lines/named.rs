//! Cords and tapes known by name: what a rigger orders, with the constants of a linear cable.
//!
//! Strength, length per weight and elongation of cords are those of MIL-C-5040H (types I to IV), the strength of tapes that of MIL-T-5038
//! (type III). Their law is the straight line from nothing to strength and elongation at break. Tapes are taken to be as heavy for their strength, and
//! as stretchy, as the cord of type III.

/// N of one pound-force.
const POUND_FORCE_N: f64 = 4.448_222;

/// kg/m of one pound per foot.
const POUND_PER_FOOT_KG_M: f64 = 0.453_592_37 / 0.3048;

/// Density of nylon 6.6 [kg/m³].
const NYLON_KG_M3: f64 = 1140.0;

/// Elongation at break that MIL-C-5040 asks for at least.
const ELONGATION: f64 = 0.30;

/// Strength over mass per length of the cord of type III [N m/kg].
const SPECIFIC_STRENGTH: f64 = 550.0 * POUND_FORCE_N / (POUND_PER_FOOT_KG_M / 225.0);

/// A cord or tape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cord {
    /// Name in case files.
    pub name: &'static str,
    /// Strength [lbf].
    pub strength_lbf: f64,
    /// Length that weighs one pound \[ft\]; `None`: from the strength.
    pub feet_per_pound: Option<f64>,
    /// Where its numbers stand.
    pub source: &'static str,
}

/// Suspension lines known by name.
pub const CORDS: [Cord; 4] = [
    cord("nylon cord 95 lbf", 95.0, 950.0, "MIL-C-5040H, type I"),
    cord("nylon cord 400 lbf", 400.0, 265.0, "MIL-C-5040H, type II"),
    cord("nylon cord 550 lbf", 550.0, 225.0, "MIL-C-5040H, type III"),
    cord("nylon cord 750 lbf", 750.0, 165.0, "MIL-C-5040H, type IV"),
];

/// Tapes along seams known by name.
pub const TAPES: [Cord; 3] = [
    tape("nylon tape 10 mm, 200 lbf", 200.0),
    tape("nylon tape 13 mm, 250 lbf", 250.0),
    tape("nylon tape 25 mm, 525 lbf", 525.0),
];

const fn cord(
    name: &'static str,
    strength_lbf: f64,
    feet_per_pound: f64,
    source: &'static str,
) -> Cord {
    Cord {
        name,
        strength_lbf,
        feet_per_pound: Some(feet_per_pound),
        source,
    }
}

const fn tape(name: &'static str, strength_lbf: f64) -> Cord {
    Cord {
        name,
        strength_lbf,
        feet_per_pound: None,
        source: "MIL-T-5038, type III; mass and stretch as of the cord MIL-C-5040H, type III",
    }
}

impl Cord {
    /// Density [kg/m³].
    pub const DENSITY_KG_M3: f64 = NYLON_KG_M3;

    /// Strength [N].
    #[must_use]
    pub const fn strength_n(&self) -> f64 {
        self.strength_lbf * POUND_FORCE_N
    }

    /// Mass per length [kg/m].
    #[must_use]
    pub const fn mass_per_length_kg_m(&self) -> f64 {
        match self.feet_per_pound {
            Some(feet) => POUND_PER_FOOT_KG_M / feet,
            None => self.strength_n() / SPECIFIC_STRENGTH,
        }
    }

    /// Cross section of its fibres [m²].
    #[must_use]
    pub const fn area_m2(&self) -> f64 {
        self.mass_per_length_kg_m() / NYLON_KG_M3
    }

    /// Young's modulus of its fibres along it [Pa].
    #[must_use]
    pub const fn youngs_modulus_pa(&self) -> f64 {
        self.strength_n() / ELONGATION / self.area_m2()
    }

    /// Diameter that the wind meets: of a round cord half of which is fibre [m].
    #[must_use]
    pub fn diameter_m(&self) -> f64 {
        (8.0 * self.area_m2() / std::f64::consts::PI).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cord_of_550_lbf_is_what_it_is_known_to_be() {
        let cord = CORDS[2];
        assert!((cord.strength_n() - 2446.5).abs() < 0.1);
        assert!((1e3 * cord.mass_per_length_kg_m() - 6.614).abs() < 1e-3);
        let stiffness_n = cord.youngs_modulus_pa() * cord.area_m2();
        assert!((stiffness_n - 2446.5 / 0.3).abs() < 1.0);
        // Sold as 4 mm (5/32 inch).
        assert!(
            (1e3 * cord.diameter_m() - 4.0).abs() < 0.3,
            "{}",
            cord.diameter_m()
        );
    }
}
