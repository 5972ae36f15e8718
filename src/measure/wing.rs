//! What a designer reads of a wing in equilibrium: loads of rows and lines, balance of forces, stresses with their place, slack fabric.

use glam::DVec3;

use super::record::largest;
use crate::case::wing::Wing;
use crate::frame::{FabricState, StructureFrame};
use crate::geometry::wing::{LineKind, Part, Tag};
use crate::output::{Quantity, Results};

/// Adds the results of a wing; `weight_n` is that of fabric and lines.
pub(super) fn results(
    results: &mut Results,
    wing: &Wing,
    structure: &StructureFrame,
    weight_n: DVec3,
) {
    forces(results, wing, structure, weight_n);
    lines(results, wing, structure);
    stresses(results, wing, structure);
    shape(results, wing, structure);
}

/// Sum of the pulls of prescribed pressure on the flown shape [N]; zero if there is none.
fn pressure_force_n(wing: &Wing, structure: &StructureFrame) -> DVec3 {
    let Some(load) = &wing.load else {
        return DVec3::ZERO;
    };
    let triangles = structure.triangles.iter().zip(load.jumps_pa());
    triangles
        .map(|(nodes, jump)| {
            let [a, b, c] = nodes.map(|n| structure.positions_m[n as usize]);
            (b - a).cross(c - a) * (0.5 * jump)
        })
        .sum()
}

fn forces(results: &mut Results, wing: &Wing, structure: &StructureFrame, weight_n: DVec3) {
    let pressure = pressure_force_n(wing, structure);
    for (name, value) in [
        ("pressure_force_x_n", pressure.x),
        ("pressure_force_z_n", pressure.z),
    ] {
        results.insert(
            name,
            Quantity::new(value, "N").with_note("of the prescribed pressure on the flown shape"),
        );
    }
    let [right, left] = wing
        .wing
        .hang_points
        .map(|n| structure.reactions_n[n as usize]);
    for (name, force) in [("right", right), ("left", left)] {
        results.insert(
            &format!("riser_force_{name}_n"),
            Quantity::new(force.length(), "N").with_note("of all risers of this half together"),
        );
    }
    let mut guide = DVec3::ZERO;
    if let Some([stiffness, anchor_m]) = wing.wing.pitch_guide {
        let [nose, _] = wing.wing.middle_chord;
        guide.x = -stiffness * (structure.positions_m[nose as usize].x - anchor_m);
        results.insert(
            "pitch_guide_force_n",
            Quantity::new(guide.x, "N")
                .with_note("along x on the nose in the middle: what prescribed pressure lacks to a balance of moments about the risers"),
        );
    }
    let rest = pressure + weight_n + right + left + guide;
    let scale = pressure.length().max(weight_n.length());
    results.insert(
        "riser_balance_error",
        if scale > 0.0 {
            Quantity::new(rest.length() / scale, "1")
                .with_note("pressure, weight, pitch guide and reactions of the risers, over the larger of the first two")
        } else {
            Quantity::missing("1", "nothing acts on the wing")
        },
    );
}

fn lines(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    let kinds = || wing.wing.line_kinds.iter().zip(&structure.cable_tensions_n);
    let sum: f64 = kinds()
        .filter(|(kind, _)| matches!(kind, LineKind::Riser { .. }))
        .map(|(_, tension)| tension)
        .sum();
    for (number, name) in wing.wing.row_names.iter().enumerate() {
        let tensions = |is: &dyn Fn(LineKind) -> bool| -> Vec<f64> {
            let own = kinds().filter(|(kind, _)| is(**kind));
            own.map(|(_, tension)| *tension).collect()
        };
        let risers = tensions(&|kind| kind == LineKind::Riser { row: number });
        let total: f64 = risers.iter().sum();
        results.insert(
            &format!("row_{name}_load_n"),
            Quantity::new(total, "N").with_note("tension of its risers, both halves"),
        );
        results.insert(
            &format!("row_{name}_load_share"),
            Quantity::new(if sum > 0.0 { total / sum } else { 0.0 }, "1"),
        );
        let upper = tensions(&|kind| {
            kind == LineKind::Line {
                row: number,
                level: 0,
            }
        });
        results.insert(
            &format!("row_{name}_attachment_load_max_n"),
            Quantity::new(largest(upper.into_iter()), "N"),
        );
    }
    let margins = structure
        .cable_tensions_n
        .iter()
        .zip(&wing.breaking_loads_n)
        .filter_map(|(tension, breaking)| Some(tension / (*breaking)?));
    let used = margins.fold(f64::NAN, f64::max);
    results.insert(
        "line_load_over_breaking_load_max",
        if used.is_nan() {
            Quantity::missing("1", "no line material tells its breaking_load_n")
        } else {
            Quantity::new(used, "1").with_note("of the line, riser or tape nearest to breaking")
        },
    );
}

/// Where a triangle is, in words.
fn place(wing: &Wing, tag: &Tag) -> String {
    let number = tag.number as usize;
    let kind = match tag.part {
        Part::Upper | Part::Lower | Part::MiniRib => "cell",
        Part::Rib | Part::Diagonal => "rib",
    };
    format!(
        "{}, {kind} {} of {} from the left tip, {:.2} of the chord",
        tag.part.name(),
        number + 1,
        if kind == "cell" {
            wing.wing.cells
        } else {
            wing.wing.cells + 1
        },
        tag.chord_place
    )
}

fn stresses(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    for part in Part::ALL {
        let own = || {
            let tags = wing.wing.tags.iter().enumerate();
            tags.filter(move |(_, tag)| tag.part == part)
        };
        let stress = |triangle: usize| structure.stress_pa[triangle];
        let most = own().max_by(|a, b| stress(a.0).total_cmp(&stress(b.0)));
        let Some((triangle, tag)) = most else {
            continue;
        };
        let name = part.name().replace([' ', '-'], "_");
        results.insert(
            &format!("{name}_stress_max_pa"),
            Quantity::new(stress(triangle), "Pa").with_note(&place(wing, tag)),
        );
        let area = |state: Option<FabricState>| -> f64 {
            own()
                .filter(|(t, _)| state.is_none_or(|state| structure.states[*t] == state))
                .map(|(t, _)| structure.rest_areas_m2[t])
                .sum()
        };
        for (state, word) in [
            (FabricState::Wrinkled, "wrinkled"),
            (FabricState::Slack, "slack"),
        ] {
            results.insert(
                &format!("{name}_{word}_area_share"),
                Quantity::new(area(Some(state)) / area(None), "1"),
            );
        }
    }
}

fn shape(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    let place = |node: u32| structure.positions_m[node as usize];
    let [left, right] = wing.wing.tip_noses.map(place);
    results.insert(
        "projected_span_m",
        Quantity::new(right.y - left.y, "m").with_note("between the noses of the tip ribs"),
    );
    let [nose, tail] = wing.wing.middle_chord.map(place);
    let chord = tail - nose;
    results.insert(
        "pitch_deg",
        Quantity::new((-chord.z).atan2(chord.x).to_degrees(), "deg")
            .with_note("of the rib in or next to the middle, nose up"),
    );
}
