//! What a run tells of its validity when it is over.

use super::rule::Rule;
use crate::case::Scene;
use crate::frame::CableKind;
use crate::frame::StructureFrame;
use crate::measure::Record;
use crate::measure::canopy_shape::PRINCIPAL_STRAIN_1_MAX;
use crate::measure::shared::{LINE_LOAD_SHARE, LINE_TENSION_MAX, TAPE_LOAD_SHARE, VON_MISES_MAX};
use crate::measure::strengths::{Carrier, load_shares};
use crate::output::{Bound, ReadOut, Supports, ValidityRow, When};

/// A structure at the end of its run, and what was recorded.
struct Ended<'a> {
    scene: &'a Scene,
    structure: &'a StructureFrame,
    record: &'a Record,
}

impl Ended<'_> {
    /// The largest of a column of the history, or of the last state where the history does not have it.
    fn largest(&self, column: &ReadOut, last: impl Iterator<Item = f64>) -> f64 {
        let recorded = self.record.column(column);
        recorded.into_iter().chain(last).fold(f64::NAN, f64::max)
    }

    /// The largest load over breaking load of cables of a kind; `None` where no breaking load is told.
    fn largest_share(&self, column: &ReadOut, of: Carrier) -> Option<f64> {
        let structure = &self.scene.body.as_ref()?.structure;
        let mut last = load_shares(structure, of, &self.structure.cable_tensions_n).peekable();
        last.peek()?;
        Some(self.largest(column, last))
    }
}

const fn rules<'a>() -> [Rule<Ended<'a>>; 5] {
    [
        Rule {
            name: "largest strain of the fabric",
            unit: "1",
            meaning: "largest principal strain (Green) of the samples and of the last state; laws of fabric are those of small strain",
            bound: Bound::AtMost,
            limit: 0.1,
            supports: Supports::Everything,
            remedy: "check fabric.youngs_modulus_pa, fabric.thickness_m and the loads: such fabric would tear or creep",
            value: |ended| {
                // A network of springs has no strains.
                ended.scene.body.as_ref()?.structure.membrane.as_ref()?;
                let strains = &ended.structure.principal_strains;
                let last = strains.iter().map(|strains| strains[0]);
                (!strains.is_empty()).then(|| ended.largest(&PRINCIPAL_STRAIN_1_MAX, last))
            },
        },
        Rule {
            name: "stress over strength",
            unit: "1",
            meaning: "largest von Mises stress of the samples and of the last state over fabric.yield_stress_pa; the law stays elastic",
            bound: Bound::AtMost,
            limit: 1.0,
            supports: Supports::Everything,
            remedy: "take stronger fabric: this one would yield",
            value: |ended| {
                ended.scene.body.as_ref()?.structure.membrane.as_ref()?;
                let strength_pa = ended.structure.yield_stress_pa?;
                let last = ended.structure.von_mises_pa.iter().copied();
                Some(ended.largest(&VON_MISES_MAX, last) / strength_pa)
            },
        },
        Rule {
            name: "line tension over breaking load",
            unit: "1",
            meaning: "largest tension of a line or riser of a canopy of all samples and in the last state, or of a wing's in the last state, over its breaking load",
            bound: Bound::AtMost,
            limit: 1.0,
            supports: Supports::Everything,
            remedy: "take stronger lines: this one would break",
            value: |ended| ended.largest_share(&LINE_LOAD_SHARE, Carrier::Lines),
        },
        Rule {
            name: "tape tension over breaking load",
            unit: "1",
            meaning: "largest tension of a belt or band of a canopy of all samples and in the last state, or of a wing's tape in the last state, over its breaking load",
            bound: Bound::AtMost,
            limit: 1.0,
            supports: Supports::Everything,
            remedy: "take stronger tapes: this one would break",
            value: |ended| ended.largest_share(&TAPE_LOAD_SHARE, Carrier::Tapes),
        },
        Rule {
            name: "largest strain of a suspension line",
            unit: "1",
            meaning: "strain of a suspension line at its largest tension of all samples",
            bound: Bound::AtMost,
            limit: 0.3,
            supports: Supports::Everything,
            remedy: "check lines.youngs_modulus_pa and lines.area_m2: such lines would tear",
            value: |ended| {
                let structure = &ended.scene.body.as_ref()?.structure;
                let mut lines = structure.cables.iter();
                let line = lines.find(|cable| cable.kind == CableKind::SuspensionLine)?;
                let last = ended.structure.tensions_n(&[CableKind::SuspensionLine]);
                let largest_n = ended.largest(&LINE_TENSION_MAX, last);
                let law = &structure.cable_laws[line.law as usize];
                largest_n.is_finite().then(|| law.strain_at(largest_n))
            },
        },
    ]
}

/// Rows that the end of a run tells.
#[must_use]
pub fn at_the_end(
    scene: &Scene,
    structure: Option<&StructureFrame>,
    record: &Record,
) -> Vec<ValidityRow> {
    let Some(structure) = structure else {
        return Vec::new();
    };
    let ended = Ended {
        scene,
        structure,
        record,
    };
    let rules = rules();
    let rules = rules.iter();
    rules
        .filter_map(|rule| rule.row(&ended, ("", ""), When::AtTheEnd))
        .collect()
}
