// What changes from step to step (src/gpu/fluid/parameters.rs).

struct StepParameters {
    inlet_velocity: vec4<f32>,
    // Force per cell and unit of density excess zero: a uniform acceleration.
    acceleration: vec4<f32>,
    // First cell of the box that holds all forces, or of that whose cells wait for the structure, and its size.
    box_first: vec4<u32>,
    box_size: vec4<u32>,
    // First plane of this dispatch, and first element in its planes.
    first_plane: u32,
    first_element: u32,
    // Which cells: one of the constants below.
    part: u32,
    padding: u32,
}

const ALL_CELLS: u32 = 0u;
const OUTSIDE_BOX: u32 = 1u;
const IN_BOX: u32 = 2u;
