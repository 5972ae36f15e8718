//! Lines: from the attachments level by level down to the risers, and the risers to the points where they are held.

use glam::DVec3;

use super::builder::Builder;
use super::parts::LineKind;
use super::plan::{JoinPlace, LEAST_LINE_M, Row, WingFault};
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
    pub(super) fn add_lines(&mut self) -> Result<[u32; 2], WingFault> {
        let plan = self.plan;
        let right = plan.hang_point_m;
        let points =
            [right, DVec3::new(right.x, -right.y, right.z)].map(|p| self.structure.add_node(p));
        for node in points {
            self.structure.held[node as usize] = true;
        }
        for (number, row) in plan.rows.iter().enumerate() {
            for half in 0..2 {
                self.add_row(number, row, half, points[half])?;
            }
        }
        Ok(points)
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

    fn add_row(
        &mut self,
        number: usize,
        row: &Row,
        half: usize,
        hang: u32,
    ) -> Result<(), WingFault> {
        let node = |(from_middle, place): (usize, f64)| {
            let j = self.places.nearest(Side::Lower, place);
            let k = self.on_outline(Side::Lower, j);
            self.outlines[self.counted(from_middle)[half]][k]
        };
        let attachments: Vec<u32> = row.attachments().map(node).collect();
        let weight = |number: usize| row.weights.get(number).copied().unwrap_or(1.0);
        let places: Vec<Attachment> = (attachments.iter().enumerate())
            .map(|(number, &node)| Attachment {
                place_m: self.position(node),
                weight: weight(number),
            })
            .collect();
        let hang_m = self.position(hang);
        let towards = (mean(&places) - hang_m).normalize_or(DVec3::Z);
        let riser_m = hang_m + towards * row.riser_length_m;
        let riser = self.structure.add_node(riser_m);
        let joins = joins_of(row, &places, riser_m).map_err(|(to_sail_m, way_m)| {
            WingFault::BelowRiser {
                row: row.name.clone(),
                to_sail_m,
                way_m,
            }
        })?;
        let mut above = attachments;
        for (level, lines) in row.levels.iter().enumerate() {
            let kind = LineKind::Line { row: number, level };
            let mut below = Vec::new();
            let mut rest = &above[..];
            // The last level has none: its lines meet at the riser.
            for join in joins.get(level).into_iter().flatten() {
                let (group, others) = rest.split_at(join.lines);
                rest = others;
                let node = self.structure.add_node(join.place_m);
                below.push((node, group));
            }
            if below.is_empty() {
                below.push((riser, rest));
            }
            let ends: Vec<[u32; 2]> = (below.iter())
                .flat_map(|&(node, group)| group.iter().map(move |&upper| [upper, node]))
                .collect();
            above = below.into_iter().map(|(node, _)| node).collect();
            for nodes in ends {
                let piece = Piece {
                    nodes,
                    extra_m: 0.0,
                };
                self.add_piece(&piece, &lines.cable, kind);
            }
        }
        let piece = Piece {
            nodes: [riser, hang],
            extra_m: row.trim_m,
        };
        self.add_piece(&piece, &row.riser, LineKind::Riser { row: number });
        Ok(())
    }

    fn add_piece(&mut self, piece: &Piece, cable: &crate::lines::Cable, kind: LineKind) {
        let [a, b] = piece.nodes.map(|n| self.position(n));
        let length_m = a.distance(b) + piece.extra_m;
        self.structure
            .add_cable(&piece.nodes, &[length_m], cable, CableKind::SuspensionLine);
        self.line_kinds.push(kind);
    }
}

/// A node where lines join.
struct Join {
    /// How many lines of the level above end there.
    lines: usize,
    place_m: DVec3,
}

/// A group of lines of a level before it has its place.
struct Group {
    lines: usize,
    /// Mean of the attachments that it carries.
    target_m: DVec3,
}

/// Where a line meets the sail, and its weight in means.
#[derive(Clone, Copy)]
struct Attachment {
    place_m: DVec3,
    weight: f64,
}

fn mean(attachments: &[Attachment]) -> DVec3 {
    let all = || attachments.iter();
    all().map(|one| one.place_m * one.weight).sum::<DVec3>()
        / all().map(|one| one.weight).sum::<f64>()
}

/// The nodes of every level but the last, from the sail down; places are found from the riser up, as a node's depends on that of the one below.
///
/// # Errors
///
/// Where a node would stand at the riser or below it: its way to the sail, and that of the riser [m].
fn joins_of(
    row: &Row,
    attachments: &[Attachment],
    riser_m: DVec3,
) -> Result<Vec<Vec<Join>>, (f64, f64)> {
    let mut groups: Vec<Vec<Group>> = Vec::new();
    let mut carried: Vec<Vec<Attachment>> = attachments.iter().map(|&one| vec![one]).collect();
    for level in row.levels.iter().filter(|level| !level.joins.is_empty()) {
        let mut rest = &carried[..];
        let mut next = Vec::new();
        let mut here = Vec::new();
        for &count in &level.joins {
            let (own, others) = rest.split_at(count.min(rest.len()));
            rest = others;
            let all = own.concat();
            here.push(Group {
                lines: own.len(),
                target_m: mean(&all),
            });
            next.push(all);
        }
        groups.push(here);
        carried = next;
    }
    let mut placed: Vec<Vec<Join>> = Vec::new();
    // What every group of a level hangs on: its place, and its way to the sail where that is given.
    let mut below: Vec<(DVec3, Option<f64>)> =
        vec![(riser_m, None); groups.last().map_or(0, Vec::len)];
    for (here, level) in groups.iter().zip(&row.levels).rev() {
        let mut joins = Vec::new();
        let mut ways = Vec::new();
        for (number, group) in here.iter().enumerate() {
            let (from_m, way_below) = below[number];
            let (place_m, way) = match &level.place {
                JoinPlace::Height(share) => (riser_m.lerp(group.target_m, *share), None),
                JoinPlace::ToSail(ways) => {
                    let way = ways[number];
                    let distance = from_m.distance(group.target_m);
                    let length = way_below.unwrap_or(distance) - way;
                    if length < LEAST_LINE_M {
                        return Err((way, way_below.unwrap_or(distance)));
                    }
                    let along = (group.target_m - from_m).normalize_or(DVec3::Z);
                    (from_m + along * length, Some(way))
                }
            };
            joins.push(Join {
                lines: group.lines,
                place_m,
            });
            ways.push((place_m, way));
        }
        // Those of the level above, by the group that each belongs to.
        below = (here.iter().zip(ways))
            .flat_map(|(group, way)| std::iter::repeat_n(way, group.lines))
            .collect();
        placed.push(joins);
    }
    placed.reverse();
    Ok(placed)
}
