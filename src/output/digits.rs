//! Numbers for a reader: as many digits as are known.

use super::quantity::Quantity;

/// Digits of a value that has no confidence interval.
pub(super) const VALUE_DIGITS: i32 = 5;

/// Digits of the half width of a confidence interval, which set those of its value.
pub(super) const CONFIDENCE_DIGITS: i32 = 2;

/// Values below `1e-4` or from `1e6` on are written with an exponent.
pub(super) const PLAIN_EXPONENTS: std::ops::Range<i32> = -4..6;

/// Shown where there is no number.
pub const NOTHING: &str = "-";

/// Beside numbers that the run cannot support.
pub const UNRESOLVED: &str = "unresolved";

/// A value and its uncertainty for a reader; `-` where there is none.
///
/// A value is shown to the last digit of its half width, or of the interval between its samples, but never with less than two digits.
#[must_use]
pub fn value_and_uncertainty(quantity: &Quantity) -> [String; 2] {
    let Some(value) = quantity.value else {
        return [NOTHING.to_owned(), NOTHING.to_owned()];
    };
    let Some(half_width) = quantity.confidence.or(quantity.sampling_error) else {
        return [significant(value, VALUE_DIGITS), NOTHING.to_owned()];
    };
    let digits = if half_width > 0.0 && value != 0.0 {
        exponent(value) - exponent(half_width) + CONFIDENCE_DIGITS
    } else {
        VALUE_DIGITS
    };
    let digits = digits.clamp(CONFIDENCE_DIGITS, 2 * VALUE_DIGITS);
    let half_width = format!("±{}", significant(half_width, CONFIDENCE_DIGITS));
    [significant(value, digits), half_width]
}

/// A result's value with the half width of its interval, if it has one; without its unit.
#[must_use]
pub fn with_interval(quantity: &Quantity) -> String {
    let [value, uncertainty] = value_and_uncertainty(quantity);
    if uncertainty == NOTHING {
        value
    } else {
        format!("{value} {uncertainty}")
    }
}

/// What a result is compared with, such as `0.29241 by catenary, error +0.1 %`; `None` without a reference.
#[must_use]
pub fn reference_text(quantity: &Quantity) -> Option<String> {
    let mut text = significant(quantity.reference?, VALUE_DIGITS);
    if let Some(source) = &quantity.source {
        text += &format!(" by {source}");
    }
    if let Some(error) = quantity.error {
        text += &format!(", error {:+.1} %", 100.0 * error);
    }
    Some(text)
}

/// Power of ten of the leading digit of a finite number; 0 for zero.
pub(super) fn exponent(number: f64) -> i32 {
    let text = format!("{number:e}");
    let power = text.rsplit('e').next();
    power.and_then(|power| power.parse().ok()).unwrap_or(0)
}

/// `number` rounded to so many digits.
#[must_use]
pub fn significant(number: f64, digits: i32) -> String {
    let decimals = |count: i32| usize::try_from(count).unwrap_or(0);
    let rounded = format!("{number:.*e}", decimals(digits - 1));
    // Rounding may have carried into another digit, as in 9.99996.
    let exponent = rounded.parse().map_or(0, exponent);
    if number == 0.0 {
        "0".to_owned()
    } else if PLAIN_EXPONENTS.contains(&exponent) {
        // Digits before the point beyond those wanted are noughts.
        let number: f64 = rounded.parse().unwrap_or(number);
        format!("{number:.*}", decimals(digits - 1 - exponent))
    } else {
        rounded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_is_known() {
        assert_eq!(significant(0.0, 5), "0");
        assert_eq!(significant(9.999_996, 5), "10.000");
        assert_eq!(significant(-0.000_123_456, 3), "-0.000123");
        assert_eq!(significant(123_456.0, 3), "123000");
        assert_eq!(significant(1.5e6, 3), "1.50e6");
        assert_eq!(significant(999_999.9, 3), "1.00e6");
        let known = |value, half_width| {
            value_and_uncertainty(&Quantity::new(value).with_confidence(half_width))
        };
        assert_eq!(known(12.345_67, 0.123), ["12.35", "±0.12"]);
        assert_eq!(known(0.01, 3.0), ["0.010", "±3.0"]);
        assert_eq!(known(1.0, 0.0), ["1.0000", "±0"]);
    }
}
