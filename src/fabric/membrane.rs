//! Membrane that carries tension only (tension field).
//!
//! W_relaxed(E) = min over P ⪰ 0 of W(E + P), with W = ½ E:C:E of St Venant–Kirchhoff (Pipkin 1986; Reissner 1938).
//! * taut if the stress C:E has no negative principal value;
//! * slack, W = 0, if the strain has no positive principal value;
//! * otherwise wrinkled: P = β n⊗n with β = −(n·σn)/(nn:C:nn), where n maximises the energy given up,
//!   ½ (n·σn)²/(nn:C:nn) over n·σn < 0. For isotropic sheets n is the smaller principal direction of the strain;
//!   for orthotropic ones it is searched in one variable, because the isotropic test is wrong for G ≪ E.
//!
//! A share `residual` of W itself is kept: W_total = (1 − r) W_relaxed + r W.
//!
//! With a nonlinear shear law ([`super::shear`]) the relaxed state is that of the linear sheet whose shear stiffness is the secant at
//! the relaxed strain: both meet the same conditions (no compression, P only where there is no tension). The secant is found iteratively.
//!
//! Strains are Green's, in Voigt form (xx, yy, 2·xy); tensions are second Piola–Kirchhoff times thickness [N/m].

/// How a piece of fabric carries its load.
pub use crate::frame::FabricState;

use std::f64::consts::PI;

use super::shear::CubicShear;

/// Symmetric 3×3 matrix in Voigt space.
pub type Matrix3 = [[f64; 3]; 3];

/// Ready-to-use law of one fabric.
#[derive(Debug, Clone, Copy)]
pub struct Membrane {
    stiffness: Matrix3,
    residual: f64,
    isotropic: bool,
    shear: Option<CubicShear>,
}

/// Iterations for the direction of wrinkles; five are usual, and halving alone takes forty.
const DIRECTION_LIMIT: usize = 50;

/// Rounding of tensions in a direction, over the tensions.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Shear stiffness over the smaller of warp and weft below which both sides of the warp are searched.
const NARROW: f64 = 0.05;

/// Iterations of Newton's method on wrinkles of a sheet with nonlinear shear, and the tension left across them, per tension.
const NEWTON_LIMIT: usize = 15;
const NEWTON_TOLERANCE: f64 = 1e-13;

/// Iterations of the secant shear stiffness, where that fails; four to eight reach the tolerance.
const SECANT_LIMIT: usize = 60;

/// Relative change of the secant at which it counts as found.
const SECANT_TOLERANCE: f64 = 1e-13;

/// Least and largest slope of the change of the secant's logarithm: −1 where the relaxed shear does not depend on the secant; the secant itself
/// falls with the shear's power 2/3 at most.
const SECANT_SLOPES: [f64; 2] = [-5.0 / 3.0, -1.0 / 3.0];

/// A strain without its wrinkles.
struct Relaxed {
    strain: [f64; 3],
    state: FabricState,
    /// See [`Response::across`].
    across: [f64; 3],
}

/// Response to a strain.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Energy per rest area [J/m²].
    pub energy: f64,
    /// Tension (xx, yy, xy) [N/m].
    pub tension: [f64; 3],
    /// Taut, wrinkled or slack.
    pub state: FabricState,
    /// n⊗n as a strain (xx, yy, 2·xy), n the unit vector across the wrinkles' crests; zero unless wrinkled.
    pub across: [f64; 3],
}

fn times(matrix: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Principal values of a symmetric tensor, larger first.
#[must_use]
pub fn principal(xx: f64, yy: f64, xy: f64) -> [f64; 2] {
    let mean = 0.5 * (xx + yy);
    let half = 0.5 * (xx - yy);
    let radius = (half * half + xy * xy).sqrt();
    [mean + radius, mean - radius]
}

/// n⊗n, as a strain, of the direction n of the smaller principal value.
fn smaller_direction(xx: f64, yy: f64, xy: f64) -> [f64; 3] {
    let half = 0.5 * (xx - yy);
    let radius = (half * half + xy * xy).sqrt();
    if radius == 0.0 {
        return [0.0, 1.0, 0.0];
    }
    // With 2θ the doubled angle of the larger direction, n⊗n = ½ (1 − cos 2θ, 1 + cos 2θ) and 2 n_x n_y = −sin 2θ.
    let (cosine, sine) = (half / radius, xy / radius);
    [0.5 * (1.0 - cosine), 0.5 * (1.0 + cosine), -sine]
}

impl Membrane {
    /// Law for a stiffness [N/m] (see [`super::Fabric::stiffness_n_m`]) and a residual share of compressive stiffness.
    #[must_use]
    pub fn new(stiffness: Matrix3, residual: f64) -> Self {
        let scale = stiffness[0][0].abs();
        let isotropic = (stiffness[0][0] - stiffness[1][1]).abs() < 1e-9 * scale
            && (stiffness[2][2] - 0.5 * (stiffness[0][0] - stiffness[0][1])).abs() < 1e-9 * scale;
        Self {
            stiffness,
            residual,
            isotropic,
            shear: None,
        }
    }

    /// The same sheet with a nonlinear shear law.
    #[must_use]
    pub const fn with_shear(mut self, shear: CubicShear) -> Self {
        self.isotropic = false;
        self.shear = Some(shear);
        self
    }

    /// Nonlinear shear law, if there is one.
    #[must_use]
    pub const fn shear(&self) -> Option<&CubicShear> {
        self.shear.as_ref()
    }

    /// Stiffness of the taut sheet [N/m].
    #[must_use]
    pub const fn stiffness(&self) -> &Matrix3 {
        &self.stiffness
    }

    /// Share of the compressive stiffness that is kept.
    #[must_use]
    pub const fn residual(&self) -> f64 {
        self.residual
    }

    /// True if all directions of the sheet are alike.
    #[must_use]
    pub const fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// Energy, tension and state at a strain (xx, yy, 2·xy).
    #[must_use]
    pub fn respond(&self, strain: &[f64; 3]) -> Response {
        let relaxed = self.relax(strain);
        let (energy, tension) = self.energy_and_tension(strain);
        if relaxed.state == FabricState::Taut {
            return Response {
                energy,
                tension,
                state: relaxed.state,
                across: relaxed.across,
            };
        }
        let (relaxed_energy, relaxed_tension) = self.energy_and_tension(&relaxed.strain);
        let residual = self.residual;
        Response {
            energy: (1.0 - residual) * relaxed_energy + residual * energy,
            tension: std::array::from_fn(|k| {
                (1.0 - residual) * relaxed_tension[k] + residual * tension[k]
            }),
            state: relaxed.state,
            across: relaxed.across,
        }
    }

    /// Tension of the sheet as it is, without wrinkles, and its tangent stiffness in shear.
    fn tension_and_shear_tangent(&self, shear: &CubicShear, strain: &[f64; 3]) -> ([f64; 3], f64) {
        let mut tension = times(&self.stiffness, strain);
        tension[2] = shear.tension_n_m(strain[2]);
        (tension, shear.tangent_at_n_m(tension[2]))
    }

    /// Energy per rest area and tension of the sheet as it is, without wrinkles.
    fn energy_and_tension(&self, strain: &[f64; 3]) -> (f64, [f64; 3]) {
        let mut tension = times(&self.stiffness, strain);
        let Some(shear) = &self.shear else {
            return (0.5 * dot(strain, &tension), tension);
        };
        tension[2] = shear.tension_n_m(strain[2]);
        let normal = 0.5 * (strain[0] * tension[0] + strain[1] * tension[1]);
        (normal + shear.energy_j_m2(tension[2]), tension)
    }

    fn relax(&self, strain: &[f64; 3]) -> Relaxed {
        let Some(shear) = &self.shear else {
            return self.relax_linear(&self.stiffness, strain);
        };
        let mut stiffness = self.stiffness;
        stiffness[2][2] = shear.secant_n_m(strain[2]);
        // Tension, and with it whether there are wrinkles, is that of this sheet; their place and size are not yet.
        let start = self.relax_linear(&stiffness, strain);
        if start.state != FabricState::Wrinkled {
            return start;
        }
        self.refine(shear, strain, &start)
            .unwrap_or_else(|| self.relax_by_secants(shear, strain))
    }

    /// Wrinkles β n⊗n of least energy W(E + β n⊗n), by Newton's method in β and the doubled angle of n; nothing if it does not converge.
    fn refine(&self, shear: &CubicShear, strain: &[f64; 3], start: &Relaxed) -> Option<Relaxed> {
        let mut angle = start.across[2].atan2(start.across[0] - start.across[1]);
        let mut size = dot(
            &start.across,
            &std::array::from_fn(|k| start.strain[k] - strain[k]),
        ) / dot(&start.across, &start.across);
        let mut stiffness = self.stiffness;
        for _ in 0..NEWTON_LIMIT {
            let (s, c) = angle.sin_cos();
            let across = [0.5 * (1.0 + c), 0.5 * (1.0 - c), s];
            let turning = [-0.5 * s, 0.5 * s, c];
            let relaxed = std::array::from_fn(|k| strain[k] + size * across[k]);
            let (tension, tangent) = self.tension_and_shear_tangent(shear, &relaxed);
            // n·σn and n·σm of the crests m: nothing pulls across crests, nor shears along them.
            let (pull, shearing) = (dot(&across, &tension), dot(&turning, &tension));
            let carried = tension[0].abs().max(tension[1].abs()).max(tension[2].abs());
            if pull.abs().max(shearing.abs()) <= NEWTON_TOLERANCE * carried {
                let is_wrinkle = size >= 0.0 && tension[0] + tension[1] >= 0.0;
                return is_wrinkle.then_some(Relaxed {
                    strain: relaxed,
                    state: FabricState::Wrinkled,
                    across,
                });
            }
            stiffness[2][2] = tangent;
            let along = times(&stiffness, &across);
            let around = times(&stiffness, &turning);
            let bend = -0.5 * c * (tension[0] - tension[1]) - s * tension[2];
            let (a, b) = (
                dot(&across, &along),
                shearing + size * dot(&across, &around),
            );
            let (d, e) = (dot(&turning, &along), bend + size * dot(&turning, &around));
            let determinant = a * e - b * d;
            if determinant <= 0.0 {
                return None;
            }
            size -= (pull * e - shearing * b) / determinant;
            angle -= (a * shearing - d * pull) / determinant;
        }
        None
    }

    /// The same as the relaxed state of the linear sheet whose shear stiffness is the secant at the relaxed strain: both meet the same
    /// conditions (no compression, wrinkles only where there is no tension).
    fn relax_by_secants(&self, shear: &CubicShear, strain: &[f64; 3]) -> Relaxed {
        let mut stiffness = self.stiffness;
        // The change h(s) of the logarithm s of the secant by one iteration falls with s; the root of h is found by the secant method.
        let mut logarithm = shear.secant_n_m(strain[2]).ln();
        let mut slope = -1.0;
        let mut before: Option<[f64; 2]> = None;
        for _ in 1..SECANT_LIMIT {
            stiffness[2][2] = logarithm.exp();
            let relaxed = self.relax_linear(&stiffness, strain);
            let change = shear.secant_n_m(relaxed.strain[2]).ln() - logarithm;
            if relaxed.state == FabricState::Slack || change.abs() <= SECANT_TOLERANCE {
                return relaxed;
            }
            if let Some([logarithm_before, change_before]) = before {
                let measured = (change - change_before) / (logarithm - logarithm_before);
                if measured.is_finite() {
                    slope = measured.clamp(SECANT_SLOPES[0], SECANT_SLOPES[1]);
                }
            }
            before = Some([logarithm, change]);
            logarithm -= change / slope;
        }
        stiffness[2][2] = logarithm.exp();
        self.relax_linear(&stiffness, strain)
    }

    /// The strain with its wrinkles taken out, for a linear sheet.
    fn relax_linear(&self, stiffness: &Matrix3, strain: &[f64; 3]) -> Relaxed {
        let tension = times(stiffness, strain);
        let [_, smaller_tension] = principal(tension[0], tension[1], tension[2]);
        if smaller_tension >= 0.0 {
            return Relaxed {
                strain: *strain,
                state: FabricState::Taut,
                across: [0.0; 3],
            };
        }
        let [larger_strain, _] = principal(strain[0], strain[1], 0.5 * strain[2]);
        if larger_strain <= 0.0 {
            return Relaxed {
                strain: [0.0; 3],
                state: FabricState::Slack,
                across: [0.0; 3],
            };
        }
        let guess = smaller_direction(strain[0], strain[1], 0.5 * strain[2]);
        let n = if self.isotropic {
            guess
        } else {
            wrinkle_direction(stiffness, &tension, &guess)
        };
        let stiffness_across = dot(&n, &times(stiffness, &n));
        let excess = (-dot(&n, &tension) / stiffness_across).max(0.0);
        Relaxed {
            strain: std::array::from_fn(|k| strain[k] + excess * n[k]),
            state: FabricState::Wrinkled,
            across: n,
        }
    }

    /// Positive semidefinite tangent stiffness [N/m] for preconditioning: the full stiffness where taut, the stiffness
    /// along the crests and against turning them where wrinkled, plus the residual.
    #[must_use]
    pub fn tangent(&self, strain: &[f64; 3], response: &Response) -> Matrix3 {
        // At least a thousandth, so that the preconditioner stays regular for fabric without residual stiffness.
        let residual = self.residual.max(1e-3);
        let mut tangent = self.stiffness;
        if let Some(shear) = &self.shear {
            tangent[2][2] = shear.tangent_n_m(strain[2]);
        }
        match response.state {
            FabricState::Taut => {}
            FabricState::Slack => tangent.iter_mut().flatten().for_each(|k| *k *= residual),
            FabricState::Wrinkled => {
                tangent.iter_mut().flatten().for_each(|k| *k *= residual);
                // (n_x², n_y², 2 n_x n_y) of the direction across the crests; the crests m are perpendicular.
                let [nn_x, nn_y, two_n] = response.across;
                // Functionals on Voigt strains: m·E·m, n·E·n, and twice the shear strain between m and n.
                let along = [nn_y, nn_x, -0.5 * two_n];
                let across = [nn_x, nn_y, 0.5 * two_n];
                let turn = [-two_n, two_n, nn_x - nn_y];
                let t = response.tension;
                let tension_along = (t[0] * nn_y + t[1] * nn_x - t[2] * two_n).max(0.0);
                let (strain_along, strain_across) = (dot(&along, strain), dot(&across, strain));
                let stiffness_along = if strain_along > 0.0 {
                    tension_along / strain_along
                } else {
                    0.0
                };
                let turning = 0.5 * tension_along / (strain_along - strain_across).max(1e-12);
                for i in 0..3 {
                    for j in 0..3 {
                        tangent[i][j] +=
                            stiffness_along * along[i] * along[j] + turning * turn[i] * turn[j];
                    }
                }
            }
        }
        tangent
    }
}

/// n⊗n of the direction n that maximises the energy given up by wrinkling, ½ t²/q with t = n·σn < 0 and q = nn:C:nn.
///
/// In the doubled angle φ, n⊗n = ½ (1 + cos φ, 1 − cos φ), 2 n_x n_y = sin φ, so both t and q are short trigonometric polynomials.
/// Newton's method on 2 t′q − t q′ = 0, kept inside a bracket, starts from the best of: directions of 30° in φ from `guess` on; that of the
/// most negative tension, without which a small compression may lie between all of them; and both bias directions, around which a sheet that is soft
/// in shear has narrow maxima. Such a sheet is searched from the best on either side of the warp, since a narrow maximum is higher than what is seen
/// beside it.
fn wrinkle_direction(stiffness: &Matrix3, tension: &[f64; 3], guess: &[f64; 3]) -> [f64; 3] {
    // cos and sin of 30° steps.
    const SQRT_3_2: f64 = 0.866_025_403_784_438_6;
    const STEPS: [[f64; 2]; 12] = [
        [1.0, 0.0],
        [SQRT_3_2, 0.5],
        [0.5, SQRT_3_2],
        [0.0, 1.0],
        [-0.5, SQRT_3_2],
        [-SQRT_3_2, 0.5],
        [-1.0, 0.0],
        [-SQRT_3_2, -0.5],
        [-0.5, -SQRT_3_2],
        [0.0, -1.0],
        [0.5, -SQRT_3_2],
        [SQRT_3_2, -0.5],
    ];
    const BIAS: [[f64; 2]; 2] = [[0.0, 1.0], [0.0, -1.0]];
    let gain = |c: f64, s: f64| {
        let n = dyad_of(c, s);
        let across = dot(&n, tension).min(0.0);
        across * across / dot(&n, &times(stiffness, &n))
    };
    let (start_c, start_s) = (guess[0] - guess[1], guess[2]);
    // The guess turned by multiples of 30°.
    let turned = STEPS.map(|[c, s]| [start_c * c - start_s * s, start_s * c + start_c * s]);
    let pushed = smaller_direction(tension[0], tension[1], tension[2]);
    let candidates = [[pushed[0] - pushed[1], pushed[2]]];
    let candidates = candidates.into_iter().chain(turned).chain(BIAS);
    // The best on either side of the warp.
    let mut best = [([0.0; 2], 0.0); 2];
    for candidate in candidates {
        let value = gain(candidate[0], candidate[1]);
        let side = &mut best[usize::from(candidate[1] < 0.0)];
        if value > side.1 {
            *side = (candidate, value);
        }
    }
    let [better, other] = if best[1].1 > best[0].1 {
        [best[1], best[0]]
    } else {
        best
    };
    let found = refined_direction(stiffness, tension, better.0);
    let is_soft = stiffness[2][2] < NARROW * stiffness[0][0].min(stiffness[1][1]);
    if is_soft && other.1 > 0.0 {
        let second = refined_direction(stiffness, tension, other.0);
        if gain(second[0], second[1]) > gain(found[0], found[1]) {
            return dyad_of(second[0], second[1]);
        }
    }
    dyad_of(found[0], found[1])
}

/// n⊗n, as a strain, of a unit vector at twice the angle of n.
const fn dyad_of(c: f64, s: f64) -> [f64; 3] {
    [0.5 * (1.0 + c), 0.5 * (1.0 - c), s]
}

/// The direction, as a unit vector at twice its angle, of the maximum next to one that gives up energy.
fn refined_direction(stiffness: &Matrix3, tension: &[f64; 3], start: [f64; 2]) -> [f64; 2] {
    let centre = start[1].atan2(start[0]);
    let rounding = ROUNDING * (tension[0].abs() + tension[1].abs() + tension[2].abs());
    let (mut low, mut high) = (centre - PI / 6.0, centre + PI / 6.0);
    let mut angle = centre;
    for _ in 0..DIRECTION_LIMIT {
        let (s, c) = angle.sin_cos();
        let (n, n1, n2) = (
            dyad_of(c, s),
            [-0.5 * s, 0.5 * s, c],
            [-0.5 * c, 0.5 * c, -s],
        );
        let (cn, cn1) = (times(stiffness, &n), times(stiffness, &n1));
        let (t, t1, t2) = (dot(&n, tension), dot(&n1, tension), dot(&n2, tension));
        let (q, q1) = (dot(&n, &cn), 2.0 * dot(&n1, &cn));
        let q2 = 2.0 * (dot(&n1, &cn1) + dot(&n2, &cn));
        // For t < 0 the gain rises while this is negative; where nothing pushes, the maximum lies towards the centre.
        let slope = 2.0 * t1 * q - t * q1;
        let curvature = 2.0 * t2 * q + t1 * q1 - t * q2;
        let is_before = if t < 0.0 { slope < 0.0 } else { angle < centre };
        if is_before {
            low = angle
        } else {
            high = angle
        }
        let newton = angle - slope / curvature;
        let next = if t < 0.0 && newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let moved = (next - angle).abs();
        if slope.abs() <= rounding * (2.0 * q + q1.abs()) {
            break;
        }
        angle = next;
        if moved < 1e-12 {
            break;
        }
    }
    [angle.cos(), angle.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n⊗n as a strain (xx, yy, 2·xy), for n at an angle from the warp.
    fn dyad(angle: f64) -> [f64; 3] {
        let (sine, cosine) = angle.sin_cos();
        [cosine * cosine, sine * sine, 2.0 * sine * cosine]
    }
    use crate::fabric::Fabric;

    fn fabric(shear_modulus_pa: f64, residual_stiffness: f64) -> Membrane {
        let fabric = Fabric {
            thickness_m: 1e-4,
            density_kg_m3: 533.77,
            warp_modulus_pa: 4.31e8,
            weft_modulus_pa: 4.31e8,
            poisson_ratio: 0.14,
            shear_modulus_pa,
            residual_stiffness,
            cubic_shear_compliance_1_pa3: None,
            initial_strain: [0.0; 2],
            yield_stress_pa: None,
        };
        Membrane::new(fabric.stiffness_n_m(), residual_stiffness)
    }

    /// Shear that softens: half as stiff at a few per cent.
    fn cubic(shear_modulus_pa: f64, residual_stiffness: f64) -> Membrane {
        let compliance_m_n = 1.0 / (1e-4 * shear_modulus_pa);
        fabric(shear_modulus_pa, residual_stiffness).with_shear(CubicShear {
            compliance_m_n,
            // As much again at 100 N/m.
            cubic_m3_n3: 1e-4 * compliance_m_n,
        })
    }

    fn isotropic_shear() -> f64 {
        Fabric::isotropic_shear_modulus_pa(4.31e8, 0.14)
    }

    /// Brute force over all positive semidefinite P = R(θ) diag(a, b) Rᵀ in a wide grid.
    fn brute_force(law: &Membrane, strain: &[f64; 3]) -> f64 {
        let mut best = f64::INFINITY;
        for k in 0..180 {
            let angle = PI * f64::from(k) / 180.0;
            let n = dyad(angle);
            let m = dyad(angle + 0.5 * PI);
            for i in 0..=60 {
                for j in 0..=20 {
                    let (a, b) = (f64::from(i) * 1e-3, f64::from(j) * 1e-3);
                    let e: [f64; 3] = std::array::from_fn(|q| strain[q] + a * n[q] + b * m[q]);
                    best = best.min(law.energy_and_tension(&e).0);
                }
            }
        }
        best
    }

    #[test]
    fn relaxed_energy_is_the_minimum_over_wrinkles() {
        let strains = [
            [0.01, 0.004, 0.003],
            [0.01, -0.02, 0.0],
            [0.01, -0.02, 0.02],
            [-0.01, -0.02, 0.002],
            [0.002, -0.001, 0.03],
        ];
        let laws = [
            fabric(isotropic_shear(), 0.0),
            fabric(3e6, 0.0),
            fabric(5e7, 0.0),
            cubic(5e7, 0.0),
        ];
        for law in laws {
            for strain in strains {
                let response = law.respond(&strain);
                let expected = brute_force(&law, &strain);
                // The grid of the search is 1e-3 of strain wide, so it can only be above, by little.
                assert!(
                    response.energy <= expected + 1e-9,
                    "{strain:?} {} {expected}",
                    response.energy
                );
                assert!(
                    expected - response.energy < 0.02,
                    "{strain:?} {} {expected}",
                    response.energy
                );
            }
        }
    }

    /// Strains in all directions and proportions.
    fn many_strains() -> impl Iterator<Item = [f64; 3]> {
        (0..3000).map(|k| {
            let wave = |n: f64| 0.02 * (n * f64::from(k)).sin();
            [wave(0.37), wave(1.31), 2.0 * wave(2.77)]
        })
    }

    /// What a wrinkled sheet carries is one tension along its crests: nothing across, no shear, from sheets that hardly resist shear to isotropic
    /// ones, and with shear that softens by any amount.
    #[test]
    fn wrinkled_fabric_carries_one_tension_along_its_crests() {
        let compliance_m_n = 1.0 / (1e-4 * 1.9e8);
        let softened = [1e-16, 1e-12, 1e-10, 1e-8, 1e-4].map(|cubic_m3_n3| {
            fabric(1.9e8, 0.0).with_shear(CubicShear {
                compliance_m_n,
                cubic_m3_n3,
            })
        });
        let linear = [isotropic_shear(), 1.8e8, 1e8, 5e7, 1e7, 1e6].map(|g| fabric(g, 0.0));
        for (number, law) in linear.into_iter().chain(softened).enumerate() {
            for strain in many_strains() {
                let response = law.respond(&strain);
                if response.state != FabricState::Wrinkled {
                    continue;
                }
                let t = response.tension;
                let [larger, smaller] = principal(t[0], t[1], t[2]);
                assert!(
                    smaller.abs() < 1e-6 * larger,
                    "law {number}, {strain:?}: {larger} N/m and {smaller} N/m"
                );
                let across = dot(&response.across, &t);
                assert!(across.abs() < 1e-6 * larger, "law {number}, {strain:?}");
            }
        }
    }

    /// No direction of wrinkles gives up more energy than the one taken.
    #[test]
    fn wrinkles_give_up_the_most_energy() {
        for law in [1.8e8, 1e8, 5e7, 1e7, 1e6].map(|g| fabric(g, 0.0)) {
            for strain in many_strains() {
                let response = law.respond(&strain);
                if response.state != FabricState::Wrinkled {
                    continue;
                }
                let tension = times(&law.stiffness, &strain);
                let whole = 0.5 * dot(&strain, &tension);
                for degree in 0..180 {
                    let n = dyad(PI * f64::from(degree) / 180.0);
                    let across = dot(&n, &tension).min(0.0);
                    let left = whole - 0.5 * across * across / dot(&n, &times(&law.stiffness, &n));
                    assert!(
                        response.energy <= left + 1e-12 * whole,
                        "{strain:?}: {} and {left} at {degree} degrees",
                        response.energy
                    );
                }
            }
        }
    }

    #[test]
    fn tension_is_the_gradient_of_the_energy_and_never_pushes() {
        for law in [
            fabric(isotropic_shear(), 0.1),
            fabric(1e7, 0.1),
            cubic(5e7, 0.1),
        ] {
            for strain in [
                [0.01, -0.02, 0.01],
                [0.01, 0.001, 0.002],
                [-0.01, -0.002, 0.001],
                [0.0, -0.003, 0.03],
            ] {
                let response = law.respond(&strain);
                for k in 0..3 {
                    let step = 1e-7;
                    let mut up = strain;
                    let mut down = strain;
                    up[k] += step;
                    down[k] -= step;
                    let slope =
                        (law.respond(&up).energy - law.respond(&down).energy) / (2.0 * step);
                    assert!(
                        (slope - response.tension[k]).abs() < 1e-3 * 4.31e4 * 0.03,
                        "{strain:?} {k} {slope} {:?}",
                        response.tension
                    );
                }
                let [_, smaller] = principal(
                    response.tension[0],
                    response.tension[1],
                    response.tension[2],
                );
                // Only the residual share of the compression may be left.
                assert!(smaller > -0.11 * 4.31e4 * 0.03, "{smaller}");
            }
        }
    }

    /// Wagner's shear panel (C6 of the design): pure shear γ leaves σ₁ = E γ/2 at 45°, so τ = σ₁/2.
    #[test]
    fn sheared_panel_carries_half_the_diagonal_tension() {
        let law = fabric(isotropic_shear(), 0.0);
        let shear = 0.01;
        let response = law.respond(&[0.0, 0.0, shear]);
        let diagonal = 4.31e4 * 0.5 * shear;
        assert!((response.tension[2] - 0.5 * diagonal).abs() < 1e-9 * diagonal);
    }

    /// Bias test (eq. 1 of paper P1): 1/E45 = 1/4 (1/E1 + 1/E2 − 2 ν/E1 + 1/G).
    #[test]
    fn bias_modulus_follows_the_shear_modulus() {
        let law = fabric(1e7, 0.0);
        let (e, nu, g) = (4.31e8, 0.14, 1e7);
        let expected = 4.0 / (2.0 / e - 2.0 * nu / e + 1.0 / g);
        // Uniaxial tension at 45°: find the strain by inverting the stiffness for tension T (1, 1, 1)/2.
        let t = 100.0;
        let k = law.stiffness;
        let normal = 0.5 * t / (k[0][0] + k[0][1]);
        let shear = 0.5 * t / k[2][2];
        let along = 0.5 * (normal + normal) + 0.5 * shear;
        let modulus = t / along / 1e-4;
        assert!(
            (modulus / expected - 1.0).abs() < 1e-3,
            "{modulus} {expected}"
        );
        assert!((modulus - 38.5e6).abs() < 0.1e6);
        assert_eq!(
            law.respond(&[normal, normal, shear]).state,
            FabricState::Taut
        );
    }
}
