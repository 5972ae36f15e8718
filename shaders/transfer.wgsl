// Between a lattice and a box of finer cells in it (src/lattice/nest.rs), through a buffer of states: a shader touches the populations of one
// lattice only. The order is restrict_states (on the fine lattice), write_band (coarse), read_source (coarse), fill_shell (fine).

struct TransferParameters {
    // Uniform acceleration of the lattice whose populations are at hand.
    force: vec4<f32>,
    // Cells of this dispatch.
    count: u32,
    // States from number to number, from row to row, from plane to plane.
    number_stride: u32,
    row_stride: u32,
    plane_stride: u32,
}

@group(0) @binding(19) var<uniform> transfer: TransferParameters;
// Element of a cell among the populations (of the fine ones, of the first of eight), and its place among the states.
@group(0) @binding(20) var<storage, read> transfer_cells: array<vec2<u32>>;
// Ten numbers a cell: density excess, momentum, rate of strain.
@group(0) @binding(21) var<storage, read_write> level_states: array<f32>;

const STATE_NUMBERS: u32 = 10u;

alias Numbers = array<f32, 10>;

fn numbers_of(s: LevelState, of_strain: f32) -> Numbers {
    let normal = of_strain * s.normal;
    let shear = of_strain * s.shear;
    return Numbers(s.density_excess, s.momentum.x, s.momentum.y, s.momentum.z, normal.x, normal.y, normal.z, shear.x, shear.y, shear.z);
}

fn state_with(n: Numbers) -> LevelState {
    return LevelState(n[0], vec3<f32>(n[1], n[2], n[3]), vec3<f32>(n[4], n[5], n[6]), vec3<f32>(n[7], n[8], n[9]));
}

// Element of one of the eight fine cells of a coarse one.
fn child_element(first: u32, child: u32) -> u32 {
    return first + (child & 1u) + ((child >> 1u) & 1u) * STRIDE_Y + (child >> 2u) * STRIDE_Z;
}

// Means of the eight fine cells of each coarse cell of the band; rates of strain are per step, and a coarse one is twice as long.
@compute @workgroup_size(WORKGROUP)
fn restrict_states(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= transfer.count {
        return;
    }
    let cell = transfer_cells[i];
    var sums = Numbers();
    for (var child = 0u; child < 8u; child++) {
        let numbers = numbers_of(level_state(gather(child_element(cell.x, child)), transfer.force.xyz), 2.0);
        for (var k = 0u; k < STATE_NUMBERS; k++) {
            sums[k] += numbers[k];
        }
    }
    for (var k = 0u; k < STATE_NUMBERS; k++) {
        level_states[cell.y + k * transfer.number_stride] = 0.125 * sums[k];
    }
}

@compute @workgroup_size(WORKGROUP)
fn write_band(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= transfer.count {
        return;
    }
    let cell = transfer_cells[i];
    var numbers: Numbers;
    for (var k = 0u; k < STATE_NUMBERS; k++) {
        numbers[k] = level_states[cell.y + k * transfer.number_stride];
    }
    place(cell.x, populations_with(state_with(numbers), transfer.force.xyz));
}

@compute @workgroup_size(WORKGROUP)
fn read_source(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= transfer.count {
        return;
    }
    let cell = transfer_cells[i];
    let numbers = numbers_of(level_state(gather(cell.x), transfer.force.xyz), 0.5);
    for (var k = 0u; k < STATE_NUMBERS; k++) {
        level_states[cell.y + k * transfer.number_stride] = numbers[k];
    }
}

// One of the two children of the middle of three cells: averages of the parabola that has theirs; `side` is 1 for the lower and -1 for the upper one.
fn child_of(below: f32, middle: f32, above: f32, side: f32) -> f32 {
    return middle + side * 0.125 * (below - above);
}

fn lower_or_upper(bit: u32) -> f32 {
    return 1.0 - 2.0 * f32(bit);
}

@compute @workgroup_size(WORKGROUP)
fn fill_shell(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    // A thread for each fine cell: eight of them share the states of 27 coarse ones.
    let i = thread_index(group, groups, local);
    if i >= 8u * transfer.count {
        return;
    }
    let cell = transfer_cells[i / 8u];
    let child = i % 8u;
    let side = vec3<f32>(lower_or_upper(child & 1u), lower_or_upper((child >> 1u) & 1u), lower_or_upper(child >> 2u));
    var numbers: Numbers;
    for (var k = 0u; k < STATE_NUMBERS; k++) {
        var planes: array<f32, 3>;
        for (var z = 0u; z < 3u; z++) {
            var rows: array<f32, 3>;
            for (var y = 0u; y < 3u; y++) {
                // The cell before the one in the middle.
                let first = cell.y + k * transfer.number_stride + z * transfer.plane_stride + y * transfer.row_stride;
                rows[y] = child_of(level_states[first], level_states[first + 1u], level_states[first + 2u], side.x);
            }
            planes[z] = child_of(rows[0], rows[1], rows[2], side.y);
        }
        numbers[k] = child_of(planes[0], planes[1], planes[2], side.z);
    }
    place(child_element(cell.x, child), populations_with(state_with(numbers), transfer.force.xyz));
}
