// Kernels that all lie in the box: three times four weights for all components of a vector.

// Weights kept of a marker.
const KERNEL_STRIDE: u32 = 12u;

fn folded_weights(w: vec4<f32>, fold: u32, axis: u32) -> vec4<f32> {
    return w;
}

fn keep_normal_weights(k: u32, axis: u32, w: vec4<f32>, fold: u32) {
}

// Weight of row y, z of the kernel whose weights begin at `slot`.
fn row_weight(slot: u32, y: u32, z: u32) -> f32 {
    return weights[slot + 4u + y] * weights[slot + 8u + z];
}
