//! The sheet that is solved, and what is solved for it.

use glam::DVec3;
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::{Cloth, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};

const RIPSTOP: Fabric = Fabric {
    thickness_m: 1e-4,
    density_kg_m3: 530.0,
    warp_modulus_pa: 4.3e8,
    weft_modulus_pa: 4.3e8,
    poisson_ratio: 1.0 / 3.0,
    shear_modulus_pa: 4.3e8 / (2.0 * (1.0 + 1.0 / 3.0)),
    cubic_shear_compliance_1_pa3: None,
    residual_stiffness: 1.0,
    initial_strain: [0.0; 2],
    yield_stress_pa: None,
};

/// One solve of a square sheet of 1 m² that hangs at its four corners, from flat with 10 µm of noise.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct Problem {
    /// Springs that also push, or tension-only membrane triangles.
    pub fabric: &'static str,
    /// Cells along a side.
    pub side: usize,
    /// Young's modulus against that of ripstop nylon.
    pub softness: f64,
    /// Time step [s]; absent for the static equilibrium.
    pub time_step_s: Option<f64>,
    /// Dead load [Pa].
    pub pressure_pa: f64,
    /// Pressure under which the start is in static equilibrium; absent for the flat sheet [Pa].
    pub warm_pressure_pa: Option<f64>,
}

impl Problem {
    /// Static, cold, 50 Pa.
    pub const fn new(fabric: &'static str, side: usize) -> Self {
        Self {
            fabric,
            side,
            softness: 1.0,
            time_step_s: None,
            pressure_pa: 50.0,
            warm_pressure_pa: None,
        }
    }

    /// What is solved for, in words.
    pub fn name(&self) -> String {
        let step = self
            .time_step_s
            .map_or("static".to_owned(), |dt| format!("step {dt} s"));
        let soft = if self.softness == 1.0 {
            String::new()
        } else {
            format!(", {} E", self.softness)
        };
        let warm = if self.warm_pressure_pa.is_some() {
            ", warm"
        } else {
            ""
        };
        format!("{} {step}{soft}{warm}", self.fabric)
    }

    /// Cells that a stretching wave crosses in a step, √(E/ρ) dt over the mesh size.
    pub fn cells_crossed(&self) -> f64 {
        let speed_m_s = (RIPSTOP.warp_modulus_pa * self.softness / RIPSTOP.density_kg_m3).sqrt();
        self.time_step_s
            .map_or(f64::INFINITY, |dt| speed_m_s * dt * self.side as f64)
    }

    /// The sheet where the solve starts, but for a warm start flat.
    pub fn cloth(&self) -> Cloth {
        Cloth::new(self.structure())
    }

    /// What acts.
    pub fn input(&self) -> StepInput<'static> {
        StepInput {
            time_step_s: self.time_step_s,
            // As a weight, which stays as it is.
            gravity_m_s2: DVec3::Z * (self.pressure_pa / RIPSTOP.areal_density_kg_m2()),
            ..StepInput::default()
        }
    }

    fn structure(&self) -> Structure {
        let side = self.side;
        let shape = SheetShape {
            size_m: [1.0, 1.0],
            divisions: [side, side],
            corner_m: DVec3::ZERO,
            across: DVec3::X,
            down: DVec3::Y,
        };
        let (model, residual_stiffness) = match self.fabric {
            "network" => (FabricModel::Network, 1.0),
            "membrane" => (FabricModel::Membrane, 1.0),
            _ => (FabricModel::Membrane, 1e-3),
        };
        let fabric = Fabric {
            residual_stiffness,
            warp_modulus_pa: RIPSTOP.warp_modulus_pa * self.softness,
            weft_modulus_pa: RIPSTOP.weft_modulus_pa * self.softness,
            shear_modulus_pa: RIPSTOP.shear_modulus_pa * self.softness,
            ..RIPSTOP
        };
        let mut structure = sheet::build(&shape, &fabric, model).unwrap();
        for (i, j) in [(0, 0), (side, 0), (0, side), (side, side)] {
            structure.held[shape.node(i, j) as usize] = true;
        }
        let mut state = 1u32;
        for (x, held) in structure.positions_m.iter_mut().zip(&structure.held) {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if !held {
                x.z += 2e-5 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5);
            }
        }
        structure
    }
}
