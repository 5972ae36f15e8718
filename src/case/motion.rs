//! Checks of prescribed motions: `[bodies.NAME.motion]` and `[supports.NAME.motion]`.

use glam::DVec3;

use super::file;
use super::problem::Problem;
use super::time::Time;
use super::usual;
use super::values::{direction, positive, vector};
use crate::rigid::motion::Table;
use crate::rigid::{Motion, PrescribedMotion};

/// Checks the motion written in the table `table_key`; rotations go about `usual_centre_m` where they name no other centre.
pub(super) fn check(
    table_key: &str,
    written: &file::Motion,
    usual_centre_m: DVec3,
    time: &Time,
) -> Result<PrescribedMotion, Problem> {
    let key = |name: &str| format!("{table_key}.{name}");
    let number = |name: &str, value: f64| Ok(vector(&key(name), [value; 3])?.x);
    let rise = |name: &str, value: Option<f64>| match value {
        Some(time) => positive(&key(name), time),
        None => Ok(usual::noted(key(name), 0.0)),
    };
    let centre = |name: &str, value: Option<[f64; 3]>| {
        let own = usual_centre_m.to_array();
        vector(&key(name), usual::or(key(name), value, own))
    };
    // An axis is needed only where something turns.
    let axis = |name: &str, value: Option<[f64; 3]>, turns: bool| match value {
        Some(axis) => direction(&key(name), axis),
        None if turns => Err(Problem::new(
            key(name),
            format!("{} is missing: the motion turns", key(name)),
            "add the axis of rotation, e.g. axis = [0.0, 1.0, 0.0]",
        )),
        None => Ok(DVec3::X),
    };
    match written {
        file::Motion::ConstantVelocity(given) => Ok(PrescribedMotion {
            motion: Motion::ConstantVelocity {
                velocity_m_s: vector(&key("constant_velocity.velocity_m_s"), given.velocity_m_s)?,
                rise_s: rise("constant_velocity.start_time_s", given.start_time_s)?,
            },
            centre_m: usual_centre_m,
            axis: DVec3::X,
        }),
        file::Motion::ConstantRotation(given) => Ok(PrescribedMotion {
            motion: Motion::ConstantRotation {
                rate_rad_s: number("constant_rotation.rate_rad_s", given.rate_rad_s)?,
                rise_s: rise("constant_rotation.start_time_s", given.start_time_s)?,
            },
            centre_m: centre("constant_rotation.centre_m", given.centre_m)?,
            axis: direction(&key("constant_rotation.axis"), given.axis)?,
        }),
        file::Motion::Oscillation(given) => {
            let of = |name: &str| key(&format!("oscillation.{name}"));
            let displacement = usual::or(of("displacement_m"), given.displacement_m, [0.0; 3]);
            let angle_deg = usual::or(of("angle_deg"), given.angle_deg, 0.0);
            let phase_deg = usual::or(of("phase_deg"), given.phase_deg, 0.0);
            Ok(PrescribedMotion {
                motion: Motion::Oscillation {
                    frequency_hz: positive(&key("oscillation.frequency_hz"), given.frequency_hz)?,
                    phase_rad: number("oscillation.phase_deg", phase_deg)?.to_radians(),
                    displacement_m: vector(&key("oscillation.displacement_m"), displacement)?,
                    angle_rad: number("oscillation.angle_deg", angle_deg)?.to_radians(),
                },
                centre_m: centre("oscillation.centre_m", given.centre_m)?,
                axis: axis("oscillation.axis", given.axis, angle_deg != 0.0)?,
            })
        }
        // The box of the air falls with the body, in which it stays in its place.
        file::Motion::FreeFall(_) => Ok(PrescribedMotion::held()),
        file::Motion::Table(rows) => {
            let spline = check_table(table_key, rows, time)?;
            Ok(PrescribedMotion {
                motion: Motion::Table(spline),
                centre_m: centre("table.centre_m", rows.centre_m)?,
                axis: axis("table.axis", rows.axis, rows.angles_deg.is_some())?,
            })
        }
    }
}

fn check_table(table_key: &str, rows: &file::MotionRows, time: &Time) -> Result<Table, Problem> {
    let count = rows.times_s.len();
    let lengths = [
        (
            "displacements_m",
            rows.displacements_m.as_ref().map(Vec::len),
        ),
        ("angles_deg", rows.angles_deg.as_ref().map(Vec::len)),
    ];
    for (name, length) in lengths {
        if let Some(length) = length.filter(|length| *length != count) {
            let key = format!("{table_key}.table.{name}");
            return Err(Problem::new(
                key.as_str(),
                format!("{key} has {length} entries for {count} times"),
                "give one entry for each of times_s",
            ));
        }
    }
    let values = (0..count)
        .map(|i| {
            let [x, y, z] = rows.displacements_m.as_ref().map_or([0.0; 3], |d| d[i]);
            let angle = rows.angles_deg.as_ref().map_or(0.0, |a| a[i]);
            [x, y, z, angle.to_radians()]
        })
        .collect();
    let key = format!("{table_key}.table.times_s");
    let table = Table::new(rows.times_s.clone(), values).ok_or_else(|| {
        Problem::new(
            key.as_str(),
            format!("{key} does not make a motion: fewer than two times, not ascending, or values that are not finite"),
            "give two or more times in ascending order",
        )
    })?;
    let [first, last] = table.range_s();
    if first > 0.0 || last < time.end_s {
        return Err(Problem::new(
            key.as_str(),
            format!(
                "{key} goes from {first} to {last} s, the run from 0 to {} s",
                time.end_s
            ),
            "let the table cover the whole run: beyond it no motion is known",
        ));
    }
    Ok(table)
}
