//! What may be written in `[comparison.NAME]`: what others found for a result of the run.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// What others found for the result NAME of `summary.json`: one table, or several as `[[comparison.NAME]]` (docs/parachutes.md).
#[derive(Debug, Clone, PartialEq, JsonSchema)]
pub struct ComparisonTable(#[schemars(with = "OneOrSeveralEntries")] pub Vec<ComparisonEntry>);

/// One finding of others; exactly one of `value` and `range`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparisonEntry {
    /// The value, in the unit of the result.
    pub value: Option<f64>,
    /// Or the range in which it lies.
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
