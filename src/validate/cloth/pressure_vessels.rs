//! Balloons: tension pR/2 in a sphere, pR around and pR/2 along a cylinder with round ends, R the radius under pressure.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::{SETTINGS, Sheet, built};
use crate::cpu::cloth::read_outs::triangle_loads;
use crate::cpu::cloth::{Cloth, Pressure, StepInput};
use crate::geometry::{fabric_surface, surfaces};
use crate::rigid::Surface;

const RADIUS_M: f64 = 0.5;
const PRESSURE_PA: f64 = 500.0;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let edges: &[f64] = session.size(&[0.1, 0.05], &[0.1, 0.05, 0.025, 0.0125]);
    let finest = edges[edges.len() - 1];
    for &edge in edges {
        let surface = surfaces::sphere(RADIUS_M, edge);
        let sheet = inflate(session, &surface)?;
        let positions = &sheet.cloth.positions_m;
        let radius = positions.iter().map(|x| x.length()).sum::<f64>() / positions.len() as f64;
        let [larger, smaller] = mean_tensions(&sheet, |_| true);
        let expected = 0.5 * PRESSURE_PA * radius;
        let row = session
            .sheet_row(
                &sheet,
                format!("sphere: mean tension over pR, edge {edge} m"),
                0.5 * (larger + smaller) / (PRESSURE_PA * radius),
            )
            .reference(0.5, "exact");
        if edge == finest {
            row.gate(Gate::Within(5e-3));
        }
        session.sheet_row(
            &sheet,
            "sphere: larger less smaller tension, over mean",
            (larger - smaller) / expected,
        );
    }
    for &edge in edges {
        let surface = capsule(4.0 * RADIUS_M, edge);
        let sheet = inflate(session, &surface)?;
        // The round ends widen less; half a diameter off they are forgotten.
        let is_middle = |x: DVec3| x.z.abs() < RADIUS_M;
        let (mut sum, mut count) = (0.0, 0.0);
        for x in sheet.cloth.positions_m.iter().filter(|x| is_middle(**x)) {
            sum += x.truncate().length();
            count += 1.0;
        }
        let radius = sum / count;
        let [around, along] = mean_tensions(&sheet, is_middle);
        for (what, value, reference) in [("around", around, 1.0), ("along", along, 0.5)] {
            let row = session
                .sheet_row(
                    &sheet,
                    format!("cylinder: tension {what} over pR, edge {edge} m"),
                    value / (PRESSURE_PA * radius),
                )
                .reference(reference, "exact");
            if edge == finest {
                row.gate(Gate::Within(5e-3));
            }
        }
    }
    Ok(())
}

/// A cylinder along z of the length `length_m`, with a half sphere at either end; normals outwards.
fn capsule(length_m: f64, edge_m: f64) -> Surface {
    let around = (TAU * RADIUS_M / edge_m).ceil() as usize;
    let quarter = (0.5 * PI * RADIUS_M / edge_m).ceil() as usize;
    let along = (length_m / edge_m).ceil() as usize;
    // Radius and height of the rings from the lower pole to the upper one, poles left out.
    let mut rings: Vec<[f64; 2]> = Vec::new();
    for end in [-1.0, 1.0] {
        let mut half: Vec<[f64; 2]> = (1..=quarter)
            .map(|k| {
                let (sine, cosine) = (0.5 * PI * k as f64 / quarter as f64).sin_cos();
                [RADIUS_M * sine, end * (0.5 * length_m + RADIUS_M * cosine)]
            })
            .collect();
        if end > 0.0 {
            half.reverse();
            let z = |k: usize| length_m * (k as f64 / along as f64 - 0.5);
            rings.extend((1..along).map(|k| [RADIUS_M, z(k)]));
        }
        rings.append(&mut half);
    }
    let pole = 0.5 * length_m + RADIUS_M;
    let mut surface = Surface {
        positions_m: vec![-pole * DVec3::Z, pole * DVec3::Z],
        triangles: Vec::new(),
    };
    for [radius, z] in &rings {
        for i in 0..around {
            let (sine, cosine) = (TAU * i as f64 / around as f64).sin_cos();
            surface
                .positions_m
                .push(DVec3::new(radius * cosine, radius * sine, *z));
        }
    }
    let node = |i: usize, j: usize| (2 + j * around + i % around) as u32;
    let last = rings.len() - 1;
    for i in 0..around {
        surface.triangles.push([0, node(i + 1, 0), node(i, 0)]);
        surface
            .triangles
            .push([1, node(i, last), node(i + 1, last)]);
        for j in 0..last {
            let (a, b) = (node(i, j), node(i + 1, j));
            let (c, d) = (node(i + 1, j + 1), node(i, j + 1));
            if (i + j) % 2 == 0 {
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                surface.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    surface
}

/// A balloon at its equilibrium.
fn inflate(session: &Session, surface: &Surface) -> Result<Sheet, Stop> {
    let fabric = super::isotropic(4e8, 0.3, 1e-4);
    let structure = fabric_surface::build(surface, DVec3::Z, &fabric);
    let structure = built(structure.ok(), "the balloon")?;
    let mut sheet = session.sheet(Cloth::new(structure), true)?;
    let input = StepInput {
        pressure: Pressure::Uniform(PRESSURE_PA),
        ..StepInput::default()
    };
    session.solve_to_rest(&mut sheet, &input, &SETTINGS)?;
    Ok(sheet)
}

/// Principal tensions [N/m], averaged over the rest area of triangles whose middle is chosen.
fn mean_tensions(sheet: &Sheet, is_chosen: impl Fn(DVec3) -> bool) -> [f64; 2] {
    let (structure, positions) = (&sheet.cloth.structure, &sheet.cloth.positions_m);
    let (mut sums, mut area) = ([0.0; 2], 0.0);
    for (triangle, load) in structure
        .triangles
        .iter()
        .zip(triangle_loads(structure, positions))
    {
        let middle: DVec3 = triangle.nodes.iter().map(|n| positions[*n as usize]).sum();
        if is_chosen(middle / 3.0) {
            area += triangle.rest_area_m2;
            for (sum, tension) in sums.iter_mut().zip(load.principal_tensions_n_m) {
                *sum += triangle.rest_area_m2 * tension;
            }
        }
    }
    sums.map(|sum| sum / area)
}
