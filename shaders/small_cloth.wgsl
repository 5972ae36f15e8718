// Stage minimise of small fabric: a whole solve in one workgroup, which goes from trial to trial without another dispatch.

@group(0) @binding(34) var<storage, read_write> next_stage: ClothStage;
@group(0) @binding(35) var<storage, read_write> minimiser: Minimiser;
// `gram` and `program` between dispatches.
@group(0) @binding(36) var<storage, read_write> gram_between: array<f32>;
// Words of every node: whole numbers and remainders of its position at the present point, then H₀ g.
@group(0) @binding(38) var<storage, read_write> delivered: array<u32>;

// Threads of the workgroup, a power of two.
override SMALL_WORKGROUP: u32 = WORKGROUP;
// Trials of one dispatch at most: what does not end is asked for again.
override TRIALS: u32 = 1u;
// Slot of the loads that set the scale of the tolerance.
override DRIVE: u32 = 0u;

// Linear combinations before the next trial.
var<workgroup> program: array<u32, 52>;
var<workgroup> partial: array<vec4<f32>, SMALL_WORKGROUP>;
var<workgroup> partial_bits: array<u32, SMALL_WORKGROUP>;
// Multiples of the direction that the last step went.
var<workgroup> step_length: f32;

fn ask_for_products() {}

fn clipped_length() -> f32 {
    return step_length;
}

fn leave() {}

fn add_all(local: u32, value: vec4<f32>) -> vec4<f32> {
    partial[local] = value;
    for (var width = SMALL_WORKGROUP / 2u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            partial[local] += partial[local + width];
        }
    }
    workgroupBarrier();
    let sum = partial[0];
    workgroupBarrier();
    return sum;
}

fn largest_of_all(local: u32, bits: u32) -> u32 {
    partial_bits[local] = bits;
    for (var width = SMALL_WORKGROUP / 2u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            partial_bits[local] = max(partial_bits[local], partial_bits[local + width]);
        }
    }
    workgroupBarrier();
    let largest = partial_bits[0];
    workgroupBarrier();
    return largest;
}

// Runs the program, and goes along the direction, no node farther than the limit. What a node needs of the vectors, its own thread wrote.
fn go_along(local: u32) {
    var bits = 0u;
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        run_program(node);
        bits = max(bits, square_bits(vector(stage.direction, node)));
    }
    let longest_way = stage.length * sqrt(bitcast<f32>(largest_of_all(local, bits)));
    var length = stage.length;
    if longest_way > stage.step_limit {
        length = length * (stage.step_limit / longest_way);
    }
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        move_node(node, length);
    }
    if local == 0u {
        step_length = length;
    }
}

// Products of the start: energies of a thread, then (g, H₀ g) and (loads, H₀ loads).
fn sum_start(local: u32, energy: vec2<f32>) {
    var own = vec4<f32>(energy, 0.0, 0.0);
    var bits = 0u;
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        let step = vector(stage.preconditioned, node);
        let loads = vector(DRIVE, node);
        own.z += dot(vector(stage.gradient, node), step);
        own.w += dot(loads, preconditioned(node, loads));
        bits = max(bits, square_bits(step));
    }
    let sum = add_all(local, own);
    let largest = largest_of_all(local, bits);
    if local == 0u {
        sums[0] = vec3<f32>(sum.xy, 0.0);
        sums[1] = vec3<f32>(sum.z, 0.0, 0.0);
        sums[2] = vec3<f32>(sum.w, 0.0, 0.0);
        longest_bits[1] = largest;
    }
}

// Products of a trial, with `pairs` pairs.
fn sum_trial(local: u32, energy: vec2<f32>, pairs: u32) {
    var along = vec4<f32>(energy, 0.0, 0.0);
    var norm = vec4<f32>(0.0);
    var bits = 0u;
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        let gradient = vector(stage.gradient, node);
        let change = gradient - vector(state.gradient, node);
        let direction = vector(stage.direction, node);
        let step = vector(stage.preconditioned, node);
        let step_moved = step - vector(state.preconditioned, node);
        along.z += dot(gradient, direction);
        along.w += dot(change, direction);
        norm += vec4<f32>(dot(gradient, step), dot(change, step_moved), dot(gradient, step_moved), 0.0);
        bits = max(bits, square_bits(step));
    }
    along = add_all(local, along);
    norm = add_all(local, norm);
    let largest = largest_of_all(local, bits);
    if local == 0u {
        sums[0] = vec3<f32>(along.xy, 0.0);
        sums[1] = vec3<f32>(along.zw, 0.0);
        sums[2] = norm.xyz;
        longest_bits[2] = largest;
    }
    for (var i = 0u; i < pairs; i++) {
        let slot = pair_slot(i);
        var of_pair = vec4<f32>(0.0);
        for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
            let gradient = vector(stage.gradient, node);
            let change = gradient - vector(state.gradient, node);
            let step = vector(slot, node);
            let preconditioned_change = vector(slot + 2u, node);
            of_pair += vec4<f32>(
                dot(gradient, step),
                dot(change, step),
                dot(gradient, preconditioned_change),
                dot(change, preconditioned_change),
            );
        }
        of_pair = add_all(local, of_pair);
        if local == 0u {
            sums[3u + i] = vec3<f32>(of_pair.xy, 0.0);
            sums[3u + pairs + i] = vec3<f32>(of_pair.zw, 0.0);
        }
    }
}

// Objective, gradient and H₀ times it at the point; the energy of the elements and nodes of a thread.
fn evaluate(local: u32) -> vec2<f32> {
    storageBarrier();
    var energy = evaluate_elements(local);
    storageBarrier();
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        let found = at_node(node);
        set_vector(stage.preconditioned, node, preconditioned(node, found.gradient));
        energy += found.energy;
    }
    return energy;
}

@compute @workgroup_size(SMALL_WORKGROUP)
fn solve_small_cloth(@builtin(local_invocation_index) local: u32) {
    for (var k = local; k < GRAM; k += SMALL_WORKGROUP) {
        gram[k] = gram_between[k];
    }
    if local < PROGRAM {
        program[local] = bitcast<u32>(gram_between[GRAM + local]);
    }
    if local == 0u {
        state = minimiser;
        stage = next_stage;
    }
    workgroupBarrier();
    for (var trials = 0u; trials <= TRIALS; trials++) {
        let status = workgroupUniformLoad(&state.status);
        if status > RUNS {
            break;
        }
        if status == RUNS {
            go_along(local);
        }
        let energy = evaluate(local);
        if status == RUNS {
            let pairs = workgroupUniformLoad(&state.pairs);
            sum_trial(local, energy, pairs);
        } else {
            sum_start(local, energy);
        }
        workgroupBarrier();
        if local == 0u {
            decide_next();
        }
        storageBarrier();
        workgroupBarrier();
    }
    if local == 0u {
        next_stage = stage;
        minimiser = state;
    }
    for (var k = local; k < GRAM; k += SMALL_WORKGROUP) {
        gram_between[k] = gram[k];
    }
    if local < PROGRAM {
        gram_between[GRAM + local] = bitcast<f32>(program[local]);
    }
    for (var node = local; node < NODES; node += SMALL_WORKGROUP) {
        let at = (state.point * NODES + node) * 3u;
        let step = vector(state.preconditioned, node);
        for (var axis = 0u; axis < 3u; axis++) {
            delivered[9u * node + axis] = bitcast<u32>(whole[at + axis]);
            delivered[9u * node + 3u + axis] = bitcast<u32>(remainder[at + axis]);
            delivered[9u * node + 6u + axis] = bitcast<u32>(step[axis]);
        }
    }
}
