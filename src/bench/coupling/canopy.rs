//! The shipped canopy with one scheme of coupling.

use std::path::Path;

use super::point::{Point, median};
use super::scheme::{END_S, Scheme, Tunnel};
use crate::bench::{Engine, Stop, Watch, go_on};
use crate::case::scene::BodyKind;
use crate::case::{self, Case, Choices};
use crate::measure::Record;
use crate::measure::canopy::IMPULSE_LINES;
use crate::measure::extremes::larger;
use crate::measure::shared::{
    IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX, PROJECTED_DIAMETER_RATIO, SLIP_RATIO, TIME,
};
use crate::plan::{Placement, Plan, Precision};
use crate::simulation::{Failure, Simulation};

pub(super) const NAME: &str = "canopy";

/// Steps between samples of slip, leakage and shape.
const SAMPLE_EVERY: u64 = 10;

fn case(tunnel: &Tunnel) -> Result<Case, Stop> {
    let [length, width, height] = tunnel.size_m;
    let choices = Choices {
        variant: None,
        overrides: vec![
            format!(
                "resolution.cells_per_diameter={:?}",
                tunnel.cells_per_diameter
            ),
            format!("air.wind_tunnel.size_m=[{length:?}, {width:?}, {height:?}]"),
            format!(
                "air.wind_tunnel.sponge_length_m={:?}",
                tunnel.sponge_length_m
            ),
            format!(
                "structure.flat_circular.confluence_m=[{:?}, {:?}, {:?}]",
                tunnel.places_m[0],
                0.5 * width,
                0.5 * height
            ),
            format!("time.end_s={END_S:?}"),
            "coupling.scheme=kernel".to_owned(),
        ],
    };
    let source = include_str!("../../../cases/flat-circular-tunnel.toml");
    case::parse("flat-circular-tunnel", source, Path::new("."), &choices)
        .map_err(|error| Stop::Refused(error.to_string()))
}

fn refused(what: &str) -> Stop {
    Stop::Refused(what.to_owned())
}

/// Times of single steps [ms].
#[derive(Default)]
struct Times {
    coupling: Vec<f64>,
    /// Of the fabric, where it is solved and where it is not.
    solves: Vec<f64>,
    others: Vec<f64>,
}

impl Times {
    /// Of the fabric, per step.
    fn cloth_ms(&mut self) -> f64 {
        let (solves, others) = (self.solves.len() as f64, self.others.len() as f64);
        let share = |values: &mut Vec<f64>, count: f64| match values.is_empty() {
            true => 0.0,
            false => count * median(values),
        };
        (share(&mut self.solves, solves) + share(&mut self.others, others)) / (solves + others)
    }
}

pub(super) fn run(
    scheme: &Scheme,
    tunnel: &Tunnel,
    engine: &Engine,
    watch: &Watch,
) -> Result<Point, Stop> {
    let mut case = case(tunnel)?;
    let mut point = Point::new(NAME, scheme, tunnel.cells_per_diameter, engine);
    let scene = &mut case.scene;
    let (Some(air), Some(body), Some(coupling)) =
        (scene.air.clone(), &mut scene.body, &mut scene.coupling)
    else {
        return Err(refused("the case has no canopy in air"));
    };
    let BodyKind::Canopy(canopy) = &body.kind else {
        return Err(refused("the case has no canopy"));
    };
    coupling.over_relaxation = scheme.over_relaxation;
    coupling.structure_every = Some(scheme.structure_every);
    coupling.averaging_steps = scheme.averaging_steps;
    coupling.marker_spacing_cells = scheme.marker_spacing_cells;
    scene.solver.tolerance = scheme.tolerance;
    let units = &air.units;
    let structure = &mut body.structure;
    let rest_area_m2 = structure.rest_area_m2();
    let mass_kg: f64 = structure.masses_kg.iter().sum();
    let ratio = mass_kg / rest_area_m2 / (units.density_kg_m3 * units.cell_size_m);
    if let Some(target) = scheme.mass_ratio {
        for mass in &mut structure.masses_kg {
            *mass *= target / ratio;
        }
    }
    point.mass_ratio = scheme.mass_ratio.unwrap_or(ratio);
    let wind_m_s = air.wind_or_reference_m_s();
    let force_n = 0.5 * units.density_kg_m3 * wind_m_s * wind_m_s * canopy.nominal_area_m2;
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
        let cells = rest_area_m2 / (units.cell_size_m * units.cell_size_m);
        point.marker_distance_cells = (cells / point.markers as f64).sqrt();
    }
    let mut record = Record::new(&simulation);
    let (mut forces, mut leakages) = (Vec::new(), Vec::new());
    let mut times = Times::default();
    let (mut fastest, mut evaluations, mut first_row) = (0.0_f64, 0, 0);
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
            first_row = record.sample_count();
            evaluations = simulation.cost().evaluations;
        }
        let cost = simulation.cost();
        if step > half {
            if cost.timed_steps > before.timed_steps {
                let ms = |now: std::time::Duration, then| 1e3 * (now - then).as_secs_f64();
                times.coupling.push(ms(cost.coupling, before.coupling));
                let cloth = ms(cost.cloth, before.cloth);
                if cost.solves > before.solves {
                    times.solves.push(cloth);
                } else {
                    times.others.push(cloth);
                }
            }
            if let Some(coupled) = simulation.coupled() {
                forces.push(-coupled.force_on_air()[0]);
            }
        }
        if step <= start || !(step - start).is_multiple_of(SAMPLE_EVERY) {
            continue;
        }
        go_on(watch.interrupt)?;
        record.add(&mut simulation)?;
        let frame = simulation.structure_frame();
        let speeds = frame.structure.iter().flat_map(|s| &s.velocities_m_s);
        fastest = speeds.map(|v| v.length()).fold(fastest, larger);
        if let (true, Some(coupled)) = (step > half, simulation.coupled()) {
            leakages.extend(coupled.leakage_m_s(simulation.cloth(), simulation.time_s())?);
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let late = |column| mean(&record.column(column)[first_row..]);
    let drag = mean(&forces);
    let mut routes = Vec::new();
    let times_s = record.column(&TIME);
    for route in [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_LINES] {
        let impulse = record.column(route);
        let (first, last) = (first_row, impulse.len() - 1);
        routes.push((impulse[last] - impulse[first]) / (times_s[last] - times_s[first]));
    }
    let (low, high) = routes
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &f| {
            (low.min(f), high.max(f))
        });
    point.fastest = fastest / wind_m_s;
    point.slip = late(&SLIP_RATIO);
    // Normals of the canopy may point either way; the air goes downstream.
    point.leakage = mean(&leakages).abs() / wind_m_s;
    point.drag_noise = noise(&forces) / drag;
    point.force_imbalance = (high - low) / routes[0];
    point.drag_coefficient = routes[0] / force_n;
    point.projected_diameter_ratio = late(&PROJECTED_DIAMETER_RATIO);
    point.evaluations_per_step =
        (simulation.cost().evaluations - evaluations) as f64 / (end - half) as f64;
    point.mean_structure_every = match simulation.cadence() {
        Some(cadence) => cadence.mean().unwrap_or(f64::NAN),
        None => 1.0,
    };
    point.cloth_ms = times.cloth_ms();
    point.coupling_ms = median(&mut times.coupling);
    Ok(point)
}

/// Root mean square of the changes from one value to the next.
pub(super) fn noise(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    (changes.sum::<f64>() / (values.len() as f64 - 1.0)).sqrt()
}
