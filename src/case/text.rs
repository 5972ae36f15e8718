//! The text of a case as a TOML table: values by their paths, variants, and changes from the command line.

use super::error::CaseError;

/// The value under a dotted path; `None` where it is absent.
pub(super) fn lookup<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    let (first, rest) = path
        .split_once('.')
        .map_or((path, None), |(first, rest)| (first, Some(rest)));
    let value = table.get(first)?;
    match rest {
        None => Some(value),
        Some(rest) => lookup(value.as_table()?, rest),
    }
}

/// Overwrites `base` with `changes`, table by table; what is "absent" in `changes` is removed, or stays as that word where it is told to keep it.
pub(super) fn merge(base: &mut toml::Table, changes: toml::Table, keeps_absent: bool) {
    for (key, change) in changes {
        match (base.get_mut(&key), change) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(change)) => {
                merge(inner, change, keeps_absent);
            }
            (_, toml::Value::String(text)) if text == ABSENT && !keeps_absent => {
                base.remove(&key);
            }
            (_, change) => {
                base.insert(key, change);
            }
        }
    }
}

/// Value of an override or in a variant that removes the key or table from the case.
pub const ABSENT: &str = "absent";

/// Paths of all that is "absent" in a table of changes.
pub(super) fn absent_paths(table: &toml::Table) -> Vec<Vec<String>> {
    let below = |(key, value): (&String, &toml::Value)| match value {
        toml::Value::String(text) if text == ABSENT => vec![vec![key.clone()]],
        toml::Value::Table(inner) => absent_paths(inner)
            .into_iter()
            .map(|path| [vec![key.clone()], path].concat())
            .collect(),
        _ => Vec::new(),
    };
    table.iter().flat_map(below).collect()
}

/// Applies one `key.path=value`; `absent` removes the key, or stays as that word where it is told to keep it.
pub(super) fn apply_override(
    table: &mut toml::Table,
    change: &str,
    keeps_absent: bool,
) -> Result<(), Box<CaseError>> {
    let refuse = |why: &str| {
        CaseError::about_file(
            format!("--set {change}: {why}"),
            "write --set key.path=value, e.g. --set air.wind_tunnel.speed_m_s=20",
        )
    };
    let (path, text) = change
        .split_once('=')
        .ok_or_else(|| refuse("there is no `=`"))?;
    let value = match toml::from_str::<toml::Table>(&format!("value = {text}")) {
        Ok(parsed) if parsed.len() != 1 => return Err(refuse("give one value")),
        Ok(mut parsed) => parsed
            .remove("value")
            .ok_or_else(|| refuse("there is no value"))?,
        // Bare words are strings.
        Err(_) => toml::Value::String(text.trim().to_owned()),
    };
    // Designations of profiles are words, though they look like numbers.
    let value = match value {
        toml::Value::Integer(_) if path.trim().ends_with(".naca") => {
            toml::Value::String(text.trim().to_owned())
        }
        value => value,
    };
    let mut parts: Vec<&str> = path.trim().split('.').collect();
    let last = parts
        .pop()
        .filter(|part| !part.is_empty())
        .ok_or_else(|| refuse("there is no key"))?;
    if parts
        .iter()
        .chain([&last])
        .any(|part| part.parse::<usize>().is_ok())
    {
        return Err(refuse(
            "lists are written whole: give all of their values in [ ]",
        ));
    }
    let mut target = table;
    for part in parts {
        let entry = target
            .entry(part)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()));
        target = entry
            .as_table_mut()
            .ok_or_else(|| refuse(&format!("`{part}` is not a table")))?;
    }
    if text.trim() == ABSENT && !keeps_absent {
        return match target.remove(last) {
            Some(_) => Ok(()),
            None => Err(refuse("the case has no such key to remove")),
        };
    }
    target.insert(last.to_owned(), value);
    Ok(())
}

/// The number under a dotted path of a case's text; `None` where it is absent.
#[must_use]
pub fn number_in(text: &str, path: &str) -> Option<f64> {
    let table: toml::Table = toml::from_str(text).ok()?;
    number(lookup(&table, path)?)
}

/// A value as a number; `None` where it is none.
pub(super) fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Float(value) => Some(*value),
        toml::Value::Integer(value) => Some(*value as f64),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designations_of_profiles_are_words() {
        let mut table = toml::Table::new();
        apply_override(&mut table, "profiles.middle.naca=2415", false).unwrap();
        let written = lookup(&table, "profiles.middle.naca");
        assert_eq!(written.and_then(toml::Value::as_str), Some("2415"));
    }

    #[test]
    fn numbers_are_found_by_their_paths() {
        let text = "[time]\nend_s = 1.0\n[output]\nflow = 2\ntitle = \"a\"\n";
        assert_eq!(number_in(text, "time.end_s"), Some(1.0));
        assert_eq!(number_in(text, "output.flow"), Some(2.0));
        for path in ["output.other", "output.title", "output", "time.end_s.more"] {
            assert_eq!(number_in(text, path), None, "{path}");
        }
    }
}
