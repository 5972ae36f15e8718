//! Lift and drag of closed wings along which the air slides, with modelled boundary layers, on boxes of finer cells: against the slope of Helmbold (1942).
//!
//! The wing is straight, of aspect ratio 6, and rolled by ten degrees about the stream, so that its sections stand at all places between the cells. One that lies along the lattice has the same place at
//! all of them, and scatters as its section does (`sliding-wall`).

use std::path::Path;
use std::sync::atomic::Ordering;

use glam::DQuat;

use super::report::Gate;
use super::session::{Session, Stop};
use crate::case::{self, Case, CaseError, Choices};
use crate::measure::Record;
use crate::measure::shared::{FORCE_X, FORCE_Y, FORCE_Z, TIME};
use crate::plan::{Placement, Plan, Precision, steps_per};
use crate::simulation::{Failure, Simulation};

/// Span over chord.
const ASPECT_RATIO: f64 = 6.0;

/// Angle by which the wing is rolled about the stream [°].
const ROLL_DEG: f64 = 10.0;

/// Size of the tunnel, and where the quarter of the middle section's chord stands in it [chords].
const TUNNEL: [f64; 3] = [16.0, 18.0, 14.0];
const PLACE: [f64; 3] = [5.0, 9.0, 7.0];

/// Room in the innermost box around the wing, in chords or cells, whichever is more; each box has twice that of the one in it.
const ROOM: f64 = 0.35;
const ROOM_CELLS: f64 = 10.0;

/// Boxes are laid around the wing until the outermost cells are this many to a chord, or fewer.
const OUTERMOST_CELLS: f64 = 6.0;

const REYNOLDS: f64 = 1e6;

/// Time between samples, and of the rise of the wind [c/U].
const SAMPLE_INTERVAL: f64 = 0.25;
const RISE: f64 = 0.5;

/// Samples at the end that are judged.
const JUDGED: usize = 4;

/// Lift over that of Helmbold's slope.
const BAND: f64 = 0.15;

/// What is left of coefficients that vanish by symmetry.
const NOTHING: f64 = 0.02;

/// Fewest cells per chord at which a drag is judged, and by what share it may be off.
const DRAG_CELLS: usize = 48;
const DRAG_BAND: f64 = 0.5;

/// Friction of a side of a plate at Re = 10⁶, turbulent from its front on: Prandtl and Schlichting.
const PLATE_FRICTION: f64 = 0.00447;

/// A closed wing in the wind.
#[derive(Debug, Clone, Copy)]
struct ClosedWing {
    /// Cells per chord.
    cells: usize,
    /// Of the symmetric NACA profile [% of the chord].
    thickness: u32,
    angle_deg: f64,
    /// Time that is computed [c/U].
    end: f64,
}

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let full = [
        (24, 12, -4.0),
        (24, 12, 0.0),
        (24, 12, 4.0),
        (24, 12, 8.0),
        (24, 12, 12.0),
        (24, 20, 4.0),
        (24, 20, 8.0),
        (48, 12, 8.0),
    ];
    for (cells, thickness, angle_deg) in session.size(&[(16, 12, 8.0)][..], &full) {
        let wing = ClosedWing {
            cells: *cells,
            thickness: *thickness,
            angle_deg: *angle_deg,
            end: session.size(4.0, 8.0),
        };
        let [lift, drag, side] = wing.coefficients(session)?;
        let name = format!("NACA 00{thickness}, {cells} cells per chord, {angle_deg}°");
        let grid = TUNNEL.map(|size| size as usize * cells);
        let of_helmbold = helmbold() * angle_deg.to_radians();
        let row = session.row(grid, format!("{name}: C_L"), lift);
        row.reference(of_helmbold, "Helmbold's slope, 2 pi of the section");
        if *angle_deg == 0.0 {
            row.gate(Gate::AtMost(NOTHING));
        } else {
            row.gate(Gate::Within(BAND));
        }
        let expected = wing.section_drag() + lift * lift / (std::f64::consts::PI * ASPECT_RATIO);
        let row = session.row(grid, format!("{name}: C_D"), drag);
        row.reference(expected, "section drag and C_L^2/(pi A)");
        if *cells >= DRAG_CELLS {
            row.gate(Gate::Within(DRAG_BAND));
        }
        let name = format!("{name}: force along the span, as a coefficient");
        session.row(grid, name, side).gate(Gate::AtMost(NOTHING));
    }
    Ok(())
}

/// Slope of lift over the angle in radians, of a section with 2 π.
fn helmbold() -> f64 {
    let slender = 2.0 / ASPECT_RATIO;
    2.0 * std::f64::consts::PI / (slender.hypot(1.0) + slender)
}

impl ClosedWing {
    /// Drag coefficient of its section without lift: both sides of a plate, times 1 + 2 t/c + 60 (t/c)⁴ (Hoerner 1965, chapter 6).
    fn section_drag(&self) -> f64 {
        let thickness = 0.01 * f64::from(self.thickness);
        2.0 * PLATE_FRICTION * (1.0 + 2.0 * thickness + 60.0 * thickness.powi(4))
    }

    /// The flow as a case, with c, U and ρ of one.
    fn case(&self) -> Result<Case, Box<CaseError>> {
        let turn = DQuat::from_rotation_x(ROLL_DEG.to_radians())
            * DQuat::from_rotation_y(self.angle_deg.to_radians());
        let (axis, angle) = turn.to_axis_angle();
        let half_span = 0.5 * ASPECT_RATIO;
        let (sin, cos) = ROLL_DEG.to_radians().sin_cos();
        let levels = (self.cells as f64 / OUTERMOST_CELLS).log2().ceil().max(0.0) as i32;
        let mut boxes = String::new();
        for level in (0..levels).rev() {
            let room = ROOM.max(ROOM_CELLS / self.cells as f64) * f64::from(level).exp2();
            let beside = [half_span * cos, half_span * sin + 0.2];
            let lower = [
                PLACE[0] - 0.25 - room,
                PLACE[1] - beside[0] - room,
                PLACE[2] - beside[1] - room,
            ];
            let upper = [
                PLACE[0] + 0.75 + 2.0 * room,
                PLACE[1] + beside[0] + room,
                PLACE[2] + beside[1] + room,
            ];
            boxes.push_str(&format!(
                "[[air.refinement.boxes]]\nlower_m = {lower:?}\nupper_m = {upper:?}\n"
            ));
        }
        let source = format!(
            r#"version = 1
title = "A closed wing"
[air]
density_kg_m3 = 1.0
kinematic_viscosity_m2_s = {viscosity:?}
[air.wind_tunnel]
speed_m_s = 1.0
size_m = {TUNNEL:?}
start_time_s = {RISE:?}
sponge_length_m = 2.0
{boxes}[resolution]
cell_size_m = {cell:?}
lattice_speed = 0.08
operator = "stabilised_regularised"
[coupling]
scheme = "links"
[bodies.wing]
position_m = {PLACE:?}
rotation = {{ axis = {axis:?}, angle_deg = {angle:?} }}
friction = "model"
[bodies.wing.wing]
naca = "00{thickness}"
stations = [{{ position_m = [0.0, 0.0, 0.0], chord_m = 1.0 }}, {{ position_m = [0.0, {half_span:?}, 0.0], chord_m = 1.0 }}]
[time]
end_s = {end:?}
[output]
sample_interval_s = {SAMPLE_INTERVAL:?}
"#,
            viscosity = 1.0 / REYNOLDS,
            cell = 1.0 / self.cells as f64,
            axis = axis.to_array(),
            angle = angle.to_degrees(),
            thickness = self.thickness,
            end = self.end,
        );
        case::parse("wing", &source, Path::new("."), &Choices::default())
    }

    /// Coefficients of lift, of drag and of the force along the span at the end; not finite where the flow breaks down.
    fn coefficients(&self, session: &mut Session) -> Result<[f64; 3], Stop> {
        let refused = |error: Box<CaseError>| Stop::Refused(error.to_string());
        let case = self.case().map_err(refused)?;
        let order = session.order;
        let air = case.scene.air.as_ref();
        let updates = air.map_or(0.0, |air| 1e-6 * air.updates_per_step());
        let placement = Placement {
            air: order.placement,
            ..Placement::from(Precision::F32)
        };
        let plan = Plan::new(&case.scene, placement);
        let sample_every = steps_per(&case.scene, SAMPLE_INTERVAL);
        let (first, last) = (plan.start_steps, plan.start_steps + plan.steps);
        let failed = |failure: Failure| match failure {
            Failure::Device(error) => Stop::Device(error),
            other => Stop::Refused(other.to_string()),
        };
        let start = session.done;
        let mut simulation =
            Simulation::new(case.scene, plan, order.device.clone()).map_err(failed)?;
        let mut record = Record::new(&simulation);
        loop {
            let step = simulation.step_count();
            if step >= first && (step - first).is_multiple_of(sample_every) {
                if session.interrupt.load(Ordering::Relaxed) {
                    return Err(Stop::Interrupted);
                }
                session.progress_to(start + updates * step as f64);
                record.add(&mut simulation)?;
            }
            if step >= last {
                break;
            }
            match simulation.advance_among_threads() {
                Err(Failure::Diverged(_)) if step > first => return Ok([f64::NAN; 3]),
                advanced => advanced.map_err(failed)?,
            }
        }
        let samples = record.column(&TIME).len();
        let mean = |route| {
            let column = record.column(route);
            column[samples - JUDGED..].iter().sum::<f64>() / JUDGED as f64
        };
        let (sin, cos) = ROLL_DEG.to_radians().sin_cos();
        let unit = 0.5 * ASPECT_RATIO;
        let [x, y, z] = [&FORCE_X, &FORCE_Y, &FORCE_Z].map(mean);
        let [lift, side] = [z * cos - y * sin, y * cos + z * sin];
        Ok([lift, x, side].map(|force| force / unit))
    }
}
