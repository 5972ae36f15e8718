//! The checked scene: SI units, every value in its range, absent things `None`.

use std::path::Path;

use glam::DVec3;

pub use super::comparison::Comparison;
pub use super::descent::{Carrier, Descent};
use super::file::{self, File};
use super::lep_sim::ImportedWing;
pub use super::mesh_examination::ExaminedMesh;
use super::mesh_examination::FromFiles;
pub use super::payload_bodies::PayloadBody;
pub use super::supports::Support;
pub use super::time::{AdaptiveStep, Time};
use super::values::{PLAUSIBLE, at_least_one};
pub(super) use super::values::{absent, positive, readable, vector, within};
use super::wing::{self, Wing};
use super::{
    Problem, air, bodies, comparison, descent, output, shift, steady, structure, supports, time,
    usual,
};
use crate::cloth::Structure;
pub use crate::cloth::openings::{Opening, OpeningKind};
use crate::cloth::rims::RimInsets;
use crate::fabric::permeability::Permeability;
use crate::frame::{FabricQuantity, FlowQuantity};
use crate::geometry::mesh::quality::Quality;
use crate::geometry::parachute::shape;
use crate::geometry::plate::Plate;
use crate::immersed::markers;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::rigid::{PrescribedMotion, Surface};
use crate::units::Units;

/// Everything that a run needs to know.
#[derive(Debug, Clone)]
pub struct Scene {
    /// One line for reports and pictures.
    pub title: String,
    /// The air.
    pub air: Option<Air>,
    /// Fabric and cables.
    pub body: Option<Body>,
    /// What is known of the structure if it is a wing.
    pub wing: Option<Wing>,
    /// What is known of the structure if it is a wing of another program.
    pub imported: Option<ImportedWing>,
    /// What the meshes of others in the case are made of.
    pub meshes: Vec<ExaminedMesh>,
    /// Rigid bodies in the air, by name.
    pub rigid_bodies: Vec<RigidBody>,
    /// Held nodes that are moved.
    pub supports: Vec<Support>,
    /// Coupling of the air with fabric and bodies; present if there is something to couple.
    pub coupling: Option<Coupling>,
    /// Gravity [m/s²].
    pub gravity_m_s2: Option<DVec3>,
    /// What falls, and the box of the air with it; absent: the box stands.
    pub descent: Option<Descent>,
    /// Solver of the fabric.
    pub solver: Solver,
    /// Simulated time; absent: equilibrium only.
    pub time: Option<Time>,
    /// Static equilibrium.
    pub equilibrium: Option<Equilibrium>,
    /// Relative half width of the 95 % interval of the mean drag at which the run may stop.
    pub steady_drag_confidence: Option<f64>,
    /// What to write.
    pub output: Output,
    /// Values of others that results are set beside.
    pub comparisons: Vec<Comparison>,
}

/// The air.
#[derive(Debug, Clone, Copy)]
pub struct Air {
    /// Scales.
    pub units: Units,
    /// Kinematic viscosity [m²/s].
    pub kinematic_viscosity_m2_s: f64,
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Speed that is `lattice_speed` on the lattice [m/s].
    pub reference_speed_m_s: f64,
    /// Cells per step at the reference speed.
    pub lattice_speed: f64,
    /// Collision operator.
    pub operator: Operator,
    /// Eddy viscosity; `None` without one.
    pub eddy_viscosity: Option<EddyViscosity>,
    /// What the air does.
    pub flow: Flow,
}

impl Air {
    /// Wind speed, to which coefficients and times refer; without wind the speed that the lattice is scaled with [m/s].
    #[must_use]
    pub const fn wind_or_reference_m_s(&self) -> f64 {
        match self.flow {
            Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0 => speed_m_s,
            _ => self.reference_speed_m_s,
        }
    }
}

/// What the air does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flow {
    /// Wind along +x between frictionless walls.
    WindTunnel {
        /// Wind speed [m/s].
        speed_m_s: f64,
        /// Time in which the wind rises, before t = 0 [s].
        start_time_s: f64,
        /// Length of the viscous sponge before the outlet [m].
        sponge_length_m: Option<f64>,
    },
    /// Decaying Taylor–Green vortices in a periodic box.
    TaylorGreen {
        /// Largest initial speed [m/s].
        speed_m_s: f64,
        /// Period along x and y [m].
        side_m: f64,
    },
}

/// Fabric and cables with what reports need to know of them.
#[derive(Debug, Clone)]
pub struct Body {
    /// The structure at its start.
    pub structure: Structure,
    /// Quality of the fabric's mesh at rest.
    pub quality: Option<Quality>,
    /// What kind of structure it is.
    pub kind: BodyKind,
}

impl Body {
    /// Share of the fabric's area that has markers: those near rims end inside them.
    #[must_use]
    pub fn marked_share(&self, insets: &RimInsets) -> f64 {
        markers::marked_share(self.structure.extents(insets))
    }

    /// True for a canopy from a mesh file.
    #[must_use]
    pub const fn is_from_mesh(&self) -> bool {
        matches!(self.kind, BodyKind::Canopy(Canopy { loading: None, .. }))
    }

    /// Projected diameter of this canopy over the nominal one as it is released: opened by pressure, or as its mesh stands.
    #[must_use]
    pub fn released_diameter_ratio(&self, canopy: &Canopy) -> f64 {
        canopy.loading.map_or_else(
            || {
                let triangles = self.structure.triangles.iter().map(|t| t.nodes);
                shape::projected_diameter_m(&self.structure.positions_m, triangles)
                    / canopy.nominal_diameter_m
            },
            |loading| loading.opened_diameter_ratio,
        )
    }
}

/// Kinds of structures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BodyKind {
    /// A parachute canopy.
    Canopy(Canopy),
    /// A sheet of fabric.
    Sheet,
    /// A plate of fabric, held along one edge.
    Plate(Plate),
    /// A hanging cable between two ends.
    Cable {
        /// Distance of the ends [m].
        span_m: f64,
        /// Rest length [m].
        length_m: f64,
        /// Weight per length [N/m].
        weight_n_m: f64,
    },
    /// A mesh from a file.
    Mesh,
    /// A square airbag.
    Airbag {
        /// Nodes in the middle of the upper and of the lower sheet.
        middles: [u32; 2],
    },
    /// A strip that is pulled.
    Coupon(Coupon),
    /// A ram-air wing; [`Scene::wing`] holds more.
    Wing,
    /// A wing from a file of another program; [`Scene::imported`] holds more.
    ImportedWing,
}

/// What is measured on a strip that is pulled along x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupon {
    /// Width times thickness [m²].
    pub cross_section_m2: f64,
    /// Nodes whose distance is measured.
    pub gauge: [u32; 2],
    /// Their distance at rest [m].
    pub gauge_length_m: f64,
}

/// What is measured on a canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Canopy {
    /// Nominal area S₀ [m²].
    pub nominal_area_m2: f64,
    /// Nominal diameter D₀ [m].
    pub nominal_diameter_m: f64,
    /// Nodes of fabric, which come first; then the confluence, or where the lines of a mesh end, then others.
    pub canopy_node_count: usize,
    /// Node farthest from the skirt; means nothing where there is a vent.
    pub apex: usize,
    /// Node that is held or carries the payload: the confluence, or the lower end of the riser. `None`: the lines of a mesh end in
    /// several places, and all are held.
    pub lower_end: Option<usize>,
    /// How the folded canopy is opened before the wind starts; `None`: it starts as its mesh stands.
    pub loading: Option<LoadingPressure>,
}

impl Canopy {
    /// Where the lines meet, or the middle of where those of a mesh end, for the positions of all nodes \[m\].
    #[must_use]
    pub fn confluence_m(&self, positions_m: &[DVec3]) -> DVec3 {
        let ends = &positions_m[self.canopy_node_count..];
        let count = if self.lower_end.is_some() {
            1
        } else {
            ends.len()
        };
        ends[..count].iter().sum::<DVec3>() / count as f64
    }
}

/// Opening of a folded canopy by pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadingPressure {
    /// Pressure inside [Pa].
    pub pressure_pa: f64,
    /// Projected-diameter ratio to which it opens the canopy.
    pub opened_diameter_ratio: f64,
}

/// A rigid body.
#[derive(Debug, Clone)]
pub struct RigidBody {
    /// Its name in the case.
    pub name: String,
    /// What it is.
    pub shape: Shape,
    /// Normal of a disk or plate before it moves.
    pub normal: DVec3,
    /// Its surface before it moves.
    pub surface: Surface,
    /// The surface that markers stand on, a little inside; the same triangles.
    pub marker_surface: Surface,
    /// How it moves.
    pub motion: PrescribedMotion,
    /// Volume and its centroid before the body moves, if the surface is closed [m³, m].
    pub volume_m3: Option<(f64, DVec3)>,
    /// Area that coefficients refer to [m²].
    pub reference_area_m2: f64,
    /// Length that the Reynolds number and coefficients of moments refer to [m].
    pub reference_length_m: f64,
    /// Point of the body that moments are about, before it moves [m].
    pub moment_point_m: DVec3,
    /// Permeability of the surface; `None`: no air passes.
    pub permeability: Option<Permeability>,
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
    /// A surface from a file.
    Mesh,
}

/// Coupling of air with fabric and rigid bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Over-relaxation a on a flat sheet.
    pub over_relaxation: f64,
    /// Steps of the air per step of the fabric, where the case gives them; otherwise the plan chooses.
    pub structure_every: Option<u32>,
    /// Passes of multi-direct forcing; 1 unless all is rigid.
    pub passes: u32,
    /// Largest distance of neighbouring markers [cells].
    pub marker_spacing_cells: f64,
    /// How far inside rims markers stand [cells].
    pub rim_inset_cells: f64,
    /// Steps over which a running mean of u* is taken before the fabric feels it; 1 unless schemes are compared.
    pub averaging_steps: u32,
}

impl Coupling {
    /// Largest spacing of markers on a triangle [m].
    #[must_use]
    pub fn marker_spacing_m(&self, air: &Air) -> f64 {
        self.marker_spacing_cells * air.units.cell_size_m
    }

    /// How far inside the rims of fabric markers stand.
    #[must_use]
    pub fn rim_insets(&self, structure: &Structure, air: &Air) -> RimInsets {
        RimInsets::new(structure, self.rim_inset_cells, air.units.cell_size_m)
    }
}

/// Solver of the fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Tolerance of one step, relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed in one step.
    pub evaluation_limit: usize,
    /// Mass-proportional damping [1/s].
    pub damping_1_s: f64,
    /// Solves that miss their tolerance do not make a run count as out of balance.
    pub allow_unsolved: bool,
}

/// Static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium {
    /// Tolerance relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed.
    pub evaluation_limit: usize,
    /// Pressure jump along the triangle normals, which follows the fabric \[Pa\]; `None`: none.
    pub pressure_pa: Option<f64>,
}

/// What to write.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Panels of a wing laid flat.
    pub wing_panels: bool,
    /// Time between rows of `history.csv` [s].
    pub sample_interval_s: f64,
    /// Time between `canopy_*.vtp` files; absent: only the last.
    pub canopy_interval_s: Option<f64>,
    /// Time between `bodies_*.vtp` files; absent: only the last.
    pub bodies_interval_s: Option<f64>,
    /// Time between `flow_*.vti` files; absent: only the last.
    pub flow_interval_s: Option<f64>,
    /// Times of pictures besides the last [s].
    pub picture_times_s: Vec<f64>,
    /// What the fabric's colours show: one picture each.
    pub picture_fabric: Vec<FabricQuantity>,
    /// What the slice of air shows: one picture each.
    pub picture_flow: Vec<FlowQuantity>,
    /// Arrows of the air's velocity on the slice.
    pub picture_arrows: bool,
    /// Time between frames of `animation.png`; absent: none.
    pub animation_interval_s: Option<f64>,
    /// Charts of the history's main columns at the end.
    pub history_plots: bool,
}

/// What lines and bands belong to.
const DRAWN: &str = "a canopy drawn in the case (one from a mesh has structure.mesh.lines)";

/// Refuses tables that nothing in the case would read: a reader would take them for effective.
fn refuse_unused(file: &File) -> Result<(), Problem> {
    let of = |what: fn(&file::StructureTable) -> bool| file.structure.as_ref().is_some_and(what);
    let canopy = of(file::StructureTable::is_drawn_canopy);
    let fabric = file.structure.as_ref().is_some_and(|s| s.cable.is_none());
    let one_fabric = file
        .structure
        .as_ref()
        .is_some_and(|s| s.cable.is_none() && s.wing.is_none());
    for (key, present, used, what) in [
        ("lines", file.lines.is_some(), canopy, DRAWN),
        ("belts", file.belts.is_some(), canopy, DRAWN),
        ("skirt_band", file.skirt_band.is_some(), canopy, DRAWN),
        ("vent_band", file.vent_band.is_some(), canopy, DRAWN),
        ("vent_lines", file.vent_lines.is_some(), canopy, DRAWN),
        (
            "steady",
            file.steady.is_some(),
            file.air.is_some() && (of(file::StructureTable::is_canopy) || !file.bodies.is_empty()),
            "a canopy or a rigid body in wind",
        ),
        (
            "fabric",
            file.fabric.is_some(),
            one_fabric,
            "a structure of one fabric (a wing has [structure.wing.fabrics])",
        ),
        (
            "contact",
            file.contact.is_some(),
            fabric,
            "a structure with fabric",
        ),
        (
            "resolution",
            file.resolution.is_some(),
            file.air.is_some(),
            "[air]",
        ),
        (
            "gravity",
            file.gravity.is_some(),
            file.structure.is_some() || file.air.as_ref().is_some_and(|a| a.descent.is_some()),
            "[structure]",
        ),
        (
            "solver",
            file.solver.is_some(),
            file.structure.is_some(),
            "[structure]",
        ),
    ] {
        if present && !used {
            return Err(Problem::new(
                key,
                format!("[{key}] has no effect: it needs {what}"),
                format!("remove [{key}], or add {what}"),
            ));
        }
    }
    Ok(())
}

/// Checks a case.
pub fn check(file: &File, folder: &Path) -> Result<Scene, Problem> {
    if file.version != 1 {
        return Err(Problem::new(
            "version",
            format!("version = {} is not known", file.version),
            "this program reads version 1",
        ));
    }
    let gravity_m_s2 = file
        .gravity
        .as_ref()
        .map(|g| vector("gravity.acceleration_m_s2", g.acceleration_m_s2))
        .transpose()?;
    refuse_unused(file)?;
    let mut wing = wing::check(file, folder)?;
    let mut files = FromFiles::new(folder);
    let mut body = structure::check(file, &mut files, gravity_m_s2, wing.as_mut())?;
    let air = file
        .air
        .as_ref()
        .map(|air| air::check_air(file, air, body.as_ref()))
        .transpose()?;
    if air.is_none() && body.is_none() && file.bodies.is_empty() {
        return Err(Problem::new(
            "version",
            "the case holds neither air nor a structure: there is nothing to simulate",
            "add an [air] table, a [structure] table, or both",
        ));
    }
    let shift_m = shift::check(file, air.as_ref())?;
    shift::move_structure(shift_m, body.as_mut(), wing.as_mut());
    let file = &shift::with_moved_bodies(file, shift_m);
    let solver = check_solver(file)?;
    let time = time::check(file, air.as_ref())?;
    let supports = supports::check(file, body.as_ref(), time.as_ref(), &files)?;
    let rigid_bodies = bodies::check(file, &mut files, air.as_ref(), time.as_ref())?;
    let coupling = air::check_coupling(file, air.as_ref(), body.as_mut())?;
    let descent = descent::check(
        file,
        air.as_ref(),
        body.as_mut(),
        &rigid_bodies,
        gravity_m_s2,
    )?;
    let equilibrium = file
        .equilibrium
        .as_ref()
        .map(|e| {
            if air.is_some() {
                return Err(Problem::new(
                    "equilibrium",
                    "a static equilibrium is not defined in moving air",
                    "remove [equilibrium] or [air]",
                ));
            }
            Ok(Equilibrium {
                tolerance: within("equilibrium.tolerance", e.tolerance, 1e-12, 0.5)?,
                evaluation_limit: at_least_one("equilibrium.evaluation_limit", e.evaluation_limit)?,
                pressure_pa: e
                    .pressure_pa
                    .map(|p| within("equilibrium.pressure_pa", p, -PLAUSIBLE, PLAUSIBLE))
                    .transpose()?,
            })
        })
        .transpose()?;
    if time.is_none() && equilibrium.is_none() {
        return Err(absent(
            "time",
            "a run needs [time], or [equilibrium] for a structure without air",
        ));
    }
    let end_s = time.map_or(1.0, |t| t.end_s);
    let output = output::check(file, end_s)?;
    let steady_drag_confidence = steady::check(
        file,
        air.as_ref(),
        body.as_ref(),
        &rigid_bodies,
        descent.is_some(),
    )?;
    let title = usual::or("title", file.title.clone(), "untitled".to_owned());
    Ok(Scene {
        title,
        air,
        body,
        wing,
        imported: files.imported,
        meshes: files.meshes,
        rigid_bodies,
        supports,
        coupling,
        gravity_m_s2,
        descent,
        solver,
        time,
        equilibrium,
        steady_drag_confidence,
        output,
        comparisons: comparison::check(file)?,
    })
}

fn check_solver(file: &File) -> Result<Solver, Problem> {
    let written = file.solver.as_ref();
    let damping_1_s = written.and_then(|s| s.damping_1_s);
    let tolerance = written.and_then(|s| s.tolerance);
    let evaluation_limit = written.and_then(|s| s.evaluation_limit);
    let allow_unsolved = written.and_then(|s| s.allow_unsolved);
    let damping_1_s = usual::or("solver.damping_1_s", damping_1_s, 0.0);
    if !(damping_1_s >= 0.0 && damping_1_s.is_finite()) {
        return Err(Problem::new(
            "solver.damping_1_s",
            format!("solver.damping_1_s = {damping_1_s} must not be negative"),
            "damping takes energy out; give zero or a positive rate",
        ));
    }
    Ok(Solver {
        tolerance: within(
            "solver.tolerance",
            usual::or(
                "solver.tolerance",
                tolerance,
                descent::usual_tolerance(file),
            ),
            1e-12,
            0.5,
        )?,
        evaluation_limit: at_least_one(
            "solver.evaluation_limit",
            usual::or("solver.evaluation_limit", evaluation_limit, 2_000),
        )?,
        damping_1_s,
        allow_unsolved: usual::or("solver.allow_unsolved", allow_unsolved, false),
    })
}
