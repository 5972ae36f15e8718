//! What passes between a lattice and one whose cells are half as large: density excess, momentum and rate of strain of a cell, ten numbers, read
//! off the populations that are about to be collided, and the populations that have them.
//!
//! With the velocity on the lattice alike on both, cells and steps half as long, τ_f − ½ = 2 (τ_c − ½), and a uniform acceleration half as large
//! per step. The rate of strain S = −3Π/(2ρτ_e) per own step is the flow's, whatever the relaxation time with all eddy viscosities is on either
//! side; a fine step is half as long, so that S_f = S_c/2. The momentum is the bare one, Σ f c: under an acceleration every level gains the same,
//! while ρu = Σ f c + F/2 differs by half a step.
//!
//! Populations are rebuilt as those that the recursion has for the stress Π = −(2/3) ρ τ_e S, third order included: the cell's own operator
//! collides them, so that force, sponge and eddy viscosity need no second formula, and the stabilised operator finds no residual. (Without the
//! third order it finds one at the interface, which costs 0.4 % of the error. Operators of second order have it rebuilt without the third.) *Source*: rescaling of the stress is Filippova & Hänel's (1998,
//! doi:10.1006/jcph.1998.6089); *our departure* is that pre-collision populations of whole cells are written, at times at which both levels
//! stand, and nothing is kept of the past.

use super::Number;
use super::operators::{self, Local, Populations};

/// Numbers of a state.
pub const STATE_NUMBERS: usize = 10;

/// Density excess, momentum Σ f c along x, y, z, rate of strain xx, yy, zz, xy, xz, yz [own lattice units].
pub type LevelState<N> = [N; STATE_NUMBERS];

/// Where the rate of strain begins in a state.
pub const FIRST_STRAIN: usize = 4;

/// A factor times a tensor. (A closure would not be compiled for the CPU's vectors.)
#[inline(always)]
fn times<N: Number>(factor: N, [xx, yy, zz, xy, xz, yz]: &[N; 6]) -> [N; 6] {
    [
        factor * *xx,
        factor * *yy,
        factor * *zz,
        factor * *xy,
        factor * *xz,
        factor * *yz,
    ]
}

/// State of a cell from its populations before a collision under `local`. Without an eddy viscosity its factor is 0, which leaves the relaxation time
/// as it is, to the bit.
#[inline(always)]
pub fn level_state<N: Number, const RESIDUAL: bool, const TRACELESS: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> LevelState<N> {
    let cell = operators::regularised::<N, true, true, RESIDUAL, TRACELESS>(f, local);
    let factor = cell.density_excess.constant(-1.5) * cell.inverse_density / cell.relaxation_time;
    let [xx, yy, zz, xy, xz, yz] = times(factor, &cell.stress);
    let [x, y, z] = cell.momentum;
    [cell.density_excess, x, y, z, xx, yy, zz, xy, xz, yz]
}

/// Populations before a collision under `local` that have a state.
#[inline(always)]
pub fn populations_of<N: Number, const RECURSIVE: bool>(
    state: &LevelState<N>,
    local: &Local<N>,
) -> Populations<N> {
    let [density_excess, x, y, z, strain @ ..] = *state;
    let constant = |value: f64| density_excess.constant(value);
    let one = constant(1.0);
    let density = one + density_excess;
    let momentum = [x, y, z];
    let half_force = operators::scale(constant(0.5), local.force);
    let j = operators::sum(momentum, half_force);
    let u = operators::scale(one / density, j);
    // Smagorinsky's 3 ν_t = 3 √2 C_s² |S|, with 18 √2 C_s² at hand.
    let [xx, yy, zz, xy, xz, yz] = strain;
    let normal = operators::dot([xx, yy, zz], [xx, yy, zz]);
    let shear = operators::dot([xy, xz, yz], [xy, xz, yz]);
    let norm = (normal + (shear + shear)).square_root();
    let eddy_factor = constant(1.0 / 6.0) * local.eddy_factor;
    let tau = local.relaxation_time.plus_product(eddy_factor, norm);
    let factor = constant(-2.0 / 3.0) * density * tau;
    let stress = times(factor, &strain);
    let flux = operators::flux(&j, &u);
    let work = operators::force_work(&u, &local.force);
    let mut second = operators::sum_of_tensors(&flux, &stress);
    for k in 0..6 {
        second[k] = second[k] - work[k];
    }
    // Operators without the recursion have equilibria of second order.
    let u = if RECURSIVE { u } else { [constant(0.0); 3] };
    operators::assembled(density_excess, &u, &flux, &stress, &second, momentum)
}

/// Lower and upper child of the middle one of three neighbouring cells: cell averages of the parabola that has theirs. Their mean is the middle
/// one, so that nothing is smeared where cells are averaged again.
#[inline(always)]
pub fn children<N: Number>([below, middle, above]: [N; 3]) -> [N; 2] {
    let slope = middle.constant(0.125) * (below - above);
    [middle + slope, middle - slope]
}

#[cfg(test)]
mod tests {
    use super::super::operators::eddy_factor;
    use super::*;

    /// Numbers without a pattern, from −½ to ½.
    fn numbers() -> impl FnMut() -> f64 {
        let mut seed = 7_u64;
        move || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        }
    }

    fn state(number: &mut impl FnMut() -> f64) -> LevelState<f64> {
        let mut state: LevelState<f64> = std::array::from_fn(|_| 0.1 * number());
        for strain in &mut state[FIRST_STRAIN..] {
            *strain *= 0.1;
        }
        state[6] = -state[4] - state[5];
        state
    }

    /// What is rebuilt has the state that it was rebuilt from, with every operator, eddy viscosity and force.
    #[test]
    fn populations_have_the_state_that_they_are_built_from() {
        let mut number = numbers();
        for _ in 0..200 {
            let state = state(&mut number);
            for smagorinsky in [0.0, 0.15] {
                let local = Local {
                    relaxation_time: 0.51,
                    force: std::array::from_fn(|_| 1e-3 * number()),
                    eddy_factor: eddy_factor(smagorinsky),
                };
                let f = populations_of::<f64, true>(&state, &local);
                let found = [
                    level_state::<f64, false, false>(&f, &local),
                    level_state::<f64, true, true>(&f, &local),
                ];
                for found in found {
                    for (a, b) in found.iter().zip(state) {
                        assert!((a - b).abs() < 1e-15, "{a} {b}");
                    }
                }
            }
        }
    }

    /// Restriction is the inverse of prolongation, and parabolas are met exactly.
    #[test]
    fn the_mean_of_the_children_is_the_cell() {
        let mut number = numbers();
        let (a, b, c) = (number(), number(), number());
        // Averages of a + b x + c x² over cells of length 1 about −1, 0, 1, and of ½ about ±¼.
        let average = |middle: f64, length: f64| {
            a + b * middle + c * (middle * middle + length * length / 12.0)
        };
        let found = children([-1.0, 0.0, 1.0].map(|x| average(x, 1.0)));
        for (found, x) in found.into_iter().zip([-0.25, 0.25]) {
            assert!((found - average(x, 0.5)).abs() < 1e-15);
        }
        let mean = 0.5 * (found[0] + found[1]);
        assert!((mean - average(0.0, 1.0)).abs() < 1e-16);
    }
}
