//! A rigid disk across the same wind, forced in several passes.

use std::path::Path;

use super::canopy::noise;
use super::point::{DISK, Point, median};
use super::scheme::{END_S, Scheme, Tunnel};
use crate::bench::{Engine, Stop, Watch, go_on};
use crate::case::{self, Choices};
use crate::plan::{Placement, Plan, Precision};
use crate::simulation::{Failure, Simulation};

/// Steps between samples of slip and leakage.
const SAMPLE_EVERY: u64 = 10;

/// Disk as wide as the inflated canopy, 0.7 D_0.
const DIAMETER_M: f64 = 0.7;

/// The canopy's tunnel, with its cells.
fn source(tunnel: &Tunnel, end_s: f64) -> String {
    let [length, width, height] = tunnel.size_m;
    format!(
        r#"version = 1
title = "Rigid disk across the wind"
[air]
density_kg_m3 = 1.18
kinematic_viscosity_m2_s = 1.55e-5
[air.wind_tunnel]
speed_m_s = 30.0
size_m = [{length:?}, {width:?}, {height:?}]
start_time_s = 0.0222
sponge_length_m = {sponge:?}
[resolution]
cell_size_m = {cell_size_m:?}
lattice_speed = 0.08
operator = "recursive_regularised"
eddy_viscosity = {{ model = "smagorinsky", constant = 0.15 }}
[bodies.disk]
position_m = [{x:?}, {y:?}, {z:?}]
[bodies.disk.disk]
diameter_m = {DIAMETER_M:?}
[coupling]
over_relaxation = 1.6
[time]
end_s = {end_s:?}
[output]
sample_interval_s = 0.001
"#,
        cell_size_m = 0.997 / tunnel.cells_per_diameter,
        sponge = tunnel.sponge_length_m,
        x = tunnel.places_m[1],
        y = 0.5 * width,
        z = 0.5 * height,
    )
}

pub(super) fn run(
    scheme: &Scheme,
    tunnel: &Tunnel,
    engine: &Engine,
    watch: &Watch,
) -> Result<Point, Stop> {
    run_for(scheme, tunnel, END_S, engine, watch)
}

/// [`run`] to another end [s].
pub(super) fn run_for(
    scheme: &Scheme,
    tunnel: &Tunnel,
    end_s: f64,
    engine: &Engine,
    watch: &Watch,
) -> Result<Point, Stop> {
    let source = source(tunnel, end_s);
    let mut case = case::parse(DISK, &source, Path::new("."), &Choices::default())
        .map_err(|error| Stop::Refused(error.to_string()))?;
    let mut point = Point::new(DISK, scheme, tunnel.cells_per_diameter, engine);
    let (Some(air), Some(coupling)) = (case.scene.air.clone(), &mut case.scene.coupling) else {
        return Err(Stop::Refused("the case has no body in air".to_owned()));
    };
    coupling.over_relaxation = scheme.over_relaxation;
    coupling.passes = scheme.passes;
    let wind_m_s = air.wind_or_reference_m_s();
    let area_m2 = 0.25 * std::f64::consts::PI * DIAMETER_M * DIAMETER_M;
    let force_n = 0.5 * air.units.density_kg_m3 * wind_m_s * wind_m_s * area_m2;
    let placement = Placement {
        air: engine.placement,
        ..Placement::from(Precision::F32)
    };
    let plan = Plan::new(&case.scene, placement);
    let start = plan.start_steps;
    let end = start + plan.steps;
    let half = start.midpoint(end);
    point.steps = plan.steps;
    let mut simulation = Simulation::new(case.scene, plan, engine.device.clone())?;
    if let Some(coupled) = simulation.coupled() {
        point.markers = coupled.point_count();
        let cells = area_m2 / (air.units.cell_size_m * air.units.cell_size_m);
        point.marker_distance_cells = (cells / point.markers as f64).sqrt();
    }
    let [mut forces, mut slips, mut leakages, mut coupling_ms] = [const { Vec::new() }; 4];
    let mut first = None;
    while simulation.step_count() < end {
        let before = *simulation.cost();
        match simulation.advance_among_threads() {
            Ok(()) => {}
            // Blown up: the row keeps what it is.
            Err(Failure::Diverged(_)) => return Ok(point),
            Err(failure) => return Err(failure.into()),
        }
        let step = simulation.step_count();
        if step == half {
            first = simulation.impulse_sample()?;
        }
        let Some(coupled) = simulation.coupled().filter(|_| step > half) else {
            continue;
        };
        let cost = simulation.cost();
        if cost.timed_steps > before.timed_steps {
            coupling_ms.push(1e3 * (cost.coupling - before.coupling).as_secs_f64());
        }
        forces.push(-coupled.force_on_air()[0]);
        if step.is_multiple_of(SAMPLE_EVERY) {
            go_on(watch.interrupt)?;
            slips.extend(coupled.slip_m_s()?);
            leakages.extend(coupled.leakage_m_s(None, simulation.time_s())?);
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let drag = mean(&forces);
    let span_s = (end - half) as f64 * air.units.time_step_s;
    if let (Some(first), Some(last)) = (first, simulation.impulse_sample()?) {
        let markers = (last.markers - first.markers).x / span_s;
        point.drag_coefficient = markers / force_n;
        if let (Some(now), Some(then)) = (last.momentum_box, first.momentum_box) {
            point.force_imbalance = ((now - then).x / span_s / markers - 1.0).abs();
        }
    }
    point.fastest = 0.0;
    point.slip = mean(&slips) / wind_m_s;
    point.leakage = mean(&leakages).abs() / wind_m_s;
    point.drag_noise = noise(&forces) / drag;
    point.evaluations_per_step = 0.0;
    point.mean_structure_every = 1.0;
    point.cloth_ms = 0.0;
    point.coupling_ms = median(&mut coupling_ms);
    Ok(point)
}
