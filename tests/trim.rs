//! Trim of wings: what the air sees, the balance of all loads, the speed bar, and runs that do not settle.

use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::aero::surface::PanelSurface;
use ripstop::case::{self, Choices};
use ripstop::geometry::wing::carried_over::{Meshed, carried_over};
use ripstop::trim::balance::stream;
use ripstop::trim::skin::Skin;
use ripstop::trim::{Glider, SectionSettings, Settings};

use crate::command_line::{ripstop, root};
use crate::engines::plain;
use crate::tolerances::trim as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain("trim::all_loads_are_in_balance", balance),
        plain("trim::the_air_sees_the_wing", skin),
        plain("trim::closed_tips_have_no_drag_of_intakes", closed_tips),
        plain("trim::the_speed_bar_makes_faster", speed_bar),
        plain("trim::displacements_come_over_from_coarser_meshes", coarser),
        plain("trim::what_moves_is_told", unsettled),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CASE: &str = "cases/wing-school.toml";

fn school(overrides: &[&str]) -> case::Case {
    let text = std::fs::read_to_string(root().join(CASE)).unwrap();
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: overrides.iter().map(|s| (*s).to_owned()).collect(),
    };
    case::parse("school", &text, root(), &choices).unwrap()
}

/// A shift of the whole wing comes over from a coarser mesh as it is; a smooth bend as nearly as the coarse triangles follow the fabric; lines move alike.
fn coarser() {
    let case = school(&[
        "structure.wing.mesh.along_chord=24",
        "structure.wing.mesh.across_cell=4",
    ]);
    let (wing, body) = (
        case.scene.wing().unwrap(),
        case.scene.body.as_ref().unwrap(),
    );
    let coarser = wing.coarser.as_ref().unwrap();
    assert!(coarser.structure.node_count() < body.structure.node_count() / 2);
    assert!(coarser.wing.coarser.is_none());
    let from = Meshed {
        wing: &coarser.wing.built,
        structure: &coarser.structure,
    };
    let to = Meshed {
        wing: &wing.built,
        structure: &body.structure,
    };
    let shift = DVec3::new(0.3, -0.1, 0.2);
    // Twist along the span, and the middle lifted: at most some 0.3 m.
    let bend = |x: DVec3| DVec3::new(0.02 * x.z, 0.0, 0.01 * x.y * x.y + 0.03 * x.x);
    let fields: [(&dyn Fn(DVec3) -> DVec3, f64); 2] =
        [(&|_| shift, 1e-12), (&bend, tolerance::CARRIED_OVER_M)];
    for (field, allowed_m) in fields {
        let moved = |x: &DVec3| *x + field(*x);
        let coarse: Vec<DVec3> = coarser.structure.positions_m.iter().map(moved).collect();
        let fine = carried_over(from, &coarse, to).unwrap();
        for (found, rest) in fine.iter().zip(&body.structure.positions_m) {
            let error = found.distance(moved(rest));
            assert!(error < allowed_m, "{rest}: {error}");
        }
    }
}

/// Pressure, traction, drag of lines, weights and the pilot's drag on an arched wing with lines and intakes sum up to nothing, in force and in moment about
/// the hang points, once the wing is turned to its balance.
fn balance() {
    let case = school(&[]);
    let scene = &case.scene;
    let (wing, body) = (scene.wing().unwrap(), scene.body.as_ref().unwrap());
    let settings = wing.trim.as_ref().unwrap();
    let structure = &body.structure;
    let glider = Glider::new(
        &wing.built,
        structure,
        &wing.line_diameters_m,
        settings,
        9.81,
    )
    .unwrap();
    let designed = &structure.positions_m;
    let flight = glider
        .glide(designed, &glider.panel_nodes_m(designed), None)
        .unwrap();
    let positions = glider.turned_m(designed, flight.balance.turn_rad);
    let hang = designed[wing.built.hang_points[0] as usize].with_y(0.0);
    let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
    let mut add = |at: DVec3, pull: DVec3| {
        force += pull;
        moment += (at - hang).cross(pull);
    };
    let loads = &flight.loads;
    for (index, triangle) in structure.triangles.iter().enumerate() {
        let corners = triangle.nodes.map(|n| positions[n as usize]);
        let jump = loads.jumps_pa[index];
        let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        add((corners[0] + corners[1] + corners[2]) / 3.0, area * jump);
    }
    for ((at, load), mass) in positions
        .iter()
        .zip(&loads.nodal_n)
        .zip(&structure.masses_kg)
    {
        add(*at, *load - DVec3::Z * (9.81 * mass));
    }
    let pilot = stream(flight.balance.glide_rad) * flight.pilot_drag_n;
    add(hang, pilot - DVec3::Z * (9.81 * settings.pilot_mass_kg));
    let weight = flight.weight_n;
    assert!(
        force.length() < tolerance::BALANCE * weight,
        "{force} of {weight} N"
    );
    // Lines are as long as seven metres; the search ends at 1e-7 rad.
    assert!(
        moment.length() < tolerance::MOMENT * weight * hang.z.abs(),
        "{moment} N m"
    );
    // The parts of the drag are all there is along the stream.
    let parts =
        flight.induced_drag_n + flight.section_drag_n + flight.line_drag_n + flight.pilot_drag_n;
    assert!((parts / (weight * flight.balance.glide_rad.sin()) - 1.0).abs() < 1e-9);
    // No more than stagnation pressure gets in; panels this coarse average it over the nose.
    assert!((0.6..=1.0).contains(&flight.inside), "{}", flight.inside);
}

/// Without ballooning the panels enclose what the ribs' sections enclose; mirrored halves are one.
fn skin() {
    let case = school(&["structure.wing.ballooning=absent"]);
    let (wing, body) = (
        case.scene.wing().unwrap(),
        case.scene.body.as_ref().unwrap(),
    );
    let settings = wing.trim.as_ref().unwrap();
    let glider = Glider::new(
        &wing.built,
        &body.structure,
        &wing.line_diameters_m,
        settings,
        9.81,
    )
    .unwrap();
    let nodes = glider.panel_nodes_m(&body.structure.positions_m);
    let around = 2 * settings.panels_per_side;
    let surface = PanelSurface::new(nodes, around, true, true).unwrap();
    assert_eq!(surface.panels.len(), glider.skin.panel_count());
    let ratio = surface.volume_m3() / wing.built.measures.section_volume_m3;
    assert!((ratio - 1.0).abs() < tolerance::VOLUME, "{ratio}");
}

/// Intakes give drag to the strips whose cells have one: those of the three closed cells at each tip have as little as in a wing without. Strips of several
/// cells are open by the share of their area.
fn closed_tips() {
    let case = school(&[]);
    let (wing, body) = (
        case.scene.wing().unwrap(),
        case.scene.body.as_ref().unwrap(),
    );
    let fly = |settings: &Settings| {
        let diameters = &wing.line_diameters_m;
        let glider = Glider::new(&wing.built, &body.structure, diameters, settings, 9.81).unwrap();
        let designed = &body.structure.positions_m;
        glider
            .glide(designed, &glider.panel_nodes_m(designed), None)
            .unwrap()
    };
    let settings = wing.trim.as_ref().unwrap();
    let mut without = settings.clone();
    let sections = &settings.sections;
    without.sections = SectionSettings::new(sections.polars.clone(), sections.reynolds);
    without.sections.surface_drag = sections.surface_drag;
    let (with, without) = (fly(settings), fly(&without));
    let closed_from = 1.0 - 2.0 * 3.0 / wing.built.cells as f64;
    let (mut open, mut closed) = (0, 0);
    for (a, b) in with.strips.iter().zip(&without.strips) {
        let more = a.drag - b.drag;
        if a.place > closed_from {
            closed += 1;
            assert!(more.abs() < tolerance::CLOSED_TIP, "{}: {more}", a.place);
        } else {
            open += 1;
            assert!(more > tolerance::INTAKE, "{}: {more}", a.place);
        }
    }
    assert_eq!((open, closed), (13, 3));
    // Four strips of four cells each: the outermost has one open cell.
    let skin = Skin::new(&wing.built, 4, 4);
    let shares = skin.open_shares(&wing.built);
    assert!(shares[..3].iter().all(|share| *share == 1.0), "{shares:?}");
    let outermost: Vec<usize> = (0..wing.built.cells)
        .filter(|cell| skin.strip_of(*cell) == 3)
        .collect();
    let area = |cell: &usize| wing.built.flat_cell_area_m2(*cell);
    let is_open = |cell: &&usize| (3..wing.built.cells - 3).contains(*cell);
    let opened: f64 = outermost.iter().filter(is_open).map(area).sum();
    let expected = opened / outermost.iter().map(area).sum::<f64>();
    assert!(
        (shares[3] - expected).abs() < 1e-12,
        "{shares:?} {expected}"
    );
}

fn run(out: &std::path::Path, more: &[&str]) -> (crate::command_line::Finished, serde_json::Value) {
    let mut arguments = vec![
        "run",
        CASE,
        "--variant",
        "quick",
        "--out",
        out.to_str().unwrap(),
    ];
    arguments.extend(more);
    let output = ripstop(&arguments);
    let text = std::fs::read(out.join("summary.json")).unwrap();
    (output, serde_json::from_slice(&text).unwrap())
}

/// The pressure inside after the last outer iteration, of a table of them.
fn last_of(table: &Path) -> f64 {
    let mut rows = csv::Reader::from_path(table).unwrap();
    let columns = rows.headers().unwrap().clone();
    let is_inside = |name: &str| name == "internal_pressure_coefficient";
    let column = columns.iter().position(is_inside).unwrap();
    let last = rows.records().last().unwrap().unwrap();
    last[column].parse().unwrap()
}

/// Shorter front risers: faster, at a smaller angle of attack. What the risers carry is what the air does, and the guide carries nothing.
fn speed_bar() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, more: &[&str]| {
        let (output, summary) = run(&folder.path().join(name), more);
        assert_eq!(output.code, 0, "{}", output.errors);
        [
            "speed_m_s",
            "angle_of_attack_deg",
            "pitch_guide_force_n",
            "riser_balance_error",
        ]
        .map(|result| summary["results"][result]["value"].as_f64().unwrap())
    };
    let [speed, angle, guide, error] = of("trim", &[]);
    let [faster, smaller, ..] = of(
        "bar",
        &[
            "--set",
            "structure.wing.rows.A.trim_m=-0.03",
            "--set",
            "structure.wing.rows.B.trim_m=-0.015",
        ],
    );
    assert!(faster > speed + 0.2, "{faster} {speed} m/s");
    assert!(smaller < angle - 0.5, "{smaller} {angle} degrees");
    assert!(guide.abs() < tolerance::GUIDE_N, "{guide} N");
    assert!(error < tolerance::RISERS, "{error}");
    let inside = |name: &str| last_of(&folder.path().join(name).join("trim_iterations.csv"));
    let [with_bar, without] = ["bar", "trim"].map(inside);
    assert!(with_bar > 0.3 && with_bar < without - 0.02 && without < 1.0);
    assert!(folder.path().join("trim/trim_span.png").exists());
}

fn unsettled() {
    let folder = tempfile::tempdir().unwrap();
    let (output, summary) = run(
        &folder.path().join("out"),
        &[
            "--set",
            "equilibrium.trim.iteration_limit=2",
            "--set",
            "equilibrium.trim.tolerance={speed=1e-9}",
        ],
    );
    assert_eq!(output.code, 20, "{}", output.errors);
    let reason = summary["stop"]["reason"].as_str().unwrap();
    assert!(
        reason.contains("NOT reached within 2 outer iterations")
            && reason.contains("speed changes"),
        "{reason}"
    );
}
