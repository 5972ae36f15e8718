//! Results of air alone.

use crate::case::scene::{Air, Flow};
use crate::measure::Record;
use crate::measure::statistics::slope;
use crate::output::{Quantity, Results};

/// Energy and mass, or the decay of vortices beside its exact rate.
pub(super) fn results(results: &mut Results, record: &Record, air: &Air) {
    let Flow::TaylorGreen { side_m, .. } = air.flow else {
        for (name, unit) in [("kinetic_energy_j", "J"), ("mass_excess_kg", "kg")] {
            if let Some(value) = record.latest(name) {
                results.insert(
                    name,
                    Quantity::new(value, unit).with_note("of all the air, at the end"),
                );
            }
        }
        return;
    };
    let times = record.column("time_s");
    let amplitude = record.column("velocity_amplitude_m_s");
    if times.len() < 3 {
        results.insert(
            "velocity_decay_rate_1_s",
            Quantity::missing("1/s", "too few samples"),
        );
        return;
    }
    let logarithms: Vec<f64> = amplitude.iter().map(|a| a.ln()).collect();
    let wave_number = std::f64::consts::TAU / side_m;
    let exact = 2.0 * air.kinematic_viscosity_m2_s * wave_number * wave_number;
    results.insert(
        "velocity_decay_rate_1_s",
        Quantity::new(-slope(&times, &logarithms), "1/s").with_reference(exact, "exact, 2 nu k^2"),
    );
    let mass = record.column("mass_excess_kg");
    let total = air.units.density_kg_m3
        * air.units.cell_size_m.powi(3)
        * air.cells.iter().product::<usize>() as f64;
    let drift = mass.iter().map(|m| (m - mass[0]).abs()).fold(0.0, f64::max) / total;
    results.insert("mass_drift", Quantity::new(drift, "1"));
}
