//! The account of a run: what its solvers and balances reached. Rows of `summary.json` and of the terminal.

use serde::{Deserialize, Serialize};

use super::digits::significant;

/// Digits of values.
const DIGITS: i32 = 3;

/// One solver or balance.
///
/// In the file every key is present; `null` means that there is no such number.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AccountRow {
    /// What was solved or balanced.
    pub name: String,
    /// What `value` is.
    pub meaning: String,
    /// SI unit, `1` for a plain number.
    pub unit: String,
    /// What was reached.
    pub value: Option<f64>,
    /// What it may be at most; `None` where nothing is asked of it.
    pub limit: Option<f64>,
    /// Whether it is as it should be; `None` where nothing is asked of it, or nothing is known.
    pub reached: Option<bool>,
    /// Counts, and when it was worst.
    pub detail: String,
}

impl AccountRow {
    /// A row whose value may be `limit` at most.
    #[must_use]
    pub fn at_most(name: &str, meaning: &str, unit: &str, value: f64, limit: f64) -> Self {
        Self {
            name: name.to_owned(),
            meaning: meaning.to_owned(),
            unit: unit.to_owned(),
            value: Some(value).filter(|value| value.is_finite()),
            limit: Some(limit),
            // What is no number is not met.
            reached: Some(value <= limit),
            detail: String::new(),
        }
    }

    /// The same with a remark.
    #[must_use]
    pub fn with_detail(mut self, detail: String) -> Self {
        self.detail = detail;
        self
    }

    /// One line for a reader.
    #[must_use]
    pub fn line(&self) -> String {
        let number = |value: f64| {
            if self.unit == "1" {
                significant(value, DIGITS)
            } else {
                format!("{} {}", significant(value, DIGITS), self.unit)
            }
        };
        let value = self.value.map_or_else(|| "unknown".to_owned(), number);
        let limit = self
            .limit
            .map_or_else(String::new, |limit| format!(" (at most {})", number(limit)));
        let verdict = match self.reached {
            Some(true) => "ok",
            Some(false) => "NOT MET",
            None => "not judged",
        };
        let detail = if self.detail.is_empty() {
            String::new()
        } else {
            format!("; {}", self.detail)
        };
        format!(
            "{}: {verdict}: {} {value}{limit}{detail}",
            self.name, self.meaning
        )
    }
}
