// Air is accelerated as the inlet's profile has it: of every row along x, y fastest, its speed over the inlet's (and what absorbing_faces.wgsl takes).

@group(0) @binding(22) var<storage, read> profile: array<vec4<f32>>;

fn air_acceleration(cell: vec3<u32>) -> vec3<f32> {
    return profile[cell.y + CELLS_Y * cell.z].x * step.acceleration.xyz;
}
