//! What scenes need and engines can: refused by the plan, before anything is computed.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::plan::capabilities::{check, lacking_on_device};
use ripstop::plan::{ClothPlacement, Placement, Plan, Precision};
use ripstop::simulation::{Failure, Simulation};

use crate::command_line::{ripstop, root};
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("capabilities::shipped_cases", shipped),
        plain("capabilities::edges_under_pressure", edges),
        plain("capabilities::refused_before_the_first_step", refused),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn load(file: &Path, changes: &[&str]) -> Case {
    let source = std::fs::read_to_string(file).unwrap();
    let choices = Choices {
        variant: None,
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse("case", &source, file.parent().unwrap(), &choices).unwrap()
}

/// Fabric that only the host solves, among the shipped cases, and the reason.
const HOST_ALONE: [(&str, &str); 6] = [
    ("folded-gore", "[contact]"),
    ("parafoil-brake", "[contact]"),
    ("paraglider", "several fabrics"),
    ("ram-air-parachute", "a wing in the wind"),
    ("wing-27", "several fabrics"),
    ("wing-school", "several fabrics"),
];

fn shipped() {
    let mut refused = Vec::new();
    for (name, file) in crate::cases::files() {
        if let Some(lacking) = lacking_on_device(&load(&root().join(file), &[]).scene) {
            refused.push((name, lacking.to_string()));
        }
    }
    refused.sort();
    let names: Vec<&str> = refused.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, HOST_ALONE.map(|(name, _)| name));
    for ((_, why), (_, expected)) in refused.iter().zip(HOST_ALONE) {
        assert!(why.contains(expected), "{why}");
    }
}

/// Following pressure has a potential where fabric is closed or held, and none where a loaded edge moves.
fn edges() {
    let of = |name: &str, changes: &[&str]| {
        let file = root().join("cases/cloth").join(name);
        lacking_on_device(&load(&file, changes).scene).map(|lacking| lacking.to_string())
    };
    let pressure = "equilibrium.pressure_pa=10.0";
    assert_eq!(of("airbag.toml", &[]), None);
    assert_eq!(of("hencky-disc.toml", &[]), None);
    assert_eq!(of("hanging-sheet.toml", &[]), None);
    let sheet = of("hanging-sheet.toml", &[pressure]).unwrap();
    assert!(sheet.contains("an edge that moves, as at node"), "{sheet}");
}

/// By the program, and by the library without a device at hand.
fn refused() {
    let gore = "cases/cloth/folded-gore.toml";
    let checked = ripstop(&["check", gore, "--cloth", "device"]);
    assert_eq!(checked.code, 2);
    assert!(checked.errors.contains("[contact]"), "{}", checked.errors);
    let sheet = [
        "check",
        "cases/cloth/hanging-sheet.toml",
        "--cloth",
        "device",
    ];
    let loaded = ["--set", "equilibrium.pressure_pa=10.0"];
    let checked = ripstop(&[&sheet[..], &loaded[..]].concat());
    assert_eq!(checked.code, 2);
    assert!(
        checked.errors.contains("hold the edge"),
        "{}",
        checked.errors
    );

    let scene = load(&root().join(gore), &[]).scene;
    let placement = Placement {
        cloth: ClothPlacement::Device,
        ..Placement::from(Precision::F32)
    };
    assert!(check(&scene, &placement).is_err());
    let plan = Plan::new(&scene, placement);
    let begun = Simulation::new(scene, plan, None);
    assert!(matches!(begun, Err(Failure::Lacking(_))));
}
