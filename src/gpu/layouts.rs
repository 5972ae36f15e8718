//! Layouts of all structs that Rust and WGSL share.

use super::shaders::Layout;
use super::{cloth, fluid, immersed, multigrid};

/// Layouts of all structs that Rust and WGSL share.
#[must_use]
pub fn all() -> Vec<Layout> {
    [
        cloth::parameters::OWN_LAYOUTS,
        fluid::control_volume::OWN_LAYOUTS,
        fluid::link_lists::OWN_LAYOUTS,
        fluid::moving_tables::OWN_LAYOUTS,
        fluid::parameters::OWN_LAYOUTS,
        fluid::repeat_plane::OWN_LAYOUTS,
        fluid::standing_tables::OWN_LAYOUTS,
        immersed::OWN_LAYOUTS,
        multigrid::parameters::OWN_LAYOUTS,
    ]
    .concat()
}
