//! The immersed boundary on the device: stages `interpolate`, `spread` and `repeat_forcing` (formulas in [`crate::immersed`] and
//! [`crate::cpu::immersed`]).
//!
//! Work is confined to the box of cells that holds the kernels of all markers. The host, which knows the markers' positions in
//! double precision, sorts them by the first cell under their kernel, and sends cell, fraction and area of each; the device
//! marks the touched cells, and each of these sums over the markers that reach it, found through that order. *Departure from the
//! CPU engine*, which keeps all 64 weights of every marker in lists: here the order is 32 bytes per marker to send instead of
//! more than 500 (see `benches/results/`), and the sums run over the markers in another, equally fixed, order.

mod interpolate;
mod repeat_forcing;
mod sort_markers;
mod sorting;
mod spread;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::device::Device;
use super::error::DeviceError;
use super::fluid::{Fluid, ForceBox};
use super::pipeline::{Bound, Pipeline};
use super::shaders::{self, parameters};
use super::transfer::Staging;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::immersed::touched::{CellBox, Domain, bounding_box};

pub use sorting::LatticeInSpace;
use sorting::Sorting;

parameters! {
    /// A marker, in sorted order.
    Marker {
        /// Number in the box of the first cell under the kernel.
        corner: u32,
        /// Rest area [cells²].
        area: f32,
        /// How its kernel is folded at faces that a body passes through; 0: not.
        fold: u32,
        /// Its number in the order of the fabric.
        number: u32,
        /// Distance from the second cell under the kernel [cells].
        fraction: [f32; 4],
    }
    /// What the marker stages share.
    MarkerParameters {
        /// First cell of the box.
        box_first: [u32; 4],
        /// Its size, and in the last place 1 where it is the whole domain along y, 2 along z, through whose sides kernels go on.
        box_size: [u32; 4],
        /// Markers.
        marker_count: u32,
        /// Cells of the box.
        box_count: u32,
        /// Over-relaxation a on a flat sheet.
        over_relaxation: f32,
        /// Upper bound of a_k.
        largest_strength: f32,
    }
    /// What the sort of the markers knows of their box, where the device makes steps by itself.
    SortParameters {
        /// First cell of the box.
        box_first: [i32; 4],
        /// Its size.
        box_size: [i32; 4],
        /// Centre of the lattice's first cell: whole numbers of 2⁻¹⁶ m,
        origin_whole: [i32; 4],
        /// and remainders [m].
        origin_remainder: [f32; 4],
        /// Size of a cell alike.
        cell_whole: i32,
        /// Its remainder [m].
        cell_remainder: f32,
        /// Cells in a metre.
        cells_per_m: f32,
        /// Cells of the box.
        box_count: u32,
        /// Blocks that they are scanned in.
        block_count: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
        /// Unused.
        padding_c: u32,
    }
}

/// Numbers all force buffers ever made, so that none is taken for another.
static GENERATIONS: AtomicU64 = AtomicU64::new(0);

/// Flag of a touched cell, as in `shaders/markers.wgsl`.
const TOUCHED: u32 = 1 << 31;

/// Bytes of a marker's kernel weights: four along every axis.
const KERNEL_BYTES: u64 = 48;

/// The same where kernels are folded: four more of the normal component at the sides of y and z.
const FOLDED_KERNEL_BYTES: u64 = 80;

/// Section of a checkpoint with the forces of the markers.
pub const FORCES: &str = "marker_forces_on_device";

/// Section with the places of the markers, where the device may have found them itself.
const PLACED: &str = "markers_placed_by_device";

/// Markers in the air.
#[derive(Debug)]
pub struct Immersed {
    device: Arc<Device>,
    over_relaxation: f64,
    areas: Vec<f64>,
    domain: Domain,
    /// Marker at every place of the sorted order.
    order: Vec<u32>,
    strengths: Vec<f64>,
    air_velocities: Vec<[f64; 3]>,
    pipelines: Pipelines,
    markers: wgpu::Buffer,
    weights: wgpu::Buffer,
    parameters: wgpu::Buffer,
    marker_states: wgpu::Buffer,
    marker_forces: wgpu::Buffer,
    marker_velocities: wgpu::Buffer,
    /// Velocities of the markers themselves, sorted.
    target_velocities: wgpu::Buffer,
    /// Place of every marker in the sorted order.
    places: Vec<u32>,
    /// The same on the device, where it sorts them itself, and a marker that left the box then.
    sorted_order: wgpu::Buffer,
    strayed: wgpu::Buffer,
    /// Where the device may find the markers itself.
    sorting: Option<Sorting>,
    /// Smallest box that holds the kernels; `None` before there are any.
    kernels: Option<CellBox>,
    boxed: Option<Boxed>,
    /// Way back of the marker states.
    staging: Staging,
    /// What brings them; `None` until they are asked for.
    submitted: Option<wgpu::SubmissionIndex>,
    /// True once `spread` has written forces.
    active: bool,
    forces: Vec<[f32; 4]>,
}

#[derive(Debug)]
struct Pipelines {
    place_markers: Pipeline,
    touched_cells: Pipeline,
    interpolate: Pipeline,
    spread: Pipeline,
    half_forced_velocity: Pipeline,
    repeat_forcing: Pipeline,
}

/// What belongs to the cells of the box; made anew when the box outgrows it.
#[derive(Debug)]
struct Boxed {
    capacity: u64,
    marks: wgpu::Buffer,
    /// (u*, marker area)
    cell_states: wgpu::Buffer,
    forces: ForceBox,
    place_markers: Bound,
    touched_cells: [Bound; 2],
    interpolate: Bound,
    spread: Bound,
    half_forced_velocity: Bound,
    repeat_forcing: Bound,
}

impl Immersed {
    /// Markers of the given areas [cells²] in the air of `fluid`, of which they may touch `domain`.
    pub fn new(
        fluid: &Fluid,
        domain: Domain,
        areas: Vec<f64>,
        over_relaxation: f64,
    ) -> Result<Self, DeviceError> {
        let device = Arc::clone(fluid.device());
        let count = areas.len();
        let constants = fluid.constants();
        let storage = fluid.population_storage() as usize;
        let (of_interpolate, of_spread, of_repeat, kernel_bytes) = match domain.folds {
            None => (
                &shaders::INTERPOLATE[storage],
                &shaders::SPREAD,
                &shaders::REPEAT_FORCING,
                KERNEL_BYTES,
            ),
            Some(_) => (
                &shaders::INTERPOLATE_FOLDED[storage],
                &shaders::SPREAD_FOLDED,
                &shaders::REPEAT_FORCING_FOLDED,
                FOLDED_KERNEL_BYTES,
            ),
        };
        let [place_markers, touched_cells, interpolate] = device.pipelines(
            of_interpolate,
            ["place_markers", "touched_cells", "interpolate"],
            &constants,
        )?;
        let [spread, half_forced_velocity] =
            device.pipelines(of_spread, ["spread", "half_forced_velocity"], &[])?;
        let [repeat_forcing] = device.pipelines(of_repeat, ["repeat_forcing"], &[])?;
        let n = count as u64;
        Ok(Self {
            over_relaxation,
            domain,
            order: Vec::new(),
            strengths: vec![0.0; count],
            air_velocities: vec![[0.0; 3]; count],
            pipelines: Pipelines {
                place_markers,
                touched_cells,
                interpolate,
                spread,
                half_forced_velocity,
                repeat_forcing,
            },
            markers: device.storage("markers", 32 * n)?,
            weights: device.storage("kernel weights", kernel_bytes * n)?,
            parameters: device.uniform::<MarkerParameters>("marker parameters")?,
            marker_states: device.storage("marker states", 16 * n)?,
            marker_forces: device.storage("marker forces", 16 * n)?,
            marker_velocities: device.storage("marker velocities", 16 * n)?,
            target_velocities: device.storage("target velocities", 16 * n)?,
            places: vec![0; count],
            sorted_order: device.storage("sorted order", 4 * n)?,
            strayed: device.storage("strayed marker", 4)?,
            sorting: None,
            kernels: None,
            boxed: None,
            staging: Staging::new(&device, 16 * n.max(1))?,
            submitted: None,
            active: false,
            forces: vec![[0.0; 4]; count],
            areas,
            device,
        })
    }

    /// Number of markers.
    #[must_use]
    pub const fn marker_count(&self) -> usize {
        self.areas.len()
    }

    /// u* at the markers [cells per step].
    #[must_use]
    pub fn air_velocities(&self) -> &[[f64; 3]] {
        &self.air_velocities
    }

    /// Immersed-boundary stiffness 2 a_k A_k of marker `k` [lattice units].
    #[must_use]
    pub fn stiffness(&self, k: usize) -> f64 {
        2.0 * self.strengths[k] * self.areas[k]
    }

    /// Area of marker `k` [cells²].
    #[must_use]
    pub fn area(&self, k: usize) -> f64 {
        self.areas[k]
    }

    /// Force of marker `k` on the air by the last `spread` [lattice units].
    #[must_use]
    pub fn force(&self, k: usize) -> [f64; 3] {
        let [x, y, z, _] = self.forces[self.places[k] as usize].map(f64::from);
        [x, y, z]
    }

    /// The markers for fabric on the same device, which forms their reactions and forces itself. A lattice unit of stiffness is `stiffness_kg_s`.
    #[must_use]
    pub fn in_air(
        &self,
        stiffness_kg_s: f64,
        [speed_m_s, force_n]: [f64; 2],
    ) -> super::cloth::MarkersInAir {
        let of_marker = |area: &f64| 2.0 * area * stiffness_kg_s;
        super::cloth::MarkersInAir {
            sorted: self.markers.clone(),
            states: self.marker_states.clone(),
            forces: self.marker_forces.clone(),
            order: self.sorted_order.clone(),
            strayed: self.strayed.clone(),
            stiffness_kg_s: self.areas.iter().map(of_marker).collect(),
            speed_m_s,
            force_n,
        }
    }

    /// The body force for the next collision.
    #[must_use]
    pub fn force_box(&self) -> Option<&ForceBox> {
        self.boxed
            .as_ref()
            .filter(|_| self.active)
            .map(|boxed| &boxed.forces)
    }

    /// True if all touched cells lie in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        self.kernels.is_none_or(|(low, high)| {
            (0..3).all(|a| low[a] >= first[a] as i64 && high[a] <= end[a] as i64)
        })
    }

    fn boxed(&mut self, fluid: &Fluid, cells: u64) -> Result<(), DeviceError> {
        if self.boxed.as_ref().is_some_and(|b| b.capacity >= cells) {
            return Ok(());
        }
        // Nothing in the old box is needed any more.
        self.boxed = None;
        let device = &self.device;
        // Room to move and open, so that this is rare; as far as the device has it.
        let room = device.info().binding_limit_bytes / 16;
        let capacity = (cells + cells / 2).min(room).max(cells);
        let marks = device.storage("touched cells", 4 * capacity)?;
        let cell_states = device.storage("states of touched cells", 16 * capacity)?;
        let cell_forces = device.storage("forces on touched cells", 16 * capacity)?;
        let buffers = [
            ("parameters", &self.parameters),
            ("markers", &self.markers),
            ("weights", &self.weights),
            ("marks", &marks),
            ("touched", &marks),
            ("cell_states", &cell_states),
            ("marker_states", &self.marker_states),
            ("marker_forces", &self.marker_forces),
            ("cell_forces", &cell_forces),
            ("marker_velocities", &self.marker_velocities),
            ("target_velocities", &self.target_velocities),
        ];
        let bind = |pipeline: &Pipeline| device.bind(pipeline, &buffers);
        let touched = |odd| {
            let mut named = fluid.named_populations(odd);
            named.extend(buffers);
            device.bind(&self.pipelines.touched_cells, &named)
        };
        let boxed = Boxed {
            capacity,
            place_markers: bind(&self.pipelines.place_markers)?,
            touched_cells: [touched(false)?, touched(true)?],
            interpolate: bind(&self.pipelines.interpolate)?,
            spread: bind(&self.pipelines.spread)?,
            half_forced_velocity: bind(&self.pipelines.half_forced_velocity)?,
            repeat_forcing: bind(&self.pipelines.repeat_forcing)?,
            marks,
            cell_states,
            forces: ForceBox {
                forces: cell_forces,
                first: [0; 3],
                size: [0; 3],
                generation: GENERATIONS.fetch_add(1, Ordering::Relaxed),
            },
        };
        self.boxed = Some(boxed);
        Ok(())
    }
}

impl Immersed {
    /// Writes what the next step reads.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("markers_active", &[u64::from(self.active)])?;
        out.put("marker_strengths", &self.strengths)?;
        out.put("marker_air_velocities", &self.air_velocities)?;
        let by_marker = self.forces_by_marker();
        out.put(FORCES, &by_marker)?;
        let mut kernels = self.kernels;
        if self.sorting.is_some() && self.active {
            let placed = self.placed().map_err(std::io::Error::other)?;
            out.put(PLACED, &placed)?;
            kernels = bounding_box(&placed, self.domain).unwrap_or(kernels);
        }
        let velocities = (self.box_velocities(kernels)).map_err(std::io::Error::other)?;
        out.put("box_velocities", &velocities)
    }

    /// Goes on with forces that another engine spread at the positions of the last interpolation [lattice units].
    pub fn take_forces(&mut self, forces: &[[f64; 3]]) {
        for (slot, &marker) in self.forces.iter_mut().zip(&self.order) {
            let [x, y, z] = forces[marker as usize].map(|f| f as f32);
            *slot = [x, y, z, 0.0];
        }
        self.device.write(&self.marker_forces, 0, &self.forces);
        self.spread();
    }

    /// Takes it from a checkpoint; `positions` are those of the last interpolation [cells].
    pub fn restore(
        &mut self,
        from: &Reader,
        positions: &[[f64; 3]],
        fluid: &Fluid,
    ) -> Result<(), CheckpointError> {
        let count = self.areas.len();
        let failed = |error: DeviceError| from.damaged(error.to_string());
        self.active = from.take_exactly::<u64>("markers_active", 1)?[0] == 1;
        self.strengths = from.take_exactly("marker_strengths", count)?;
        self.air_velocities = from.take_exactly("marker_air_velocities", count)?;
        let forces: Vec<[f32; 4]> = from.take_exactly(FORCES, count)?;
        let velocities: Vec<[f32; 4]> = from.take("box_velocities")?;
        if self.active {
            let placed: Vec<[f64; 3]> = match from.has(PLACED) {
                true => from.take_exactly(PLACED, count)?,
                false => positions.to_vec(),
            };
            self.send_markers(fluid, &placed)
                .map_err(failed)?
                .map_err(|left| {
                    from.damaged(format!("marker {} lies outside the air", left.marker))
                })?;
            for (slot, &marker) in self.forces.iter_mut().zip(&self.order) {
                *slot = forces[marker as usize];
            }
            if let Some(boxed) = &self.boxed {
                self.device.write(&boxed.cell_states, 0, &velocities);
            }
            self.device.write(&self.marker_forces, 0, &self.forces);
            self.spread();
        }
        self.device.check().map_err(failed)
    }

    fn forces_by_marker(&self) -> Vec<[f32; 4]> {
        let mut result = vec![[0.0; 4]; self.areas.len()];
        for (force, &marker) in self.forces.iter().zip(&self.order) {
            result[marker as usize] = *force;
        }
        result
    }

    /// Velocities of the touched cells of the smallest box that holds all kernels. The others hold what earlier boxes left there: nothing reads it, and it is not part of
    /// the state.
    fn box_velocities(&self, kernels: Option<CellBox>) -> Result<Vec<[f32; 4]>, DeviceError> {
        let (Some(boxed), Some((low, high))) = (&self.boxed, kernels) else {
            return Ok(Vec::new());
        };
        let ForceBox { first, size, .. } = &boxed.forces;
        let [nx, ny, nz] = size.map(|n| n as usize);
        let velocities: Vec<[f32; 4]> = self.device.read(&boxed.cell_states, 0, nx * ny * nz)?;
        let marks: Vec<u32> = self.device.read(&boxed.marks, 0, nx * ny * nz)?;
        let [xs, ys, zs] = [0, 1, 2].map(|a| {
            let from = |place: i64| (place - i64::from(first[a])) as usize;
            from(low[a])..from(high[a])
        });
        let mut kept = Vec::new();
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let cell = x + nx * (y + ny * z);
                    let is_touched = marks[cell] & TOUCHED != 0;
                    kept.push(if is_touched {
                        velocities[cell]
                    } else {
                        [0.0; 4]
                    });
                }
            }
        }
        Ok(kept)
    }
}
