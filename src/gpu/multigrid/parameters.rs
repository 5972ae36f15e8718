//! Parameters of the multigrid shaders.

use crate::gpu::shaders::parameters;

parameters! {
    /// Sizes of a level (`shaders/block_rows.wgsl`).
    MultigridLevel {
        /// Rows of blocks.
        nodes: u32,
        /// Places of the next coarser matrix.
        coarse_places: u32,
        /// Workgroups that stride over the nodes where sums are wanted.
        strides: u32,
        /// 3 · nodes of a level that is solved directly; zero elsewhere.
        unknowns: u32,
    }
}
