//! The program as a user meets it: commands, exit codes, faults of the outside world.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices, SHIPPED};
use ripstop::plan::{Plan, Precision, Stage};

use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("command_line::new_prints_shipped_cases", new_prints),
        plain(
            "command_line::check_lists_what_a_scene_has_and_skips",
            check_three_scenes,
        ),
        plain("command_line::usage_errors", usage_errors),
        plain("command_line::no_gpu_engine", no_gpu),
        plain("command_line::divergence", divergence),
        plain(
            "command_line::equilibrium_not_reached",
            equilibrium_not_reached,
        ),
        plain("command_line::steady_state_stops_a_run", steady_state),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    // A shell that can close streams.
    if cfg!(unix) {
        trials.extend(plain(
            "command_line::closed_and_full_standard_output",
            standard_output,
        ));
    }
    trials
}

/// Root of the repository, as cargo names it when the tests run: a machine without the sources gets `cases/` alone and names their
/// folder itself (`benches/accelerator.sh`).
pub fn root() -> &'static Path {
    static ROOT: LazyLock<PathBuf> = LazyLock::new(|| {
        std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from)
    });
    &ROOT
}

/// The program under test: `RIPSTOP_PROGRAM` where the tests run on another machine than that which built them, else cargo's.
pub fn program() -> &'static Path {
    static PROGRAM: LazyLock<PathBuf> = LazyLock::new(|| {
        std::env::var_os("RIPSTOP_PROGRAM")
            .map_or_else(|| env!("CARGO_BIN_EXE_ripstop").into(), PathBuf::from)
    });
    &PROGRAM
}

/// What a finished process left.
pub struct Finished {
    pub code: i32,
    pub printed: String,
    pub errors: String,
}

pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command
        .args(arguments)
        .current_dir(root())
        .env("NO_COLOR", "1")
        .stdin(Stdio::null());
    command
}

/// Runs the program in the repository's root.
pub fn ripstop(arguments: &[&str]) -> Finished {
    finished(command(arguments).output().unwrap())
}

pub fn finished(output: std::process::Output) -> Finished {
    // Validation layers, where they are on, write what they have against the program to its output.
    for stream in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(stream);
        assert!(!text.contains("Validation Error"), "{text}");
    }
    Finished {
        code: output.status.code().unwrap_or(-1),
        printed: String::from_utf8(output.stdout).unwrap(),
        errors: String::from_utf8(output.stderr).unwrap(),
    }
}

pub const CANOPY: &str = "cases/flat-circular-tunnel.toml";

fn new_prints() {
    let files = crate::cases::files();
    for (name, text) in SHIPPED {
        let output = ripstop(&["new", name]);
        assert_eq!(output.code, 0);
        // But for the line that tells where its schema is in the repository.
        assert_eq!(output.printed, text.split_once('\n').unwrap().1);
        assert_eq!(
            text,
            std::fs::read_to_string(root().join(&files[name])).unwrap()
        );
    }
    // The list has their first sentences, whose numbers hold points.
    let list = ripstop(&["new"]).printed;
    assert!(list.contains("pulled together to 0.8 m\n"), "{list}");
    // With a folder, the case and all that it names, ready to be checked; nothing that is there is lost.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("mine");
    let arguments = ["new", "hemispherical-mesh", "--out", out.to_str().unwrap()];
    assert_eq!(ripstop(&arguments).code, 0);
    let case = out.join("hemispherical-mesh.toml");
    assert_eq!(ripstop(&["check", case.to_str().unwrap()]).code, 0);
    let again = ripstop(&arguments);
    assert_eq!(again.code, 2);
    assert!(
        again.errors.contains("is there already"),
        "{}",
        again.errors
    );
    // No shipped case names a file that is not written with it.
    let every = folder.path().join("every");
    for (name, _) in SHIPPED {
        let arguments = ["new", name, "--out", every.to_str().unwrap()];
        assert_eq!(ripstop(&arguments).code, 0);
        let case = every.join(format!("{name}.toml"));
        let output = ripstop(&["check", case.to_str().unwrap()]);
        assert_eq!(output.code, 0, "{name}: {}", output.errors);
    }
    let output = ripstop(&["new", "zeppelin"]);
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("flat-circular-tunnel"),
        "{}",
        output.errors
    );
}

fn check_three_scenes() {
    let plan = |file: &str| {
        let case = case::load(&root().join(file), &Choices::default()).unwrap();
        Plan::new(&case.scene, Precision::F32)
    };
    let has = |plan: &Plan, stage: Stage| plan.stages.iter().any(|p| p.stage == stage);

    let canopy = plan(CANOPY);
    let order: Vec<Stage> = canopy.stages.iter().map(|p| p.stage).collect();
    assert_eq!(
        order,
        [
            Stage::CollideStream,
            Stage::CoarserLevels,
            Stage::FindLinks,
            Stage::ReadLinks,
            Stage::SolveCloth,
            Stage::Bounce,
            Stage::Measure,
            Stage::Output
        ]
    );
    let text = ripstop(&["check", CANOPY]).printed;
    for needed in [
        "collide_stream",
        "memory",
        "steps",
        "Mach",
        "tau",
        "mass ratio",
        "cells across mouth",
        "duration",
        "blockage",
        "length of the run",
    ] {
        assert!(text.contains(needed), "{needed} is missing in\n{text}");
    }

    assert!(!text.contains("warnings"), "{text}");
    let narrow = "air.wind_tunnel.size_m=[4.985, 2.0, 2.0]";
    let confluence = "structure.flat_circular.confluence_m=[0.6, 1.0, 1.0]";
    let text = ripstop(&["check", CANOPY, "--set", narrow, "--set", confluence]).printed;
    assert!(text.contains("blocks 20 % of the section"), "{text}");
    // Millimetres and mm2 for what the keys name.
    for slip in ["fabric.thickness_m=0.08", "lines.area_m2=4.42"] {
        let text = ripstop(&["check", CANOPY, "--set", slip]).printed;
        assert!(text.contains("kg per m2 of fabric"), "{slip}: {text}");
    }
    let alike = "air.refinement={around=\"nothing\"}";
    let with = |precision, changes: &[&str]| {
        let choices = Choices {
            overrides: changes.iter().map(|&change| change.to_owned()).collect(),
            ..Choices::default()
        };
        let case = case::load(&root().join(CANOPY), &choices).unwrap();
        Plan::new(&case.scene, precision)
    };
    let gradients = [
        alike,
        "resolution.eddy_viscosity.model=wale",
        "resolution.eddy_viscosity.constant=0.5",
    ];
    let canopy = with(Precision::F32, &[alike]);
    let with_gradients = with(Precision::F32, &gradients);
    let first = with_gradients.stages[0];
    assert_eq!((first.stage, first.every), (Stage::EddyViscosity, 4));
    assert_eq!(
        with_gradients.sizes.air_bytes - canopy.sizes.air_bytes,
        4 * canopy.sizes.cells
    );
    assert_eq!(with_gradients.stages.len(), canopy.stages.len() + 1);
    // Only populations are kept in 16 bits.
    let halved = with(Precision::F16Storage, &[alike]);
    let share = halved.sizes.air_bytes as f64 / canopy.sizes.air_bytes as f64;
    assert!((0.5..0.6).contains(&share), "{share}");
    assert_eq!(
        with(Precision::F16Storage, &gradients).sizes.air_bytes - halved.sizes.air_bytes,
        4 * canopy.sizes.cells
    );

    let air = plan("cases/taylor-green.toml");
    assert!(
        has(&air, Stage::CollideStream)
            && !has(&air, Stage::Interpolate)
            && !has(&air, Stage::SolveCloth)
    );
    assert_eq!(
        (
            air.sizes.markers,
            air.sizes.marker_bytes,
            air.sizes.structure_bytes
        ),
        (0, 0, 0)
    );
    let text = ripstop(&["check", "cases/taylor-green.toml"]).printed;
    assert!(
        text.contains("the case has no [structure]") && !text.contains("mass ratio"),
        "{text}"
    );

    let cloth = plan("cases/cloth/hanging-sheet.toml");
    assert!(
        has(&cloth, Stage::SolveCloth)
            && !has(&cloth, Stage::CollideStream)
            && !has(&cloth, Stage::Spread)
    );
    assert_eq!(
        (
            cloth.sizes.cells,
            cloth.sizes.air_bytes,
            cloth.sizes.marker_bytes
        ),
        (0, 0, 0)
    );
    let text = ripstop(&["check", "cases/cloth/hanging-sheet.toml"]).printed;
    assert!(
        text.contains("the case has no [air]") && !text.contains("Mach"),
        "{text}"
    );
}

fn usage_errors() {
    assert_eq!(ripstop(&["fly"]).code, 2);
    assert_eq!(ripstop(&["--help"]).code, 0);
    let output = ripstop(&["check", "cases/absent.toml"]);
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("cases/absent.toml"),
        "{}",
        output.errors
    );
    let output = ripstop(&["check", CANOPY, "--variant", "huge"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("quick"), "{}", output.errors);
    let output = ripstop(&["check", CANOPY, "--set", "lines.count=0"]);
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("--set lines.count=0"),
        "{}",
        output.errors
    );
    assert_eq!(ripstop(&["check", CANOPY, "--threads", "100000"]).code, 2);
    let output = ripstop(&[
        "check",
        CANOPY,
        "--set",
        "structure.flat_circular.confluence_m=[nan, 1.5, 1.5]",
    ]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("confluence_m"), "{}", output.errors);
    let output = ripstop(&["check", CANOPY, "--set", "time.end_s=1e12"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("steps"), "{}", output.errors);
    let output = ripstop(&["check", CANOPY, "--set", "lines.count"]);
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("key.path=value"),
        "{}",
        output.errors
    );
}

fn no_gpu() {
    // A driver list that names no driver: a machine without any adapter.
    let without_adapter = |arguments: &[&str]| {
        finished(
            command(arguments)
                .env("VK_DRIVER_FILES", "/nonexistent.json")
                .env("VK_ICD_FILENAMES", "/nonexistent.json")
                .output()
                .unwrap(),
        )
    };
    let output = without_adapter(&["check", CANOPY, "--engine", "gpu"]);
    assert_eq!(output.code, 3);
    assert!(output.errors.contains("no adapter"), "{}", output.errors);
    let output = without_adapter(&[
        "check",
        CANOPY,
        "--set",
        "coupling.scheme=kernel",
        "--cloth",
        "device",
    ]);
    assert_eq!(output.code, 3);
    assert!(output.errors.contains("no adapter"), "{}", output.errors);
    let output = ripstop(&["check", CANOPY, "--engine", "cpu", "--adapter", "some"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("--adapter"), "{}", output.errors);
    let output = without_adapter(&["check", CANOPY]);
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(output.printed.contains("CPU"), "{}", output.printed);
    let output = without_adapter(&["devices", "--measure"]);
    assert_eq!(output.code, 0);
    let measured = |line: &str| {
        Some(
            line.split_once("measured ")?
                .1
                .split(' ')
                .next()?
                .to_owned(),
        )
    };
    let pace = output.printed.lines().find_map(measured).unwrap();
    assert!(pace.parse::<f64>().unwrap() > 0.0, "{}", output.printed);
    assert!(
        output.printed.contains("no adapter found"),
        "{}",
        output.printed
    );
    let output = ripstop(&["check", CANOPY, "--adapter", "zeppelin"]);
    assert_eq!(output.code, 3);
    assert!(
        output.errors.contains("zeppelin") && output.errors.contains("ripstop devices"),
        "{}",
        output.errors
    );
    let output = ripstop(&["check", CANOPY, "--engine", "gpu", "--precision", "f64"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("f32"), "{}", output.errors);
}

/// All files of a folder and of those in it.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                files(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

/// Name of a file in a folder or in one below it.
pub fn name_in(folder: &Path, path: &Path) -> String {
    let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
    name.replace('\\', "/")
}

/// Air that a plate drives faster than the method represents breaks down: the run must say where, and keep files.
fn divergence() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    // Behind the canopy, at up to 2.8 times the speed of the wind.
    let plate = "bodies.plate={ position_m = [3.0, 1.5, 1.5], plate.size_m = [1.2, 1.2], motion.oscillation = { frequency_hz = 50.0, \
                 displacement_m = [0.27, 0.0, 0.0] } }";
    let scene = [CANOPY, "--variant", "quick", "--set", plate];
    let output = ripstop(&[&["run"], &scene[..], &["--out", out.to_str().unwrap()]].concat());
    assert_eq!(output.code, 20, "{}{}", output.printed, output.errors);
    assert!(
        output.errors.contains("diverged at t ="),
        "{}",
        output.errors
    );
    // With the cell where it began: the first cell of all is only the first to which it has spread.
    let place = output.errors.contains("the air at cell [");
    assert!(place, "{}", output.errors);
    assert!(!output.errors.contains("[0, 0, 0]"), "{}", output.errors);
    assert!(out.join("canopy_last_good.vtp").exists());
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("diverged at t ="), "{summary}");
}

/// A static solve cut short must not look like a result.
fn equilibrium_not_reached() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = ripstop(&[
        "run",
        "cases/cloth/hanging-chain.toml",
        "--set",
        "equilibrium.evaluation_limit=10",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 20, "{}", output.errors);
    assert!(output.errors.contains("not reached"), "{}", output.errors);
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("out of balance"), "{summary}");
}

/// A reader that goes away is no failure, a full disk behind the redirection is; neither is a panic.
fn standard_output() {
    let shell = |script: &str| {
        let script = script.replace("RIPSTOP", &format!("'{}'", program().display()));
        finished(
            Command::new("sh")
                .args(["-c", &script])
                .current_dir(root())
                .output()
                .unwrap(),
        )
    };
    if Path::new("/dev/full").exists() {
        for arguments in ["new taylor-green", "check cases/taylor-green.toml"] {
            let output = shell(&format!("RIPSTOP {arguments} > /dev/full"));
            assert_eq!(output.code, 74, "{}", output.errors);
        }
    }
    let output = shell("{ sleep 0.3; RIPSTOP new taylor-green; echo code $? >&2; } | true");
    assert!(output.errors.contains("code 0"), "{}", output.errors);
}

/// A coarse canopy in a small tunnel.
fn steady_canopy(out: &Path) -> Vec<&str> {
    vec![
        "run",
        CANOPY,
        "--set",
        "resolution.cells_per_diameter=12.0",
        "--set",
        "air.wind_tunnel.size_m=[2.9915, 1.994, 1.994]",
        "--set",
        "air.wind_tunnel.sponge_length_m=0.4",
        "--set",
        "structure.flat_circular.confluence_m=[0.4, 0.997, 0.997]",
        "--set",
        "structure.flat_circular.rings=8",
        "--set",
        "steady.drag_confidence=0.4",
        "--set",
        "time.end_s=2.0",
        "--out",
        out.to_str().unwrap(),
    ]
}

/// A coarse canopy in a small tunnel, asked for no more than 40 % of confidence, must stop by itself and say when and why.
fn steady_state() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = ripstop(&steady_canopy(&out));
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(
        output
            .printed
            .contains("stopped: steady: the mean drag coefficient"),
        "{}",
        output.printed
    );
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let when = summary["stop"]["when_s"].as_f64().unwrap();
    // Not before the wake has settled (18 D_0/U, 0.6 s, after the first peak) and 6 D_0/U of averaging, and well before the end.
    assert!((0.8..1.5).contains(&when), "{when}");
    // Made longer it goes on although it is steady; the sample that it stopped after is not there twice.
    let mut longer = steady_canopy(&out);
    longer.extend(["--extend", "0.01"]);
    let output = ripstop(&longer);
    assert_eq!(output.code, 0, "{}", output.errors);
    let history = std::fs::read_to_string(out.join("history.csv")).unwrap();
    let times: Vec<f64> = history
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    let last = times[times.len() - 1];
    assert!(last > when && last < when + 0.011, "{last} after {when}");
    // The mean drag and the impulse of the markers are of the same interval.
    let result = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    assert!((result("drag_n") / result("drag_markers_n") - 1.0).abs() < 1e-9);
    let drag = &summary["results"]["drag_coefficient"];
    assert!(drag["confidence"].as_f64().unwrap() <= 0.4 * drag["value"].as_f64().unwrap());
}
