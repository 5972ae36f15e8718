//! Markers that feel the air across their triangle alone: surfaces of a wing along which the air slides.
//!
//! The kernel gives the air the velocity of a wall over two cells on both of its sides. On panels these are boundary layers many times as thick as those
//! of a paraglider, which leave the upper side at the nose; inside, ribs would stop all air between them where a cell is less than some
//! eight cells of air wide, and the pressure before the intake would not get in. So parts of a wing with `structure.wing.tunnel.friction` = `none` hold air
//! back across themselves, and let it pass along them without friction: the reaction is K n n·(v − u*), in the fabric's implicit step as in what
//! the air gets.

use glam::DVec3;

use super::bodies::normal_of;
use super::markers::MarkerEngine;
use crate::case::Scene;
use crate::case::coupling::Friction;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::Cloth;
use crate::immersed::markers::Marker;

/// Markers of the fabric that act across their triangle alone; absent where none do.
#[derive(Debug)]
pub(super) struct Across {
    /// Numbers of the markers.
    markers: Vec<usize>,
    /// Unit normals of their triangles.
    normals: Vec<DVec3>,
    /// What the air is to move with at all markers [cells per step].
    targets: Vec<[f64; 3]>,
}

impl Across {
    /// Those of the parts of a wing in the wind that let the air slide; `count` markers are there in all, those of the fabric first.
    pub(super) fn new(scene: &Scene, fabric: &[Marker], count: usize) -> Option<Self> {
        let friction = &scene.friction.as_ref()?.fabric;
        let markers: Vec<usize> = (0..fabric.len())
            .filter(|&k| friction[fabric[k].triangle as usize] == Friction::None)
            .collect();
        (!markers.is_empty()).then(|| Self {
            normals: vec![DVec3::ZERO; markers.len()],
            markers,
            targets: vec![[0.0; 3]; count],
        })
    }

    /// Takes the normals as they are now.
    pub(super) fn turn(&mut self, cloth: &Cloth, fabric: &[Marker]) {
        for (normal, &k) in self.normals.iter_mut().zip(&self.markers) {
            let nodes = cloth.structure.triangles[fabric[k].triangle as usize].nodes;
            *normal = normal_of(nodes.map(|n| cloth.positions_m[n as usize]));
        }
    }

    /// Numbers and normals of the markers.
    pub(super) fn normals(&self) -> impl Iterator<Item = (usize, DVec3)> {
        self.markers
            .iter()
            .copied()
            .zip(self.normals.iter().copied())
    }

    /// Works out the targets of markers that are to move with `velocities` [cells per step]: along the triangles, those of the air itself.
    pub(super) fn aim(&mut self, velocities: &[[f64; 3]], immersed: &MarkerEngine) {
        self.targets.copy_from_slice(velocities);
        let air = immersed.air_velocities();
        for (&k, &normal) in self.markers.iter().zip(&self.normals) {
            let air = DVec3::from_array(air[k]);
            let slip = DVec3::from_array(velocities[k]) - air;
            self.targets[k] = (air + normal * normal.dot(slip)).to_array();
        }
    }

    /// Targets of all markers [cells per step].
    pub(super) fn targets(&self) -> &[[f64; 3]] {
        &self.targets
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("across_targets", &self.targets)?;
        out.put("across_normals", &self.normals)
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        self.targets = from.take_exactly("across_targets", self.targets.len())?;
        self.normals = from.take_exactly("across_normals", self.normals.len())?;
        Ok(())
    }
}
