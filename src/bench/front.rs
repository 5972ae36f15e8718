//! Which of several settings are worth their time.

/// True for every point that no other beats in one coordinate and equals or beats in the others; points that are not finite never are.
pub(super) fn unbeaten<const N: usize>(points: &[[f64; N]]) -> Vec<bool> {
    let beats = |one: &[f64; N], other: &[f64; N]| {
        (0..N).all(|i| one[i] <= other[i]) && (0..N).any(|i| one[i] < other[i])
    };
    points
        .iter()
        .map(|point| {
            point.iter().all(|x| x.is_finite()) && !points.iter().any(|other| beats(other, point))
        })
        .collect()
}

/// The same of points (seconds, error).
pub(super) fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let points: Vec<[f64; 2]> = points.iter().map(|&(s, e)| [s, e]).collect();
    unbeaten(&points)
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

    /// A third coordinate keeps a point that two would beat.
    #[test]
    fn points_of_three_coordinates() {
        let points = [
            [1.0, 2.0, 3.0],
            [2.0, 3.0, 1.0],
            [2.0, 3.0, 3.5],
            [1.0, 2.0, f64::NAN],
        ];
        assert_eq!(unbeaten(&points), [true, true, false, false]);
    }

    #[test]
    fn the_fastest_accurate_point_is_found() {
        assert_eq!(fastest_within(&POINTS, 0.3), Some(1));
        assert_eq!(fastest_within(&POINTS, 0.05), Some(3));
        assert_eq!(fastest_within(&POINTS, 1e-3), None);
    }
}
