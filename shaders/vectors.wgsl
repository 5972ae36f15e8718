// Bulk operations of the minimiser (src/solve/): vectors live in one buffer, addressed by slots of three numbers per node.
// A fixed number of workgroups strides over the nodes, so that sums depend on sizes only.

@group(0) @binding(13) var<storage, read> energies: array<vec2<f32>>;
@group(0) @binding(20) var<storage, read_write> vectors: array<f32>;
// Linear combinations, one after the other: slot of the result, number of terms, then slot and coefficient of each.
@group(0) @binding(21) var<storage, read> program: array<u32>;
// Products: slots a, a′, b, b′; NONE for a zero vector, ENERGY in place of a for the sum of the energies.
@group(0) @binding(22) var<storage, read> rows: array<vec4<u32>>;
// Slots of v and H₀ v.
@group(0) @binding(23) var<storage, read> transforms: array<vec2<u32>>;
// Longest displacement, squared, of the direction in every workgroup of `combine`, as bits.
@group(0) @binding(24) var<storage, read_write> reach: array<u32>;
// Clipped length, three words unused; then four words of every workgroup of every row of `products`.
@group(0) @binding(25) var<storage, read_write> report: array<u32>;

override STRIDES: u32 = 1u;
override PRODUCT_STRIDES: u32 = 1u;
override ENERGIES: u32 = 0u;

var<workgroup> shared_bits: array<u32, 64>;
var<workgroup> shared_sums: array<vec3<f32>, 64>;

fn largest_bits(local: u32, bits: u32) -> u32 {
    shared_bits[local] = bits;
    for (var width = 32u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            shared_bits[local] = max(shared_bits[local], shared_bits[local + width]);
        }
    }
    workgroupBarrier();
    return shared_bits[0];
}

// Runs the program at every node, then measures the direction.
@compute @workgroup_size(64)
fn combine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var longest = 0u;
    for (var node = group.x * WORKGROUP + local; node < NODES; node += STRIDES * WORKGROUP) {
        run_program(node);
        if stage.direction != NONE {
            longest = max(longest, square_bits(vector(stage.direction, node)));
        }
    }
    let largest = largest_bits(local, longest);
    if local == 0u {
        reach[group.x] = largest;
    }
}

// Moves the start point along the direction, no node farther than the limit.
@compute @workgroup_size(64)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var bits = 0u;
    for (var k = local; k < STRIDES; k += WORKGROUP) {
        bits = max(bits, reach[k]);
    }
    let longest = stage.length * sqrt(bitcast<f32>(largest_bits(local, bits)));
    var length = stage.length;
    if longest > stage.step_limit {
        length = length * (stage.step_limit / longest);
    }
    for (var node = group.x * WORKGROUP + local; node < NODES; node += STRIDES * WORKGROUP) {
        move_node(node, length);
    }
    if group.x == 0u && local == 0u {
        report[0] = bitcast<u32>(length);
    }
}

// H₀ v of several vectors.
@compute @workgroup_size(64)
fn precondition(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let slots = transforms[group.y];
    for (var node = group.x * WORKGROUP + local; node < NODES; node += STRIDES * WORKGROUP) {
        set_vector(slots.y, node, preconditioned(node, vector(slots.x, node)));
    }
}

// Row (a, a′, b, b′): a·b, (a − a′)·(b − b′), a·(b − b′), and the longest displacement in b.
@compute @workgroup_size(64)
fn products(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = rows[group.y];
    var sums = vec3<f32>(0.0);
    var longest = 0u;
    let first = group.x * WORKGROUP + local;
    if row.x == ENERGY {
        for (var k = first; k < ENERGIES; k += PRODUCT_STRIDES * WORKGROUP) {
            sums += vec3<f32>(energies[k], 0.0);
        }
    } else {
        for (var node = first; node < NODES; node += PRODUCT_STRIDES * WORKGROUP) {
            let a = vector(row.x, node);
            let b = vector(row.z, node);
            var a_change = a;
            if row.y != NONE {
                a_change -= vector(row.y, node);
            }
            var b_change = b;
            if row.w != NONE {
                b_change -= vector(row.w, node);
            }
            sums += vec3<f32>(dot(a, b), dot(a_change, b_change), dot(a, b_change));
            longest = max(longest, square_bits(b));
        }
    }
    shared_sums[local] = sums;
    shared_bits[local] = longest;
    for (var width = 32u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            shared_sums[local] += shared_sums[local + width];
            shared_bits[local] = max(shared_bits[local], shared_bits[local + width]);
        }
    }
    if local == 0u {
        let to = 4u + 4u * (group.y * PRODUCT_STRIDES + group.x);
        report[to] = bitcast<u32>(shared_sums[0].x);
        report[to + 1u] = bitcast<u32>(shared_sums[0].y);
        report[to + 2u] = bitcast<u32>(shared_sums[0].z);
        report[to + 3u] = shared_bits[0];
    }
}
