//! What of a trim moves from one outer iteration to the next, and what is allowed.

use super::iteration::TrimIteration;
use crate::trim::Settings;

/// What has not come to rest, in words.
pub(super) fn moving(
    last: &TrimIteration,
    now: &TrimIteration,
    settings: &Settings,
) -> Vec<String> {
    let changes = changes(last, now, settings).into_iter();
    let moving = changes.filter(|c| c.value.is_nan() || c.value > c.allowed);
    moving.map(|change| change.text).collect()
}

/// Something that is to come to rest.
pub(super) struct Change {
    pub(super) value: f64,
    pub(super) allowed: f64,
    text: String,
}

/// All that is to come to rest, with how far it still moves.
pub(super) fn changes(
    last: &TrimIteration,
    now: &TrimIteration,
    settings: &Settings,
) -> Vec<Change> {
    let tolerance = &settings.tolerance;
    let relative = |name: &str, old: f64, new: f64, allowed: f64| {
        let value = (new / old - 1.0).abs();
        Change {
            value,
            allowed,
            text: format!("{name} changes by {value:.1e} of itself ({allowed:.0e} allowed)"),
        }
    };
    let mut changes = vec![
        relative("speed", last.speed_m_s, now.speed_m_s, tolerance.speed),
        relative(
            "glide ratio",
            last.glide_ratio,
            now.glide_ratio,
            tolerance.glide,
        ),
        Change {
            value: now.turn_rad.abs(),
            allowed: tolerance.pitch_rad,
            text: format!(
                "the balance turns the wing by {:.3} degrees ({:.3} allowed)",
                now.turn_rad.to_degrees(),
                tolerance.pitch_rad.to_degrees()
            ),
        },
        Change {
            value: now.shape_change,
            allowed: tolerance.shape,
            text: format!(
                "outlines move by {:.1e} mean chords ({:.0e} allowed)",
                now.shape_change, tolerance.shape
            ),
        },
        Change {
            value: now.balance_error,
            allowed: tolerance.balance,
            text: format!(
                "the risers lack {:.1e} of the weight ({:.0e} allowed)",
                now.balance_error, tolerance.balance
            ),
        },
    ];
    if !now.outcome.stop.reached() {
        changes.push(Change {
            value: f64::NAN,
            allowed: 0.0,
            text: format!(
                "the fabric is not in equilibrium (energy norm {:.1e} of the loads')",
                now.relative_norm
            ),
        });
    }
    changes
}
