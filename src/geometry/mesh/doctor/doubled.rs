//! Findings of what lies upon each other: vertices of seams, faces.

use super::common::{CROSSING_DEPTH, Common};
use super::examination::{Finding, Kind, Marks};
use super::near;
use super::seams::{self, Hanging};
use super::words::{Words, counted};
use crate::sets::Sets;

/// Distance below which borders with other vertices count as a seam, as a share of the edge that vertices lie at: as far as the chords of a
/// quarter of a circle in five lie off it.
const SEAM: f64 = 0.05;

/// The same, as a share of the shortest edge at a vertex.
const SEAM_AT_VERTEX: f64 = 0.25;

/// Seams that are not joined: vertices upon vertices, and vertices upon edges.
pub(super) fn seams(words: &Words, common: &Common) -> Vec<Finding> {
    let doubled = vertices(words, common);
    let hanging = hanging_nodes(words, common);
    let both = [&doubled, &hanging];
    let farthest_m = both.iter().filter_map(|f| f.as_ref().map(|f| f.1));
    let farthest_m = farthest_m.fold(0.0, f64::max);
    // What lies together exactly is joined by any tolerance; this one is small against all else.
    let tolerance_m = (1.5 * farthest_m).max(1e-6 * common.median_edge_m);
    let findings = [doubled, hanging].into_iter().flatten();
    findings
        .map(|(finding, _)| Finding {
            remedy: format!("weld_tolerance_m = {tolerance_m:.1e} joins them"),
            ..finding
        })
        .collect()
}

/// How far apart things are at most, in words.
fn apart(farthest_m: f64, none: &str) -> String {
    if farthest_m > 0.0 {
        format!("at most {farthest_m:.1e} m apart")
    } else {
        none.to_owned()
    }
}

fn vertices(words: &Words, common: &Common) -> Option<(Finding, f64)> {
    let mut on_border = vec![false; common.places_m.len()];
    for node in common.borders.iter().flatten() {
        on_border[*node as usize] = true;
    }
    let mut is_doubled = vec![false; common.places_m.len()];
    let mut first: Option<[u32; 2]> = None;
    let mut farthest_m: f64 = 0.0;
    let mut sets = Sets::new(common.places_m.len());
    near::together(&common.places_m, &common.reaches_m, |a, b, apart_m| {
        if on_border[a] || on_border[b] {
            let pair = [a as u32, b as u32];
            first = Some(first.map_or(pair, |known| known.min(pair)));
            farthest_m = farthest_m.max(apart_m);
            is_doubled[a] = true;
            is_doubled[b] = true;
            sets.join(pair[0], pair[1]);
        }
    });
    let first = first?;
    let firsts = sets.into_firsts();
    let count = (0..firsts.len())
        .filter(|&n| firsts[n] as usize != n)
        .count();
    let nodes = (0..is_doubled.len() as u32).filter(|n| is_doubled[*n as usize]);
    let finding = Finding {
        kind: Kind::DoubledVertices,
        count,
        what: format!(
            "{} upon others along open borders, where the mesh is not joined: first {}, {}",
            counted(count, "vertex lies", "vertices lie"),
            words.nodes(&first),
            apart(farthest_m, "all of them in the same places")
        ),
        remedy: String::new(),
        marks: Marks {
            nodes: nodes.collect(),
            ..Marks::default()
        },
        is_at_start: false,
    };
    Some((finding, farthest_m))
}

fn hanging_nodes(words: &Words, common: &Common) -> Option<(Finding, f64)> {
    let triangles = &words.subject.surface.triangles;
    let of_edge = |nodes: [u32; 2]| {
        let [a, b] = nodes.map(|node| common.places_m[node as usize]);
        SEAM * a.distance(b)
    };
    let reach = |edge: [u32; 2], vertex: u32| {
        of_edge(edge).min(SEAM_AT_VERTEX * common.shortest_m[vertex as usize])
    };
    let hanging = seams::hanging(
        &common.places_m,
        triangles,
        &common.edges,
        of_edge,
        reach,
        0.0,
    );
    let first = hanging.first()?;
    let mut nodes: Vec<u32> = hanging.iter().map(|h| h.vertex).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut edges: Vec<[u32; 2]> = hanging.iter().map(|h| h.edge).collect();
    edges.dedup();
    let count = nodes.len();
    let farthest_m = hanging.iter().map(|Hanging { apart_m, .. }| *apart_m);
    let farthest_m = farthest_m.fold(0.0, f64::max);
    let finding = Finding {
        kind: Kind::HangingNodes,
        count,
        what: format!(
            "{} upon edges of others along open borders, where the mesh is not joined and has other vertices: first {} {}, {}",
            counted(count, "vertex lies", "vertices lie"),
            words.nodes(&[first.vertex]),
            words.between(first.edge),
            apart(farthest_m, "all of them on the edges")
        ),
        remedy: String::new(),
        marks: Marks {
            nodes,
            edges,
            ..Marks::default()
        },
        is_at_start: false,
    };
    Some((finding, farthest_m))
}

pub(super) fn faces(words: &Words, common: &Common) -> Option<Finding> {
    let triangles = &words.subject.surface.triangles;
    let mut keys: Vec<([u32; 3], u32)> = triangles
        .iter()
        .enumerate()
        .map(|(number, nodes)| {
            let mut places = nodes.map(|node| common.together[node as usize]);
            places.sort_unstable();
            (places, number as u32)
        })
        .collect();
    keys.sort_unstable();
    let mut doubled: Vec<u32> = Vec::new();
    let mut count = 0;
    for same in keys
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() > 1)
    {
        count += same.len() - 1;
        doubled.extend(same.iter().map(|(_, number)| *number));
    }
    doubled.sort_unstable();
    let first = *doubled.first()?;
    Some(Finding {
        kind: Kind::DoubledFaces,
        count,
        what: format!(
            "{} upon another, so that mass and stiffness count twice: first {}",
            counted(count, "triangle lies", "triangles lie"),
            words.triangle(first)
        ),
        remedy: "keep one of each in the program that drew the mesh".to_owned(),
        marks: Marks {
            triangles: doubled,
            ..Marks::default()
        },
        is_at_start: false,
    })
}

/// Triangles that cover others in part.
pub(super) fn overlapping_faces(words: &Words, common: &Common) -> Option<Finding> {
    let triangles = &words.subject.surface.triangles;
    let depth_m = CROSSING_DEPTH * common.median_edge_m;
    let pairs = near::overlapping(&common.places_m, triangles, &common.together, depth_m);
    let &(first, other) = pairs.first()?;
    let mut covering: Vec<u32> = pairs
        .iter()
        .flat_map(|(a, b)| [*a, *b].map(|t| t as u32))
        .collect();
    covering.sort_unstable();
    covering.dedup();
    Some(Finding {
        kind: Kind::OverlappingFaces,
        count: pairs.len(),
        what: format!(
            "{} each other in part, in one plane, so that fabric lies there twice: first {} and {}",
            counted(
                pairs.len(),
                "pair of triangles covers",
                "pairs of triangles cover"
            ),
            words.triangle(first as u32),
            words.triangle(other as u32)
        ),
        remedy: "cut away what lies twice, or draw the layers apart".to_owned(),
        marks: Marks {
            triangles: covering,
            ..Marks::default()
        },
        is_at_start: false,
    })
}
