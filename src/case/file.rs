//! Mirror of a case file: what may be written, in SI units with the unit in the key. What is absent is not simulated.

use std::collections::BTreeMap;

use serde::Deserialize;

pub use super::file_bodies::*;
pub use super::file_canopy::*;
pub use super::file_comparison::*;
pub use super::file_descent::*;
pub use super::file_permeability::*;
pub use super::file_plate::*;
pub use super::file_specimens::*;
pub use super::file_supports::*;
pub use super::file_trim::*;
pub use super::file_wing::*;
pub use super::file_wing_design::*;
use crate::frame::{FabricQuantity, FlowQuantity};
use crate::geometry::mesh::doctor::Kind;
use crate::geometry::sheet::FabricModel;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosityModel;

/// A case file, version 1.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Format of the file; must be 1.
    pub version: u32,
    /// One line for reports and pictures.
    pub title: Option<String>,
    /// The air; absent: none.
    pub air: Option<Air>,
    /// Lattice of the air.
    pub resolution: Option<Resolution>,
    /// What hangs or flies.
    pub structure: Option<StructureTable>,
    /// Rigid bodies, by name.
    #[serde(default)]
    pub bodies: BTreeMap<String, BodyTable>,
    /// Held nodes that are moved, by name.
    #[serde(default)]
    pub supports: BTreeMap<String, SupportTable>,
    /// Fabric of the structure.
    pub fabric: Option<Fabric>,
    /// Suspension lines.
    pub lines: Option<Lines>,
    /// Belts sewn on the seams; absent: none.
    pub belts: Option<CableMaterial>,
    /// Band along the lower edge of a canopy; absent: none.
    pub skirt_band: Option<CableMaterial>,
    /// Band around the vent; absent: none.
    pub vent_band: Option<CableMaterial>,
    /// Lines across the vent; absent: of the suspension lines' material.
    pub vent_lines: Option<CableMaterial>,
    /// Contact of fabric with itself; absent: it passes through itself.
    pub contact: Option<ContactTable>,
    /// Gravity; absent: none.
    pub gravity: Option<Gravity>,
    /// What hangs on the canopy and falls with it; absent: the confluence is held.
    pub payload: Option<PayloadTable>,
    /// Coupling of air and fabric.
    pub coupling: Option<Coupling>,
    /// Solver of the fabric.
    pub solver: Option<Solver>,
    /// Simulated time; absent: no motion, only the equilibrium.
    pub time: Option<Time>,
    /// Static equilibrium, sought after the motion if there is one; absent: none.
    pub equilibrium: Option<Equilibrium>,
    /// Stop when the drag is known well enough; absent: run to the end.
    pub steady: Option<Steady>,
    /// What to write and how often.
    pub output: Option<Output>,
    /// Values of others, by the names of results.
    #[serde(default)]
    pub comparison: BTreeMap<String, ComparisonTable>,
    /// Named changes to this case, e.g. a quick version.
    #[serde(default)]
    pub variants: BTreeMap<String, toml::Table>,
}

impl File {
    /// Other files that the case takes its structure and bodies from, relative to its own.
    pub(super) fn named_files(&self) -> Vec<&str> {
        let of_bodies = self.bodies.values().filter_map(|body| body.mesh.as_ref());
        let mut found: Vec<&str> = of_bodies.map(|mesh| mesh.file.as_str()).collect();
        let Some(structure) = &self.structure else {
            return found;
        };
        if let Some(mesh) = &structure.mesh {
            found.push(&mesh.file);
            found.extend(mesh.start_file.as_deref());
            found.extend(mesh.lines.as_deref());
        }
        found.extend(structure.lep_sim.iter().map(|wing| wing.file.as_str()));
        let profiles = structure
            .wing
            .iter()
            .flat_map(|wing| wing.profiles.values());
        found.extend(profiles.filter_map(|profile| profile.file.as_deref()));
        found
    }
}

/// `[air]`; exactly one flow inside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Air {
    /// Or an altitude.
    pub density_kg_m3: Option<f64>,
    pub kinematic_viscosity_m2_s: f64,
    pub descent: Option<Descent>,
    pub wind_tunnel: Option<WindTunnel>,
    pub taylor_green: Option<TaylorGreen>,
}

/// `[air.wind_tunnel]`: wind along +x between frictionless walls.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct WindTunnel {
    pub speed_m_s: f64,
    pub size_m: [f64; 3],
    pub start_time_s: f64,
    pub sponge_length_m: Option<f64>,
}

/// `[air.taylor_green]`: a periodic box of decaying vortices.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct TaylorGreen {
    pub speed_m_s: f64,
    pub side_m: f64,
    pub depth_m: f64,
}

/// `[resolution]`; exactly one of the first three keys.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Resolution {
    pub cells_per_diameter: Option<f64>,
    /// Of a wing.
    pub cells_per_chord: Option<f64>,
    pub cell_size_m: Option<f64>,
    pub lattice_speed: f64,
    pub reference_speed_m_s: Option<f64>,
    pub operator: Operator,
    pub eddy_viscosity: Option<EddyViscosity>,
    /// Of all that stands in the air, against the lattice.
    pub shift_cells: Option<[f64; 3]>,
}

/// `[resolution.eddy_viscosity]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct EddyViscosity {
    pub model: EddyViscosityModel,
    pub constant: f64,
    pub update_every: Option<u32>,
}

/// `[structure]`; exactly one shape inside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct StructureTable {
    pub flat_circular: Option<FlatCircular>,
    pub conical: Option<Conical>,
    pub slotted: Option<Slotted>,
    pub extended_skirt: Option<ExtendedSkirt>,
    pub annular: Option<Annular>,
    pub disk_gap_band: Option<DiskGapBand>,
    pub cruciform: Option<Cruciform>,
    pub sheet: Option<Sheet>,
    pub plate: Option<Plate>,
    pub cable: Option<HangingCable>,
    pub mesh: Option<MeshFile>,
    pub lep_sim: Option<LepSimTable>,
    pub airbag: Option<Airbag>,
    pub disc: Option<Disc>,
    pub coupon: Option<Coupon>,
    pub wing: Option<WingTable>,
}

impl StructureTable {
    /// True for a parachute canopy that is drawn here.
    #[must_use]
    pub const fn is_drawn_canopy(&self) -> bool {
        self.flat_circular.is_some()
            || self.conical.is_some()
            || self.slotted.is_some()
            || self.extended_skirt.is_some()
            || self.annular.is_some()
            || self.disk_gap_band.is_some()
            || self.cruciform.is_some()
    }

    /// True for a parachute canopy, drawn here or from a mesh with a nominal area.
    #[must_use]
    pub fn is_canopy(&self) -> bool {
        let of_mesh = self
            .mesh
            .as_ref()
            .is_some_and(|mesh| mesh.nominal_area_m2.is_some());
        self.is_drawn_canopy() || of_mesh
    }
}

/// `[structure.sheet]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Sheet {
    pub size_m: [f64; 2],
    pub divisions: [usize; 2],
    pub model: FabricModel,
    pub corner_m: [f64; 3],
    pub hung_width_m: f64,
}

/// `[structure.cable]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct HangingCable {
    pub ends_m: [[f64; 3]; 2],
    pub length_m: f64,
    pub segments: usize,
    pub material: CableMaterial,
}

/// `[structure.mesh]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct MeshFile {
    pub file: String,
    pub scale: f64,
    pub held_nodes: Vec<u32>,
    /// Vertices nearer than this are joined; 0 if absent.
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours.
    #[serde(default)]
    pub orient_triangles: bool,
    /// Findings that are meant.
    #[serde(default)]
    pub accept: Vec<Kind>,
    /// The same triangles where they are at the start.
    pub start_file: Option<String>,
    /// Where the file's origin is.
    pub position_m: Option<[f64; 3]>,
    /// Of all that the files name, about their origin.
    pub rotation: Option<Rotation>,
    /// Makes it a parachute canopy.
    pub nominal_area_m2: Option<f64>,
    /// A table of lines, with their material.
    pub lines: Option<String>,
    pub line_material: Option<CableMaterial>,
}

/// `[fabric]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Fabric {
    pub thickness_m: f64,
    pub density_kg_m3: f64,
    pub youngs_modulus_pa: f64,
    pub weft_youngs_modulus_pa: Option<f64>,
    pub poisson_ratio: f64,
    pub shear_modulus_pa: Option<f64>,
    pub cubic_shear_compliance_1_pa3: Option<f64>,
    pub residual_stiffness: Option<f64>,
    pub initial_strain: Option<[f64; 2]>,
    pub yield_stress_pa: Option<f64>,
    pub permeability: Option<PermeabilityTable>,
}

/// A cable material.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct CableMaterial {
    pub area_m2: f64,
    pub density_kg_m3: f64,
    /// Or a table.
    pub youngs_modulus_pa: Option<f64>,
    pub force_strain: Option<Vec<[f64; 2]>>,
    pub damping_n_s: Option<f64>,
}

/// `[contact]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct ContactTable {
    pub thickness_m: f64,
}

/// `[gravity]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Gravity {
    pub acceleration_m_s2: [f64; 3],
}

/// `[coupling]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Coupling {
    pub over_relaxation: f64,
    /// Only with fabric.
    pub structure_every: Option<u32>,
    /// Passes of multi-direct forcing; only without fabric.
    pub passes: Option<u32>,
    /// How far markers stand inside closed rigid surfaces.
    pub surface_inset_cells: Option<f64>,
    /// How far markers stand inside the rims of open ones, and of plates of fabric.
    pub rim_inset_cells: Option<f64>,
    /// Largest distance of neighbouring markers.
    pub marker_spacing_cells: Option<f64>,
    /// Multiplies the mass of fabric and cables, to study light and heavy sheets.
    pub mass_factor: Option<f64>,
}

/// `[solver]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Solver {
    pub tolerance: Option<f64>,
    pub evaluation_limit: Option<usize>,
    pub damping_1_s: Option<f64>,
    pub allow_unsolved: Option<bool>,
}

/// `[time]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Time {
    pub end_s: f64,
    /// Only without air, which has its own step.
    pub step_s: Option<f64>,
    /// Divides steps as accuracy asks for; only without air; absent: every step is solved at once.
    pub adaptive: Option<AdaptiveTable>,
}

/// `[time.adaptive]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct AdaptiveTable {
    pub tolerance_m: f64,
    pub smallest_step_s: f64,
}

/// `[equilibrium]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Equilibrium {
    pub tolerance: f64,
    pub evaluation_limit: usize,
    pub pressure_pa: Option<f64>,
    /// Per cell and chord place.
    pub wing_pressure: Option<WingPressureTable>,
    /// Steady glide of a wing.
    pub trim: Option<TrimTable>,
    /// Its loads, or the prescribed ones, several times over.
    pub load_test: Option<LoadTestTable>,
    /// Widths of panels that fly as they were designed.
    pub panel_shaping: Option<PanelShapingTable>,
}

/// `[steady]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Steady {
    pub drag_confidence: f64,
    pub grid_sequence: Option<Vec<f64>>,
}

/// `[output]`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Output {
    pub sample_interval_s: Option<f64>,
    pub canopy_interval_s: Option<f64>,
    pub bodies_interval_s: Option<f64>,
    pub flow_interval_s: Option<f64>,
    pub picture_times_s: Option<Vec<f64>>,
    pub picture_fabric: Option<Vec<FabricQuantity>>,
    pub picture_flow: Option<Vec<FlowQuantity>>,
    /// Of the air's velocity.
    pub picture_arrows: Option<bool>,
    pub animation_interval_s: Option<f64>,
    /// Panels of a wing laid flat.
    pub wing_panels: Option<bool>,
    pub history_plots: Option<bool>,
}
