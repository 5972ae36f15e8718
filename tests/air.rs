//! The air alone: exact solutions, convergence, conservation, symmetry, stability.

use libtest_mimic::Trial;
use ripstop::cpu::fluid::{BodyForce, Fluid, ForcedCells, Stored};
use ripstop::lattice::Operator;
use ripstop::lattice::eddy_viscosity::EddyViscosity;
use ripstop::lattice::grid::{Faces, InletProfile, Setup, Sides, StreamwiseEnds, Wall};
use ripstop::simulation::AirEngine;

use crate::engines::{
    Body, Engine, mass_and_momentum, on_every_engine, on_every_storage, plain, states,
};
use crate::read_outs::{column, latest};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_storage("air::taylor_green_decay", Decay),
        on_every_storage("air::conservation", Conservation),
        plain("air::forced_cells_add_their_force::cpu_f64", || {
            forced::<f64>(Engine::CpuF64)
        }),
        plain("air::forced_cells_add_their_force::cpu_f32", || {
            forced::<f32>(Engine::CpuF32)
        }),
        on_every_engine("air::free_slip_is_a_mirror", Mirror),
        on_every_engine("air::uniform_wind_passes_unchanged", Wind),
        on_every_engine("air::sheared_wind_comes_through", ShearedWind),
        on_every_engine("air::an_empty_tunnel_starts_without_sound", TunnelStart),
        on_every_storage("air::shear_layer_at_reynolds_2e6", ShearLayer),
        on_every_engine("air::eddy_viscosity_of_a_shear_wave", ShearWave),
        plain("air::taylor_green_order", order),
        plain("air::same_bits_on_any_number_of_threads", threads),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub fn periodic(cells: [usize; 3], relaxation_time: f64, operator: Operator) -> Setup {
    Setup::periodic(cells, relaxation_time, operator)
}

/// Taylor–Green vortices of amplitude `speed` at time zero.
fn taylor_green(n: usize, speed: f64) -> impl Fn([usize; 3]) -> (f64, [f64; 3]) {
    let k = std::f64::consts::TAU / n as f64;
    move |[x, y, _]| {
        let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
        let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
        (
            excess,
            [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
        )
    }
}

pub fn advance(air: &mut AirEngine, steps: usize) {
    for _ in 0..steps {
        air.collide_stream(None, None).unwrap();
    }
}

#[derive(Clone, Copy)]
struct Decay;

impl Body for Decay {
    /// All operators must decay vortices at 2 ν k²; the energy at twice that.
    fn run(self, engine: Engine) {
        let n = 32;
        for operator in Operator::ALL {
            let tau = 0.6;
            let mut fluid = engine.air(periodic([n, n, 4], tau, operator), &taylor_green(n, 0.02));
            advance(&mut fluid, 50);
            let (_, before) = fluid.mass_and_energy().unwrap();
            let steps = 200;
            advance(&mut fluid, steps);
            let (_, after) = fluid.mass_and_energy().unwrap();
            let rate = (before / after).ln() / steps as f64;
            let k = std::f64::consts::TAU / n as f64;
            let exact = 4.0 * (tau - 0.5) / 3.0 * k * k;
            assert!(
                (rate / exact - 1.0).abs() < tolerances::DECAY_RATE,
                "{operator:?}: {rate} against {exact}"
            );
        }
    }
}

/// Order of convergence of the velocity under diffusive scaling (Mach number falls with the cell size).
fn order() {
    for operator in Operator::ALL {
        let error = |n: usize| {
            let speed = 0.64 / n as f64;
            let tau = 0.65;
            let mut fluid =
                Engine::CpuF64.air(periodic([n, n, 4], tau, operator), &taylor_green(n, speed));
            let steps = n * n / 8;
            advance(&mut fluid, steps);
            let k = std::f64::consts::TAU / n as f64;
            let decay = (-2.0 * (tau - 0.5) / 3.0 * k * k * steps as f64).exp();
            let exact = taylor_green(n, speed * decay);
            let mut square = 0.0;
            for (i, (_, u)) in states(&fluid).iter().take(n * n).enumerate() {
                let (_, e) = exact([i % n, i / n, 0]);
                square += (u[0] - e[0]).powi(2) + (u[1] - e[1]).powi(2);
            }
            (square / (n * n) as f64).sqrt() / speed
        };
        let errors = [16, 32, 64].map(error);
        // Over both steps: the sound of the start is at another phase on every grid.
        let order = 0.5 * (errors[0] / errors[2]).log2();
        assert!(
            order >= tolerances::CONVERGENCE_ORDER,
            "{operator:?}: order {order:.2}, errors {errors:?}"
        );
    }
}

#[derive(Clone, Copy)]
struct Conservation;

impl Body for Conservation {
    fn run(self, engine: Engine) {
        for (operator, eddy_viscosity) in Operator::ALL.into_iter().zip([
            EddyViscosity::wale(0.5),
            EddyViscosity::vreman(0.07),
            EddyViscosity::smagorinsky(0.15),
        ]) {
            let mut setup = periodic([12, 10, 7], 0.51, operator);
            setup.eddy_viscosity = Some(eddy_viscosity);
            let initial = |[x, y, z]: [usize; 3]| {
                let phase = (3 * x + 5 * y + 7 * z) as f64;
                (
                    0.01 * phase.sin(),
                    [
                        0.05 * phase.cos(),
                        0.03 * (2.0 * phase).sin(),
                        -0.04 * (0.5 * phase).cos(),
                    ],
                )
            };
            let mut fluid = engine.air(setup, &initial);
            let before = mass_and_momentum(&fluid);
            advance(&mut fluid, 300);
            let after = mass_and_momentum(&fluid);
            for a in 0..4 {
                let drift = (after[a] - before[a]).abs() / 840.0;
                assert!(
                    drift < tolerances::conservation(engine),
                    "{operator:?}, moment {a}: {drift:e}"
                );
            }
        }
    }
}

/// (On the device all forces come from markers: `coupling::a_held_sheet_takes_the_momentum_the_air_loses`.)
/// A force on two cells, one in a middle row, must add exactly its momentum per step and nothing else.
fn forced<P: Stored>(engine: Engine) {
    for operator in Operator::ALL {
        let mut fluid = Fluid::<P>::new(
            periodic([11, 6, 9], 0.55, operator),
            Some(&|_: [usize; 3]| (0.0, [0.03, 0.0, 0.01])),
        );
        let force = [[1e-3, -2e-3, 3e-3], [0.0, 1e-3, 0.0], [-2e-3, 0.0, 0.0]];
        let rows = [(3 + 2 * 6, 0, 2), (5 + 7 * 6, 2, 3)];
        let x = [4, 10, 0];
        let cells = ForcedCells {
            rows: &rows,
            x: &x,
            force: &force,
        };
        let steps = 40;
        for _ in 0..steps {
            fluid.collide_stream(&BodyForce {
                acceleration: None,
                cells,
            });
        }
        let mut momentum = [0.0; 3];
        for z in 0..9 {
            for y in 0..6 {
                for x in 0..11 {
                    let (excess, u) = fluid.bare_state([x, y, z]);
                    for a in 0..3 {
                        momentum[a] += (1.0 + excess) * u[a];
                    }
                }
            }
        }
        let volume = (11 * 6 * 9) as f64;
        for a in 0..3 {
            let added: f64 = force.iter().map(|f| f[a]).sum::<f64>() * f64::from(steps);
            let expected = [0.03, 0.0, 0.01][a] * volume + added;
            let error = (momentum[a] - expected).abs() / volume;
            assert!(
                error < tolerances::conservation(engine),
                "{operator:?}: {error:e}"
            );
        }
    }
}

#[derive(Clone, Copy)]
struct Mirror;

impl Body for Mirror {
    /// y = 0 and y = π are symmetry planes of Taylor–Green vortices: half the box between frictionless walls must compute the
    /// same flow as the whole periodic box.
    fn run(self, engine: Engine) {
        let n = 16;
        for eddy_viscosity in [None, Some(EddyViscosity::vreman(0.07))] {
            let setup = Setup {
                eddy_viscosity,
                ..periodic([n, n, 4], 0.52, Operator::RecursiveRegularised)
            };
            let mut whole = engine.air(setup.clone(), &taylor_green(n, 0.05));
            let mut half = engine.air(
                Setup {
                    cells: [n, n / 2, 4],
                    sides: Sides::FreeSlip,
                    ..setup
                },
                &taylor_green(n, 0.05),
            );
            advance(&mut whole, 200);
            advance(&mut half, 200);
            let (whole, half) = (states(&whole), states(&half));
            for y in 0..n / 2 {
                for x in 0..n {
                    let (a, u) = whole[x + n * (y + n)];
                    let (b, v) = half[x + n * (y + n)];
                    let difference = (0..3)
                        .map(|k| (u[k] - v[k]).abs())
                        .fold((a - b).abs(), f64::max);
                    assert!(
                        difference < tolerances::same_flow(engine),
                        "{eddy_viscosity:?}, {x} {y}: {difference:e}"
                    );
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Wind;

impl Body for Wind {
    /// Uniform wind is an exact solution between inlet, outlet, sponge and frictionless walls, one of which absorbs.
    fn run(self, engine: Engine) {
        let setup = Setup {
            cells: [20, 8, 6],
            ends: StreamwiseEnds::InletOutlet,
            sides: Sides::Each([
                Faces::Walls([Wall::FreeSlip; 2]),
                Faces::Walls([Wall::FreeSlip, Wall::Absorbing]),
            ]),
            relaxation_time: 0.500_003,
            inlet_profile: None,
            sponge_cells: Some(6.0),
            idle: None,
            operator: Operator::RecursiveRegularised,
            eddy_viscosity: Some(EddyViscosity::smagorinsky(0.15)),
        };
        let wind = [0.08, 0.0, 0.0];
        let mut fluid = engine.air(setup, &|_| (0.0, wind));
        fluid.set_inlet_velocity(wind);
        advance(&mut fluid, 500);
        for (i, (excess, u)) in states(&fluid).iter().enumerate() {
            let worst = (0..3)
                .map(|a| (u[a] - wind[a]).abs())
                .fold(excess.abs(), f64::max);
            assert!(worst < tolerances::same_flow(engine), "cell {i}: {worst:e}");
        }
    }
}

#[derive(Clone, Copy)]
struct ShearedWind;

impl Body for ShearedWind {
    /// Wind that differs from layer to layer rises as the inlet's profile has it, and goes on unchanged: parallel flow is an exact solution
    /// where viscosity hardly acts, with uniform pressure. The profile is level at the walls, as the air that slides along them.
    fn run(self, engine: Engine) {
        let cells = [32, 5, 16];
        let ratio = |z: usize| 1.0 + 0.4 * (std::f64::consts::PI * (z as f64 + 0.5) / 16.0).cos();
        let setup = Setup {
            cells,
            ends: StreamwiseEnds::InletOutlet,
            sides: Sides::Each([
                Faces::Walls([Wall::FreeSlip; 2]),
                Faces::Walls([Wall::Absorbing, Wall::FreeSlip]),
            ]),
            relaxation_time: 0.5003,
            inlet_profile: Some(InletProfile::new(cells, |_, z| ratio(z))),
            sponge_cells: None,
            idle: None,
            operator: Operator::StabilisedRegularised,
            eddy_viscosity: None,
        };
        let (wind, rise) = (0.08, 200);
        let mut fluid = engine.air(setup, &|_| (0.0, [0.0; 3]));
        for step in 1..=rise {
            fluid.set_inlet_velocity([wind * f64::from(step) / f64::from(rise), 0.0, 0.0]);
            fluid
                .collide_stream(Some([wind / f64::from(rise), 0.0, 0.0]), None)
                .unwrap();
        }
        // The slowest layer passes nearly twice.
        advance(&mut fluid, 1200);
        let (mut worst_excess, mut worst) = (0.0f64, 0.0f64);
        for (i, (excess, u)) in states(&fluid).iter().enumerate() {
            // What the outlet repeats has no shear: it is felt some cells upstream.
            if i % 32 >= 24 {
                continue;
            }
            let off = [u[0] - wind * ratio(i / (32 * 5)), u[1], u[2]];
            worst = off
                .map(|u| u.abs() / wind)
                .into_iter()
                .fold(worst, f64::max);
            worst_excess = worst_excess.max(excess.abs());
        }
        assert!(worst < tolerances::SHEARED_WIND, "{worst:e}");
        assert!(
            worst_excess < tolerances::SHEARED_WIND_EXCESS,
            "{worst_excess:e}"
        );
    }
}

#[derive(Clone, Copy)]
struct TunnelStart;

impl Body for TunnelStart {
    /// While all air is accelerated alike and the inlet follows, pressure and shape of the wind stay uniform: a lag of a single
    /// step between inlet and air would start a sound wave that the tunnel keeps (it did).
    fn run(self, engine: Engine) {
        let source = "version = 1\n[air]\ndensity_kg_m3 = 1.18\nkinematic_viscosity_m2_s = 1.55e-5\n\
            [air.wind_tunnel]\nspeed_m_s = 30.0\nsize_m = [2.4, 0.4, 0.4]\nstart_time_s = 0.0222\nsponge_length_m = 0.4\n\
            [resolution]\ncell_size_m = 0.04\nlattice_speed = 0.08\noperator = \"recursive_regularised\"\n\
            eddy_viscosity = { model = \"smagorinsky\", constant = 0.15 }\n[time]\nend_s = 0.03\n[output]\nsample_interval_s = 0.001\n";
        let case = ripstop::case::parse(
            "tunnel",
            source,
            std::path::Path::new("."),
            &Default::default(),
        )
        .unwrap();
        let plan = ripstop::plan::Plan::new(&case.scene, engine.plan_placement());
        let (simulation, record) =
            ripstop::run::without_files(&case, plan, engine.device()).unwrap();
        let mass = 1.18 * 2.4 * 0.4 * 0.4;
        for excess in column(&record, "mass_excess_kg") {
            assert!(
                (excess / mass).abs() < tolerances::TUNNEL_START,
                "{:e}",
                excess / mass
            );
        }
        let energy = latest(&record, "kinetic_energy_j").unwrap() / (0.5 * mass * 900.0);
        let off = (energy - 1.0).abs();
        assert!(off < tolerances::TUNNEL_START_ENERGY, "{energy}");
        assert!(simulation.released());
    }
}

#[derive(Clone, Copy)]
struct ShearLayer;

impl Body for ShearLayer {
    /// A thin double shear layer at τ − ½ = 1e-6 (Reynolds 1e7 on the box) for 1.6 turns: finite, and the energy never rises (F2).
    fn run(self, engine: Engine) {
        let n = 64;
        let speed = 0.05;
        let mut setup = periodic([n, n, 4], 0.5 + 1e-6, Operator::RecursiveRegularised);
        setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.15));
        let initial = move |[x, y, _]: [usize; 3]| {
            let (x, y) = ((x as f64 + 0.5) / n as f64, (y as f64 + 0.5) / n as f64);
            let along = if y <= 0.5 {
                (80.0 * (y - 0.25)).tanh()
            } else {
                (80.0 * (0.75 - y)).tanh()
            };
            let across = 0.05 * (std::f64::consts::TAU * (x + 0.25)).sin();
            (0.0, [speed * along, speed * across, 0.0])
        };
        let mut fluid = engine.air(setup, &initial);
        let (_, mut energy) = fluid.mass_and_energy().unwrap();
        let first = energy;
        for _ in 0..10 {
            advance(&mut fluid, 200);
            assert_eq!(fluid.breakdown(0.3).unwrap(), None);
            let (_, now) = fluid.mass_and_energy().unwrap();
            // Sound from the unbalanced start moves up to a thousandth between kinetic and pressure energy.
            assert!(
                now < energy + 1e-3 * first,
                "energy rises from {energy} to {now}"
            );
            energy = now;
        }
        assert!(
            energy > 0.3 * first,
            "the layer must roll up, not vanish: {energy} of {first}"
        );
    }
}

#[derive(Clone, Copy)]
struct ShearWave;

impl Body for ShearWave {
    /// A shear wave A sin(ky) loses energy to ν A²k²/2 and, with Smagorinsky's ν_t = C_s² |S|, to C_s² (Ak)³ 4/(3π) besides.
    fn run(self, engine: Engine) {
        let n = 32;
        let k = std::f64::consts::TAU / n as f64;
        for operator in Operator::ALL {
            let mut setup = periodic([4, n, 4], 0.503, operator);
            setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.6));
            let wave =
                |[_, y, _]: [usize; 3]| (0.0, [0.1 * (k * (y as f64 + 0.5)).sin(), 0.0, 0.0]);
            let mut fluid = engine.air(setup, &wave);
            advance(&mut fluid, 100);
            let volume = (16 * n) as f64;
            let (_, before) = fluid.mass_and_energy().unwrap();
            let steps = 100;
            advance(&mut fluid, steps);
            let (_, after) = fluid.mass_and_energy().unwrap();
            // ½ <u²> = A²/4.
            let amplitude = (2.0 * (before + after) / volume).sqrt();
            let loss = (before - after) / volume / steps as f64;
            let molecular = 0.001 * 0.5 * (amplitude * k).powi(2);
            let eddy = 0.6 * 0.6 * (amplitude * k).powi(3) * 4.0 / (3.0 * std::f64::consts::PI);
            assert!(
                eddy > molecular,
                "the test must be about the eddy viscosity"
            );
            let error = loss / (molecular + eddy) - 1.0;
            assert!(
                error.abs() < tolerances::EDDY_VISCOSITY,
                "{operator:?}: {error}"
            );
        }
    }
}

fn threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut setup = periodic([20, 12, 13], 0.5001, Operator::RecursiveRegularised);
            setup.eddy_viscosity = Some(EddyViscosity::wale(0.5));
            let mut fluid = Engine::CpuF32.air(setup, &|[x, y, z]| {
                (0.0, [0.05 * ((x + 2 * y + 3 * z) as f64).sin(), 0.02, 0.0])
            });
            advance(&mut fluid, 30);
            let mut bits = Vec::new();
            for (excess, u) in fluid.macroscopic().unwrap() {
                bits.extend([
                    excess.to_bits(),
                    u[0].to_bits(),
                    u[1].to_bits(),
                    u[2].to_bits(),
                ]);
            }
            bits
        })
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(3));
}
