//! Every column and result is declared once, with unit and meaning, and the documentation shows what is declared.

use std::collections::BTreeMap;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::measure::{self, Group, Record};
use ripstop::output::ReadOut;

use crate::cases::files;
use crate::command_line::root;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        ("read_outs::columns_are_declared", columns as fn()),
        ("read_outs::results_are_declared", results),
        ("read_outs::names_mean_one_thing", names),
        ("read_outs::the_page_shows_the_rows", page),
    ]
    .into_iter()
    .flat_map(|(name, test)| plain(name, test))
    .collect()
}

/// A column that a test names, over time.
pub fn column(record: &Record, name: &str) -> Vec<f64> {
    let column = record.named(name);
    record.column(column.unwrap_or_else(|| panic!("no column {name}")))
}

/// Its last value; `None` where the scene does not have it.
pub fn latest(record: &Record, name: &str) -> Option<f64> {
    record.latest(record.named(name)?)
}

/// All shipped cases, as written and in their quick variant.
fn shipped() -> Vec<Case> {
    let load = |file: &String| {
        let text = std::fs::read_to_string(root().join(file)).unwrap();
        let quick = text.contains("[variants.quick").then(|| "quick".to_owned());
        let variants = [Some(None), quick.map(Some)];
        let of = |variant| {
            let choices = Choices {
                variant,
                overrides: Vec::new(),
            };
            case::load(&root().join(file), &choices).unwrap()
        };
        variants.into_iter().flatten().map(of).collect::<Vec<_>>()
    };
    files().values().flat_map(load).collect()
}

fn has_unit_and_meaning(read_out: &ReadOut) {
    let ReadOut {
        name,
        unit,
        meaning,
    } = read_out;
    assert!(
        !unit.is_empty() && meaning.len() > 5,
        "{name}: {unit}, {meaning}"
    );
    // Names end in their unit.
    let ending = match *unit {
        "1" => return,
        "N m" => "_n_m".to_owned(),
        "N s" => "_n_s".to_owned(),
        unit => format!("_{}", unit.to_lowercase().replace('/', "_")),
    };
    let stem = ["_before", "_after"]
        .iter()
        .fold(&**name, |name, end| name.strip_suffix(end).unwrap_or(name));
    assert!(stem.ends_with(&ending), "{name} does not end in {unit}");
}

fn distinct<'a>(what: &str, names: impl Iterator<Item = &'a str>) {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        assert!(seen.insert(name), "{what} has {name} twice");
    }
}

fn columns() {
    for case in shipped() {
        let columns = measure::history_columns(&case.scene);
        assert!(
            columns.len() > 3 && columns[0].name == "time_s",
            "{}",
            case.name
        );
        distinct(&case.name, columns.iter().map(|column| &*column.name));
        columns.iter().for_each(has_unit_and_meaning);
        let [tables, _] = measure::read_out_tables();
        for ReadOut { name, unit, .. } in columns {
            let mut rows = tables.iter().flat_map(Group::read_outs);
            assert!(
                rows.any(|row| row.covers(&name) && row.unit == unit),
                "no table has {name} in {unit}"
            );
        }
    }
}

fn results() {
    let declared = measure::declared_results();
    declared.iter().for_each(has_unit_and_meaning);
    for case in shipped() {
        let names = measure::result_names(&case.scene);
        distinct(&case.name, names.iter().map(String::as_str));
        for name in names {
            let known = declared.iter().any(|result| result.covers(&name));
            assert!(
                known,
                "{}: the result {name} is declared nowhere",
                case.name
            );
        }
    }
}

/// A name has one unit wherever it is declared, and no table has it twice.
fn names() {
    let mut units: BTreeMap<String, &str> = BTreeMap::new();
    for table in measure::read_out_tables().iter().flatten() {
        let names: Vec<&str> = table.read_outs().map(|row| &*row.name).collect();
        distinct(table.title(), names.into_iter());
        for ReadOut { name, unit, .. } in table.read_outs().cloned().chain(table.results()) {
            let known = *units.entry(name.to_string()).or_insert(unit);
            assert_eq!(known, unit, "{name} has two units");
        }
    }
}

const PAGE: &str = "docs/read-outs.md";

const BEGIN: &str =
    "<!-- from the rows in src/measure; RIPSTOP_WRITE_DOCS=1 writes them anew -->\n";

const END: &str = "<!-- end -->\n";

/// The tables of the page are those of the rows; `RIPSTOP_WRITE_DOCS=1` makes them so.
fn page() {
    let path = root().join(PAGE);
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (written, after) = rest.split_once(END).unwrap();
    let [columns, results] = measure::read_out_tables().map(|tables| {
        let tables: Vec<String> = tables.iter().map(Group::markdown).collect();
        tables.join("\n")
    });
    let wanted = format!("\n## Columns\n\n{columns}\n## Other results\n\n{results}\n");
    if std::env::var_os("RIPSTOP_WRITE_DOCS").is_some_and(|set| set == "1") {
        std::fs::write(&path, format!("{before}{BEGIN}{wanted}{END}{after}")).unwrap();
        return;
    }
    for (number, (is, should)) in written.lines().zip(wanted.lines()).enumerate() {
        assert_eq!(
            is, should,
            "{PAGE}, line {number} of its tables: RIPSTOP_WRITE_DOCS=1 writes them anew"
        );
    }
    assert_eq!(
        written, wanted,
        "{PAGE}: RIPSTOP_WRITE_DOCS=1 writes its tables anew"
    );
}
