//! Plates of fabric held along an edge: bending, supports, and the air's force by three routes.

use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::plate::{self, Plate, Support};
use ripstop::plan::{Plan, Precision};
use ripstop::run;
use ripstop::statics::Statics;
use ripstop::validity;

use crate::command_line::root;
use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        plain("plates::a_clamp_holds_place_and_tangent", clamp),
        plain("plates::a_strip_bends_like_a_beam", strip),
        plain("plates::a_pinned_edge_turns_freely", pinned),
        plain("plates::set_ups_are_judged", judged),
        on_every_engine("plates::three_routes_to_one_force", Routes),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-7,
    displacement_floor_m: 0.0,
    evaluation_limit: 200_000,
    history: 8,
    refresh_every: Some(10),
    initial_hessian: InitialHessian::Multigrid,
};

/// Flexural rigidity E h³/12 of a metre of width [N m].
const BEAM_NM: f64 = 1.0;

fn fabric(poisson_ratio: f64, thickness_m: f64) -> Fabric {
    let modulus_pa = 12.0 * BEAM_NM / thickness_m.powi(3);
    Fabric {
        thickness_m,
        density_kg_m3: 1.0 / thickness_m,
        warp_modulus_pa: modulus_pa,
        weft_modulus_pa: modulus_pa,
        poisson_ratio,
        shear_modulus_pa: Fabric::isotropic_shear_modulus_pa(modulus_pa, poisson_ratio),
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 1.0,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// A level plate of a metre; returns its tip's way under gravity [m].
fn sag(width_m: f64, divisions: [usize; 2], fabric: &Fabric, support: Support, g: DVec3) -> DVec3 {
    let plate = Plate {
        size_m: [1.0, width_m],
        divisions,
        held_edge_m: DVec3::ZERO,
        along: DVec3::X,
        across: DVec3::Y,
        support,
        flexural_rigidity_nm: fabric.rigidity_nm()[0][0],
    };
    let structure = plate::build(&plate, fabric).unwrap();
    let mut cloth = Cloth::new(structure);
    let input = StepInput {
        gravity_m_s2: g,
        ..StepInput::default()
    };
    cloth.solve_cloth(&input, &SETTINGS);
    cloth.positions_m[plate.tip() as usize] - plate.flat_tip_m()
}

/// Heavy cantilever, w L³/(E I) = 1: drop 0.1235 (elastica; `src/validate/cloth/heavy_cantilever.rs`), with second order.
fn clamp() {
    let fabric = fabric(0.0, 0.02);
    let errors = [5, 10, 20].map(|cells| {
        let down = -DVec3::Z;
        let way = sag(0.2, [cells, 2], &fabric, Support::Clamped, down);
        (-way.z / 0.1235 - 1.0).abs()
    });
    assert!(errors[2] < tolerances::CLAMP, "{errors:?}");
    assert!(errors[1] < 0.4 * errors[0], "{errors:?}");
}

/// A narrow strip is free to bend across its length the other way: it is as stiff as a beam, not 1/(1 − ν²) = 1.19 times that.
fn strip() {
    let fabric = fabric(0.4, 0.02);
    let down = -DVec3::Z;
    let way = sag(0.05, [60, 3], &fabric, Support::Clamped, down);
    assert!(
        (-way.z / 0.1235 - 1.0).abs() < tolerances::STRIP,
        "{}",
        way.z
    );
}

/// Pinned at its edge a plate hangs straight down, bent nowhere, whatever its rigidity.
fn pinned() {
    let fabric = fabric(0.3, 0.02);
    let pull = DVec3::new(-0.05, 0.0, -1.0);
    let way = sag(0.5, [8, 4], &fabric, Support::Pinned, pull);
    let expected = pull.normalize() - DVec3::X;
    let stretch = pull.length() / (2.0 * fabric.warp_modulus_pa * fabric.thickness_m);
    assert!(
        way.distance(expected) < tolerances::PINNED + 2.0 * stretch,
        "{way} {expected}"
    );
}

/// Length of the run, distance to the side walls and blockage of plates are judged, each by what it stands for.
fn judged() {
    let (flag, plate) = ("cases/flag.toml", "cases/flexible-plate.toml");
    let along = "length of the run, along the stream";
    let across = "length of the run, across the stream";
    let (walls, blockage) = ("distance to the side walls", "blockage of the body");
    for (file, change, name, value, valid) in [
        (flag, None, along, 40.0, true),
        (flag, Some("time.end_s=0.5"), along, 0.5, false),
        (plate, None, across, 60.0, true),
        // A third of L/U.
        (plate, Some("time.end_s=0.1"), across, 1.6, false),
        (flag, None, walls, 1.5, true),
        (
            flag,
            Some("structure.plate.held_edge_m=[2.0, 0.2, 2.0]"),
            walls,
            0.2,
            false,
        ),
        // A row of its clamp stands below its foot.
        (
            plate,
            Some("structure.plate.held_edge_m=[0.05, 0.08, 0.02]"),
            walls,
            0.4 - 1.0 / 30.0,
            false,
        ),
        // It stands on the floor.
        (
            plate,
            Some("structure.plate.held_edge_m=[0.05, 0.08, 0.004]"),
            walls,
            1.5,
            true,
        ),
        (plate, None, blockage, 5e-4 / 0.0256, true),
        (
            plate,
            Some("structure.plate.size_m=[0.05, 0.06]"),
            blockage,
            3e-3 / 0.0256,
            false,
        ),
    ] {
        let choices = Choices {
            variant: None,
            overrides: change.into_iter().map(str::to_owned).collect(),
        };
        let case = case::load(&root().join(file), &choices).unwrap();
        let plan = Plan::new(&case.scene, Precision::F32);
        let rows = validity::beforehand(&case.scene, &plan);
        let row = rows.iter().find(|row| row.name == name).unwrap();
        let found = row.value.unwrap();
        assert!((found / value - 1.0).abs() < 1e-6, "{name}: {found}");
        assert_eq!(row.valid, Some(valid), "{file} {change:?}: {name}");
        // A flag lies along the stream.
        assert!(file != flag || rows.iter().all(|row| row.name != blockage));
        let other = if name == along { across } else { along };
        assert!(name == walls || name == blockage || rows.iter().all(|row| row.name != other));
    }
}

/// A plate in the wind, coarse and short.
const IN_WIND: &str = r#"version = 1
[air]
density_kg_m3 = 1000.0
kinematic_viscosity_m2_s = 1e-5
[air.wind_tunnel]
speed_m_s = 0.16
size_m = [0.12, 0.08, 0.1]
start_time_s = 0.03
sponge_length_m = 0.02
[resolution]
cell_size_m = 2.5e-3
lattice_speed = 0.1
operator = "recursive_regularised"
[structure.plate]
size_m = [0.05, 0.02]
divisions = [10, 4]
held_edge_m = [0.035, 0.04, 0.03]
along = [0.0, 0.0, 2.0]
across = [0.0, 1.0, 0.0]
support = "clamped"
[fabric]
thickness_m = 2e-3
density_kg_m3 = 678.0
youngs_modulus_pa = 4.878e5
poisson_ratio = 0.4
[gravity]
acceleration_m_s2 = [0.0, 0.0, 4.659]
[coupling]
over_relaxation = 1.6
structure_every = 1
[solver]
tolerance = 1e-4
[time]
end_s = 0.25
[output]
sample_interval_s = 0.025
"#;

#[derive(Clone, Copy)]
struct Routes;

impl Body for Routes {
    fn run(self, engine: Engine) {
        let case = case::parse("plate", IN_WIND, Path::new("."), &Choices::default()).unwrap();
        let plan = Plan::new(&case.scene, engine.plan_placement());
        let (simulation, record) = run::without_files(&case, plan, engine.device()).unwrap();
        let results = ripstop::measure::results(&simulation, &Statics::default(), &record);
        let value = |name: &str| results.get(name).and_then(|found| found.value).unwrap();
        let markers = value("drag_markers_n");
        let momentum_box = value("drag_momentum_box_n");
        let supports = value("drag_supports_n");
        assert!(markers > 0.0);
        let closure = tolerances::momentum_closure(engine);
        assert!(
            (momentum_box / markers - 1.0).abs() < closure,
            "{markers} {momentum_box}"
        );
        assert!(
            (supports / markers - 1.0).abs() < tolerances::REACTION,
            "{markers} {supports}"
        );
        // One force, one number: also where the coefficient comes from.
        let force = value("force_x_n");
        assert!((force / markers - 1.0).abs() < 1e-9, "{force} {markers}");
        let of_coefficient = value("drag_coefficient") * 0.5 * 1000.0 * 0.16 * 0.16 * 1e-3;
        assert!((of_coefficient / force - 1.0).abs() < 1e-9);
        // 2 b/U, of which 50 are needed.
        let drag = results.get("drag_coefficient").unwrap();
        let why = drag.unresolved.as_deref().unwrap();
        assert!(why.contains("averaging begins 30 b/U"), "{why}");
        // Bent downstream, not torn off.
        let tip = value("tip_displacement_x_m");
        assert!((0.005..0.05).contains(&tip), "{tip}");
    }
}
