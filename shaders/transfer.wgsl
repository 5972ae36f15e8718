// Between a lattice and a box of finer cells in it (src/lattice/nest.rs), through a buffer of states: a shader touches the populations of one
// lattice only. The order is restrict_states (on the fine lattice), write_band (coarse), read_source (coarse), fill_shell (fine).

override RELAXATION_TIME: f32 = 1.0;
override CELLS_X: u32 = 2u;
override CELLS_Y: u32 = 2u;

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
@group(0) @binding(22) var<storage, read_write> level_states: array<f32>;

// No arrays below: an index that a loop counts up would keep them out of registers.

fn state_at(place: u32) -> LevelState {
    let n = transfer.number_stride;
    return LevelState(level_states[place],
        vec3<f32>(level_states[place + n], level_states[place + 2u * n], level_states[place + 3u * n]),
        vec3<f32>(level_states[place + 4u * n], level_states[place + 5u * n], level_states[place + 6u * n]),
        vec3<f32>(level_states[place + 7u * n], level_states[place + 8u * n], level_states[place + 9u * n]));
}

fn set_state(place: u32, s: LevelState) {
    let n = transfer.number_stride;
    level_states[place] = s.density_excess;
    level_states[place + n] = s.momentum.x;
    level_states[place + 2u * n] = s.momentum.y;
    level_states[place + 3u * n] = s.momentum.z;
    level_states[place + 4u * n] = s.normal.x;
    level_states[place + 5u * n] = s.normal.y;
    level_states[place + 6u * n] = s.normal.z;
    level_states[place + 7u * n] = s.shear.x;
    level_states[place + 8u * n] = s.shear.y;
    level_states[place + 9u * n] = s.shear.z;
}

// Element of one of the eight fine cells of a coarse one.
fn child_element(first: u32, child: u32) -> u32 {
    return first + (child & 1u) + ((child >> 1u) & 1u) * STRIDE_Y + (child >> 2u) * STRIDE_Z;
}

// Relaxation time of a cell, without what its collision evaluates itself.
fn relaxation_time_at(element: u32) -> f32 {
    let z = element / STRIDE_Z;
    let in_plane = element % STRIDE_Z;
    // One layer of ghosts comes first along every axis.
    return with_eddy_viscosity(RELAXATION_TIME, vec3<u32>(in_plane % STRIDE_Y, in_plane / STRIDE_Y, z) - 1u);
}

fn state_of(element: u32) -> LevelState {
    return level_state(gather(element), transfer.force.xyz, relaxation_time_at(element));
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
    var sum = LevelState();
    for (var child = 0u; child < 8u; child++) {
        let state = state_of(child_element(cell.x, child));
        sum.density_excess += state.density_excess;
        sum.momentum += state.momentum;
        sum.normal += 2.0 * state.normal;
        sum.shear += 2.0 * state.shear;
    }
    set_state(cell.y, LevelState(0.125 * sum.density_excess, 0.125 * sum.momentum, 0.125 * sum.normal, 0.125 * sum.shear));
}

@compute @workgroup_size(WORKGROUP)
fn write_band(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= transfer.count {
        return;
    }
    let cell = transfer_cells[i];
    place(cell.x, populations_with(state_at(cell.y), transfer.force.xyz, relaxation_time_at(cell.x)));
}

@compute @workgroup_size(WORKGROUP)
fn read_source(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    if i >= transfer.count {
        return;
    }
    let cell = transfer_cells[i];
    let state = state_of(cell.x);
    set_state(cell.y, LevelState(state.density_excess, state.momentum, 0.5 * state.normal, 0.5 * state.shear));
}

// One of the two children of the middle of three cells: averages of the parabola that has theirs; `side` is 1 for the lower and -1 for the upper one.
fn child_of(below: f32, middle: f32, above: f32, side: f32) -> f32 {
    return middle + side * 0.125 * (below - above);
}

fn lower_or_upper(bit: u32) -> f32 {
    return 1.0 - 2.0 * f32(bit);
}

fn child_in_row(first: u32, side: vec3<f32>) -> f32 {
    return child_of(level_states[first], level_states[first + 1u], level_states[first + 2u], side.x);
}

fn child_in_plane(first: u32, side: vec3<f32>) -> f32 {
    let r = transfer.row_stride;
    return child_of(child_in_row(first, side), child_in_row(first + r, side), child_in_row(first + 2u * r, side), side.y);
}

// Number `k` of a child, from those of 27 coarse cells of which `first` is the first.
fn child_number(first: u32, k: u32, side: vec3<f32>) -> f32 {
    let at = first + k * transfer.number_stride;
    let p = transfer.plane_stride;
    return child_of(child_in_plane(at, side), child_in_plane(at + p, side), child_in_plane(at + 2u * p, side), side.z);
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
    let f = cell.y;
    let state = LevelState(child_number(f, 0u, side),
        vec3<f32>(child_number(f, 1u, side), child_number(f, 2u, side), child_number(f, 3u, side)),
        vec3<f32>(child_number(f, 4u, side), child_number(f, 5u, side), child_number(f, 6u, side)),
        vec3<f32>(child_number(f, 7u, side), child_number(f, 8u, side), child_number(f, 9u, side)));
    let element = child_element(cell.x, child);
    place(element, populations_with(state, transfer.force.xyz, relaxation_time_at(element)));
}
