//! What a column of the history, or a result of a run, is.

use std::borrow::Cow;

/// Name, unit and meaning of a read-out. Results are put in by it, so that none lacks a unit or a meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadOut {
    /// Its name, unit included. What stands in braces is the owner's name, as in `row_{row}_load_n`.
    pub name: Cow<'static, str>,
    /// SI unit, `1` for a plain number.
    pub unit: &'static str,
    /// What it is: a phrase for axes; behind a semicolon details, which become the remark of the result.
    pub meaning: &'static str,
}

impl ReadOut {
    /// A read-out from its parts.
    #[must_use]
    pub const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self {
            name: Cow::Borrowed(name),
            unit,
            meaning,
        }
    }

    /// The same of one owner, such as a row of lines, whose name replaces the braces; a prefix of a body may be empty.
    #[must_use]
    pub fn of(&self, owner: impl std::fmt::Display) -> Self {
        let name = match self.split() {
            Some((before, after)) => Cow::Owned(format!("{before}{owner}{after}")),
            None => self.name.clone(),
        };
        Self { name, ..*self }
    }

    /// The same quantity under another name.
    #[must_use]
    pub const fn named(&self, name: &'static str) -> Self {
        Self::new(name, self.unit, self.meaning)
    }

    /// What stands before and behind the owner's name.
    fn split(&self) -> Option<(&str, &str)> {
        let (before, rest) = self.name.split_once('{')?;
        let (_, after) = rest.split_once('}')?;
        Some((before, after))
    }

    /// True if a column or result of that name may be this read-out.
    #[must_use]
    pub fn covers(&self, name: &str) -> bool {
        match self.split() {
            Some((before, after)) => {
                let owner = name
                    .strip_prefix(before)
                    .and_then(|rest| rest.strip_suffix(after));
                // A prefix of a body ends with the line that joins it to the rest.
                let is_joined = |owner: &str| owner.is_empty() || owner.ends_with('_');
                let is_prefix = before.is_empty() && !after.starts_with('_');
                owner.is_some_and(|owner| !is_prefix || is_joined(owner))
            }
            None => self.name == name,
        }
    }

    /// What the meaning says behind its first phrase.
    #[must_use]
    pub fn detail(&self) -> Option<&'static str> {
        self.meaning.split_once("; ").map(|(_, detail)| detail)
    }

    /// The first phrase of the meaning.
    #[must_use]
    pub fn phrase(&self) -> &'static str {
        self.meaning.split(';').next().unwrap_or_default()
    }

    /// What an axis says: the first phrase of the meaning, and the unit.
    #[must_use]
    pub fn label(&self) -> String {
        let phrase = self.phrase();
        match self.unit {
            "1" => phrase.to_owned(),
            unit => format!("{phrase} [{unit}]"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ReadOut;

    #[test]
    fn names_of_owners() {
        let load = ReadOut::new(
            "row_{row}_load_n",
            "N",
            "tension of its risers; both halves",
        );
        assert_eq!(load.of("a").name, "row_a_load_n");
        assert!(load.covers("row_a_load_n") && !load.covers("row_a_load_share"));
        assert_eq!(load.label(), "tension of its risers [N]");
        assert_eq!(load.detail(), Some("both halves"));
        let drag = ReadOut::new("{body}drag_coefficient", "1", "drag coefficient");
        assert_eq!(drag.of("").name, "drag_coefficient");
        assert!(drag.covers("ball_drag_coefficient") && !drag.covers("balldrag_coefficient"));
        let stress = ReadOut::new("{part}_stress_max_pa", "Pa", "stress");
        assert!(stress.covers("upper_panels_stress_max_pa"));
        assert_eq!(drag.label(), "drag coefficient");
        let time = ReadOut::new("time_s", "s", "time since release");
        assert!(time.of("sphere") == time && time.covers("time_s") && !time.covers("time"));
    }
}
