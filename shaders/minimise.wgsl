// Stage minimise: L-BFGS (src/solve/lbfgs.rs) of a time step with block-Jacobi, decided on the device between one trial and the next.
// One workgroup adds up the products of a trial; one of its threads accepts or shortens it, and lays out the next.

// Mirrors gpu::cloth::parameters::Minimiser.
struct Minimiser {
    // Share of `scale` that the energy norm may have; displacement that counts as nothing [m].
    tolerance: f32,
    displacement_floor: f32,
    // Pairs kept; evaluations allowed.
    history: u32,
    evaluation_limit: u32,
    // STARTS, RUNS, or why it ended; so far.
    status: u32,
    iterations: u32,
    evaluations: u32,
    // Trials along the present direction that were not taken; iterations without progress; pairs kept now; rows of products asked for.
    refused: u32,
    stagnant: u32,
    pairs: u32,
    rows: u32,
    // Slots of the present point, its gradient, and H₀ times that.
    point: u32,
    gradient: u32,
    preconditioned: u32,
    // Of the present point: objective and its round-off without what never changes [J], energy norm, longest displacement of H₀ g [m].
    objective: f32,
    round_off: f32,
    norm: f32,
    longest: f32,
    // What the tolerance is relative to; lowest norm so far; slope of the objective along the direction.
    scale: f32,
    lowest_norm: f32,
    slope: f32,
    // γ
    direction_scale: f32,
}

@group(0) @binding(1) var<storage, read> whole: array<i32>;
@group(0) @binding(2) var<storage, read> remainder: array<f32>;
@group(0) @binding(20) var<storage, read> vectors: array<u32>;
@group(0) @binding(21) var<storage, read_write> program: array<u32>;
@group(0) @binding(22) var<storage, read_write> rows: array<vec4<u32>>;
@group(0) @binding(25) var<storage, read> report: array<u32>;
// The buffer that the other shaders of the cloth read as `stage`.
@group(0) @binding(34) var<storage, read_write> next_stage: ClothStage;
@group(0) @binding(35) var<storage, read_write> minimiser: Minimiser;
// What `gram` below holds, between trials.
@group(0) @binding(36) var<storage, read_write> gram_between: array<f32>;
// Workgroups of the dispatches of a trial along x, y and z: none once the minimiser has ended.
@group(0) @binding(37) var<storage, read_write> workgroups: array<u32>;
// Words of every node: whole numbers and remainders of its position at the present point, then H₀ g.
@group(0) @binding(38) var<storage, read_write> delivered: array<u32>;

override PRODUCT_STRIDES: u32 = 1u;
// First slot of vectors that is free.
override FIRST_FREE: u32 = 2u;
// Constants of src/solve/lbfgs.rs.
override ROUND_OFF: f32 = 0.0;
override OUT_OF_BALANCE: f32 = 0.0;
override ARMIJO: f32 = 0.0;
override WOLFE: f32 = 0.0;
override RETREAT: f32 = 0.0;
override SHORTEST: f32 = 0.0;
override SHORTENED: f32 = 0.0;
override LEAST_CURVATURE: f32 = 0.0;
override PROGRESS: f32 = 0.0;
override LINE_SEARCH_LIMIT: u32 = 1u;
override STAGNATION_LIMIT: u32 = 1u;
override ROUND_OFF_LIMIT: u32 = 1u;

const NONE: u32 = 0xffffffffu;
const ENERGY: u32 = 0xfffffffeu;

// Mirrors gpu::cloth::batches::STOPS.
const STARTS: u32 = 0u;
const RUNS: u32 = 1u;
const CONVERGED: u32 = 2u;
const ROUND_OFF_REACHED: u32 = 3u;
const STALLED: u32 = 4u;
const LIMIT_REACHED: u32 = 5u;
const NOT_FINITE: u32 = 6u;
const INDEFINITE: u32 = 7u;

// Pairs that there is room for while the oldest goes; rows of products of a trial; threads that add up a row.
const PAIRS: u32 = 9u;
const ROWS: u32 = 19u;
const LANES: u32 = 3u;
// Dispatches of a trial whose workgroups are set here: products.
const PRODUCTS: u32 = 1u;

// Dot products of the pairs, oldest first, and what the present direction is made of.
const GRADIENT_STEP: u32 = 0u; // g·s_i
const GRADIENT_CHANGE: u32 = 9u; // g·z_i
const STEP_CHANGE: u32 = 18u; // s_i·y_j
const CHANGE_CHANGE: u32 = 99u; // y_i·z_j
const ALONG_CHANGES: u32 = 180u; // d·y_i
const ALPHA: u32 = 189u;
const GAIN: u32 = 198u;
const ORDER: u32 = 207u; // which pair of vectors it is
const GRAM: u32 = 216u;

var<workgroup> gram: array<f32, 216>;
var<workgroup> lane_sums: array<vec3<f32>, 64>;
var<workgroup> lane_bits: array<u32, 64>;
var<workgroup> sums: array<vec3<f32>, 19>;
var<workgroup> longest_bits: array<u32, 19>;

var<private> state: Minimiser;
var<private> trial: ClothStage;
// Words of the program written so far.
var<private> program_end: u32;

fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn step_change(i: u32, j: u32) -> f32 {
    return gram[STEP_CHANGE + i * PAIRS + j];
}

fn change_change(i: u32, j: u32) -> f32 {
    return gram[CHANGE_CHANGE + i * PAIRS + j];
}

// First of the three slots of a pair: s, y, z.
fn pair_slot(i: u32) -> u32 {
    return FIRST_FREE + 5u + 3u * u32(gram[ORDER + i]);
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

// Longest displacement of a row [m]; as large as no displacement is where it is not finite.
fn longest(row: u32) -> f32 {
    let square = bitcast<f32>(longest_bits[row]);
    if is_finite(square) {
        return sqrt(square);
    }
    return bitcast<f32>(0x7f7fffffu);
}

fn end(status: u32) {
    state.status = status;
    for (var k = 0u; k < arrayLength(&workgroups); k++) {
        workgroups[k] = 0u;
    }
}

fn begin_operation(result: u32, terms: u32) {
    program[program_end] = result;
    program[program_end + 1u] = terms;
    program_end += 2u;
    trial.operations += 1u;
}

fn add_term(coefficient: f32, slot: u32) {
    program[program_end] = slot;
    program[program_end + 1u] = bitcast<u32>(coefficient);
    program_end += 2u;
}

// The two-loop recursion on the products of the pairs.
fn find_direction() {
    let m = state.pairs;
    var scale = 1.0;
    if m > 0u {
        let curvature = step_change(m - 1u, m - 1u);
        let square = change_change(m - 1u, m - 1u);
        if curvature > 0.0 && square > 0.0 {
            scale = curvature / square;
        }
    }
    for (var k = 0u; k < m; k++) {
        let i = m - 1u - k;
        var projection = gram[GRADIENT_STEP + i];
        for (var j = i + 1u; j < m; j++) {
            projection -= gram[ALPHA + j] * step_change(i, j);
        }
        gram[ALPHA + i] = projection / step_change(i, i);
    }
    for (var i = 0u; i < m; i++) {
        var projection = gram[GRADIENT_CHANGE + i];
        for (var j = 0u; j < m; j++) {
            projection -= gram[ALPHA + j] * change_change(i, j);
        }
        projection *= scale;
        for (var j = 0u; j < i; j++) {
            projection += gram[GAIN + j] * step_change(j, i);
        }
        gram[GAIN + i] = gram[ALPHA + i] - projection / step_change(i, i);
    }
    state.slope = -scale * state.norm * state.norm;
    for (var i = 0u; i < m; i++) {
        state.slope += scale * gram[ALPHA + i] * gram[GRADIENT_CHANGE + i] - gram[GAIN + i] * gram[GRADIENT_STEP + i];
        var along = -scale * gram[GRADIENT_CHANGE + i];
        for (var j = 0u; j < m; j++) {
            along += scale * gram[ALPHA + j] * change_change(j, i) - gram[GAIN + j] * step_change(j, i);
        }
        gram[ALONG_CHANGES + i] = along;
    }
    state.direction_scale = scale;
}

// Asks for the first trial along a new direction, d = −γ H₀ g + Σ γ α_i z_i − gain_i s_i.
fn lay_out_trial() {
    let m = state.pairs;
    let direction = FIRST_FREE + 2u;
    begin_operation(direction, 1u + 2u * m);
    add_term(-state.direction_scale, state.preconditioned);
    for (var i = 0u; i < m; i++) {
        add_term(state.direction_scale * gram[ALPHA + i], pair_slot(i) + 2u);
        add_term(-gram[GAIN + i], pair_slot(i));
    }
    // Gradients change places between slots 0 and 3, H₀ times them between 1 and 4.
    trial.start = state.point;
    trial.point = 1u - state.point;
    trial.direction = direction;
    trial.gradient = 2u * FIRST_FREE + 3u - state.gradient;
    trial.preconditioned = 2u * FIRST_FREE + 5u - state.preconditioned;
    trial.length = 1.0;
    rows[0] = vec4<u32>(ENERGY, NONE, NONE, NONE);
    rows[1] = vec4<u32>(trial.gradient, state.gradient, direction, NONE);
    rows[2] = vec4<u32>(trial.gradient, state.gradient, trial.preconditioned, state.preconditioned);
    for (var i = 0u; i < m; i++) {
        rows[3u + i] = vec4<u32>(trial.gradient, state.gradient, pair_slot(i), NONE);
        rows[3u + m + i] = vec4<u32>(trial.gradient, state.gradient, pair_slot(i) + 2u, NONE);
    }
    state.rows = 3u + 2u * m;
    state.refused = 0u;
    workgroups[3u * PRODUCTS + 1u] = state.rows;
}

fn is_hidden() -> bool {
    return 0.5 * state.norm * state.norm <= state.round_off;
}

// Ends at the present point, or goes on from it.
fn go_on(norm_square: f32) {
    if norm_square < 0.0 {
        end(INDEFINITE);
        return;
    }
    if state.norm <= state.tolerance * state.scale || state.longest <= state.displacement_floor {
        end(CONVERGED);
        return;
    }
    if state.evaluations >= state.evaluation_limit {
        end(LIMIT_REACHED);
        return;
    }
    if is_hidden() && state.stagnant >= ROUND_OFF_LIMIT {
        end(ROUND_OFF_REACHED);
        return;
    }
    if state.stagnant >= STAGNATION_LIMIT {
        end(STALLED);
        return;
    }
    find_direction();
    if !(state.slope < 0.0 && is_finite(state.slope)) {
        state.pairs = 0u;
        find_direction();
    }
    lay_out_trial();
}

// Takes the products of the start: energy, (g, H₀ g), and the same of the loads.
fn take_start() {
    let norm_square = sums[1].x;
    state.status = RUNS;
    state.evaluations = 1u;
    state.objective = sums[0].x;
    state.round_off = ROUND_OFF * sums[0].y;
    state.longest = longest(1u);
    state.norm = sqrt(max(norm_square, 0.0));
    state.lowest_norm = state.norm;
    state.scale = max(sqrt(max(sums[2].x, 0.0)), OUT_OF_BALANCE * state.norm);
    let energy_is_finite = is_finite(state.objective) && is_finite(norm_square);
    if !(energy_is_finite && is_finite(bitcast<f32>(longest_bits[1]))) {
        end(NOT_FINITE);
        return;
    }
    go_on(norm_square);
}

// Vectors of a pair that none of those kept uses.
fn spare_pair() -> u32 {
    for (var candidate = 0u; candidate < PAIRS; candidate++) {
        var taken = false;
        for (var i = 0u; i < state.pairs; i++) {
            taken = taken || u32(gram[ORDER + i]) == candidate;
        }
        if !taken {
            return candidate;
        }
    }
    return 0u;
}

fn forget_oldest() {
    state.pairs -= 1u;
    for (var i = 0u; i < state.pairs; i++) {
        gram[GRADIENT_STEP + i] = gram[GRADIENT_STEP + i + 1u];
        gram[GRADIENT_CHANGE + i] = gram[GRADIENT_CHANGE + i + 1u];
        gram[ORDER + i] = gram[ORDER + i + 1u];
        for (var j = 0u; j < state.pairs; j++) {
            gram[STEP_CHANGE + i * PAIRS + j] = step_change(i + 1u, j + 1u);
            gram[CHANGE_CHANGE + i * PAIRS + j] = change_change(i + 1u, j + 1u);
        }
    }
}

// Keeps the pair of an accepted trial.
fn keep_pair(length: f32) {
    let m = state.pairs;
    for (var i = 0u; i < m; i++) {
        let of_step = sums[3u + i];
        let of_change = sums[3u + m + i];
        gram[GRADIENT_STEP + i] = of_step.x;
        gram[GRADIENT_CHANGE + i] = of_change.x;
        gram[STEP_CHANGE + i * PAIRS + m] = of_step.y;
        gram[STEP_CHANGE + m * PAIRS + i] = length * gram[ALONG_CHANGES + i];
        gram[CHANGE_CHANGE + i * PAIRS + m] = of_change.y;
        gram[CHANGE_CHANGE + m * PAIRS + i] = of_change.y;
    }
    let curvature = length * sums[1].y;
    let square = sums[2].y;
    gram[GRADIENT_STEP + m] = length * sums[1].x;
    gram[GRADIENT_CHANGE + m] = sums[2].z;
    gram[STEP_CHANGE + m * PAIRS + m] = curvature;
    gram[CHANGE_CHANGE + m * PAIRS + m] = square;
    if !(curvature > LEAST_CURVATURE * square && curvature > 0.0) {
        return;
    }
    let pair = spare_pair();
    gram[ORDER + m] = f32(pair);
    let slot = pair_slot(m);
    begin_operation(slot, 1u);
    add_term(length, trial.direction);
    begin_operation(slot + 1u, 2u);
    add_term(1.0, trial.gradient);
    add_term(-1.0, state.gradient);
    begin_operation(slot + 2u, 2u);
    add_term(1.0, trial.preconditioned);
    add_term(-1.0, state.preconditioned);
    state.pairs = m + 1u;
    if state.pairs > state.history {
        forget_oldest();
    }
}

fn accept(length: f32, round_off: f32) {
    state.iterations += 1u;
    keep_pair(length);
    let norm_square = sums[2].x;
    state.norm = sqrt(max(norm_square, 0.0));
    state.longest = longest(2u);
    let changes = abs(sums[0].x - state.objective) > max(round_off, state.round_off);
    state.stagnant = select(state.stagnant + 1u, 0u, changes || state.norm < PROGRESS * state.lowest_norm);
    state.lowest_norm = min(state.lowest_norm, state.norm);
    state.point = trial.point;
    state.gradient = trial.gradient;
    state.preconditioned = trial.preconditioned;
    state.objective = sums[0].x;
    state.round_off = round_off;
    go_on(norm_square);
}

// Takes the products of a trial: energy, (y, d), (y, H₀ y), then those with the pairs.
fn take_trial() {
    state.evaluations += 1u;
    let length = bitcast<f32>(report[0]);
    let slope = state.slope;
    var shorter = RETREAT * length;
    if is_finite(sums[0].x) && is_finite(sums[2].x) {
        let round_off = ROUND_OFF * sums[0].y;
        let change = sums[0].x - state.objective;
        let measurable = abs(change) > max(round_off, state.round_off);
        var enough = sums[1].x <= -WOLFE * slope;
        var parabola = -length * slope / sums[1].y;
        if measurable {
            enough = change <= ARMIJO * length * slope;
            parabola = -slope * length * length / (2.0 * (change - length * slope));
        }
        if enough {
            accept(length, round_off);
            return;
        }
        shorter = SHORTENED * length;
        if is_finite(parabola) {
            shorter = clamp(parabola, SHORTEST * length, SHORTENED * length);
        }
    }
    state.refused += 1u;
    if state.refused < LINE_SEARCH_LIMIT {
        trial.length = shorter;
        return;
    }
    if state.pairs == 0u {
        end(select(STALLED, ROUND_OFF_REACHED, is_hidden()));
        return;
    }
    state.pairs = 0u;
    go_on(state.norm * state.norm);
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
        trial = next_stage;
        trial.operations = 0u;
        program_end = 0u;
        if state.status == STARTS {
            take_start();
        } else if state.status == RUNS {
            take_trial();
        }
        next_stage = trial;
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
        delivered[9u * node + 6u + axis] = vectors[vector + axis];
    }
}
