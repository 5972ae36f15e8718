//! Extremes in which a value that is not a number counts: `f64::max` and `f64::min` pass over it, and a gate on them would hold.

/// The larger of two numbers; not a number where one of them is not.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The largest of numbers; not a number where one of them is not, or where there is none.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().reduce(larger).unwrap_or(f64::NAN)
}

/// The smallest of numbers, by the same rule.
pub(crate) fn smallest(values: impl IntoIterator<Item = f64>) -> f64 {
    -largest(values.into_iter().map(|value| -value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_not_passed_over() {
        assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
        assert_eq!(smallest([1.0, -3.0, 2.0]), -3.0);
        for place in 0..3 {
            let mut values = [1.0, 3.0, 2.0];
            values[place] = f64::NAN;
            assert!(largest(values).is_nan() && smallest(values).is_nan());
        }
        assert!(largest([]).is_nan() && smallest([]).is_nan());
    }
}
