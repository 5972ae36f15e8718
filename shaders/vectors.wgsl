// Bulk operations of the minimiser (src/solve/): vectors live in one buffer, addressed by slots of three numbers per node.
// A fixed number of workgroups strides over the nodes, so that sums depend on sizes only.

@group(0) @binding(1) var<storage, read_write> whole: array<i32>;
@group(0) @binding(2) var<storage, read_write> remainder: array<f32>;
@group(0) @binding(13) var<storage, read> energies: array<vec2<f32>>;
@group(0) @binding(19) var<storage, read> inverse_blocks: array<f32>;
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

const NONE: u32 = 0xffffffffu;
const ENERGY: u32 = 0xfffffffeu;

var<workgroup> shared_bits: array<u32, 64>;
var<workgroup> shared_sums: array<vec3<f32>, 64>;

fn vector(slot: u32, node: u32) -> vec3<f32> {
    let k = (slot * NODES + node) * 3u;
    return vec3<f32>(vectors[k], vectors[k + 1u], vectors[k + 2u]);
}

fn set_vector(slot: u32, node: u32, value: vec3<f32>) {
    let k = (slot * NODES + node) * 3u;
    vectors[k] = value.x;
    vectors[k + 1u] = value.y;
    vectors[k + 2u] = value.z;
}

// |v|² as bits: ordered like the numbers, with infinity and then what is not a number above all of them.
fn square_bits(v: vec3<f32>) -> u32 {
    return bitcast<u32>(dot(v, v)) & 0x7fffffffu;
}

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
        var at = 0u;
        for (var operation = 0u; operation < stage.operations; operation++) {
            let result = program[at];
            let end = at + 2u + 2u * program[at + 1u];
            at += 2u;
            var sum = vec3<f32>(0.0);
            while at < end {
                sum += bitcast<f32>(program[at + 1u]) * vector(program[at], node);
                at += 2u;
            }
            set_vector(result, node, sum);
        }
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
        let step = length * vector(stage.direction, node);
        let from_slot = (stage.start * NODES + node) * 3u;
        let to = (stage.point * NODES + node) * 3u;
        for (var axis = 0u; axis < 3u; axis++) {
            // Steps beyond 16 km, and what is not a number, stay in the remainder.
            let moves = select(0.0, round(step[axis] * 65536.0), abs(step[axis]) < 16384.0);
            let rest = remainder[from_slot + axis] + (step[axis] - moves * UNIT);
            let carry = select(0.0, round(rest * 65536.0), abs(rest) < 1.0);
            whole[to + axis] = whole[from_slot + axis] + i32(moves) + i32(carry);
            remainder[to + axis] = rest - carry * UNIT;
        }
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
        let v = vector(slots.x, node);
        let b = node * 6u;
        let off = vec3<f32>(inverse_blocks[b + 3u], inverse_blocks[b + 4u], inverse_blocks[b + 5u]);
        set_vector(slots.y, node, vec3<f32>(
            inverse_blocks[b] * v.x + off.x * v.y + off.y * v.z,
            off.x * v.x + inverse_blocks[b + 1u] * v.y + off.z * v.z,
            off.y * v.x + off.z * v.y + inverse_blocks[b + 2u] * v.z,
        ));
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
