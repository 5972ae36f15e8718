//! Stiffness constants of the mass–spring network (Lolies et al., paper P0; Provot 1995).
//!
//! A rectangular cell a_x × a_y with two springs along x, two along y and both diagonals stores, under uniform strain,
//! the energy of a plane-stress sheet with C12 = G if
//! k_x = C11 a_y/a_x − G a_x/a_y, k_y = C22 a_x/a_y − G a_y/a_x, k_d = G (a_x² + a_y²)/(2 a_x a_y).
//! k_x and k_y are the sums over the two parallel edges of the cell. Bending is the quadratic second difference
//! ½ (D/a²)|x₋ − 2x + x₊|² of square cells, scaled a_y/a_x³ for others.
//! *Departure from the paper*: constants per cell, not global, and bending by second differences, since springs over
//! two cells have no bending stiffness at first order.

use super::Fabric;

/// Spring stiffnesses of one rectangular cell [N/m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellStiffness {
    /// Both edges along x together.
    pub along_x: f64,
    /// Both edges along y together.
    pub along_y: f64,
    /// Each diagonal.
    pub diagonal: f64,
}

/// Stiffness of a cell of `size_m` (x along the warp); `None` if a spring would need a negative constant, which happens
/// for cells too elongated for their shear modulus.
#[must_use]
pub fn cell_stiffness(fabric: &Fabric, size_m: [f64; 2]) -> Option<CellStiffness> {
    let [ax, ay] = size_m;
    let stiffness = fabric.stiffness_n_m();
    let shear = stiffness[2][2];
    let cell = CellStiffness {
        along_x: stiffness[0][0] * ay / ax - shear * ax / ay,
        along_y: stiffness[1][1] * ax / ay - shear * ay / ax,
        diagonal: shear * (ax * ax + ay * ay) / (2.0 * ax * ay),
    };
    (cell.along_x > 0.0 && cell.along_y > 0.0).then_some(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform small strains must cost the continuum's energy (with C12 replaced by G), whatever the cell's shape.
    #[test]
    fn a_cell_stores_the_energy_of_the_sheet() {
        let fabric = Fabric {
            thickness_m: 1e-4,
            density_kg_m3: 500.0,
            warp_modulus_pa: 4e8,
            weft_modulus_pa: 3e8,
            poisson_ratio: 0.2,
            shear_modulus_pa: 1e8,
            residual_stiffness: 1e-3,
            cubic_shear_compliance_1_pa3: None,
            initial_strain: [0.0; 2],
            yield_stress_pa: None,
        };
        let c = fabric.stiffness_n_m();
        for size in [[0.01, 0.01], [0.01, 0.014], [0.012, 0.01]] {
            let [ax, ay] = size;
            let k = cell_stiffness(&fabric, size).unwrap();
            for (ex, ey, shear) in [
                (1e-6, 0.0, 0.0),
                (0.0, 1e-6, 0.0),
                (0.0, 0.0, 1e-6),
                (1e-6, 2e-6, 5e-7),
            ] {
                let energy = |spring: f64, dx: f64, dy: f64| {
                    let length = dx.hypot(dy);
                    let deformed = (dx * (1.0 + ex) + 0.5 * shear * dy)
                        .hypot(dy * (1.0 + ey) + 0.5 * shear * dx);
                    0.5 * spring * (deformed - length).powi(2)
                };
                let springs = energy(k.along_x, ax, 0.0)
                    + energy(k.along_y, 0.0, ay)
                    + energy(k.diagonal, ax, ay)
                    + energy(k.diagonal, ax, -ay);
                let g = c[2][2];
                let sheet = 0.5
                    * ax
                    * ay
                    * (c[0][0] * ex * ex
                        + c[1][1] * ey * ey
                        + 2.0 * g * ex * ey
                        + g * shear * shear);
                assert!(
                    (springs / sheet - 1.0).abs() < 1e-4,
                    "{size:?} {springs} {sheet}"
                );
            }
        }
    }
}
