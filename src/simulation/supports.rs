//! Supports that are moved, in motion and in equilibrium, and risers that are hauled in.

use glam::DVec3;

use super::Simulation;

impl Simulation {
    /// Takes where supports are to be at `time_s`, and how long risers are then; nothing where none is moved.
    pub(super) fn place_supports(&mut self, time_s: f64) {
        self.haul_risers(time_s);
        self.moved_supports.clear();
        if let Some(body) = &self.scene.body {
            for support in &self.scene.supports {
                self.moved_supports
                    .extend(support.places_m(&body.structure, time_s));
            }
        }
    }

    /// Shortens the risers of a wing as the case says, on its own mesh.
    pub(super) fn haul_risers(&mut self, time_s: f64) {
        let (Some(wing), Some(body), Some(cloth)) =
            (self.scene.wing(), &self.scene.body, &mut self.cloth)
        else {
            return;
        };
        // A coarser mesh of the wing has other cables.
        if cloth.structure.cables.len() != body.structure.cables.len() {
            return;
        }
        for pull in &wing.pulls {
            for &cable in &pull.cables {
                let designed_m = body.structure.cables[cable].rest_length_m;
                cloth.structure.cables[cable].rest_length_m = designed_m - pull.at(time_s);
            }
        }
    }

    /// Displacement [m] of the middle of every support that is moved, and the force with which it holds the structure [N], by the
    /// reactions of all nodes, `[node_count]`.
    pub fn support_loads(&self, reactions_n: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
        let pairs = self.cloth.as_ref().zip(self.scene.body.as_ref());
        self.scene.supports.iter().filter_map(move |support| {
            let (cloth, body) = pairs?;
            let (mut way, mut force) = (DVec3::ZERO, DVec3::ZERO);
            for &node in &support.nodes {
                let node = node as usize;
                way += cloth.positions_m[node] - body.structure.positions_m[node];
                force += reactions_n.get(node).copied().unwrap_or(DVec3::NAN);
            }
            Some((way / support.nodes.len() as f64, force))
        })
    }
}
