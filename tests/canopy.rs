//! The canopy in wind, coarse and short: physics that must hold at any resolution.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::measure::Record;
use ripstop::plan::{Plan, Precision};
use ripstop::run;
use ripstop::simulation::Simulation;

use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::read_outs::{column, latest};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("canopy::inflates_and_its_forces_balance", inflates),
        plain("canopy::does_not_inflate_without_wind", still_air),
        plain(
            "canopy::fill_time_scales_with_diameter_over_speed",
            fill_time,
        ),
        on_every_engine("canopy::momentum_box_closes", MomentumBox),
        plain(
            "canopy::reference_speed_only_sets_the_time_step",
            reference_speed,
        ),
        plain("canopy::same_bits_on_any_number_of_threads", threads),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    // The canopy's own mass opens in the trials above.
    for (mass, every, folded) in [(0.1, 2, 0.15), (0.01, 1, 0.08), (0.01, 2, 0.08)] {
        trials.extend(plain(
            &format!("canopy::light_sheet_stays_bounded::mass_x{mass}_k{every}_folded_{folded}"),
            move || light_sheet(mass, every, folded),
        ));
    }
    trials
}

/// The shipped case at 12 cells per diameter in a smaller tunnel, with changes.
pub fn small_case(changes: &[&str]) -> Case {
    let source = include_str!("../cases/flat-circular-tunnel.toml");
    let mut overrides: Vec<String> = [
        "coupling.scheme=kernel",
        "resolution.cells_per_diameter=12.0",
        "air.refinement={around=\"nothing\"}",
        "air.wind_tunnel.size_m=[2.9915, 1.994, 1.994]",
        "air.wind_tunnel.sponge_length_m=0.4",
        "structure.flat_circular.confluence_m=[0.4, 0.997, 0.997]",
        "structure.flat_circular.rings=8",
        "time.end_s=0.1",
        "output.sample_interval_s=0.002",
    ]
    .map(str::to_owned)
    .to_vec();
    overrides.extend(changes.iter().map(|&c| c.to_owned()));
    case::parse(
        "small case",
        source,
        Path::new("."),
        &Choices {
            variant: None,
            overrides,
        },
    )
    .unwrap()
}

fn simulate(case: &Case, precision: Precision) -> (Simulation, Record) {
    run::without_files(case, Plan::new(&case.scene, precision), None).unwrap()
}

fn inflates() {
    let (_, record) = simulate(&small_case(&["time.end_s=0.2"]), Precision::F32);
    let ratio = column(&record, "projected_diameter_ratio");
    assert!(ratio[0] < 0.3, "starts folded: {}", ratio[0]);
    let last = ratio[ratio.len() - 1];
    assert!((0.55..0.95).contains(&last), "ends inflated: {last}");
    // The three routes over the second half of the run.
    let times = column(&record, "time_s");
    let (first, end) = (times.len() / 2, times.len() - 1);
    let mean = |name: &str| {
        let impulse = column(&record, name);
        (impulse[end] - impulse[first]) / (times[end] - times[first])
    };
    let markers = mean("impulse_markers_n_s");
    let drag_coefficient = markers / (0.5 * 1.18 * 900.0 * 0.78);
    assert!((0.5..1.6).contains(&drag_coefficient), "{drag_coefficient}");
    for route in ["impulse_momentum_box_n_s", "impulse_lines_n_s"] {
        let imbalance = (mean(route) / markers - 1.0).abs();
        assert!(
            imbalance < tolerances::FORCE_IMBALANCE,
            "{route}: {imbalance}"
        );
    }
}

fn still_air() {
    let case = small_case(&[
        "air.wind_tunnel.speed_m_s=0.0",
        "resolution.reference_speed_m_s=30.0",
    ]);
    let (_, record) = simulate(&case, Precision::F32);
    let ratio = column(&record, "projected_diameter_ratio");
    let widest = ratio.iter().copied().fold(0.0, f64::max);
    assert!(widest < 0.3, "{widest}");
}

/// Time to D_p/D_0 = 0.6 in units of D_0/U must not depend on the speed.
fn fill_time() {
    let time = |speed: f64| {
        let case = small_case(&[
            &format!("air.wind_tunnel.speed_m_s={speed:.1}"),
            &format!("air.wind_tunnel.start_time_s={}", 0.0222 * 30.0 / speed),
            &format!("time.end_s={}", 0.1 * 30.0 / speed),
            &format!("output.sample_interval_s={}", 0.001 * 30.0 / speed),
        ]);
        let (_, record) = simulate(&case, Precision::F32);
        let ratio = column(&record, "projected_diameter_ratio");
        let index = ratio
            .iter()
            .position(|&r| r >= 0.6)
            .expect("the canopy opens");
        column(&record, "time_s")[index] * speed
    };
    let reference = time(30.0);
    for speed in [20.0, 40.0] {
        let scaled = time(speed) / reference;
        assert!((scaled - 1.0).abs() < 0.1, "{speed} m/s: {scaled}");
    }
}

/// The speed that the lattice is scaled with halves the time step when doubled; forces and coefficients stay.
fn reference_speed() {
    let drag = |changes: &[&str]| {
        let (_, record) = simulate(
            &small_case(&[&["time.end_s=0.03"], changes].concat()),
            Precision::F32,
        );
        let coefficients = column(&record, "drag_coefficient");
        coefficients[1..].iter().sum::<f64>() / (coefficients.len() - 1) as f64
    };
    let ratio = drag(&["resolution.reference_speed_m_s=60.0"]) / drag(&[]);
    // The time step enters the fabric's implicit damping and the exchange with the air: some percent at 12 cells.
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

#[derive(Clone, Copy)]
struct MomentumBox;

impl Body for MomentumBox {
    /// Markers and momentum box share no data; they agree to round-off.
    fn run(self, engine: Engine) {
        let case = small_case(&["time.end_s=0.05"]);
        let plan = Plan::new(&case.scene, engine.plan_placement());
        let (_, record) = run::without_files(&case, plan, engine.device()).unwrap();
        let last = |name: &str| latest(&record, name).unwrap();
        let (markers, momentum) = (
            last("impulse_markers_n_s"),
            last("impulse_momentum_box_n_s"),
        );
        let error = (momentum / markers - 1.0).abs();
        assert!(error < tolerances::momentum_closure(engine), "{error:e}");
        let mass = last("mass_defect").abs();
        assert!(
            mass < tolerances::mass_closure(engine),
            "mass defect {mass:e}"
        );
    }
}

fn threads() {
    // Triangles alone are shared among threads, then nodes, too.
    for (scheme, rings) in [("kernel", 8), ("links", 18)] {
        same_on_threads([
            &format!("coupling.scheme={scheme}"),
            &format!("structure.flat_circular.rings={rings}"),
        ]);
    }
}

fn same_on_threads([scheme, rings]: [&str; 2]) {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let (simulation, _) = simulate(
                &small_case(&["time.end_s=0.01", scheme, rings]),
                Precision::F32,
            );
            let cloth = simulation.cloth().unwrap();
            cloth
                .positions_m
                .iter()
                .flat_map(|p| p.to_array())
                .map(f64::to_bits)
                .collect::<Vec<_>>()
        })
    };
    assert!(run(1) == run(2));
}

/// Two thousand steps with a light sheet: no node leaves (a marker leaving is an error), nothing diverges, and the canopy
/// inflates all the same.
fn light_sheet(mass: f64, every: u32, folded: f64) {
    let case = small_case(&[
        &format!("coupling.mass_factor={mass:?}"),
        &format!("coupling.structure_every={every}"),
        &format!("structure.flat_circular.folding.folded_diameter_ratio={folded:?}"),
        &format!(
            "structure.flat_circular.folding.opened_diameter_ratio={:?}",
            folded + 0.02
        ),
        "time.end_s=0.4432",
        "output.sample_interval_s=0.004",
    ]);
    let plan = Plan::new(&case.scene, Precision::F32);
    assert!(plan.steps >= 2_000, "{}", plan.steps);
    let (_, record) = simulate(&case, Precision::F32);
    let ratio = column(&record, "projected_diameter_ratio");
    assert!(ratio.iter().all(|r| (0.0..1.05).contains(r)), "{ratio:?}");
    let late = &ratio[3 * ratio.len() / 4..];
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    assert!((0.5..0.95).contains(&mean), "{mean}");
}
