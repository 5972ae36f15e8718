// Elements read points and write to slots of their own, one per corner; nodes gather their slots later, in a fixed order, so
// sums never depend on the order of threads. Slot = first slot of the kind + corner · count + element.

override TRIANGLES: u32 = 1u;
override TRIANGLE_SLOTS: u32 = 0u;
override TRIANGLE_ENERGIES: u32 = 0u;
override SPRINGS: u32 = 1u;
override SPRING_SLOTS: u32 = 0u;
override SPRING_ENERGIES: u32 = 0u;
override BENDINGS: u32 = 1u;
override BENDING_SLOTS: u32 = 0u;
override BENDING_ENERGIES: u32 = 0u;
override CURVATURES: u32 = 1u;
override CURVATURE_SLOTS: u32 = 0u;
override CURVATURE_ENERGIES: u32 = 0u;
override CABLES: u32 = 1u;
override CABLE_SLOTS: u32 = 0u;
override CABLE_ENERGIES: u32 = 0u;
override DASHPOTS: u32 = 1u;
override DASHPOT_SLOTS: u32 = 0u;
override DASHPOT_ENERGIES: u32 = 0u;
override FACES: u32 = 1u;
override FACE_SLOTS: u32 = 0u;
override FACE_ENERGIES: u32 = 0u;
override GUIDES: u32 = 1u;
override GUIDE_SLOTS: u32 = 0u;
override GUIDE_ENERGIES: u32 = 0u;
override MARKERS: u32 = 1u;
override MARKER_SLOTS: u32 = 0u;
override MARKER_ENERGIES: u32 = 0u;
override PERMEABLE_MARKERS: u32 = 1u;
override PERMEABLE_MARKER_SLOTS: u32 = 0u;
override PERMEABLE_MARKER_ENERGIES: u32 = 0u;
override CUT_TRIANGLES: u32 = 1u;
override CUT_TRIANGLE_SLOTS: u32 = 0u;
override CUT_TRIANGLE_ENERGIES: u32 = 0u;

@group(0) @binding(3) var<storage, read> predicted_whole: array<i32>;
@group(0) @binding(4) var<storage, read> predicted_remainder: array<f32>;
// Words of element e: k · count + e, in the order written by gpu::cloth::elements.
@group(0) @binding(5) var<storage, read> triangles: array<u32>;
@group(0) @binding(6) var<storage, read> springs: array<u32>;
@group(0) @binding(7) var<storage, read> bendings: array<u32>;
@group(0) @binding(8) var<storage, read> cables: array<u32>;
@group(0) @binding(9) var<storage, read> guides: array<u32>;
@group(0) @binding(10) var<storage, read> markers: array<u32>;
// Of every marker: velocity [m/s] of the predicted sheet relative to the air, stiffness [kg/s].
@group(0) @binding(11) var<storage, read> reactions: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> contributions: array<f32>;
@group(0) @binding(14) var<storage, read> node_first: array<u32>;
@group(0) @binding(15) var<storage, read> node_slots: array<u32>;
@group(0) @binding(16) var<storage, read> masses: array<f32>;
@group(0) @binding(18) var<storage, read> held: array<u32>;
@group(0) @binding(24) var<storage, read> curvatures: array<u32>;
// Pieces of the cables' laws: strain and force where each begins, slope, energy up to there.
@group(0) @binding(25) var<storage, read> cable_laws: array<vec4<f32>>;
@group(0) @binding(26) var<storage, read> dashpots: array<u32>;
// Words of a dashpot in a step: direction, stiffness [N/m], stretch of the prediction [m].
@group(0) @binding(27) var<storage, read> dashpot_states: array<f32>;
@group(0) @binding(28) var<storage, read> faces: array<u32>;
// Pressure jump along the normal of every face [Pa].
@group(0) @binding(29) var<storage, read> face_pressures: array<f32>;
@group(0) @binding(30) var<storage, read> permeable_markers: array<u32>;
// Words of a permeable marker in a step: normal, alpha, beta (src/immersed/permeable.rs).
@group(0) @binding(31) var<storage, read> permeabilities: array<f32>;
@group(0) @binding(32) var<storage, read> cut_triangles: array<u32>;
// Words of a triangle that cuts the lattice, in a step. First the stiffness [kg/s] between its corners 00, 11, 22, 01, 12, 20, each kept as (xx, yy, zz, xy, xz, yz).
// Then the force of the predicted velocities on each corner [N].
@group(0) @binding(33) var<storage, read> cut_reactions: array<f32>;

fn place(node: u32) -> Place {
    let k = (stage.point * NODES + node) * 3u;
    return Place(
        vec3<i32>(whole[k], whole[k + 1u], whole[k + 2u]),
        vec3<f32>(remainder[k], remainder[k + 1u], remainder[k + 2u]),
    );
}

fn predicted_place(node: u32) -> Place {
    let k = node * 3u;
    return Place(
        vec3<i32>(predicted_whole[k], predicted_whole[k + 1u], predicted_whole[k + 2u]),
        vec3<f32>(predicted_remainder[k], predicted_remainder[k + 1u], predicted_remainder[k + 2u]),
    );
}

// Displacement from the prediction [m].
fn displacement(node: u32) -> vec3<f32> {
    return metres(between(predicted_place(node), place(node)));
}

// Rest length squared: whole number of 2⁻³² m² (modulo 2³²), what is left of it in the same unit, and as it is [m²].
struct RestSquare {
    whole: u32,
    part: f32,
    square: f32,
}

// |edge|² − rest² [m²], without the cancellation: squares of whole numbers are compared modulo 2³², which is exact as long as
// the difference is below 2³¹ units; larger ones are far above the round-off of the plain difference.
fn squared_elongation(along: Place, edge: vec3<f32>, rest: RestSquare) -> f32 {
    let plain = dot(edge, edge) - rest.square;
    let squares = along.whole * along.whole;
    let difference = bitcast<i32>(bitcast<u32>(squares.x + squares.y + squares.z) - rest.whole);
    let units = along.remainder * 65536.0;
    let fine = f32(difference)
        + (2.0 * dot(vec3<f32>(along.whole), units) + dot(units, units) - rest.part);
    return select(plain, fine * UNIT_SQUARE, abs(plain) < 0.25);
}

struct TriangleState {
    // Edges 1→2, 2→0, 0→1 [m].
    edge0: vec3<f32>,
    edge1: vec3<f32>,
    edge2: vec3<f32>,
    // Columns of B of E = B s.
    b0: vec3<f32>,
    b1: vec3<f32>,
    b2: vec3<f32>,
    strain: vec3<f32>,
    rest_area: f32,
}

fn triangle_word(k: u32, e: u32) -> f32 {
    return bitcast<f32>(triangles[k * TRIANGLES + e]);
}

fn triangle_rest(k: u32, e: u32) -> RestSquare {
    return RestSquare(triangles[k * TRIANGLES + e], triangle_word(k + 1u, e), triangle_word(k + 2u, e));
}

fn triangle_state(e: u32) -> TriangleState {
    let p0 = place(triangles[e]);
    let p1 = place(triangles[TRIANGLES + e]);
    let p2 = place(triangles[2u * TRIANGLES + e]);
    let along0 = between(p1, p2);
    let along1 = between(p2, p0);
    let along2 = between(p0, p1);
    var t: TriangleState;
    t.edge0 = metres(along0);
    t.edge1 = metres(along1);
    t.edge2 = metres(along2);
    t.b0 = vec3<f32>(triangle_word(12u, e), triangle_word(15u, e), triangle_word(18u, e));
    t.b1 = vec3<f32>(triangle_word(13u, e), triangle_word(16u, e), triangle_word(19u, e));
    t.b2 = vec3<f32>(triangle_word(14u, e), triangle_word(17u, e), triangle_word(20u, e));
    t.strain = t.b0 * squared_elongation(along0, t.edge0, triangle_rest(3u, e))
        + t.b1 * squared_elongation(along1, t.edge1, triangle_rest(6u, e))
        + t.b2 * squared_elongation(along2, t.edge2, triangle_rest(9u, e));
    t.rest_area = triangle_word(21u, e);
    return t;
}

// A straight piece between two nodes.
struct Piece {
    edge: vec3<f32>,
    length: f32,
    elongation: f32,
}

fn piece(a: u32, b: u32, rest: RestSquare, rest_length: f32) -> Piece {
    let along = between(place(a), place(b));
    let edge = metres(along);
    let length = length(edge);
    return Piece(edge, length, squared_elongation(along, edge, rest) / (length + rest_length));
}

// Words of a spring or cable: two nodes, rest square (three words), rest length; then stiffnesses, or first piece of the law and their
// number.
fn spring_piece(e: u32) -> Piece {
    let rest = RestSquare(
        springs[2u * SPRINGS + e],
        bitcast<f32>(springs[3u * SPRINGS + e]),
        bitcast<f32>(springs[4u * SPRINGS + e]),
    );
    return piece(springs[e], springs[SPRINGS + e], rest, bitcast<f32>(springs[5u * SPRINGS + e]));
}

fn cable_piece(e: u32) -> Piece {
    let rest = RestSquare(
        cables[2u * CABLES + e],
        bitcast<f32>(cables[3u * CABLES + e]),
        bitcast<f32>(cables[4u * CABLES + e]),
    );
    return piece(cables[e], cables[CABLES + e], rest, bitcast<f32>(cables[5u * CABLES + e]));
}

struct CableState {
    tension: f32,
    // dT/dε
    tangent: f32,
    // Per rest length.
    energy: f32,
}

// Of a taut cable; slack ones carry nothing.
fn cable_state(e: u32, strain: f32) -> CableState {
    let first = cables[6u * CABLES + e];
    var piece = cable_laws[first];
    for (var k = 1u; k < cables[7u * CABLES + e]; k++) {
        let next = cable_laws[first + k];
        if next.x < strain {
            piece = next;
        }
    }
    let beyond = strain - piece.x;
    let tension = piece.y + piece.z * beyond;
    return CableState(tension, piece.z, piece.w + 0.5 * beyond * (piece.y + tension));
}

fn cable_rest_length(e: u32) -> f32 {
    return bitcast<f32>(cables[5u * CABLES + e]);
}

// Words of a curvature: six nodes, their coefficients, stiffness.
fn curvature_word(k: u32, e: u32) -> f32 {
    return bitcast<f32>(curvatures[k * CURVATURES + e]);
}

fn dashpot_direction(e: u32) -> vec3<f32> {
    return vec3<f32>(dashpot_states[e], dashpot_states[DASHPOTS + e], dashpot_states[2u * DASHPOTS + e]);
}

fn dashpot_stiffness(e: u32) -> f32 {
    return dashpot_states[3u * DASHPOTS + e];
}

fn guide_word(k: u32, e: u32) -> f32 {
    return bitcast<f32>(guides[k * GUIDES + e]);
}

fn marker_weight(corner: u32, e: u32) -> f32 {
    return bitcast<f32>(markers[(3u + corner) * MARKERS + e]);
}

fn permeable_marker_weight(corner: u32, e: u32) -> f32 {
    return bitcast<f32>(permeable_markers[(3u + corner) * PERMEABLE_MARKERS + e]);
}

// What a permeable marker does where the point sought has it.
struct PermeableReaction {
    normal: vec3<f32>,
    // V + v n - u* [m/s]
    slip: vec3<f32>,
    // v, dv/dw, and the work that the fabric takes from the air, over K
    through: f32,
    slope: f32,
    potential: f32,
}

fn permeable_reaction(e: u32) -> PermeableReaction {
    let moved = displacement(permeable_markers[e]) * permeable_marker_weight(0u, e)
        + displacement(permeable_markers[PERMEABLE_MARKERS + e]) * permeable_marker_weight(1u, e)
        + displacement(permeable_markers[2u * PERMEABLE_MARKERS + e]) * permeable_marker_weight(2u, e);
    let slip = moved * stage.rate + reactions[e].xyz;
    let normal = vec3<f32>(
        permeabilities[e],
        permeabilities[PERMEABLE_MARKERS + e],
        permeabilities[2u * PERMEABLE_MARKERS + e],
    );
    let viscous = permeabilities[3u * PERMEABLE_MARKERS + e];
    let inertial = permeabilities[4u * PERMEABLE_MARKERS + e];
    let against = -dot(slip, normal);
    let linear = 1.0 + viscous;
    let through = 2.0 * against / (linear + sqrt(linear * linear + 4.0 * inertial * abs(against)));
    return PermeableReaction(
        normal,
        slip + normal * through,
        through,
        1.0 / (linear + 2.0 * inertial * abs(through)),
        (0.5 * viscous + inertial * abs(through) / 3.0) * through * through,
    );
}

fn cut_words(first: u32, e: u32) -> vec3<f32> {
    let k = first * CUT_TRIANGLES + e;
    return vec3<f32>(cut_reactions[k], cut_reactions[k + CUT_TRIANGLES], cut_reactions[k + 2u * CUT_TRIANGLES]);
}

// Stiffness between a pair of corners times a velocity.
fn cut_resistance(pair: u32, e: u32, v: vec3<f32>) -> vec3<f32> {
    let diagonal = cut_words(6u * pair, e);
    let off = cut_words(6u * pair + 3u, e);
    return vec3<f32>(
        diagonal.x * v.x + off.x * v.y + off.y * v.z,
        off.x * v.x + diagonal.y * v.y + off.z * v.z,
        off.y * v.x + off.z * v.y + diagonal.z * v.z,
    );
}

fn cut_force(corner: u32, e: u32) -> vec3<f32> {
    return cut_words(36u + 3u * corner, e);
}
