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
    /// Node of the apex, where there is no vent.
    pub apex: usize,
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
        let confluence = canopy.confluence_m(&structure.positions_m);
        let middle = mean(lines.iter().map(|line| place(line.attachment)));
        let axis = Axis::new(confluence, middle);
        lines.sort_by(|a, b| {
            let azimuth = |line: &Line| axis.azimuth(place(line.attachment));
            azimuth(a).total_cmp(&azimuth(b))
        });

        let mut outline = Self {
            apex: canopy.apex,
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

    /// The apex, or the middle of the vent [m].
    pub fn apex(&self, positions_m: &[DVec3]) -> DVec3 {
        if self.vent.is_empty() {
            positions_m.get(self.apex).copied().unwrap_or(DVec3::NAN)
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
mod tests {
    use super::*;
    use crate::cloth::Triangle;
    use crate::lines::Cable;

    const SIDES: u32 = 24;

    /// Nodes of rings round the x axis, `SIDES` each, at (x, radius).
    fn rings(places: &[(f64, f64)]) -> Vec<DVec3> {
        let node = |&(x, radius): &(f64, f64)| {
            (0..SIDES).map(move |k| {
                let angle = TAU * f64::from(k) / f64::from(SIDES);
                DVec3::new(x, radius * angle.cos(), radius * angle.sin())
            })
        };
        places.iter().flat_map(node).collect()
    }

    /// Triangles between rings `inner` and `inner + 1`, without the quadrilaterals that `left_out` names.
    fn band(inner: u32, left_out: &[u32]) -> Vec<[u32; 3]> {
        (0..SIDES)
            .filter(|k| !left_out.contains(k))
            .flat_map(|k| {
                let next = (k + 1) % SIDES;
                let [a, b] = [k, next].map(|n| inner * SIDES + n);
                let [c, d] = [k, next].map(|n| (inner + 1) * SIDES + n);
                [[a, c, d], [a, d, b]]
            })
            .collect()
    }

    /// A disk with a vent, a gap and a band, eight lines of two segments each that go on across the gap, and one slot in the disk.
    fn disk_gap_band(turned: bool) -> (Structure, Canopy) {
        let mut positions_m = rings(&[(1.0, 0.1), (1.0, 0.5), (1.0, 1.0), (0.9, 1.0), (0.6, 1.0)]);
        let fabric = positions_m.len();
        let confluence = positions_m.len() as u32;
        positions_m.push(DVec3::new(-2.0, 0.0, 0.0));
        let mut triangles = band(0, &[]);
        triangles.extend(band(1, &[5]));
        triangles.extend(band(3, &[]));
        let mut structure = Structure {
            positions_m,
            triangles: triangles
                .iter()
                .map(|nodes| {
                    Triangle::laid_out(
                        *nodes,
                        [DVec3::ZERO, DVec3::Y, DVec3::Z],
                        DVec3::Y,
                        [0.0; 2],
                    )
                    .unwrap()
                })
                .collect(),
            ..Structure::default()
        };
        structure.masses_kg = vec![0.0; structure.node_count()];
        let cable = Cable::linear(1e-6, 1000.0, 1e9);
        for k in (0..SIDES).step_by(3) {
            let (skirt, upper, disk) = (4 * SIDES + k, 3 * SIDES + k, 2 * SIDES + k);
            let middle = structure.positions_m.len() as u32;
            let at = 0.5 * (structure.positions_m[skirt as usize] + DVec3::new(-2.0, 0.0, 0.0));
            structure.positions_m.push(at);
            structure.masses_kg.push(0.0);
            structure.add_cable(
                &[disk, upper, skirt],
                &[0.1, 0.3],
                &cable,
                CableKind::SuspensionLine,
            );
            structure.add_cable(
                &[skirt, middle, confluence],
                &[1.0, 1.0],
                &cable,
                CableKind::SuspensionLine,
            );
        }
        if turned {
            let turn = glam::DQuat::from_rotation_z(0.3);
            for place in &mut structure.positions_m {
                *place = turn * *place;
            }
        }
        let canopy = Canopy {
            nominal_area_m2: PI,
            nominal_diameter_m: 2.0,
            canopy_node_count: fabric,
            apex: 0,
            lower_end: Some(fabric),
            loading: None,
        };
        (structure, canopy)
    }

    #[test]
    fn a_disk_gap_band_with_a_slot_has_all_its_parts() {
        for turned in [false, true] {
            let (structure, canopy) = disk_gap_band(turned);
            let outline = Outline::new(&structure, &canopy);
            let ring = |nodes: &[u32]| -> Option<u32> {
                let first = nodes.first()? / SIDES;
                (nodes.len() == SIDES as usize && nodes.iter().all(|n| n / SIDES == first))
                    .then_some(first)
            };
            assert_eq!(ring(&outline.skirt), Some(4));
            assert_eq!(ring(&outline.vent), Some(0));
            assert_eq!(outline.gaps.len(), 1);
            assert_eq!(ring(&outline.gaps[0][0]), Some(3));
            // The slot opens into the gap: its border is part of the disk's.
            assert_eq!(outline.gaps[0][1].len(), SIDES as usize + 2);
            assert_eq!(outline.lines.len(), 8);
            for (k, line) in outline.lines.iter().enumerate() {
                assert_eq!(line.attachment, 4 * SIDES + 3 * k as u32);
                assert_eq!((line.lower.len(), line.upper.len()), (2, 2));
            }
            assert_eq!(outline.gores.len(), 8);
            for (k, gore) in outline.gores.iter().enumerate() {
                assert_eq!(gore.len(), 4);
                assert_eq!(gore[0], outline.lines[k].attachment);
                assert_eq!(gore[3], outline.lines[(k + 1) % 8].attachment);
            }
            let apex = outline.apex(&structure.positions_m);
            let expected = structure.positions_m[..SIDES as usize]
                .iter()
                .sum::<DVec3>();
            assert!(apex.distance(expected / f64::from(SIDES)) < 1e-12);
            assert_eq!(outline.at_vent.len(), 2 * SIDES as usize);
        }
    }

    /// A square hole in the fabric does not run round the axis.
    #[test]
    fn a_hole_beside_the_axis_is_a_slot() {
        let positions_m = rings(&[(1.0, 0.2), (1.0, 0.5), (1.0, 0.7), (0.8, 1.0)]);
        let mut triangles = band(0, &[]);
        triangles.extend(band(1, &[7]));
        triangles.extend(band(2, &[]));
        let loops = border_loops(&triangles);
        assert_eq!(loops.len(), 3);
        let axis = Axis::new(DVec3::ZERO, DVec3::X);
        let mut turns: Vec<(usize, i64)> = loops
            .iter()
            .map(|border| {
                let places: Vec<DVec3> = border.iter().map(|&n| positions_m[n as usize]).collect();
                (border.len(), axis.turns(&places).abs())
            })
            .collect();
        turns.sort_unstable();
        assert_eq!(turns, [(4, 0), (SIDES as usize, 1), (SIDES as usize, 1)]);
    }

    /// Two holes that touch at a node are two loops.
    #[test]
    fn loops_that_touch_are_cut_there() {
        let mut triangles = band(0, &[]);
        triangles.extend(band(1, &[7]));
        triangles.extend(band(2, &[8]));
        triangles.extend(band(3, &[]));
        let mut lengths: Vec<usize> = border_loops(&triangles).iter().map(Vec::len).collect();
        lengths.sort_unstable();
        assert_eq!(lengths, [4, 4, SIDES as usize, SIDES as usize]);
    }
}
