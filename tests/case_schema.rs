//! The keys of case files in words: the JSON schema beside the cases, and the tables of docs/case-files.md, are those of the program.

use std::collections::BTreeMap;

use libtest_mimic::Trial;
use ripstop::case::{SCHEMA_DIRECTIVE, SHIPPED, key_reference, schema_text};
use serde_json::Value;

use crate::cases::files;
use crate::command_line::{ripstop, root};
use crate::engines::plain;

/// Set where the files shall be written anew.
const WRITE: &str = "RIPSTOP_WRITE_DOCS";

pub fn trials() -> Vec<Trial> {
    [
        plain("case_schema::docs_have_all_keys", docs),
        plain("case_schema::links_lead_to_headings", links),
        plain("case_schema::cases_have_their_schema", beside_cases),
        plain("case_schema::every_key_has_a_meaning", meanings),
        plain("case_schema::cases_hold_to_it", cases_hold),
        plain("case_schema::new_cases_bring_it", new_cases),
        plain("case_schema::of_alternatives_one", alternatives),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Compares a file with what it should hold, or writes it.
fn assert_written(path: &str, expected: &str) {
    let file = root().join(path);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&file, expected).unwrap();
    }
    let found = std::fs::read_to_string(&file).unwrap();
    let differs = (found.lines().zip(expected.lines())).find(|(found, expected)| found != expected);
    assert!(
        found == expected,
        "{path} is not what the program says ({differs:?}): run this test with {WRITE}=1, and read what changed"
    );
}

fn docs() {
    const PATH: &str = "docs/case-files.md";
    let page = std::fs::read_to_string(root().join(PATH)).unwrap();
    let (before, rest) = page.split_once("<!-- keys: begin").unwrap();
    let (marker, rest) = rest.split_once('\n').unwrap();
    let (_, after) = rest.split_once("<!-- keys: end -->").unwrap();
    let keys = key_reference();
    let expected = format!("{before}<!-- keys: begin{marker}\n{keys}<!-- keys: end -->{after}");
    assert_written(PATH, &expected);
}

/// Every link from one page to a heading, of its own or of another page, leads to one that is there.
fn links() {
    let anchor = |heading: &str| -> String {
        let kept = |c: &char| c.is_alphanumeric() || ['_', '-', ' '].contains(c);
        let plain: String = heading.to_lowercase().chars().filter(kept).collect();
        plain.trim().replace(' ', "-")
    };
    let mut pages = BTreeMap::new();
    for folder in [".", "docs", "docs/results", "benches"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "md") {
                let text = std::fs::read_to_string(&path).unwrap();
                let headings = text.lines().filter(|line| line.starts_with('#'));
                let anchors: Vec<String> = headings
                    .map(|line| anchor(line.trim_start_matches('#')))
                    .collect();
                pages.insert(path.canonicalize().unwrap(), (text, anchors));
            }
        }
    }
    let mut seen = 0;
    for (path, (text, _)) in &pages {
        for link in text.split("](").skip(1) {
            let link = link.split(')').next().unwrap();
            let Some((file, heading)) = link.split_once('#').filter(|_| !link.contains(':')) else {
                continue;
            };
            let target = match file {
                "" => path.clone(),
                file => path.parent().unwrap().join(file),
            };
            let target = target
                .canonicalize()
                .unwrap_or_else(|_| panic!("{path:?}: {link}"));
            let anchors = &pages[&target].1;
            assert!(anchors.iter().any(|a| a == heading), "{path:?}: {link}");
            seen += 1;
        }
    }
    assert!(seen > 120, "{seen}");
}

fn beside_cases() {
    assert_written("cases/ripstop.schema.json", &schema_text());
    for path in files().values() {
        let text = std::fs::read_to_string(root().join(path)).unwrap();
        let line = text.lines().next().unwrap();
        let named = line.strip_prefix(SCHEMA_DIRECTIVE).unwrap().trim();
        let schema = root().join(path).parent().unwrap().join(named);
        assert!(schema.exists(), "{path}: {line}");
    }
}

pub fn schema() -> Value {
    serde_json::from_str(&schema_text()).unwrap()
}

/// Keys without words, or with Rust's links or paths in them; and how many keys there are.
fn without_meaning(schema: &Value) -> (Vec<String>, usize) {
    fn look(path: &str, part: &Value, above: Option<&str>, found: &mut (Vec<String>, usize)) {
        for (key, of) in part["properties"].as_object().into_iter().flatten() {
            let words = of["description"].as_str().or(above).unwrap_or("");
            if words.len() < 5 || words.contains("::") || words.contains("[`") {
                found.0.push(format!("{path}.{key}"));
            }
            found.1 += 1;
        }
        // Of alternatives, the words stand a level higher.
        for one in part["oneOf"].as_array().into_iter().flatten() {
            look(path, one, one["description"].as_str(), found);
        }
    }
    let mut found = (Vec::new(), 0);
    look("", schema, None, &mut found);
    for (name, part) in schema["definitions"].as_object().unwrap() {
        look(name, part, None, &mut found);
    }
    found
}

fn meanings() {
    let mut schema = schema();
    let (lost, seen) = without_meaning(&schema);
    assert!(lost.is_empty() && seen > 250, "{seen}: {lost:?}");
    // Words that are gone are noticed.
    for part in [
        "/definitions/Air/properties/density_kg_m3",
        "/definitions/Motion/oneOf/0",
    ] {
        let part = schema.pointer_mut(part).unwrap().as_object_mut().unwrap();
        part.remove("description").unwrap();
    }
    let expected = ["Air.density_kg_m3", "Motion.constant_velocity"];
    assert_eq!(without_meaning(&schema).0, expected);
}

/// Editors find nothing wrong with shipped cases, and what is wrong with cases of unknown keys and other types.
fn cases_hold() {
    let (mut known, mut compiler) = (boon::Schemas::new(), boon::Compiler::new());
    compiler.add_resource("case.json", schema()).unwrap();
    let schema = compiler.compile("case.json", &mut known).unwrap();
    let looked_at = |text: &str| -> Result<(), String> {
        let case: Value = toml::from_str(text).unwrap();
        known.validate(&case, schema).map_err(|why| why.to_string())
    };
    for (name, text) in SHIPPED {
        assert_eq!(looked_at(text), Ok(()), "{name}");
    }
    for (name, why) in [
        ("unknown-key", "additionalProperties 'ringz' not allowed"),
        ("wrong-type", "want number, but got string"),
        ("wrong-unit", "not allowed"),
        ("unknown-operator", "oneOf failed, none matched"),
        ("structure-two-kinds", "oneOf failed, none matched"),
        ("structure-unknown-kind", "oneOf failed, none matched"),
        ("comparison-without-source", "missing properties 'source'"),
    ] {
        let path = root().join(format!("cases/bad/{name}.toml"));
        let found = looked_at(&std::fs::read_to_string(path).unwrap()).unwrap_err();
        assert!(found.contains(why), "{name}: {found}");
    }
}

fn new_cases() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    for name in ["airbag", "sphere"] {
        let printed = ripstop(&["new", name]);
        assert!(
            !printed.printed.contains(SCHEMA_DIRECTIVE),
            "{}",
            printed.printed
        );
        let output = ripstop(&["new", name, "--out", out]);
        assert_eq!(output.code, 0, "{}", output.errors);
        let text = std::fs::read_to_string(folder.path().join(format!("{name}.toml"))).unwrap();
        let (line, rest) = text.split_once('\n').unwrap();
        assert_eq!(rest, printed.printed);
        let schema = line.strip_prefix(SCHEMA_DIRECTIVE).unwrap().trim();
        let schema = std::fs::read_to_string(folder.path().join(schema)).unwrap();
        assert_eq!(schema, ripstop(&["schema"]).printed);
    }
    let tables = ripstop(&["schema", "--markdown"]);
    assert_eq!((tables.code, tables.printed), (0, key_reference()));
}

/// A command that must be refused, with these words in the message, however its lines are broken.
fn refused(arguments: &[&str], said: &str) {
    let output = ripstop(arguments);
    assert_eq!(output.code, 2, "{}", output.errors);
    let words = output.errors.split_whitespace();
    let words: Vec<&str> = words.filter(|word| *word != "│").collect();
    assert!(words.join(" ").contains(said), "{}", output.errors);
}

/// Where exactly one of several tables belongs, the message names them all.
fn alternatives() {
    let sphere = std::fs::read_to_string(root().join("cases/sphere.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    for (added, said) in [
        (
            "[structure]\n",
            "[structure] needs exactly one of flat_circular, conical, slotted,",
        ),
        (
            "[bodies.sphere.motion]\n",
            "[bodies.sphere.motion] needs exactly one of constant_velocity, constant_rotation, oscillation, table, free_fall",
        ),
        (
            "[bodies.sphere.permeability]\nmaterial = \"pia_c_44378_type_2\"\ndischarge_coefficient = 0.6\n",
            "[bodies.sphere.permeability] needs exactly one of ergun, measured, discharge_coefficient, material",
        ),
        ("[bodies.sphere.motion.hop]\n", "unknown key `hop`"),
        (
            "[bodies.sphere.permeability]\nmaterial = \"pia_c_44378_type_2\"\nthickness_m = 1e-4\n",
            "unknown key `thickness_m`, expected exactly one of ergun,",
        ),
    ] {
        std::fs::write(&path, format!("{sphere}\n{added}")).unwrap();
        refused(&["check", path.to_str().unwrap()], said);
    }
    for (change, said) in [
        (
            "structure=3",
            "structure is a table with exactly one of flat_circular",
        ),
        (
            "structure=\"airbag\"",
            "structure is a table with exactly one of flat_circular",
        ),
        (
            "structure.bogus=1",
            "unknown key `bogus`, expected exactly one of flat_circular",
        ),
        (
            "resolution.operator={}",
            "resolution.operator is a word, not a table",
        ),
    ] {
        refused(&["check", "cases/sphere.toml", "--set", change], said);
    }
}
