//! Balance of the fabric's energy: what is put in is found again, but for what falls with the time step.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::measure::Record;
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Plan, Precision, Storage};
use ripstop::run::without_files;
use ripstop::simulation::Energies;

use crate::canopy::small_case;
use crate::engines::{Engine, needs_device, plain};
use crate::read_outs::column;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("energy::a_shaken_rope", shaken_rope),
        plain("energy::a_canopy_in_the_wind::cpu", canopy_on_host),
        plain("energy::columns_follow_the_scene", columns),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    trials.push(needs_device(
        "energy::a_canopy_in_the_wind::gpu".to_owned(),
        canopy_on_device,
    ));
    trials
}

const ROPE: &str = r#"
version = 1

[structure.cable]
ends_m = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]
pretension_n = 20.0
segments = 12
material = { area_m2 = 1e-4, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e7, damping_n_s = 0.5 }

[supports.hand]
box_m = [[0.9, -0.1, 0.9], [1.1, 0.1, 1.1]]

[supports.hand.motion.oscillation]
frequency_hz = 2.0
displacement_m = [0.005, 0.0, 0.02]

[gravity]
acceleration_m_s2 = [0.0, 0.0, -9.81]

[solver]
tolerance = 1e-7
damping_1_s = 0.3

[time]
end_s = 0.4
step_s = 1e-3
"#;

/// Energies at the end of a shaken rope with damping of both kinds.
fn rope(integration: &str, step_s: f64) -> Energies {
    let choices = Choices {
        variant: None,
        overrides: vec![
            format!("time.integration=\"{integration}\""),
            format!("time.step_s={step_s:e}"),
        ],
    };
    let case = case::parse("rope", ROPE, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, Precision::F64);
    let (simulation, _) = without_files(&case, plan, None).unwrap();
    simulation.energies().unwrap()
}

/// The rest of the balance falls with the third power of the step by BDF2, as what it takes of an oscillation does, with the step by backward Euler.
fn shaken_rope() {
    for (integration, order) in [("bdf2", 3.0), ("backward_euler", 1.0)] {
        let ladder = [5e-4, 2.5e-4, 1.25e-4].map(|step_s| rope(integration, step_s));
        let losses = ladder.map(|energies| energies.numerical_loss_j);
        let all = ladder[2];
        println!("{integration}: {losses:?} J of {all:?}");
        let put_in = all.work.of_supports_j.abs() + all.work.lost_to_damping_j;
        assert!(all.work.lost_to_damping_j > 5e-4 && all.work.of_supports_j.abs() > 1e-3);
        assert!(
            losses[2].abs() < tolerances::ENERGY_REST * put_in,
            "{losses:?}"
        );
        for i in 0..2 {
            let found = (losses[i] / losses[i + 1]).log2();
            assert!(
                (found - order).abs() < tolerances::ORDER_OF_THE_REST,
                "{integration}: {found}, {losses:?}"
            );
        }
    }
}

fn last(record: &Record, name: &str) -> f64 {
    *column(record, name).last().unwrap()
}

/// A canopy that opens: fabric that snaps taut loses motion that no mesh holds, whatever the integration; by BDF2 it loses less, and the balance knows
/// nothing that is negative. A device has the account of the host.
fn canopy(placement: &Placement, engine: Engine, ways: &[&str]) -> Vec<f64> {
    let share = |integration: &&str| {
        let change = format!("time.integration=\"{integration}\"");
        let case = small_case(&[&change, "time.end_s=0.012", "solver.tolerance=1e-3"]);
        let plan = Plan::new(&case.scene, placement.clone());
        let (_, record) = without_files(&case, plan, engine.device()).unwrap();
        let loss_j = last(&record, "numerical_loss_j");
        let work_j = last(&record, "work_of_air_j");
        println!("{integration}: work of the air {work_j:.3} J, lost {loss_j:.3} J");
        assert!(work_j > 0.1);
        loss_j / work_j
    };
    let shares: Vec<f64> = ways.iter().map(share).collect();
    for share in &shares {
        assert!((0.0..1.0).contains(share), "{shares:?}");
    }
    shares
}

fn canopy_on_host() {
    let ways = ["bdf2", "backward_euler"];
    let shares = canopy(&Precision::F32.into(), Engine::CpuF32, &ways);
    assert!(shares[0] < 0.9 * shares[1], "{shares:?}");
}

fn canopy_on_device() {
    let placement = Placement {
        air: AirPlacement::Gpu(Storage::F32),
        cloth: ClothPlacement::Device,
        ..Engine::Gpu.plan_placement()
    };
    let host = canopy(&Precision::F32.into(), Engine::CpuF32, &["bdf2"]);
    let device = canopy(&placement, Engine::Gpu, &["bdf2"]);
    assert!(
        (host[0] - device[0]).abs() < tolerances::ENERGY_REST,
        "{host:?} {device:?}"
    );
}

/// What a scene does not have, has no column.
fn columns() {
    let names = |source: &str| -> Vec<String> {
        let case = case::parse("rope", source, Path::new("."), &Choices::default()).unwrap();
        let plan = Plan::new(&case.scene, Precision::F64);
        let simulation = ripstop::simulation::Simulation::new(case.scene, plan, None).unwrap();
        let record = Record::new(&simulation);
        record
            .columns()
            .iter()
            .map(|c| c.name.to_string())
            .collect()
    };
    let all = names(ROPE);
    for name in [
        "elastic_energy_j",
        "potential_energy_j",
        "work_of_supports_j",
        "lost_to_damping_j",
        "numerical_loss_j",
    ] {
        assert!(all.iter().any(|n| n == name), "{name}");
    }
    assert!(
        !all.iter()
            .any(|n| n == "work_of_air_j" || n == "work_of_frame_j")
    );
    let weightless = ROPE.replace("[gravity]\nacceleration_m_s2 = [0.0, 0.0, -9.81]\n", "");
    assert!(!names(&weightless).iter().any(|n| n == "potential_energy_j"));
}
