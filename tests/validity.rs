//! What a case and a run say of their own validity: the table, the error to be expected, `--strict`, and results that are marked.

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::output::{ExpectedError, Quantity, ReadOut, Results, Supports, ValidityRow, mark};
use ripstop::plan::{Plan, Precision};
use ripstop::validity;

use crate::command_line::{CANOPY, finished, ripstop, root};
use crate::engines::plain;
use crate::folders::canopy;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        ("validity::errors_are_foretold", foretold as fn()),
        ("validity::check_says_what_will_be_wrong", check_says),
        ("validity::wings_on_coarse_cells", coarse_wing),
        ("validity::thin_boundary_layers", thin_layers),
        ("validity::strict_sphere", strict_sphere),
        ("validity::runs_beyond_their_limits", beyond),
        ("validity::results_and_their_support", support),
        (
            "validity::short_steps_in_sixteen_bits",
            short_steps_in_sixteen_bits,
        ),
        ("validity::vents_and_gaps", vents_and_gaps),
        ("validity::names_of_bodies", names_of_bodies),
        ("validity::strict_about_what_has_not_settled", strict_wake),
        ("validity::springs_have_no_strain", springs),
    ]
    .into_iter()
    .flat_map(|(name, test)| plain(name, test))
    .collect()
}

/// A sphere or a disk in a tunnel with a square section; lengths in diameters.
#[derive(Clone, Copy)]
pub struct Body {
    pub shape: &'static str,
    pub reynolds: f64,
    pub cells: f64,
    pub inlet: f64,
    /// From the middle to the sponge.
    pub sponge: f64,
    pub width: f64,
}

impl Body {
    pub fn text(&self) -> String {
        let Self {
            shape,
            reynolds,
            cells,
            inlet,
            sponge,
            width,
        } = *self;
        let whole = |length: f64| (length * cells).round() / cells;
        format!(
            "version = 1\ntitle = \"{shape}\"\n[air]\ndensity_kg_m3 = 1.0\nkinematic_viscosity_m2_s = {:e}\n\
             [air.wind_tunnel]\nspeed_m_s = 1.0\nsize_m = [{:?}, {:?}, {:?}]\nstart_time_s = 1.0\nsponge_length_m = {:?}\n\
             [resolution]\ncells_per_diameter = {cells:?}\nlattice_speed = 0.1\noperator = \"recursive_regularised\"\n\
             [bodies.{shape}]\nposition_m = [{inlet:?}, {:?}, {:?}]\n[bodies.{shape}.{shape}]\ndiameter_m = 1.0\n\
             [coupling]\nover_relaxation = 1.6\n[time]\nend_s = 30.0\n[output]\nsample_interval_s = 0.25\n",
            1.0 / reynolds,
            whole(inlet + sponge + 1.0),
            whole(width),
            whole(width),
            1.0,
            0.5 * whole(width),
            0.5 * whole(width),
        )
    }

    fn case(&self) -> Case {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), self.text()).unwrap();
        case::load(file.path(), &Choices::default()).unwrap()
    }
}

pub const SPHERE: Body = Body {
    shape: "sphere",
    reynolds: 100.0,
    cells: 16.0,
    inlet: 5.0,
    sponge: 4.0,
    width: 10.0,
};

fn expected(case: &Case) -> ExpectedError {
    let errors = validity::expected_errors(&case.scene);
    assert_eq!(errors.len(), 1, "{errors:?}");
    errors[0].clone()
}

/// Eight set-ups that no number of the forecast was taken from, with what they measured against published drag
/// (docs/results/2026-11-23-expected-error.md): the forecast is within a factor of two.
fn foretold() {
    let body = |shape, reynolds, cells, inlet, sponge, width| Body {
        shape,
        reynolds,
        cells,
        inlet,
        sponge,
        width,
    };
    for (set_up, measured) in [
        (body("sphere", 100.0, 10.0, 1.5, 4.0, 5.0), 0.203),
        (body("sphere", 100.0, 5.0, 4.0, 4.0, 6.0), 0.456),
        (body("sphere", 300.0, 8.0, 4.0, 5.0, 3.5), 0.082),
        (body("sphere", 100.0, 10.0, 4.0, 0.7, 5.0), 0.175),
        (body("disk", 100.0, 8.0, 1.0, 4.0, 5.0), 0.413),
        (body("disk", 100.0, 7.0, 3.0, 4.0, 3.5), 0.163),
        (body("sphere", 50.0, 7.0, 2.2, 1.2, 4.4), 0.303),
        (body("sphere", 30.0, 9.0, 1.0, 3.0, 6.0), 0.639),
    ] {
        let error = expected(&set_up.case());
        let factor = error.total / measured;
        assert!(
            (1.0 / tolerances::FORECAST..tolerances::FORECAST).contains(&factor),
            "{}: measured {measured}",
            error.line()
        );
        let sum: f64 = error.parts.iter().map(|(_, part)| part).sum();
        assert!((sum - error.total).abs() < 1e-12);
    }
    // At cut links nothing is fitted to the cells: on few of them they add more than markers do.
    for shape in ["sphere", "disk"] {
        let at = |coupling: &str| {
            let body = Body {
                shape,
                cells: 12.0,
                ..SPHERE
            };
            let text = body.text().replace("over_relaxation = 1.6", coupling);
            let case = case::parse("body", &text, root(), &Choices::default());
            let error = expected(&case.unwrap());
            error
                .parts
                .iter()
                .find(|(name, _)| name == "cells")
                .unwrap()
                .1
        };
        let [kernel, links] = ["", "scheme = \"links\""].map(at);
        assert!(links > 1.5 * kernel, "{shape}: {links} {kernel}");
    }
}

/// A body in the sponge, one right behind the inlet, one of three cells: `check` says that it will be wrong, by how much, and why.
fn check_says() {
    let folder = tempfile::tempdir().unwrap();
    for (name, body, row, part, measured) in [
        // Measured: 2.26 and 2.36 for 1.21 without, 2.08 for 1.20.
        (
            "sponge",
            Body {
                sponge: 0.0,
                ..SPHERE
            },
            "distance to the sponge or outlet",
            "sponge",
            0.87,
        ),
        (
            "inlet",
            Body {
                inlet: 0.8,
                ..SPHERE
            },
            "distance to the inlet",
            "inlet",
            0.96,
        ),
        (
            "cells",
            Body {
                cells: 3.0,
                ..SPHERE
            },
            "cells across the body",
            "cells",
            0.74,
        ),
    ] {
        let path = folder.path().join(format!("{name}.toml"));
        std::fs::write(&path, body.text()).unwrap();
        let path = path.to_str().unwrap();
        let finished = ripstop(&["check", path]);
        assert_eq!(finished.code, 0, "{}", finished.errors);
        let lines = finished.printed.lines();
        let no: Vec<&str> = lines
            .filter(|line| line.trim().starts_with("NO "))
            .collect();
        assert!(no.iter().any(|line| line.contains(row)), "{name}: {no:?}");
        assert!(
            finished.printed.contains("mean drag about "),
            "{}",
            finished.printed
        );
        let error = expected(&body.case());
        let found = error.parts.iter().find(|(name, _)| name == part).unwrap().1;
        assert!((found / measured - 1.0).abs() < 0.1, "{name}: {found}");
        let strict = ripstop(&["check", path, "--strict"]);
        assert_eq!(strict.code, 1);
        assert!(strict.errors.contains(row), "{}", strict.errors);
    }
}

/// Boundary layers of a canopy are thinner than its cells, which matters where the air sticks to it and nowhere else.
fn thin_layers() {
    let check = |changes: &[&str]| {
        let mut all = vec!["check", "cases/flat-circular-tunnel.toml"];
        all.extend(changes.iter().flat_map(|change| ["--set", change]));
        let finished = ripstop(&all);
        assert_eq!(finished.code, 0, "{changes:?}: {}", finished.errors);
        finished.printed
    };
    // 0.37 (2·10⁶)^(−1/5) D_0 on 24 cells.
    let row = "cells across the boundary layer";
    let printed = check(&[]);
    assert!(
        printed.contains(&format!("NO  {row}              0.491 ")),
        "{printed}"
    );
    for changes in [
        &["fabric.friction=model"][..],
        &["fabric.friction=none"],
        &["coupling.scheme=kernel"],
    ] {
        let printed = check(changes);
        assert!(!printed.contains(row), "{changes:?}: {printed}");
    }
    // Re = 193: 5 Re^(−1/2) D_0.
    let printed = check(&[
        "air.kinematic_viscosity_m2_s=0.155",
        "resolution.cells_per_diameter=48.0",
    ]);
    assert!(
        printed.contains(&format!("ok  {row}              17.3 ")),
        "{printed}"
    );
}

/// A ram-air wing with 16 cells per chord lacks most of its lift, unless it cuts links.
fn coarse_wing() {
    let check = |scheme: &str, cells: u32| {
        ripstop(&[
            "check",
            "cases/ram-air-parachute.toml",
            "--set",
            &format!("resolution.cells_per_chord={cells}"),
            "--set",
            &format!("coupling.scheme={scheme}"),
        ])
    };
    // With 48 cells lift is 12 % too low to 22 % too high (docs/results/2026-11-26-sliding-in-creases.md).
    for cells in [16, 48] {
        let links = check("links", cells);
        assert_eq!(links.code, 0, "{}", links.errors);
        assert!(
            !links.printed.contains("lift over the angle"),
            "{}",
            links.printed
        );
        let row = "NO  cells across the chord for lift, cut links";
        assert!(links.printed.contains(row), "{cells}: {}", links.printed);
    }
    let finished = check("kernel", 16);
    assert_eq!(finished.code, 0, "{}", finished.errors);
    for text in [
        "NO  trailing edge within the kernel              0.250",
        "NO  cells across the thickness",
        "lift over the angle about 68.0 % too low",
    ] {
        assert!(
            finished.printed.contains(text),
            "{text}: {}",
            finished.printed
        );
    }
}

/// The shipped sphere keeps to all limits.
fn strict_sphere() {
    let finished = ripstop(&["check", "cases/sphere.toml", "--strict"]);
    assert_eq!(finished.code, 0, "{}", finished.errors);
    assert!(
        finished.printed.contains("mean drag about 0.8 % too high"),
        "{}",
        finished.printed
    );
}

/// Runs whose numbers mean nothing ended with exit code 0 and without a word.
fn beyond() {
    let canopy = [CANOPY, "--variant", "quick"];
    let sheet = ["cases/cloth/hanging-sheet.toml", "--variant", "quick"];
    for (case, changes, finding) in [
        (
            canopy,
            &[
                "air.wind_tunnel.speed_m_s=1000.0",
                "air.wind_tunnel.start_time_s=0.0006",
                "time.end_s=0.0006",
                "output.sample_interval_s=0.0001",
            ][..],
            "physical Mach number 2.94",
        ),
        (
            canopy,
            &[
                "fabric.youngs_modulus_pa=1e-10",
                "time.end_s=0.006",
                "output.sample_interval_s=0.001",
            ][..],
            "largest strain of the fabric",
        ),
        (
            canopy,
            &[
                "lines.breaking_load_n=0.1",
                "time.end_s=0.006",
                "output.sample_interval_s=0.001",
            ][..],
            "line tension over breaking load",
        ),
        (
            canopy,
            &[
                "belts.breaking_load_n=0.01",
                "time.end_s=0.006",
                "output.sample_interval_s=0.001",
            ][..],
            "tape tension over breaking load",
        ),
        (
            canopy,
            &[
                "lines.area_m2=1e-10",
                "time.end_s=0.03",
                "output.sample_interval_s=0.001",
            ][..],
            "largest strain of a suspension line",
        ),
        (
            sheet,
            &[
                "gravity.acceleration_m_s2=[0.0, 0.0, -1e9]",
                "time=absent",
                "equilibrium.tolerance=0.1",
                "output.sample_interval_s=absent",
            ][..],
            "largest strain of the fabric",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut arguments = vec!["run"];
        arguments.extend(case);
        for change in changes {
            arguments.extend(["--set", change]);
        }
        arguments.extend([
            "--set",
            "output.picture_times_s=absent",
            "--strict",
            "--all",
        ]);
        arguments.extend(["--engine", "cpu", "--out", folder.path().to_str().unwrap()]);
        let finished = ripstop(&arguments);
        assert_eq!(finished.code, 1, "{finding}: {}", finished.errors);
        assert!(finished.errors.contains(finding), "{}", finished.errors);
        // The reader of the table sees it, too, and so does who reads the file.
        assert!(
            finished.printed.contains("unresolved: "),
            "{}",
            finished.printed
        );
        let summary = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        let rows: Vec<ValidityRow> = serde_json::from_value(summary["validity"].clone()).unwrap();
        assert!(rows.iter().any(|row| row.valid == Some(false)));
        let results = summary["results"].as_object().unwrap();
        let marked = results
            .values()
            .filter(|result| result["unresolved"].is_string());
        assert!(marked.count() > results.len() / 2, "{results:?}");
    }
    // A run that is over in one step.
    let rows = beforehand(
        CANOPY,
        &["air.wind_tunnel.speed_m_s=1e-6", "time.end_s=0.03"],
    );
    let steps = rows
        .iter()
        .find(|row| row.name == "steps of the run")
        .unwrap();
    assert_eq!((steps.value, steps.valid), (Some(1.0), Some(false)));
}

/// What is said of a quick variant before its first step.
fn beforehand(file: &str, overrides: &[&str]) -> Vec<ValidityRow> {
    beforehand_in(Precision::F32, file, overrides)
}

fn beforehand_in(precision: Precision, file: &str, overrides: &[&str]) -> Vec<ValidityRow> {
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: overrides.iter().map(|&change| change.to_owned()).collect(),
    };
    let case = case::load(&root().join(file), &choices).unwrap();
    let plan = Plan::new(&case.scene, precision);
    validity::beforehand(&case.scene, &plan)
}

/// Populations in 16 bits lose what changes slowly: short steps are told of with them alone.
fn short_steps_in_sixteen_bits() {
    let of = |precision, lattice_speed: &str| {
        let speed = format!("resolution.lattice_speed={lattice_speed}");
        let rows = beforehand_in(precision, "cases/sphere.toml", &[&speed]);
        let mut rows = rows.into_iter();
        rows.find(|row| row.name.ends_with("16 bits"))
            .map(|row| (row.value.unwrap().round(), row.valid))
    };
    assert_eq!(of(Precision::F16Storage, "0.08"), Some((100.0, Some(true))));
    assert_eq!(
        of(Precision::F16Storage, "0.005"),
        Some((1600.0, Some(false)))
    );
    assert_eq!(of(Precision::F32, "0.005"), None);
}

/// A vent and a gap are judged each by its own rule, whichever is narrower.
fn vents_and_gaps() {
    let rows = beforehand("cases/disk-gap-band.toml", &[]);
    for kind in ["hole", "gap or slot"] {
        let of_kind = rows.iter().filter(|row| {
            row.name
                .starts_with(&format!("cells across the narrowest {kind}"))
        });
        assert_eq!(of_kind.count(), 1, "{kind}");
    }
}

/// The name of a body tells nothing of what its results need.
fn names_of_bodies() {
    let mut rows = beforehand("cases/sphere.toml", &[]);
    let mut row = rows.swap_remove(0);
    row.prefix = "lift_max_".to_owned();
    row.valid = Some(false);
    let marked = |supports, name: &'static str| {
        let row = ValidityRow {
            supports,
            ..row.clone()
        };
        let mut results = Results::default();
        results.insert(&ReadOut::new(name, "1", ""), Quantity::new(1.0));
        mark(&mut results, &[row]);
        results.get(name).unwrap().unresolved.is_some()
    };
    for supports in [Supports::Lift, Supports::Opening] {
        assert!(!marked(supports, "lift_max_drag_coefficient"));
    }
    assert!(marked(Supports::Lift, "lift_max_lift_coefficient"));
    assert!(marked(Supports::Means, "lift_max_drag_coefficient"));
}

/// Which results a row supports.
fn support() {
    for (supports, name, covered) in [
        (Supports::Everything, "drag_coefficient", true),
        (Supports::Everything, "mass_drift", false),
        (Supports::Everything, "kite_force_imbalance", false),
        (Supports::Means, "drag_coefficient", true),
        (Supports::Means, "von_mises_max_steady_pa", true),
        (Supports::Means, "line_tension_max_n", false),
        (Supports::Opening, "opening_force_factor", true),
        (Supports::Opening, "fill_time_s", true),
        (Supports::Opening, "projected_diameter_ratio", false),
        (Supports::Lift, "lift_coefficient", true),
        (Supports::Lift, "moment_y_n_m", true),
        (Supports::Lift, "drag_coefficient", false),
        (Supports::Lift, "drag_momentum_box_n", false),
    ] {
        assert_eq!(supports.covers(name), covered, "{supports:?} {name}");
    }
}

/// Where nothing in the set-up speaks against a mean, its wake may still not have settled.
fn strict_wake() {
    let folder = tempfile::tempdir().unwrap();
    let output = finished(
        canopy(
            &folder.path().join("out"),
            &["--set", "time.end_s=0.02", "--strict"],
        )
        .output()
        .unwrap(),
    );
    assert_eq!(output.code, 1, "{}", output.errors);
    let reason = "\n  the wake has not settled";
    assert_eq!(
        output.errors.matches(reason).count(),
        1,
        "{}",
        output.errors
    );
}

/// A network of springs has no strain and no stress of fabric: its results are not marked for want of them.
fn springs() {
    let out = tempfile::tempdir().unwrap();
    let run = ripstop(&[
        "run",
        "cases/cloth/hanging-sheet.toml",
        "--variant",
        "quick",
        "--set",
        "structure.sheet.model=\"network\"",
        "--set",
        "time.end_s=0.05",
        "--out",
        out.path().to_str().unwrap(),
    ]);
    assert_eq!(run.code, 0, "{}", run.errors);
    assert!(!run.printed.contains("unresolved"), "{}", run.printed);
}
