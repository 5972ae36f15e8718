//! Fabric and cables: in the wind, and without air.

use glam::DVec3;

use super::catenary;
use super::impulses::Forces;
use super::plate;
use super::read_out::Reduction::{Last, Mean};
use super::read_out::{ReadOut, columns, results};
use super::record::Record;
use super::reduce::{mass_drift, second_half};
use super::shared::{
    BELT_TENSION_MAX, BY_MARKERS, CABLE_TENSION_MAX, FASTEST_NODE, FORCE_X, FORCE_Y, FORCE_Z,
    IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX, KINETIC_ENERGY, LINE_TENSION_MAX, MASS_DEFECT,
    MASS_DRIFT, RISER_TENSION_MAX, SHEAR_STRESS_MAX, SLIP_RATIO, STRESS_MAX, TENSION_MAX, TIME,
    VENT_LINE_TENSION_MAX, VON_MISES_MAX, WIND_SPEED,
};
use super::statistics::{average, largest};
use crate::case::Scene;
use crate::case::scene::{Airbag, BodyKind, HangingCable};
use crate::frame::{CableKind, FabricState, StructureFrame};
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

columns! {
    /// The first columns of a sheet, a plate, a mesh or a wing in the wind.
    IN_WIND of InWind, in Scene: "Sheets, plates, meshes and wings in air";
    TIME => |now| now.fabric.time_s;
    WIND_SPEED => |now| now.wind_m_s;
    FORCE_X => |now| now.forces.markers_n.x, reduced Mean;
    FORCE_Y => |now| now.forces.markers_n.y, reduced Mean;
    FORCE_Z => |now| now.forces.markers_n.z, reduced Mean;
    FORCE_X_MOMENTUM_BOX: "force_x_momentum_box_n", "N", "force along the wind by the momentum of a box of air"
        => |now| now.forces.momentum_box_n.x, reduced Mean;
    IMPULSE_MARKERS => |now| now.forces.impulse.markers.x;
    IMPULSE_MOMENTUM_BOX => |now| now.forces.impulse.momentum_box.x;
    TENSION_MAX => |now| now.fabric.tension_max_n_m(), reduced Mean;
    SLIP_RATIO => |now| now.slip_ratio, reduced Mean, when BY_MARKERS;
    KINETIC_ENERGY => |now| now.fabric.kinetic_energy_j;
    FASTEST_NODE => |now| largest(now.fabric.speeds_m_s());
    MASS_DEFECT => |now| now.forces.mass_defect;
}

columns! {
    /// Columns of fabric and cables without air.
    ALONE of Fabric, in Scene: "Fabric and cables without air";
    TIME => |now| now.time_s;
    LOWEST_POINT: "lowest_point_m", "m", "height of the lowest node"
        => |now| now.frame.positions_m.iter().map(|p| p.z).fold(f64::INFINITY, f64::min), reduced Last;
    TENSION_MAX => |now| now.tension_max_n_m(), reduced Last;
    ALONE_ENERGY: "kinetic_energy_j", "J", "kinetic energy of fabric and cables" => |now| now.kinetic_energy_j;
    FASTEST_NODE => |now| now.speeds_m_s().fold(0.0, f64::max);
}

results! {
    /// The state at the end of fabric and cables without air.
    RESULTS: "Fabric and cables without air";
    STRESS_MAX;
    TRUE_STRESS_MAX: "true_stress_max_pa", "Pa", "largest principal stress over the thickness of fabric that has kept its volume";
    VON_MISES_MAX;
    SHEAR_STRESS_MAX;
    LINE_TENSION_MAX;
    BELT_TENSION_MAX;
    VENT_LINE_TENSION_MAX;
    RISER_TENSION_MAX;
    CABLE_TENSION_MAX;
    SAG: "sag_m", "m", "sag of a cable";
    HORIZONTAL_TENSION: "horizontal_tension_n", "N", "horizontal tension of a cable";
    END_TENSION: "end_tension_n", "N", "tension of a cable at its ends";
    HIGHEST_POINT: "highest_point_m", "m", "height of the highest node";
    WRINKLED_SHARE: "wrinkled_area_share", "1", "share of the area that is wrinkled";
    SLACK_SHARE: "slack_area_share", "1", "share of the area that is slack";
    YIELDING_SHARE: "yielding_area_share", "1", "share of the area whose von Mises stress exceeds fabric.yield_stress_pa";
    WEIGHT: "weight_n", "N", "weight";
    HALF_HEIGHT: "half_height_m", "m", "half the height of an airbag; in the middle";
    PULL: "pull_n", "N", "force that a coupon is pulled with";
    GAUGE_STRAIN: "gauge_strain", "1", "strain of a coupon; middle third of the length";
    MODULUS: "modulus_pa", "Pa", "pull over cross-section and strain of a coupon";
}

/// Fabric at a sample.
pub(super) struct Fabric {
    time_s: f64,
    kinetic_energy_j: f64,
    frame: StructureFrame,
}

/// Fabric in the wind at a sample.
pub(super) struct InWind {
    fabric: Fabric,
    wind_m_s: f64,
    pub forces: Forces,
    slip_ratio: f64,
}

impl Fabric {
    /// A sample; `None` where there is none.
    pub fn new(simulation: &Simulation) -> Option<Self> {
        Some(Self {
            time_s: simulation.time_s(),
            kinetic_energy_j: simulation.cloth()?.kinetic_energy_j(),
            frame: simulation.structure_frame().structure?,
        })
    }

    fn tension_max_n_m(&self) -> f64 {
        largest(self.frame.principal_tensions_n_m.iter().map(|t| t[0]))
    }

    fn speeds_m_s(&self) -> impl Iterator<Item = f64> {
        self.frame.velocities_m_s.iter().map(|v| v.length())
    }
}

impl InWind {
    /// A sample; `None` where there is no fabric in air.
    pub fn new(simulation: &Simulation, forces: Forces) -> Result<Option<Self>, DeviceError> {
        let (Some(fabric), Some(coupled), Some(air)) = (
            Fabric::new(simulation),
            simulation.coupled(),
            &simulation.scene().air,
        ) else {
            return Ok(None);
        };
        Ok(Some(Self {
            fabric,
            wind_m_s: simulation.wind_speed_m_s(),
            forces,
            slip_ratio: coupled.slip_m_s()?.unwrap_or(f64::NAN) / air.wind_or_reference_m_s(),
        }))
    }
}

/// Means over the second half of the run; of a plate over its own window, with intervals.
pub(super) fn in_wind(results: &mut Results, record: &Record, scene: &Scene) {
    let times = record.column(&TIME);
    let Some(first) = second_half(&times) else {
        results.insert(
            &FORCE_X,
            Quantity::missing("the run ended before two samples after the release"),
        );
        return;
    };
    let plate = scene.plate().zip(scene.air.as_ref());
    let window = plate.and_then(|(plate, air)| plate::Window::new(record, plate, air));
    let first = window.as_ref().map_or(first, plate::Window::first);
    let part = format!(
        "mean from {:.4} s on",
        times.get(first).copied().unwrap_or(f64::NAN)
    );
    for column in IN_WIND.reduced(scene, Mean) {
        let mean = match &window {
            Some(window) => window.mean(record, column),
            None => Quantity::new(average(&record.column(column)[first..])),
        };
        results.insert(column, mean.with_note(&part));
    }
    let defects = record.column(&MASS_DEFECT);
    let since_release = defects.get(1..).unwrap_or_default();
    results.insert(&MASS_DRIFT, mass_drift(since_release));
}

/// Fabric and cables without air; where they `rest` as the case builds them, exact values stand beside.
pub(super) fn alone(
    results: &mut Results,
    kind: &BodyKind,
    structure: &StructureFrame,
    (weight_n, rests): (f64, bool),
) {
    let lowest = structure
        .positions_m
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    let highest = structure
        .positions_m
        .iter()
        .map(|p| p.z)
        .fold(f64::NEG_INFINITY, f64::max);
    tension_results(results, structure);
    if let BodyKind::Cable(HangingCable {
        span_m,
        length_m,
        weight_n_m,
        hangs_by_itself,
    }) = *kind
    {
        let exact =
            catenary::solve(span_m, length_m, weight_n_m).filter(|_| rests && hangs_by_itself);
        let source = "exact catenary of an inextensible cable";
        let tensions = &structure.cable_tensions_n;
        let mut insert = |read_out: &ReadOut, value: f64, exact: Option<f64>| {
            let quantity = Quantity::new(value);
            results.insert(
                read_out,
                match exact {
                    Some(exact) => quantity.with_reference(exact, source),
                    None => quantity,
                },
            );
        };
        insert(&SAG, highest - lowest, exact.map(|c| c.sag_m));
        let middle = tensions.iter().copied().fold(f64::INFINITY, f64::min);
        let horizontal_n = exact.map(|c| c.horizontal_tension_n);
        insert(&HORIZONTAL_TENSION, middle, horizontal_n);
        // A segment's tension belongs to its middle; the support also carries the half segment next to it.
        let (first, tension) = (structure.cables[0], tensions[0]);
        let [a, b] = first.map(|n| structure.positions_m[n as usize]);
        let pull = (b - a).normalize_or_zero() * tension;
        let half_weight = 0.5 * weight_n_m * length_m / tensions.len() as f64;
        let end = (pull - DVec3::Z * half_weight).length();
        insert(&END_TENSION, end, exact.map(|c| c.end_tension_n));
        return;
    }
    specimen_results(results, kind, structure);
    results.insert(&LOWEST_POINT, Quantity::new(lowest));
    results.insert(&HIGHEST_POINT, Quantity::new(highest));
    let springs = "springs carry no membrane tension";
    for (read_out, value) in [
        (
            &TENSION_MAX,
            largest(structure.principal_tensions_n_m.iter().map(|t| t[0])),
        ),
        (&STRESS_MAX, largest(structure.stress_pa.iter().copied())),
        (
            &TRUE_STRESS_MAX,
            largest(structure.true_stress_pa.iter().copied()),
        ),
        (
            &VON_MISES_MAX,
            largest(structure.von_mises_pa.iter().copied()),
        ),
        (
            &SHEAR_STRESS_MAX,
            largest(structure.shear_stress_pa.iter().map(|s| s.abs())),
        ),
    ] {
        let quantity = if value.is_nan() {
            Quantity::missing(springs)
        } else {
            Quantity::new(value)
        };
        results.insert(read_out, quantity);
    }
    let has_stress = structure.von_mises_pa.iter().any(|stress| !stress.is_nan());
    let of_membrane = |value: f64| {
        if has_stress {
            Quantity::new(value)
        } else {
            Quantity::missing(springs)
        }
    };
    let area: f64 = structure.rest_areas_m2.iter().sum();
    let share = |is_counted: &dyn Fn(usize) -> bool| {
        let areas = structure.rest_areas_m2.iter().enumerate();
        areas
            .filter(|(triangle, _)| is_counted(*triangle))
            .map(|(_, area)| area)
            .sum::<f64>()
            / area
    };
    for (read_out, state) in [
        (&WRINKLED_SHARE, FabricState::Wrinkled),
        (&SLACK_SHARE, FabricState::Slack),
    ] {
        let value = share(&|triangle| structure.states[triangle] == state);
        results.insert(read_out, of_membrane(value));
    }
    if let Some(yield_pa) = structure.yield_stress_pa {
        let value = share(&|triangle| structure.von_mises_pa[triangle] > yield_pa);
        results.insert(&YIELDING_SHARE, of_membrane(value));
    }
    results.insert(&WEIGHT, Quantity::new(weight_n));
}

/// Largest tensions of the kinds of cables that there are.
fn tension_results(results: &mut Results, structure: &StructureFrame) {
    let lines = [CableKind::SuspensionLine, CableKind::GapLine];
    for (read_out, kinds) in [
        (&LINE_TENSION_MAX, &lines[..]),
        (&BELT_TENSION_MAX, &[CableKind::Belt]),
        (&VENT_LINE_TENSION_MAX, &[CableKind::VentLine]),
        (&RISER_TENSION_MAX, &[CableKind::Riser]),
        (&CABLE_TENSION_MAX, &[CableKind::Cable]),
    ] {
        if let Some(tension_n) = structure.largest_tension_n(kinds) {
            results.insert(read_out, Quantity::new(tension_n));
        }
    }
}

/// What airbags and coupons are made for.
fn specimen_results(results: &mut Results, kind: &BodyKind, structure: &StructureFrame) {
    let place = |node: u32| structure.positions_m[node as usize];
    match kind {
        BodyKind::Airbag(Airbag { middles }) => {
            let [up, down] = middles.map(place);
            results.insert(
                &HALF_HEIGHT,
                Quantity::new(0.5 * (up.z - down.z)).with_note("in the middle"),
            );
        }
        BodyKind::Coupon(coupon) => {
            let [a, b] = coupon.gauge.map(place);
            let strain = a.distance(b) / coupon.gauge_length_m - 1.0;
            // Both clamps pull alike.
            let pull = 0.5 * structure.reactions_n.iter().map(|f| f.x.abs()).sum::<f64>();
            results.insert(&PULL, Quantity::new(pull));
            results.insert(
                &GAUGE_STRAIN,
                Quantity::new(strain).with_note("middle third of the length"),
            );
            results.insert(
                &MODULUS,
                Quantity::new(pull / coupon.cross_section_m2 / strain),
            );
        }
        BodyKind::Plate(shape) => {
            let tip = place(shape.tip()) - shape.flat_tip_m();
            for (read_out, value) in plate::TIP.into_iter().zip(tip.to_array()) {
                let note = "middle of the free edge, from where the flat plate has it";
                results.insert(read_out, Quantity::new(value).with_note(note));
            }
        }
        BodyKind::Canopy(_)
        | BodyKind::Sheet
        | BodyKind::Cable { .. }
        | BodyKind::Mesh
        | BodyKind::Wing(_)
        | BodyKind::ImportedWing(_) => {}
    }
}
