//! Which faces of a surface look at the same air.
//!
//! Around an edge the triangles follow each other by angle; between one and the next lies air that the faces towards it share. At a rim, where a triangle ends alone, the air goes round
//! from one of its faces to the other. They share it, too, but no boundary layer goes on there. Where the surface ends with the air, or at a side that repeats, it does not.

use std::collections::HashMap;

use glam::DVec3;

use crate::sets::Sets;

/// Spaces of air by face.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Spaces {
    of: Vec<u32>,
    count: usize,
    /// Of every face, twice the triangle's number plus its own: the face that follows it around the edge from node k to the next.
    beside: Vec<[Option<u32>; 3]>,
}

/// A triangle at an edge: its number, which of its edges that is, its third node, and whether it follows the edge from the node of the smaller number.
type Corner = (u32, usize, u32, bool);

/// A triangle at an edge, seen along it from the node of the smaller number.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    triangle: u32,
    /// Which of its edges this is.
    edge: usize,
    /// Angle of its half-plane.
    angle: f64,
    /// The face that looks to larger angles.
    ahead: u32,
}

impl Spaces {
    /// Of a surface with its nodes at `positions`, in any unit; `rim` tells by the middle of an edge of one triangle if the air goes round there.
    #[must_use]
    pub fn new(triangles: &[[u32; 3]], positions: &[DVec3], rim: impl Fn(DVec3) -> bool) -> Self {
        let mut edges: HashMap<[u32; 2], Vec<Corner>> = HashMap::new();
        for (number, nodes) in triangles.iter().enumerate() {
            for k in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|j| nodes[(k + j) % 3]);
                let forwards = a < b;
                let leaf = (number as u32, k, c, forwards);
                edges.entry([a.min(b), a.max(b)]).or_default().push(leaf);
            }
        }
        let faces = 2 * triangles.len();
        let mut joined = Sets::new(faces);
        let mut beside = vec![[None; 3]; faces];
        for ([from, to], leaves) in edges {
            if let [(triangle, ..)] = leaves[..] {
                let middle = 0.5 * (positions[from as usize] + positions[to as usize]);
                if !rim(middle) {
                    continue;
                }
                joined.join(2 * triangle, 2 * triangle + 1);
                continue;
            }
            let start = positions[from as usize];
            let along = (positions[to as usize] - start).normalize_or_zero();
            let first = along.any_orthonormal_vector();
            let second = along.cross(first);
            let mut around: Vec<Leaf> = (leaves.into_iter())
                .map(|(triangle, edge, corner, forwards)| {
                    let out = positions[corner as usize] - start;
                    Leaf {
                        triangle,
                        edge,
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
                beside[own as usize][leaf.edge] = Some(other);
                beside[other as usize][next.edge] = Some(own);
                joined.join(own, other);
            }
        }
        let mut numbers = vec![u32::MAX; faces];
        let mut count = 0;
        let mut number = |face: u32| {
            let place = &mut numbers[joined.first(face) as usize];
            if *place == u32::MAX {
                *place = count;
                count += 1;
            }
            *place
        };
        let of = (0..faces as u32).map(&mut number).collect();
        Self {
            of,
            count: count as usize,
            beside,
        }
    }

    /// The faces that follow a face, twice the triangle's number plus 1 behind its normal, around its edges from node to node; `None` at a rim.
    #[must_use]
    pub fn beside(&self, face: usize) -> [Option<u32>; 3] {
        self.beside[face]
    }

    /// The space that a face looks at: twice the triangle's number, plus 1 behind its normal.
    #[must_use]
    pub fn of(&self, face: usize) -> usize {
        self.of[face] as usize
    }

    /// Which of them faces shut in on all sides, by number: those whose faces meet others along all edges, around a volume that is positive.
    #[must_use]
    pub fn shut_in(&self, triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<bool> {
        let mut closed = vec![true; self.count];
        let mut volumes = vec![0.0; self.count];
        let Some(origin) = positions.first() else {
            return closed;
        };
        for (face, beside) in self.beside.iter().enumerate() {
            let space = self.of(face);
            closed[space] &= beside.iter().all(Option::is_some);
            let [a, b, c] = triangles[face / 2].map(|node| positions[node as usize] - *origin);
            // The air lies where the normal of a face's triangle points, or behind it.
            let sign = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
            volumes[space] += sign * a.dot(b.cross(c));
        }
        (closed.into_iter().zip(volumes))
            .map(|(closed, volume)| closed && volume > 0.0)
            .collect()
    }

    /// How many there are.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }
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
        let all = Spaces::new(&triangles(&quads), &positions, |_| true);
        assert_eq!(all.count(), 3);
        // The wall between them looks at both insides, and an end wall at the outside and one of them.
        let [middle, end] = [9, 8].map(|quad| [0, 1].map(|face| all.of(4 * quad + face)));
        let shared = middle.iter().filter(|space| end.contains(space)).count();
        assert!(middle[0] != middle[1] && end[0] != end[1] && shared == 1);
        // Faces beside each other look at one space, and know each other.
        for face in 0..2 * triangles(&quads).len() {
            for other in all.beside(face) {
                let other = other.unwrap() as usize;
                assert_eq!(all.of(other), all.of(face));
                assert!(all.beside(other).contains(&Some(face as u32)));
            }
        }
        // Both insides are shut in, the outside is not.
        let shut_in = all.shut_in(&triangles(&quads), &positions);
        assert_eq!(shut_in.iter().filter(|is| **is).count(), 2);
        assert!(!shut_in[*end.iter().find(|space| !middle.contains(space)).unwrap()]);
        // Open at one end: the air inside and that outside are one; without the wall between them, all of it.
        quads.remove(10);
        let count = |quads: &[[u32; 4]], open: bool| {
            Spaces::new(&triangles(quads), &positions, |_| open).count()
        };
        assert_eq!([true, false].map(|open| count(&quads, open)), [2, 3]);
        let open = Spaces::new(&triangles(&quads), &positions, |_| true);
        let shut_in = open.shut_in(&triangles(&quads), &positions);
        assert_eq!(shut_in.iter().filter(|is| **is).count(), 1);
        quads.remove(9);
        assert_eq!([true, false].map(|open| count(&quads, open)), [1, 2]);
    }
}
