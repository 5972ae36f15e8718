// Stage find_links where surfaces move and a device answers along their links by itself (src/cut_links/search.rs; src/gpu/fluid/moving_walls.rs). In this order:
//   look_along    which links are cut
//   scan_cells    where the links of every cell begin, counted within a block of cells
//   scan_blocks   where those of every block begin, and how many there are
//   look_along    the first and the last cut on every link
//   look_along    of which triangles these are
//   lay_links     what every side gets back, and where that lies in memory
// The three looks are one pipeline, so that they find the same to the last bit. Nothing depends on which thread comes first.

struct LookParameters {
    // Which look it is: 0, 1, 2.
    number: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// A link as the looks find it. All is zero before them; what is sought as the least is kept as its complement.
struct FoundLink {
    // Complement of the bits of the first cut's distance from A, and bits of the last one's.
    first_complement: atomic<u32>,
    last: atomic<u32>,
    // Their triangles.
    first_triangle_complement: atomic<u32>,
    last_triangle: atomic<u32>,
    // Cuts on it.
    layers: atomic<u32>,
    // Nine times the place of cell A in the box, plus the pair.
    place: atomic<u32>,
}

@group(0) @binding(47) var<uniform> look: LookParameters;
@group(0) @binding(48) var<storage, read_write> around: array<atomic<u32>>;
@group(0) @binding(49) var<storage, read_write> found: array<FoundLink>;
// First word: 1 where a link lies outside the box, 2 where there is no room for all. Second word: 1 where a link has two layers or more.
@group(0) @binding(50) var<storage, read_write> trouble: array<atomic<u32>>;
// Array and element of what is read for every side: what left, and the further population.
@group(0) @binding(51) var<storage, read_write> read_places: array<vec2<u32>>;
// The same of what comes back.
@group(0) @binding(52) var<storage, read_write> back_places: array<vec2<u32>>;

const LEFT_THE_BOX: u32 = 1u;
const TOO_MANY: u32 = 2u;

// Cells that a thread scans.
const RUN: u32 = 16u;
var<workgroup> sums: array<vec2<u32>, WORKGROUP>;

// A cut of a triangle on a link of a pair.
fn found_cut(triangle: u32, pair: u32, cut: LineCut) {
    let place = box_place(cut.cell);
    let other_place = box_place(cut.cell + pair_direction(pair));
    if place == OUTSIDE || other_place == OUTSIDE {
        atomicMax(&trouble[0], LEFT_THE_BOX);
        return;
    }
    if look.number == 0u {
        atomicOr(&around[place], 1u << pair);
        atomicOr(&around[other_place], 1u << (PAIRS + pair));
        return;
    }
    let link = link_number(place, atomicLoad(&around[place]), pair);
    if link >= walls.most_links {
        atomicMax(&trouble[0], TOO_MANY);
        return;
    }
    let bits = bitcast<u32>(cut.at);
    if look.number == 1u {
        atomicMax(&found[link].first_complement, ~bits);
        atomicMax(&found[link].last, bits);
        atomicAdd(&found[link].layers, 1u);
        atomicStore(&found[link].place, PAIRS * place + pair);
        return;
    }
    if atomicLoad(&found[link].first_complement) == ~bits {
        atomicMax(&found[link].first_triangle_complement, ~triangle);
    }
    if atomicLoad(&found[link].last) == bits {
        atomicMax(&found[link].last_triangle, triangle);
    }
}

// A thread for every triangle.
@compute @workgroup_size(WORKGROUP)
fn look_along(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let triangle = thread_index(group, groups, local);
    if triangle >= walls.triangles {
        return;
    }
    let nodes = wall_triangles[triangle].xyz;
    for (var pair = 0u; pair < PAIRS; pair++) {
        let seen = seen_along(pair, nodes);
        for (var v = seen.low.y; v <= seen.high.y; v++) {
            for (var u = seen.low.x; u <= seen.high.x; u++) {
                let cut = cut_at(seen, nodes, vec2<i32>(u, v));
                if cut.is_one {
                    found_cut(triangle, pair, cut);
                }
            }
        }
    }
}

// Sum over all threads of lower number.
fn sum_below(local: u32, own: vec2<u32>) -> vec2<u32> {
    sums[local] = own;
    for (var width = 1u; width < WORKGROUP; width <<= 1u) {
        workgroupBarrier();
        var below = vec2<u32>();
        if local >= width {
            below = sums[local - width];
        }
        workgroupBarrier();
        sums[local] += below;
    }
    workgroupBarrier();
    return sums[local] - own;
}

// Links that begin in a cell, and whether it lies beside one.
fn counted(place: u32) -> vec2<u32> {
    let bits = atomicLoad(&around[place]);
    return vec2<u32>(countOneBits(bits & ALL_PAIRS), u32(bits != 0u));
}

// A workgroup for every block.
@compute @workgroup_size(WORKGROUP)
fn scan_cells(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let block = group.y * groups.x + group.x;
    let first = block * BLOCK + local * RUN;
    let end = min(first + RUN, walls.box_count);
    var own = vec2<u32>();
    for (var place = first; place < end; place++) {
        own += counted(place);
    }
    var start = sum_below(local, own);
    for (var place = first; place < end; place++) {
        starts[place] = start;
        start += counted(place);
    }
    if local == WORKGROUP - 1u && block < walls.block_count {
        blocks[block] = start;
    }
}

@compute @workgroup_size(WORKGROUP)
fn scan_blocks(@builtin(local_invocation_index) local: u32) {
    let run = (walls.block_count + WORKGROUP - 1u) / WORKGROUP;
    let first = local * run;
    let end = min(first + run, walls.block_count);
    var own = vec2<u32>();
    for (var block = first; block < end; block++) {
        own += blocks[block];
    }
    var start = sum_below(local, own);
    for (var block = first; block < end; block++) {
        let count = blocks[block];
        blocks[block] = start;
        start += count;
    }
    if local == WORKGROUP - 1u {
        if start.x > walls.most_links || start.y > walls.most_cells {
            atomicMax(&trouble[0], TOO_MANY);
        }
        let links = min(start.x, walls.most_links);
        let cells = min(start.y, walls.most_cells);
        totals[READ] = 4u * links;
        totals[WRITTEN] = 2u * links + cells;
        totals[LINKS] = links;
        totals[CELLS] = cells;
    }
}

// Array and element of the population of a direction that a cell reads in the step to come (src/lattice/grid.rs).
fn place_of(cell: vec3<i32>, pair: u32, backwards: u32) -> vec2<u32> {
    let first = 2u * pair + 1u;
    if backwards == 0u {
        return vec2<u32>(first + 1u - walls.odd, element(cell));
    }
    return vec2<u32>(first + walls.odd, element(cell + pair_direction(pair)));
}

// True where the link of a pair that begins in a cell is cut.
fn begins_cut(cell: vec3<i32>, pair: u32) -> bool {
    let place = box_place(cell);
    if place == OUTSIDE {
        return false;
    }
    return ((atomicLoad(&around[place]) >> pair) & 1u) != 0u;
}

fn lay_side(link: u32, side: u32, pair: u32, cell: vec3<i32>, blocked: bool) {
    let c = pair_direction(pair);
    let own = select(cell + c, cell, side == 0u);
    let other = select(cell, cell + c, side == 0u);
    let first = bitcast<f32>(~atomicLoad(&found[link].first_complement));
    let last = bitcast<f32>(atomicLoad(&found[link].last));
    let triangle = select(
        atomicLoad(&found[link].last_triangle),
        ~atomicLoad(&found[link].first_triangle_complement),
        side == 0u,
    );
    let nodes = wall_triangles[triangle].xyz;
    let seen = seen_along(pair, nodes);
    let weights = weights_in(nodes, seen, line_through(seen, cell));
    let distance = select(1.0 - last, first, side == 0u);
    // Half-way bounce-back where the link behind is cut, or leads out of the air.
    var cut = CutSide(weights.xyz, triangle, 1.0, 0.0, 1.0, atomicLoad(&found[link].layers));
    let out = place_of(other, pair, side);
    var further = out;
    if !blocked {
        if distance < 0.5 {
            cut.share = 2.0 * distance;
            cut.further = 1.0 - cut.share;
            further = place_of(own, pair, side);
        } else {
            cut.share = 0.5 / distance;
            cut.further = 1.0 - cut.share;
            cut.strength = cut.share;
            further = place_of(select(own + c, own - c, side == 0u), pair, 1u - side);
        }
    }
    let number = 2u * link + side;
    cut_sides[number] = cut;
    read_places[2u * number] = out;
    read_places[2u * number + 1u] = further;
    back_places[number] = place_of(own, pair, 1u - side);
}

// A thread for every link.
@compute @workgroup_size(WORKGROUP)
fn lay_links(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let link = thread_index(group, groups, local);
    if link >= totals[LINKS] {
        return;
    }
    let where_cut = atomicLoad(&found[link].place);
    let pair = where_cut % PAIRS;
    let cell = cell_at(where_cut / PAIRS);
    let c = pair_direction(pair);
    if atomicLoad(&found[link].layers) > 1u {
        atomicMax(&trouble[1], 1u);
    }
    // The link behind A begins one cell before it, the one behind B in B itself.
    lay_side(link, 0u, pair, cell, !in_lattice(cell - c) || begins_cut(cell - c, pair));
    lay_side(link, 1u, pair, cell, !in_lattice(cell + 2 * c) || begins_cut(cell + c, pair));
}
