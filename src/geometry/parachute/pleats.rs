//! Folding of any pattern of gores: seams outward, centre lines inward, rows of nodes straight in between.
//!
//! Lengths along seams, along centre lines and across half gores stay those of the pattern. Where all sections are sectors about one apex
//! (flat circular, conical, slotted, annular) half gores stay plane and the folding is an isometry, as in [`super::folding`]; so are a band,
//! whose fold lines are parallel, and the arms of a cross, which hang freely. Where the half width bends otherwise (extended skirts)
//! half gores shear by little, and the fabric is that much strained until the opening relaxes it.
//!
//! Pleats may be uneven: gore g takes the azimuth 2π/N (1 + a cos(2π (g + ½)/N)), every seam leans as much as the others, and centre lines
//! follow from the widths.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::folding::{half_azimuths, inner_angle};
use super::pattern::{Pattern, PatternMesh, Row};

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
    let (mut low, mut high) = (least, 0.5 * PI);
    let mut best = None;
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        match fold_lines(pattern, &mesh.rows, middle, &half_azimuths) {
            Some(folds) if area_m2(&folds) < projected_area_m2 => {
                low = middle;
                best = Some(folds);
            }
            _ => high = middle,
        }
    }
    let folds = best?;
    if (area_m2(&folds) / projected_area_m2 - 1.0).abs() > 1e-3 {
        return None;
    }
    let position = |place: &super::pattern::Place| {
        let [first, centre, second] = folds[place.row][place.gore];
        let seam = if place.across < 0.0 { first } else { second };
        centre.lerp(seam, place.across.abs())
    };
    Some(mesh.places.iter().map(position).collect())
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
    let mut folds = vec![Vec::with_capacity(pattern.gores); rows.len()];
    let mut azimuth = 0.0;
    for &half in half_azimuths {
        let [first, centre, second] = [azimuth, azimuth + half, azimuth + 2.0 * half];
        azimuth = second;
        for (row, lines) in one_gore(pattern, rows, outer, half)?
            .into_iter()
            .enumerate()
        {
            let Lines {
                seam,
                centre: middle,
                free,
            } = lines;
            let place = |point: DVec2, angle: f64| {
                DVec3::new(point.x, point.y * angle.cos(), point.y * angle.sin())
            };
            // What hangs freely is carried along in the plane of the centre line.
            let carried = place(free, centre);
            folds[row].push([
                place(seam, first) + carried,
                place(middle, centre) + carried,
                place(seam, second) + carried,
            ]);
        }
    }
    Some(folds)
}

/// Places (x, distance from the axis) of a row's seam in the plane of the seam and of its centre in that of the centre line, and what is added
/// to both in the latter.
#[derive(Debug, Clone, Copy)]
struct Lines {
    seam: DVec2,
    centre: DVec2,
    free: DVec2,
}

fn one_gore(pattern: &Pattern, rows: &[Row], outer: f64, half: f64) -> Option<Vec<Lines>> {
    let steepest = pattern.sections.first()?.slope();
    let mut found: Vec<Lines> = Vec::with_capacity(rows.len());
    for (number, row) in rows.iter().enumerate() {
        let width = row.at.half_width_m;
        let lines = match number
            .checked_sub(1)
            .map(|before| (&rows[before], found[before]))
        {
            None => first_row(row, steepest, outer, half)?,
            Some((above, last)) if row.begins => {
                after_gap(row.at.distance_m - above.at.distance_m, width, &last, half)?
            }
            Some((above, last)) => {
                let section = &pattern.sections[row.section];
                let down = row.at.distance_m - above.at.distance_m;
                if section.slots.is_some_and(|slots| slots.open_at_skirt) {
                    // Perpendicular to the chord from centre to seam, so that the half gore goes on as a rectangle.
                    let chord = last.seam * DVec2::new(1.0, half.cos()) - last.centre;
                    let direction = DVec2::new(-chord.y, chord.x).try_normalize()?;
                    Lines {
                        free: last.free + direction * down,
                        ..last
                    }
                } else {
                    let sine = outer.sin() * section.slope() / steepest;
                    let along = down.hypot(width - above.at.half_width_m);
                    let seam = last.seam + DVec2::new(-(1.0 - sine * sine).sqrt(), sine) * along;
                    let centre = inner_point(last.centre, down, seam, width, half)?;
                    Lines {
                        seam,
                        centre,
                        ..last
                    }
                }
            }
        };
        if number > 0 && !(lines.centre.y > 0.0 && lines.seam.y > 0.0) {
            return None;
        }
        found.push(lines);
    }
    Some(found)
}

/// The first row: an apex, or part of a sector about one.
fn first_row(row: &Row, slope: f64, outer: f64, half: f64) -> Option<Lines> {
    let inner = inner_angle(outer, half, slope.atan())?;
    let down = row.at.half_width_m / slope;
    let across = down.hypot(row.at.half_width_m);
    Some(Lines {
        seam: DVec2::new(-outer.cos(), outer.sin()) * across,
        centre: DVec2::new(-inner.cos(), inner.sin()) * down,
        free: DVec2::ZERO,
    })
}

/// The row that begins below a gap: level, as far down as the lines over the gap allow, its centre at the same distance from the axis.
fn after_gap(gap: f64, width: f64, last: &Lines, half: f64) -> Option<Lines> {
    let inner = last.centre.y;
    // ρ² − 2 ρ ρ_i cos β + ρ_i² = b²
    let root = width * width - (inner * half.sin()).powi(2);
    if root < 0.0 {
        return None;
    }
    let outer = inner * half.cos() + root.sqrt();
    let beside = outer - last.seam.y;
    if beside.abs() >= gap {
        return None;
    }
    let x = (last.centre.x - gap).max(last.seam.x - (gap * gap - beside * beside).sqrt());
    Some(Lines {
        seam: DVec2::new(x, outer),
        centre: DVec2::new(x, inner),
        free: DVec2::ZERO,
    })
}

/// Next place of the centre line: `down` from the last one and `width` from the seam.
fn inner_point(last: DVec2, down: f64, seam: DVec2, width: f64, half: f64) -> Option<DVec2> {
    let target = DVec2::new(seam.x, seam.y * half.cos());
    let beside = seam.y * half.sin();
    let reach = width * width - beside * beside;
    let apart = target - last;
    let square = apart.length_squared();
    if square == 0.0 {
        return None;
    }
    // Circles about the last place and about the target.
    let along = 0.5 * (down * down - reach + square) / square;
    let height = down * down / square - along * along;
    if reach < 0.0 || height < -1e-12 {
        return None;
    }
    // The side on which the seam stays outside of the centre line.
    Some(last + apart * along + apart.perp() * height.max(0.0).sqrt())
}
