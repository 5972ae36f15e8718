//! Results of fabric and cables: in the wind, and without air.

use glam::DVec3;

use crate::case::scene::{Airbag, BodyKind, HangingCable};
use crate::frame::{CableKind, FabricState, StructureFrame};
use crate::measure::record::largest as largest_of;
use crate::measure::{Record, catenary, plate};
use crate::output::{Quantity, Results};

/// Means over the second half of the run.
pub(super) fn in_wind(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let Some(first) = times.iter().position(|&t| t > 0.0) else {
        results.insert(
            "force_x_n",
            Quantity::missing("N", "the run ended before release"),
        );
        return;
    };
    let first = first.midpoint(times.len());
    let half = format!(
        "mean from {:.4} s on",
        times.get(first).copied().unwrap_or(f64::NAN)
    );
    for (name, unit) in [
        ("force_x_n", "N"),
        ("force_y_n", "N"),
        ("force_z_n", "N"),
        ("force_x_momentum_box_n", "N"),
        ("tension_max_n_m", "N/m"),
        ("slip_ratio", "1"),
    ] {
        let values = &record.column(name)[first..];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        results.insert(name, Quantity::new(mean, unit).with_note(&half));
    }
    let defect = largest_of(
        record
            .column("mass_defect")
            .into_iter()
            .skip(1)
            .map(f64::abs),
    );
    results.insert("mass_drift", Quantity::new(defect, "1"));
}

/// Fabric and cables without air; where they `rest` as the case builds them, exact values stand beside.
pub(super) fn alone(
    results: &mut Results,
    kind: &BodyKind,
    structure: &StructureFrame,
    (weight_n, rests): (f64, bool),
) {
    let lowest = structure
        .positions_m
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    let highest = structure
        .positions_m
        .iter()
        .map(|p| p.z)
        .fold(f64::NEG_INFINITY, f64::max);
    if let BodyKind::Cable(HangingCable {
        span_m,
        length_m,
        weight_n_m,
    }) = *kind
    {
        let exact = catenary::solve(span_m, length_m, weight_n_m).filter(|_| rests);
        let source = "exact catenary of an inextensible cable";
        let tensions = &structure.cable_tensions_n;
        let mut insert = |name: &str, value: f64, unit: &str, exact: Option<f64>| {
            let quantity = Quantity::new(value, unit);
            results.insert(
                name,
                match exact {
                    Some(exact) => quantity.with_reference(exact, source),
                    None => quantity,
                },
            );
        };
        insert("sag_m", highest - lowest, "m", exact.map(|c| c.sag_m));
        let middle = tensions.iter().copied().fold(f64::INFINITY, f64::min);
        insert(
            "horizontal_tension_n",
            middle,
            "N",
            exact.map(|c| c.horizontal_tension_n),
        );
        // A segment's tension belongs to its middle; the support also carries the half segment next to it.
        let (first, tension) = (structure.cables[0], tensions[0]);
        let [a, b] = first.map(|n| structure.positions_m[n as usize]);
        let pull = (b - a).normalize_or_zero() * tension;
        let half_weight = 0.5 * weight_n_m * length_m / tensions.len() as f64;
        let end = (pull - DVec3::Z * half_weight).length();
        insert("end_tension_n", end, "N", exact.map(|c| c.end_tension_n));
        return;
    }
    specimen_results(results, kind, structure);
    results.insert("lowest_point_m", Quantity::new(lowest, "m"));
    results.insert("highest_point_m", Quantity::new(highest, "m"));
    let springs = "springs carry no membrane tension";
    for (name, unit, value) in [
        (
            "tension_max_n_m",
            "N/m",
            largest_of(structure.principal_tensions_n_m.iter().map(|t| t[0])),
        ),
        (
            "stress_max_pa",
            "Pa",
            largest_of(structure.stress_pa.iter().copied()),
        ),
        (
            "von_mises_max_pa",
            "Pa",
            largest_of(structure.von_mises_pa.iter().copied()),
        ),
        (
            "shear_stress_max_pa",
            "Pa",
            largest_of(structure.shear_stress_pa.iter().map(|s| s.abs())),
        ),
    ] {
        let quantity = if value.is_nan() {
            Quantity::missing(unit, springs)
        } else {
            Quantity::new(value, unit)
        };
        results.insert(name, quantity);
    }
    let area: f64 = structure.rest_areas_m2.iter().sum();
    let share = |is_counted: &dyn Fn(usize) -> bool| {
        let areas = structure.rest_areas_m2.iter().enumerate();
        areas
            .filter(|(triangle, _)| is_counted(*triangle))
            .map(|(_, area)| area)
            .sum::<f64>()
            / area
    };
    for (name, state) in [
        ("wrinkled_area_share", FabricState::Wrinkled),
        ("slack_area_share", FabricState::Slack),
    ] {
        let value = share(&|triangle| structure.states[triangle] == state);
        results.insert(name, Quantity::new(value, "1"));
    }
    if let Some(yield_pa) = structure.yield_stress_pa {
        let value = share(&|triangle| structure.von_mises_pa[triangle] > yield_pa);
        results.insert("yielding_area_share", Quantity::new(value, "1"));
    }
    results.insert("weight_n", Quantity::new(weight_n, "N"));
    if structure.cable_kinds.contains(&CableKind::SuspensionLine) {
        let tension = structure
            .cable_tensions_n
            .iter()
            .copied()
            .fold(0.0, f64::max);
        results.insert("line_tension_max_n", Quantity::new(tension, "N"));
    }
}

/// What airbags and coupons are made for.
fn specimen_results(results: &mut Results, kind: &BodyKind, structure: &StructureFrame) {
    let place = |node: u32| structure.positions_m[node as usize];
    match kind {
        BodyKind::Airbag(Airbag { middles }) => {
            let [up, down] = middles.map(place);
            results.insert(
                "half_height_m",
                Quantity::new(0.5 * (up.z - down.z), "m").with_note("in the middle"),
            );
        }
        BodyKind::Coupon(coupon) => {
            let [a, b] = coupon.gauge.map(place);
            let strain = a.distance(b) / coupon.gauge_length_m - 1.0;
            // Both clamps pull alike.
            let pull = 0.5 * structure.reactions_n.iter().map(|f| f.x.abs()).sum::<f64>();
            results.insert("pull_n", Quantity::new(pull, "N"));
            results.insert(
                "gauge_strain",
                Quantity::new(strain, "1").with_note("middle third of the length"),
            );
            results.insert(
                "modulus_pa",
                Quantity::new(pull / coupon.cross_section_m2 / strain, "Pa"),
            );
        }
        BodyKind::Plate(shape) => {
            let tip = place(shape.tip()) - shape.flat_tip_m();
            for (name, value) in plate::COLUMNS.iter().zip(tip.to_array()) {
                let note = "middle of the free edge, from where the flat plate has it";
                results.insert(name, Quantity::new(value, "m").with_note(note));
            }
        }
        BodyKind::Canopy(_)
        | BodyKind::Sheet
        | BodyKind::Cable { .. }
        | BodyKind::Mesh
        | BodyKind::Wing(_)
        | BodyKind::ImportedWing(_) => {}
    }
}
