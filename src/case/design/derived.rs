//! Keys that follow from a design, with the reason for each.

use std::ops::Range;

use toml::{Table, Value};

use super::super::problem::Problem;
use super::super::text::lookup;
use super::units::{is_quantity, rounded};

/// A key of the case that follows from its design.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// Its dotted path.
    pub key: String,
    /// Its value.
    pub value: Value,
    /// What it follows from.
    pub why: String,
}

/// Keys of which a case has one or the other: what is written takes the place of what follows.
const ALTERNATIVES: [&[&str]; 7] = [
    &["resolution.cells_per_diameter", "resolution.cell_size_m"],
    &["lines.youngs_modulus_pa", "lines.force_strain"],
    &["belts.youngs_modulus_pa", "belts.force_strain"],
    &["air.density_kg_m3", "air.descent.altitude_m"],
    &["air.refinement.around", "air.refinement.boxes"],
    &["air.refinement.margin", "air.refinement.boxes"],
    &[
        "structure.disk_gap_band.nominal_area_m2",
        "structure.disk_gap_band.nominal_diameter_m",
    ],
];

/// Keys as they are collected.
#[derive(Debug, Default)]
pub(in crate::case) struct Keys {
    all: Vec<Derived>,
    /// Numbers of those that are constants of one material, and its name.
    materials: Vec<(Range<usize>, String)>,
}

/// Ends of the keys of a material's strength, and of those that say nothing of its strength.
const STRENGTH: &str = ".breaking_load_n";
const WITHOUT_STRENGTH: [&str; 3] = [".breaking_load_n", ".diameter_m", ".drag_coefficient"];

impl Keys {
    pub(in crate::case) fn set(
        &mut self,
        key: impl Into<String>,
        value: impl Into<Value>,
        why: &str,
    ) {
        self.all.push(Derived {
            key: key.into(),
            value: short(value.into()),
            why: why.to_owned(),
        });
    }

    /// The constants of a material, in a table: values and reasons.
    pub(super) fn set_material<'a>(
        &mut self,
        material: &str,
        table: &str,
        constants: impl IntoIterator<Item = (&'a str, Value, &'a str)>,
    ) {
        let first = self.all.len();
        for (name, value, why) in constants {
            self.set(format!("{table}.{name}"), value, why);
        }
        self.materials
            .push((first..self.all.len(), material.to_owned()));
    }

    /// Puts them into the case, where it does not say otherwise, and returns those that it took.
    pub(in crate::case) fn put_into(mut self, case: &mut Table) -> Vec<Derived> {
        let written = case.clone();
        let mut unknown: Vec<String> = Vec::new();
        for (numbers, material) in self.materials {
            let constants = &mut self.all[numbers];
            // Then it is not that material any more, whose reasons would speak of it.
            let is_written = |one: &Derived| says_otherwise(&written, &one.key);
            if constants.iter().any(is_written) {
                // What breaks such a material is not known, unless the case tells it.
                let is_mechanical =
                    |one: &&Derived| !WITHOUT_STRENGTH.iter().any(|name| one.key.ends_with(name));
                if constants.iter().filter(is_mechanical).any(is_written) {
                    let strengths = constants.iter().filter(|one| one.key.ends_with(STRENGTH));
                    unknown.extend(strengths.map(|one| one.key.clone()));
                }
                for one in constants {
                    one.why =
                        format!("as of {material}, beside other constants that the case writes");
                }
            }
        }
        let taken: Vec<Derived> = (self.all.into_iter())
            .filter(|derived| !says_otherwise(&written, &derived.key))
            .filter(|derived| !unknown.contains(&derived.key))
            .collect();
        for derived in &taken {
            put(case, &derived.key, derived.value.clone());
        }
        taken
    }
}

/// True where a case has a key itself, one that takes its place, or removes it or a table that it stands in.
fn says_otherwise(written: &Table, key: &str) -> bool {
    let itself = [key];
    let alternatives = ALTERNATIVES.iter().find(|all| all.contains(&key));
    let others = alternatives.map_or(&itself[..], |all| *all);
    // A part of the path that is no table is a word in its place, such as `"absent"`.
    let above = key.match_indices('.').map(|(end, _)| &key[..end]);
    let replaced = |path: &str| lookup(written, path).is_some_and(|value| !value.is_table());
    others.iter().any(|other| lookup(written, other).is_some()) || above.into_iter().any(replaced)
}

fn put(table: &mut Table, key: &str, value: Value) {
    let (first, rest) = match key.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (key, None),
    };
    let Some(rest) = rest else {
        table.insert(first.to_owned(), value);
        return;
    };
    let inner = (table.entry(first)).or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(inner) = inner {
        put(inner, rest, value);
    }
}

/// Removes what a case says is absent, key by key.
pub(super) fn remove_absent(table: &mut Table, absent: &str) {
    table.retain(|_, value| value.as_str() != Some(absent));
    for (_, value) in table.iter_mut() {
        if let Value::Table(inner) = value {
            remove_absent(inner, absent);
        }
    }
}

/// What is wrong with a key, with what it follows from where the case does not write it: the place is then that key of the design, if one alone is
/// the reason.
pub(in crate::case) fn traced(problem: Problem, derived: &[Derived], design: &Table) -> Problem {
    let is_of = |one: &&Derived| {
        let rest = problem.key.strip_prefix(&one.key);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    let Some(one) = derived.iter().find(is_of) else {
        return problem;
    };
    // A quantity stands under the key of the unit that it is written in.
    let mut written = design.iter().filter_map(|(table, keys)| {
        let mut names = keys.as_table()?.keys();
        let name = names.find(|name| **name == one.why || is_quantity(name, &one.why))?;
        Some((table, name))
    });
    let written = written.next();
    let help = format!(
        "{} follows from the design ({}): change that, or write {} itself; {}",
        one.key,
        written.map_or(&one.why, |(_, name)| name),
        one.key,
        problem.help
    );
    Problem {
        key: written.map_or(problem.key, |(table, name)| format!("{table}.{name}")),
        help,
        ..problem
    }
}

/// A case as TOML, with the reason behind every key that follows from a design.
pub(in crate::case) fn commented(case: &Table, derived: &[Derived]) -> String {
    let mut text = String::new();
    write_table(&mut text, "", case, derived);
    text
}

fn write_table(text: &mut String, path: &str, table: &Table, derived: &[Derived]) {
    let of = |key: &str| {
        if path.is_empty() {
            as_written(key)
        } else {
            format!("{path}.{}", as_written(key))
        }
    };
    let why = |key: &str| derived.iter().find(|one| one.key == key);
    // A table that follows as a whole stands in one line.
    let is_inner = |key: &str, value: &Value| value.is_table() && why(&of(key)).is_none();
    let plain = table.iter().filter(|(key, value)| !is_inner(key, value));
    let plain: Vec<_> = plain.collect();
    if !plain.is_empty() && !path.is_empty() {
        text.push_str(&format!("\n[{path}]\n"));
    }
    for (key, value) in plain {
        text.push_str(&format!("{} = {value}", as_written(key)));
        if let Some(one) = why(&of(key)) {
            text.push_str(&format!(" # {}", one.why));
        }
        text.push('\n');
    }
    for (key, value) in table {
        if let Value::Table(inner) = value
            && is_inner(key, value)
        {
            write_table(text, &of(key), inner, derived);
        }
    }
}

/// A key in quotation marks where TOML asks for them.
fn as_written(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(is_bare) {
        key.to_owned()
    } else {
        Value::from(key).to_string()
    }
}

/// With numbers as they are written.
fn short(value: Value) -> Value {
    match value {
        Value::Float(number) => Value::Float(rounded(number)),
        Value::Array(all) => Value::Array(all.into_iter().map(short).collect()),
        Value::Table(table) => {
            Value::Table(table.into_iter().map(|(k, v)| (k, short(v))).collect())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn what_is_written_stands() {
        let mut keys = Keys::default();
        keys.set("air.wind_tunnel.speed_m_s", 30.0, "");
        keys.set("resolution.cells_per_diameter", 24.0, "");
        keys.set("belts.area_m2", 1e-6, "");
        keys.set("time.end_s", 2.0, "");
        let mut case = table(
            "belts = \"absent\"\n[air]\ndensity_kg_m3 = 1.0\n[resolution]\ncell_size_m = 0.1\n[time]\nend_s = 1.0\n",
        );
        let taken = keys.put_into(&mut case);
        remove_absent(&mut case, "absent");
        let names: Vec<&str> = taken.iter().map(|d| &d.key[..]).collect();
        assert_eq!(names, ["air.wind_tunnel.speed_m_s"]);
        // What the derived keys are not part of is kept, whatever it is called.
        let other = "[\"a b\".c]\n\"d.e\" = [{ f = 1, g = \"h\\n\" }, { f = 2 }]\n";
        let with_other = table(&format!("{}\n{other}", toml::to_string(&case).unwrap()));
        assert_eq!(table(&commented(&with_other, &taken)), with_other);
        let expected = "[air]\ndensity_kg_m3 = 1.0\nwind_tunnel = { speed_m_s = 30.0 }\n[resolution]\ncell_size_m = 0.1\n[time]\nend_s = 1.0\n";
        assert_eq!(case, table(expected));
        assert_eq!(table(&commented(&case, &taken)), case);
    }

    /// Where the case writes a constant of a material, the others do not pass for those of what the case has.
    #[test]
    fn constants_of_another_material_say_whose_they_are() {
        let reasons = |text: &str| {
            let mut keys = Keys::default();
            for table in ["lines", "belts"] {
                let constants = [
                    ("area_m2", Value::from(1e-6), "bears the load"),
                    ("density_kg_m3", Value::from(1140.0), "nylon"),
                ];
                keys.set_material("a cord", table, constants);
            }
            let taken = keys.put_into(&mut table(text));
            let of_each = taken.into_iter().map(|one| (one.key, one.why));
            of_each.collect::<Vec<(String, String)>>()
        };
        assert_eq!(reasons("").len(), 4);
        assert!(
            reasons("[lines]\ncount = 8\n")
                .iter()
                .all(|(_, why)| !why.contains("a cord"))
        );
        let left = reasons("[lines]\narea_m2 = 2e-6\n");
        let left: Vec<(&str, &str)> = left.iter().map(|(key, why)| (&key[..], &why[..])).collect();
        assert_eq!(
            left,
            [
                (
                    "lines.density_kg_m3",
                    "as of a cord, beside other constants that the case writes"
                ),
                ("belts.area_m2", "bears the load"),
                ("belts.density_kg_m3", "nylon"),
            ]
        );
    }

    /// What is wrong with a key that follows is told at the key of the design, in the unit that it is written in.
    #[test]
    fn what_follows_is_traced_to_what_is_written() {
        let of = |key: &str, why: &str| Derived {
            key: key.to_owned(),
            value: Value::from(1.0),
            why: why.to_owned(),
        };
        let derived = [
            of("air.wind_tunnel.speed_m_s", "speed"),
            of("payload.mass_kg", "payload"),
            of("structure.conical.gores", "gores"),
            of("time.end_s", "60 D_0/U"),
        ];
        let design = table(
            "[canopy]\nspeed_kt = 60.0\npayload_drag_area_m2 = 1.0\npayload_lb = 200.0\ngores = 12\n",
        );
        for (key, traced_to, reason) in [
            ("air.wind_tunnel.speed_m_s", "canopy.speed_kt", "speed_kt"),
            ("payload.mass_kg", "canopy.payload_lb", "payload_lb"),
            ("structure.conical.gores", "canopy.gores", "gores"),
            ("time.end_s", "time.end_s", "60 D_0/U"),
        ] {
            let told = traced(Problem::new(key, "", ""), &derived, &design);
            assert_eq!(told.key, traced_to);
            let expected = format!("{key} follows from the design ({reason}): ");
            assert!(told.help.starts_with(&expected), "{}", told.help);
        }
    }

    /// Boxes of finer cells take the place of where and how far around they would be; a margin alone does not.
    #[test]
    fn alternatives_take_the_place_of_what_follows() {
        let taken = |text: &str| {
            let mut keys = Keys::default();
            keys.set("air.refinement.around", "structure", "");
            keys.set("air.refinement.margin", 0.5, "");
            keys.set("structure.disk_gap_band.nominal_area_m2", 2.0, "");
            let taken = keys.put_into(&mut table(text));
            taken
                .iter()
                .map(|derived| derived.key.clone())
                .collect::<Vec<_>>()
        };
        let area = "structure.disk_gap_band.nominal_area_m2";
        let boxes = "[[air.refinement.boxes]]\nlower_m = [0, 0, 0]\nupper_m = [1, 1, 1]\n";
        assert_eq!(taken(boxes), [area]);
        let margin = "[air.refinement]\nmargin = 1.0\n";
        assert_eq!(taken(margin), ["air.refinement.around", area]);
        let diameter = "[structure.disk_gap_band]\nnominal_diameter_m = 1.6\n";
        assert_eq!(
            taken(diameter),
            ["air.refinement.around", "air.refinement.margin"]
        );
    }
}
