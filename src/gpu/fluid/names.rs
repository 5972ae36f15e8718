//! What shaders of the air call buffers and the numbers that a scene fixes.

use crate::gpu::tuning::Tuning;
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::grid::{
    Grid, OUTLET_COSINE, OUTLET_DELAY, OUTLET_RELAXATION, Setup, StreamwiseEnds,
};

const NEAR_FAR: [[&str; 2]; 9] = [
    ["near_x", "far_x"],
    ["near_y", "far_y"],
    ["near_z", "far_z"],
    ["near_xy", "far_xy"],
    ["near_xz", "far_xz"],
    ["near_yz", "far_yz"],
    ["near_x_y", "far_x_y"],
    ["near_x_z", "far_x_z"],
    ["near_y_z", "far_y_z"],
];

const ARRAY_NAMES: [&str; DIRECTION_COUNT] = [
    "population_0",
    "population_1",
    "population_2",
    "population_3",
    "population_4",
    "population_5",
    "population_6",
    "population_7",
    "population_8",
    "population_9",
    "population_10",
    "population_11",
    "population_12",
    "population_13",
    "population_14",
    "population_15",
    "population_16",
    "population_17",
    "population_18",
];

/// Numbers that the scene fixes, by their names in the shaders.
pub(super) fn constants(tuning: Tuning, setup: &Setup, grid: &Grid) -> Vec<(&'static str, f64)> {
    let smagorinsky = setup
        .eddy_viscosity
        .and_then(|eddy_viscosity| eddy_viscosity.smagorinsky_constant());
    let idle = setup
        .idle
        .map_or([[0; 3]; 2], |idle| [idle.first, idle.end]);
    vec![
        ("IDLE_FIRST_X", idle[0][0] as f64),
        ("IDLE_FIRST_Y", idle[0][1] as f64),
        ("IDLE_FIRST_Z", idle[0][2] as f64),
        ("IDLE_END_X", idle[1][0] as f64),
        ("IDLE_END_Y", idle[1][1] as f64),
        ("IDLE_END_Z", idle[1][2] as f64),
        ("COLLIDE_WORKGROUP", tuning.workgroup.into()),
        ("CELLS_X", grid.cells[0] as f64),
        ("CELLS_Y", grid.cells[1] as f64),
        ("CELLS_Z", grid.cells[2] as f64),
        ("STRIDE_Y", grid.stride_y as f64),
        ("STRIDE_Z", grid.stride_z as f64),
        ("RELAXATION_TIME", setup.relaxation_time),
        ("OPERATOR", setup.operator.number().into()),
        ("EDDY", f64::from(u8::from(smagorinsky.is_some()))),
        (
            "EDDY_FACTOR",
            smagorinsky.map_or(0.0, crate::lattice::operators::eddy_factor),
        ),
        (
            "INLET_OUTLET",
            f64::from(u8::from(setup.ends == StreamwiseEnds::InletOutlet)),
        ),
        ("SPONGE_LENGTH", setup.sponge_cells.unwrap_or(0.0)),
        ("OUTLET_RELAXATION", OUTLET_RELAXATION),
        ("OUTLET_DELAY", OUTLET_DELAY),
        ("OUTLET_COSINE", OUTLET_COSINE),
    ]
}

/// Names of the populations in `populations.wgsl` for a step of the given parity.
pub(super) fn by_parity(
    populations: &[wgpu::Buffer],
    odd: bool,
) -> Vec<(&'static str, &wgpu::Buffer)> {
    let mut named = vec![("rest", &populations[0])];
    for (pair, [near, far]) in NEAR_FAR.into_iter().enumerate() {
        let first = 2 * pair + 1;
        let odd = usize::from(odd);
        named.push((near, &populations[first + 1 - odd]));
        named.push((far, &populations[first + odd]));
    }
    named
}

/// Names of the populations in `arrays.wgsl`.
pub(super) fn by_number(populations: &[wgpu::Buffer]) -> Vec<(&'static str, &wgpu::Buffer)> {
    ARRAY_NAMES.into_iter().zip(populations).collect()
}
