//! The opening of a canopy: times of its stages, sides of its lines; then breathing and flapping.

use super::canopy_shape::{
    APEX_DENT, CanopyShape, FABRIC_AREA, GORE_SKIRT_RADIUS, ONE_LINE_TENSION, TOP_DIAMETER_RATIO,
};
use super::filling::{FULL_SHARE, filling};
use super::read_out::results;
use super::record::Record;
use super::reduce::column_max;
use super::shared::{FILL_TIME, HEIGHT, PROJECTED_DIAMETER_RATIO, TIME};
use super::spectrum::{Spectrum, oscillation, periodogram};
use super::steady::{self, Window};
use crate::case::Scene;
use crate::case::scene::BodyKind;
use crate::output::{Quantity, Results};

/// Depth of the apex below the farthest node downstream, over the height of the canopy, from which its top counts as collapsed.
const COLLAPSED: f64 = 0.05;

results! {
    /// Of the opening, and of what follows it.
    RESULTS: "Canopies in air: opening, breathing and flapping";
    TOP_OPEN_TIME: "top_open_time_s", "s", "time until the inner half of the canopy is full";
    FIRST_PEAK_TIME: "first_peak_time_s", "s", "time of the first peak of the projected diameter";
    FIRST_PEAK_RATIO: "first_peak_projected_diameter_ratio", "1", "projected over nominal diameter at its first peak";
    LARGEST_TIME: "largest_projected_diameter_time_s", "s", "time of the largest projected diameter";
    LARGEST_RATIO: "largest_projected_diameter_ratio", "1", "largest projected over nominal diameter";
    DENT_AT_LARGEST: "apex_dent_at_largest_diameter_m", "m", "depth of the apex upstream of the farthest node downstream, at the largest diameter";
    FABRIC_AREA_MAX: "fabric_area_max_m2", "m2", "largest area of the fabric; stretched";
    DENT_MAX: "apex_dent_max_m", "m", "largest depth of the apex";
    DENT_MAX_TIME: "apex_dent_max_time_s", "s", "time of the largest depth of the apex";
    TENSION_SIDE_1: "line_tension_mean_side_1_n", "N", "mean tension of the first half of the lines; in the order of their azimuth";
    TENSION_SIDE_2: "line_tension_mean_side_2_n", "N", "mean tension of the second half of the lines";
    BREATHING_PERIOD: "breathing_period_s", "s", "period of the strongest frequency of the projected diameter";
    BREATHING_AMPLITUDE: "breathing_amplitude", "1", "amplitude of the projected over the nominal diameter; of the sine of the same variance";
    FLAPPING_FREQUENCY: "skirt_flapping_frequency_hz", "Hz", "strongest frequency of the gores' skirt radii less their mean";
}

/// Times of the stages of inflation. Each is known to the interval between samples. `ways` are those of the air past the canopy since release until each
/// sample from there on, in D₀.
pub(super) fn inflation(results: &mut Results, record: &Record, released: usize, ways: &[f64]) {
    let times = record.column(&TIME);
    let ratios = record.column(&PROJECTED_DIAMETER_RATIO);
    let interval = (times[times.len() - 1] - times[released]) / (times.len() - 1 - released) as f64;
    let at = |time: f64| Quantity::new(time).with_sampling_error(interval);
    let unseen = "no peak of the projected diameter yet: the canopy was not seen full";
    let of = |diameters: &[f64]| filling(&times[released..], &diameters[released..], ways);
    let filled = of(&ratios);
    let known = |time: Option<f64>| match time.filter(|_| filled.is_some()) {
        Some(time) => at(time),
        None => Quantity::missing(unseen),
    };
    let share = 100.0 * FULL_SHARE;
    results.insert(
        &FILL_TIME,
        match &filled {
            Some(filled) if filled.time_s <= 0.0 => Quantity::missing("full from the start"),
            _ => known(filled.as_ref().map(|filled| filled.time_s)),
        }
        .with_note(&format!("projected area at {share:.0} % of its first peak")),
    );
    let top = of(&record.column(&TOP_DIAMETER_RATIO));
    results.insert(
        &TOP_OPEN_TIME,
        known(top.map(|top| top.time_s)).with_note(&format!(
            "projected area of the inner half of the canopy at {share:.0} % of its first peak"
        )),
    );
    let peak = filled.map(|filled| released + filled.peak);
    results.insert(&FIRST_PEAK_TIME, known(peak.map(|peak| times[peak])));
    results.insert(
        &FIRST_PEAK_RATIO,
        peak.map_or_else(
            || Quantity::missing(unseen),
            |peak| Quantity::new(ratios[peak]),
        ),
    );
    let (time, ratio) = column_max(record, &PROJECTED_DIAMETER_RATIO, released);
    results.insert(&LARGEST_TIME, known(Some(time)));
    results.insert(
        &LARGEST_RATIO,
        Quantity::new(ratio).with_note("largest of the run"),
    );
    let sample = times.iter().position(|&t| t == time).unwrap_or(released);
    let depth = record.column(&APEX_DENT)[sample];
    let height = record.column(&HEIGHT)[sample];
    results.insert(
        &DENT_AT_LARGEST,
        Quantity::new(depth).with_note(&format!(
            "apex upstream of the farthest node downstream; the top is {}collapsed then (from {:.0} % of the height on)",
            if depth > COLLAPSED * height { "" } else { "not " },
            100.0 * COLLAPSED
        )),
    );
    let (time, area) = column_max(record, &FABRIC_AREA, released);
    results.insert(
        &FABRIC_AREA_MAX,
        Quantity::new(area).with_note(&format!("stretched; largest of the run, at {time:.4} s")),
    );
    let (time, depth) = column_max(record, &APEX_DENT, released);
    results.insert(
        &DENT_MAX,
        Quantity::new(depth).with_note(&format!("largest of the run, at {time:.4} s")),
    );
    results.insert(&DENT_MAX_TIME, known(Some(time)));
}

/// Mean tension of the lines of both sides: first and second half of the lines in the order of their azimuth.
pub(super) fn line_sides(results: &mut Results, record: &Record, window: &Window) {
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
            .map(|k| steady::mean(record, &ONE_LINE_TENSION.of(format!("{k:02}")), window).value)
            .sum();
        sum / number
    };
    for (name, lines) in [
        (&TENSION_SIDE_1, 1..=count / 2),
        (&TENSION_SIDE_2, count / 2 + 1..=count),
    ] {
        let note = format!("lines {} to {}", lines.start(), lines.end());
        results.insert(name, Quantity::new(side(lines)).with_note(&note));
    }
}

/// Time between samples of the window.
fn sample_interval(record: &Record, window: &Window) -> f64 {
    let times = record.column(&TIME);
    (times[window.end - 1] - times[window.first]) / (window.end - 1 - window.first).max(1) as f64
}

/// Breathing of the projected diameter, and flapping of the skirt.
pub(super) fn oscillations(results: &mut Results, record: &Record, window: &Window) {
    let interval = sample_interval(record, window);
    let diameter = &record.column(&PROJECTED_DIAMETER_RATIO)[window.first..window.end];
    let found = if window.opened {
        oscillation(diameter, interval)
    } else {
        Err("the opening was not over")
    };
    match found {
        Ok(found) => {
            results.insert(
                &BREATHING_PERIOD,
                Quantity::new(found.period)
                    .with_sampling_error(found.period_error)
                    .with_note("strongest frequency of D_p/D_0; ± half a line of its spectrum"),
            );
            results.insert(
                &BREATHING_AMPLITUDE,
                Quantity::new(found.amplitude).with_note("of D_p/D_0, sine of the same variance"),
            );
        }
        Err(why) => {
            results.insert(&BREATHING_PERIOD, Quantity::missing(why));
            results.insert(&BREATHING_AMPLITUDE, Quantity::missing(why));
        }
    }
    if record.canopy().is_some_and(CanopyShape::has_wrinkles) {
        let spectrum = spectrum_of_skirt(record, window);
        let dominant = spectrum.as_ref().and_then(Spectrum::dominant);
        results.insert(
            &FLAPPING_FREQUENCY,
            match (dominant, &spectrum) {
                (Some(frequency), Some(spectrum)) => Quantity::new(frequency)
                    .with_sampling_error(0.5 * spectrum.frequencies[0])
                    .with_note(&format!(
                        "strongest frequency of the gores' skirt radii less their mean; samples show up to {:.0} Hz",
                        0.5 / interval
                    )),
                _ => Quantity::missing("the opening was not over, or too few samples"),
            },
        );
    }
}

/// Spectrum of the middle of every gore's skirt, as it moves outward and inward against the mean of all, averaged over the gores.
/// `None` before the opening is over.
fn spectrum_of_skirt(record: &Record, window: &Window) -> Option<Spectrum> {
    if !window.opened {
        return None;
    }
    let canopy = record.canopy().filter(|canopy| canopy.has_wrinkles())?;
    let gores = canopy.outline().gores.len();
    let radii: Vec<Vec<f64>> = (1..=gores)
        .map(|k| {
            let column = record.column(&GORE_SKIRT_RADIUS.of(format!("{k:02}")));
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

/// Rows of frequency [Hz] and power density [m² s] with which the skirt flaps, averaged over the gores; `None` where there is no canopy in
/// air, or before its opening is over.
#[must_use]
pub fn skirt_spectrum(scene: &Scene, record: &Record) -> Option<Vec<Vec<f64>>> {
    let (Some(body), Some(air)) = (&scene.body, &scene.air) else {
        return None;
    };
    let BodyKind::Canopy(canopy) = &body.kind else {
        return None;
    };
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let window = steady::window(record, unit_s)?;
    let spectrum = spectrum_of_skirt(record, &window)?;
    let pairs = spectrum.frequencies.iter().zip(&spectrum.densities);
    Some(pairs.map(|(f, density)| vec![*f, *density]).collect())
}
