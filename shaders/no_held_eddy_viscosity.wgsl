// No eddy viscosity but what the collision itself evaluates.

fn with_eddy_viscosity(relaxation_time: f32, cell: vec3<u32>) -> f32 {
    return relaxation_time;
}
