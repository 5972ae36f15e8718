//! What the host tells a device of walls that move ([`super::moving_walls`]), and what lies between its passes.

use crate::gpu::shaders::parameters;

parameters! {
    /// What a step of the device needs to know.
    WallParameters {
        /// First cell of the box around the surface.
        box_first: [i32; 4],
        /// Its size.
        box_size: [i32; 4],
        /// Cells of the lattice.
        cells: [i32; 4],
        /// Cells of the box.
        box_count: u32,
        /// Blocks of them that are scanned.
        block_count: u32,
        /// Triangles.
        triangles: u32,
        /// Links that there is room for.
        most_links: u32,
        /// Cells beside links that there is room for.
        most_cells: u32,
        /// 1 in an odd step.
        odd: u32,
        /// Element of the lattice's first cell.
        first_element: u32,
        /// Elements from row to row.
        stride_y: u32,
        /// Elements from plane to plane.
        stride_z: u32,
        /// Where the sums of the forces of this step go.
        sums_from: u32,
        /// Portions of the links whose forces are summed.
        portions: u32,
        /// Unused.
        padding: u32,
    }
    /// A node of the surface.
    WallNode {
        /// The cell whose centre is nearest.
        cell: [i32; 3],
        /// Unused.
        padding_a: u32,
        /// Where the node is from there [cells].
        offset: [f32; 3],
        /// Unused.
        padding_b: u32,
        /// Cells per step.
        velocity: [f32; 3],
        /// Unused.
        padding_c: u32,
    }
    /// Which look at the triangles it is.
    LookParameters {
        /// 0, 1, 2.
        number: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
        /// Unused.
        padding_c: u32,
    }
    /// A link as the looks find it.
    FoundLink {
        /// Complement of the bits of the first cut's distance.
        first_complement: u32,
        /// Bits of the last one's.
        last: u32,
        /// Complement of the triangle of the first.
        first_triangle_complement: u32,
        /// Triangle of the last.
        last_triangle: u32,
        /// Cuts on it.
        layers: u32,
        /// Nine times the place of its first cell in the box, plus the pair.
        place: u32,
    }
    /// What one side of a link gets back.
    CutSide {
        /// Weights of the nodes of its triangle.
        weights: [f32; 3],
        /// The triangle.
        triangle: u32,
        /// Share of what left.
        share: f32,
        /// Share of the further population.
        further: f32,
        /// Share of the wall's velocity.
        strength: f32,
        /// Cuts on the link.
        layers: u32,
    }
}

impl WallNode {
    /// A node at `position` [cells] that moves with `velocity` [cells per step].
    #[must_use]
    pub fn new(position: [f64; 3], velocity: [f64; 3]) -> Self {
        let cell = position.map(f64::round);
        Self {
            cell: cell.map(|place| place as i32),
            offset: std::array::from_fn(|a| (position[a] - cell[a]) as f32),
            velocity: velocity.map(|component| component as f32),
            ..Self::default()
        }
    }
}
