// Stage repeat_forcing: one more pass of multi-direct forcing (src/cpu/immersed/repeat_forcing.rs): the slip that the body force so far
// leaves at every marker is added to its force; `spread` then gathers anew.

// (force, 0)
@group(0) @binding(23) var<storage, read_write> marker_forces: array<vec4<f32>>;
@group(0) @binding(24) var<storage, read> cell_forces: array<vec4<f32>>;
@group(0) @binding(25) var<storage, read> cell_states: array<vec4<f32>>;
// (u*, strength)
@group(0) @binding(26) var<storage, read> marker_states: array<vec4<f32>>;
@group(0) @binding(27) var<storage, read> target_velocities: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP)
fn repeat_forcing(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
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
    let stiffness = 2.0 * marker_states[k].w * markers[k].area;
    marker_forces[k] += vec4<f32>(stiffness * (target_velocities[k].xyz - sum.xyz), 0.0);
}
