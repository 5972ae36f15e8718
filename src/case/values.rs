//! Checks of single values, with what to say about them.

use std::cell::RefCell;

use glam::{DQuat, DVec3};

use super::file::Rotation;
use super::problem::Problem;

/// Largest and (inverted) smallest quantity taken for a real one, in SI units.
pub(super) const PLAUSIBLE: f64 = 1e15;

/// Most wrong values that are told at once.
const MOST: usize = 10;

thread_local! {
    /// Wrong values that the check that goes on in this thread has met; `None` outside of one.
    static WRONG: RefCell<Option<Vec<Problem>>> = const { RefCell::new(None) };
}

/// Makes a check that goes on behind wrong values, so that all of them are told at once.
///
/// # Errors
///
/// The wrong values, or else what the check found.
pub(super) fn all_told<T>(
    check: impl FnOnce() -> Result<T, Problem>,
) -> Result<T, (Problem, Vec<Problem>)> {
    let outer = WRONG.replace(Some(Vec::new()));
    let result = check();
    let mut wrong = Vec::new();
    // The same key may be looked at again, as on the coarser lattices of a grid sequence.
    for problem in WRONG.replace(outer).unwrap_or_default() {
        if !wrong.iter().any(|known: &Problem| known.key == problem.key) {
            wrong.push(problem);
        }
    }
    let mut wrong = wrong.into_iter();
    match (wrong.next(), result) {
        // What is found after a wrong value may be its consequence.
        (Some(first), _) => Err((first, wrong.collect())),
        (None, result) => result.map_err(|problem| (problem, Vec::new())),
    }
}

/// Makes a check of a value that is then taken as it is written: a wrong one ends the whole check at once.
pub(super) fn at_once<T>(check: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    let outer = WRONG.replace(None);
    let result = check();
    WRONG.replace(outer);
    result
}

/// A wrong value: where all are to be told the check goes on with a value that is allowed.
fn wrong<T>(problem: Problem, allowed: T) -> Result<T, Problem> {
    WRONG.with_borrow_mut(|all| match all {
        Some(all) if all.len() < MOST => {
            all.push(problem);
            Ok(allowed)
        }
        _ => Err(problem),
    })
}

/// Diameters that lines may have [m].
pub(super) const LINE_DIAMETERS_M: [f64; 2] = [1e-5, 0.05];

/// Refuses values that are not positive and finite, or beyond anything physical.
pub(super) fn positive(key: &str, value: f64) -> Result<f64, Problem> {
    if (1.0 / PLAUSIBLE..=PLAUSIBLE).contains(&value) {
        Ok(value)
    } else {
        let help = if value > PLAUSIBLE {
            "give a number of at most 1e15, in the unit that the key names"
        } else if value > 0.0 {
            "give a number of at least 1e-15, in the unit that the key names"
        } else {
            "give a number greater than zero, in the unit that the key names"
        };
        let problem = Problem::new(
            key,
            format!("{key} = {value:e} must be positive (and between 1e-15 and 1e15)")
                .replace("e0 must", " must"),
            help,
        );
        wrong(problem, 1.0)
    }
}

/// Refuses names that columns and results cannot carry; `what` they would be the names of.
pub(super) fn check_name(key: &str, name: &str, what: &str) -> Result<(), Problem> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(plain) {
        return Ok(());
    }
    Err(Problem::new(
        key,
        format!("`{name}` cannot be the name of {what}: columns and results carry it"),
        "use letters, digits, - and _",
    ))
}

/// Refuses vectors that are not finite, or beyond anything physical.
pub(super) fn vector(key: &str, value: [f64; 3]) -> Result<DVec3, Problem> {
    if value.iter().all(|v| v.abs() <= PLAUSIBLE) {
        Ok(DVec3::from_array(value))
    } else {
        let problem = Problem::new(
            key,
            format!("{key} = {value:?} is not a vector of plausible numbers"),
            "give three finite numbers",
        );
        wrong(problem, DVec3::ONE)
    }
}

pub(super) fn at_least_one(key: &str, value: usize) -> Result<usize, Problem> {
    if value > 0 {
        Ok(value)
    } else {
        let problem = Problem::new(
            key,
            format!("{key} = 0 would solve nothing"),
            "give at least 1; hundreds are usual",
        );
        wrong(problem, 1)
    }
}

/// Refuses values outside a closed range.
pub(super) fn within(key: &str, value: f64, low: f64, high: f64) -> Result<f64, Problem> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        let problem = Problem::new(
            key,
            format!("{key} = {} is out of range", readable(value)),
            format!(
                "allowed are values from {} to {}",
                readable(low),
                readable(high)
            ),
        );
        // Near the lower end: counts then stay small.
        wrong(problem, low + f64::min(1.0, 0.5 * (high - low)))
    }
}

/// Refuses counts outside a closed range.
pub(super) fn count_within(
    key: &str,
    value: usize,
    low: usize,
    high: usize,
) -> Result<usize, Problem> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(Problem::new(
        key,
        format!("{key} = {value} is out of range"),
        format!("allowed are {low} to {high}"),
    ))
}

/// A number without hundreds of zeros, and without round-off.
pub(super) fn readable(value: f64) -> String {
    let value = format!("{value:.11e}").parse().unwrap_or(value);
    if value == 0.0 || (1e-6..1e9).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

pub(super) fn absent(key: &str, why: &str) -> Problem {
    Problem::new(
        key,
        format!("{key} is missing: {why}"),
        format!("add `{key}`"),
    )
}

/// A vector made one long; refuses the zero vector.
pub(super) fn direction(key: &str, value: [f64; 3]) -> Result<DVec3, Problem> {
    vector(key, value)?.try_normalize().ok_or_else(|| {
        Problem::new(
            key,
            format!("{key} = {value:?} has no direction"),
            "give a vector that is not zero; its length does not matter",
        )
    })
}

/// A rotation; none if absent.
pub(super) fn rotation(key: &str, written: Option<&Rotation>) -> Result<DQuat, Problem> {
    let Some(rotation) = written else {
        return Ok(DQuat::IDENTITY);
    };
    Ok(DQuat::from_axis_angle(
        direction(&format!("{key}.axis"), rotation.axis)?,
        vector(&format!("{key}.angle_deg"), [rotation.angle_deg; 3])?
            .x
            .to_radians(),
    ))
}

/// Refuses tables of points whose places do not grow, or lie outside 0 to 1, or whose values are out of range.
pub(super) fn points(
    key: &str,
    table: &[[f64; 2]],
    [low, high]: [f64; 2],
) -> Result<Vec<[f64; 2]>, Problem> {
    let grows = table.windows(2).all(|p| p[1][0] > p[0][0]);
    let inside = table.iter().all(|p| (0.0..=1.0).contains(&p[0]));
    if table.is_empty() || !grows || !inside {
        return Err(Problem::new(
            key,
            format!(
                "{key} is not a table of points [place, value] with places growing from 0 to 1"
            ),
            "e.g. [[0.0, 0.01], [0.3, 0.03], [1.0, 0.0]]",
        ));
    }
    for point in table {
        at_once(|| within(key, point[1], low, high))?;
    }
    Ok(table.to_vec())
}

/// Dotted path of a key of `[structure.wing]`.
pub(super) fn wing_key(name: &str) -> String {
    format!("structure.wing.{name}")
}
