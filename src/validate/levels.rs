//! Boxes of finer cells inside a lattice ([`crate::simulation::Levels`]): uniform streams, uniform acceleration, vortices that pass, sound that
//! meets a box.

use super::flows::{periodic, states};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::grid::Setup;
use crate::lattice::nest::Nest;
use crate::measure::extremes::largest;
use crate::simulation::Levels;

/// Density excess and velocity by place and time, in cells and steps of the coarsest lattice.
type Flow<'a> = &'a (dyn Fn([f64; 3]) -> (f64, [f64; 3]) + Sync);

/// Streams in double precision: nothing but round-off.
const STREAM_DOUBLE: f64 = 1e-14;

/// In single precision: 5e-7 with two relaxation times on a software adapter. A wrong index, parity or scale leaves 1e-3 and more.
const STREAM_SINGLE: f64 = 2e-6;

/// 4e-7 in every precision; exchanging momenta with half the force leaves 3.5e-4.
const ACCELERATION: f64 = 2e-6;

/// Error over that of coarse cells alone: 0.98 to 0.99; linear interpolation has 4 and more.
const OVER_COARSE: f64 = 1.02;

/// 1.995; every prolongation whose children have another mean than their cell is of first order.
const ORDER: f64 = 1.9;

/// 1.7e-3, of whatever width: the bulk mode is damped alike per step on both sides. A stress that is not rescaled sends 5e-3 back.
const REFLECTED: f64 = 2.5e-3;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    for operator in Operator::in_use() {
        stream(session, operator)?;
    }
    acceleration(session)?;
    vortices(session)?;
    sound(session)?;
    if session.order.full {
        passing_vortex(session)?;
    }
    Ok(())
}

/// A lattice with boxes one within the other, the outermost first.
fn nested(
    session: &Session,
    setup: Setup,
    boxes: &[Nest],
    origin: [f64; 3],
    size: f64,
    flow: Flow<'_>,
) -> Result<Levels, Stop> {
    let initial = |cell: [usize; 3]| {
        flow(std::array::from_fn(|a| {
            origin[a] + size * (cell[a] as f64 + 0.5)
        }))
    };
    let levels = Levels::new(session.air(setup.clone(), &initial)?);
    let Some((nest, inner)) = boxes.split_first() else {
        return Ok(levels);
    };
    if !nest.fits(setup.cells) {
        return Err(Stop::Refused(format!("{nest:?} does not fit")));
    }
    let fine = Setup {
        cells: nest.fine_cells(),
        relaxation_time: 0.5 + 2.0 * (setup.relaxation_time - 0.5),
        ..setup
    };
    let corner = std::array::from_fn(|a| origin[a] + size * nest.first[a] as f64);
    let inner = nested(session, fine, inner, corner, 0.5 * size, flow)?;
    Ok(levels.with(*nest, inner)?)
}

/// A cell that no finer ones cover.
struct Seen {
    place: [f64; 3],
    volume: f64,
    density_excess: f64,
    velocity: [f64; 3],
}

/// All such cells.
fn seen(levels: &Levels, origin: [f64; 3], size: f64, all: &mut Vec<Seen>) -> Result<(), Stop> {
    let [nx, ny, _] = levels.engine().grid().cells;
    for (i, (density_excess, velocity)) in states(levels.engine())?.into_iter().enumerate() {
        let cell = [i % nx, i / nx % ny, i / nx / ny];
        let covered = levels.boxes().any(|(nest, _)| {
            (0..3).all(|a| (nest.first[a]..nest.first[a] + nest.cells[a]).contains(&cell[a]))
        });
        if !covered {
            all.push(Seen {
                place: std::array::from_fn(|a| origin[a] + size * (cell[a] as f64 + 0.5)),
                volume: size.powi(3),
                density_excess,
                velocity,
            });
        }
    }
    for (nest, inner) in levels.boxes() {
        let corner = std::array::from_fn(|a| origin[a] + size * nest.first[a] as f64);
        seen(inner, corner, 0.5 * size, all)?;
    }
    Ok(())
}

fn all_cells(levels: &Levels, size: f64) -> Result<Vec<Seen>, Stop> {
    let mut all = Vec::new();
    seen(levels, [0.0; 3], size, &mut all)?;
    Ok(all)
}

fn advance(
    session: &mut Session,
    levels: &mut Levels,
    steps: usize,
    acceleration: impl Fn(usize) -> Option<[f64; 3]>,
) -> Result<(), Stop> {
    for step in 0..steps {
        session.check_interrupt()?;
        levels.whole_step(acceleration(step))?;
        let updates = session.done + 1e-6 * levels.updates() as f64;
        session.progress_to(updates);
    }
    Ok(())
}

/// Two boxes, one within the other, in 16³ cells.
const TWO_BOXES: [Nest; 2] = [Nest {
    first: [4; 3],
    cells: [8; 3],
    spans: [false; 3],
}; 2];

/// A uniform oblique stream passes three levels unchanged: every index, parity and scale is right.
fn stream(session: &mut Session, operator: Operator) -> Result<(), Stop> {
    let wind = [0.1, 0.03, -0.02];
    let setup = periodic([16; 3], 0.6, operator);
    let flow = move |_: [f64; 3]| (0.0, wind);
    let mut levels = nested(session, setup, &TWO_BOXES, [0.0; 3], 1.0, &flow)?;
    let steps = session.size(20, 300);
    advance(session, &mut levels, steps, |_| None)?;
    let all = all_cells(&levels, 1.0)?;
    let worst = largest(all.iter().flat_map(|cell| {
        let [u, v, w] = cell.velocity;
        [u - wind[0], v - wind[1], w - wind[2], cell.density_excess].map(f64::abs)
    }));
    let limit = if session.is_double() {
        STREAM_DOUBLE
    } else {
        STREAM_SINGLE
    };
    session
        .row(
            [16; 3],
            format!(
                "uniform stream, {}: largest difference",
                operator.short_name()
            ),
            worst,
        )
        .gate(Gate::AtMost(limit));
    Ok(())
}

/// Accelerated uniformly from rest to 0.08 in 50 steps, then left alone, all levels move alike.
fn acceleration(session: &mut Session) -> Result<(), Stop> {
    let setup = periodic([16; 3], 0.5005, Operator::StabilisedRegularised);
    let mut levels = nested(session, setup, &TWO_BOXES, [0.0; 3], 1.0, &|_| {
        (0.0, [0.0; 3])
    })?;
    advance(session, &mut levels, 100, |step| {
        (step < 50).then_some([1.6e-3, 0.0, 0.0])
    })?;
    let all = all_cells(&levels, 1.0)?;
    let worst = largest(all.iter().flat_map(|cell| {
        let [u, v, w] = cell.velocity;
        [u - 0.08, v, w, cell.density_excess].map(f64::abs)
    }));
    session
        .row([16; 3], "uniform acceleration: largest difference", worst)
        .gate(Gate::AtMost(ACCELERATION));
    Ok(())
}

/// Taylor–Green vortices that a wind carries across the box, until they have decayed by a factor e: relative L2 error of the velocity.
fn carried_vortices(session: &mut Session, n: usize, boxes: &[Nest]) -> Result<f64, Stop> {
    let wide = n as f64;
    let speed = 0.05 * 16.0 / wide;
    let k = std::f64::consts::TAU / wide;
    let nu = 0.1 / 3.0;
    let wind = [1.0, 0.6, 0.3].map(|w| w * speed);
    let flow = move |place: [f64; 3], time: f64| {
        let x = k * (place[0] - wind[0] * time);
        let y = k * (place[1] - wind[1] * time);
        let left = (-2.0 * nu * k * k * time).exp() * speed;
        let velocity = [
            wind[0] + left * x.sin() * y.cos(),
            wind[1] - left * x.cos() * y.sin(),
            wind[2],
        ];
        let excess = 0.75 * left * left * ((2.0 * x).cos() + (2.0 * y).cos());
        (excess, velocity)
    };
    let setup = periodic([n; 3], 0.6, Operator::StabilisedRegularised);
    let start = move |place: [f64; 3]| flow(place, 0.0);
    let mut levels = nested(session, setup, boxes, [0.0; 3], 1.0, &start)?;
    let steps = (1.0 / (2.0 * nu * k * k)).round();
    advance(session, &mut levels, steps as usize, |_| None)?;
    let (mut off, mut whole) = (0.0, 0.0);
    for cell in all_cells(&levels, 1.0)? {
        let (_, exact) = flow(cell.place, steps);
        for a in 0..3 {
            off += cell.volume * (cell.velocity[a] - exact[a]).powi(2);
            whole += cell.volume * (exact[a] - wind[a]).powi(2);
        }
    }
    Ok((off / whole).sqrt())
}

/// A box adds no error to that of the coarse cells around it, and is of second order.
fn vortices(session: &mut Session) -> Result<(), Stop> {
    let sizes: &[usize] = session.size(&[12, 24], &[16, 32, 64]);
    let mut points = Vec::new();
    for &n in sizes {
        let nest = Nest {
            first: [n / 4; 3],
            cells: [n / 2; 3],
            spans: [false; 3],
        };
        let coarse = carried_vortices(session, n, &[])?;
        let found = carried_vortices(session, n, &[nest])?;
        session.row([n; 3], "carried vortices: error", found);
        session
            .row(
                [n; 3],
                "carried vortices: error over that of coarse cells alone",
                found / coarse,
            )
            .gate(Gate::AtMost(OVER_COARSE));
        points.push([(1.0 / n as f64).ln(), found.ln()]);
    }
    let order = super::flows::slope(&points);
    session
        .row([0; 3], "carried vortices: order", order)
        .gate(Gate::AtLeast(ORDER));
    Ok(())
}

/// A plane pulse of sound meets a slab of fine cells: what comes back, over what came.
fn sound(session: &mut Session) -> Result<(), Stop> {
    const WIDTH: f64 = 4.0;
    const HEIGHT: f64 = 1e-3;
    let cells = [384, 4, 4];
    let nest = Nest {
        first: [192, 0, 0],
        cells: [96, 4, 4],
        spans: [false, true, true],
    };
    let speed_of_sound = (1.0f64 / 3.0).sqrt();
    let flow = move |place: [f64; 3]| {
        let x = (place[0] - 130.0) / WIDTH;
        let excess = HEIGHT * (-0.5 * x * x).exp();
        (excess, [speed_of_sound * excess, 0.0, 0.0])
    };
    let setup = periodic(cells, 0.5001, Operator::StabilisedRegularised);
    let mut levels = nested(session, setup, &[nest], [0.0; 3], 1.0, &flow)?;
    // The pulse stands 44 cells behind the interface, what came back 44 before it.
    advance(session, &mut levels, 184, |_| None)?;
    let all = all_cells(&levels, 1.0)?;
    let before = all
        .iter()
        .filter(|cell| (118.0..184.0).contains(&cell.place[0]));
    let leftwards = |cell: &Seen| 0.5 * (cell.density_excess - cell.velocity[0] / speed_of_sound);
    let back = largest(before.map(|cell| leftwards(cell).abs()));
    session
        .row(cells, "sound: reflected over incident", back / HEIGHT)
        .gate(Gate::AtMost(REFLECTED));
    Ok(())
}

/// A vortex of eight coarse cells passes a box in a wind, at a viscosity that does nothing: its error, and the pressure far from it.
fn passing_vortex(session: &mut Session) -> Result<(), Stop> {
    const RADIUS: f64 = 8.0;
    const SPEED: f64 = 0.05;
    const WIND: f64 = 0.1;
    let cells = [160, 80, 4];
    let nest = Nest {
        first: [60, 20, 0],
        cells: [40, 40, 4],
        spans: [false, false, true],
    };
    let flow = move |place: [f64; 3], time: f64| {
        let off = |a: usize, start: f64, n: f64| {
            let x = place[a] - start;
            x - n * (x / n).round()
        };
        let (x, y) = (off(0, 20.0 + WIND * time, 160.0), off(1, 40.0, 80.0));
        let e = (1.0 - (x * x + y * y) / (RADIUS * RADIUS)).exp();
        let around = SPEED / RADIUS * e.sqrt();
        (
            (-1.5 * SPEED * SPEED * e).exp() - 1.0,
            [WIND - around * y, around * x, 0.0],
        )
    };
    let steps = 1600;
    let start = move |place: [f64; 3]| flow(place, 0.0);
    let mut errors = [0.0; 2];
    for (error, boxes) in errors.iter_mut().zip([&[][..], &[nest][..]]) {
        let setup = periodic(cells, 0.500_01, Operator::StabilisedRegularised);
        let mut levels = nested(session, setup, boxes, [0.0; 3], 1.0, &start)?;
        advance(session, &mut levels, steps, |_| None)?;
        let (mut off, mut whole) = (0.0, 0.0);
        for cell in all_cells(&levels, 1.0)? {
            let (_, exact) = flow(cell.place, steps as f64);
            for a in 0..3 {
                off += cell.volume * (cell.velocity[a] - exact[a]).powi(2);
            }
            whole += cell.volume * ((exact[0] - WIND).powi(2) + exact[1].powi(2));
        }
        *error = (off / whole).sqrt();
    }
    session.row(
        cells,
        "passing vortex: error of coarse cells alone",
        errors[0],
    );
    session
        .row(
            cells,
            "passing vortex: error with the box, over that",
            errors[1] / errors[0],
        )
        .gate(Gate::AtMost(1.0));
    Ok(())
}
