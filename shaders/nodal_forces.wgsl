// Stage nodal_forces: energy Π(x) and its gradient (src/cpu/cloth/objective.rs), elements first, then nodes.

@group(0) @binding(13) var<storage, read_write> energies: array<vec2<f32>>;

override NODE_ENERGIES: u32 = 0u;

var<workgroup> partial_energies: array<vec2<f32>, 64>;

// Sums the energies of a workgroup, and their magnitudes, into one entry per workgroup.
fn gather_energy(first: u32, count: u32, group: u32, local: u32, energy: vec2<f32>) {
    partial_energies[local] = energy;
    for (var width = 32u; width > 0u; width >>= 1u) {
        workgroupBarrier();
        if local < width {
            partial_energies[local] += partial_energies[local + width];
        }
    }
    if local == 0u && group * WORKGROUP < count {
        energies[first + group] = partial_energies[0];
    }
}

@compute @workgroup_size(64)
fn triangle_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < TRIANGLES {
        energy = triangle_force(e);
    }
    gather_energy(TRIANGLE_ENERGIES, TRIANGLES, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn spring_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < SPRINGS {
        energy = spring_force(e);
    }
    gather_energy(SPRING_ENERGIES, SPRINGS, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn bending_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < BENDINGS {
        energy = bending_force(e);
    }
    gather_energy(BENDING_ENERGIES, BENDINGS, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn curvature_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < CURVATURES {
        energy = curvature_force(e);
    }
    gather_energy(CURVATURE_ENERGIES, CURVATURES, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn dashpot_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < DASHPOTS {
        energy = dashpot_force(e);
    }
    gather_energy(DASHPOT_ENERGIES, DASHPOTS, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn cable_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < CABLES {
        energy = cable_force(e);
    }
    gather_energy(CABLE_ENERGIES, CABLES, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn guide_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < GUIDES {
        energy = guide_force(e);
    }
    gather_energy(GUIDE_ENERGIES, GUIDES, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn face_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < FACES {
        energy = face_force(e);
    }
    gather_energy(FACE_ENERGIES, FACES, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn marker_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < MARKERS {
        energy = marker_force(e);
    }
    gather_energy(MARKER_ENERGIES, MARKERS, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn permeable_marker_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < PERMEABLE_MARKERS {
        energy = permeable_marker_force(e);
    }
    gather_energy(PERMEABLE_MARKER_ENERGIES, PERMEABLE_MARKERS, group.y * groups.x + group.x, local, energy);
}

@compute @workgroup_size(64)
fn cut_triangle_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if e < CUT_TRIANGLES {
        energy = cut_triangle_force(e);
    }
    gather_energy(CUT_TRIANGLE_ENERGIES, CUT_TRIANGLES, group.y * groups.x + group.x, local, energy);
}

// Gradient of every node, and H₀ times it, H₀ being block-Jacobi.
@compute @workgroup_size(64)
fn gather_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if node < NODES {
        let found = at_node(node);
        let gradient = found.gradient;
        energy = found.energy;
        set_vector(stage.preconditioned, node, preconditioned(node, gradient));
    }
    gather_energy(NODE_ENERGIES, NODES, group.y * groups.x + group.x, local, energy);
}

// Gradient of every node alone.
@compute @workgroup_size(64)
fn gather_gradient(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = thread_index(group, groups, local);
    var energy = vec2<f32>(0.0);
    if node < NODES {
        energy = at_node(node).energy;
    }
    gather_energy(NODE_ENERGIES, NODES, group.y * groups.x + group.x, local, energy);
}
