//! When the structure's energy is accounted for, and what others read of it.

use glam::DVec3;

use super::Simulation;
use super::descent::Descent;
use super::energy_account::Energies;
use crate::cpu::cloth::Cloth;

impl Simulation {
    /// Energy of fabric and lines now; `None` without any.
    #[must_use]
    pub fn energies(&self) -> Option<Energies> {
        let gravity_m_s2 = self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO);
        let cloth = self.cloth.as_ref()?;
        Some(self.energy.energies(cloth, gravity_m_s2))
    }

    /// A solve begins.
    pub(super) fn begin_energy(&mut self) {
        let gravity_m_s2 = self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO);
        if let Some(cloth) = &self.cloth {
            self.energy.begin(cloth, gravity_m_s2);
        }
    }

    /// Takes where supports are to be at `time_s`, and counts the work of hauling in risers while the nodes stand still.
    pub(super) fn place_supports_at_work(&mut self, time_s: f64) {
        if self.scene.wing().is_none_or(|wing| wing.pulls.is_empty()) {
            return self.place_supports(time_s);
        }
        let elastic_j = |cloth: &Option<Cloth>| cloth.as_ref().map_or(0.0, Cloth::elastic_energy_j);
        let before_j = elastic_j(&self.cloth);
        self.place_supports(time_s);
        self.energy.work.of_supports_j += elastic_j(&self.cloth) - before_j;
    }

    /// Acceleration that all masses feel in a box that falls, beside gravity [m/s²].
    pub(super) fn frame_m_s2(&self) -> DVec3 {
        let descent = self.descent.as_ref();
        descent.map_or(DVec3::ZERO, Descent::apparent_m_s2)
    }
}
