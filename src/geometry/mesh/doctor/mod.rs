//! What a mesh of others is made of, and what in it would change a run without a word.
//!
//! [`examine`] looks at triangles alone: pieces, open borders, area and size are told of each mesh; what is hardly ever meant is a [`Finding`].
//! [`weld()`] joins vertices that lie together, [`orient()`] turns triangles alike, [`mouth()`] tells where an opening faces. Lengths are in metres; what counts as "together" or "touching" is a share of the mesh's own
//! edges, so that nothing depends on the unit of a file.

mod common;
mod doubled;
mod examination;
mod findings;
pub mod mouth;
mod near;
pub mod orient;
pub mod seams;
mod topology;
pub mod weld;
mod words;

use crate::sets::Sets;
use common::Common;
pub use examination::{Border, Examination, Finding, Kind, Marks, Piece, Subject, Use};
pub use mouth::{Mouth, mouth};
pub use orient::{NoSides, orient};
pub use weld::{TooWide, Welded, weld};

/// Examines a mesh with finite places; the time grows with the number of triangles, not with its square.
#[must_use]
pub fn examine(subject: &Subject) -> Examination {
    let surface = subject.surface;
    let common = Common::new(surface);
    let (low, high) = surface.bounds_m();
    let borders = topology::chains(&common.borders);
    let mut borders: Vec<Border> = borders
        .into_iter()
        .map(|nodes| Border {
            length_m: nodes
                .windows(2)
                .map(|pair| {
                    let [a, b] = [pair[0], pair[1]].map(|n| common.places_m[n as usize]);
                    a.distance(b)
                })
                .sum(),
            nodes,
        })
        .collect();
    borders.sort_by(|a, b| b.length_m.total_cmp(&a.length_m));
    let mut examination = Examination {
        node_count: surface.positions_m.len(),
        triangle_count: surface.triangles.len(),
        pieces: pieces(subject, &common),
        borders,
        area_m2: common.areas_m2.iter().sum(),
        size_m: high - low,
        findings: Vec::new(),
    };
    examination.findings = findings::all(subject, &common, &examination);
    examination
}

fn pieces(subject: &Subject, common: &Common) -> Vec<Piece> {
    let node_count = subject.surface.positions_m.len();
    let mut sets = Sets::new(node_count);
    for &[a, b, c] in &subject.surface.triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut numbers = vec![usize::MAX; node_count];
    let mut pieces: Vec<Piece> = Vec::new();
    for (triangle, nodes) in subject.surface.triangles.iter().enumerate() {
        let first = sets.first(nodes[0]) as usize;
        if numbers[first] == usize::MAX {
            numbers[first] = pieces.len();
            pieces.push(Piece {
                nodes: 0,
                triangles: Vec::new(),
                area_m2: 0.0,
                is_anchored: false,
            });
        }
        let piece = &mut pieces[numbers[first]];
        piece.triangles.push(triangle as u32);
        piece.area_m2 += common.areas_m2[triangle];
    }
    for node in 0..node_count {
        let number = numbers[sets.first(node as u32) as usize];
        if let Some(piece) = pieces.get_mut(number) {
            piece.nodes += 1;
            piece.is_anchored |= match subject.used_as {
                Use::Fabric { anchored, .. } => anchored[node],
                Use::RigidBody => true,
            };
        }
    }
    pieces.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
    pieces
}

#[cfg(test)]
mod tests;
