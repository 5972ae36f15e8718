//! What a designer reads off a polar.

use super::solve::{Point, Polar};

/// Lift below this share of the highest one counts as straight.
const STRAIGHT_SHARE: f64 = 0.6;

/// Numbers of a polar; `None` where the sweep does not show them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Numbers {
    /// Slope of the lift coefficient where it is straight [1/°].
    pub lift_slope_per_deg: Option<f64>,
    /// Angle without lift [°].
    pub zero_lift_deg: Option<f64>,
    /// Highest lift coefficient of the branch that follows from small angles, and its angle [°]; `None` where the sweep ends before it.
    pub highest_lift: Option<(f64, f64)>,
    /// Least drag coefficient, and its angle [°].
    pub least_drag: Option<(f64, f64)>,
    /// Highest lift over drag, and its angle [°].
    pub best_glide: Option<(f64, f64)>,
    /// Slope of the pitching moment over lift where it is straight: minus the distance of the neutral point behind the reference point, in chords.
    pub moment_slope: Option<f64>,
}

/// Reads them off.
#[must_use]
pub fn numbers(polar: &Polar) -> Numbers {
    let points: Vec<(&Point, super::Coefficients)> = (polar.points.iter())
        .filter_map(|point| Some((point, point.coefficients?)))
        .collect();
    let highest = points
        .iter()
        .map(|(point, c)| (c.lift, point.angle_deg))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let ends = [points.first(), points.last()].map(|end| end.map(|(point, _)| point.angle_deg));
    // What lies at an end of the sweep may go on beyond it.
    let inside =
        |found: Option<(f64, f64)>| found.filter(|(_, angle)| !ends.contains(&Some(*angle)));
    let largest = points.iter().map(|(_, c)| c.lift.abs()).fold(0.0, f64::max);
    let limit = STRAIGHT_SHARE * largest;
    let straight: Vec<[f64; 3]> = points
        .iter()
        .filter(|(point, c)| c.lift.abs() <= limit && point.stalled_share == 0.0)
        .map(|(point, c)| [point.angle_deg, c.lift, c.pitching_moment])
        .collect();
    let line = fit(straight.iter().map(|[a, lift, _]| [*a, *lift]));
    let least = |value: &dyn Fn(&super::Coefficients) -> f64| {
        let all = points.iter().map(|(p, c)| (value(c), p.angle_deg));
        all.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    Numbers {
        lift_slope_per_deg: line.map(|(slope, _)| slope),
        zero_lift_deg: line.map(|(slope, at_zero)| -at_zero / slope),
        highest_lift: inside(highest),
        least_drag: inside(least(&super::Coefficients::drag)),
        best_glide: inside(least(&|c| -c.lift / c.drag())).map(|(minus, angle)| (-minus, angle)),
        moment_slope: fit(straight.iter().map(|[_, lift, moment]| [*lift, *moment]))
            .map(|(slope, _)| slope),
    }
}

/// Slope and value at zero of the straight line through points (least squares); `None` of fewer than two places.
fn fit(points: impl Iterator<Item = [f64; 2]>) -> Option<(f64, f64)> {
    let points: Vec<[f64; 2]> = points.collect();
    let count = points.len() as f64;
    let [x, y] = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let square: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    let product: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (points.len() > 1 && square > 0.0).then(|| {
        let slope = product / square;
        (slope, y - slope * x)
    })
}
