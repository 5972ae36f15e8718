//! Air and sheet together: slip, adjointness of momentum, reproducibility.

use libtest_mimic::Trial;
use ripstop::cpu::fluid::{BodyForce, Fluid, Operator, Setup, Sides, StreamwiseEnds};
use ripstop::cpu::immersed::Immersed;
use ripstop::lattice::Real;

use crate::engines::{Body, Engine, on_every_engine};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("coupling::slip_of_a_flat_sheet", FlatSheet),
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
    Setup {
        cells: [16, 24, 24],
        ends: StreamwiseEnds::Periodic,
        sides: Sides::Periodic,
        relaxation_time,
        sponge_cells: None,
        operator: Operator::RecursiveRegularised,
        smagorinsky_constant: None,
    }
}

/// A sheet x = `x` of markers one cell apart, `half` cells to each side of the middle.
fn sheet(x: f64, half: i32) -> Vec<[f64; 3]> {
    (-half..=half)
        .flat_map(|j| (-half..=half).map(move |k| [x, 11.6 + f64::from(j), 11.3 + f64::from(k)]))
        .collect()
}

#[derive(Clone, Copy)]
struct FlatSheet;

impl Body for FlatSheet {
    /// Inside a flat sheet one pass of strength a leaves 1 − (3/8) a of the slip: 5/8 for plain direct forcing, nothing for
    /// a = 8/3, whatever the offset to the grid (I1).
    fn run<T: Real>(self, engine: Engine) {
        let wind = [0.05, 0.01, -0.02];
        let fluid = Fluid::<T>::new(still_box(0.6), |_| (0.0, wind));
        for a in [1.0, 1.6, 8.0 / 3.0] {
            for offset in [0.0, 0.13, 0.5, 0.81] {
                let positions = sheet(7.0 + offset, 7);
                let mut immersed = Immersed::new(vec![1.0; positions.len()], a, [16, 24, 24]);
                immersed.interpolate(&fluid, &positions).unwrap();
                let still = vec![[0.0; 3]; positions.len()];
                immersed.spread(&still);
                let speed = wind.iter().map(|u| u * u).sum::<f64>().sqrt();
                // The middle marker, beyond the reach of the rim's stronger exchange.
                let slip = immersed.marker_slips(&still)[positions.len() / 2] / speed;
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
struct Momentum;

impl Body for Momentum {
    /// What a held sheet takes in a periodic box, the air loses, step by step.
    fn run<T: Real>(self, engine: Engine) {
        let mut fluid = Fluid::<T>::new(still_box(0.51), |_| (0.0, [0.05, 0.0, 0.01]));
        let positions = sheet(7.4, 4);
        let mut immersed = Immersed::new(vec![1.0; positions.len()], 1.6, [16, 24, 24]);
        let still = vec![[0.0; 3]; positions.len()];
        let momentum = |fluid: &Fluid<T>| {
            let mut sum = 0.0;
            for z in 0..24 {
                for y in 0..24 {
                    for x in 0..16 {
                        let (excess, u) = fluid.bare_state([x, y, z]);
                        sum += (1.0 + excess) * u[0];
                    }
                }
            }
            sum
        };
        let before = momentum(&fluid);
        let mut given = 0.0;
        for _ in 0..150 {
            immersed.interpolate(&fluid, &positions).unwrap();
            given += immersed.spread(&still)[0];
            fluid.collide_stream(&BodyForce {
                acceleration: None,
                cells: immersed.forced_cells(),
            });
        }
        let change = momentum(&fluid) - before;
        assert!(given < -1.0, "the sheet must brake the air: {given}");
        let error = (change - given).abs() / (16.0 * 24.0 * 24.0);
        assert!(error < tolerances::conservation(engine), "{error:e}");
    }
}
