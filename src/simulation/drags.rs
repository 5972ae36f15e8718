//! Drag of single nodes in a step: of the payload, of what hangs below it, and of suspension lines in the undisturbed wind.

use glam::DVec3;

use super::Simulation;
use super::descent::{Descent, Fall};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::line_drag::add_line_drags;
use crate::cpu::cloth::{Cloth, NodalDrag};

impl Simulation {
    /// Drag of the payload, and of the lines in the undisturbed wind, for the step that begins.
    pub(super) fn gather_drags(&mut self) {
        self.drags.clear();
        if self.step < self.plan.start_steps {
            return;
        }
        if let Some(descent) = &self.descent {
            self.drags.extend_from_slice(descent.drags());
        }
        let speed_m_s = self.wind_speed_at(self.step + 1);
        if let (Some(cloth), Some(air)) = (&self.cloth, &self.scene.air) {
            let wind = |place_m| DVec3::X * (speed_m_s * air.wind_ratio_at(place_m));
            add_line_drags(
                &cloth.structure,
                &cloth.positions_m,
                &cloth.velocities_m_s,
                (air.units.density_kg_m3, wind),
                &mut self.drags,
            );
        }
    }

    /// Force of the air on the suspension lines in the last step [N]; `None` where they have no drag.
    #[must_use]
    pub fn line_drag_n(&self) -> Option<DVec3> {
        let cloth = self.cloth.as_ref()?;
        if !cloth.structure.has_line_drag() {
            return None;
        }
        let payload = self.descent.as_ref().map_or(0, |d| d.drags().len());
        let of_lines = self.drags.get(payload..).unwrap_or_default();
        Some(
            of_lines
                .iter()
                .map(|drag| {
                    let slip = drag.air_velocity_m_s - cloth.velocities_m_s[drag.node as usize];
                    slip * drag.coefficient_kg_s
                })
                .sum(),
        )
    }

    /// Speed of what falls, and height fallen; `None` where nothing falls.
    #[must_use]
    pub fn fall(&self) -> Option<Fall> {
        let descent = self.descent.as_ref()?;
        Some(descent.fall(self.cloth.as_ref()))
    }

    /// Gravity with what the box adds to it in this step [m/s²]; `None` where neither acts.
    pub(super) fn felt_gravity_m_s2(&self) -> Option<DVec3> {
        match (self.scene.gravity_m_s2, &self.descent) {
            (None, None) => None,
            (gravity, descent) => {
                let apparent = descent.as_ref().map_or(DVec3::ZERO, Descent::apparent_m_s2);
                Some(gravity.unwrap_or(DVec3::ZERO) + apparent)
            }
        }
    }

    /// True if payload or lines have drag of their own.
    pub(super) fn has_drags(&self) -> bool {
        let of_lines = |cloth: &Cloth| cloth.structure.has_line_drag();
        self.descent.is_some() || self.cloth.as_ref().is_some_and(of_lines)
    }

    /// Read-outs between steps show the drag of the step before.
    pub(super) fn save_drags(&self, out: &mut Writer) -> std::io::Result<()> {
        let words: Vec<[f64; 5]> = self
            .drags
            .iter()
            .map(|drag| {
                let [x, y, z] = drag.air_velocity_m_s.to_array();
                [f64::from(drag.node), drag.coefficient_kg_s, x, y, z]
            })
            .collect();
        out.put("drags", &words)?;
        let of_payload = self.descent.as_ref().map_or(0, |d| d.drags().len());
        out.put("drags_of_payload", &[of_payload as u64])
    }

    pub(super) fn restore_drags(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let words: Vec<[f64; 5]> = from.take("drags")?;
        self.drags = words
            .into_iter()
            .map(|[node, coefficient_kg_s, x, y, z]| NodalDrag {
                node: node as u32,
                coefficient_kg_s,
                air_velocity_m_s: DVec3::new(x, y, z),
            })
            .collect();
        let nodes = self.cloth.as_ref().map_or(0, |c| c.structure.node_count());
        if self.drags.iter().any(|drag| drag.node as usize >= nodes) {
            return Err(from.damaged("a drag acts on a node that does not exist".to_owned()));
        }
        let of_payload = from.take_exactly::<u64>("drags_of_payload", 1)?[0] as usize;
        if let Some(descent) = &mut self.descent {
            descent.drags = self.drags.iter().take(of_payload).copied().collect();
        }
        Ok(())
    }
}
