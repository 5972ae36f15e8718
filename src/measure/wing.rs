//! What a designer reads of a wing in equilibrium: loads of rows and lines, balance of forces, stresses with their place, slack fabric.

use glam::DVec3;

use super::read_out::results;
use super::shared::{LINE_LOAD_SHARE, TAPE_LOAD_SHARE};
use super::statistics::largest;
use crate::case::wing::Wing;
use crate::frame::{CableKind, FabricState, StructureFrame};
use crate::geometry::wing::{LineKind, Part, Tag};
use crate::output::{Quantity, Results};
use crate::statics::Trim;
use crate::trim::Flight;

results! {
    /// Of wings in equilibrium, and of wings in the wind.
    RESULTS: "Wings";
    PRESSURE_FORCE_X: "pressure_force_x_n", "N", "force of the air on the flown shape along x";
    PRESSURE_FORCE_Z: "pressure_force_z_n", "N", "force of the air on the flown shape along z";
    RISER_FORCE_RIGHT: "riser_force_right_n", "N", "force of all risers of the right half together";
    RISER_FORCE_LEFT: "riser_force_left_n", "N", "force of all risers of the left half together";
    PITCH_GUIDE_FORCE: "pitch_guide_force_n", "N", "force of the pitch guide along x on the nose in the middle";
    RISER_BALANCE_ERROR: "riser_balance_error", "1", "error of the balance of forces; pressure, weight, pitch guide and reactions of the risers, over the larger of the first two";
    LINE_LOAD_SHARE;
    TAPE_LOAD_SHARE;
    ROW_LOAD: "row_{row}_load_n", "N", "load of the row; tension of its risers, both halves";
    ROW_SHARE: "row_{row}_load_share", "1", "load of the row over that of all rows";
    ROW_ATTACHMENT_MAX: "row_{row}_attachment_load_max_n", "N", "largest tension of a line of the row at an attachment";
    PART_STRESS_MAX: "{part}_stress_max_pa", "Pa", "largest stress of the part; of panels, ribs, diagonals and mini-ribs";
    PART_WRINKLED: "{part}_wrinkled_area_share", "1", "share of the part's area that is wrinkled";
    PART_SLACK: "{part}_slack_area_share", "1", "share of the part's area that is slack";
    PROJECTED_SPAN: "projected_span_m", "m", "span seen from above; between the noses of the tip ribs";
    PITCH: "pitch_deg", "deg", "pitch; of the rib in the middle or both beside it, nose up";
}

/// Adds the results of a wing; `weight_n` is that of fabric and lines.
pub(super) fn results(
    results: &mut Results,
    wing: &Wing,
    structure: &StructureFrame,
    weight_n: DVec3,
    trim: Option<&Trim>,
) {
    forces(results, wing, structure, weight_n, trim);
    lines(results, wing, structure);
    stresses(results, wing, structure);
    shape(results, wing, structure);
}

/// Sum of the pulls of pressure, and in a trim of traction and drag of lines, on the flown shape [N]; zero if there is none.
fn air_force_n(wing: &Wing, structure: &StructureFrame, flight: Option<&Flight>) -> DVec3 {
    let sum = |jumps: &[f64]| -> DVec3 {
        let triangles = structure.triangles.iter().zip(jumps);
        triangles
            .map(|(nodes, jump)| {
                let [a, b, c] = nodes.map(|n| structure.positions_m[n as usize]);
                (b - a).cross(c - a) * (0.5 * jump)
            })
            .sum()
    };
    match (flight, &wing.load_pa) {
        (Some(Flight { loads, .. }), _) => {
            sum(&loads.jumps_pa) + loads.nodal_n.iter().sum::<DVec3>()
        }
        (None, Some(jumps_pa)) => sum(jumps_pa),
        (None, None) => DVec3::ZERO,
    }
}

fn forces(
    results: &mut Results,
    wing: &Wing,
    structure: &StructureFrame,
    weight_n: DVec3,
    trim: Option<&Trim>,
) {
    let flight = trim.and_then(|trim| trim.flight.as_ref());
    let pressure = air_force_n(wing, structure, flight);
    for (read_out, value) in [
        (&PRESSURE_FORCE_X, pressure.x),
        (&PRESSURE_FORCE_Z, pressure.z),
    ] {
        results.insert(
            read_out,
            Quantity::new(value).with_note(if wing.trim.is_some() {
                "of pressure, traction and drag of lines on the flown shape"
            } else {
                "of the prescribed pressure on the flown shape"
            }),
        );
    }
    let [right, left] = wing
        .built
        .hang_points
        .map(|n| structure.reactions_n[n as usize]);
    for (read_out, force) in [(&RISER_FORCE_RIGHT, right), (&RISER_FORCE_LEFT, left)] {
        let note = "of all risers of this half together";
        results.insert(read_out, Quantity::new(force.length()).with_note(note));
    }
    let mut guide = DVec3::ZERO;
    if let Some([stiffness, anchor_m]) = wing.built.pitch_guide {
        let [nose, _] = wing.built.middle_chord;
        guide.x = match trim {
            Some(trim) => trim.iterations.last().map_or(0.0, |last| last.guide_n),
            None => -stiffness * (structure.positions_m[nose as usize].x - anchor_m),
        };
        results.insert(
            &PITCH_GUIDE_FORCE,
            Quantity::new(guide.x).with_note(if wing.trim.is_some() {
                "along x on the nose in the middle: what is left of it once the wing stands still"
            } else {
                "along x on the nose in the middle: what prescribed pressure lacks to a balance of moments about the risers"
            }),
        );
    }
    let rest = pressure + weight_n + right + left + guide;
    let scale = pressure.length().max(weight_n.length());
    results.insert(
        &RISER_BALANCE_ERROR,
        if scale > 0.0 {
            Quantity::told(&RISER_BALANCE_ERROR, rest.length() / scale)
        } else {
            Quantity::missing("nothing acts on the wing")
        },
    );
}

/// What a row of lines carries.
#[derive(Debug, Clone, PartialEq)]
pub struct RowLoad {
    /// Name of the row.
    pub name: String,
    /// Tension of its risers, both halves [N].
    pub load_n: f64,
    /// Largest tension of a line at an attachment [N].
    pub attachment_max_n: f64,
}

/// Loads of all rows.
#[must_use]
pub fn row_loads(wing: &Wing, structure: &StructureFrame) -> Vec<RowLoad> {
    let kinds = || {
        wing.built
            .line_kinds
            .iter()
            .zip(&structure.cable_tensions_n)
    };
    let row = |(number, name): (usize, &String)| {
        let tensions = |is: LineKind| {
            let own = kinds().filter(move |(kind, _)| **kind == is);
            own.map(|(_, tension)| *tension)
        };
        RowLoad {
            name: name.clone(),
            load_n: tensions(LineKind::Riser { row: number }).sum(),
            attachment_max_n: largest(tensions(LineKind::Line {
                row: number,
                level: 0,
            })),
        }
    };
    wing.built.row_names.iter().enumerate().map(row).collect()
}

fn lines(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    let rows = row_loads(wing, structure);
    let sum: f64 = rows.iter().map(|row| row.load_n).sum();
    for RowLoad {
        name,
        load_n,
        attachment_max_n,
    } in rows
    {
        results.tell(&ROW_LOAD.of(&name), load_n);
        results.insert(
            &ROW_SHARE.of(&name),
            Quantity::new(if sum > 0.0 { load_n / sum } else { 0.0 }),
        );
        results.insert(
            &ROW_ATTACHMENT_MAX.of(&name),
            Quantity::new(attachment_max_n),
        );
    }
    margins(results, wing, structure);
}

/// Largest load of a line or riser over its breaking load, and of a tape.
pub(super) fn margins(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    let shares = |are_tapes: bool| {
        let tensions = structure.cable_tensions_n.iter();
        let kinds = structure.cable_kinds.iter().zip(&wing.breaking_loads_n);
        let cables = tensions.zip(kinds).enumerate();
        cables.filter_map(move |(cable, (tension, (kind, breaking)))| {
            let is_asked = (*kind == CableKind::Belt) == are_tapes;
            Some((cable, tension / breaking.filter(|_| is_asked)?))
        })
    };
    if let Some(share) = shares(true).map(|(_, share)| share).reduce(f64::max) {
        results.tell(&TAPE_LOAD_SHARE, share);
    }
    let margins = shares(false);
    let nearest = margins.max_by(|a, b| a.1.total_cmp(&b.1));
    let used = nearest.map_or(f64::NAN, |(_, share)| share);
    results.insert(
        &LINE_LOAD_SHARE,
        if used.is_nan() {
            Quantity::missing("no line material tells its breaking_load_n")
        } else {
            let names = super::wing_lines::names(wing, &structure.cables, &structure.positions_m);
            let line = nearest.and_then(|(cable, _)| {
                let name = names.get(cable)?.text();
                Some(format!(
                    "{name}, {:.0} N",
                    structure.cable_tensions_n[cable]
                ))
            });
            match line {
                Some(line) => Quantity::new(used).with_note(&line),
                None => Quantity::told(&LINE_LOAD_SHARE, used),
            }
        },
    );
}

/// Name of a part as in the names of results.
#[must_use]
pub fn key(part: Part) -> String {
    part.name().replace([' ', '-'], "_")
}

/// Where a triangle is, in words.
pub(super) fn place(wing: &Wing, tag: &Tag) -> String {
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
            wing.built.cells
        } else {
            wing.built.cells + 1
        },
        tag.chord_place
    )
}

/// Largest stress of every part with its place, and how much of it is wrinkled and slack.
pub(super) fn stresses(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    for part in Part::ALL {
        let own = || {
            let tags = wing.built.tags.iter().enumerate();
            tags.filter(move |(_, tag)| tag.part == part)
        };
        let stress = |triangle: usize| structure.stress_pa[triangle];
        let most = own().max_by(|a, b| stress(a.0).total_cmp(&stress(b.0)));
        let Some((triangle, tag)) = most else {
            continue;
        };
        let name = key(part);
        results.insert(
            &PART_STRESS_MAX.of(&name),
            Quantity::new(stress(triangle)).with_note(&place(wing, tag)),
        );
        let area = |state: Option<FabricState>| -> f64 {
            own()
                .filter(|(t, _)| state.is_none_or(|state| structure.states[*t] == state))
                .map(|(t, _)| structure.rest_areas_m2[t])
                .sum()
        };
        for (state, share) in [
            (FabricState::Wrinkled, &PART_WRINKLED),
            (FabricState::Slack, &PART_SLACK),
        ] {
            let value = area(Some(state)) / area(None);
            results.insert(&share.of(&name), Quantity::new(value));
        }
    }
}

fn shape(results: &mut Results, wing: &Wing, structure: &StructureFrame) {
    let place = |node: u32| structure.positions_m[node as usize];
    let [left, right] = wing.built.tip_noses.map(place);
    results.tell(&PROJECTED_SPAN, right.y - left.y);
    let [nose, tail] = wing.built.middle_chord_m(&structure.positions_m);
    let chord = tail - nose;
    results.tell(&PITCH, (-chord.z).atan2(chord.x).to_degrees());
}
