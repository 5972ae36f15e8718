// Populations of links that a surface cuts (src/cut_links/): a thread for each of those that are read, and of those that come back. No two of them
// lie at one place, so that the order does not matter. What comes back is worked out on the host, with the velocity of the fabric, or by
// standing_walls.wgsl and moving_walls.wgsl.

struct LinkParameters {
    // Populations in the list.
    count: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(19) var<uniform> link_parameters: LinkParameters;
// Array and element.
@group(0) @binding(20) var<storage, read> link_places: array<vec2<u32>>;
@group(0) @binding(21) var<storage, read_write> link_populations: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn read_links(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i < link_parameters.count {
        let place = link_places[i];
        link_populations[i] = load(place.x, place.y);
    }
}

// Populations at rest, of array 0, are added to.
@compute @workgroup_size(WORKGROUP)
fn bounce(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i < link_parameters.count {
        let place = link_places[i];
        var population = link_populations[i];
        if place.x == 0u {
            population += load(0u, place.y);
        }
        store(place.x, place.y, population);
    }
}
