//! Structs that the stages of the air share with their shaders.

use crate::gpu::shaders::parameters;

parameters! {
    /// What changes from step to step.
    StepParameters {
        /// Velocity at the inlet [cells per step].
        inlet_velocity: [f32; 4],
        /// Uniform acceleration [cells per step²].
        acceleration: [f32; 4],
        /// First cell of the box that holds all forces, or of that whose cells wait for the structure.
        box_first: [u32; 4],
        /// Its size.
        box_size: [u32; 4],
        /// First plane of a dispatch.
        first_plane: u32,
        /// First element of a dispatch in its planes.
        first_element: u32,
        /// Which cells: 0 all, 1 those outside the box, 2 those in it.
        part: u32,
        /// Unused.
        padding: u32,
    }
    /// Where to evaluate, and what lies beyond the faces.
    EddyParameters {
        /// Factors of the velocity before a face, lower and upper along x, y, z; the fourth is 1 where the face is periodic and 2 where it is that of a box of finer cells.
        factors: [[f32; 4]; 6],
        /// What is added [cells per step].
        offsets: [[f32; 4]; 6],
        /// First cell of a dispatch.
        first: u32,
        /// Cells at most.
        count: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
    }
    /// Box of cells to look at.
    Region {
        /// First cell.
        first_cell: [u32; 4],
        /// Size.
        size: [u32; 4],
        /// Number of cells.
        count: u32,
        /// First of them that a dispatch handles.
        offset: u32,
        /// How many it handles at most.
        at_once: u32,
        /// Unused.
        padding: u32,
    }
    /// What a lattice exchanges with a box of finer cells.
    TransferParameters {
        /// Uniform acceleration [cells per step²].
        force: [f32; 4],
        /// Cells of a dispatch.
        count: u32,
        /// States from number to number.
        number_stride: u32,
        /// From row to row.
        row_stride: u32,
        /// From plane to plane.
        plane_stride: u32,
    }
    /// A face that lets sound out.
    AbsorbingFace {
        /// Array and element of the populations of the first cell that leave through it.
        leaving: [[u32; 4]; 5],
        /// Of those that enter.
        entering: [[u32; 4]; 5],
        /// Of those that move along the inlet, and their velocities along y and z, plus one.
        along: [[u32; 4]; 16],
        /// Cells of a row, rows, elements from cell to cell, elements from row to row.
        shape: [u32; 4],
        /// Where its running means begin.
        first_mean: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
        /// Unused.
        padding_c: u32,
    }
    /// One copy of the list that `boundaries` reads.
    BoundaryCopy {
        /// Array written + 32 array read.
        arrays: u32,
        /// Element written.
        to_slot: u32,
        /// Element read.
        from_slot: u32,
        /// What a moving wall adds.
        added: f32,
    }
}
