//! What a canopy's mesh tells of its parts: border loops, lines, gores, the top. Found once, from the shape at the start.
//!
//! A border loop is a closed chain of edges that belong to one triangle only. Loops that run round the axis (from the confluence to
//! the middle of the lines' attachments) are the skirt, the one farthest upstream; the vent, the narrowest of the others if their number
//! is odd; and pairs on both sides of a gap. Loops that do not run round it are slots.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::skirt::mean_radius_m;
use crate::case::scene::Canopy;
use crate::cloth::Structure;
use crate::frame::CableKind;

/// The top of a canopy reaches this share of the way from the apex to the farthest node.
const TOP_REACH: f64 = 0.5;

/// A suspension line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    /// Node of the fabric from which it goes down.
    pub attachment: u32,
    /// Segments between attachment and confluence.
    pub lower: Vec<usize>,
    /// Segments that go on along the fabric, across gaps or vents.
    pub upper: Vec<usize>,
}

/// Parts of a canopy.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline {
    /// Nodes of the skirt in order.
    pub skirt: Vec<u32>,
    /// Nodes of the vent in order; empty without one.
    pub vent: Vec<u32>,
    /// Both borders of every gap, the upstream one first.
    pub gaps: Vec<[Vec<u32>; 2]>,
    /// Border of every slot.
    pub slots: Vec<Vec<u32>>,
    /// Lines in the order of their azimuth.
    pub lines: Vec<Line>,
    /// Skirt nodes of every gore, from the attachment of its line to that of the next.
    pub gores: Vec<Vec<u32>>,
    /// Triangles of the top.
    pub top: Vec<usize>,
    /// Rest area of the top [m²].
    pub top_area_m2: f64,
    /// Triangles that touch the vent.
    pub at_vent: Vec<usize>,
}

/// Closed chains of border edges, in the direction of the triangles; a chain that meets itself at a node is cut there.
pub(super) fn border_loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut starts = Vec::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if edges[&(a.min(b), a.max(b))] == 1 {
                next.entry(a).or_default().push(b);
                starts.push(a);
            }
        }
    }
    let mut loops = Vec::new();
    for start in starts {
        let mut chain = vec![start];
        let mut at = start;
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            if let Some(met) = chain.iter().position(|&node| node == to) {
                loops.push(chain.split_off(met));
                if met == 0 {
                    break;
                }
                // The node where the loop closed remains on the chain that goes on from it.
                chain.push(to);
                at = to;
            } else {
                chain.push(to);
                at = to;
            }
        }
    }
    loops
}

/// A straight axis with two directions across it.
struct Axis {
    origin: DVec3,
    along: DVec3,
    across: [DVec3; 2],
}

impl Axis {
    fn new(from: DVec3, to: DVec3) -> Self {
        let along = (to - from).try_normalize().unwrap_or(DVec3::X);
        // For an axis along the wind these are y and z.
        let helper = if along.y.abs() < 0.9 {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let first = (helper - along * along.dot(helper)).normalize();
        Self {
            origin: from,
            along,
            across: [first, along.cross(first)],
        }
    }

    fn height(&self, place: DVec3) -> f64 {
        (place - self.origin).dot(self.along)
    }

    fn azimuth(&self, place: DVec3) -> f64 {
        let arm = place - self.origin;
        let [y, z] = self.across.map(|direction| arm.dot(direction));
        // Numbers start at +y; what rounding puts just before it belongs there.
        (z.atan2(y) + 1e-9).rem_euclid(TAU)
    }

    /// How often a loop runs round the axis.
    fn turns(&self, places: &[DVec3]) -> i64 {
        let mut sum = 0.0;
        for (k, &place) in places.iter().enumerate() {
            let step = self.azimuth(places[(k + 1) % places.len()]) - self.azimuth(place);
            sum += (step + PI).rem_euclid(TAU) - PI;
        }
        (sum / TAU).round() as i64
    }
}

/// Segments that hang on `from`, one after the other, as long as the way is single and `allowed`.
fn follow(
    structure: &Structure,
    at: &HashMap<u32, Vec<usize>>,
    from: u32,
    first: usize,
    allowed: &dyn Fn(usize) -> bool,
) -> Vec<usize> {
    let mut found = vec![first];
    let other = |segment: usize, node: u32| {
        let [a, b] = structure.cables[segment].nodes;
        if a == node { b } else { a }
    };
    let mut node = other(first, from);
    while let Some([one, two]) = at.get(&node).map(Vec::as_slice) {
        let Some(&onward) = [one, two].into_iter().find(|s| !found.contains(s)) else {
            break;
        };
        if !allowed(onward) {
            break;
        }
        found.push(onward);
        node = other(onward, node);
    }
    found
}

fn mean(places: impl ExactSizeIterator<Item = DVec3>) -> DVec3 {
    let count = places.len().max(1) as f64;
    places.sum::<DVec3>() / count
}

impl Outline {
    /// Parts of a canopy with the triangles and cables of `structure` at its start.
    pub fn new(structure: &Structure, canopy: &Canopy) -> Self {
        let place = |node: u32| structure.positions_m[node as usize];
        let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
        let on_fabric = |node: u32| (node as usize) < canopy.canopy_node_count;
        let is_line = |s: usize| structure.cables[s].kind == CableKind::SuspensionLine;
        let segments = || (0..structure.cables.len()).filter(|&s| is_line(s));
        let ends_on_fabric = |s: usize| {
            structure.cables[s]
                .nodes
                .iter()
                .filter(|&&n| on_fabric(n))
                .count()
        };
        let mut at: HashMap<u32, Vec<usize>> = HashMap::new();
        for s in segments() {
            for node in structure.cables[s].nodes {
                at.entry(node).or_default().push(s);
            }
        }
        let mut lines: Vec<Line> = segments()
            .filter(|&s| ends_on_fabric(s) == 1)
            .filter_map(|s| {
                let attachment = structure.cables[s]
                    .nodes
                    .into_iter()
                    .find(|&n| on_fabric(n))?;
                let lower = follow(structure, &at, attachment, s, &|t| ends_on_fabric(t) == 0);
                let along = at[&attachment].iter().copied();
                let upper = along
                    .filter(|&t| ends_on_fabric(t) == 2)
                    .flat_map(|t| {
                        follow(structure, &at, attachment, t, &|u| ends_on_fabric(u) == 2)
                    })
                    .collect();
                Some(Line {
                    attachment,
                    lower,
                    upper,
                })
            })
            .collect();
        let confluence = structure
            .positions_m
            .get(canopy.canopy_node_count)
            .copied()
            .unwrap_or_default();
        let middle = mean(lines.iter().map(|line| place(line.attachment)));
        let axis = Axis::new(confluence, middle);
        lines.sort_by(|a, b| {
            let azimuth = |line: &Line| axis.azimuth(place(line.attachment));
            azimuth(a).total_cmp(&azimuth(b))
        });

        let mut outline = Self {
            lines,
            ..Self::default()
        };
        // Height and radius of those that run round the axis.
        let mut round: Vec<([f64; 2], Vec<u32>)> = Vec::new();
        for border in border_loops(&triangles) {
            let places: Vec<DVec3> = border.iter().map(|&n| place(n)).collect();
            if axis.turns(&places) == 0 {
                outline.slots.push(border);
            } else {
                let height = axis.height(mean(places.iter().copied()));
                round.push(([height, mean_radius_m(&places)], border));
            }
        }
        round.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        if !round.is_empty() {
            outline.skirt = round.remove(0).1;
        }
        if round.len() % 2 == 1 {
            // Before a flat canopy is loaded, its vent is no farther downstream than the other borders.
            let radius = |k: &usize| round[*k].0[1];
            let vent = (0..round.len()).min_by(|a, b| radius(a).total_cmp(&radius(b)));
            outline.vent = vent.map(|k| round.remove(k).1).unwrap_or_default();
        }
        for pair in round.chunks_exact(2) {
            outline.gaps.push([pair[0].1.clone(), pair[1].1.clone()]);
        }
        outline.gores = outline.find_gores();

        let apex = outline.apex(&structure.positions_m);
        let reach = structure.positions_m[..canopy.canopy_node_count]
            .iter()
            .map(|p| p.distance(apex))
            .fold(0.0, f64::max);
        let near = |node: &u32| place(*node).distance(apex) <= TOP_REACH * reach + 1e-9;
        outline.top = (0..triangles.len())
            .filter(|&t| triangles[t].iter().all(near))
            .collect();
        outline.top_area_m2 = outline
            .top
            .iter()
            .map(|&t| structure.triangles[t].rest_area_m2)
            .sum();
        outline.at_vent = (0..triangles.len())
            .filter(|&t| triangles[t].iter().any(|n| outline.vent.contains(n)))
            .collect();
        outline
    }

    /// The apex, node 0, or the middle of the vent [m].
    pub fn apex(&self, positions_m: &[DVec3]) -> DVec3 {
        if self.vent.is_empty() {
            positions_m.first().copied().unwrap_or(DVec3::NAN)
        } else {
            mean(self.vent.iter().map(|&n| positions_m[n as usize]))
        }
    }

    /// The skirt cut at the attachments of lines, in the order of the lines; empty where lines are not attached to the skirt.
    fn find_gores(&self) -> Vec<Vec<u32>> {
        let count = self.skirt.len();
        let place_of = |node: u32| self.skirt.iter().position(|&n| n == node);
        let Some(places) = self
            .lines
            .iter()
            .map(|line| place_of(line.attachment))
            .collect::<Option<Vec<usize>>>()
            .filter(|places| places.len() >= 2)
        else {
            return Vec::new();
        };
        // The loop may run either way round.
        let ahead = |from: usize, to: usize| (to + count - from) % count;
        let forward: usize = (0..places.len())
            .map(|k| ahead(places[k], places[(k + 1) % places.len()]))
            .sum();
        (0..places.len())
            .map(|k| {
                let (from, to) = (places[k], places[(k + 1) % places.len()]);
                if forward == count {
                    (0..=ahead(from, to))
                        .map(|i| self.skirt[(from + i) % count])
                        .collect()
                } else {
                    (0..=ahead(to, from))
                        .map(|i| self.skirt[(from + count - i) % count])
                        .collect()
                }
            })
            .collect()
    }
}

#[cfg(test)]
#[path = "outline_tests.rs"]
mod tests;
