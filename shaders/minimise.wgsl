// Stage minimise: one workgroup adds up the products of a trial that the other shaders of the cloth have made, and decides on the next.

@group(0) @binding(1) var<storage, read> whole: array<i32>;
@group(0) @binding(2) var<storage, read> remainder: array<f32>;
@group(0) @binding(20) var<storage, read> vectors: array<f32>;
// What `run_program` of the other shaders reads.
@group(0) @binding(21) var<storage, read_write> program: array<u32>;
@group(0) @binding(22) var<storage, read_write> rows: array<vec4<u32>>;
@group(0) @binding(25) var<storage, read> report: array<u32>;
// The buffer that the other shaders of the cloth read as `stage`.
@group(0) @binding(34) var<storage, read_write> next_stage: ClothStage;
@group(0) @binding(35) var<storage, read_write> minimiser: Minimiser;
// `gram` between trials.
@group(0) @binding(36) var<storage, read_write> gram_between: array<f32>;
// Workgroups of the dispatches of a trial along x, y and z: none once the minimiser has ended.
@group(0) @binding(37) var<storage, read_write> workgroups: array<u32>;
// Words of every node: whole numbers and remainders of its position at the present point, then H₀ g.
@group(0) @binding(38) var<storage, read_write> delivered: array<u32>;

override PRODUCT_STRIDES: u32 = 1u;

const NONE: u32 = 0xffffffffu;
const ENERGY: u32 = 0xfffffffeu;
// Threads that add up a row of products.
const LANES: u32 = 3u;
// Dispatch of a trial whose workgroups depend on the pairs.
const PRODUCTS: u32 = 1u;

var<workgroup> lane_sums: array<vec3<f32>, 64>;
var<workgroup> lane_bits: array<u32, 64>;

fn ask_for_products() {
    let m = state.pairs;
    rows[0] = vec4<u32>(ENERGY, NONE, NONE, NONE);
    rows[1] = vec4<u32>(stage.gradient, state.gradient, stage.direction, NONE);
    rows[2] = vec4<u32>(stage.gradient, state.gradient, stage.preconditioned, state.preconditioned);
    for (var i = 0u; i < m; i++) {
        rows[3u + i] = vec4<u32>(stage.gradient, state.gradient, pair_slot(i), NONE);
        rows[3u + m + i] = vec4<u32>(stage.gradient, state.gradient, pair_slot(i) + 2u, NONE);
    }
    state.rows = 3u + 2u * m;
    workgroups[3u * PRODUCTS + 1u] = state.rows;
}

fn clipped_length() -> f32 {
    return bitcast<f32>(report[0]);
}

fn leave() {
    for (var k = 0u; k < arrayLength(&workgroups); k++) {
        workgroups[k] = 0u;
    }
}

// Adds up the rows of products that every workgroup has its part of.
fn add_up(local: u32) {
    let row = local / LANES;
    var sum = vec3<f32>(0.0);
    var bits = 0u;
    if row < minimiser.rows {
        for (var group = local % LANES; group < PRODUCT_STRIDES; group += LANES) {
            let at = 4u + 4u * (row * PRODUCT_STRIDES + group);
            sum += bitcast<vec3<f32>>(vec3<u32>(report[at], report[at + 1u], report[at + 2u]));
            bits = max(bits, report[at + 3u]);
        }
    }
    lane_sums[local] = sum;
    lane_bits[local] = bits;
    workgroupBarrier();
    if local < ROWS {
        let first = local * LANES;
        sums[local] = lane_sums[first] + lane_sums[first + 1u] + lane_sums[first + 2u];
        longest_bits[local] = max(max(lane_bits[first], lane_bits[first + 1u]), lane_bits[first + 2u]);
    }
}

@compute @workgroup_size(64)
fn decide(@builtin(local_invocation_index) local: u32) {
    for (var k = local; k < GRAM; k += WORKGROUP) {
        gram[k] = gram_between[k];
    }
    add_up(local);
    workgroupBarrier();
    if local == 0u {
        state = minimiser;
        stage = next_stage;
        decide_next();
        next_stage = stage;
        minimiser = state;
    }
    workgroupBarrier();
    for (var k = local; k < GRAM; k += WORKGROUP) {
        gram_between[k] = gram[k];
    }
}

// Puts the present point together, for the host.
@compute @workgroup_size(64)
fn deliver(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    let at = (minimiser.point * NODES + node) * 3u;
    let vector = (minimiser.preconditioned * NODES + node) * 3u;
    for (var axis = 0u; axis < 3u; axis++) {
        delivered[9u * node + axis] = bitcast<u32>(whole[at + axis]);
        delivered[9u * node + 3u + axis] = bitcast<u32>(remainder[at + axis]);
        delivered[9u * node + 6u + axis] = bitcast<u32>(vectors[vector + axis]);
    }
}
