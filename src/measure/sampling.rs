//! The columns of a scene, and their values at a sample: the tables of all that it holds, one behind the other.

use super::canopy_shape::{self, CanopyShape};
use super::record::Record;
use super::{
    air, bodies, canopy, contact, energy, fabric, falling, line_drag, payload_bodies, permeable,
    plate, residual, solver, supports, wing_wind,
};
use crate::case::Scene;
use crate::case::scene::Canopy;
use crate::gpu::DeviceError;
use crate::simulation::Simulation;

/// What the first columns of a scene describe.
enum Subject {
    Canopy(Canopy),
    FabricInWind,
    Fabric,
    Bodies,
    Air,
}

impl Subject {
    fn of(scene: &Scene) -> Self {
        match (&scene.body, &scene.air) {
            (Some(body), Some(_)) => body
                .canopy()
                .map_or(Self::FabricInWind, |canopy| Self::Canopy(*canopy)),
            (Some(_), None) => Self::Fabric,
            (None, Some(_)) if !scene.rigid_bodies.is_empty() => Self::Bodies,
            (None, _) => Self::Air,
        }
    }
}

/// True for a plate in air.
fn has_plate(scene: &Scene) -> bool {
    scene.air.is_some() && scene.plate().is_some()
}

impl Record {
    /// Record for a scene: its columns follow from what the scene holds.
    #[must_use]
    pub fn new(simulation: &Simulation) -> Self {
        Self::of(simulation.scene())
    }

    /// The same from the scene alone.
    pub(super) fn of(scene: &Scene) -> Self {
        let subject = Subject::of(scene);
        let mut columns = match subject {
            Subject::Canopy(_) => canopy::COLUMNS.read_outs(scene),
            Subject::FabricInWind => fabric::IN_WIND.read_outs(scene),
            Subject::Fabric => fabric::ALONE.read_outs(scene),
            Subject::Bodies => bodies::OF_SCENE.read_outs(scene),
            Subject::Air => air::COLUMNS.read_outs(scene),
        };
        if has_plate(scene) {
            columns.extend(plate::COLUMNS.read_outs(scene));
        }
        let shape = match (&subject, &scene.body) {
            (Subject::Canopy(canopy), Some(body)) => {
                Some(CanopyShape::new(&body.structure, canopy))
            }
            _ => None,
        };
        columns.extend(wing_wind::columns(scene));
        if let Some(shape) = &shape {
            columns.extend(canopy_shape::COLUMNS.read_outs(shape));
        }
        columns.extend(permeable::COLUMNS.read_outs(scene));
        columns.extend(falling::columns(scene));
        columns.extend(payload_bodies::columns(scene));
        columns.extend(line_drag::COLUMNS.read_outs(scene));
        columns.extend(supports::columns(scene));
        columns.extend(contact::COLUMNS.read_outs(scene));
        columns.extend(energy::COLUMNS.read_outs(scene));
        columns.extend(residual::COLUMNS.read_outs(scene));
        columns.extend(solver::COLUMNS.read_outs(scene));
        columns.extend(bodies::columns(scene));
        let details = shape
            .as_ref()
            .map_or_else(Vec::new, CanopyShape::detail_columns);
        Self::with(columns, details, shape)
    }

    /// A record of a scene in which nothing happens, to learn what it measures.
    pub(super) fn at_rest(scene: &Scene) -> Self {
        let mut record = Self::of(scene);
        let end_s = scene.time.map_or(1.0, |time| time.end_s);
        let count = 8;
        for sample in 0..=count {
            let mut row = record.zeros();
            row[0] = end_s * f64::from(sample) / f64::from(count);
            record.push(row);
        }
        record
    }

    /// Adds a sample of the running scene and returns its row of the history.
    pub fn add(&mut self, simulation: &mut Simulation) -> Result<&[f64], DeviceError> {
        let subject = Subject::of(simulation.scene());
        let forces = match subject {
            Subject::Fabric | Subject::Air => None,
            _ => Some(self.impulses.sample(simulation)?),
        };
        let interval = simulation.take_solver_interval();
        let simulation = &*simulation;
        let scene = simulation.scene();
        let mut details = Vec::new();
        let mut row = match (&subject, forces, self.canopy()) {
            (Subject::Canopy(canopy), Some(forces), Some(shape)) => {
                let sample = canopy::Moment::new(simulation, (shape, canopy), forces)?;
                let mut row = canopy::COLUMNS.values(scene, sample.as_ref());
                let seen = sample.as_ref().map(|sample| &sample.shape);
                row.extend(canopy_shape::COLUMNS.values(shape, seen));
                details = match seen {
                    Some(seen) => shape.details(seen),
                    None => vec![f64::NAN; shape.detail_columns().len()],
                };
                row
            }
            (Subject::FabricInWind, Some(forces), _) => {
                let sample = fabric::InWind::new(simulation, forces)?;
                fabric::IN_WIND.values(scene, sample.as_ref())
            }
            (Subject::Bodies, Some(forces), _) => {
                let sample = bodies::Bodies::new(simulation, forces)?;
                bodies::OF_SCENE.values(scene, sample.as_ref())
            }
            (Subject::Fabric, ..) => {
                let sample = fabric::Fabric::new(simulation);
                fabric::ALONE.values(scene, sample.as_ref())
            }
            _ => air::COLUMNS.values(scene, air::Moment::new(simulation)?.as_ref()),
        };
        if let Some(forces) = forces {
            if has_plate(scene) {
                let sample = plate::Moment::new(simulation, forces);
                row.extend(plate::COLUMNS.values(scene, sample.as_ref()));
            }
            row.extend(wing_wind::values(simulation, forces)?);
        }
        let through = simulation.through_velocities_m_s();
        row.extend(permeable::COLUMNS.values(scene, through.as_ref()));
        row.extend(falling::values(simulation, self));
        row.extend(payload_bodies::values(simulation));
        let line_drag_n = simulation.line_drag_n().map(|force| force.x);
        row.extend(line_drag::COLUMNS.values(scene, line_drag_n.as_ref()));
        row.extend(supports::values(simulation));
        let contact = simulation.cloth().and_then(|cloth| cloth.contact_state());
        row.extend(contact::COLUMNS.values(scene, contact));
        row.extend(energy::COLUMNS.values(scene, simulation.energies().as_ref()));
        row.extend(residual::COLUMNS.values(scene, Some(simulation)));
        row.extend(solver::COLUMNS.values(scene, Some(&interval)));
        row.extend(bodies::values(simulation, &self.impulses));
        row.extend(details);
        Ok(self.push(row))
    }
}
