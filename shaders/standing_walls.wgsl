// What comes back along cut links of walls that stand still (src/cut_links/standing_walls.rs), step after step without the host. `read_links` has read what left; `bounce` writes what
// comes back. In between, in this order: where the air slides, `reflect` and `share_losses`; `answer`; where it slides, `lose` and `share_losses`; `relieve` where walls shut cells in; `gather_rest`.
//
// Sides of links are numbered by their links: twice the link's number, plus the side's.

struct StandingParameters {
    // Where the sums of the forces of this step go.
    sums_from: u32,
    // Portions of the sides whose forces are summed; blocks, spaces, pockets, and cells beside links.
    portions: u32,
    blocks: u32,
    spaces: u32,
    pockets: u32,
    cells: u32,
    sides: u32,
    padding: u32,
}

// Where the air sticks, shares of what left and of the further population; where it slides, numbers of image and block.
struct StandingSide {
    share: f32,
    further: f32,
    image: u32,
    block: u32,
}

struct StandingImage {
    cells: vec3<u32>,
    own: u32,
    shares: vec3<f32>,
    direction: u32,
    // Unit normal away from the air.
    away: vec3<f32>,
    turned_round: f32,
    // Direction in which air leaves.
    leaving: vec3<f32>,
    side: u32,
}

// Its images.
struct StandingBlock {
    first: u32,
    end: u32,
    weight: f32,
    padding: u32,
}

// Its blocks in `blocks_of_spaces`.
struct StandingSpace {
    first: u32,
    end: u32,
    weight: f32,
    padding: u32,
}

// A side of a body: what a force along its direction does to the body, and how it turns it.
struct StandingPush {
    leaving: vec3<f32>,
    side: u32,
    turning: vec3<f32>,
    padding: u32,
}

// Its sides in `pocket_sides`.
struct StandingPocket {
    first: u32,
    end: u32,
    weight: f32,
    padding: u32,
}

// What a cell's population at rest gets: of a side, or of a pocket.
struct RestPart {
    number: u32,
    factor: f32,
}

@group(0) @binding(0) var<uniform> standing: StandingParameters;
// What left every side, and the further population.
@group(0) @binding(1) var<storage, read> link_numbers: array<f32>;
// What left the cells of the images.
@group(0) @binding(2) var<storage, read> cell_numbers: array<f32>;
@group(0) @binding(3) var<storage, read> sides: array<StandingSide>;
@group(0) @binding(4) var<storage, read> images: array<StandingImage>;
@group(0) @binding(5) var<storage, read> blocks: array<StandingBlock>;
@group(0) @binding(6) var<storage, read> spaces: array<StandingSpace>;
@group(0) @binding(7) var<storage, read> blocks_of_spaces: array<u32>;
@group(0) @binding(8) var<storage, read> pushes: array<StandingPush>;
@group(0) @binding(9) var<storage, read> pockets: array<StandingPocket>;
@group(0) @binding(10) var<storage, read> pocket_sides: array<u32>;
// Where the parts of every cell begin; one more at the end.
@group(0) @binding(11) var<storage, read> rest_starts: array<u32>;
@group(0) @binding(12) var<storage, read> rest_parts: array<RestPart>;
// By image: what left, what comes back, velocity of the air at the wall along the direction of leaving.
@group(0) @binding(13) var<storage, read_write> reflected: array<vec3<f32>>;
// By block: mass lost along a plane, and beyond that.
@group(0) @binding(14) var<storage, read_write> losses: array<vec2<f32>>;
// By block: what its sides get by their weight.
@group(0) @binding(15) var<storage, read_write> given: array<f32>;
// By side: what left less what comes back.
@group(0) @binding(16) var<storage, read_write> left: array<f32>;
// By pocket: what it lets out.
@group(0) @binding(17) var<storage, read_write> let_out: array<f32>;
// Both sides of every link, then the populations at rest.
@group(0) @binding(18) var<storage, read_write> back_numbers: array<f32>;
// By step and portion: force on the body, and its moment.
@group(0) @binding(19) var<storage, read_write> force_sums: array<f32>;

// Largest share of what slides that comes back (src/cut_links/energy.rs).
override LARGEST_SHARE: f32 = 1.0;
// Density excess that air shut in keeps, and the share of the rest that gets out (src/cut_links/pockets.rs).
override KEPT_EXCESS: f32 = 0.05;
override LET_OUT_SHARE: f32 = 0.5;
// Sides of a portion that one thread sums.
override SIDES_OF_A_THREAD: u32 = 1u;

// Where the air sticks, and no side.
const NONE: u32 = 0xffffffffu;
// Marks the numbers of pockets among the parts of a cell.
const OF_A_POCKET: u32 = 0x80000000u;

var<workgroup> shared_sums: array<vec4<f32>, WORKGROUP>;
var<workgroup> shared_turns: array<vec4<f32>, WORKGROUP>;

fn weight_of(direction: u32) -> f32 {
    return select(1.0 / 36.0, 1.0 / 18.0, direction < 7u);
}

fn opposite(direction: u32) -> u32 {
    return ((direction - 1u) ^ 1u) + 1u;
}

// The sum over a workgroup, in all of its threads.
fn summed(local: u32, own: vec4<f32>) -> vec4<f32> {
    shared_sums[local] = own;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            shared_sums[local] += shared_sums[local + half];
        }
        workgroupBarrier();
    }
    return shared_sums[0];
}

// What comes back if all slides, with what left; the velocity of the air at the wall; mass lost along a plane.
struct Slid {
    out: f32,
    back: f32,
    velocity: f32,
    along: f32,
    // c − a and b of src/cut_links/energy.rs.
    free: f32,
    square: f32,
}

fn slid(image: StandingImage) -> Slid {
    var f: Populations;
    for (var direction = 0u; direction < 19u; direction += 1u) {
        f[direction] = image.shares.x * cell_numbers[19u * image.cells.x + direction]
            + image.shares.y * cell_numbers[19u * image.cells.y + direction]
            + image.shares.z * cell_numbers[19u * image.cells.z + direction];
    }
    let m = moments(f);
    let went = f[image.direction];
    let came = f[opposite(image.direction)];
    let six_weights = 6.0 * weight_of(image.direction);
    let n = image.away;
    let d = image.leaving;
    let across = dot(d, n);
    let tangent = d - n * across;
    let pressure = m.density_excess / 3.0;
    let s = m.shear_stress;
    let flux = (m.normal_stress - vec3<f32>(pressure)) * n
        + vec3<f32>(s.x * n.y + s.y * n.z, s.x * n.x + s.z * n.z, s.y * n.x + s.z * n.y);
    let along = dot(tangent, m.momentum);
    let shear = dot(tangent, flux);
    var result: Slid;
    result.out = cell_numbers[19u * image.own + image.direction];
    result.back = came + six_weights * (image.turned_round * across * dot(n, m.momentum) - 3.0 * across * shear);
    result.velocity = along / (1.0 + m.density_excess);
    result.along = six_weights * along;
    let more = result.back - result.out;
    result.free = ((came - went) * (came + went) - 2.0 * result.out * more) / six_weights;
    result.square = more * more / six_weights;
    return result;
}

// First image of a block, and the end of its images; none of a number beyond the blocks.
fn images_of(block: u32) -> vec2<u32> {
    if block < standing.blocks {
        return vec2<u32>(blocks[block].first, blocks[block].end);
    }
    return vec2<u32>();
}

// A workgroup for every block.
@compute @workgroup_size(WORKGROUP)
fn reflect(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = group.y * groups.x + group.x;
    let range = images_of(number);
    // Of energy free and square; mass lost along a plane, and all.
    var own = vec4<f32>();
    for (var i = range.x + local; i < range.y; i += WORKGROUP) {
        let found = slid(images[i]);
        own += vec4<f32>(found.free, found.square, found.along, found.out - found.back);
        reflected[i] = vec3<f32>(found.out, found.back, found.velocity);
    }
    let all = summed(local, own);
    var share = 1.0;
    if all.y > 0.0 {
        share = clamp(all.x / all.y, 0.0, LARGEST_SHARE);
    }
    for (var i = range.x + local; i < range.y; i += WORKGROUP) {
        let out = reflected[i].x;
        reflected[i].y = out + share * (reflected[i].y - out);
    }
    if local == 0u && number < standing.blocks {
        losses[number] = vec2<f32>(share * all.z, share * (all.w - all.z));
    }
}

// A workgroup for every space.
@compute @workgroup_size(WORKGROUP)
fn share_losses(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = group.y * groups.x + group.x;
    var first = 0u;
    var end = 0u;
    var weight = 1.0;
    if number < standing.spaces {
        first = spaces[number].first;
        end = spaces[number].end;
        weight = spaces[number].weight;
    }
    var own = vec4<f32>();
    for (var i = first + local; i < end; i += WORKGROUP) {
        own.x += losses[blocks_of_spaces[i]].x;
    }
    let along = summed(local, own).x / weight;
    for (var i = first + local; i < end; i += WORKGROUP) {
        let block = blocks_of_spaces[i];
        given[block] = along + losses[block].y / blocks[block].weight;
    }
}

// A workgroup for every portion.
@compute @workgroup_size(WORKGROUP)
fn answer(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let portion = group.y * groups.x + group.x;
    var force = vec4<f32>();
    var moment = vec4<f32>();
    if portion < standing.portions {
        for (var k = 0u; k < SIDES_OF_A_THREAD; k += 1u) {
            let push = pushes[(portion * SIDES_OF_A_THREAD + k) * WORKGROUP + local];
            if push.side == NONE {
                continue;
            }
            let side = sides[push.side];
            let out = link_numbers[2u * push.side];
            var back = side.share * out + side.further * link_numbers[2u * push.side + 1u];
            if side.image != NONE {
                let image = reflected[side.image];
                back = image.y - 3.0 * given[side.block] * weight_of(images[side.image].direction) * image.z;
            }
            back_numbers[push.side] = back;
            left[push.side] = out - back;
            let pushed = out + back;
            force += vec4<f32>(pushed * push.leaving, 0.0);
            moment += vec4<f32>(pushed * push.turning, 0.0);
        }
    }
    shared_turns[local] = moment;
    let all = summed(local, force);
    // `summed` has waited for all.
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            shared_turns[local] += shared_turns[local + half];
        }
        workgroupBarrier();
    }
    if local == 0u && portion < standing.portions {
        let at = standing.sums_from + 6u * portion;
        let turned = shared_turns[0];
        force_sums[at] = all.x;
        force_sums[at + 1u] = all.y;
        force_sums[at + 2u] = all.z;
        force_sums[at + 3u] = turned.x;
        force_sums[at + 4u] = turned.y;
        force_sums[at + 5u] = turned.z;
    }
}

// A workgroup for every block: what its links lose beyond what passes along a plane.
@compute @workgroup_size(WORKGROUP)
fn lose(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = group.y * groups.x + group.x;
    let range = images_of(number);
    var own = vec4<f32>();
    for (var i = range.x + local; i < range.y; i += WORKGROUP) {
        own.x += left[images[i].side];
    }
    let all = summed(local, own).x;
    if local == 0u && number < standing.blocks {
        losses[number].y = all - losses[number].x;
    }
}

// A thread for every pocket.
@compute @workgroup_size(WORKGROUP)
fn relieve(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = thread_index(group, groups, local);
    if number >= standing.pockets {
        return;
    }
    let pocket = pockets[number];
    var more = 0.0;
    for (var i = pocket.first; i < pocket.end; i += 1u) {
        let side = pocket_sides[i];
        more += link_numbers[2u * side] - link_numbers[2u * (side ^ 1u)];
    }
    let excess = more / pocket.weight;
    let beyond = max(abs(excess) - KEPT_EXCESS, 0.0);
    let_out[number] = LET_OUT_SHARE * select(beyond, -beyond, excess < 0.0);
}

// A thread for every cell beside a cut link.
@compute @workgroup_size(WORKGROUP)
fn gather_rest(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let cell = thread_index(group, groups, local);
    if cell >= standing.cells {
        return;
    }
    var sum = 0.0;
    for (var i = rest_starts[cell]; i < rest_starts[cell + 1u]; i += 1u) {
        let part = rest_parts[i];
        if (part.number & OF_A_POCKET) != 0u {
            sum += part.factor * let_out[part.number & ~OF_A_POCKET];
            continue;
        }
        let side = sides[part.number];
        if side.image == NONE {
            sum += left[part.number];
        } else {
            sum += given[side.block] * weight_of(images[side.image].direction);
        }
    }
    back_numbers[standing.sides + cell] = sum;
}
