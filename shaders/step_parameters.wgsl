// What changes from step to step (src/gpu/fluid/parameters.rs).

struct StepParameters {
    inlet_velocity: vec4<f32>,
    // Force per cell and unit of density excess zero: a uniform acceleration.
    acceleration: vec4<f32>,
    // First cell of the box that holds all forces, and its size.
    box_first: vec4<u32>,
    box_size: vec4<u32>,
    // First plane of this dispatch.
    first_plane: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}
