//! The air on the CPU: million lattice updates per second, as a share of the memory's bandwidth, with an error beside every speed.
//!
//! `cargo bench --bench fluid [-- FILE]` prints tables and, with FILE, writes the same as JSON, with machine, commit and date from the
//! environment (`RIPSTOP_MACHINE`, `RIPSTOP_COMMIT`, `RIPSTOP_DATE`). `fluid serve` answers `benches/peers/lbmpy_compare.py`.
//!
//! A step reads and writes 19 populations: 152 B per cell in single, 304 B in double precision, 76 B with 16 bits (`f16`, computed in single precision). Rounds of all set-ups and of a plain pass
//! over memory alternate and shares are taken within a round, since the bandwidth of shared machines changes within seconds; medians are
//! shown. The pass works in place, as a step does: it reads a long array and writes it back through the caches, so no line is fetched only
//! to be overwritten. A copy from array to array is shown beside it; the system's `memcpy` does that with stores that go round the caches.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a benchmark that cannot run, or tell, should stop"
)]

use std::io::BufRead;
use std::time::Instant;

use half::f16;
use rayon::prelude::*;
use ripstop::cpu::fluid::{BodyForce, Fluid, ForcedCells, Stored};
use ripstop::lattice::Operator;
use ripstop::lattice::control_volume::ControlVolume;
use ripstop::lattice::eddy_viscosity::EddyViscosity;
use ripstop::lattice::grid::{Setup, Sides, StreamwiseEnds};
use serde_json::{Value, json};

const RELAXATION_TIME: f64 = 0.6;
const SPEED: f64 = 0.02;
const SMAGORINSKY_CONSTANT: f64 = 0.15;

/// What is timed.
#[derive(Clone, Copy, PartialEq)]
enum Scene {
    /// Periodic box with a shear wave u_x = 0.02 sin(k y).
    Periodic {
        operator: Operator,
        eddy: bool,
        /// With the force terms everywhere, for a force of zero.
        always_forced: bool,
    },
    /// Uniform wind through inlet, outlet and frictionless walls, without sponge or force.
    Wind,
    /// Regularised operator, eddy viscosity, all boundaries, sponge, and a force on the cells near a hemisphere.
    Canopy,
}

impl Scene {
    const TRT: Self = Self::periodic(Operator::TwoRelaxationTimes, false);
    const ALL: [(&str, Self); 6] = [
        ("trt", Self::TRT),
        ("rr", Self::periodic(Operator::RecursiveRegularised, false)),
        (
            "rr+les",
            Self::periodic(Operator::RecursiveRegularised, true),
        ),
        ("canopy", Self::Canopy),
        (
            "trt, forced everywhere",
            Self::Periodic {
                operator: Operator::TwoRelaxationTimes,
                eddy: false,
                always_forced: true,
            },
        ),
        ("trt, inlet and walls", Self::Wind),
    ];

    const fn periodic(operator: Operator, eddy: bool) -> Self {
        Self::Periodic {
            operator,
            eddy,
            always_forced: false,
        }
    }
}

/// A scene with its air, and what acts on it.
struct Bench<P: Stored> {
    scene: Scene,
    side: usize,
    air: Fluid<P>,
    rows: Vec<(u32, u32, u32)>,
    x: Vec<u32>,
    force: Vec<[f64; 3]>,
    steps: usize,
}

impl<P: Stored> Bench<P> {
    fn new(scene: Scene, side: usize) -> Self {
        let canopy = scene == Scene::Canopy;
        let (operator, eddy) = match scene {
            Scene::Periodic { operator, eddy, .. } => (operator, eddy),
            Scene::Wind => (Operator::TwoRelaxationTimes, false),
            Scene::Canopy => (Operator::RecursiveRegularised, true),
        };
        let periodic = matches!(scene, Scene::Periodic { .. });
        let setup = Setup {
            cells: [side; 3],
            ends: if periodic {
                StreamwiseEnds::Periodic
            } else {
                StreamwiseEnds::InletOutlet
            },
            sides: if periodic {
                Sides::Periodic
            } else {
                Sides::FreeSlip
            },
            relaxation_time: RELAXATION_TIME,
            inlet_profile: None,
            sponge_cells: canopy.then_some(0.15 * side as f64),
            idle: None,
            operator,
            eddy_viscosity: eddy.then_some(EddyViscosity::smagorinsky(SMAGORINSKY_CONSTANT)),
        };
        let k = std::f64::consts::TAU / side as f64;
        let mut air = Fluid::new(
            setup,
            Some(&|[_, y, _]: [usize; 3]| {
                let wave = (k * (y as f64 + 0.5)).sin();
                let speed = if periodic { SPEED * wave } else { SPEED };
                (0.0, [speed, 0.0, 0.0])
            }),
        );
        air.set_inlet_velocity([SPEED, 0.0, 0.0]);
        let mut bench = Self {
            scene,
            side,
            air,
            rows: Vec::new(),
            x: Vec::new(),
            force: Vec::new(),
            steps: 0,
        };
        if canopy {
            bench.force_near_hemisphere();
        }
        bench.advance(4);
        bench
    }

    /// Cells within two of a hemispherical sheet, as wide as a quarter of the tunnel, open downstream.
    fn force_near_hemisphere(&mut self) {
        let n = self.side;
        let radius = 0.125 * n as f64;
        for row in 0..n * n {
            let first = self.x.len() as u32;
            let (y, z) = ((row % n) as f64, (row / n) as f64);
            for x in 0..n {
                let from_centre = [
                    x as f64 - 0.4 * n as f64,
                    y - 0.5 * n as f64,
                    z - 0.5 * n as f64,
                ];
                let distance = from_centre.iter().map(|d| d * d).sum::<f64>().sqrt();
                if from_centre[0] < 2.0 && (distance - radius).abs() < 2.0 {
                    self.x.push(x as u32);
                    self.force.push([-1e-5, 0.0, 0.0]);
                }
            }
            if self.x.len() as u32 > first {
                self.rows.push((row as u32, first, self.x.len() as u32));
            }
        }
    }

    fn advance(&mut self, steps: usize) {
        let always_forced = matches!(
            self.scene,
            Scene::Periodic {
                always_forced: true,
                ..
            }
        );
        let body_force = BodyForce {
            acceleration: always_forced.then_some([0.0; 3]),
            cells: ForcedCells {
                rows: &self.rows,
                x: &self.x,
                force: &self.force,
            },
        };
        for _ in 0..steps {
            self.air.collide_stream(&body_force);
        }
        self.steps += steps;
    }

    /// Million lattice updates per second over `seconds`.
    fn timed(&mut self, seconds: f64) -> f64 {
        let start = Instant::now();
        let before = self.steps;
        while start.elapsed().as_secs_f64() < seconds {
            self.advance(2);
        }
        let elapsed = start.elapsed().as_secs_f64();
        (self.side.pow(3) * (self.steps - before)) as f64 / elapsed * 1e-6
    }

    /// Periodic: relative error of the decay rate against molecular viscosity since the start. Wind: largest change of velocity, over
    /// the speed. Canopy: what the momentum balance of a box misses, over the force inside.
    fn error(&mut self) -> f64 {
        let n = self.side;
        match self.scene {
            Scene::Periodic { .. } => {
                let k = std::f64::consts::TAU / n as f64;
                let amplitude = (0..n)
                    .map(|y| {
                        let (_, u) = self.air.bare_state([n / 2, y, n / 2]);
                        2.0 / n as f64 * u[0] * (k * (y as f64 + 0.5)).sin()
                    })
                    .sum::<f64>();
                let exact = (RELAXATION_TIME - 0.5) / 3.0 * k * k;
                (SPEED / amplitude).ln() / self.steps as f64 / exact - 1.0
            }
            Scene::Wind => self
                .air
                .macroscopic()
                .iter()
                .map(|(_, u)| (f64::from(u[0]) - SPEED).abs() / SPEED)
                .fold(0.0, f64::max),
            Scene::Canopy => {
                let grid = *self.air.grid();
                let volume = ControlVolume::new(&grid, [2; 3], [n * 3 / 4, n - 2, n - 2]);
                let before = self.air.storage(&volume).momentum[0];
                self.advance(1);
                let after = self.air.storage(&volume).momentum[0];
                let force: f64 = self.force.iter().map(|f| f[0]).sum();
                let missing = after - before + self.air.outflow(&volume).momentum[0] - force;
                missing / force
            }
        }
    }
}

/// Two large arrays, for the bandwidth of memory on all threads.
struct Memory {
    from: Vec<f64>,
    to: Vec<f64>,
}

impl Memory {
    fn new() -> Self {
        let values = (256 << 20) / size_of::<f64>();
        Self {
            from: vec![1.0; values],
            to: vec![2.0; values],
        }
    }

    /// Bytes per second, read and written, of a pass in place.
    fn pass(&mut self, seconds: f64) -> f64 {
        let part = self.to.len().div_ceil(rayon::current_num_threads());
        self.repeat(seconds, |memory| {
            memory.to.par_chunks_mut(part).for_each(|part| {
                for value in part {
                    *value = -*value;
                }
            });
        })
    }

    /// Bytes per second, read and written, of a copy from one array to the other.
    fn copy(&mut self, seconds: f64) -> f64 {
        let part = self.to.len().div_ceil(rayon::current_num_threads());
        self.repeat(seconds, |memory| {
            memory
                .to
                .par_chunks_mut(part)
                .zip(memory.from.par_chunks(part))
                .for_each(|(to, from)| to.copy_from_slice(from));
        })
    }

    fn repeat(&mut self, seconds: f64, work: impl Fn(&mut Self)) -> f64 {
        let start = Instant::now();
        let mut bytes = 0;
        while start.elapsed().as_secs_f64() < seconds {
            work(self);
            bytes += 2 * size_of_val(&self.to[..]);
        }
        bytes as f64 / start.elapsed().as_secs_f64()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// All set-ups of one size and precision, in alternation.
fn table<P: Stored>(precision: &str, side: usize, rounds: usize, seconds: f64) -> Vec<Value> {
    let mut benches = Scene::ALL.map(|(_, scene)| Bench::<P>::new(scene, side));
    let mut memory = Memory::new();
    let mut bandwidths = [const { Vec::new() }; 2];
    let mut speeds = [const { Vec::new() }; Scene::ALL.len()];
    let mut shares = [const { Vec::new() }; Scene::ALL.len()];
    let mut to_trt = [const { Vec::new() }; Scene::ALL.len()];
    let bytes_per_cell = (38 * size_of::<P>()) as f64;
    for _ in 0..rounds {
        let bandwidth = memory.pass(seconds);
        bandwidths[0].push(1e-9 * bandwidth);
        bandwidths[1].push(1e-9 * memory.copy(seconds));
        let mut trt = f64::NAN;
        for (i, bench) in benches.iter_mut().enumerate() {
            let speed = bench.timed(seconds);
            if i == 0 {
                trt = speed;
            }
            speeds[i].push(speed);
            shares[i].push(1e6 * speed * bytes_per_cell / bandwidth);
            to_trt[i].push(speed / trt);
        }
    }
    let [pass, copy] = bandwidths.map(median);
    println!("{precision:>4} {side:>5} memory: {pass:.1} GB/s in place, {copy:.1} GB/s copied");
    let mut results = Vec::new();
    for (i, (name, _)) in Scene::ALL.iter().enumerate() {
        let [speed, share, ratio] = [&mut speeds, &mut shares, &mut to_trt]
            .map(|list| median(std::mem::take(&mut list[i])));
        let error = benches[i].error();
        println!(
            "{precision:>4} {side:>5} {name:>23} {speed:>7.0} {:>8.0}% {ratio:>9.2} {error:>+11.1e}",
            100.0 * share
        );
        results.push(json!({
            "precision": precision, "side": side, "setup": name, "million_lattice_updates_per_s": speed,
            "share_of_bandwidth_in_place": share, "gigabytes_per_s_in_place": pass, "gigabytes_per_s_copied": copy, "ratio_to_trt": ratio, "error": error,
        }));
    }
    results
}

/// What leaving out the force terms changes in the results: largest difference of velocity after `steps`, over the speed.
fn change_by_skipping_force<P: Stored>(side: usize, steps: usize) -> f64 {
    let [bare, forced] = [Scene::ALL[0].1, Scene::ALL[4].1].map(|scene| {
        let mut bench = Bench::<P>::new(scene, side);
        bench.advance(steps);
        bench.air.macroscopic()
    });
    bare.iter()
        .zip(&forced)
        .flat_map(|(a, b)| (0..3).map(|k| f64::from((a.1[k] - b.1[k]).abs()) / SPEED))
        .fold(0.0, f64::max)
}

/// Answers lines `SETUP PRECISION SIDE SECONDS`, `memory - 0 SECONDS` and `decay PRECISION SIDE STEPS` with a line of JSON each.
fn serve() {
    let mut single: Option<(String, Bench<f32>)> = None;
    let mut sixteen_bits: Option<(String, Bench<f16>)> = None;
    let mut double: Option<(String, Bench<f64>)> = None;
    let mut memory = None;
    for line in std::io::stdin().lock().lines() {
        let line = line.unwrap();
        let words: Vec<&str> = line.split_whitespace().collect();
        let [setup, precision, side, amount] = words[..] else {
            println!("{}", json!({"error": "four words are needed"}));
            continue;
        };
        let side: usize = side.parse().unwrap();
        let amount: f64 = amount.parse().unwrap();
        let answer = if setup == "memory" {
            let memory = memory.get_or_insert_with(Memory::new);
            json!({"gigabytes_per_s_in_place": 1e-9 * memory.pass(amount)})
        } else if precision == "f32" {
            answer::<f32>(&mut single, setup, side, amount)
        } else if precision == "f16" {
            answer::<f16>(&mut sixteen_bits, setup, side, amount)
        } else {
            answer::<f64>(&mut double, setup, side, amount)
        };
        println!("{answer}");
    }
}

fn answer<P: Stored>(
    kept: &mut Option<(String, Bench<P>)>,
    setup: &str,
    side: usize,
    amount: f64,
) -> Value {
    if setup == "decay" {
        let mut bench = Bench::<P>::new(Scene::TRT, side);
        bench.advance(amount as usize - bench.steps);
        return json!({"decay_rate_error": bench.error()});
    }
    let Some((_, scene)) = Scene::ALL.iter().find(|(name, _)| *name == setup) else {
        return json!({"error": format!("no set-up '{setup}'")});
    };
    let key = format!("{setup} {side}");
    if kept.as_ref().is_none_or(|(name, _)| *name != key) {
        *kept = None;
    }
    let (_, bench) = kept.get_or_insert_with(|| (key, Bench::new(*scene, side)));
    json!({"million_lattice_updates_per_s": bench.timed(amount)})
}

fn main() {
    // Cargo passes `--bench`.
    let argument = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    if argument.as_deref() == Some("serve") {
        serve();
        return;
    }
    let threads = rayon::current_num_threads();
    println!(
        "{threads} threads, shear wave or as named; errors: decay rate, velocity, momentum balance"
    );
    println!(
        "{:>4} {:>5} {:>23} {:>7} {:>9} {:>9} {:>11}",
        "", "side", "set-up", "MLUPS", "of pass", "of trt", "error"
    );
    let mut rows = Vec::new();
    for side in [128, 192] {
        rows.extend(table::<f32>("f32", side, 7, 0.25));
        rows.extend(table::<f16>("f16", side, 7, 0.25));
    }
    rows.extend(table::<f64>("f64", 128, 7, 0.25));
    let change = [
        change_by_skipping_force::<f32>(64, 200),
        change_by_skipping_force::<f64>(64, 200),
    ];
    println!(
        "velocity changed by leaving out force terms where no force acts: {:.1e} (f32), {:.1e} (f64) of the speed",
        change[0], change[1]
    );
    let report = json!({
        "benchmark": "fluid", "ripstop": env!("CARGO_PKG_VERSION"), "threads": threads,
        "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
        "date": std::env::var("RIPSTOP_DATE").ok(),
        "setups": rows, "change_by_skipping_force": {"f32": change[0], "f64": change[1]},
    });
    if let Some(file) = argument {
        std::fs::write(&file, serde_json::to_string_pretty(&report).unwrap()).unwrap();
        println!("written to {file}");
    }
}
