// Stage initial_hessian: 3×3 diagonal blocks of a positive semidefinite Hessian, inverted per node (src/cpu/cloth/
// initial_hessian.rs). A symmetric block is kept as (xx, yy, zz, xy, xz, yz).

@group(0) @binding(19) var<storage, read_write> inverse_blocks: array<f32>;

fn contribute_block(slot: u32, block: Block) {
    let k = slot * 6u;
    contributions[k] = block.diagonal.x;
    contributions[k + 1u] = block.diagonal.y;
    contributions[k + 2u] = block.diagonal.z;
    contributions[k + 3u] = block.off.x;
    contributions[k + 4u] = block.off.y;
    contributions[k + 5u] = block.off.z;
}

// k (a bᵀ + b aᵀ).
fn cross_square(a: vec3<f32>, b: vec3<f32>, k: f32) -> Block {
    return Block(
        2.0 * k * a * b,
        k * vec3<f32>(a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y),
    );
}

// Block of the corner where `ends` ends and `starts` starts; k: the stiffness of the squared elongations.
fn corner_block(
    ends: vec3<f32>,
    starts: vec3<f32>,
    k_ends: f32,
    k_both: f32,
    k_starts: f32,
    geometric: f32,
) -> Block {
    return plus(
        plus(square(ends, 4.0 * k_ends), square(starts, 4.0 * k_starts)),
        plus(cross_square(ends, starts, -4.0 * k_both), isotropic(max(geometric, 0.0))),
    );
}

@compute @workgroup_size(64)
fn triangle_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= TRIANGLES {
        return;
    }
    let t = triangle_state(e);
    let response = respond(t.strain);
    let tangent = tangent_of(t.strain, response);
    let c0 = t.rest_area * apply_tangent(tangent, t.b0);
    let c1 = t.rest_area * apply_tangent(tangent, t.b1);
    let c2 = t.rest_area * apply_tangent(tangent, t.b2);
    let k00 = dot(t.b0, c0);
    let k11 = dot(t.b1, c1);
    let k22 = dot(t.b2, c2);
    let k01 = dot(t.b0, c1);
    let k02 = dot(t.b0, c2);
    let k12 = dot(t.b1, c2);
    let q0 = 2.0 * t.rest_area * dot(t.b0, response.tension);
    let q1 = 2.0 * t.rest_area * dot(t.b1, response.tension);
    let q2 = 2.0 * t.rest_area * dot(t.b2, response.tension);
    contribute_block(TRIANGLE_SLOTS + e, corner_block(t.edge1, t.edge2, k11, k12, k22, q1 + q2));
    contribute_block(TRIANGLE_SLOTS + TRIANGLES + e, corner_block(t.edge2, t.edge0, k22, k02, k00, q2 + q0));
    contribute_block(TRIANGLE_SLOTS + 2u * TRIANGLES + e, corner_block(t.edge0, t.edge1, k00, k01, k11, q0 + q1));
}

@compute @workgroup_size(64)
fn spring_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= SPRINGS {
        return;
    }
    let p = spring_piece(e);
    let block = spring_block(e, p);
    contribute_block(SPRING_SLOTS + e, block);
    contribute_block(SPRING_SLOTS + SPRINGS + e, block);
}

@compute @workgroup_size(64)
fn bending_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= BENDINGS {
        return;
    }
    let stiffness = bitcast<f32>(bendings[3u * BENDINGS + e]);
    contribute_block(BENDING_SLOTS + e, isotropic(stiffness));
    contribute_block(BENDING_SLOTS + BENDINGS + e, isotropic(4.0 * stiffness));
    contribute_block(BENDING_SLOTS + 2u * BENDINGS + e, isotropic(stiffness));
}

@compute @workgroup_size(64)
fn curvature_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= CURVATURES {
        return;
    }
    for (var k = 0u; k < 6u; k++) {
        let coefficient = curvature_word(6u + k, e);
        let stiffness = curvature_word(12u, e) * coefficient * coefficient;
        contribute_block(CURVATURE_SLOTS + k * CURVATURES + e, isotropic(stiffness));
    }
}

// Pressure has no part in the initial Hessian; its slots held forces.
@compute @workgroup_size(64)
fn face_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= FACES {
        return;
    }
    for (var corner = 0u; corner < 3u; corner++) {
        contribute_block(FACE_SLOTS + corner * FACES + e, isotropic(0.0));
    }
}

@compute @workgroup_size(64)
fn dashpot_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= DASHPOTS {
        return;
    }
    let block = square(dashpot_direction(e), dashpot_stiffness(e));
    contribute_block(DASHPOT_SLOTS + e, block);
    contribute_block(DASHPOT_SLOTS + DASHPOTS + e, block);
}

@compute @workgroup_size(64)
fn cable_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= CABLES {
        return;
    }
    let p = cable_piece(e);
    let block = cable_block(e, p);
    contribute_block(CABLE_SLOTS + e, block);
    contribute_block(CABLE_SLOTS + CABLES + e, block);
}

@compute @workgroup_size(64)
fn guide_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= GUIDES {
        return;
    }
    let stiffness = vec3<f32>(guide_word(7u, e), guide_word(8u, e), guide_word(9u, e));
    contribute_block(GUIDE_SLOTS + e, Block(stiffness, vec3<f32>(0.0)));
}

@compute @workgroup_size(64)
fn marker_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= MARKERS {
        return;
    }
    let stiffness = reactions[e].w * stage.rate;
    for (var corner = 0u; corner < 3u; corner++) {
        let weight = marker_weight(corner, e);
        contribute_block(MARKER_SLOTS + corner * MARKERS + e, isotropic(stiffness * weight * weight));
    }
}

@compute @workgroup_size(64)
fn permeable_marker_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= PERMEABLE_MARKERS {
        return;
    }
    let found = permeable_reaction(e);
    let stiffness = reactions[e].w * stage.rate;
    for (var corner = 0u; corner < 3u; corner++) {
        let weight = permeable_marker_weight(corner, e);
        let k = stiffness * weight * weight;
        contribute_block(
            PERMEABLE_MARKER_SLOTS + corner * PERMEABLE_MARKERS + e,
            plus(isotropic(k), square(found.normal, -k * found.slope)),
        );
    }
}

@compute @workgroup_size(64)
fn cut_triangle_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let e = thread_index(group, groups, local);
    if e >= CUT_TRIANGLES {
        return;
    }
    for (var corner = 0u; corner < 3u; corner++) {
        let block = Block(stage.rate * cut_words(6u * corner, e), stage.rate * cut_words(6u * corner + 3u, e));
        contribute_block(CUT_TRIANGLE_SLOTS + corner * CUT_TRIANGLES + e, block);
    }
}

// Sums the blocks of every node and inverts them; held nodes get zero.
@compute @workgroup_size(64)
fn gather_blocks(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    var block = isotropic(0.0);
    for (var k = node_first[node]; k < node_first[node + 1u]; k++) {
        let slot = node_slots[k] * 6u;
        block = plus(block, Block(
            vec3<f32>(contributions[slot], contributions[slot + 1u], contributions[slot + 2u]),
            vec3<f32>(contributions[slot + 3u], contributions[slot + 4u], contributions[slot + 5u]),
        ));
    }
    block = plus(block, isotropic(masses[node] * stage.inertia));
    let largest = max(max(block.diagonal.x, block.diagonal.y), max(block.diagonal.z, stage.stiffness_floor));
    // A millionth of the largest entry keeps the block regular where an element gives no transverse stiffness.
    var inverse = inverted(block, largest);
    if held[node] != 0u {
        inverse = isotropic(0.0);
    }
    let to = node * 6u;
    inverse_blocks[to] = inverse.diagonal.x;
    inverse_blocks[to + 1u] = inverse.diagonal.y;
    inverse_blocks[to + 2u] = inverse.diagonal.z;
    inverse_blocks[to + 3u] = inverse.off.x;
    inverse_blocks[to + 4u] = inverse.off.y;
    inverse_blocks[to + 5u] = inverse.off.z;
}
