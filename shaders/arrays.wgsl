// The population buffers by the number of their array (not by near and far, see populations.wgsl), for the few populations at the
// faces of the domain or of a box. Lists are sorted by array, so that neighbouring threads take the same branch.

@group(0) @binding(0) var<storage, read_write> population_0: array<Stored>;
@group(0) @binding(1) var<storage, read_write> population_1: array<Stored>;
@group(0) @binding(2) var<storage, read_write> population_2: array<Stored>;
@group(0) @binding(3) var<storage, read_write> population_3: array<Stored>;
@group(0) @binding(4) var<storage, read_write> population_4: array<Stored>;
@group(0) @binding(5) var<storage, read_write> population_5: array<Stored>;
@group(0) @binding(6) var<storage, read_write> population_6: array<Stored>;
@group(0) @binding(7) var<storage, read_write> population_7: array<Stored>;
@group(0) @binding(8) var<storage, read_write> population_8: array<Stored>;
@group(0) @binding(9) var<storage, read_write> population_9: array<Stored>;
@group(0) @binding(10) var<storage, read_write> population_10: array<Stored>;
@group(0) @binding(11) var<storage, read_write> population_11: array<Stored>;
@group(0) @binding(12) var<storage, read_write> population_12: array<Stored>;
@group(0) @binding(13) var<storage, read_write> population_13: array<Stored>;
@group(0) @binding(14) var<storage, read_write> population_14: array<Stored>;
@group(0) @binding(15) var<storage, read_write> population_15: array<Stored>;
@group(0) @binding(16) var<storage, read_write> population_16: array<Stored>;
@group(0) @binding(17) var<storage, read_write> population_17: array<Stored>;
@group(0) @binding(18) var<storage, read_write> population_18: array<Stored>;

fn load(array_number: u32, slot: u32) -> f32 {
    switch array_number {
        case 1u: { return unpacked(population_1[slot]); }
        case 2u: { return unpacked(population_2[slot]); }
        case 3u: { return unpacked(population_3[slot]); }
        case 4u: { return unpacked(population_4[slot]); }
        case 5u: { return unpacked(population_5[slot]); }
        case 6u: { return unpacked(population_6[slot]); }
        case 7u: { return unpacked(population_7[slot]); }
        case 8u: { return unpacked(population_8[slot]); }
        case 9u: { return unpacked(population_9[slot]); }
        case 10u: { return unpacked(population_10[slot]); }
        case 11u: { return unpacked(population_11[slot]); }
        case 12u: { return unpacked(population_12[slot]); }
        case 13u: { return unpacked(population_13[slot]); }
        case 14u: { return unpacked(population_14[slot]); }
        case 15u: { return unpacked(population_15[slot]); }
        case 16u: { return unpacked(population_16[slot]); }
        case 17u: { return unpacked(population_17[slot]); }
        case 18u: { return unpacked(population_18[slot]); }
        default: { return unpacked(population_0[slot]); }
    }
}

fn store(array_number: u32, slot: u32, value: f32) {
    let stored = packed(value);
    switch array_number {
        case 1u: { population_1[slot] = stored; }
        case 2u: { population_2[slot] = stored; }
        case 3u: { population_3[slot] = stored; }
        case 4u: { population_4[slot] = stored; }
        case 5u: { population_5[slot] = stored; }
        case 6u: { population_6[slot] = stored; }
        case 7u: { population_7[slot] = stored; }
        case 8u: { population_8[slot] = stored; }
        case 9u: { population_9[slot] = stored; }
        case 10u: { population_10[slot] = stored; }
        case 11u: { population_11[slot] = stored; }
        case 12u: { population_12[slot] = stored; }
        case 13u: { population_13[slot] = stored; }
        case 14u: { population_14[slot] = stored; }
        case 15u: { population_15[slot] = stored; }
        case 16u: { population_16[slot] = stored; }
        case 17u: { population_17[slot] = stored; }
        case 18u: { population_18[slot] = stored; }
        default: { population_0[slot] = stored; }
    }
}
