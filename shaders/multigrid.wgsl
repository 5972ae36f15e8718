// Stage multigrid: one V-cycle for `right`, from zero (src/solve/multigrid/mod.rs). On every level but the coarsest
//
//   smooth_from_zero, smooth_again, take_residual, restrict_residual … interpolate, smooth_corrected, smooth_again,
//
// each one thread per row; rows are read and written by their own thread, and what is multiplied is never written at the same time.

@group(0) @binding(5) var<storage, read> inverse_diagonal: array<f32>;
// (share of the old step that is kept, factor of the new one) of every sweep of the smoother.
@group(0) @binding(6) var<storage, read> chebyshev: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read> right: array<f32>;
@group(0) @binding(8) var<storage, read_write> residual: array<f32>;
@group(0) @binding(9) var<storage, read_write> solution: array<f32>;
@group(0) @binding(10) var<storage, read_write> new_step: array<f32>;
// Number of the sweep, in x.
@group(0) @binding(11) var<uniform> sweep: vec4<u32>;
@group(0) @binding(12) var<storage, read> interpolation_first: array<u32>;
// Coarse node, weight.
@group(0) @binding(13) var<storage, read> interpolation: array<vec2<u32>>;
@group(0) @binding(14) var<storage, read> restriction_first: array<u32>;
// Fine node, weight.
@group(0) @binding(15) var<storage, read> restriction: array<vec2<u32>>;
// Of the finer level, on the coarser.
@group(0) @binding(16) var<storage, read> fine_residual: array<f32>;
@group(0) @binding(17) var<storage, read_write> coarse_right: array<f32>;
@group(0) @binding(18) var<storage, read> coarse_solution: array<f32>;
// Symmetric, dense.
@group(0) @binding(19) var<storage, read> coarsest_inverse: array<f32>;

// Inverse of the diagonal block times a vector; a block is kept as (xx, yy, zz, xy, xz, yz).
fn divided(row: u32, v: vec3<f32>) -> vec3<f32> {
    let b = row * 6u;
    let off = vec3<f32>(inverse_diagonal[b + 3u], inverse_diagonal[b + 4u], inverse_diagonal[b + 5u]);
    return vec3<f32>(
        inverse_diagonal[b] * v.x + off.x * v.y + off.y * v.z,
        off.x * v.x + inverse_diagonal[b + 1u] * v.y + off.z * v.z,
        off.y * v.x + off.z * v.y + inverse_diagonal[b + 2u] * v.z,
    );
}

fn own_right(row: u32) -> vec3<f32> {
    let k = row * 3u;
    return vec3<f32>(right[k], right[k + 1u], right[k + 2u]);
}

fn own_residual(row: u32) -> vec3<f32> {
    let k = row * 3u;
    return vec3<f32>(residual[k], residual[k + 1u], residual[k + 2u]);
}

fn own_operand(row: u32) -> vec3<f32> {
    let k = row * 3u;
    return vec3<f32>(operand[k], operand[k + 1u], operand[k + 2u]);
}

fn own_solution(row: u32) -> vec3<f32> {
    let k = row * 3u;
    return vec3<f32>(solution[k], solution[k + 1u], solution[k + 2u]);
}

fn set_residual(row: u32, v: vec3<f32>) {
    let k = row * 3u;
    residual[k] = v.x;
    residual[k + 1u] = v.y;
    residual[k + 2u] = v.z;
}

fn set_solution(row: u32, v: vec3<f32>) {
    let k = row * 3u;
    solution[k] = v.x;
    solution[k + 1u] = v.y;
    solution[k + 2u] = v.z;
}

fn set_new_step(row: u32, v: vec3<f32>) {
    let k = row * 3u;
    new_step[k] = v.x;
    new_step[k + 1u] = v.y;
    new_step[k + 2u] = v.z;
}

// First sweep of the smoother from a solution of zero.
@compute @workgroup_size(64)
fn smooth_from_zero(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    let r = own_right(row);
    let step = chebyshev[0].y * divided(row, r);
    set_residual(row, r);
    set_new_step(row, step);
    set_solution(row, step);
}

// First sweep of the smoother from the corrected solution, the operand.
@compute @workgroup_size(64)
fn smooth_corrected(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    let r = own_right(row) - multiply_row(row);
    let step = chebyshev[0].y * divided(row, r);
    set_residual(row, r);
    set_new_step(row, step);
    set_solution(row, own_operand(row) + step);
}

// Another sweep; the operand is the step of the one before.
@compute @workgroup_size(64)
fn smooth_again(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    let r = own_residual(row) - multiply_row(row);
    let factors = chebyshev[sweep.x];
    let step = factors.x * own_operand(row) + factors.y * divided(row, r);
    set_residual(row, r);
    set_new_step(row, step);
    set_solution(row, own_solution(row) + step);
}

// What the last sweep, whose step is the operand, leaves of the residual.
@compute @workgroup_size(64)
fn take_residual(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row < level.nodes {
        set_residual(row, own_residual(row) - multiply_row(row));
    }
}

// The matrix times the operand, for Newton's method; on the finest level.
@compute @workgroup_size(64)
fn multiply(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row < level.nodes {
        set_new_step(row, multiply_row(row));
    }
}

// Right side of the coarser level.
@compute @workgroup_size(64)
fn restrict_residual(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var k = restriction_first[row]; k < restriction_first[row + 1u]; k++) {
        let entry = restriction[k];
        let fine = entry.x * 3u;
        sum += bitcast<f32>(entry.y)
            * vec3<f32>(fine_residual[fine], fine_residual[fine + 1u], fine_residual[fine + 2u]);
    }
    let to = row * 3u;
    coarse_right[to] = sum.x;
    coarse_right[to + 1u] = sum.y;
    coarse_right[to + 2u] = sum.z;
}

// The solution corrected by that of the coarser level, in place of a step.
@compute @workgroup_size(64)
fn interpolate_correction(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    var sum = own_solution(row);
    for (var k = interpolation_first[row]; k < interpolation_first[row + 1u]; k++) {
        let entry = interpolation[k];
        let coarse = entry.x * 3u;
        sum += bitcast<f32>(entry.y)
            * vec3<f32>(coarse_solution[coarse], coarse_solution[coarse + 1u], coarse_solution[coarse + 2u]);
    }
    set_new_step(row, sum);
}

// The coarsest level, one thread per unknown; the inverse is read by columns, being symmetric.
@compute @workgroup_size(64)
fn solve_coarsest(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let unknown = thread_index(group, groups, local);
    if unknown >= level.unknowns {
        return;
    }
    var sum = 0.0;
    for (var k = 0u; k < level.unknowns; k++) {
        sum += coarsest_inverse[k * level.unknowns + unknown] * right[k];
    }
    solution[unknown] = sum;
}
