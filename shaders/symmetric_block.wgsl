// Symmetric 3×3 blocks, kept as (xx, yy, zz, xy, xz, yz).

struct Block {
    diagonal: vec3<f32>,
    // xy, xz, yz
    off: vec3<f32>,
}

fn plus(a: Block, b: Block) -> Block {
    return Block(a.diagonal + b.diagonal, a.off + b.off);
}

fn isotropic(k: f32) -> Block {
    return Block(vec3<f32>(k), vec3<f32>(0.0));
}

// k a aᵀ.
fn square(a: vec3<f32>, k: f32) -> Block {
    return Block(k * a * a, k * vec3<f32>(a.x * a.y, a.x * a.z, a.y * a.z));
}

// k nnᵀ + t (1 − nnᵀ) along an edge.
fn axial(edge: vec3<f32>, length: f32, k: f32, t: f32) -> Block {
    var n = vec3<f32>(0.0);
    if length > 0.0 {
        n = edge / length;
    }
    return plus(isotropic(t), square(n, k - t));
}

fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

// Inverse of a positive semidefinite block, regular by a millionth of `largest`, its largest entry. No pivot of L D Lᵀ can be
// smaller than that; in f32 round-off can make one.
fn inverted(block: Block, largest: f32) -> Block {
    let least = 1e-6 * largest;
    let d = block.diagonal + vec3<f32>(least);
    let d0 = max(d.x, least);
    let l10 = block.off.x / d0;
    let l20 = block.off.y / d0;
    let d1 = max(d.y - l10 * block.off.x, least);
    let below = block.off.z - l20 * block.off.x;
    let l21 = below / d1;
    let d2 = max(d.z - l20 * block.off.y - l21 * below, least);
    // L⁻¹ has the rows (1, 0, 0), (−l10, 1, 0), (m, −l21, 1).
    let m = l10 * l21 - l20;
    let inverse = Block(
        vec3<f32>(1.0 / d0 + l10 * l10 / d1 + m * m / d2, 1.0 / d1 + l21 * l21 / d2, 1.0 / d2),
        vec3<f32>(-l10 / d1 - m * l21 / d2, m / d2, -l21 / d2),
    );
    let sum = dot(inverse.diagonal, vec3<f32>(1.0)) + dot(abs(inverse.off), vec3<f32>(1.0));
    if !is_finite(sum) {
        return isotropic(1.0 / largest);
    }
    return inverse;
}
