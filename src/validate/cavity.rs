//! Cubic cavity under a moving lid at Re 1000, steady: velocity on two centre lines against the tables of Albensoeder & Kuhlmann 2005.

use super::flows::{relaxation_time, states};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use crate::measure::extremes::largest;
use crate::simulation::AirEngine;

const REFERENCE: &str = include_str!("data/cavity_re1000.csv");

/// Lid speed [cells per step]: Mach 0.17.
const LID: f64 = 0.1;

const REYNOLDS: f64 = 1000.0;

/// The flow counts as steady when no point moves by more than this within a unit of time (side over lid speed) [lid speeds].
const STEADY: f64 = 2e-4;

/// It is looked at no longer than this [units of time].
const LONGEST: usize = 80;

/// Shortest time before it may count as steady [units of time].
const SHORTEST: usize = 30;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    // The band of 32 cells is what was measured there, 0.044, with a margin.
    let (n, limit): (usize, f64) = session.size((32, 0.055), (96, 0.03));
    for operator in Operator::in_use() {
        let name = operator.short_name();
        // At 32 cells τ − ½ is 0.01, too little for two relaxation times at the corners of the lid.
        if n >= 96 || operator == Operator::RecursiveRegularised {
            one(session, n, limit, operator, name)?;
        }
    }
    Ok(())
}

fn one(
    session: &mut Session,
    n: usize,
    limit: f64,
    operator: Operator,
    name: &str,
) -> Result<(), Stop> {
    let cells = [n; 3];
    let lid = Wall::NoSlip {
        velocity: [0.0, LID, 0.0],
    };
    let setup = Setup {
        cells,
        ends: StreamwiseEnds::Walls([lid, Wall::AT_REST]),
        sides: Sides::Each([Faces::Walls([Wall::AT_REST; 2]); 2]),
        relaxation_time: relaxation_time(LID * n as f64 / REYNOLDS),
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator,
        eddy_viscosity: None,
    };
    let reference = reference();
    let mut air = session.air(setup, &|_| (0.0, [0.0; 3]))?;
    let unit = (n as f64 / LID).round() as usize;
    let mut before: Vec<f64> = Vec::new();
    let mut units = 0;
    let mut change = f64::INFINITY;
    while units < LONGEST && (units < SHORTEST || change > STEADY) && !change.is_nan() {
        session.advance(&mut air, unit, None)?;
        units += 1;
        let now = at_reference_points(&air, &reference)?;
        if !before.is_empty() {
            change = farthest(&now, &before);
        }
        before = now;
    }
    let off: Vec<f64> = reference
        .iter()
        .zip(&before)
        .map(|(point, value)| value - point.velocity)
        .collect();
    let square = off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64;
    session
        .row(
            cells,
            format!("{name}: RMS difference at {} points, lid speeds", off.len()),
            square.sqrt(),
        )
        .reference(0.0, "Albensoeder & Kuhlmann 2005, tables 5 and 6")
        .gate(Gate::AtMost(limit));
    let worst = farthest(&off, &vec![0.0; off.len()]);
    session.row(
        cells,
        format!("{name}: largest difference, after {units} L/U"),
        worst,
    );
    Ok(())
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    // What is not a number is far.
    largest(a.iter().zip(b).map(|(a, b)| (a - b).abs()))
}

/// A point of the tables, with the cavity's side and the lid's speed as units.
struct Point {
    /// On the line along x through the centre (velocity along y), else on that along y (velocity along x).
    along_x: bool,
    coordinate: f64,
    velocity: f64,
}

/// The points of the tables inside the cavity.
fn reference() -> Vec<Point> {
    REFERENCE
        .lines()
        .filter_map(|line| {
            let mut fields = line.split(',');
            let table = fields.next()?;
            let coordinate: f64 = fields.next()?.parse().ok()?;
            let velocity: f64 = fields.next()?.parse().ok()?;
            // On the walls there is nothing to compare.
            (coordinate.abs() < 0.5).then_some(Point {
                along_x: table == "v_on_x",
                coordinate,
                velocity,
            })
        })
        .collect()
}

fn at_reference_points(air: &AirEngine, points: &[Point]) -> Result<Vec<f64>, Stop> {
    let n = air.grid().cells[0];
    let state = states(air)?;
    // The centre lines run between four rows of cells (n is even).
    let middle = [n / 2 - 1, n / 2];
    let mut profiles = [Vec::with_capacity(n + 2), Vec::with_capacity(n + 2)];
    for (profile, along_x) in profiles.iter_mut().zip([true, false]) {
        // The walls belong to the profile; the lid is at the lower end of x.
        profile.push((-0.5, if along_x { 1.0 } else { 0.0 }));
        for i in 0..n {
            let mut sum = 0.0;
            for j in middle {
                for k in middle {
                    let (cell, component) = if along_x {
                        ([i, j, k], 1)
                    } else {
                        ([j, i, k], 0)
                    };
                    sum += state[cell[0] + n * (cell[1] + n * cell[2])].1[component];
                }
            }
            profile.push(((i as f64 + 0.5) / n as f64 - 0.5, 0.25 * sum / LID));
        }
        profile.push((0.5, 0.0));
    }
    Ok(points
        .iter()
        .map(|point| interpolate(&profiles[usize::from(!point.along_x)], point.coordinate))
        .collect())
}

/// Cubic through the four nodes around `x`.
fn interpolate(profile: &[(f64, f64)], x: f64) -> f64 {
    let above = profile.partition_point(|(node, _)| *node < x);
    let first = above.saturating_sub(2).min(profile.len() - 4);
    let nodes = &profile[first..first + 4];
    let mut value = 0.0;
    for (i, (xi, yi)) in nodes.iter().enumerate() {
        let mut weight = 1.0;
        for (j, (xj, _)) in nodes.iter().enumerate() {
            if i != j {
                weight *= (x - xj) / (xi - xj);
            }
        }
        value += weight * yi;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_points_of_the_tables_are_read() {
        let points = reference();
        assert_eq!(points.iter().filter(|p| p.along_x).count(), 15);
        assert_eq!(points.iter().filter(|p| !p.along_x).count(), 15);
        assert!(points.iter().all(|p| p.velocity.abs() < 0.6));
    }

    #[test]
    fn a_cubic_is_interpolated_exactly() {
        let cubic = |x: f64| 1.0 - x + 2.0 * x * x - 3.0 * x * x * x;
        let nodes = [-0.5, -0.45, -0.35, -0.2, 0.0, 0.3, 0.5].map(|x| (x, cubic(x)));
        for x in [-0.49, -0.4, -0.2, 0.1, 0.45] {
            assert!((interpolate(&nodes, x) - cubic(x)).abs() < 1e-14);
        }
    }
}
