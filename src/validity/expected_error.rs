//! The error to be expected of a lattice and a box before a run: parts that were measured one by one on spheres at Reynolds number 100, disks
//! and the shipped canopy (docs/results/2026-11-23-expected-error.md), read off by interpolation.

use super::subject::{Kind, Subject, subjects};
use crate::case::Scene;
use crate::measure::flow_past_bodies::{disk_drag, sphere_drag};
use crate::output::ExpectedError;

/// What cells and the ends of the box add to the drag, measured one by one.
struct Ladders {
    /// Cells across the body.
    cells: &'static [[f64; 2]],
    /// Distance from the inlet to the middle [diameters].
    inlet: &'static [[f64; 2]],
    /// Distance from the middle to the sponge [diameters].
    sponge: &'static [[f64; 2]],
}

/// A sphere at Reynolds number 100.
const CLOSED: Ladders = Ladders {
    cells: &[
        [3.0, 0.75],
        [4.0, 0.82],
        [6.0, 0.234],
        [8.0, 0.069],
        [12.0, 0.0124],
        [16.0, 0.0037],
        [24.0, 0.0007],
    ],
    inlet: &[
        [0.8, 0.957],
        [1.2, 0.267],
        [2.0, 0.0534],
        [3.0, 0.0112],
        [5.0, 0.0007],
    ],
    sponge: &[
        [-1.0, 2.15],
        [-0.5, 1.09],
        [0.0, 0.866],
        [0.5, 0.186],
        [1.0, 0.069],
        [2.0, 0.0141],
        [4.0, 0.0008],
    ],
};

/// A disk across the stream at Reynolds number 1000; from 6 cells on its drag keeps within 3 %.
const FLAT: Ladders = Ladders {
    cells: &[[4.0, 0.18], [6.0, 0.03], [24.0, 0.03]],
    inlet: &[
        [0.8, 0.583],
        [1.2, 0.226],
        [2.0, 0.0573],
        [3.0, 0.0131],
        [5.0, 0.0008],
    ],
    sponge: &[
        [-1.0, 2.32],
        [-0.5, 1.16],
        [0.0, 0.871],
        [0.5, 0.256],
        [1.0, 0.109],
        [2.0, 0.0214],
        [4.0, 0.0002],
    ],
};

/// What cells add to the drag of a sphere and of a disk at Reynolds number 100 whose surfaces cut links (docs/results/2026-11-30-bodies-at-cut-links.md): nothing is
/// calibrated there. All are means over places between the cells.
const CLOSED_AT_LINKS: &[[f64; 2]] = &[
    [4.0, 0.32],
    [6.0, 0.158],
    [8.0, 0.079],
    [12.0, 0.027],
    [16.0, 0.011],
    [24.0, 0.004],
];
const FLAT_AT_LINKS: &[[f64; 2]] = &[
    [4.0, 0.29],
    [6.0, 0.196],
    [8.0, 0.118],
    [12.0, 0.052],
    [16.0, 0.05],
    [24.0, 0.032],
    [48.0, 0.026],
];

/// What an outlet without a sponge may do to the drag at a distance of one diameter.
const OUTLET: f64 = 0.03;

/// Walls add this times the drag coefficient and a power of the blockage to the drag of spheres and disks.
const WALLS: [f64; 2] = [11.0, 1.7];

/// Drag coefficient of a sphere in the range of Newton's law, and of flat bodies.
const OF_A_SPHERE: f64 = 0.45;
const OF_A_FLAT_BODY: f64 = 1.1;

/// Drag coefficient that walls act on.
fn drag_coefficient(of: &Subject) -> f64 {
    match of.kind {
        Kind::Round => sphere_drag(of.reynolds()).unwrap_or(OF_A_SPHERE),
        _ => disk_drag(of.reynolds()).unwrap_or(OF_A_FLAT_BODY),
    }
}

/// Walls add this times the blockage by the nominal area to the drag of a canopy: K C_D of Macha & Buffington 1990 with C_D = 0.8.
const WALLS_OF_CANOPIES: f64 = 1.85 * 0.8;

/// Over the cells across D_0: what they add to the mean drag of a canopy.
const CELLS_OF_CANOPIES: f64 = 1.2;

/// What is missing of the lift over the angle, seen at 24 cells per chord alone, and the cells up to which nothing better was seen.
const LIFT: f64 = -0.68;
const LIFT_CELLS: f64 = 48.0;

/// Logarithms of both, between two points and on beyond the first and the last as between the nearest two.
fn interpolated(points: &[[f64; 2]], at: f64, log_places: bool) -> f64 {
    let place = |x: f64| if log_places { x.ln() } else { x };
    let next = points.partition_point(|point| point[0] < at);
    let next = next.clamp(1, points.len() - 1);
    let ([x0, y0], [x1, y1]) = (points[next - 1], points[next]);
    let share = (place(at) - place(x0)) / (place(x1) - place(x0));
    y0 * (y1 / y0).powf(share)
}

/// The largest part that a forecast names: beyond it only "wrong" is known.
const LARGEST: f64 = 3.0;

fn parts_of_drag(of: &Subject) -> Vec<(String, f64)> {
    let mut parts = Vec::new();
    let mut part =
        |name: &str, share: f64| parts.push((name.to_owned(), share.clamp(-1.0, LARGEST)));
    let ladders = if of.thickness_m.is_some() {
        &CLOSED
    } else {
        &FLAT
    };
    if of.kind == Kind::Canopy {
        part("cells", CELLS_OF_CANOPIES / of.cells());
        part("walls", WALLS_OF_CANOPIES * of.blockage());
    } else {
        let of_cells = match (of.cuts_links(), of.thickness_m) {
            (true, Some(_)) => CLOSED_AT_LINKS,
            (true, None) if of.is_flat() => FLAT_AT_LINKS,
            _ => ladders.cells,
        };
        let cells = of.cells().max(of_cells[0][0]);
        part("cells", interpolated(of_cells, cells, true));
        let walls = WALLS[0] * drag_coefficient(of) * of.blockage().powf(WALLS[1]);
        part("walls", walls);
    }
    part("inlet", interpolated(ladders.inlet, of.inlet(), false));
    if of.sponge() {
        part("sponge", interpolated(ladders.sponge, of.outlet(), false));
    } else if of.outlet() < 1.0 {
        part("outlet", OUTLET);
    }
    parts
}

/// Least Reynolds number of the ladders.
const LEAST_REYNOLDS: f64 = 30.0;

/// What is to be expected of the means of a case, beforehand; empty where nothing is known.
#[must_use]
pub fn expected_errors(scene: &Scene) -> Vec<ExpectedError> {
    let subjects = subjects(scene);
    let of_subject = |of: &Subject| {
        // All was measured on bodies that keep off the faces, at Reynolds numbers from 30 on.
        if of.passes_through_a_face() || of.reynolds() < LEAST_REYNOLDS {
            return None;
        }
        let (quantity, parts) = match of.kind {
            Kind::Canopy | Kind::Round | Kind::Rigid if of.held && of.is_bluff() => {
                ("mean drag", parts_of_drag(of))
            }
            Kind::Wing if of.cells() <= LIFT_CELLS && !of.cuts_links() => (
                "lift over the angle",
                vec![("trailing edge within the kernel".to_owned(), LIFT)],
            ),
            _ => return None,
        };
        let quantity = if of.name.is_empty() {
            quantity.to_owned()
        } else {
            format!("{}: {quantity}", of.name)
        };
        Some(ExpectedError {
            quantity,
            total: parts.iter().map(|(_, part)| part).sum(),
            parts,
        })
    };
    subjects.iter().filter_map(of_subject).collect()
}
