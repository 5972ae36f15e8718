// Vectors of the minimiser, in one buffer that the shader declares: three numbers per node and slot.

const NONE: u32 = 0xffffffffu;
const ENERGY: u32 = 0xfffffffeu;

fn vector(slot: u32, node: u32) -> vec3<f32> {
    let k = (slot * NODES + node) * 3u;
    return vec3<f32>(vectors[k], vectors[k + 1u], vectors[k + 2u]);
}

fn set_vector(slot: u32, node: u32, value: vec3<f32>) {
    let k = (slot * NODES + node) * 3u;
    vectors[k] = value.x;
    vectors[k + 1u] = value.y;
    vectors[k + 2u] = value.z;
}

// |v|² as bits: ordered like the numbers, with infinity and then what is not a number above all of them.
fn square_bits(v: vec3<f32>) -> u32 {
    return bitcast<u32>(dot(v, v)) & 0x7fffffffu;
}
