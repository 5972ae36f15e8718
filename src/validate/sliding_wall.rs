//! Walls along which the air slides, at cut links: a plane that lies anyhow in the lattice, and the lift of a section.
//!
//! A stream along a plane loses nothing where the air slides; what it loses is told over what it loses where the air sticks. A closed section (NACA 0012 at 4°,
//! between planes that repeat) lifts as in a frictionless stream, if the flow leaves its trailing edge smoothly on so few cells: C_l of potential flow. It has no drag. Where the section stands between
//! the cells turns it by some half a cell over its chord, so that the mean over four places is judged; their scatter is told.

use glam::DVec3;

use super::flows::periodic;
use super::report::Gate;
use super::session::{Session, Stop};
use crate::case::coupling::Friction;
use crate::geometry::profile::Profile;
use crate::lattice::Operator;
use crate::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use crate::simulation::{AirEngine, CutSurface};

/// Most of the drag where the air sticks that a plane may take.
const BAND_OF_DRAG: f64 = 0.05;

/// Width of a channel between turned planes [cells]; the share of its flow that may be lost while the stream goes four fifths of the box.
const CHANNEL: f64 = 8.0;
const BAND_OF_FLOW: f64 = 0.01;

/// Speed of the streams [cells per step].
const SPEED: f64 = 0.08;

/// Steps along planes.
const STEPS: usize = 400;

/// Reynolds number of the section: hardly any viscosity.
const REYNOLDS: f64 = 1e6;

/// Angle of attack [°], and C_l there of NACA 0012 in potential flow: 6.87 sin α (lift slope by panels; 2π without thickness).
const ANGLE_DEG: f64 = 4.0;
const LIFT: f64 = 0.479;

/// Distance of the mean over the places of the section from that.
const BAND_OF_LIFT: f64 = 0.15;

/// Most drag or thrust of the mean over the places: in a plane stream without friction there is none.
const BAND_OF_SECTION_DRAG: f64 = 0.02;

/// Cells per chord from which on it is judged.
const GATED_CELLS: usize = 24;

/// Places of the section between cells [cells].
const PLACES: [[f64; 2]; 4] = [[0.0, 0.0], [0.25, 0.5], [0.5, 0.0], [0.75, 0.5]];

/// Box of the section, in chords along and above; cells across.
const BOX: f64 = 8.0;
const ACROSS: usize = 4;

/// Chords that the stream goes, in the quick and the full set, and those of them, at the end, that are judged.
const CHORDS: [f64; 2] = [7.0, 10.0];
const JUDGED: f64 = 2.0;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    planes(session)?;
    channel(session)?;
    for chord in session.size(&[24][..], &[16, 24, 32, 48]) {
        section(session, *chord)?;
    }
    Ok(())
}

fn planes(session: &mut Session) -> Result<(), Stop> {
    let v = DVec3::new;
    let planes = [
        ([40, 20, 6], [v(40.0, 0.0, 0.0), v(0.0, 0.0, 6.0)], "0"),
        ([40, 20, 6], [v(40.0, 20.0, 0.0), v(0.0, 0.0, 6.0)], "26.6"),
        ([20, 20, 6], [v(20.0, 20.0, 0.0), v(0.0, 0.0, 6.0)], "45"),
    ];
    for (cells, [side, across], angle) in planes {
        let along = side.normalize();
        let middle = DVec3::from_array(cells.map(|n| 0.5 * n as f64)) + v(-0.07, 0.11, -0.5);
        let start = middle - 0.5 * (side + across);
        let positions = vec![start, start + side, start + side + across, start + across];
        let triangles = [[0, 1, 2], [2, 3, 0]];
        let drag = drags(session, cells, along, (&positions, &triangles))?;
        session
            .row(
                cells,
                format!("plane at {angle} degrees: drag over that where the air sticks"),
                share_of_drag(drag, SPEED * cells.iter().product::<usize>() as f64),
            )
            .gate(Gate::AtMost(BAND_OF_DRAG));
    }
    Ok(())
}

/// What is lost where the air slides over what is lost where it sticks; not a number where that is none: a stream loses no more than its momentum.
fn share_of_drag([slides, sticks]: [f64; 2], momentum: f64) -> f64 {
    if sticks > 0.0 && sticks < momentum {
        (slides / sticks).abs()
    } else {
        f64::NAN
    }
}

/// What a disturbed stream along walls loses where it slides and where it sticks, summed over all steps.
fn drags(
    session: &mut Session,
    cells: [usize; 3],
    along: DVec3,
    (positions, triangles): (&[DVec3], &[[u32; 3]]),
) -> Result<[f64; 2], Stop> {
    let mut drags = [0.0; 2];
    for (friction, drag) in [Friction::None, Friction::NoSlip]
        .into_iter()
        .zip(&mut drags)
    {
        let setup = periodic(cells, 0.5001, Operator::StabilisedRegularised);
        let mut air = session.air(setup, &|cell| (0.0, disturbed(along * SPEED, cell)))?;
        let surface = CutSurface::new(&air, triangles.to_vec(), positions.len(), (0, None));
        let mut surface = surface.with_friction(vec![friction; triangles.len()], 0.0, positions);
        for _ in 0..STEPS {
            *drag -= step(session, &mut air, &mut surface, positions)?.dot(along);
        }
    }
    Ok(drags)
}

/// A stream with noise of up to a twentieth of its speed.
fn disturbed(stream: DVec3, cell: [usize; 3]) -> [f64; 3] {
    std::array::from_fn(|a| {
        let number = cell[0] * 7919 + cell[1] * 104_729 + cell[2] * 1_299_709 + a * 15_485;
        stream[a] + 0.1 * SPEED * ((number % 1009) as f64 / 1009.0 - 0.5)
    })
}

fn section(session: &mut Session, chord: usize) -> Result<(), Stop> {
    let mut lifts = Vec::new();
    for place in PLACES {
        lifts.push(coefficients(session, chord, place, Friction::None)?);
    }
    let cells = setup(chord).cells;
    let mean = |k: usize| lifts.iter().map(|c| c[k]).sum::<f64>() / lifts.len() as f64;
    let squares: f64 = lifts.iter().map(|c| (c[0] - mean(0)).powi(2)).sum();
    let scatter = (squares / (lifts.len() - 1) as f64).sqrt();
    let of = format!("section, {chord} cells per chord");
    let row = session
        .row(cells, format!("{of}: lift, mean of four places"), mean(0))
        .reference(LIFT, "potential flow");
    // With 16 cells the nose is a quarter of a cell round.
    if chord >= GATED_CELLS {
        row.gate(Gate::Within(BAND_OF_LIFT));
    }
    session.row(cells, format!("{of}: lift, scatter"), scatter);
    let row = session.row(cells, format!("{of}: drag, mean"), mean(1));
    if chord >= GATED_CELLS {
        row.gate(Gate::AtMost(BAND_OF_SECTION_DRAG));
    }
    if chord == GATED_CELLS {
        let [lift, drag] = coefficients(session, chord, PLACES[0], Friction::NoSlip)?;
        session.row(cells, format!("{of}, the air sticks: lift"), lift);
        session.row(cells, format!("{of}, the air sticks: drag"), drag);
    }
    Ok(())
}

fn setup(chord: usize) -> Setup {
    let length = (BOX * chord as f64) as usize;
    Setup {
        cells: [length, ACROSS, length],
        ends: StreamwiseEnds::InletOutlet,
        inlet_profile: None,
        sides: Sides::Each([Faces::Periodic, Faces::Walls([Wall::FreeSlip; 2])]),
        relaxation_time: 0.5 + 3.0 * SPEED * chord as f64 / REYNOLDS,
        sponge_cells: Some(chord as f64),
        idle: None,
        operator: Operator::StabilisedRegularised,
        eddy_viscosity: None,
    }
}

/// C_l and C_d of the section.
fn coefficients(
    session: &mut Session,
    chord: usize,
    place: [f64; 2],
    friction: Friction,
) -> Result<[f64; 2], Stop> {
    let setup = setup(chord);
    let length = setup.cells[0] as f64;
    let refused = |what: &str| Stop::Refused(format!("the section cannot be made: {what}"));
    let outline = Profile::naca("0012")
        .map_err(|error| refused(&error.to_string()))?
        .resampled(chord * 3 / 4);
    let (sine, cosine) = ANGLE_DEG.to_radians().sin_cos();
    let chord = chord as f64;
    let placed = |x: f64, z: f64, y: f64| {
        let (x, z) = ((x - 0.25) * chord, z * chord);
        DVec3::new(
            3.0 * chord + 0.37 + place[0] + cosine * x + sine * z,
            y,
            0.5 * length - 0.31 + place[1] - sine * x + cosine * z,
        )
    };
    // The trailing edge is both ends of the outline.
    let corners = outline.len() - 1;
    let mut positions = Vec::new();
    for y in [-0.5, ACROSS as f64 - 0.5] {
        positions.extend(outline[..corners].iter().map(|p| placed(p.x, p.y, y)));
    }
    let mut triangles = Vec::new();
    for k in 0..corners {
        let [a, b] = [k, (k + 1) % corners].map(|node| node as u32);
        let [c, d] = [a, b].map(|node| node + corners as u32);
        triangles.extend([[a, c, b], [b, c, d]]);
    }
    let mut air = session.air(setup, &|_| (0.0, [SPEED, 0.0, 0.0]))?;
    air.set_inlet_velocity([SPEED, 0.0, 0.0]);
    let (count, friction) = (positions.len(), vec![friction; triangles.len()]);
    let surface = CutSurface::new(&air, triangles, count, (0, None));
    let mut surface = surface.with_friction(friction, 0.0, &positions);
    let steps = |chords: f64| (chords * chord / SPEED) as usize;
    let mut sum = DVec3::ZERO;
    let all = steps(session.size(CHORDS[0], CHORDS[1]));
    for done in 0..all {
        let force = step(session, &mut air, &mut surface, &positions)?;
        if done + steps(JUDGED) >= all {
            sum -= force;
        }
    }
    let unit = 0.5 * SPEED * SPEED * chord * ACROSS as f64 * steps(JUDGED) as f64;
    Ok([sum.z / unit, sum.x / unit])
}

/// Two planes that lie anyhow in the lattice: what flows between them goes on.
fn channel(session: &mut Session) -> Result<(), Stop> {
    let cells = [40, 20, 6];
    let (side, across) = (DVec3::new(40.0, 20.0, 0.0), DVec3::new(0.0, 0.0, 6.0));
    let along = side.normalize();
    let apart = DVec3::Z.cross(along) * CHANNEL;
    let mut positions = Vec::new();
    for from in [
        DVec3::new(-0.07, 0.11, -0.5),
        DVec3::new(-0.07, 0.11, -0.5) + apart,
    ] {
        positions.extend([from, from + side, from + side + across, from + across]);
    }
    let triangles = [[0, 1, 2], [2, 3, 0], [4, 5, 6], [6, 7, 4]];
    let drag = drags(session, cells, along, (&positions, &triangles))?;
    let momentum = SPEED * cells.iter().product::<usize>() as f64;
    let of = "channels turned by 26.6 degrees, 8 and 10 cells wide";
    session
        .row(
            cells,
            format!("{of}: share of the flow that is lost"),
            (drag[0] / momentum).abs(),
        )
        .gate(Gate::AtMost(BAND_OF_FLOW));
    session.row(
        cells,
        format!("{of}: the same where the air sticks"),
        drag[1] / momentum,
    );
    Ok(())
}

/// One step of air around a surface that stands still; its force on the air.
pub(super) fn step(
    session: &mut Session,
    air: &mut AirEngine,
    surface: &mut CutSurface,
    positions: &[DVec3],
) -> Result<DVec3, Stop> {
    let still = vec![DVec3::ZERO; positions.len()];
    session.check_interrupt()?;
    air.collide_stream(None, None)?;
    let left = |_| Stop::Refused("the surface left the air".to_owned());
    surface.find_links(positions).map_err(left)?;
    surface.read_links(air)?;
    surface.fetch_links(air, &still)?;
    surface.bounce(air, &still)?;
    session.progress_to(session.done + 1e-6 * air.grid().cell_count() as f64);
    Ok(surface.forces().map(|(_, force)| force).sum())
}
