//! Panels laid flat: the outlines that a cutter needs.
//!
//! A panel is a strip from rib to rib, given row by row along the chord. Flat, every row is straight and as long as the cloth is wide there, and both seams
//! keep their lengths edge by edge, since they are sewn to ribs and neighbours. One angle per row is left; it is taken such that both diagonals of
//! the band between two rows miss their lengths alike (those of the band laid out triangle by triangle). On a surface that can be developed
//! with straight rows (a cylinder along the chord, a cone of generators) they do not miss at all; a ballooned panel is curved twice, and the strain that is left,
//! which its cloth takes up, is told. No allowance for seams is added.

use glam::{DVec2, DVec3};

use super::{BuiltWing, Part};

/// Halvings in the search for the angle of a row.
const HALVINGS: usize = 60;

/// A strip laid flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Flat {
    /// Left ends of the rows [m].
    pub left: Vec<DVec2>,
    /// Right ends of the rows [m].
    pub right: Vec<DVec2>,
    /// Largest strain of diagonals of bands, and of edges along the chord inside the strip, flat against sewn.
    pub strain: f64,
}

/// A panel laid flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Upper or lower.
    pub part: Part,
    /// Number of its cell, from the left tip, from 0.
    pub cell: usize,
    /// Places of its rows along the chord, from the trailing edge forwards on the upper, from the front backwards on the lower side.
    pub chord_places: Vec<f64>,
    /// The outline.
    pub flat: Flat,
    /// Lengths of the left and the right seam [m].
    pub seams_m: [f64; 2],
    /// Largest width [m].
    pub width_m: f64,
}

/// The third corner of a triangle over `a` and `b`, at distances from both, left of the way from `a` to `b`; on the line where the distances do not reach.
fn third(a: DVec2, b: DVec2, from_a: f64, from_b: f64) -> DVec2 {
    let base = b - a;
    let length = base.length();
    let along = 0.5 * (length + (from_a * from_a - from_b * from_b) / length);
    let up = (from_a * from_a - along * along).max(0.0).sqrt();
    let x = base / length;
    a + x * along + x.perp() * up
}

/// Lengths of both diagonals of the band between two rows, from the left end of the first to the right end of the second and the other way, laid out flat
/// triangle by triangle.
fn diagonals(rows: [&[DVec3]; 2], number: usize) -> [f64; 2] {
    let [lower, upper] = rows;
    let mut low = DVec2::ZERO;
    let mut high = DVec2::new(0.0, upper[0].distance(lower[0]));
    let starts = [low, high];
    for a in 0..lower.len() - 1 {
        let (p, q, r, s) = (lower[a], upper[a], upper[a + 1], lower[a + 1]);
        // Above `low` stands `high`; new corners lie to the right of that edge, left of the way down.
        if (number + a).is_multiple_of(2) {
            let next_high = third(high, low, q.distance(r), p.distance(r));
            low = third(next_high, low, r.distance(s), p.distance(s));
            high = next_high;
        } else {
            let next_low = third(high, low, q.distance(s), p.distance(s));
            high = third(high, next_low, q.distance(r), s.distance(r));
            low = next_low;
        }
    }
    [starts[0].distance(high), starts[1].distance(low)]
}

/// Lays a strip flat; rows have the same number of nodes, at least two, from left to right, and go on to the left of their direction. `first_place` is
/// the place of the first row on the outline: diagonals of the mesh take turns by it.
#[must_use]
pub fn unroll(rows: &[Vec<DVec3>], first_place: usize) -> Flat {
    let width = |row: &[DVec3]| -> f64 { row.windows(2).map(|p| p[0].distance(p[1])).sum() };
    let mut flat = Flat {
        left: vec![DVec2::ZERO],
        right: vec![DVec2::new(width(&rows[0]), 0.0)],
        strain: 0.0,
    };
    for (number, pair) in rows.windows(2).enumerate() {
        let (row, next) = (&pair[0], &pair[1]);
        let last = row.len() - 1;
        let seams = [row[0].distance(next[0]), row[last].distance(next[last])];
        let across = width(next);
        let [rising, falling] = diagonals([row, next], first_place + number);
        let (a, b) = (flat.left[number], flat.right[number]);
        // One diagonal exact, then the other.
        let by_falling = third(a, b, seams[0], falling);
        let by_rising = {
            let d = third(a, b, rising, seams[1]);
            third(a, d, seams[0], across)
        };
        let angle_of = |c: DVec2| (b - a).angle_to(c - a);
        let ends = |angle: f64| {
            let x = (b - a).normalize();
            let c = a + (x * angle.cos() + x.perp() * angle.sin()) * seams[0];
            // To the right of the way from c to b turned about.
            (c, third(c, b, across, seams[1]))
        };
        let miss = |angle: f64| {
            let (c, d) = ends(angle);
            (a.distance(d) - b.distance(c)) - (rising - falling)
        };
        let (mut low, mut high) = (angle_of(by_falling), angle_of(by_rising));
        let sign = miss(low);
        if sign * miss(high) < 0.0 {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if miss(middle) * sign > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
        }
        let (c, d) = ends(low);
        for (flat_m, sewn_m) in [(a.distance(d), rising), (b.distance(c), falling)] {
            flat.strain = flat.strain.max((flat_m / sewn_m - 1.0).abs());
        }
        // Nodes inside, at their share of the width.
        let shares = |row: &[DVec3]| -> Vec<f64> {
            let all = width(row);
            let mut sum = 0.0;
            row.windows(2)
                .map(|p| {
                    sum += p[0].distance(p[1]);
                    sum / all
                })
                .collect()
        };
        for (node, (s, t)) in shares(row)
            .into_iter()
            .zip(shares(next))
            .enumerate()
            .take(last - 1)
        {
            let flat_m = a.lerp(b, s).distance(c.lerp(d, t));
            let sewn_m = row[node + 1].distance(next[node + 1]);
            flat.strain = flat.strain.max((flat_m / sewn_m - 1.0).abs());
        }
        flat.left.push(c);
        flat.right.push(d);
    }
    flat
}

/// All panels laid flat, the upper ones first, from the left tip. The upper panel goes around the nose to the front edge of the intake, where there is one.
/// `positions_m` are those of the sewn, unloaded shape.
#[must_use]
pub fn patterns(wing: &BuiltWing, positions_m: &[DVec3]) -> Vec<Pattern> {
    let count = wing.outlines[0].len();
    let tail = count / 2;
    let place = |node: u32| positions_m[node as usize];
    let chord_place = |k: usize| {
        if k <= tail {
            wing.places.upper[k]
        } else {
            wing.places.lower[count - k]
        }
    };
    let row = |cell: usize, k: usize| -> Option<Vec<DVec3>> {
        let k = k % count;
        let inside = &wing.rows_across[cell][k];
        if inside.is_empty() {
            return None;
        }
        let nodes = std::iter::once(wing.outlines[cell][k])
            .chain(inside.iter().copied())
            .chain([wing.outlines[cell + 1][k]]);
        Some(nodes.map(place).collect())
    };
    let intakes = |cell: usize| {
        wing.intakes
            .filter(|intakes| intakes.open_cells(wing.cells).contains(&cell))
    };
    // Places of the outline count from the nose over the upper side and back below; the lip between nose and intake has the last of them.
    let on_lower = |from: f64, to: f64| {
        (tail..=count).filter(move |k| {
            let x = chord_place(*k % count);
            x > from - 1e-9 && x < to + 1e-9
        })
    };
    let mut patterns = Vec::new();
    for part in [Part::Upper, Part::Lower] {
        for cell in 0..wing.cells {
            let mut places: Vec<usize> = match (part, intakes(cell)) {
                (Part::Upper, None) => (0..=tail).rev().collect(),
                (Part::Upper, Some(open)) => {
                    let lip = on_lower(0.0, open.from)
                        .filter(|k| *k < count)
                        .collect::<Vec<_>>();
                    (0..=tail).rev().chain(lip.into_iter().rev()).collect()
                }
                (_, None) => on_lower(0.0, 1.0).collect(),
                (_, Some(open)) => on_lower(open.to, 1.0).collect(),
            };
            if part == Part::Lower {
                // From the front backwards.
                places.reverse();
            }
            let rows: Vec<Vec<DVec3>> = places.iter().filter_map(|k| row(cell, *k)).collect();
            if rows.len() < 2 || rows.len() != places.len() {
                continue;
            }
            let seam = |end: fn(&Vec<DVec3>) -> Option<&DVec3>| -> f64 {
                let ends: Vec<DVec3> = rows.iter().filter_map(end).copied().collect();
                ends.windows(2).map(|p| p[0].distance(p[1])).sum()
            };
            let widths = rows
                .iter()
                .map(|row| -> f64 { row.windows(2).map(|p| p[0].distance(p[1])).sum() });
            patterns.push(Pattern {
                part,
                cell,
                chord_places: places.iter().map(|k| chord_place(k % count)).collect(),
                seams_m: [seam(|row| row.first()), seam(|row| row.last())],
                width_m: widths.fold(0.0, f64::max),
                flat: unroll(&rows, places[0]),
            });
        }
    }
    patterns
}
