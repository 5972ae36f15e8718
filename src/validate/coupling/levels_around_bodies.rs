//! Boxes of finer cells around bodies and fabric: a sphere in a tunnel that one lattice could not afford, and a canopy that opens in boxes as it
//! does in finest cells throughout.

use super::super::drag;
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::case_runs::{self, Outcome};
use crate::bluff_body::{BluffBody, Shape, Until};
use crate::case::coupling::Scheme;
use crate::lattice::Operator;
use crate::measure::opening::LARGEST_RATIO;
use crate::measure::shared::{FILL_TIME, PROJECTED_DIAMETER_RATIO, TIME};
use crate::output::ReadOut;

/// 12, 6 and 3 cells per diameter, walls and outlet far away.
const SPHERE: BluffBody = BluffBody {
    shape: Shape::Sphere,
    reynolds: 100.0,
    resolution: 12,
    lattice_speed: 0.1,
    operator: Operator::RecursiveRegularised,
    scheme: Scheme::Kernel,
    levels: 2,
    tunnel: [25.0, 20.0, 20.0],
    upstream: 10.0,
    sponge: 3.0,
    until: Until::Settled(16.0),
};

const CANOPY: &str = include_str!("../../../cases/flat-circular-tunnel.toml");

/// The canopy in the tunnel of the benchmark, which finest cells throughout can afford.
const TUNNEL: [&str; 4] = [
    "coupling.scheme=kernel",
    "air.wind_tunnel.size_m=[5.982, 2.991, 2.991]",
    "structure.flat_circular.confluence_m=[1.67, 1.4955, 1.4955]",
    "output.picture_times_s=absent",
];

/// Largest difference of the fill time [samples]. An opening of one lattice moves by as much where it begins at another part of a cell.
const SAMPLES: f64 = 1.0;

/// D_p/D_0 of a canopy that opens fastest, and the largest difference of the time at which it passes that [samples]. Round-off moves this time by 0.03, that of
/// the largest D_p by 2 samples: six runs of either lattice whose confluence was moved by up to 5e-7 m.
const OPENED: f64 = 0.6;
const SAMPLES_WHEN_OPENED: f64 = 0.3;

/// Largest difference of the largest D_p/D_0.
const LARGEST: f64 = 0.01;

pub(in crate::validate) fn compute(session: &mut Session) -> Result<(), Stop> {
    // 1.6 % in the experiment that the boxes come from; one lattice with a nearer wall errs by 2.9 % at 24 cells per diameter.
    drag::rows(session, &SPHERE, Some(0.025))?;
    if session.order.full {
        let finer = BluffBody {
            resolution: 24,
            ..SPHERE
        };
        drag::rows(session, &finer, Some(0.02))?;
    }
    let sizes: &[(f64, u32)] = session.size(&[(16.0, 1)], &[(16.0, 1), (24.0, 1), (48.0, 2)]);
    for (cells, levels) in sizes {
        canopy(session, *cells, *levels)?;
    }
    Ok(())
}

/// When a canopy passes [`OPENED`], between samples [s]; not a number where it does not.
fn opened_s(outcome: &Outcome) -> f64 {
    let [times, ratios] = [&TIME, &PROJECTED_DIAMETER_RATIO].map(|of| outcome.column(of));
    let mut between = times.windows(2).zip(ratios.windows(2));
    between
        .find(|(_, ratios)| ratios[1] >= OPENED)
        .map_or(f64::NAN, |(times, ratios)| {
            let share = (OPENED - ratios[0]) / (ratios[1] - ratios[0]);
            times[0] + share * (times[1] - times[0])
        })
}

/// The opening in boxes against that in finest cells throughout.
fn canopy(session: &mut Session, cells: f64, levels: u32) -> Result<(), Stop> {
    let interval_s = 1e-3;
    let mut run = |refinement: &str| -> Result<Outcome, Stop> {
        let mut changes: Vec<String> = TUNNEL.iter().map(|&change| change.to_owned()).collect();
        changes.extend([
            format!("resolution.cells_per_diameter={cells:?}"),
            format!("output.sample_interval_s={interval_s:?}"),
            "time.end_s=0.09".to_owned(),
            refinement.to_owned(),
        ]);
        let case = case_runs::case("flat-circular-tunnel", CANOPY, None, &changes)?;
        case_runs::run(session, case)
    };
    let uniform = run("air.refinement={around=\"nothing\"}")?;
    let nested = run(&format!(
        "air.refinement={{around=\"structure\", levels={levels}}}"
    ))?;
    let what = format!("canopy, {cells} cells/D_0 in {levels} boxes");
    let difference = |read_out: &ReadOut| nested.value(read_out) - uniform.value(read_out);
    for (name, difference_s, samples) in [
        ("fill time", difference(&FILL_TIME), SAMPLES),
        (
            "time to D_p/D_0 = 0.6",
            opened_s(&nested) - opened_s(&uniform),
            SAMPLES_WHEN_OPENED,
        ),
    ] {
        session
            .row(
                nested.cells,
                format!("{what}: {name} against finest cells throughout, in samples"),
                difference_s / interval_s,
            )
            .gate(Gate::AtMost(samples));
    }
    session
        .row(
            nested.cells,
            format!("{what}: largest D_p/D_0 against the same"),
            difference(&LARGEST_RATIO),
        )
        .gate(Gate::AtMost(LARGEST));
    Ok(())
}
