//! The air on the device, computed in single precision and stored in 32 or 16 bits: one buffer per direction, streamed in place (see [`crate::lattice::grid`]).
//!
//! A storage binding is capped at 2³¹ bytes on many drivers, hence one buffer per direction: 5·10⁸ cells. The parity of a step is
//! a choice between two bind groups.

mod absorbing_faces;
mod answers;
mod at_rest;
mod awaited;
mod collide_ahead;
pub mod collide_stream;
pub mod control_volume;
pub mod cut_links;
pub mod eddy_viscosity;
mod force_box;
mod force_sums;
mod held_eddy_viscosity;
pub mod link_lists;
pub mod macroscopic;
pub mod moving_answers;
pub mod moving_tables;
pub mod moving_walls;
mod names;
pub mod parameters;
mod read_back;
pub mod repeat_plane;
pub mod standing_tables;
pub mod standing_walls;
pub mod transfer;

use std::sync::Arc;
use std::time::Duration;

use half::f16;
use rayon::prelude::*;

use super::device::Device;
use super::error::DeviceError;
use super::pipeline::{Bound, Counted, Pipeline};
use super::shaders;
use super::tuning::Padding;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::lattice::grid::{Grid, Initial, InletProfile, PADDED_ELEMENTS, ProfileRow, Setup};
use crate::lattice::links::Boundaries;
use crate::lattice::start::Start;
use crate::lattice::{DIRECTION_COUNT, F16_SCALE, Storage};
use absorbing_faces::AbsorbingFaces;
use answers::Answers;
use awaited::Awaited;
pub use control_volume::VolumeWatch;
pub use force_box::ForceBox;
use held_eddy_viscosity::HeldEddyViscosity;
use link_lists::LinkLists;
use moving_answers::Moving;
use names::{by_number, by_parity, constants};
use parameters::{BoundaryCopy, StepParameters};
use read_back::ReadBack;

/// The air: populations, boundaries and the parity of the next step.
#[derive(Debug)]
pub struct Fluid {
    device: Arc<Device>,
    setup: Setup,
    grid: Grid,
    storage: Storage,
    populations: Vec<wgpu::Buffer>,
    step_parameters: wgpu::Buffer,
    /// Without a force, and under a uniform acceleration; by parity.
    free: [Bound; 2],
    accelerated: [Bound; 2],
    forced_pipeline: Pipeline,
    /// With the body force near the sheet, by parity, and the generation of the force box that it is bound to.
    forced: Option<([Bound; 2], u64)>,
    boundaries: Option<[Counted; 2]>,
    /// `None` where no face lets sound out.
    absorbing_faces: Option<AbsorbingFaces>,
    /// `None` until surfaces cut links.
    link_lists: Option<LinkLists>,
    /// `None` unless the device answers along cut links by itself: of walls that stand, and of walls that move.
    answers: Option<Answers>,
    moving: Option<Moving>,
    /// Links that walls cut in the last step whose forces were fetched, where the device finds them.
    moving_links: usize,
    /// `None` where no model needs the velocity gradient.
    held_eddy_viscosity: Option<HeldEddyViscosity>,
    read_back: ReadBack,
    /// See [`inlet_profile`]; `None` where the wind is the same everywhere.
    inlet_profile: Option<wgpu::Buffer>,
    inlet_velocity: [f64; 3],
    /// Uniform acceleration of the last step.
    last_acceleration: [f64; 3],
    odd: bool,
    steps: u64,
    /// Cells whose step is still to come, where all others have made it.
    awaited: Option<Awaited>,
    /// Measured duration of one plane, which bounds the planes of a submission.
    plane_time: Option<Duration>,
    timed_submissions: u32,
}

impl Fluid {
    /// Air that begins with the given density excess and velocity, `initial(cell) = (δρ, u)` in lattice units
    /// ([`crate::lattice::start`]); at rest where it is `None`.
    pub fn new(
        device: &Arc<Device>,
        setup: Setup,
        storage: Storage,
        initial: Option<&Initial>,
    ) -> Result<Self, DeviceError> {
        let grid = padded(setup.cells, device.tuning().padding);
        if storage == Storage::F16 {
            device.require_f16()?;
        }
        let bytes = storage.bytes() * grid.total as u64;
        let groups = grid.stride_z.div_ceil(device.tuning().workgroup as usize) as u64;
        if groups > u64::from(device.workgroup_limit()) {
            return Err(DeviceError::Limit {
                what: "a plane of cells".to_owned(),
                needed: groups,
                limit: device.workgroup_limit().into(),
                limit_name: "max_compute_workgroups_per_dimension",
                device: device.info().name.clone(),
                remedy: "choose larger cells, a tunnel longer and less wide, or --engine cpu",
            });
        }
        let populations = (0..DIRECTION_COUNT)
            .map(|direction| device.storage(&format!("populations {direction}"), bytes))
            .collect::<Result<Vec<_>, _>>()?;
        let step_parameters = device.uniform::<StepParameters>("step")?;
        let constants = constants(device.tuning(), &setup, &grid);
        let held_eddy_viscosity =
            HeldEddyViscosity::new(device, &setup, &grid, storage, &populations, &constants)?;
        let inlet_profile = inlet_profile(device, &setup)?;
        let shaders = match (&held_eddy_viscosity, &inlet_profile) {
            (None, None) => &shaders::COLLIDE_STREAM,
            (Some(_), None) => &shaders::COLLIDE_STREAM_HELD,
            (None, Some(_)) => &shaders::COLLIDE_STREAM_PROFILED,
            (Some(_), Some(_)) => &shaders::COLLIDE_STREAM_HELD_PROFILED,
        };
        let [free, accelerated, forced_pipeline] = device.pipelines(
            &shaders[storage as usize],
            [
                "collide_stream",
                "collide_stream_accelerated",
                "collide_stream_forced",
            ],
            &constants,
        )?;
        let both = |pipeline: &Pipeline,
                    profile: Option<&wgpu::Buffer>|
         -> Result<[Bound; 2], DeviceError> {
            let mut named = [false, true].map(|odd| by_parity(&populations, odd));
            for names in &mut named {
                names.push(("step", &step_parameters));
                names.extend(held_eddy_viscosity.iter().map(HeldEddyViscosity::named));
                names.extend(profile.map(|profile| ("profile", profile)));
            }
            Ok([
                device.bind(pipeline, &named[0])?,
                device.bind(pipeline, &named[1])?,
            ])
        };
        let free = both(&free, None)?;
        let accelerated = both(&accelerated, inlet_profile.as_ref())?;
        let boundaries = boundaries(device, &setup, &grid, storage, &populations)?;
        let absorbing_faces = AbsorbingFaces::new(
            device,
            &setup,
            &grid,
            storage,
            &populations,
            &step_parameters,
            inlet_profile.as_ref(),
        )?;
        let read_back = ReadBack::new(device, &grid, storage, &populations, &constants)?;
        let mut fluid = Self {
            device: Arc::clone(device),
            grid,
            storage,
            populations,
            step_parameters,
            free,
            accelerated,
            forced_pipeline,
            forced: None,
            boundaries,
            absorbing_faces,
            link_lists: None,
            answers: None,
            moving: None,
            moving_links: 0,
            held_eddy_viscosity,
            read_back,
            inlet_profile,
            inlet_velocity: [0.0; 3],
            last_acceleration: [0.0; 3],
            odd: false,
            steps: 0,
            awaited: None,
            plane_time: None,
            timed_submissions: 0,
            setup,
        };
        if let Some(initial) = initial {
            fluid.fill(&Start::new(&fluid.setup, initial));
        }
        fluid.device.check()?;
        Ok(fluid)
    }

    /// Takes the populations of a start, before the first step.
    pub fn fill(&mut self, start: &Start) {
        for array in 0..DIRECTION_COUNT {
            // In an even step array i holds what comes from the local slot of i − 1 or from the far slot of i + 1.
            let direction = crate::lattice::opposite(array);
            let (_, data) = self.first_planes(start, direction, self.grid.cells[2]);
            self.write_populations(array, &data);
        }
        if let Some(faces) = &self.absorbing_faces {
            faces.fill(&self.device, &self.setup, start);
        }
    }

    /// Populations of the first `planes` of a start as their array holds them before an even step, from its first element on, and the
    /// element at which the first plane begins. A multiple of two elements, as transfers need in 16 bits.
    fn first_planes(&self, start: &Start, direction: usize, planes: usize) -> (usize, Vec<f32>) {
        let grid = self.grid;
        let [nx, ny, nz] = grid.cells;
        let (_, origin) = grid.slot(grid.index([0; 3]), direction, false);
        let first = origin - 1;
        let end = if planes == nz {
            grid.total
        } else {
            first + planes * grid.stride_z
        };
        let mut data = vec![0f32; end.next_multiple_of(2)];
        data[first..]
            .par_chunks_mut(grid.stride_z)
            .enumerate()
            .take(planes)
            .for_each(|(z, plane)| {
                for y in 0..ny {
                    for x in 0..nx {
                        let cell = [x, y, z];
                        plane[1 + x + y * grid.stride_y] = start.population(cell, direction) as f32;
                        if direction == 0 && x + 1 == nx {
                            // An outlet's ghost remembers the density excess of the last cell.
                            plane[2 + x + y * grid.stride_y] = start.density_excess(cell) as f32;
                        }
                    }
                }
            });
        (first, data)
    }

    fn write_populations(&self, array: usize, data: &[f32]) {
        let buffer = &self.populations[array];
        match self.storage {
            Storage::F32 => self.device.write(buffer, 0, data),
            Storage::F16 => {
                let packed: Vec<f16> = data.iter().map(|&f| f16::from_f32(f * F16_SCALE)).collect();
                self.device.write(buffer, 0, &packed);
            }
        }
    }

    /// What the air was built from.
    #[must_use]
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> &Grid {
        &self.grid
    }

    /// How populations are stored.
    #[must_use]
    pub const fn population_storage(&self) -> Storage {
        self.storage
    }

    /// The device.
    #[must_use]
    pub const fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// True after an odd number of steps.
    #[must_use]
    pub const fn is_odd(&self) -> bool {
        self.odd
    }

    /// Velocity at the inlet in the steps to come [cells per step].
    pub const fn set_inlet_velocity(&mut self, velocity: [f64; 3]) {
        self.inlet_velocity = velocity;
    }

    /// True if the next step is odd.
    pub(super) const fn odd(&self) -> bool {
        self.odd
    }

    /// The populations as the stages that read them whole name them, for a step of the given parity.
    pub(super) fn named_populations(&self, odd: bool) -> Vec<(&'static str, &wgpu::Buffer)> {
        by_parity(&self.populations, odd)
    }

    /// Pipeline constants of the scene.
    pub(super) fn constants(&self) -> Vec<(&'static str, f64)> {
        constants(self.device.tuning(), &self.setup, &self.grid)
    }
}

/// The grid of the device; without padding it is that of checkpoints, too.
fn padded(cells: [usize; 3], padding: Padding) -> Grid {
    match padding {
        Padding::None => Grid::new(cells),
        Padding::Planes => Grid::padded(cells, [1, PADDED_ELEMENTS]),
        Padding::Rows => Grid::padded(cells, [PADDED_ELEMENTS, 1]),
    }
}

/// The copies after a step, by the parity of the step to come; `None` if nothing has to be copied.
fn boundaries(
    device: &Device,
    setup: &Setup,
    grid: &Grid,
    storage: Storage,
    populations: &[wgpu::Buffer],
) -> Result<Option<[Counted; 2]>, DeviceError> {
    let links = Boundaries::new(grid, setup.ends, setup.sides);
    if links.copies.iter().all(Vec::is_empty) {
        return Ok(None);
    }
    let moving = f64::from(u8::from(links.moving()));
    let [pipeline] = device.pipelines(
        &shaders::BOUNDARIES[storage as usize],
        ["boundaries"],
        &[("MOVING_WALLS", moving)],
    )?;
    let bound = |runs: &[crate::lattice::links::Run]| -> Result<_, DeviceError> {
        let mut copies: Vec<BoundaryCopy> = runs
            .iter()
            .flat_map(|run| {
                (0..run.length).map(|k| BoundaryCopy {
                    arrays: u32::from(run.to_array) + 32 * u32::from(run.from_array),
                    to_slot: run.to + k,
                    from_slot: run.from + k,
                    added: run.added as f32,
                })
            })
            .collect();
        copies.sort_unstable_by_key(|copy| (copy.arrays, copy.to_slot));
        let list = device.storage_of("boundary copies", &copies)?;
        let mut named = by_number(populations);
        named.push(("copies", &list));
        Ok((
            device.bind(&pipeline, &named)?,
            device.workgroups(copies.len() as u64),
        ))
    };
    Ok(Some([bound(&links.copies[0])?, bound(&links.copies[1])?]))
}

impl Fluid {
    /// Writes populations, parity and step count; in 32 bits the same sections as the CPU engine in single precision.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        self.check_readable().map_err(std::io::Error::other)?;
        out.put("air_steps", &[self.steps, u64::from(self.odd)])?;
        out.put("inlet_velocity", &self.inlet_velocity)?;
        for (array, buffer) in self.populations.iter().enumerate() {
            let name = format!("populations_{array:02}");
            match self.storage {
                Storage::F32 => self.save_packed::<f32>(out, &name, buffer)?,
                Storage::F16 => self.save_packed::<f16>(out, &name, buffer)?,
            }
        }
        if let Some(faces) = &self.absorbing_faces {
            faces.save(&self.device, out)?;
        }
        if let Some(held) = &self.held_eddy_viscosity {
            let (buffer, count) = (&held.relaxation_times, self.grid.cell_count());
            self.save_stored(out, "eddy_relaxation_times", buffer, count)?;
        }
        Ok(())
    }

    /// Takes them from a checkpoint of the same grid.
    pub fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let counters: Vec<u64> = from.take_exactly("air_steps", 2)?;
        self.awaited = None;
        self.steps = counters[0];
        self.odd = counters[1] == 1;
        self.inlet_velocity
            .copy_from_slice(&from.take_exactly::<f64>("inlet_velocity", 3)?);
        for (array, buffer) in self.populations.iter().enumerate() {
            let name = format!("populations_{array:02}");
            match self.storage {
                Storage::F32 => self.restore_packed::<f32>(from, &name, buffer)?,
                Storage::F16 => self.restore_packed::<f16>(from, &name, buffer)?,
            }
        }
        if let Some(faces) = &self.absorbing_faces {
            faces.restore(&self.device, from)?;
        }
        if let Some(held) = &self.held_eddy_viscosity {
            let (buffer, count) = (&held.relaxation_times, self.grid.cell_count());
            self.restore_stored(from, "eddy_relaxation_times", buffer, count)?;
        }
        if let Some(held) = &mut self.held_eddy_viscosity {
            // Evaluated anew if the step to come asks for it.
            held.evaluated = None;
        }
        Ok(())
    }

    /// Writes an array of populations without the padding of rows and planes, as every engine does.
    fn save_packed<T: bytemuck::Pod>(
        &self,
        out: &mut Writer,
        name: &str,
        buffer: &wgpu::Buffer,
    ) -> std::io::Result<()> {
        let padded = self.device.read::<T>(buffer, 0, self.grid.total);
        let padded = padded.map_err(std::io::Error::other)?;
        let mut packed = Vec::with_capacity(Grid::new(self.setup.cells).total);
        for row in self.grid.rows() {
            packed.extend_from_slice(&padded[row]);
        }
        out.put(name, &packed)
    }

    /// Takes such an array.
    fn restore_packed<T: bytemuck::Pod>(
        &self,
        from: &Reader,
        name: &str,
        buffer: &wgpu::Buffer,
    ) -> Result<(), CheckpointError> {
        let packed_grid = Grid::new(self.setup.cells);
        let packed: Vec<T> = from.take_exactly(name, packed_grid.total)?;
        let mut padded = vec![T::zeroed(); self.grid.total];
        for (row, packed_row) in self.grid.rows().zip(packed_grid.rows()) {
            padded[row].copy_from_slice(&packed[packed_row]);
        }
        self.device.write::<T>(buffer, 0, &padded);
        Ok(())
    }

    /// Writes a buffer as it is stored.
    fn save_stored(
        &self,
        out: &mut Writer,
        name: &str,
        buffer: &wgpu::Buffer,
        count: usize,
    ) -> std::io::Result<()> {
        match self.storage {
            Storage::F32 => {
                let data = self.device.read::<f32>(buffer, 0, count);
                out.put(name, &data.map_err(std::io::Error::other)?)
            }
            Storage::F16 => {
                let data = self.device.read::<f16>(buffer, 0, count);
                out.put(name, &data.map_err(std::io::Error::other)?)
            }
        }
    }

    /// Takes a buffer as it is stored.
    fn restore_stored(
        &self,
        from: &Reader,
        name: &str,
        buffer: &wgpu::Buffer,
        count: usize,
    ) -> Result<(), CheckpointError> {
        match self.storage {
            Storage::F32 => {
                let data = from.take_exactly(name, count)?;
                self.device.write::<f32>(buffer, 0, &data);
            }
            Storage::F16 => {
                let data = from.take_exactly(name, count)?;
                self.device.write::<f16>(buffer, 0, &data);
            }
        }
        Ok(())
    }

    /// Reads a buffer that stores numbers as populations are stored.
    fn read_stored(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<f32>, DeviceError> {
        match self.storage {
            Storage::F32 => self.device.read(buffer, 0, count),
            Storage::F16 => {
                let data = self.device.read::<f16>(buffer, 0, count)?;
                Ok(data.iter().map(|f| f.to_f32() / F16_SCALE).collect())
            }
        }
    }
}

/// Wind at the inlet that is not the same everywhere, of every row along x, y fastest: its speed over the inlet's, and 3(1 − τ)
/// times its rates of change along y and z.
fn inlet_profile(device: &Device, setup: &Setup) -> Result<Option<wgpu::Buffer>, DeviceError> {
    let of_rate = 3.0 * (1.0 - setup.relaxation_time);
    let rows = |profile: &InletProfile| -> Vec<[f32; 4]> {
        let row = |row: &ProfileRow| {
            let [y, z] = row.shear.map(|rate| (of_rate * rate) as f32);
            [row.ratio as f32, y, z, 0.0]
        };
        profile.rows().iter().map(row).collect()
    };
    (setup.inlet_profile.as_ref())
        .map(|profile| device.storage_of("inlet profile", &rows(profile)))
        .transpose()
}
