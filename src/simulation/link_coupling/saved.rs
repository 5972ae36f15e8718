//! What a checkpoint keeps of surfaces that cut links.

use super::LinkCoupling;
use crate::checkpoint::{CheckpointError, Reader, Writer};

impl LinkCoupling {
    pub(in crate::simulation) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("link_face_pressures", self.surface.face_pressures())?;
        if let Some(layers) = self.surface.boundary_layers() {
            out.put("link_boundary_layers", &layers.saved())?;
            out.put("link_boundary_layer_steps_left", &[layers.steps_left()])?;
        }
        if let Some(mean) = self.surface.mean_through() {
            out.put("link_mean_through", &[mean])?;
        }
        out.put("link_velocities", &self.velocities)?;
        out.put("link_positions", &self.positions)?;
        let sums: Vec<[f64; 3]> = [self.force_on_air, self.fabric_force_on_air]
            .into_iter()
            .chain(self.loads.iter().flat_map(|load| [load.force, load.moment]))
            .collect();
        out.put("link_forces", &sums)?;
        out.put("link_fastest", &[self.fastest])
    }

    pub(in crate::simulation) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let count = self.positions.len();
        let excess = from.take_exactly("link_face_pressures", count)?;
        self.velocities = from.take_exactly("link_velocities", count)?;
        self.positions = from.take_exactly("link_positions", count)?;
        let (layers, steps_left) = match self.surface.boundary_layers() {
            Some(layers) => (
                from.take_exactly("link_boundary_layers", layers.saved().len())?,
                from.take_exactly("link_boundary_layer_steps_left", 1)?[0],
            ),
            None => (Vec::new(), 0),
        };
        if self.surface.mean_through().is_some() {
            let mean = from.take_exactly::<f64>("link_mean_through", 1)?[0];
            self.surface.go_on_with_mean_through(mean);
        }
        let layers = (&*layers, steps_left);
        self.surface.go_on(excess, layers, self.positions.clone());
        let sums: Vec<[f64; 3]> = from.take_exactly("link_forces", 2 + 2 * self.loads.len())?;
        (self.force_on_air, self.fabric_force_on_air) = (sums[0], sums[1]);
        for (load, pair) in self.loads.iter_mut().zip(sums[2..].chunks_exact(2)) {
            (load.force, load.moment) = (pair[0], pair[1]);
        }
        self.fastest = from.take_exactly::<f64>("link_fastest", 1)?[0];
        Ok(())
    }
}
