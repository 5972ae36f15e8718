//! What a structure is made of, in SI units: nodes, membrane triangles, springs, cables, supports.
//!
//! Geometry modules build a [`Structure`]; engines read it. Nothing here moves.

pub mod contact;
pub mod covers;
pub mod curvature;
pub mod elements;
pub mod fabrics;
pub mod faults;
pub mod integration;
pub mod openings;
pub mod patches;
pub mod rims;
mod waves;

use glam::DVec3;

pub use elements::{Bending, CableSegment, Spring, Triangle};
pub use fabrics::{Laws, SewnFabric, TENSION_ONLY};
pub use integration::TimeIntegration;

use contact::Contact;
use openings::Opening;

use crate::fabric::membrane::Membrane;
use crate::fabric::permeability::Permeability;
use crate::frame::CableKind;
use crate::lines::drag::LineDrag;
use crate::lines::{CableLaw, CableState};

/// A spring between a node and a fixed place, with its own stiffness along each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// Guided node.
    pub node: u32,
    /// Where the guide is at rest [m].
    pub anchor_m: DVec3,
    /// Stiffness along x, y, z [N/m]; zero leaves an axis free.
    pub stiffness_n_m: DVec3,
}

/// Fabric and cables with their masses and supports.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Start positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Lumped masses [kg], `[node_count]`.
    pub masses_kg: Vec<f64>,
    /// Nodes that never move, `[node_count]`.
    pub held: Vec<bool>,
    /// Membrane triangles; without a law (`membrane` absent) they only carry area, pressure and markers.
    pub triangles: Vec<Triangle>,
    /// Law of the membrane triangles of the first fabric; absent where a spring network carries the load.
    pub membrane: Option<Membrane>,
    /// Thickness of the first fabric [m], to turn tensions into stresses.
    pub thickness_m: f64,
    /// Von Mises stress from which fabric is flagged as yielding [Pa]; `None`: never.
    pub yield_stress_pa: Option<f64>,
    /// Fabrics beside the first, in structures sewn of several; triangles name theirs by number.
    pub further_fabrics: Vec<SewnFabric>,
    /// Permeability of the fabric; `None`: no air passes.
    pub permeability: Option<Permeability>,
    /// Springs of a network.
    pub springs: Vec<Spring>,
    /// Second-difference bending terms of a network.
    pub bendings: Vec<Bending<3>>,
    /// Curvatures of membrane triangles with bending stiffness.
    pub curvatures: Vec<Bending<6>>,
    /// Cable segments.
    pub cables: Vec<CableSegment>,
    /// Laws of the cables, by the numbers that segments hold.
    pub cable_laws: Vec<CableLaw>,
    /// Lateral guides.
    pub guides: Vec<Guide>,
    /// That fabric meets itself; `None`: it passes through itself.
    pub contact: Option<Contact>,
    /// Openings that the fabric is built with.
    pub openings: Vec<Opening>,
    /// Forces that pull nodes and stay as they are [N], `[node_count]`; empty: none.
    pub loads_n: Vec<DVec3>,
    /// Velocities at the start [m/s], `[node_count]`; empty: it starts from rest.
    pub start_velocities_m_s: Vec<DVec3>,
}

impl Structure {
    /// Number of nodes.
    #[must_use]
    pub const fn node_count(&self) -> usize {
        self.positions_m.len()
    }

    /// Adds a free node [m] without mass, and returns its number.
    pub fn add_node(&mut self, place_m: DVec3) -> u32 {
        self.positions_m.push(place_m);
        self.masses_kg.push(0.0);
        self.held.push(false);
        self.node_count() as u32 - 1
    }

    /// Adds a cable through `nodes` with the given rest lengths, and its mass to the nodes.
    pub fn add_cable(
        &mut self,
        nodes: &[u32],
        rest_lengths_m: &[f64],
        cable: &crate::lines::Cable,
        kind: CableKind,
    ) {
        let known = self.cable_laws.iter().position(|law| *law == cable.law);
        let law = known.unwrap_or_else(|| {
            self.cable_laws.push(cable.law.clone());
            self.cable_laws.len() - 1
        }) as u32;
        for (pair, &rest_length_m) in nodes.windows(2).zip(rest_lengths_m) {
            let half = 0.5 * cable.mass_per_length_kg_m() * rest_length_m;
            for &node in pair {
                self.masses_kg[node as usize] += half;
            }
            self.cables.push(CableSegment {
                nodes: [pair[0], pair[1]],
                rest_length_m,
                law,
                damping_n_s: cable.damping_n_s,
                breaking_load_n: cable.breaking_load_n,
                drag: None,
                kind,
            });
        }
    }

    /// Gives suspension lines the drag that `of` tells of each, by its number among all cables. Belts, which lie on the fabric, have none, nor have risers of
    /// parachutes, which are short.
    pub fn give_lines_drag(&mut self, of: impl Fn(usize) -> LineDrag) {
        for (number, cable) in self.cables.iter_mut().enumerate() {
            if cable.kind == CableKind::SuspensionLine {
                cable.drag = Some(of(number));
            }
        }
    }

    /// True if lines feel the wind.
    #[must_use]
    pub fn has_line_drag(&self) -> bool {
        self.cables.iter().any(|cable| cable.drag.is_some())
    }

    /// Adds fabric of another structure, which has only triangles, beside this one; fabrics keep their numbers.
    pub fn add_beside(&mut self, other: Self) {
        let first = self.node_count() as u32;
        self.positions_m.extend(other.positions_m);
        self.masses_kg.extend(other.masses_kg);
        self.held.extend(other.held);
        for mut triangle in other.triangles {
            triangle.nodes = triangle.nodes.map(|node| node + first);
            self.triangles.push(triangle);
        }
    }

    /// State of a cable segment at a length [m], without its damping.
    #[must_use]
    pub fn cable_state(&self, cable: &CableSegment, length_m: f64) -> CableState {
        self.cable_laws[cable.law as usize].at(length_m / cable.rest_length_m - 1.0)
    }

    /// Shortest rest length of an edge or a cable segment [m]; zero without any.
    #[must_use]
    pub fn smallest_element_m(&self) -> f64 {
        let edges = self.triangles.iter().flat_map(|t| t.rest_squares_m2);
        let cables = self
            .cables
            .iter()
            .map(|c| c.rest_length_m * c.rest_length_m);
        let smallest = edges.chain(cables).fold(f64::INFINITY, f64::min).sqrt();
        if smallest.is_finite() { smallest } else { 0.0 }
    }

    /// Rest area of all triangles [m²].
    #[must_use]
    pub fn rest_area_m2(&self) -> f64 {
        self.triangles.iter().map(|t| t.rest_area_m2).sum()
    }

    /// Bytes held by the host's engine for this structure, vectors of the minimiser (`history` pairs) and multigrid included. A sheet of
    /// 1000² cells took 0.97 of it with springs, 0.94 to 0.99 as a tension-only membrane.
    #[must_use]
    pub fn estimated_bytes(&self, history: usize) -> u64 {
        let [nodes, triangles, springs, bendings] = [
            self.node_count(),
            self.triangles.len(),
            self.springs.len(),
            self.bendings.len(),
        ];
        // Vectors in single and double precision, and what every level of multigrid keeps of a node.
        let of_nodes = nodes * (12 * (3 * history + 8) + 24 * 8 + 300);
        // Beside the elements, what they pull with, how stiff they are, and where they meet.
        let of_elements = triangles * (size_of::<Triangle>() + 290)
            + springs * (size_of::<Spring>() + 16)
            + bendings * (size_of::<Bending<3>>() + 12)
            + self.curvatures.len() * (size_of::<Bending<6>>() + 24)
            + self.cables.len() * (size_of::<CableSegment>() + 16);
        // Pairs with room around the thickness, and boxes of the grid; folded fabric has many.
        let of_contact = match self.contact {
            Some(_) => triangles * 2_000,
            None => 0,
        };
        // Blocks of the stiffness matrix and their columns; the coarser levels add two fifths.
        let blocks = nodes + (3 * triangles).max(2 * springs) + 2 * bendings;
        (of_nodes + of_elements + of_contact + blocks * 56) as u64
    }
}

impl Structure {
    /// True of a structure of membranes all of which are tension-only.
    #[must_use]
    pub fn is_tension_only(&self) -> bool {
        self.laws()
            .is_some_and(|laws| laws.all().all(|law| law.residual() < TENSION_ONLY))
    }

    /// Laws of the triangles; `None` where they have none.
    #[inline]
    #[must_use]
    pub fn laws(&self) -> Option<Laws<'_>> {
        Some(Laws {
            first: self.membrane.as_ref()?,
            further: &self.further_fabrics,
        })
    }

    /// Thickness of the fabric of a triangle [m].
    #[must_use]
    pub fn thickness_of_m(&self, triangle: &Triangle) -> f64 {
        match (triangle.fabric as usize).checked_sub(1) {
            None => self.thickness_m,
            Some(further) => self.further_fabrics[further].thickness_m,
        }
    }
}
