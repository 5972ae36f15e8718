//! Sections of a wing's surface: profiles, chords, twist and lean, cut from its triangles.
//!
//! Planes along the stream are laid across the span twice: first at even distances from the middle, through whose quarter chords a line runs; then across that line, so that sections of
//! an arched wing are those that its span meets squarely. x runs downstream, y along the span, z up.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::geometry::profile::Profile;
use crate::rigid::Surface;

/// Planes of the first pass.
const FIRST_PLANES: usize = 60;

/// The outermost section that is cut stands at this share of the way to the tip, which has none itself.
const OUTERMOST: f64 = 0.97;

/// How far the tip may lie beyond the last section, over the distance of the last two; and its least chord over that of the last.
const MOST_BEYOND: f64 = 4.0;
const LEAST_TIP: f64 = 0.05;

/// Points this near the rear end, per chord, are corners of a blunt trailing edge.
const BLUNT: f64 = 0.004;

/// A section of a wing.
#[derive(Debug, Clone)]
pub struct CutSection {
    /// Quarter of its chord [m].
    pub quarter_m: DVec3,
    /// Chord [m].
    pub chord_m: f64,
    /// Turn of the chord, nose up [rad].
    pub twist_rad: f64,
    /// Lean of the span there, the right tip up [rad].
    pub roll_rad: f64,
    /// Its outline.
    pub profile: Profile,
}

/// Cuts the half of a wing at y ≥ 0 into `count` sections, at least 3, from the middle outwards; the last one, at the tip, goes on as the two before it.
///
/// # Errors
///
/// Where a plane meets no section; the text says where.
pub fn sections(surface: &Surface, count: usize) -> Result<Vec<CutSection>, String> {
    let widest = surface.positions_m.iter().map(|p| p.y).fold(0.0, f64::max);
    if widest <= 0.0 {
        return Err("no vertex lies at y > 0: the span has to run along y".to_owned());
    }
    let mut line: Vec<DVec3> = Vec::new();
    for k in 0..FIRST_PLANES {
        // Not through vertices, of which many meshes have rows at round places.
        let y = widest * (k as f64 + 0.013) / FIRST_PLANES as f64;
        if let Some(section) = at(surface, DVec3::Y * y, DVec3::Y, None) {
            line.push(section.quarter_m);
        }
    }
    if line.len() < FIRST_PLANES / 2 {
        return Err("most planes along the stream meet no section that is closed at its nose: the mesh has to be the surface of a wing, intakes closed, x downstream, y along the span, z up".to_owned());
    }
    let mut lengths = vec![0.0];
    for pair in line.windows(2) {
        let step = pair[1] - pair[0];
        lengths.push(lengths[lengths.len() - 1] + step.y.hypot(step.z));
    }
    let whole = lengths[lengths.len() - 1];
    let mut found: Vec<CutSection> = (0..count - 1)
        .map(|k| {
            let along = OUTERMOST * whole * k as f64 / (count - 2).max(1) as f64;
            let piece = lengths
                .partition_point(|l| *l <= along)
                .clamp(1, line.len() - 1)
                - 1;
            let share = (along - lengths[piece]) / (lengths[piece + 1] - lengths[piece]);
            let point = line[piece].lerp(line[piece + 1], share);
            // Over neighbours on both sides: single steps carry the unevenness of the mesh.
            let [from, to] = [piece.saturating_sub(1), (piece + 2).min(line.len() - 1)];
            let step = line[to] - line[from];
            let across = DVec3::new(0.0, step.y, step.z).normalize();
            let across = if k == 0 { DVec3::Y } else { across };
            at(surface, point, across, Some(point)).ok_or_else(|| {
                format!(
                    "the plane at y = {:.3} m, z = {:.3} m meets no closed section",
                    point.y, point.z
                )
            })
        })
        .collect::<Result<_, String>>()?;
    if let [.., before, last] = &found[..] {
        let tip = tip(before, last, widest);
        found.push(tip);
    }
    Ok(found)
}

/// The tip, where the last two sections lead to: as far out as the surface reaches.
fn tip(before: &CutSection, last: &CutSection, widest: f64) -> CutSection {
    let step = last.quarter_m - before.quarter_m;
    let lacking = (widest - last.quarter_m.y).max(0.0);
    let share = (lacking / step.y.max(f64::MIN_POSITIVE)).min(MOST_BEYOND);
    let on = |from: f64, to: f64| to + share * (to - from);
    CutSection {
        quarter_m: last.quarter_m + share * step,
        chord_m: on(before.chord_m, last.chord_m).max(LEAST_TIP * last.chord_m),
        twist_rad: on(before.twist_rad, last.twist_rad),
        roll_rad: on(before.roll_rad, last.roll_rad),
        profile: last.profile.clone(),
    }
}

/// The section in a plane; of several the one nearest to a point, or the longest.
fn at(surface: &Surface, point: DVec3, across: DVec3, near: Option<DVec3>) -> Option<CutSection> {
    let chains = chains(surface, point, across);
    let length =
        |chain: &Vec<DVec3>| -> f64 { chain.windows(2).map(|p| p[0].distance(p[1])).sum() };
    let longest = chains.iter().map(length).fold(0.0, f64::max);
    let chain = chains
        .iter()
        .filter(|chain| length(chain) > 0.3 * longest)
        .min_by(|a, b| {
            let off = |chain: &Vec<DVec3>| {
                let middle = chain.iter().sum::<DVec3>() / chain.len() as f64;
                near.map_or_else(|| -length(chain), |near| middle.distance(near))
            };
            off(a).total_cmp(&off(b))
        })?;
    section(chain, across)
}

/// Polygons in which a plane cuts the triangles.
fn chains(surface: &Surface, point: DVec3, across: DVec3) -> Vec<Vec<DVec3>> {
    let side: Vec<f64> = surface
        .positions_m
        .iter()
        .map(|p| (*p - point).dot(across))
        .collect();
    let is_above = |node: u32| side[node as usize] >= 0.0;
    // Edges of the mesh that are cut, each with those that triangles join it to.
    let mut joined: HashMap<(u32, u32), Vec<(u32, u32)>> = HashMap::new();
    for triangle in &surface.triangles {
        let edges: Vec<(u32, u32)> = (0..3)
            .map(|k| (triangle[k], triangle[(k + 1) % 3]))
            .filter(|&(a, b)| is_above(a) != is_above(b))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        if let [a, b] = edges[..] {
            joined.entry(a).or_default().push(b);
            joined.entry(b).or_default().push(a);
        }
    }
    let place = |(a, b): (u32, u32)| {
        let [p, q] = [a, b].map(|n| surface.positions_m[n as usize]);
        let [low, high] = [a, b].map(|n| side[n as usize]);
        p.lerp(q, low / (low - high))
    };
    let mut left: Vec<(u32, u32)> = joined.keys().copied().collect();
    // Ends of open chains first; sorted, so that the order of a table decides nothing.
    left.sort_unstable_by_key(|edge| (joined[edge].len(), *edge));
    let mut seen: HashMap<(u32, u32), ()> = HashMap::new();
    let mut chains = Vec::new();
    for begin in left {
        if seen.insert(begin, ()).is_some() {
            continue;
        }
        let mut chain = vec![begin];
        let mut here = begin;
        while let Some(&next) = joined[&here].iter().find(|edge| !seen.contains_key(*edge)) {
            seen.insert(next, ());
            chain.push(next);
            here = next;
        }
        let is_closed = chain.len() > 2 && joined[&here].contains(&begin);
        let mut points: Vec<DVec3> = chain.into_iter().map(place).collect();
        if is_closed {
            points.push(points[0]);
        }
        points.dedup_by(|a, b| a.distance(*b) < 1e-12);
        chains.push(points);
    }
    chains
}

/// Chord, twist and outline of a polygon.
fn section(chain: &[DVec3], across: DVec3) -> Option<CutSection> {
    let up = DVec3::X.cross(across);
    let origin = *chain.first()?;
    let flat = |p: DVec3| DVec2::new((p - origin).x, (p - origin).dot(up));
    let mut points: Vec<DVec2> = chain.iter().map(|p| flat(*p)).collect();
    let is_closed = points.len() > 3 && points[0].distance(points[points.len() - 1]) < 1e-9;
    let rear = points.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let front = points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let length = rear - front;
    if points.len() < 8 || length <= 0.0 {
        return None;
    }
    if is_closed {
        points.pop();
        let first = (0..points.len()).max_by(|&a, &b| points[a].x.total_cmp(&points[b].x))?;
        points.rotate_left(first);
        // Corners of a blunt edge: the outline begins at one and ends at the other.
        let is_rear = |p: &DVec2| rear - p.x < BLUNT * length;
        let ahead = points.iter().position(|p| !is_rear(p))?;
        let behind = points.iter().rposition(|p| !is_rear(p))?;
        let (begin, end) = (points[ahead - 1], points[(behind + 1) % points.len()]);
        points = std::iter::once(begin)
            .chain(points[ahead..=behind].iter().copied())
            .chain([end])
            .collect();
    }
    let last = points.len() - 1;
    let tail = points[0].midpoint(points[last]);
    let nose = points
        .iter()
        .copied()
        .max_by(|a, b| a.distance(tail).total_cmp(&b.distance(tail)))?;
    let chord = tail - nose;
    // An outline that is open at its nose, as at an intake, begins there.
    if chord.x <= 0.0 {
        return None;
    }
    let back = DVec2::new(chord.x, -chord.y) / chord.length_squared();
    let mut outline: Vec<DVec2> = points.iter().map(|p| (*p - nose).rotate(back)).collect();
    // Lower side first.
    let doubled: f64 = outline.windows(2).map(|p| p[0].perp_dot(p[1])).sum();
    if doubled > 0.0 {
        outline.reverse();
    }
    let quarter = nose + 0.25 * chord;
    Some(CutSection {
        quarter_m: origin + DVec3::X * quarter.x + up * quarter.y,
        chord_m: chord.length(),
        twist_rad: (-chord.y).atan2(chord.x),
        roll_rad: across.z.atan2(across.y),
        profile: Profile::new(outline).ok()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An arched, tapered, twisted wing of triangles is cut into what it was made of.
    #[test]
    fn a_wing_is_cut_into_its_sections() {
        const STRIPS: usize = 24;
        const SIDE: usize = 60;
        let profile = Profile::naca("2415").unwrap().resampled(SIDE);
        let mut surface = Surface::default();
        let row = profile.len() as u32 - 1;
        // Lean from 0 to 60 degrees along an arc of 4 m radius.
        let lean = |share: f64| 60f64.to_radians() * share;
        let chord = |share: f64| 1.5 - 0.7 * share;
        let twist = |share: f64| -0.06 * share;
        for strip in 0..=2 * STRIPS {
            let share = strip as f64 / STRIPS as f64 - 1.0;
            let angle = lean(share);
            let middle = DVec3::new(
                0.2 * share * share,
                4.0 * angle.sin(),
                4.0 * (angle.cos() - 1.0),
            );
            let normal = DVec3::new(0.0, angle.sin(), angle.cos());
            let (c, t) = (chord(share.abs()), twist(share.abs()));
            for p in &profile[..row as usize] {
                let (x, y) = ((p.x - 0.25) * c, p.y * c);
                surface.positions_m.push(
                    middle
                        + DVec3::X * (x * t.cos() + y * t.sin())
                        + normal * (y * t.cos() - x * t.sin()),
                );
            }
        }
        for strip in 0..2 * STRIPS as u32 {
            for k in 0..row {
                let at = |strip: u32, k: u32| strip * row + k % row;
                surface
                    .triangles
                    .push([at(strip, k), at(strip, k + 1), at(strip + 1, k + 1)]);
                surface
                    .triangles
                    .push([at(strip, k), at(strip + 1, k + 1), at(strip + 1, k)]);
            }
        }
        let found = sections(&surface, 7).unwrap();
        assert_eq!(found.len(), 7);
        for section in &found {
            let angle = section.quarter_m.y.atan2(section.quarter_m.z + 4.0);
            let share = angle / lean(1.0);
            assert!(
                (section.chord_m - chord(share)).abs() < 0.01,
                "{share}: {}",
                section.chord_m
            );
            assert!(
                (section.twist_rad - twist(share)).abs() < 0.01,
                "{share}: {}",
                section.twist_rad
            );
            assert!(
                (section.roll_rad + angle).abs() < 0.03,
                "{share}: {}",
                section.roll_rad
            );
            assert!((section.profile.thickness() - 0.15).abs() < 0.003);
            let camber = section.profile.camber(&[0.4])[0];
            assert!((camber - 0.02).abs() < 0.003, "{share}: {camber}");
        }
        let widest = 4.0 * lean(1.0).sin();
        // The upper side of a leaning tip reaches farther than its quarter line.
        assert!((found[6].quarter_m.y - widest).abs() < 0.08);
        assert!(sections(&Surface::default(), 4).is_err());
    }
}
