//! What may be written in `[comparison.NAME]`: what others found for a result of the run.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// One finding of others, or several.
#[derive(Debug, Clone, PartialEq, JsonSchema)]
pub struct ComparisonTable(#[schemars(with = "OneOrSeveralEntries")] pub Vec<ComparisonEntry>);

/// What others found for the result NAME of `summary.json`; several are written `[[comparison.NAME]]` (docs/parachutes.md#comparisons). Exactly
/// one of `value` and `range`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparisonEntry {
    /// The value, in the unit of the result.
    pub value: Option<f64>,
    /// Range in which the value lies, instead of `value`.
    pub range: Option<[f64; 2]>,
    /// Where it is from.
    pub source: String,
    /// What should be known of it.
    pub note: Option<String>,
}

/// For the schema alone.
#[derive(JsonSchema)]
#[serde(untagged)]
enum OneOrSeveralEntries {
    #[expect(dead_code, reason = "stands in the schema")]
    One(ComparisonEntry),
    #[expect(dead_code, reason = "stands in the schema")]
    Several(Vec<ComparisonEntry>),
}

impl<'de> Deserialize<'de> for ComparisonTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrSeveral)
    }
}

/// Unlike an untagged enumeration, it keeps the messages about single keys.
struct OneOrSeveral;

impl<'de> Visitor<'de> for OneOrSeveral {
    type Value = ComparisonTable;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a table with value or range, and source, or a list of such tables")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ComparisonTable, A::Error> {
        let entry = ComparisonEntry::deserialize(MapAccessDeserializer::new(map))?;
        Ok(ComparisonTable(vec![entry]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<ComparisonTable, A::Error> {
        let entries = Vec::deserialize(SeqAccessDeserializer::new(list))?;
        Ok(ComparisonTable(entries))
    }
}
