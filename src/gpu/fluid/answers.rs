//! What a device has of walls that stand still, and its passes between `read_links` and `bounce` ([`super::standing_walls`]).

use bytemuck::Pod;

use super::force_sums::ForceSums;
use super::link_lists::LinkLists;
use super::standing_tables::{PORTION, Push, SIDES_OF_A_THREAD, StandingParameters, Tables};
use crate::cut_links::StandingWalls;
use crate::cut_links::energy::LARGEST_SHARE;
use crate::cut_links::pockets::{KEPT, SHARE};
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Counted, Pipeline};
use crate::gpu::shaders::{self, WORKGROUP};

/// Device's answers along the cut links of standing walls.
#[derive(Debug)]
pub(super) struct Answers {
    /// Number of the search for the links.
    pub search: u64,
    pub counts: StandingParameters,
    pub image_numbers: usize,
    pub parameters: wgpu::Buffer,
    /// By parity of the step to come.
    pub passes: [Passes; 2],
    pub sums: ForceSums,
}

/// Between `read_links` and `bounce`, in this order.
#[derive(Debug)]
pub(super) struct Passes {
    reflect: Option<Counted>,
    share_losses: Option<Counted>,
    answer: Counted,
    lose: Option<Counted>,
    relieve: Option<Counted>,
    gather_rest: Counted,
}

impl Passes {
    pub fn record(&self, pass: &mut Pass<'_>) {
        let of_images = [&self.reflect, &self.share_losses];
        let after = [&self.lose, &self.share_losses, &self.relieve];
        let all = (of_images.into_iter().flatten())
            .chain([&self.answer])
            .chain(after.into_iter().flatten())
            .chain([&self.gather_rest]);
        for (bound, groups) in all {
            bound.dispatch(pass, *groups);
        }
    }
}

/// A buffer of `entries`; of one that nobody reads where there are none, for a buffer has room for one at least.
fn table<T: Pod>(device: &Device, label: &str, entries: &[T]) -> Result<wgpu::Buffer, DeviceError> {
    match entries {
        [] => device.storage_of(label, &[T::zeroed()]),
        _ => device.storage_of(label, entries),
    }
}

/// Names, and buffers that do not depend on the parity of a step.
type Named = Vec<(&'static str, wgpu::Buffer)>;

impl Answers {
    pub fn new(
        device: &Device,
        walls: &StandingWalls,
        (lists, image_numbers): (&LinkLists, usize),
        (bodies, most): (&[Vec<Push>], usize),
    ) -> Result<Self, DeviceError> {
        let tables = Tables::new(walls, bodies);
        let (rest_starts, rest_parts) = tables.of_rest(walls, lists);
        let counts = StandingParameters {
            sums_from: 0,
            portions: (tables.pushes.len() / PORTION) as u32,
            blocks: tables.blocks.len() as u32,
            spaces: tables.spaces.len() as u32,
            pockets: tables.pockets.len() as u32,
            cells: lists.at_rest.count() as u32,
            sides: tables.sides.len() as u32,
            padding: 0,
        };
        let parameters = device.uniform::<StandingParameters>("standing walls")?;
        let sums = ForceSums::new(device, tables.bodies, most)?;
        let words = |label, count: u32| device.storage(label, 4 * u64::from(count));
        let named: Named = vec![
            ("sides", table(device, "sides", &tables.sides)?),
            ("images", table(device, "images", &tables.images)?),
            ("blocks", table(device, "blocks", &tables.blocks)?),
            ("spaces", table(device, "spaces", &tables.spaces)?),
            (
                "blocks_of_spaces",
                table(device, "blocks of spaces", &tables.blocks_of_spaces)?,
            ),
            ("pushes", table(device, "pushes", &tables.pushes)?),
            ("pockets", table(device, "pockets", &tables.pockets)?),
            (
                "pocket_sides",
                table(device, "pocket sides", &tables.pocket_sides)?,
            ),
            ("rest_starts", table(device, "rest starts", &rest_starts)?),
            ("rest_parts", table(device, "rest parts", &rest_parts)?),
            (
                "reflected",
                words("reflected", 4 * tables.images.len() as u32)?,
            ),
            ("losses", words("losses", 2 * counts.blocks)?),
            ("given", words("given", counts.blocks)?),
            ("left", words("left", counts.sides)?),
            ("let_out", words("let out", counts.pockets)?),
            // Where the air sticks everywhere, nothing is read of images.
            ("cell_numbers", words("no cells", 0)?),
        ];
        let constants = [
            ("LARGEST_SHARE", LARGEST_SHARE),
            ("KEPT_EXCESS", KEPT),
            ("LET_OUT_SHARE", SHARE),
            ("SIDES_OF_A_THREAD", SIDES_OF_A_THREAD as f64),
        ];
        let pipelines = device.pipelines(
            &shaders::STANDING_WALLS,
            [
                "reflect",
                "share_losses",
                "answer",
                "lose",
                "relieve",
                "gather_rest",
            ],
            &constants,
        )?;
        let fixed = [("standing", &parameters), ("force_sums", &sums.buffer)];
        let both = |parity| {
            Passes::new(device, &pipelines, &counts, {
                let mut all: Vec<(&str, &wgpu::Buffer)> = fixed.to_vec();
                all.extend(named.iter().map(|(name, buffer)| (*name, buffer)));
                all.extend(of_parity(lists, parity));
                all
            })
        };
        Ok(Self {
            search: walls.links.search(),
            passes: [both(0)?, both(1)?],
            counts,
            image_numbers,
            parameters,
            sums,
        })
    }
}

/// Numbers of the lists of a parity.
fn of_parity(lists: &LinkLists, parity: usize) -> impl Iterator<Item = (&str, &wgpu::Buffer)> {
    let of_lists = [
        ("link_numbers", &lists.read_links[parity]),
        ("back_numbers", &lists.bounce[parity]),
        // Laid out where the air slides, in place of none.
        ("cell_numbers", &lists.read_images[parity]),
    ];
    (of_lists.into_iter()).filter_map(|(name, list)| Some((name, list.on_device()?)))
}

impl Passes {
    fn new(
        device: &Device,
        [reflect, share_losses, answer, lose, relieve, gather_rest]: &[Pipeline; 6],
        counts: &StandingParameters,
        named: Vec<(&str, &wgpu::Buffer)>,
    ) -> Result<Self, DeviceError> {
        let in_groups = |pipeline: &Pipeline, count: u32, threads: u32| -> Result<_, DeviceError> {
            let groups = device.workgroups(u64::from(count) * u64::from(threads));
            Ok((device.bind(pipeline, &named)?, groups))
        };
        let some = |pipeline: &Pipeline, count: u32, threads: u32| {
            (count > 0)
                .then(|| in_groups(pipeline, count, threads))
                .transpose()
        };
        Ok(Self {
            reflect: some(reflect, counts.blocks, WORKGROUP)?,
            share_losses: some(share_losses, counts.spaces, WORKGROUP)?,
            answer: in_groups(answer, counts.portions, WORKGROUP)?,
            lose: some(lose, counts.blocks, WORKGROUP)?,
            relieve: some(relieve, counts.pockets, 1)?,
            gather_rest: in_groups(gather_rest, counts.cells, 1)?,
        })
    }
}
