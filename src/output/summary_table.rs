//! The results of a [`Summary`] as a table for the terminal.

use super::digits::{NOTHING, UNRESOLVED, VALUE_DIGITS, significant, value_and_uncertainty};
use super::quantity::Quantity;
use super::summary::Summary;

/// Results that are named of those that the same reason makes unresolved.
const NAMED: usize = 4;
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
