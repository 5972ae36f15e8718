//! Which triangles of a sheet share what the air does to one of them.
//!
//! A cut is one point, but its link stands for the air of a cell, and so for all fabric there. Where triangles are smaller than cells, most of them have no cut of
//! their own, and light fabric between cuts has nothing but its own mass. So what the air does to a triangle is shared by those within half a cell of
//! it, and the air meets their mean velocity. The shares are the same both ways: the air has what the fabric felt.
//!
//! Ways along the sheet join the middles of triangles across their common edges, in its flat pattern. They pass no free edge. The more a triangle on the way is
//! turned, the less is shared beyond it, from 60° on nothing: a fold ends it. Triangles farther than that from all others are alone, and keep the points of their cuts.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Triangle;

/// How far the middles of triangles that share lie apart, along the sheet [cells].
pub const REACH: f64 = 0.5;

/// Cosine of the turn between two triangles from which they share nothing.
pub const LEAST_COSINE: f64 = 0.5;

/// Triangles that one task works on.
const TRIANGLES_AT_ONCE: usize = 512;

/// A triangle that shares with another.
#[derive(Debug, Clone, Copy)]
pub struct Member {
    /// The triangle.
    pub triangle: u32,
    /// Area as it was cut [cells²].
    pub area: f64,
    /// Which of the members the way to it passes last; itself of the triangle that shares.
    pub via: u32,
    /// Where the other one stands among its own members.
    pub back: u32,
}

/// The triangles that share, each with itself among them.
#[derive(Debug, Clone)]
pub struct Patches {
    starts: Vec<u32>,
    members: Vec<Member>,
    /// What every member gets of what the air does to the triangle.
    shares: Vec<f64>,
}

/// Twice the area of a triangle by the squares of its edges (Heron).
fn doubled_area([a, b, c]: [f64; 3]) -> f64 {
    let square = 2.0 * (a * b + b * c + c * a) - (a * a + b * b + c * c);
    0.5 * square.max(0.0).sqrt()
}

/// The third corner, and the middle, of a triangle laid with one edge from the origin along x: squares of that edge, and of those from both its ends to the corner.
fn middle([edge, from_start, from_end]: [f64; 3], up: f64) -> DVec2 {
    let length = edge.sqrt();
    let x = (edge + from_start - from_end) / (2.0 * length);
    let y = (from_start - x * x).max(0.0).sqrt();
    DVec2::new((length + x) / 3.0, up * y / 3.0)
}

/// Distances of the middles of triangles across their common edges, of those that are turned alike there: `[triangle]` with its edges opposite corners 0, 1, 2.
fn steps(triangles: &[[u32; 3]], squares: &[[f64; 3]]) -> Vec<Vec<(u32, f64)>> {
    // Triangles and edges by their nodes.
    let mut edges: BTreeMap<[u32; 2], Vec<(u32, usize)>> = BTreeMap::new();
    for (number, nodes) in triangles.iter().enumerate() {
        for k in 0..3 {
            let [from, to] = [nodes[(k + 1) % 3], nodes[(k + 2) % 3]];
            let key = [from.min(to), from.max(to)];
            edges.entry(key).or_default().push((number as u32, k));
        }
    }
    let mut found = vec![Vec::new(); triangles.len()];
    for sides in edges.into_values() {
        let &[(one, k), (other, l)] = &sides[..] else {
            continue;
        };
        let [of_one, of_other] = [one, other].map(|triangle| triangles[triangle as usize]);
        if of_one[(k + 1) % 3] != of_other[(l + 2) % 3] {
            continue;
        }
        // From the end of the edge where `one` begins it.
        let seen = |triangle: u32, k: usize, turned: bool| {
            let of = squares[triangle as usize];
            let [first, second] = [of[(k + 2) % 3], of[(k + 1) % 3]];
            let pair = if turned {
                [second, first]
            } else {
                [first, second]
            };
            [of[k], pair[0], pair[1]]
        };
        let distance =
            middle(seen(one, k, false), 1.0).distance(middle(seen(other, l, true), -1.0));
        found[one as usize].push((other, distance));
        found[other as usize].push((one, distance));
    }
    found
}

impl Patches {
    /// Of a sheet in a lattice of such cells, as it was cut; `None` where every triangle is alone.
    #[must_use]
    pub fn new(triangles: &[Triangle], cell_size_m: f64) -> Option<Self> {
        let cell_m2 = cell_size_m.powi(2);
        let in_cells = |t: &Triangle| t.rest_squares_m2.map(|square| square / cell_m2);
        let squares: Vec<_> = triangles.iter().map(in_cells).collect();
        let nodes: Vec<_> = triangles.iter().map(|t| t.nodes).collect();
        Self::of(&nodes, &squares)
    }

    /// Of triangles whose edges have these squares, opposite their corners [cells²].
    fn of(triangles: &[[u32; 3]], squares: &[[f64; 3]]) -> Option<Self> {
        let steps = steps(triangles, squares);
        let area = |triangle: u32| 0.5 * doubled_area(squares[triangle as usize]);
        let reached: Vec<Vec<Reached>> = (0..triangles.len() as u32)
            .into_par_iter()
            .with_min_len(TRIANGLES_AT_ONCE)
            .map(|triangle| within_reach(&steps, triangle))
            .collect();
        // Round-off may leave a way within reach in one direction alone.
        let place = |members: &[Reached], triangle: u32| {
            let mut numbers = members.iter().map(|member| member.triangle);
            numbers.position(|number| number == triangle)
        };
        let both = |triangle: u32| {
            let members = reached[triangle as usize].iter().copied();
            let meets =
                |other: &Reached| place(&reached[other.triangle as usize], triangle).is_some();
            members.filter(meets).collect()
        };
        let within: Vec<Vec<Reached>> = (0..triangles.len() as u32).map(both).collect();
        if within.iter().all(|members| members.len() == 1) {
            return None;
        }
        let mut patches = Self {
            starts: vec![0],
            members: Vec::new(),
            shares: Vec::new(),
        };
        for (triangle, members) in within.iter().enumerate() {
            for member in members {
                let back = place(&within[member.triangle as usize], triangle as u32);
                patches.members.push(Member {
                    triangle: member.triangle,
                    area: area(member.triangle),
                    via: place(members, member.via).unwrap_or_default() as u32,
                    back: back.unwrap_or_default() as u32,
                });
            }
            patches.starts.push(patches.members.len() as u32);
        }
        patches.shares.resize(patches.members.len(), 0.0);
        Some(patches)
    }

    fn range(&self, triangle: usize) -> std::ops::Range<usize> {
        self.starts[triangle] as usize..self.starts[triangle + 1] as usize
    }

    /// Shares by area, among those that are turned alike as the sheet stands now: `normals` of the triangles.
    pub fn share(&mut self, normals: &[DVec3]) {
        let mut shares = std::mem::take(&mut self.shares);
        let mut rest = &mut shares[..];
        let mut rows = Vec::with_capacity(self.starts.len());
        for triangle in 0..self.starts.len() - 1 {
            let (row, others) = rest.split_at_mut(self.range(triangle).len());
            rows.push(row);
            rest = others;
        }
        (rows.into_par_iter().enumerate())
            .with_min_len(TRIANGLES_AT_ONCE)
            .for_each(|(triangle, row)| {
                let members = &self.members[self.range(triangle)];
                let normal = normals[triangle];
                // First how much is shared along the way to each, itself being the first of its members.
                row[0] = 1.0;
                for (number, member) in members.iter().enumerate().skip(1) {
                    // Fading, not ending at once: a switch would make rounding grow.
                    let cosine = normal.dot(normals[member.triangle as usize]);
                    let alike = ((cosine - LEAST_COSINE) / (1.0 - LEAST_COSINE)).max(0.0);
                    row[number] = alike.min(row[member.via as usize]);
                }
                let mut sum = 0.0;
                for (share, member) in row.iter_mut().zip(members) {
                    *share *= member.area;
                    sum += *share;
                }
                row.iter_mut().for_each(|share| *share /= sum);
            });
        self.shares = shares;
    }

    /// True if a triangle is one of the sheet, and shares with another wherever the sheet is flat.
    #[inline]
    #[must_use]
    pub fn shares(&self, triangle: u32) -> bool {
        (triangle as usize) < self.count() && self.range(triangle as usize).len() > 1
    }

    /// Where those who share with each triangle begin, one more at the end; and who they are, itself the first.
    #[must_use]
    pub fn members(&self) -> (&[u32], &[Member]) {
        (&self.starts, &self.members)
    }

    /// Triangles that share with one, itself among them, the mean over the sheet.
    #[must_use]
    pub fn mean_size(&self) -> f64 {
        self.members.len() as f64 / self.count() as f64
    }

    /// Triangles of the sheet.
    #[must_use]
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Who shares what the air does to a triangle, and how much of it.
    pub fn given(&self, triangle: u32) -> impl Iterator<Item = (u32, f64)> {
        let range = self.range(triangle as usize);
        let shares = &self.shares[range.clone()];
        (self.members[range].iter().zip(shares)).map(|(member, share)| (member.triangle, *share))
    }

    /// Whose share a triangle gets, and how much of it.
    pub fn received(&self, triangle: u32) -> impl Iterator<Item = (u32, f64)> {
        self.members[self.range(triangle as usize)]
            .iter()
            .map(|member| {
                let first = self.starts[member.triangle as usize];
                (member.triangle, self.shares[(first + member.back) as usize])
            })
    }

    /// Mean of a field on nodes over the middles of those who share what the air does to a triangle, of every triangle; zero where one is alone.
    #[must_use]
    pub fn means(&self, triangles: &[[u32; 3]], field: &[DVec3]) -> Vec<DVec3> {
        let middle = |triangle: u32| {
            let [a, b, c] = triangles[triangle as usize].map(|node| field[node as usize]);
            (a + b + c) / 3.0
        };
        let mean = |triangle: u32| {
            if !self.shares(triangle) {
                return DVec3::ZERO;
            }
            let given = self.given(triangle);
            given.map(|(other, share)| middle(other) * share).sum()
        };
        (0..self.count() as u32)
            .into_par_iter()
            .with_min_len(TRIANGLES_AT_ONCE)
            .map(mean)
            .collect()
    }
}

/// A triangle within reach of another.
#[derive(Debug, Clone, Copy)]
struct Reached {
    triangle: u32,
    /// Length of the way to it.
    way: f64,
    /// The triangle before it on that way.
    via: u32,
}

/// Triangles whose way from one is at most [`REACH`], by their ways; the one itself is the first.
fn within_reach(steps: &[Vec<(u32, f64)>], from: u32) -> Vec<Reached> {
    let mut ways = BTreeMap::from([(from, (0.0_f64, from))]);
    let mut next = vec![from];
    while let Some(triangle) = next.pop() {
        let (way, _) = ways[&triangle];
        for &(other, step) in &steps[triangle as usize] {
            let longer = way + step;
            if longer <= REACH && ways.get(&other).is_none_or(|(known, _)| longer < *known) {
                ways.insert(other, (longer, triangle));
                next.push(other);
            }
        }
    }
    let of = |(triangle, (way, via))| Reached { triangle, way, via };
    let mut found: Vec<Reached> = ways.into_iter().map(of).collect();
    found.sort_by(|one, other| one.way.total_cmp(&other.way));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat sheet of squares of this size, each cut into two triangles; the squares of its edges are those of the flat pattern.
    fn sheet(size: f64) -> (Vec<[u32; 3]>, Vec<[f64; 3]>) {
        let mut triangles = Vec::new();
        for row in 0..6_u32 {
            for column in 0..6 {
                let a = 7 * row + column;
                triangles.extend([[a, a + 1, a + 8], [a, a + 8, a + 7]]);
            }
        }
        let square = size * size;
        let squares = [
            [square, 2.0 * square, square],
            [square, square, 2.0 * square],
        ];
        let all = triangles.iter().enumerate().map(|(k, _)| squares[k % 2]);
        let all = all.collect();
        (triangles, all)
    }

    fn middle_of(triangle: &[u32; 3], size: f64) -> DVec2 {
        let place = |node: u32| DVec2::new(f64::from(node % 7), f64::from(node / 7)) * size;
        triangle.iter().map(|node| place(*node)).sum::<DVec2>() / 3.0
    }

    #[test]
    fn triangles_larger_than_cells_are_alone() {
        let (triangles, squares) = sheet(1.5);
        assert!(Patches::of(&triangles, &squares).is_none());
    }

    /// Those who share are near, and all of what one gives arrives.
    #[test]
    fn shares_are_whole_and_near() {
        let size = 0.25;
        let (triangles, squares) = sheet(size);
        let mut patches = Patches::of(&triangles, &squares).unwrap();
        let mut normals = vec![DVec3::Z; triangles.len()];
        // The last rows are folded over.
        normals[48..].fill(-DVec3::Z);
        patches.share(&normals);
        let mut got = vec![0.0; triangles.len()];
        for triangle in 0..triangles.len() as u32 {
            let middle = middle_of(&triangles[triangle as usize], size);
            let given: Vec<_> = patches.given(triangle).collect();
            assert!((given.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-14);
            assert!(given.len() > 3, "{given:?}");
            for (other, share) in given {
                let way = middle.distance(middle_of(&triangles[other as usize], size));
                assert!(way <= REACH + 1e-12);
                assert!((share > 0.0) == ((other < 48) == (triangle < 48)));
            }
            for (from, share) in patches.received(triangle) {
                got[from as usize] += share;
                let known = patches.given(from).find(|(to, _)| *to == triangle);
                assert_eq!(known, Some((triangle, share)));
            }
        }
        assert!(got.iter().all(|sum| (sum - 1.0).abs() < 1e-14));
    }

    /// Layers of a fold narrower than half a cell: the first and the third are turned alike, but the way between them leads over the second.
    #[test]
    fn a_fold_ends_a_patch() {
        let (triangles, squares) = sheet(0.12);
        let mut patches = Patches::of(&triangles, &squares).unwrap();
        let mut normals = vec![DVec3::Z; triangles.len()];
        // A row of squares that is turned over.
        normals[24..36].fill(-DVec3::Z);
        let within = |patches: &Patches| {
            let of_first = patches.given(20).filter(|(_, share)| *share > 0.0);
            of_first.map(|(other, _)| other).collect::<Vec<u32>>()
        };
        patches.share(&vec![DVec3::Z; triangles.len()]);
        assert!(within(&patches).iter().any(|other| *other >= 36));
        patches.share(&normals);
        assert!(within(&patches).iter().all(|other| *other < 24));
    }

    /// Over the edge of two pieces that do not meet nothing is shared.
    #[test]
    fn a_free_edge_ends_a_patch() {
        let (triangles, squares) = sheet(0.2);
        // The second piece has nodes of its own.
        let both: Vec<[u32; 3]> = (triangles.iter().copied())
            .chain(triangles.iter().map(|nodes| nodes.map(|node| node + 49)))
            .collect();
        let squares = [squares.clone(), squares].concat();
        let mut patches = Patches::of(&both, &squares).unwrap();
        patches.share(&vec![DVec3::Z; both.len()]);
        let half = triangles.len() as u32;
        for triangle in 0..2 * half {
            assert!(
                (patches.given(triangle)).all(|(other, _)| (other < half) == (triangle < half))
            );
        }
    }
}
