//! Shear law of woven fabric that stiffens or softens with the load: 2ε₁₂ = τ/G + α τ³ (paper P3 of the documentation).
//!
//! Per width instead of per area: with T = h τ, 2ε₁₂ = T/(hG) + (α/h³) T³, in \[N/m\].

/// Cubic shear compliance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubicShear {
    /// 1/(hG) [m/N].
    pub compliance_m_n: f64,
    /// α/h³ [m³/N³]; positive.
    pub cubic_m3_n3: f64,
}

impl CubicShear {
    /// Shear tension [N/m] at an engineering shear strain 2ε₁₂: the one real root of the cubic.
    #[must_use]
    pub fn tension_n_m(&self, strain: f64) -> f64 {
        let (c, a) = (self.compliance_m_n, self.cubic_m3_n3);
        let argument = 1.5 * strain / c * (3.0 * a / c).sqrt();
        2.0 * (c / (3.0 * a)).sqrt() * (argument.asinh() / 3.0).sinh()
    }

    /// Energy per rest area [J/m²] at a shear tension: ∫T dγ = T²/(2hG) + ¾ (α/h³) T⁴.
    #[must_use]
    pub fn energy_j_m2(&self, tension_n_m: f64) -> f64 {
        let square = tension_n_m * tension_n_m;
        square * (0.5 * self.compliance_m_n + 0.75 * self.cubic_m3_n3 * square)
    }

    /// T/γ [N/m], at γ → 0 as well.
    #[must_use]
    pub fn secant_n_m(&self, strain: f64) -> f64 {
        let tension = self.tension_n_m(strain);
        1.0 / (self.compliance_m_n + self.cubic_m3_n3 * tension * tension)
    }

    /// dT/dγ [N/m].
    #[must_use]
    pub fn tangent_n_m(&self, strain: f64) -> f64 {
        self.tangent_at_n_m(self.tension_n_m(strain))
    }

    /// dT/dγ [N/m] at a tension.
    pub(super) fn tangent_at_n_m(&self, tension_n_m: f64) -> f64 {
        1.0 / (self.compliance_m_n + 3.0 * self.cubic_m3_n3 * tension_n_m * tension_n_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_solves_the_cubic_and_is_the_slope_of_the_energy() {
        for cubic_m3_n3 in [1e-16, 1e-10, 1e-6, 1e-2] {
            let law = CubicShear {
                compliance_m_n: 1e-3,
                cubic_m3_n3,
            };
            for strain in [-0.3, -1e-6, 0.0, 1e-9, 1e-3, 0.2] {
                let t = law.tension_n_m(strain);
                let back = 1e-3 * t + cubic_m3_n3 * t.powi(3);
                assert!(
                    (back - strain).abs() <= 1e-12 * strain.abs(),
                    "{back} {strain}"
                );
                let step = 1e-6;
                let [up, down] =
                    [strain + step, strain - step].map(|s| law.energy_j_m2(law.tension_n_m(s)));
                assert!(((up - down) / (2.0 * step) - t).abs() < 1e-4 * t.abs().max(1.0));
                let [up, down] = [strain + step, strain - step].map(|s| law.tension_n_m(s));
                let slope = (up - down) / (2.0 * step);
                assert!((slope / law.tangent_n_m(strain) - 1.0).abs() < 1e-3);
                assert!((law.secant_n_m(strain) * strain - t).abs() <= 1e-9 * t.abs());
            }
        }
    }
}
