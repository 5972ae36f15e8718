//! Names that were meant: the nearest of those that are known.

/// Similarity (Jaro–Winkler, 0 to 1) from which a name counts as meant.
const NEAR: f64 = 0.78;

/// The known name nearest to one that is not known, of several as near the first; `None` where none is near.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |one: &str| strsim::jaro_winkler(&name.to_lowercase(), &one.to_lowercase());
    known
        .map(|one| (likeness(one), one))
        .filter(|(likeness, _)| *likeness >= NEAR)
        .reduce(|best, other| if other.0 > best.0 { other } else { best })
        .map(|(_, one)| one)
}

/// The nearest known name as a question, to stand before a remedy; empty where none is near.
#[must_use]
pub fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    nearest(name, known).map_or_else(String::new, |near| format!("did you mean `{near}`? "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_strangers_are_not() {
        let known = || ["speed_m_s", "size_m", "start_time_s", "sponge_length_m"].into_iter();
        for slip in ["speed_ms", "sped_m_s", "Speed_m_s", "speed"] {
            assert_eq!(nearest(slip, known()), Some("speed_m_s"), "{slip}");
        }
        assert_eq!(nearest("colour", known()), None);
        let units = ["payload_kg", "payload_lb"];
        assert_eq!(nearest("payload", units.into_iter()), Some("payload_kg"));
        assert_eq!(did_you_mean("sizes_m", known()), "did you mean `size_m`? ");
    }
}
