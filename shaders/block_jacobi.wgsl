// H₀ where it is block-Jacobi: the inverse block of every node, kept as (xx, yy, zz, xy, xz, yz).

@group(0) @binding(19) var<storage, read> inverse_blocks: array<f32>;

fn preconditioned(node: u32, v: vec3<f32>) -> vec3<f32> {
    let b = node * 6u;
    let off = vec3<f32>(inverse_blocks[b + 3u], inverse_blocks[b + 4u], inverse_blocks[b + 5u]);
    return vec3<f32>(
        inverse_blocks[b] * v.x + off.x * v.y + off.y * v.z,
        off.x * v.x + inverse_blocks[b + 1u] * v.y + off.z * v.z,
        off.y * v.x + off.z * v.y + inverse_blocks[b + 2u] * v.z,
    );
}
