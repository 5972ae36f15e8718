//! What LEparagliding found for the same wing: `lep-out.txt` and `lines.txt`, where they lie beside its input.

use super::super::load::Case;
use crate::geometry::wing::LineKind;

/// Measures of a wing, as far as the files tell them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Published {
    /// Flat area [m²].
    pub flat_area_m2: Option<f64>,
    /// Flat span [m].
    pub flat_span_m: Option<f64>,
    /// Projected area [m²].
    pub projected_area_m2: Option<f64>,
    /// Projected span [m].
    pub projected_span_m: Option<f64>,
    /// Length of all lines of both halves, without risers and brakes [m].
    pub lines_m: Option<f64>,
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
            lines_m: half_lines_m(lines).map(|half| 2.0 * half),
        }
    }
}

/// Length of the lines of one half: `12   4A4   90.1 cm  …`, where the first digit of a name is its level from the riser, 1, up.
fn half_lines_m(text: &str) -> Option<f64> {
    let length_m = |line: &str| {
        let mut words = line.split_whitespace();
        words.next()?.parse::<usize>().ok()?;
        let name = words.next()?;
        let length: f64 = words.next()?.parse().ok()?;
        let is_centimetres = words.next()? == "cm";
        let level = name.chars().next()?.to_digit(10)?;
        let is_brake = name[1..].starts_with(['F', 'f']) || name.to_lowercase().contains("br");
        (is_centimetres && level > 1 && !is_brake).then_some(0.01 * length)
    };
    let all: Vec<f64> = text.lines().filter_map(length_m).collect();
    (!all.is_empty()).then(|| all.iter().sum())
}

/// Length of all lines of a wing's rows but the brakes, both halves, at rest [m].
#[must_use]
pub fn line_length_m(case: &Case) -> f64 {
    let (Some(wing), Some(body)) = (case.scene.wing(), &case.scene.body) else {
        return 0.0;
    };
    let brake = wing.plan.rows.iter().position(|row| row.position >= 1.0);
    let cables = body.structure.cables.iter().zip(&wing.built.line_kinds);
    let lines = cables
        .filter(|(_, kind)| matches!(kind, LineKind::Line { row, .. } if Some(*row) != brake));
    lines.map(|(cable, _)| cable.rest_length_m).sum()
}
