//! Outlines of sections: what is refused.
//!
//! Points go from the trailing edge along the lower side around the nose and along the upper side to the trailing edge, in chords, with the
//! nose near x = 0 and the trailing edge near x = 1.

use glam::DVec2;

use super::error::SectionError;

/// A trailing edge may be open by this much [chords].
const WIDEST_GAP: f64 = 0.05;

/// Thinner outlines than this are refused [chords].
const LEAST_THICKNESS: f64 = 0.002;

/// Refuses what is no outline, with the reason.
pub fn check(points: &[DVec2]) -> Result<(), SectionError> {
    let wrong = |what: String| Err(SectionError::Outline(what));
    if points.len() < 10 {
        return wrong(format!(
            "{} points are too few, at least 10 are needed",
            points.len()
        ));
    }
    if let Some(k) = points.iter().position(|p| !p.is_finite()) {
        return wrong(format!("point {k} is not finite"));
    }
    if let Some(k) = points.windows(2).position(|p| p[0].distance(p[1]) < 1e-9) {
        return wrong(format!("points {k} and {} coincide", k + 1));
    }
    let (first, last) = (points[0], points[points.len() - 1]);
    let edge = 0.5 * (first + last);
    let nose = points.iter().fold(f64::INFINITY, |x, p| x.min(p.x));
    if nose.abs() > 0.05 || (edge.x - 1.0).abs() > 0.05 || edge.y.abs() > 0.2 {
        return wrong(
            "the chord has to lie from x = 0 at the nose to x = 1 at the trailing edge".to_owned(),
        );
    }
    if first.distance(last) > WIDEST_GAP {
        return wrong(format!(
            "the trailing edge is open by more than {WIDEST_GAP} chords"
        ));
    }
    let closing = std::iter::once([last, first]);
    let doubled: f64 = points
        .windows(2)
        .map(|p| [p[0], p[1]])
        .chain(closing)
        .map(|[a, b]| a.perp_dot(b))
        .sum();
    if doubled > 0.0 {
        return wrong("the points have to begin along the lower side".to_owned());
    }
    if let Some((j, k)) = crossing(points) {
        return wrong(format!("it crosses itself, near points {j} and {k}"));
    }
    // Two thirds of the thickness times the chord is about the area.
    if -0.75 * doubled < LEAST_THICKNESS {
        return wrong("it encloses no area".to_owned());
    }
    Ok(())
}

/// First pair of straight pieces that cross or touch.
fn crossing(points: &[DVec2]) -> Option<(usize, usize)> {
    let pieces = points.len() - 1;
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
    for j in 0..pieces {
        for k in j + 2..pieces {
            let [a, b, c, d] = [points[j], points[j + 1], points[k], points[k + 1]];
            if j == 0 && k == pieces - 1 && a.distance(d) < 1e-9 {
                // They share a closed trailing edge.
                continue;
            }
            if side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 {
                let straight = side(a, b, c) == 0.0 && side(a, b, d) == 0.0;
                let apart = (c - a).dot(b - a) > (b - a).length_squared();
                if !(straight && apart) {
                    return Some((j, k));
                }
            }
        }
    }
    None
}
