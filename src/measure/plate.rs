//! What is measured on a plate of fabric in the wind: columns of the history behind those of fabric, and named results.
//!
//! Displacements are those of the middle of the free edge, from where it is while the plate is flat. The drag coefficient refers to ½ ρ U² and
//! length times width, the Strouhal number f L/U to the length.

use glam::DVec3;

use super::impulses::Forces;
use super::read_out::Reduction::Mean;
use super::read_out::{ReadOut, columns, results};
use super::record::Record;
use super::reduce::{mean_forces_n, second_half};
use super::shared::{
    DRAG_COEFFICIENT, DRAG_MARKERS, DRAG_MOMENTUM_BOX, FORCE_IMBALANCE, IMPULSE_MARKERS,
    IMPULSE_MOMENTUM_BOX, STROUHAL_NUMBER, TIME,
};
use super::spectrum::frequency;
use super::statistics::{average, largest, range};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow};
use crate::geometry::plate::Plate;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

columns! {
    /// Behind those of fabric in the wind.
    COLUMNS of Moment, in Scene: "Plates in air";
    TIP_X: "tip_displacement_x_m", "m", "displacement of the tip along x" => |now| now.tip_m.x, reduced Mean;
    TIP_Y: "tip_displacement_y_m", "m", "displacement of the tip along y" => |now| now.tip_m.y, reduced Mean;
    TIP_Z: "tip_displacement_z_m", "m", "displacement of the tip along z" => |now| now.tip_m.z, reduced Mean;
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

/// Means over the second half of the run; amplitude and frequency there.
pub(super) fn results(results: &mut Results, record: &Record, plate: &Plate, air: &Air) {
    let times = record.column(&TIME);
    let Some(first) = second_half(&times) else {
        return;
    };
    let last = times.len() - 1;
    if first >= last {
        return;
    }
    let speed = air.wind_or_reference_m_s();
    let length = plate.size_m[0];
    let window = format!(
        "last {:.1} L/U",
        (times[last] - times[first]) * speed / length
    );
    let wind = matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0);
    let impulses = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_SUPPORTS];
    let routes = mean_forces_n(record, impulses, [first, last]);
    let pressure = 0.5 * air.units.density_kg_m3 * speed * speed;
    results.insert(
        &DRAG_COEFFICIENT,
        if wind {
            Quantity::new(routes[0] / (pressure * plate.area_m2()))
                .with_note(&format!("mean of the {window}; length times width"))
        } else {
            Quantity::missing("there is no wind to refer to")
        },
    );
    for (drag, force) in [&DRAG_MARKERS, &DRAG_MOMENTUM_BOX, &DRAG_SUPPORTS]
        .into_iter()
        .zip(routes)
    {
        results.tell(drag, force);
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
    let columns = TIP.map(|column| record.column(column)[first..].to_vec());
    for (read_out, column) in TIP.into_iter().zip(&columns) {
        let note = format!("middle of the free edge, mean of the {window}");
        results.insert(read_out, Quantity::new(average(column)).with_note(&note));
    }
    // The axis along which the tip moves most; a flag's is across its plane.
    let swing = |a: usize| range(&columns[a]);
    let axis = (0..3).fold(0, |best, a| if swing(a) > swing(best) { a } else { best });
    let name = ["x", "y", "z"][axis];
    results.insert(
        &PEAK_TO_PEAK,
        Quantity::new(swing(axis)).with_note(&format!("along {name}, in the {window}")),
    );
    let interval = (times[last] - times[first]) / (last - first) as f64;
    let scaled: Vec<f64> = columns[axis].iter().map(|x| x / length).collect();
    results.insert(
        &STROUHAL_NUMBER.of(""),
        match frequency(&scaled, interval, AT_REST) {
            Ok(mean) => Quantity::new(mean.value * length / speed)
                .with_note(&format!("f L/U of the tip along {name}")),
            Err(why) => Quantity::missing(&format!("of the tip along {name}: {why}")),
        },
    );
}
