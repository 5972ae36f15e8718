// The eddy part of every cell's relaxation time, as the stage eddy_viscosity left it, x fastest.

@group(0) @binding(21) var<storage, read> eddy_relaxation_times: array<Stored>;

fn with_eddy_viscosity(relaxation_time: f32, cell: vec3<u32>) -> f32 {
    return relaxation_time + unpacked(eddy_relaxation_times[cell.x + CELLS_X * (cell.y + CELLS_Y * cell.z)]);
}
