//! Folding of any pattern of gores: seams outward, centre lines inward, rows of nodes straight in between.
//!
//! Lengths along seams, along centre lines, across half gores and along one diagonal per ring stay those of the pattern. Where all sections are
//! sectors about one apex (flat circular, conical, slotted, annular, ringslot) half gores stay plane and the folding is an isometry, as in
//! [`super::folding`]; so are a band, whose fold lines are parallel, and the arms of a cross, which hang freely. Where the half width bends
//! otherwise (extended skirts) half gores twist by little, and the fabric is that much strained until the opening relaxes it.
//!
//! Pleats may be uneven: gore g takes the azimuth 2π/N (1 + a cos(2π (g + ½)/N)), every seam leans as much as the others, and centre lines
//! follow from the widths.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::folding::{half_azimuths, inner_angle};
use super::pattern::{Pattern, PatternMesh, Place, Row, Slots};
use super::shape;

/// Halvings of the interval of fold angles.
const HALVINGS: usize = 50;

/// Relative error of the projected area; the shadow of arms is counted on a grid.
const AREA_TOLERANCE: f64 = 0.02;

/// A row of one gore: its first seam, its centre line, its second seam.
type Fold = [DVec3; 3];

/// Node positions pleated to the projected area given, the apex on the axis and the skirt towards −x [m]; `None` where no such folding exists.
#[must_use]
pub fn pleat(
    pattern: &Pattern,
    mesh: &PatternMesh,
    projected_area_m2: f64,
    asymmetry: f64,
) -> Option<Vec<DVec3>> {
    let half_azimuths = half_azimuths(pattern.gores, asymmetry);
    let least = pattern.sections.first()?.slope().atan();
    let hangs = |slots: Slots| slots.open_at_skirt;
    let has_arms = pattern.sections.iter().any(|s| s.slots.is_some_and(hangs));
    let (mut low, mut high) = (least, 0.5 * PI);
    let mut best = None;
    for _ in 0..HALVINGS {
        let outer = 0.5 * (low + high);
        let folded = fold_lines(pattern, &mesh.rows, outer, &half_azimuths).map(|folds| {
            let positions = positions(mesh, &folds);
            let area = if has_arms {
                shape::projected_area_m2(&positions, mesh.triangles.iter().copied())
            } else {
                area_m2(&folds)
            };
            (area, positions)
        });
        match folded {
            Some((area, positions)) if area < projected_area_m2 => {
                low = outer;
                best = Some((area, positions));
            }
            _ => high = outer,
        }
    }
    let (area, positions) = best?;
    ((area / projected_area_m2 - 1.0).abs() < AREA_TOLERANCE).then_some(positions)
}

fn positions(mesh: &PatternMesh, folds: &[Vec<Fold>]) -> Vec<DVec3> {
    let position = |place: &Place| {
        let [first, centre, second] = folds[place.row][place.gore];
        let seam = if place.across < 0.0 { first } else { second };
        centre.lerp(seam, place.across.abs())
    };
    mesh.places.iter().map(position).collect()
}

/// Largest shadow of a row, a star about the axis [m²].
fn area_m2(folds: &[Vec<Fold>]) -> f64 {
    let triangle = |a: DVec3, b: DVec3| 0.5 * (a.y * b.z - a.z * b.y);
    folds
        .iter()
        .map(|row| {
            row.iter()
                .map(|[first, centre, second]| {
                    triangle(*first, *centre) + triangle(*centre, *second)
                })
                .sum()
        })
        .fold(0.0, f64::max)
}

/// Fold lines of all gores where seams of the first section lean `outer` from the axis; by row and gore.
fn fold_lines(
    pattern: &Pattern,
    rows: &[Row],
    outer: f64,
    half_azimuths: &[f64],
) -> Option<Vec<Vec<Fold>>> {
    let mut folds = Vec::with_capacity(rows.len());
    let mut last: Option<Lines> = None;
    for (number, row) in rows.iter().enumerate() {
        let lines = match number.checked_sub(1).map(|before| &rows[before]).zip(last) {
            None => Lines::first(pattern, row, outer, half_azimuths)?,
            // Below an apex the seams' lean is still free.
            Some((above, _)) if above.segments == 0 => {
                Lines::first(pattern, row, outer, half_azimuths)?
            }
            // A ring of the same sectors goes on along their fold lines.
            Some(_) if row.begins && pattern.continues_sectors(row) => {
                Lines::first(pattern, row, outer, half_azimuths)?
            }
            Some((above, last)) => last.next(pattern, above, row, half_azimuths)?,
        };
        if number > 0 && !(lines.seam.y > 0.0 && lines.centres.iter().all(|c| c.y > 0.0)) {
            return None;
        }
        folds.push(lines.folds(half_azimuths));
        last = Some(lines);
    }
    Some(folds)
}

/// A row folded: places (x, distance from the axis) of its seams, all alike, in their planes, and of its centres in theirs.
#[derive(Debug, Clone)]
struct Lines {
    seam: DVec2,
    centres: Vec<DVec2>,
    /// The centre in a gore of the mean azimuth, which the seams follow.
    mean: DVec2,
    /// What is added to all nodes of a gore, in the plane of its centre line, where it hangs freely.
    free: Vec<DVec2>,
}

impl Lines {
    /// The first row: an apex, or part of a sector about one.
    fn first(pattern: &Pattern, row: &Row, outer: f64, half_azimuths: &[f64]) -> Option<Self> {
        let slope = pattern.sections.first()?.slope();
        let down = row.at.half_width_m / slope;
        let centre = |half: f64| {
            let inner = inner_angle(outer, half, slope.atan())?;
            Some(DVec2::new(-inner.cos(), inner.sin()) * down)
        };
        Some(Self {
            seam: DVec2::new(-outer.cos(), outer.sin()) * down.hypot(row.at.half_width_m),
            centres: half_azimuths
                .iter()
                .map(|half| centre(*half))
                .collect::<Option<_>>()?,
            mean: centre(pattern.half_gore_rad())?,
            free: vec![DVec2::ZERO; half_azimuths.len()],
        })
    }

    fn next(
        self,
        pattern: &Pattern,
        above: &Row,
        row: &Row,
        half_azimuths: &[f64],
    ) -> Option<Self> {
        let width = row.at.half_width_m;
        let down = row.at.distance_m - above.at.distance_m;
        let section = &pattern.sections[row.section];
        if row.begins {
            return self.after_gap(down, width, pattern.half_gore_rad(), half_azimuths);
        }
        if section.slots.is_some_and(|slots| slots.open_at_skirt) {
            return self.hanging(down, half_azimuths);
        }
        let mean_half = pattern.half_gore_rad();
        let along = down.hypot(width - above.at.half_width_m);
        // Of a gore of the mean azimuth, both triangles that a diagonal of its half makes keep their lengths.
        let seam = meet(
            self.seam,
            along,
            self.mean,
            down.hypot(width),
            mean_half,
            -1.0,
        )?;
        let centre = |last: DVec2, half: f64| meet(last, down, seam, width, half, 1.0);
        let centres = self.centres.iter().zip(half_azimuths);
        Some(Self {
            centres: centres
                .map(|(last, half)| centre(*last, *half))
                .collect::<Option<_>>()?,
            mean: centre(self.mean, mean_half)?,
            seam,
            free: self.free,
        })
    }

    /// The row that begins below a gap: level, as far down as the lines over the gap allow, seams at about their distance from the axis.
    fn after_gap(
        self,
        gap: f64,
        width: f64,
        mean_half: f64,
        half_azimuths: &[f64],
    ) -> Option<Self> {
        let turned = self.mean.y * mean_half.sin();
        let root = width * width - turned * turned;
        if root < 0.0 {
            return None;
        }
        let outer = self.mean.y * mean_half.cos() + root.sqrt();
        // How far down a node may go that was there and is to be so far from the axis.
        let reach = |last: DVec2, distance: f64| {
            let square = gap * gap - (distance - last.y).powi(2);
            (square >= 0.0).then(|| last.x - square.sqrt())
        };
        let inner = |half: f64| {
            let square = width * width - (outer * half.sin()).powi(2);
            (square >= 0.0).then(|| outer * half.cos() - square.sqrt())
        };
        let distances: Vec<f64> = half_azimuths
            .iter()
            .map(|half| inner(*half))
            .collect::<Option<_>>()?;
        let mut x = reach(self.seam, outer)?;
        for (last, distance) in self.centres.iter().zip(&distances) {
            x = x.max(reach(*last, *distance)?);
        }
        Some(Self {
            seam: DVec2::new(x, outer),
            centres: distances.iter().map(|y| DVec2::new(x, *y)).collect(),
            mean: DVec2::new(x, self.mean.y),
            free: self.free,
        })
    }

    /// An arm that hangs freely: perpendicular to the chord from centre to seam, so that half gores go on as rectangles.
    fn hanging(self, down: f64, half_azimuths: &[f64]) -> Option<Self> {
        let direction = |(centre, half): (&DVec2, &f64)| {
            let chord = self.seam * DVec2::new(1.0, half.cos()) - *centre;
            DVec2::new(-chord.y, chord.x).try_normalize()
        };
        let directions: Vec<DVec2> = self
            .centres
            .iter()
            .zip(half_azimuths)
            .map(direction)
            .collect::<Option<_>>()?;
        let free = self.free.iter().zip(directions);
        Some(Self {
            free: free
                .map(|(free, direction)| *free + direction * down)
                .collect(),
            ..self.clone()
        })
    }

    fn folds(&self, half_azimuths: &[f64]) -> Vec<Fold> {
        let mut azimuth: f64 = 0.0;
        let mut folds = Vec::with_capacity(half_azimuths.len());
        for (gore, half) in half_azimuths.iter().enumerate() {
            let [first, centre, second] = [azimuth, azimuth + half, azimuth + 2.0 * half];
            azimuth = second;
            let place = |point: DVec2, angle: f64| {
                DVec3::new(point.x, point.y * angle.cos(), point.y * angle.sin())
            };
            let carried = place(self.free[gore], centre);
            folds.push([
                place(self.seam, first) + carried,
                place(self.centres[gore], centre) + carried,
                place(self.seam, second) + carried,
            ]);
        }
        folds
    }
}

/// The place at the distance `down` from `last`, in the same plane through the axis, and at the distance `width` from `other`, which lies in the
/// plane `half` beside it; of two such places the one on the given side of the way from `last` to `other`.
fn meet(last: DVec2, down: f64, other: DVec2, width: f64, half: f64, side: f64) -> Option<DVec2> {
    let target = DVec2::new(other.x, other.y * half.cos());
    let beside = other.y * half.sin();
    let reach = width * width - beside * beside;
    let apart = target - last;
    let square = apart.length_squared();
    if square == 0.0 || reach < 0.0 {
        return None;
    }
    let along = 0.5 * (down * down - reach + square) / square;
    let height = down * down / square - along * along;
    if height < -1e-12 {
        return None;
    }
    Some(last + apart * along + apart.perp() * (side * height.max(0.0).sqrt()))
}
