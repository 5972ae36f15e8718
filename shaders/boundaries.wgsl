// Populations that enter through the sides, through walls, or through the ends of a periodic box: copied from the slots of those that
// left, after collide_stream. The list of copies is src/lattice/links.rs's.

struct BoundaryCopy {
    // to + 32 from
    arrays: u32,
    to_slot: u32,
    from_slot: u32,
    // What a moving wall adds.
    added: f32,
}

// Some wall moves.
override MOVING_WALLS: bool = false;

@group(0) @binding(19) var<storage, read> copies: array<BoundaryCopy>;

@compute @workgroup_size(WORKGROUP)
fn boundaries(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i < arrayLength(&copies) {
        let link = copies[i];
        var population = load(link.arrays >> 5u, link.from_slot);
        if MOVING_WALLS {
            population += link.added;
        }
        store(link.arrays & 31u, link.to_slot, population);
    }
}
