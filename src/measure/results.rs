//! Named results of a run.

use glam::DVec3;

use super::record::largest as largest_of;
use super::statistics::{Mean, slope};
use super::{Record, bodies, catenary, plate, wing};
use crate::case::scene::{Air, BodyKind, Canopy, Flow};
use crate::frame::{CableKind, FabricState, StructureFrame};
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;
use crate::steady::{self, SHORTEST_WINDOW, Window};

/// Blockage factor K of Macha & Buffington 1990, q_corrected/q = 1 + K C_D S/C.
const BLOCKAGE_FACTOR: f64 = 1.85;

/// Drag coefficient below which relative differences of forces mean nothing.
const NO_DRAG: f64 = 1e-3;

/// All results that the scene defines.
#[must_use]
pub fn results(simulation: &Simulation, record: &Record) -> Results {
    let mut results = Results::new();
    let scene = simulation.scene();
    let frame = simulation.structure_frame();
    match (&scene.body, &scene.air) {
        (Some(body), Some(air)) => {
            if let BodyKind::Canopy(canopy) = &body.kind {
                canopy_results(&mut results, record, canopy, air);
            } else {
                fabric_in_wind_results(&mut results, record);
            }
            if let BodyKind::Plate(shape) = &body.kind {
                plate::results(&mut results, record, shape, air);
            }
        }
        (Some(body), None) => {
            if let Some(structure) = &frame.structure {
                let weight: f64 = body.structure.masses_kg.iter().sum::<f64>()
                    * scene.gravity_m_s2.map_or(0.0, DVec3::length);
                body_results(&mut results, &body.kind, structure, weight);
                if let Some(known) = &scene.wing {
                    let gravity = scene.gravity_m_s2.unwrap_or(DVec3::ZERO);
                    let mass: f64 = body.structure.masses_kg.iter().sum();
                    wing::results(&mut results, known, structure, gravity * mass);
                }
            }
        }
        (None, Some(air)) if !scene.rigid_bodies.is_empty() => {
            bodies::scene_results(&mut results, record, scene, air);
        }
        (None, Some(air)) => air_results(&mut results, record, air),
        (None, None) => {}
    }
    through_results(&mut results, record);
    if scene.descent.is_some() {
        fall_results(&mut results, record);
    }
    line_drag_results(&mut results, record);
    contact_results(&mut results, record);
    if let (Some(_), Some(air)) = (&scene.body, &scene.air) {
        bodies::body_results(&mut results, record, scene, air);
    }
    results
}

/// What falls: largest load factor, speed at the end, height.
fn fall_results(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    let (time, factor) = column_max(record, "load_factor_g", released);
    results.insert(
        "peak_load_factor_g",
        if factor.is_finite() {
            Quantity::new(factor, "1")
                .with_note(&format!("mean of a sample interval, at {time:.4} s"))
        } else {
            Quantity::missing("1", "the run ended before two samples")
        },
    );
    let speeds = record.column("descent_speed_m_s");
    let last = times
        .len()
        .saturating_sub((times.len() - released).div_ceil(4));
    if let Some(end) = speeds.get(last..).filter(|end| !end.is_empty()) {
        let mean = end.iter().sum::<f64>() / end.len() as f64;
        let change = end.last().unwrap_or(&mean) - end.first().unwrap_or(&mean);
        results.insert(
            "terminal_speed_m_s",
            Quantity::new(mean, "m/s").with_note(&format!(
                "mean of the last quarter of the run, in which it changed by {change:.3} m/s"
            )),
        );
    }
    if let Some(height) = record.latest("height_fallen_m") {
        results.insert("height_fallen_m", Quantity::new(height, "m"));
    }
}

/// Drag of suspension lines, mean over the second half of the run.
fn line_drag_results(results: &mut Results, record: &Record) {
    let values = record.column("line_drag_n");
    let Some(half) = values
        .get(values.len() / 2..)
        .filter(|half| !half.is_empty())
    else {
        return;
    };
    let mean = half.iter().sum::<f64>() / half.len() as f64;
    results.insert(
        "line_drag_n",
        Quantity::new(mean, "N")
            .with_note("along the wind, second half of the run; not given to the air"),
    );
}

/// What passes permeable surfaces: means over the second half of the run.
fn through_results(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let Some(released) = times.iter().position(|&t| t > 0.0) else {
        return;
    };
    let first = released.midpoint(times.len());
    for (name, what) in [
        ("through_velocity_m_s", "along the normals of the triangles"),
        (
            "through_velocity_of_slip_m_s",
            "what residual slip adds: the permeability of the method itself",
        ),
    ] {
        let values = record.column(name);
        if let Some(values) = values.get(first..).filter(|values| !values.is_empty()) {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let note = format!("mean over the permeable area, second half of the run; {what}");
            results.insert(name, Quantity::new(mean, "m/s").with_note(&note));
        }
    }
}

/// Where fabric meets itself.
fn contact_results(results: &mut Results, record: &Record) {
    let gaps = record.column("smallest_gap_m");
    if gaps.is_empty() {
        return;
    }
    // f64::min passes over samples in which nothing is near.
    let smallest = gaps.into_iter().fold(f64::INFINITY, f64::min);
    let gap = if smallest.is_finite() {
        Quantity::new(smallest, "m").with_note("smallest of all samples, between middle surfaces")
    } else {
        Quantity::missing(
            "m",
            "no fabric came closer to other fabric than contact.thickness_m",
        )
    };
    results.insert("smallest_gap_m", gap);
    let energies = record.column("contact_energy_j");
    let largest = energies.into_iter().fold(0.0, f64::max);
    results.insert(
        "contact_energy_max_j",
        Quantity::new(largest, "J").with_note("largest of all samples"),
    );
}

fn quantity(mean: Mean, unit: &str) -> Quantity {
    let quantity = Quantity::new(mean.value, unit);
    match mean.confidence {
        Some(confidence) => quantity.with_confidence(confidence),
        None => quantity,
    }
}

fn canopy_results(results: &mut Results, record: &Record, canopy: &Canopy, air: &Air) {
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let Some(window) = steady::window(record, unit_s) else {
        results.insert(
            "drag_coefficient",
            Quantity::missing("1", "the run ended before release"),
        );
        return;
    };
    let indicative = (!window.settled || window.length < SHORTEST_WINDOW).then(|| {
        format!(
            "window of {:.1} D_0/U{}; {SHORTEST_WINDOW} after settling are needed: means of this run are indicative only",
            window.length,
            if window.settled { "" } else { ", not settled" }
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
    let section = air.cells[1] as f64 * air.cells[2] as f64 * air.units.cell_size_m.powi(2);
    let blockage = canopy.nominal_area_m2 / section;
    let corrected = 1.0 + BLOCKAGE_FACTOR * drag.value * blockage;
    let corrected_drag = Mean {
        value: drag.value / corrected,
        confidence: drag.confidence.map(|c| c / (corrected * corrected)),
    };
    results.insert(
        "drag_coefficient_blockage_corrected",
        if wind {
            quantity(corrected_drag, "1")
                .with_note("Macha & Buffington 1990, factor 1.85 on C_D S_0 / section")
        } else {
            Quantity::missing("1", "there is no wind to refer to")
        },
    );
    results.insert("blockage_ratio", Quantity::new(blockage, "1"));
    let ratio = mean("projected_diameter_ratio");
    results.insert("projected_diameter_ratio", quantity(ratio, "1"));
    let ratios = record.column("projected_diameter_ratio");
    let times = record.column("time_s");
    let released = times.iter().position(|&t| t >= 0.0).unwrap_or(0);
    results.insert(
        "projected_diameter_ratio_at_release",
        Quantity::new(ratios[released], "1"),
    );
    match window.peak {
        Some(peak) => {
            results.insert("first_peak_time_s", Quantity::new(times[peak], "s"));
            results.insert(
                "first_peak_projected_diameter_ratio",
                Quantity::new(ratios[peak], "1"),
            );
        }
        None => results.insert(
            "first_peak_time_s",
            Quantity::missing("s", "no peak of the projected diameter yet"),
        ),
    }
    let filled = (released..times.len()).find(|&i| ratios[i] >= ratio.value);
    results.insert(
        "fill_time_s",
        match filled {
            Some(_) if window.peak.is_none() => Quantity::missing(
                "s",
                "no peak of the projected diameter yet: the canopy was not seen full",
            ),
            Some(i) => Quantity::new(times[i], "s"),
            None => Quantity::missing("s", "the projected diameter never reached its mean"),
        },
    );
    results.insert("height_m", quantity(mean("height_m"), "m"));
    results.insert(
        "line_tension_mean_n",
        quantity(mean("line_tension_mean_n"), "N"),
    );
    largest(results, record, released, "line_tension_max_n", "N");
    largest(results, record, released, "stress_max_pa", "Pa");
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
        results.insert(
            "opening_force_factor",
            Quantity::new(peak.1 / drag.value, "1"),
        );
    }
    insert_balances(results, record, &window, released, drag.value);
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

/// Means over the second half of the run.
fn fabric_in_wind_results(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let Some(first) = times.iter().position(|&t| t > 0.0) else {
        results.insert(
            "force_x_n",
            Quantity::missing("N", "the run ended before release"),
        );
        return;
    };
    let first = first.midpoint(times.len());
    let half = format!(
        "mean from {:.4} s on",
        times.get(first).copied().unwrap_or(f64::NAN)
    );
    for (name, unit) in [
        ("force_x_n", "N"),
        ("force_y_n", "N"),
        ("force_z_n", "N"),
        ("force_x_momentum_box_n", "N"),
        ("tension_max_n_m", "N/m"),
        ("slip_ratio", "1"),
    ] {
        let values = &record.column(name)[first..];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        results.insert(name, Quantity::new(mean, unit).with_note(&half));
    }
    let defect = largest_of(
        record
            .column("mass_defect")
            .into_iter()
            .skip(1)
            .map(f64::abs),
    );
    results.insert("mass_drift", Quantity::new(defect, "1"));
}

/// (time, value) of the largest entry from `first` on.
fn column_max(record: &Record, name: &str, first: usize) -> (f64, f64) {
    let times = record.column("time_s");
    record.column(name).into_iter().zip(times).skip(first).fold(
        (0.0, f64::NEG_INFINITY),
        |best, (value, time)| {
            if value > best.1 { (time, value) } else { best }
        },
    )
}

fn largest(results: &mut Results, record: &Record, first: usize, name: &str, unit: &str) {
    let (time, value) = column_max(record, name, first);
    results.insert(
        name,
        Quantity::new(value, unit).with_note(&format!("largest of the run, at {time:.4} s")),
    );
}

fn body_results(results: &mut Results, kind: &BodyKind, structure: &StructureFrame, weight_n: f64) {
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
    if let BodyKind::Cable {
        span_m,
        length_m,
        weight_n_m,
    } = *kind
    {
        let exact = catenary::solve(span_m, length_m, weight_n_m);
        let source = "exact catenary of an inextensible cable";
        let tensions = &structure.cable_tensions_n;
        let mut insert = |name: &str, value: f64, unit: &str, exact: Option<f64>| {
            let quantity = Quantity::new(value, unit);
            results.insert(
                name,
                match exact {
                    Some(exact) => quantity.with_reference(exact, source),
                    None => quantity,
                },
            );
        };
        insert("sag_m", highest - lowest, "m", exact.map(|c| c.sag_m));
        let middle = tensions.iter().copied().fold(f64::INFINITY, f64::min);
        insert(
            "horizontal_tension_n",
            middle,
            "N",
            exact.map(|c| c.horizontal_tension_n),
        );
        // A segment's tension belongs to its middle; the support also carries the half segment next to it.
        let (first, tension) = (structure.cables[0], tensions[0]);
        let [a, b] = first.map(|n| structure.positions_m[n as usize]);
        let pull = (b - a).normalize_or_zero() * tension;
        let half_weight = 0.5 * weight_n_m * length_m / tensions.len() as f64;
        let end = (pull - DVec3::Z * half_weight).length();
        insert("end_tension_n", end, "N", exact.map(|c| c.end_tension_n));
        return;
    }
    specimen_results(results, kind, structure);
    results.insert("lowest_point_m", Quantity::new(lowest, "m"));
    results.insert("highest_point_m", Quantity::new(highest, "m"));
    let springs = "springs carry no membrane tension";
    for (name, unit, value) in [
        (
            "tension_max_n_m",
            "N/m",
            largest_of(structure.principal_tensions_n_m.iter().map(|t| t[0])),
        ),
        (
            "stress_max_pa",
            "Pa",
            largest_of(structure.stress_pa.iter().copied()),
        ),
        (
            "von_mises_max_pa",
            "Pa",
            largest_of(structure.von_mises_pa.iter().copied()),
        ),
        (
            "shear_stress_max_pa",
            "Pa",
            largest_of(structure.shear_stress_pa.iter().map(|s| s.abs())),
        ),
    ] {
        let quantity = if value.is_nan() {
            Quantity::missing(unit, springs)
        } else {
            Quantity::new(value, unit)
        };
        results.insert(name, quantity);
    }
    let area: f64 = structure.rest_areas_m2.iter().sum();
    let share = |is_counted: &dyn Fn(usize) -> bool| {
        let areas = structure.rest_areas_m2.iter().enumerate();
        areas
            .filter(|(triangle, _)| is_counted(*triangle))
            .map(|(_, area)| area)
            .sum::<f64>()
            / area
    };
    for (name, state) in [
        ("wrinkled_area_share", FabricState::Wrinkled),
        ("slack_area_share", FabricState::Slack),
    ] {
        let value = share(&|triangle| structure.states[triangle] == state);
        results.insert(name, Quantity::new(value, "1"));
    }
    if let Some(yield_pa) = structure.yield_stress_pa {
        let value = share(&|triangle| structure.von_mises_pa[triangle] > yield_pa);
        results.insert("yielding_area_share", Quantity::new(value, "1"));
    }
    results.insert("weight_n", Quantity::new(weight_n, "N"));
    if structure.cable_kinds.contains(&CableKind::SuspensionLine) {
        let tension = structure
            .cable_tensions_n
            .iter()
            .copied()
            .fold(0.0, f64::max);
        results.insert("line_tension_max_n", Quantity::new(tension, "N"));
    }
}

/// What airbags and coupons are made for.
fn specimen_results(results: &mut Results, kind: &BodyKind, structure: &StructureFrame) {
    let place = |node: u32| structure.positions_m[node as usize];
    match kind {
        BodyKind::Airbag { middles } => {
            let [up, down] = middles.map(place);
            results.insert(
                "half_height_m",
                Quantity::new(0.5 * (up.z - down.z), "m").with_note("in the middle"),
            );
        }
        BodyKind::Coupon(coupon) => {
            let [a, b] = coupon.gauge.map(place);
            let strain = a.distance(b) / coupon.gauge_length_m - 1.0;
            // Both clamps pull alike.
            let pull = 0.5 * structure.reactions_n.iter().map(|f| f.x.abs()).sum::<f64>();
            results.insert("pull_n", Quantity::new(pull, "N"));
            results.insert(
                "gauge_strain",
                Quantity::new(strain, "1").with_note("middle third of the length"),
            );
            results.insert(
                "modulus_pa",
                Quantity::new(pull / coupon.cross_section_m2 / strain, "Pa"),
            );
        }
        BodyKind::Plate(shape) => {
            let tip = place(shape.tip()) - shape.flat_tip_m();
            for (name, value) in plate::COLUMNS.iter().zip(tip.to_array()) {
                let note = "middle of the free edge, from where the flat plate has it";
                results.insert(name, Quantity::new(value, "m").with_note(note));
            }
        }
        BodyKind::Canopy(_)
        | BodyKind::Sheet
        | BodyKind::Cable { .. }
        | BodyKind::Mesh
        | BodyKind::Wing => {}
    }
}

fn air_results(results: &mut Results, record: &Record, air: &Air) {
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
