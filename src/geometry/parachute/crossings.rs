//! What crosses the gaps of a pattern: lines along seams and centre lines, and tapes between them.

use super::pattern::{Path, PatternMesh, Row};

/// From a node over a gap to one under it, each by the number of its row and its own there.
fn across_gap(mesh: &PatternMesh, gore: usize, ends: [(usize, usize); 2]) -> Path {
    let nodes = ends.map(|(row, j)| mesh.node(row, gore, j));
    let [from, to] = [0, 1].map(|end| {
        let at = mesh.rows[ends[end].0].at;
        let across = mesh.places[nodes[end] as usize].across;
        (at.distance_m, across * at.half_width_m)
    });
    Path {
        nodes: nodes.to_vec(),
        rest_m: vec![(to.0 - from.0).hypot(to.1 - from.1)],
    }
}

/// Numbers of the rows over and under every gap.
fn gaps(mesh: &PatternMesh) -> impl Iterator<Item = [usize; 2]> {
    (1..mesh.rows.len())
        .filter(|number| mesh.rows[*number].begins)
        .map(|number| [number - 1, number])
}

fn along(mesh: &PatternMesh, gore: usize, j: impl Fn(&Row) -> usize) -> Vec<Path> {
    let at = |rows: [usize; 2]| rows.map(|number| (number, j(&mesh.rows[number])));
    gaps(mesh)
        .map(|rows| across_gap(mesh, gore, at(rows)))
        .collect()
}

/// Over every gap, along a gore's first seam.
#[must_use]
pub fn along_seam(mesh: &PatternMesh, gore: usize) -> Vec<Path> {
    along(mesh, gore, |_| 0)
}

/// Over every gap, along a gore's centre line.
#[must_use]
pub fn along_centre(mesh: &PatternMesh, gore: usize) -> Vec<Path> {
    along(mesh, gore, |row| row.segments)
}

/// Over every gap, so many tapes at even distances from seam to seam; where nodes are few, fewer of them. The second half of a gore is the first one mirrored.
#[must_use]
pub fn tapes(mesh: &PatternMesh, gore: usize, per_gore: usize) -> Vec<Path> {
    let mut found = Vec::new();
    for rows in gaps(mesh) {
        let segments = rows.map(|number| mesh.rows[number].segments);
        // Of the row of fewer nodes the nearest one, and of the other the one nearest to that.
        let few = usize::from(segments[1] < segments[0]);
        let nearest = |share: f64, of: usize| (share * segments[of] as f64).round() as usize;
        let mut last = None;
        for tape in 1..=per_gore.div_ceil(2) {
            let share = 2.0 * tape as f64 / (per_gore + 1) as f64;
            let mut j = [nearest(share, few); 2];
            j[1 - few] = nearest(j[few] as f64 / segments[few] as f64, 1 - few);
            let at_a_seam = j.contains(&0);
            if at_a_seam || last == Some(j) {
                continue;
            }
            last = Some(j);
            let at = |j: [usize; 2]| [0, 1].map(|end| (rows[end], j[end]));
            found.push(across_gap(mesh, gore, at(j)));
            if j != segments {
                let mirrored = [0, 1].map(|end| 2 * segments[end] - j[end]);
                found.push(across_gap(mesh, gore, at(mirrored)));
            }
        }
    }
    found
}
