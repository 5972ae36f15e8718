//! What a case has for keys that it leaves out: told by the ledger, and no key forgotten.

use std::collections::BTreeSet;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices, SHIPPED};
use serde_json::Value;

use crate::case_schema::schema;
use crate::command_line::root;
use crate::engines::plain;
use crate::folders::{json, sheet};

pub fn trials() -> Vec<Trial> {
    [
        plain("resolved::no_key_is_forgotten", no_key_is_forgotten),
        plain("resolved::values_are_those_of_the_run", values),
        plain("resolved::the_ledger_tells_them", the_ledger),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Keys whose absence has no value: what they would give is not there, or another key gives it.
const ABSENT_IS_NOTHING: &[&str] = &[
    "altitude_m",
    "angles_deg",
    "angular_velocity_rad_s",
    "animation_interval_s",
    "apex_guide_n_m",
    "at_m",
    "axial_stiffness_n",
    "axis",
    "bodies_interval_s",
    "box_m",
    "breaking_load_n",
    "canopy_interval_s",
    "cells_per_chord",
    "cells_per_diameter",
    "cubic_shear_compliance_1_pa3",
    "diameter_m",
    "displacements_m",
    "drag_coefficient",
    "ends_m",
    "file",
    "flow_interval_s",
    "force_strain",
    "grid_sequence",
    "half",
    "hangs_from",
    "height",
    "inside",
    "inside_per_cell",
    "internal_pressure_coefficient",
    "joins",
    "length_m",
    "lines",
    "load_n",
    "lower",
    "mass_kg",
    "mini_ribs_from",
    "naca",
    "nodes",
    "nominal_area_m2",
    "nominal_diameter_m",
    "nose_cut",
    "note",
    "pitch_guide_n_m",
    "polar",
    "polar_file",
    "positions",
    "pressure_pa",
    "pretension_n",
    "range",
    "rib_places_m",
    "riser_length_m",
    "roll_deg",
    "shift_cells",
    "sponge_length_m",
    "start_file",
    "structure_every",
    "to_sail_m",
    "transition",
    "upper",
    "value",
    "velocity_m_s",
    "vent_diameter_m",
    "weights",
    "yield_stress_pa",
    "youngs_modulus_pa",
];

/// What brings keys into cases that no shipped one has.
const FURTHER: &[(&str, Option<&str>, &[&str])] = &[
    ("flat-circular-tunnel", None, &["fabric.friction=model"]),
    (
        "ringslot-drop",
        None,
        &["structure.ringslot.tapes_per_gore=absent"],
    ),
    (
        "slung-weight",
        None,
        &["springs.tie={ nodes = [1, 10], stiffness_n_m = 100.0 }"],
    ),
    (
        "flat-circular-tunnel",
        None,
        &[
            "air.wind_tunnel.size_m=absent",
            "air.refinement=absent",
            "structure.flat_circular.confluence_m=absent",
        ],
    ),
    (
        "tapered-wing",
        None,
        &["aero.wing.kinematic_viscosity_m2_s=absent"],
    ),
    (
        "sphere",
        None,
        &[
            "coupling.scheme=links",
            "resolution.cells_per_diameter=absent",
            "resolution.cell_size_m=0.0125",
            "bodies.sphere.sphere=absent",
            "bodies.sphere.wing={ naca = \"0020\", stations = [{ position_m = [0.0, 0.0, 0.0], chord_m = 0.1 }, { position_m = [0.0, 0.1, 0.0], chord_m = 0.1 }] }",
        ],
    ),
    (
        "sphere",
        None,
        &[
            "bodies.sphere.motion.constant_rotation.rate_rad_s=1e-3",
            "bodies.sphere.motion.constant_rotation.axis=[1.0, 0.0, 0.0]",
        ],
    ),
    (
        "sphere",
        None,
        &[
            "bodies.sphere.motion.oscillation.frequency_hz=0.1",
            "air.faces.z_lower=\"no_slip\"",
            "air.faces.inlet.boundary_layer.thickness_m=0.1",
        ],
    ),
    (
        "hanging-sheet",
        None,
        &[
            "supports.hand.nodes=[1]",
            "supports.hand.displacement_m=[0.0, 0.0, 0.1]",
        ],
    ),
    (
        "flat-circular-tunnel",
        None,
        &[
            "fabric.permeability.ergun.viscous_coefficient_pa_s_m2=1e6",
            "fabric.permeability.ergun.inertial_coefficient_kg_m4=1e5",
            "title=absent",
            "resolution.lattice_speed=absent",
        ],
    ),
    (
        "flat-circular-tunnel",
        None,
        &[
            "air.refinement={around=\"nothing\"}",
            "resolution.eddy_viscosity={model=\"wale\",constant=0.5}",
            "structure.flat_circular=absent",
            "structure.extended_skirt={nominal_area_m2=0.78,gores=8,rings=12,extension_ratio=0.1,confluence_m=[0.6,1.4955,1.4955],\
             folding={folded_diameter_ratio=0.15,opened_diameter_ratio=0.2,loading_pressure_pa=20.0}}",
        ],
    ),
    (
        "hemispherical-mesh",
        None,
        &[
            "structure.mesh.position_m=absent",
            "air=absent",
            "resolution=absent",
            "coupling=absent",
            "time.step_s=1e-3",
        ],
    ),
    (
        "ram-air-parachute",
        None,
        &["structure.wing.tunnel.held=absent"],
    ),
    (
        "wing-school",
        None,
        &["structure.wing.rods={nose={upper=[0.0,0.12],lower=[0.0,0.08],diameter_m=0.0024}}"],
    ),
    (
        "wing-school",
        Some("prescribed"),
        &["equilibrium.wing_pressure.along_span=absent"],
    ),
    (
        "finite-mass-drop",
        None,
        &["payload.drag_area_m2=absent", "coupling.scheme=absent"],
    ),
];

fn load(path: &std::path::Path, variant: Option<&str>, overrides: &[&str]) -> Case {
    let choices = Choices {
        variant: variant.map(str::to_owned),
        overrides: overrides.iter().map(|&change| change.to_owned()).collect(),
    };
    case::load(path, &choices).unwrap_or_else(|error| panic!("{}: {error:?}", path.display()))
}

/// Last parts of all keys that a case may leave out and that are no tables, from the schema of case files.
fn optional_keys() -> BTreeSet<String> {
    let schema = schema();
    let definitions = schema["definitions"].as_object().unwrap();
    let resolved = |of: &Value| {
        let mut part = of.clone();
        while let Some(name) = (part["allOf"][0]["$ref"].as_str()).or(part["$ref"].as_str()) {
            part = schema
                .pointer(name.trim_start_matches('#'))
                .unwrap()
                .clone();
        }
        part
    };
    let is_table = |of: &Value| {
        let mut part = resolved(of);
        if part["items"].is_object() {
            part = resolved(&part["items"]);
        }
        let has_keys = |part: &Value| part["properties"].is_object();
        let alternatives = part["oneOf"].as_array();
        has_keys(&part)
            || part["additionalProperties"].is_object()
            || alternatives.is_some_and(|all| all.iter().any(has_keys))
    };
    let mut keys = BTreeSet::new();
    // What a design leaves out is told by the keys that follow from it (`Case::derived`).
    let of_designs = ["CanopyDesign", "WingDesign", "MeshDesign"];
    assert!(
        of_designs
            .iter()
            .all(|name| definitions.contains_key(*name))
    );
    let is_design = |name: &String| of_designs.contains(&name.as_str());
    let others = definitions.iter().filter(|(name, _)| !is_design(name));
    for part in others.map(|(_, part)| part).chain([&schema]) {
        let required = part["required"].as_array();
        for (key, of) in part["properties"].as_object().into_iter().flatten() {
            let is_required = required.is_some_and(|all| all.iter().any(|name| name == key));
            // What has a default in the schema is read with it.
            if !is_required && of["default"].is_null() && !is_table(of) {
                keys.insert(key.clone());
            }
        }
    }
    keys
}

/// The checks of cases, without white space.
fn checks() -> Vec<(String, String)> {
    let entries = std::fs::read_dir(root().join("src/case")).unwrap();
    entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (
                path.display().to_string(),
                text.split_whitespace().collect(),
            )
        })
        .collect()
}

/// Every key that may be left out has a value that the ledger tells, or is in the list of those whose absence means that there is nothing.
fn no_key_is_forgotten() {
    if !root().join("src/case").exists() {
        // The sources are not everywhere that the tests run.
        return;
    }
    let optional = optional_keys();
    assert!(optional.len() > 80, "{optional:?}");
    let files = crate::cases::files();
    let mut told = BTreeSet::new();
    let mut note = |case: &Case| {
        told.extend(case.resolved.keys().map(|key| {
            let last = key.rsplit('.').next().unwrap();
            last.to_owned()
        }));
    };
    for (name, text) in SHIPPED {
        let path = root().join(&files[name]);
        let table: toml::Table = toml::from_str(text).unwrap();
        let variants = table.get("variants").and_then(|v| v.as_table()).cloned();
        note(&load(&path, None, &[]));
        for variant in variants.unwrap_or_default().keys() {
            note(&load(&path, Some(variant), &[]));
        }
    }
    for (name, variant, overrides) in FURTHER {
        note(&load(&root().join(&files[*name]), *variant, overrides));
    }
    let nothing: BTreeSet<String> = ABSENT_IS_NOTHING
        .iter()
        .map(|key| (*key).to_owned())
        .collect();
    let forgotten: Vec<&String> = (optional.iter())
        .filter(|key| !told.contains(*key) && !nothing.contains(*key))
        .collect();
    assert!(
        forgotten.is_empty(),
        "keys without a value in the ledger: {forgotten:?}; take their defaults with usual::or in src/case"
    );
    for (name, text) in checks() {
        for key in optional.difference(&nothing) {
            // As one word: line breaks do not matter.
            for default in [format!(".{key}.unwrap_or"), format!(".{key}).unwrap_or")] {
                assert!(
                    !text.contains(&default),
                    "{name}: take the default of {key} with usual::or, or the ledger will not tell it"
                );
            }
        }
    }
    let unknown: Vec<&String> = nothing.difference(&optional).collect();
    assert!(unknown.is_empty(), "no such keys: {unknown:?}");
}

/// What is told is what the scene has; what the case gives is not told.
fn values() {
    let files = crate::cases::files();
    let canopy = load(&root().join(&files["flat-circular-tunnel"]), None, &[]);
    let of = |key: &str| canopy.resolved[key].as_f64().unwrap();
    let scene = &canopy.scene;
    let (air, time) = (scene.air.as_ref().unwrap(), scene.time.unwrap());
    assert_eq!(of("time.step_s"), time.step_s);
    assert_eq!(of("resolution.cell_size_m"), air.units.cell_size_m);
    assert_eq!(
        of("resolution.reference_speed_m_s"),
        air.reference_speed_m_s
    );
    assert_eq!(
        of("solver.evaluation_limit"),
        scene.solver.evaluation_limit as f64
    );
    let cells = canopy.resolved["air.cells"].as_array().unwrap();
    let expected = air.cells.map(serde_json::Value::from);
    assert_eq!(cells[..], expected[..]);
    for given in ["solver.tolerance", "time.end_s", "output.sample_interval_s"] {
        assert!(!canopy.resolved.contains_key(given), "{given}");
    }
    let fewer = load(
        &root().join(&files["flat-circular-tunnel"]),
        None,
        &["solver=absent", "output=absent"],
    );
    let scene = &fewer.scene;
    assert_eq!(fewer.resolved["solver.tolerance"], scene.solver.tolerance);
    let interval_s = scene.output.sample_interval_s;
    assert_eq!(fewer.resolved["output.sample_interval_s"], interval_s);
    // What follows from a key is told of the case as it is run.
    let coarse = load(
        &root().join(&files["flat-circular-tunnel"]),
        Some("quick"),
        &[],
    );
    let ratio = coarse.resolved["time.step_s"].as_f64().unwrap() / of("time.step_s");
    assert!((ratio - 2.0).abs() < 1e-12, "{ratio}");
}

/// With the time between checkpoints, which the case does not know.
fn the_ledger() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = sheet(&out, &["--checkpoint-every", "77"]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let resolved = &json(&out.join("run.json"))["case"]["resolved"];
    assert_eq!(resolved["checkpoint_every_s"], 77.0);
    assert_eq!(resolved["fabric.residual_stiffness"], 1e-5);
    assert_eq!(resolved["output.picture_fabric"], "tension");
    assert!(resolved["solver.tolerance"].is_null(), "the case gives it");
}
