//! What falls: columns of the history, and results.
//!
//! Coefficients of the history refer to the speed of release, which a fall soon leaves behind; those here to the speed of the moment. Means begin when
//! the wake has settled: as in a tunnel, so many lengths of air behind the first peak of the diameter, here lengths that were fallen.

use super::impulses::Impulses;
use super::line_drag::LINE_DRAG;
use super::read_out::Reduction::{LargestAs, Last, Mean as MeanOf};
use super::read_out::{ReadOut, When, columns, results};
use super::record::Record;
use super::reduce::{column_max, quantity, released};
use super::shared::{PROJECTED_DIAMETER_RATIO, TIME};
use super::statistics::{Mean, first_peak, mean_of, slope};
use super::steady::{BATCH, SETTLING, SHORTEST_WINDOW};
use crate::case::Scene;
use crate::case::scene::{BodyKind, Carrier, Descent, STANDARD_GRAVITY_M_S2};
use crate::output::{Quantity, Results};
use crate::simulation::{Fall, Simulation};

/// Speed over that of release below which coefficients mean nothing.
const SLOWEST: f64 = 0.01;

/// Relative change of the speed between the halves of the window up to which a fall counts as settled, whatever its interval.
const STEADY: f64 = 0.01;

/// What a sample knows of the fall.
pub(super) struct Moment {
    fall: Fall,
    /// Time since the last sample [s] and the speed then [m/s].
    before: Option<[f64; 2]>,
    gravity_m_s2: f64,
    /// Mean force of the air on the canopy or body since the last sample, along its way [N].
    drag_n: f64,
    /// Mean dynamic pressure since the last sample [Pa]; NaN where the air hardly comes.
    dynamic_pressure_pa: f64,
    reference_area_m2: f64,
    /// What pulls the payload upwards [N].
    riser_n: f64,
}

static HAS_PAYLOAD: When<Scene> = When {
    words: "with a payload",
    holds: has_payload,
};

columns! {
    /// Those whose results are means have them under the same name.
    COLUMNS of Moment, in Scene: "What falls";
    DESCENT_SPEED: "descent_speed_m_s", "m/s", "speed of the payload or body" => |now| now.fall.speed_m_s;
    HEIGHT_FALLEN: "height_fallen_m", "m", "height fallen since release" => |now| now.fall.fallen_m, reduced Last;
    LOAD_FACTOR: "load_factor_g", "1", "load factor, in 9.80665 m/s2; what an accelerometer on the falling mass would show: 0 in free fall, 1 at constant speed on Earth; mean since the last sample"
        => |now| now.before.map_or(f64::NAN, |[interval_s, speed_m_s]| {
            let gained = (now.fall.speed_m_s - speed_m_s) / interval_s;
            (now.gravity_m_s2 - gained) / STANDARD_GRAVITY_M_S2
        }), reduced LargestAs("peak_load_factor_g");
    DRAG_COEFFICIENT_PRESENT: "drag_coefficient_present", "1", "drag over the dynamic pressure of the present speed and the reference area"
        => |now| now.drag_n / now.dynamic_pressure_pa / now.reference_area_m2, reduced MeanOf;
    DRAG_AREA: "drag_area_m2", "m2", "drag over the dynamic pressure of the present speed, C_D S"
        => |now| now.drag_n / now.dynamic_pressure_pa, reduced MeanOf;
    RISER_FORCE: "riser_force_n", "N", "pull of riser or lines on the payload" => |now| now.riser_n, reduced MeanOf, when HAS_PAYLOAD;
}

fn has_payload(scene: &Scene) -> bool {
    let descent = scene.descent.as_ref();
    descent.is_some_and(|d| matches!(d.carrier, Carrier::Confluence { .. }))
}

/// The columns of a scene; none where nothing falls.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = ReadOut> {
    let falls = scene.descent.as_ref().into_iter();
    falls.flat_map(|_| COLUMNS.read_outs(scene))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation, record: &Record) -> Vec<f64> {
    let scene = simulation.scene();
    let (Some(fall), Some(descent), Some(air)) = (simulation.fall(), &scene.descent, &scene.air)
    else {
        return Vec::new();
    };
    let last = record.latest(&TIME).zip(record.latest(&DESCENT_SPEED));
    let before = last.map(|(time_s, speed_m_s)| [simulation.time_s() - time_s, speed_m_s]);
    let earlier = before.map_or(fall.speed_m_s, |[_, speed]| speed);
    let is_slow = fall.speed_m_s.abs() < SLOWEST * air.wind_or_reference_m_s();
    let moment = Moment {
        fall,
        before,
        gravity_m_s2: descent.gravity_m_s2,
        drag_n: drag_n(&record.impulses, descent),
        dynamic_pressure_pa: if is_slow {
            f64::NAN
        } else {
            dynamic_pressure_pa(air.units.density_kg_m3, [earlier, fall.speed_m_s])
        },
        reference_area_m2: reference(scene, descent).map_or(f64::NAN, |[area, _]| area),
        riser_n: riser_n(simulation, descent),
    };
    COLUMNS.values(scene, Some(&moment))
}

/// Mean force along x of the air on what falls since the last sample [N].
fn drag_n(impulses: &Impulses, descent: &Descent) -> f64 {
    impulses.force_x_n(match descent.carrier {
        Carrier::RigidBody { number, .. } => Some(number),
        Carrier::Confluence { .. } => None,
    })
}

/// Mean over an interval with these speeds at its ends [Pa].
fn dynamic_pressure_pa(density_kg_m3: f64, [a, b]: [f64; 2]) -> f64 {
    0.25 * density_kg_m3 * (a * a + b * b)
}

/// Reference area [m²] and length [m] of what carries the mass.
fn reference(scene: &Scene, descent: &Descent) -> Option<[f64; 2]> {
    match descent.carrier {
        Carrier::Confluence { .. } => match &scene.body.as_ref()?.kind {
            BodyKind::Canopy(canopy) => Some([canopy.nominal_area_m2, canopy.nominal_diameter_m]),
            _ => None,
        },
        Carrier::RigidBody { number, .. } => {
            let body = scene.rigid_bodies.get(number)?;
            Some([body.reference_area_m2, body.reference_length_m])
        }
    }
}

/// What cables pull at the payload with, tethers below it left out [N].
fn riser_n(simulation: &Simulation, descent: &Descent) -> f64 {
    let (Carrier::Confluence { node, .. }, Some(cloth)) = (descent.carrier, simulation.cloth())
    else {
        return f64::NAN;
    };
    let cables = cloth.structure.cables.iter().enumerate();
    cables
        .filter(|(index, _)| descent.bodies.iter().all(|body| body.tether != *index))
        .filter_map(|(index, cable)| {
            let [a, b] = cable.nodes;
            let other = match (a == node, b == node) {
                (true, _) => b,
                (_, true) => a,
                _ => return None,
            };
            let [here, there] = [node, other].map(|n| cloth.positions_m[n as usize]);
            Some((there - here).normalize_or_zero() * cloth.cable_tension_n(index))
        })
        .sum::<glam::DVec3>()
        .length()
}

/// Samples that count as those of a settled fall.
#[derive(Debug)]
struct Window {
    first: usize,
    end: usize,
    /// Samples of a batch.
    batch: usize,
    /// Lengths fallen in it.
    lengths: f64,
    /// Why the fall does not count as settled.
    unsettled: Option<String>,
}

impl Window {
    fn mean(&self, column: &[f64]) -> Mean {
        let series: Vec<f64> = column[self.first..self.end]
            .iter()
            .copied()
            .filter(|value| value.is_finite())
            .collect();
        mean_of(&series, self.batch)
    }

    fn quantity(&self, mean: Mean, note: &str) -> Quantity {
        let mut quantity = quantity(mean).with_note(&format!(
            "{note}; mean over the last {:.1} lengths of the fall",
            self.lengths
        ));
        if self.unsettled.is_some() {
            quantity.mark_unresolved("the fall has not settled");
        }
        quantity
    }
}

/// The settled part of a fall: from [`SETTLING`] lengths behind the first peak of the diameter (of the release, without diameters) on, if it goes on
/// for [`SHORTEST_WINDOW`] and the speed stays; else its second half, with the reason. `None` before two samples exist after release.
fn window(
    times: &[f64],
    speeds: &[f64],
    heights: &[f64],
    ratios: &[f64],
    length_m: f64,
) -> Option<Window> {
    let released = times.iter().position(|&time| time > 0.0)?;
    let end = times.len();
    let fallen = heights.last()? - heights.get(released)?;
    let intervals = (end - 1).checked_sub(released).filter(|&n| n > 0)?;
    let samples = |lengths: f64| {
        let share = lengths * length_m / fallen.max(f64::MIN_POSITIVE);
        (share * intervals as f64).round().clamp(1.0, end as f64) as usize
    };
    let peak = match ratios {
        [] => Some(released),
        _ => first_peak(&ratios[released..], 0.8, samples(0.5)).map(|peak| released + peak),
    };
    let from_m = peak.map(|peak| heights[peak] + SETTLING * length_m);
    let lengths_from = |first: usize| (heights[end - 1] - heights[first]) / length_m;
    let settled = from_m
        .and_then(|from_m| heights.iter().position(|&height| height >= from_m))
        .filter(|&first| lengths_from(first) >= SHORTEST_WINDOW);
    let first = settled.unwrap_or_else(|| released.midpoint(end - 1));
    let mut window = Window {
        first,
        end,
        batch: samples(BATCH),
        lengths: lengths_from(first),
        unsettled: settled.is_none().then(|| {
            format!(
                "it went on for {:.1} lengths after release; {:.0} after the first peak of the diameter are needed",
                fallen / length_m,
                SETTLING + SHORTEST_WINDOW
            )
        }),
    };
    // Of a straight line through the speeds; what they scatter about it is what hides a change.
    let per_s = slope(&times[first..end], &speeds[first..end]);
    let change = 0.5 * per_s * (times[end - 1] - times[first]);
    let scatter: Vec<f64> = (times.iter().zip(speeds))
        .map(|(time, speed)| speed - per_s * (time - times[first]))
        .collect();
    let scatter = window.mean(&scatter).confidence.unwrap_or(0.0);
    let allowed = (STEADY * window.mean(speeds).value.abs()).max(2.0 * scatter);
    if change.abs() > allowed && window.unsettled.is_none() {
        window.unsettled = Some(format!(
            "between the halves of the window the speed changes by {change:.3} m/s"
        ));
    }
    Some(window)
}

fn window_of(record: &Record, length_m: f64) -> Option<Window> {
    let [times, speeds, heights] =
        [&TIME, &DESCENT_SPEED, &HEIGHT_FALLEN].map(|column| record.column(column));
    let ratios = match record.has(&PROJECTED_DIAMETER_RATIO) {
        true => record.column(&PROJECTED_DIAMETER_RATIO),
        false => Vec::new(),
    };
    window(&times, &speeds, &heights, &ratios, length_m)
}

/// Why means of a fall are no terminal ones; `None` where nothing falls or the fall has settled.
#[must_use]
pub fn unsettled_fall(scene: &Scene, record: &Record) -> Option<String> {
    let descent = scene.descent.as_ref()?;
    let [_, length_m] = reference(scene, descent)?;
    let window = window_of(record, length_m);
    let why = match window {
        Some(window) => window.unsettled?,
        None => "it ended at its release".to_owned(),
    };
    Some(format!(
        "the fall has not settled: {why}; terminal values are indicative only, raise time.end_s"
    ))
}

/// Largest load factor, means of the settled fall, terminal speed and what belongs to it, height.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    let Some(descent) = &scene.descent else {
        return;
    };
    let released = released(&record.column(&TIME));
    let (time, factor) = column_max(record, &LOAD_FACTOR, released);
    results.insert(
        &LOAD_FACTOR.named("peak_load_factor_g"),
        if factor.is_finite() {
            let note = format!("mean of a sample interval, at {time:.4} s");
            Quantity::new(factor).with_note(&note)
        } else {
            Quantity::missing("the run ended before two samples")
        },
    );
    terminal_results(results, record, scene, descent);
    if let Some(height) = record.latest(&HEIGHT_FALLEN) {
        results.insert(&HEIGHT_FALLEN, Quantity::new(height));
    }
}

fn terminal_results(results: &mut Results, record: &Record, scene: &Scene, descent: &Descent) {
    let (Some([area_m2, length_m]), Some(air)) = (reference(scene, descent), &scene.air) else {
        return;
    };
    let speeds = record.column(&DESCENT_SPEED);
    let Some(window) = window_of(record, length_m) else {
        let missing = || Quantity::missing("the run ended at its release");
        let means = COLUMNS.reduced(scene, MeanOf);
        let terminal = TERMINAL.iter().map(|row| row.read_out);
        for read_out in means.chain(terminal) {
            results.insert(read_out, missing());
        }
        return;
    };
    for column in COLUMNS.reduced(scene, MeanOf) {
        let mean = window.mean(&record.column(column));
        results.insert(column, window.quantity(mean, column.meaning));
    }
    let density = air.units.density_kg_m3;
    let pressures: Vec<f64> = (0..speeds.len())
        .map(|i| dynamic_pressure_pa(density, [speeds[i.saturating_sub(1)], speeds[i]]))
        .collect();
    let drag_area = ratio(&window, &record.column(&DRAG_AREA), &pressures);
    let line_area = if record.has(&LINE_DRAG) {
        window.mean(&record.column(&LINE_DRAG)).value / window.mean(&pressures).value
    } else {
        0.0
    };
    let of_payload: f64 = descent.drag_area_m2
        + descent
            .bodies
            .iter()
            .map(|body| body.drag_area_m2)
            .sum::<f64>();
    let mass_kg = match (descent.carrier, &scene.body) {
        (Carrier::Confluence { .. }, Some(body)) => body.structure.masses_kg.iter().sum(),
        _ => descent.mass_kg,
    };
    let known = Terminal {
        speed: window.mean(&speeds),
        drag_area,
        all_area_m2: drag_area.value + line_area + of_payload,
        area_m2,
        weight_n: mass_kg * descent.gravity_m_s2,
        hanging_n: descent.all_masses_kg() * descent.gravity_m_s2,
        of_payload_m2: of_payload,
        density_kg_m3: density,
    };
    for row in TERMINAL.iter().filter(|row| (row.when)(scene)) {
        let mean = (row.how)(&known);
        results.insert(row.read_out, window.quantity(mean, row.read_out.meaning));
    }
}

/// Σ aᵢ qᵢ/Σ qᵢ of drag areas a and dynamic pressures q, with the interval of the mean of (aᵢ − a) qᵢ over the mean of q.
fn ratio(window: &Window, areas: &[f64], pressures: &[f64]) -> Mean {
    let sums = areas[window.first..window.end]
        .iter()
        .zip(&pressures[window.first..window.end])
        .filter(|(area, _)| area.is_finite())
        .fold([0.0; 2], |[drag, pressure], (area, q)| {
            [drag + area * q, pressure + q]
        });
    let value = sums[0] / sums[1];
    let mean_pressure = window.mean(pressures).value;
    let rest: Vec<f64> = areas
        .iter()
        .zip(pressures)
        .map(|(area, pressure)| (area - value) * pressure / mean_pressure)
        .collect();
    Mean {
        value,
        ..window.mean(&rest)
    }
}

/// What terminal values follow from.
struct Terminal {
    speed: Mean,
    /// Mean drag over mean dynamic pressure [m²].
    drag_area: Mean,
    /// With what lines and payload have of their own [m²].
    all_area_m2: f64,
    /// Reference area [m²].
    area_m2: f64,
    /// Of all that falls [N].
    weight_n: f64,
    /// Of the payload and what hangs below it [N].
    hanging_n: f64,
    /// Drag area of those [m²].
    of_payload_m2: f64,
    density_kg_m3: f64,
}

impl Terminal {
    /// At which the drag balances the weight [Pa].
    fn pressure_pa(&self) -> Mean {
        let value = self.weight_n / self.all_area_m2;
        Mean {
            value,
            confidence: self
                .drag_area
                .confidence
                .map(|confidence| value * confidence / self.all_area_m2),
        }
    }
}

results! {
    /// Of the settled fall.
    RESULTS: "What falls";
    TERMINAL_SPEED: "terminal_speed_m_s", "m/s", "speed of the payload or body";
    SPEED_OF_DRAG_AREA: "terminal_speed_of_drag_area_m_s", "m/s", "speed at which all drag areas together balance the weight of all that falls, sqrt(2 m g/(rho C_D S))";
    TERMINAL_DRAG: "drag_coefficient_terminal", "1", "mean drag over the mean dynamic pressure and the reference area";
    TERMINAL_RISER_FORCE: "riser_force_terminal_n", "N", "weight of the payload and what hangs below it, less their own drag at that speed of balance";
}

/// A result of the settled fall.
struct TerminalRow {
    read_out: &'static ReadOut,
    when: fn(&Scene) -> bool,
    how: fn(&Terminal) -> Mean,
}

static TERMINAL: [TerminalRow; 4] = [
    TerminalRow {
        read_out: &TERMINAL_SPEED,
        when: |_| true,
        how: |known| known.speed,
    },
    TerminalRow {
        read_out: &SPEED_OF_DRAG_AREA,
        when: |_| true,
        how: |known| {
            let pressure = known.pressure_pa();
            let value = (2.0 * pressure.value / known.density_kg_m3).sqrt();
            Mean {
                value,
                confidence: pressure
                    .confidence
                    .map(|confidence| 0.5 * value * confidence / pressure.value),
            }
        },
    },
    TerminalRow {
        read_out: &TERMINAL_DRAG,
        when: |_| true,
        how: |known| Mean {
            value: known.drag_area.value / known.area_m2,
            confidence: known.drag_area.confidence.map(|c| c / known.area_m2),
        },
    },
    TerminalRow {
        read_out: &TERMINAL_RISER_FORCE,
        when: has_payload,
        how: |known| {
            let pressure = known.pressure_pa();
            Mean {
                value: known.hanging_n - known.of_payload_m2 * pressure.value,
                confidence: pressure.confidence.map(|c| c * known.of_payload_m2),
            }
        },
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall of 2 m in size from 10 m/s that nears 5 m/s, breathing by 5 % once a length: times, speeds, heights and diameters.
    fn fall(lengths: f64) -> [Vec<f64>; 4] {
        let step = 0.02;
        let mut columns: [Vec<f64>; 4] = Default::default();
        let (mut time, mut height) = (0.0, 0.0);
        while height < lengths * 2.0 {
            let turn = (std::f64::consts::TAU * height / 2.0).sin();
            let speed = (5.0 + 5.0 * f64::exp(-time)) * (1.0 + 0.05 * turn);
            height += speed * step;
            time += step;
            let ratio = (0.4 * time).min(0.7) + 0.02 * turn;
            for (column, value) in columns.iter_mut().zip([time, speed, height, ratio]) {
                column.push(value);
            }
        }
        columns
    }

    fn window_after(lengths: f64) -> Window {
        let [times, speeds, heights, ratios] = fall(lengths);
        window(&times, &speeds, &heights, &ratios, 2.0).unwrap()
    }

    #[test]
    fn a_fall_settles() {
        let early = window_after(12.0);
        assert!(early.unsettled.is_some(), "{early:?}");
        let late = window_after(40.0);
        assert!(late.unsettled.is_none(), "{late:?}");
        assert!(late.lengths < 40.0 - SETTLING);
        let [_, speeds, ..] = fall(40.0);
        let mean = late.mean(&speeds);
        let confidence = mean.confidence.unwrap();
        assert!((mean.value - 5.0).abs() < confidence.max(0.02), "{mean:?}");
        assert!(confidence < 0.2, "{mean:?}");
        // One that goes on slowing down does not.
        let [times, mut speeds, heights, ratios] = fall(40.0);
        let count = speeds.len() as f64;
        for (i, speed) in speeds.iter_mut().enumerate() {
            *speed *= 1.5 - i as f64 / count;
        }
        let falling = window(&times, &speeds, &heights, &ratios, 2.0).unwrap();
        assert!(falling.unsettled.is_some(), "{falling:?}");
        assert!(window(&[0.0], &[1.0], &[0.0], &[], 2.0).is_none());
    }

    /// Drag that follows the square of the speed has one area; a mean of areas that differ weighs them by pressure.
    #[test]
    fn areas_are_weighed_by_dynamic_pressure() {
        let window = Window {
            first: 0,
            end: 40,
            batch: 4,
            lengths: 10.0,
            unsettled: None,
        };
        let pressures: Vec<f64> = (0..40).map(|i| 1.0 + f64::from(i % 4)).collect();
        let same = ratio(&window, &[2.0; 40], &pressures);
        assert!((same.value - 2.0).abs() < 1e-12 && same.confidence.unwrap() < 1e-12);
        let areas: Vec<f64> = pressures.iter().map(|q| 6.0 / q).collect();
        let found = ratio(&window, &areas, &pressures);
        assert!((found.value - 6.0 / 2.5).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn weight_and_drag_area_make_the_terminal_speed() {
        let known = Terminal {
            speed: Mean {
                value: f64::NAN,
                confidence: None,
            },
            drag_area: Mean {
                value: 60.0,
                confidence: Some(6.0),
            },
            all_area_m2: 61.0,
            area_m2: 80.0,
            weight_n: 1000.0,
            hanging_n: 950.0,
            of_payload_m2: 1.0,
            density_kg_m3: 1.2,
        };
        let of = |name: &str| {
            let mut rows = TERMINAL.iter();
            let row = rows.find(|row| row.read_out.name == name).unwrap();
            (row.how)(&known)
        };
        let speed = of("terminal_speed_of_drag_area_m_s");
        assert!((0.6 * speed.value.powi(2) * 61.0 - 1000.0).abs() < 1e-9);
        // Half of 6 in 61.
        assert!((speed.confidence.unwrap() / speed.value - 3.0 / 61.0).abs() < 1e-12);
        assert_eq!(of("drag_coefficient_terminal").value, 0.75);
        assert!((of("riser_force_terminal_n").value - (950.0 - 1000.0 / 61.0)).abs() < 1e-9);
    }
}
