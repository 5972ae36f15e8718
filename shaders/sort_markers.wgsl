// Where a device makes steps by itself: markers at the nodes as they stand, sorted by the cell where their kernel begins, and by number within a cell.
//   find_cells       cell and fraction of every marker, and how many kernels begin in a cell
//   scan_cells       where the markers of every cell begin, counted within a block of cells
//   scan_blocks      where those of every block begin
//   scatter_markers  every marker to one of the places of its cell, whichever thread comes first
//   rank_markers     to the one by its number: one order, always the same

// Mirrors gpu::immersed::SortParameters.
struct SortParameters {
    // First cell of the box, and its size.
    box_first: vec4<i32>,
    box_size: vec4<i32>,
    // Centre of the lattice's first cell: whole numbers of 2⁻¹⁶ m, and remainders [m].
    origin_whole: vec4<i32>,
    origin_remainder: vec4<f32>,
    // Size of a cell alike, and cells in a metre.
    cell_whole: i32,
    cell_remainder: f32,
    cells_per_m: f32,
    // Cells and blocks of the box.
    box_count: u32,
    block_count: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> parameters: SortParameters;
// Of every node, three each: whole numbers and remainders.
@group(0) @binding(1) var<storage, read> nodes_whole: array<i32>;
@group(0) @binding(2) var<storage, read> nodes_remainder: array<f32>;
// Of every marker of the fabric: three nodes and their weights, word by word.
@group(0) @binding(3) var<storage, read> fabric_markers: array<u32>;
@group(0) @binding(4) var<storage, read> areas: array<f32>;
@group(0) @binding(5) var<storage, read_write> unsorted: array<Marker>;
// Markers whose kernel begins in a cell; none again once they are scattered.
@group(0) @binding(6) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> starts: array<u32>;
@group(0) @binding(8) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(9) var<storage, read_write> scattered: array<u32>;
@group(0) @binding(10) var<storage, read_write> markers: array<Marker>;
@group(0) @binding(11) var<storage, read_write> order: array<u32>;
// One more than the number of a marker that left the box; 0: none did.
@group(0) @binding(12) var<storage, read_write> strayed: array<atomic<u32>>;

override MARKERS: u32 = 1u;

// Cells that a thread, and that a workgroup scans.
const RUN: u32 = 16u;
const BLOCK: u32 = 1024u;
// The largest number below 1.
const BELOW_ONE: f32 = 0.99999994;

var<workgroup> sums: array<u32, WORKGROUP>;

fn node_place(node: u32) -> Place {
    let p = 3u * node;
    return Place(
        vec3<i32>(nodes_whole[p], nodes_whole[p + 1u], nodes_whole[p + 2u]),
        vec3<f32>(nodes_remainder[p], nodes_remainder[p + 1u], nodes_remainder[p + 2u]),
    );
}

fn marker_weight(corner: u32, k: u32) -> f32 {
    return bitcast<f32>(fabric_markers[(3u + corner) * MARKERS + k]);
}

// Distance from a cell's centre [cells].
fn from_cell(place: Place, cell: vec3<i32>) -> vec3<f32> {
    let whole = place.whole - cell * parameters.cell_whole;
    let rest = place.remainder - vec3<f32>(cell) * parameters.cell_remainder;
    return metres(Place(whole, rest)) * parameters.cells_per_m;
}

// Sum over all threads of lower number.
fn sum_below(local: u32, own: u32) -> u32 {
    sums[local] = own;
    for (var width = 1u; width < WORKGROUP; width <<= 1u) {
        workgroupBarrier();
        var below = 0u;
        if local >= width {
            below = sums[local - width];
        }
        workgroupBarrier();
        sums[local] += below;
    }
    workgroupBarrier();
    return sums[local] - own;
}

@compute @workgroup_size(WORKGROUP)
fn find_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= MARKERS {
        return;
    }
    // Counted from a corner of its triangle, an offset needs no whole numbers.
    let corner = node_place(fabric_markers[k]);
    let second = metres(between(corner, node_place(fabric_markers[MARKERS + k])));
    let third = metres(between(corner, node_place(fabric_markers[2u * MARKERS + k])));
    let offset = marker_weight(1u, k) * second + marker_weight(2u, k) * third;
    let origin = Place(parameters.origin_whole.xyz, parameters.origin_remainder.xyz);
    var place = between(origin, corner);
    place.remainder += offset;
    var cell = vec3<i32>(floor(from_cell(place, vec3<i32>(0))));
    cell += vec3<i32>(floor(from_cell(place, cell)));
    let fraction = clamp(from_cell(place, cell), vec3<f32>(0.0), vec3<f32>(BELOW_ONE));
    let first = cell - 1 - parameters.box_first.xyz;
    let last = parameters.box_size.xyz - 4;
    if any(first < vec3<i32>(0)) || any(first > last) {
        atomicMax(&strayed[0], k + 1u);
    }
    let kept = vec3<u32>(clamp(first, vec3<i32>(0), last));
    let size = vec3<u32>(parameters.box_size.xyz);
    let number = kept.x + size.x * (kept.y + size.y * kept.z);
    unsorted[k] = Marker(number, areas[k], 0u, k, vec4<f32>(fraction, 0.0));
    atomicAdd(&counts[number], 1u);
}

@compute @workgroup_size(WORKGROUP)
fn scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let block = group.y * groups.x + group.x;
    let first = block * BLOCK + local * RUN;
    let end = min(first + RUN, parameters.box_count);
    var own = 0u;
    for (var cell = first; cell < end; cell++) {
        own += atomicLoad(&counts[cell]);
    }
    var start = sum_below(local, own);
    for (var cell = first; cell < end; cell++) {
        starts[cell] = start;
        start += atomicLoad(&counts[cell]);
    }
    if local == WORKGROUP - 1u && block < parameters.block_count {
        blocks[block] = start;
    }
}

@compute @workgroup_size(WORKGROUP)
fn scan_blocks(@builtin(local_invocation_index) local: u32) {
    let run = (parameters.block_count + WORKGROUP - 1u) / WORKGROUP;
    let first = local * run;
    let end = min(first + run, parameters.block_count);
    var own = 0u;
    for (var block = first; block < end; block++) {
        own += blocks[block];
    }
    var start = sum_below(local, own);
    for (var block = first; block < end; block++) {
        let count = blocks[block];
        blocks[block] = start;
        start += count;
    }
}

fn start_of(cell: u32) -> u32 {
    return blocks[cell / BLOCK] + starts[cell];
}

@compute @workgroup_size(WORKGROUP)
fn scatter_markers(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= MARKERS {
        return;
    }
    let cell = unsorted[k].corner;
    scattered[start_of(cell) + atomicSub(&counts[cell], 1u) - 1u] = k;
}

@compute @workgroup_size(WORKGROUP)
fn rank_markers(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= MARKERS {
        return;
    }
    let own = unsorted[k];
    let start = start_of(own.corner);
    var rank = 0u;
    for (var place = start; place < MARKERS; place++) {
        let other = scattered[place];
        if unsorted[other].corner != own.corner {
            break;
        }
        rank += u32(other < k);
    }
    markers[start + rank] = own;
    order[start + rank] = k;
}
