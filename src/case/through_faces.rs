//! Rigid bodies that pass through faces of the box of air: half models, mounts, stings.

use glam::DVec3;

use super::air::{Air, Flow};
use super::problem::Problem;
use crate::immersed::kernel::WIDTH;
use crate::lattice::grid::{Faces, Sides};
use crate::rigid::{BoxFace, Surface};

/// How far a body keeps from faces that it does not pass through, and how far it reaches beyond those which it does [cells]: the reach of the kernel.
pub(super) const REACH_CELLS: f64 = 0.5 * WIDTH as f64;

/// Frontal area over the area of a surface below which it stands along the wind.
const ALONG_THE_WIND: f64 = 1e-6;

/// A body as far as it matters here.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passing<'a> {
    /// The key of its place.
    pub key: &'a str,
    /// Its name.
    pub name: &'a str,
    /// It is a mesh from a file.
    pub from_file: bool,
    /// It is held.
    pub held: bool,
    /// The box of the air falls.
    pub falls: bool,
}

/// What of a body lies in the box of air.
#[derive(Debug, Clone)]
pub(super) struct Inside {
    /// The faces that it passes through; empty if all of it lies inside.
    pub faces: Vec<BoxFace>,
    /// Its surface.
    pub surface: Surface,
    /// The surface that markers stand on.
    pub marker_surface: Surface,
    /// Frontal area inside over that of the whole; of surfaces along the wind the same of areas.
    pub frontal_share: f64,
    /// Volume and its centroid, if the whole is closed [m³, m].
    pub volume_m3: (f64, DVec3),
}

/// Takes what lies in the box of a body's surface and of the one that markers stand on; refuses bodies that may not pass where they do.
pub(super) fn inside(
    body: Passing,
    surface: Surface,
    marker_surface: Surface,
    air: &Air,
) -> Result<Inside, Problem> {
    let faces = passed(body, &surface, air)?;
    if faces.is_empty() {
        let (volume, centroid) = surface.volume_m3();
        return Ok(Inside {
            faces,
            surface,
            marker_surface,
            frontal_share: 1.0,
            volume_m3: (volume.abs(), centroid),
        });
    }
    let size_m = air.box_m();
    let part = surface.before(&faces, size_m);
    let marker_part = marker_surface.before(&faces, size_m);
    if marker_part.triangles.is_empty() {
        return Err(nothing_inside(body, &surface));
    }
    let [frontal, frontal_whole] = [&part, &surface].map(Surface::frontal_area_m2);
    let [area, area_whole] = [&part, &surface].map(Surface::area_m2);
    let along_the_wind = frontal_whole < ALONG_THE_WIND * area_whole;
    Ok(Inside {
        frontal_share: if along_the_wind {
            area / area_whole
        } else {
            frontal / frontal_whole
        },
        volume_m3: part.volume_before_m3(size_m.x),
        faces,
        surface: part,
        marker_surface: marker_part,
    })
}

fn nothing_inside(body: Passing, whole: &Surface) -> Problem {
    let (low, high) = whole.bounds_m();
    let size = high - low;
    Problem::new(
        body.key,
        format!(
            "nothing of the surface of the body `{}` lies in the box of air; it is {:.4} × {:.4} × {:.4} m large",
            body.name, size.x, size.y, size.z
        ),
        if body.from_file {
            "move the body (of one that passes through a face the part inside counts), or give the unit of its file (mesh.scale)"
        } else {
            "move the body; of one that passes through a face the part inside counts"
        },
    )
}

/// The faces that a body with this whole surface passes through.
fn passed(body: Passing, surface: &Surface, air: &Air) -> Result<Vec<BoxFace>, Problem> {
    let size_m = air.box_m();
    let reach_m = REACH_CELLS * air.units.cell_size_m;
    let least_m = |surface: &Surface, face: BoxFace| {
        let places = surface.positions_m.iter();
        places
            .map(|&place| face.depth_m(place, size_m))
            .fold(f64::INFINITY, f64::min)
    };
    let mut faces = BoxFace::ALL.to_vec();
    faces.retain(|&face| least_m(surface, face) <= -reach_m);
    if faces.is_empty() {
        return Ok(faces);
    }
    let part = surface.before(&faces, size_m);
    if part.triangles.is_empty() {
        return Err(nothing_inside(body, surface));
    }
    // What lies outside may cross the planes of other faces.
    faces.retain(|&face| least_m(&part, face) < 0.5 * reach_m);
    let refused = faces
        .iter()
        .find_map(|&face| Some((face, refusal(body, face, air)?)));
    match refused {
        None => Ok(faces),
        Some((face, why)) => Err(Problem::new(
            body.key,
            format!(
                "the body `{}` passes through {}, {why}",
                body.name,
                face.name()
            ),
            "a held body of a wind tunnel may pass through the outlet, and through sides that are \"absorbing\", \"frictionless\", \"symmetry\" or \
             \"no_slip\"; else move the body, or enlarge air.wind_tunnel.size_m",
        )),
    }
}

/// Why a body may not pass through a face.
fn refusal(body: Passing, face: BoxFace, air: &Air) -> Option<&'static str> {
    let repeats = match air.flow {
        Flow::WindTunnel {
            sides: Sides::Each(sides),
            ..
        } if face.axis > 0 => sides[face.axis - 1] == Faces::Periodic,
        Flow::WindTunnel {
            sides: Sides::FreeSlip,
            ..
        } => false,
        _ => face.axis > 0,
    };
    if face == BoxFace::INLET {
        Some("where the wind comes in")
    } else if repeats {
        Some("which is periodic: what leaves there would have to come in at the other side")
    } else if !body.held {
        Some("but moves")
    } else if body.falls {
        Some("but the box of [air.descent] falls, and with it all that stands beside it")
    } else {
        None
    }
}
