//! Whether a set-up can support its results: rows of the validity table, and the error to be expected of a lattice and a box.

use serde::{Deserialize, Serialize};

use super::digits::significant;
use super::quantity::Results;

/// Digits of values.
const DIGITS: i32 = 3;

/// On which side of its limit a value must lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// At most the limit.
    AtMost,
    /// At least the limit.
    AtLeast,
}

/// When a row is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum When {
    /// From the case alone, by `ripstop check`, too.
    Beforehand,
    /// At the end of the run.
    AtTheEnd,
}

/// Which results a row supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Supports {
    /// All.
    Everything,
    /// Forces and shapes of the settled flow.
    Means,
    /// Largest values and times of an opening.
    Opening,
    /// Lift, and what follows from it.
    Lift,
}

/// Results that say how well a run did, or repeat what the case has, and need no support.
const DIAGNOSTICS: [&str; 8] = [
    "reference_area_m2",
    "force_imbalance",
    "mass_drift",
    "slip_mean",
    "blockage_ratio",
    "dynamic_pressure_ratio_of_blockage",
    "through_velocity_of_slip_m_s",
    "projected_diameter_ratio_at_release",
];

/// Parts of names of results that belong to an opening.
const OF_OPENINGS: [&str; 7] = [
    "_max",
    "_min",
    "opening",
    "fill_time",
    "largest",
    "top_open",
    "peak",
];

/// Parts of names of results that belong to lift.
const OF_LIFT: [&str; 4] = ["lift", "glide", "moment_", "incidence"];

impl Supports {
    /// Whether the result of that name needs the row.
    #[must_use]
    pub fn covers(self, result: &str) -> bool {
        let has = |parts: &[&str]| parts.iter().any(|part| result.contains(part));
        // Extremes over the fabric, averaged over a window, are means.
        let opening = has(&OF_OPENINGS) && !result.contains("steady");
        if DIAGNOSTICS.iter().any(|name| result.ends_with(name)) {
            return false;
        }
        match self {
            Self::Everything => true,
            Self::Means => !opening,
            Self::Opening => opening,
            Self::Lift => has(&OF_LIFT),
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Everything => "all results",
            Self::Means => "means",
            Self::Opening => "largest values and times of the opening",
            Self::Lift => "lift",
        }
    }
}

/// One row of the validity table.
///
/// In the file every key is present; `null` means that there is no such number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ValidityRow {
    /// What is looked at.
    pub name: String,
    /// Its unit, `1` for a plain number.
    pub unit: String,
    /// What the value is, and of what.
    pub meaning: String,
    /// When it is known.
    pub when: When,
    /// The value; `None` where it is not known.
    pub value: Option<f64>,
    /// Where it must lie.
    pub bound: Bound,
    /// The limit.
    pub limit: f64,
    /// Whether it lies there; `None` where it is not known.
    pub valid: Option<bool>,
    /// Which results need it.
    pub supports: Supports,
    /// Beginning of the names of those results; empty: of all.
    pub prefix: String,
    /// What to do where it does not.
    pub remedy: String,
}

impl ValidityRow {
    fn number(&self, value: f64) -> String {
        let number = significant(value, DIGITS);
        if self.unit == "1" {
            number
        } else {
            format!("{number} {}", self.unit)
        }
    }

    /// What is wanted, such as `at most 0.300`.
    #[must_use]
    pub fn wanted(&self) -> String {
        format!("{} {}", self.side(), self.number(self.limit))
    }

    fn side(&self) -> &'static str {
        match self.bound {
            Bound::AtMost => "at most",
            Bound::AtLeast => "at least",
        }
    }

    /// The finding in a few words, for results that lack support.
    #[must_use]
    pub fn finding(&self) -> String {
        let value = self.value.map_or_else(String::new, |v| self.number(v));
        format!(
            "{} {value}, {} {} wanted",
            self.name,
            self.side(),
            self.number(self.limit)
        )
    }

    /// One line for a reader.
    #[must_use]
    pub fn line(&self) -> String {
        let value = self
            .value
            .map_or_else(|| "not known".to_owned(), |v| self.number(v));
        let verdict = match self.valid {
            Some(true) => "ok",
            Some(false) => "NO",
            None => "?",
        };
        let mut line = format!(
            "{verdict:<3} {:<44} {value} ({} {})",
            self.name,
            self.side(),
            self.number(self.limit)
        );
        if self.valid == Some(false) {
            line += &format!(
                "; not supported: {}; {}",
                self.supports.words(),
                self.remedy
            );
        }
        line
    }
}

/// Marks results that the table does not support as unresolved.
pub fn mark(results: &mut Results, rows: &[ValidityRow]) {
    let lacking = rows.iter().filter(|row| row.valid == Some(false));
    for row in lacking {
        for (name, quantity) in results.iter_mut() {
            // The name of a body tells nothing of its results.
            let own = name.strip_prefix(&row.prefix);
            if own.is_some_and(|own| row.supports.covers(own)) && quantity.value.is_some() {
                quantity.mark_unresolved(&row.finding());
            }
        }
    }
}

/// What is to be expected of a result, beforehand: parts that add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectedError {
    /// Of which result, and of what.
    pub quantity: String,
    /// Their sum over the value in an unbounded stream on a fine lattice, with its sign.
    pub total: f64,
    /// What it comes from, and how much.
    pub parts: Vec<(String, f64)>,
}

/// Parts below this share are not named.
const NAMED: f64 = 5e-4;

impl ExpectedError {
    /// One line for a reader.
    #[must_use]
    pub fn line(&self) -> String {
        let percent = |share: f64| format!("{:+.1} %", 100.0 * share);
        let named = self.parts.iter().filter(|(_, part)| part.abs() >= NAMED);
        let parts: Vec<String> = named
            .map(|(name, part)| format!("{name} {}", percent(*part)))
            .collect();
        let of = if parts.is_empty() {
            String::new()
        } else {
            format!(" ({})", parts.join(", "))
        };
        let side = if self.total < 0.0 { "low" } else { "high" };
        let share = 100.0 * self.total.abs();
        format!("{} about {share:.1} % too {side}{of}", self.quantity)
    }
}
