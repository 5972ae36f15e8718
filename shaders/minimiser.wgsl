// L-BFGS (src/solve/lbfgs.rs) of a time step with block-Jacobi, as far as one thread decides it: it accepts or shortens a trial, and lays out the next.
// The shader says where linear combinations before the next trial go (`program`), what it is asked for (`ask_for_products`), how long the last step was
// (`clipped_length`), and what it does at the end (`leave`).

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

// Pairs that there is room for while the oldest goes; rows of products of a trial.
const PAIRS: u32 = 9u;
const ROWS: u32 = 19u;
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
const PROGRAM: u32 = 52u;

var<workgroup> gram: array<f32, 216>;
// Rows of products: of the start (energy, magnitudes), (g, H₀ g), (loads, H₀ loads); of a trial (energy, magnitudes), (g⁺, d), (g⁺, H₀ g⁺), then those with s_i
// and with z_i. A row of a trial holds a·b, (a − a′)·(b − b′) and a·(b − b′), with a′ and b′ at the point before.
var<workgroup> sums: array<vec3<f32>, 19>;
// Longest displacement in b, squared, as bits.
var<workgroup> longest_bits: array<u32, 19>;
var<workgroup> state: Minimiser;
// Of the trial.
var<workgroup> stage: ClothStage;

// Words of the program written so far, of at most PROGRAM.
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

// Longest displacement of a row [m]; the largest number where it is not finite.
fn longest(row: u32) -> f32 {
    let square = bitcast<f32>(longest_bits[row]);
    if is_finite(square) {
        return sqrt(square);
    }
    return bitcast<f32>(0x7f7fffffu);
}

fn end(status: u32) {
    state.status = status;
    leave();
}

fn begin_operation(result: u32, terms: u32) {
    program[program_end] = result;
    program[program_end + 1u] = terms;
    program_end += 2u;
    stage.operations += 1u;
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
    // Gradients change places between slots FIRST_FREE and FIRST_FREE + 3, H₀ times them between the slots behind these.
    stage.start = state.point;
    stage.point = 1u - state.point;
    stage.direction = direction;
    stage.gradient = 2u * FIRST_FREE + 3u - state.gradient;
    stage.preconditioned = 2u * FIRST_FREE + 5u - state.preconditioned;
    stage.length = 1.0;
    state.refused = 0u;
    ask_for_products();
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
    add_term(length, stage.direction);
    begin_operation(slot + 1u, 2u);
    add_term(1.0, stage.gradient);
    add_term(-1.0, state.gradient);
    begin_operation(slot + 2u, 2u);
    add_term(1.0, stage.preconditioned);
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
    state.point = stage.point;
    state.gradient = stage.gradient;
    state.preconditioned = stage.preconditioned;
    state.objective = sums[0].x;
    state.round_off = round_off;
    go_on(norm_square);
}

// Takes the products of a trial: energy, (y, d), (y, H₀ y), then those with the pairs.
fn take_trial() {
    state.evaluations += 1u;
    let length = clipped_length();
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
        stage.length = shorter;
        return;
    }
    if state.pairs == 0u {
        end(select(STALLED, ROUND_OFF_REACHED, is_hidden()));
        return;
    }
    state.pairs = 0u;
    go_on(state.norm * state.norm);
}

// Takes what was summed up, and lays out what comes next; for one thread.
fn decide_next() {
    stage.operations = 0u;
    program_end = 0u;
    if state.status == STARTS {
        take_start();
    } else if state.status == RUNS {
        take_trial();
    }
}
