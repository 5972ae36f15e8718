// Stage multigrid_refresh: what the cycle needs of a new finest matrix (src/solve/multigrid/mod.rs): coarser matrices PᵀAP, inverse
// diagonal blocks, and the smoother's polynomial from an estimate of the largest eigenvalue of D⁻¹A.

@group(0) @binding(5) var<storage, read_write> inverse_diagonal: array<f32>;
@group(0) @binding(6) var<storage, read_write> chebyshev: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read_write> eigenvector: array<f32>;
@group(0) @binding(8) var<storage, read_write> new_step: array<f32>;
// Σ |step|² of every workgroup of `power_step`.
@group(0) @binding(9) var<storage, read_write> squares: array<f32>;
@group(0) @binding(12) var<storage, read> interpolation_first: array<u32>;
@group(0) @binding(13) var<storage, read> interpolation: array<vec2<u32>>;
@group(0) @binding(14) var<storage, read> restriction_first: array<u32>;
@group(0) @binding(15) var<storage, read> restriction: array<vec2<u32>>;
@group(0) @binding(16) var<storage, read> coarse_columns: array<u32>;
// Row of every place of the coarser matrix; NONE where it only fills up.
@group(0) @binding(17) var<storage, read> coarse_rows: array<u32>;
@group(0) @binding(18) var<storage, read_write> coarse_matrix: array<f32>;
@group(0) @binding(19) var<storage, read> eigenvector_guess: array<f32>;

// Values of src/solve/multigrid/mod.rs.
override SWEEPS: u32 = 1u;
override SMOOTHED_SHARE: f32 = 0.1;
override EIGENVALUE_MARGIN: f32 = 1.0;

const NONE: u32 = 0xffffffffu;

var<workgroup> shared_sums: array<f32, 64>;

fn interpolation_weight(fine: u32, coarse: u32) -> f32 {
    for (var k = interpolation_first[fine]; k < interpolation_first[fine + 1u]; k++) {
        let entry = interpolation[k];
        if entry.x == coarse {
            return bitcast<f32>(entry.y);
        }
    }
    return 0.0;
}

// One block of PᵀAP per thread, summed in the order of the fine rows.
@compute @workgroup_size(64)
fn galerkin(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let place = thread_index(group, groups, local);
    if place >= level.coarse_places {
        return;
    }
    let row = coarse_rows[place];
    if row == NONE {
        return;
    }
    let column = coarse_columns[place];
    var sum0 = vec3<f32>(0.0);
    var sum1 = vec3<f32>(0.0);
    var sum2 = vec3<f32>(0.0);
    for (var r = restriction_first[row]; r < restriction_first[row + 1u]; r++) {
        let entry = restriction[r];
        let slice = entry.x / WORKGROUP;
        let lane = entry.x % WORKGROUP;
        let share = bitcast<f32>(entry.y);
        for (var k = slices[slice]; k < slices[slice + 1u]; k++) {
            let factor = share * interpolation_weight(columns[k * WORKGROUP + lane], column);
            if factor != 0.0 {
                let b = k * BLOCK + lane;
                sum0 += factor * vec3<f32>(matrix[b], matrix[b + 64u], matrix[b + 128u]);
                sum1 += factor * vec3<f32>(matrix[b + 192u], matrix[b + 256u], matrix[b + 320u]);
                sum2 += factor * vec3<f32>(matrix[b + 384u], matrix[b + 448u], matrix[b + 512u]);
            }
        }
    }
    let to = place / WORKGROUP * BLOCK + place % WORKGROUP;
    coarse_matrix[to] = sum0.x;
    coarse_matrix[to + 64u] = sum0.y;
    coarse_matrix[to + 128u] = sum0.z;
    coarse_matrix[to + 192u] = sum1.x;
    coarse_matrix[to + 256u] = sum1.y;
    coarse_matrix[to + 320u] = sum1.z;
    coarse_matrix[to + 384u] = sum2.x;
    coarse_matrix[to + 448u] = sum2.y;
    coarse_matrix[to + 512u] = sum2.z;
}

// Inverse of every diagonal block; zero where nothing is stiff, as at held nodes.
@compute @workgroup_size(64)
fn invert_diagonal(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    let slice = row / WORKGROUP;
    let lane = row % WORKGROUP;
    var block = isotropic(0.0);
    for (var k = slices[slice]; k < slices[slice + 1u]; k++) {
        // What fills the row up follows the diagonal block.
        if columns[k * WORKGROUP + lane] == row {
            let b = k * BLOCK + lane;
            block = Block(
                vec3<f32>(matrix[b], matrix[b + 256u], matrix[b + 512u]),
                vec3<f32>(matrix[b + 64u], matrix[b + 128u], matrix[b + 320u]),
            );
            break;
        }
    }
    let largest = max(block.diagonal.x, max(block.diagonal.y, block.diagonal.z));
    var inverse = isotropic(0.0);
    if largest > 0.0 && is_finite(largest) {
        inverse = inverted(block, largest);
    }
    let to = row * 6u;
    inverse_diagonal[to] = inverse.diagonal.x;
    inverse_diagonal[to + 1u] = inverse.diagonal.y;
    inverse_diagonal[to + 2u] = inverse.diagonal.z;
    inverse_diagonal[to + 3u] = inverse.off.x;
    inverse_diagonal[to + 4u] = inverse.off.y;
    inverse_diagonal[to + 5u] = inverse.off.z;
}

// The stiffest place may have moved to where the last eigenvector has no part.
@compute @workgroup_size(64)
fn power_start(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = thread_index(group, groups, local);
    if row >= level.nodes {
        return;
    }
    for (var k = row * 3u; k < row * 3u + 3u; k++) {
        eigenvector[k] += eigenvector_guess[k];
    }
}

// D⁻¹A times the vector so far (the operand), and its square.
@compute @workgroup_size(64)
fn power_step(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var sum = 0.0;
    for (var row = group.x * WORKGROUP + local; row < level.nodes; row += level.strides * WORKGROUP) {
        let v = multiply_row(row);
        let b = row * 6u;
        let off = vec3<f32>(inverse_diagonal[b + 3u], inverse_diagonal[b + 4u], inverse_diagonal[b + 5u]);
        let step = vec3<f32>(
            inverse_diagonal[b] * v.x + off.x * v.y + off.y * v.z,
            off.x * v.x + inverse_diagonal[b + 1u] * v.y + off.z * v.z,
            off.y * v.x + off.z * v.y + inverse_diagonal[b + 2u] * v.z,
        );
        let to = row * 3u;
        new_step[to] = step.x;
        new_step[to + 1u] = step.y;
        new_step[to + 2u] = step.z;
        sum += dot(step, step);
    }
    shared_sums[local] = sum;
    for (var width = 32u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            shared_sums[local] += shared_sums[local + width];
        }
    }
    if local == 0u {
        squares[group.x] = shared_sums[0];
    }
}

// Makes that product the next unit vector; its length estimates the largest eigenvalue, which fixes the polynomial.
@compute @workgroup_size(64)
fn power_normalise(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    var square = 0.0;
    for (var k = 0u; k < level.strides; k++) {
        square += squares[k];
    }
    if !(square > 0.0 && is_finite(square)) {
        return;
    }
    let largest = sqrt(square);
    for (var row = group.x * WORKGROUP + local; row < level.nodes; row += level.strides * WORKGROUP) {
        for (var k = row * 3u; k < row * 3u + 3u; k++) {
            eigenvector[k] = new_step[k] / largest;
        }
    }
    if group.x == 0u && local == 0u {
        let upper = EIGENVALUE_MARGIN * largest;
        let lower = SMOOTHED_SHARE * upper;
        let centre = 0.5 * (upper + lower);
        let half_width = 0.5 * (upper - lower);
        let sigma = centre / half_width;
        var rho = 1.0 / sigma;
        chebyshev[0] = vec2<f32>(0.0, 1.0 / centre);
        for (var k = 1u; k < SWEEPS; k++) {
            let next = 1.0 / (2.0 * sigma - rho);
            chebyshev[k] = vec2<f32>(next * rho, 2.0 * next / half_width);
            rho = next;
        }
    }
}
