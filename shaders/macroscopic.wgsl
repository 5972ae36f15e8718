// Density and velocity read back from the populations: whole fields for pictures, sums for balances, and the cells that
// stand out: the fastest one, and the one whose density is farthest off.

struct Region {
    // First cell and size of a box of cells.
    first_cell: vec4<u32>,
    size: vec4<u32>,
    // Number of cells in it, the first of them that this dispatch handles, and how many at most.
    count: u32,
    offset: u32,
    at_once: u32,
    padding: u32,
}

@group(0) @binding(19) var<uniform> region: Region;
// (u, density excess) of the cells of this dispatch.
@group(0) @binding(20) var<storage, read_write> states: array<vec4<f32>>;
// Per workgroup: density excess, momentum, 1/2 rho u^2, 3 unused.
@group(0) @binding(21) var<storage, read_write> partial_sums: array<f32>;
// Two per workgroup, of the fastest finite cell and of the one with the largest |density excess|: that value, the cell's number, its
// density excess and its squared speed, all as bits.
@group(0) @binding(22) var<storage, read_write> group_extremes: array<vec4<u32>>;

fn element_of(i: u32) -> u32 {
    let row = i / region.size.x;
    let x = i - row * region.size.x;
    let z = row / region.size.y;
    let y = row - z * region.size.y;
    let cell = vec3<u32>(x, y, z) + region.first_cell.xyz + 1u;
    return cell.x + STRIDE_Y * cell.y + STRIDE_Z * cell.z;
}

@compute @workgroup_size(WORKGROUP)
fn macroscopic(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    let cell = i + region.offset;
    if i < region.at_once && cell < region.count {
        states[i] = bare_state(gather(element_of(cell)));
    }
}

const SUMS: u32 = 8u;
var<workgroup> shared_sums: array<array<f32, 5>, WORKGROUP>;

@compute @workgroup_size(WORKGROUP)
fn totals(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    let cell = i + region.offset;
    var own = array<f32, 5>();
    if i < region.at_once && cell < region.count {
        let m = moments(gather(element_of(cell)));
        own = array<f32, 5>(m.density_excess, m.momentum.x, m.momentum.y, m.momentum.z,
            0.5 * dot(m.momentum, m.momentum) / (1.0 + m.density_excess));
    }
    shared_sums[local] = own;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            for (var k = 0u; k < 5u; k++) {
                shared_sums[local][k] += shared_sums[local + half][k];
            }
        }
        workgroupBarrier();
    }
    if local < 5u {
        let slot = group.y * groups.x + group.x;
        partial_sums[slot * SUMS + local] = shared_sums[0][local];
    }
}

// Comparisons with a number that is none may be compiled away; its bits may not.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

const INFINITE: u32 = 0x7f800000u;
const NO_CELL: u32 = 0xffffffffu;
// A value's bits and the number of its cell; bits of numbers that are not negative stand in the order of the numbers.
var<workgroup> shared_fastest: array<vec2<u32>, WORKGROUP>;
var<workgroup> shared_farthest: array<vec2<u32>, WORKGROUP>;

// The larger value; of equal ones that of the first cell.
fn larger(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    if b.x > a.x || (b.x == a.x && b.y < a.y) {
        return b;
    }
    return a;
}

@compute @workgroup_size(WORKGROUP)
fn extremes(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let i = thread_index(group, groups, local);
    let cell = i + region.offset;
    let inside = i < region.at_once && cell < region.count;
    var own = vec2<u32>();
    var fastest = vec2<u32>(0u, NO_CELL);
    var farthest = vec2<u32>(0u, NO_CELL);
    if inside {
        let state = bare_state(gather(element_of(cell)));
        let square = dot(state.xyz, state.xyz);
        own = vec2<u32>(bitcast<u32>(state.w), bitcast<u32>(square));
        if is_finite(state.w) && is_finite(square) {
            fastest = vec2<u32>(own.y, cell);
            farthest = vec2<u32>(bitcast<u32>(abs(state.w)), cell);
        } else {
            farthest = vec2<u32>(INFINITE, cell);
        }
    }
    shared_fastest[local] = fastest;
    shared_farthest[local] = farthest;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            shared_fastest[local] = larger(shared_fastest[local], shared_fastest[local + half]);
            shared_farthest[local] = larger(shared_farthest[local], shared_farthest[local + half]);
        }
        workgroupBarrier();
    }
    // The winners write; where no cell is finite, the first thread says so.
    let slot = 2u * (region.offset / WORKGROUP + group.y * groups.x + group.x);
    let most = shared_fastest[0];
    if inside && (cell == most.y || (local == 0u && most.y == NO_CELL)) {
        group_extremes[slot] = vec4<u32>(most, own);
    }
    if inside && cell == shared_farthest[0].y {
        group_extremes[slot + 1u] = vec4<u32>(shared_farthest[0], own);
    }
}
