//! The structure between two solves: where it is, and what acts on it at rest.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::cloth::Structure;
use crate::cpu::cloth::{Cloth, StepBefore};
use crate::trim::Loads;

/// What acts on the structure in a static equilibrium, beside gravity.
#[derive(Debug, Clone, PartialEq)]
pub enum StaticLoads {
    /// The pressure that the case prescribes, if it does.
    Prescribed,
    /// Those of a glide, or a multiple of them.
    Given(Loads),
}

/// Where fabric and cables are.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StructureState {
    /// Positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Velocities [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
    /// Where guides rest [m], `[guide_count]`.
    pub guide_anchors_m: Vec<DVec3>,
    /// Where the structure was a step before, for a step that asks for it; not part of what is written.
    #[serde(skip)]
    pub step_before: Option<StepBefore>,
}

impl StructureState {
    /// True if it is one of this structure.
    #[must_use]
    pub fn fits(&self, structure: &Structure) -> bool {
        let lengths = [self.positions_m.len(), self.velocities_m_s.len()];
        lengths == [structure.node_count(); 2]
            && self.guide_anchors_m.len() == structure.guides.len()
    }

    /// Puts the fabric back to where it was.
    pub(super) fn put_back(&self, cloth: &mut Cloth) {
        cloth.positions_m.copy_from_slice(&self.positions_m);
        cloth.velocities_m_s.copy_from_slice(&self.velocities_m_s);
        cloth.step_before.clone_from(&self.step_before);
        let guides = cloth.structure.guides.iter_mut();
        for (guide, anchor_m) in guides.zip(&self.guide_anchors_m) {
            guide.anchor_m = *anchor_m;
        }
    }
}
