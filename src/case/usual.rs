//! What a case has for the keys that it leaves out: every default goes through [`or`] or [`noted`], which write it down for the ledger of a run.

use std::cell::RefCell;
use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

/// Values by their keys, with the unit in the key's name as in a case.
pub type Resolved = BTreeMap<String, Value>;

thread_local! {
    /// What the check that goes on in this thread has taken; `None` outside of one.
    static TAKEN: RefCell<Option<Resolved>> = const { RefCell::new(None) };
}

/// What is written for `key`; where it is left out `usual`, which is written down.
pub(super) fn or<T: Serialize>(key: impl Into<String>, written: Option<T>, usual: T) -> T {
    written.unwrap_or_else(|| noted(key, usual))
}

/// Writes down the value of a key that is left out, whether it has a usual one or follows from others.
pub(super) fn noted<T: Serialize>(key: impl Into<String>, value: T) -> T {
    TAKEN.with_borrow_mut(|taken| {
        // A number that is not finite has no form in JSON, and no meaning as a default.
        if let (Some(taken), Ok(value)) = (taken, serde_json::to_value(&value)) {
            taken.insert(key.into(), value);
        }
    });
    value
}

/// Makes a check, and returns with its result what it took.
pub(super) fn collected<T>(check: impl FnOnce() -> T) -> (T, Resolved) {
    let outer = TAKEN.replace(Some(Resolved::new()));
    let result = check();
    (result, TAKEN.replace(outer).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_written_down_and_nothing_else() {
        let ((a, b), taken) = collected(|| (or("a.b_m", None, 2.5), or("a.c", Some(7), 8)));
        assert_eq!((a, b), (2.5, 7));
        assert_eq!(taken.len(), 1);
        assert_eq!(taken["a.b_m"], 2.5);
        // Outside of a check nobody asks.
        assert_eq!(or("a", None, 1), 1);
        assert!(collected(|| ()).1.is_empty());
    }
}
