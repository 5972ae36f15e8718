//! Where fabric meets itself.

use super::read_out::Reduction::{LargestAs, Smallest};
use super::read_out::{ReadOut, When, columns};
use super::record::Record;
use crate::case::Scene;
use crate::cpu::cloth::ContactState;
use crate::output::{Quantity, Results};

static CONTACT: When<Scene> = When {
    words: "",
    holds: |scene| {
        let body = scene.body.as_ref();
        body.is_some_and(|body| body.structure.contact.is_some())
    },
};

columns! {
    /// No gap where nothing is closer than the thickness.
    COLUMNS of ContactState, in Scene: "Fabric with contact";
    SMALLEST_GAP: "smallest_gap_m", "m", "smallest gap between middle surfaces"
        => |now| if now.smallest_gap_m.is_finite() { now.smallest_gap_m } else { f64::NAN }, reduced Smallest, when CONTACT;
    ENERGY: "contact_energy_j", "J", "energy of contact"
        => |now| now.energy_j, reduced LargestAs("contact_energy_max_j"), when CONTACT;
}

/// Extremes of all samples.
pub(super) fn results(results: &mut Results, record: &Record) {
    if !record.has(&SMALLEST_GAP) {
        return;
    }
    // f64::min passes over samples in which nothing is near.
    let gaps = record.column(&SMALLEST_GAP).into_iter();
    let smallest = gaps.fold(f64::INFINITY, f64::min);
    let gap = if smallest.is_finite() {
        Quantity::new(smallest).with_note("smallest of all samples, between middle surfaces")
    } else {
        Quantity::missing("no fabric came closer to other fabric than contact.thickness_m")
    };
    results.insert(&SMALLEST_GAP, gap);
    let energies = record.column(&ENERGY).into_iter();
    let largest = Quantity::new(energies.fold(0.0, f64::max));
    let energy: ReadOut = ENERGY.named("contact_energy_max_j");
    results.insert(&energy, largest.with_note("largest of all samples"));
}
