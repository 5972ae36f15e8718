// Links that a surface cuts, as a device finds them (find_links.wgsl) and answers along them (moving_walls.wgsl): what both know of them.
//
// A link joins cell A with B = A + c; there are nine pairs of directions c and -c. `around` has, for every cell of a box around the surface, a bit of each pair for the cut links that begin
// there, and behind those one for the cut links that end there. Links are numbered by cell, then pair; sides of links by their links: twice the link's number, plus the side's.

struct WallParameters {
    // First cell of the box, and its size.
    box_first: vec4<i32>,
    box_size: vec4<i32>,
    // Cells of the lattice.
    cells: vec4<i32>,
    // Cells and blocks of the box.
    box_count: u32,
    block_count: u32,
    triangles: u32,
    // Links, and cells beside them, that there is room for.
    most_links: u32,
    most_cells: u32,
    // 1 in an odd step.
    odd: u32,
    // Element of the lattice's first cell, and from row to row and plane to plane.
    first_element: u32,
    stride_y: u32,
    stride_z: u32,
    // Where the sums of the forces of this step go.
    sums_from: u32,
    // Portions of the links whose forces are summed.
    portions: u32,
    padding: u32,
}

// A node of the surface.
struct WallNode {
    // The cell whose centre is nearest, and where the node is from there [cells].
    cell: vec3<i32>,
    padding_a: u32,
    offset: vec3<f32>,
    padding_b: u32,
    // Cells per step.
    velocity: vec3<f32>,
    padding_c: u32,
}

// What one side of a link gets back.
struct CutSide {
    // Weights of the nodes of its triangle.
    weights: vec3<f32>,
    triangle: u32,
    // Share of what left, of the further population, and of the wall's velocity.
    share: f32,
    further: f32,
    strength: f32,
    // Cuts on the link.
    layers: u32,
}

@group(0) @binding(40) var<uniform> walls: WallParameters;
@group(0) @binding(41) var<storage, read_write> wall_nodes: array<WallNode>;
// Three nodes, and what the triangle belongs to: 0 fabric, 1 and more a body.
@group(0) @binding(42) var<storage, read> wall_triangles: array<vec4<u32>>;
// Links that begin in the cells before, and those beside links: within a block, and before it.
@group(0) @binding(43) var<storage, read_write> starts: array<vec2<u32>>;
@group(0) @binding(44) var<storage, read_write> blocks: array<vec2<u32>>;
// Populations that are read and written, each with three words beside it; links; cells beside them.
@group(0) @binding(45) var<storage, read_write> totals: array<u32>;
@group(0) @binding(46) var<storage, read_write> cut_sides: array<CutSide>;
// By triangle: mean velocity of those who share what the air does to it, and 1 where it shares.
@group(0) @binding(56) var<storage, read_write> shared_velocities: array<vec4<f32>>;

// Places in `totals`.
const READ: u32 = 0u;
const WRITTEN: u32 = 4u;
const LINKS: u32 = 8u;
const CELLS: u32 = 9u;

const PAIRS: u32 = 9u;
// Bits of the pairs.
const ALL_PAIRS: u32 = 0x1ffu;
// No place in the box.
const OUTSIDE: u32 = 0xffffffffu;
// Cells that a workgroup scans.
const BLOCK: u32 = 1024u;

// c of a pair.
fn pair_direction(pair: u32) -> vec3<i32> {
    switch pair {
        case 0u: { return vec3<i32>(1, 0, 0); }
        case 1u: { return vec3<i32>(0, 1, 0); }
        case 2u: { return vec3<i32>(0, 0, 1); }
        case 3u: { return vec3<i32>(1, 1, 0); }
        case 4u: { return vec3<i32>(1, 0, 1); }
        case 5u: { return vec3<i32>(0, 1, 1); }
        case 6u: { return vec3<i32>(1, -1, 0); }
        case 7u: { return vec3<i32>(1, 0, -1); }
        default: { return vec3<i32>(0, 1, -1); }
    }
}

fn pair_weight(pair: u32) -> f32 {
    return select(1.0 / 36.0, 1.0 / 18.0, pair < 3u);
}

fn in_lattice(cell: vec3<i32>) -> bool {
    return all(cell >= vec3<i32>(0)) && all(cell < walls.cells.xyz);
}

fn box_place(cell: vec3<i32>) -> u32 {
    let inwards = cell - walls.box_first.xyz;
    if any(inwards < vec3<i32>(0)) || any(inwards >= walls.box_size.xyz) {
        return OUTSIDE;
    }
    let size = vec3<u32>(walls.box_size.xyz);
    let at = vec3<u32>(inwards);
    return at.x + size.x * (at.y + size.y * at.z);
}

fn cell_at(place: u32) -> vec3<i32> {
    let size = vec3<u32>(walls.box_size.xyz);
    let row = place / size.x;
    return walls.box_first.xyz + vec3<i32>(vec3<u32>(place % size.x, row % size.y, row / size.y));
}

// Links that begin, and cells beside links, before a cell of the box.
fn before(place: u32) -> vec2<u32> {
    return blocks[place / BLOCK] + starts[place];
}

// Number of the link of a pair that begins in a cell of the box with these bits.
fn link_number(place: u32, bits: u32, pair: u32) -> u32 {
    return before(place).x + countOneBits(bits & ((1u << pair) - 1u));
}

fn element(cell: vec3<i32>) -> u32 {
    return walls.first_element + u32(cell.x) + u32(cell.y) * walls.stride_y + u32(cell.z) * walls.stride_z;
}
