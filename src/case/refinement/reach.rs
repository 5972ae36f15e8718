//! Where what stands in the air can come.

use glam::DVec3;

use super::written::{Corners, KEPT_CELLS};
use crate::case::bodies::RigidBody;
use crate::case::body::{Body, BodyKind};

/// Of a round canopy, in nominal diameters: half its width laid out flat, and the height of its inflated crown over the skirt, at most.
const FLAT_RADIUS: f64 = 0.5;
const CROWN_HEIGHT: f64 = 0.45;

/// How far an unguided canopy swings to the side, in lengths of its lines.
const SWING: f64 = 0.5;

/// What a held plate sweeps, in its lengths.
const PLATE_REACH: f64 = 1.05;

/// Instants at which the way of a rigid body is looked at.
const LOOKS: u32 = 200;

/// What stands in the air.
#[derive(Debug, Clone, Copy)]
pub(super) struct Standing {
    /// A nominal diameter, a chord, the length of a plate, or the largest extent of a body [m].
    pub length_m: f64,
    /// Corners of all that feels the air, at the start and on ways that are known [m].
    pub start: Corners,
    /// Corners of all places to which it can come [m].
    pub reach: Corners,
    /// Finest cells between it and the faces of its box, at least.
    pub kept_cells: usize,
}

const EMPTY: Corners = (DVec3::INFINITY, DVec3::NEG_INFINITY);

fn joined(a: Corners, b: Corners) -> Corners {
    (a.0.min(b.0), a.1.max(b.1))
}

fn corners(places: impl Iterator<Item = DVec3>) -> Corners {
    places.fold(EMPTY, |all, place| joined(all, (place, place)))
}

impl Standing {
    /// Fabric and bodies of a scene that ends at `end_s`; `None` without any.
    pub fn of(body: Option<&Body>, bodies: &[RigidBody], end_s: f64) -> Option<Self> {
        let mut all: Option<Self> = None;
        let rigid = bodies.iter().map(|body| of_rigid(body, end_s));
        for one in body.and_then(of_fabric).into_iter().chain(rigid) {
            all = Some(match all {
                None => one,
                Some(before) => Self {
                    length_m: before.length_m.max(one.length_m),
                    start: joined(before.start, one.start),
                    reach: joined(before.reach, one.reach),
                    ..before
                },
            });
        }
        all
    }

    /// Its middle [m].
    pub fn middle_m(&self) -> DVec3 {
        0.5 * (self.start.0 + self.start.1)
    }
}

fn of_fabric(body: &Body) -> Option<Standing> {
    let structure = &body.structure;
    let places = &structure.positions_m;
    let fabric = structure.triangles.iter().flat_map(|t| t.nodes);
    let start = corners(fabric.map(|node| places[node as usize]));
    if !start.0.is_finite() {
        return None;
    }
    let extent_m = (start.1 - start.0).max_element();
    let (length_m, reach) = match &body.kind {
        BodyKind::Canopy(canopy) => {
            let diameter = canopy.nominal_diameter_m;
            let confluence = canopy.confluence_m(places);
            // Lines as they are drawn, the shortest and the longest.
            let skirt = places[..canopy.canopy_node_count].iter();
            let line = skirt
                .map(|p| p.distance(confluence))
                .fold(f64::INFINITY, f64::min);
            let flat = FLAT_RADIUS * diameter;
            // What no guide keeps on the axis leaves it.
            let swing = if structure.guides.is_empty() {
                SWING * line
            } else {
                0.0
            };
            let radius = flat + swing;
            let nearest = (line.powi(2) - radius.powi(2)).max(0.0).sqrt();
            let low = confluence + DVec3::new(nearest, -radius, -radius);
            let high = confluence + DVec3::new(line + CROWN_HEIGHT * diameter, radius, radius);
            (diameter, (low, high))
        }
        BodyKind::Plate(plate) => {
            let held = places.iter().zip(&structure.held);
            let held = corners(held.filter(|(_, held)| **held).map(|(place, _)| *place));
            let length = plate.size_m[0];
            let around = DVec3::splat(PLATE_REACH * length);
            // Against the wind it does not stand.
            let low = held.0 - around.with_x(0.3 * length);
            (length, (low, held.1 + around))
        }
        BodyKind::Wing(wing) => (wing.built.measures.largest_chord_m, EMPTY),
        _ => (extent_m, EMPTY),
    };
    Some(Standing {
        length_m,
        start,
        reach: joined(start, reach),
        kept_cells: KEPT_CELLS,
    })
}

fn of_rigid(body: &RigidBody, end_s: f64) -> Standing {
    let (low, high) = body.surface.bounds_m();
    let looks_s = body.motion.looks_s(end_s, LOOKS);
    let way = looks_s
        .map(|time_s| body.motion.at(time_s))
        .fold(EMPTY, |way, placement| {
            let points = body.surface.positions_m.iter();
            joined(
                way,
                corners(points.map(|point| placement.position_m(*point))),
            )
        });
    Standing {
        length_m: (high - low).max_element(),
        start: way,
        reach: way,
        kept_cells: KEPT_CELLS,
    }
}
