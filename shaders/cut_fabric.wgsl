// Fabric that cuts links of the lattice, where a device has air and fabric and makes steps by itself (src/gpu/cloth/cut_fabric.rs). Before links are found (find_links.wgsl):
//   place_nodes   nodes as they stand, among the cells
// Before the solve:
//   sum_faces     what the links of every triangle see of its two faces
//   take_faces    density excess on both faces of every node (src/cut_links/faces.rs)
//   carry_faces   the same, carried on to where a face has no links
//   share_cuts    who shares what the air does to a triangle (src/cloth/patches.rs)
//   react_cuts    what the air does to every triangle, which the solve has inside (src/cpu/cloth/triangle_reaction.rs); of those who share, at its middle
//   share_reactions   the same of those who share
//   drive_cuts    the loads that set the scale of its tolerance
// After it, and before what comes back (moving_walls.wgsl):
//   move_nodes        the velocities that the step ends with
//   mean_velocities   the mean of those who share
// Populations are in lattice units, all else of the fabric in SI.

// Mirrors gpu::cloth::parameters::CellsInSpace.
struct CellsInSpace {
    // Centre of the lattice's first cell: whole numbers of 2⁻¹⁶ m, and remainders [m].
    origin_whole: vec4<i32>,
    origin_remainder: vec4<f32>,
    // Size of a cell alike, and cells in a metre.
    cell_whole: i32,
    cell_remainder: f32,
    cells_per_m: f32,
    padding: u32,
}

// Mirrors gpu::cloth::parameters::PatchMember.
struct PatchMember {
    triangle: u32,
    // As it was cut [cells²].
    area: f32,
    // Which of the members the way to it passes last.
    via: u32,
    // Where the other one stands among its own members.
    back: u32,
}

@group(0) @binding(3) var<storage, read> predicted_whole: array<i32>;
@group(0) @binding(4) var<storage, read> predicted_remainder: array<f32>;
@group(0) @binding(17) var<storage, read_write> vectors: array<f32>;
// Loads beside the pull of the air at the cuts [N].
@group(0) @binding(24) var<storage, read> still_drive: array<f32>;
// Words of every node: whole numbers and remainders of its position at the end of the solve, then what else it delivers.
@group(0) @binding(38) var<storage, read> delivered: array<u32>;
@group(0) @binding(60) var<uniform> space: CellsInSpace;
// Nodes as they stand, three numbers each.
@group(0) @binding(61) var<storage, read> nodes_whole: array<i32>;
@group(0) @binding(62) var<storage, read> nodes_remainder: array<f32>;
// Velocities of the prediction [m/s].
@group(0) @binding(63) var<storage, read> base_velocities: array<f32>;
// Where the triangles of every node begin, and which they are: 3 · triangle + corner.
@group(0) @binding(64) var<storage, read> triangle_first: array<u32>;
@group(0) @binding(65) var<storage, read> triangle_corners: array<u32>;
// As elements.wgsl has them.
@group(0) @binding(66) var<storage, read_write> cut_reactions: array<f32>;
// Pull of the air on every corner of a triangle at rest [N], word by word.
@group(0) @binding(67) var<storage, read_write> cut_pulls: array<f32>;
// By corner of a triangle and face: sum of what left, and of the weights.
@group(0) @binding(68) var<storage, read_write> face_sums: array<vec4<f32>>;
// By node: density excess on both faces, then whether links see them; taken, and carried on.
@group(0) @binding(69) var<storage, read_write> faces_taken: array<vec4<f32>>;
@group(0) @binding(70) var<storage, read_write> faces_carried: array<vec4<f32>>;
// Which of both is read, and which written, by a step of carrying on.
@group(0) @binding(71) var<storage, read> faces_from: array<vec4<f32>>;
@group(0) @binding(72) var<storage, read_write> faces_to: array<vec4<f32>>;
@group(0) @binding(73) var<storage, read> around: array<u32>;
// The second word is 1 where a link has two layers or more.
@group(0) @binding(79) var<storage, read> trouble: array<u32>;
// What left every side, and the further population.
@group(0) @binding(74) var<storage, read> link_numbers: array<f32>;

// Where those begin who share what the air does to a triangle, itself the first; one more at the end.
@group(0) @binding(75) var<storage, read> patch_starts: array<u32>;
@group(0) @binding(76) var<storage, read> patch_members: array<PatchMember>;
// What every member gets.
@group(0) @binding(77) var<storage, read_write> patch_shares: array<f32>;
// Of a triangle that shares: a ninth of the block (xx, yy, zz, xy, xz, yz) at its middle, a third of the pull.
@group(0) @binding(78) var<storage, read_write> middle_reactions: array<f32>;

// Triangles of the fabric.
override TRIANGLES: u32 = 1u;
// Slot of the loads that set the scale of the tolerance.
override DRIVE: u32 = 0u;
// A lattice unit of velocity [m/s], of stiffness [kg/s], and of force [N].
override SPEED: f32 = 1.0;
override STIFFNESS: f32 = 1.0;
override FORCE_N: f32 = 1.0;
// Share that a face takes of what its links see, and links that a node has a share in at least (src/cut_links/faces.rs).
override NEW_SHARE: f32 = 0.3;
override LEAST_WEIGHT: f32 = 0.0001;
// Cosine of the turn between two triangles from which they share nothing (src/cloth/patches.rs).
override LEAST_COSINE: f32 = 0.5;

const MIDDLE_WORDS: u32 = 9u;

fn node_place(node: u32) -> Place {
    let p = 3u * node;
    return Place(
        vec3<i32>(nodes_whole[p], nodes_whole[p + 1u], nodes_whole[p + 2u]),
        vec3<f32>(nodes_remainder[p], nodes_remainder[p + 1u], nodes_remainder[p + 2u]),
    );
}

// Distance from a cell's centre [cells].
fn from_cell(place: Place, cell: vec3<i32>) -> vec3<f32> {
    let whole = place.whole - cell * space.cell_whole;
    let rest = place.remainder - vec3<f32>(cell) * space.cell_remainder;
    return metres(Place(whole, rest)) * space.cells_per_m;
}

@compute @workgroup_size(WORKGROUP)
fn place_nodes(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    let origin = Place(space.origin_whole.xyz, space.origin_remainder.xyz);
    let place = between(origin, node_place(node));
    let cell = vec3<i32>(round(from_cell(place, vec3<i32>(0))));
    wall_nodes[node].cell = cell;
    wall_nodes[node].offset = from_cell(place, cell);
}

// Number of the link of a pair that a triangle cuts there; none where the box ends before it.
fn link_of(pair: u32, cut: LineCut) -> u32 {
    let place = box_place(cut.cell);
    if place == OUTSIDE {
        return OUTSIDE;
    }
    let bits = around[place];
    let link = link_number(place, bits, pair);
    return select(OUTSIDE, link, ((bits >> pair) & 1u) != 0u && link < totals[LINKS]);
}

fn normal_of(nodes: vec3<u32>) -> vec3<f32> {
    let a = wall_nodes[nodes.x];
    let b = wall_nodes[nodes.y];
    let c = wall_nodes[nodes.z];
    let first = vec3<f32>(b.cell - a.cell) + (b.offset - a.offset);
    let second = vec3<f32>(c.cell - a.cell) + (c.offset - a.offset);
    return cross(first, second);
}

// Face of a triangle with this normal that a side of a link looks at: 0 where the normal points, 1 behind.
fn face_of(normal: vec3<f32>, pair: u32, side: u32) -> u32 {
    let towards = dot(normal, vec3<f32>(pair_direction(pair))) > 0.0;
    return select(0u, 1u, towards == (side == 0u));
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn sum_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= TRIANGLES || trouble[1] == 0u {
        return;
    }
    let nodes = wall_triangles[triangle].xyz;
    let normal = normal_of(nodes);
    var sums: array<vec4<f32>, 3>;
    for (var pair = 0u; pair < PAIRS; pair++) {
        let seen = seen_along(pair, nodes);
        let weight = pair_weight(pair);
        for (var v = seen.low.y; v <= seen.high.y; v++) {
            for (var u = seen.low.x; u <= seen.high.x; u++) {
                let cut = cut_at(seen, nodes, vec2<i32>(u, v));
                if !cut.is_one {
                    continue;
                }
                let link = link_of(pair, cut);
                if link == OUTSIDE {
                    continue;
                }
                for (var side = 0u; side < 2u; side++) {
                    let number = 2u * link + side;
                    if cut_sides[number].triangle != triangle {
                        continue;
                    }
                    let seen_there = vec2<f32>(link_numbers[2u * number], weight);
                    let is_front = face_of(normal, pair, side) == 0u;
                    let of_faces = select(vec4<f32>(0.0, 0.0, seen_there), vec4<f32>(seen_there, 0.0, 0.0), is_front);
                    for (var corner = 0u; corner < 3u; corner++) {
                        sums[corner] += cut.weights[corner] * of_faces;
                    }
                }
            }
        }
    }
    for (var corner = 0u; corner < 3u; corner++) {
        face_sums[3u * triangle + corner] = sums[corner];
    }
}

// A thread for every node.
@compute @workgroup_size(WORKGROUP)
fn take_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    // Pressures are asked for between two layers alone.
    if trouble[1] == 0u {
        faces_taken[node] = vec4<f32>(faces_carried[node].xy, 1.0, 1.0);
        return;
    }
    var sum = vec4<f32>();
    for (var i = triangle_first[node]; i < triangle_first[node + 1u]; i++) {
        sum += face_sums[triangle_corners[i]];
    }
    var excess = faces_carried[node].xy;
    let known = sum.yw > vec2<f32>(LEAST_WEIGHT);
    let now = sum.xz / select(vec2<f32>(1.0), sum.yw, known);
    excess += select(vec2<f32>(0.0), NEW_SHARE * (now - excess), known);
    faces_taken[node] = vec4<f32>(excess, select(vec2<f32>(0.0), vec2<f32>(1.0), known));
}

// A thread for every node.
@compute @workgroup_size(WORKGROUP)
fn carry_faces(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    let own = faces_from[node];
    var sum = vec2<f32>();
    var count = 0.0;
    for (var i = triangle_first[node]; i < triangle_first[node + 1u]; i++) {
        let corner = triangle_corners[i];
        let nodes = wall_triangles[corner / 3u];
        for (var further = 1u; further < 3u; further++) {
            sum += faces_from[nodes[(corner + further) % 3u]].xy;
            count += 1.0;
        }
    }
    let mean = sum / max(count, 1.0);
    let kept = (own.zw > vec2<f32>(0.5)) | vec2<bool>(count == 0.0);
    faces_to[node] = vec4<f32>(select(mean, own.xy, kept), own.zw);
}

// Density excess between the two layers on a link: the mean of the faces that look at each other.
fn between_layers(link: u32, pair: u32) -> f32 {
    var sum = 0.0;
    for (var side = 0u; side < 2u; side++) {
        let cut = cut_sides[2u * link + side];
        let nodes = wall_triangles[cut.triangle].xyz;
        let face = 1u - face_of(normal_of(nodes), pair, side);
        for (var corner = 0u; corner < 3u; corner++) {
            sum += 0.5 * cut.weights[corner] * faces_carried[nodes[corner]][face];
        }
    }
    return sum;
}

fn shares(triangle: u32) -> bool {
    return patch_starts[triangle + 1u] - patch_starts[triangle] > 1u;
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn share_cuts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= TRIANGLES {
        return;
    }
    let first = patch_starts[triangle];
    let end = patch_starts[triangle + 1u];
    let normal = normal_of(wall_triangles[triangle].xyz);
    // First how much is shared along the way to each.
    for (var i = first; i < end; i++) {
        var alike = 1.0;
        if i > first {
            let other = normal_of(wall_triangles[patch_members[i].triangle].xyz);
            let lengths = max(length(normal) * length(other), 1e-30);
            let cosine = dot(normal, other) / lengths;
            alike = max((cosine - LEAST_COSINE) / (1.0 - LEAST_COSINE), 0.0);
            alike = min(alike, patch_shares[first + patch_members[i].via]);
        }
        patch_shares[i] = alike;
    }
    var sum = 0.0;
    for (var i = first; i < end; i++) {
        sum += patch_shares[i] * patch_members[i].area;
    }
    for (var i = first; i < end; i++) {
        patch_shares[i] *= patch_members[i].area / sum;
    }
}

fn base_velocity(node: u32) -> vec3<f32> {
    let p = 3u * node;
    return vec3<f32>(base_velocities[p], base_velocities[p + 1u], base_velocities[p + 2u]);
}

// A block (xx, yy, zz; xy, xz, yz) times a velocity.
fn resistance(diagonal: vec3<f32>, off: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        diagonal.x * v.x + off.x * v.y + off.y * v.z,
        off.x * v.x + diagonal.y * v.y + off.z * v.z,
        off.y * v.x + off.z * v.y + diagonal.z * v.z,
    );
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn react_cuts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= TRIANGLES {
        return;
    }
    let nodes = wall_triangles[triangle].xyz;
    let shares_it = shares(triangle);
    // Of the corners 00, 11, 22, 01, 12, 20.
    var diagonals: array<vec3<f32>, 6>;
    var offs: array<vec3<f32>, 6>;
    var pulls: array<vec3<f32>, 3>;
    for (var pair = 0u; pair < PAIRS; pair++) {
        let seen = seen_along(pair, nodes);
        let c = vec3<f32>(seen.c);
        let weight = pair_weight(pair);
        for (var v = seen.low.y; v <= seen.high.y; v++) {
            for (var u = seen.low.x; u <= seen.high.x; u++) {
                let found_cut = cut_at(seen, nodes, vec2<i32>(u, v));
                if !found_cut.is_one {
                    continue;
                }
                let link = link_of(pair, found_cut);
                if link == OUTSIDE {
                    continue;
                }
                var inside = 0.0;
                if cut_sides[2u * link].layers > 1u {
                    inside = between_layers(link, pair);
                }
                for (var side = 0u; side < 2u; side++) {
                    let number = 2u * link + side;
                    let cut = cut_sides[number];
                    if cut.triangle != triangle {
                        continue;
                    }
                    let w = select(cut.weights, vec3<f32>(1.0 / 3.0), shares_it);
                    let out = link_numbers[2u * number];
                    let push = (1.0 + cut.share) * out + cut.further * link_numbers[2u * number + 1u]
                        - 2.0 * weight * inside;
                    let k = 6.0 * weight * cut.strength * STIFFNESS;
                    var shares = array<f32, 6>(w.x * w.x, w.y * w.y, w.z * w.z, w.x * w.y, w.y * w.z, w.z * w.x);
                    let diagonal = k * c * c;
                    let off = k * vec3<f32>(c.x * c.y, c.x * c.z, c.y * c.z);
                    for (var block = 0u; block < 6u; block++) {
                        diagonals[block] += shares[block] * diagonal;
                        offs[block] += shares[block] * off;
                    }
                    let pull = select(-push, push, side == 0u) * FORCE_N * c;
                    for (var corner = 0u; corner < 3u; corner++) {
                        pulls[corner] += w[corner] * pull;
                    }
                }
            }
        }
    }
    if shares_it {
        for (var axis = 0u; axis < 3u; axis++) {
            middle_reactions[MIDDLE_WORDS * triangle + axis] = diagonals[0][axis];
            middle_reactions[MIDDLE_WORDS * triangle + 3u + axis] = offs[0][axis];
            middle_reactions[MIDDLE_WORDS * triangle + 6u + axis] = pulls[0][axis];
        }
        return;
    }
    lay_reaction(triangle, diagonals, offs, pulls);
}

// What the solve has inside: blocks of the corners 00, 11, 22, 01, 12, 20, and the force of the prediction.
fn lay_reaction(triangle: u32, blocks_diagonal: array<vec3<f32>, 6>, blocks_off: array<vec3<f32>, 6>,
    of_corners: array<vec3<f32>, 3>) {
    var diagonals = blocks_diagonal;
    var offs = blocks_off;
    var pulls = of_corners;
    let nodes = wall_triangles[triangle].xyz;
    for (var block = 0u; block < 6u; block++) {
        for (var axis = 0u; axis < 3u; axis++) {
            cut_reactions[(6u * block + axis) * TRIANGLES + triangle] = diagonals[block][axis];
            cut_reactions[(6u * block + 3u + axis) * TRIANGLES + triangle] = offs[block][axis];
        }
    }
    let v0 = base_velocity(nodes.x);
    let v1 = base_velocity(nodes.y);
    let v2 = base_velocity(nodes.z);
    let r0 = resistance(diagonals[0], offs[0], v0) + resistance(diagonals[3], offs[3], v1) + resistance(diagonals[5], offs[5], v2);
    let r1 = resistance(diagonals[3], offs[3], v0) + resistance(diagonals[1], offs[1], v1) + resistance(diagonals[4], offs[4], v2);
    let r2 = resistance(diagonals[5], offs[5], v0) + resistance(diagonals[4], offs[4], v1) + resistance(diagonals[2], offs[2], v2);
    var resists = array<vec3<f32>, 3>(r0, r1, r2);
    for (var corner = 0u; corner < 3u; corner++) {
        for (var axis = 0u; axis < 3u; axis++) {
            let word = 3u * corner + axis;
            cut_reactions[(36u + word) * TRIANGLES + triangle] = resists[corner][axis] - pulls[corner][axis];
            cut_pulls[word * TRIANGLES + triangle] = pulls[corner][axis];
        }
    }
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn share_reactions(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= TRIANGLES || !shares(triangle) {
        return;
    }
    var diagonal = vec3<f32>();
    var off = vec3<f32>();
    var pull = vec3<f32>();
    for (var i = patch_starts[triangle]; i < patch_starts[triangle + 1u]; i++) {
        let member = patch_members[i];
        let share = patch_shares[patch_starts[member.triangle] + member.back];
        let m = MIDDLE_WORDS * member.triangle;
        diagonal += share * vec3<f32>(middle_reactions[m], middle_reactions[m + 1u], middle_reactions[m + 2u]);
        off += share * vec3<f32>(middle_reactions[m + 3u], middle_reactions[m + 4u], middle_reactions[m + 5u]);
        pull += share * vec3<f32>(middle_reactions[m + 6u], middle_reactions[m + 7u], middle_reactions[m + 8u]);
    }
    lay_reaction(
        triangle,
        array<vec3<f32>, 6>(diagonal, diagonal, diagonal, diagonal, diagonal, diagonal),
        array<vec3<f32>, 6>(off, off, off, off, off, off),
        array<vec3<f32>, 3>(pull, pull, pull),
    );
}

// A thread for every node.
@compute @workgroup_size(WORKGROUP)
fn drive_cuts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    var load = vec3<f32>(still_drive[3u * node], still_drive[3u * node + 1u], still_drive[3u * node + 2u]);
    for (var i = triangle_first[node]; i < triangle_first[node + 1u]; i++) {
        let triangle = triangle_corners[i] / 3u;
        let corner = triangle_corners[i] % 3u;
        for (var axis = 0u; axis < 3u; axis++) {
            load[axis] += cut_pulls[(3u * corner + axis) * TRIANGLES + triangle];
        }
    }
    set_vector(DRIVE, node, load);
}

// A thread for every node.
@compute @workgroup_size(WORKGROUP)
fn move_nodes(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    let p = 3u * node;
    let d = 9u * node;
    let predicted = Place(
        vec3<i32>(predicted_whole[p], predicted_whole[p + 1u], predicted_whole[p + 2u]),
        vec3<f32>(predicted_remainder[p], predicted_remainder[p + 1u], predicted_remainder[p + 2u]),
    );
    let solved = Place(
        bitcast<vec3<i32>>(vec3<u32>(delivered[d], delivered[d + 1u], delivered[d + 2u])),
        bitcast<vec3<f32>>(vec3<u32>(delivered[d + 3u], delivered[d + 4u], delivered[d + 5u])),
    );
    let displacement = metres(between(predicted, solved));
    wall_nodes[node].velocity = (base_velocity(node) + displacement * stage.rate) / SPEED;
}

fn middle_velocity(triangle: u32) -> vec3<f32> {
    let nodes = wall_triangles[triangle].xyz;
    return (wall_nodes[nodes.x].velocity + wall_nodes[nodes.y].velocity + wall_nodes[nodes.z].velocity) / 3.0;
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn mean_velocities(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= TRIANGLES {
        return;
    }
    if !shares(triangle) {
        shared_velocities[triangle] = vec4<f32>();
        return;
    }
    var mean = vec3<f32>();
    for (var i = patch_starts[triangle]; i < patch_starts[triangle + 1u]; i++) {
        mean += patch_shares[i] * middle_velocity(patch_members[i].triangle);
    }
    shared_velocities[triangle] = vec4<f32>(mean, 1.0);
}
