// Stage collide_stream: one in-place step of every cell. Threads run along the padded planes, so that neighbours read neighbouring
// elements; those on ghosts have nothing to do.
//
// A step is one dispatch, or two: of all cells but those of a box, and later, when the structure has moved, of these.
//
// Three entry points: without a force, under one acceleration of all air, and with the body force near the sheet besides.

override CELLS_X: u32 = 2u;
override CELLS_Y: u32 = 2u;
override RELAXATION_TIME: f32 = 1.0;
// The ghosts of a pressure outlet at +x stream for themselves; those of the inlet have a stage of their own (absorbing_faces.wgsl).
override INLET_OUTLET: bool = false;
// Length of the viscous sponge before the outlet [cells]; 0 without one.
override SPONGE_LENGTH: f32 = 0.0;
const SPONGE_RELAXATION_TIME: f32 = 1.0;
// Share of its density excess that the outlet loses per step, times CELLS_X.
override OUTLET_RELAXATION: f32 = 0.0;
// Delay of sound between the last cell and the outlet's ghost [steps].
override OUTLET_DELAY: f32 = 0.0;
// Change of velocity over that of density of a wave that leaves there, in units of the speed of sound.
override OUTLET_COSINE: f32 = 1.0;
// Threads of a workgroup of this stage; all others have WORKGROUP.
override COLLIDE_WORKGROUP: u32 = WORKGROUP;
// Cells deep below a box of finer cells, which are left out (src/lattice/nest.rs); none where the ends are 0.
override IDLE_FIRST_X: u32 = 0u;
override IDLE_FIRST_Y: u32 = 0u;
override IDLE_FIRST_Z: u32 = 0u;
override IDLE_END_X: u32 = 0u;
override IDLE_END_Y: u32 = 0u;
override IDLE_END_Z: u32 = 0u;
const SOUND_SPEED: f32 = 0.57735026919;

@group(0) @binding(19) var<uniform> step: StepParameters;
// Body force of the cells of the box (x, y, z, unused).
@group(0) @binding(20) var<storage, read> cell_forces: array<vec4<f32>>;

struct Place {
    // Cell without ghosts; x is out of range on a ghost.
    cell: vec3<u32>,
    element: u32,
    // Neither a ghost nor left out, nor in the part of another dispatch.
    inside: bool,
}

fn place(group: vec3<u32>, local: u32) -> Place {
    let in_plane = step.first_element + group.x * COLLIDE_WORKGROUP + local;
    let row = in_plane / STRIDE_Y;
    let column = in_plane - row * STRIDE_Y;
    let plane = step.first_plane + group.y;
    var p: Place;
    // Ghosts wrap to huge numbers.
    p.cell = vec3<u32>(column - 1u, row - 1u, plane);
    p.element = in_plane + (plane + 1u) * STRIDE_Z;
    p.inside = p.cell.x < CELLS_X && p.cell.y < CELLS_Y && !is_idle(p.cell) && is_of_part(p.cell);
    return p;
}

fn is_in_box(cell: vec3<u32>) -> bool {
    // Cells before the box wrap to huge numbers.
    return all(cell - step.box_first.xyz < step.box_size.xyz);
}

fn is_of_part(cell: vec3<u32>) -> bool {
    return step.part == ALL_CELLS || is_in_box(cell) == (step.part == IN_BOX);
}

fn is_idle(cell: vec3<u32>) -> bool {
    if IDLE_END_X == 0u {
        return false;
    }
    let first = vec3<u32>(IDLE_FIRST_X, IDLE_FIRST_Y, IDLE_FIRST_Z);
    let end = vec3<u32>(IDLE_END_X, IDLE_END_Y, IDLE_END_Z);
    return all(cell >= first) && all(cell < end);
}

fn relaxation_time_at(x: u32) -> f32 {
    if SPONGE_LENGTH == 0.0 {
        return RELAXATION_TIME;
    }
    let from_outlet = f32(CELLS_X) - (f32(x) + 0.5);
    let depth = clamp(1.0 - from_outlet / SPONGE_LENGTH, 0.0, 1.0);
    return RELAXATION_TIME + max(SPONGE_RELAXATION_TIME - RELAXATION_TIME, 0.0) * depth * depth;
}

fn advance(p: Place, force: vec3<f32>, forced: bool) {
    let tau = with_eddy_viscosity(relaxation_time_at(p.cell.x), p.cell);
    let out = collide(gather(p.element), tau, force, forced);
    scatter(p.element, out);
    if INLET_OUTLET {
        send_ghosts(p, out);
    }
}

// The last cell of a row lends the outlet's ghost its state, delayed like sound that leaves; the ghost is at equilibrium and streams like any
// cell (src/cpu/fluid/boundaries.rs). Its population at rest is the memory of the last cell's density excess.
fn send_ghosts(p: Place, out: Populations) {
    let n = p.element;
    if p.cell.x == CELLS_X - 1u {
        let state = bare_state(out);
        let ghost = n + 1u;
        let late = -(OUTLET_DELAY * (state.w - unpacked(rest[ghost])));
        rest[ghost] = packed(state.w);
        let excess = (1.0 - OUTLET_RELAXATION / f32(CELLS_X)) * (state.w + late);
        let u = vec3<f32>(state.x + OUTLET_COSINE * SOUND_SPEED * late, state.yz);
        near_x[ghost] = packed(shifted_equilibrium(AXIS, vec3<f32>(-1.0, 0.0, 0.0), excess, u));
        near_xy[ghost] = packed(shifted_equilibrium(DIAGONAL, vec3<f32>(-1.0, -1.0, 0.0), excess, u));
        near_xz[ghost] = packed(shifted_equilibrium(DIAGONAL, vec3<f32>(-1.0, 0.0, -1.0), excess, u));
        near_x_y[ghost] = packed(shifted_equilibrium(DIAGONAL, vec3<f32>(-1.0, 1.0, 0.0), excess, u));
        near_x_z[ghost] = packed(shifted_equilibrium(DIAGONAL, vec3<f32>(-1.0, 0.0, 1.0), excess, u));
    }
}

@compute @workgroup_size(COLLIDE_WORKGROUP)
fn collide_stream(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let p = place(group, local);
    if p.inside {
        advance(p, vec3<f32>(), false);
    }
}

@compute @workgroup_size(COLLIDE_WORKGROUP)
fn collide_stream_accelerated(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let p = place(group, local);
    if p.inside {
        advance(p, air_acceleration(p.cell), true);
    }
}

@compute @workgroup_size(COLLIDE_WORKGROUP)
fn collide_stream_forced(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let p = place(group, local);
    if !p.inside {
        return;
    }
    var force = air_acceleration(p.cell);
    if is_in_box(p.cell) {
        let b = p.cell - step.box_first.xyz;
        force += cell_forces[b.x + step.box_size.x * (b.y + step.box_size.y * b.z)].xyz;
    }
    advance(p, force, true);
}
