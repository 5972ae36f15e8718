// The population buffers by the number of their array (not by near and far, see populations.wgsl), for the few populations at the
// faces of the domain or of a box. Lists are sorted by array, so that neighbouring threads take the same branch.

@group(0) @binding(0) var<storage, read_write> population_0: array<f32>;
@group(0) @binding(1) var<storage, read_write> population_1: array<f32>;
@group(0) @binding(2) var<storage, read_write> population_2: array<f32>;
@group(0) @binding(3) var<storage, read_write> population_3: array<f32>;
@group(0) @binding(4) var<storage, read_write> population_4: array<f32>;
@group(0) @binding(5) var<storage, read_write> population_5: array<f32>;
@group(0) @binding(6) var<storage, read_write> population_6: array<f32>;
@group(0) @binding(7) var<storage, read_write> population_7: array<f32>;
@group(0) @binding(8) var<storage, read_write> population_8: array<f32>;
@group(0) @binding(9) var<storage, read_write> population_9: array<f32>;
@group(0) @binding(10) var<storage, read_write> population_10: array<f32>;
@group(0) @binding(11) var<storage, read_write> population_11: array<f32>;
@group(0) @binding(12) var<storage, read_write> population_12: array<f32>;
@group(0) @binding(13) var<storage, read_write> population_13: array<f32>;
@group(0) @binding(14) var<storage, read_write> population_14: array<f32>;
@group(0) @binding(15) var<storage, read_write> population_15: array<f32>;
@group(0) @binding(16) var<storage, read_write> population_16: array<f32>;
@group(0) @binding(17) var<storage, read_write> population_17: array<f32>;
@group(0) @binding(18) var<storage, read_write> population_18: array<f32>;

fn load(array_number: u32, slot: u32) -> f32 {
    switch array_number {
        case 1u: { return population_1[slot]; }
        case 2u: { return population_2[slot]; }
        case 3u: { return population_3[slot]; }
        case 4u: { return population_4[slot]; }
        case 5u: { return population_5[slot]; }
        case 6u: { return population_6[slot]; }
        case 7u: { return population_7[slot]; }
        case 8u: { return population_8[slot]; }
        case 9u: { return population_9[slot]; }
        case 10u: { return population_10[slot]; }
        case 11u: { return population_11[slot]; }
        case 12u: { return population_12[slot]; }
        case 13u: { return population_13[slot]; }
        case 14u: { return population_14[slot]; }
        case 15u: { return population_15[slot]; }
        case 16u: { return population_16[slot]; }
        case 17u: { return population_17[slot]; }
        case 18u: { return population_18[slot]; }
        default: { return population_0[slot]; }
    }
}

fn store(array_number: u32, slot: u32, value: f32) {
    switch array_number {
        case 1u: { population_1[slot] = value; }
        case 2u: { population_2[slot] = value; }
        case 3u: { population_3[slot] = value; }
        case 4u: { population_4[slot] = value; }
        case 5u: { population_5[slot] = value; }
        case 6u: { population_6[slot] = value; }
        case 7u: { population_7[slot] = value; }
        case 8u: { population_8[slot] = value; }
        case 9u: { population_9[slot] = value; }
        case 10u: { population_10[slot] = value; }
        case 11u: { population_11[slot] = value; }
        case 12u: { population_12[slot] = value; }
        case 13u: { population_13[slot] = value; }
        case 14u: { population_14[slot] = value; }
        case 15u: { population_15[slot] = value; }
        case 16u: { population_16[slot] = value; }
        case 17u: { population_17[slot] = value; }
        case 18u: { population_18[slot] = value; }
        default: { population_0[slot] = value; }
    }
}
