// Markers of the immersed boundary, sorted by the first cell under their kernel within the box that holds all kernels. A cell finds the
// markers that reach it by a lookup of that first cell: 4 x 4 rows of 4 neighbouring entries. Sums over markers have one order, so
// spreading gives the same bits every time, without atomics on numbers.

struct MarkerParameters {
    box_first: vec4<u32>,
    // In w: 1 where kernels go on through the sides of y, 2 through those of z; the box is the whole domain there.
    box_size: vec4<u32>,
    marker_count: u32,
    box_count: u32,
    over_relaxation: f32,
    largest_strength: f32,
}

@group(0) @binding(19) var<uniform> parameters: MarkerParameters;
@group(0) @binding(20) var<storage, read> markers: array<Marker>;
// Kernel weights along x, y, z, four each; KERNEL_STRIDE in all for a marker.
@group(0) @binding(21) var<storage, read_write> weights: array<f32>;
// Per cell of the box: 1 + the first marker whose kernel begins here, and the flag of a touched cell.
@group(0) @binding(22) var<storage, read> touched: array<u32>;
const TOUCHED: u32 = 0x80000000u;

fn box_cell(i: u32) -> vec3<u32> {
    let row = i / parameters.box_size.x;
    let z = row / parameters.box_size.y;
    return vec3<u32>(i - row * parameters.box_size.x, row - z * parameters.box_size.y, z);
}

fn box_number(cell: vec3<u32>) -> u32 {
    return cell.x + parameters.box_size.x * (cell.y + parameters.box_size.y * cell.z);
}

// First of the four cells of a marker's kernel in its row y, z; rows go on at the other end of the box where the domain repeats.
fn kernel_row(corner: u32, y: u32, z: u32) -> u32 {
    let row = corner + parameters.box_size.x * (y + parameters.box_size.y * z);
    if parameters.box_size.w == 0u {
        return row;
    }
    let c = box_cell(corner);
    return c.x + parameters.box_size.x
        * ((c.y + y) % parameters.box_size.y + parameters.box_size.y * ((c.z + z) % parameters.box_size.z));
}

// Rows of kernels along y and z that reach a cell from below: four, or fewer at the border of the box.
fn rows_below(b: vec3<u32>) -> vec2<u32> {
    let through = vec2<bool>((parameters.box_size.w & 1u) != 0u, (parameters.box_size.w & 2u) != 0u);
    return select(min(vec2<u32>(4u), b.yz + 1u), vec2<u32>(4u), through);
}

// First cell of the row of the box that lies y and z below a cell.
fn row_below(b: vec3<u32>, y: u32, z: u32) -> u32 {
    let size = parameters.box_size.yz;
    let up = vec2<u32>(y, z);
    let below = select(b.yz - up, b.yz + size - up, b.yz < up);
    return parameters.box_size.x * (below.x + size.x * below.y);
}

// First marker whose kernel begins in the given run of cells; the number of markers if there is none.
fn first_marker(from_cell: u32, last_cell: u32) -> u32 {
    for (var i = from_cell; i <= last_cell; i++) {
        let found = touched[i] & ~TOUCHED;
        if found > 0u {
            return found - 1u;
        }
    }
    return parameters.marker_count;
}
