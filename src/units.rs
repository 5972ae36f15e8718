//! SI ↔ lattice units: the scales are computed here and nowhere else.
//!
//! Inside the air a cell, a time step and the density of undisturbed air are 1.

use glam::DVec3;

/// Scales of a scene with air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Edge length of a cell [m].
    pub cell_size_m: f64,
    /// Time step of the air [s].
    pub time_step_s: f64,
    /// Density of undisturbed air [kg/m³].
    pub density_kg_m3: f64,
    /// Corner of the lattice that positions are counted from [m]: that of the finest cells around the structure.
    pub origin_m: DVec3,
}

impl Units {
    /// Scales in which `speed_m_s` becomes `lattice_speed` [cells per step].
    #[must_use]
    pub fn from_speed(
        cell_size_m: f64,
        speed_m_s: f64,
        lattice_speed: f64,
        density_kg_m3: f64,
    ) -> Self {
        Self {
            cell_size_m,
            time_step_s: lattice_speed * cell_size_m / speed_m_s,
            density_kg_m3,
            origin_m: DVec3::ZERO,
        }
    }

    /// The same cells in steps that are `factor` times as long.
    #[must_use]
    pub fn with_step_factor(self, factor: f64) -> Self {
        Self {
            time_step_s: self.time_step_s * factor,
            ..self
        }
    }

    /// m/s of one cell per step.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.cell_size_m / self.time_step_s
    }

    /// Newtons of one lattice unit of force.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.density_kg_m3 * self.cell_size_m.powi(4) / self.time_step_s.powi(2)
    }

    /// N·s (kg·m/s) of one lattice unit of momentum.
    #[must_use]
    pub fn impulse_n_s(&self) -> f64 {
        self.force_n() * self.time_step_s
    }

    /// kg/s of one lattice unit of immersed-boundary stiffness (force per velocity).
    #[must_use]
    pub fn stiffness_kg_s(&self) -> f64 {
        self.density_kg_m3 * self.cell_size_m.powi(3) / self.time_step_s
    }

    /// Pascals of a density excess δρ = 1, p = cs² δρ.
    #[must_use]
    pub fn pressure_pa(&self) -> f64 {
        self.density_kg_m3 * self.speed_m_s().powi(2) / 3.0
    }

    /// Relaxation time τ = 3 ν dt/dx² + ½ for a kinematic viscosity [m²/s].
    #[must_use]
    pub fn relaxation_time(&self, kinematic_viscosity_m2_s: f64) -> f64 {
        3.0 * kinematic_viscosity_m2_s * self.time_step_s / self.cell_size_m.powi(2) + 0.5
    }

    /// Lattice velocity [cells per step].
    #[must_use]
    pub fn velocity_to_lattice(&self, velocity_m_s: DVec3) -> [f64; 3] {
        (velocity_m_s / self.speed_m_s()).to_array()
    }

    /// Velocity [m/s] of a lattice velocity.
    #[must_use]
    pub fn velocity_m_s(&self, velocity: [f64; 3]) -> DVec3 {
        DVec3::from_array(velocity) * self.speed_m_s()
    }

    /// Position in cells of the lattice, whose first cell's centre is the origin.
    #[must_use]
    pub fn position_to_lattice(&self, position_m: DVec3) -> [f64; 3] {
        ((position_m - self.origin_m) / self.cell_size_m - DVec3::splat(0.5)).to_array()
    }

    /// Position [m] of a lattice position.
    #[must_use]
    pub fn position_m(&self, position: [f64; 3]) -> DVec3 {
        self.origin_m + (DVec3::from_array(position) + DVec3::splat(0.5)) * self.cell_size_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_consistent() {
        let units = Units::from_speed(0.04, 30.0, 0.08, 1.2);
        assert!((units.velocity_to_lattice(DVec3::X * 30.0)[0] - 0.08).abs() < 1e-15);
        // Force = mass · acceleration: one cell of air under one cell per step² in both systems.
        let force = units.density_kg_m3 * units.cell_size_m.powi(3) * units.cell_size_m
            / units.time_step_s.powi(2);
        assert!((force / units.force_n() - 1.0).abs() < 1e-12);
        // Dynamic pressure ½ ρ u² of lattice speed u is ½ u² / cs² density excess.
        let excess = 0.5 * 0.08 * 0.08 * 3.0;
        assert!((units.pressure_pa() * excess - 0.5 * 1.2 * 900.0).abs() < 1e-9);
        let x = DVec3::new(0.3, 0.1, 0.7);
        assert!((units.position_m(units.position_to_lattice(x)) - x).length() < 1e-15);
    }
}
