//! Which of several settings are worth their time.

/// True for every point (seconds, error) that no other beats in one and equals in the other; points that are not finite never are.
pub(super) fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    points
        .iter()
        .map(|&(seconds, error)| {
            seconds.is_finite()
                && error.is_finite()
                && !points
                    .iter()
                    .any(|&(s, e)| s <= seconds && e <= error && (s < seconds || e < error))
        })
        .collect()
}

/// Index of the fastest point with an error of at most `limit`.
pub(super) fn fastest_within(points: &[(f64, f64)], limit: f64) -> Option<usize> {
    (0..points.len())
        .filter(|&i| points[i].1 <= limit && points[i].0.is_finite())
        .min_by(|&i, &j| points[i].0.total_cmp(&points[j].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [(f64, f64); 6] = [
        (1.0, 0.5),
        (2.0, 0.2),
        (3.0, 0.3),
        (4.0, 0.01),
        (0.5, f64::NAN),
        (9.0, 0.01),
    ];

    #[test]
    fn only_unbeaten_points_are_on_the_front() {
        assert_eq!(pareto(&POINTS), [true, true, false, true, false, false]);
    }

    #[test]
    fn the_fastest_accurate_point_is_found() {
        assert_eq!(fastest_within(&POINTS, 0.3), Some(1));
        assert_eq!(fastest_within(&POINTS, 0.05), Some(3));
        assert_eq!(fastest_within(&POINTS, 1e-3), None);
    }
}
