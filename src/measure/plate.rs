//! What is measured on a plate of fabric in the wind: columns of the history behind those of fabric, and named results.
//!
//! Displacements are those of the middle of the free edge, from where it is while the plate is flat. The drag coefficient refers to ½ ρ U² and
//! length times width, the Strouhal number f L/U to the length.
//!
//! Means begin when the first swings are over and the wake has settled ([`ALONG`], [`ACROSS`]). Those of a shorter run are taken over its second
//! half, and marked.

use std::ops::Range;

use glam::DVec3;

use super::impulses::Forces;
use super::read_out::Reduction::Mean as MeanOf;
use super::read_out::{ReadOut, columns, results};
use super::record::Record;
use super::reduce::{mean_forces_n, quantity};
use super::shared::{
    DRAG_COEFFICIENT, DRAG_MARKERS, DRAG_MOMENTUM_BOX, FORCE_IMBALANCE, FORCE_X, FORCE_Y, FORCE_Z,
    IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX, STROUHAL_NUMBER, TIME,
};
use super::spectrum::frequency;
use super::statistics::{Mean, largest, range};
use super::steady::bodies::{BodyWindow, UNSTEADY_SETTLING, UNSTEADY_WINDOW};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow};
use crate::geometry::plate::{Plate, Support};
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

columns! {
    /// Behind those of fabric in the wind.
    COLUMNS of Moment, in Scene: "Plates in air";
    TIP_X: "tip_displacement_x_m", "m", "displacement of the tip along x" => |now| now.tip_m.x, reduced MeanOf;
    TIP_Y: "tip_displacement_y_m", "m", "displacement of the tip along y" => |now| now.tip_m.y, reduced MeanOf;
    TIP_Z: "tip_displacement_z_m", "m", "displacement of the tip along z" => |now| now.tip_m.z, reduced MeanOf;
    IMPULSE_SUPPORTS: "impulse_supports_n_s", "N s", "impulse of the held edge, and of the plate itself, along x; since release"
        => |now| now.forces.impulse.supports.x;
}

results! {
    /// What follows from them.
    RESULTS: "Plates in air";
    DRAG_COEFFICIENT;
    DRAG_SUPPORTS: "drag_supports_n", "N", "mean drag by the held edge; reaction of the held edge plus the plate's own momentum";
    PEAK_TO_PEAK: "tip_peak_to_peak_m", "m", "way of the tip from one end of its swing to the other";
}

/// Displacements of the tip along the axes.
pub(super) static TIP: [&ReadOut; 3] = [&TIP_X, &TIP_Y, &TIP_Z];

/// A plate at a sample.
pub(super) struct Moment {
    tip_m: DVec3,
    forces: Forces,
}

impl Moment {
    /// A sample; `None` where there is no plate in air.
    pub fn new(simulation: &Simulation, forces: Forces) -> Option<Self> {
        let BodyKind::Plate(plate) = simulation.scene().body.as_ref()?.kind else {
            return None;
        };
        let cloth = simulation.cloth();
        let tip_m = cloth.map_or(DVec3::NAN, |cloth| {
            cloth.positions_m[plate.tip() as usize] - plate.flat_tip_m()
        });
        Some(Self { tip_m, forces })
    }
}

/// Amplitude over the length below which a plate counts as at rest.
const AT_REST: f64 = 2e-3;

/// From t = 0 to the begin of the means of a plate that lies along the stream, and how long these take at least [L/U]. A flag's first swings last to
/// 16 L/U (docs/results/2026-11-26-motion-of-fabric.md); five of its periods take the rest, of which a frequency needs four.
pub const ALONG: [f64; 2] = [16.0, UNSTEADY_WINDOW];

/// The same of one across the stream, in b/U with b its lesser side there: those of a rigid body's wake. Means of the shipped plate begin at 30, too
/// (docs/validation.md).
pub const ACROSS: [f64; 2] = [UNSTEADY_SETTLING, UNSTEADY_WINDOW];

/// Reynolds number up to which no wake sheds vortices: that of a cylinder (Williamson 1996, Annu. Rev. Fluid Mech. 28).
const STEADY_REYNOLDS: f64 = 47.0;

/// Share of its area that a plate shows the wind, below which it lies along the stream.
const LIES_ALONG: f64 = 0.5;

/// True for a plate that lies along the stream, or that comes to since its edge is pinned: a flag.
pub fn lies_along(plate: &Plate) -> bool {
    plate.support == Support::Pinned || plate.normal().x.abs() < LIES_ALONG
}

/// Lesser side of a plate, as the wind sees it [m].
pub fn lesser_side_m(plate: &Plate) -> f64 {
    let [length, width] = plate.size_m;
    let sides = [plate.along * length, plate.across * width];
    let [along, across] = sides.map(|side| side.reject_from(DVec3::X).length());
    along.min(across)
}

/// True where a wind blows.
fn has_wind(air: &Air) -> bool {
    matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0)
}

/// The samples that means of a plate in air are taken over.
pub(super) struct Window {
    samples: BodyWindow,
    /// Why means over them cannot be trusted.
    unsettled: Option<String>,
}

impl Window {
    /// Chooses them; `None` before two samples exist after t = 0.
    pub fn new(record: &Record, plate: &Plate, air: &Air) -> Option<Self> {
        let (unit_m, unit, settled) = if lies_along(plate) {
            (plate.size_m[0], "L/U", ALONG)
        } else {
            (lesser_side_m(plate), "b/U", ACROSS)
        };
        let unit = (unit_m / air.wind_or_reference_m_s(), unit);
        let samples = BodyWindow::of_swaying(&record.column(&TIME), unit, settled)?;
        let [drag, side, lift] = [&FORCE_X, &FORCE_Y, &FORCE_Z].map(|force| record.column(force));
        let reynolds = air.wind_or_reference_m_s() * unit_m / air.kinematic_viscosity_m2_s;
        let across = (reynolds > STEADY_REYNOLDS).then_some([&side[..], &lift]);
        let unsettled = if has_wind(air) {
            samples.unsettled(&drag, across)
        } else {
            None
        };
        Some(Self { samples, unsettled })
    }

    /// First sample.
    pub const fn first(&self) -> usize {
        self.samples.first
    }

    /// A number, marked where means over the window cannot be trusted.
    fn marked(&self, mut quantity: Quantity) -> Quantity {
        if let (Some(why), Some(_)) = (&self.unsettled, quantity.value) {
            quantity.mark_unresolved(why);
        }
        quantity
    }

    /// Mean of a column with its interval.
    pub fn mean(&self, record: &Record, column: &ReadOut) -> Quantity {
        self.marked(quantity(self.samples.mean(&record.column(column))))
    }
}

/// Samples over which the means of a plate in air are taken; `None` of other scenes.
pub(super) fn averaged(scene: &Scene, record: &Record) -> Option<Range<usize>> {
    let window = Window::new(record, scene.plate()?, scene.air.as_ref()?)?;
    Some(window.samples.first..window.samples.end)
}

/// A mean over what it is measured in.
fn over(mean: Mean, unit: f64) -> Mean {
    Mean {
        value: mean.value / unit,
        confidence: mean.confidence.map(|half| half / unit),
    }
}

/// Means over the settled window, or the second half of a shorter run; amplitude and frequency there.
pub(super) fn results(results: &mut Results, record: &Record, plate: &Plate, air: &Air) {
    let Some(means) = Window::new(record, plate, air) else {
        return;
    };
    let times = record.column(&TIME);
    let [first, last] = [means.samples.first, means.samples.end - 1];
    let speed = air.wind_or_reference_m_s();
    let length = plate.size_m[0];
    let window = format!(
        "last {:.1} L/U",
        (times[last] - times[first]) * speed / length
    );
    let drag = means.samples.mean(&record.column(&FORCE_X));
    let pressure = 0.5 * air.units.density_kg_m3 * speed * speed;
    results.insert(
        &DRAG_COEFFICIENT,
        if has_wind(air) {
            means
                .marked(quantity(over(drag, pressure * plate.area_m2())))
                .with_note(&format!("mean of the {window}; length times width"))
        } else {
            Quantity::missing("there is no wind to refer to")
        },
    );
    // A row's force is that of the interval before it, so the impulses count from the row before the window.
    let impulses = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_SUPPORTS];
    let routes = mean_forces_n(record, impulses, [first.saturating_sub(1), last]);
    for (read_out, force) in [&DRAG_MARKERS, &DRAG_MOMENTUM_BOX, &DRAG_SUPPORTS]
        .into_iter()
        .zip(routes)
    {
        results.insert(read_out, means.marked(Quantity::told(read_out, force)));
    }
    let [markers, momentum_box, supports] = routes;
    let differences = [
        markers - momentum_box,
        markers - supports,
        momentum_box - supports,
    ];
    let imbalance = largest(differences.map(f64::abs)) / markers.abs();
    results.insert(
        &FORCE_IMBALANCE,
        if imbalance.is_finite() {
            Quantity::new(imbalance)
                .with_note("largest difference of the three routes over the drag")
        } else {
            Quantity::missing("markers left the momentum box, or there is no drag")
        },
    );
    for read_out in TIP {
        let note = format!("middle of the free edge, mean of the {window}");
        results.insert(read_out, means.mean(record, read_out).with_note(&note));
    }
    let columns = TIP.map(|column| record.column(column)[first..].to_vec());
    // The axis along which the tip moves most; a flag's is across its plane.
    let swing = |a: usize| range(&columns[a]);
    let axis = (0..3).fold(0, |best, a| if swing(a) > swing(best) { a } else { best });
    let name = ["x", "y", "z"][axis];
    results.insert(
        &PEAK_TO_PEAK,
        means
            .marked(Quantity::new(swing(axis)))
            .with_note(&format!("along {name}, in the {window}")),
    );
    let interval = (times[last] - times[first]) / (last - first) as f64;
    let scaled: Vec<f64> = columns[axis].iter().map(|x| x / length).collect();
    results.insert(
        &STROUHAL_NUMBER.of(""),
        match frequency(&scaled, interval, AT_REST) {
            Ok(mean) => means
                .marked(quantity(over(mean, speed / length)))
                .with_note(&format!("f L/U of the tip along {name}")),
            Err(why) => Quantity::missing(&format!("of the tip along {name}: {why}")),
        },
    );
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use super::*;
    use crate::case::{self, Choices};
    use crate::measure::fabric;

    const FLAG: &str = include_str!("../../cases/flag.toml");
    const PLATE: &str = include_str!("../../cases/flexible-plate.toml");

    /// Results of a shipped case that ends at `end_s`, with that force along the wind.
    fn results_of(text: &str, end_s: f64, force: impl Fn(f64) -> f64) -> Results {
        let case = case::parse("plate", text, Path::new("."), &Choices::default()).unwrap();
        let scene = &case.scene;
        let interval_s = scene.output.sample_interval_s;
        let mut record = Record::of(scene);
        let columns = [&TIME, &FORCE_X, &FORCE_Y, &IMPULSE_MARKERS];
        let places = columns.map(|column| {
            let own = record.columns().iter();
            own.map(|own| &own.name)
                .position(|name| *name == column.name)
                .unwrap()
        });
        let mut impulse = 0.0;
        for sample in 0..=(end_s / interval_s).round() as u32 {
            let time_s = f64::from(sample) * interval_s;
            if sample > 0 {
                impulse += force(time_s) * interval_s;
            }
            let mut row = record.zeros();
            let values = [time_s, force(time_s), 0.1 * time_s.sin(), impulse];
            for (place, value) in places.into_iter().zip(values) {
                row[place] = value;
            }
            record.push(row);
        }
        let (plate, air) = (scene.plate().unwrap(), scene.air.as_ref().unwrap());
        let mut found = Results::new();
        fabric::in_wind(&mut found, &record, scene);
        super::results(&mut found, &record, plate, air);
        found
    }

    #[test]
    fn means_of_settled_runs_have_intervals() {
        // ½ ρ U² is 0.5 and 12.8 Pa, on 1 m² and 5e-4 m².
        let flag = results_of(FLAG, 40.0, |t| 1.0 + 0.1 * (PI * t).sin());
        let plate = results_of(PLATE, 3.75, |_| 6.4e-3);
        for (found, expected) in [(flag, 2.0), (plate, 1.0)] {
            let drag = found.get("drag_coefficient").unwrap();
            assert!(
                (drag.value.unwrap() / expected - 1.0).abs() < 1e-3,
                "{drag:?}"
            );
            assert!(drag.confidence.unwrap() < 0.01, "{drag:?}");
            assert_eq!(drag.unresolved, None);
            let [force, markers] =
                ["force_x_n", "drag_markers_n"].map(|name| found.get(name).unwrap());
            let ratio = force.value.unwrap() / markers.value.unwrap();
            assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
            assert!(force.confidence.is_some());
            let tip = found.get("tip_displacement_x_m").unwrap();
            assert!(tip.confidence.is_some());
        }
    }

    #[test]
    fn short_and_drifting_runs_are_marked() {
        for (text, end_s, slope, told) in [
            (FLAG, 12.0, 0.0, "averaging begins 16 L/U"),
            (PLATE, 0.1, 0.0, "averaging begins 30 b/U"),
            (FLAG, 40.0, 0.01, "the drag changes by +"),
        ] {
            let found = results_of(text, end_s, |t| 1.0 + slope * t);
            for name in ["drag_coefficient", "force_x_n", "tip_displacement_x_m"] {
                let quantity = found.get(name).unwrap();
                let why = quantity.unresolved.as_deref().unwrap();
                assert!(why.contains(told), "{name}: {why}");
                assert!(slope > 0.0 || quantity.confidence.is_none(), "{name}");
            }
        }
    }
}
