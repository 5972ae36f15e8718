//! Sizes and bytes.

use glam::DVec3;

use super::Placement;
use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::case::scene::{Air, BodyKind};
use crate::immersed::markers;
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::grid::LINE_BYTES;
use crate::lattice::grid::PADDED_ELEMENTS;
use crate::lattice::level_state::STATE_NUMBERS;
use crate::lattice::nest::Level;

/// Share of the free memory that a run may take.
const MEMORY_SHARE: f64 = 0.8;

/// Cell updates that take as long as the exchange of one cell of a box's shell (`ripstop bench levels`).
pub(super) const UPDATES_PER_EXCHANGED_CELL: f64 = 6.0;

/// Links that a surface of a cell's area cuts, in the mean over its directions: half of the sum of the lengths of the nine.
const LINKS_PER_CELL_AREA: f64 = 0.5 * (3.0 + 6.0 * std::f64::consts::SQRT_2);

/// Bytes of a cut link, with what is read, returned and sorted of it.
const LINK_BYTES: u64 = 500;

/// Sizes and bytes of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Cells of the air, those under boxes of finer ones included.
    pub cells: u64,
    /// Cell updates in a step, on the mean: coarser cells make fewer steps.
    pub updates: u64,
    /// Cell updates that take as long as the exchange between lattices, in a step, on the mean.
    pub exchange_updates: u64,
    /// Markers.
    pub markers: u64,
    /// Links that surfaces cut, in the mean over all directions of a surface.
    pub links: u64,
    /// Nodes of the structure.
    pub nodes: u64,
    /// Triangles of the structure.
    pub triangles: u64,
    /// Cable segments.
    pub cables: u64,
    /// Bytes of the air.
    pub air_bytes: u64,
    /// True if those are a device's.
    pub air_on_device: bool,
    /// True if a device's memory is the host's.
    pub shared_memory: bool,
    /// Bytes of one array of populations on the device, the largest buffer.
    pub population_bytes: u64,
    /// Cells of the largest lattice with the ghost layer, and the padding of rows on the CPU, of planes on a device.
    pub padded_cells: u64,
    /// Bytes of a snapshot of the air, taken for pictures and files.
    pub snapshot_bytes: u64,
    /// Bytes of markers, or of cut links, and their lists.
    pub marker_bytes: u64,
    /// Bytes of the structure and its solver.
    pub structure_bytes: u64,
    /// Bytes of the structure on a device; zero where it is not on one.
    pub structure_device_bytes: u64,
}

/// A run that does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryRefusal {
    /// Bytes needed.
    pub needed: u64,
    /// Bytes free now; `None` if memory is not what lacks, but addresses.
    pub free: Option<u64>,
}

/// Cells and bytes of a lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LevelSizes {
    /// Cells.
    pub cells: u64,
    /// With the ghost layer, and the padding of rows on the CPU, of planes on a device.
    pub padded_cells: u64,
    /// Populations, and what belongs to cells beside them.
    pub bytes: u64,
}

impl LevelSizes {
    /// Of every lattice of the air, in the order of [`Air::levels`].
    pub fn of(air: &Air, placement: &Placement) -> Vec<Self> {
        let (each, kept) = (placement.population_bytes(), placement.kept_bytes());
        let held = air
            .eddy_viscosity
            .is_some_and(|eddy_viscosity| eddy_viscosity.gradient_model().is_some());
        let of_level = |level: Level| {
            let counts = level.cells.map(|n| n as u64);
            let cells = counts.into_iter().fold(1, u64::saturating_mul);
            let [row, rest @ ..] = counts.map(|n| n + 2);
            let [rows, planes] = rest;
            let plane = if placement.air_on_device() {
                let plane = row.saturating_mul(rows);
                plane
                    .checked_next_multiple_of(PADDED_ELEMENTS as u64)
                    .unwrap_or(plane)
            } else {
                // CPU threads begin every row on a cache line.
                row.next_multiple_of(LINE_BYTES as u64 / each)
                    .saturating_mul(rows)
            };
            let padded_cells = plane.saturating_mul(planes);
            let populations = padded_cells.saturating_mul(DIRECTION_COUNT as u64 * each);
            // The eddy part of every cell's relaxation time.
            let eddy = if held { cells.saturating_mul(kept) } else { 0 };
            // Of boxes on CPU threads: ends of rows that are exchanged, and states of coarse cells.
            let exchanged = if level.depth > 0 && !placement.air_on_device() {
                let [nx, ny, nz] = counts;
                let ends = 8 * DIRECTION_COUNT as u64 * ny.saturating_mul(nz);
                let states = [nx, ny, nz].map(|n| n / 2 + 2);
                let states = states.into_iter().fold(1, u64::saturating_mul);
                let states = states.saturating_mul(STATE_NUMBERS as u64 * kept);
                ends.saturating_mul(each).saturating_add(states)
            } else {
                0
            };
            Self {
                cells,
                padded_cells,
                bytes: populations.saturating_add(eddy).saturating_add(exchanged),
            }
        };
        air.levels().into_iter().map(of_level).collect()
    }
}

impl Sizes {
    /// Sizes of a scene.
    #[must_use]
    pub fn new(scene: &Scene, placement: &Placement) -> Self {
        let mut sizes = Self::default();
        if let Some(air) = &scene.air {
            for level in LevelSizes::of(air, placement) {
                sizes.cells = sizes.cells.saturating_add(level.cells);
                sizes.air_bytes = sizes.air_bytes.saturating_add(level.bytes);
                sizes.padded_cells = sizes.padded_cells.max(level.padded_cells);
            }
            sizes.updates = air.updates_per_step().round() as u64;
            let exchange = UPDATES_PER_EXCHANGED_CELL * air.exchanged_per_step();
            sizes.exchange_updates = exchange.round() as u64;
            sizes.population_bytes =
                (sizes.padded_cells).saturating_mul(placement.population_bytes());
            sizes.air_on_device = placement.air_on_device();
            sizes.shared_memory = placement.shared_memory;
            // Pictures and flow files take a snapshot of density and velocity, and its conversion to SI.
            sizes.snapshot_bytes = sizes.cells.saturating_mul(2 * 16);
        }
        if let Some(body) = &scene.body {
            sizes.nodes = body.structure.node_count() as u64;
            sizes.triangles = body.structure.triangles.len() as u64;
            sizes.cables = body.structure.cables.len() as u64;
            sizes.structure_bytes = body.structure.estimated_bytes(crate::solve::lbfgs::HISTORY);
            if placement.cloth_on_device() {
                // Single precision, half of the host's.
                sizes.structure_device_bytes = sizes.structure_bytes / 2;
            }
        }
        if let (Some(air), Some(coupling)) = (&scene.air, &scene.coupling) {
            let cell_size_m = air.units.cell_size_m;
            if coupling.scheme == Scheme::Links {
                let fabric = scene.body.iter().map(|body| body.structure.rest_area_m2());
                let bodies = scene.rigid_bodies.iter().map(|body| {
                    let areas = body.surface.area_vectors_m2();
                    areas.map(DVec3::length).sum::<f64>()
                });
                let area_m2: f64 = fabric.chain(bodies).sum();
                sizes.links = (LINKS_PER_CELL_AREA * area_m2 / (cell_size_m * cell_size_m)) as u64;
                sizes.marker_bytes = sizes.links.saturating_mul(LINK_BYTES);
                return sizes;
            }
            let spacing_m = coupling.marker_spacing_m(air);
            if let Some(body) = &scene.body {
                sizes.markers = match &body.kind {
                    BodyKind::Plate(plate) => {
                        let inset_m = coupling.rim_inset_cells * cell_size_m;
                        let [along, across] = plate.marker_counts(spacing_m, inset_m);
                        (along as u64).saturating_mul(across as u64)
                    }
                    _ => {
                        let insets = coupling.rim_insets(&body.structure, air);
                        markers::count(body.structure.extents(&insets), spacing_m)
                    }
                };
            }
            for body in &scene.rigid_bodies {
                let own = markers::count(body.marker_surface.extents(), spacing_m);
                sizes.markers = sizes.markers.saturating_add(own);
            }
            // 64 kernel points with cell, weight and sorted entry, plus per-marker vectors.
            sizes.marker_bytes = sizes.markers.saturating_mul(64 * 24 + 160);
        }
        sizes
    }

    /// All bytes of host memory.
    #[must_use]
    pub const fn host_bytes(&self) -> u64 {
        let air = if self.air_on_device && !self.shared_memory {
            0
        } else {
            self.air_bytes
        };
        air.saturating_add(self.snapshot_bytes)
            .saturating_add(self.marker_bytes)
            .saturating_add(self.structure_bytes)
    }

    /// Refuses a run beyond 80 % of the memory that is free (if that is known), or with a grid too large for 32-bit addresses.
    pub fn fit_into(&self, free: Option<u64>) -> Result<(), MemoryRefusal> {
        let needed = self.host_bytes();
        let too_much = free.filter(|&free| needed as f64 > MEMORY_SHARE * free as f64);
        if too_much.is_some() || self.padded_cells >= u64::from(u32::MAX) {
            return Err(MemoryRefusal {
                needed,
                free: too_much,
            });
        }
        Ok(())
    }
}

/// Memory free for this process now [bytes]: that of the machine, of its control group, or of the limit of address space (`ulimit -v`),
/// whichever is least; `None` where the system does not tell.
#[must_use]
pub fn free_memory() -> Option<u64> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    let of_machine = Some(system.available_memory()).filter(|&bytes| bytes > 0);
    let of_group = system.cgroup_limits().map(|limits| limits.free_memory);
    [of_machine, of_group, free_address_space(&mut system)]
        .into_iter()
        .flatten()
        .min()
}

/// Address space that the allocator reserves for each thread, used or not [bytes].
#[cfg(unix)]
const RESERVED_PER_THREAD: u64 = 66 << 20;

/// What `ulimit -v` leaves beside what this process has and its threads will reserve [bytes]; `None` without such a limit.
#[cfg(unix)]
fn free_address_space(system: &mut sysinfo::System) -> Option<u64> {
    let (limit, _) = rlimit::getrlimit(rlimit::Resource::AS).ok()?;
    if limit == rlimit::INFINITY {
        return None;
    }
    let own = sysinfo::get_current_pid().ok()?;
    system.refresh_processes(sysinfo::ProcessesToUpdate::Some(&[own]), false);
    let taken = system.process(own)?.virtual_memory();
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    Some(limit.saturating_sub(taken + threads * RESERVED_PER_THREAD))
}

#[cfg(not(unix))]
fn free_address_space(_system: &mut sysinfo::System) -> Option<u64> {
    None
}
