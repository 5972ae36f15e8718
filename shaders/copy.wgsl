// A plain copy, which measures the bandwidth that every other stage is held against.

@group(0) @binding(0) var<storage, read> copy_source: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> copy_target: array<vec4<f32>>;

@compute @workgroup_size(WORKGROUP)
fn copy(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i < arrayLength(&copy_source) {
        copy_target[i] = copy_source[i];
    }
}
