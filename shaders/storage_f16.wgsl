enable f16;

// How populations lie in memory: in 16 bits, scaled by 2^15, so that the numbers near zero that shifted populations are keep their 11 bits
// down to 1.9e-9; the largest is 2 (Lehmann et al. 2022, doi:10.1103/PhysRevE.106.015308, format FP16S). Arithmetic stays in f32.

alias Stored = f16;

const STORAGE_SCALE: f32 = 32768.0;

fn unpacked(value: Stored) -> f32 {
    return f32(value) * (1.0 / STORAGE_SCALE);
}

fn packed(value: f32) -> Stored {
    return f16(value * STORAGE_SCALE);
}
