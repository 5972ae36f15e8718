//! Fabric and cables on the device, in `f32` with split positions; the stages of [`crate::cpu::cloth`].
//!
//! | file | holds |
//! |---|---|
//! | `elements` | the structure as words for the shaders; which slots every node gathers |
//! | `gathering` | nodal forces and initial Hessian: elements first, then nodes |
//! | `stiffness` | the whole Hessian, for multigrid; absent until a solve asks for it |
//! | `vectors` | the vector space that the minimisers work in |
//! | `decisions` | what decides on the device between two evaluations |
//! | `batches` | the minimiser of time steps that it decides |
//! | `slots` | numbers of vectors and points |
//! | `marker_reactions` | reactions of the air at markers, where the device has both |
//! | `motion` | from the end of one solve to the start of the next, on the device |
//! | `own_steps` | steps that the device makes without the host |
//! | `host_constants` | what shaders that decide know of the host's minimiser |
//! | `small_cloth` | the same for small fabric, in one workgroup |
//! | `cut_fabric` | reactions of the air at cut links, where the device has both and makes steps by itself |
//! | `curvature` | what Newton's method asks of it besides |
//! | `workspace` | its buffers and pipelines |
//! | `step_words` | what a step sends of elements |
//! | `solve_cloth` | the implicit step, or the static equilibrium |
//!
//! *Departures from the CPU*: displacements count from the prediction instead of from xⁿ, so that the velocity change,
//! which decides, is not the small difference of two large numbers; what that adds to the objective is constant or linear and is
//! put together on the host in `f64`. Elongations come from whole numbers (`shaders/elements.wgsl`), so strains are as fine as
//! positions, 5e-13 m over an edge, not as `f32`. Everything is computed in the same order every time: same bits on one device.
//!
//! *What single precision limits*: forces are rounded to 2⁻²⁴ of the tension T that they come from. Noise on a sheet of 10 mm mesh, 10 m
//! from the origin, is 2e-4 of the nodal load of 50 Pa. In a static equilibrium the energy norm cannot fall below that of this
//! rounding: for a hanging cable of stiffness EA about 2⁻²⁴ √(EA/T) of the loads' (4e-6 reached in `cases/cloth/hanging-chain.toml`, where
//! this is 8e-6), because the transverse part of the rounding moves a cable that only T holds, while the loads only stretch it.

mod batches;
mod curvature;
mod cut_fabric;
mod decisions;
mod elements;
mod gathering;
mod host_constants;
mod marker_reactions;
mod motion;
mod own_steps;
pub mod parameters;
mod points;
mod slots;
mod small_cloth;
mod solve_cloth;
mod step_words;
mod stiffness;
mod vectors;
mod workspace;

use std::sync::Arc;

use glam::DVec3;

use crate::cloth::Structure;
use crate::cpu::cloth::pressure::middle;
use crate::cpu::cloth::stiffness::graph;
use crate::cpu::cloth::{InitialHessian, SolverSettings, StepInput};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::multigrid::{Multigrid, Traffic};
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::{HISTORY, Options};
use crate::solve::multigrid::hierarchy::hierarchy;

use cut_fabric::CutFabric;
pub use cut_fabric::{AirScales, AtCuts, LinksInAir};
pub(super) use elements::split;
use elements::{CUT_WORDS, Elements, Triangles};
use gathering::Gathering;
use marker_reactions::MarkerPipelines;
pub use marker_reactions::{AtMarkers, MarkersInAir};
pub use motion::NodesOnDevice;
use motion::Series;
use parameters::ClothStage;
use points::PointSlot;
use slots::POINTS;
use stiffness::Stiffness;
use workspace::{Operations, Workspace};

/// A structure on the device.
#[derive(Debug)]
pub struct Cloth {
    device: Arc<Device>,
    nodes: usize,
    markers: Vec<(u32, [f64; 3])>,
    /// What they are besides fabric; faces once a solve asks for pressure that follows them.
    triangles: Triangles,
    buffers: Vec<(&'static str, wgpu::Buffer)>,
    forces: Gathering,
    blocks: Gathering,
    operations: Operations,
    /// Where the device forms the reactions of the air at its markers itself.
    in_air: Option<MarkerPipelines>,
    /// Where the device makes steps of fabric that cuts links by itself.
    cuts: Option<CutFabric>,
    workspace: Option<Workspace>,
    /// Made when a solve first asks for it.
    multigrid: Option<WholeHessian>,
    /// Loads as they were last uploaded.
    loads: Vec<[f32; 3]>,
    /// Loads that set the scale of the tolerance, as they were last uploaded.
    drive: Vec<[f32; 3]>,
    /// What shaders know of the step that was uploaded.
    stage: ClothStage,
    /// Part of the objective that does not depend on the positions sought [J].
    constant_j: f64,
    /// A solve that was begun, until its end is fetched.
    begun: Option<Options>,
    /// Steps of the device's own that were begun last.
    series: Option<Series>,
    /// Where the last solve ended, until it is fetched.
    solution: Option<Solution>,
    /// True if the masses on the device hold drag of nodes.
    drags: bool,
    /// Evaluations that the next solve is expected to take.
    expected_evaluations: usize,
    /// What positions on the device could not hold of it [m]; empty where they could.
    remainder: Vec<[f32; 3]>,
    /// Way back of positions.
    staging: Staging,
}

/// Where a solve ended.
#[derive(Debug)]
enum Solution {
    /// A point on the device.
    Point(PointSlot),
    /// Positions that have come back already [m].
    Positions(Vec<DVec3>),
    /// The same of a step that the device has ended itself: to the last bit.
    Ended(Vec<DVec3>),
}

/// Multigrid on the whole Hessian in place of block-Jacobi.
#[derive(Debug)]
struct WholeHessian {
    multigrid: Multigrid,
    stiffness: Stiffness,
    /// Nodal forces without block-Jacobi.
    gradient: Gathering,
}

/// Bytes of the largest buffer for a structure with so many markers. It is one of four: the minimiser's vectors, what elements and markers add at their nodes,
/// the matrix of a solve that asks for multigrid, the reactions of triangles that are `cut`.
#[must_use]
pub fn largest_buffer_bytes(
    structure: &Structure,
    marker_count: usize,
    multigrid: bool,
    cut: bool,
) -> u64 {
    let nodes = structure.node_count() as u64;
    let reactions = if cut {
        4 * (CUT_WORDS * structure.triangles.len()) as u64
    } else {
        0
    };
    // Six numbers for every corner of an element.
    let corners = elements::most_slots(structure, marker_count);
    let vectors = (12 * nodes * workspace::vector_slots(HISTORY) as u64)
        .max(reactions)
        .max(24 * corners as u64);
    if !multigrid {
        return vectors;
    }
    // Every inner edge of a mesh belongs to two triangles; a network's springs lie on those edges, its bending reaches one node farther.
    let triangles = 3 * structure.triangles.len();
    let springs = 2 * structure.springs.len();
    let edges = if triangles > springs {
        triangles
    } else {
        springs
    };
    let blocks = nodes + (edges + 2 * structure.bendings.len() + 2 * structure.cables.len()) as u64;
    let matrix = 36 * blocks;
    matrix.max(vectors)
}

impl Cloth {
    /// Uploads what does not change and makes room for the minimiser; `markers` are (triangle, barycentric weights).
    pub fn new(
        device: Arc<Device>,
        structure: &Structure,
        markers: &[(u32, [f64; 3])],
    ) -> Result<Self, DeviceError> {
        Self::with_triangles(device, structure, (markers, None), Triangles::default())
    }

    /// The same of fabric whose markers are in the air of the same device: it forms their reactions itself.
    pub fn new_in_air(
        device: Arc<Device>,
        structure: &Structure,
        markers: &[(u32, [f64; 3])],
        air: MarkersInAir,
    ) -> Result<Self, DeviceError> {
        Self::with_triangles(
            device,
            structure,
            (markers, Some(air)),
            Triangles::default(),
        )
    }

    /// The same of fabric that cuts the lattice of the air.
    pub fn new_cut(device: Arc<Device>, structure: &Structure) -> Result<Self, DeviceError> {
        let triangles = Triangles {
            faces: false,
            cut: true,
        };
        Self::with_triangles(device, structure, (&[], None), triangles)
    }

    fn with_triangles(
        device: Arc<Device>,
        structure: &Structure,
        (markers, air): (&[(u32, [f64; 3])], Option<MarkersInAir>),
        triangles: Triangles,
    ) -> Result<Self, DeviceError> {
        if structure.contact.is_some() {
            return Err(DeviceError::Feature {
                what: "search for contact of fabric with itself",
                device: device.info().name.clone(),
                remedy: "use --cloth host, or remove [contact]",
            });
        }
        if !structure.further_fabrics.is_empty() {
            return Err(DeviceError::Feature {
                what: "structure sewn of several fabrics",
                device: device.info().name.clone(),
                remedy: "use --cloth host",
            });
        }
        let nodes = structure.node_count();
        let elements = Elements::new(structure, markers, triangles);
        let constants = constants(structure, &elements);
        let gathering = |shader, what| {
            Gathering::new(&device, shader, what, &elements.kinds, nodes, &constants)
        };
        let forces = gathering(&shaders::NODAL_FORCES, "forces")?;
        let blocks = gathering(&shaders::INITIAL_HESSIAN, "blocks")?;
        let operations = Operations::new(&device, (nodes, &elements.kinds), &constants)?;
        let masses: Vec<f32> = structure.masses_kg.iter().map(|m| *m as f32).collect();
        let held: Vec<u32> = structure.held.iter().map(|h| u32::from(*h)).collect();
        let node_bytes = |values: u64| values * nodes as u64 * 4;
        let usage = wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST;
        let stage = device.buffer("cloth stage", size_of::<ClothStage>() as u64, usage)?;
        let mut buffers = vec![
            ("stage", stage),
            (
                "whole",
                device.storage("cloth positions", node_bytes(3 * POINTS))?,
            ),
            (
                "remainder",
                device.storage("cloth remainders", node_bytes(3 * POINTS))?,
            ),
            (
                "predicted_whole",
                device.storage("predicted positions", node_bytes(3))?,
            ),
            (
                "predicted_remainder",
                device.storage("predicted remainders", node_bytes(3))?,
            ),
            (
                "reactions",
                device.storage("marker reactions", 16 * markers.len() as u64)?,
            ),
            (
                "contributions",
                device.storage("cloth contributions", 24 * elements.slots as u64)?,
            ),
            (
                "energies",
                device.storage("cloth energies", 8 * elements.energies as u64)?,
            ),
            (
                "node_first",
                device.storage_of("first slots", &elements.node_first)?,
            ),
            (
                "node_slots",
                device.storage_of("slots of nodes", &elements.node_slots)?,
            ),
            ("masses", device.storage_of("masses", &masses)?),
            ("loads", device.storage("loads", node_bytes(3))?),
            ("held", device.storage_of("held nodes", &held)?),
            (
                "inverse_blocks",
                device.storage("initial Hessian", node_bytes(6))?,
            ),
        ];
        for kind in &elements.kinds {
            buffers.push((kind.plural, device.storage_of(kind.plural, &kind.words)?));
            match kind.name {
                "cable" => buffers.push((
                    "cable_laws",
                    device.storage_of("cable laws", &elements.cable_laws)?,
                )),
                "dashpot" => buffers.push((
                    "dashpot_states",
                    device.storage("dashpot states", 20 * kind.count as u64)?,
                )),
                "face" => buffers.push((
                    "face_pressures",
                    device.storage("face pressures", 4 * kind.count as u64)?,
                )),
                "cut_triangle" => buffers.push((
                    "cut_reactions",
                    device.storage("cut reactions", 4 * (CUT_WORDS * kind.count) as u64)?,
                )),
                "permeable_marker" => buffers.push((
                    "permeabilities",
                    device.storage("permeabilities", 20 * kind.count as u64)?,
                )),
                _ => (),
            }
        }
        let staging = Staging::new(&device, 24 * nodes as u64)?;
        let in_air = air
            .map(|air| MarkerPipelines::new(&device, structure, (markers, air)))
            .transpose()?;
        let mut cloth = Self {
            device,
            nodes,
            markers: markers.to_vec(),
            triangles,
            buffers,
            forces,
            blocks,
            operations,
            in_air,
            cuts: None,
            workspace: None,
            multigrid: None,
            loads: Vec::new(),
            drive: Vec::new(),
            stage: ClothStage::default(),
            constant_j: 0.0,
            begun: None,
            series: None,
            solution: None,
            drags: false,
            expected_evaluations: 0,
            remainder: Vec::new(),
            staging,
        };
        cloth.make_room(HISTORY)?;
        Ok(cloth)
    }

    /// The device it is on.
    #[must_use]
    pub const fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Bytes that multigrid has moved between host and device; `None` before a solve asks for it.
    #[must_use]
    pub fn multigrid_traffic(&self) -> Option<Traffic> {
        self.multigrid.as_ref().map(|m| m.multigrid.traffic())
    }

    /// Makes what a solve with these settings needs and is not there yet.
    fn prepare(
        &mut self,
        structure: &Structure,
        (input, settings): (&StepInput, &SolverSettings),
    ) -> Result<(), DeviceError> {
        if input.pressure_follows() && !self.triangles.faces {
            let device = Arc::clone(&self.device);
            let triangles = Triangles {
                faces: true,
                ..self.triangles
            };
            let air = self.in_air.take().map(MarkerPipelines::into_air);
            let markers = std::mem::take(&mut self.markers);
            *self = Self::with_triangles(device, structure, (&markers, air), triangles)?;
            // Whoever followed its nodes knows nothing of the new buffers.
            if let Some(in_air) = &mut self.in_air {
                in_air.own_steps = None;
            }
        }
        self.make_room(settings.history)?;
        if settings.initial_hessian == InitialHessian::Multigrid && self.multigrid.is_none() {
            self.multigrid = Some(self.whole_hessian(structure)?);
        }
        Ok(())
    }

    fn whole_hessian(&self, structure: &Structure) -> Result<WholeHessian, DeviceError> {
        let elements = Elements::new(structure, &self.markers, self.triangles);
        let constants = constants(structure, &elements);
        let shapes = hierarchy(graph(structure));
        let pattern = shapes
            .first()
            .map(|shape| shape.pattern.clone())
            .unwrap_or_default();
        let multigrid = Multigrid::new(&self.device, shapes)?;
        let (matrix, sliced) = multigrid.finest()?;
        let stiffness = Stiffness::new(
            &self.device,
            structure,
            &elements.kinds,
            &constants,
            &self.named_buffers(),
            (matrix, &pattern, sliced),
        )?;
        let shader = &shaders::NODAL_FORCES;
        let gradient =
            self.forces
                .gathered_by(&self.device, shader, "gather_gradient", &constants)?;
        Ok(WholeHessian {
            multigrid,
            stiffness,
            gradient,
        })
    }

    /// Makes room for `history` pairs of the minimiser.
    fn make_room(&mut self, history: usize) -> Result<(), DeviceError> {
        if self.workspace.as_ref().map(|w| w.history) == Some(history) {
            return Ok(());
        }
        self.workspace = None;
        self.drive.clear();
        self.workspace = Some(Workspace::new(
            &self.device,
            &self.operations,
            ([&self.forces, &self.blocks], self.in_air.as_ref()),
            &self.named_buffers(),
            history,
            self.nodes,
        )?);
        Ok(())
    }

    fn named_buffers(&self) -> Vec<(&str, &wgpu::Buffer)> {
        self.buffers.iter().map(|(name, b)| (*name, b)).collect()
    }

    fn buffer(&self, wanted: &str) -> Result<&wgpu::Buffer, DeviceError> {
        self.buffers
            .iter()
            .find_map(|(name, buffer)| (*name == wanted).then_some(buffer))
            .ok_or_else(|| DeviceError::Command(format!("no buffer {wanted}")))
    }
}

/// What a structure fixes in the shaders of its elements.
fn constants<'a>(structure: &Structure, elements: &'a Elements) -> Vec<(&'a str, f64)> {
    let mut constants: Vec<(&str, f64)> = elements
        .constants
        .iter()
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    let origin = middle(&structure.positions_m).to_array().map(split);
    for (name, (whole, _)) in ["ORIGIN_X", "ORIGIN_Y", "ORIGIN_Z"].into_iter().zip(origin) {
        constants.push((name, f64::from(whole)));
    }
    if let Some(membrane) = &structure.membrane {
        let c = membrane.stiffness();
        constants.extend([
            ("STIFFNESS_XX", c[0][0]),
            ("STIFFNESS_XY", c[0][1]),
            ("STIFFNESS_XS", c[0][2]),
            ("STIFFNESS_YY", c[1][1]),
            ("STIFFNESS_YS", c[1][2]),
            ("STIFFNESS_SS", c[2][2]),
            ("RESIDUAL", membrane.residual()),
            ("ISOTROPIC", f64::from(u8::from(membrane.is_isotropic()))),
        ]);
        if let Some(shear) = membrane.shear() {
            constants.extend([
                ("NONLINEAR_SHEAR", 1.0),
                ("SHEAR_COMPLIANCE", shear.compliance_m_n),
                ("SHEAR_CUBIC", shear.cubic_m3_n3),
            ]);
        }
    }
    constants
}
