// All air is accelerated alike.

fn air_acceleration(cell: vec3<u32>) -> vec3<f32> {
    return step.acceleration.xyz;
}
