// Stage spread: the forces of the markers on the air, gathered by every touched cell of the box; and the slip that they leave.

@group(0) @binding(23) var<storage, read> marker_forces: array<vec4<f32>>;
@group(0) @binding(24) var<storage, read_write> cell_forces: array<vec4<f32>>;
@group(0) @binding(25) var<storage, read> cell_states: array<vec4<f32>>;
// u* + F/2
@group(0) @binding(26) var<storage, read_write> marker_velocities: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP)
fn spread(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= parameters.box_count {
        return;
    }
    var force = vec4<f32>();
    if (touched[i] & TOUCHED) != 0u {
        let b = box_cell(i);
        let below = rows_below(b);
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
                    force += weights[slot + last - corner] * row_weight(slot, y, z) * marker_forces[k];
                    k++;
                }
            }
        }
    }
    cell_forces[i] = force;
}

@compute @workgroup_size(WORKGROUP)
fn half_forced_velocity(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
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
                sum += weight * weights[KERNEL_STRIDE * k + x] * (cell_states[row + x] + 0.5 * cell_forces[row + x]);
            }
        }
    }
    marker_velocities[k] = sum;
}
