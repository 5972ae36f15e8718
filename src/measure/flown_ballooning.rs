//! Ballooning as it is flown: how far panels stand out between their ribs, as the share by which a circular arc is longer than its chord.
//!
//! Read from the height h of a panel's middle over the straight line between its ribs, a distance w apart: θ = 2 atan(2h/w), b = θ/sin θ − 1, the inverse of how
//! panels are drawn. A mean over all cells, weighted by their area. Where mini-ribs hold the middle, over openings and at the trailing edge there is nothing
//! to read.

use glam::DVec3;

use super::read_out::results;
use crate::case::wing::Wing;
use crate::case::wing_design::Ballooning;
use crate::geometry::table::lookup;
use crate::geometry::wing::section::Side;
use crate::output::{Quantity, Results};
use crate::statics::ShapingStep;

/// Ballooning whose middle stands out by a share of the width; negative inwards.
#[must_use]
fn of_height(height: f64) -> f64 {
    let angle = 2.0 * (2.0 * height.abs()).atan();
    if angle < 1e-6 {
        return height.signum() * angle * angle / 6.0;
    }
    (angle / angle.sin() - 1.0) * height.signum()
}

/// Height of the middle of a cell's panel over the width at place `k` of the outline; `None` where there is no node, or a mini-rib.
fn height(wing: &Wing, positions_m: &[DVec3], cell: usize, k: usize) -> Option<f64> {
    let count = wing.built.outlines[cell].len();
    let place = |rib: usize, k: usize| positions_m[wing.built.outlines[rib][k % count] as usize];
    let across = &wing.built.rows_across[cell][k];
    let middle = positions_m[*across.get(across.len() / 2)? as usize];
    let (left, right) = (place(cell, k), place(cell + 1, k));
    let along = |rib: usize| place(rib, k + 1) - place(rib, k + count - 1);
    let span = right - left;
    let out = (along(cell) + along(cell + 1))
        .cross(span)
        .normalize_or_zero();
    Some((middle - 0.5 * (left + right)).dot(out) / span.length())
}

/// Ballooning of both sides for positions of the mesh [m]: points [x/c, b].
#[must_use]
pub fn flown_ballooning(wing: &Wing, positions_m: &[DVec3]) -> Ballooning {
    let count = wing.built.outlines[0].len();
    let tail = count / 2;
    let held_from = wing.plan.mini_ribs_from.unwrap_or(1.0);
    [Side::Upper, Side::Lower].map(|side| {
        let places = wing.built.places.of(side);
        // Mini-ribs begin at the node nearest to their place.
        let last = wing.built.places.nearest(side, held_from).min(tail);
        (1..last)
            .filter_map(|j| {
                let k = if side == Side::Upper { j } else { count - j };
                let (mut sum, mut weight) = (0.0, 0.0);
                for (cell, pair) in wing.built.frames.windows(2).enumerate() {
                    let area =
                        (pair[1].span_m - pair[0].span_m) * (pair[0].chord_m + pair[1].chord_m);
                    if let Some(height) = height(wing, positions_m, cell, k) {
                        sum += area * of_height(height);
                        weight += area;
                    }
                }
                (weight > 0.0).then(|| [places[j], sum / weight])
            })
            .collect()
    })
}

/// Distances of neighbouring ribs over the designed ones, means over the cells by area, where there are panels between nose and trailing edge: points
/// [x/c, ratio] of both sides.
#[must_use]
pub fn width_ratios(wing: &Wing, designed_m: &[DVec3], flown_m: &[DVec3]) -> Ballooning {
    let count = wing.built.outlines[0].len();
    let distance = |positions_m: &[DVec3], cell: usize, k: usize| {
        let [a, b] = [cell, cell + 1].map(|rib| positions_m[wing.built.outlines[rib][k] as usize]);
        a.distance(b)
    };
    [Side::Upper, Side::Lower].map(|side| {
        let places = wing.built.places.of(side);
        (1..count / 2)
            .filter_map(|j| {
                let k = if side == Side::Upper { j } else { count - j };
                let (mut sum, mut weight) = (0.0, 0.0);
                for (cell, pair) in wing.built.frames.windows(2).enumerate() {
                    if wing.built.rows_across[cell][k].is_empty() {
                        continue;
                    }
                    let area =
                        (pair[1].span_m - pair[0].span_m) * (pair[0].chord_m + pair[1].chord_m);
                    sum += area * distance(flown_m, cell, k) / distance(designed_m, cell, k);
                    weight += area;
                }
                (weight > 0.0).then(|| [places[j], sum / weight])
            })
            .collect()
    })
}

/// Largest difference, and root of the mean square, of tables over the chord from others; `None`: from 1.
#[must_use]
pub fn differences(flown: &Ballooning, target: Option<&Ballooning>) -> [f64; 2] {
    let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
    for (side, points) in flown.iter().enumerate() {
        for [x, b] in points {
            let error = b - target.map_or(1.0, |target| lookup(&target[side], *x));
            largest = largest.max(error.abs());
            sum += error * error;
            count += 1.0;
        }
    }
    [largest, f64::sqrt(sum / f64::max(count, 1.0))]
}

results! {
    /// Before the first change of the panels, and after the last.
    RESULTS: "Panel shaping";
    ERROR_MAX: "panel_shaping_error_max_{when}", "1",
        "largest error of the shaped panels; largest difference of what is aimed at: flown ballooning, or distance of ribs over the designed one";
    ERROR_RMS: "panel_shaping_error_rms_{when}", "1", "mean error of the shaped panels; root of the mean square of it";
    CELL_WIDTH: "panel_shaping_cell_width_over_designed_{when}", "1", "width of the cells over the design; distance of neighbouring ribs, mean";
    CHANGES: "panel_shaping_changes", "1", "changes of the panels";
}

/// A number of a step.
type OfStep = fn(&ShapingStep) -> f64;

/// Adds the results of a panel shaping; without steps their names alone.
pub(super) fn results(results: &mut Results, steps: &[ShapingStep]) {
    let pair = steps.first().zip(steps.last());
    let of: [(_, OfStep); 3] = [
        (&ERROR_MAX, |step| step.error_max),
        (&ERROR_RMS, |step| step.error_rms),
        (&CELL_WIDTH, |step| step.cell_width_ratio),
    ];
    for (read_out, of) in of {
        for (when, step) in [("before", pair.map(|p| p.0)), ("after", pair.map(|p| p.1))] {
            let quantity = match step {
                Some(step) => Quantity::told(read_out, of(step)),
                None => Quantity::missing("no panels were shaped"),
            };
            results.insert(&read_out.of(when), quantity);
        }
    }
    let changes = steps.len().saturating_sub(1);
    results.insert(&CHANGES, Quantity::new(changes as f64));
}
