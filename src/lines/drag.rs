//! Drag of a line that is thinner than a cell.
//!
//! Per length ½ ρ C_d d |u_n| u_n, u_n the part of the air's velocity across the line (the cross-flow principle: Hoerner, Fluid-Dynamic Drag,
//! 1965, chapter 3). Friction along the line is left out.

/// What the air sees of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineDrag {
    /// Drag coefficient C_d across the line, about 1.1 for a smooth round one.
    pub coefficient: f64,
    /// Diameter d [m].
    pub diameter_m: f64,
}

impl LineDrag {
    /// Force over velocity of a line of `length_m`, ½ ρ C_d d L |u_n| [kg/s].
    #[must_use]
    pub fn coefficient_kg_s(&self, density_kg_m3: f64, length_m: f64, across_m_s: f64) -> f64 {
        0.5 * density_kg_m3 * self.coefficient * self.diameter_m * length_m * across_m_s
    }
}
