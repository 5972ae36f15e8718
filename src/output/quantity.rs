//! Results of a run: numbers with their units, uncertainties and references, by name.

use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::read_out::ReadOut;

/// One result with its uncertainty and, where one exists, a reference to compare it with.
///
/// In the file `value` and `unit` are always present; the others are left out when `None`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The number in `unit`; `None` when it could not be determined, and then `note` says why.
    pub value: Option<f64>,
    /// SI unit, `1` for a plain number.
    pub unit: String,
    /// Half width of the 95 % confidence interval, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// Interval between samples where the number was read from single ones, such as a time, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling_error: Option<f64>,
    /// Measured or analytic number to compare with, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// Where the reference comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Relative error `(value - reference) / |reference|`, a plain number; `None` for a reference of zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Why the run cannot support the number, such as too few cells; `None` where nothing is known against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unresolved: Option<String>,
    /// Remark for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Quantity {
    /// The number `value`; one that is not finite becomes `None` with a note. Its unit comes with the read-out that it is put in as.
    #[must_use]
    pub fn new(value: f64) -> Self {
        Self {
            value: Some(value),
            ..Self::default()
        }
        .finite()
    }

    /// A number with the details of its read-out's meaning, or all of a short one, as a note.
    #[must_use]
    pub fn told(read_out: &ReadOut, value: f64) -> Self {
        Self::new(value).with_note(read_out.detail().unwrap_or(read_out.meaning))
    }

    /// A quantity that could not be determined because of `why`.
    #[must_use]
    pub fn missing(why: &str) -> Self {
        Self {
            note: Some(why.to_owned()),
            ..Self::default()
        }
    }

    /// Adds the half width of the 95 % confidence interval, in the unit of the value.
    #[must_use]
    pub fn with_confidence(mut self, half_width: f64) -> Self {
        self.confidence = Some(half_width);
        self.finite()
    }

    /// Adds the interval between the samples that the value was read from, in the unit of the value.
    #[must_use]
    pub fn with_sampling_error(mut self, interval: f64) -> Self {
        self.sampling_error = Some(interval);
        self.finite()
    }

    /// Adds the reference from `source`, in the unit of the value, and the relative error.
    #[must_use]
    pub fn with_reference(mut self, reference: f64, source: &str) -> Self {
        self.reference = Some(reference);
        self.source = Some(source.to_owned());
        self.error = match self.value {
            Some(value) if reference != 0.0 => Some((value - reference) / reference.abs()),
            _ => None,
        };
        self.finite()
    }

    /// Marks the number as one that the run cannot support, because of `why`; a second reason joins the first.
    pub fn mark_unresolved(&mut self, why: &str) {
        self.unresolved = match self.unresolved.take() {
            Some(earlier) if earlier.contains(why) => Some(earlier),
            Some(earlier) => Some(format!("{earlier}; {why}")),
            None => Some(why.to_owned()),
        };
    }

    /// Adds a remark behind those already there.
    #[must_use]
    pub fn with_note(mut self, remark: &str) -> Self {
        self.note = match self.note.take() {
            Some(earlier) => Some(format!("{earlier}; {remark}")),
            None => Some(remark.to_owned()),
        };
        self
    }

    /// Replaces every number that is not finite by `None` and a note.
    pub(super) fn finite(mut self) -> Self {
        let mut remarks = Vec::new();
        for (name, number) in [
            ("value", &mut self.value),
            ("confidence", &mut self.confidence),
            ("sampling_error", &mut self.sampling_error),
            ("reference", &mut self.reference),
            ("error", &mut self.error),
        ] {
            keep_finite(name, number, &mut remarks);
        }
        remarks
            .iter()
            .fold(self, |quantity, remark| quantity.with_note(remark))
    }
}

/// Named results in the order they were put in; a JSON object.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results {
    entries: Vec<(String, Quantity)>,
}

impl Results {
    /// No results.
    pub fn new() -> Self {
        Self::default()
    }

    /// Puts in `quantity` as a read-out, in its unit: at the end, or in place of an earlier one of that name.
    pub fn insert(&mut self, read_out: &ReadOut, mut quantity: Quantity) {
        read_out.unit.clone_into(&mut quantity.unit);
        self.put(&read_out.name, quantity);
    }

    /// The same of a number with a note from its meaning.
    pub fn tell(&mut self, read_out: &ReadOut, value: f64) {
        self.insert(read_out, Quantity::told(read_out, value));
    }

    fn put(&mut self, name: &str, quantity: Quantity) {
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, earlier)) => *earlier = quantity,
            None => self.entries.push((name.to_owned(), quantity)),
        }
    }

    /// The number of a read-out; `None` where there is no such result, or it could not be determined.
    #[must_use]
    pub fn value(&self, read_out: &ReadOut) -> Option<f64> {
        self.get(&read_out.name)?.value
    }

    /// The result of that name.
    pub fn get(&self, name: &str) -> Option<&Quantity> {
        let mut entries = self.iter();
        entries.find_map(|(known, quantity)| (known == name).then_some(quantity))
    }

    /// All results with their names, in order, to be changed in place.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&str, &mut Quantity)> {
        let entries = self.entries.iter_mut();
        entries.map(|(name, quantity)| (name.as_str(), quantity))
    }

    /// All results with their names, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Quantity)> + Clone {
        let entries = self.entries.iter();
        entries.map(|(name, quantity)| (name.as_str(), quantity))
    }

    /// Number of results.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no results.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

impl Serialize for Results {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Results {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ResultsVisitor)
    }
}

pub(super) struct ResultsVisitor;

impl<'de> Visitor<'de> for ResultsVisitor {
    type Value = Results;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a map from names to quantities")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Results, A::Error> {
        let mut results = Results::new();
        while let Some((name, quantity)) = map.next_entry::<String, Quantity>()? {
            results.put(&name, quantity);
        }
        Ok(results)
    }
}

/// Replaces `number` by `None` and a remark if it is not finite.
pub(super) fn keep_finite(name: &str, number: &mut Option<f64>, remarks: &mut Vec<String>) {
    if let Some(strange) = number.take_if(|number| !number.is_finite()) {
        remarks.push(format!("{name} was not finite ({strange})"));
    }
}
