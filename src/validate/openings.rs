//! Openings in an impermeable wall, from wide ones down to a cell, whose markers stand inside their rims.
//!
//! A plate with a square hole of a third of the width stands across a duct that repeats along all axes (a grid of openings, a ninth of the
//! area open). A uniform force per mass drives the air along x: force times length is the pressure difference in the mean, whatever the
//! scheme does. The discharge coefficient C_d = v/√(2Δp/ρ) of the mean velocity v in the hole is compared with that of sharp-edged thin grids
//! (Idelchik, Handbook of Hydraulic Resistance, diagram 8-1: Δp = ½ρv² (0.707 √(1 − f) + 1 − f)² at high Reynolds numbers, f the open share).
//!
//! A marker closes the air within some two cells, so that a hole of four cells with markers up to its rim passes less than half of what it
//! should. With the inset of rims, which was calibrated with a disk's drag and not with holes, and the wider one of narrow openings
//! ([`markers::opening_inset_cells`]), holes of one to six cells pass the right amount. Wider ones pass more, as rounded holes do: the kernel
//! smooths the edge that the jet would leave, and narrows it less.

use super::{Gate, Session, Stop, periodic, states};
use crate::immersed::markers;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::simulation::MarkerEngine;

/// Widths of the duct per width of the hole; the duct is four of its own widths long. Twice that changes nothing by more than 1 %.
const WIDTHS: f64 = 3.0;

/// Widths of the hole [cells].
const WIDTHS_CELLS: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 6.0];

/// Speed in the hole that the force is chosen for [cells per step].
const SPEED: f64 = 0.06;

/// Largest distance of markers [cells].
const SPACING: f64 = 0.6;

/// Where the plate is, in widths of the duct; and where the hole begins, in cells of the duct, between two of the lattice.
const PLATE: f64 = 0.523;
const OFFSETS: [f64; 2] = [0.13, 0.6];

/// Largest relative error of the coefficient.
const BAND: f64 = 0.15;

/// The hole of a single cell, whose coefficient depends on where between cells it lies.
const BAND_OF_ONE_CELL: f64 = 0.2;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let open = WIDTHS.powi(-2);
    let exact = 1.0 / (0.707 * (1.0 - open).sqrt() + 1.0 - open);
    let [widths, offsets] = session.size([4, 1], [WIDTHS_CELLS.len(), OFFSETS.len()]);
    for width in &WIDTHS_CELLS[..widths] {
        let width = *width;
        for offset in &OFFSETS[..offsets] {
            let inset = markers::opening_inset_cells(width);
            let (cells, coefficient) = discharge(session, width, inset, *offset, exact)?;
            session
                .row(
                    cells,
                    format!("hole of {width} cells at {offset}: discharge coefficient"),
                    coefficient,
                )
                .reference(exact, "Idelchik, diagram 8-1")
                .gate(Gate::Within(if width > 1.0 {
                    BAND
                } else {
                    BAND_OF_ONE_CELL
                }));
        }
    }
    let mut shown = vec![(4.0, 0.0, "markers up to the rim")];
    if session.size(false, true) {
        shown.push((12.0, markers::RIM_INSET_CELLS, "resolved"));
    }
    for (width, inset, what) in shown {
        let (cells, coefficient) = discharge(session, width, inset, OFFSETS[0], exact)?;
        session
            .row(
                cells,
                format!("hole of {width} cells, {what}: discharge coefficient"),
                coefficient,
            )
            .reference(exact, "Idelchik, diagram 8-1");
    }
    Ok(())
}

/// Middles of equal parts of `from..to`, no longer than [`SPACING`], and their length.
fn parts(from: f64, to: f64) -> (Vec<f64>, f64) {
    let count = ((to - from) / SPACING).ceil();
    let length = (to - from) / count;
    let middles = (0..count as usize).map(|i| from + (i as f64 + 0.5) * length);
    (middles.collect(), length)
}

/// Cells, and v/√(2Δp/ρ) in the mean, with markers `inset` inside the plate.
fn discharge(
    session: &mut Session,
    width: f64,
    inset: f64,
    offset: f64,
    wanted: f64,
) -> Result<([usize; 3], f64), Stop> {
    let open = WIDTHS.powi(-2);
    // A duct is never narrower than a kernel.
    let holes = if width < 2.0 { 2 } else { 1 };
    let pitch = WIDTHS * width;
    let side = (pitch * f64::from(holes)).round() as usize;
    let cells = [4 * side, side, side];
    let pressure = 0.5 * (SPEED / wanted).powi(2);
    let mut setup = periodic(cells, 0.5 + 3e-4, Operator::RecursiveRegularised);
    setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.15));
    let mut air = session.air(setup, &|_| (0.0, [SPEED * open, 0.0, 0.0]))?;
    let (mut positions, mut areas) = (Vec::new(), Vec::new());
    let gap = width + 2.0 * inset;
    let (solid, solid_length) = parts(gap, pitch);
    let (hole, hole_length) = parts(0.0, gap);
    let strips = || {
        let solid = solid.iter().map(|&at| (at, solid_length, true));
        solid.chain(hole.iter().map(|&at| (at, hole_length, false)))
    };
    let place = |at: f64, hole: i32| (at + offset + pitch * f64::from(hole)) % side as f64 - 0.5;
    for (k, l) in (0..holes).flat_map(|k| (0..holes).map(move |l| (k, l))) {
        for (z, height, beside) in strips() {
            for (y, breadth, above) in strips() {
                if beside || above {
                    positions.push([PLATE * side as f64, place(y, k), place(z, l)]);
                    areas.push(breadth * height);
                }
            }
        }
    }
    let mut markers = MarkerEngine::new(&air, areas, 1.6)?;
    let at_rest = vec![[0.0; 3]; positions.len()];
    let acceleration = Some([pressure / cells[0] as f64, 0.0, 0.0]);
    // The jet goes around so many times; the mean is taken over the second half.
    let steps = (session.size(12.0, 30.0) * cells[0] as f64 / SPEED) as usize;
    let left = |_| Stop::Refused("the plate left the duct".to_owned());
    let (mut sum, mut samples) = (0.0, 0.0);
    for step in 0..steps {
        markers.send_markers(&air, &positions)?.map_err(left)?;
        markers.interpolate(&air, &positions)?.map_err(left)?;
        markers.fetch_air_velocities()?;
        markers.send_marker_forces(&at_rest);
        markers.spread(&at_rest);
        air.collide_stream(acceleration, Some(&markers))?;
        if step.is_multiple_of(64) {
            session.check_interrupt()?;
            if 2 * step >= steps {
                let states = states(&air)?;
                let momentum: f64 = states.iter().map(|(excess, u)| (1.0 + excess) * u[0]).sum();
                sum += momentum / states.len() as f64;
                samples += 1.0;
            }
        }
    }
    session.progress_to(session.done + 1e-6 * (steps * cells.iter().product::<usize>()) as f64);
    Ok((cells, sum / samples / open / (2.0 * pressure).sqrt()))
}
