//! The JSON schema of case files, from the comments and types of [`super::file`]; and which keys of it are alternatives.

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
use serde_json::Value;

use super::file::File;

/// Begins the line of a case that tells editors where its schema is.
pub const SCHEMA_DIRECTIVE: &str = "#:schema";

/// Name of the schema beside a case.
pub const SCHEMA_FILE: &str = "ripstop.schema.json";

/// JSON schema (draft 7, which editors of TOML read) of a case file.
#[must_use]
pub(super) fn schema() -> Value {
    let mut schema = SchemaSettings::draft07()
        .into_generator()
        .into_root_schema_for::<File>();
    RecursiveTransform(without_null).transform(&mut schema);
    schema.insert("title".to_owned(), "Ripstop case".into());
    schema.to_value()
}

/// The same as text, as it lies beside cases.
#[must_use]
pub fn schema_text() -> String {
    format!("{:#}\n", schema())
}

/// What the schema says of a key or table; `None` where cases have none such.
fn at<'a, 'b>(root: &'a Value, mut path: impl Iterator<Item = &'b str>) -> Option<&'a Value> {
    path.try_fold(root, |part, step| {
        let own = (part.get("properties").and_then(|keys| keys.get(step)))
            .or_else(|| {
                let all = part.get("oneOf")?.as_array()?.iter();
                let mut found = all.filter_map(|one| one.get("properties")?.get(step));
                found.next()
            })
            .or_else(|| {
                let all = part.get("anyOf")?.as_array()?.iter();
                let mut found =
                    all.filter_map(|one| resolved(root, one).get("properties")?.get(step));
                found.next()
            })
            .or_else(|| part.get("additionalProperties").filter(|of| of.is_object()));
        own.map(|own| resolved(root, own))
    })
}

/// True if cases may have the key or table that these steps lead to.
pub(super) fn knows(path: &[String]) -> bool {
    at(&schema(), path.iter().map(String::as_str)).is_some()
}

/// Names of the tables and keys of which exactly one belongs under a dotted path, such as `structure`; none where that is not so.
pub(super) fn alternatives(path: &str) -> Vec<String> {
    let root = schema();
    let Some(part) = at(&root, path.split('.')) else {
        return Vec::new();
    };
    let all = part.get("oneOf").and_then(Value::as_array);
    (all.into_iter().flatten())
        .filter_map(|one| one.get("properties")?.as_object()?.keys().next().cloned())
        .collect()
}

/// What a part of the schema refers to, if it does.
pub(super) fn resolved<'a>(root: &'a Value, part: &'a Value) -> &'a Value {
    let inner = match part.get("allOf").and_then(Value::as_array) {
        Some(all) => all.first().unwrap_or(part),
        None => part,
    };
    (inner.get("$ref").and_then(Value::as_str))
        .and_then(|path| root.pointer(path.trim_start_matches('#')))
        .map_or(part, |referred| resolved(root, referred))
}

/// TOML has no null: what is optional may be left out.
fn without_null(schema: &mut Schema) {
    let is_null = |value: &Value| value.get("type").is_some_and(|kind| kind == "null");
    let Some(object) = schema.as_object_mut() else {
        return;
    };
    if let Some(Value::Array(kinds)) = object.get_mut("type") {
        kinds.retain(|kind| kind != "null");
        if let [only] = &kinds[..] {
            let only = only.clone();
            object.insert("type".to_owned(), only);
        }
    }
    if let Some(Value::Array(values)) = object.get_mut("enum") {
        values.retain(|value| !value.is_null());
    }
    if let Some(Value::Array(choices)) = object.get_mut("anyOf") {
        choices.retain(|choice| !is_null(choice));
        if let [only] = &choices[..] {
            let only = vec![only.clone()];
            object.remove("anyOf");
            object.insert("allOf".to_owned(), only.into());
        }
    }
}
