// Kernels at faces that a body passes through (src/immersed/folds.rs): what lies beyond a face is folded back on the cells before it. After the
// twelve weights of a marker come those of the normal component at the sides of y and z, which has the opposite sign beyond them.

// Weights kept of a marker.
const KERNEL_STRIDE: u32 = 20u;

fn folded(w: vec4<f32>, code: u32, sign: f32) -> vec4<f32> {
    switch code {
        // By one and two cells at the lower side.
        case 1u: {
            return vec4<f32>(w.y + sign * w.x, w.z, w.w, 0.0);
        }
        case 2u: {
            return vec4<f32>(w.z + sign * w.y, w.w + sign * w.x, 0.0, 0.0);
        }
        // At the upper side.
        case 3u: {
            return vec4<f32>(0.0, w.x, w.y, w.z + sign * w.w);
        }
        case 4u: {
            return vec4<f32>(0.0, 0.0, w.x + sign * w.w, w.y + sign * w.z);
        }
        // At the outlet, where the last cell stands for all beyond.
        case 5u: {
            return vec4<f32>(0.0, w.x, w.y, w.z + w.w);
        }
        case 6u: {
            return vec4<f32>(0.0, 0.0, w.x, w.y + w.z + w.w);
        }
        default: {
            return w;
        }
    }
}

fn folded_weights(w: vec4<f32>, fold: u32, axis: u32) -> vec4<f32> {
    return folded(w, (fold >> (4u * axis)) & 15u, 1.0);
}

fn keep_normal_weights(k: u32, axis: u32, w: vec4<f32>, fold: u32) {
    if axis == 0u {
        return;
    }
    let normal = folded(w, (fold >> (4u * axis)) & 15u, -1.0);
    let slot = KERNEL_STRIDE * k + 8u + 4u * axis;
    weights[slot] = normal.x;
    weights[slot + 1u] = normal.y;
    weights[slot + 2u] = normal.z;
    weights[slot + 3u] = normal.w;
}

// Weight of row y, z of the kernel whose weights begin at `slot`: of the components along x, y and z, and of scalars.
fn row_weight(slot: u32, y: u32, z: u32) -> vec4<f32> {
    let along_y = weights[slot + 4u + y];
    let along_z = weights[slot + 8u + z];
    let plain = along_y * along_z;
    return vec4<f32>(plain, weights[slot + 12u + y] * along_z, along_y * weights[slot + 16u + z], plain);
}
