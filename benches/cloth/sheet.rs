//! The sheet that is solved, and what is solved for it.

use std::f64::consts::PI;

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
    /// Distance of its two upper corners, by which alone it hangs under its weight [m]; absent: it hangs at four.
    pub hung_width_m: Option<f64>,
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
            hung_width_m: None,
            warm_pressure_pa: None,
        }
    }

    /// A sheet that hangs slack between two corners, under its own weight.
    pub fn slack(fabric: &'static str, side: usize, hung_width_m: f64) -> Self {
        Self {
            pressure_pa: 9.81 * RIPSTOP.areal_density_kg_m2(),
            hung_width_m: Some(hung_width_m),
            ..Self::new(fabric, side)
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
        let slack = self
            .hung_width_m
            .map_or(String::new(), |width| format!(", hung to {width} m"));
        format!("{} {step}{soft}{warm}{slack}", self.fabric)
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
            down: match self.hung_width_m {
                Some(_) => DVec3::Z,
                None => DVec3::Y,
            },
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
            shear_modulus_pa: match self.hung_width_m {
                // As it is measured.
                Some(_) => 1e7,
                None => RIPSTOP.shear_modulus_pa * self.softness,
            },
            ..RIPSTOP
        };
        let mut structure = sheet::build(&shape, &fabric, model).unwrap();
        if let Some(width_m) = self.hung_width_m {
            structure.held[shape.node(0, 0) as usize] = true;
            structure.held[shape.node(side, 0) as usize] = true;
            gather(&mut structure, width_m);
            return structure;
        }
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

/// Brings the width of a sheet of 1 m together to `width_m`, in a bulge.
fn gather(structure: &mut Structure, width_m: f64) {
    let bulge_m = (0.5 * (1.0 - width_m * width_m)).max(0.0).sqrt() / PI;
    for place in &mut structure.positions_m {
        let (s, t) = (place.x, place.z);
        *place = DVec3::new(s * width_m, bulge_m * (PI * s).sin() * (1.0 + 0.2 * t), t);
    }
}
