//! Tables of (place, value) that are straight between their points.

/// The value at a place between points whose places grow; the first or the last one's beyond them, 0 of an empty table.
#[must_use]
pub fn lookup(points: &[[f64; 2]], place: f64) -> f64 {
    let next = points.partition_point(|point| point[0] <= place);
    let before = next.checked_sub(1).map(|i| points[i]);
    match (before, points.get(next).copied()) {
        (Some([from, a]), Some([to, b])) => a + (b - a) * (place - from) / (to - from),
        (Some([_, only]), None) | (None, Some([_, only])) => only,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_straight_between_their_points() {
        let points = [[1.0, 0.2], [2.0, 0.6], [4.0, 1.0]];
        for (place, value) in [
            (0.0, 0.2),
            (1.0, 0.2),
            (1.5, 0.4),
            (3.0, 0.8),
            (4.0, 1.0),
            (9.0, 1.0),
        ] {
            assert!((lookup(&points, place) - value).abs() < 1e-15);
        }
        assert_eq!(lookup(&[], 1.0), 0.0);
    }
}
