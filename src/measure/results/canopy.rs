//! Results of a canopy in air: drag by three routes and its correction for walls.

use super::{canopy_shape, column_max, largest, quantity};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Canopy, Flow};
use crate::measure::blockage::THREE_DIMENSIONS;
use crate::measure::record::largest as largest_of;
use crate::measure::statistics::Mean;
use crate::measure::steady::{self, SETTLING, SHORTEST_WINDOW, Window};
use crate::measure::{Record, bodies};
use crate::output::{Quantity, Results, Supports};

/// As close as times of samples come [D₀/U].
const ROUND_OFF: f64 = 1e-6;

/// Drag coefficient below which relative differences of forces mean nothing.
const NO_DRAG: f64 = 1e-3;

/// How long a run of a canopy or of rigid bodies in the wind of a tunnel is, and from when on means are taken; `None` of other scenes.
#[must_use]
pub fn averaging(scene: &Scene) -> Option<String> {
    if scene.body.is_none() {
        return bodies::averaging(scene);
    }
    let (Some(air), Some(body), Some(time)) = (&scene.air, &scene.body, &scene.time) else {
        return None;
    };
    let (BodyKind::Canopy(canopy), Flow::WindTunnel { speed_m_s, .. }) = (&body.kind, air.flow)
    else {
        return None;
    };
    (speed_m_s > 0.0 && scene.descent.is_none()).then(|| {
        format!(
            "length of the run {:.1} D_0/U; means begin {SETTLING} D_0/U after the first peak of the diameter, when the wake has settled, and need {SHORTEST_WINDOW}",
            time.end_s * speed_m_s / canopy.nominal_diameter_m
        )
    })
}

/// Means over the settled window, extremes and times since release.
pub(super) fn results(results: &mut Results, record: &Record, canopy: &Canopy, air: &Air) {
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let Some(window) = steady::window(record, unit_s) else {
        results.insert(
            "drag_coefficient",
            Quantity::missing("1", "the run ended before release"),
        );
        return;
    };
    let indicative = (!window.settled || window.length < SHORTEST_WINDOW - ROUND_OFF).then(|| {
        format!(
            "window of {:.1} D_0/U{}; {SHORTEST_WINDOW} after settling are needed: means of this run are indicative only",
            window.length,
            match (window.settled, window.opened) {
                (true, _) => "",
                (false, true) => ", wake not settled",
                (false, false) => ", opening not over",
            }
        )
    });
    let mean = |name: &str| steady::mean(record, name, &window);
    let drag = mean("drag_coefficient");
    let mut drag_quantity = quantity(drag, "1");
    if let Some(note) = &indicative {
        drag_quantity = drag_quantity.with_note(note);
    }
    let wind = matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0);
    results.insert(
        "drag_coefficient",
        if wind {
            drag_quantity
        } else {
            Quantity::missing("1", "there is no wind to refer to")
        },
    );
    if matches!(air.flow, Flow::WindTunnel { .. }) {
        blockage_results(results, canopy, air, drag, wind);
    }
    let ratio = mean("projected_diameter_ratio");
    results.insert("projected_diameter_ratio", quantity(ratio, "1"));
    let ratios = record.column("projected_diameter_ratio");
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    results.insert(
        "projected_diameter_ratio_at_release",
        Quantity::new(ratios[released], "1"),
    );
    canopy_shape::results(results, record, &window, (released, unit_s));
    largest(results, record, released, "line_tension_max_n", "N");
    let force = 0.5
        * air.units.density_kg_m3
        * air.wind_or_reference_m_s().powi(2)
        * canopy.nominal_area_m2;
    results.insert(
        "drag_n",
        Quantity::new(drag.value * force, "N")
            .with_note("mean drag coefficient times dynamic pressure and S_0"),
    );
    let peak = column_max(record, "drag_coefficient", released);
    if wind {
        let factor = Quantity::new(peak.1 / drag.value, "1").with_note(&format!(
            "C_x: largest drag of a sample interval, at {:.4} s, over the mean drag",
            peak.0
        ));
        results.insert(
            "opening_force_factor",
            match drag.confidence {
                Some(confidence) => {
                    factor.with_confidence(peak.1 * confidence / (drag.value * drag.value))
                }
                None => factor,
            },
        );
    }
    insert_balances(results, record, &window, released, drag.value);
    if indicative.is_some() {
        let means = results.iter_mut();
        for (_, mean) in means.filter(|(name, _)| Supports::Means.covers(name)) {
            mean.mark_unresolved("the wake has not settled");
        }
    }
}

/// Drag coefficient without the walls of the tunnel, by Macha & Buffington (1990), "Wall-interference corrections for parachutes in a
/// closed wind tunnel", J. Aircraft 27: q_corrected/q = 1 + K C_D S_0/C, C the section. Their K holds for steady drag of inflated
/// canopies between solid walls; ours are frictionless, which takes no drag away.
fn blockage_results(results: &mut Results, canopy: &Canopy, air: &Air, drag: Mean, wind: bool) {
    let section = air.cells[1] as f64 * air.cells[2] as f64 * air.units.cell_size_m.powi(2);
    let blockage = canopy.nominal_area_m2 / section;
    let ratio = 1.0 + THREE_DIMENSIONS * drag.value * blockage;
    let corrected = Mean {
        value: drag.value / ratio,
        confidence: drag.confidence.map(|c| c / (ratio * ratio)),
    };
    let missing = || Quantity::missing("1", "there is no wind to refer to");
    results.insert(
        "drag_coefficient_blockage_corrected",
        if wind {
            quantity(corrected, "1")
                .with_note("Macha & Buffington 1990, factor 1.85 on C_D S_0 / section")
        } else {
            missing()
        },
    );
    results.insert(
        "dynamic_pressure_ratio_of_blockage",
        if wind {
            Quantity::new(ratio, "1").with_note("what the correction divides the drag by")
        } else {
            missing()
        },
    );
    results.insert(
        "blockage_ratio",
        Quantity::new(blockage, "1").with_note("nominal area over section"),
    );
}

fn insert_balances(
    results: &mut Results,
    record: &Record,
    window: &Window,
    released: usize,
    drag_coefficient: f64,
) {
    let times = record.column("time_s");
    // A row's drag is that of the interval before it, so the impulses count from the row before the window.
    let (first, last) = (window.first.saturating_sub(1), window.end - 1);
    let span = times[last] - times[first];
    let routes = [
        "impulse_markers_n_s",
        "impulse_momentum_box_n_s",
        "impulse_lines_n_s",
    ]
    .map(|name| {
        let impulse = record.column(name);
        (impulse[last] - impulse[first]) / span
    });
    let [markers, momentum_box, lines] = routes;
    for (name, force, what) in [
        ("drag_markers_n", markers, "sum over markers"),
        (
            "drag_momentum_box_n",
            momentum_box,
            "populations through a box, with storage",
        ),
        (
            "drag_lines_n",
            lines,
            "line tensions plus the sheet's own momentum",
        ),
    ] {
        results.insert(name, Quantity::new(force, "N").with_note(what));
    }
    let spread = [
        markers - momentum_box,
        markers - lines,
        momentum_box - lines,
    ]
    .into_iter()
    .fold(0.0, |worst: f64, difference| {
        if difference.is_nan() {
            f64::NAN
        } else {
            worst.max(difference.abs())
        }
    });
    let imbalance = if spread.is_nan() {
        Quantity::missing("1", "the fabric left the momentum box, or is held directly")
    } else if drag_coefficient.abs() < NO_DRAG {
        Quantity::missing("1", "there is no drag to compare with")
    } else {
        Quantity::new(spread / markers.abs(), "1")
            .with_note("largest difference of the three routes over the drag")
    };
    results.insert("force_imbalance", imbalance);
    results.insert(
        "slip_mean",
        quantity(steady::mean(record, "slip_ratio", window), "1"),
    );
    let defect = largest_of(
        record.column("mass_defect")[released..]
            .iter()
            .map(|d| d.abs()),
    );
    results.insert(
        "mass_drift",
        Quantity::new(defect, "1")
            .with_note("largest defect of the mass balance of the momentum box, over its mass"),
    );
}
