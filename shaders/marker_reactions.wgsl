// Where air and fabric meet at markers, and a device has both (src/gpu/cloth/marker_reactions.rs). Before a solve:
//   react       what the air does to every marker, which the solve has inside
//   drive       the loads that set the scale of its tolerance
// After it:
//   react_back  the force of every marker on the air, with the velocity that the step ends with
// u* and forces are in lattice units, all else in SI.

@group(0) @binding(3) var<storage, read> predicted_whole: array<i32>;
@group(0) @binding(4) var<storage, read> predicted_remainder: array<f32>;
// Of every marker of the fabric: three nodes and their weights, word by word.
@group(0) @binding(10) var<storage, read> fabric_markers: array<u32>;
// Of every marker: velocity [m/s] of the predicted sheet relative to the air, stiffness [kg/s].
@group(0) @binding(11) var<storage, read_write> reactions: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> vectors: array<f32>;
@group(0) @binding(20) var<storage, read> sorted_markers: array<Marker>;
// In that order: (u*, strength), and the force on the air.
@group(0) @binding(21) var<storage, read> marker_states: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> marker_forces: array<vec4<f32>>;
// Of every marker of the fabric: velocity of the predicted sheet [m/s], stiffness over strength [kg/s].
@group(0) @binding(23) var<storage, read> marker_motions: array<vec4<f32>>;
// Loads beside the pull of the air at the markers [N].
@group(0) @binding(24) var<storage, read> still_drive: array<f32>;
// Where the markers of every node begin, and which they are: 3 · marker + corner.
@group(0) @binding(25) var<storage, read> marker_first: array<u32>;
@group(0) @binding(26) var<storage, read> marker_corners: array<u32>;
// Words of every node: whole numbers and remainders of its position at the end of the solve, then what else it delivers.
@group(0) @binding(38) var<storage, read> delivered: array<u32>;

override MARKERS: u32 = 1u;
// Slot of the loads that set the scale of the tolerance.
override DRIVE: u32 = 0u;
// A lattice unit of velocity [m/s]; lattice units in a force of 1 N.
override SPEED: f32 = 1.0;
override FORCE: f32 = 1.0;

fn marker_node(corner: u32, k: u32) -> u32 {
    return fabric_markers[corner * MARKERS + k];
}

fn marker_weight(corner: u32, k: u32) -> f32 {
    return bitcast<f32>(fabric_markers[(3u + corner) * MARKERS + k]);
}

@compute @workgroup_size(WORKGROUP)
fn react(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let place = thread_index(group, groups, local);
    if place >= MARKERS {
        return;
    }
    let k = sorted_markers[place].number;
    let motion = marker_motions[k];
    let air = marker_states[place];
    reactions[k] = vec4<f32>(motion.xyz - air.xyz * SPEED, motion.w * air.w);
}

@compute @workgroup_size(WORKGROUP)
fn drive(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let node = thread_index(group, groups, local);
    if node >= NODES {
        return;
    }
    var load = vec3<f32>(still_drive[3u * node], still_drive[3u * node + 1u], still_drive[3u * node + 2u]);
    for (var i = marker_first[node]; i < marker_first[node + 1u]; i++) {
        let k = marker_corners[i] / 3u;
        let reaction = reactions[k];
        let air = marker_motions[k].xyz - reaction.xyz;
        load += (marker_weight(marker_corners[i] % 3u, k) * reaction.w) * air;
    }
    set_vector(DRIVE, node, load);
}

// Displacement of a node from the prediction at the end of the solve [m].
fn displacement(node: u32) -> vec3<f32> {
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
    return metres(between(predicted, solved));
}

@compute @workgroup_size(WORKGROUP)
fn react_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let place = thread_index(group, groups, local);
    if place >= MARKERS {
        return;
    }
    let k = sorted_markers[place].number;
    var moved = vec3<f32>(0.0);
    for (var corner = 0u; corner < 3u; corner++) {
        moved += marker_weight(corner, k) * displacement(marker_node(corner, k));
    }
    let reaction = reactions[k];
    let slip = reaction.xyz + moved * stage.rate;
    marker_forces[place] = vec4<f32>((reaction.w * FORCE) * slip, 0.0);
}
