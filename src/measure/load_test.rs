//! What a designer reads of a load test: how near lines come to breaking, largest stresses with their place, and the shape.
//!
//! EN 926-1 has a wing bear eight times its largest weight in flight on a test rig, and the breaking loads of the lines of every level together exceed
//! fourteen times that weight (and 14 kN), after bending; brakes are not counted here.

use glam::DVec3;

use super::read_out::{ReadOut, results};
use super::wing::{key, place};
use super::wing_lines::{self, LineName};
use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::geometry::wing::{LineKind, Part};
use crate::output::{Quantity, Results};
use crate::statics::{LoadStep, LoadTest};

/// The line nearest to breaking.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// Number of its cable.
    pub cable: usize,
    /// Its load over its breaking load.
    pub share: f64,
}

/// What is read of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadReading {
    /// Multiple of the loads.
    pub load_factor: f64,
    /// Forces of the risers of the right and the left half [N].
    pub riser_forces_n: [f64; 2],
    /// Tension of the risers of every row, both halves [N].
    pub row_loads_n: Vec<f64>,
    /// Of every row, risers included; `None` where no breaking load is told.
    pub rows: Vec<Option<Nearest>>,
    /// Of all lines, risers and tapes.
    pub nearest: Option<Nearest>,
    /// Largest stress [Pa] and its triangle, by the parts of [`parts`].
    pub stresses: Vec<(usize, f64)>,
    /// Area of the chords seen from above [m²].
    pub projected_area_m2: f64,
}

/// The parts that the wing has.
#[must_use]
pub fn parts(wing: &Wing) -> Vec<Part> {
    let has = |part: &Part| wing.built.tags.iter().any(|tag| tag.part == *part);
    Part::ALL.into_iter().filter(has).collect()
}

fn nearest_of(
    wing: &Wing,
    tensions_n: &[f64],
    is_asked: impl Fn(&LineKind) -> bool,
) -> Option<Nearest> {
    let kinds = wing.built.line_kinds.iter().zip(&wing.breaking_loads_n);
    kinds
        .zip(tensions_n)
        .enumerate()
        .filter_map(|(cable, ((kind, breaking), tension))| {
            let share = tension / (*breaking)?;
            is_asked(kind).then_some(Nearest { cable, share })
        })
        .max_by(|a, b| a.share.total_cmp(&b.share))
}

/// Area of the chord lines seen from above [m²].
fn projected_area_m2(wing: &Wing, positions_m: &[DVec3]) -> f64 {
    let chord = |outline: &Vec<u32>| {
        [outline[0], outline[outline.len() / 2]].map(|node| positions_m[node as usize])
    };
    let area = |pair: &[Vec<u32>]| {
        let ([a, b], [d, c]) = (chord(&pair[0]), chord(&pair[1]));
        let corners = [a, b, c, d];
        let twice: f64 = (0..4)
            .map(|i| {
                corners[i]
                    .truncate()
                    .perp_dot(corners[(i + 1) % 4].truncate())
            })
            .sum();
        0.5 * twice.abs()
    };
    wing.built.outlines.windows(2).map(area).sum()
}

/// Reads a step.
#[must_use]
pub fn read(wing: &Wing, step: &LoadStep) -> LoadReading {
    let tensions = &step.cable_tensions_n;
    let of_row = |row: usize| {
        move |kind: &LineKind| match kind {
            LineKind::Line { row: own, .. } | LineKind::Riser { row: own } => *own == row,
            LineKind::Tape(_) => false,
        }
    };
    let rows = 0..wing.built.row_names.len();
    let riser_load = |row: usize| {
        let kinds = wing.built.line_kinds.iter().zip(tensions);
        let own = kinds.filter(|(kind, _)| **kind == LineKind::Riser { row });
        own.map(|(_, tension)| *tension).sum()
    };
    let largest = |part: Part| {
        let own = wing.built.tags.iter().enumerate();
        let own = own.filter(|(_, tag)| tag.part == part);
        let stresses = own.map(|(triangle, _)| (triangle, step.stress_pa[triangle]));
        stresses.fold(
            (0, 0.0),
            |best, next| if next.1 > best.1 { next } else { best },
        )
    };
    LoadReading {
        load_factor: step.load_factor,
        riser_forces_n: step.riser_forces_n.map(DVec3::length),
        row_loads_n: rows.clone().map(riser_load).collect(),
        rows: rows
            .map(|row| nearest_of(wing, tensions, of_row(row)))
            .collect(),
        nearest: nearest_of(wing, tensions, |_| true),
        stresses: parts(wing).into_iter().map(largest).collect(),
        projected_area_m2: projected_area_m2(wing, &step.positions_m),
    }
}

/// Where the first line breaks.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstFailure {
    /// Load factor, interpolated between the steps.
    pub load_factor: f64,
    /// Number of its cable.
    pub cable: usize,
}

/// The load factor at which a line first reaches its breaking load, linear between steps; `None` if none does.
#[must_use]
pub fn first_failure(wing: &Wing, steps: &[LoadStep]) -> Option<FirstFailure> {
    let share = |step: &LoadStep, cable: usize| {
        let breaking = wing.breaking_loads_n[cable]?;
        Some(step.cable_tensions_n[cable] / breaking)
    };
    let first = steps.first()?;
    let broken_at_once = (0..wing.breaking_loads_n.len())
        .find(|cable| share(first, *cable).is_some_and(|s| s >= 1.0));
    if let Some(cable) = broken_at_once {
        return Some(FirstFailure {
            load_factor: first.load_factor,
            cable,
        });
    }
    steps.windows(2).find_map(|pair| {
        let crossing = |cable: usize| {
            let (low, high) = (share(&pair[0], cable)?, share(&pair[1], cable)?);
            (high >= 1.0).then(|| {
                let t = (1.0 - low) / (high - low);
                let load_factor =
                    pair[0].load_factor + t * (pair[1].load_factor - pair[0].load_factor);
                FirstFailure { load_factor, cable }
            })
        };
        (0..wing.breaking_loads_n.len())
            .filter_map(crossing)
            .min_by(|a, b| a.load_factor.total_cmp(&b.load_factor))
    })
}

/// Names of the lines.
#[must_use]
pub fn line_names(wing: &Wing, designed: &Structure) -> Vec<LineName> {
    let cables: Vec<[u32; 2]> = designed.cables.iter().map(|c| c.nodes).collect();
    wing_lines::names(wing, &cables, &designed.positions_m)
}

/// Sum of the breaking loads of a level counted from the risers up, from 0, brakes left out [N]; `None` where one of them is not told, or the level has
/// no lines.
fn strength_of_level_n(wing: &Wing, level: usize) -> Option<f64> {
    let wing_rows = &wing.built.row_names;
    let depths: Vec<usize> = (0..wing_rows.len())
        .map(|row| {
            let of_row = wing
                .built
                .line_kinds
                .iter()
                .filter_map(move |kind| match kind {
                    LineKind::Line { row: own, level } if *own == row => Some(level + 1),
                    _ => None,
                });
            of_row.max().unwrap_or(0)
        })
        .collect();
    let kinds = wing.built.line_kinds.iter().zip(&wing.breaking_loads_n);
    let own: Vec<Option<f64>> = kinds
        .filter(|(kind, _)| match kind {
            LineKind::Line { row, level: own } => {
                wing.plan.rows[*row].position < 1.0 && depths[*row] - 1 - own == level
            }
            _ => false,
        })
        .map(|(_, breaking)| *breaking)
        .collect();
    if own.is_empty() {
        return None;
    }
    own.into_iter().sum()
}

results! {
    /// Of the last load, but for the first failure.
    RESULTS: "Load tests of wings";
    LOAD_FACTOR_MAX: "load_test_load_factor_max", "1", "largest multiple of the loads in flight";
    FIRST_FAILURE: "load_test_first_failure_load_factor", "1", "multiple at which a line or tape first reaches its breaking load; EN 926-1 asks for 8 on the test rig";
    NEAREST: "load_test_line_load_over_breaking_load_max", "1", "load over breaking load of the line or tape nearest to breaking";
    ROW_NEAREST: "load_test_row_{row}_load_over_breaking_load_max", "1", "the same of a row";
    RISER_FORCE: "load_test_riser_force_n", "N", "force of the risers, both halves";
    PART_STRESS: "load_test_{part}_stress_max_pa", "Pa", "largest stress of the part";
    AREA_RATIO: "load_test_projected_area_ratio", "1", "area seen from above over that in flight; last step over flight, chords seen from above";
    LEVEL_STRENGTH: "line_strength_level_{level}_over_weight", "1",
        "strength of a level of lines; sum of breaking loads, counted from the risers up, brakes left out, over the weight in flight; EN 926-1 asks for 14 after bending";
}

/// Adds the results of a load test; without steps their names alone.
pub(super) fn results(
    results: &mut Results,
    wing: &Wing,
    designed: &Structure,
    gravity_m_s2: f64,
    state: Option<&LoadTest>,
) {
    let steps = state.map_or(&[][..], |state| &state.steps);
    let names = line_names(wing, designed);
    let last = steps.last().map(|step| read(wing, step));
    let untested = "no load test was done";
    let told = "no line material tells its breaking_load_n";
    let mut insert = |read_out: &ReadOut, value: Option<(f64, String)>, why: &str| {
        let quantity = match value {
            Some((value, note)) => Quantity::new(value).with_note(&note),
            None => Quantity::missing(why),
        };
        results.insert(read_out, quantity);
    };
    let factor = last.as_ref().map(|reading| reading.load_factor);
    insert(
        &LOAD_FACTOR_MAX,
        factor.map(|f| (f, "last step; multiple of the loads in flight".to_owned())),
        untested,
    );
    let failure = first_failure(wing, steps);
    let unbroken = last.as_ref().map_or_else(
        || untested.to_owned(),
        |reading| match &reading.nearest {
            Some(nearest) => format!(
                "no line reaches its breaking load up to {}; nearest is {} with {:.2} of it",
                reading.load_factor,
                names[nearest.cable].text(),
                nearest.share
            ),
            None => told.to_owned(),
        },
    );
    insert(
        &FIRST_FAILURE,
        failure.map(|f| {
            let name = names[f.cable].text();
            let note = format!("{name}; between steps; EN 926-1 asks for 8 on the test rig");
            (f.load_factor, note)
        }),
        &unbroken,
    );
    let as_quantity = |nearest: &Option<Nearest>| {
        let nearest = nearest.as_ref()?;
        Some((nearest.share, names[nearest.cable].text()))
    };
    let why = if last.is_some() { told } else { untested };
    let nearest = last
        .as_ref()
        .and_then(|reading| as_quantity(&reading.nearest));
    insert(&NEAREST, nearest, why);
    for (row, name) in wing.built.row_names.iter().enumerate() {
        let nearest = last.as_ref().and_then(|r| as_quantity(&r.rows[row]));
        insert(&ROW_NEAREST.of(name), nearest, why);
    }
    let riser = last.as_ref().map(|r| r.riser_forces_n.iter().sum::<f64>());
    let note = || "both halves, last step".to_owned();
    insert(&RISER_FORCE, riser.map(|force| (force, note())), untested);
    for (number, part) in parts(wing).into_iter().enumerate() {
        let stress = last.as_ref().map(|reading| {
            let (triangle, stress) = reading.stresses[number];
            (stress, place(wing, &wing.built.tags[triangle]))
        });
        insert(&PART_STRESS.of(key(part)), stress, untested);
    }
    let first = steps.first().map(|step| read(wing, step));
    let ratio = first.zip(last).map(|(first, last)| {
        let ratio = last.projected_area_m2 / first.projected_area_m2;
        (ratio, AREA_RATIO.detail().unwrap_or_default().to_owned())
    });
    insert(&AREA_RATIO, ratio, untested);
    strengths(results, wing, designed, gravity_m_s2);
}

/// What EN 926-1 computes of breaking loads alone.
fn strengths(results: &mut Results, wing: &Wing, designed: &Structure, gravity_m_s2: f64) {
    let Some(settings) = &wing.trim else {
        return;
    };
    let mass: f64 = designed.masses_kg.iter().sum::<f64>() + settings.pilot_mass_kg;
    let weight_n = mass * gravity_m_s2;
    for level in 0.. {
        let has_lines = wing
            .built
            .line_kinds
            .iter()
            .any(|kind| matches!(kind, LineKind::Line { level: own, .. } if *own == level));
        if !has_lines {
            break;
        }
        results.insert(
            &LEVEL_STRENGTH.of(level + 1),
            match strength_of_level_n(wing, level) {
                Some(strength) => Quantity::told(&LEVEL_STRENGTH, strength / weight_n),
                None => Quantity::missing("a line of the level does not tell its breaking_load_n"),
            },
        );
    }
}
