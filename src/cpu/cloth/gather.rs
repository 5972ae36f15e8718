//! Which elements meet at every node, so that nodes can be worked on in parallel: each adds up its own share, always in the same order.

use std::sync::{Arc, OnceLock};

use super::edges::Edges;
use super::membrane_lanes::MembraneLanes;
use crate::cloth::Structure;

/// Corners of elements at every node: `element · CORNERS + corner`, ascending.
#[derive(Debug, Clone, Default)]
pub struct Corners<const CORNERS: usize> {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl<const CORNERS: usize> Corners<CORNERS> {
    fn new(node_count: usize, elements: impl Iterator<Item = [u32; CORNERS]> + Clone) -> Self {
        let mut starts = vec![0u32; node_count + 1];
        for node in elements.clone().flatten() {
            starts[node as usize + 1] += 1;
        }
        for i in 0..node_count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; starts[node_count] as usize];
        for (place, node) in elements.flatten().enumerate() {
            let slot = &mut next[node as usize];
            entries[*slot as usize] = place as u32;
            *slot += 1;
        }
        Self { starts, entries }
    }

    /// `element · CORNERS + corner` at a node.
    #[inline]
    pub fn places(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        // Most structures lack some kinds of elements; their starts need not be read.
        let range = if self.entries.is_empty() {
            0..0
        } else {
            self.starts[node] as usize..self.starts[node + 1] as usize
        };
        self.entries[range].iter().map(|&entry| entry as usize)
    }

    /// (element, corner) at a node.
    #[inline]
    pub fn at(&self, node: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.places(node)
            .map(|place| (place / CORNERS, place % CORNERS))
    }
}

/// All elements of a structure.
#[derive(Debug, Clone, Default)]
pub struct Gather {
    /// Of membrane triangles.
    pub triangles: Corners<3>,
    /// Of springs.
    pub springs: Corners<2>,
    /// Of bending terms.
    pub bendings: Corners<3>,
    /// Of curvatures.
    pub curvatures: Corners<6>,
    /// Of cable segments.
    pub cables: Corners<2>,
    /// Of guides.
    pub guides: Corners<1>,
    /// Membrane triangles, made ready for the lanes of vectors.
    pub membrane: MembraneLanes,
    /// Edges of triangles, found when the fabric first cuts the lattice.
    edges: OnceLock<Arc<Edges>>,
}

impl Gather {
    /// Looks all elements up.
    #[must_use]
    pub fn new(structure: &Structure) -> Self {
        let count = structure.node_count();
        Self {
            triangles: Corners::new(count, structure.triangles.iter().map(|t| t.nodes)),
            springs: Corners::new(count, structure.springs.iter().map(|s| s.nodes)),
            bendings: Corners::new(count, structure.bendings.iter().map(|b| b.nodes)),
            curvatures: Corners::new(count, structure.curvatures.iter().map(|b| b.nodes)),
            cables: Corners::new(count, structure.cables.iter().map(|c| c.nodes)),
            guides: Corners::new(count, structure.guides.iter().map(|g| [g.node])),
            membrane: MembraneLanes::new(structure),
            edges: OnceLock::new(),
        }
    }

    /// Edges of the triangles of the structure that this was made of.
    pub(super) fn edges(&self, structure: &Structure) -> Arc<Edges> {
        let triangles = structure.triangles.iter().map(|t| t.nodes);
        let edges = self
            .edges
            .get_or_init(|| Arc::new(Edges::new(structure.node_count(), triangles)));
        Arc::clone(edges)
    }
}
