// Collision operators on one cell (src/lattice/operators.rs: sources and departures there). `forced` is always a literal, so that
// the force-free stage carries no forcing terms.

// Names and numbers of `Operator` (src/lattice/collision.rs).
const SINGLE_RELAXATION_TIME: u32 = 0u;
const TWO_RELAXATION_TIMES: u32 = 1u;
const RECURSIVE_REGULARISED: u32 = 2u;
const STABILISED_REGULARISED: u32 = 3u;
override OPERATOR: u32 = RECURSIVE_REGULARISED;
// Smagorinsky's eddy viscosity, evaluated within the collision.
override EDDY: bool = false;
// 18 sqrt(2) C_s^2
override EDDY_FACTOR: f32 = 0.0;

const TRT_MAGIC: f32 = 3.0 / 16.0;
const RESIDUAL_FACTOR: f32 = 1.0;
const AXIS: f32 = 1.0 / 18.0;
const DIAGONAL: f32 = 1.0 / 36.0;

fn collide(f: Populations, relaxation_time: f32, force: vec3<f32>, forced: bool) -> Populations {
    switch OPERATOR {
        case SINGLE_RELAXATION_TIME: {
            return relax_pairs(f, relaxation_time, force, forced, true);
        }
        case TWO_RELAXATION_TIMES: {
            return relax_pairs(f, relaxation_time, force, forced, false);
        }
        case RECURSIVE_REGULARISED: {
            return regularise(f, relaxation_time, force, forced, false);
        }
        case STABILISED_REGULARISED: {
            return regularise(f, relaxation_time, force, forced, true);
        }
        default: {
            // No operator has this number: the run is to break down, not to take another one.
            var none: Populations;
            none[0] = sqrt(-1.0 - f[0] * f[0]);
            return none;
        }
    }
}

// Relaxation time with the eddy viscosity of a non-equilibrium stress.
fn eddy_relaxation_time(tau: f32, normal: vec3<f32>, shear: vec3<f32>, inverse_density: f32) -> f32 {
    let norm = sqrt(dot(normal, normal) + 2.0 * dot(shear, shear));
    return 0.5 * (tau + sqrt(tau * tau + EDDY_FACTOR * norm * inverse_density));
}

// (xy, xz, yz) of 1/2 (a b + b a)
fn symmetric_shear(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return 0.5 * vec3<f32>(a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y);
}

// Relaxes even and odd parts of all pairs, at one rate (`single`, always a literal) or at two.
fn relax_pairs(f: Populations, relaxation_time: f32, force: vec3<f32>, forced: bool, single: bool) -> Populations {
    let m = moments(f);
    let density = 1.0 + m.density_excess;
    let inverse_density = 1.0 / density;
    var momentum = m.momentum;
    var force_along_u = 0.0;
    if forced {
        momentum += 0.5 * force;
    }
    let u = momentum * inverse_density;
    if forced {
        force_along_u = dot(u, force);
    }
    var tau = relaxation_time;
    if EDDY {
        var normal = m.normal_stress - m.density_excess / 3.0 - density * u * u;
        var shear = m.shear_stress - density * vec3<f32>(u.x * u.y, u.x * u.z, u.y * u.z);
        if forced {
            normal += u * force;
            shear += symmetric_shear(u, force);
        }
        tau = eddy_relaxation_time(tau, normal, shear, inverse_density);
    }
    let even_rate = 1.0 / tau;
    var odd_rate = even_rate;
    if !single {
        odd_rate = 1.0 / (0.5 + TRT_MAGIC / (tau - 0.5));
    }
    let rest = m.density_excess - 1.5 * density * dot(u, u);
    let even_source = 1.0 - 0.5 * even_rate;
    let odd_source = 1.0 - 0.5 * odd_rate;

    var out: Populations;
    out[0] = f[0] - even_rate * (f[0] - rest / 3.0);
    if forced {
        out[0] -= even_source * force_along_u;
    }
    let terms = PairCommon(density, rest, even_rate, odd_rate, even_source, odd_source, force_along_u);
    var p: vec2<f32>;
    p = relax_pair(f[1], f[2], AXIS, u.x, force.x, terms, forced);
    out[1] = p.x; out[2] = p.y;
    p = relax_pair(f[3], f[4], AXIS, u.y, force.y, terms, forced);
    out[3] = p.x; out[4] = p.y;
    p = relax_pair(f[5], f[6], AXIS, u.z, force.z, terms, forced);
    out[5] = p.x; out[6] = p.y;
    p = relax_pair(f[7], f[8], DIAGONAL, u.x + u.y, force.x + force.y, terms, forced);
    out[7] = p.x; out[8] = p.y;
    p = relax_pair(f[9], f[10], DIAGONAL, u.x + u.z, force.x + force.z, terms, forced);
    out[9] = p.x; out[10] = p.y;
    p = relax_pair(f[11], f[12], DIAGONAL, u.y + u.z, force.y + force.z, terms, forced);
    out[11] = p.x; out[12] = p.y;
    p = relax_pair(f[13], f[14], DIAGONAL, u.x - u.y, force.x - force.y, terms, forced);
    out[13] = p.x; out[14] = p.y;
    p = relax_pair(f[15], f[16], DIAGONAL, u.x - u.z, force.x - force.z, terms, forced);
    out[15] = p.x; out[16] = p.y;
    p = relax_pair(f[17], f[18], DIAGONAL, u.y - u.z, force.y - force.z, terms, forced);
    out[17] = p.x; out[18] = p.y;
    return out;
}

struct PairCommon {
    density: f32,
    rest: f32,
    even_rate: f32,
    odd_rate: f32,
    even_source: f32,
    odd_source: f32,
    force_along_u: f32,
}

fn relax_pair(first: f32, second: f32, weight: f32, cu: f32, cf: f32, terms: PairCommon, forced: bool) -> vec2<f32> {
    let sum = first + second;
    let difference = first - second;
    let two_weights = weight + weight;
    let even_equilibrium = two_weights * (terms.rest + 4.5 * terms.density * cu * cu);
    let odd_equilibrium = two_weights * 3.0 * terms.density * cu;
    var even = sum - terms.even_rate * (sum - even_equilibrium);
    var odd = difference - terms.odd_rate * (difference - odd_equilibrium);
    if forced {
        even += terms.even_source * two_weights * (9.0 * cu * cf - 3.0 * terms.force_along_u);
        odd += terms.odd_source * two_weights * 3.0 * cf;
    }
    return vec2<f32>(0.5 * (even + odd), 0.5 * (even - odd));
}

// Square of the third-order moments that the recursion does not predict; the moments are bare, without any force.
fn residual_square(f: Populations, bare: vec3<f32>, density: f32, u: vec3<f32>, normal: vec3<f32>, shear: vec3<f32>) -> f32 {
    let isotropic = bare / 3.0;
    // Of orders xxy, xxz, yyz and yyx, zzx, zzy.
    let flux = density * vec3<f32>(u.x * u.y, u.x * u.z, u.y * u.z) + 2.0 * shear;
    let first = vec3<f32>(f[7] - f[8], f[9] - f[10], f[11] - f[12]);
    let second = vec3<f32>(f[13] - f[14], f[15] - f[16], f[17] - f[18]);
    let aab = first - second - isotropic.yzz - u.xxy * flux - u.yzz * normal.xxy;
    let bba = first + second - isotropic.xxy - u.yzz * flux - u.xxy * normal.yzz;
    return dot(aab, aab) + dot(bba, bba);
}

// Recursive regularisation; with viscosity from the residual where `stabilised` (always a literal).
fn regularise(f: Populations, relaxation_time: f32, force: vec3<f32>, forced: bool, stabilised: bool) -> Populations {
    let m = moments(f);
    let density = 1.0 + m.density_excess;
    let inverse_density = 1.0 / density;
    var momentum = m.momentum;
    // Momentum after the collision.
    var carried = m.momentum;
    if forced {
        momentum += 0.5 * force;
        carried += force;
    }
    let u = momentum * inverse_density;
    let uu = u * u;
    let u_shear = vec3<f32>(u.x * u.y, u.x * u.z, u.y * u.z);
    // Non-equilibrium stress.
    var normal = m.normal_stress - m.density_excess / 3.0 - density * uu;
    var shear = m.shear_stress - density * u_shear;
    var work_normal = vec3<f32>();
    var work_shear = vec3<f32>();
    if forced {
        work_normal = u * force;
        work_shear = symmetric_shear(u, force);
        normal += work_normal;
        shear += work_shear;
    }
    normal -= (normal.x + normal.y + normal.z) / 3.0;
    var tau = relaxation_time;
    if EDDY {
        tau = eddy_relaxation_time(tau, normal, shear, inverse_density);
    }
    if stabilised {
        let viscous = tau - 0.5;
        let square = residual_square(f, m.momentum, density, u, normal, shear);
        tau = 0.5 + sqrt(viscous * viscous + RESIDUAL_FACTOR * RESIDUAL_FACTOR * square);
    }
    let keep = 1.0 - 1.0 / tau;
    let kept_normal = keep * normal;
    let kept_shear = keep * shear;

    // Second-order Hermite coefficients.
    var q = density * uu + kept_normal;
    var r = density * u_shear + kept_shear;
    if forced {
        q += work_normal;
        r += work_shear;
    }
    return assembled(m.density_excess, carried, q, r, u, density * u_shear, kept_normal, kept_shear);
}

// Populations of third order with the momentum `carried` and the second-order Hermite coefficients q, r; those of third order are what the
// recursion has for the velocity, the momentum flux (xy, xz, yz) and a stress beyond equilibrium.
fn assembled(density_excess: f32, carried: vec3<f32>, q: vec3<f32>, r: vec3<f32>, u: vec3<f32>, flux: vec3<f32>,
    kept_normal: vec3<f32>, kept_shear: vec3<f32>) -> Populations {
    let xxy = u.x * (flux.x + 2.0 * kept_shear.x) + u.y * kept_normal.x;
    let xxz = u.x * (flux.y + 2.0 * kept_shear.y) + u.z * kept_normal.x;
    let yyx = u.y * (flux.x + 2.0 * kept_shear.x) + u.x * kept_normal.y;
    let yyz = u.y * (flux.z + 2.0 * kept_shear.z) + u.z * kept_normal.y;
    let zzx = u.z * (flux.y + 2.0 * kept_shear.y) + u.x * kept_normal.z;
    let zzy = u.z * (flux.z + 2.0 * kept_shear.z) + u.y * kept_normal.z;

    let base = density_excess - 1.5 * (q.x + q.y + q.z);
    var out: Populations;
    out[0] = base / 3.0;
    var p: vec2<f32>;
    p = pair(AXIS, base + 4.5 * q.x, 3.0 * carried.x - 9.0 * (yyx + zzx));
    out[1] = p.x; out[2] = p.y;
    p = pair(AXIS, base + 4.5 * q.y, 3.0 * carried.y - 9.0 * (xxy + zzy));
    out[3] = p.x; out[4] = p.y;
    p = pair(AXIS, base + 4.5 * q.z, 3.0 * carried.z - 9.0 * (xxz + yyz));
    out[5] = p.x; out[6] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.x + q.y + 2.0 * r.x), 3.0 * (carried.x + carried.y) + 9.0 * (xxy + yyx));
    out[7] = p.x; out[8] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.x + q.z + 2.0 * r.y), 3.0 * (carried.x + carried.z) + 9.0 * (xxz + zzx));
    out[9] = p.x; out[10] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.y + q.z + 2.0 * r.z), 3.0 * (carried.y + carried.z) + 9.0 * (yyz + zzy));
    out[11] = p.x; out[12] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.x + q.y - 2.0 * r.x), 3.0 * (carried.x - carried.y) + 9.0 * (yyx - xxy));
    out[13] = p.x; out[14] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.x + q.z - 2.0 * r.y), 3.0 * (carried.x - carried.z) + 9.0 * (zzx - xxz));
    out[15] = p.x; out[16] = p.y;
    p = pair(DIAGONAL, base + 4.5 * (q.y + q.z - 2.0 * r.z), 3.0 * (carried.y - carried.z) + 9.0 * (zzy - yyz));
    out[17] = p.x; out[18] = p.y;
    return out;
}

fn pair(weight: f32, even: f32, odd: f32) -> vec2<f32> {
    return vec2<f32>(weight * (even + odd), weight * (even - odd));
}
