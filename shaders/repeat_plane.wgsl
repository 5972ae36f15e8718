// The first plane of populations, written into all others: a start that does not vary along z (src/gpu/fluid/repeat_plane.rs).

struct RepeatParameters {
    // Element at which the first plane begins.
    first: u32,
    // Elements from plane to plane.
    stride: u32,
    // Elements to write, after the first plane.
    elements: u32,
    padding: u32,
}

@group(0) @binding(0) var<storage, read_write> repeated: array<Stored>;
@group(0) @binding(1) var<uniform> repeat: RepeatParameters;

@compute @workgroup_size(WORKGROUP)
fn repeat_plane(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
                @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i < repeat.elements {
        repeated[repeat.first + repeat.stride + i] = repeated[repeat.first + i % repeat.stride];
    }
}
