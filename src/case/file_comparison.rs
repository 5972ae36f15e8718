//! `[comparison.NAME]`: what others found for a result of the run.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// One or several reference values of one result: `[comparison.NAME]` or `[[comparison.NAME]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonTable(pub Vec<ComparisonEntry>);

/// One reference; exactly one of value and range.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md; the unit is that of the result"
)]
pub struct ComparisonEntry {
    pub value: Option<f64>,
    pub range: Option<[f64; 2]>,
    pub source: String,
    pub note: Option<String>,
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
