//! Stage `send_markers` where no host is asked: the device finds the markers at the nodes of the fabric as they stand, and sorts them
//! (`shaders/sort_markers.wgsl`).
//!
//! The box that holds all kernels stays the same for several steps, with room to move. *Departure from the sort of the host*: fractions of a cell come from positions in fixed
//! point, in `f32`; they differ by some 1e-7 cells.

use super::sorting::{LatticeInSpace, SortedBox, Sorting};
use super::{Immersed, Marker, SortParameters};
use crate::gpu::cloth::NodesOnDevice;
use crate::gpu::cloth::split;
use crate::gpu::error::DeviceError;
use crate::gpu::fluid::{Fluid, ForceBox};
use crate::gpu::pipeline::Pipeline;
use crate::gpu::shaders;
use crate::immersed::touched::{OutOfDomain, bounding_box};

/// Cells that one workgroup scans, as in the shader.
const BLOCK: u64 = 1024;

impl Immersed {
    /// From now on the device may find the markers itself, at these nodes. False, and it may not, where kernels go on through sides or are folded at faces.
    pub fn follow(
        &mut self,
        nodes: NodesOnDevice,
        lattice: LatticeInSpace,
    ) -> Result<bool, DeviceError> {
        if self.domain.folds.is_some() || self.domain.repeats.contains(&true) {
            return Ok(false);
        }
        let device = &self.device;
        let n = self.areas.len() as u64;
        let pipelines = device.pipelines(
            &shaders::SORT_MARKERS,
            [
                "find_cells",
                "scan_cells",
                "scan_blocks",
                "scatter_markers",
                "rank_markers",
            ],
            &[("MARKERS", n as f64)],
        )?;
        let areas: Vec<f32> = self.areas.iter().map(|area| *area as f32).collect();
        self.sorting = Some(Sorting {
            lattice,
            pipelines,
            nodes,
            parameters: device.uniform::<SortParameters>("sort parameters")?,
            areas: device.storage_of("marker areas", &areas)?,
            unsorted: device.storage("unsorted markers", 32 * n)?,
            scattered: device.storage("scattered markers", 4 * n)?,
            boxed: None,
        });
        Ok(true)
    }

    /// Lays a box around the markers at `positions` [cells], with so many cells of room to move in. What the last step spread must have been taken by the air.
    pub fn enclose(
        &mut self,
        fluid: &Fluid,
        positions: &[[f64; 3]],
        room: u32,
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        let (low, high) = match bounding_box(positions, self.domain) {
            Ok(Some(found)) => found,
            Ok(None) => return Ok(Ok(())),
            Err(left) => return Ok(Err(left)),
        };
        let kept = self.domain.kept as i64;
        let room = i64::from(room);
        let low: [i64; 3] = std::array::from_fn(|a| (low[a] - room).max(kept));
        let high: [i64; 3] =
            std::array::from_fn(|a| (high[a] + room).min(self.domain.cells[a] as i64 - kept));
        let size: [u64; 3] = std::array::from_fn(|a| (high[a] - low[a]) as u64);
        let box_count: u64 = size.iter().product();
        self.boxed(fluid, box_count)?;
        self.bind_sorting()?;
        self.lay_box(low, size, 0);
        let (Some(sorting), device) = (&self.sorting, &self.device) else {
            return Ok(Ok(()));
        };
        let LatticeInSpace {
            first_centre_m,
            cell_size_m,
        } = sorting.lattice;
        let origin = first_centre_m.to_array().map(split);
        let (cell_whole, cell_remainder) = split(cell_size_m);
        let four = |of: &dyn Fn(usize) -> i32| [of(0), of(1), of(2), 0];
        let [x, y, z] = origin.map(|(_, remainder)| remainder);
        let parameters = SortParameters {
            box_first: four(&|a| low[a] as i32),
            box_size: four(&|a| size[a] as i32),
            origin_whole: four(&|a| origin[a].0),
            origin_remainder: [x, y, z, 0.0],
            cell_whole,
            cell_remainder,
            cells_per_m: (1.0 / cell_size_m) as f32,
            box_count: box_count as u32,
            block_count: box_count.div_ceil(BLOCK) as u32,
            ..SortParameters::default()
        };
        device.write(&sorting.parameters, 0, &[parameters]);
        device.write(&self.strayed, 0, &[0_u32]);
        Ok(Ok(()))
    }

    /// Buffers for the cells of the present box.
    fn bind_sorting(&mut self) -> Result<(), DeviceError> {
        let (Some(sorting), Some(boxed)) = (&mut self.sorting, &self.boxed) else {
            return Ok(());
        };
        let generation = boxed.forces.generation;
        if sorting
            .boxed
            .as_ref()
            .is_some_and(|b| b.generation == generation)
        {
            return Ok(());
        }
        let device = &self.device;
        // All counts are none, here and after every sort.
        let counts = device.storage("markers in cells", 4 * boxed.capacity)?;
        let starts = device.storage("first markers of cells", 4 * boxed.capacity)?;
        let blocks = device.storage(
            "first markers of blocks",
            4 * boxed.capacity.div_ceil(BLOCK),
        )?;
        let NodesOnDevice {
            whole,
            remainder,
            fabric_markers,
        } = &sorting.nodes;
        let buffers = [
            ("parameters", &sorting.parameters),
            ("nodes_whole", whole),
            ("nodes_remainder", remainder),
            ("fabric_markers", fabric_markers),
            ("areas", &sorting.areas),
            ("unsorted", &sorting.unsorted),
            ("counts", &counts),
            ("starts", &starts),
            ("blocks", &blocks),
            ("scattered", &sorting.scattered),
            ("markers", &self.markers),
            ("order", &self.sorted_order),
            ("strayed", &self.strayed),
        ];
        let [a, b, c, d, e] = &sorting.pipelines;
        let bind = |pipeline: &Pipeline| device.bind(pipeline, &buffers);
        sorting.boxed = Some(SortedBox {
            generation,
            find_cells: bind(a)?,
            scan_cells: bind(b)?,
            scan_blocks: bind(c)?,
            scatter_markers: bind(d)?,
            rank_markers: bind(e)?,
        });
        Ok(())
    }

    /// Finds and sorts the markers, and marks the touched cells, in the box that was laid.
    pub fn sort_markers(&self) {
        let (Some(boxed), Some(sorted)) = (
            &self.boxed,
            self.sorting
                .as_ref()
                .and_then(|sorting| sorting.boxed.as_ref()),
        ) else {
            return;
        };
        let device = &self.device;
        let box_count: u64 = boxed.forces.size.iter().map(|&n| u64::from(n)).product();
        let markers = device.workgroups(self.areas.len() as u64);
        // A workgroup for every block.
        let blocks = device.workgroups(u64::from(shaders::WORKGROUP) * box_count.div_ceil(BLOCK));
        let mut commands = device.record("sort_markers");
        commands
            .raw
            .clear_buffer(&boxed.marks, 0, Some(4 * box_count));
        {
            let mut pass = commands.pass("sort_markers");
            sorted.find_cells.dispatch(&mut pass, markers);
            sorted.scan_cells.dispatch(&mut pass, blocks);
            sorted.scan_blocks.dispatch(&mut pass, [1, 1]);
            sorted.scatter_markers.dispatch(&mut pass, markers);
            sorted.rank_markers.dispatch(&mut pass, markers);
            boxed.place_markers.dispatch(&mut pass, markers);
        }
        device.leave(commands);
    }

    /// Takes where the device had sorted the markers to in a step, and which cells they touched at `positions` [cells].
    pub fn take_sorted(
        &mut self,
        order: &[u32],
        positions: &[[f64; 3]],
    ) -> Result<(), OutOfDomain> {
        self.take_order(order.iter().copied());
        self.kernels = bounding_box(positions, self.domain)?;
        Ok(())
    }

    /// Places of the markers as the kernels have them [cells]: whole cells, and fractions in single precision.
    pub(super) fn placed(&self) -> Result<Vec<[f64; 3]>, DeviceError> {
        let mut placed = vec![[0.0; 3]; self.areas.len()];
        let Some(boxed) = &self.boxed else {
            return Ok(placed);
        };
        let ForceBox { first, size, .. } = boxed.forces;
        let markers: Vec<Marker> = self.device.read(&self.markers, 0, placed.len())?;
        for marker in markers {
            let row = marker.corner / size[0];
            let corner = [marker.corner % size[0], row % size[1], row / size[1]];
            placed[marker.number as usize] = std::array::from_fn(|a| {
                f64::from(first[a] + corner[a] + 1) + f64::from(marker.fraction[a])
            });
        }
        Ok(placed)
    }
}
