// Stage interpolate: u* at the markers and their local strengths (src/cpu/immersed/).
//   place_markers  kernel weights, and which cells are touched
//   touched_cells  bare velocity and marker area of every touched cell
//   interpolate    sums under every marker's kernel

@group(0) @binding(23) var<storage, read_write> marks: array<atomic<u32>>;
// (u*, spread marker area)
@group(0) @binding(24) var<storage, read_write> cell_states: array<vec4<f32>>;
// (u*, strength)
@group(0) @binding(25) var<storage, read_write> marker_states: array<vec4<f32>>;

const SUM_OF_SQUARES: f32 = 3.0 / 8.0;

// Peskin's 4-point kernel (src/immersed/kernel.rs) at cells floor - 1 .. floor + 2.
fn kernel(r: f32) -> vec4<f32> {
    let near = sqrt(1.0 + 4.0 * r - 4.0 * r * r);
    let q = 1.0 - r;
    return vec4<f32>(3.0 - 2.0 * r - near, 3.0 - 2.0 * r + near, 3.0 - 2.0 * q + near, 3.0 - 2.0 * q - near) / 8.0;
}

@compute @workgroup_size(WORKGROUP)
fn place_markers(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= parameters.marker_count {
        return;
    }
    let marker = markers[k];
    for (var axis = 0u; axis < 3u; axis++) {
        let own = kernel(marker.fraction[axis]);
        let w = folded_weights(own, marker.fold, axis);
        let slot = KERNEL_STRIDE * k + 4u * axis;
        weights[slot] = w.x;
        weights[slot + 1u] = w.y;
        weights[slot + 2u] = w.z;
        weights[slot + 3u] = w.w;
        keep_normal_weights(k, axis, own, marker.fold);
    }
    var first = true;
    if k > 0u {
        first = markers[k - 1u].corner != marker.corner;
    }
    if first {
        atomicOr(&marks[marker.corner], k + 1u);
        for (var z = 0u; z < 4u; z++) {
            for (var y = 0u; y < 4u; y++) {
                let row = kernel_row(marker.corner, y, z);
                for (var x = 0u; x < 4u; x++) {
                    atomicOr(&marks[row + x], TOUCHED);
                }
            }
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn touched_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= parameters.box_count {
        return;
    }
    if (touched[i] & TOUCHED) == 0u {
        return;
    }
    let b = box_cell(i);
    let cell = b + parameters.box_first.xyz + 1u;
    let u = bare_state(gather(cell.x + STRIDE_Y * cell.y + STRIDE_Z * cell.z)).xyz;
    let below = rows_below(b);
    var area = 0.0;
    for (var z = 0u; z < below.y; z++) {
        for (var y = 0u; y < below.x; y++) {
            let row = row_below(b, y, z);
            let last = row + b.x;
            var k = first_marker(row + b.x - min(b.x, 3u), last);
            while k < parameters.marker_count {
                let corner = markers[k].corner;
                if corner > last {
                    break;
                }
                let slot = KERNEL_STRIDE * k;
                area += weights[slot + last - corner] * (weights[slot + 4u + y] * weights[slot + 8u + z]) * markers[k].area;
                k++;
            }
        }
    }
    cell_states[i] = vec4<f32>(u, area);
}

@compute @workgroup_size(WORKGROUP)
fn interpolate(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= parameters.marker_count {
        return;
    }
    var sum = vec4<f32>();
    for (var z = 0u; z < 4u; z++) {
        for (var y = 0u; y < 4u; y++) {
            let row = kernel_row(markers[k].corner, y, z);
            let weight = row_weight(KERNEL_STRIDE * k, y, z);
            for (var x = 0u; x < 4u; x++) {
                sum += weight * weights[KERNEL_STRIDE * k + x] * cell_states[row + x];
            }
        }
    }
    let strength = min(parameters.over_relaxation * SUM_OF_SQUARES / sum.w, parameters.largest_strength);
    marker_states[k] = vec4<f32>(sum.xyz, strength);
}
