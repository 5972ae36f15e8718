// Stage stiffness: the whole positive semidefinite Hessian, block by block, for multigrid (src/cpu/cloth/stiffness.rs). The matrix is
// laid out as block_rows.wgsl says. For every kind of element one dispatch runs over the blocks that its elements touch; each
// thread adds its elements' shares in a fixed order. What triangles give is prepared once per triangle before.

@group(0) @binding(20) var<storage, read_write> matrix: array<f32>;
// Places of the blocks that a kind of element touches, first terms, and terms: element · 64 + corner of the row · 8 + corner of the
// column.
@group(0) @binding(21) var<storage, read> block_places: array<u32>;
@group(0) @binding(22) var<storage, read> block_first: array<u32>;
@group(0) @binding(23) var<storage, read> block_terms: array<u32>;

// Blocks that the kind touches.
override TOUCHED: u32 = 0u;

struct Term {
    element: u32,
    row: u32,
    column: u32,
}

fn term(k: u32) -> Term {
    let word = block_terms[k];
    return Term(word >> 6u, (word >> 3u) & 7u, word & 7u);
}

fn place_of(thread: u32) -> u32 {
    let place = block_places[thread];
    return place / WORKGROUP * 576u + place % WORKGROUP;
}

fn add_to_matrix(at: u32, row0: vec3<f32>, row1: vec3<f32>, row2: vec3<f32>) {
    matrix[at] += row0.x;
    matrix[at + 64u] += row0.y;
    matrix[at + 128u] += row0.z;
    matrix[at + 192u] += row1.x;
    matrix[at + 256u] += row1.y;
    matrix[at + 320u] += row1.z;
    matrix[at + 384u] += row2.x;
    matrix[at + 448u] += row2.y;
    matrix[at + 512u] += row2.z;
}

fn add_block(at: u32, block: Block) {
    add_to_matrix(
        at,
        vec3<f32>(block.diagonal.x, block.off.x, block.off.y),
        vec3<f32>(block.off.x, block.diagonal.y, block.off.z),
        vec3<f32>(block.off.y, block.off.z, block.diagonal.z),
    );
}

fn scaled(block: Block, factor: f32) -> Block {
    return Block(factor * block.diagonal, factor * block.off);
}

// +1 on the diagonal, −1 between the two ends of a piece.
fn end_sign(t: Term) -> f32 {
    return select(-1.0, 1.0, t.row == t.column);
}

// Tensile part of a tension (xx, yy, xy).
fn tensile(tension: vec3<f32>) -> vec3<f32> {
    let stress = circle(tension.x, tension.y, tension.z);
    let smaller = stress.x - stress.y;
    let larger = stress.x + stress.y;
    if smaller >= 0.0 {
        return tension;
    }
    if larger <= 0.0 {
        return vec3<f32>(0.0);
    }
    // T = larger m⊗m + smaller n⊗n, and m⊗m + n⊗n = I.
    let share = larger / (larger - smaller);
    return share * vec3<f32>(tension.x - smaller, tension.y - smaller, tension.z);
}

fn keep_triangle(slot: u32, edge: vec3<f32>, geometric: f32, material: vec2<f32>) {
    let k = slot * 6u;
    contributions[k] = edge.x;
    contributions[k + 1u] = edge.y;
    contributions[k + 2u] = edge.z;
    contributions[k + 3u] = geometric;
    contributions[k + 4u] = material.x;
    contributions[k + 5u] = material.y;
}

// Per triangle: edges, 4 A Bᵀ C B and 2 A Bᵀ T⁺, in the slots of its corners.
@compute @workgroup_size(64)
fn triangle_stiffness(
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
    let c0 = 4.0 * t.rest_area * apply_tangent(tangent, t.b0);
    let c1 = 4.0 * t.rest_area * apply_tangent(tangent, t.b1);
    let c2 = 4.0 * t.rest_area * apply_tangent(tangent, t.b2);
    let tension = 2.0 * t.rest_area * tensile(response.tension);
    keep_triangle(TRIANGLE_SLOTS + e, t.edge0, dot(t.b0, tension), vec2<f32>(dot(t.b0, c0), dot(t.b1, c2)));
    keep_triangle(TRIANGLE_SLOTS + TRIANGLES + e, t.edge1, dot(t.b1, tension), vec2<f32>(dot(t.b1, c1), dot(t.b2, c0)));
    keep_triangle(TRIANGLE_SLOTS + 2u * TRIANGLES + e, t.edge2, dot(t.b2, tension), vec2<f32>(dot(t.b2, c2), dot(t.b0, c1)));
}

// Signs of a corner in the three edges: it ends the edge after it and starts the one after that.
fn signs(corner: u32) -> vec3<f32> {
    if corner == 0u {
        return vec3<f32>(0.0, 1.0, -1.0);
    }
    if corner == 1u {
        return vec3<f32>(-1.0, 0.0, 1.0);
    }
    return vec3<f32>(1.0, -1.0, 0.0);
}

fn kept(slot: u32, k: u32) -> f32 {
    return contributions[slot * 6u + k];
}

fn kept_edge(slot: u32) -> vec3<f32> {
    return vec3<f32>(kept(slot, 0u), kept(slot, 1u), kept(slot, 2u));
}

@compute @workgroup_size(64)
fn triangle_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var row0 = vec3<f32>(0.0);
    var row1 = vec3<f32>(0.0);
    var row2 = vec3<f32>(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let slot0 = TRIANGLE_SLOTS + t.element;
        let slot1 = slot0 + TRIANGLES;
        let slot2 = slot1 + TRIANGLES;
        let edge0 = kept_edge(slot0);
        let edge1 = kept_edge(slot1);
        let edge2 = kept_edge(slot2);
        let geometric = vec3<f32>(kept(slot0, 3u), kept(slot1, 3u), kept(slot2, 3u));
        // xx, yy, zz and yz, zx, xy of the edges' stiffness.
        let own = vec3<f32>(kept(slot0, 4u), kept(slot1, 4u), kept(slot2, 4u));
        let mixed = vec3<f32>(kept(slot0, 5u), kept(slot1, 5u), kept(slot2, 5u));
        let a = signs(t.row);
        let b = signs(t.column);
        let w0 = edge0 * (own.x * b.x) + edge1 * (mixed.z * b.y) + edge2 * (mixed.y * b.z);
        let w1 = edge0 * (mixed.z * b.x) + edge1 * (own.y * b.y) + edge2 * (mixed.x * b.z);
        let w2 = edge0 * (mixed.y * b.x) + edge1 * (mixed.x * b.y) + edge2 * (own.z * b.z);
        let left0 = a.x * edge0;
        let left1 = a.y * edge1;
        let left2 = a.z * edge2;
        let stress = dot(geometric, a * b);
        row0 += left0.x * w0 + left1.x * w1 + left2.x * w2 + vec3<f32>(stress, 0.0, 0.0);
        row1 += left0.y * w0 + left1.y * w1 + left2.y * w2 + vec3<f32>(0.0, stress, 0.0);
        row2 += left0.z * w0 + left1.z * w1 + left2.z * w2 + vec3<f32>(0.0, 0.0, stress);
    }
    add_to_matrix(place_of(thread), row0, row1, row2);
}

@compute @workgroup_size(64)
fn spring_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = isotropic(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let e = t.element;
        let p = spring_piece(e);
        let block = spring_block(e, p);
        sum = plus(sum, scaled(block, end_sign(t)));
    }
    add_block(place_of(thread), sum);
}

@compute @workgroup_size(64)
fn bending_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = 0.0;
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let factor = select(1.0, -2.0, t.row == 1u) * select(1.0, -2.0, t.column == 1u);
        sum += factor * bitcast<f32>(bendings[3u * BENDINGS + t.element]);
    }
    add_block(place_of(thread), isotropic(sum));
}

@compute @workgroup_size(64)
fn curvature_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = 0.0;
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let e = t.element;
        sum += curvature_word(12u, e) * curvature_word(6u + t.row, e) * curvature_word(6u + t.column, e);
    }
    add_block(place_of(thread), isotropic(sum));
}

@compute @workgroup_size(64)
fn dashpot_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = isotropic(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let block = square(dashpot_direction(t.element), dashpot_stiffness(t.element));
        sum = plus(sum, scaled(block, end_sign(t)));
    }
    add_block(place_of(thread), sum);
}

@compute @workgroup_size(64)
fn cable_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = isotropic(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let e = t.element;
        let p = cable_piece(e);
        let block = cable_block(e, p);
        sum = plus(sum, scaled(block, end_sign(t)));
    }
    add_block(place_of(thread), sum);
}

@compute @workgroup_size(64)
fn guide_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let e = term(k).element;
        sum += vec3<f32>(guide_word(7u, e), guide_word(8u, e), guide_word(9u, e));
    }
    add_block(place_of(thread), Block(sum, vec3<f32>(0.0)));
}

@compute @workgroup_size(64)
fn marker_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = 0.0;
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let e = t.element;
        sum += reactions[e].w * stage.rate * marker_weight(t.row, e) * marker_weight(t.column, e);
    }
    add_block(place_of(thread), isotropic(sum));
}

@compute @workgroup_size(64)
fn permeable_marker_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = isotropic(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        let e = t.element;
        let found = permeable_reaction(e);
        let stiffness = reactions[e].w * stage.rate
            * permeable_marker_weight(t.row, e) * permeable_marker_weight(t.column, e);
        sum = plus(sum, plus(isotropic(stiffness), square(found.normal, -stiffness * found.slope)));
    }
    add_block(place_of(thread), sum);
}

@compute @workgroup_size(64)
fn cut_triangle_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = isotropic(0.0);
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        let t = term(k);
        // Of two corners the missing one is 2, 0, 1 in the order of the pairs behind those of a corner with itself.
        var pair = t.row;
        if t.row != t.column {
            pair = 3u + (3u - t.row - t.column + 1u) % 3u;
        }
        let e = t.element;
        sum = plus(sum, Block(stage.rate * cut_words(6u * pair, e), stage.rate * cut_words(6u * pair + 3u, e)));
    }
    add_block(place_of(thread), sum);
}

// Inertia; every term is a node.
@compute @workgroup_size(64)
fn node_matrix(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = thread_index(group, groups, local);
    if thread >= TOUCHED {
        return;
    }
    var sum = 0.0;
    for (var k = block_first[thread]; k < block_first[thread + 1u]; k++) {
        sum += masses[term(k).element] * stage.inertia;
    }
    add_block(place_of(thread), isotropic(sum));
}
