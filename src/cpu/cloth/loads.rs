//! What acts on a structure during a step, and where the step starts.

use glam::{DMat3, DVec3};

use super::pressure::{self, Pressure};
use super::triangle_reaction::TriangleReaction;
use crate::cloth::{Structure, TimeIntegration};
use crate::immersed::permeable::Permeable;

/// One marker as the cloth feels it.
#[derive(Debug, Clone, Copy)]
pub struct MarkerReaction {
    /// Triangle it sits on.
    pub triangle: u32,
    /// Barycentric weights.
    pub weights: [f64; 3],
    /// Immersed-boundary stiffness K [kg/s].
    pub stiffness_kg_s: f64,
    /// Velocity u* of the air at the marker [m/s].
    pub air_velocity_m_s: DVec3,
    /// Unit normal along which alone the air pulls; `None`: along all axes.
    pub across: Option<DVec3>,
}

impl MarkerReaction {
    /// The part of a velocity that the air feels.
    #[must_use]
    pub fn felt(&self, velocity: DVec3) -> DVec3 {
        self.across
            .map_or(velocity, |normal| normal * normal.dot(velocity))
    }

    /// The same as a matrix.
    #[must_use]
    pub fn projection(&self) -> DMat3 {
        self.across.map_or(DMat3::IDENTITY, |n| {
            DMat3::from_cols(n * n.x, n * n.y, n * n.z)
        })
    }
}

/// Drag of the air on one node, linear in its velocity during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodalDrag {
    /// The node.
    pub node: u32,
    /// Force per velocity c [kg/s], ½ ρ C_D A |u − v| with the velocities at the start of the step.
    pub coefficient_kg_s: f64,
    /// Velocity u of the air [m/s].
    pub air_velocity_m_s: DVec3,
}

/// What acts during one step.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepInput<'a> {
    /// Time step [s]; `None` asks for the static equilibrium.
    pub time_step_s: Option<f64>,
    /// How motion is integrated; without meaning in the static limit.
    pub integration: TimeIntegration,
    /// Gravity [m/s²].
    pub gravity_m_s2: DVec3,
    /// Pressure jumps along the triangle normals; those at the start of a time step, turning with the fabric in the static limit.
    pub pressure: Pressure<'a>,
    /// Mass-proportional damping β [1/s].
    pub damping_1_s: f64,
    /// Markers; empty without air.
    pub markers: &'a [MarkerReaction],
    /// What the same markers let pass, SI; empty where no air passes the fabric.
    pub permeable: &'a [Permeable],
    /// What the air does to triangles that cut its lattice; empty where markers stand for them.
    pub cut_triangles: &'a [TriangleReaction],
    /// Drag of single nodes, c (u − v) with the velocity v at the end of the step; empty in the static limit.
    pub drags: &'a [NodalDrag],
    /// Held nodes that are moved: where each is at the end of the step [m].
    pub moved_supports: &'a [(u32, DVec3)],
    /// Further loads that do not change with the fabric [N], `[node_count]`; empty: none.
    pub nodal_loads_n: &'a [DVec3],
}

impl StepInput<'_> {
    /// The markers with what they let pass; nothing where no air passes the fabric.
    pub fn permeable_markers(&self) -> impl Iterator<Item = (&MarkerReaction, &Permeable)> {
        self.markers.iter().zip(self.permeable)
    }

    /// The markers that no air passes; none where the fabric is permeable.
    #[must_use]
    pub const fn impermeable_markers(&self) -> &[MarkerReaction] {
        if self.permeable.is_empty() {
            self.markers
        } else {
            &[]
        }
    }

    /// True if pressure turns with the fabric until both stand still, within one solve or from solve to solve.
    #[must_use]
    pub fn pressure_follows(&self) -> bool {
        self.time_step_s.is_none() && !self.pressure.is_none()
    }
}

/// Gravity, loads of single nodes and further nodal loads [N], `[node_count]`.
#[must_use]
pub fn dead_loads(structure: &Structure, input: &StepInput) -> Vec<DVec3> {
    let masses = structure.masses_kg.iter();
    let mut loads: Vec<DVec3> = masses.map(|&mass| input.gravity_m_s2 * mass).collect();
    for further in [&structure.loads_n[..], input.nodal_loads_n] {
        for (load, further) in loads.iter_mut().zip(further) {
            *load += *further;
        }
    }
    loads
}

/// Loads that do not change during a step [N], `[node_count]`: gravity, and in a time step pressure on the positions at its start.
#[must_use]
pub fn step_loads(structure: &Structure, start: &[DVec3], input: &StepInput) -> Vec<DVec3> {
    let mut loads = dead_loads(structure, input);
    let staying = if input.pressure_follows() {
        input.pressure.lagged()
    } else {
        input.pressure
    };
    pressure::add_forces(structure, start, staying, &mut loads);
    loads
}

/// Adds to `loads` the pull of the air on a sheet at rest [N].
pub fn add_pull_of_the_air(structure: &Structure, input: &StepInput, loads: &mut [DVec3]) {
    for (marker, permeable) in input.permeable_markers() {
        let nodes = structure.triangles[marker.triangle as usize].nodes;
        let air = marker.air_velocity_m_s;
        let through = DVec3::from_array(permeable.through([0.0; 3], air.to_array()));
        for (node, weight) in nodes.into_iter().zip(marker.weights) {
            loads[node as usize] += (air - through) * (marker.stiffness_kg_s * weight);
        }
    }
    for drag in input.drags {
        loads[drag.node as usize] += drag.air_velocity_m_s * drag.coefficient_kg_s;
    }
    for marker in input.impermeable_markers() {
        let nodes = structure.triangles[marker.triangle as usize].nodes;
        for (node, weight) in nodes.into_iter().zip(marker.weights) {
            let pull = marker.felt(marker.air_velocity_m_s) * marker.stiffness_kg_s;
            loads[node as usize] += pull * weight;
        }
    }
    for reaction in input.cut_triangles {
        let nodes = structure.triangles[reaction.triangle as usize].nodes;
        for (node, pull) in nodes.into_iter().zip(reaction.pull_n) {
            loads[node as usize] += pull;
        }
    }
}
