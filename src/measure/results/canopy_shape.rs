//! Results of a canopy's shape and stresses, times of its inflation, breathing and flapping.

use super::filling::{FULL_SHARE, filling};
use super::{column_max, largest, quantity};
use crate::measure::Record;
use crate::measure::spectrum::{Spectrum, oscillation, periodogram};
use crate::measure::steady::{self, Window};
use crate::output::{Quantity, Results};

/// Depth of the apex below the farthest node downstream, over the height of the canopy, from which its top counts as collapsed.
const COLLAPSED: f64 = 0.05;

/// Columns whose mean over the window is a result of the same name.
const MEANS: [(&str, &str); 19] = [
    ("height_m", "m"),
    ("height_to_projected_diameter", "1"),
    ("projected_area_m2", "m2"),
    ("fabric_area_m2", "m2"),
    ("vent_radius_m", "m"),
    ("edge_distance_m", "m"),
    ("edge_distance_min_m", "m"),
    ("edge_distance_max_m", "m"),
    ("wrinkle_height_m", "m"),
    ("wrinkle_height_max_m", "m"),
    ("wrinkle_height_asymmetry", "1"),
    ("wrinkle_radius_m", "m"),
    ("wrinkle_angle_deg", "deg"),
    ("gap_width_m", "m"),
    ("slot_width_m", "m"),
    ("line_tension_mean_n", "N"),
    ("line_tension_asymmetry", "1"),
    ("line_tension_lower_mean_n", "N"),
    ("line_tension_upper_mean_n", "N"),
];

/// Columns of extremes over the fabric: the largest of the run under their own name, and their mean over the window as `…_steady`.
const EXTREMES: [(&str, &str, &str); 12] = [
    ("stress_max_pa", "stress_max_steady_pa", "Pa"),
    ("von_mises_max_pa", "von_mises_max_steady_pa", "Pa"),
    ("vent_stress_max_pa", "vent_stress_max_steady_pa", "Pa"),
    ("shear_stress_max_pa", "shear_stress_max_steady_pa", "Pa"),
    ("shear_stress_min_pa", "shear_stress_min_steady_pa", "Pa"),
    ("shear_strain_max", "shear_strain_max_steady", "1"),
    ("shear_strain_min", "shear_strain_min_steady", "1"),
    (
        "principal_strain_1_max",
        "principal_strain_1_max_steady",
        "1",
    ),
    (
        "principal_strain_1_min",
        "principal_strain_1_min_steady",
        "1",
    ),
    (
        "principal_strain_2_max",
        "principal_strain_2_max_steady",
        "1",
    ),
    (
        "principal_strain_2_min",
        "principal_strain_2_min_steady",
        "1",
    ),
    ("slot_width_max_m", "slot_width_max_steady_m", "m"),
];

/// Everything of the shape; from the sample of the release on, with D₀/U [s].
pub(super) fn results(
    results: &mut Results,
    record: &Record,
    window: &Window,
    (released, unit_s): (usize, f64),
) {
    let has = |name: &str| record.columns().contains(&name);
    inflation(results, record, released, unit_s);
    for (name, unit) in MEANS.into_iter().filter(|(name, _)| has(name)) {
        results.insert(name, quantity(steady::mean(record, name, window), unit));
    }
    line_sides(results, record, window);
    for (name, steady_name, unit) in EXTREMES.into_iter().filter(|(name, _, _)| has(name)) {
        if name.contains("_min") {
            let lowest = record.column(name)[released..]
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
            results.insert(
                name,
                Quantity::new(lowest, unit).with_note("smallest of the run"),
            );
        } else {
            largest(results, record, released, name, unit);
        }
        results.insert(
            steady_name,
            quantity(steady::mean(record, name, window), unit)
                .with_note("mean over the window of the extreme over the fabric"),
        );
    }
    oscillations(results, record, window);
}

/// Times of the stages of inflation. Each is known to the interval between samples.
fn inflation(results: &mut Results, record: &Record, released: usize, unit_s: f64) {
    let times = record.column("time_s");
    let ratios = record.column("projected_diameter_ratio");
    let interval = (times[times.len() - 1] - times[released]) / (times.len() - 1 - released) as f64;
    let at = |time: f64| Quantity::new(time, "s").with_sampling_error(interval);
    let unseen = "no peak of the projected diameter yet: the canopy was not seen full";
    let of = |diameters: &[f64]| filling(&times[released..], &diameters[released..], unit_s);
    let filled = of(&ratios);
    let known = |time: Option<f64>| match time.filter(|_| filled.is_some()) {
        Some(time) => at(time),
        None => Quantity::missing("s", unseen),
    };
    let share = 100.0 * FULL_SHARE;
    results.insert(
        "fill_time_s",
        known(filled.map(|filled| filled.time_s))
            .with_note(&format!("projected area at {share:.0} % of its first peak")),
    );
    let top = of(&record.column("top_projected_diameter_ratio"));
    results.insert(
        "top_open_time_s",
        known(top.map(|top| top.time_s)).with_note(&format!(
            "projected area of the inner half of the canopy at {share:.0} % of its first peak"
        )),
    );
    let peak = filled.map(|filled| released + filled.peak);
    results.insert("first_peak_time_s", known(peak.map(|peak| times[peak])));
    results.insert(
        "first_peak_projected_diameter_ratio",
        peak.map_or_else(
            || Quantity::missing("1", unseen),
            |peak| Quantity::new(ratios[peak], "1"),
        ),
    );
    let (time, ratio) = column_max(record, "projected_diameter_ratio", released);
    results.insert("largest_projected_diameter_time_s", known(Some(time)));
    results.insert(
        "largest_projected_diameter_ratio",
        Quantity::new(ratio, "1").with_note("largest of the run"),
    );
    let sample = times.iter().position(|&t| t == time).unwrap_or(released);
    let depth = record.column("apex_dent_m")[sample];
    let height = record.column("height_m")[sample];
    results.insert(
        "apex_dent_at_largest_diameter_m",
        Quantity::new(depth, "m").with_note(&format!(
            "apex upstream of the farthest node downstream; the top is {}collapsed then (from {:.0} % of the height on)",
            if depth > COLLAPSED * height { "" } else { "not " },
            100.0 * COLLAPSED
        )),
    );
    let (time, area) = column_max(record, "fabric_area_m2", released);
    results.insert(
        "fabric_area_max_m2",
        Quantity::new(area, "m2")
            .with_note(&format!("stretched; largest of the run, at {time:.4} s")),
    );
    let (time, depth) = column_max(record, "apex_dent_m", released);
    results.insert(
        "apex_dent_max_m",
        Quantity::new(depth, "m").with_note(&format!("largest of the run, at {time:.4} s")),
    );
    results.insert("apex_dent_max_time_s", known(Some(time)));
}

/// Mean tension of the lines of both sides: first and second half of the lines in the order of their azimuth.
fn line_sides(results: &mut Results, record: &Record, window: &Window) {
    let Some(canopy) = record.canopy() else {
        return;
    };
    let count = canopy.outline().lines.len();
    if count < 4 || !count.is_multiple_of(2) {
        return;
    }
    let side = |lines: std::ops::RangeInclusive<usize>| {
        let number = lines.clone().count() as f64;
        let sum: f64 = lines
            .map(|k| steady::mean(record, &format!("line_{k:02}_tension_n"), window).value)
            .sum();
        sum / number
    };
    for (name, lines) in [
        ("line_tension_mean_side_1_n", 1..=count / 2),
        ("line_tension_mean_side_2_n", count / 2 + 1..=count),
    ] {
        let note = format!("lines {} to {}", lines.start(), lines.end());
        results.insert(name, Quantity::new(side(lines), "N").with_note(&note));
    }
}

/// Time between samples of the window.
fn sample_interval(record: &Record, window: &Window) -> f64 {
    let times = record.column("time_s");
    (times[window.end - 1] - times[window.first]) / (window.end - 1 - window.first).max(1) as f64
}

/// Breathing of the projected diameter, and flapping of the skirt.
fn oscillations(results: &mut Results, record: &Record, window: &Window) {
    let interval = sample_interval(record, window);
    let diameter = &record.column("projected_diameter_ratio")[window.first..window.end];
    let found = if window.opened {
        oscillation(diameter, interval)
    } else {
        Err("the opening was not over")
    };
    match found {
        Ok(found) => {
            results.insert(
                "breathing_period_s",
                Quantity::new(found.period, "s")
                    .with_sampling_error(found.period_error)
                    .with_note("strongest frequency of D_p/D_0; ± half a line of its spectrum"),
            );
            results.insert(
                "breathing_amplitude",
                Quantity::new(found.amplitude, "1")
                    .with_note("of D_p/D_0, sine of the same variance"),
            );
        }
        Err(why) => {
            results.insert("breathing_period_s", Quantity::missing("s", why));
            results.insert("breathing_amplitude", Quantity::missing("1", why));
        }
    }
    if record.canopy().is_some_and(|canopy| {
        canopy
            .detail_columns()
            .iter()
            .any(|name| name.ends_with("_skirt_radius_m"))
    }) {
        let spectrum = skirt_spectrum(record, window);
        let dominant = spectrum.as_ref().and_then(Spectrum::dominant);
        results.insert(
            "skirt_flapping_frequency_hz",
            match (dominant, &spectrum) {
                (Some(frequency), Some(spectrum)) => Quantity::new(frequency, "Hz")
                    .with_sampling_error(0.5 * spectrum.frequencies[0])
                    .with_note(&format!(
                        "strongest frequency of the gores' skirt radii less their mean; samples show up to {:.0} Hz",
                        0.5 / interval
                    )),
                _ => Quantity::missing("Hz", "the opening was not over, or too few samples"),
            },
        );
    }
}

/// Spectrum of the middle of every gore's skirt, as it moves outward and inward against the mean of all, averaged over the gores.
/// `None` before the opening is over.
pub(super) fn skirt_spectrum(record: &Record, window: &Window) -> Option<Spectrum> {
    if !window.opened {
        return None;
    }
    let gores = record.canopy()?.outline().gores.len();
    let radii: Vec<Vec<f64>> = (1..=gores)
        .map(|k| {
            let column = record.column(&format!("gore_{k:02}_skirt_radius_m"));
            column.get(window.first..window.end).map(<[f64]>::to_vec)
        })
        .collect::<Option<_>>()?;
    let interval = sample_interval(record, window);
    let spectra: Vec<Spectrum> = radii
        .iter()
        .map(|own| {
            let relative: Vec<f64> = (0..own.len())
                .map(|i| own[i] - radii.iter().map(|r| r[i]).sum::<f64>() / gores as f64)
                .collect();
            periodogram(&relative, interval)
        })
        .collect::<Option<_>>()?;
    Spectrum::mean_of(&spectra)
}
