// A matrix of 3×3 blocks in slices of 64 rows, so that neighbouring threads read neighbouring numbers. Block k of a slice's rows
// starts at place (slices[s] + k)·64 + lane in `columns`; component c of that block is matrix[((slices[s] + k)·9 + c)·64 + lane].
// Rows shorter than the longest of their slice are filled up with zero blocks in their own column. Vectors have three numbers per row.

// Mirrors gpu::multigrid::parameters::MultigridLevel.
struct MultigridLevel {
    nodes: u32,
    // Places of the next coarser matrix.
    coarse_places: u32,
    // Workgroups that stride over the nodes where sums are wanted.
    strides: u32,
    // 3 · nodes of a level that is solved directly.
    unknowns: u32,
}

@group(0) @binding(0) var<uniform> level: MultigridLevel;
@group(0) @binding(1) var<storage, read> slices: array<u32>;
@group(0) @binding(2) var<storage, read> columns: array<u32>;
@group(0) @binding(3) var<storage, read> matrix: array<f32>;
// The vector that is multiplied.
@group(0) @binding(4) var<storage, read> operand: array<f32>;

const BLOCK: u32 = 576u; // 9 · 64

fn multiply_row(row: u32) -> vec3<f32> {
    let slice = row / WORKGROUP;
    let lane = row % WORKGROUP;
    var sum = vec3<f32>(0.0);
    for (var k = slices[slice]; k < slices[slice + 1u]; k++) {
        let from_row = columns[k * WORKGROUP + lane] * 3u;
        let v = vec3<f32>(operand[from_row], operand[from_row + 1u], operand[from_row + 2u]);
        let b = k * BLOCK + lane;
        sum += vec3<f32>(
            matrix[b] * v.x + matrix[b + 64u] * v.y + matrix[b + 128u] * v.z,
            matrix[b + 192u] * v.x + matrix[b + 256u] * v.y + matrix[b + 320u] * v.z,
            matrix[b + 384u] * v.x + matrix[b + 448u] * v.y + matrix[b + 512u] * v.z,
        );
    }
    return sum;
}
