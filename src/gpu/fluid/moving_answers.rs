//! What a device finds links of moving walls with, and answers along them ([`super::moving_walls`]).

use super::force_sums::{ForceAndMoment, ForceSums};
use super::link_lists::LinkParameters;
use super::moving_tables::{CutSide, FoundLink, LookParameters, WallNode, WallParameters};
use super::names::by_number;
use crate::cut_links::pockets::{KEPT, SHARE};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders::{self, WORKGROUP};
use crate::lattice::Storage;
use crate::lattice::grid::Grid;

/// Cells that one workgroup scans, as in the shader.
pub(super) const BLOCK: u64 = 1024;

/// Links that a plane cuts over its area in cells², at most: √35 = 5.92, of a plane with the normal (5, 3, 1). A mesh adds some at its ends.
const LINKS_OF_A_CELL: f64 = 6.2;
const FURTHER_LINKS: u64 = 1000;

/// Links of a portion that one thread sums, and all.
const LINKS_OF_A_THREAD: u64 = 4;
const PORTION: u64 = LINKS_OF_A_THREAD * WORKGROUP as u64;

/// Room for one cell more for so many of the box, when the room is made anew.
const SPARE: u64 = 4;

/// Surfaces that move.
#[derive(Debug)]
pub struct MovingWalls<'a> {
    /// Nodes of the triangles.
    pub triangles: &'a [[u32; 3]],
    /// What each belongs to: 0 fabric, 1 and more a body.
    pub bodies: &'a [u32],
    /// Bodies, and one for the fabric, whose forces are summed; none where fabric is solved.
    pub count: usize,
    /// Nodes in all.
    pub nodes: usize,
    /// Area of the triangles [cells²].
    pub area: f64,
    /// Factor by which it may grow before room is made anew.
    pub growth: f64,
}

/// What a device finds links with, and answers along them.
#[derive(Debug)]
pub(super) struct Moving {
    pub counts: WallParameters,
    pub parameters: wgpu::Buffer,
    looks: [wgpu::Buffer; 3],
    /// By name, what does not depend on the box.
    pub named: Vec<(&'static str, wgpu::Buffer)>,
    find: [Pipeline; 4],
    answer: [Pipeline; 3],
    pub read_links: Bound,
    pub bounce: Bound,
    /// How many populations these read and write, on the device.
    pub read_parameters: wgpu::Buffer,
    pub bounce_parameters: wgpu::Buffer,
    pub boxed: Option<Boxed>,
    /// False where fabric is solved, which knows of its forces itself.
    pub sums_forces: bool,
    pub sums: ForceSums,
}

/// What belongs to the cells of the box.
#[derive(Debug)]
pub(super) struct Boxed {
    capacity: u64,
    pub around: wgpu::Buffer,
    pub starts: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub look_along: [Bound; 3],
    pub scan_cells: Bound,
    pub scan_blocks: Bound,
    pub lay_links: Bound,
    pub answer: Bound,
    pub gather_rest: Bound,
    pub sum_forces: Bound,
}

/// What was wrong, by what a device leaves where it finds links.
#[must_use]
pub const fn trouble(left: u32) -> Option<&'static str> {
    match left {
        0 => None,
        1 => Some(
            "a surface left the box of cells that was laid around it: it moved farther than any that the wind moves; look at its loads",
        ),
        _ => Some(
            "surfaces cut more links than there is room for: fabric was stretched by half and more; look at its loads and its stiffness",
        ),
    }
}

/// Fails where the device could not find all links: what it left behind the sums of a step.
pub(super) fn untroubled(left: &ForceAndMoment) -> Result<(), DeviceError> {
    match trouble(left[0][0] as u32) {
        None => Ok(()),
        Some(what) => Err(DeviceError::Command(what.to_owned())),
    }
}

/// Links that there is room for, of triangles of this area [cells²].
fn links_of(area: f64) -> u64 {
    (LINKS_OF_A_CELL * area) as u64 + FURTHER_LINKS
}

pub(super) fn not_laid() -> DeviceError {
    DeviceError::Command("walls that move are answered before they are laid out".to_owned())
}

impl Moving {
    /// For walls in air of this layout, whose populations are stored so; room for the forces of `most_steps` steps.
    pub fn new(
        device: &Device,
        (grid, storage, populations): (&Grid, Storage, &[wgpu::Buffer]),
        walls: &MovingWalls<'_>,
        most_steps: usize,
    ) -> Result<Self, DeviceError> {
        let most_links = links_of(walls.growth * walls.area);
        let portions = most_links.div_ceil(PORTION);
        let ends = (1..=walls.count).map(|body| body * portions as usize);
        // And one for what went wrong.
        let all = walls.count * portions as usize + 1;
        let sums = ForceSums::new(device, ends.chain([all]).collect(), most_steps)?;
        let [x, y, z] = grid.cells.map(|count| count as i32);
        let counts = WallParameters {
            cells: [x, y, z, 0],
            triangles: walls.triangles.len() as u32,
            most_links: most_links as u32,
            most_cells: 2 * most_links as u32,
            first_element: grid.index([0; 3]) as u32,
            stride_y: grid.stride_y as u32,
            stride_z: grid.stride_z as u32,
            portions: portions as u32,
            ..WallParameters::default()
        };
        let corners = walls.triangles.iter().zip(walls.bodies);
        let triangles: Vec<[u32; 4]> = corners.map(|(&[a, b, c], body)| [a, b, c, *body]).collect();
        let numbers = 4 * 4 * most_links;
        let bytes_of = |each: usize, count: u64| each as u64 * count;
        let buffer = |label, bytes| device.storage(label, bytes);
        let named = vec![
            (
                "wall_nodes",
                buffer(
                    "nodes of walls",
                    bytes_of(size_of::<WallNode>(), walls.nodes as u64),
                )?,
            ),
            (
                "wall_triangles",
                device.storage_of("triangles of walls", &triangles)?,
            ),
            (
                "shared_velocities",
                buffer(
                    "shared velocities",
                    bytes_of(16, walls.triangles.len() as u64),
                )?,
            ),
            ("totals", buffer("numbers of links", 40)?),
            (
                "cut_sides",
                buffer("cuts", bytes_of(size_of::<CutSide>(), 2 * most_links))?,
            ),
            (
                "found",
                buffer("found links", bytes_of(size_of::<FoundLink>(), most_links))?,
            ),
            ("trouble", buffer("trouble", 8)?),
            ("read_places", buffer("places read", 2 * numbers)?),
            ("back_places", buffer("places written", 2 * numbers)?),
            ("link_numbers", buffer("what left", numbers)?),
            ("back_numbers", buffer("what comes back", numbers)?),
            ("answered", buffer("answers", numbers)?),
            (
                "moment_points",
                buffer(
                    "moment points",
                    bytes_of(size_of::<WallNode>(), walls.count.max(1) as u64),
                )?,
            ),
        ];
        let looks = [0, 1, 2].map(|number| {
            let look = device.uniform::<LookParameters>("look")?;
            let parameters = LookParameters {
                number,
                ..LookParameters::default()
            };
            device.write(&look, 0, &[parameters]);
            Ok(look)
        });
        let [first, second, third] = looks;
        let constants = [
            ("KEPT_EXCESS", KEPT),
            ("LET_OUT_SHARE", SHARE),
            ("LINKS_OF_A_THREAD", LINKS_OF_A_THREAD as f64),
        ];
        let [read, bounce] = device.pipelines(
            &shaders::CUT_LINKS[storage as usize],
            ["read_links", "bounce"],
            &[],
        )?;
        let read_parameters = device.uniform::<LinkParameters>("links read")?;
        let bounce_parameters = device.uniform::<LinkParameters>("links written")?;
        let of = |wanted: &str| named.iter().find(|(name, _)| *name == wanted);
        let on_links = |pipeline: &Pipeline, parameters, [places, numbers]: [&str; 2]| {
            let (Some((_, places)), Some((_, numbers))) = (of(places), of(numbers)) else {
                return Err(not_laid());
            };
            let mut all = by_number(populations);
            all.extend([
                ("link_parameters", parameters),
                ("link_places", places),
                ("link_populations", numbers),
            ]);
            device.bind(pipeline, &all)
        };
        Ok(Self {
            counts,
            parameters: device.uniform::<WallParameters>("walls")?,
            looks: [first?, second?, third?],
            find: device.pipelines(
                &shaders::FIND_LINKS,
                ["look_along", "scan_cells", "scan_blocks", "lay_links"],
                &[],
            )?,
            answer: device.pipelines(
                &shaders::MOVING_WALLS,
                ["answer", "gather_rest", "sum_forces"],
                &constants,
            )?,
            read_links: on_links(&read, &read_parameters, ["read_places", "link_numbers"])?,
            bounce: on_links(&bounce, &bounce_parameters, ["back_places", "back_numbers"])?,
            named,
            read_parameters,
            bounce_parameters,
            boxed: None,
            sums_forces: walls.count > 0,
            sums,
        })
    }

    /// True if there is room for the links of walls of this area [cells²], with a tenth of those that are always there to spare.
    pub fn has_room(&self, area: f64) -> bool {
        links_of(area) <= u64::from(self.counts.most_links) + FURTHER_LINKS / 10
    }

    fn lattice_cells(&self) -> u64 {
        let [x, y, z, _] = self.counts.cells.map(|cells| cells as u64);
        x * y * z
    }

    pub fn buffer(&self, wanted: &str) -> Result<&wgpu::Buffer, DeviceError> {
        (self.named.iter())
            .find_map(|(name, buffer)| (*name == wanted).then_some(buffer))
            .ok_or_else(not_laid)
    }

    /// Room for so many cells of the box.
    pub fn make_room(&mut self, device: &Device, cells: u64) -> Result<(), DeviceError> {
        if (self.boxed.as_ref()).is_some_and(|boxed| boxed.capacity >= cells) {
            return Ok(());
        }
        self.boxed = None;
        let capacity = (cells + cells / SPARE).min(self.lattice_cells());
        let around = device.storage("links around cells", 4 * capacity)?;
        let starts = device.storage("first links of cells", 8 * capacity)?;
        let blocks = device.storage("first links of blocks", 8 * capacity.div_ceil(BLOCK))?;
        let mut all: Vec<(&str, &wgpu::Buffer)> = vec![
            ("walls", &self.parameters),
            ("around", &around),
            ("starts", &starts),
            ("blocks", &blocks),
            ("force_sums", &self.sums.buffer),
            ("found_words", self.buffer("found")?),
        ];
        all.extend(self.named.iter().map(|(name, buffer)| (*name, buffer)));
        let bind = |pipeline: &Pipeline| device.bind(pipeline, &all);
        let [look_along, scan_cells, scan_blocks, lay_links] = &self.find;
        let [answer, gather_rest, sum_forces] = &self.answer;
        let look = |buffer| {
            let mut named = all.clone();
            named.push(("look", buffer));
            device.bind(look_along, &named)
        };
        let [first, second, third] = &self.looks;
        let boxed = Boxed {
            capacity,
            look_along: [look(first)?, look(second)?, look(third)?],
            scan_cells: bind(scan_cells)?,
            scan_blocks: bind(scan_blocks)?,
            lay_links: bind(lay_links)?,
            answer: bind(answer)?,
            gather_rest: bind(gather_rest)?,
            sum_forces: bind(sum_forces)?,
            around,
            starts,
            blocks,
        };
        self.boxed = Some(boxed);
        Ok(())
    }
}
