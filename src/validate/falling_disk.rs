//! A mass on a disk that falls in still air, against the speed √(2 m g/(ρ C_D S)) of the drag that the same disk has held in a wind of that
//! speed.
//!
//! First the disk stands in a tunnel of speed 1 at Re 100 until its drag has settled. Then it falls as a rigid body with gravity chosen so
//! that its speed is to be 1, released 20 % faster, in a box of the same size that follows it (`src/simulation/descent.rs`). What differs is
//! the acceleration of the frame on the way; the tunnel's walls are the same in both.

use std::path::Path;

use super::report::Gate;
use super::session::{Session, Stop};
use crate::bluff_body::{BluffBody, Shape, Until};
use crate::case::coupling::Scheme;
use crate::case::{self, Choices};
use crate::lattice::Operator;
use crate::measure::Record;
use crate::measure::falling::DESCENT_SPEED;
use crate::measure::shared::{IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX};
use crate::output::ReadOut;
use crate::plan::{Placement, Plan, Precision};
use crate::simulation::Simulation;

const DISK: BluffBody = BluffBody {
    shape: Shape::Disk,
    reynolds: 100.0,
    resolution: 8,
    lattice_speed: 0.08,
    operator: Operator::RecursiveRegularised,
    scheme: Scheme::Kernel,
    levels: 0,
    tunnel: [6.0, 5.0, 5.0],
    upstream: 2.5,
    sponge: 1.0,
    until: Until::Settled(20.0),
};

/// Mass [ρ D³]: heavier than the air that the disk carries along (1/3), light enough to settle soon.
const MASS: f64 = 1.0;

/// Speed of release over the speed to be reached.
const RELEASE: f64 = 1.2;

/// Time of the fall [D/U].
const END: f64 = 20.0;

/// Largest relative error of the speed (gate I9).
const BAND: f64 = 0.03;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let body = BluffBody {
        resolution: session.size(DISK.resolution, 16),
        ..DISK
    };
    let cells = body.cells();
    let updates = 1e-6 * cells.iter().product::<usize>() as f64;
    let start = session.done;
    let (placement, device) = (session.order.placement, session.order.device.clone());
    let held = body.drag(placement, device.as_ref(), &mut |simulation| {
        session.progress_to(start + updates * simulation.step_count() as f64);
        session.check_interrupt().is_ok()
    })?;
    session.row(cells, "held in a tunnel: C_D", held.coefficient);
    let area = 0.25 * std::f64::consts::PI;
    let gravity = 0.5 * held.coefficient * area / MASS;
    let [length, width, height] = body.tunnel;
    let source = format!(
        r#"version = 1
[air]
density_kg_m3 = 1.0
kinematic_viscosity_m2_s = {viscosity:?}
[air.descent]
release_speed_m_s = {RELEASE:?}
size_m = [{length:?}, {width:?}, {height:?}]
start_time_s = 1.0
sponge_length_m = {sponge:?}
[gravity]
acceleration_m_s2 = [{down:?}, 0.0, 0.0]
[resolution]
cells_per_diameter = {resolution:?}
reference_speed_m_s = 1.0
lattice_speed = {speed:?}
operator = "recursive_regularised"
[bodies.disk]
position_m = [{upstream:?}, {y:?}, {z:?}]
disk.diameter_m = 1.0
motion.free_fall.mass_kg = {MASS:?}
[coupling]
over_relaxation = 1.6
[time]
end_s = {END:?}
[output]
sample_interval_s = 0.25
"#,
        viscosity = 1.0 / body.reynolds,
        sponge = body.sponge,
        down = -gravity,
        resolution = body.resolution as f64,
        speed = body.lattice_speed,
        upstream = body.upstream,
        y = 0.5 * width,
        z = 0.5 * height,
    );
    let case = case::parse("disk", &source, Path::new("."), &Choices::default())
        .map_err(|error| Stop::Refused(error.to_string()))?;
    let placement = Placement {
        air: placement,
        ..Placement::from(Precision::F32)
    };
    let plan = Plan::new(&case.scene, placement);
    let steps = plan.start_steps + plan.steps;
    let mut simulation =
        Simulation::new(case.scene, plan, device).map_err(crate::bluff_body::Stop::from)?;
    let mut record = Record::new(&simulation);
    let start = session.done;
    while simulation.step_count() < steps {
        if simulation.step_count().is_multiple_of(64) {
            session.check_interrupt()?;
            session.progress_to(start + updates * simulation.step_count() as f64);
            if simulation.released() {
                record.add(&mut simulation)?;
            }
        }
        simulation
            .advance()
            .map_err(crate::bluff_body::Stop::from)?;
    }
    let speeds = record.column(&DESCENT_SPEED);
    let last = &speeds[speeds.len() - speeds.len() / 4..];
    let speed = last.iter().sum::<f64>() / last.len() as f64;
    session
        .row(cells, "falling: speed over the last quarter", speed)
        .reference(1.0, "drag of the disk held = weight")
        .gate(Gate::Within(BAND));
    let imbalance = |column: &ReadOut| {
        let impulse = record.column(column);
        impulse.last().copied().unwrap_or(f64::NAN)
    };
    let markers = imbalance(&IMPULSE_MARKERS);
    let difference = (imbalance(&IMPULSE_MOMENTUM_BOX) - markers) / markers;
    session
        .row(cells, "falling: momentum box against markers", difference)
        .gate(Gate::AtMost(2e-3));
    Ok(())
}
