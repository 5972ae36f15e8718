// What comes back along cut links of walls that move, where a device answers by itself (src/cut_links/mod.rs; src/gpu/fluid/moving_walls.rs). `read_links` has read what left; `bounce` writes
// what comes back. In between:
//   answer        what every side of every link gets back, and the force there
//   gather_rest   what populations at rest get
//   sum_forces    forces on fabric and bodies, and their moments

@group(0) @binding(47) var<storage, read> around: array<u32>;
// What left every side, and the further population.
@group(0) @binding(48) var<storage, read> link_numbers: array<f32>;
// Both sides of every link, then the populations at rest.
@group(0) @binding(49) var<storage, read_write> back_numbers: array<f32>;
@group(0) @binding(50) var<storage, read_write> back_places: array<vec2<u32>>;
// By side: what left less what comes back, with the velocity of the wall; what the air gets along the direction of leaving.
@group(0) @binding(51) var<storage, read_write> answered: array<vec2<f32>>;
// Nine times the place of cell A in the box, plus the pair, is the last of six words.
@group(0) @binding(52) var<storage, read> found_words: array<u32>;
// Of fabric, and of every body: the point that moments are about.
@group(0) @binding(53) var<storage, read> moment_points: array<WallNode>;
// By step, body and portion: force, and moment; behind those of a step, what trouble there was, and how many links.
@group(0) @binding(54) var<storage, read_write> force_sums: array<f32>;
@group(0) @binding(55) var<storage, read> trouble: array<u32>;

// Density excess that air shut in keeps, and the share of the rest that gets out (src/cut_links/pockets.rs).
override KEPT_EXCESS: f32 = 0.05;
override LET_OUT_SHARE: f32 = 0.5;
// Links of a portion that one thread sums.
override LINKS_OF_A_THREAD: u32 = 1u;

// Words of a found link, and which of them is its place.
const FOUND_WORDS: u32 = 6u;
const FOUND_PLACE: u32 = 5u;
// Cut links of a cell that is shut in, at least (src/cut_links/pockets.rs).
const SHUT_IN: u32 = 17u;

var<workgroup> shared_sums: array<vec4<f32>, WORKGROUP>;
var<workgroup> shared_turns: array<vec4<f32>, WORKGROUP>;

fn velocity_at(cut: CutSide) -> vec3<f32> {
    let shared_velocity = shared_velocities[cut.triangle];
    if shared_velocity.w > 0.0 {
        return shared_velocity.xyz;
    }
    let nodes = wall_triangles[cut.triangle].xyz;
    return cut.weights.x * wall_nodes[nodes.x].velocity
        + cut.weights.y * wall_nodes[nodes.y].velocity
        + cut.weights.z * wall_nodes[nodes.z].velocity;
}

fn pair_of(link: u32) -> u32 {
    return found_words[FOUND_WORDS * link + FOUND_PLACE] % PAIRS;
}

// A thread for every link.
@compute @workgroup_size(WORKGROUP)
fn answer(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let link = thread_index(group, groups, local);
    if link >= totals[LINKS] {
        return;
    }
    let pair = pair_of(link);
    let c = vec3<f32>(pair_direction(pair));
    let six_weights = 6.0 * pair_weight(pair);
    let along = vec2<f32>(dot(c, velocity_at(cut_sides[2u * link])), dot(c, velocity_at(cut_sides[2u * link + 1u])));
    // Both sides at one velocity: what one loses the other gains.
    let mean = 0.5 * (along.x + along.y);
    for (var side = 0u; side < 2u; side++) {
        let number = 2u * link + side;
        let cut = cut_sides[number];
        let sign = select(-1.0, 1.0, side == 0u);
        let out = link_numbers[2u * number];
        let back = cut.share * out + cut.further * link_numbers[2u * number + 1u]
            - six_weights * cut.strength * sign * along[side];
        back_numbers[number] = back;
        answered[number] = vec2<f32>(out - six_weights * sign * mean - back, out + back);
    }
}

// What a cell that is shut in lets out, over the sum of the weights of its cut links.
fn let_out(cell: vec3<i32>, place: u32) -> f32 {
    var more = 0.0;
    var weight = 0.0;
    let bits = around[place];
    for (var pair = 0u; pair < PAIRS; pair++) {
        for (var side = 0u; side < 2u; side++) {
            if ((bits >> (PAIRS * side + pair)) & 1u) == 0u {
                continue;
            }
            let link = link_of(cell, place, bits, pair, side);
            more += link_numbers[2u * (2u * link + side)] - link_numbers[2u * (2u * link + 1u - side)];
            weight += pair_weight(pair);
        }
    }
    let excess = more / weight;
    let beyond = max(abs(excess) - KEPT_EXCESS, 0.0);
    return LET_OUT_SHARE * select(beyond, -beyond, excess < 0.0) / weight;
}

// The cut link of a pair that begins (side 0) or ends (side 1) in a cell.
fn link_of(cell: vec3<i32>, place: u32, bits: u32, pair: u32, side: u32) -> u32 {
    if side == 0u {
        return link_number(place, bits, pair);
    }
    let other = box_place(cell - pair_direction(pair));
    return link_number(other, around[other], pair);
}

fn is_shut_in(bits: u32) -> bool {
    return countOneBits(bits) >= SHUT_IN;
}

// A thread for every cell of the box.
@compute @workgroup_size(WORKGROUP)
fn gather_rest(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let place = thread_index(group, groups, local);
    if place >= walls.box_count {
        return;
    }
    let bits = around[place];
    let number = before(place).y;
    if bits == 0u || number >= totals[CELLS] {
        return;
    }
    let cell = cell_at(place);
    var own_out = 0.0;
    if is_shut_in(bits) {
        own_out = let_out(cell, place);
    }
    var sum = 0.0;
    for (var pair = 0u; pair < PAIRS; pair++) {
        for (var side = 0u; side < 2u; side++) {
            if ((bits >> (PAIRS * side + pair)) & 1u) == 0u {
                continue;
            }
            let link = link_of(cell, place, bits, pair, side);
            if link >= totals[LINKS] {
                continue;
            }
            sum += answered[2u * link + side].x - pair_weight(pair) * own_out;
            let c = pair_direction(pair);
            let other = select(cell - c, cell + c, side == 0u);
            let other_place = box_place(other);
            if is_shut_in(around[other_place]) {
                sum += pair_weight(pair) * let_out(other, other_place);
            }
        }
    }
    let at = 2u * totals[LINKS] + number;
    back_places[at] = vec2<u32>(0u, element(cell));
    back_numbers[at] = sum;
}

// A workgroup for every portion, for fabric and then for every body; one more leaves trouble and the number of links.
@compute @workgroup_size(WORKGROUP)
fn sum_forces(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = group.y * groups.x + group.x;
    let body = number / walls.portions;
    let first = (number % walls.portions) * LINKS_OF_A_THREAD * WORKGROUP;
    var force = vec4<f32>();
    var moment = vec4<f32>();
    for (var k = 0u; k < LINKS_OF_A_THREAD; k++) {
        let link = first + k * WORKGROUP + local;
        if link >= totals[LINKS] || body >= arrayLength(&moment_points) {
            continue;
        }
        let pair = pair_of(link);
        for (var side = 0u; side < 2u; side++) {
            let cut = cut_sides[2u * link + side];
            let triangle = wall_triangles[cut.triangle];
            if triangle.w != body {
                continue;
            }
            let point = moment_points[body];
            var arm = vec3<f32>();
            for (var corner = 0u; corner < 3u; corner++) {
                let node = wall_nodes[triangle[corner]];
                arm += cut.weights[corner] * (vec3<f32>(node.cell - point.cell) + (node.offset - point.offset));
            }
            let pushed = answered[2u * link + side].y * select(-1.0, 1.0, side == 0u);
            let own = pushed * vec3<f32>(pair_direction(pair));
            force += vec4<f32>(own, 0.0);
            moment += vec4<f32>(cross(arm, own), 0.0);
        }
    }
    shared_sums[local] = force;
    shared_turns[local] = moment;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            shared_sums[local] += shared_sums[local + half];
            shared_turns[local] += shared_turns[local + half];
        }
        workgroupBarrier();
    }
    if local != 0u {
        return;
    }
    let at = walls.sums_from + 6u * number;
    if body < arrayLength(&moment_points) {
        for (var axis = 0u; axis < 3u; axis++) {
            force_sums[at + axis] = shared_sums[0][axis];
            force_sums[at + 3u + axis] = shared_turns[0][axis];
        }
    } else if number == arrayLength(&moment_points) * walls.portions {
        force_sums[at] = f32(trouble[0]);
        force_sums[at + 1u] = f32(totals[LINKS]);
    }
}
