//! Canopies cut into gores of any pattern, and their triangle mesh.
//!
//! All gores are alike and symmetrical. A gore is flat and described along its centre line: at the distance s from the (constructed) apex it
//! reaches b(s) to either side, b linear within a [`Section`]. Rows of nodes lie straight across it, so seams, centre lines and the edges
//! of sections are mesh lines. Neighbouring gores share the nodes of their seam, but where a slot parts them.

use std::f64::consts::PI;

use glam::DVec3;

use crate::cloth::openings::{Opening, OpeningKind};

/// A place along the centre line of a gore.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Distance from the apex along the centre line [m].
    pub distance_m: f64,
    /// Half the gore's width there [m].
    pub half_width_m: f64,
}

/// Seams that are open within a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slots {
    /// Every so many seams one is open.
    pub every: usize,
    /// Width \[m\]; zero for a cut.
    pub width_m: f64,
    /// True where slots reach the skirt; otherwise both their ends are closed.
    pub open_at_skirt: bool,
}

/// A trapezoid of every gore.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Its end nearer to the apex.
    pub from: Station,
    /// Its other end.
    pub to: Station,
    /// Rings of triangles.
    pub rings: usize,
    /// False where a gap parts it from the section before.
    pub sewn: bool,
    /// Seams that are open.
    pub slots: Option<Slots>,
    /// True where the borders of gores are seams, which belts may reinforce.
    pub has_seams: bool,
}

impl Section {
    /// Fabric of one gore [m²], slots not taken out.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        (self.to.distance_m - self.from.distance_m)
            * (self.from.half_width_m + self.to.half_width_m)
    }

    /// Where its rings end, in shares of its length: closer together where the gore is narrower than rings of this height [m].
    fn ring_shares(&self, height_m: f64) -> Vec<f64> {
        let sums = self.crowding(height_m);
        let all = sums[PIECES];
        (0..=self.rings)
            .map(|ring| {
                let wanted = all * ring as f64 / self.rings as f64;
                let piece = sums.partition_point(|sum| *sum < wanted).clamp(1, PIECES);
                let [below, above] = [sums[piece - 1], sums[piece]];
                ((piece - 1) as f64 + (wanted - below) / (above - below)) / PIECES as f64
            })
            .collect()
    }

    /// Length in rings of its own height there [m], where rings are `height_m` high but for narrow gores.
    #[must_use]
    pub fn weighted_length_m(&self, height_m: f64) -> f64 {
        let length = self.to.distance_m - self.from.distance_m;
        length / PIECES as f64 * self.crowding(height_m)[PIECES]
    }

    /// Sums, from the upper end, of how much closer than `height_m` rings should be.
    fn crowding(&self, height_m: f64) -> Vec<f64> {
        let mut sums = vec![0.0];
        for piece in 0..PIECES {
            let share = (piece as f64 + 0.5) / PIECES as f64;
            let half_width =
                self.from.half_width_m + share * (self.to.half_width_m - self.from.half_width_m);
            let height = (half_width / (NARROW * height_m)).clamp(LEAST_HEIGHT, 1.0);
            sums.push(sums[piece] + 1.0 / height);
        }
        sums
    }

    /// db/ds.
    #[must_use]
    pub fn slope(&self) -> f64 {
        (self.to.half_width_m - self.from.half_width_m)
            / (self.to.distance_m - self.from.distance_m)
    }
}

/// Pattern of a canopy.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Number of gores.
    pub gores: usize,
    /// From the vent, or the apex, to the skirt.
    pub sections: Vec<Section>,
    /// Segments of the last section's rows per half gore are a multiple of this.
    pub skirt_multiple: usize,
    /// Tapes across every gap between two seams ([`super::crossings`]).
    pub tapes_per_gore: usize,
}

/// A row of nodes across all gores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Where it is.
    pub at: Station,
    /// Section that ends or lies here.
    pub section: usize,
    /// True for the first row of a part that is not sewn to the one before.
    pub begins: bool,
    /// Segments per half gore; none at the apex.
    pub segments: usize,
    /// Open seams in this row.
    pub slots: Option<Slots>,
}

/// Where a node lies in the pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Row.
    pub row: usize,
    /// Gore; the nodes of a seam belong to the one that begins there, but where a slot parts them.
    pub gore: usize,
    /// Distance from the gore's centre line, from −1 (its first seam) to 1, in half widths.
    pub across: f64,
}

/// Nodes in a row along which something is sewn, and the rest lengths between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Nodes.
    pub nodes: Vec<u32>,
    /// Rest lengths between them [m].
    pub rest_m: Vec<f64>,
}

/// Mesh of a pattern.
#[derive(Debug, Clone, Default)]
pub struct PatternMesh {
    /// Rows of nodes.
    pub rows: Vec<Row>,
    /// Place of every node.
    pub places: Vec<Place>,
    /// Triangles; normals out of the canopy.
    pub triangles: Vec<[u32; 3]>,
    /// Corners of every triangle in its gore: x along the centre line, y across [m].
    pub rest_m: Vec<[DVec3; 3]>,
    /// Paths along every seam.
    pub seams: Vec<Vec<Path>>,
    /// Paths along every centre line.
    pub centres: Vec<Vec<Path>>,
    /// The edge of the vent, closed; absent without a vent.
    pub vent: Option<Path>,
    /// The lower edge; closed unless slots reach it.
    pub skirt: Vec<Path>,
    /// Openings.
    pub openings: Vec<Opening>,
    ids: Vec<Vec<u32>>,
}

impl Pattern {
    /// Angle of half a gore about the axis [rad].
    #[must_use]
    pub fn half_gore_rad(&self) -> f64 {
        PI / self.gores as f64
    }

    /// True where a row reaches as far across its gore as the first section's sector about the apex does there.
    #[must_use]
    pub fn continues_sectors(&self, row: &Row) -> bool {
        self.sections.first().is_some_and(|first| {
            let half_width_m = first.slope() * row.at.distance_m;
            (row.at.half_width_m - half_width_m).abs() < 1e-9 * half_width_m
        })
    }

    /// Fabric in all [m²], as meshed: slots of a width close over one ring of triangles at either end.
    #[must_use]
    pub fn fabric_area_m2(&self) -> f64 {
        let gores = self.gores as f64;
        let height_m = self.ring_height_m();
        let section = |section: &Section| {
            let length = section.to.distance_m - section.from.distance_m;
            let slots = section.slots.map_or(0.0, |slots| {
                let shares = section.ring_shares(height_m);
                let last = if slots.open_at_skirt {
                    0.0
                } else {
                    1.0 - shares[section.rings - 1]
                };
                let clear = length * (1.0 - 0.5 * (shares[1] + last));
                slots.width_m * clear * (self.gores / slots.every) as f64
            });
            gores * section.area_m2() - slots
        };
        self.sections.iter().map(section).sum()
    }

    /// Mean height of a ring of triangles [m].
    fn ring_height_m(&self) -> f64 {
        let length = |s: &Section| s.to.distance_m - s.from.distance_m;
        let rings: usize = self.sections.iter().map(|s| s.rings).sum();
        self.sections.iter().map(length).sum::<f64>() / rings as f64
    }

    /// Rows of nodes from the vent or the apex to the skirt.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let height_m = self.ring_height_m();
        let mut rows: Vec<Row> = Vec::new();
        for (number, section) in self.sections.iter().enumerate() {
            let sewn = number > 0 && section.sewn;
            let is_last = number + 1 == self.sections.len();
            let shares = section.ring_shares(height_m);
            for ring in usize::from(sewn)..=section.rings {
                let share = shares[ring];
                let between = |a: f64, b: f64| {
                    if ring == section.rings {
                        b
                    } else {
                        a + share * (b - a)
                    }
                };
                let at = Station {
                    distance_m: between(section.from.distance_m, section.to.distance_m),
                    half_width_m: between(section.from.half_width_m, section.to.half_width_m),
                };
                let multiple = if is_last {
                    self.skirt_multiple.max(1)
                } else {
                    1
                };
                let wanted =
                    (at.half_width_m / (WIDTH_OVER_HEIGHT * height_m * multiple as f64)).round();
                let open = section
                    .slots
                    .filter(|slots| ring > 0 && (ring < section.rings || slots.open_at_skirt));
                rows.push(Row {
                    at,
                    section: number,
                    begins: ring == 0,
                    segments: if at.half_width_m > 0.0 {
                        (wanted as usize).max(1) * multiple
                    } else {
                        0
                    },
                    slots: open,
                });
            }
        }
        rows
    }

    /// Meshes the pattern.
    #[must_use]
    pub fn mesh(&self) -> PatternMesh {
        let mut mesh = PatternMesh {
            rows: self.rows(),
            ..PatternMesh::default()
        };
        for row in 0..mesh.rows.len() {
            self.add_nodes(&mut mesh, row);
        }
        for row in 1..mesh.rows.len() {
            if !mesh.rows[row].begins {
                self.add_strip(&mut mesh, row);
            }
        }
        self.add_paths(&mut mesh);
        mesh
    }

    fn is_open(&self, row: &Row, seam: usize) -> bool {
        row.slots
            .is_some_and(|slots| seam.is_multiple_of(slots.every))
    }

    /// Distance of a node from the centre line, in half widths.
    fn across(&self, row: &Row, gore: usize, j: usize) -> f64 {
        let t = j as f64 / row.segments as f64 - 1.0;
        let seam = if t < 0.0 {
            gore
        } else {
            (gore + 1) % self.gores
        };
        match row.slots {
            Some(slots) if self.is_open(row, seam) => {
                t * (1.0 - 0.5 * slots.width_m / row.at.half_width_m)
            }
            _ => t,
        }
    }

    fn add_nodes(&self, mesh: &mut PatternMesh, number: usize) {
        let row = mesh.rows[number];
        let per_gore = 2 * row.segments + 1;
        let mut ids = vec![0; self.gores * per_gore];
        if row.segments == 0 {
            mesh.places.push(Place {
                row: number,
                gore: 0,
                across: 0.0,
            });
            mesh.ids
                .push(vec![mesh.places.len() as u32 - 1; self.gores]);
            return;
        }
        for gore in 0..self.gores {
            let next = (gore + 1) % self.gores;
            for j in 0..per_gore {
                if j + 1 == per_gore && !self.is_open(&row, next) {
                    continue;
                }
                ids[gore * per_gore + j] = mesh.places.len() as u32;
                mesh.places.push(Place {
                    row: number,
                    gore,
                    across: self.across(&row, gore, j),
                });
            }
        }
        for gore in 0..self.gores {
            let next = (gore + 1) % self.gores;
            if !self.is_open(&row, next) {
                ids[gore * per_gore + per_gore - 1] = ids[next * per_gore];
            }
        }
        mesh.ids.push(ids);
    }

    /// Triangles between a row and the one before.
    fn add_strip(&self, mesh: &mut PatternMesh, outer_row: usize) {
        let [upper, lower] = [mesh.rows[outer_row - 1], mesh.rows[outer_row]];
        for gore in 0..self.gores {
            for side in 0..2 {
                let (inner, outer) = (upper.segments, lower.segments);
                let corner = |row: &Row, number: usize, k: usize| {
                    let j = side * row.segments + k;
                    let node = mesh.node(number, gore, j);
                    let y = if row.segments == 0 {
                        0.0
                    } else {
                        self.across(row, gore, j) * row.at.half_width_m
                    };
                    (node, DVec3::new(row.at.distance_m, y, 0.0))
                };
                let above = |k| corner(&upper, outer_row - 1, k);
                let below = |k| corner(&lower, outer_row, k);
                let mut found = Vec::with_capacity(inner + outer);
                let (mut i, mut o) = (0, 0);
                while i < inner || o < outer {
                    // Mirrored in the second half, so that a gore is symmetrical about its centre line.
                    let behind = (2 * o + 1) * inner;
                    let ahead = (2 * i + 1) * outer;
                    let first = if side == 0 {
                        behind < ahead
                    } else {
                        behind <= ahead
                    };
                    if i == inner || (o < outer && first) {
                        found.push([above(i), below(o), below(o + 1)]);
                        o += 1;
                    } else {
                        found.push([above(i), below(o), above(i + 1)]);
                        i += 1;
                    }
                }
                for corners in found {
                    mesh.triangles.push(corners.map(|(node, _)| node));
                    mesh.rest_m.push(corners.map(|(_, place)| place));
                }
            }
        }
    }

    fn add_paths(&self, mesh: &mut PatternMesh) {
        let last = mesh.rows.len() - 1;
        for gore in 0..self.gores {
            let before = (gore + self.gores - 1) % self.gores;
            let mut seams = self.along(mesh, gore, |_| 0, |_| true);
            // The other side of a slot.
            let other = self.along(
                mesh,
                before,
                |row| 2 * row.segments,
                |row| self.is_open(row, gore),
            );
            seams.extend(other);
            mesh.seams.push(seams);
            let centres = self.along(mesh, gore, |row| row.segments, |_| true);
            mesh.centres.push(centres);
        }
        if mesh.rows[0].segments > 0 {
            let vent = self.around(mesh, 0).remove(0);
            mesh.openings.push(Opening {
                kind: OpeningKind::Vent,
                width_m: 2.0 * mesh.rows[0].at.half_width_m / self.half_gore_rad().tan(),
                rim: edges(&vent.nodes),
            });
            mesh.vent = Some(vent);
        }
        mesh.skirt = self.around(mesh, last);
        for row in 1..mesh.rows.len() {
            if mesh.rows[row].begins {
                let rims = [self.around(mesh, row - 1), self.around(mesh, row)];
                mesh.openings.push(Opening {
                    kind: OpeningKind::Gap,
                    width_m: mesh.rows[row].at.distance_m - mesh.rows[row - 1].at.distance_m,
                    rim: rims
                        .iter()
                        .flatten()
                        .flat_map(|path| edges(&path.nodes))
                        .collect(),
                });
            }
        }
        for (number, section) in self.sections.iter().enumerate() {
            let Some(slots) = section.slots.filter(|slots| !slots.open_at_skirt) else {
                continue;
            };
            for seam in (0..self.gores).step_by(slots.every) {
                mesh.openings
                    .push(self.slot(mesh, number, seam, slots.width_m));
            }
        }
    }

    /// One slot: its two sides from closed end to closed end.
    fn slot(&self, mesh: &PatternMesh, section: usize, seam: usize, width_m: f64) -> Opening {
        let before = (seam + self.gores - 1) % self.gores;
        let rows = (1..mesh.rows.len()).filter(|&row| mesh.rows[row].section == section);
        let mut rim = Vec::new();
        for row in rows {
            for (gore, last) in [(seam, false), (before, true)] {
                let node = |row: usize| {
                    let j = if last { 2 * mesh.rows[row].segments } else { 0 };
                    mesh.node(row, gore, j)
                };
                rim.push([node(row - 1), node(row)]);
            }
        }
        Opening {
            kind: OpeningKind::Slot,
            width_m,
            rim,
        }
    }

    /// Paths down a gore through the nodes that `j` names, broken at gaps; only segments with an end in a row that `wanted` takes, and only
    /// where gores have seams.
    fn along(
        &self,
        mesh: &PatternMesh,
        gore: usize,
        j: impl Fn(&Row) -> usize,
        wanted: impl Fn(&Row) -> bool,
    ) -> Vec<Path> {
        let mut paths: Vec<Path> = Vec::new();
        let mut connected = false;
        for number in 1..mesh.rows.len() {
            let [upper, lower] = [mesh.rows[number - 1], mesh.rows[number]];
            let taken = !lower.begins
                && self.sections[lower.section].has_seams
                && (wanted(&upper) || wanted(&lower));
            if taken {
                let ends = [(&upper, number - 1), (&lower, number)];
                let nodes = ends.map(|(row, n)| mesh.node(n, gore, j(row)));
                let places = ends.map(|(row, _)| {
                    let across = if row.segments == 0 {
                        0.0
                    } else {
                        self.across(row, gore, j(row))
                    };
                    (row.at.distance_m, across * row.at.half_width_m)
                });
                let rest = (places[1].0 - places[0].0).hypot(places[1].1 - places[0].1);
                if !connected {
                    paths.push(Path {
                        nodes: vec![nodes[0]],
                        rest_m: Vec::new(),
                    });
                }
                if let Some(path) = paths.last_mut() {
                    path.nodes.push(nodes[1]);
                    path.rest_m.push(rest);
                }
            }
            connected = taken;
        }
        paths
    }

    /// Paths around the canopy along a row: one closed path, or one per piece between open seams.
    fn around(&self, mesh: &PatternMesh, number: usize) -> Vec<Path> {
        let row = mesh.rows[number];
        let mut paths: Vec<Path> = Vec::new();
        for gore in 0..self.gores {
            if gore == 0 || self.is_open(&row, gore) {
                paths.push(Path {
                    nodes: vec![mesh.node(number, gore, 0)],
                    rest_m: Vec::new(),
                });
            }
            let Some(path) = paths.last_mut() else {
                continue;
            };
            for j in 1..=2 * row.segments {
                let step = self.across(&row, gore, j) - self.across(&row, gore, j - 1);
                path.nodes.push(mesh.node(number, gore, j));
                path.rest_m.push(step * row.at.half_width_m);
            }
        }
        paths
    }
}

impl PatternMesh {
    /// Node `j` of a gore in a row, counted from its first seam.
    #[must_use]
    pub fn node(&self, row: usize, gore: usize, j: usize) -> u32 {
        let per_gore = 2 * self.rows[row].segments + 1;
        let ids = &self.ids[row];
        if self.rows[row].segments == 0 {
            ids[gore]
        } else {
            ids[gore * per_gore + j]
        }
    }
}

/// Edges along a row of nodes.
fn edges(nodes: &[u32]) -> Vec<[u32; 2]> {
    nodes.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Pieces of a section by which the places of its rings are found.
const PIECES: usize = 256;

/// Half width of a gore over the mean height of a ring below which rings come closer together.
const NARROW: f64 = 0.6;

/// Height of the closest rings over the mean.
const LEAST_HEIGHT: f64 = 1.0 / 3.0;

/// Width of a triangle's base over the height of a ring that the mesh aims at.
const WIDTH_OVER_HEIGHT: f64 = 1.0;
