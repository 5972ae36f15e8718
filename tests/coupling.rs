//! Air and sheet together: slip, adjointness of momentum, reproducibility.

use libtest_mimic::Trial;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::Setup;
use ripstop::simulation::{AirEngine, MarkerEngine};

use crate::engines::{Body, Engine, mass_and_momentum, on_every_engine, states};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("coupling::slip_of_a_flat_sheet", FlatSheet),
        on_every_engine("coupling::a_sheet_across_sides_that_repeat", AcrossSides),
        on_every_engine(
            "coupling::a_held_sheet_takes_the_momentum_the_air_loses",
            Momentum,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn still_box(relaxation_time: f64) -> Setup {
    Setup::periodic(
        [16, 24, 24],
        relaxation_time,
        Operator::RecursiveRegularised,
    )
}

/// A sheet x = `x` of markers one cell apart, `half` cells to each side of the middle.
fn sheet(x: f64, half: i32) -> Vec<[f64; 3]> {
    (-half..=half)
        .flat_map(|j| (-half..=half).map(move |k| [x, 11.6 + f64::from(j), 11.3 + f64::from(k)]))
        .collect()
}

/// Interpolates and spreads, with the transfers that the engine needs; returns the sum of the forces on the air.
pub fn exchange(
    air: &AirEngine,
    markers: &mut MarkerEngine,
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
) -> [f64; 3] {
    markers.send_markers(air, positions).unwrap().unwrap();
    markers.interpolate(air, positions).unwrap().unwrap();
    markers.fetch_air_velocities().unwrap();
    let sent = markers.send_marker_forces(velocities);
    let formed = markers.spread(velocities);
    sent.or(formed).unwrap()
}

#[derive(Clone, Copy)]
struct FlatSheet;

impl Body for FlatSheet {
    /// Inside a flat sheet one pass of strength a leaves 1 − (3/8) a of the slip: 5/8 for plain direct forcing, nothing for
    /// a = 8/3, whatever the offset to the grid (I1).
    fn run(self, engine: Engine) {
        let wind = [0.05, 0.01, -0.02];
        let air = engine.air(still_box(0.6), &|_| (0.0, wind));
        for a in [1.0, 1.6, 8.0 / 3.0] {
            for offset in [0.0, 0.13, 0.5, 0.81] {
                let positions = sheet(7.0 + offset, 7);
                let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], a).unwrap();
                let still = vec![[0.0; 3]; positions.len()];
                exchange(&air, &mut markers, &positions, &still);
                let speed = wind.iter().map(|u| u * u).sum::<f64>().sqrt();
                // The middle marker, beyond the reach of the rim's stronger exchange.
                let slips = markers.marker_slips(&still).unwrap();
                let slip = slips[positions.len() / 2] / speed;
                let expected = 1.0 - 0.375 * a;
                assert!(
                    (slip - expected.abs()).abs() < 10.0 * tolerances::same_flow(engine),
                    "a {a}: {slip}"
                );
            }
        }
    }
}

#[derive(Clone, Copy)]
struct AcrossSides;

impl Body for AcrossSides {
    /// A sheet through sides that repeat has no rim: all its markers keep the same slip, and all cells of a plane get the same force.
    fn run(self, engine: Engine) {
        let wind = [0.05, 0.0, 0.0];
        let mut air = engine.air(still_box(0.6), &|_| (0.0, wind));
        let positions: Vec<[f64; 3]> = (0..24 * 24)
            .map(|k| [7.3, f64::from(k % 24) - 0.3, f64::from(k / 24) + 0.2])
            .collect();
        let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], 1.6).unwrap();
        let still = vec![[0.0; 3]; positions.len()];
        exchange(&air, &mut markers, &positions, &still);
        let limit = 10.0 * tolerances::same_flow(engine);
        for slip in markers.marker_slips(&still).unwrap() {
            assert!((slip / wind[0] - 0.4).abs() < limit, "{slip}");
        }
        for _ in 0..20 {
            exchange(&air, &mut markers, &positions, &still);
            air.collide_stream(None, Some(&markers)).unwrap();
        }
        let found = states(&air);
        for (cell, (_, u)) in found.iter().enumerate() {
            let first = found[cell % 16].1;
            assert!((u[0] - first[0]).abs() < limit, "{cell}: {u:?} {first:?}");
        }
        assert!(found[6].1[0] < 0.04, "the sheet must brake the air");
    }
}

#[derive(Clone, Copy)]
struct Momentum;

impl Body for Momentum {
    /// What a held sheet takes in a periodic box, the air loses, step by step.
    fn run(self, engine: Engine) {
        let mut air = engine.air(still_box(0.51), &|_| (0.0, [0.05, 0.0, 0.01]));
        let positions = sheet(7.4, 4);
        let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], 1.6).unwrap();
        let still = vec![[0.0; 3]; positions.len()];
        let before = mass_and_momentum(&air)[1];
        let mut given = 0.0;
        for _ in 0..150 {
            given += exchange(&air, &mut markers, &positions, &still)[0];
            air.collide_stream(None, Some(&markers)).unwrap();
        }
        let change = mass_and_momentum(&air)[1] - before;
        assert!(given < -1.0, "the sheet must brake the air: {given}");
        let error = (change - given).abs() / (16.0 * 24.0 * 24.0);
        assert!(error < tolerances::conservation(engine), "{error:e}");
    }
}
