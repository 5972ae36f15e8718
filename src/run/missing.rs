//! Files that a run did without for want of room.

/// Most files that a note names.
const TOLD: usize = 8;

/// Files that a run did without.
#[derive(Debug, Default)]
pub(super) struct Missing {
    /// What they would have been.
    names: Vec<String>,
    /// It was said that something was left out, that rows wait, and that there is no checkpoint.
    pub(super) told: [bool; 3],
}

impl Missing {
    pub(super) fn add(&mut self, what: &str, time_s: f64) {
        self.names.push(format!("{what} at t = {time_s:.6} s"));
    }

    /// A line about all of them; `None` if nothing is missing.
    pub(super) fn note(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let mut told = self.names[..self.names.len().min(TOLD)].to_vec();
        if self.names.len() > TOLD {
            told.push(format!("and {} more", self.names.len() - TOLD));
        }
        Some(format!(
            "warning: files are missing that there was no room for: {}",
            told.join(", ")
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let mut missing = Missing::default();
        assert_eq!(missing.note(), None);
        for number in 0..10 {
            missing.add("the canopy", f64::from(number));
        }
        let note = missing.note().unwrap();
        assert!(note.contains(": the canopy at t = 0.000000 s, the canopy"));
        assert!(note.ends_with("at t = 7.000000 s, and 2 more"), "{note}");
    }
}
