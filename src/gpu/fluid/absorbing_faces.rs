//! Stages `absorb_at_inlet` and `absorb_at_sides`: faces that let sound out ([`crate::lattice::faces`]).

use super::names::by_number;
use super::parameters::AbsorbingFace;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::Counted;
use crate::gpu::shaders::{self, WORKGROUP};
use crate::lattice::faces::{
    ALONG_INLET, AbsorbingSide, FACE_MEANS, FaceMeans, INLET_IMPEDANCE, LEAVING_INLET, SIDE_FLOW,
    inlet_tangential, present_share,
};
use crate::lattice::grid::{Grid, Setup};
use crate::lattice::start::Start;
use crate::lattice::{DIRECTIONS, DOWNSTREAM, Storage};

/// The faces of a set-up, by the parity of the step to come.
#[derive(Debug)]
pub(super) struct AbsorbingFaces {
    means: wgpu::Buffer,
    count: usize,
    inlet: Option<[Counted; 2]>,
    /// The sides of y, and those of z.
    sides: Vec<[Counted; 2]>,
}

impl AbsorbingFaces {
    /// Of a set-up; `None` without such a face.
    pub(super) fn new(
        device: &Device,
        setup: &Setup,
        grid: &Grid,
        storage: Storage,
        populations: &[wgpu::Buffer],
        step_parameters: &wgpu::Buffer,
        inlet_profile: Option<&wgpu::Buffer>,
    ) -> Result<Option<Self>, DeviceError> {
        let at_rest = FaceMeans::at_rest(setup);
        let count = at_rest.count();
        if count == 0 {
            return Ok(None);
        }
        let means = device.storage_of("face means", &at_rest.joined())?;
        let [at_inlet, at_sides] = device.pipelines(
            &shaders::ABSORBING_FACES[storage as usize],
            [
                match inlet_profile {
                    None => "absorb_at_inlet",
                    Some(_) => "absorb_at_profiled_inlet",
                },
                "absorb_at_sides",
            ],
            &[
                ("INLET_IMPEDANCE", INLET_IMPEDANCE),
                ("INLET_TANGENTIAL", inlet_tangential(setup.operator)),
                ("SIDE_FLOW", SIDE_FLOW),
                ("PRESENT_SHARE", present_share(setup.cells)),
            ],
        )?;
        let bound = |pipeline, faces: &[AbsorbingFace], inlet| -> Result<Counted, DeviceError> {
            let list = device.storage_of("absorbing faces", faces)?;
            let mut named = by_number(populations);
            named.extend([("faces", &list), ("means", &means)]);
            if inlet {
                named.push(("step", step_parameters));
                named.extend(inlet_profile.map(|profile| ("profile", profile)));
            }
            let cells = faces.iter().map(|face| face.shape[0] * face.shape[1]).max();
            let groups = cells.unwrap_or(0).div_ceil(WORKGROUP);
            Ok((device.bind(pipeline, &named)?, [groups, faces.len() as u32]))
        };
        let inlet = if at_rest.inlet.is_empty() {
            None
        } else {
            let of = |odd| bound(&at_inlet, &[inlet_face(grid, odd)], true);
            Some([of(false)?, of(true)?])
        };
        let mut first_mean = at_rest.inlet.len();
        let mut sides = Vec::new();
        for axis in [1, 2] {
            let mut faces = [Vec::new(), Vec::new()];
            for side in AbsorbingSide::all(setup) {
                if side.axis == axis {
                    for (odd, faces) in [false, true].into_iter().zip(&mut faces) {
                        faces.push(side_face(side, grid, odd, first_mean));
                    }
                    first_mean += side.rows(setup.cells) * setup.cells[0];
                }
            }
            if !faces[0].is_empty() {
                let of = |faces: &[AbsorbingFace]| bound(&at_sides, faces, false);
                sides.push([of(&faces[0])?, of(&faces[1])?]);
            }
        }
        Ok(Some(Self {
            means,
            count,
            inlet,
            sides,
        }))
    }

    /// Recorded before `boundaries`, with the parity of the step to come.
    pub(super) fn record_inlet(&self, pass: &mut Pass<'_>, parity: usize) {
        if let Some(inlet) = &self.inlet {
            let (bound, groups) = &inlet[parity];
            bound.dispatch(pass, *groups);
        }
    }

    /// Recorded after `boundaries`, with the parity of the step to come.
    pub(super) fn record_sides(&self, pass: &mut Pass<'_>, parity: usize) {
        for sides in &self.sides {
            let (bound, groups) = &sides[parity];
            bound.dispatch(pass, *groups);
        }
    }

    /// Takes the state of a start as the mean at the faces.
    pub(super) fn fill(&self, device: &Device, setup: &Setup, start: &Start) {
        let means = FaceMeans::of_start(setup, start);
        device.write(&self.means, 0, &means.joined());
    }

    /// Writes the running means.
    pub(super) fn save(&self, device: &Device, out: &mut Writer) -> std::io::Result<()> {
        let means = device.read::<f32>(&self.means, 0, self.count);
        out.put(FACE_MEANS, &means.map_err(std::io::Error::other)?)
    }

    /// Takes them from a checkpoint.
    pub(super) fn restore(&self, device: &Device, from: &Reader) -> Result<(), CheckpointError> {
        let means: Vec<f32> = from.take_exactly(FACE_MEANS, self.count)?;
        device.write(&self.means, 0, &means);
        Ok(())
    }
}

/// The inlet: what leaves goes to ghosts, and what enters comes from them.
fn inlet_face(grid: &Grid, odd: bool) -> AbsorbingFace {
    let slot = |from: [i64; 3], direction: usize| {
        let c = DIRECTIONS[direction].map(i64::from);
        let to = std::array::from_fn(|a| from[a] + c[a]);
        four(grid.slot(grid.index(to), direction, odd))
    };
    AbsorbingFace {
        leaving: LEAVING_INLET.map(|direction| slot([0; 3], direction)),
        entering: DOWNSTREAM.map(|direction| slot([-1, 0, 0], direction)),
        along: ALONG_INLET.map(|direction| {
            let [array, element, ..] = slot([0; 3], direction);
            let [_, y, z] = DIRECTIONS[direction].map(|c| (c + 1) as u32);
            [array, element, y, z]
        }),
        shape: [grid.cells[1], grid.cells[2], grid.stride_y, grid.stride_z].map(|n| n as u32),
        ..AbsorbingFace::default()
    }
}

/// A side: what leaves has come back.
fn side_face(side: AbsorbingSide, grid: &Grid, odd: bool, first_mean: usize) -> AbsorbingFace {
    let slots = side.slots(grid, odd).map(four);
    AbsorbingFace {
        leaving: slots,
        entering: slots,
        shape: [
            grid.cells[0],
            side.rows(grid.cells),
            1,
            side.row_stride(grid),
        ]
        .map(|n| n as u32),
        first_mean: first_mean as u32,
        ..AbsorbingFace::default()
    }
}

fn four((array, element): (usize, usize)) -> [u32; 4] {
    [array as u32, element as u32, 0, 0]
}
