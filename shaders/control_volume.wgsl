// Populations that crossed the faces of a box of cells in the step just done (src/lattice/control_volume.rs), summed per workgroup.
// Sums of many steps wait in a ring until the host fetches them.

// What one workgroup sums: entries of one array.
struct Portion {
    array_number: u32,
    // First entry in the list, and how many.
    first: u32,
    count: u32,
    padding: u32,
}

struct RingPlace {
    // Where the sums of this step begin.
    offset: u32,
    // Number of portions.
    portions: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(19) var<storage, read> crossings: array<u32>;
@group(0) @binding(20) var<storage, read> portions: array<Portion>;
@group(0) @binding(21) var<storage, read_write> outflow_sums: array<f32>;
@group(0) @binding(22) var<uniform> ring: RingPlace;

var<workgroup> shared_sums: array<f32, WORKGROUP>;

@compute @workgroup_size(WORKGROUP)
fn outflow(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32) {
    let number = group.y * groups.x + group.x;
    var own = 0.0;
    if number < ring.portions {
        let portion = portions[number];
        for (var i = local; i < portion.count; i += WORKGROUP) {
            own += load(portion.array_number, crossings[portion.first + i]);
        }
    }
    shared_sums[local] = own;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            shared_sums[local] += shared_sums[local + half];
        }
        workgroupBarrier();
    }
    if local == 0u && number < ring.portions {
        outflow_sums[ring.offset + number] = shared_sums[0];
    }
}
