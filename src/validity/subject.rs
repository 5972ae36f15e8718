//! What stands in the air: canopy, wing, sheet, plate or rigid body, with the lengths that its results depend on.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::case::Scene;
use crate::case::coupling::{Friction, Scheme};
use crate::case::scene::{Air, BodyKind, Flow, RigidBody, Shape};
use crate::cloth::openings::OpeningKind;
use crate::geometry::plate::Plate;
use crate::geometry::wing::section::Side;
use crate::measure::flow_past_bodies;
use crate::measure::plate::{lesser_side_m, lies_along};

/// Projected diameter of an inflated canopy over its nominal one.
pub const INFLATED: f64 = 0.7;

/// Reynolds number of the length at which the boundary layer along a flat plate turns turbulent.
const TURBULENT_REYNOLDS: f64 = 5e5;

/// Places along a chord at which its thickness is looked for.
const LOOKS: u32 = 50;

/// Distance from the surface of another body up to which a point lies on it [cells]: triangles of two shapes at one place differ by some hundredths.
const ON_A_SURFACE: f64 = 0.1;

/// Cosine between the stream and the normal of a plate or disk, above which its wake is that of one across the stream: 45°.
const ACROSS_THE_STREAM: f64 = 0.7;

/// Kinds of what stands in the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A parachute canopy.
    Canopy,
    /// A ram-air wing.
    Wing,
    /// A plate or a sheet of fabric.
    Sheet,
    /// A rigid body whose wake separates where its surface curves.
    Round,
    /// Another rigid body.
    Rigid,
}

/// One of them.
#[derive(Debug, Clone)]
pub struct Subject<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The air.
    pub air: &'a Air,
    /// The rigid body, if it is one.
    pub body: Option<&'a RigidBody>,
    /// Its name; empty for the fabric.
    pub name: String,
    /// Beginning of the names of its results.
    pub prefix: String,
    /// What it is.
    pub kind: Kind,
    /// Nominal diameter, largest chord, length, or diameter [m].
    pub length_m: f64,
    /// Diameter across the stream that displaces the air [m].
    pub across_m: f64,
    /// Frontal or nominal area [m²].
    pub area_m2: f64,
    /// Corners of the box around it at the start [m].
    pub corners_m: [DVec3; 2],
    /// Lower and upper faces of the box along x, y and z that it passes through by intent.
    pub passed: [[bool; 2]; 3],
    /// Thickness, if it has an inside: of a body the median over its surface, of a wing of fabric the largest at its root [m].
    pub thickness_m: Option<f64>,
    /// Narrowest hole that air is meant to pass [m].
    pub hole_m: Option<f64>,
    /// Narrowest gap or slot that air is meant to pass [m].
    pub slot_m: Option<f64>,
    /// Diameter of a canopy's mouth at release [m].
    pub mouth_m: Option<f64>,
    /// Held in the stream.
    pub held: bool,
    /// Speed of a rigid body that moves: that to which its coefficients refer, or its fastest point's [m/s].
    pub own_speed_m_s: Option<f64>,
    /// How long a rigid body takes to settle and to be averaged, from t = 0 [s].
    pub settling_s: Option<f64>,
}

/// Corners of the box around points [m].
fn corners(points: &[DVec3]) -> [DVec3; 2] {
    let all = points.iter().copied();
    [
        all.clone().fold(DVec3::INFINITY, DVec3::min),
        all.fold(DVec3::NEG_INFINITY, DVec3::max),
    ]
}

/// What stands in the air of a tunnel or a fall.
pub fn subjects(scene: &Scene) -> Vec<Subject<'_>> {
    let Some(air) = scene.air.as_ref() else {
        return Vec::new();
    };
    if !matches!(air.flow, Flow::WindTunnel { .. }) {
        return Vec::new();
    }
    let mut found: Vec<Subject> = fabric(scene, air).into_iter().collect();
    let several = scene.body.is_some() || scene.rigid_bodies.len() > 1;
    found.extend(scene.rigid_bodies.iter().map(|body| {
        let prefix = flow_past_bodies::prefix(scene, body);
        let subject = rigid(scene, air, body, prefix);
        Subject {
            name: if several {
                body.name.clone()
            } else {
                String::new()
            },
            ..subject
        }
    }));
    found
}

/// Part of a unit vector along an axis from which on a plate stands across the faces there.
const STANDS: f64 = 0.5;

/// How near its held edge is to a face that a plate stands on [cells]: the kernel's width.
const FOOT_CELLS: f64 = 4.0;

/// Faces of the box along y and z that a sheet reaches with an edge, or that a plate stands on.
fn faces_met(air: &Air, plate: Option<&Plate>, [low, high]: [DVec3; 2]) -> [[bool; 2]; 3] {
    let cell_m = air.units.cell_size_m;
    let mut met = [[false; 2]; 3];
    for axis in [1_usize, 2] {
        let box_m = air.cells[axis] as f64 * cell_m;
        // What lies along a face has no edge there.
        let has_edges = plate.is_none_or(|plate| plate.normal()[axis].abs() < STANDS);
        let feet_m = plate.map_or([f64::INFINITY; 2], |plate| {
            let foot_m = plate.held_edge_m[axis];
            let up = plate.along[axis];
            [(up > STANDS, foot_m), (up < -STANDS, box_m - foot_m)]
                .map(|(stands, gap_m)| if stands { gap_m } else { f64::INFINITY })
        });
        let gaps_m = [low[axis], box_m - high[axis]];
        met[axis] = [0, 1].map(|side| {
            (has_edges && gaps_m[side] <= cell_m) || feet_m[side] <= FOOT_CELLS * cell_m
        });
    }
    met
}

fn fabric<'a>(scene: &'a Scene, air: &'a Air) -> Option<Subject<'a>> {
    let body = scene.body.as_ref()?;
    let positions = &body.structure.positions_m;
    let narrowest_m = |is_hole: bool| {
        let openings = body.structure.openings.iter();
        openings
            .filter(|opening| opening.width_m > 0.0 && opening.kind != OpeningKind::RibHole)
            .filter(|opening| (opening.kind == OpeningKind::Vent) == is_hole)
            .map(|opening| opening.width_m)
            .min_by(f64::total_cmp)
    };
    let rest = Subject {
        scene,
        air,
        body: None,
        name: String::new(),
        prefix: String::new(),
        kind: Kind::Sheet,
        length_m: 0.0,
        across_m: 0.0,
        area_m2: 0.0,
        corners_m: corners(positions),
        passed: [[false; 2]; 3],
        thickness_m: None,
        hole_m: narrowest_m(true),
        slot_m: narrowest_m(false),
        mouth_m: None,
        held: scene.descent.is_none(),
        own_speed_m_s: None,
        settling_s: None,
    };
    Some(match &body.kind {
        BodyKind::Canopy(canopy) => Subject {
            kind: Kind::Canopy,
            length_m: canopy.nominal_diameter_m,
            across_m: INFLATED * canopy.nominal_diameter_m,
            area_m2: canopy.nominal_area_m2,
            corners_m: corners(&positions[..canopy.canopy_node_count]),
            mouth_m: Some(body.released_diameter_ratio(canopy) * canopy.nominal_diameter_m),
            ..rest
        },
        BodyKind::Wing(_) => {
            let plan = &scene.wing()?.plan;
            let chords = plan.stations.iter().map(|station| station.chord_m);
            let chord_m = chords.fold(0.0, f64::max);
            let root = plan.stations.first()?;
            let profile = plan.profiles.get(root.profile)?;
            let heights = (0..=LOOKS).map(|look| {
                let x = f64::from(look) / f64::from(LOOKS);
                profile.height(Side::Upper, x) - profile.height(Side::Lower, x)
            });
            let thickness = heights.fold(0.0, f64::max);
            let area: f64 = plan
                .stations
                .windows(2)
                .map(|pair| (pair[0].chord_m + pair[1].chord_m) * (pair[1].span_m - pair[0].span_m))
                .sum();
            Subject {
                kind: Kind::Wing,
                length_m: chord_m,
                across_m: thickness * chord_m,
                area_m2: thickness * area,
                thickness_m: Some(thickness * root.chord_m),
                ..rest
            }
        }
        BodyKind::Plate(plate) => {
            // What stands across the stream.
            let across = [
                plate.along * plate.size_m[0],
                plate.across * plate.size_m[1],
            ];
            Subject {
                length_m: plate.size_m[0],
                across_m: across
                    .map(|side| side.reject_from(DVec3::X).length())
                    .into_iter()
                    .fold(0.0, f64::max),
                area_m2: across[0].cross(across[1]).x.abs(),
                passed: faces_met(air, Some(plate), rest.corners_m),
                ..rest
            }
        }
        BodyKind::Sheet | BodyKind::Mesh => {
            let size = rest.corners_m[1] - rest.corners_m[0];
            let length_m = size.max_element();
            Subject {
                length_m,
                across_m: size.y.max(size.z),
                area_m2: size.y * size.z,
                passed: faces_met(air, None, rest.corners_m),
                ..rest
            }
        }
        _ => return None,
    })
}

fn rigid<'a>(scene: &'a Scene, air: &'a Air, body: &'a RigidBody, prefix: String) -> Subject<'a> {
    let corners_m = corners(&body.surface.positions_m);
    let mut size = corners_m[1] - corners_m[0];
    let mut passed = [[false; 2]; 3];
    for face in &body.faces {
        passed[face.axis][usize::from(face.upper)] = true;
        // It goes on beyond the face.
        size[face.axis] = f64::INFINITY;
    }
    let kind = match body.shape {
        Shape::Sphere { .. } | Shape::Cylinder { .. } => Kind::Round,
        _ => Kind::Rigid,
    };
    let settling = flow_past_bodies::settling(scene, air, body).ok();
    // A length that coefficients refer to may be any.
    let own_m = size.y.max(size.z);
    let [length_m, across_m] = match body.shape {
        Shape::Mesh if own_m.is_finite() => [own_m.min(body.reference_length_m), own_m],
        _ => [body.reference_length_m; 2],
    };
    Subject {
        scene,
        air,
        body: Some(body),
        name: String::new(),
        prefix,
        kind,
        length_m,
        across_m,
        area_m2: body.blocking_area_m2,
        corners_m,
        passed,
        thickness_m: body
            .volume_m3
            .map(|_| {
                let across_m = body.surface.thickness_m().unwrap_or(f64::INFINITY);
                across_m.min(size.min_element())
            })
            .filter(|thickness_m| thickness_m.is_finite()),
        hole_m: None,
        slot_m: None,
        mouth_m: None,
        held: !body.motion.moves() && scene.descent.is_none(),
        own_speed_m_s: (body.motion.moves())
            .then(|| body.reference_speed_m_s(air).max(body.fastest_m_s)),
        settling_s: settling.map(|settling| {
            let [begin, least] = settling.times();
            settling.risen_s.max(0.0) + (begin + least) * settling.unit_s
        }),
    }
}

impl Subject<'_> {
    /// Size of a cell [m].
    pub const fn cell_m(&self) -> f64 {
        self.air.units.cell_size_m
    }

    /// Length over a cell.
    pub fn cells(&self) -> f64 {
        self.length_m / self.cell_m()
    }

    /// True of a rigid disk or plate without thickness.
    pub fn is_flat(&self) -> bool {
        let shape = self.body.map(|body| &body.shape);
        matches!(shape, Some(Shape::Disk { .. } | Shape::Plate { .. }))
    }

    /// True where it cuts links of the lattice, in place of markers.
    pub fn cuts_links(&self) -> bool {
        let coupling = self.scene.coupling;
        coupling.is_some_and(|coupling| coupling.scheme == Scheme::Links)
    }

    /// Cells over the thickness: of a rigid body that cuts `links`, or of all others.
    pub fn thickness_cells(&self, links: bool) -> Option<f64> {
        let cuts = self.body.is_some() && self.cuts_links();
        let thickness_m = self.thickness_m.filter(|_| cuts == links)?;
        Some(thickness_m / self.cell_m())
    }

    /// True for a rigid wing.
    pub fn is_closed_wing(&self) -> bool {
        self.body
            .is_some_and(|body| matches!(body.shape, Shape::Wing { .. }))
    }

    /// True for what the forecast of the drag was measured on: all but rigid wings, and plates and disks that lie along the stream.
    pub fn is_bluff(&self) -> bool {
        let Some(body) = self.body else {
            return true;
        };
        match body.shape {
            Shape::Wing { .. } => false,
            Shape::Disk { .. } | Shape::Plate { .. } => body.normal.x.abs() > ACROSS_THE_STREAM,
            Shape::Sphere { .. } | Shape::Cylinder { .. } | Shape::Mesh => true,
        }
    }

    /// Cells across the narrowest hole.
    pub fn hole_cells(&self) -> Option<f64> {
        self.hole_m.map(|width_m| width_m / self.cell_m())
    }

    /// Cells across the narrowest gap or slot.
    pub fn slot_cells(&self) -> Option<f64> {
        self.slot_m.map(|width_m| width_m / self.cell_m())
    }

    /// Size of the box of air along an axis [m].
    pub fn box_m(&self, axis: usize) -> f64 {
        self.air.cells[axis] as f64 * self.cell_m()
    }

    /// Area over the section of the box.
    pub fn blockage(&self) -> f64 {
        self.area_m2 / self.section_m2()
    }

    /// The same of a rigid body by its frontal area, of a plate across the stream by all of its area.
    pub fn blockage_of_a_body(&self) -> Option<f64> {
        match self.kind {
            Kind::Round | Kind::Rigid => Some(self.blockage()),
            Kind::Sheet => {
                let across = self.scene.plate().filter(|plate| !lies_along(plate))?;
                Some(across.area_m2() / self.section_m2())
            }
            Kind::Canopy | Kind::Wing => None,
        }
    }

    fn section_m2(&self) -> f64 {
        self.box_m(1) * self.box_m(2)
    }

    /// Middle along the wind [m].
    pub fn middle_m(&self) -> f64 {
        0.5 * (self.corners_m[0].x + self.corners_m[1].x)
    }

    /// From the inlet to the middle [diameters across the stream].
    pub fn inlet(&self) -> f64 {
        self.middle_m() / self.across_m
    }

    fn sponge_m(&self) -> Option<f64> {
        match self.air.flow {
            Flow::WindTunnel {
                sponge_length_m, ..
            } => sponge_length_m,
            Flow::TaylorGreen { .. } => None,
        }
    }

    /// Whether a sponge stands before the outlet.
    pub fn sponge(&self) -> bool {
        self.sponge_m().is_some()
    }

    /// From the middle to the sponge, or to the outlet where there is none [diameters across the stream].
    pub fn outlet(&self) -> f64 {
        let sponge_m = self.sponge_m().unwrap_or(0.0);
        (self.box_m(0) - sponge_m - self.middle_m()) / self.across_m
    }

    /// From the nearest side wall that it does not pass through, or stand on, to the body [diameters across the stream]; `None` if there is no such wall.
    /// Of a sheet it is in its larger extent.
    pub fn wall(&self) -> Option<f64> {
        let [low, high] = self.corners_m;
        let gaps = [1, 2].into_iter().flat_map(|axis| {
            let gaps = [low[axis], self.box_m(axis) - high[axis]];
            gaps.into_iter().zip(self.passed[axis])
        });
        let kept = gaps.filter(|(_, passed)| !passed).map(|(gap, _)| gap);
        let unit_m = match self.kind {
            // It swings.
            Kind::Sheet => self.length_m.max(self.across_m),
            _ => self.across_m,
        };
        kept.min_by(f64::total_cmp).map(|gap| gap / unit_m)
    }

    /// Time from t = 0 to the end: of a sheet, or a plate that lies `along` the stream, in L/U; of a plate across it in b/U, with its lesser side b.
    /// `None` of what is not asked for.
    pub fn length_of_run(&self, along: bool) -> Option<f64> {
        let wind = matches!(self.air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0);
        let across = self.scene.plate().filter(|plate| !lies_along(plate));
        if self.kind != Kind::Sheet || !wind || !self.held || along == across.is_some() {
            return None;
        }
        let unit_m = across.map_or(self.length_m, lesser_side_m);
        Some(self.scene.time.as_ref()?.end_s * self.speed_m_s() / unit_m)
    }

    /// True if it passes through a face of the box.
    pub fn passes_through_a_face(&self) -> bool {
        self.passed.iter().flatten().any(|passed| *passed)
    }

    /// Largest share of a rigid body's surface that lies inside another one, or on it, at the start. `None` where the box around it meets no other's.
    pub fn overlap(&self) -> Option<f64> {
        let body = self.body?;
        let bodies = &self.scene.rigid_bodies;
        if bodies.len() < 2 {
            return None;
        }
        let at_the_start = |body: &RigidBody| {
            let placement = body.motion.at(0.0);
            let mut surface = body.surface.clone();
            for place_m in &mut surface.positions_m {
                *place_m = placement.position_m(*place_m);
            }
            surface
        };
        let own = at_the_start(body);
        let near_m = ON_A_SURFACE * self.cell_m();
        let shares = bodies
            .iter()
            .filter(|other| other.name != body.name)
            .filter_map(|other| {
                let has_inside = other.volume_m3.is_some();
                own.share_within(&at_the_start(other), has_inside, &other.faces, near_m)
            });
        shares.reduce(f64::max)
    }

    /// Speed of the wind, of the fall at release, or of a body that moves [m/s].
    pub fn speed_m_s(&self) -> f64 {
        self.own_speed_m_s
            .unwrap_or_else(|| self.air.wind_or_reference_m_s())
    }

    /// Reynolds number of the length.
    pub fn reynolds(&self) -> f64 {
        self.speed_m_s() * self.length_m / self.air.kinematic_viscosity_m2_s
    }

    /// Mean free path of the lattice's gas over the length: √(π/2) Ma/Re.
    pub fn knudsen(&self) -> f64 {
        let mach = self.speed_m_s() / self.air.units.speed_m_s() * 3f64.sqrt();
        FRAC_PI_2.sqrt() * mach / self.reynolds()
    }

    /// Thickness of the boundary layer at the end of a flat plate as long as a canopy's D_0 [m], laminar (Blasius) or turbulent (Prandtl). There is one where the air
    /// sticks to fabric that cuts links.
    pub fn boundary_layer_m(&self) -> Option<f64> {
        let friction = self.scene.friction.as_ref()?;
        let sticks = friction.fabric.iter().all(|own| *own == Friction::NoSlip);
        let reynolds = self.reynolds();
        let share = if reynolds < TURBULENT_REYNOLDS {
            5.0 / reynolds.sqrt()
        } else {
            0.37 / reynolds.powf(0.2)
        };
        (self.kind == Kind::Canopy && self.cuts_links() && sticks).then_some(share * self.length_m)
    }

    /// Dynamic pressure of the wind [Pa].
    pub fn dynamic_pressure_pa(&self) -> f64 {
        0.5 * self.air.units.density_kg_m3 * self.speed_m_s().powi(2)
    }
}
