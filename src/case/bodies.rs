//! Rigid bodies and their surfaces: `[bodies.NAME]`.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;

use super::air::{Air, Flow};
use super::body_wing::{self, TRIANGLE_LIMIT};
use super::file::Scheme;
use super::file::{self, File};
use super::mesh_examination::{self, ExaminedMesh, FromFiles};
use super::motion;
use super::permeability;
use super::problem::Problem;
use super::through_faces::{self, Passing, REACH_CELLS};
use super::time::Time;
use super::usual;
use super::usual_box;
use super::values::{self, check_name, positive, vector, within};
use crate::fabric::permeability::Permeability;
use crate::geometry::mesh::surface;
use crate::geometry::parachute::shape::{RESOLUTION, projected_area_m2};
use crate::geometry::surfaces;
use crate::immersed::markers::{RIM_INSET_CELLS, SURFACE_INSET_CELLS};
use crate::rigid::{self, BoxFace, Motion, PrescribedMotion, Surface};

/// Edges of the triangles that shapes are divided into [cells]: one marker each, some 0.7 cells apart.
const EDGE_CELLS: f64 = 1.2;

/// Farthest that a marker may move in a step [cells].
pub const MARKER_MOTION_LIMIT: f64 = 0.25;

/// Instants at which a prescribed motion is looked at.
const LOOKS: u32 = 400;

/// A rigid body.
#[derive(Debug, Clone)]
pub struct RigidBody {
    /// Its name in the case.
    pub name: String,
    /// What it is.
    pub shape: Shape,
    /// Normal of a disk or plate before it moves.
    pub normal: DVec3,
    /// Its surface before it moves; of a body that passes through faces the part in the box of air.
    pub surface: Surface,
    /// The surface that markers stand on, a little inside.
    pub marker_surface: Surface,
    /// The faces of the box that it passes through; empty of most.
    pub faces: Vec<BoxFace>,
    /// How it moves.
    pub motion: PrescribedMotion,
    /// Speed of its fastest point on its way, at 400 times up to the end [m/s].
    pub fastest_m_s: f64,
    /// Volume and its centroid before the body moves, in the box, if the whole surface is closed [m³, m].
    pub volume_m3: Option<(f64, DVec3)>,
    /// Area that coefficients refer to [m²].
    pub reference_area_m2: f64,
    /// Area by which it blocks the section: the frontal area before it moves, in the box [m²].
    pub blocking_area_m2: f64,
    /// Length that the Reynolds number and coefficients of moments refer to [m].
    pub reference_length_m: f64,
    /// Point of the body that moments are about, before it moves [m].
    pub moment_point_m: DVec3,
    /// Permeability of the surface; `None`: no air passes.
    pub permeability: Option<Permeability>,
}

impl RigidBody {
    /// Speed that its coefficients refer to: of the wind, of its own constant motion, or the case's reference [m/s].
    #[must_use]
    pub fn reference_speed_m_s(&self, air: &Air) -> f64 {
        match (&self.motion.motion, &air.flow) {
            (_, Flow::WindTunnel { speed_m_s, .. }) if *speed_m_s > 0.0 => *speed_m_s,
            (Motion::ConstantVelocity { velocity_m_s, .. }, _) if *velocity_m_s != DVec3::ZERO => {
                velocity_m_s.length()
            }
            _ => air.reference_speed_m_s,
        }
    }
}

/// Shape of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Diameter [m].
        diameter_m: f64,
    },
    /// A disk without thickness.
    Disk {
        /// Diameter [m].
        diameter_m: f64,
    },
    /// A rectangle without thickness.
    Plate {
        /// Width and height [m].
        size_m: [f64; 2],
    },
    /// A circular cylinder.
    Cylinder {
        /// Diameter [m].
        diameter_m: f64,
        /// Length [m].
        length_m: f64,
        /// True if its ends are closed.
        closed: bool,
    },
    /// A closed wing by its sections.
    Wing {
        /// Area of the chords, the wing laid flat [m²].
        area_m2: f64,
        /// Mean aerodynamic chord [m].
        chord_m: f64,
    },
    /// A surface from a file.
    Mesh,
}

/// Checks all bodies.
pub(super) fn check(
    file: &File,
    files: &mut FromFiles,
    air: Option<&Air>,
    time: Option<&Time>,
) -> Result<Vec<RigidBody>, Problem> {
    let Some(first) = file.bodies.keys().next() else {
        return Ok(Vec::new());
    };
    let (Some(air), Some(time)) = (air, time) else {
        return Err(Problem::new(
            format!("bodies.{first}"),
            "rigid bodies do nothing without air",
            "add [air], or remove [bodies]",
        ));
    };
    if !matches!(air.flow, Flow::WindTunnel { .. }) {
        return Err(Problem::new(
            "air.taylor_green",
            "Taylor–Green vortices are a test of the air alone, but the case has rigid bodies",
            "remove [bodies], or use [air.wind_tunnel]",
        ));
    }
    // Before surfaces of millions of triangles are made for cells that no machine has.
    if air.cells.iter().map(|n| *n as f64).product::<f64>() >= f64::from(u32::MAX) {
        let [x, y, z] = air.cells;
        return Err(Problem::new(
            "resolution",
            format!(
                "the air has {x} x {y} x {z} cells, and more than 4 294 967 294 cannot be addressed"
            ),
            "choose larger cells (resolution.cells_per_diameter or cell_size_m), or a smaller tunnel",
        ));
    }
    file.bodies
        .iter()
        .map(|(name, table)| check_body(file, name, table, files, air, time))
        .collect()
}

/// A body's name and table, for messages.
struct Written<'a> {
    key: String,
    table: &'a file::Body,
}

impl Written<'_> {
    fn key(&self, name: &str) -> String {
        format!("{}.{name}", self.key)
    }
}

fn check_body(
    file: &File,
    name: &str,
    table: &file::Body,
    files: &mut FromFiles,
    air: &Air,
    time: &Time,
) -> Result<RigidBody, Problem> {
    let written = Written {
        key: format!("bodies.{name}"),
        table,
    };
    check_name("bodies", name, "a body")?;
    let place_m = table
        .position_m
        .ok_or_else(|| usual_box::unknown_place(&written.key("position_m")))?;
    let position_m = vector(&written.key("position_m"), place_m)?;
    let cell = air.units.cell_size_m;
    let (shape, mut surface) = check_shape(&written, files, EDGE_CELLS * cell)?;
    let rotation = values::rotation(&written.key("rotation"), table.rotation.as_ref())?;
    for place in &mut surface.positions_m {
        *place = position_m + rotation * *place;
    }
    let coupling = file.coupling.as_ref();
    let links = coupling.is_some_and(|c| c.scheme == Some(Scheme::Links));
    let inset = |key: &str, value: Option<f64>, usual_cells: f64| {
        if links {
            // The surface itself cuts links.
            return Ok(0.0);
        }
        within(key, usual::or(key, value, usual_cells), -1.0, 1.0)
    };
    let whole_markers = rigid::inset(
        &surface,
        cell * inset(
            "coupling.surface_inset_cells",
            coupling.and_then(|c| c.surface_inset_cells),
            SURFACE_INSET_CELLS,
        )?,
        cell * inset(
            "coupling.rim_inset_cells",
            coupling.and_then(|c| c.rim_inset_cells),
            RIM_INSET_CELLS,
        )?,
    )
    .ok_or_else(|| {
        Problem::new(
            written.key.as_str(),
            format!("cells of {cell} m are too large for the body `{name}`: its parts are about as thin as a cell"),
            "choose smaller cells, or model thin parts as open surfaces",
        )
    })?;
    let motion = match &table.motion {
        Some(motion) => motion::check(&written.key("motion"), motion, position_m, time)?,
        None => PrescribedMotion::held(),
    };
    let closed = surface.is_closed();
    let permeability = check_permeability(&written, closed, file, air.units.density_kg_m3)?;
    let passing = Passing {
        key: &written.key("position_m"),
        name,
        from_file: matches!(shape, Shape::Mesh),
        held: !motion.moves(),
        falls: file.air.as_ref().is_some_and(|air| air.descent.is_some()),
    };
    let inside = through_faces::inside(passing, surface, whole_markers, air)?;
    let own_area_m2 = shape.area_m2().map(|area| area * inside.frontal_share);
    let reference_area_m2 = reference(&written, "area_m2", |r| r.area_m2, own_area_m2)?;
    let mut body = RigidBody {
        name: name.to_owned(),
        normal: rotation * DVec3::X,
        shape,
        volume_m3: closed.then_some(inside.volume_m3),
        blocking_area_m2: match shape {
            // Their triangles have a little less.
            Shape::Sphere { diameter_m } if inside.faces.is_empty() => {
                0.25 * PI * diameter_m * diameter_m
            }
            Shape::Disk { diameter_m } if inside.faces.is_empty() => {
                0.25 * PI * diameter_m * diameter_m * (rotation * DVec3::X).x.abs()
            }
            Shape::Mesh => frontal_area_m2(&inside.surface),
            _ => inside.surface.frontal_area_m2(),
        },
        surface: inside.surface,
        marker_surface: inside.marker_surface,
        faces: inside.faces,
        motion,
        fastest_m_s: 0.0,
        reference_area_m2,
        reference_length_m: reference(&written, "length_m", |r| r.length_m, shape.length_m())?,
        moment_point_m: match table.reference.as_ref().and_then(|r| r.moment_point_m) {
            Some(point) => vector(&written.key("reference.moment_point_m"), point)?,
            None => usual::noted(
                written.key("reference.moment_point_m"),
                position_m.to_array(),
            )
            .into(),
        },
        permeability,
    };
    body.fastest_m_s = check_way(&written, &body, air, time)?;
    Ok(body)
}

/// Area that a mesh shows to the wind: that of its shadow where parts of it stand one behind another, by more than the grid errs on which the shadow is counted [m²].
fn frontal_area_m2(surface: &Surface) -> f64 {
    let of_faces = surface.frontal_area_m2();
    let shadow = projected_area_m2(&surface.positions_m, surface.triangles.iter().copied());
    let (low, high) = surface.bounds_m();
    let (width, height) = (high.y - low.y, high.z - low.z);
    // A sample more or less along every side.
    let may_err = width.max(height) / RESOLUTION as f64 * (width + height);
    if shadow < of_faces - may_err {
        shadow
    } else {
        of_faces
    }
}

/// Only open surfaces may be permeable, and only in one pass, with which the law of the surface is solved.
fn check_permeability(
    written: &Written,
    closed: bool,
    file: &File,
    density_kg_m3: f64,
) -> Result<Option<Permeability>, Problem> {
    let Some(table) = &written.table.permeability else {
        return Ok(None);
    };
    let key = written.key("permeability");
    if closed {
        return Err(Problem::new(
            key.as_str(),
            format!("{key}: a closed body keeps the air inside it, which would have nowhere to go"),
            "make the body an open surface (disk, plate, open cylinder or mesh), or remove its permeability",
        ));
    }
    let passes = file.coupling.as_ref().and_then(|c| c.passes);
    if usual::or("coupling.passes", passes, 1) > 1 {
        return Err(Problem::new(
            "coupling.passes",
            format!(
                "coupling.passes is given, but [{key}] is solved together with the force of a single pass"
            ),
            "remove coupling.passes, or the permeability",
        ));
    }
    permeability::check(&key, table, None, density_kg_m3).map(Some)
}

fn reference(
    written: &Written,
    name: &str,
    pick: fn(&file::Reference) -> Option<f64>,
    own: Option<f64>,
) -> Result<f64, Problem> {
    let key = written.key(&format!("reference.{name}"));
    match (written.table.reference.as_ref().and_then(pick), own) {
        (Some(value), _) => positive(&key, value),
        (None, Some(own)) => Ok(usual::noted(key, own)),
        (None, None) => Err(Problem::new(
            key.as_str(),
            format!("{key} is missing: a mesh has no area or length of its own to refer to"),
            format!("add [{}.reference] with area_m2 and length_m", written.key),
        )),
    }
}

fn check_shape(
    written: &Written,
    files: &mut FromFiles,
    edge_m: f64,
) -> Result<(Shape, Surface), Problem> {
    let table = written.table;
    let size = |name: &str, value: f64| positive(&written.key(name), value);
    let shape = match (
        &table.sphere,
        &table.disk,
        &table.plate,
        &table.cylinder,
        &table.wing,
        &table.mesh,
    ) {
        (Some(sphere), None, None, None, None, None) => Shape::Sphere {
            diameter_m: size("sphere.diameter_m", sphere.diameter_m)?,
        },
        (None, Some(disk), None, None, None, None) => Shape::Disk {
            diameter_m: size("disk.diameter_m", disk.diameter_m)?,
        },
        (None, None, Some(plate), None, None, None) => Shape::Plate {
            size_m: [
                size("plate.size_m", plate.size_m[0])?,
                size("plate.size_m", plate.size_m[1])?,
            ],
        },
        (None, None, None, Some(cylinder), None, None) => Shape::Cylinder {
            diameter_m: size("cylinder.diameter_m", cylinder.diameter_m)?,
            length_m: size("cylinder.length_m", cylinder.length_m)?,
            closed: cylinder.closed,
        },
        (None, None, None, None, Some(wing), None) => {
            let drawn = body_wing::check(&written.key("wing"), wing, files.folder, edge_m)?;
            let shape = Shape::Wing {
                area_m2: drawn.area_m2,
                chord_m: drawn.chord_m,
            };
            return Ok((shape, drawn.surface));
        }
        (None, None, None, None, None, Some(mesh)) => {
            let cell_size_m = edge_m / EDGE_CELLS;
            let (surface, examined) =
                read_mesh(&written.key("mesh"), mesh, files.folder, Some(cell_size_m))?;
            examined.refuse()?;
            files.meshes.push(examined);
            return Ok((Shape::Mesh, surface));
        }
        _ => {
            return Err(Problem::new(
                written.key.as_str(),
                format!("[{}] needs exactly one shape", written.key),
                "keep or add just one of sphere, disk, plate, cylinder, wing, mesh",
            ));
        }
    };
    let area_m2 = shape.surface_area_m2().unwrap_or(0.0);
    if area_m2 / (edge_m * edge_m) > 0.5 * TRIANGLE_LIMIT {
        return Err(Problem::new(
            written.key.as_str(),
            format!(
                "the surface of {area_m2} m² is too large for cells of {:e} m",
                edge_m / EDGE_CELLS
            ),
            "choose larger cells or a smaller body",
        ));
    }
    let surface = match shape {
        Shape::Sphere { diameter_m } => surfaces::sphere(0.5 * diameter_m, edge_m),
        Shape::Disk { diameter_m } => surfaces::disk(0.5 * diameter_m, edge_m),
        Shape::Plate { size_m } => surfaces::plate(size_m, edge_m),
        Shape::Cylinder {
            diameter_m,
            length_m,
            closed,
        } => surfaces::cylinder(0.5 * diameter_m, length_m, closed, edge_m),
        Shape::Wing { .. } | Shape::Mesh => Surface::default(),
    };
    Ok((shape, surface))
}

/// Reads, joins and examines a mesh.
pub(super) fn read_mesh(
    key: &str,
    mesh: &file::SurfaceFile,
    folder: &Path,
    cell_size_m: Option<f64>,
) -> Result<(Surface, ExaminedMesh), Problem> {
    let path = folder.join(&mesh.file);
    let scale = positive(&format!("{key}.scale"), mesh.scale)?;
    let unreadable = |why: String| {
        Problem::new(
            format!("{key}.file"),
            format!("cannot read the mesh {}: {why}", path.display()),
            "give an OBJ, STL or PLY file with triangles or polygons, relative to the case file",
        )
    };
    let surface = surface::read(&path, scale).map_err(unreadable)?;
    let wished = (mesh.weld_tolerance_m, mesh.orient_triangles);
    let prepared = mesh_examination::prepared(key, wished, surface)?;
    let welded = &prepared.welded;
    if let Some(triangle) = surface::without_area(&welded.surface) {
        let number = welded.triangle_numbers[triangle] + 1;
        return Err(unreadable(format!(
            "triangle {number} encloses no area; remove or repair it"
        )));
    }
    let examined = ExaminedMesh::of_body(key, &path, &prepared, &mesh.accept, cell_size_m);
    Ok((prepared.welded.surface, examined))
}

/// Speed of a body's fastest point [m/s]; refuses bodies that leave the air or outrun the coupling.
fn check_way(written: &Written, body: &RigidBody, air: &Air, time: &Time) -> Result<f64, Problem> {
    let size = air.box_m();
    let margin = REACH_CELLS * air.units.cell_size_m;
    let mut walls = BoxFace::ALL.to_vec();
    walls.retain(|wall| !body.faces.contains(wall));
    let (mut fastest, mut when) = (0.0, 0.0);
    for t in body.motion.looks_s(time.end_s, LOOKS) {
        let placement = body.motion.at(t);
        for &point in &body.surface.positions_m {
            let place = placement.position_m(point);
            if walls.iter().any(|wall| wall.depth_m(place, size) < margin) {
                let remedy = if body.motion.moves() {
                    "move the body, enlarge the tunnel (air.wind_tunnel.size_m), or end sooner (time.end_s)"
                } else {
                    "move the body, or enlarge the tunnel (air.wind_tunnel.size_m); one that is meant to pass through a side or the outlet must reach \
                     two cells beyond it or more"
                };
                // Whoever brings a mesh may have another unit in mind.
                let (unit, large) = match body.shape {
                    // Of one that passes through a face its part in the box is known here.
                    Shape::Mesh if !body.faces.is_empty() => {
                        ("; check the unit of its file (mesh.scale)", String::new())
                    }
                    Shape::Mesh => {
                        let (low, high) = body.surface.bounds_m();
                        let own = high - low;
                        (
                            "; check the unit of its file (mesh.scale)",
                            format!("; it is {:.4} × {:.4} × {:.4} m large", own.x, own.y, own.z),
                        )
                    }
                    _ => ("", String::new()),
                };
                return Err(Problem::new(
                    written.key("position_m"),
                    format!(
                        "the body `{}` does not fit: at t = {t:.4} s it reaches ({:.4}, {:.4}, {:.4}) m, outside or within two \
                         cells of the walls of the tunnel of {:.4} × {:.4} × {:.4} m{large}",
                        body.name, place.x, place.y, place.z, size.x, size.y, size.z
                    ),
                    format!("{remedy}{unit}"),
                ));
            }
            let speed = placement.velocity_m_s(point).length();
            // What turns evenly is as fast at all instants, but for round-off.
            if speed > fastest * (1.0 + 1e-9) {
                (fastest, when) = (speed, t);
            }
        }
    }
    let motion = fastest / air.units.speed_m_s();
    if motion >= MARKER_MOTION_LIMIT {
        return Err(Problem::new(
            written.key("motion"),
            format!(
                "the body `{}` moves {motion:.3} cells in a step at t = {when:.4} s ({fastest:.3} m/s): the coupling is meant for less \
                 than {MARKER_MOTION_LIMIT}",
                body.name
            ),
            format!(
                "lower resolution.lattice_speed to {:.3} or less, or raise resolution.reference_speed_m_s, or move the body slower",
                0.99 * air.lattice_speed * MARKER_MOTION_LIMIT / motion
            ),
        ));
    }
    Ok(fastest)
}

impl Shape {
    /// Usual reference area: what the shape shows to the wind at its largest, of a wing that of the chords [m²]; `None` for a mesh.
    #[must_use]
    pub fn area_m2(self) -> Option<f64> {
        match self {
            Self::Sphere { diameter_m } | Self::Disk { diameter_m } => {
                Some(0.25 * PI * diameter_m * diameter_m)
            }
            Self::Plate { size_m } => Some(size_m[0] * size_m[1]),
            Self::Cylinder {
                diameter_m,
                length_m,
                ..
            } => Some(diameter_m * length_m),
            Self::Wing { area_m2, .. } => Some(area_m2),
            Self::Mesh => None,
        }
    }

    /// Usual reference length: diameter, the plate's smaller side, or the wing's mean chord [m]; `None` for a mesh.
    #[must_use]
    pub fn length_m(self) -> Option<f64> {
        match self {
            Self::Sphere { diameter_m }
            | Self::Disk { diameter_m }
            | Self::Cylinder { diameter_m, .. } => Some(diameter_m),
            Self::Plate { size_m } => Some(size_m[0].min(size_m[1])),
            Self::Wing { chord_m, .. } => Some(chord_m),
            Self::Mesh => None,
        }
    }

    fn surface_area_m2(self) -> Option<f64> {
        match self {
            Self::Cylinder { diameter_m, .. } => self
                .area_m2()
                .map(|a| PI * a + 0.5 * PI * diameter_m * diameter_m),
            _ => self.area_m2().map(|a| 4.0 * a),
        }
    }
}
