//! Bodies that pass through faces of the box: a half model against the whole body, markers against their images, mounts and stings.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::immersed::folds::Folds;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::{Setup, Sides, StreamwiseEnds};
use ripstop::measure::{Record, results};
use ripstop::output::Results;
use ripstop::plan::Plan;
use ripstop::rigid::Surface;
use ripstop::run::without_files;
use ripstop::simulation::{MarkerEngine, Simulation};
use ripstop::statics::Statics;
use ripstop::validity;

use crate::coupling::exchange;
use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::tolerances::through_faces as tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("through_faces::markers_meet_their_images", Images),
        on_every_engine("through_faces::markers_before_the_outlet", Outlet),
        on_every_engine("through_faces::half_a_sphere_has_half_the_drag", HalfSphere),
        on_every_engine("through_faces::struts_panels_and_stings_stand", Mounts),
        plain("through_faces::what_lies_inside_counts", inside),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn parse(source: &str, folder: &Path, overrides: &[&str]) -> Case {
    let choices = Choices {
        variant: None,
        overrides: overrides.iter().map(|&o| o.to_owned()).collect(),
    };
    case::parse("case", source, folder, &choices).unwrap()
}

fn simulate(case: &Case, engine: Engine) -> (Simulation, Results) {
    let plan = Plan::new(&case.scene, engine.plan_placement());
    let (simulation, record): (Simulation, Record) =
        without_files(case, plan, engine.device()).unwrap();
    let results = results(&simulation, &Statics::default(), &record);
    (simulation, results)
}

fn value(results: &Results, name: &str) -> f64 {
    let quantity = results
        .get(name)
        .unwrap_or_else(|| panic!("no result {name}"));
    quantity
        .value
        .unwrap_or_else(|| panic!("{name} has no value: {quantity:?}"))
}

/// Cells of a small box; of the doubled one twice as many along y and z.
const CELLS: [usize; 3] = [14, 12, 11];

fn setup(cells: [usize; 3]) -> Setup {
    Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        sides: Sides::FreeSlip,
        relaxation_time: 0.6,
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator: Operator::RecursiveRegularised,
        eddy_viscosity: None,
    }
}

/// A wind in the small box.
fn wind([x, y, z]: [usize; 3]) -> [f64; 3] {
    let phase = 0.5 * x as f64 + 0.8 * y as f64 - 0.3 * z as f64;
    [
        0.05 + 0.01 * phase.sin(),
        0.02 * phase.cos(),
        -0.01 + 0.02 * (1.3 * phase).sin(),
    ]
}

/// What the markers exchange with the air in two passes: velocities, stiffness, forces and slips of each.
fn exchanged(
    engine: Engine,
    (cells, folds): ([usize; 3], Option<Folds>),
    wind: &(dyn Fn([usize; 3]) -> [f64; 3] + Sync),
    positions: &[[f64; 3]],
) -> Vec<[f64; 10]> {
    let air = engine.air(setup(cells), &|cell| (0.0, wind(cell)));
    let areas = vec![0.8; positions.len()];
    let mut markers = MarkerEngine::at_faces(&air, (folds, 0), areas, 1.2).unwrap();
    let still = vec![[0.0; 3]; positions.len()];
    exchange(&air, &mut markers, positions, &still);
    markers.repeat_forcing(&still).unwrap();
    markers.fetch_marker_forces().unwrap();
    let slips = markers.slip_velocities(&still).unwrap();
    (0..positions.len())
        .map(|k| {
            let (u, f, s) = (markers.air_velocities()[k], markers.force(k), slips[k]);
            let stiffness = markers.stiffness(k);
            [
                u[0], u[1], u[2], stiffness, f[0], f[1], f[2], s[0], s[1], s[2],
            ]
        })
        .collect()
}

/// Largest difference of each of the ten numbers over the largest of its kind.
fn assert_alike(got: &[[f64; 10]], expected: &[[f64; 10]], tolerance: f64) {
    for kind in [0..3, 3..4, 4..7, 7..10] {
        let largest = expected
            .iter()
            .flat_map(|all| &all[kind.clone()])
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
            for i in kind.clone() {
                let difference = (got[i] - expected[i]).abs() / largest;
                assert!(
                    difference < tolerance,
                    "marker {k}, number {i}: {} {} ({difference:e})",
                    got[i],
                    expected[i]
                );
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Images;

impl Body for Images {
    /// Markers at the lower side of y and the upper one of z, and in the edge between: as if their images stood in a box twice as wide and high.
    fn run(self, engine: Engine) {
        let folds = Folds {
            sides: [[true, false], [false, true]],
            outlet: false,
        };
        let positions: Vec<[f64; 3]> = (0..200)
            .map(|k| {
                let part = |factor: f64| (f64::from(k) * factor).fract();
                [
                    3.0 + 7.0 * part(0.618),
                    -0.499 + 6.0 * part(0.414).powi(2),
                    10.499 - 6.0 * part(0.732).powi(2),
                ]
            })
            .collect();
        let half = exchanged(engine, (CELLS, Some(folds)), &wind, &positions);
        let turns = [[false, false], [true, false], [false, true], [true, true]];
        let doubled: Vec<[f64; 3]> = turns
            .iter()
            .flat_map(|turn| {
                positions.iter().map(|&[x, y, z]| {
                    let y = if turn[0] { -1.0 - y } else { y };
                    [x, 12.0 + y, if turn[1] { 21.0 - z } else { z }]
                })
            })
            .collect();
        let mirrored = |[x, y, z]: [usize; 3]| {
            let turn = [y < 12, z > 10];
            let y = if turn[0] { 11 - y } else { y - 12 };
            let [u, v, w] = wind([x, y, if turn[1] { 21 - z } else { z }]);
            [
                u,
                if turn[0] { -v } else { v },
                if turn[1] { -w } else { w },
            ]
        };
        let whole = exchanged(engine, ([14, 24, 22], None), &mirrored, &doubled);
        assert_alike(
            &half,
            &whole[..positions.len()],
            tolerances::exchange(engine),
        );
    }
}

#[derive(Clone, Copy)]
struct Outlet;

impl Body for Outlet {
    /// Before the outlet markers read the last cell's velocity beyond it; every engine exchanges there what the CPU exchanges.
    fn run(self, engine: Engine) {
        let folds = Folds {
            sides: [[false; 2]; 2],
            outlet: true,
        };
        let positions: Vec<[f64; 3]> = (0..60)
            .map(|k| {
                let part = |factor: f64| (f64::from(k) * factor).fract();
                [
                    13.499 - 4.0 * part(0.618),
                    3.0 + 5.0 * part(0.414),
                    3.0 + 4.0 * part(0.732),
                ]
            })
            .collect();
        let own = exchanged(engine, (CELLS, Some(folds)), &wind, &positions);
        let on_cpu = exchanged(Engine::CpuF64, (CELLS, Some(folds)), &wind, &positions);
        assert_alike(&own, &on_cpu, tolerances::exchange(engine));
        let longer = |[x, y, z]: [usize; 3]| wind([x.min(13), y, z]);
        let beyond = exchanged(engine, ([20, 12, 11], None), &longer, &positions);
        for (own, beyond) in own.iter().zip(&beyond) {
            for a in 0..3 {
                let difference = (own[a] - beyond[a]).abs() / 0.06;
                assert!(difference < tolerances::exchange(engine), "{difference:e}");
            }
        }
    }
}

/// A sphere of triangles that are mirror images of each other at its three planes of symmetry: an octahedron whose faces are divided.
fn sphere(radius_m: f64, parts: i32) -> Surface {
    let mut surface = Surface::default();
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    for octant in 0..8 {
        let signs = [0, 1, 2].map(|axis| if octant >> axis & 1 == 1 { -1 } else { 1 });
        let mut add = |corners: [[i32; 2]; 3]| {
            let mut nodes = corners.map(|[p, q]| {
                let place = [p, q, parts - p - q];
                let key: [i32; 3] = std::array::from_fn(|a| signs[a] * place[a]);
                *numbers.entry(key).or_insert_with(|| {
                    let direction = DVec3::from_array(key.map(f64::from)).normalize();
                    surface.positions_m.push(direction * radius_m);
                    surface.positions_m.len() as u32 - 1
                })
            });
            if signs.iter().product::<i32>() < 0 {
                nodes.swap(1, 2);
            }
            surface.triangles.push(nodes);
        };
        for p in 0..parts {
            for q in 0..parts - p {
                add([[p, q], [p + 1, q], [p, q + 1]]);
                if p + q + 1 < parts {
                    add([[p + 1, q], [p + 1, q + 1], [p, q + 1]]);
                }
            }
        }
    }
    surface
}

const SPHERE: &str = r#"
version = 1
title = "Sphere, Re 100"
[air]
density_kg_m3 = 1.2
kinematic_viscosity_m2_s = 1.5e-5
[air.wind_tunnel]
speed_m_s = 0.015
size_m = [0.5, 0.4, 0.3]
start_time_s = 2.0
[resolution]
cell_size_m = 0.0125
lattice_speed = 0.08
operator = "recursive_regularised"
[bodies.sphere]
position_m = [0.175, 0.2, 0.15]
[bodies.sphere.sphere]
diameter_m = 0.1
[coupling]
over_relaxation = 1.6
[time]
end_s = 20.0
[output]
sample_interval_s = 0.5
"#;

/// The half of the tunnel above the sphere's middle.
const HALF: [&str; 3] = [
    "air.wind_tunnel.size_m=[0.5, 0.2, 0.3]",
    "bodies.sphere.position_m=[0.175, 0.0, 0.15]",
    "air.faces.y_lower=symmetry",
];

#[derive(Clone, Copy)]
struct HalfSphere;

impl Body for HalfSphere {
    /// On a plane of symmetry half a sphere has half the drag of a whole one in a tunnel twice as wide: to round-off where their markers are images of
    /// each other, and nearly so where triangles are cut.
    fn run(self, engine: Engine) {
        let folder = tempfile::tempdir().unwrap();
        let mut obj = String::new();
        let symmetric = sphere(0.05, 5);
        for p in &symmetric.positions_m {
            writeln!(obj, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
        }
        for [a, b, c] in &symmetric.triangles {
            writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
        }
        std::fs::write(folder.path().join("sphere.obj"), obj).unwrap();
        let area_m2 = 0.25 * PI * 0.01;
        let from_file = |area_m2: f64| {
            SPHERE.replace(
                "[bodies.sphere.sphere]\ndiameter_m = 0.1",
                &format!(
                    "[bodies.sphere.reference]\narea_m2 = {area_m2:?}\nlength_m = 0.1\n\
                     [bodies.sphere.mesh]\nfile = \"sphere.obj\"\nscale = 1.0"
                ),
            )
        };
        let drag = |source: &str, changes: &[&str]| {
            let case = parse(source, folder.path(), changes);
            let (_, results) = simulate(&case, engine);
            [
                "drag_coefficient",
                "side_force_coefficient",
                "lift_coefficient",
            ]
            .map(|name| value(&results, name))
        };
        let symmetric = tolerances::half_model(engine);
        for (whole, half, tolerance) in [
            (from_file(area_m2), from_file(0.5 * area_m2), symmetric),
            (
                SPHERE.to_owned(),
                SPHERE.to_owned(),
                symmetric.max(tolerances::CUT_TRIANGLES),
            ),
        ] {
            let [whole, side, lift] = drag(&whole, &[]);
            assert!(side.abs() + lift.abs() < 1e-2 * whole);
            let [half, side, lift] = drag(&half, &HALF);
            let difference = (half / whole - 1.0).abs();
            assert!(difference < tolerance, "{half} {whole}: {difference:e}");
            // The other half's force across the plane is missing.
            assert!(side.abs() > 0.1 * half && lift.abs() < 1e-2 * half);
        }
    }
}

/// A strut on a floor to which the air sticks, a panel through a side and a sting through the outlet.
const MOUNTS: &str = r#"
version = 1
title = "Mounts"
[air]
density_kg_m3 = 1.2
kinematic_viscosity_m2_s = 1.5e-5
[air.wind_tunnel]
speed_m_s = 0.015
size_m = [0.5, 0.3, 0.25]
start_time_s = 2.0
[air.faces]
y_upper = "frictionless"
z_lower = "no_slip"
[resolution]
cell_size_m = 0.0125
lattice_speed = 0.08
operator = "recursive_regularised"
[bodies.panel]
position_m = [0.28, 0.3, 0.1]
[bodies.panel.plate]
size_m = [0.1, 0.1]
[bodies.sting]
position_m = [0.5, 0.15, 0.15]
rotation = { axis = [0.0, 1.0, 0.0], angle_deg = 90.0 }
[bodies.sting.cylinder]
diameter_m = 0.075
length_m = 0.3
closed = true
[bodies.strut]
position_m = [0.15, 0.15, 0.0]
[bodies.strut.cylinder]
diameter_m = 0.075
length_m = 0.2
closed = true
[coupling]
over_relaxation = 1.6
[time]
end_s = 8.0
[output]
sample_interval_s = 0.5
"#;

#[derive(Clone, Copy)]
struct Mounts;

impl Body for Mounts {
    /// Bodies at three kinds of faces feel the wind, and nothing pretends that the momentum box holds them.
    fn run(self, engine: Engine) {
        let (mut simulation, results) = simulate(&parse(MOUNTS, Path::new("."), &[]), engine);
        for name in ["panel", "sting", "strut"] {
            let drag = value(&results, &format!("{name}_drag_coefficient"));
            assert!((0.05..5.0).contains(&drag), "{name}: {drag}");
        }
        let slip = value(&results, "slip_mean");
        assert!(slip < tolerances::SLIP, "{slip}");
        for name in ["force_imbalance", "drag_momentum_box_n"] {
            let missing = results.get(name).unwrap();
            assert_eq!(missing.value, None, "{name}");
            assert!(missing.note.as_ref().unwrap().contains("through a face"));
        }
        let sample = simulation.impulse_sample().unwrap().unwrap();
        assert_eq!(sample.momentum_box, None);
        assert!(sample.mass_defect.abs() < 1e-4, "{}", sample.mass_defect);
    }
}

/// Areas and volumes are those of the part in the box; the report names the faces; nothing is foretold or corrected that is known of whole bodies alone.
fn inside() {
    let case = parse(MOUNTS, Path::new("."), &[]);
    let [panel, sting, strut] = &case.scene.rigid_bodies[..] else {
        panic!("three bodies");
    };
    let near = |got: f64, expected: f64, tolerance: f64| {
        assert!((got / expected - 1.0).abs() < tolerance, "{got} {expected}");
    };
    let circle_m2 = 0.25 * PI * 0.075 * 0.075;
    near(panel.reference_area_m2, 0.005, 1e-9);
    near(panel.blocking_area_m2, 0.005, 1e-9);
    assert_eq!(panel.volume_m3, None);
    near(strut.reference_area_m2, 0.0075, 1e-9);
    near(sting.reference_area_m2, 0.0225, 1e-9);
    // Cylinders are prisms.
    let prism = tolerances::PRISM;
    near(strut.blocking_area_m2, 0.0075, prism);
    near(sting.blocking_area_m2, circle_m2, prism);
    let (volume, middle) = strut.volume_m3.unwrap();
    near(volume, 0.1 * circle_m2, prism);
    assert!((middle - DVec3::new(0.15, 0.15, 0.05)).length() < 1e-9);
    let (volume, middle) = sting.volume_m3.unwrap();
    near(volume, 0.15 * circle_m2, prism);
    assert!((middle - DVec3::new(0.425, 0.15, 0.15)).length() < 1e-9);
    let (low, high) = strut.surface.bounds_m();
    assert_eq!(low.z, 0.0);
    near(high.z, 0.1, 1e-9);
    let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
    let report = plan.report(&case.scene, &case.coarser, 1);
    for face in ["air.faces.y_upper", "the outlet", "air.faces.z_lower"] {
        let line = format!("    passes through    {face}\n");
        assert!(report.contains(&line), "{face} is not in\n{report}");
    }

    let half = parse(SPHERE, Path::new("."), &HALF);
    let body = &half.scene.rigid_bodies[0];
    near(body.reference_area_m2, 0.125 * PI * 0.01, 1e-9);
    assert!(validity::expected_errors(&half.scene).is_empty());
    let plan = Plan::new(&half.scene, Engine::CpuF32.plan_placement());
    let rows = validity::beforehand(&half.scene, &plan);
    let row = |name: &str| rows.iter().find(|row| row.name == name).unwrap();
    // Of the walls that it does not touch those of z are nearest, one diameter away; half its thickness lies in the box.
    let walls = row("distance to the side walls").value.unwrap();
    near(walls, 1.0, 0.02);
    let thickness = row("cells across the thickness").value.unwrap();
    near(thickness, 8.0, 0.02);
    let (_, results) = simulate(
        &parse(
            SPHERE,
            Path::new("."),
            &[&HALF[..], &["time.end_s=6.0"]].concat(),
        ),
        Engine::CpuF32,
    );
    let corrected = results.get("drag_coefficient_blockage_corrected").unwrap();
    assert_eq!(corrected.value, None);
    assert!(format!("{corrected:?}").contains("passes through a face"));
    assert_eq!(results.get("drag_coefficient").unwrap().reference, None);
}
