//! Membrane triangles side by side in the lanes of vectors: energy, and the forces on their corners.
//!
//! A triangle is kept as one matrix A = √area V⁻¹B, which takes its squared elongations s to the coordinates e = A s of its law's cone
//! ([`super::cone`]); its energy is that of e, and ∂E/∂s = Aᵀ ∂E/∂e. Taut, wrinkled and slack triangles take the same path.
//! Triangles whose law has no cone, as with a nonlinear shear law, are left to [`Membrane::respond`].
//!
//! Every lane is computed for itself from single operations that IEEE 754 rounds, none of them fused, and energies are summed lane by lane
//! over 256 triangles: the bits depend neither on the CPU's vectors nor on the number of threads.

use std::collections::HashMap;

use glam::DVec3;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::cone::{Cone, Constants, energy_and_tension};
use super::vectors::{ALONE, CHUNK};
use crate::cloth::elements::EDGES;
use crate::cloth::{Structure, Triangle};
use crate::fabric::membrane::Membrane;
use crate::lattice::Lanes;

/// Triangles of a block; vectors of a CPU hold a whole number of parts of it.
const WIDTH: usize = 8;

/// Blocks whose positions are collected before they are computed, so that vectors read what has left the store buffer.
const GROUP: usize = 4;

/// Blocks of a chunk.
const BLOCKS: usize = CHUNK / WIDTH;

/// One value of every triangle of a block.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
struct Row([f64; WIDTH]);

/// Rest state of eight triangles.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// Squared rest lengths of the edges [m²].
    rest_squares_m2: [Row; 3],
    /// A, row by row [√J/m²].
    coordinates: [[Row; 3]; 3],
    /// Nodes of every triangle, corner by corner.
    nodes: [[u32; WIDTH]; 3],
    /// Number in [`MembraneLanes::palette`].
    laws: u32,
}

/// Laws of the eight triangles of a block.
#[derive(Debug, Clone, Copy)]
struct Palette {
    constants: Constants<Row>,
    steps: u32,
}

/// Triangles of a structure, prepared once.
#[derive(Debug, Clone, Default)]
pub struct MembraneLanes {
    blocks: Vec<Block>,
    palette: Vec<Palette>,
    /// Triangles without a cone, ascending.
    others: Vec<u32>,
    instructions: pulp::Arch,
}

impl MembraneLanes {
    /// Takes the triangles of a structure; none where they have no law.
    #[must_use]
    pub fn new(structure: &Structure) -> Self {
        let Some(laws) = structure.laws() else {
            return Self::default();
        };
        let cones: Vec<Option<Cone>> = laws.all().map(Cone::new).collect();
        let mut lanes = Self::default();
        if cones.iter().all(Option::is_none) {
            lanes.others = (0..structure.triangles.len() as u32).collect();
            return lanes;
        }
        let mut known = HashMap::new();
        for (number, triangles) in structure.triangles.chunks(WIDTH).enumerate() {
            // Triangles without a cone hold zeros, and so do lanes behind the last triangle.
            let mut fabrics = [None; WIDTH];
            let mut block = Block {
                rest_squares_m2: [Row::default(); 3],
                coordinates: [[Row::default(); 3]; 3],
                nodes: [0, 1, 2].map(|corner| [0; WIDTH].map(|_: u32| triangles[0].nodes[corner])),
                laws: 0,
            };
            for (lane, triangle) in triangles.iter().enumerate() {
                let fabric = triangle.fabric as usize;
                let Some(Some(cone)) = cones.get(fabric) else {
                    lanes.others.push((number * WIDTH + lane) as u32);
                    continue;
                };
                fabrics[lane] = Some(fabric);
                block.set(lane, triangle, cone);
            }
            block.laws = *known.entry(fabrics).or_insert_with(|| {
                let of_lanes = fabrics.map(|f| f.and_then(|f| cones[f]));
                lanes.palette.push(Palette::new(of_lanes));
                lanes.palette.len() as u32 - 1
            });
            lanes.blocks.push(block);
        }
        lanes
    }

    /// Writes the gradient of the membrane's energy at the three corners of every triangle [N], `[3 · triangle_count]`, and returns the
    /// energy [J]. The structure must be the one that this was made of.
    pub fn pulls(&self, structure: &Structure, positions: &[DVec3], pulls: &mut Vec<DVec3>) -> f64 {
        pulls.resize(3 * structure.triangles.len(), DVec3::ZERO);
        let one = |(chunk, pulls): (usize, &mut [DVec3])| {
            let blocks = &self.blocks[(chunk * BLOCKS).min(self.blocks.len())..];
            let energy = self.instructions.dispatch(EvaluateChunk {
                blocks: &blocks[..BLOCKS.min(blocks.len())],
                palette: &self.palette,
                positions,
                pulls,
            });
            energy + self.pulls_of_others(structure, positions, chunk, pulls)
        };
        let energies: Vec<f64> = if structure.triangles.len() <= ALONE {
            pulls.chunks_mut(3 * CHUNK).enumerate().map(one).collect()
        } else {
            pulls
                .par_chunks_mut(3 * CHUNK)
                .enumerate()
                .map(one)
                .collect()
        };
        energies.iter().sum()
    }

    /// The same for the triangles of a chunk that have no cone.
    fn pulls_of_others(
        &self,
        structure: &Structure,
        positions: &[DVec3],
        chunk: usize,
        pulls: &mut [DVec3],
    ) -> f64 {
        let Some(laws) = structure.laws() else {
            return 0.0;
        };
        let [first, end] = [chunk, chunk + 1].map(|chunk| {
            self.others
                .partition_point(|&t| (t as usize) < chunk * CHUNK)
        });
        let mut sum = 0.0;
        for &t in &self.others[first..end] {
            let triangle = &structure.triangles[t as usize];
            let (pull, energy) = triangle_pulls(laws.of(triangle), triangle, positions);
            let place = 3 * (t as usize - chunk * CHUNK);
            pulls[place..place + 3].copy_from_slice(&pull);
            sum += energy;
        }
        sum
    }
}

/// Gradient at the corners of a triangle [N], and its energy [J], without lanes.
fn triangle_pulls(
    membrane: &Membrane,
    triangle: &Triangle,
    positions: &[DVec3],
) -> ([DVec3; 3], f64) {
    let edges = triangle.edge_vectors(positions);
    let response = membrane.respond(&triangle.strain(&edges));
    let (b, t) = (&triangle.strain_from_squares, &response.tension);
    let area = triangle.rest_area_m2;
    let mut pulls = [DVec3::ZERO; 3];
    for (i, [from, to]) in EDGES.into_iter().enumerate() {
        // ∂s_i/∂x = ±2 (x_to − x_from).
        let pull = edges[i] * (2.0 * area * (b[0][i] * t[0] + b[1][i] * t[1] + b[2][i] * t[2]));
        pulls[to] += pull;
        pulls[from] -= pull;
    }
    (pulls, area * response.energy)
}

impl Block {
    /// Puts a triangle into a lane.
    fn set(&mut self, lane: usize, triangle: &Triangle, cone: &Cone) {
        let root = triangle.rest_area_m2.sqrt();
        let b = &triangle.strain_from_squares;
        for k in 0..3 {
            self.nodes[k][lane] = triangle.nodes[k];
            self.rest_squares_m2[k].0[lane] = triangle.rest_squares_m2[k];
            for i in 0..3 {
                let row = &cone.from_strain[k];
                self.coordinates[k][i].0[lane] =
                    root * (row[0] * b[0][i] + row[1] * b[1][i] + row[2] * b[2][i]);
            }
        }
    }
}

impl Palette {
    /// Laws lane by lane; lanes without one have zeros.
    fn new(cones: [Option<Cone>; WIDTH]) -> Self {
        let constants = cones.map(|cone| cone.map_or(Constants::default(), |c| c.constants));
        let of = |value: fn(&Constants<f64>) -> f64| Row(constants.map(|c| value(&c)));
        Self {
            constants: Constants {
                shares: [of(|c| c.shares[0]), of(|c| c.shares[1])],
                rests: [of(|c| c.rests[0]), of(|c| c.rests[1])],
                weights: [of(|c| c.weights[0]), of(|c| c.weights[1])],
                residual: of(|c| c.residual),
            },
            steps: cones.iter().flatten().map(|c| c.steps).max().unwrap_or(0),
        }
    }
}

impl Row {
    /// A part of the lanes, as one vector.
    #[inline(always)]
    fn part<S: Simd>(&self, simd: S, part: usize) -> Lanes<S, f64> {
        Lanes::new(simd, S::as_simd_f64s(&self.0).0[part])
    }

    #[inline(always)]
    fn set_part<S: Simd>(&mut self, part: usize, value: Lanes<S, f64>) {
        S::as_mut_simd_f64s(&mut self.0).0[part] = value.vector;
    }
}

impl Constants<Row> {
    /// A part of the lanes, as vectors.
    #[inline(always)]
    fn part<S: Simd>(&self, simd: S, part: usize) -> Constants<Lanes<S, f64>> {
        let [c2, c3] = &self.shares;
        let [d2, d3] = &self.rests;
        let [w2, w3] = &self.weights;
        Constants {
            shares: [c2.part(simd, part), c3.part(simd, part)],
            rests: [d2.part(simd, part), d3.part(simd, part)],
            weights: [w2.part(simd, part), w3.part(simd, part)],
            residual: self.residual.part(simd, part),
        }
    }
}

/// Positions of the corners of a block [m], or the pulls on them [N]: corner by corner, and axis by axis.
type Corners = [[Row; 3]; 3];

/// One chunk of triangles.
struct EvaluateChunk<'a> {
    blocks: &'a [Block],
    palette: &'a [Palette],
    positions: &'a [DVec3],
    pulls: &'a mut [DVec3],
}

impl WithSimd for EvaluateChunk<'_> {
    type Output = f64;

    /// Energy [J].
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut sums = Row::default();
        let mut corners: [Corners; GROUP] = Default::default();
        let groups = self.blocks.chunks(GROUP);
        for (blocks, pulls) in groups.zip(self.pulls.chunks_mut(3 * WIDTH * GROUP)) {
            for (block, corners) in blocks.iter().zip(&mut corners) {
                collect(block, self.positions, corners);
            }
            for (block, corners) in blocks.iter().zip(&mut corners) {
                let palette = &self.palette[block.laws as usize];
                for part in 0..WIDTH / S::F64_LANES {
                    evaluate(simd, block, palette, part, corners, &mut sums);
                }
            }
            for (corners, pulls) in corners.iter().zip(pulls.chunks_mut(3 * WIDTH)) {
                distribute(corners, pulls);
            }
        }
        sums.0.iter().sum()
    }
}

/// Positions of the corners of a block.
#[inline(always)]
fn collect(block: &Block, positions: &[DVec3], corners: &mut Corners) {
    for (nodes, corner) in block.nodes.iter().zip(corners) {
        for lane in 0..WIDTH {
            let place = positions[nodes[lane] as usize];
            corner[0].0[lane] = place.x;
            corner[1].0[lane] = place.y;
            corner[2].0[lane] = place.z;
        }
    }
}

/// Pulls on the corners of a block, triangle by triangle.
#[inline(always)]
fn distribute(corners: &Corners, pulls: &mut [DVec3]) {
    for (lane, pulls) in pulls.chunks_exact_mut(3).enumerate().take(WIDTH) {
        for (corner, pull) in corners.iter().zip(pulls) {
            *pull = DVec3::new(corner[0].0[lane], corner[1].0[lane], corner[2].0[lane]);
        }
    }
}

/// Replaces the positions of the corners by the pulls on them, in a part of the lanes, and adds the energies [J].
// Closures would be called, not inlined, and vectors then go through memory.
#[inline(always)]
fn evaluate<S: Simd>(
    simd: S,
    block: &Block,
    palette: &Palette,
    part: usize,
    corners: &mut Corners,
    sums: &mut Row,
) {
    let zero = Lanes::splat(simd, 0.0);
    let mut edges = [[zero; 3]; 3];
    let mut s = [zero; 3];
    for (i, [from, to]) in EDGES.into_iter().enumerate() {
        for axis in 0..3 {
            edges[i][axis] =
                corners[to][axis].part(simd, part) - corners[from][axis].part(simd, part);
        }
        let [x, y, z] = edges[i];
        s[i] = x * x + y * y + z * z - block.rest_squares_m2[i].part(simd, part);
    }
    let mut e = [zero; 3];
    for k in 0..3 {
        let [a, b, c] = &block.coordinates[k];
        e[k] = a.part(simd, part) * s[0] + b.part(simd, part) * s[1] + c.part(simd, part) * s[2];
    }
    let law = palette.constants.part(simd, part);
    let (energy, t) = energy_and_tension(&e, &law, palette.steps);
    sums.set_part(part, sums.part(simd, part) + energy);
    for i in 0..3 {
        let [a, b, c] = &block.coordinates;
        let half = a[i].part(simd, part) * t[0]
            + b[i].part(simd, part) * t[1]
            + c[i].part(simd, part) * t[2];
        // ∂s/∂x = ±2 (x_to − x_from).
        let pull = half + half;
        for axis in 0..3 {
            edges[i][axis] = pull * edges[i][axis];
        }
    }
    // At every corner one edge ends and another begins.
    for (corner, [end, begin]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        for axis in 0..3 {
            corners[corner][axis].set_part(part, edges[end][axis] - edges[begin][axis]);
        }
    }
}

#[cfg(test)]
#[path = "membrane_lanes_tests.rs"]
mod tests;
