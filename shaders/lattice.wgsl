// The D3Q19 lattice in lattice units, on populations shifted by their weights; the formulas of src/lattice/.
// Directions come in opposite pairs (1, 2) .. (17, 18):
//   x, y, z, xy, xz, yz, x-y, x-z, y-z.

alias Populations = array<f32, 19>;

struct Moments {
    density_excess: f32,
    momentum: vec3<f32>,
    // xx, yy, zz
    normal_stress: vec3<f32>,
    // xy, xz, yz
    shear_stress: vec3<f32>,
}

// Moments of the populations, without any forcing correction.
fn moments(f: Populations) -> Moments {
    let sx = f[1] + f[2];
    let sy = f[3] + f[4];
    let sz = f[5] + f[6];
    let sxy = f[7] + f[8];
    let sxz = f[9] + f[10];
    let syz = f[11] + f[12];
    let txy = f[13] + f[14];
    let txz = f[15] + f[16];
    let tyz = f[17] + f[18];
    let xy = sxy + txy;
    let xz = sxz + txz;
    let yz = syz + tyz;
    let dxy = f[7] - f[8];
    let dxz = f[9] - f[10];
    let dyz = f[11] - f[12];
    let exy = f[13] - f[14];
    let exz = f[15] - f[16];
    let eyz = f[17] - f[18];
    var m: Moments;
    m.density_excess = f[0] + ((sx + sy + sz) + (xy + xz + yz));
    m.momentum = vec3<f32>(
        (f[1] - f[2]) + ((dxy + exy) + (dxz + exz)),
        (f[3] - f[4]) + ((dxy - exy) + (dyz + eyz)),
        (f[5] - f[6]) + ((dxz - exz) + (dyz - eyz)),
    );
    m.normal_stress = vec3<f32>(sx + xy + xz, sy + xy + yz, sz + xz + yz);
    m.shear_stress = vec3<f32>(sxy - txy, sxz - txz, syz - tyz);
    return m;
}

// Density excess and bare velocity (no F/2).
fn bare_state(f: Populations) -> vec4<f32> {
    let m = moments(f);
    return vec4<f32>(m.momentum / (1.0 + m.density_excess), m.density_excess);
}

// Second-order equilibrium of a direction `c` with its weight.
fn shifted_equilibrium(weight: f32, c: vec3<f32>, density_excess: f32, u: vec3<f32>) -> f32 {
    let along = dot(c, u);
    return weight * (density_excess
        + (1.0 + density_excess) * (3.0 * along + 4.5 * along * along - 1.5 * dot(u, u)));
}
