// Lines of the lattice along its links, and where a triangle cuts them (src/cut_links/search.rs).
//
// Links of one direction c lie on parallel lines through cell centres. Seen along them, the lines are the whole points of a plane, and a triangle is a triangle of that plane.

// By how much a triangle's range of lines is widened, beyond round-off [cells].
const WIDENED: f32 = 0.001;

// A triangle seen along the lines of a pair.
struct Seen {
    c: vec3<i32>,
    // The first axis that c has, and the two others.
    along: u32,
    across: vec2<u32>,
    // Its corners: whole numbers, and what is left.
    whole: array<vec2<i32>, 3>,
    rest: array<vec2<f32>, 3>,
    // Lines that may pass it.
    low: vec2<i32>,
    high: vec2<i32>,
    // Places of its corners along the first axis, from a cell there.
    base: i32,
    places: vec3<f32>,
}

// Where a triangle cuts a line.
struct LineCut {
    is_one: bool,
    // Cell A of the link, and the distance of the cut from it [links].
    cell: vec3<i32>,
    at: f32,
    weights: vec3<f32>,
}

fn seen_along(pair: u32, nodes: vec3<u32>) -> Seen {
    var seen: Seen;
    let c = pair_direction(pair);
    seen.c = c;
    seen.along = select(select(2u, 1u, c.y != 0), 0u, c.x != 0);
    seen.across = vec2<u32>(select(0u, 1u, seen.along == 0u), select(2u, 1u, seen.along == 2u));
    let slant = vec2<i32>(c[seen.across.x], c[seen.across.y]);
    seen.base = wall_nodes[nodes.x].cell[seen.along];
    for (var k = 0u; k < 3u; k++) {
        let node = wall_nodes[nodes[k]];
        seen.whole[k] = vec2<i32>(node.cell[seen.across.x], node.cell[seen.across.y]) - slant * node.cell[seen.along];
        seen.rest[k] = vec2<f32>(node.offset[seen.across.x], node.offset[seen.across.y])
            - vec2<f32>(slant) * node.offset[seen.along];
        seen.places[k] = f32(node.cell[seen.along] - seen.base) + node.offset[seen.along];
    }
    let p = seen.rest[0];
    let q = vec2<f32>(seen.whole[1] - seen.whole[0]) + seen.rest[1];
    let r = vec2<f32>(seen.whole[2] - seen.whole[0]) + seen.rest[2];
    seen.low = seen.whole[0] + vec2<i32>(ceil(min(min(p, q), r) - WIDENED));
    seen.high = seen.whole[0] + vec2<i32>(floor(max(max(p, q), r) + WIDENED));
    return seen;
}

// Twice the area from edge a–b to the origin, positive to its left. Written so that it has the same bits wherever it stands in the code, unless a driver takes fma apart
// in one place and not in another: then cut_fabric.wgsl might miss a cut at an edge that find_links.wgsl has found.
fn beside(a: vec2<f32>, b: vec2<f32>) -> f32 {
    let d = b - a;
    return fma(d.y, a.x, -(d.x * a.y));
}

// Area opposite to a corner, from the edge between the other two in the order of their numbers; y is 1 to the left of it.
fn opposite_area(from_node: u32, to_node: u32, a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    if from_node < to_node {
        let area = beside(a, b);
        return vec2<f32>(area, select(0.0, 1.0, area >= 0.0));
    }
    let area = beside(b, a);
    return vec2<f32>(-area, select(0.0, 1.0, area < 0.0));
}

// Barycentric weights of a line in a triangle; the fourth is 0 where it passes beside it.
fn weights_in(nodes: vec3<u32>, seen: Seen, line: vec2<i32>) -> vec4<f32> {
    let p = vec2<f32>(seen.whole[0] - line) + seen.rest[0];
    let q = vec2<f32>(seen.whole[1] - line) + seen.rest[1];
    let r = vec2<f32>(seen.whole[2] - line) + seen.rest[2];
    let first = opposite_area(nodes.y, nodes.z, q, r);
    let second = opposite_area(nodes.z, nodes.x, r, p);
    let third = opposite_area(nodes.x, nodes.y, p, q);
    let areas = vec3<f32>(first.x, second.x, third.x);
    let whole = areas.x + areas.y + areas.z;
    let inside = first.y == second.y && second.y == third.y && whole != 0.0;
    return vec4<f32>(areas / select(1.0, whole, whole != 0.0), select(0.0, 1.0, inside));
}

// The line of the links of a cell.
fn line_through(seen: Seen, cell: vec3<i32>) -> vec2<i32> {
    let slant = vec2<i32>(seen.c[seen.across.x], seen.c[seen.across.y]);
    return vec2<i32>(cell[seen.across.x], cell[seen.across.y]) - slant * cell[seen.along];
}

// Where a triangle cuts a line, on a link inside of the lattice.
fn cut_at(seen: Seen, nodes: vec3<u32>, line: vec2<i32>) -> LineCut {
    var cut: LineCut;
    let weights = weights_in(nodes, seen, line);
    if weights.w == 0.0 {
        return cut;
    }
    cut.weights = weights.xyz;
    let place = fma(weights.z, seen.places.z, fma(weights.y, seen.places.y, weights.x * seen.places.x));
    let whole = floor(place);
    cut.at = place - whole;
    cut.cell[seen.along] = seen.base + i32(whole);
    cut.cell[seen.across.x] = line.x + seen.c[seen.across.x] * cut.cell[seen.along];
    cut.cell[seen.across.y] = line.y + seen.c[seen.across.y] * cut.cell[seen.along];
    cut.is_one = in_lattice(cut.cell) && in_lattice(cut.cell + seen.c);
    return cut;
}
