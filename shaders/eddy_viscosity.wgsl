// Stage eddy_viscosity: the eddy part of every cell's relaxation time, 3 nu_t, from the velocity gradient of its neighbours
// (src/lattice/eddy_viscosity.rs: sources and departures there), for the steps until it is evaluated again.

override CELLS_X: u32 = 2u;
override CELLS_Y: u32 = 2u;
override CELLS_Z: u32 = 2u;
// 0: WALE, 1: Vreman.
override GRADIENT_MODEL: u32 = 0u;
// 3 nu_t per value of the model.
override RELAXATION_FACTOR: f32 = 0.0;

const SMALLEST_SQUARE: f32 = 1e-30;

struct EddyParameters {
    // Velocity beyond a face, factor * u + offset of the cell before it; lower and upper face along x, y, z. A factor whose w is 1
    // stands for a periodic face, one whose w is 2 for the face of a box, where the velocity goes on as between the last two cells.
    factors: array<vec4<f32>, 6>,
    offsets: array<vec4<f32>, 6>,
    // First cell of this dispatch, and how many at most.
    first: u32,
    count: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(19) var<uniform> eddy: EddyParameters;
// 3 nu_t of every cell, x fastest.
@group(0) @binding(20) var<storage, read_write> eddy_relaxation_times: array<Stored>;

fn velocity(cell: vec3<u32>) -> vec3<f32> {
    let c = cell + 1u;
    return bare_state(gather(c.x + STRIDE_Y * c.y + STRIDE_Z * c.z)).xyz;
}

// Velocity beyond a face, or of the cell at the opposite one; `next` is the cell before that at the face.
fn beyond(face: u32, at_face: vec3<f32>, next: vec3<u32>, opposite: vec3<u32>) -> vec3<f32> {
    let factor = eddy.factors[face];
    if factor.w == 1.0 {
        return velocity(opposite);
    }
    if factor.w == 2.0 {
        return at_face + (at_face - velocity(next));
    }
    return factor.xyz * at_face + eddy.offsets[face].xyz;
}

// Central difference along an axis; `place` and `cells` are the cell's place on it and its length.
fn difference(axis: u32, cell: vec3<u32>, place: u32, cells: u32, here: vec3<f32>) -> vec3<f32> {
    let unit = vec3<u32>(u32(axis == 0u), u32(axis == 1u), u32(axis == 2u));
    let around = cell - place * unit;
    var below: vec3<f32>;
    var above: vec3<f32>;
    if place == 0u {
        below = beyond(2u * axis, here, cell + unit, around + (cells - 1u) * unit);
    } else {
        below = velocity(cell - unit);
    }
    if place == cells - 1u {
        above = beyond(2u * axis + 1u, here, cell - unit, around);
    } else {
        above = velocity(cell + unit);
    }
    return 0.5 * (above - below);
}

fn wale(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>) -> f32 {
    let gradient = mat3x3<f32>(x, y, z);
    let product = gradient * gradient;
    let third = (product[0].x + product[1].y + product[2].z) / 3.0;
    let normal = vec3<f32>(product[0].x, product[1].y, product[2].z) - third;
    let shear = 0.5 * vec3<f32>(product[0].y + product[1].x, product[0].z + product[2].x, product[1].z + product[2].y);
    let d = dot(normal, normal) + 2.0 * dot(shear, shear);
    let normal_strain = vec3<f32>(x.x, y.y, z.z);
    let shear_strain = 0.5 * vec3<f32>(x.y + y.x, x.z + z.x, y.z + z.y);
    let s = dot(normal_strain, normal_strain) + 2.0 * dot(shear_strain, shear_strain);
    let root = sqrt(d);
    return d * root / (s * s * sqrt(s) + d * sqrt(root) + SMALLEST_SQUARE);
}

fn vreman(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>) -> f32 {
    let xy = cross(x, y);
    let yz = cross(y, z);
    let zx = cross(z, x);
    return sqrt(dot(xy, xy) + dot(yz, yz) + dot(zx, zx));
}

@compute @workgroup_size(WORKGROUP)
fn eddy_viscosity(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let thread = thread_index(group, groups, local);
    let number = eddy.first + thread;
    if thread >= eddy.count || number >= CELLS_X * CELLS_Y * CELLS_Z {
        return;
    }
    let row = number / CELLS_X;
    let z = row / CELLS_Y;
    let cell = vec3<u32>(number - row * CELLS_X, row - z * CELLS_Y, z);
    let here = velocity(cell);
    let dx = difference(0u, cell, cell.x, CELLS_X, here);
    let dy = difference(1u, cell, cell.y, CELLS_Y, here);
    let dz = difference(2u, cell, cell.z, CELLS_Z, here);
    let norm = sqrt(dot(dx, dx) + dot(dy, dy) + dot(dz, dz) + SMALLEST_SQUARE);
    let inverse = 1.0 / norm;
    var value: f32;
    if GRADIENT_MODEL == 0u {
        value = wale(inverse * dx, inverse * dy, inverse * dz);
    } else {
        value = vreman(inverse * dx, inverse * dy, inverse * dz);
    }
    eddy_relaxation_times[number] = packed(RELAXATION_FACTOR * (norm * value));
}
