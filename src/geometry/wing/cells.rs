//! Cells as they stand: what a cell encloses, where its middle is, and what it looks like laid flat.
//!
//! Positions are those of all nodes of the wing's structure, wherever the fabric has got to. The skin of a cell is the grid of nodes from its
//! left rib to its right one at every place of the outline; over an open intake it is taken straight from rib to rib.

use glam::DVec3;

use super::section::Side;
use super::{BuiltWing, LineKind, Part, Tag};

/// Part of the chord over which the air inside a cell is looked at: behind the intake, before the section gets thin.
const PROBED: [f64; 2] = [0.15, 0.6];

impl BuiltWing {
    /// Edges along each side of a rib.
    const fn along_chord(&self) -> usize {
        self.places.upper.len() - 1
    }

    /// Number on the outline of node `j` of a side, counted from the nose.
    const fn on_outline(&self, side: Side, j: usize) -> usize {
        let count = 2 * self.along_chord();
        match side {
            Side::Upper => j,
            Side::Lower => (count - j) % count,
        }
    }

    /// Outlines of both ribs beside the middle; of the one in the middle twice.
    #[must_use]
    pub fn middle_outlines(&self) -> [&[u32]; 2] {
        [self.cells / 2, self.cells.div_ceil(2)].map(|rib| &self.outlines[rib][..])
    }

    /// Nose and trailing edge in the middle of the span [m], the mean of both ribs beside it.
    #[must_use]
    pub fn middle_chord_m(&self, positions_m: &[DVec3]) -> [DVec3; 2] {
        [0, self.along_chord()].map(|k| {
            let [left, right] = self
                .middle_outlines()
                .map(|nodes| positions_m[nodes[k] as usize]);
            0.5 * (left + right)
        })
    }

    /// Edges across every cell.
    fn across_cell(&self) -> usize {
        let rows = self.rows_across.iter().flatten();
        rows.map(Vec::len).max().unwrap_or(0) + 1
    }

    /// Places of the skin from the left rib of a cell to its right one at place `k` of the outline [m], `[edges across + 1]`.
    fn row_m(&self, cell: usize, k: usize, positions_m: &[DVec3]) -> Vec<DVec3> {
        let place = |node: u32| positions_m[node as usize];
        let [left, right] = [cell, cell + 1].map(|rib| place(self.outlines[rib][k]));
        let inner = &self.rows_across[cell][k];
        let edges = self.across_cell();
        let mut row = vec![left];
        if inner.is_empty() {
            row.extend((1..edges).map(|a| left.lerp(right, a as f64 / edges as f64)));
        } else {
            row.extend(inner.iter().map(|&node| place(node)));
        }
        row.push(right);
        row
    }

    /// Area of a cell as designed, laid flat [m²].
    #[must_use]
    pub fn flat_cell_area_m2(&self, cell: usize) -> f64 {
        let [left, right] = [&self.frames[cell], &self.frames[cell + 1]];
        0.5 * (right.span_m - left.span_m) * (left.chord_m + right.chord_m)
    }

    /// Volume that a cell encloses between its panels and both ribs, intakes taken as closed [m³].
    #[must_use]
    pub fn cell_volume_m3(&self, cell: usize, positions_m: &[DVec3]) -> f64 {
        let count = 2 * self.along_chord();
        let rows: Vec<Vec<DVec3>> = (0..count)
            .map(|k| self.row_m(cell, k, positions_m))
            .collect();
        let origin = rows[0][0];
        let sixfold = |[a, b, c]: [DVec3; 3]| (a - origin).dot((b - origin).cross(c - origin));
        let last = rows[0].len() - 1;
        let middle = |a: usize| rows.iter().map(|row| row[a]).sum::<DVec3>() / count as f64;
        let [left, right] = [middle(0), middle(last)];
        let mut sum = 0.0;
        for k in 0..count {
            let (row, next) = (&rows[k], &rows[(k + 1) % count]);
            for a in 0..last {
                sum += sixfold([row[a], next[a], next[a + 1]]);
                sum += sixfold([row[a], next[a + 1], row[a + 1]]);
            }
            sum += sixfold([left, next[0], row[0]]);
            sum += sixfold([right, row[last], next[last]]);
        }
        sum / 6.0
    }

    /// Outline of the middle of a cell between its ribs, from the nose over the upper side [m]; straight from rib to rib over an open intake.
    #[must_use]
    pub fn middle_section_m(&self, cell: usize, positions_m: &[DVec3]) -> Vec<DVec3> {
        let half = self.across_cell() / 2;
        (0..2 * self.along_chord())
            .map(|k| self.row_m(cell, k, positions_m)[half])
            .collect()
    }

    /// Its fabric alone: from the front edge of an open intake over the upper side and around the trailing edge to its rear edge, or all around.
    #[must_use]
    pub fn middle_skin_m(&self, cell: usize, positions_m: &[DVec3]) -> Vec<DVec3> {
        let section = self.middle_section_m(cell, positions_m);
        let count = section.len();
        let open = (self.intakes).filter(|intakes| intakes.open_cells(self.cells).contains(&cell));
        let [first, steps] = match open {
            Some(intakes) => {
                let [front, rear] =
                    [intakes.from, intakes.to].map(|x| self.places.nearest(Side::Lower, x));
                [self.on_outline(Side::Lower, front), count - (rear - front)]
            }
            None => [0, count],
        };
        (0..=steps).map(|k| section[(first + k) % count]).collect()
    }

    /// Points inside a cell, in the middle between its ribs and between its panels, over `PROBED` of the chord [m].
    #[must_use]
    pub fn inner_points_m(&self, cell: usize, positions_m: &[DVec3]) -> Vec<DVec3> {
        let section = self.middle_section_m(cell, positions_m);
        let lower: Vec<(f64, DVec3)> = (0..=self.along_chord())
            .map(|j| {
                let place = section[self.on_outline(Side::Lower, j)];
                (self.places.lower[j], place)
            })
            .collect();
        let upper = self.places.upper.iter().zip(&section);
        upper
            .filter(|(x, _)| (PROBED[0]..=PROBED[1]).contains(*x))
            .map(|(x, above)| above.midpoint(between(&lower, *x)))
            .collect()
    }

    /// Nodes of a side nearest to a place along the chord, from the left tip to the right one, each with its place along the span as laid flat [m].
    #[must_use]
    pub fn span_line(&self, side: Side, chord_place: f64) -> Vec<(f64, u32)> {
        let k = self.on_outline(side, self.places.nearest(side, chord_place));
        let edges = self.across_cell() as f64;
        let mut line = vec![(self.frames[0].span_m, self.outlines[0][k])];
        for cell in 0..self.cells {
            let [from, to] = [cell, cell + 1].map(|rib| self.frames[rib].span_m);
            let inner = self.rows_across[cell][k].iter().enumerate();
            line.extend(inner.map(|(a, &node)| {
                let share = (a + 1) as f64 / edges;
                (from + (to - from) * share, node)
            }));
            line.push((to, self.outlines[cell + 1][k]));
        }
        line
    }

    /// The wing with its panels laid together: everything `1 − ratio` of its way to the lower side of the ribs, across the chord [m].
    /// `positions_m` are those of the design; nodes of lines stay.
    #[must_use]
    pub fn laid_together_m(&self, positions_m: &[DVec3], ratio: f64) -> Vec<DVec3> {
        let mut places = positions_m.to_vec();
        // Lines and hang points come behind all fabric.
        let fabric = positions_m.len() - self.line_node_count(positions_m.len());
        for place in &mut places[..fabric] {
            let to_the_right = |rib: usize| {
                let frame = &self.frames[rib];
                (*place - frame.quarter_m).dot(frame.up.cross(frame.aft))
            };
            let cell = (0..self.cells)
                .rev()
                .find(|&cell| to_the_right(cell) >= 0.0)
                .unwrap_or(0);
            let [from, to] = [cell, cell + 1].map(to_the_right);
            let share = (from / (from - to)).clamp(0.0, 1.0);
            let way = |rib: usize| {
                let frame = &self.frames[rib];
                let along = (*place - frame.quarter_m) / frame.chord_m;
                let x = (along.dot(frame.aft) + 0.25).clamp(0.0, 1.0);
                let above = along.dot(frame.up) - frame.height(&self.profiles, Side::Lower, x);
                frame.up * ((ratio - 1.0) * above * frame.chord_m)
            };
            *place += way(cell).lerp(way(cell + 1), share);
        }
        places
    }

    /// Nodes of the fabric at which lines of chosen rows are sewn on.
    #[must_use]
    pub fn attachments(&self, chosen: impl Fn(usize) -> bool) -> Vec<u32> {
        let lines = self.structure.cables.iter().zip(&self.line_kinds);
        let top = lines
            .filter(|(_, kind)| matches!(**kind, LineKind::Line { row, level: 0 } if chosen(row)));
        let mut nodes: Vec<u32> = top
            .flat_map(|(cable, _)| cable.nodes)
            .filter(|&node| node < self.hang_points[0])
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// True for triangles that air may meet on both sides inside the wing: ribs but for the tips', mini-ribs and diagonals.
    #[must_use]
    pub fn inner_triangles(&self) -> Vec<bool> {
        let inner = |tag: &Tag| match tag.part {
            Part::Upper | Part::Lower => false,
            Part::Rib => (1..self.cells).contains(&(tag.number as usize)),
            Part::MiniRib | Part::Diagonal => true,
        };
        self.tags.iter().map(inner).collect()
    }

    /// Nodes that only lines have.
    fn line_node_count(&self, node_count: usize) -> usize {
        // The hang points are the first of them.
        node_count - self.hang_points[0] as usize
    }
}

/// Point of a polyline over growing places.
fn between(line: &[(f64, DVec3)], x: f64) -> DVec3 {
    let next = line.partition_point(|(place, _)| *place < x);
    let next = next.clamp(1, line.len() - 1);
    let ((from, a), (to, b)) = (line[next - 1], line[next]);
    a.lerp(b, ((x - from) / (to - from)).clamp(0.0, 1.0))
}
