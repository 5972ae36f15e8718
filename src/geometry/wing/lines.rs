//! Lines: from the attachments level by level down to the risers, and the risers to the points where they are held.

use glam::DVec3;

use super::builder::Builder;
use super::parts::LineKind;
use super::plan::Row;
use super::section::Side;
use crate::cloth::Guide;
use crate::frame::CableKind;

/// Cable between two nodes, and its length beyond their distance [m].
struct Piece {
    nodes: [u32; 2],
    extra_m: f64,
}

impl Builder<'_> {
    /// Adds the lines of all rows and returns the held nodes, right and left.
    pub(super) fn add_lines(&mut self) -> [u32; 2] {
        let plan = self.plan;
        let right = plan.hang_point_m;
        let points =
            [right, DVec3::new(right.x, -right.y, right.z)].map(|p| self.structure.add_node(p));
        for node in points {
            self.structure.held[node as usize] = true;
        }
        for (number, row) in plan.rows.iter().enumerate() {
            for half in 0..2 {
                self.add_row(number, row, half, points[half]);
            }
        }
        points
    }

    /// Keeps the middle from drifting: along x as stiffly as the plan says, along y, where symmetry leaves nothing to carry, alike.
    pub(super) fn add_guides(&mut self) {
        let Some(stiffness) = self.plan.pitch_guide_n_m else {
            return;
        };
        let ribs = self.counted(if self.plan.cells.is_multiple_of(2) {
            0
        } else {
            1
        });
        let [right, left] = ribs.map(|rib| {
            let outline = &self.outlines[rib];
            [outline[0], outline[self.fineness.along_chord]]
        });
        let nodes = if right == left {
            vec![right]
        } else {
            vec![right, left]
        };
        let share = stiffness / nodes.len() as f64;
        for [nose, tail] in nodes {
            for (node, axes) in [(nose, DVec3::new(1.0, 1.0, 0.0)), (tail, DVec3::Y)] {
                let anchor_m = self.position(node);
                self.structure.guides.push(Guide {
                    node,
                    anchor_m,
                    stiffness_n_m: axes * share,
                });
            }
        }
    }

    fn add_row(&mut self, number: usize, row: &Row, half: usize, hang: u32) {
        let node = |(from_middle, place): (usize, f64)| {
            let j = self.places.nearest(Side::Lower, place);
            let k = if place >= 1.0 {
                self.fineness.along_chord
            } else {
                self.on_outline(Side::Lower, j)
            };
            self.outlines[self.counted(from_middle)[half]][k]
        };
        let attachments: Vec<u32> = row.attachments().map(node).collect();
        let mean = |nodes: &[u32], builder: &Self| {
            nodes.iter().map(|&n| builder.position(n)).sum::<DVec3>() / nodes.len() as f64
        };
        let hang_m = self.position(hang);
        let towards = (mean(&attachments, self) - hang_m).normalize_or(DVec3::Z);
        let riser_m = hang_m + towards * row.riser_length_m;
        let riser = self.structure.add_node(riser_m);
        // Every node above with the attachments that it carries.
        let mut above: Vec<(u32, Vec<u32>)> = attachments.iter().map(|&n| (n, vec![n])).collect();
        for (level, lines) in row.levels.iter().enumerate() {
            let mut below: Vec<(u32, Vec<u32>)> = Vec::new();
            let mut pieces = Vec::new();
            if lines.joins.is_empty() {
                let ends = above.iter().map(|(node, _)| Piece {
                    nodes: [*node, riser],
                    extra_m: 0.0,
                });
                pieces.extend(ends);
            } else {
                let mut rest = &above[..];
                for &count in &lines.joins {
                    let (group, others) = rest.split_at(count.min(rest.len()));
                    rest = others;
                    let carried: Vec<u32> =
                        group.iter().flat_map(|(_, c)| c.iter().copied()).collect();
                    let place = riser_m.lerp(mean(&carried, self), lines.height);
                    let node = self.structure.add_node(place);
                    pieces.extend(group.iter().map(|(upper, _)| Piece {
                        nodes: [*upper, node],
                        extra_m: 0.0,
                    }));
                    below.push((node, carried));
                }
            }
            for piece in pieces {
                let kind = LineKind::Line { row: number, level };
                self.add_piece(&piece, &lines.cable, kind);
            }
            above = below;
        }
        let piece = Piece {
            nodes: [riser, hang],
            extra_m: row.trim_m,
        };
        self.add_piece(&piece, &row.riser, LineKind::Riser { row: number });
    }

    fn add_piece(&mut self, piece: &Piece, cable: &crate::lines::Cable, kind: LineKind) {
        let [a, b] = piece.nodes.map(|n| self.position(n));
        let length_m = a.distance(b) + piece.extra_m;
        self.structure
            .add_cable(&piece.nodes, &[length_m], cable, CableKind::SuspensionLine);
        self.line_kinds.push(kind);
    }
}
