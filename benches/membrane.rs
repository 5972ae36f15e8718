//! The membrane's elastic energy and its gradient on one core: nanoseconds per triangle and evaluation.
//!
//! `cargo bench --bench membrane [-- CELLS …]` prints a line for each law, state of the fabric and number of cells along a side. Times include
//! what gathers the pulls at the nodes. The shortest of many short slices counts, since others work on shared machines.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark that cannot run, or tell, should stop"
)]

use std::hint::black_box;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use ripstop::cloth::{Structure, Triangle};
use ripstop::cpu::cloth::gather::Gather;
use ripstop::cpu::cloth::nodal_forces::{Pulls, elastic_gradient};
use ripstop::fabric::Fabric;

/// Slices of time, and how long each lasts at least.
const SLICES: usize = 150;
const SLICE: Duration = Duration::from_millis(4);

const CELL_M: f64 = 0.02;
const YOUNGS_MODULUS_PA: f64 = 4.31e8;
const POISSON_RATIO: f64 = 0.14;

/// Fabric of 0.1 mm with a shear modulus [Pa].
fn fabric(shear_modulus_pa: f64) -> Fabric {
    Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 533.77,
        warp_modulus_pa: YOUNGS_MODULUS_PA,
        weft_modulus_pa: YOUNGS_MODULUS_PA,
        poisson_ratio: POISSON_RATIO,
        shear_modulus_pa,
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 1e-3,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// Square sheet in the plane, of cells cut along alternating diagonals; its warp lies 0.3 rad from x.
fn sheet(cells: usize, fabric: &Fabric) -> Structure {
    let mut structure = Structure {
        membrane: Some(fabric.membrane()),
        ..Structure::default()
    };
    let row = cells + 1;
    structure.positions_m = (0..row * row)
        .map(|k| CELL_M * DVec3::new((k % row) as f64, (k / row) as f64, 0.0))
        .collect();
    for j in 0..cells {
        for i in 0..cells {
            let [a, b, c, d] =
                [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| ((j + y) * row + i + x) as u32);
            let halves = if (i + j) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for nodes in halves {
                let rest = nodes.map(|n| {
                    let place = structure.positions_m[n as usize].truncate();
                    DVec2::from_angle(-0.3).rotate(place)
                });
                structure
                    .triangles
                    .push(Triangle::new(nodes, rest).unwrap());
            }
        }
    }
    structure
}

/// Shortest time of one run [ns].
fn time_ns(mut run: impl FnMut()) -> f64 {
    run();
    let mut shortest = f64::INFINITY;
    for _ in 0..SLICES {
        let start = Instant::now();
        let mut runs = 0;
        while start.elapsed() < SLICE {
            run();
            runs += 1;
        }
        shortest = shortest.min(start.elapsed().as_nanos() as f64 / f64::from(runs));
    }
    shortest
}

/// Between −1 and 1 (SplitMix64, Steele et al. 2014).
fn noise(number: usize) -> f64 {
    let mut x = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn measure(cells: usize) {
    let isotropic = Fabric::isotropic_shear_modulus_pa(YOUNGS_MODULUS_PA, POISSON_RATIO);
    for (law, shear_modulus_pa) in [("orthotropic", 1e7), ("isotropic", isotropic)] {
        let structure = sheet(cells, &fabric(shear_modulus_pa));
        let gather = Gather::new(&structure);
        // Stretch along x and y, and how far nodes stray [m].
        let states = [
            ("taut", [1.02, 1.015], 1e-5),
            ("wrinkled", [1.02, 0.98], 1e-4),
            ("slack", [0.97, 0.98], 1e-5),
            ("mixed", [1.002, 0.997], 4e-4),
        ];
        for (state, [x, y], stray_m) in states {
            let place = |(k, place): (usize, &DVec3)| {
                let noise = DVec3::new(noise(3 * k), noise(3 * k + 1), noise(3 * k + 2));
                *place * DVec3::new(x, y, 1.0) + stray_m * noise
            };
            let positions: Vec<DVec3> = structure
                .positions_m
                .iter()
                .enumerate()
                .map(place)
                .collect();
            let law_of_all = structure.laws().unwrap();
            let mut counts = [0; 3];
            for triangle in &structure.triangles {
                let strain = triangle.strain(&triangle.edge_vectors(&positions));
                counts[law_of_all.of(triangle).respond(&strain).state as usize] += 1;
            }
            let count = structure.triangles.len();
            let [taut, wrinkled, slack] = counts.map(|n| (100 * n + count / 2) / count);
            let mut pulls = Pulls::default();
            let mut gradient = vec![DVec3::ZERO; positions.len()];
            let time = time_ns(|| {
                let energy = elastic_gradient(
                    &structure,
                    &gather,
                    black_box(&positions),
                    &mut pulls,
                    &mut gradient,
                );
                black_box(energy);
            });
            println!(
                "{count:7} triangles, {law:11} {state:8} ({taut:3} % taut, {wrinkled:3} % wrinkled, {slack:3} % slack): {:6.1} ns/triangle",
                time / count as f64
            );
        }
    }
}

fn main() {
    let cells: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(|| {
        for &cells in if cells.is_empty() {
            &[64, 224]
        } else {
            &cells[..]
        } {
            measure(cells);
        }
    });
}
