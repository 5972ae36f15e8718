//! Checks of `structure.wing.vh_ribs`.

use super::file;
use super::problem::Problem;
use super::values::wing_key;
use crate::geometry::wing::plan::{VhRib, VhRibEnd};

/// Places of the chord between which one may be sewn to a rib.
const PLACES: std::ops::RangeInclusive<f64> = 0.0..=1.0;

/// The same, and the heights, away from both seams.
pub(super) const PLACES_BETWEEN_SEAMS: std::ops::RangeInclusive<f64> = 0.03..=0.95;
pub(super) const HEIGHTS_BETWEEN_SEAMS: std::ops::RangeInclusive<f64> = 0.1..=0.9;

pub(super) fn check(table: &file::Wing) -> Result<Vec<VhRib>, Problem> {
    let written = table.vh_ribs.iter().enumerate();
    written
        .map(|(number, one)| check_one(table.cells, number + 1, one))
        .collect()
}

fn check_one(cells: usize, number: usize, written: &file::VhRib) -> Result<VhRib, Problem> {
    let key = wing_key("vh_ribs");
    let refuse =
        |message: String, help: &str| Err(Problem::new(&key, format!("{key}: {message}"), help));
    let [one, other] = written.ribs;
    let last = cells.div_ceil(2);
    if one.abs_diff(other) != 1 || one.max(other) > last {
        return refuse(
            format!("number {number} leads from rib {one} to rib {other}, which are no neighbours"),
            &format!("name two neighbours of 0 to {last}, counted from the middle"),
        );
    }
    for (between, height) in written.between.iter().zip(written.heights) {
        let on_seam = height == 0.0 || height == 1.0;
        if !on_seam && !HEIGHTS_BETWEEN_SEAMS.contains(&height) {
            return refuse(
                format!("number {number} is sewn to a rib at {height} of its height"),
                "give 0 for the lower seam, 1 for the upper one, or 0.1 to 0.9",
            );
        }
        let allowed = if on_seam {
            PLACES
        } else {
            PLACES_BETWEEN_SEAMS
        };
        let [from, to] = *between;
        if !(from < to && allowed.contains(&from) && allowed.contains(&to)) {
            return refuse(
                format!("number {number} is sewn to a rib from {from} to {to} of the chord"),
                &format!(
                    "give two places that grow, within {} to {}",
                    allowed.start(),
                    allowed.end()
                ),
            );
        }
    }
    Ok(VhRib {
        ribs: written.ribs,
        ends: [0, 1].map(|end| VhRibEnd {
            between: written.between[end],
            height: written.heights[end],
        }),
    })
}
