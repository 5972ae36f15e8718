// Where a device makes steps by itself: fabric from the end of one step to the start of the next (src/cpu/cloth/integration.rs).
//   predict             where nodes go on without forces, their loads, and what velocities count from
//   marker_velocities   of the predicted sheet
//   end_step            where nodes are at the end of the solve
// Ways of the last steps are kept in fixed point like places: in single precision alone their rounding would strain the fabric. All steps have one length.

// Mirrors gpu::cloth::parameters::FabricMotion.
struct FabricMotion {
    // Of x̂ beyond xⁿ: 1/3 of the last way in steps of BDF2, none in those of backward Euler.
    share: f32,
    // 1/h [1/s].
    rate: f32,
    // Mass-proportional damping [1/s].
    damping: f32,
    // H₀ g of a solve that converged counts where no node moves farther by it [m].
    longest_remainder: f32,
}

@group(0) @binding(0) var<uniform> motion: FabricMotion;
@group(0) @binding(1) var<storage, read_write> nodes_whole: array<i32>;
@group(0) @binding(2) var<storage, read_write> nodes_remainder: array<f32>;
@group(0) @binding(3) var<storage, read_write> predicted_whole: array<i32>;
@group(0) @binding(4) var<storage, read_write> predicted_remainder: array<f32>;
// Of every node: its ways in the last three steps, the last one first.
@group(0) @binding(5) var<storage, read_write> ways_whole: array<i32>;
@group(0) @binding(6) var<storage, read_write> ways_remainder: array<f32>;
// Velocities of the prediction [m/s].
@group(0) @binding(7) var<storage, read_write> base_velocities: array<f32>;
// Loads that no motion changes, and all that are the same during a step [N].
@group(0) @binding(8) var<storage, read> still_drive: array<f32>;
@group(0) @binding(9) var<storage, read_write> loads: array<f32>;
@group(0) @binding(10) var<storage, read> masses: array<f32>;
@group(0) @binding(11) var<storage, read> held: array<u32>;
// Of every marker of the fabric: three nodes and their weights, word by word.
@group(0) @binding(12) var<storage, read> fabric_markers: array<u32>;
@group(0) @binding(13) var<storage, read_write> marker_motions: array<vec4<f32>>;
// Words of every node: whole numbers and remainders of its position at the end of the solve, then H₀ g.
@group(0) @binding(14) var<storage, read> delivered: array<u32>;
@group(0) @binding(15) var<storage, read> minimiser: Minimiser;

override MARKERS: u32 = 1u;

// Ways of a node.
const WAYS: u32 = 3u;
// 2⁴⁰
const FINEST: f32 = 1099511627776.0;

fn node_place(node: u32) -> Place {
    let p = 3u * node;
    return Place(
        vec3<i32>(nodes_whole[p], nodes_whole[p + 1u], nodes_whole[p + 2u]),
        vec3<f32>(nodes_remainder[p], nodes_remainder[p + 1u], nodes_remainder[p + 2u]),
    );
}

fn way(node: u32, number: u32) -> Place {
    let p = 3u * (WAYS * node + number);
    return Place(
        vec3<i32>(ways_whole[p], ways_whole[p + 1u], ways_whole[p + 2u]),
        vec3<f32>(ways_remainder[p], ways_remainder[p + 1u], ways_remainder[p + 2u]),
    );
}

fn set_way(node: u32, number: u32, value: Place) {
    let p = 3u * (WAYS * node + number);
    for (var axis = 0u; axis < 3u; axis++) {
        ways_whole[p + axis] = value.whole[axis];
        ways_remainder[p + axis] = value.remainder[axis];
    }
}

// Moved by a short way [m]: what is not a number stays in the remainder.
fn moved(place: Place, by: vec3<f32>) -> Place {
    let moves = select(vec3<f32>(0.0), round(by * 65536.0), abs(by) < vec3<f32>(16384.0));
    let rest = place.remainder + (by - moves * UNIT);
    let carry = select(vec3<f32>(0.0), round(rest * 65536.0), abs(rest) < vec3<f32>(1.0));
    return Place(place.whole + vec3<i32>(moves) + vec3<i32>(carry), rest - carry * UNIT);
}

// The place as the host has it, too: remainders are whole numbers of 2⁻⁴⁰ m, from −2⁻¹⁷ m to below 2⁻¹⁷ m, whose differences are exact.
fn settled(place: Place) -> Place {
    let remainder = round(place.remainder * FINEST) / FINEST;
    let halves = remainder * 131072.0;
    let carry = select(vec3<f32>(0.0), vec3<f32>(1.0), halves >= vec3<f32>(1.0))
        - select(vec3<f32>(0.0), vec3<f32>(1.0), halves < vec3<f32>(-1.0));
    return Place(place.whole + vec3<i32>(carry), remainder - carry * UNIT);
}

@compute @workgroup_size(WORKGROUP)
fn predict(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    var place = node_place(node);
    var base = vec3<f32>(0.0);
    if held[node] == 0u {
        let last = way(node, 0u);
        var further = vec3<f32>(0.0);
        if motion.share > 0.0 {
            // x̂ + h v̂ = xⁿ + (15 d₁ − 7 d₂ + d₃)/9 with the ways d.
            let before = way(node, 1u);
            let change = metres(between(before, last));
            let change_before = metres(between(way(node, 2u), before));
            further = (6.0 * change - change_before) / 9.0;
        }
        place = moved(Place(place.whole + last.whole, place.remainder + last.remainder), further);
        base = ((1.0 - motion.share) * metres(last) + further) * motion.rate;
    }
    let damping = motion.damping * masses[node];
    for (var axis = 0u; axis < 3u; axis++) {
        let p = 3u * node + axis;
        predicted_whole[p] = place.whole[axis];
        predicted_remainder[p] = place.remainder[axis];
        base_velocities[p] = base[axis];
        loads[p] = still_drive[p] - damping * base[axis];
    }
}

@compute @workgroup_size(WORKGROUP)
fn marker_velocities(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let k = thread_index(group, groups, local);
    if k >= MARKERS {
        return;
    }
    var velocity = vec3<f32>(0.0);
    for (var corner = 0u; corner < 3u; corner++) {
        let p = 3u * fabric_markers[corner * MARKERS + k];
        let weight = bitcast<f32>(fabric_markers[(3u + corner) * MARKERS + k]);
        velocity += weight * vec3<f32>(base_velocities[p], base_velocities[p + 1u], base_velocities[p + 2u]);
    }
    marker_motions[k] = vec4<f32>(velocity, marker_motions[k].w);
}

@compute @workgroup_size(WORKGROUP)
fn end_step(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    if held[node] != 0u {
        return;
    }
    let d = 9u * node;
    var solved = Place(
        bitcast<vec3<i32>>(vec3<u32>(delivered[d], delivered[d + 1u], delivered[d + 2u])),
        bitcast<vec3<f32>>(vec3<u32>(delivered[d + 3u], delivered[d + 4u], delivered[d + 5u])),
    );
    if minimiser.status == CONVERGED && minimiser.longest <= motion.longest_remainder {
        solved.remainder -= bitcast<vec3<f32>>(vec3<u32>(delivered[d + 6u], delivered[d + 7u], delivered[d + 8u]));
    }
    solved = settled(solved);
    set_way(node, 2u, way(node, 1u));
    set_way(node, 1u, way(node, 0u));
    set_way(node, 0u, settled(between(node_place(node), solved)));
    for (var axis = 0u; axis < 3u; axis++) {
        let p = 3u * node + axis;
        nodes_whole[p] = solved.whole[axis];
        nodes_remainder[p] = solved.remainder[axis];
    }
}
