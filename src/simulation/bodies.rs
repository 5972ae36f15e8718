//! Rigid bodies among the markers: where theirs are, and what the air does to each body.

use std::ops::Range;

use glam::DVec3;

use crate::case::Scene;
use crate::case::scene::RigidBody;
use crate::immersed::folds::Folds;
use crate::immersed::markers::{self, Marker};
use crate::rigid::PrescribedMotion;
use crate::units::Units;

/// Normal of a marker's triangle before a body moves.
pub(super) fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The faces that bodies pass through; `None` where none does.
pub(super) fn folds(scene: &Scene) -> Option<Folds> {
    let mut folds = Folds::default();
    for face in scene.rigid_bodies.iter().flat_map(|body| &body.faces) {
        match face.axis {
            0 => folds.outlet = true,
            axis => folds.sides[axis - 1][usize::from(face.upper)] = true,
        }
    }
    scene.passes_through_a_face().then_some(folds)
}

/// A body's markers.
#[derive(Debug)]
pub struct BodyMarkers {
    motion: PrescribedMotion,
    /// Places before the body moves [m].
    points_m: Vec<DVec3>,
    moment_point_m: DVec3,
    /// Normals before the body moves.
    normals: Vec<DVec3>,
    /// Where they are among all markers.
    range: Range<usize>,
}

/// Force of the air on a body, and its moment about the body's moment point [lattice units], of one step; or their sums.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    /// Force.
    pub force: [f64; 3],
    /// Moment.
    pub moment: [f64; 3],
}

impl Load {
    /// Adds another.
    pub fn add(&mut self, other: &Self) {
        for a in 0..3 {
            self.force[a] += other.force[a];
            self.moment[a] += other.moment[a];
        }
    }
}

impl BodyMarkers {
    /// Markers of all bodies, at most `spacing_m` apart on a triangle and numbered from `first`, and their areas [m²].
    pub(super) fn place_all(
        scene: &Scene,
        spacing_m: f64,
        mut first: usize,
    ) -> (Vec<Self>, Vec<f64>) {
        let mut areas_m2 = Vec::new();
        let bodies = scene
            .rigid_bodies
            .iter()
            .map(|body| {
                let placed = markers::place(body.marker_surface.extents(), spacing_m);
                areas_m2.extend(placed.iter().map(|marker| marker.area_m2));
                let points_m: Vec<DVec3> =
                    placed.iter().map(|marker| point_m(body, marker)).collect();
                let range = first..first + points_m.len();
                let normal = |marker: &Marker| {
                    let nodes = body.marker_surface.triangles[marker.triangle as usize];
                    normal_of(body.marker_surface.corners(nodes))
                };
                let normals = placed.iter().map(normal).collect();
                first = range.end;
                Self {
                    motion: body.motion.clone(),
                    points_m,
                    moment_point_m: body.moment_point_m,
                    normals,
                    range,
                }
            })
            .collect();
        (bodies, areas_m2)
    }

    /// Where the markers of this body are among all.
    pub(super) fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// Normals at `time_s`.
    pub(super) fn normals(&self, time_s: f64, all: &mut [[f64; 3]]) {
        let placement = self.motion.at(time_s);
        let points = self.points_m.iter().zip(&self.normals);
        for (normal, (&point, &before)) in all[self.range.clone()].iter_mut().zip(points) {
            let turned = placement.position_m(point + before) - placement.position_m(point);
            *normal = turned.normalize_or_zero().to_array();
        }
    }

    /// Their positions at `time_s` [cells].
    pub(super) fn positions(&self, time_s: f64, units: &Units, all: &mut [[f64; 3]]) {
        let placement = self.motion.at(time_s);
        for (position, &point) in all[self.range.clone()].iter_mut().zip(&self.points_m) {
            *position = units.position_to_lattice(placement.position_m(point));
        }
    }

    /// Their velocities at `time_s` [cells per step].
    pub(super) fn velocities(&self, time_s: f64, units: &Units, all: &mut [[f64; 3]]) {
        let placement = self.motion.at(time_s);
        for (velocity, &point) in all[self.range.clone()].iter_mut().zip(&self.points_m) {
            *velocity = units.velocity_to_lattice(placement.velocity_m_s(point));
        }
    }

    /// Opposite of the forces on the air, `force(marker)`, of markers at `positions`, spread at `time_s`.
    pub(super) fn load(
        &self,
        time_s: f64,
        units: &Units,
        positions: &[[f64; 3]],
        force: impl Fn(usize) -> [f64; 3],
    ) -> Load {
        let placement = self.motion.at(time_s);
        let point = units.position_to_lattice(placement.position_m(self.moment_point_m));
        let mut load = Load::default();
        for k in self.range.clone() {
            let g = DVec3::from_array(force(k));
            let arm = DVec3::from_array(positions[k]) - DVec3::from_array(point);
            load.add(&Load {
                force: (-g).to_array(),
                moment: (-arm.cross(g)).to_array(),
            });
        }
        load
    }
}

fn point_m(body: &RigidBody, marker: &Marker) -> DVec3 {
    let corners = body
        .marker_surface
        .corners(body.marker_surface.triangles[marker.triangle as usize]);
    corners
        .iter()
        .zip(marker.weights)
        .map(|(corner, weight)| *corner * weight)
        .sum()
}

/// Momentum of the air inside a body, which moves with it [kg·m/s]; zero for open surfaces.
pub(super) fn inner_momentum(body: &RigidBody, density_kg_m3: f64, time_s: f64) -> DVec3 {
    body.volume_m3.map_or(DVec3::ZERO, |(volume, centroid)| {
        body.motion.at(time_s).velocity_m_s(centroid) * (density_kg_m3 * volume)
    })
}
