//! Air alone: energy, mass, and the decay of vortices.

use super::read_out::Reduction::Last;
use super::read_out::{columns, results};
use super::record::Record;
use super::shared::{MASS_DRIFT, TIME};
use super::statistics::slope;
use crate::case::Scene;
use crate::case::scene::{Air, Flow};
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// Air at a sample.
pub(super) struct Moment {
    time_s: f64,
    energy_j: f64,
    total_mass_kg: f64,
    mass_excess_kg: f64,
}

columns! {
    /// Columns of air alone.
    COLUMNS of Moment, in Scene: "Air alone";
    TIME => |now| now.time_s;
    ENERGY: "kinetic_energy_j", "J", "kinetic energy of all the air" => |now| now.energy_j, reduced Last;
    // Mean of ½ u² is a quarter of the squared amplitude for sin·cos in two components.
    AMPLITUDE: "velocity_amplitude_m_s", "m/s", "amplitude of the velocity of vortices"
        => |now| (4.0 * now.energy_j / now.total_mass_kg).sqrt();
    MASS_EXCESS: "mass_excess_kg", "kg", "mass of all the air above that at rest" => |now| now.mass_excess_kg, reduced Last;
}

results! {
    /// Their results.
    RESULTS: "Air alone";
    DECAY_RATE: "velocity_decay_rate_1_s", "1/s", "rate at which the vortices decay";
}

impl Moment {
    /// A sample; `None` without air.
    pub fn new(simulation: &Simulation) -> Result<Option<Self>, DeviceError> {
        let (Some(engine), Some(air)) = (simulation.air(), &simulation.scene().air) else {
            return Ok(None);
        };
        let (mass, energy) = engine.mass_and_energy()?;
        let cell_mass = air.units.density_kg_m3 * air.outer_cell_size_m().powi(3);
        let cells: usize = air.outer_cells().iter().product();
        Ok(Some(Self {
            time_s: simulation.time_s(),
            energy_j: energy * cell_mass * air.units.speed_m_s().powi(2),
            total_mass_kg: cell_mass * cells as f64,
            mass_excess_kg: mass * cell_mass,
        }))
    }
}

/// Energy and mass, or the decay of vortices beside its exact rate.
pub(super) fn results(results: &mut Results, record: &Record, (scene, air): (&Scene, &Air)) {
    let Flow::TaylorGreen { side_m, .. } = air.flow else {
        for column in COLUMNS.reduced(scene, Last) {
            if let Some(value) = record.latest(column) {
                let note = "of all the air, at the end";
                results.insert(column, Quantity::new(value).with_note(note));
            }
        }
        return;
    };
    let times = record.column(&TIME);
    let amplitude = record.column(&AMPLITUDE);
    if times.len() < 3 {
        results.insert(&DECAY_RATE, Quantity::missing("too few samples"));
        return;
    }
    let logarithms: Vec<f64> = amplitude.iter().map(|a| a.ln()).collect();
    let wave_number = std::f64::consts::TAU / side_m;
    let exact = 2.0 * air.kinematic_viscosity_m2_s * wave_number * wave_number;
    results.insert(
        &DECAY_RATE,
        Quantity::new(-slope(&times, &logarithms)).with_reference(exact, "exact, 2 nu k^2"),
    );
    let mass = record.column(&MASS_EXCESS);
    let total = air.units.density_kg_m3
        * air.units.cell_size_m.powi(3)
        * air.cells.iter().product::<usize>() as f64;
    let drift = mass.iter().map(|m| (m - mass[0]).abs()).fold(0.0, f64::max) / total;
    results.insert(&MASS_DRIFT, Quantity::new(drift));
}
