//! What tells a case from others, and what of it may change while its run goes on.

use std::collections::BTreeMap;
use std::path::Path;

use super::file::File;

/// Tables and keys that do not act on the state: names, outputs, what results are compared with, and variants, which are applied already.
const NOT_PHYSICS: [&str; 4] = ["title", "output", "comparison", "variants"];

/// CRC-32 of a text, and of meshes, profiles and tables of lines that its case names, in hexadecimal.
pub(super) fn hash(text: &str, file: &File, folder: &Path) -> String {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(text.as_bytes());
    for name in file.named_files() {
        // Those that cannot be read have been refused before.
        let content = std::fs::read(folder.join(name)).unwrap_or_default();
        hasher.update(name.as_bytes());
        hasher.update(&content.len().to_le_bytes());
        hasher.update(&content);
    }
    format!("{:08x}", hasher.finalize())
}

/// The case without title, length, outputs and comparisons.
pub(super) fn physics(case: &toml::Table) -> toml::Table {
    let mut physics = case.clone();
    for key in NOT_PHYSICS {
        physics.remove(key);
    }
    // A support that is displaced over the whole run moves otherwise in a longer one.
    let tables = |table: &toml::Table, key: &str| table.get(key)?.as_table().cloned();
    let over_the_whole_run = tables(case, "supports").is_some_and(|supports| {
        let mut supports = supports.values().filter_map(toml::Value::as_table);
        supports.any(|s| s.contains_key("displacement_m") && !s.contains_key("ramp_time_s"))
    });
    if let Some(toml::Value::Table(time)) = physics.get_mut("time")
        && !over_the_whole_run
    {
        time.remove("end_s");
    }
    physics
}

/// True for an override, `key.path=value`, that may act on the state.
pub(super) fn acts_on_state(change: &str) -> bool {
    let key = change.split('=').next().unwrap_or_default().trim();
    let table = key.split('.').next().unwrap_or_default();
    !NOT_PHYSICS.contains(&table) && key != "time.end_s"
}

/// Keys of the physics that differ between two cases as they were run, with both values; empty if none does.
#[must_use]
pub fn changed_physics(before: &str, now: &str) -> Vec<String> {
    changed(before, now, physics)
}

/// Keys that differ and are not physics; variants are applied already.
#[must_use]
pub fn changed_outputs(before: &str, now: &str) -> Vec<String> {
    let physical = changed_physics(before, now);
    let mut others = changed(before, now, |table| {
        let mut table = table.clone();
        table.remove("variants");
        table
    });
    others.retain(|line| !physical.contains(line));
    others
}

fn changed(before: &str, now: &str, part: fn(&toml::Table) -> toml::Table) -> Vec<String> {
    let [before, now] = [before, now].map(|text| {
        let table: toml::Table = toml::from_str(text).unwrap_or_default();
        let mut keys = BTreeMap::new();
        flatten("", &toml::Value::Table(part(&table)), &mut keys);
        keys
    });
    let all = before
        .keys()
        .chain(now.keys().filter(|key| !before.contains_key(*key)));
    let value = |keys: &BTreeMap<String, String>, key: &String| {
        keys.get(key).map_or("absent", String::as_str).to_owned()
    };
    let mut changed: Vec<String> = all
        .filter(|key| before.get(*key) != now.get(*key))
        .map(|key| {
            format!(
                "{key} was {}, is now {}",
                value(&before, key),
                value(&now, key)
            )
        })
        .collect();
    changed.sort();
    changed
}

/// All keys of a table by their dotted paths.
fn flatten(path: &str, value: &toml::Value, keys: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) if !table.is_empty() => {
            for (key, inner) in table {
                let below = if path.is_empty() {
                    key.clone()
                } else {
                    format!("{path}.{key}")
                };
                flatten(&below, inner, keys);
            }
        }
        value => {
            keys.insert(path.to_owned(), value.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: &str = "title = \"a\"\n[air]\nspeed = 20.0\n[time]\nend_s = 1.0\nstep_s = 0.1\n[output]\nflow = 2\n[variants.quick]\n";

    #[test]
    fn length_outputs_and_titles_are_not_physics() {
        let other = "[air]\nspeed = 20.0\n[time]\nend_s = 2.0\nstep_s = 0.1\n[comparison.drag]\nvalue = 1\n";
        assert!(changed_physics(CASE, other).is_empty());
        assert_eq!(
            changed_outputs(CASE, other),
            [
                "comparison.drag.value was absent, is now 1",
                "output.flow was 2, is now absent",
                "time.end_s was 1.0, is now 2.0",
                "title was \"a\", is now absent"
            ]
        );
        let faster = CASE.replace("20.0", "30.0").replace("step_s", "steps");
        assert_eq!(
            changed_physics(CASE, &faster),
            [
                "air.speed was 20.0, is now 30.0",
                "time.step_s was 0.1, is now absent",
                "time.steps was absent, is now 0.1"
            ]
        );
    }

    /// Displacements that take the whole run are others in a longer one.
    #[test]
    fn the_length_is_physics_where_a_support_follows_it() {
        let pulled =
            |more: &str| format!("{CASE}[supports.top]\ndisplacement_m = [0, 0, 1]\n{more}");
        let longer = |text: &str| text.replace("end_s = 1.0", "end_s = 2.0");
        let whole = pulled("");
        assert_eq!(
            changed_physics(&whole, &longer(&whole)),
            ["time.end_s was 1.0, is now 2.0"]
        );
        let own = pulled("ramp_time_s = 0.5\n");
        assert!(changed_physics(&own, &longer(&own)).is_empty());
    }
}
