// Energy and forces of one element of every kind, and the gradient of a node (src/cpu/cloth/objective.rs). Functions give the energy [J], and its magnitude.

@group(0) @binding(17) var<storage, read> loads: array<f32>;
@group(0) @binding(20) var<storage, read_write> vectors: array<f32>;

// A point in the middle of the structure, in 2⁻¹⁶ m, from where volumes are seen.
override ORIGIN_X: i32 = 0;
override ORIGIN_Y: i32 = 0;
override ORIGIN_Z: i32 = 0;

fn contribute(slot: u32, force: vec3<f32>) {
    let k = slot * 3u;
    contributions[k] = force.x;
    contributions[k + 1u] = force.y;
    contributions[k + 2u] = force.z;
}

fn positive(energy: f32) -> vec2<f32> {
    return vec2<f32>(energy, abs(energy));
}

fn triangle_force(e: u32) -> vec2<f32> {
    let t = triangle_state(e);
    let response = respond(t.strain);
    let energy = positive(t.rest_area * response.energy);
    // ∂W/∂s_i, times ∂s_i/∂x = ±2 (x_to − x_from).
    let pull0 = t.edge0 * (2.0 * t.rest_area * dot(t.b0, response.tension));
    let pull1 = t.edge1 * (2.0 * t.rest_area * dot(t.b1, response.tension));
    let pull2 = t.edge2 * (2.0 * t.rest_area * dot(t.b2, response.tension));
    contribute(TRIANGLE_SLOTS + e, pull1 - pull2);
    contribute(TRIANGLE_SLOTS + TRIANGLES + e, pull2 - pull0);
    contribute(TRIANGLE_SLOTS + 2u * TRIANGLES + e, pull0 - pull1);
    return energy;
}

fn spring_force(e: u32) -> vec2<f32> {
    let p = spring_piece(e);
    let stretched = bitcast<f32>(springs[6u * SPRINGS + e]);
    let shortened = bitcast<f32>(springs[7u * SPRINGS + e]);
    let stiffness = select(stretched, shortened, p.elongation < 0.0);
    let energy = positive(0.5 * stiffness * p.elongation * p.elongation);
    // Coincident ends have no direction; other values of length, not finite ones too, go through.
    var pull = vec3<f32>(0.0);
    if p.length != 0.0 {
        pull = p.edge * (stiffness * p.elongation / p.length);
    }
    contribute(SPRING_SLOTS + e, -pull);
    contribute(SPRING_SLOTS + SPRINGS + e, pull);
    return energy;
}

fn bending_force(e: u32) -> vec2<f32> {
    let middle = place(bendings[BENDINGS + e]);
    let before = between(middle, place(bendings[e]));
    let after = between(middle, place(bendings[2u * BENDINGS + e]));
    let second_difference = metres(Place(
        before.whole + after.whole,
        before.remainder + after.remainder,
    ));
    let stiffness = bitcast<f32>(bendings[3u * BENDINGS + e]);
    let energy = positive(0.5 * stiffness * dot(second_difference, second_difference));
    let pull = second_difference * stiffness;
    contribute(BENDING_SLOTS + e, pull);
    contribute(BENDING_SLOTS + BENDINGS + e, -2.0 * pull);
    contribute(BENDING_SLOTS + 2u * BENDINGS + e, pull);
    return energy;
}

fn curvature_force(e: u32) -> vec2<f32> {
    // Coefficients sum to zero: places count from that of the first node.
    let origin = place(curvatures[e]);
    var bend = vec3<f32>(0.0);
    for (var k = 1u; k < 6u; k++) {
        bend += curvature_word(6u + k, e) * metres(between(origin, place(curvatures[k * CURVATURES + e])));
    }
    let stiffness = curvature_word(12u, e);
    let energy = positive(0.5 * stiffness * dot(bend, bend));
    for (var k = 0u; k < 6u; k++) {
        contribute(CURVATURE_SLOTS + k * CURVATURES + e, (curvature_word(6u + k, e) * stiffness) * bend);
    }
    return energy;
}

// Axial damping of cables (src/cpu/cloth/dashpots.rs).
fn dashpot_force(e: u32) -> vec2<f32> {
    let direction = dashpot_direction(e);
    let moved = displacement(dashpots[DASHPOTS + e]) - displacement(dashpots[e]);
    let stretch = dot(moved, direction) + dashpot_states[4u * DASHPOTS + e];
    let pull = dashpot_stiffness(e) * stretch;
    let energy = positive(0.5 * pull * stretch);
    contribute(DASHPOT_SLOTS + e, -pull * direction);
    contribute(DASHPOT_SLOTS + DASHPOTS + e, pull * direction);
    return energy;
}

fn cable_force(e: u32) -> vec2<f32> {
    var energy = vec2<f32>(0.0);
    let p = cable_piece(e);
    let rest_length = cable_rest_length(e);
    var pull = vec3<f32>(0.0);
    // Slack cables carry nothing; an elongation that is not a number is not slack.
    if !(p.elongation <= 0.0) {
        let state = cable_state(e, p.elongation / rest_length);
        energy = positive(state.energy * rest_length);
        pull = p.edge * (state.tension / p.length);
    }
    contribute(CABLE_SLOTS + e, -pull);
    contribute(CABLE_SLOTS + CABLES + e, pull);
    return energy;
}

fn guide_force(e: u32) -> vec2<f32> {
    let anchor = Place(
        vec3<i32>(
            bitcast<i32>(guides[GUIDES + e]),
            bitcast<i32>(guides[2u * GUIDES + e]),
            bitcast<i32>(guides[3u * GUIDES + e]),
        ),
        vec3<f32>(guide_word(4u, e), guide_word(5u, e), guide_word(6u, e)),
    );
    let offset = metres(between(anchor, place(guides[e])));
    let force = vec3<f32>(guide_word(7u, e), guide_word(8u, e), guide_word(9u, e)) * offset;
    let energy = positive(0.5 * dot(force, offset));
    contribute(GUIDE_SLOTS + e, force);
    return energy;
}

// Pressure that follows the surface (src/cpu/cloth/pressure.rs), whose edges are held. The energy −p V counts from the prediction, so
// that no volume is taken from another: with d = 6 V = a·S, a a corner and S the doubled area vector, d − d_p = (a − a_p)·S + a_p·(S − S_p).
fn face_force(e: u32) -> vec2<f32> {
    let nodes = vec3<u32>(faces[e], faces[FACES + e], faces[2u * FACES + e]);
    let corner = place(nodes.x);
    let along1 = metres(between(corner, place(nodes.y)));
    let along2 = metres(between(corner, place(nodes.z)));
    let moved = displacement(nodes.x);
    let stretch1 = displacement(nodes.y) - moved;
    let stretch2 = displacement(nodes.z) - moved;
    let area = cross(along1, along2);
    let turned = cross(along1 - stretch1, stretch2) + cross(stretch1, along2);
    let origin = Place(vec3<i32>(ORIGIN_X, ORIGIN_Y, ORIGIN_Z), vec3<f32>(0.0));
    let before = metres(between(origin, predicted_place(nodes.x)));
    let share = face_pressures[e] / 6.0;
    let lifted = share * dot(moved, area);
    let swung = share * dot(before, turned);
    let energy = vec2<f32>(-lifted - swung, abs(lifted) + abs(swung));
    let pull = -share * area;
    contribute(FACE_SLOTS + e, pull);
    contribute(FACE_SLOTS + FACES + e, pull);
    contribute(FACE_SLOTS + 2u * FACES + e, pull);
    return energy;
}

// Reaction of the air: K (v − u*) at every marker, with v − u* = (sheet's velocity in the prediction − u*) + displacement / dt.
fn marker_force(e: u32) -> vec2<f32> {
    let w0 = marker_weight(0u, e);
    let w1 = marker_weight(1u, e);
    let w2 = marker_weight(2u, e);
    let moved = displacement(markers[e]) * w0
        + displacement(markers[MARKERS + e]) * w1
        + displacement(markers[2u * MARKERS + e]) * w2;
    let reaction = reactions[e];
    let slip = moved * stage.rate + reaction.xyz;
    let force = slip * reaction.w;
    let energy = positive(0.5 * stage.time_step * dot(force, slip));
    contribute(MARKER_SLOTS + e, force * w0);
    contribute(MARKER_SLOTS + MARKERS + e, force * w1);
    contribute(MARKER_SLOTS + 2u * MARKERS + e, force * w2);
    return energy;
}

// The same where air passes the fabric (src/cpu/cloth/permeable.rs).
fn permeable_marker_force(e: u32) -> vec2<f32> {
    let found = permeable_reaction(e);
    let stiffness = reactions[e].w;
    let force = found.slip * stiffness;
    let energy = positive(stage.time_step * stiffness * (0.5 * dot(found.slip, found.slip) + found.potential));
    contribute(PERMEABLE_MARKER_SLOTS + e, force * permeable_marker_weight(0u, e));
    contribute(PERMEABLE_MARKER_SLOTS + PERMEABLE_MARKERS + e, force * permeable_marker_weight(1u, e));
    contribute(PERMEABLE_MARKER_SLOTS + 2u * PERMEABLE_MARKERS + e, force * permeable_marker_weight(2u, e));
    return energy;
}

// Reaction of the air at the cuts of a triangle (src/cpu/cloth/triangle_reaction.rs): S w and the force of the prediction, w = displacement / dt.
fn cut_triangle_force(e: u32) -> vec2<f32> {
    let w0 = displacement(cut_triangles[e]) * stage.rate;
    let w1 = displacement(cut_triangles[CUT_TRIANGLES + e]) * stage.rate;
    let w2 = displacement(cut_triangles[2u * CUT_TRIANGLES + e]) * stage.rate;
    let r0 = cut_resistance(0u, e, w0) + cut_resistance(3u, e, w1) + cut_resistance(5u, e, w2);
    let r1 = cut_resistance(3u, e, w0) + cut_resistance(1u, e, w1) + cut_resistance(4u, e, w2);
    let r2 = cut_resistance(5u, e, w0) + cut_resistance(4u, e, w1) + cut_resistance(2u, e, w2);
    let f0 = cut_force(0u, e);
    let f1 = cut_force(1u, e);
    let f2 = cut_force(2u, e);
    let resisted = 0.5 * (dot(w0, r0) + dot(w1, r1) + dot(w2, r2));
    let worked = dot(w0, f0) + dot(w1, f1) + dot(w2, f2);
    let energy = stage.time_step * vec2<f32>(resisted + worked, abs(resisted) + abs(worked));
    contribute(CUT_TRIANGLE_SLOTS + e, r0 + f0);
    contribute(CUT_TRIANGLE_SLOTS + CUT_TRIANGLES + e, r1 + f1);
    contribute(CUT_TRIANGLE_SLOTS + 2u * CUT_TRIANGLES + e, r2 + f2);
    return energy;
}

// Gradient of a node, which is written, with the energy of its motion and loads.
struct AtNode {
    gradient: vec3<f32>,
    energy: vec2<f32>,
}

fn at_node(node: u32) -> AtNode {
    var gradient = vec3<f32>(0.0);
    for (var k = node_first[node]; k < node_first[node + 1u]; k++) {
        let slot = node_slots[k] * 3u;
        gradient += vec3<f32>(contributions[slot], contributions[slot + 1u], contributions[slot + 2u]);
    }
    let moved = displacement(node);
    let inertia = masses[node] * stage.inertia * moved;
    let load = vec3<f32>(loads[node * 3u], loads[node * 3u + 1u], loads[node * 3u + 2u]);
    let kinetic = 0.5 * dot(inertia, moved);
    let work = dot(load, moved);
    gradient += inertia - load;
    if held[node] != 0u {
        gradient = vec3<f32>(0.0);
    }
    set_vector(stage.gradient, node, gradient);
    return AtNode(gradient, vec2<f32>(kinetic - work, abs(kinetic) + abs(work)));
}
