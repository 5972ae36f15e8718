// Faces that let sound out: the inlet and the sides (src/lattice/faces.rs tells how). A thread per cell of a face. The inlet's stage comes before
// `boundaries`, which mirror what its ghosts send; the sides' after it, those of y and of z one after the other, since they share edges.

struct AbsorbingFace {
    // (array, element) of the populations of the first cell that leave through the face: along its normal, then the four diagonals.
    leaving: array<vec4<u32>, 5>,
    // (array, element) of those that enter, in the same order.
    entering: array<vec4<u32>, 5>,
    // Of the inlet: (array, element) of the populations that move along it from its first cell, and their velocities along y and z, plus one.
    along: array<vec4<u32>, 16>,
    // Cells of a row, rows, elements from cell to cell, elements from row to row.
    shape: vec4<u32>,
    first_mean: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Flow through the inlet over the density of a wave that leaves.
override INLET_IMPEDANCE: f32 = 0.0;
// Share of the tangential momentum of the first cell, over its running mean, that the inlet has.
override INLET_TANGENTIAL: f32 = 0.0;
// Flow out of a side over the populations that meet it.
override SIDE_FLOW: f32 = 0.0;
// Share of the present that the running means take in a step.
override PRESENT_SHARE: f32 = 0.0;

@group(0) @binding(19) var<storage, read> faces: array<AbsorbingFace>;
@group(0) @binding(20) var<storage, read_write> means: array<f32>;
@group(0) @binding(21) var<uniform> step: StepParameters;
// Of an inlet whose wind is not the same everywhere, y fastest: speed of every cell over that of the inlet, and 3(1 − τ) times its rates of change
// along y and z.
@group(0) @binding(22) var<storage, read> profile: array<vec4<f32>>;

const AXIS: f32 = 1.0 / 18.0;
const DIAGONAL: f32 = 1.0 / 36.0;
// Running means of a cell at the inlet: density, and momenta along y and z.
const INLET_MEANS: u32 = 3u;

struct FaceCell {
    // Elements from those of the first cell.
    shift: u32,
    mean: u32,
    inside: bool,
}

fn face_cell(face: u32, i: u32) -> FaceCell {
    let shape = faces[face].shape;
    let row = i / shape.x;
    var cell: FaceCell;
    cell.shift = (i - row * shape.x) * shape.z + row * shape.w;
    cell.mean = faces[face].first_mean + i;
    cell.inside = row < shape.y;
    return cell;
}

@compute @workgroup_size(WORKGROUP)
fn absorb_at_inlet(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let cell = face_cell(0u, group.x * WORKGROUP + local);
    if cell.inside {
        answer_at_inlet(cell, step.inlet_velocity.xyz, vec2<f32>(0.0));
    }
}

@compute @workgroup_size(WORKGROUP)
fn absorb_at_profiled_inlet(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = group.x * WORKGROUP + local;
    let cell = face_cell(0u, i);
    if cell.inside {
        answer_at_inlet(cell, profile[i].x * step.inlet_velocity.xyz, profile[i].yz * step.inlet_velocity.x);
    }
}

fn answer_at_inlet(cell: FaceCell, wind: vec3<f32>, shear: vec2<f32>) {
    var met: array<f32, 5>;
    for (var k = 0u; k < 5u; k++) {
        let slot = faces[0].leaving[k];
        met[k] = load(slot.x, slot.y + cell.shift);
    }
    let square = 3.0 * wind.x * wind.x;
    let sum = met[0] + ((met[1] + met[3]) + (met[2] + met[4]));
    var momentum = vec2<f32>(0.0);
    for (var k = 0u; k < 16u; k++) {
        let slot = faces[0].along[k];
        momentum += (vec2<f32>(slot.zw) - 1.0) * load(slot.x, slot.y + cell.shift);
    }
    let mean = INLET_MEANS * cell.mean;
    let past = means[mean];
    let over_mean = 6.0 * sum + (3.0 * wind.x - square) - past;
    means[mean] = past + PRESENT_SHARE * over_mean;
    let past_momentum = vec2<f32>(means[mean + 1u], means[mean + 2u]);
    let over_momentum = momentum - past_momentum;
    let new_momentum = past_momentum + PRESENT_SHARE * over_momentum;
    means[mean + 1u] = new_momentum.x;
    means[mean + 2u] = new_momentum.y;
    let wave = over_mean / (1.0 - 3.0 * wind.x + square + (3.0 - 6.0 * wind.x) * INLET_IMPEDANCE);
    let excess = past + wave;
    let u = vec3<f32>(wind.x - INLET_IMPEDANCE * wave, wind.yz + INLET_TANGENTIAL * over_momentum);
    send(0u, cell.shift, shifted_equilibrium(AXIS, vec3<f32>(1.0, 0.0, 0.0), excess, u));
    send(1u, cell.shift, shifted_equilibrium(DIAGONAL, vec3<f32>(1.0, 1.0, 0.0), excess, u) + DIAGONAL * shear.x);
    send(2u, cell.shift, shifted_equilibrium(DIAGONAL, vec3<f32>(1.0, 0.0, 1.0), excess, u) + DIAGONAL * shear.y);
    send(3u, cell.shift, shifted_equilibrium(DIAGONAL, vec3<f32>(1.0, -1.0, 0.0), excess, u) - DIAGONAL * shear.x);
    send(4u, cell.shift, shifted_equilibrium(DIAGONAL, vec3<f32>(1.0, 0.0, -1.0), excess, u) - DIAGONAL * shear.y);
}

fn send(k: u32, shift: u32, population: f32) {
    let slot = faces[0].entering[k];
    store(slot.x, slot.y + shift, population);
}

@compute @workgroup_size(WORKGROUP)
fn absorb_at_sides(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let face = group.y;
    let cell = face_cell(face, group.x * WORKGROUP + local);
    if !cell.inside {
        return;
    }
    var met: array<f32, 5>;
    var sum = 0.0;
    for (var k = 0u; k < 5u; k++) {
        let slot = faces[face].leaving[k];
        met[k] = load(slot.x, slot.y + cell.shift);
        sum += met[k];
    }
    let past = means[cell.mean];
    let over_mean = sum - past;
    means[cell.mean] = past + PRESENT_SHARE * over_mean;
    let taken = SIDE_FLOW * over_mean / (1.0 / 6.0 + sum);
    for (var k = 0u; k < 5u; k++) {
        let slot = faces[face].entering[k];
        let weight = select(DIAGONAL, AXIS, k == 0u);
        store(slot.x, slot.y + cell.shift, met[k] - taken * (met[k] + weight));
    }
}
