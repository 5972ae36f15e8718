//! Which flows past bluff bodies stand: bodies in a tunnel, over body, resolution, Reynolds number and speed on the lattice.
//!
//! A sphere, a square plate normal to the wind, a thick profile at 5° and the shipped flat circular canopy stand in a tunnel of 5 × 3 × 3 D
//! with the faces of shipped cases. The wind rises over 1 D/U. [`Flow::outcome`] follows one such flow; [`matrix`] follows many with the operator that
//! is meant to stand them all, and [`super::stability`] looks for the fastest flow that each operator stands.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::{Engine, Stop, Watch, go_on, write_rows};
use crate::case::{self, Case, Choices};
use crate::geometry::profile::Profile;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::lattice::stability::Body;
use crate::measure::extremes::largest;
use crate::output::write_atomically;
use crate::plan::{Placement, Plan, Precision};
use crate::simulation::{Failure, Simulation};

/// Length, width and height of the tunnel [D].
const TUNNEL: [f64; 3] = [5.0, 3.0, 3.0];

/// From the inlet to the middle of a body [D].
const UPSTREAM: f64 = 1.5;

/// Distances from the middle of the tunnel: nothing is symmetric on the lattice [D].
const ASIDE: [f64; 2] = [0.03, 0.05];

/// Points of the profile per side, and along its span of one chord.
const PROFILE_POINTS: usize = 24;

/// A cell faster than this makes a flow one that does not stand [U].
const FASTEST: f64 = 6.0;

/// The same for flows that stand well [U]; and the Mach number on the lattice.
const WANTED_FASTEST: f64 = 3.0;
const WANTED_MACH: f64 = 0.4;

/// Factor within which the mean energy of the last quarter is that of the quarter before.
const WANTED_TREND: f64 = 1.25;

/// Nominal diameter and wind of the canopy [m, m/s].
const CANOPY_DIAMETER_M: f64 = 0.996_56;
const CANOPY_WIND_M_S: f64 = 30.0;

/// A flow past a body.
#[derive(Debug, Clone, Copy)]
pub struct Flow {
    /// What stands in it.
    pub body: Body,
    /// Cells per diameter, side, chord or D_0.
    pub cells: usize,
    /// U D/ν.
    pub reynolds: f64,
    /// Cells per step at U.
    pub lattice_speed: f64,
    /// Collision operator.
    pub operator: Operator,
    /// Eddy viscosity, if any.
    pub eddy_viscosity: Option<EddyViscosity>,
    /// Time after the wind has risen [D/U].
    pub end: f64,
}

/// How a flow ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Time that was reached [D/U].
    pub time: f64,
    /// True if it was the end asked for.
    pub stands: bool,
    /// Fastest cell of all looks, one per D/U [U].
    pub fastest: f64,
    /// Mean over the last quarter of Σ |u − U|² over that of the quarter before; NaN where the flow broke down.
    pub energy_trend: f64,
}

/// One row of the matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Engine and precision.
    pub engine: String,
    /// Collision operator.
    pub operator: Operator,
    /// What stands in the wind.
    pub body: Body,
    /// Cells per diameter, side, chord or D_0.
    pub cells: usize,
    /// U D/ν.
    pub reynolds: f64,
    /// Cells per step at U.
    pub lattice_speed: f64,
    /// τ − ½.
    pub viscous_part: f64,
    /// Time that was reached [D/U].
    pub time: f64,
    /// True if the flow stood to the end.
    pub stands: bool,
    /// Fastest cell [U].
    pub fastest: f64,
    /// Its Mach number on the lattice.
    pub fastest_mach: f64,
    /// See [`Outcome::energy_trend`].
    pub energy_trend: f64,
    /// By the clock [s].
    pub seconds: f64,
}

impl Flow {
    /// τ − ½.
    #[must_use]
    pub fn viscous_part(&self) -> f64 {
        3.0 * self.lattice_speed * self.cells as f64 / self.reynolds
    }

    /// Follows the flow on an engine. Files that the body needs are written into `folder`.
    ///
    /// # Errors
    /// Where the device fails, the case is refused or the user interrupts; a flow that breaks down is no error.
    pub fn outcome(
        &self,
        engine: &Engine,
        folder: &Path,
        interrupt: &AtomicBool,
    ) -> Result<Outcome, Stop> {
        let case = self.case(folder)?;
        let (wind_m_s, diameter_m) = self.scales();
        let step_s = case
            .scene
            .time
            .map_or(f64::NAN, |time| time.step_s * wind_m_s / diameter_m);
        let placement = Placement {
            air: engine.placement,
            ..Placement::from(Precision::F32)
        };
        let plan = Plan::new(&case.scene, placement);
        let start = plan.start_steps;
        let end = start + plan.steps;
        let look_every = (1.0 / step_s).round() as u64;
        let mut simulation = Simulation::new(case.scene, plan, engine.device.clone())?;
        let (mut fastest, mut energies) = (0.0_f64, Vec::new());
        let after = |step: u64| (step.saturating_sub(start)) as f64 * step_s;
        let broken = |step: u64, fastest: f64| Outcome {
            time: after(step),
            stands: false,
            fastest,
            energy_trend: f64::NAN,
        };
        while simulation.step_count() < end {
            let step = simulation.step_count() + 1;
            match simulation.advance_among_threads() {
                Ok(()) => {}
                Err(Failure::Diverged(_)) => return Ok(broken(step, fastest)),
                Err(failure) => return Err(failure.into()),
            }
            if step <= start || !(step - start).is_multiple_of(look_every) {
                continue;
            }
            go_on(interrupt)?;
            let frame = simulation.frame(true)?;
            let Some(air) = &frame.fluid else { continue };
            let (speed, energy) = speed_and_energy(&air.velocity_m_s, wind_m_s);
            fastest = fastest.max(speed);
            energies.push(energy);
            if !speed.is_finite() || speed > FASTEST {
                return Ok(broken(step, fastest));
            }
        }
        Ok(Outcome {
            time: after(end),
            stands: true,
            fastest,
            energy_trend: trend(&energies),
        })
    }

    /// Wind [m/s] and diameter [m] of the case.
    const fn scales(&self) -> (f64, f64) {
        match self.body {
            Body::Canopy => (CANOPY_WIND_M_S, CANOPY_DIAMETER_M),
            Body::Sphere | Body::Plate | Body::Profile => (1.0, 1.0),
        }
    }

    fn case(&self, folder: &Path) -> Result<Case, Stop> {
        let refused = |error: Box<case::CaseError>| Stop::Refused(error.to_string());
        let choices = Choices::default();
        let mut case = match self.body {
            Body::Canopy => self.canopy(),
            Body::Profile => {
                write_profile(&folder.join(PROFILE_FILE))?;
                case::parse("profile", &self.source(), folder, &choices)
            }
            Body::Sphere | Body::Plate => case::parse("body", &self.source(), folder, &choices),
        }
        .map_err(refused)?;
        // What a case file refuses is what is to be measured.
        if let Some(air) = &mut case.scene.air {
            air.operator = self.operator;
            air.eddy_viscosity = self.eddy_viscosity;
        }
        Ok(case)
    }

    /// Lengths in D, speeds in U.
    fn source(&self) -> String {
        let [length, width, height] = TUNNEL;
        let (shape, rotation) = match self.body {
            Body::Sphere => ("[bodies.body.sphere]\ndiameter_m = 1.0".to_owned(), ""),
            Body::Plate => ("[bodies.body.plate]\nsize_m = [1.0, 1.0]".to_owned(), ""),
            Body::Profile | Body::Canopy => (
                format!("[bodies.body.mesh]\nfile = \"{PROFILE_FILE}\"\nscale = 1.0"),
                "[bodies.body.rotation]\naxis = [0.0, 1.0, 0.0]\nangle_deg = 5.0",
            ),
        };
        format!(
            r#"version = 1
title = "A body in a tunnel"
[air]
density_kg_m3 = 1.0
kinematic_viscosity_m2_s = {viscosity:?}
[air.wind_tunnel]
speed_m_s = 1.0
size_m = [{length:?}, {width:?}, {height:?}]
start_time_s = 1.0
sponge_length_m = 1.0
[resolution]
cell_size_m = {cell:?}
lattice_speed = {lattice_speed:?}
operator = "stabilised_regularised"
[bodies.body]
position_m = [{UPSTREAM:?}, {y:?}, {z:?}]
{shape}
{rotation}
[bodies.body.reference]
area_m2 = 1.0
length_m = 1.0
[coupling]
over_relaxation = 1.6
surface_inset_cells = 0.0
[time]
end_s = {end:?}
[output]
sample_interval_s = 1.0
"#,
            viscosity = 1.0 / self.reynolds,
            cell = 1.0 / self.cells as f64,
            lattice_speed = self.lattice_speed,
            y = 0.5 * width + ASIDE[0],
            z = 0.5 * height + ASIDE[1],
            end = self.end,
        )
    }

    fn canopy(&self) -> Result<Case, Box<case::CaseError>> {
        let (wind_m_s, diameter_m) = self.scales();
        let choices = Choices {
            variant: None,
            overrides: vec![
                format!("resolution.cells_per_diameter={:?}", self.cells as f64),
                format!("resolution.lattice_speed={:?}", self.lattice_speed),
                "resolution.operator=\"stabilised_regularised\"".to_owned(),
                format!(
                    "air.kinematic_viscosity_m2_s={:?}",
                    wind_m_s * diameter_m / self.reynolds
                ),
                format!("time.end_s={:?}", self.end * diameter_m / wind_m_s),
                "steady=absent".to_owned(),
                "coupling.scheme=kernel".to_owned(),
            ],
        };
        let source = include_str!("../../cases/flat-circular-tunnel.toml");
        case::parse("flat-circular-tunnel", source, Path::new("."), &choices)
    }
}

/// Fastest cell [U] and Σ |u − U|² [U²]; NaN where a cell is not finite.
fn speed_and_energy(velocities_m_s: &[[f32; 3]], wind_m_s: f64) -> (f64, f64) {
    let (mut fastest, mut energy) = (0.0_f64, 0.0);
    for velocity in velocities_m_s {
        let [x, y, z] = velocity.map(|v| f64::from(v) / wind_m_s);
        let across = y * y + z * z;
        let square = x * x + across;
        if !square.is_finite() {
            return (f64::NAN, f64::NAN);
        }
        fastest = fastest.max(square);
        energy += (x - 1.0).powi(2) + across;
    }
    (fastest.sqrt(), energy)
}

/// Mean of the last quarter over that of the quarter before.
fn trend(values: &[f64]) -> f64 {
    let quarter = values.len() / 4;
    let (before, last) = values[values.len() - 2 * quarter..].split_at(quarter);
    last.iter().sum::<f64>() / before.iter().sum::<f64>()
}

const PROFILE_FILE: &str = "naca-0020.obj";

/// A wing of one chord's span with the profile NACA 0020 and flat ends, its middle at the origin, as an OBJ file.
fn write_profile(path: &Path) -> Result<(), Stop> {
    let refused = |what: String| Stop::Refused(what);
    let profile = Profile::naca("0020").map_err(|error| refused(error.to_string()))?;
    // The last point is the first.
    let mut section = profile.resampled(PROFILE_POINTS);
    section.pop();
    let count = section.len();
    let mut text = String::new();
    let spans = PROFILE_POINTS;
    for j in 0..=spans {
        let y = j as f64 / spans as f64 - 0.5;
        for point in &section {
            let _ = writeln!(text, "v {} {y} {}", point.x - 0.5, point.y);
        }
    }
    let node = |i: usize, j: usize| j * count + i % count + 1;
    for j in 0..spans {
        for i in 0..count {
            let [a, b, c, d] = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    // Both ends: strips between the lower and the upper side.
    for (j, turned) in [(0, true), (spans, false)] {
        let mut face = |a: usize, b: usize, c: usize| {
            let [b, c] = if turned { [c, b] } else { [b, c] };
            let _ = writeln!(text, "f {} {} {}", node(a, j), node(b, j), node(c, j));
        };
        for i in 0..count / 2 {
            let (lower, upper) = ([i, i + 1], [count - i, count - i - 1]);
            if i > 0 {
                face(lower[0], lower[1], upper[0]);
            }
            if lower[1] != upper[1] {
                face(lower[1], upper[1], upper[0]);
            }
        }
    }
    let unchanged = fs::read_to_string(path).is_ok_and(|known| known == text);
    if !unchanged {
        write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}

/// The flows of the matrix, cheap ones first.
#[must_use]
pub fn flows(full: bool) -> Vec<Flow> {
    let (cells, reynolds, end): (&[usize], &[f64], f64) = if full {
        (&[8, 12, 16, 24], &[1e4, 1e5, 1e6, 2e6], 100.0)
    } else {
        (&[8, 12], &[1e4, 2e6], 60.0)
    };
    let mut flows = Vec::new();
    for &cells in cells {
        for body in Body::ALL {
            // Fewer cells hold no canopy; a quick look takes none.
            if body == Body::Canopy && (!full || cells < 12) {
                continue;
            }
            for &reynolds in reynolds {
                for lattice_speed in [0.15, 0.1, 0.05] {
                    flows.push(Flow {
                        body,
                        cells,
                        reynolds,
                        lattice_speed,
                        operator: Operator::StabilisedRegularised,
                        eddy_viscosity: None,
                        end,
                    });
                }
            }
        }
    }
    flows
}

/// Follows all flows of the matrix on an engine; writes `bluff-bodies.csv` into `folder` after every flow.
pub fn matrix(
    full: bool,
    engine: &Engine,
    folder: &Path,
    watch: &mut Watch,
) -> Result<Vec<Row>, Stop> {
    let flows = flows(full);
    let mut rows = Vec::new();
    for (done, flow) in flows.iter().enumerate() {
        watch
            .observer
            .progress(done as u64, flows.len() as u64, "bluff bodies");
        let began = Instant::now();
        let outcome = flow.outcome(engine, folder, watch.interrupt)?;
        rows.push(Row {
            engine: engine.name(),
            operator: flow.operator,
            body: flow.body,
            cells: flow.cells,
            reynolds: flow.reynolds,
            lattice_speed: flow.lattice_speed,
            viscous_part: flow.viscous_part(),
            time: outcome.time,
            stands: outcome.stands,
            fastest: outcome.fastest,
            fastest_mach: outcome.fastest * flow.lattice_speed * 3f64.sqrt(),
            energy_trend: outcome.energy_trend,
            seconds: began.elapsed().as_secs_f64(),
        });
        write_rows(&folder.join("bluff-bodies.csv"), &rows)?;
    }
    Ok(rows)
}

/// The matrix in words: how many stand, and a line for each body, number of cells and speed, worst over the Reynolds numbers.
#[must_use]
pub fn table(rows: &[Row]) -> String {
    let standing = rows.iter().filter(|row| row.stands).count();
    let mut text = format!(
        "{standing} of {} flows stand; worst over the Reynolds numbers:\n{:<9}{:>6}{:>8}{:>9}{:>11}{:>8}{:>15}\n",
        rows.len(),
        "body",
        "cells",
        "speed",
        "stands",
        "fastest/U",
        "Mach",
        "energy trend"
    );
    let mut known: Vec<(Body, usize, f64)> = Vec::new();
    for row in rows {
        let key = (row.body, row.cells, row.lattice_speed);
        if known.contains(&key) {
            continue;
        }
        known.push(key);
        let alike = || {
            rows.iter()
                .filter(|other| (other.body, other.cells, other.lattice_speed) == key)
        };
        let stands = alike().filter(|other| other.stands).count();
        let worst = |value: fn(&Row) -> f64| largest(alike().map(value));
        let least = alike().map(|row| row.energy_trend).fold(f64::NAN, f64::min);
        let most = alike().map(|row| row.energy_trend).fold(f64::NAN, f64::max);
        let _ = writeln!(
            text,
            "{:<9}{:>6}{:>8}{:>9}{:>11.2}{:>8.2}{:>15}",
            row.body.name(),
            row.cells,
            row.lattice_speed,
            format!("{stands} of {}", alike().count()),
            worst(|row| row.fastest),
            worst(|row| row.fastest_mach),
            format!("{least:.2} .. {most:.2}"),
        );
    }
    let beyond = |what: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| what(row)).count();
    let _ = writeln!(
        text,
        "beyond {WANTED_FASTEST} U: {}, beyond Mach {WANTED_MACH}: {}, energy by more than a factor of {WANTED_TREND} up: {}",
        beyond(&|row| row.fastest > WANTED_FASTEST),
        beyond(&|row| row.fastest_mach > WANTED_MACH),
        beyond(&|row| row.energy_trend > WANTED_TREND),
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_is_a_closed_surface_whose_normals_point_outwards() {
        let folder = tempfile::tempdir().unwrap();
        for body in Body::ALL {
            let flow = Flow {
                body,
                cells: 12,
                reynolds: 1e6,
                lattice_speed: 0.1,
                operator: Operator::TwoRelaxationTimes,
                eddy_viscosity: None,
                end: 1.0,
            };
            let case = flow.case(folder.path()).unwrap();
            let air = case.scene.air.as_ref().unwrap();
            assert_eq!(air.operator, Operator::TwoRelaxationTimes);
            let tau = air.units.relaxation_time(air.kinematic_viscosity_m2_s);
            assert!((tau - 0.5 - flow.viscous_part()).abs() < 1e-3 * flow.viscous_part());
            if let (Body::Profile, [wing]) = (body, &case.scene.rigid_bodies[..]) {
                // Area of NACA 0020: 0.6851 of thickness times chord.
                let (volume_m3, _) = wing.volume_m3.unwrap();
                assert!((volume_m3 - 0.6851 * 0.2).abs() < 0.002, "{volume_m3}");
            }
        }
    }

    #[test]
    fn the_trend_compares_the_last_quarters() {
        let values = [9.0, 9.0, 9.0, 9.0, 1.0, 3.0, 2.0, 6.0];
        assert_eq!(trend(&values), 2.0);
    }
}
