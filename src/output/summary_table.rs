//! The results of a [`Summary`] as a table for the terminal.

use super::summary::{Quantity, Summary};

/// Digits of a value that has no confidence interval.
const VALUE_DIGITS: i32 = 5;
/// Digits of the half width of a confidence interval, which set those of its value.
const CONFIDENCE_DIGITS: i32 = 2;
/// Values below `1e-4` or from `1e6` on are written with an exponent.
const PLAIN_EXPONENTS: std::ops::Range<i32> = -4..6;
/// Results that are named of those that the same reason makes unresolved.
const NAMED: usize = 4;
/// Shown where there is no number.
pub(super) const NOTHING: &str = "-";
/// Beside numbers that the run cannot support.
pub(super) const UNRESOLVED: &str = "unresolved";

impl Summary {
    /// The results as an aligned plain-text table: name, value with the half width of its 95 %
    /// confidence interval (or the interval between samples where it was read from single ones), unit, reference and relative error, followed by the results' notes.
    ///
    /// Every line ends with a line feed.
    pub fn table(&self) -> String {
        let summary = self.finite();
        if summary.results.is_empty() {
            return "no results\n".to_owned();
        }
        let header = ["result", "value", "±", "unit", "reference", "error", ""];
        let mut rows = vec![header.map(str::to_owned)];
        rows.extend(
            summary
                .results
                .iter()
                .map(|(name, quantity)| row(name, quantity)),
        );
        let mut text = align(&rows);
        for (name, quantity) in summary.results.iter() {
            if let Some(note) = &quantity.note {
                text += &format!("{name}: {note}\n");
            }
        }
        text + &unresolved(summary.results.iter())
    }
}

/// Results that the run cannot support, by why.
fn unresolved<'a>(results: impl Iterator<Item = (&'a str, &'a Quantity)>) -> String {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for (name, quantity) in results {
        let Some(why) = &quantity.unresolved else {
            continue;
        };
        match reasons.iter_mut().find(|(known, _)| known == why) {
            Some((_, names)) => names.push(name),
            None => reasons.push((why, vec![name])),
        }
    }
    reasons
        .iter()
        .map(|(why, names)| {
            let more = names.len().saturating_sub(NAMED);
            let and = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            let named = &names[..names.len().min(NAMED)];
            format!("{UNRESOLVED}: {}{and}: {why}\n", named.join(", "))
        })
        .collect()
}

fn row(name: &str, quantity: &Quantity) -> [String; 7] {
    let [value, confidence] = value_and_uncertainty(quantity);
    let reference = quantity
        .reference
        .map(|number| significant(number, VALUE_DIGITS));
    let error = quantity
        .error
        .map(|error| format!("{:+.1} %", 100.0 * error));
    [
        name.to_owned(),
        value,
        confidence,
        quantity.unit.clone(),
        reference.unwrap_or_else(|| NOTHING.to_owned()),
        error.unwrap_or_else(|| NOTHING.to_owned()),
        quantity
            .unresolved
            .as_ref()
            .map_or_else(String::new, |_| UNRESOLVED.to_owned()),
    ]
}

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

/// Power of ten of the leading digit of a finite number; 0 for zero.
fn exponent(number: f64) -> i32 {
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

/// Pads the columns to their widest entry: names and units to the left, numbers to the right.
fn align(rows: &[[String; 7]]) -> String {
    let width = |column: usize| {
        let lengths = rows.iter().map(|row| row[column].chars().count());
        lengths.max().unwrap_or(0)
    };
    let widths: [usize; 7] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let [name, value, confidence, unit, reference, error, remark] = row;
        let [w0, w1, w2, w3, w4, w5, w6] = widths;
        let line = format!(
            "{name:<w0$}  {value:>w1$} {confidence:<w2$}  {unit:<w3$}  {reference:>w4$}  {error:>w5$}  {remark:<w6$}"
        );
        text += line.trim_end();
        text.push('\n');
    }
    text
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
