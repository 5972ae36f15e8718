//! Time series of a run: one row per sample, the columns of `history.csv`.

mod samples;
mod stored;

use std::path::Path;

use glam::DVec3;

use super::canopy_shape::CanopyShape;
use super::{bodies, falling, payload_bodies, plate, residual, solver, supports, wing_wind};
use crate::case::Scene;
use crate::case::scene::{BodyKind, Canopy, Carrier};
use crate::frame::CableKind;
use crate::geometry::parachute::shape;
use crate::gpu::DeviceError;
use crate::simulation::{BodyImpulse, Simulation};
pub use samples::SAMPLES_FILE;
use samples::Samples;

/// Samples of a run.
#[derive(Debug, Default)]
pub struct Record {
    columns: Vec<String>,
    /// How many of the columns belong to the history; those behind describe single lines and gores.
    history_columns: usize,
    canopy: Option<CanopyShape>,
    samples: Samples,
    last: Option<LastImpulses>,
    /// Impulse and angular impulse of every rigid body at the last two samples.
    body_impulses: [Vec<BodyImpulse>; 2],
    /// Impulse of all markers along x at the last two samples [N s].
    markers_x: [Option<f64>; 2],
    /// Time between the last two samples [s].
    interval_s: f64,
    /// When the run went on on a finer grid; `None` if it never did [s].
    grid_changed_s: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct LastImpulses {
    time_s: f64,
    markers: DVec3,
    momentum_box: DVec3,
    supports: DVec3,
}

const CANOPY: [&str; 19] = [
    "time_s",
    "wind_speed_m_s",
    "drag_coefficient",
    "drag_coefficient_momentum_box",
    "drag_coefficient_lines",
    "force_y_n",
    "force_z_n",
    "impulse_markers_n_s",
    "impulse_momentum_box_n_s",
    "impulse_lines_n_s",
    "projected_diameter_ratio",
    "height_m",
    "line_tension_mean_n",
    "line_tension_max_n",
    "stress_max_pa",
    "slip_ratio",
    "apex_offset_m",
    "fabric_kinetic_energy_j",
    "mass_defect",
];

/// Behind the others where fabric meets itself; no gap where nothing is closer than the thickness.
const CONTACT: [&str; 2] = ["smallest_gap_m", "contact_energy_j"];

/// A sheet or a mesh in the wind.
const FABRIC_IN_WIND: [&str; 13] = [
    "time_s",
    "wind_speed_m_s",
    "force_x_n",
    "force_y_n",
    "force_z_n",
    "force_x_momentum_box_n",
    "impulse_markers_n_s",
    "impulse_momentum_box_n_s",
    "tension_max_n_m",
    "slip_ratio",
    "fabric_kinetic_energy_j",
    "fastest_node_m_s",
    "mass_defect",
];

const FABRIC: [&str; 5] = [
    "time_s",
    "lowest_point_m",
    "tension_max_n_m",
    "kinetic_energy_j",
    "fastest_node_m_s",
];

const AIR: [&str; 4] = [
    "time_s",
    "kinetic_energy_j",
    "velocity_amplitude_m_s",
    "mass_excess_kg",
];

/// Mean velocity of the air through permeable surfaces, and what residual slip adds to it.
const THROUGH: [&str; 2] = ["through_velocity_m_s", "through_velocity_of_slip_m_s"];

impl Record {
    /// Record for a scene: its columns follow from what the scene holds.
    #[must_use]
    pub fn new(simulation: &Simulation) -> Self {
        Self::of(simulation.scene())
    }

    /// The same from the scene alone.
    pub(super) fn of(scene: &Scene) -> Self {
        let columns: &[&str] = match (&scene.body, &scene.air) {
            (Some(body), Some(_)) if matches!(body.kind, BodyKind::Canopy(_)) => &CANOPY,
            (Some(_), Some(_)) => &FABRIC_IN_WIND,
            (Some(_), None) => &FABRIC,
            (None, Some(_)) if !scene.rigid_bodies.is_empty() => &bodies::SCENE_COLUMNS,
            (None, _) => &AIR,
        };
        let mut columns: Vec<String> = columns.iter().map(|&name| name.to_owned()).collect();
        if let (Some(BodyKind::Plate(_)), Some(_)) =
            (scene.body.as_ref().map(|b| &b.kind), &scene.air)
        {
            columns.extend(plate::COLUMNS.map(str::to_owned));
        }
        let canopy = match (&scene.body, &scene.air) {
            (Some(body), Some(_)) => match &body.kind {
                BodyKind::Canopy(canopy) => Some(CanopyShape::new(&body.structure, canopy)),
                _ => None,
            },
            _ => None,
        };
        columns.extend(wing_wind::columns(scene));
        columns.extend(canopy.iter().flat_map(CanopyShape::columns));
        let structure = scene.body.as_ref().map(|body| &body.structure);
        let permeable = structure.is_some_and(|s| s.permeability.is_some())
            || scene.rigid_bodies.iter().any(|b| b.permeability.is_some());
        if permeable && scene.air.is_some() {
            columns.extend(THROUGH.map(str::to_owned));
        }
        columns.extend(falling::columns(scene));
        columns.extend(payload_bodies::columns(scene));
        if structure.is_some_and(|s| s.line_drag.is_some()) {
            columns.push("line_drag_n".to_owned());
        }
        columns.extend(supports::columns(scene));
        if structure.is_some_and(|s| s.contact.is_some()) {
            columns.extend(CONTACT.map(str::to_owned));
        }
        columns.extend(residual::columns(scene));
        columns.extend(solver::columns(scene));
        for body in &scene.rigid_bodies {
            let prefix = bodies::prefix(scene, body);
            columns.extend(bodies::COLUMNS.map(|name| format!("{prefix}{name}")));
        }
        let history_columns = columns.len();
        columns.extend(canopy.iter().flat_map(CanopyShape::detail_columns));
        let samples = Samples::new(columns.len());
        Self {
            columns,
            history_columns,
            samples,
            canopy,
            ..Self::default()
        }
    }

    /// Names of the columns of the history, units included.
    #[must_use]
    pub fn columns(&self) -> Vec<&str> {
        let history = &self.columns[..self.history_columns];
        history.iter().map(String::as_str).collect()
    }

    /// Time and the columns of single lines and gores, which are not part of the history: names, then rows; `None` without any.
    #[must_use]
    pub fn details(&self) -> Option<(Vec<&str>, impl Iterator<Item = Vec<f64>>)> {
        let own = &self.columns[self.history_columns..];
        let first = self.columns.iter().position(|name| name == "time_s")?;
        (!own.is_empty()).then(|| {
            let names = std::iter::once("time_s").chain(own.iter().map(String::as_str));
            let rows = self.samples.rows().map(move |row| {
                let own = row[self.history_columns..].iter().copied();
                std::iter::once(row[first]).chain(own).collect()
            });
            (names.collect(), rows)
        })
    }

    /// Parts of the canopy, where there is one in air.
    pub(super) fn canopy(&self) -> Option<&CanopyShape> {
        self.canopy.as_ref()
    }

    /// A record of a scene in which nothing happens, to learn what it measures.
    pub(super) fn at_rest(scene: &Scene) -> Self {
        let mut record = Self::of(scene);
        let end_s = scene.time.map_or(1.0, |time| time.end_s);
        let count = 8;
        for sample in 0..=count {
            let mut row = vec![0.0; record.columns.len()];
            row[0] = end_s * f64::from(sample) / f64::from(count);
            record.samples.push(row);
        }
        record
    }

    /// One column.
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<f64> {
        let Some(index) = self.columns.iter().position(|c| *c == name) else {
            return Vec::new();
        };
        self.samples.column(index)
    }

    /// Last value of a column.
    #[must_use]
    pub fn latest(&self, name: &str) -> Option<f64> {
        let index = self.columns.iter().position(|c| *c == name)?;
        self.samples.last().map(|row| row[index])
    }

    /// The run goes on on a finer grid: what comes settles anew.
    pub const fn grid_changes(&mut self, time_s: f64) {
        self.grid_changed_s = Some(time_s);
    }

    /// When the run went on on a finer grid, if it did [s].
    #[must_use]
    pub const fn grid_changed_s(&self) -> Option<f64> {
        self.grid_changed_s
    }

    /// Adds a sample of the running scene and returns its row of the history.
    pub fn add(&mut self, simulation: &mut Simulation) -> Result<&[f64], DeviceError> {
        let scene = simulation.scene();
        let in_air = scene.air.is_some();
        let kind = scene.body.as_ref().map(|body| body.kind.clone());
        let has_bodies = !scene.rigid_bodies.is_empty();
        let mut details = Vec::new();
        let mut row = match &kind {
            Some(BodyKind::Canopy(canopy)) if in_air => {
                let (row, of_parts) = self.canopy_row(simulation, canopy)?;
                details = of_parts;
                row
            }
            Some(_) if in_air => self.fabric_in_wind_row(simulation)?,
            Some(_) => fabric_row(simulation),
            None if has_bodies => self.bodies_row(simulation)?,
            None => air_row(simulation)?,
        };
        if let (Some(BodyKind::Plate(plate)), true) = (&kind, in_air) {
            row.extend(plate::tip_displacement_m(simulation, plate).to_array());
            row.push(self.last.map_or(f64::NAN, |last| last.supports.x));
        }
        if let (Some(BodyKind::Wing(_)), true) = (&kind, in_air) {
            let last = self.last.map(|l| [l.markers.z, l.momentum_box.z]);
            let force_n = DVec3::from_slice(&row[2..5]);
            row.extend(wing_wind::values(
                simulation,
                force_n,
                last.unwrap_or([f64::NAN; 2]),
            )?);
        }
        row.extend(simulation.through_velocities_m_s().into_iter().flatten());
        let last = self.latest("time_s").zip(self.latest("descent_speed_m_s"));
        let drag_n = self.drag_of_what_falls_n(simulation);
        row.extend(falling::values(
            simulation,
            last.map(<[f64; 2]>::from),
            drag_n,
        ));
        row.extend(payload_bodies::values(simulation));
        row.extend(simulation.line_drag_n().map(|force| force.x));
        row.extend(supports::values(simulation));
        if let Some(contact) = simulation.cloth().and_then(|c| c.contact_state()) {
            let gap_m = contact.smallest_gap_m;
            let gap_m = if gap_m.is_finite() { gap_m } else { f64::NAN };
            row.extend([gap_m, contact.energy_j]);
        }
        row.extend(residual::values(simulation));
        row.extend(solver::values(simulation));
        if has_bodies {
            row.extend(self.body_columns(simulation));
        }
        row.extend(details);
        self.samples.push(row);
        let newest = self.samples.last().unwrap_or_default();
        Ok(&newest[..self.history_columns.min(newest.len())])
    }

    /// Impulses now, mean forces since the last sample by the three routes [N], and the defect of the mass balance; NaN where a
    /// route is not defined.
    fn forces(
        &mut self,
        simulation: &mut Simulation,
    ) -> Result<(LastImpulses, [DVec3; 3], f64), DeviceError> {
        let sample = simulation.impulse_sample()?;
        let unknown = DVec3::NAN;
        let now = LastImpulses {
            time_s: simulation.time_s(),
            markers: sample.as_ref().map_or(unknown, |s| s.markers),
            momentum_box: sample
                .as_ref()
                .and_then(|s| s.momentum_box)
                .unwrap_or(unknown),
            supports: sample.as_ref().and_then(|s| s.supports).unwrap_or(unknown),
        };
        let last = self.last;
        self.interval_s = last.map_or(f64::NAN, |last| now.time_s - last.time_s);
        let force = |pick: fn(&LastImpulses) -> DVec3| {
            last.map_or(unknown, |last| {
                (pick(&now) - pick(&last)) / (now.time_s - last.time_s)
            })
        };
        let forces = [
            force(|i| i.markers),
            force(|i| i.momentum_box),
            force(|i| i.supports),
        ];
        self.last = sample.as_ref().map(|_| now);
        self.markers_x = [last.map(|last| last.markers.x), Some(now.markers.x)];
        let mass_defect = sample.as_ref().map_or(f64::NAN, |s| s.mass_defect);
        let bodies = sample.map_or_else(Vec::new, |sample| sample.bodies);
        self.body_impulses = [std::mem::take(&mut self.body_impulses[1]), bodies];
        Ok((now, forces, mass_defect))
    }

    /// A scene of rigid bodies alone; the drag is that of the first body's direction.
    fn bodies_row(&mut self, simulation: &mut Simulation) -> Result<Vec<f64>, DeviceError> {
        let (now, [markers, momentum_box, _], mass_defect) = self.forces(simulation)?;
        let scene = simulation.scene();
        let (Some(air), Some(body), Some(coupled)) =
            (&scene.air, scene.rigid_bodies.first(), simulation.coupled())
        else {
            return Ok(vec![f64::NAN; bodies::SCENE_COLUMNS.len()]);
        };
        let along = bodies::drag_direction(air, body);
        Ok(vec![
            simulation.time_s(),
            simulation.wind_speed_m_s(),
            markers.dot(along),
            momentum_box.dot(along),
            now.markers.dot(along),
            now.momentum_box.dot(along),
            coupled.slip_m_s()? / bodies::reference_speed_m_s(air, body),
            mass_defect,
        ])
    }

    /// Mean force along x of the air on what falls since the last sample [N].
    fn drag_of_what_falls_n(&self, simulation: &Simulation) -> f64 {
        let descent = simulation.scene().descent.as_ref();
        let [before, now] = match descent.map(|descent| descent.carrier) {
            Some(Carrier::RigidBody { number, .. }) => {
                let impulse = |all: &Vec<BodyImpulse>| all.get(number).map(|body| body.force.x);
                [0, 1].map(|sample| impulse(&self.body_impulses[sample]))
            }
            Some(Carrier::Confluence { .. }) => self.markers_x,
            None => [None; 2],
        };
        let gained = now.zip(before).map(|(now, before)| now - before);
        gained.unwrap_or(f64::NAN) / self.interval_s
    }

    /// Mean forces on every rigid body since the last sample.
    fn body_columns(&self, simulation: &Simulation) -> Vec<f64> {
        let scene = simulation.scene();
        let Some(air) = &scene.air else {
            return Vec::new();
        };
        let [last, now] = &self.body_impulses;
        let span_s = self.interval_s;
        let mut columns = Vec::new();
        for (number, body) in scene.rigid_bodies.iter().enumerate() {
            let (force, moment) = match (now.get(number), last.get(number)) {
                (Some(now), Some(last)) => (
                    (now.force - last.force) / span_s,
                    (now.moment - last.moment) / span_s,
                ),
                _ => (DVec3::NAN, DVec3::NAN),
            };
            columns.extend(bodies::row(air, body, force, moment));
        }
        columns
    }

    fn fabric_in_wind_row(&mut self, simulation: &mut Simulation) -> Result<Vec<f64>, DeviceError> {
        let (now, [markers, momentum_box, _], mass_defect) = self.forces(simulation)?;
        let frame = simulation.structure_frame();
        let (Some(structure), Some(coupled), Some(cloth)) =
            (frame.structure, simulation.coupled(), simulation.cloth())
        else {
            return Ok(vec![f64::NAN; FABRIC_IN_WIND.len()]);
        };
        let reference = simulation
            .scene()
            .air
            .map_or(f64::NAN, |air| air.wind_or_reference_m_s());
        Ok(vec![
            simulation.time_s(),
            simulation.wind_speed_m_s(),
            markers.x,
            markers.y,
            markers.z,
            momentum_box.x,
            now.markers.x,
            now.momentum_box.x,
            largest(structure.principal_tensions_n_m.iter().map(|t| t[0])),
            coupled.slip_m_s()? / reference,
            cloth.kinetic_energy_j(),
            largest(structure.velocities_m_s.iter().map(|v| v.length())),
            mass_defect,
        ])
    }

    fn canopy_row(
        &mut self,
        simulation: &mut Simulation,
        canopy: &Canopy,
    ) -> Result<(Vec<f64>, Vec<f64>), DeviceError> {
        let (now, forces, mass_defect) = self.forces(simulation)?;
        let time_s = simulation.time_s();
        let wind = simulation.wind_speed_m_s();
        let reference = simulation
            .scene()
            .air
            .map_or(f64::NAN, |air| air.wind_or_reference_m_s());
        let density = simulation
            .scene()
            .air
            .map_or(f64::NAN, |air| air.units.density_kg_m3);
        let dynamic_force = 0.5 * density * reference * reference * canopy.nominal_area_m2;
        let frame = simulation.structure_frame();
        let (Some(structure), Some(coupled), Some(parts)) =
            (frame.structure, simulation.coupled(), &self.canopy)
        else {
            return Ok((
                vec![
                    f64::NAN;
                    CANOPY.len() + self.canopy.as_ref().map_or(0, |c| c.columns().len())
                ],
                vec![f64::NAN; self.columns.len() - self.history_columns],
            ));
        };
        let [markers, momentum_box, supports] = forces;
        let lines: Vec<f64> = structure
            .cable_tensions_n
            .iter()
            .zip(&structure.cable_kinds)
            .filter(|(_, kind)| **kind == CableKind::SuspensionLine)
            .map(|(tension, _)| *tension)
            .collect();
        let area =
            shape::projected_area_m2(&structure.positions_m, structure.triangles.iter().copied());
        let fabric = &structure.positions_m[..canopy.canopy_node_count];
        let confluence = canopy.confluence_m(&structure.positions_m);
        let apex = parts.outline().apex(&structure.positions_m) - confluence;
        let (of_shape, details) = parts.row(&structure, area);
        let mut row = vec![
            time_s,
            wind,
            markers.x / dynamic_force,
            momentum_box.x / dynamic_force,
            supports.x / dynamic_force,
            markers.y,
            markers.z,
            now.markers.x,
            now.momentum_box.x,
            now.supports.x,
            (area / canopy.nominal_area_m2).sqrt(),
            shape::height_m(fabric),
            lines.iter().sum::<f64>() / lines.len() as f64,
            lines.iter().copied().fold(0.0, f64::max),
            structure.stress_pa.iter().copied().fold(0.0, f64::max),
            coupled.slip_m_s()? / reference,
            apex.y.hypot(apex.z),
            simulation
                .cloth()
                .map_or(f64::NAN, crate::cpu::cloth::Cloth::kinetic_energy_j),
            mass_defect,
        ];
        row.extend(of_shape);
        Ok((row, details))
    }
}

/// Largest value; NaN if any is (a spring network has no tensions, which must not look like zero).
pub(super) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, value| {
        if value.is_nan() {
            f64::NAN
        } else if value > largest {
            value
        } else {
            largest
        }
    })
}

fn fabric_row(simulation: &Simulation) -> Vec<f64> {
    let frame = simulation.structure_frame();
    let (Some(structure), Some(cloth)) = (frame.structure, simulation.cloth()) else {
        return vec![f64::NAN; FABRIC.len()];
    };
    let fastest = structure
        .velocities_m_s
        .iter()
        .map(|v| v.length())
        .fold(0.0, f64::max);
    vec![
        simulation.time_s(),
        structure
            .positions_m
            .iter()
            .map(|p| p.z)
            .fold(f64::INFINITY, f64::min),
        largest(structure.principal_tensions_n_m.iter().map(|t| t[0])),
        cloth.kinetic_energy_j(),
        fastest,
    ]
}

fn air_row(simulation: &Simulation) -> Result<Vec<f64>, DeviceError> {
    let (Some(engine), Some(air)) = (simulation.air(), simulation.scene().air) else {
        return Ok(vec![f64::NAN; AIR.len()]);
    };
    let (mass, energy) = engine.mass_and_energy()?;
    let cell_mass = air.units.density_kg_m3 * air.units.cell_size_m.powi(3);
    let energy_j = energy * cell_mass * air.units.speed_m_s().powi(2);
    let total_mass = cell_mass * engine.grid().cell_count() as f64;
    // Mean of ½ u² is a quarter of the squared amplitude for sin·cos in two components.
    Ok(vec![
        simulation.time_s(),
        energy_j,
        (4.0 * energy_j / total_mass).sqrt(),
        mass * cell_mass,
    ])
}

impl Record {
    /// Samples so far.
    #[must_use]
    pub fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// Rows of the history, oldest first.
    pub fn history_rows(&self) -> impl Iterator<Item = Vec<f64>> {
        self.samples.rows().map(|mut row| {
            row.truncate(self.history_columns);
            row
        })
    }

    /// From now on older samples are kept in a file of that folder instead of in memory.
    pub fn keep_in(&mut self, folder: &Path) -> std::io::Result<()> {
        self.samples.keep_in(folder)
    }

    /// True where samples could not be read back from that file: they count as not known.
    #[must_use]
    pub fn unreadable(&self) -> bool {
        self.samples.unreadable()
    }
}
