//! Which links of the lattice a surface of triangles cuts.
//!
//! Links of one direction lie on parallel lines through cell centres. Seen along them, the lines are the whole points of a plane, and a triangle is a
//! triangle of that plane. The points in it are the lines that it cuts. Which side of an edge a point lies on is worked out from the edge's ends in the order of
//! their numbers. So both triangles at an edge get the same bits, and every line passes just one of them. A closed surface has no leak, wherever it stands.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::cell_box::CellBox;
use crate::lattice::DIRECTIONS;

/// Number of the next search.
static NEXT_SEARCH: AtomicU64 = AtomicU64::new(1);

/// By how much the whole surface is moved, so that no cell's centre lies on a sheet along the lattice [cells]. It would lie before it for one link and
/// behind it for another. Along the stream it is moved farthest. So a plate across it, with its middle and edges at cells' centres or midway between them, cuts as many links that rise as ones that fall,
/// and has no force along itself. Moved less along the stream than across it, a square plate of 24 cells had a lift coefficient of 0.022.
pub const GENERAL_POSITION: DVec3 = DVec3::new(3.9e-5, 2.7e-5, 1.2e-5);

/// Triangles and links that one task works on.
const TRIANGLES_AT_ONCE: usize = 64;
const LINKS_AT_ONCE: usize = 1024;

/// Places in the order of cuts that one task looks at.
const PLACES_AT_ONCE: usize = 16384;

/// Cells of a lattice, cell centres at whole numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Domain {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Axes along which the domain repeats.
    pub repeats: [bool; 3],
    /// Cells at faces that the surface keeps off: those that a box of finer cells exchanges with the lattice around it.
    pub kept: usize,
    /// Triangles from this one on may go on beyond faces that do not repeat, where they cut nothing; `None`: none may.
    pub open_from: Option<usize>,
}

/// A node of the surface outside the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfAir {
    /// Its number.
    pub node: usize,
    /// Its position [cells].
    pub position: [f64; 3],
}

/// Where a triangle cuts a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric weights of its nodes.
    pub weights: [f64; 3],
    /// Distance from cell A [links].
    pub at: f64,
}

/// A link with the first and the last cut on it, as seen from cell A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutLink {
    /// Cells A and B.
    pub cells: [[i32; 3]; 2],
    /// Its pair of directions: c is `DIRECTIONS[2 pair + 1]`.
    pub pair: u8,
    /// Cuts on it.
    pub layers: u32,
    /// What stands before A and before B; the same with one layer.
    pub cuts: [Cut; 2],
    /// True where the link behind A, and behind B, is cut or leads out of the air.
    pub blocked: [bool; 2],
}

impl CutLink {
    /// Direction c from A to B.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        as_vector(DIRECTIONS[2 * usize::from(self.pair) + 1])
    }

    /// Number of the direction in which air leaves A (side 0) or B (side 1).
    #[must_use]
    pub const fn leaving(&self, side: usize) -> usize {
        2 * self.pair as usize + 1 + side
    }

    /// Distance of the cut from the cell of a side [links].
    #[must_use]
    pub const fn distance(&self, side: usize) -> f64 {
        if side == 0 {
            self.cuts[0].at
        } else {
            1.0 - self.cuts[1].at
        }
    }
}

fn as_vector(c: [i32; 3]) -> DVec3 {
    DVec3::from_array(c.map(f64::from))
}

/// All links that a surface cuts, ordered by cell and pair.
#[derive(Debug, Clone, Default)]
pub struct CutLinks {
    links: Vec<CutLink>,
    /// Number of the search that found them, no other's in this process; 0 before.
    search: u64,
    /// The cuts in the order of links.
    order: Vec<Order>,
    /// The same as they were found.
    unsorted: Vec<Order>,
    /// Where those of a link begin among them; one more at the end.
    starts: Vec<u32>,
    /// By cell of a box, the pairs of links from there, and to there, that are cut.
    mask: Mask,
    /// Those with more than one layer on them.
    doubled: Vec<u32>,
}

/// A cut of a link.
#[derive(Debug, Clone, Copy)]
struct Hit {
    cells: [[i32; 3]; 2],
    pair: u8,
    cut: Cut,
}

/// A hit, ordered by the row of cell A, the link in it, then the triangle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Order {
    /// Row of cell A along x.
    row: u32,
    /// Of cell A and pair.
    link: u32,
    /// The part of those that were found, and the place in it.
    part: u32,
    hit: u32,
}

impl Order {
    const fn is_of_link(&self, other: &Self) -> bool {
        self.row == other.row && self.link == other.link
    }
}

#[derive(Debug, Clone, Default)]
struct Mask {
    cells: CellBox,
    around: Vec<CutAround>,
}

impl Mask {
    fn lay(&mut self, links: &[CutLink]) {
        self.cells = (links.par_chunks(PLACES_AT_ONCE))
            .map(|links| CellBox::around(links.iter().flat_map(|link| link.cells)))
            .reduce(CellBox::default, CellBox::with);
        self.around.clear();
        self.around.resize(self.cells.count(), CutAround::default());
        for link in links {
            let [from, to] = link.cells.map(|cell| self.cells.place(cell));
            if let (Some(from), Some(to)) = (from, to) {
                self.around[from].from |= 1 << link.pair;
                self.around[to].to |= 1 << link.pair;
            }
        }
    }

    fn has(&self, cell: [i32; 3], pair: u8) -> bool {
        (self.cells.place(cell)).is_some_and(|place| self.around[place].from >> pair & 1 == 1)
    }
}

impl Domain {
    /// A cell in the domain, or the one that it repeats; `None` outside.
    pub(super) fn cell(&self, mut cell: [i64; 3]) -> Option<[i32; 3]> {
        for a in 0..3 {
            let n = self.cells[a] as i64;
            if self.repeats[a] {
                cell[a] = cell[a].rem_euclid(n);
            } else if !(0..n).contains(&cell[a]) {
                return None;
            }
        }
        Some(cell.map(|c| c as i32))
    }

    /// True where all neighbours of a cell are in the domain, and none of them is one that it repeats.
    #[inline]
    pub(super) fn is_inside(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| cell[a] >= 1 && cell[a] + 1 < self.cells[a] as i32)
    }

    /// True where the air goes on around a place [cells]: not beyond its end, nor where it repeats, within a fiftieth of a cell.
    pub(crate) fn goes_round(&self, place: DVec3) -> bool {
        const NEAR: f64 = 0.02;
        (0..3).all(|a| {
            let (place, end) = (place[a] + 0.5, self.cells[a] as f64);
            let place = if self.repeats[a] {
                place.rem_euclid(end)
            } else {
                place
            };
            (NEAR..end - NEAR).contains(&place)
        })
    }

    /// Refuses nodes that stand where the surface may not.
    pub fn holds(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), OutOfAir> {
        let closed = self.open_from.unwrap_or(triangles.len());
        let kept = self.kept as f64;
        for &node in triangles[..closed.min(triangles.len())].iter().flatten() {
            let position = positions[node as usize].to_array();
            let outside = |a: usize| {
                let bounds = if self.kept > 0 {
                    [kept, self.cells[a] as f64 - 1.0 - kept]
                } else {
                    [-0.5, self.cells[a] as f64 - 0.5]
                };
                // Not finite counts as outside.
                !self.repeats[a] && !(bounds[0]..=bounds[1]).contains(&position[a])
            };
            if (0..3).any(outside) || position.iter().any(|p| !p.is_finite()) {
                return Err(OutOfAir {
                    node: node as usize,
                    position,
                });
            }
        }
        Ok(())
    }
}

impl CutLinks {
    /// Finds anew what a surface cuts, its nodes at `positions` [cells].
    pub fn find(
        &mut self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        domain: &Domain,
    ) -> Result<(), OutOfAir> {
        domain.holds(positions, triangles)?;
        self.search = NEXT_SEARCH.fetch_add(1, Ordering::Relaxed);
        let parts: Vec<Vec<Hit>> = triangles
            .par_chunks(TRIANGLES_AT_ONCE)
            .enumerate()
            .map(|(part, chunk)| {
                let mut hits = Vec::with_capacity(12 * chunk.len());
                for (k, nodes) in chunk.iter().enumerate() {
                    let triangle = (part * TRIANGLES_AT_ONCE + k) as u32;
                    cuts_of(triangle, *nodes, positions, domain, &mut hits);
                }
                hits
            })
            .collect();
        self.sort(&parts, domain);
        let order = &self.order;
        self.starts.clear();
        let first_of_a_link = |place: &u32| {
            let place = *place as usize;
            place == 0 || !order[place - 1].is_of_link(&order[place])
        };
        let places = (0..order.len() as u32).into_par_iter();
        self.starts
            .par_extend(places.with_min_len(PLACES_AT_ONCE).filter(first_of_a_link));
        self.starts.push(order.len() as u32);
        let hit = |place: u32| {
            let Order { part, hit, .. } = order[place as usize];
            &parts[part as usize][hit as usize]
        };
        (self.starts.par_windows(2))
            .with_min_len(LINKS_AT_ONCE)
            .map(|bounds| link_of(hit(bounds[0]), (bounds[0]..bounds[1]).map(hit)))
            .collect_into_vec(&mut self.links);
        let links = &self.links;
        self.doubled.clear();
        self.doubled.par_extend(
            (0..links.len() as u32)
                .into_par_iter()
                .with_min_len(LINKS_AT_ONCE)
                .filter(|link| links[*link as usize].layers > 1),
        );
        self.mask.lay(&self.links);
        let mask = &self.mask;
        self.links
            .par_iter_mut()
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|link| {
                let c = DIRECTIONS[2 * usize::from(link.pair) + 1];
                let before = |cell: [i32; 3], sign: i32| {
                    domain.cell(std::array::from_fn(|a| i64::from(cell[a] + sign * c[a])))
                };
                // The link behind A begins one cell before it, the one behind B in B itself.
                let behind_a = before(link.cells[0], -1);
                let behind_b = before(link.cells[1], 1);
                link.blocked = [
                    behind_a.is_none_or(|cell| mask.has(cell, link.pair)),
                    behind_b.is_none() || mask.has(link.cells[1], link.pair),
                ];
            });
        Ok(())
    }

    /// Orders the cuts that were found: first by rows of cells, then within each.
    fn sort(&mut self, parts: &[Vec<Hit>], domain: &Domain) {
        let rows_of_a_layer = domain.cells[1] as u32;
        let place = |part: usize, (number, hit): (usize, &Hit)| {
            let [x, y, z] = hit.cells[0].map(|place| place as u32);
            Order {
                row: y + rows_of_a_layer * z,
                link: 9 * x + u32::from(hit.pair),
                part: part as u32,
                hit: number as u32,
            }
        };
        self.unsorted.clear();
        let found = parts.par_iter().enumerate().flat_map_iter(|(part, hits)| {
            (hits.iter().enumerate()).map(move |hit| place(part, hit))
        });
        self.unsorted.par_extend(found);
        let of_rows = self.unsorted.iter().map(|order| order.row);
        let (first, last) = of_rows.fold((u32::MAX, 0), |(first, last), row| {
            (first.min(row), last.max(row))
        });
        // Where the next of each row goes.
        let mut next = vec![0_u32; (last + 2).saturating_sub(first) as usize];
        for order in &self.unsorted {
            next[(order.row - first) as usize + 1] += 1;
        }
        for row in 1..next.len() {
            next[row] += next[row - 1];
        }
        self.order.resize(self.unsorted.len(), Order::default());
        for order in &self.unsorted {
            let place = &mut next[(order.row - first) as usize];
            self.order[*place as usize] = *order;
            *place += 1;
        }
        (self.order.par_chunk_by_mut(|a, b| a.row == b.row)).for_each(<[Order]>::sort_unstable);
    }

    /// The links.
    #[must_use]
    pub fn links(&self) -> &[CutLink] {
        &self.links
    }

    /// Number of the search that found them, by which others know whether they still have what they made of them.
    #[must_use]
    pub const fn search(&self) -> u64 {
        self.search
    }

    /// Which links of a cell are cut.
    #[inline]
    #[must_use]
    pub fn cut_around(&self, cell: [i32; 3]) -> CutAround {
        let mask = &self.mask;
        mask.cells
            .place(cell)
            .map_or_else(CutAround::default, |place| mask.around[place])
    }

    /// The box of their cells.
    pub(super) const fn cells(&self) -> &CellBox {
        &self.mask.cells
    }

    /// Least and largest places of their cells; `None` where nothing is cut.
    #[must_use]
    pub fn reach(&self) -> Option<[[i32; 3]; 2]> {
        self.mask.cells.bounds()
    }

    /// Numbers of the links with more than one layer on them.
    #[must_use]
    pub fn doubled(&self) -> &[u32] {
        &self.doubled
    }
}

/// Links of a cell that are cut.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CutAround {
    /// By pair of directions, a bit of those that begin in the cell, and of those that end there.
    from: u16,
    to: u16,
}

/// Nine bits, each at twice its place.
static EVERY_OTHER: [u32; 512] = {
    let mut spread = [0; 512];
    let mut bits = 0;
    while bits < 512 {
        let mut bit = 0;
        while bit < 9 {
            spread[bits] |= ((bits as u32 >> bit) & 1) << (2 * bit);
            bit += 1;
        }
        bits += 1;
    }
    spread
};

impl CutAround {
    /// True where the link in a direction (not 0) is cut.
    #[inline]
    #[must_use]
    pub const fn has(self, direction: usize) -> bool {
        let of_pair = if direction % 2 == 1 {
            self.from
        } else {
            self.to
        };
        of_pair >> ((direction - 1) / 2) & 1 == 1
    }

    /// By direction, a bit of those that are cut.
    #[inline]
    #[must_use]
    pub fn directions(self) -> u32 {
        EVERY_OTHER[self.from as usize] << 1 | EVERY_OTHER[self.to as usize] << 2
    }

    /// How many are.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.from.count_ones() + self.to.count_ones()
    }

    /// True where those on both sides are cut, along any direction.
    #[must_use]
    pub const fn on_both_sides(self) -> bool {
        self.from & self.to != 0
    }
}

/// The link of some cuts, `first` being one of them.
fn link_of<'a>(first: &Hit, hits: impl Iterator<Item = &'a Hit>) -> CutLink {
    let nearer = |a: &Cut, b: &Cut| {
        let order = a.at.total_cmp(&b.at).then(a.triangle.cmp(&b.triangle));
        order.is_lt()
    };
    let mut link = CutLink {
        cells: first.cells,
        pair: first.pair,
        layers: 0,
        cuts: [first.cut; 2],
        blocked: [false; 2],
    };
    for hit in hits {
        link.layers += 1;
        if nearer(&hit.cut, &link.cuts[0]) {
            link.cuts[0] = hit.cut;
        }
        if nearer(&link.cuts[1], &hit.cut) {
            link.cuts[1] = hit.cut;
        }
    }
    link
}

/// The largest whole number that is not larger; without a call to the system's library, which `f64::floor` is on some machines.
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(x < towards_zero as f64)
}

/// Twice the area from edge `from`–`to` to a point, positive to its left.
fn beside(from: [f64; 2], to: [f64; 2], point: [f64; 2]) -> f64 {
    (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
}

/// Adds what a triangle cuts.
fn cuts_of(
    triangle: u32,
    nodes: [u32; 3],
    positions: &[DVec3],
    domain: &Domain,
    hits: &mut Vec<Hit>,
) {
    let corners = nodes.map(|n| (positions[n as usize] + GENERAL_POSITION).to_array());
    for pair in 0..9_usize {
        let c = DIRECTIONS[2 * pair + 1];
        // The axis along which lines are followed; the first that the direction has, which it has forwards.
        let along = (0..3).find(|a| c[*a] != 0).unwrap_or(0);
        let [left, right] = [[1, 2], [0, 2], [0, 1]][along];
        let slant = [f64::from(c[left]), f64::from(c[right])];
        let seen = corners.map(|p| {
            [
                p[left] - slant[0] * p[along],
                p[right] - slant[1] * p[along],
            ]
        });
        let range = |a: usize| {
            let [p, q, r] = seen.map(|place| place[a]);
            let (low, high) = (p.min(q).min(r), p.max(q).max(r));
            -floor(-low)..=floor(high)
        };
        let (rows, columns) = (range(1), range(0));
        if rows.is_empty() || columns.is_empty() {
            continue;
        }
        for v in rows {
            for u in columns.clone() {
                let point = [u as f64, v as f64];
                let Some(weights) = weights_in(nodes, &seen, point) else {
                    continue;
                };
                let place: f64 = (0..3).map(|k| weights[k] * corners[k][along]).sum();
                let whole = floor(place);
                let mut cell = [0; 3];
                cell[along] = whole;
                cell[left] = u + i64::from(c[left]) * whole;
                cell[right] = v + i64::from(c[right]) * whole;
                let other = std::array::from_fn(|a| cell[a] + i64::from(c[a]));
                let (Some(cell), Some(other)) = (domain.cell(cell), domain.cell(other)) else {
                    continue;
                };
                hits.push(Hit {
                    cells: [cell, other],
                    pair: pair as u8,
                    cut: Cut {
                        triangle,
                        weights,
                        at: place - whole as f64,
                    },
                });
            }
        }
    }
}

/// Barycentric weights of a point in a triangle of the plane; `None` outside. A point on an edge lies in one of the triangles at it.
fn weights_in(nodes: [u32; 3], corners: &[[f64; 2]; 3], point: [f64; 2]) -> Option<[f64; 3]> {
    let mut opposite = [0.0; 3];
    let mut left = [false; 3];
    for k in 0..3 {
        let (from, to) = ((k + 1) % 3, (k + 2) % 3);
        if nodes[from] < nodes[to] {
            let area = beside(corners[from], corners[to], point);
            opposite[k] = area;
            left[k] = area >= 0.0;
        } else {
            let area = beside(corners[to], corners[from], point);
            opposite[k] = -area;
            left[k] = area < 0.0;
        }
    }
    if left[0] != left[1] || left[1] != left[2] {
        return None;
    }
    let whole = opposite[0] + opposite[1] + opposite[2];
    (whole != 0.0).then(|| opposite.map(|area| area / whole))
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
