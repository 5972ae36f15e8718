//! Which faces of a surface look at the same air.
//!
//! Around an edge the triangles follow each other by angle; between one and the next lies air that the faces towards it share. At a rim, where a triangle ends alone, the air of
//! both of its faces meets, but they count as apart: so the inside of a cell with an intake is a space of its own.

use std::collections::HashMap;

use glam::DVec3;

/// Spaces of air by triangle and face: 0 where its normal points, 1 behind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Spaces {
    of: Vec<[u32; 2]>,
    count: usize,
}

/// A triangle at an edge, seen along it from the node of the smaller number.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    triangle: u32,
    /// Angle of its half-plane.
    angle: f64,
    /// The face that looks to larger angles.
    ahead: u32,
}

impl Spaces {
    /// Of a surface with its nodes at `positions`, in any unit.
    #[must_use]
    pub fn new(triangles: &[[u32; 3]], positions: &[DVec3]) -> Self {
        let mut edges: HashMap<[u32; 2], Vec<(u32, u32, bool)>> = HashMap::new();
        for (number, nodes) in triangles.iter().enumerate() {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|j| nodes[(k + j) % 3]);
                let forwards = a < b;
                let leaf = (number as u32, c, forwards);
                edges.entry([a.min(b), a.max(b)]).or_default().push(leaf);
            }
        }
        let mut parents: Vec<u32> = (0..2 * triangles.len() as u32).collect();
        for ([from, to], leaves) in edges {
            if leaves.len() < 2 {
                continue;
            }
            let start = positions[from as usize];
            let along = (positions[to as usize] - start).normalize_or_zero();
            let first = along.any_orthonormal_vector();
            let second = along.cross(first);
            let mut around: Vec<Leaf> = (leaves.into_iter())
                .map(|(triangle, corner, forwards)| {
                    let out = positions[corner as usize] - start;
                    Leaf {
                        triangle,
                        angle: out.dot(second).atan2(out.dot(first)),
                        ahead: u32::from(!forwards),
                    }
                })
                .collect();
            around.sort_by(|a, b| (a.angle.total_cmp(&b.angle)).then(a.triangle.cmp(&b.triangle)));
            for (k, leaf) in around.iter().enumerate() {
                let next = &around[(k + 1) % around.len()];
                let own = 2 * leaf.triangle + leaf.ahead;
                let other = 2 * next.triangle + 1 - next.ahead;
                let [own, other] = [own, other].map(|face| root(&mut parents, face));
                // The smaller number stays, so that the order of edges does not matter.
                parents[own.max(other) as usize] = own.min(other);
            }
        }
        let mut numbers = vec![u32::MAX; parents.len()];
        let mut count = 0;
        let mut number = |face: u32| {
            let place = &mut numbers[root(&mut parents, face) as usize];
            if *place == u32::MAX {
                *place = count;
                count += 1;
            }
            *place
        };
        let of = (0..triangles.len() as u32)
            .map(|triangle| [number(2 * triangle), number(2 * triangle + 1)])
            .collect();
        Self {
            of,
            count: count as usize,
        }
    }

    /// The space that a face of a triangle looks at.
    #[must_use]
    pub fn of(&self, triangle: u32, face: usize) -> usize {
        self.of[triangle as usize][face] as usize
    }

    /// How many there are.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }
}

/// The number that stands for all faces that are known to share one space with this.
fn root(parents: &mut [u32], mut face: u32) -> u32 {
    while parents[face as usize] != face {
        let parent = parents[face as usize];
        parents[face as usize] = parents[parent as usize];
        face = parent;
    }
    face
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two boxes side by side with one wall between them, all triangles turned anyhow: the outside and two insides. Without one wall, one inside less.
    #[test]
    fn boxes_with_a_common_wall() {
        let place = |n: usize| DVec3::new((n % 3) as f64, (n / 3 % 2) as f64, (n / 6) as f64);
        let positions: Vec<DVec3> = (0..12).map(place).collect();
        let node = |x: u32, y: u32, z: u32| x + 3 * y + 6 * z;
        let mut quads = Vec::new();
        for x in 0..2 {
            for z in 0..2 {
                quads.push([
                    node(x, 0, z),
                    node(x + 1, 0, z),
                    node(x + 1, 1, z),
                    node(x, 1, z),
                ]);
            }
            for y in 0..2 {
                quads.push([
                    node(x, y, 0),
                    node(x, y, 1),
                    node(x + 1, y, 1),
                    node(x + 1, y, 0),
                ]);
            }
        }
        for x in 0..3 {
            quads.push([node(x, 0, 0), node(x, 1, 0), node(x, 1, 1), node(x, 0, 1)]);
        }
        let triangles = |quads: &[[u32; 4]]| -> Vec<[u32; 3]> {
            let halves = quads
                .iter()
                .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*c, *a, *d]]);
            let turned = |(k, [a, b, c]): (usize, [u32; 3])| {
                if k % 3 == 1 { [b, a, c] } else { [a, b, c] }
            };
            halves.enumerate().map(turned).collect()
        };
        let all = Spaces::new(&triangles(&quads), &positions);
        assert_eq!(all.count(), 3);
        // The wall between them looks at both insides, and an end wall at the outside and one of them.
        let [middle, end] = [9, 8].map(|quad: u32| [0, 1].map(|face| all.of(2 * quad, face)));
        let shared = middle.iter().filter(|space| end.contains(space)).count();
        assert!(middle[0] != middle[1] && end[0] != end[1] && shared == 1);
        // Open at one end: still two spaces, since a rim does not join its faces; without the wall between them, too.
        quads.remove(10);
        assert_eq!(Spaces::new(&triangles(&quads), &positions).count(), 3);
        quads.remove(9);
        assert_eq!(Spaces::new(&triangles(&quads), &positions).count(), 2);
    }
}
