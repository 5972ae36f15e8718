//! Wings and airbags under pressure: equilibrium, noses, pressure that lags, several fabrics in one structure.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::{SewnFabric, Structure};
use ripstop::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::airbag;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};

use crate::command_line::ripstop;
use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;
use crate::wing::FABRIC;

pub fn trials() -> Vec<Trial> {
    [
        plain("wing::risers_carry_the_pressure", equilibrium),
        plain("wing::several_fabrics", several_fabrics),
        plain(
            "wing::lagged_pressure_ends_where_following_pressure_does",
            lagged_pressure,
        ),
        plain("wing::noses_stand_on_whole_meshes", noses_stand),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn equilibrium() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = ripstop(&[
        "run",
        "cases/wing-school.toml",
        "--variant",
        "quick",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let text = std::fs::read(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let value = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    // What the risers carry is pressure and weight, well within the tolerance of the quick solve, 3e-2.
    assert!(
        value("riser_balance_error") < 1e-2,
        "{}",
        value("riser_balance_error")
    );
    let (right, left) = (value("riser_force_right_n"), value("riser_force_left_n"));
    assert!((right / left - 1.0).abs() < 1e-2, "{right} {left}");
    let shares: f64 = ["A", "B", "C", "brake"]
        .iter()
        .map(|row| value(&format!("row_{row}_load_share")))
        .sum();
    assert!((shares - 1.0).abs() < 1e-9);
}

fn sheet_of(fabric: &Fabric) -> Structure {
    let shape = SheetShape {
        size_m: [1.0, 1.0],
        divisions: [8, 8],
        corner_m: DVec3::ZERO,
        across: DVec3::X,
        down: -DVec3::Z,
    };
    sheet::build(&shape, fabric, FabricModel::Membrane).unwrap()
}

/// Energy and gradient of a stretched state.
fn state(structure: &Structure) -> (f64, Vec<DVec3>) {
    let points: Vec<DVec3> = structure
        .positions_m
        .iter()
        .map(|p| {
            DVec3::new(
                1.02 * p.x + 0.01 * p.z,
                0.05 * p.x * p.z,
                1.01 * p.z - 0.02 * p.x,
            )
        })
        .collect();
    let mut cloth = Cloth::new(structure.clone());
    let input = StepInput::default();
    let mut evaluator = cloth.evaluator(&input, InitialHessian::BlockJacobi);
    let mut gradient = vec![DVec3::ZERO; points.len()];
    let energy = evaluator.evaluate(&points, &mut gradient);
    (energy, gradient)
}

/// Two names of one fabric change no bit; two fabrics give the sum of what each gives on its triangles.
fn several_fabrics() {
    let stiff = Fabric {
        warp_modulus_pa: 2e9,
        shear_modulus_pa: 3e8,
        ..FABRIC
    };
    let one = sheet_of(&FABRIC);
    let mut named_twice = one.clone();
    named_twice.further_fabrics = vec![SewnFabric::from(&FABRIC)];
    for triangle in named_twice.triangles.iter_mut().step_by(3) {
        triangle.fabric = 1;
    }
    let (energy, gradient) = state(&one);
    let (again, forces) = state(&named_twice);
    assert_eq!(energy.to_bits(), again.to_bits());
    assert_eq!(gradient, forces);
    let mut sewn = named_twice.clone();
    sewn.further_fabrics = vec![SewnFabric::from(&stiff)];
    let part = |fabric: &Fabric, number: u32| {
        let mut part = sheet_of(fabric);
        let keep: Vec<bool> = sewn.triangles.iter().map(|t| t.fabric == number).collect();
        let mut keep = keep.into_iter();
        part.triangles.retain(|_| keep.next().unwrap());
        state(&part)
    };
    let ((a, ga), (b, gb), (whole, g)) = (part(&FABRIC, 0), part(&stiff, 1), state(&sewn));
    assert!(((a + b) / whole - 1.0).abs() < 1e-12);
    let scale = g.iter().map(|f| f.length()).fold(0.0, f64::max);
    for ((x, y), z) in ga.iter().zip(&gb).zip(&g) {
        assert!((*x + *y - *z).length() < 1e-12 * scale);
    }
    assert!(
        (whole / energy - 1.0).abs() > 0.1,
        "the second law is not used"
    );
}

/// Below the nose, pressures inside and outside nearly cancel; on whole meshes it stands all the same, and shares its loads alike.
fn noses_stand() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let shares = |arguments: &[&str]| -> [f64; 3] {
        let mut all = vec!["run", "cases/wing-school.toml", "--overwrite", "--out"];
        all.push(out.to_str().unwrap());
        all.extend(arguments);
        let output = ripstop(&all);
        assert_eq!(output.code, 0, "{arguments:?}: {}", output.errors);
        let summary = std::fs::read(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        ["A", "B", "C"].map(|row| {
            let name = format!("row_{row}_load_share");
            summary["results"][name.as_str()]["value"].as_f64().unwrap()
        })
    };
    let shipped = shares(&["--variant", "prescribed"]);
    let coarser = "structure.wing.mesh.along_chord=16";
    let coarse = shares(&["--variant", "prescribed", "--set", coarser]);
    // The glide, whose pressure is computed.
    let glide = shares(&[]);
    // As docs/wings.md has them.
    // Fabric of the glide keeps some stiffness against pushing, that under prescribed pressure does not.
    for (known, found) in [
        ([0.40, 0.36, 0.24], shipped),
        ([0.40, 0.36, 0.24], coarse),
        ([0.39, 0.30, 0.30], glide),
    ] {
        for (known, found) in known.into_iter().zip(found) {
            let apart: f64 = found - known;
            assert!(apart.abs() < tolerance::LOAD_SHARE, "{found} for {known}");
        }
    }
}

/// An airbag under a pressure that lags takes the same shape as under one that follows.
fn lagged_pressure() {
    let bag = airbag::build(1.0, 10, &FABRIC).unwrap();
    let count = bag.structure.triangles.len();
    let height = |pressure: Pressure| {
        let mut cloth = Cloth::new(bag.structure.clone());
        let input = StepInput {
            pressure,
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-5,
            displacement_floor_m: 0.0,
            evaluation_limit: 20_000,
            history: 10,
            refresh_every: Some(10),
            initial_hessian: InitialHessian::Multigrid,
        };
        let outcome = cloth.solve_cloth(&input, &settings);
        assert_eq!(outcome.stop, ripstop::solve::lbfgs::Stop::Converged);
        cloth.positions_m[bag.middles[0] as usize].z
    };
    let whole = height(Pressure::Uniform(500.0));
    let lagged = height(Pressure::Lagged(&vec![500.0; count]));
    assert!((lagged / whole - 1.0).abs() < 1e-3, "{lagged} {whole}");
}
