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

use super::plane::{Matrix3, dot, smaller_direction, times};
use super::shear::CubicShear;
use super::wrinkles::wrinkle_direction;

/// Ready-to-use law of one fabric.
#[derive(Debug, Clone, Copy)]
pub struct Membrane {
    stiffness: Matrix3,
    residual: f64,
    isotropic: bool,
    shear: Option<CubicShear>,
}

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
    /// How much strain the wrinkles take up across their crests; zero unless wrinkled.
    pub wrinkle_strain: f64,
}

/// Principal values of a symmetric tensor, larger first.
#[must_use]
pub fn principal(xx: f64, yy: f64, xy: f64) -> [f64; 2] {
    let mean = 0.5 * (xx + yy);
    let half = 0.5 * (xx - yy);
    let radius = (half * half + xy * xy).sqrt();
    [mean + radius, mean - radius]
}

impl Membrane {
    /// Stiffness against stretching along warp or weft, the smaller of the two [N/m].
    #[must_use]
    pub fn stretching_stiffness_n_m(&self) -> f64 {
        self.stiffness[0][0].min(self.stiffness[1][1])
    }

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
                wrinkle_strain: 0.0,
            };
        }
        let taken: [f64; 3] = std::array::from_fn(|k| relaxed.strain[k] - strain[k]);
        let square = dot(&relaxed.across, &relaxed.across);
        let (relaxed_energy, relaxed_tension) = self.energy_and_tension(&relaxed.strain);
        let residual = self.residual;
        Response {
            energy: (1.0 - residual) * relaxed_energy + residual * energy,
            tension: std::array::from_fn(|k| {
                (1.0 - residual) * relaxed_tension[k] + residual * tension[k]
            }),
            state: relaxed.state,
            across: relaxed.across,
            wrinkle_strain: if square > 0.0 {
                dot(&relaxed.across, &taken) / square
            } else {
                0.0
            },
        }
    }

    /// What the residual stiffness adds to the tension at a strain: r times what relaxing takes away [N/m]; nothing where the sheet is taut.
    #[must_use]
    pub fn residual_tension(&self, strain: &[f64; 3]) -> [f64; 3] {
        let relaxed = self.relax(strain);
        if relaxed.state == FabricState::Taut {
            return [0.0; 3];
        }
        let (_, tension) = self.energy_and_tension(strain);
        let (_, left) = self.energy_and_tension(&relaxed.strain);
        std::array::from_fn(|k| self.residual * (tension[k] - left[k]))
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

    /// Tangent stiffness [N/m], the second derivative of the energy, which is convex: the full stiffness C where taut; where wrinkled,
    ///
    /// C − [Cη Cη′] M⁻¹ [Cη Cη′]ᵀ,  M = [η·Cη, η·Cη′; η·Cη′, η′·Cη′ + 2 t/β],
    ///
    /// which lets the wrinkles β η, η = n⊗n, grow and turn (η′ = dη/dθ) as the strain changes, t being the tension along their crests; plus the residual.
    /// At least a thousandth of C is kept, so that what is built on it stays regular.
    #[must_use]
    pub fn tangent(&self, strain: &[f64; 3], response: &Response) -> Matrix3 {
        let residual = self.residual.max(1e-3);
        let mut full = self.stiffness;
        if let Some(shear) = &self.shear {
            full[2][2] = shear.tangent_n_m(strain[2]);
        }
        let kept = full.map(|row| row.map(|k| residual * k));
        match response.state {
            FabricState::Taut => full,
            FabricState::Slack => kept,
            FabricState::Wrinkled => {
                let across = response.across;
                let size = response.wrinkle_strain;
                let relaxed: [f64; 3] = std::array::from_fn(|k| strain[k] + size * across[k]);
                if let Some(shear) = &self.shear {
                    full[2][2] = shear.tangent_n_m(relaxed[2]);
                }
                let (_, tension) = self.energy_and_tension(&relaxed);
                let [nn_x, nn_y, two_n] = across;
                let turned = [-two_n, two_n, 2.0 * (nn_x - nn_y)];
                let along = tension[0] * nn_y + tension[1] * nn_x - tension[2] * two_n;
                // Scaled such that M's second diagonal entry is 1.
                let pull = times(&full, &across);
                let turning = times(&full, &turned);
                let scale = (size
                    / (size * dot(&turned, &turning) + 2.0 * along.max(0.0))
                        .max(f64::MIN_POSITIVE))
                .max(0.0)
                .sqrt();
                let turning = turning.map(|k| scale * k);
                let (first, mixed) = (dot(&across, &pull), dot(&across, &turning));
                let determinant = first - mixed * mixed;
                if determinant <= 0.0 {
                    return kept;
                }
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        let lost = pull[i] * pull[j]
                            - mixed * (pull[i] * turning[j] + turning[i] * pull[j])
                            + first * turning[i] * turning[j];
                        (1.0 - residual) * (full[i][j] - lost / determinant) + kept[i][j]
                    })
                })
            }
        }
    }
}

#[cfg(test)]
#[path = "membrane_tests.rs"]
mod tests;
