//! How triangles hang together: edges, pieces, borders, sides.

/// A triangle at an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// Nodes of the edge, the smaller first.
    pub nodes: [u32; 2],
    /// Number of the triangle.
    pub triangle: u32,
    /// True if the triangle runs from the smaller node to the larger.
    pub is_forward: bool,
}

/// Edges of a mesh, in the order of their nodes.
pub(super) struct Edges {
    uses: Vec<Use>,
}

impl Edges {
    /// Edges of those triangles that count; what begins and ends at one node is none.
    pub fn new(triangles: &[[u32; 3]], counts: impl Fn(usize) -> bool) -> Self {
        let mut uses = Vec::with_capacity(3 * triangles.len());
        for (number, &[a, b, c]) in triangles.iter().enumerate() {
            if counts(number) {
                for [from, to] in [[a, b], [b, c], [c, a]] {
                    if from != to {
                        uses.push(Use {
                            nodes: [from.min(to), from.max(to)],
                            triangle: number as u32,
                            is_forward: from < to,
                        });
                    }
                }
            }
        }
        uses.sort_unstable();
        Self { uses }
    }

    /// Triangles at each edge.
    pub fn iter(&self) -> impl Iterator<Item = &[Use]> {
        self.uses.chunk_by(|a, b| a.nodes == b.nodes)
    }

    /// Edges of one triangle alone.
    pub fn borders(&self) -> Vec<[u32; 2]> {
        let alone = self.iter().filter(|uses| uses.len() == 1);
        alone.map(|uses| uses[0].nodes).collect()
    }
}

/// Border edges joined to lines: the nodes of each, the first of a closed one again at its end.
pub(super) fn chains(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut at: Vec<(u32, usize)> = Vec::with_capacity(2 * edges.len());
    for (number, nodes) in edges.iter().enumerate() {
        at.extend(nodes.map(|node| (node, number)));
    }
    at.sort_unstable();
    let mut used = vec![false; edges.len()];
    let mut chains = Vec::new();
    for start in 0..edges.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let [first, mut last] = edges[start];
        let mut chain = vec![first, last];
        while last != first {
            let from = at.partition_point(|(node, _)| *node < last);
            let next = at[from..]
                .iter()
                .take_while(|(node, _)| *node == last)
                .find(|(_, number)| !used[*number]);
            let Some(&(_, number)) = next else { break };
            used[number] = true;
            let [a, b] = edges[number];
            last = if a == last { b } else { a };
            chain.push(last);
        }
        chains.push(chain);
    }
    chains
}

/// Triangles that run against their neighbours.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Turned {
    /// The smaller part, by area, of each patch with two sides.
    pub triangles: Vec<u32>,
    /// Edges at which no turning helps, as on a Möbius strip.
    pub edges: Vec<[u32; 2]>,
}

/// Looks for triangles that run against their neighbours; patches end at borders and where more than two triangles meet.
pub(super) fn turned(edges: &Edges, areas_m2: &[f64]) -> Turned {
    let count = areas_m2.len();
    let mut neighbours: Vec<(u32, u32, bool)> = Vec::new();
    for uses in edges.iter() {
        if let [a, b] = uses {
            let alike = a.is_forward != b.is_forward;
            neighbours.push((a.triangle, b.triangle, alike));
            neighbours.push((b.triangle, a.triangle, alike));
        }
    }
    neighbours.sort_unstable();
    let mut sides: Vec<Option<bool>> = vec![None; count];
    let mut found = Turned::default();
    for start in 0..count {
        if sides[start].is_some() {
            continue;
        }
        sides[start] = Some(true);
        let mut patch = vec![start as u32];
        let mut next = 0;
        while let Some(&triangle) = patch.get(next) {
            next += 1;
            let side = sides[triangle as usize] == Some(true);
            let from = neighbours.partition_point(|(own, _, _)| *own < triangle);
            let around = neighbours[from..]
                .iter()
                .take_while(|(own, _, _)| *own == triangle);
            for &(_, other, alike) in around {
                if sides[other as usize].is_none() {
                    sides[other as usize] = Some(side == alike);
                    patch.push(other);
                }
            }
        }
        let area = |side: bool| -> f64 {
            let triangles = patch.iter().map(|t| *t as usize);
            let of_side = triangles.filter(|t| sides[*t] == Some(side));
            of_side.map(|t| areas_m2[t]).sum()
        };
        let smaller = Some(area(true) < area(false));
        let triangles = patch.iter().copied();
        let of_smaller = triangles.filter(|t| sides[*t as usize] == smaller);
        found.triangles.extend(of_smaller);
    }
    for uses in edges.iter() {
        if let [a, b] = uses {
            let [first, second] = [a, b].map(|edge| sides[edge.triangle as usize]);
            if (first == second) != (a.is_forward != b.is_forward) {
                found.edges.push(a.nodes);
            }
        }
    }
    found.triangles.sort_unstable();
    found
}

/// True for triangles with the same three nodes as an earlier one.
pub(super) fn repeated(triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut keys: Vec<([u32; 3], usize)> = triangles
        .iter()
        .enumerate()
        .map(|(number, nodes)| {
            let mut nodes = *nodes;
            nodes.sort_unstable();
            (nodes, number)
        })
        .collect();
    keys.sort_unstable();
    let mut is_repeated = vec![false; triangles.len()];
    for pair in keys.windows(2) {
        is_repeated[pair[1].1] = pair[0].0 == pair[1].0;
    }
    is_repeated
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_has_one_border_and_a_turned_triangle_is_found() {
        let mut triangles = vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
        let edges = Edges::new(&triangles, |_| true);
        assert_eq!(edges.iter().count(), 9);
        let chains = chains(&edges.borders());
        assert_eq!(chains.len(), 1);
        assert_eq!(chains[0].len(), 7);
        assert_eq!(turned(&edges, &[1.0; 4]), Turned::default());
        triangles[2].swap(0, 1);
        let edges = Edges::new(&triangles, |_| true);
        let expected = Turned {
            triangles: vec![2],
            edges: Vec::new(),
        };
        assert_eq!(turned(&edges, &[1.0; 4]), expected);
    }

    /// Five triangles around with an odd number of turns.
    #[test]
    fn a_moebius_strip_has_no_sides() {
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]];
        let edges = Edges::new(&triangles, |_| true);
        assert_eq!(turned(&edges, &[1.0; 5]).edges.len(), 1);
        assert_eq!(chains(&edges.borders()).len(), 1);
    }
}
