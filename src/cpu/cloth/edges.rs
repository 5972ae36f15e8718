//! Edges of triangles, and who meets whom along them.

/// The neighbours of every node along the edges of triangles, and the edges of every triangle.
#[derive(Debug, Clone, Default)]
pub struct Edges {
    /// Of a triangle: between its corners 0 and 1, 1 and 2, 2 and 0.
    of_triangles: Vec<[u32; 3]>,
    count: usize,
    /// Where the neighbours of a node begin; one more at the end.
    starts: Vec<u32>,
    /// Neighbour and edge.
    neighbours: Vec<[u32; 2]>,
}

impl Edges {
    /// Of triangles among so many nodes.
    pub fn new(node_count: usize, triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let ends =
            |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
        let mut edges: Vec<[u32; 2]> = triangles.clone().flat_map(ends).collect();
        edges.sort_unstable();
        edges.dedup();
        let number = |edge| edges.binary_search(&edge).unwrap_or_default() as u32;
        let mut starts = vec![0; node_count + 1];
        for node in edges.iter().flatten() {
            starts[*node as usize + 1] += 1;
        }
        for node in 0..node_count {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![[0; 2]; 2 * edges.len()];
        for (edge, &[a, b]) in edges.iter().enumerate() {
            for (node, other) in [(a, b), (b, a)] {
                let place = &mut next[node as usize];
                neighbours[*place as usize] = [other, edge as u32];
                *place += 1;
            }
        }
        Self {
            of_triangles: triangles.map(|nodes| ends(nodes).map(number)).collect(),
            count: edges.len(),
            starts,
            neighbours,
        }
    }

    /// How many there are.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Those of a triangle.
    pub fn of_triangle(&self, triangle: u32) -> [u32; 3] {
        self.of_triangles[triangle as usize]
    }

    /// Neighbours of a node, and the edges to them.
    pub fn at(&self, node: usize) -> &[[u32; 2]] {
        &self.neighbours[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}
