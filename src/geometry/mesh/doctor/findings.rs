//! Findings of an examination, in words with numbers and places.

use glam::DVec3;

use super::common::{CROSSING_DEPTH, Common};
use super::doubled;
use super::examination::{Examination, Finding, Kind, Marks, Piece, Subject, Use};
use super::near;
use super::topology;
use super::words::{Words, counted};

/// Smallest and largest box around a mesh [m]: what is beyond was read in another unit.
const SIZES_M: [f64; 2] = [1e-3, 1e3];

/// Area over S₀ beyond which either is in another unit.
const LARGEST_AREA_RATIO: f64 = 10.0;

/// Least size of a mesh in cells of the air.
const FEWEST_CELLS: f64 = 2.0;

/// A piece whose borders are shorter than this, over the root of its area, is meant to be closed: the mouth of a hemisphere has 2.5.
const HOLE: f64 = 0.5;

/// All findings, in the order of their kinds.
pub(super) fn all(subject: &Subject, common: &Common, examination: &Examination) -> Vec<Finding> {
    let words = Words::new(subject, examination.size_m);
    let mut findings = Vec::new();
    findings.extend(doubled::seams(&words, common));
    findings.extend(doubled::faces(&words, common));
    findings.extend(doubled::overlapping_faces(&words, common));
    findings.extend(non_manifold_edges(&words, common));
    findings.extend(orientation(&words, common));
    findings.extend(self_crossing(&words, common));
    match subject.used_as {
        Use::Fabric { .. } => findings.extend(pieces(&words, &examination.pieces)),
        Use::RigidBody => findings.extend(holes(&words, common, examination)),
    }
    findings.extend(size(subject, examination));
    findings
}

fn non_manifold_edges(words: &Words, common: &Common) -> Option<Finding> {
    let shared = || common.edges.iter().filter(|uses| uses.len() > 2);
    let edges: Vec<[u32; 2]> = shared().map(|uses| uses[0].nodes).collect();
    let most = shared().map(<[_]>::len).max()?;
    Some(Finding {
        kind: Kind::NonManifoldEdges,
        count: edges.len(),
        what: format!(
            "{} of up to {most} triangles, as where a rib meets a skin: first between {}",
            counted(edges.len(), "edge", "edges"),
            words.nodes(&edges[0])
        ),
        remedy: "remove the fabric that does not belong there".to_owned(),
        marks: Marks {
            edges,
            ..Marks::default()
        },
        is_at_start: false,
    })
}

fn orientation(words: &Words, common: &Common) -> Option<Finding> {
    let turned = topology::turned(&common.edges, &common.areas_m2);
    let (count, what) = match (turned.edges.first(), turned.triangles.first()) {
        (Some(edge), _) => (
            turned.edges.len(),
            format!(
                "the surface has no two sides, as a Möbius strip has none: no turning of triangles helps between {}",
                words.nodes(edge)
            ),
        ),
        (None, Some(&first)) => {
            let count = turned.triangles.len();
            (
                count,
                format!(
                    "{} against {}, so that pressure acts on the other side: first {}",
                    counted(count, "triangle runs", "triangles run"),
                    if count == 1 {
                        "its neighbours"
                    } else {
                        "their neighbours"
                    },
                    words.triangle(first)
                ),
            )
        }
        (None, None) => return None,
    };
    Some(Finding {
        kind: Kind::Orientation,
        count,
        what,
        remedy: if turned.edges.is_empty() {
            "orient_triangles = true turns them"
        } else {
            "cut the surface where it should end, in the program that drew the mesh"
        }
        .to_owned(),
        marks: Marks {
            edges: turned.edges,
            triangles: turned.triangles,
            ..Marks::default()
        },
        is_at_start: false,
    })
}

fn self_crossing(words: &Words, common: &Common) -> Option<Finding> {
    let subject = words.subject;
    let low = subject
        .start_m
        .iter()
        .copied()
        .fold(DVec3::INFINITY, DVec3::min);
    let start_m: Vec<DVec3> = subject.start_m.iter().map(|p| *p - low).collect();
    let edges: Vec<[u32; 2]> = common.edges.iter().map(|uses| uses[0].nodes).collect();
    let depth_m = CROSSING_DEPTH * common.median_edge_m;
    let triangles = &subject.surface.triangles;
    let crossings = near::crossings(&start_m, &edges, triangles, &common.together, depth_m);
    let &(edge, triangle) = crossings.first()?;
    let mut crossing: Vec<[u32; 2]> = crossings.iter().map(|(edge, _)| edges[*edge]).collect();
    crossing.dedup();
    let mut crossed: Vec<u32> = crossings.iter().map(|(_, t)| *t as u32).collect();
    crossed.sort_unstable();
    crossed.dedup();
    let count = crossing.len();
    let [a, b] = edges[edge].map(|node| subject.start_m[node as usize]);
    let through = match subject.numbers {
        None => String::new(),
        Some((nodes, numbers)) => format!(
            ", between vertices {} and {} through triangle {}",
            nodes[edges[edge][0] as usize] + 1,
            nodes[edges[edge][1] as usize] + 1,
            numbers[triangle] + 1
        ),
    };
    Some(Finding {
        kind: Kind::SelfCrossing,
        count,
        what: format!(
            "{} through the mesh itself: first near {}{through}",
            counted(count, "edge passes", "edges pass"),
            words.place(0.5 * (a + b))
        ),
        remedy: "draw the parts apart, or join them where they meet".to_owned(),
        marks: Marks {
            edges: crossing,
            triangles: crossed,
            ..Marks::default()
        },
        is_at_start: true,
    })
}

fn pieces(words: &Words, pieces: &[Piece]) -> Vec<Finding> {
    let told = |piece: &Piece| {
        format!(
            "the one of {} ({:.3} m²) about {}",
            counted(piece.triangles.len(), "triangle", "triangles"),
            piece.area_m2,
            words.place(words.middle(piece.triangles[piece.triangles.len() / 2]))
        )
    };
    let (held, loose): (Vec<&Piece>, Vec<&Piece>) = pieces.iter().partition(|p| p.is_anchored);
    let marks = |pieces: &[&Piece]| Marks {
        triangles: pieces
            .iter()
            .flat_map(|p| p.triangles.iter().copied())
            .collect(),
        ..Marks::default()
    };
    let mut findings = Vec::new();
    if let [_, second, ..] = held[..] {
        findings.push(Finding {
            kind: Kind::Pieces,
            count: held.len(),
            what: format!(
                "{} pieces of fabric without a common node, which nothing but lines joins: beside the largest, {}",
                held.len(),
                told(second)
            ),
            remedy: "join them in the mesh, by common nodes".to_owned(),
            marks: marks(&held[1..]),
            is_at_start: false,
        });
    }
    if let Some(first) = loose.first() {
        findings.push(Finding {
            kind: Kind::LoosePieces,
            count: loose.len(),
            what: format!(
                "{} neither a held node nor a line and would fly off: {}",
                counted(loose.len(), "piece of fabric has", "pieces of fabric have"),
                told(first)
            ),
            remedy: "join what is loose to the rest, hold one of its nodes, or remove it"
                .to_owned(),
            marks: marks(&loose),
            is_at_start: false,
        });
    }
    findings
}

fn holes(words: &Words, common: &Common, examination: &Examination) -> Option<Finding> {
    let mut piece_of = vec![usize::MAX; common.places_m.len()];
    for (number, piece) in examination.pieces.iter().enumerate() {
        for triangle in &piece.triangles {
            for node in words.subject.surface.triangles[*triangle as usize] {
                piece_of[node as usize] = number;
            }
        }
    }
    let mut lengths_m = vec![0.0; examination.pieces.len()];
    for border in &examination.borders {
        lengths_m[piece_of[border.nodes[0] as usize]] += border.length_m;
    }
    let is_hole = |node: u32| {
        let piece = piece_of[node as usize];
        lengths_m[piece] < HOLE * examination.pieces[piece].area_m2.sqrt()
    };
    let holes = examination.borders.iter().filter(|b| is_hole(b.nodes[0]));
    let first = holes.clone().next()?;
    let count = holes.clone().count();
    Some(Finding {
        kind: Kind::Holes,
        count,
        what: format!(
            "{} in a body that is closed but for {}: the longest is {:.3e} m around, {}. A body with a hole counts as an open surface, without volume",
            counted(count, "opening", "openings"),
            if count == 1 { "it" } else { "them" },
            first.length_m,
            words.nodes(&first.nodes[..1])
        ),
        remedy: "close the holes in the program that drew the mesh".to_owned(),
        marks: Marks {
            edges: holes
                .flat_map(|border| border.nodes.windows(2).map(|pair| [pair[0], pair[1]]))
                .collect(),
            ..Marks::default()
        },
        is_at_start: false,
    })
}

fn size(subject: &Subject, examination: &Examination) -> Option<Finding> {
    let longest_m = examination.size_m.max_element();
    let [smallest_m, largest_m] = SIZES_M;
    let mut reasons = Vec::new();
    if !(smallest_m..=largest_m).contains(&longest_m) {
        reasons.push(format!(
            "the mesh is {longest_m:.3e} m long, but canopies and bodies have {smallest_m} to {largest_m} m"
        ));
    }
    if let Use::Fabric {
        nominal_area_m2: Some(nominal_m2),
        ..
    } = subject.used_as
    {
        let ratio = examination.area_m2 / nominal_m2;
        if !(1.0 / LARGEST_AREA_RATIO..=LARGEST_AREA_RATIO).contains(&ratio) {
            let diameter_m = (4.0 * nominal_m2 / std::f64::consts::PI).sqrt();
            reasons.push(format!(
                "the mesh has an area of {:.3e} m², {ratio:.1e} times the nominal area of {nominal_m2} m² (D_0 = {diameter_m:.3} m)",
                examination.area_m2
            ));
        }
    }
    if let Some(cell_m) = subject
        .cell_size_m
        .filter(|cell| longest_m < FEWEST_CELLS * cell)
    {
        reasons.push(format!(
            "the mesh is {:.1e} cells of {cell_m} m long, so that the air hardly sees it",
            longest_m / cell_m
        ));
    }
    (!reasons.is_empty()).then(|| Finding {
        kind: Kind::Size,
        count: 1,
        what: reasons.join(", and "),
        remedy: "give the metres per unit of the file as scale (0.001 for mm, 0.0254 for inches)"
            .to_owned(),
        marks: Marks::default(),
        is_at_start: false,
    })
}
