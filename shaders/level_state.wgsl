// What passes between a lattice and one whose cells are half as large (src/lattice/level_state.rs: scheme and sources there).

struct LevelState {
    density_excess: f32,
    // Sum of f c, without F/2.
    momentum: vec3<f32>,
    // Rate of strain per own step: xx, yy, zz, and xy, xz, yz.
    normal: vec3<f32>,
    shear: vec3<f32>,
}

fn is_recursive() -> bool {
    return OPERATOR == RECURSIVE_REGULARISED || OPERATOR == STABILISED_REGULARISED;
}

// `relaxation_time`: of the cell, without what its collision evaluates itself.
fn level_state(f: Populations, force: vec3<f32>, relaxation_time: f32) -> LevelState {
    let m = moments(f);
    let density = 1.0 + m.density_excess;
    let u = (m.momentum + 0.5 * force) / density;
    var normal = m.normal_stress - m.density_excess / 3.0 - density * u * u + u * force;
    let shear = m.shear_stress - density * vec3<f32>(u.x * u.y, u.x * u.z, u.y * u.z) + symmetric_shear(u, force);
    if is_recursive() {
        normal -= (normal.x + normal.y + normal.z) / 3.0;
    }
    var tau = relaxation_time;
    if EDDY {
        tau = eddy_relaxation_time(tau, normal, shear, 1.0 / density);
    }
    if OPERATOR == STABILISED_REGULARISED {
        let viscous = tau - 0.5;
        let square = residual_square(f, m.momentum, density, u, normal, shear);
        tau = 0.5 + sqrt(viscous * viscous + RESIDUAL_FACTOR * RESIDUAL_FACTOR * square);
    }
    let factor = -1.5 / (density * tau);
    return LevelState(m.density_excess, m.momentum, factor * normal, factor * shear);
}

fn populations_with(state: LevelState, force: vec3<f32>, relaxation_time: f32) -> Populations {
    let density = 1.0 + state.density_excess;
    let u = (state.momentum + 0.5 * force) / density;
    var tau = relaxation_time;
    if EDDY {
        tau += EDDY_FACTOR / 6.0 * sqrt(dot(state.normal, state.normal) + 2.0 * dot(state.shear, state.shear));
    }
    let factor = -2.0 / 3.0 * density * tau;
    let kept_normal = factor * state.normal;
    let kept_shear = factor * state.shear;
    let flux = density * vec3<f32>(u.x * u.y, u.x * u.z, u.y * u.z);
    let q = density * u * u + kept_normal - u * force;
    let r = flux + kept_shear - symmetric_shear(u, force);
    // Operators without the recursion have equilibria of second order.
    var third = u;
    if !is_recursive() {
        third = vec3<f32>();
    }
    return assembled(state.density_excess, state.momentum, q, r, third, flux, kept_normal, kept_shear);
}
