//! What follows from a mesh in a stream: tunnel, its place there, lattice, materials, time, outputs.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use toml::{Table, Value};

use super::super::density::{standard_density_kg_m3, standard_kinematic_viscosity_m2_s};
use super::super::file::{CanopyType, MeshDesign, MeshType, Quality};
use super::super::problem::Problem;
use super::super::values::{absent, positive, readable, rotation};
use super::derived::Keys;
use super::handbook::Published;
use super::materials;
use super::units::{altitude_m, rounded, speed_m_s};
use crate::geometry::line_table;
use crate::geometry::mesh::{obj, surface};

/// The table of the design.
const TABLE: &str = "mesh";

/// Room that the tunnel leaves, in lengths: before the middle of the mesh and behind it, its width; before the ends of lines.
const UPSTREAM: f64 = 3.0;
const DOWNSTREAM: f64 = 6.5;
const WIDTH: f64 = 6.0;
const BEFORE_LINES: f64 = 0.3;

/// Cells per step at the speed of the wind.
const LATTICE_SPEED: f64 = 0.08;

/// Lengths over the speed: rise of the wind, longest run, time between samples and between files of the fabric.
const START: f64 = 0.67;
const LENGTH: f64 = 60.0;
const SAMPLES: f64 = 0.03;
const FRAMES: f64 = 0.5;

/// Length of the sponge before the outlet, in lengths.
const SPONGE: f64 = 1.5;

/// Lengths over the speed at which pictures are drawn.
const PICTURES: [f64; 3] = [0.0, 2.0, 10.0];

/// Extents that a mesh may have without a word on its unit [m].
const USUAL_EXTENTS_M: [f64; 2] = [0.02, 60.0];

/// Cells over the length, half width of the mean drag's interval over it.
const fn fineness(quality: Quality) -> (f64, f64) {
    match quality {
        Quality::Draft => (16.0, 0.10),
        Quality::Normal => (24.0, 0.05),
        Quality::Fine => (32.0, 0.03),
    }
}

/// What the files of a mesh hold, turned.
struct Measured {
    /// Ends of the mesh at the start [m].
    low_m: DVec3,
    high_m: DVec3,
    /// Area of its triangles [m²].
    area_m2: f64,
    /// What it shows to the wind [m²].
    frontal_area_m2: f64,
    /// Lines, and where the foremost one ends [m].
    line_count: usize,
    foremost_m: f64,
}

impl Measured {
    fn new(design: &MeshDesign, scale: f64, folder: &Path) -> Result<Self, Problem> {
        let turn = rotation(&format!("{TABLE}.rotation"), design.rotation.as_ref())?;
        let unreadable = |key: &str, name: &str, why: String| {
            Problem::new(
                format!("{TABLE}.{key}"),
                format!("cannot read {}: {why}", folder.join(name).display()),
                "give a file that is there, relative to the case file",
            )
        };
        let mut mesh = surface::read(&folder.join(&design.file), scale)
            .map_err(|why| unreadable("file", &design.file, why))?;
        for place in &mut mesh.positions_m {
            *place = turn * *place;
        }
        let area_m2 = mesh.area_vectors_m2().map(DVec3::length).sum();
        let frontal_area_m2 = mesh.frontal_area_m2();
        let starts_m = match &design.start_file {
            None => mesh.positions_m,
            Some(start) => {
                let start = obj::read_folded(&folder.join(start), scale)
                    .map_err(|why| unreadable("start_file", start, why.to_string()))?;
                start.positions_m.iter().map(|p| turn * *p).collect()
            }
        };
        let places = || starts_m.iter().copied();
        let low_m = places().fold(DVec3::INFINITY, DVec3::min);
        let high_m = places().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (mut line_count, mut foremost_m) = (0, low_m.x);
        if let Some(table) = &design.line_table {
            let text = std::fs::read_to_string(folder.join(table))
                .map_err(|why| unreadable("line_table", table, why.to_string()))?;
            let lines =
                line_table::parse(&text).map_err(|why| unreadable("line_table", table, why))?;
            line_count = lines.len();
            let ends = lines.iter().map(|line| (turn * line.end_m).x);
            foremost_m = ends.fold(foremost_m, f64::min);
        }
        Ok(Self {
            low_m,
            high_m,
            area_m2,
            frontal_area_m2,
            line_count,
            foremost_m,
        })
    }

    /// Refuses a mesh that is as large as a unit that was forgotten makes it.
    fn refuse_without_scale(&self) -> Result<(), Problem> {
        let extent_m = self.extent_m();
        if (USUAL_EXTENTS_M[0]..=USUAL_EXTENTS_M[1]).contains(&extent_m) {
            return Ok(());
        }
        Err(Problem::new(
            "mesh.scale",
            format!(
                "mesh.scale is missing: in metres the mesh would be {} m large",
                readable(rounded(extent_m))
            ),
            "write the metres per unit of the file: scale = 0.001 for millimetres, 0.0254 for inches, 1.0 if it is metres",
        ))
    }

    fn extent_m(&self) -> f64 {
        (self.high_m - self.low_m).max_element()
    }
}

/// Refuses keys that a mesh of its kind has no use for, and asks for those that it needs.
fn refuse(design: &MeshDesign) -> Result<(), Problem> {
    let is = |kind: MeshType| design.kind == kind;
    for (key, written, needed, used, what) in [
        (
            "line_table",
            design.line_table.is_some(),
            is(MeshType::Canopy),
            is(MeshType::Canopy),
            "a canopy hangs on lines",
        ),
        (
            "lines",
            design.lines.is_some(),
            false,
            is(MeshType::Canopy),
            "a canopy hangs on lines",
        ),
        (
            "held_nodes",
            design.held_nodes.is_some(),
            is(MeshType::Sheet),
            is(MeshType::Sheet),
            "a sheet is held at nodes",
        ),
        (
            "fabric",
            design.fabric.is_some(),
            false,
            !is(MeshType::Rigid),
            "canopies and sheets are of fabric",
        ),
        (
            "start_file",
            design.start_file.is_some(),
            false,
            !is(MeshType::Rigid),
            "canopies and sheets start in another shape",
        ),
        (
            "reference_area_m2",
            design.reference_area_m2.is_some(),
            false,
            !is(MeshType::Sheet),
            "canopies and rigid bodies have coefficients",
        ),
    ] {
        let key = format!("{TABLE}.{key}");
        if written && !used {
            return Err(Problem::new(
                key.as_str(),
                format!("{key} has no effect here: only {what}"),
                "remove it, or choose another type",
            ));
        }
        if needed && !written {
            return Err(absent(&key, what));
        }
    }
    Ok(())
}

/// Name of a rigid body by its file.
fn body_name(file: &str) -> String {
    let stem = Path::new(file).file_stem().unwrap_or_default();
    let word = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    stem.to_string_lossy().chars().map(word).collect()
}

/// All keys that follow; `written` is the design's table, for what is passed on as it is.
pub(super) fn derive(design: &MeshDesign, written: &Table, folder: &Path) -> Result<Keys, Problem> {
    refuse(design)?;
    let speeds = [
        design.speed_m_s,
        design.speed_km_h,
        design.speed_ft_s,
        design.speed_kt,
    ];
    let speed = speed_m_s(TABLE, speeds)?;
    let speed = speed.ok_or_else(|| absent("mesh.speed_m_s", "the mesh stands in a wind"))?;
    let altitude = altitude_m(TABLE, [design.altitude_m, design.altitude_ft])?;
    let scale = positive("mesh.scale", design.scale.unwrap_or(1.0))?;
    let found = Measured::new(design, scale, folder)?;
    if design.scale.is_none() {
        found.refuse_without_scale()?;
    }
    let reference_m2 = match design.reference_area_m2 {
        Some(area) => positive("mesh.reference_area_m2", area)?,
        None if design.kind == MeshType::Canopy => found.area_m2,
        None => found.frontal_area_m2,
    };
    let is_canopy = design.kind == MeshType::Canopy;
    let (length_m, of) = if is_canopy {
        ((4.0 * reference_m2 / PI).sqrt(), "D_0")
    } else {
        (found.extent_m(), "largest extent")
    };
    let quality = design.quality.unwrap_or(Quality::Normal);
    let (cells, confidence) = fineness(quality);
    let density = standard_density_kg_m3(altitude);
    let mut keys = Keys::default();
    let of_length = |factor: f64| format!("{factor} {of}");
    let title = format!("{} in {} m/s", body_name(&design.file), rounded(speed));
    keys.set("title", title, "file, speed");
    let why = "standard atmosphere at altitude_m";
    keys.set("air.density_kg_m3", density, why);
    let viscosity = standard_kinematic_viscosity_m2_s(altitude);
    let why = "standard atmosphere, Sutherland's law";
    keys.set("air.kinematic_viscosity_m2_s", viscosity, why);
    keys.set("air.refinement.around", "structure", "usual");
    keys.set("air.wind_tunnel.speed_m_s", speed, "speed");
    let middle_m = 0.5 * (found.low_m + found.high_m);
    let half = 0.5 * WIDTH * length_m;
    let behind_inlet = UPSTREAM * length_m - middle_m.x;
    let behind_lines = BEFORE_LINES * length_m - found.foremost_m;
    let position = DVec3::new(
        behind_inlet.max(behind_lines),
        half - middle_m.y,
        half - middle_m.z,
    );
    let long_m = position.x + middle_m.x + DOWNSTREAM * length_m;
    let size = [long_m, 2.0 * half, 2.0 * half];
    let why = format!("{DOWNSTREAM} {of} behind the middle of the mesh, {WIDTH} wide");
    let list = |numbers: [f64; 3]| numbers.map(Value::from).to_vec();
    keys.set("air.wind_tunnel.size_m", list(size), &why);
    let time_s = length_m / speed;
    let over_speed = |factor: f64| format!("{factor} {of} over the speed");
    let start = "air.wind_tunnel.start_time_s";
    keys.set(start, START * time_s, &over_speed(START));
    let sponge = "air.wind_tunnel.sponge_length_m";
    keys.set(sponge, SPONGE * length_m, &of_length(SPONGE));
    if is_canopy {
        keys.set("resolution.cells_per_diameter", cells, "quality");
    } else {
        let why = format!("{cells} over the largest extent: quality");
        keys.set("resolution.cell_size_m", length_m / cells, &why);
    }
    keys.set("resolution.lattice_speed", LATTICE_SPEED, "usual");
    keys.set("resolution.operator", "stabilised_regularised", "usual");
    let or_lines = match design.line_table {
        Some(_) => format!(", or the ends of its lines {BEFORE_LINES}"),
        None => String::new(),
    };
    let why = format!("its middle {UPSTREAM} {of} behind the inlet{or_lines}");
    let own = match design.kind {
        MeshType::Rigid => format!("bodies.{}", body_name(&design.file)),
        MeshType::Canopy | MeshType::Sheet => "structure.mesh".to_owned(),
    };
    keys.set(format!("{own}.position_m"), list(position.to_array()), &why);
    let mut pass = |from: &str, to: String| {
        if let Some(value) = written.get(from) {
            keys.set(to, value.clone(), from);
        }
    };
    let mesh = match design.kind {
        MeshType::Rigid => format!("{own}.mesh"),
        MeshType::Canopy | MeshType::Sheet => own.clone(),
    };
    pass("rotation", format!("{own}.rotation"));
    pass("line_table", format!("{mesh}.lines"));
    for key in [
        "file",
        "start_file",
        "weld_tolerance_m",
        "orient_triangles",
        "accept",
        "held_nodes",
    ] {
        pass(key, format!("{mesh}.{key}"));
    }
    keys.set(format!("{mesh}.scale"), scale, "scale");
    match design.kind {
        MeshType::Rigid => {
            let reference = format!("{own}.reference");
            let why = match design.reference_area_m2 {
                Some(_) => "reference_area_m2",
                None => "frontal area",
            };
            keys.set(format!("{reference}.area_m2"), reference_m2, why);
            keys.set(format!("{reference}.length_m"), length_m, of);
        }
        MeshType::Canopy => {
            let why = match design.reference_area_m2 {
                Some(_) => "reference_area_m2",
                None => "area of the fabric",
            };
            keys.set(format!("{own}.nominal_area_m2"), reference_m2, why);
            keys.set(
                format!("{own}.held_nodes"),
                Value::Array(Vec::new()),
                "none",
            );
            let published = Published::of(CanopyType::FlatCircular);
            let load_n = published.opening_force_factor[1]
                * published.mean_drag_coefficient()
                * 0.5
                * density
                * speed
                * speed
                * reference_m2;
            let wanted = (length_m, found.line_count, load_n);
            let (cord, why) = materials::line(TABLE, design.lines.as_deref(), wanted)?;
            let table = format!("{own}.line_material");
            materials::set_cord(&table, (&cord, &why), &[], &mut keys);
        }
        MeshType::Sheet => {}
    }
    if design.kind != MeshType::Rigid {
        let cloth = materials::cloth(TABLE, design.fabric.as_deref())?;
        materials::set_cloth(&cloth, &mut keys);
        keys.set("coupling.structure_every", 1, "usual");
        let canopies = "output.canopy_interval_s";
        keys.set(canopies, FRAMES * time_s, &over_speed(FRAMES));
    }
    keys.set("coupling.scheme", "kernel", "usual for meshes");
    keys.set("time.end_s", LENGTH * time_s, &over_speed(LENGTH));
    if design.kind != MeshType::Sheet {
        keys.set("steady.drag_confidence", confidence, "quality");
    }
    let samples = "output.sample_interval_s";
    keys.set(samples, SAMPLES * time_s, &over_speed(SAMPLES));
    let times: Vec<Value> = PICTURES.map(|t| Value::from(t * time_s)).to_vec();
    let why = format!("multiples of {of} over the speed");
    keys.set("output.picture_times_s", times, &why);
    keys.set("output.history_plots", true, "usual");
    Ok(keys)
}
