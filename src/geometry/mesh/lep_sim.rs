//! Wings of `lep-sim.json`, version 1: what LEparagliding Studio's engine writes for its own simulation.
//!
//! There is no specification; what stands in the file was read from its writer and its reader (github.com/Kulitorum/LeParagliding, `nurbs_model.cpp` and
//! `playground_sim.cpp`): `version` 1, `unit` "mm", `nodes` of the whole skin (x along the span, z up), `quads` of four of them, `quadSurfaces` (0 upper side,
//! 1 intake, 2 lower side), `ribLoops` (nodes of every rib's outline from the trailing edge around the nose), `ribHoles` (per rib, outlines as points), `straps`
//! (diagonals and mini-ribs: two rows of points, `a` and `b`), `lines` (ends `a` and `b`, `label`, `plan` 1 to 6 for the rows A to F, 0 where unknown, `brake` 0 or
//! 1).
//!
//! Departures: the skin's samples are the nodes of our mesh, as coarse as they are; lines and straps are sewn to the nearest node of the wing and are as long as they
//! then are; intakes are left open; ends of lines that nothing else meets are where the risers are held. x runs aft and y to the side here.

use std::collections::{HashMap, HashSet};

use glam::{DVec2, DVec3};
use serde::Deserialize;

use crate::cloth::{Structure, Triangle};
use crate::fabric::Fabric;
use crate::frame::CableKind;
use crate::geometry::wing::planar;
use crate::lines::Cable;

/// Metres per unit of the file.
const UNIT_M: f64 = 1e-3;

/// Distance within which ends of lines are one knot [m].
const KNOT_M: f64 = 2e-3;

/// Surface of an intake.
const INTAKE: u8 = 1;

/// What stands in the file.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct File {
    version: u32,
    unit: String,
    nodes: Vec<[f64; 3]>,
    quads: Vec<[u32; 4]>,
    #[serde(default)]
    quad_surfaces: Vec<u8>,
    #[serde(default)]
    rib_loops: Vec<Vec<u32>>,
    #[serde(default)]
    rib_holes: Vec<Vec<Vec<[f64; 3]>>>,
    #[serde(default)]
    straps: Vec<Strap>,
    #[serde(default)]
    lines: Vec<Line>,
}

#[derive(Debug, Clone, Deserialize)]
struct Strap {
    a: Vec<[f64; 3]>,
    b: Vec<[f64; 3]>,
}

#[derive(Debug, Clone, Deserialize)]
struct Line {
    a: [f64; 3],
    b: [f64; 3],
    #[serde(default)]
    plan: usize,
    #[serde(default)]
    brake: u8,
}

/// A wing from a file.
#[derive(Debug, Clone)]
pub struct Imported {
    /// Fabric and lines, free of stress as they stand; normals of the skin point outwards.
    pub structure: Structure,
    /// Triangles of the skin, `[triangle_count]`; the others are ribs and straps.
    pub is_skin: Vec<bool>,
    /// Row of every line, `[cable_count]`.
    pub rows: Vec<String>,
    /// Nodes where lines are held.
    pub held: Vec<u32>,
    /// Volume inside skin and intakes as drawn [m³].
    pub volume_m3: f64,
    /// Farthest that the end of a line or strap was moved to a node [m].
    pub moved_max_m: f64,
}

/// Reads the text of a file and sews it of one fabric and one kind of line. The message says what is wrong.
pub fn read(text: &str, fabric: &Fabric, line: &Cable) -> Result<Imported, String> {
    let file: File = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if file.version != 1 || file.unit != "mm" {
        return Err(format!(
            "version {} in `{}` is not known: version 1 in `mm` is",
            file.version, file.unit
        ));
    }
    check(&file)?;
    let aft = aft(&file);
    let place = |p: &[f64; 3]| DVec3::new(aft * p[1], -aft * p[0], p[2]) * UNIT_M;
    let nodes: Vec<DVec3> = file.nodes.iter().map(place).collect();
    let mut sewing = Sewing {
        fabric,
        imported: Imported {
            structure: Structure {
                masses_kg: vec![0.0; nodes.len()],
                held: vec![false; nodes.len()],
                positions_m: nodes,
                membrane: Some(fabric.membrane()),
                thickness_m: fabric.thickness_m,
                yield_stress_pa: fabric.yield_stress_pa,
                ..Structure::default()
            },
            is_skin: Vec::new(),
            rows: Vec::new(),
            held: Vec::new(),
            volume_m3: 0.0,
            moved_max_m: 0.0,
        },
    };
    sewing.add_skin(&file);
    for (number, outline) in file.rib_loops.iter().enumerate() {
        let holes: Vec<Vec<DVec3>> = file.rib_holes.get(number).map_or_else(Vec::new, |holes| {
            holes
                .iter()
                .map(|hole| hole.iter().map(place).collect())
                .collect()
        });
        sewing.add_rib(number, outline, &holes)?;
    }
    let wing_nodes = sewing.used_nodes();
    for strap in &file.straps {
        let [a, b] = [&strap.a, &strap.b].map(|row| row.iter().map(place).collect::<Vec<_>>());
        sewing.add_strap(&wing_nodes, &a, &b);
    }
    let lines = file.lines.iter().map(|written| {
        let row = match (written.brake, written.plan) {
            (0, plan @ 1..=6) => char::from(b'A' + plan as u8 - 1).to_string(),
            (0, _) => "other".to_owned(),
            _ => "brake".to_owned(),
        };
        (place(&written.a), place(&written.b), row)
    });
    let lines: Vec<_> = lines.collect();
    sewing.add_lines(&wing_nodes, &lines, line)?;
    sewing.drop_idle()
}

fn check(file: &File) -> Result<(), String> {
    let count = file.nodes.len();
    if file.quads.is_empty() || file.rib_loops.is_empty() {
        return Err("there are no quads or no ribLoops: nothing could be inflated".to_owned());
    }
    let outside = |node: &u32| *node as usize >= count;
    for (what, far) in [
        ("quads", file.quads.iter().flatten().find(|n| outside(n))),
        (
            "ribLoops",
            file.rib_loops.iter().flatten().find(|n| outside(n)),
        ),
    ] {
        if let Some(node) = far {
            return Err(format!(
                "{what} name node {node}, but there are {count} (counted from 0)"
            ));
        }
    }
    if let Some(strap) = file.straps.iter().position(|s| s.a.len() != s.b.len()) {
        return Err(format!(
            "strap {strap} (counted from 0) has {} points in `a` and {} in `b`",
            file.straps[strap].a.len(),
            file.straps[strap].b.len()
        ));
    }
    let points = file
        .nodes
        .iter()
        .chain(file.lines.iter().flat_map(|l| [&l.a, &l.b]));
    if points.flatten().any(|c| !c.is_finite()) {
        return Err("a coordinate is not finite".to_owned());
    }
    Ok(())
}

/// Sign of y in the file that points aft: outlines begin at the trailing edge, and the nose is farthest from there.
fn aft(file: &File) -> f64 {
    let sum: f64 = file
        .rib_loops
        .iter()
        .filter_map(|outline| {
            let place = |n: &u32| DVec3::from_array(file.nodes[*n as usize]);
            let tail = place(outline.first()?);
            let far = |n: &&u32| place(n).distance(tail);
            let nose = outline.iter().max_by(|a, b| far(a).total_cmp(&far(b)))?;
            Some(tail.y - place(nose).y)
        })
        .sum();
    if sum < 0.0 { -1.0 } else { 1.0 }
}

struct Sewing<'a> {
    fabric: &'a Fabric,
    imported: Imported,
}

impl Sewing<'_> {
    fn place(&self, node: u32) -> DVec3 {
        self.imported.structure.positions_m[node as usize]
    }

    /// Adds a triangle; one without area is left out, as at trailing edges.
    fn add_triangle(&mut self, nodes: [u32; 3], warp: DVec3, is_skin: bool) {
        let corners = nodes.map(|n| self.place(n));
        let laid = Triangle::laid_out(nodes, corners, warp, self.fabric.initial_strain);
        let Some(triangle) = laid else {
            return;
        };
        let mass = self.fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        for node in nodes {
            self.imported.structure.masses_kg[node as usize] += mass;
        }
        self.imported.structure.triangles.push(triangle);
        self.imported.is_skin.push(is_skin);
    }

    /// Skin, outwards, with its intakes open.
    fn add_skin(&mut self, file: &File) {
        let surface = |quad: usize| file.quad_surfaces.get(quad).copied().unwrap_or(0);
        let mut triangles: Vec<([u32; 3], bool)> = Vec::new();
        for (number, &[a, b, c, d]) in file.quads.iter().enumerate() {
            // Alternate diagonals do not favour a direction.
            let halves = if number.is_multiple_of(2) {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for nodes in halves {
                let [p, q, r] = nodes;
                if p != q && q != r && r != p {
                    triangles.push((nodes, surface(number) == INTAKE));
                }
            }
        }
        turn_alike(&mut triangles);
        let middle = self.imported.structure.positions_m.iter().sum::<DVec3>()
            / self.imported.structure.node_count() as f64;
        let volume: f64 = triangles
            .iter()
            .map(|(nodes, _)| {
                let [a, b, c] = nodes.map(|n| self.place(n) - middle);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        self.imported.volume_m3 = volume.abs();
        for (mut nodes, is_open) in triangles {
            if volume < 0.0 {
                nodes.swap(1, 2);
            }
            if !is_open {
                self.add_triangle(nodes, DVec3::X, true);
            }
        }
    }

    fn add_rib(
        &mut self,
        number: usize,
        outline: &[u32],
        holes: &[Vec<DVec3>],
    ) -> Result<(), String> {
        let mut nodes: Vec<u32> = Vec::new();
        for &node in outline {
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        let places: Vec<DVec3> = nodes.iter().map(|n| self.place(*n)).collect();
        if places.len() < 3 {
            return Ok(());
        }
        // The plane of the outline by its area.
        let middle = places.iter().sum::<DVec3>() / places.len() as f64;
        let area: DVec3 = (0..places.len())
            .map(|i| (places[i] - middle).cross(places[(i + 1) % places.len()] - middle))
            .sum();
        let reach = places
            .iter()
            .map(|p| p.distance(middle))
            .fold(0.0, f64::max);
        let normal = area.normalize_or_zero();
        if area.length() < 1e-4 * reach * reach {
            // A tip that is closed to a line.
            return Ok(());
        }
        let along = (places[0] - middle).reject_from(normal).normalize_or_zero();
        let up = normal.cross(along);
        let flat = |p: &DVec3| DVec2::new((*p - middle).dot(along), (*p - middle).dot(up));
        let ring: Vec<DVec2> = places.iter().map(flat).collect();
        let cut: Vec<Vec<DVec2>> = holes
            .iter()
            .filter(|hole| hole.len() >= 3)
            .map(|hole| thinned(&hole.iter().map(flat).collect::<Vec<_>>(), mean_edge(&ring)))
            .collect();
        let filled = planar::fill(&ring, &cut, &[]).ok_or_else(|| {
            format!("rib {number} (counted from 0) cannot be filled with triangles: its outline crosses itself or a hole")
        })?;
        for point in &filled.points[nodes.len()..] {
            let node = self
                .imported
                .structure
                .add_node(middle + along * point.x + up * point.y);
            nodes.push(node);
        }
        for triangle in &filled.triangles {
            self.add_triangle(triangle.map(|i| nodes[i as usize]), along, false);
        }
        Ok(())
    }

    /// Nodes that fabric has.
    fn used_nodes(&self) -> Vec<u32> {
        let triangles = self.imported.structure.triangles.iter();
        let used: HashSet<u32> = triangles.flat_map(|t| t.nodes).collect();
        let mut used: Vec<u32> = used.into_iter().collect();
        used.sort_unstable();
        used
    }

    fn nearest(&self, among: &[u32], place: DVec3) -> Option<(u32, f64)> {
        let pairs = among.iter().map(|n| (*n, self.place(*n).distance(place)));
        pairs.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn add_strap(&mut self, among: &[u32], a: &[DVec3], b: &[DVec3]) {
        let sewn: Vec<[u32; 2]> = a
            .iter()
            .zip(b)
            .filter_map(|(a, b)| {
                let ends = [self.nearest(among, *a)?, self.nearest(among, *b)?];
                let moved = ends[0].1.max(ends[1].1);
                self.imported.moved_max_m = self.imported.moved_max_m.max(moved);
                Some(ends.map(|end| end.0))
            })
            .collect();
        for pair in sewn.windows(2) {
            let ([p, q], [s, r]) = (pair[0], pair[1]);
            let warp = self.place(q) - self.place(p);
            for nodes in [[p, q, r], [p, r, s]] {
                let [x, y, z] = nodes;
                if x != y && y != z && z != x {
                    self.add_triangle(nodes, warp, false);
                }
            }
        }
    }

    /// Lines between knots, those at the wing sewn to its nearest node.
    fn add_lines(
        &mut self,
        among: &[u32],
        lines: &[(DVec3, DVec3, String)],
        cable: &Cable,
    ) -> Result<(), String> {
        let mut knots: Vec<(DVec3, usize)> = Vec::new();
        let mut knot = |place: DVec3| -> usize {
            let known = knots.iter().position(|(at, _)| at.distance(place) < KNOT_M);
            let knot = known.unwrap_or_else(|| {
                knots.push((place, 0));
                knots.len() - 1
            });
            knots[knot].1 += 1;
            knot
        };
        let ends: Vec<[usize; 2]> = lines.iter().map(|(a, b, _)| [knot(*a), knot(*b)]).collect();
        // Upper ends: knots that no line leaves upwards; lower ends: none leaves downwards.
        let mut has_above = vec![false; knots.len()];
        let mut has_below = vec![false; knots.len()];
        for &[a, b] in &ends {
            // Shorter than a knot: no line, and nothing above or below it.
            if a == b {
                continue;
            }
            let (up, down) = if knots[a].0.z > knots[b].0.z {
                (a, b)
            } else {
                (b, a)
            };
            has_above[down] = true;
            has_below[up] = true;
        }
        let mut nodes = Vec::with_capacity(knots.len());
        for (number, (place, _)) in knots.iter().enumerate() {
            let node = if has_above[number] {
                self.imported.structure.add_node(*place)
            } else {
                let (node, moved) = self
                    .nearest(among, *place)
                    .ok_or_else(|| "there is no fabric to sew lines to".to_owned())?;
                self.imported.moved_max_m = self.imported.moved_max_m.max(moved);
                node
            };
            if !has_below[number] {
                self.imported.structure.held[node as usize] = true;
                self.imported.held.push(node);
            }
            nodes.push(node);
        }
        for (pair, (_, _, row)) in ends.iter().zip(lines) {
            let [a, b] = pair.map(|knot| nodes[knot]);
            let length_m = self.place(a).distance(self.place(b));
            if a == b || length_m <= 0.0 {
                continue;
            }
            let kind = CableKind::SuspensionLine;
            self.imported
                .structure
                .add_cable(&[a, b], &[length_m], cable, kind);
            self.imported.rows.push(row.clone());
        }
        Ok(())
    }

    /// Leaves out nodes that nothing uses: corners between intakes.
    fn drop_idle(self) -> Result<Imported, String> {
        let mut imported = self.imported;
        let structure = &mut imported.structure;
        let mut used = vec![false; structure.node_count()];
        let triangles = structure.triangles.iter().flat_map(|t| t.nodes);
        for node in triangles.chain(structure.cables.iter().flat_map(|c| c.nodes)) {
            used[node as usize] = true;
        }
        let mut number = 0;
        let numbers: Vec<u32> = used
            .iter()
            .map(|used| {
                number += u32::from(*used);
                number.saturating_sub(1)
            })
            .collect();
        let keep = |node: &mut u32| *node = numbers[*node as usize];
        structure
            .triangles
            .iter_mut()
            .flat_map(|t| &mut t.nodes)
            .for_each(keep);
        structure
            .cables
            .iter_mut()
            .flat_map(|c| &mut c.nodes)
            .for_each(keep);
        imported.held.iter_mut().for_each(keep);
        let mut of = used.iter();
        structure
            .positions_m
            .retain(|_| of.next().is_some_and(|u| *u));
        let mut of = used.iter();
        structure
            .masses_kg
            .retain(|_| of.next().is_some_and(|u| *u));
        let mut of = used.iter();
        structure.held.retain(|_| of.next().is_some_and(|u| *u));
        if structure.triangles.is_empty() {
            return Err("no quad has an area".to_owned());
        }
        Ok(imported)
    }
}

/// Turns triangles such that neighbours have the same side out.
fn turn_alike(triangles: &mut [([u32; 3], bool)]) {
    let mut beside: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
    for (number, (nodes, _)) in triangles.iter().enumerate() {
        for i in 0..3 {
            beside
                .entry(edge(nodes[i], nodes[(i + 1) % 3]))
                .or_default()
                .push(number);
        }
    }
    let mut seen = vec![false; triangles.len()];
    for seed in 0..triangles.len() {
        if seen[seed] {
            continue;
        }
        seen[seed] = true;
        let mut front = vec![seed];
        while let Some(number) = front.pop() {
            let nodes = triangles[number].0;
            for i in 0..3 {
                let (a, b) = (nodes[i], nodes[(i + 1) % 3]);
                for &other in &beside[&edge(a, b)] {
                    if seen[other] {
                        continue;
                    }
                    let own = triangles[other].0;
                    // A neighbour turned alike runs along the edge the other way.
                    if (0..3).any(|j| own[j] == a && own[(j + 1) % 3] == b) {
                        triangles[other].0.swap(1, 2);
                    }
                    seen[other] = true;
                    front.push(other);
                }
            }
        }
    }
}

fn mean_edge(ring: &[DVec2]) -> f64 {
    let count = ring.len();
    (0..count)
        .map(|i| ring[i].distance(ring[(i + 1) % count]))
        .sum::<f64>()
        / count as f64
}

/// A ring without points closer than half an edge of the mesh, so that holes are not finer than the rest.
fn thinned(ring: &[DVec2], edge: f64) -> Vec<DVec2> {
    let mut kept: Vec<DVec2> = Vec::new();
    for point in ring {
        if kept
            .last()
            .is_none_or(|last| last.distance(*point) > 0.5 * edge)
        {
            kept.push(*point);
        }
    }
    while kept.len() > 3 && kept[0].distance(kept[kept.len() - 1]) < 0.5 * edge {
        kept.pop();
    }
    if kept.len() < 3 { ring.to_vec() } else { kept }
}
