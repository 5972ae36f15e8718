//! The WGSL files of `shaders/`, embedded, and the shaders put together from them.
//!
//! WGSL has no includes: a shader is the text of its parts, one after the other. Numbers that a scene fixes (sizes, relaxation
//! times, switches) are pipeline constants; what changes during a run is a struct of parameters, declared once here for Rust
//! (by the macro `parameters!`) and once in WGSL. A test without any device compares the two, field by field.

/// Threads of a workgroup of every compute shader but `collide_stream` ([`crate::gpu::Tuning`]) and `small_cloth`, along x.
pub const WORKGROUP: u32 = 64;

/// A shader: its parts in order.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    /// Name of the stage.
    pub name: &'static str,
    /// (file in `shaders/`, text)
    pub parts: &'static [(&'static str, &'static str)],
}

impl Shader {
    /// The whole text.
    #[must_use]
    pub fn source(&self) -> String {
        self.parts.iter().map(|(_, text)| *text).collect()
    }
}

macro_rules! parts {
    ($($file:literal),+) => { &[$(($file, include_str!(concat!("../../shaders/", $file)))),+] };
}

macro_rules! shaders {
    ($($constant:ident = $name:literal: $($file:literal),+;)*) => {
        $(
            #[doc = concat!("The shader `", $name, "`.")]
            pub const $constant: Shader = Shader { name: $name, parts: parts!($($file),+) };
        )*
        const INDEPENDENT: &[Shader] = &[$($constant),*];
    };
}

/// Shaders that touch populations, in the order of [`Storage`].
macro_rules! stored_shaders {
    ($($constant:ident = $name:literal: $($file:literal),+;)*) => {
        $(
            #[doc = concat!("The shader `", $name, "`, by how populations are stored.")]
            pub const $constant: [Shader; 2] = [
                Shader { name: $name, parts: parts!("storage_f32.wgsl", $($file),+) },
                Shader { name: concat!($name, "_f16"), parts: parts!("storage_f16.wgsl", $($file),+) },
            ];
        )*
        const STORED: &[[Shader; 2]] = &[$($constant),*];
    };
}

/// All shaders.
#[must_use]
pub fn all() -> Vec<Shader> {
    [STORED.concat(), INDEPENDENT.to_vec()].concat()
}

stored_shaders! {
    COLLIDE_STREAM = "collide_stream": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "operators.wgsl", "no_held_eddy_viscosity.wgsl",
        "step_parameters.wgsl", "uniform_wind.wgsl", "collide_stream.wgsl";
    COLLIDE_STREAM_HELD = "collide_stream_held": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "operators.wgsl",
        "held_eddy_viscosity.wgsl", "step_parameters.wgsl", "uniform_wind.wgsl", "collide_stream.wgsl";
    COLLIDE_STREAM_PROFILED = "collide_stream_profiled": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "operators.wgsl",
        "no_held_eddy_viscosity.wgsl", "step_parameters.wgsl", "profiled_wind.wgsl", "collide_stream.wgsl";
    COLLIDE_STREAM_HELD_PROFILED = "collide_stream_held_profiled": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "operators.wgsl",
        "held_eddy_viscosity.wgsl", "step_parameters.wgsl", "profiled_wind.wgsl", "collide_stream.wgsl";
    EDDY_VISCOSITY = "eddy_viscosity": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "eddy_viscosity.wgsl";
    ABSORBING_FACES = "absorbing_faces": "threads.wgsl", "lattice.wgsl", "arrays.wgsl", "step_parameters.wgsl", "absorbing_faces.wgsl";
    TRANSFER = "transfer": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "place.wgsl", "operators.wgsl", "level_state.wgsl",
        "no_held_eddy_viscosity.wgsl", "transfer.wgsl";
    TRANSFER_HELD = "transfer_held": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "place.wgsl", "operators.wgsl", "level_state.wgsl",
        "held_eddy_viscosity.wgsl", "transfer.wgsl";
    BOUNDARIES = "boundaries": "threads.wgsl", "arrays.wgsl", "boundaries.wgsl";
    CUT_LINKS = "cut_links": "threads.wgsl", "arrays.wgsl", "cut_links.wgsl";
    REPEAT_PLANE = "repeat_plane": "threads.wgsl", "repeat_plane.wgsl";
    MACROSCOPIC = "macroscopic": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "macroscopic.wgsl";
    INTERPOLATE = "interpolate": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "marker.wgsl", "markers.wgsl", "plain_kernels.wgsl",
        "interpolate.wgsl";
    INTERPOLATE_FOLDED = "interpolate_folded": "threads.wgsl", "lattice.wgsl", "populations.wgsl", "marker.wgsl", "markers.wgsl",
        "folded_kernels.wgsl", "interpolate.wgsl";
    CONTROL_VOLUME = "control_volume": "threads.wgsl", "arrays.wgsl", "control_volume.wgsl";
}

shaders! {
    SPREAD = "spread": "threads.wgsl", "marker.wgsl", "markers.wgsl", "plain_kernels.wgsl", "spread.wgsl";
    SPREAD_FOLDED = "spread_folded": "threads.wgsl", "marker.wgsl", "markers.wgsl", "folded_kernels.wgsl", "spread.wgsl";
    REPEAT_FORCING = "repeat_forcing": "threads.wgsl", "marker.wgsl", "markers.wgsl", "plain_kernels.wgsl", "repeat_forcing.wgsl";
    REPEAT_FORCING_FOLDED = "repeat_forcing_folded":
        "threads.wgsl", "marker.wgsl", "markers.wgsl", "folded_kernels.wgsl", "repeat_forcing.wgsl";
    STANDING_WALLS = "standing_walls": "threads.wgsl", "lattice.wgsl", "standing_walls.wgsl";
    FIND_LINKS = "find_links": "threads.wgsl", "found_links.wgsl", "lines.wgsl", "find_links.wgsl";
    MOVING_WALLS = "moving_walls": "threads.wgsl", "found_links.wgsl", "moving_walls.wgsl";
    EMPTY = "empty": "threads.wgsl", "empty.wgsl";
    COPY = "copy": "threads.wgsl", "copy.wgsl";
    NODAL_FORCES = "nodal_forces":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "points.wgsl", "elements.wgsl", "membrane.wgsl", "vector.wgsl",
        "block_jacobi.wgsl", "element_forces.wgsl", "nodal_forces.wgsl";
    INITIAL_HESSIAN = "initial_hessian":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "points.wgsl", "elements.wgsl", "membrane.wgsl", "symmetric_block.wgsl",
        "axial_blocks.wgsl", "initial_hessian.wgsl";
    STIFFNESS = "stiffness":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "points.wgsl", "elements.wgsl", "membrane.wgsl", "symmetric_block.wgsl",
        "axial_blocks.wgsl", "stiffness.wgsl";
    MULTIGRID = "multigrid": "threads.wgsl", "block_rows.wgsl", "multigrid.wgsl";
    MULTIGRID_REFRESH = "multigrid_refresh":
        "threads.wgsl", "block_rows.wgsl", "symmetric_block.wgsl", "multigrid_refresh.wgsl";
    VECTORS = "vectors":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "vector.wgsl", "moved_points.wgsl", "block_jacobi.wgsl", "vectors.wgsl";
    MARKER_REACTIONS = "marker_reactions":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "vector.wgsl", "marker.wgsl", "marker_reactions.wgsl";
    SORT_MARKERS = "sort_markers": "threads.wgsl", "cloth.wgsl", "marker.wgsl", "sort_markers.wgsl";
    FABRIC_MOTION = "fabric_motion": "threads.wgsl", "cloth.wgsl", "minimiser_state.wgsl", "fabric_motion.wgsl";
    CUT_FABRIC = "cut_fabric":
        "threads.wgsl", "cloth.wgsl", "cloth_stage.wgsl", "vector.wgsl", "found_links.wgsl", "lines.wgsl", "cut_fabric.wgsl";
    MINIMISE = "minimise": "threads.wgsl", "cloth.wgsl", "minimiser_state.wgsl", "minimiser.wgsl", "minimise.wgsl";
    SMALL_CLOTH = "small_cloth":
        "threads.wgsl", "cloth.wgsl", "minimiser_state.wgsl", "minimiser.wgsl", "vector.wgsl", "moved_points.wgsl", "block_jacobi.wgsl", "elements.wgsl",
        "membrane.wgsl", "element_forces.wgsl", "every_element.wgsl", "small_cloth.wgsl";
}

/// Layout of a struct of parameters: its name and its fields with their byte offsets.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Name in Rust and in WGSL.
    pub name: &'static str,
    /// Bytes in all.
    pub size: usize,
    /// (field, byte offset)
    pub fields: &'static [(&'static str, usize)],
}

/// Declares structs that both Rust and WGSL know under the same names.
macro_rules! parameters {
    ($( $(#[$doc:meta])* $name:ident { $( $(#[$field_doc:meta])* $field:ident: $type:ty, )+ } )+) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
            pub struct $name { $( $(#[$field_doc])* pub $field: $type, )+ }
        )+
        /// Layouts of these structs.
        pub(in crate::gpu) const OWN_LAYOUTS: &[$crate::gpu::shaders::Layout] = &[
            $( $crate::gpu::shaders::Layout {
                name: stringify!($name),
                size: size_of::<$name>(),
                fields: &[ $( (stringify!($field), std::mem::offset_of!($name, $field)) ),+ ],
            } ),+
        ];
    };
}
pub(super) use parameters;
