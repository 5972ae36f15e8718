//! Speed, glide angle and turn of a given shape: a search for the angle of the stream at which the moment about the hang points vanishes.
//!
//! Everything else follows from that angle φ in closed form (see [`super`]). The moment about the hang points falls as the nose rises where a wing is
//! stable, as lift moves behind them; the search goes from where it starts in the direction that its sign says, in steps, until the sign
//! changes, and closes in by false position with Illinois' rule (Dowell & Jarratt, BIT 11, 1971).

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::TrimError;

/// Aerodynamic forces of a shape at an angle of the stream, over the dynamic pressure; in the frame of the shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums {
    /// Force of the air on wing and lines [m²].
    pub force_m2: DVec3,
    /// Its moment about the hang points, nose up [m³].
    pub moment_m3: f64,
}

/// Masses, and what hangs below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Acceleration of gravity [m/s²].
    pub gravity_m_s2: f64,
    /// Fabric and lines [kg].
    pub wing_kg: f64,
    /// Their centre of mass seen from the hang points [m].
    pub centre_m: DVec3,
    /// What hangs at the hang points [kg].
    pub pilot_kg: f64,
    /// Its drag area [m²].
    pub pilot_area_m2: f64,
    /// Density of the air [kg/m³].
    pub density_kg_m3: f64,
}

/// A glide in balance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Angle φ of the stream in the shape's frame, from below [rad].
    pub stream_rad: f64,
    /// Glide angle γ [rad].
    pub glide_rad: f64,
    /// Turn θ = φ − γ of the shape about the hang points, nose up [rad].
    pub turn_rad: f64,
    /// Dynamic pressure [Pa].
    pub dynamic_pa: f64,
    /// Speed along the path [m/s].
    pub speed_m_s: f64,
    /// Moment about the hang points that is left [N m].
    pub moment_n_m: f64,
}

/// Step of the search [rad].
const STEP_RAD: f64 = 0.026;

/// Angles at which it ends [rad].
const RANGE_RAD: [f64; 2] = [-0.35, 0.7];

/// Width of the bracket at which it is done [rad].
const ANGLE_TOLERANCE_RAD: f64 = 1e-7;

/// Largest arm of all weight whose moment counts as balance [m].
const LARGEST_ARM_M: f64 = 1e-3;

/// The same as a turn of the wing's own centre of mass [rad].
const LARGEST_TURN_RAD: f64 = 1e-3;

/// Most evaluations within a bracket.
const LIMIT: usize = 60;

/// The unit vector of a stream at an angle from below.
#[must_use]
pub fn stream(angle_rad: f64) -> DVec3 {
    let (sin, cos) = angle_rad.sin_cos();
    DVec3::new(cos, 0.0, sin)
}

/// A vector turned about the y axis, nose up.
#[must_use]
pub fn turned(vector: DVec3, angle_rad: f64) -> DVec3 {
    let (sin, cos) = angle_rad.sin_cos();
    DVec3::new(
        vector.x * cos + vector.z * sin,
        vector.y,
        vector.z * cos - vector.x * sin,
    )
}

/// The glide of a shape if the stream comes at an angle; its moment need not be in balance.
fn at(angle_rad: f64, sums: &Sums, weights: &Weights) -> Result<Balance, TrimError> {
    let along = stream(angle_rad);
    let up = DVec3::new(-along.z, 0.0, along.x);
    let drag_m2 = sums.force_m2.dot(along) + weights.pilot_area_m2;
    let lift_m2 = sums.force_m2.dot(up);
    if lift_m2.is_nan() || lift_m2 <= 0.0 {
        return Err(TrimError::NoLift {
            angle_deg: angle_rad.to_degrees(),
        });
    }
    let weight_n = weights.gravity_m_s2 * (weights.wing_kg + weights.pilot_kg);
    let dynamic_pa = weight_n / lift_m2.hypot(drag_m2);
    let glide_rad = drag_m2.atan2(lift_m2);
    let turn_rad = angle_rad - glide_rad;
    let centre = turned(weights.centre_m, turn_rad);
    let of_weight = centre.x * weights.wing_kg * weights.gravity_m_s2;
    Ok(Balance {
        stream_rad: angle_rad,
        glide_rad,
        turn_rad,
        dynamic_pa,
        speed_m_s: (2.0 * dynamic_pa / weights.density_kg_m3).sqrt(),
        moment_n_m: dynamic_pa * sums.moment_m3 + of_weight,
    })
}

/// Finds the balance next to a start angle [rad]; `sums` is asked for forces at angles of the stream.
pub fn find(
    start_rad: f64,
    weights: &Weights,
    mut sums: impl FnMut(f64) -> Result<Sums, TrimError>,
) -> Result<Balance, TrimError> {
    let mut evaluate = |angle: f64| at(angle, &sums(angle)?, weights);
    // Where the wing does not lift yet, the search goes up.
    let mut start_rad = start_rad;
    let start = loop {
        match evaluate(start_rad) {
            Err(TrimError::NoLift { .. }) if start_rad < RANGE_RAD[1] => start_rad += STEP_RAD,
            found => break found?,
        }
    };
    let direction = start.moment_n_m.signum();
    let mut low = start;
    let mut high = loop {
        if low.moment_n_m == 0.0 {
            return Ok(low);
        }
        let angle = low.stream_rad + direction * STEP_RAD;
        let ended = || TrimError::NoAngle {
            from_deg: start.stream_rad.to_degrees(),
            to_deg: low.stream_rad.to_degrees(),
            from_n_m: start.moment_n_m,
            to_n_m: low.moment_n_m,
        };
        if !(RANGE_RAD[0]..=RANGE_RAD[1]).contains(&angle) {
            return Err(ended());
        }
        let next = match evaluate(angle) {
            Err(TrimError::NoLift { .. }) => return Err(ended()),
            found => found?,
        };
        if next.moment_n_m.signum() != direction {
            break next;
        }
        low = next;
    };
    let [mut of_low, mut of_high] = [low.moment_n_m, high.moment_n_m];
    let mut best = if of_low.abs() < of_high.abs() {
        low
    } else {
        high
    };
    for _ in 0..LIMIT {
        let width = high.stream_rad - low.stream_rad;
        if width.abs() < ANGLE_TOLERANCE_RAD || best.moment_n_m == 0.0 {
            break;
        }
        let share = (of_low / (of_low - of_high)).clamp(1e-3, 1.0 - 1e-3);
        let next = evaluate(low.stream_rad + share * width)?;
        let moved = (next.stream_rad - best.stream_rad).abs();
        if next.moment_n_m.abs() < best.moment_n_m.abs() {
            best = next;
        }
        if next.moment_n_m.signum() == direction {
            (low, of_low) = (next, next.moment_n_m);
            of_high *= 0.5;
        } else {
            (high, of_high) = (next, next.moment_n_m);
            of_low *= 0.5;
        }
        if moved < ANGLE_TOLERANCE_RAD {
            break;
        }
    }
    let of_all = (weights.wing_kg + weights.pilot_kg) * LARGEST_ARM_M;
    let of_wing = weights.wing_kg * LARGEST_TURN_RAD * weights.centre_m.length();
    let allowed_n_m = weights.gravity_m_s2 * of_all.max(of_wing);
    if best.moment_n_m.abs() <= allowed_n_m {
        return Ok(best);
    }
    Err(TrimError::Jump {
        angle_deg: low.stream_rad.midpoint(high.stream_rad).to_degrees(),
        moment_n_m: best.moment_n_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lift a φ and drag c + k (a φ)² at a point ahead of and above the hang points: angle by bisection of the written-out moment, speed in closed form.
    #[test]
    fn a_wing_of_known_polar_is_in_balance() {
        let (slope, least, k, area) = (4.8, 0.03, 0.06, 25.0);
        let weights = Weights {
            gravity_m_s2: 9.81,
            wing_kg: 0.0,
            centre_m: DVec3::ZERO,
            pilot_kg: 95.0,
            pilot_area_m2: 0.4,
            density_kg_m3: 1.2,
        };
        let place = DVec3::new(-0.9, 0.0, 7.0);
        let force = |angle: f64| {
            let lift = area * slope * angle;
            let drag = area * (least + k * (slope * angle).powi(2));
            let s = stream(angle);
            s * drag + DVec3::new(-s.z, 0.0, s.x) * lift
        };
        let moment = |angle: f64| place.cross(force(angle)).y;
        let found = find(0.02, &weights, |angle| {
            Ok(Sums {
                force_m2: force(angle),
                moment_m3: moment(angle),
            })
        })
        .unwrap();
        let (mut a, mut b) = (0.01, 0.3);
        for _ in 0..100 {
            let middle = 0.5 * (a + b);
            if moment(middle) > 0.0 {
                a = middle
            } else {
                b = middle
            }
        }
        assert!((found.stream_rad - a).abs() < 1e-6, "{found:?} {a}");
        let lift = area * slope * a;
        let drag = area * (least + k * (slope * a).powi(2)) + 0.4;
        assert!((found.glide_rad.tan() - drag / lift).abs() < 1e-6);
        let speed = (2.0 * 95.0 * 9.81 / 1.2 / lift.hypot(drag)).sqrt();
        assert!((found.speed_m_s / speed - 1.0).abs() < 1e-6);
        // From above, too; and none where lift is far behind.
        let again = find(0.3, &weights, |angle| {
            Ok(Sums {
                force_m2: force(angle),
                moment_m3: moment(angle),
            })
        })
        .unwrap();
        assert!((again.stream_rad - found.stream_rad).abs() < 1e-6);
        let behind = find(0.1, &weights, |angle| {
            Ok(Sums {
                force_m2: force(angle),
                moment_m3: -1.0,
            })
        });
        assert!(
            matches!(behind, Err(TrimError::NoAngle { .. })),
            "{behind:?}"
        );
        // A moment that jumps over nothing is in balance nowhere.
        let jumps = find(0.02, &weights, |angle| {
            Ok(Sums {
                force_m2: force(angle),
                moment_m3: if angle < 0.1 { 1.0 } else { -0.5 },
            })
        });
        let Err(TrimError::Jump { angle_deg, .. }) = jumps else {
            panic!("{jumps:?}");
        };
        assert!(
            (angle_deg - 0.1_f64.to_degrees()).abs() < 1e-3,
            "{angle_deg}"
        );
    }
}
