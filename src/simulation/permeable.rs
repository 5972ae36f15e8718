//! Markers that air passes: what lets it, and the velocities that the air is given there ([`crate::immersed::permeable`]).
//!
//! A permeable marker hands `spread` the target V + v n in place of its own velocity V, v solved with the very K and u* that `spread`
//! takes; so the air gets exactly the opposite of what the fabric felt.

use super::bodies::BodyMarkers;
use super::markers::MarkerEngine;
use crate::case::Scene;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::Cloth;
use crate::fabric::permeability::Permeability;
use crate::immersed::kernel::SUM_OF_SQUARES;
use crate::immersed::markers::Marker;
use crate::immersed::permeable::{Permeable, Resistance};
use crate::units::Units;

/// α of a marker that nothing passes, among others that let air through; its square is finite in single precision.
const IMPERMEABLE: f64 = 1e12;

/// What every marker lets pass; absent where no surface is permeable.
#[derive(Debug)]
pub struct PermeableMarkers {
    /// r and s of every marker [lattice units]; `None` where nothing passes.
    resistances: Vec<Option<[f64; 2]>>,
    /// Present areas [cells²]: stretched fabric lets more pass.
    areas: Vec<f64>,
    /// The same at rest.
    rest_areas: Vec<f64>,
    /// Unit normals.
    normals: Vec<[f64; 3]>,
    /// What the fabric's markers let pass in the solve, SI.
    of_fabric: Vec<Permeable>,
    fabric_is_permeable: bool,
    /// V + v n [cells per step].
    targets: Vec<[f64; 3]>,
    /// Volume flow through all permeable markers, and what slip adds to it, over their area [cells per step].
    means: [f64; 2],
    /// Share of the slip that a pass leaves.
    slip_share: f64,
}

impl PermeableMarkers {
    /// Of the markers of a scene, those of the fabric first; `None` if nothing in it is permeable.
    pub(super) fn new(
        scene: &Scene,
        units: &Units,
        fabric: &[Marker],
        bodies: &[BodyMarkers],
        areas: &[f64],
        over_relaxation: f64,
    ) -> Option<Self> {
        let of_fabric = scene
            .body
            .as_ref()
            .and_then(|body| body.structure.permeability);
        let any_body = scene
            .rigid_bodies
            .iter()
            .any(|body| body.permeability.is_some());
        if of_fabric.is_none() && !any_body {
            return None;
        }
        let lattice = |permeability: Permeability| {
            [
                permeability.viscous_pa_s_m / (units.density_kg_m3 * units.speed_m_s()),
                permeability.inertial_kg_m3 / units.density_kg_m3,
            ]
        };
        let mut resistances = vec![of_fabric.map(lattice); fabric.len()];
        for (body, markers) in scene.rigid_bodies.iter().zip(bodies) {
            let count = markers.range().len();
            resistances.extend(std::iter::repeat_n(body.permeability.map(lattice), count));
        }
        Some(Self {
            resistances,
            areas: areas.to_vec(),
            rest_areas: areas.to_vec(),
            normals: vec![[0.0; 3]; areas.len()],
            of_fabric: Vec::new(),
            fabric_is_permeable: of_fabric.is_some(),
            targets: vec![[0.0; 3]; areas.len()],
            means: [0.0; 2],
            slip_share: 1.0 - SUM_OF_SQUARES * over_relaxation,
        })
    }

    /// Takes the normals of fabric and bodies, and the areas of fabric, as they are now.
    pub(super) fn turn(
        &mut self,
        cloth: Option<&Cloth>,
        markers: &[Marker],
        bodies: &[BodyMarkers],
        time_s: f64,
    ) {
        if let Some(cloth) = cloth.filter(|_| self.fabric_is_permeable) {
            for (k, marker) in markers.iter().enumerate() {
                let triangle = &cloth.structure.triangles[marker.triangle as usize];
                let [a, b, c] = triangle.nodes.map(|n| cloth.positions_m[n as usize]);
                let doubled = (b - a).cross(c - a);
                let stretch = 0.5 * doubled.length() / triangle.rest_area_m2;
                self.normals[k] = doubled.normalize_or_zero().to_array();
                self.areas[k] = stretch * self.rest_areas[k];
            }
        }
        for body in bodies {
            body.normals(time_s, &mut self.normals);
        }
    }

    fn permeable(&self, k: usize, stiffness: f64) -> Permeable {
        let resistance = match self.resistances[k] {
            Some([viscous, inertial]) => Resistance {
                viscous: viscous * self.areas[k] / stiffness,
                inertial: inertial * self.areas[k] / stiffness,
            },
            None => Resistance {
                viscous: IMPERMEABLE,
                inertial: 0.0,
            },
        };
        Permeable {
            normal: self.normals[k],
            resistance,
        }
    }

    /// What the markers of the fabric let pass, as the solve takes it; the strengths of this step must be known.
    pub(super) fn gather(&mut self, fabric: usize, immersed: &MarkerEngine, units: &Units) {
        self.of_fabric.clear();
        if !self.fabric_is_permeable {
            return;
        }
        for k in 0..fabric {
            let mut permeable = self.permeable(k, immersed.stiffness(k));
            permeable.resistance.inertial /= units.speed_m_s();
            self.of_fabric.push(permeable);
        }
    }

    /// The markers of the fabric in the solve; empty where it lets nothing pass.
    pub(super) fn of_fabric(&self) -> &[Permeable] {
        &self.of_fabric
    }

    /// Works out the targets of markers that move with `velocities` [cells per step].
    pub(super) fn aim(&mut self, velocities: &[[f64; 3]], immersed: &MarkerEngine) {
        let air = immersed.air_velocities();
        let (mut flow, mut slip_flow, mut area) = (0.0, 0.0, 0.0);
        for k in 0..velocities.len() {
            self.targets[k] = velocities[k];
            if self.resistances[k].is_none() {
                continue;
            }
            let permeable = self.permeable(k, immersed.stiffness(k));
            let through = permeable.through(velocities[k], air[k]);
            for a in 0..3 {
                self.targets[k][a] += through[a];
                flow += self.areas[k] * through[a] * permeable.normal[a];
                slip_flow += self.areas[k] * (air[k][a] - self.targets[k][a]) * permeable.normal[a];
            }
            area += self.areas[k];
        }
        self.means = [flow / area, self.slip_share * slip_flow / area];
    }

    /// V + v n of every marker [cells per step].
    pub(super) fn targets(&self) -> &[[f64; 3]] {
        &self.targets
    }

    /// Mean velocity of the air through the permeable surfaces, and what residual slip adds to it [cells per step]. The second is exact
    /// for a flat sheet and one pass.
    pub(super) const fn means(&self) -> [f64; 2] {
        self.means
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("permeable_targets", &self.targets)?;
        out.put("permeable_normals", &self.normals)?;
        out.put("permeable_means", &self.means)
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let count = self.targets.len();
        self.targets = from.take_exactly("permeable_targets", count)?;
        self.normals = from.take_exactly("permeable_normals", count)?;
        self.means
            .copy_from_slice(&from.take_exactly::<f64>("permeable_means", 2)?);
        Ok(())
    }
}
