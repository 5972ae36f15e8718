//! Panels of a wing sewn anew, wider or narrower, in the midst of an equilibrium.

use super::{Failure, Simulation};
use crate::case::wing_design::Ballooning;
use crate::cpu::cloth::Cloth;
use crate::geometry::wing::{self, plan::Plan};

impl Simulation {
    /// Sews the wing anew with panels of another ballooning; nodes stay where they are. The mesh keeps its topology, so loads of triangles and nodes keep
    /// their places.
    pub fn reshape_panels(&mut self, ballooning: Ballooning) -> Result<(), Failure> {
        let (Some(known), Some(old)) = (self.scene.wing(), &self.cloth) else {
            return Ok(());
        };
        let plan = Plan {
            ballooning,
            ..known.plan.clone()
        };
        let sewn = wing::build(&plan, known.fineness)
            .map_err(|why| Failure::Start(format!("the panels cannot be sewn anew: {why}")))?;
        let mut structure = old.structure.clone();
        structure.positions_m = sewn.structure.positions_m;
        structure.masses_kg = sewn.structure.masses_kg;
        structure.triangles = sewn.structure.triangles;
        structure.cables = sewn.structure.cables;
        let mut cloth = Cloth::new(structure);
        cloth.positions_m.clone_from(&old.positions_m);
        cloth.velocities_m_s.clone_from(&old.velocities_m_s);
        self.take_fabric(cloth)?;
        Ok(())
    }
}
