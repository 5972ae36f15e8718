//! Flows through boxes of finer cells, against exact solutions.

use super::*;
use crate::lattice::Operator;
use crate::lattice::grid::{Initial, Setup, Sides, StreamwiseEnds};

fn periodic(cells: [usize; 3], relaxation_time: f64, operator: Operator) -> Setup {
    Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        inlet_profile: None,
        sides: Sides::Periodic,
        relaxation_time,
        sponge_cells: None,
        operator,
        eddy_viscosity: None,
    }
}

/// A flow by its place in cells of the coarsest lattice.
type Flow<'a> = &'a (dyn Fn([f64; 3]) -> (f64, [f64; 3]) + Sync);

/// Boxes within boxes, the outermost first, in a periodic lattice; fine cells are half as large.
fn nested<T: Real>(
    cells: [usize; 3],
    relaxation_time: f64,
    operator: Operator,
    boxes: &[Nest],
    flow: Flow<'_>,
) -> Levels<T> {
    build(
        periodic(cells, relaxation_time, operator),
        boxes,
        [0.0; 3],
        1.0,
        flow,
    )
}

fn build<T: Real>(
    setup: Setup,
    boxes: &[Nest],
    origin: [f64; 3],
    size: f64,
    flow: Flow<'_>,
) -> Levels<T> {
    let inner = boxes.split_first().map(|(nest, inner)| {
        let fine = Setup {
            cells: nest.fine_cells(),
            relaxation_time: 0.5 + 2.0 * (setup.relaxation_time - 0.5),
            ..setup.clone()
        };
        let origin = std::array::from_fn(|a| origin[a] + size * nest.first[a] as f64);
        (*nest, build(fine, inner, origin, 0.5 * size, flow))
    });
    assert!(boxes.first().is_none_or(|nest| nest.fits(setup.cells)));
    let initial = |cell: [usize; 3]| {
        flow(std::array::from_fn(|a| {
            origin[a] + size * (cell[a] as f64 + 0.5)
        }))
    };
    let initial: &Initial = &initial;
    let levels = Levels::new(Fluid::new(setup, Some(initial)));
    match inner {
        Some((nest, inner)) => levels.with(nest, inner),
        None => levels,
    }
}

/// Visits all cells that no finer ones cover: place, volume, density excess, bare velocity.
fn visit<T: Real>(
    levels: &Levels<T>,
    origin: [f64; 3],
    size: f64,
    see: &mut impl FnMut([f64; 3], f64, f64, [f64; 3]),
) {
    let [nx, ny, nz] = levels.fluid.setup().cells;
    for i in 0..nx * ny * nz {
        let cell = [i % nx, i / nx % ny, i / nx / ny];
        let covered = levels.boxes().any(|(nest, _)| {
            (0..3).all(|a| (nest.first[a]..nest.first[a] + nest.cells[a]).contains(&cell[a]))
        });
        if !covered {
            let (excess, velocity) = levels.fluid.bare_state(cell);
            let place = std::array::from_fn(|a| origin[a] + size * (cell[a] as f64 + 0.5));
            see(place, size.powi(3), excess, velocity);
        }
    }
    for (nest, inner) in levels.boxes() {
        let origin = std::array::from_fn(|a| origin[a] + size * nest.first[a] as f64);
        visit(inner, origin, 0.5 * size, see);
    }
}

/// Two boxes, one within the other, in 16³ cells.
fn two_boxes() -> [Nest; 2] {
    [Nest {
        first: [4; 3],
        cells: [8; 3],
        spans: [false; 3],
    }; 2]
}

/// A uniform oblique stream passes three levels unchanged: every index, parity and scale is right.
#[test]
fn a_uniform_stream_passes() {
    let wind = [0.1, 0.03, -0.02];
    for operator in [
        Operator::TwoRelaxationTimes,
        Operator::RecursiveRegularised,
        Operator::StabilisedRegularised,
    ] {
        let mut levels = nested::<f64>([16; 3], 0.6, operator, &two_boxes(), &|_| (0.0, wind));
        for _ in 0..100 {
            levels.whole_step(None);
        }
        let mut worst = 0.0f64;
        visit(&levels, [0.0; 3], 1.0, &mut |_, _, excess, velocity| {
            for a in 0..3 {
                worst = worst.max((velocity[a] - wind[a]).abs()).max(excess.abs());
            }
        });
        assert!(worst < 1e-14, "{operator:?}: {worst:e}");
    }
}

/// Accelerated uniformly from rest to 0.08 in 200 of the finest steps, all levels move alike.
#[test]
fn all_levels_are_accelerated_alike() {
    let mut levels = nested::<f64>(
        [16; 3],
        0.5005,
        Operator::StabilisedRegularised,
        &two_boxes(),
        &|_| (0.0, [0.0; 3]),
    );
    for step in 0..200 {
        levels.whole_step((step < 50).then_some([1.6e-3, 0.0, 0.0]));
    }
    let mut worst = 0.0f64;
    visit(&levels, [0.0; 3], 1.0, &mut |_, _, excess, velocity| {
        let off = [velocity[0] - 0.08, velocity[1], velocity[2], excess];
        worst = off.into_iter().fold(worst, |worst, x| worst.max(x.abs()));
    });
    assert!(worst < 2e-6, "{worst:e}");
}

/// Relative L2 error of Taylor–Green vortices that a wind carries across the box, after they have decayed by a factor e.
fn carried_vortices(n: usize, boxes: &[Nest], size: f64) -> f64 {
    let wide = n as f64;
    let speed = 0.05 * 16.0 / wide;
    let k = std::f64::consts::TAU / wide;
    let nu = 0.1 / 3.0;
    let wind = [1.0, 0.6, 0.3].map(|w| w * speed);
    let flow = move |place: [f64; 3], time: f64| {
        let x = k * (place[0] - wind[0] * time);
        let y = k * (place[1] - wind[1] * time);
        let left = (-2.0 * nu * k * k * time).exp() * speed;
        (
            0.75 * left * left * ((2.0 * x).cos() + (2.0 * y).cos()),
            [
                wind[0] + left * x.sin() * y.cos(),
                wind[1] - left * x.cos() * y.sin(),
                wind[2],
            ],
        )
    };
    // `size` is ½ for a uniform lattice of fine cells.
    let cells = [(wide / size) as usize; 3];
    let setup = periodic(cells, 0.5 + 0.1 / size, Operator::StabilisedRegularised);
    let start = move |place: [f64; 3]| flow(place, 0.0);
    let mut levels = build::<f64>(setup, boxes, [0.0; 3], size, &start);
    let steps = (1.0 / (2.0 * nu * k * k)).round();
    for _ in 0..(steps / size) as usize {
        levels.whole_step(None);
    }
    let (mut off, mut whole) = (0.0, 0.0);
    visit(
        &levels,
        [0.0; 3],
        size,
        &mut |place, volume, _, velocity| {
            let (_, exact) = flow(place, steps);
            for a in 0..3 {
                off += volume * (velocity[a] - exact[a]).powi(2);
                whole += volume * (exact[a] - wind[a]).powi(2);
            }
        },
    );
    (off / whole).sqrt()
}

/// A box adds no error to that of the coarse cells around it, and is of second order.
#[test]
fn vortices_that_pass_are_of_second_order() {
    let nest = |n: usize| Nest {
        first: [n / 4; 3],
        cells: [n / 2; 3],
        spans: [false; 3],
    };
    let errors = [12, 24].map(|n| {
        let found = carried_vortices(n, &[nest(n)], 1.0);
        let coarse = carried_vortices(n, &[], 1.0);
        println!("{n}: nested {found:.3e}, coarse {coarse:.3e}");
        assert!(found < 1.02 * coarse, "{n}: {found:e} {coarse:e}");
        found
    });
    let order = (errors[0] / errors[1]).log2();
    assert!(order > 1.9, "{order}");
}
