// Points that a step of the minimiser writes, and the linear combinations before it; the shader declares the program.

@group(0) @binding(1) var<storage, read_write> whole: array<i32>;
@group(0) @binding(2) var<storage, read_write> remainder: array<f32>;

// Runs the program at a node.
fn run_program(node: u32) {
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
}

// Moves a node from the start point along the direction.
fn move_node(node: u32, length: f32) {
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
