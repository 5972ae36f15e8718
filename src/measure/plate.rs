//! What is measured on a plate of fabric in the wind: columns of the history behind those of fabric, and named results.
//!
//! Displacements are those of the middle of the free edge, from where it is while the plate is flat. The drag coefficient refers to ½ ρ U² and
//! length times width, the Strouhal number f L/U to the length.

use glam::DVec3;

use super::Record;
use super::bodies::frequency;
use crate::case::scene::{Air, Flow};
use crate::geometry::plate::Plate;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// Columns behind those of fabric in the wind.
pub(super) const COLUMNS: [&str; 4] = [
    "tip_displacement_x_m",
    "tip_displacement_y_m",
    "tip_displacement_z_m",
    "impulse_supports_n_s",
];

/// Amplitude over the length below which a plate counts as at rest.
const AT_REST: f64 = 2e-3;

/// Displacement of the tip [m].
pub(super) fn tip_displacement_m(simulation: &Simulation, plate: &Plate) -> DVec3 {
    simulation.cloth().map_or(DVec3::NAN, |cloth| {
        cloth.positions_m[plate.tip() as usize] - plate.flat_tip_m()
    })
}

/// Means over the second half of the run; amplitude and frequency there.
pub(super) fn results(results: &mut Results, record: &Record, plate: &Plate, air: &Air) {
    let times = record.column("time_s");
    let Some(first) = times.iter().position(|&t| t > 0.0) else {
        return;
    };
    let first = first.midpoint(times.len());
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
    let routes = [
        "impulse_markers_n_s",
        "impulse_momentum_box_n_s",
        "impulse_supports_n_s",
    ]
    .map(|name| {
        let impulse = record.column(name);
        (impulse[last] - impulse[first]) / (times[last] - times[first])
    });
    let pressure = 0.5 * air.units.density_kg_m3 * speed * speed;
    results.insert(
        "drag_coefficient",
        if wind {
            Quantity::new(routes[0] / (pressure * plate.area_m2()), "1")
                .with_note(&format!("mean of the {window}; length times width"))
        } else {
            Quantity::missing("1", "there is no wind to refer to")
        },
    );
    for (name, force, what) in [
        ("drag_markers_n", routes[0], "sum over markers"),
        (
            "drag_momentum_box_n",
            routes[1],
            "populations through a box, with storage",
        ),
        (
            "drag_supports_n",
            routes[2],
            "reaction of the held edge plus the plate's own momentum",
        ),
    ] {
        results.insert(name, Quantity::new(force, "N").with_note(what));
    }
    let spread = routes
        .iter()
        .fold(0.0, |worst: f64, force| {
            if force.is_nan() {
                f64::NAN
            } else {
                worst.max((force - routes[0]).abs())
            }
        })
        .max((routes[1] - routes[2]).abs());
    let imbalance = spread / routes[0].abs();
    results.insert(
        "force_imbalance",
        if imbalance.is_finite() {
            Quantity::new(imbalance, "1")
                .with_note("largest difference of the three routes over the drag")
        } else {
            Quantity::missing("1", "markers left the momentum box, or there is no drag")
        },
    );
    let columns: [Vec<f64>; 3] =
        std::array::from_fn(|a| record.column(COLUMNS[a])[first..].to_vec());
    for (name, column) in COLUMNS.iter().zip(&columns) {
        let mean = column.iter().sum::<f64>() / column.len() as f64;
        results.insert(
            name,
            Quantity::new(mean, "m")
                .with_note(&format!("middle of the free edge, mean of the {window}")),
        );
    }
    // The axis along which the tip moves most; a flag's is across its plane.
    let swing = |column: &Vec<f64>| {
        let most = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - column.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let axis = (0..3).fold(0, |best, a| {
        if swing(&columns[a]) > swing(&columns[best]) {
            a
        } else {
            best
        }
    });
    let name = ["x", "y", "z"][axis];
    results.insert(
        "tip_peak_to_peak_m",
        Quantity::new(swing(&columns[axis]), "m")
            .with_note(&format!("along {name}, in the {window}")),
    );
    let interval = (times[last] - times[first]) / (last - first) as f64;
    let scaled: Vec<f64> = columns[axis].iter().map(|x| x / length).collect();
    results.insert(
        "strouhal_number",
        match frequency(&scaled, interval, AT_REST) {
            Ok(mean) => Quantity::new(mean.value * length / speed, "1")
                .with_note(&format!("f L/U of the tip along {name}")),
            Err(why) => Quantity::missing("1", &format!("of the tip along {name}: {why}")),
        },
    );
}
