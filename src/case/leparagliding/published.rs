//! What LEparagliding found for the same wing: `lep-out.txt` and `lines.txt`, where they lie beside its input.

use super::super::load::Case;
use super::read::CENTIMETRE_M;
use crate::geometry::wing::LineKind;

/// Measures of a wing, as far as the files tell them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Published {
    /// Flat area [m²].
    pub flat_area_m2: Option<f64>,
    /// Flat span [m].
    pub flat_span_m: Option<f64>,
    /// Projected area [m²].
    pub projected_area_m2: Option<f64>,
    /// Projected span [m].
    pub projected_span_m: Option<f64>,
    /// Names of rows, as the plan has them, and lengths of their lines above the risers and the brakes' main line, both halves [m].
    pub rows_m: Vec<(String, f64)>,
}

impl Published {
    /// Reads the texts of both files; an empty one tells nothing.
    #[must_use]
    pub fn read(measures: &str, lines: &str) -> Self {
        let of = |name: &str| {
            let rest = measures.lines().find_map(|line| {
                let rest = line.trim().strip_prefix(name)?;
                rest.trim_start().strip_prefix('=')
            });
            rest?.split_whitespace().next()?.parse().ok()
        };
        Self {
            flat_area_m2: of("Flat area"),
            flat_span_m: of("Flat span"),
            projected_area_m2: of("Projected area"),
            projected_span_m: of("Projected span"),
            rows_m: rows_m(lines),
        }
    }
}

/// Lengths by rows of lines as `12   4A4   90.1 cm  …` under `Plan A` or `Brake lines`, where the first digit of a name is its level, from 1 for the
/// riser or the brakes' main line. Older versions write no unit.
fn rows_m(text: &str) -> Vec<(String, f64)> {
    let mut rows: Vec<(String, f64)> = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("Brake lines") {
            rows.push(("brake".to_owned(), 0.0));
        } else if let Some(name) = line.strip_prefix("Plan ") {
            rows.push((name.trim().to_owned(), 0.0));
        } else if let (Some(length_m), Some((_, sum))) = (upper_line_m(line), rows.last_mut()) {
            // That of the other half is as long.
            *sum += 2.0 * length_m;
        }
    }
    // A row of risers alone has nothing to compare.
    rows.retain(|(_, length_m)| *length_m > 0.0);
    rows
}

/// Length of a line above the first level [m]; `None` of anything else.
fn upper_line_m(line: &str) -> Option<f64> {
    let mut words = line.split_whitespace();
    words.next()?.parse::<usize>().ok()?;
    let mut name = words.next()?.chars();
    let level = name.next()?.to_digit(10)?;
    let is_name = name.next()?.is_ascii_uppercase() && name.all(|digit| digit.is_ascii_digit());
    let length: f64 = words.next()?.parse().ok()?;
    (is_name && level > 1).then_some(CENTIMETRE_M * length)
}

/// Names of a wing's rows and lengths of their lines without risers, both halves, at rest [m].
#[must_use]
pub fn rows_of_lines_m(case: &Case) -> Vec<(String, f64)> {
    let (Some(wing), Some(body)) = (case.scene.wing(), &case.scene.body) else {
        return Vec::new();
    };
    let cables = || body.structure.cables.iter().zip(&wing.built.line_kinds);
    let of = |number: usize| {
        let lines = cables()
            .filter(|(_, kind)| matches!(kind, LineKind::Line { row, .. } if *row == number));
        lines.map(|(cable, _)| cable.rest_length_m).sum()
    };
    (wing.built.row_names.iter().enumerate())
        .map(|(number, name)| (name.clone(), of(number)))
        .collect()
}

/// Sum over the rows but the brakes; `None` without rows.
#[must_use]
pub fn lines_m(rows: &[(String, f64)]) -> Option<f64> {
    let others = rows.iter().filter(|(name, _)| name != "brake");
    (!rows.is_empty()).then(|| others.map(|(_, length_m)| length_m).sum())
}
