//! Panels of a wing sewn anew, wider or narrower, in the midst of an equilibrium.

use super::{Failure, Simulation};
use crate::case::wing_design::Ballooning;
use crate::cpu::cloth::Cloth;
use crate::geometry::wing;
use crate::gpu;

/// A cut of the panels, and what came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapingStep {
    /// Ballooning that the panels are cut with.
    pub cut: Ballooning,
    /// Ballooning flown: points as in `cut`, where it can be read.
    pub flown: Ballooning,
    /// Distance of neighbouring ribs over the designed one: points as in `cut`, where there are panels.
    pub widths: Ballooning,
    /// Largest difference of what is aimed at.
    pub error_max: f64,
    /// Root of the mean square of it.
    pub error_rms: f64,
    /// Width of cells over the designed one, mean.
    pub cell_width_ratio: f64,
}

impl Simulation {
    /// Cuts of the panels so far; empty where they are as the plan says.
    #[must_use]
    pub fn shaping_steps(&self) -> &[ShapingStep] {
        &self.shaping
    }

    /// Notes what came of a cut.
    pub fn note_shaping(&mut self, step: ShapingStep) {
        self.shaping.push(step);
    }

    /// Sews the wing anew with panels of another ballooning; nodes stay where they are. The mesh keeps its topology, so loads of triangles and nodes keep
    /// their places.
    pub fn reshape_panels(&mut self, ballooning: Ballooning) -> Result<(), Failure> {
        let (Some(known), Some(old)) = (&mut self.scene.wing, self.cloth.take()) else {
            return Ok(());
        };
        known.plan.ballooning = ballooning;
        let sewn = match wing::build(&known.plan, known.fineness) {
            Ok(sewn) => sewn,
            Err(why) => {
                self.cloth = Some(old);
                return Err(Failure::Start(format!(
                    "the panels cannot be sewn anew: {why}"
                )));
            }
        };
        let mut structure = old.structure;
        structure.positions_m = sewn.structure.positions_m;
        structure.masses_kg = sewn.structure.masses_kg;
        structure.triangles = sewn.structure.triangles;
        structure.cables = sewn.structure.cables;
        let mut cloth = Cloth::new(structure);
        cloth.positions_m = old.positions_m;
        cloth.velocities_m_s = old.velocities_m_s;
        if self.device_cloth.is_some()
            && let Some(device) = &self.device
        {
            let device = std::sync::Arc::clone(device);
            let anew = gpu::cloth::Cloth::new(device, &cloth.structure, &[])?;
            self.device_cloth = Some(anew);
        }
        self.cloth = Some(cloth);
        Ok(())
    }
}
