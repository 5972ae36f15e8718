//! Air between two spheres, the inner turning slowly inside the outer: Couette flow with immersed walls.
//!
//! Without inertia u_φ = Ω (R₁³ R₂³/(R₂³ − R₁³)) (1/r² − r/R₂³) sin θ, and either sphere feels the torque 8πμΩ R₁³ R₂³/(R₂³ − R₁³) (Landau &
//! Lifshitz, Fluid Mechanics, section 20, problem 1). R₂ = 2 R₁ and Re = ΩR₁²/ν = 0.3, where inertia changes the torque by 1e-4. Markers stand on
//! the spheres, or half a cell behind them, as those of closed rigid bodies do (`docs/rigid-bodies.md`): a check of that inset which owes
//! nothing to the drags it was found from.

use std::f64::consts::PI;

use super::super::flows::{periodic, relaxation_time, slope, states};
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::exchange;
use crate::geometry::surfaces;
use crate::lattice::Operator;
use crate::simulation::MarkerEngine;

const VISCOSITY: f64 = 1.0 / 6.0;
const REYNOLDS: f64 = 0.3;

/// Viscous times (R₂ − R₁)²/(π²ν) until the flow counts as steady.
const SETTLING_TIMES: f64 = 6.0;

/// Cells that the kernel reaches from a wall.
const REACH: f64 = 2.0;

/// Over-relaxation, as canopies and bodies have it.
const STRENGTH: f64 = 1.6;

struct Sphere {
    directions: Vec<[f64; 3]>,
    areas: Vec<f64>,
    radius: f64,
}

/// Markers in the middles of triangles of at most a cell's area, moved out to `radius`, with the sphere's area.
fn sphere(radius: f64) -> Sphere {
    let surface = surfaces::sphere(radius, 1.5);
    let (mut directions, mut areas) = (Vec::new(), Vec::new());
    for nodes in &surface.triangles {
        let [a, b, c] = nodes.map(|n| surface.positions_m[n as usize]);
        directions.push((a + b + c).normalize().to_array());
        areas.push(0.5 * (b - a).cross(c - a).length());
    }
    let share = 4.0 * PI * radius * radius / areas.iter().sum::<f64>();
    areas.iter_mut().for_each(|area| *area *= share);
    Sphere {
        directions,
        areas,
        radius,
    }
}

/// Relative errors of the torque on the inner sphere and of the velocity between the walls.
struct Errors {
    cells: [usize; 3],
    torque: f64,
    velocity: f64,
}

fn errors(session: &mut Session, inner: f64, inset: f64) -> Result<Errors, Stop> {
    let outer = 2.0 * inner;
    let side = 2 * (outer + inset + 3.5).ceil() as usize;
    let cells = [side; 3];
    // Off the lattice's symmetry.
    let middle = [
        0.5 * side as f64 - 0.37,
        0.5 * side as f64 - 0.61,
        0.5 * side as f64 - 0.5,
    ];
    let rate = REYNOLDS * VISCOSITY / (inner * inner);
    let mut air = session.air(
        periodic(
            cells,
            relaxation_time(VISCOSITY),
            Operator::TwoRelaxationTimes,
        ),
        &|_| (0.0, [0.0; 3]),
    )?;
    let spheres = [sphere(inner - inset), sphere(outer + inset)];
    let (mut positions, mut velocities, mut areas) = (Vec::new(), Vec::new(), Vec::new());
    for (number, sphere) in spheres.iter().enumerate() {
        for direction in &sphere.directions {
            let arm = direction.map(|d| d * sphere.radius);
            positions.push([0, 1, 2].map(|a| middle[a] + arm[a]));
            let turning = if number == 0 { rate } else { 0.0 };
            velocities.push([-turning * arm[1], turning * arm[0], 0.0]);
        }
        areas.extend(&sphere.areas);
    }
    let mut markers = MarkerEngine::new(&air, areas, STRENGTH)?;
    let gap = outer - inner;
    let steps = (SETTLING_TIMES * gap * gap / (PI * PI * VISCOSITY)).ceil() as usize;
    for _ in 0..steps {
        exchange(&air, &mut markers, &positions, &velocities)?;
        session.advance_with(&mut air, &markers)?;
    }
    exchange(&air, &mut markers, &positions, &velocities)?;
    markers.fetch_marker_forces()?;
    let shape = outer.powi(3) * inner.powi(3) / (outer.powi(3) - inner.powi(3));
    let expected = 8.0 * PI * VISCOSITY * rate * shape;
    let found: f64 = (0..spheres[0].directions.len())
        .map(|k| {
            let (force, place) = (markers.force(k), positions[k]);
            (place[0] - middle[0]) * force[1] - (place[1] - middle[1]) * force[0]
        })
        .sum();
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, (_, u)) in states(&air)?.into_iter().enumerate() {
        let cell = [i % side, i / side % side, i / side / side];
        let arm = [0, 1, 2].map(|a| cell[a] as f64 - middle[a]);
        let r = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (inner + REACH..outer - REACH).contains(&r) {
            let turning = rate * shape * (1.0 / r.powi(3) - 1.0 / outer.powi(3));
            let exact = [-turning * arm[1], turning * arm[0], 0.0];
            for a in 0..3 {
                off += (u[a] - exact[a]).powi(2);
                whole += exact[a] * exact[a];
            }
        }
    }
    Ok(Errors {
        cells,
        torque: found / expected - 1.0,
        velocity: (off / whole).sqrt(),
    })
}

pub(in crate::validate) fn compute(session: &mut Session) -> Result<(), Stop> {
    let radii: &[f64] = session.size(&[5.0, 7.0, 10.0], &[5.0, 7.0, 10.0, 14.0, 20.0]);
    for (inset, what) in [
        (0.0, "markers on the walls"),
        (0.5, "markers half a cell behind the walls"),
    ] {
        let mut points = Vec::new();
        for (number, &radius) in radii.iter().enumerate() {
            let Errors {
                cells,
                torque,
                velocity,
            } = errors(session, radius, inset)?;
            let last = number + 1 == radii.len();
            session.row(
                cells,
                format!("{what}, R = {radius}: error of the torque"),
                torque,
            );
            let row = session.row(
                cells,
                format!("{what}, R = {radius}: L2 error of the velocity"),
                velocity,
            );
            if last && inset > 0.0 {
                row.gate(Gate::AtMost(0.02));
            }
            points.push([radius.ln(), velocity.ln()]);
            if last {
                let row = session.row(
                    cells,
                    format!("{what}: order of the velocity, fitted"),
                    -slope(&points),
                );
                if inset == 0.0 {
                    row.reference(1.0, "first order, as markers spread over the wall")
                        .gate(Gate::AtLeast(0.95));
                }
            }
        }
    }
    Ok(())
}
