//! The keys of case files in words, as tables of Markdown for `docs/case-files.md`: from the JSON schema, that is from the comments of
//! [`super::file`].

use std::fmt::Write;

use serde_json::{Map, Value};

use super::schema::{resolved, schema};

/// A table of a case file: where it may stand, and the part of the schema that says what is in it.
struct Table {
    /// Its name in the schema, by which tables of the same keys are known.
    definition: String,
    /// Its headings, such as `[air]` or `[[structure.wing.holes]]`.
    headings: Vec<String>,
    part: Value,
}

/// A section for each table of a case file, in the order of the schema; tables of the same keys share one.
#[must_use]
pub fn key_reference() -> String {
    let root = schema();
    let mut tables = vec![Table {
        definition: String::new(),
        headings: vec!["A case file".to_owned()],
        part: root.clone(),
    }];
    collect(&root, &root, "", &mut tables);
    let mut text = String::new();
    for table in &tables {
        section(&root, table, &tables, &mut text);
    }
    text
}

/// A key of case files in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyMeaning {
    /// Its dotted path; of tables of the same keys, the first that the schema names.
    pub path: String,
    /// What its value is, such as `number`.
    pub kind: String,
    /// True if it may be left out.
    pub is_optional: bool,
    /// What it means, its unit, and what it is if absent.
    pub meaning: String,
}

/// All keys of case files.
#[must_use]
pub fn key_meanings() -> Vec<KeyMeaning> {
    let root = schema();
    let mut tables = vec![Table {
        definition: String::new(),
        headings: vec![String::new()],
        part: root.clone(),
    }];
    collect(&root, &root, "", &mut tables);
    let mut found = Vec::new();
    for table in &tables {
        for heading in &table.headings {
            let above = heading.trim_matches(['[', ']']);
            for key in keys(&table.part) {
                let path = match above {
                    "" => key.name.to_owned(),
                    above => format!("{above}.{}", key.name),
                };
                found.push(KeyMeaning {
                    path,
                    kind: kind(&root, key.of).replace('`', ""),
                    is_optional: key.is_optional,
                    meaning: with_choices(&root, key.of, plain(&key.meaning)),
                });
            }
        }
    }
    found
}

/// A meaning without links of Markdown.
fn plain(meaning: &str) -> String {
    let mut text = meaning.replace("\\|", "|");
    while let Some((before, rest)) = text.split_once("](") {
        let (Some(start), Some(end)) = (before.rfind('['), rest.find(')')) else {
            break;
        };
        text = format!(
            "{}docs/{}{}",
            &before[..start],
            &rest[..end],
            &rest[end + 1..]
        );
    }
    text.replace('`', "")
}

/// A meaning with the words of which one is chosen.
fn with_choices(root: &Value, of: &Value, meaning: String) -> String {
    let (listed, how) = match resolved(root, of).get("items") {
        Some(listed) => (listed, "Any of"),
        None => (of, "One of"),
    };
    match chosen(resolved(root, listed)) {
        Some(chosen) => format!("{meaning} {how} {chosen}."),
        None => meaning,
    }
}

/// A key of a table.
struct Key<'a> {
    name: &'a str,
    /// What the schema says of its value.
    of: &'a Value,
    /// What it means.
    meaning: String,
    is_optional: bool,
}

/// Keys of a table, required ones first; of alternatives all.
fn keys(part: &Value) -> Vec<Key<'_>> {
    let required: Vec<&str> = (part.get("required").and_then(Value::as_array))
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .collect();
    let properties = part.get("properties").and_then(Value::as_object);
    let own = properties.into_iter().flat_map(Map::iter);
    let mut found: Vec<Key> = own
        .map(|(name, of)| Key {
            name,
            of,
            meaning: words(of),
            is_optional: !required.contains(&name.as_str()),
        })
        .collect();
    let place = |key: &Key| required.iter().position(|known| *known == key.name);
    found.sort_by_key(|key| place(key).unwrap_or(usize::MAX));
    let alternatives = part.get("oneOf").and_then(Value::as_array);
    for one in alternatives.into_iter().flatten() {
        found.extend(keys(one).into_iter().map(|key| Key {
            meaning: words(one),
            ..key
        }));
    }
    found
}

/// What the value of a key holds: its heading below `path`, if it is a table or a list of tables, and the table's part of the schema.
fn table_below<'a>(root: &'a Value, path: &str, of: &'a Value) -> Option<(String, &'a Value)> {
    let part = resolved(root, of);
    if part.get("properties").is_some() || part.get("oneOf").is_some_and(has_tables) {
        return Some((format!("[{path}]"), of));
    }
    if let Some(named) = part.get("additionalProperties").filter(|of| of.is_object()) {
        return table_below(root, &format!("{path}.NAME"), named);
    }
    // One table or several.
    if let Some(several) = part.get("anyOf").and_then(Value::as_array) {
        return table_below(root, path, several.first()?);
    }
    let listed = part.get("items")?;
    let is_table = resolved(root, listed).get("properties").is_some();
    is_table.then(|| (format!("[[{path}]]"), listed))
}

/// True for alternatives that are keys, not values.
fn has_tables(alternatives: &Value) -> bool {
    let all = alternatives.as_array();
    all.is_some_and(|all| all.iter().any(|one| one.get("properties").is_some()))
}

/// Name of the definition that a part of the schema refers to.
fn definition(of: &Value) -> Option<&str> {
    let inner = of.get("allOf").and_then(Value::as_array);
    let inner = inner.and_then(|all| all.first()).unwrap_or(of);
    inner.get("$ref")?.as_str()?.rsplit('/').next()
}

fn collect(root: &Value, part: &Value, path: &str, tables: &mut Vec<Table>) {
    for key in keys(part) {
        let own = match path {
            "" => key.name.to_owned(),
            path => format!("{path}.{}", key.name),
        };
        let Some((heading, below)) = table_below(root, &own, key.of) else {
            continue;
        };
        let Some(definition) = definition(below) else {
            continue;
        };
        if let Some(known) = tables.iter_mut().find(|t| t.definition == definition) {
            known.headings.push(heading);
            continue;
        }
        let inner = heading.trim_matches(['[', ']']).to_owned();
        let part = resolved(root, below).clone();
        tables.push(Table {
            definition: definition.to_owned(),
            headings: vec![heading],
            part: part.clone(),
        });
        collect(root, &part, &inner, tables);
    }
}

fn section(root: &Value, table: &Table, tables: &[Table], text: &mut String) {
    let [first, others @ ..] = &table.headings[..] else {
        return;
    };
    let heading = match first.starts_with('[') {
        true => format!("`{first}`"),
        false => first.clone(),
    };
    let _ = writeln!(text, "### {heading}\n");
    if !others.is_empty() {
        let others: Vec<String> = others.iter().map(|other| format!("`{other}`")).collect();
        let _ = writeln!(text, "The same keys as {}.\n", others.join(", "));
    }
    let _ = writeln!(text, "{}\n", words(&table.part));
    let _ = writeln!(text, "| key | value | meaning |\n|---|---|---|");
    for Key {
        name,
        of,
        meaning,
        is_optional,
    } in keys(&table.part)
    {
        let below = table_below(root, name, of);
        let known = below.and_then(|(_, below)| {
            let name = definition(below)?;
            tables.iter().find(|table| table.definition == name)
        });
        let key = match known {
            Some(table) => format!("[`{name}`](#{})", anchor(&table.headings[0])),
            None => format!("`{name}`"),
        };
        let meaning = with_choices(root, of, meaning);
        let optional = if is_optional { ", optional" } else { "" };
        let _ = writeln!(text, "| {key} | {}{optional} | {meaning} |", kind(root, of));
    }
    text.push('\n');
}

/// Anchor of a heading, as renderers of Markdown make it.
fn anchor(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || *c == '_' || *c == '-')
        .collect()
}

/// The description of a part of the schema on one line, with links to the pages that it names.
fn words(of: &Value) -> String {
    let own = of.get("description").and_then(Value::as_str);
    let mut text = own.unwrap_or_default().replace('\n', " ");
    while let Some((before, rest)) = text.split_once("docs/") {
        let end = rest.find(".md").map_or(0, |at| at + 3);
        let is_anchor = |c: char| c == '#' || c == '-' || c == '_' || c.is_alphanumeric();
        let anchor: String = rest[end..].chars().take_while(|c| is_anchor(*c)).collect();
        let (page, link) = (&rest[..end], &rest[..end + anchor.len()]);
        text = format!("{before}[{page}]({link}){}", &rest[link.len()..]);
    }
    text.replace('|', "\\|")
}

/// What kind of value a key has.
fn kind(root: &Value, of: &Value) -> String {
    let part = resolved(root, of);
    if chosen(part).is_some() {
        return "word".to_owned();
    }
    if let Some(named) = (part.get("additionalProperties")).filter(|of| of.is_object()) {
        return match kind(root, named).as_str() {
            "table" => "tables by name".to_owned(),
            other => format!("{other} by name"),
        };
    }
    match part.get("type").and_then(Value::as_str) {
        Some("number") => "number".to_owned(),
        Some("integer") => "whole number".to_owned(),
        Some("boolean") => "`true` or `false`".to_owned(),
        Some("string") => "text".to_owned(),
        Some("array") => {
            let inner = part.get("items").map_or(String::new(), |of| kind(root, of));
            let inner = match inner.as_str() {
                "number" | "whole number" | "table" | "word" => format!("{inner}s"),
                other => format!("rows of {other}"),
            };
            match part.get("minItems").and_then(Value::as_u64) {
                Some(count) => format!("{count} {inner}"),
                None => format!("list of {inner}"),
            }
        }
        _ => "table".to_owned(),
    }
}

/// Words of which one is chosen, with what they mean.
fn chosen(part: &Value) -> Option<String> {
    let quoted = |value: &Value| value.as_str().map(|word| format!("`{word}`"));
    let words: Vec<String> = match part.get("enum").and_then(Value::as_array) {
        Some(words) => words.iter().filter_map(quoted).collect(),
        None => (part.get("oneOf")?.as_array()?.iter())
            .map(|one| {
                let word = one.get("const").and_then(quoted)?;
                let meaning = words(one);
                Some(match meaning.trim_end_matches('.') {
                    "" => word,
                    meaning => format!("{word} ({meaning})"),
                })
            })
            .collect::<Option<_>>()?,
    };
    Some(words.join(", "))
}
