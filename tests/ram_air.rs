//! Wings in the wind: what cells enclose, their openings, risers that are hauled in, and the air's force by symmetry and momentum.

use std::path::Path;

use glam::{DMat3, DVec3};
use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::cloth::openings::OpeningKind;
use ripstop::cloth::rims;
use ripstop::cpu::cloth::{Cloth, InitialHessian, MarkerReaction, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::frame::CableKind;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};
use ripstop::geometry::wing::LineKind;
use ripstop::geometry::wing::section::Side;
use ripstop::plan::{Plan, Precision};
use ripstop::run;
use ripstop::simulation::Simulation;
use ripstop::statics::Statics;

use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::resumed::{bits_of_nodes, taken_up};
use crate::tolerances::{self, ram_air};

pub fn trials() -> Vec<Trial> {
    [
        plain("ram_air::cells_enclose_their_volume", volumes),
        plain("ram_air::openings_have_their_rims", openings),
        plain("ram_air::risers_are_hauled_in", pulls),
        plain("ram_air::a_symmetric_wing_lifts_nothing", symmetry),
        plain("ram_air::lines_drag_across_the_wind", line_drag),
        plain("ram_air::ribs_feel_the_air_across_themselves", across),
        on_every_engine("ram_air::a_wing_goes_on_from_a_checkpoint", GoesOn),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A rectangular wing of four cells and a metre of chord, 12 cells of air per chord, in a small tunnel; `more` goes on with its wing.
fn text(profile: &str, (pitch_deg, held): (f64, &str), end_s: f64, more: &str) -> String {
    format!(
        r#"
version = 1

[air]
density_kg_m3 = 1.2
kinematic_viscosity_m2_s = 1.5e-3

[air.wind_tunnel]
speed_m_s = 10.0
size_m = [3.0, 2.5, 2.5]
start_time_s = 0.02

[resolution]
cells_per_chord = 12.0
lattice_speed = 0.1
operator = "recursive_regularised"
eddy_viscosity = {{ model = "smagorinsky", constant = 0.15 }}

[coupling]
over_relaxation = 1.6

[time]
end_s = {end_s}

[output]
sample_interval_s = 0.01

[structure.wing]
cells = 4
hang_point_m = [0.25, 0.2, -0.6]
stations = [
  {{ span_m = 0.0, chord_m = 1.0, sweep_m = 0.0, roll_deg = 0.0, twist_deg = 0.0, profile = "all" }},
  {{ span_m = 0.6, chord_m = 1.0, sweep_m = 0.0, roll_deg = 0.0, twist_deg = 0.0, profile = "all" }},
]
profiles = {{ all = {{ naca = "{profile}" }} }}
{more}

[structure.wing.tunnel]
# The middle of the chord in the middle of the tunnel.
place_m = [1.0, 1.25, 0.65]
pitch_deg = {pitch_deg}
held = "{held}"

[structure.wing.mesh]
along_chord = 12
across_cell = 4

[structure.wing.fabrics.upper]
thickness_m = 6e-5
density_kg_m3 = 700.0
youngs_modulus_pa = 4e8
poisson_ratio = 0.15

[structure.wing.line_materials.line]
diameter_m = 0.001
mass_per_length_kg_m = 0.0008
axial_stiffness_n = 2e4

[structure.wing.rows.A]
position = 0.15
ribs = [1, 2]
levels = [{{ material = "line" }}]
riser_length_m = 0.2
riser_material = "line"

[structure.wing.rows.brake]
position = 1.0
ribs = [1, 2]
levels = [{{ material = "line" }}]
riser_length_m = 0.2
riser_material = "line"
"#
    )
}

fn parse(text: &str) -> case::Case {
    case::parse("ram_air.toml", text, Path::new("."), &Choices::default()).unwrap()
}

const OPEN: &str = "intakes = { from = 0.0, to = 0.1 }\nholes = [{ position = 0.3, width = 0.2, height = 0.5 }, { position = 0.6, width = 0.1, height = 0.5 }]";

/// Without ballooning, cells enclose section times width, wherever the wing stands; laid together, the same share of it.
fn volumes() {
    for intakes in ["", OPEN] {
        let case = parse(&text("4418", (20.0, "hang_points"), 0.1, intakes));
        let known = case.scene.wing().unwrap();
        let tunnel = known.tunnel.as_ref().unwrap();
        let wing = &known.built;
        let whole = |places: &[DVec3]| -> f64 {
            (0..4).map(|cell| wing.cell_volume_m3(cell, places)).sum()
        };
        let exact = wing.measures.section_volume_m3;
        let error = whole(&tunnel.designed_m) / exact - 1.0;
        assert!(error.abs() < ram_air::VOLUME, "{error:e}");
        let back: Vec<DVec3> = (tunnel.designed_m.iter())
            .map(|p| DMat3::from_rotation_y(-tunnel.pitch_rad) * *p)
            .collect();
        // The design stands with its nose in the origin.
        let nose = back[wing.middle_chord[0] as usize];
        let design: Vec<DVec3> = back.iter().map(|p| *p - nose).collect();
        let laid = wing.laid_together_m(&design, 0.25);
        let error = whole(&laid) / (0.25 * exact) - 1.0;
        assert!(error.abs() < ram_air::LAID_TOGETHER, "{error:e}");
        let lines = wing.hang_points[0] as usize..;
        assert_eq!(laid[lines.clone()], design[lines]);
        // Points between the panels lie inside the section.
        for point in wing.inner_points_m(1, &design) {
            let share = point.x;
            let frame = &wing.frames[1];
            let height = |side| frame.height(&wing.profiles, side, share);
            let middle = height(Side::Upper).midpoint(height(Side::Lower));
            assert!((point.z - middle).abs() < ram_air::MIDDLE, "{point}");
        }
    }
}

/// Every cell has an intake, every inner rib its holes, and together with the tips' none their rims are all free edges of the wing.
fn openings() {
    let case = parse(&text("4418", (0.0, "hang_points"), 0.1, OPEN));
    let structure = &case.scene.body.as_ref().unwrap().structure;
    let of = |kind| structure.openings.iter().filter(move |o| o.kind == kind);
    assert_eq!(of(OpeningKind::Intake).count(), 4);
    assert_eq!(of(OpeningKind::RibHole).count(), 3 * 2);
    let sorted = |edges: Vec<[u32; 2]>| {
        let mut edges: Vec<[u32; 2]> = edges.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    };
    let rims: Vec<[u32; 2]> = structure
        .openings
        .iter()
        .flat_map(|o| o.rim.clone())
        .collect();
    assert_eq!(sorted(rims), sorted(rims::rim_edges(structure)));
    // The lower nose of NACA 4418 from 0 to 10 % of the chord.
    let yt = |x: f64| {
        0.9 * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
            - 0.1036 * x.powi(4))
    };
    let yc = |x: f64| 0.04 / 0.16 * (0.8 * x - x * x);
    let height = yc(0.1) - yt(0.1);
    for intake in of(OpeningKind::Intake) {
        assert!((intake.width_m - f64::hypot(0.1, height)).abs() < 1e-9);
    }
    let widths: Vec<f64> = of(OpeningKind::RibHole).map(|o| o.width_m).collect();
    assert!(
        widths.iter().all(|w| (0.05..0.11).contains(w)),
        "{widths:?}"
    );
}

/// A line at rest drags along a horizontal wind by ½ ρ C_d d L u² sin³ of the angle between both; lines and risers of 1 mm. In the boundary layer of a
/// floor u is the seventh root of the height.
fn line_drag() {
    let layer = "[air.faces]\nz_lower = \"no_slip\"\n\n[air.faces.inlet.boundary_layer]\nthickness_m = 2.5\n\n[resolution]";
    let even = text("0012", (10.0, "everything"), 0.1, "");
    for (text, exponent) in [
        (even.clone(), 0.0),
        (even.replace("[resolution]", layer), 1.0 / 7.0),
    ] {
        let case = parse(&text);
        let mut simulation = Simulation::new(
            case.scene.clone(),
            Plan::new(&case.scene, Engine::CpuF32.plan_placement()),
            None,
        )
        .unwrap();
        while simulation.step_count() <= simulation.plan().start_steps {
            simulation.advance().unwrap();
        }
        let structure = &simulation.cloth().unwrap().structure;
        let lines = structure
            .cables
            .iter()
            .filter(|cable| cable.kind == CableKind::SuspensionLine);
        let expected: f64 = lines
            .map(|line| {
                let [a, b] = line.nodes.map(|n| structure.positions_m[n as usize]);
                let sine = (1.0 - ((b - a).normalize().x).powi(2)).sqrt();
                let speed = 10.0 * (a.midpoint(b).z / 2.5).powf(exponent);
                0.5 * 1.2 * 1.1 * 0.001 * a.distance(b) * speed * speed * sine.powi(3)
            })
            .sum();
        let error = simulation.line_drag_n().unwrap().x / expected - 1.0;
        let allowed = if exponent == 0.0 {
            ram_air::LINE_DRAG_IN_EVEN_WIND
        } else {
            ram_air::LINE_DRAG
        };
        assert!(error.abs() < allowed, "{error:e}");
    }
    let without = even.replace("held =", "line_drag_coefficient = 0.0\nheld =");
    assert!(
        !parse(&without)
            .scene
            .body
            .unwrap()
            .structure
            .has_line_drag()
    );
}

/// Risers are as long as their table says, and the trailing edge follows the brakes of its half alone.
fn pulls() {
    let pulled = text("4418", (0.0, "hang_points"), 0.12, OPEN).replace(
        "position = 1.0\n",
        "position = 1.0\npull = { length_m = 0.1, table = [[0.02, 0.0], [0.08, 1.0]], half = \"right\" }\n",
    );
    let case = parse(&pulled);
    let plan = Plan::new(&case.scene, Precision::F32);
    let mut simulation = Simulation::new(case.scene.clone(), plan, None).unwrap();
    let known = case.scene.wing().unwrap();
    let designed = &case.scene.body.as_ref().unwrap().structure;
    let steps = simulation.plan().start_steps + simulation.plan().steps;
    while simulation.step_count() < steps {
        simulation.advance().unwrap();
        if !simulation.released() {
            continue;
        }
        let cloth = simulation.cloth().unwrap();
        for (i, kind) in known.built.line_kinds.iter().enumerate() {
            let (now, then) = (&cloth.structure.cables[i], &designed.cables[i]);
            let right = then.nodes.contains(&known.built.hang_points[0]);
            let pull = match kind {
                LineKind::Riser { row: 1 } if right => {
                    0.1 * ((simulation.time_s() - 0.02) / 0.06).clamp(0.0, 1.0)
                }
                _ => 0.0,
            };
            let error = then.rest_length_m - now.rest_length_m - pull;
            assert!(error.abs() < 1e-12, "{kind:?}: {error:e}");
        }
    }
    let cloth = simulation.cloth().unwrap();
    let way = |rib: usize| {
        let tail = known.built.outlines[rib][12] as usize;
        cloth.positions_m[tail].z - designed.positions_m[tail].z
    };
    let [left, right] = [way(1), way(3)];
    assert!(right < left - ram_air::BRAKED_M, "{left} {right}");
}

/// A symmetric section along the wind, held rigidly in the middle between the walls: no lift and no side force. Turned, it lifts up, and its
/// force by the markers is that of the momentum box. Held by friction as well it drags more and lifts less.
fn symmetry() {
    let run = |pitch_deg: f64, friction: &str| {
        // It turns about the middle of its chord, in the middle of the tunnel.
        let held = format!("held = \"everything\"\nfriction = \"{friction}\"");
        let text = text("0018", (pitch_deg, "everything"), 0.3, "")
            .replace("[0.25, 0.2, -0.6]", "[0.5, 0.2, 0.0]")
            .replace("[1.0, 1.25, 0.65]", "[1.25, 1.25, 1.25]")
            .replace("held = \"everything\"", &held);
        let case = parse(&text);
        let plan = Plan::new(&case.scene, Precision::F32);
        let (simulation, record) = run::without_files(&case, plan, None).unwrap();
        let results = ripstop::measure::results(&simulation, &Statics::default(), &record);
        [
            "lift_coefficient",
            "drag_coefficient",
            "force_imbalance",
            "force_y_n",
        ]
        .map(|name| results.get(name).unwrap().value.unwrap())
    };
    let [lift, drag, imbalance, side_n] = run(0.0, "none");
    assert!(
        drag > 0.0 && imbalance < ram_air::IMBALANCE,
        "{drag} {imbalance}"
    );
    assert!(lift.abs() < ram_air::SYMMETRY * drag, "{lift} of {drag}");
    // ½ ρ U² S = 72 N.
    assert!(side_n.abs() < ram_air::SYMMETRY * drag * 72.0, "{side_n}");
    let [_, held_drag, ..] = run(0.0, "no_slip");
    assert!(
        held_drag > ram_air::HELD_DRAG * drag,
        "{held_drag} against {drag}"
    );
    let [up, drag, imbalance, _] = run(10.0, "none");
    let [down, ..] = run(-10.0, "none");
    let [held_up, ..] = run(10.0, "no_slip");
    assert!(held_up < ram_air::HELD_LIFT * up, "{held_up} against {up}");
    assert!(imbalance < ram_air::IMBALANCE, "{imbalance}");
    let [least, most] = ram_air::LIFT_AT_10_DEG;
    assert!((least..most).contains(&up), "{up} {drag}");
    assert!((up + down).abs() < ram_air::SYMMETRY * up, "{up} {down}");
}

#[derive(Clone, Copy)]
struct GoesOn;

impl Body for GoesOn {
    /// A wing along which the air slides, while its brakes are hauled in: what the air gets is what the wing felt, and a run that stops halfway goes on with
    /// the same bits.
    fn run(self, engine: Engine) {
        let text = text("4418", (5.0, "attachments"), 0.12, OPEN).replace(
            "position = 1.0\n",
            "position = 1.0\npull = { length_m = 0.1, table = [[0.0, 0.0], [0.1, 1.0]] }\n",
        );
        let case = parse(&text);
        let plan = || Plan::new(&case.scene, engine.plan_placement());
        let mut straight = Simulation::new(case.scene.clone(), plan(), engine.device()).unwrap();
        for _ in 0..straight.plan().start_steps + 10 {
            straight.advance().unwrap();
        }
        let fresh = Simulation::new(case.scene.clone(), plan(), engine.device()).unwrap();
        let mut resumed = taken_up(&mut straight, fresh);
        for _ in 0..10 {
            straight.advance().unwrap();
            resumed.advance().unwrap();
        }
        assert_eq!(bits_of_nodes(&straight), bits_of_nodes(&resumed));
        let sample = straight.impulse_sample().unwrap().unwrap();
        let apart = (sample.momentum_box.unwrap() - sample.markers).length();
        let scale = sample.markers.length();
        assert!(
            apart < tolerances::momentum_closure(engine) * scale,
            "{apart:e} of {scale:e}"
        );
    }
}

/// A free sheet in a gust along and across it: what feels the air across itself alone is not moved along, and moves across as mass and reaction say,
/// v = u ΣK dt/(M + ΣK dt).
fn across() {
    let fabric = Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 500.0,
        warp_modulus_pa: 4e8,
        weft_modulus_pa: 4e8,
        poisson_ratio: 0.14,
        shear_modulus_pa: 1.8e8,
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 1e-3,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    };
    let shape = SheetShape {
        size_m: [1.0, 0.5],
        divisions: [4, 2],
        corner_m: DVec3::ZERO,
        across: DVec3::X,
        down: DVec3::Y,
    };
    let structure = sheet::build(&shape, &fabric, FabricModel::Membrane).unwrap();
    let (dt, stiffness_kg_s_m2, air) = (1e-3, 50.0, DVec3::new(9.0, -4.0, 3.0));
    for normal in [Some(DVec3::Z), None] {
        let markers: Vec<MarkerReaction> = (structure.triangles.iter().enumerate())
            .map(|(triangle, t)| MarkerReaction {
                triangle: triangle as u32,
                weights: [1.0 / 3.0; 3],
                stiffness_kg_s: stiffness_kg_s_m2 * t.rest_area_m2,
                air_velocity_m_s: air,
                across: normal,
            })
            .collect();
        let mass: f64 = structure.masses_kg.iter().sum();
        let pull = dt * stiffness_kg_s_m2 * structure.rest_area_m2();
        let share = pull / (mass + pull);
        let expected = match normal {
            Some(normal) => normal * normal.dot(air) * share,
            None => air * share,
        };
        let mut cloth = Cloth::new(structure.clone());
        let input = StepInput {
            time_step_s: Some(dt),
            markers: &markers,
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-9,
            displacement_floor_m: 0.0,
            evaluation_limit: 1000,
            history: 8,
            refresh_every: None,
            initial_hessian: InitialHessian::BlockJacobi,
        };
        cloth.solve_cloth(&input, &settings);
        for velocity in &cloth.velocities_m_s {
            let error = velocity.distance(expected);
            assert!(error < ram_air::ACROSS_M_S, "{velocity} {expected}");
        }
    }
}
