//! What left the cells that images are taken from, and the state of their air.

use glam::DVec3;

use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real};

/// Cells that an image is taken from.
pub(super) const CELLS_OF_AN_IMAGE: usize = 3;

/// Numbers of a state: density excess, momentum, flux of momentum beyond the pressure (xx, yy, zz, yz, xz, xy); the rest are zeros, for whole vectors.
const MOMENTS: usize = 12;

/// A cell as the air leaves it, in lattice units. A state fills whole cache lines: walls ask for cells in an order that is not that of memory.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
pub struct CellState<R> {
    moments: [R; MOMENTS],
    /// Shifted populations by direction.
    leaving: [R; DIRECTION_COUNT],
}

impl<R: Real> CellState<R> {
    /// Of shifted populations, by the direction in which they leave.
    #[must_use]
    pub fn new(leaving: [R; DIRECTION_COUNT]) -> Self {
        let mut moments = [0.0; MOMENTS];
        let [excess, momentum_and_flux @ ..] = &mut moments;
        let (momentum, flux) = momentum_and_flux.split_at_mut(3);
        *excess = leaving[0].to_f64();
        for pair in 0..DIRECTION_COUNT / 2 {
            let [there, back] = [1, 2].map(|k| leaving[2 * pair + k].to_f64());
            let (both, beyond) = (there + back, there - back);
            let c = DIRECTIONS[2 * pair + 1];
            *excess += both;
            for a in 0..3 {
                match c[a] {
                    0 => {}
                    sign => {
                        momentum[a] += f64::from(sign) * beyond;
                        flux[a] += both;
                    }
                }
                match c[(a + 1) % 3] * c[(a + 2) % 3] {
                    0 => {}
                    sign => flux[3 + a] += f64::from(sign) * both,
                }
            }
        }
        for diagonal in &mut flux[..3] {
            *diagonal -= *excess / 3.0;
        }
        Self {
            moments: moments.map(R::of),
            leaving,
        }
    }

    /// The shifted population that left in a direction.
    #[inline]
    #[must_use]
    pub fn leaving(&self, direction: usize) -> f64 {
        self.leaving[direction].to_f64()
    }

    /// Velocity of the air [cells per step].
    pub(super) fn velocity(&self) -> DVec3 {
        let air = Air::of(self.moments);
        air.momentum / air.density
    }
}

/// State of the air where an image lies, as it leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Air {
    pub(super) density: f64,
    pub(super) momentum: DVec3,
    /// Flux of momentum beyond the pressure: xx, yy, zz and yz, xz, xy.
    flux: [DVec3; 2],
}

impl Air {
    fn of<R: Real>(moments: [R; MOMENTS]) -> Self {
        let [excess, x, y, z, xx, yy, zz, yz, xz, xy, ..] = moments.map(R::to_f64);
        Self {
            density: 1.0 + excess,
            momentum: DVec3::new(x, y, z),
            flux: [DVec3::new(xx, yy, zz), DVec3::new(yz, xz, xy)],
        }
    }

    /// Between some cells, by their shares, whose sum is 1.
    #[inline]
    pub(super) fn between<R: Real>(
        shares: [f64; CELLS_OF_AN_IMAGE],
        cells: [&CellState<R>; CELLS_OF_AN_IMAGE],
    ) -> Self {
        let mut moments = [R::default(); MOMENTS];
        for (share, cell) in shares.into_iter().zip(cells) {
            let share = R::of(share);
            for (sum, moment) in moments.iter_mut().zip(cell.moments) {
                *sum += share * moment;
            }
        }
        Self::of(moments)
    }

    /// Flux of momentum across a plane.
    pub(super) fn flux(&self, normal: DVec3) -> DVec3 {
        let [diagonal, off] = self.flux;
        diagonal * normal
            + DVec3::new(
                off.z * normal.y + off.y * normal.z,
                off.z * normal.x + off.x * normal.z,
                off.y * normal.x + off.x * normal.y,
            )
    }
}

/// States of all cells that are asked for, in the precision of the air.
#[derive(Debug, Clone, Default)]
pub struct CellStates {
    single: Vec<CellState<f32>>,
    /// Empty where the air is in single precision.
    double: Vec<CellState<f64>>,
}

impl CellStates {
    /// Room for those of air in single precision.
    pub fn single(&mut self) -> &mut Vec<CellState<f32>> {
        self.double.clear();
        &mut self.single
    }

    /// Room for those of air in double precision.
    pub fn double(&mut self) -> &mut Vec<CellState<f64>> {
        self.single.clear();
        &mut self.double
    }

    /// Those in single precision, as a device has them; none in double precision.
    #[must_use]
    pub fn as_single(&self) -> &[CellState<f32>] {
        &self.single
    }

    /// Those in double precision; none in single precision.
    #[must_use]
    pub fn as_double(&self) -> &[CellState<f64>] {
        &self.double
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut_links::slide::vector;

    /// Moments are sums over populations, between cells by their shares; single precision is that of the populations.
    #[test]
    fn moments_are_those_of_the_populations() {
        let noise = |k: usize| ((k * 7919 % 1009) as f64 / 1009.0 - 0.5) * 0.02;
        let leaving = |cell: usize| -> [f64; DIRECTION_COUNT] {
            std::array::from_fn(|direction| noise(DIRECTION_COUNT * cell + direction))
        };
        let shares = [0.5, 0.3, 0.2];
        let double = [0, 1, 2].map(|cell| CellState::new(leaving(cell)));
        let single = [0, 1, 2].map(|cell| CellState::new(leaving(cell).map(|f| f as f32)));
        let of = |direction: usize| -> f64 {
            (0..3)
                .map(|k| shares[k] * double[k].leaving(direction))
                .sum()
        };
        let all = || (0..DIRECTION_COUNT).map(|direction| (vector(direction), of(direction)));
        let excess: f64 = all().map(|(_, f)| f).sum();
        let momentum: DVec3 = all().map(|(c, f)| c * f).sum();
        let normal = DVec3::new(0.48, -0.6, 0.64);
        let flux: DVec3 = all().map(|(c, f)| c * c.dot(normal) * f).sum();
        let flux = flux - normal * (excess / 3.0);
        let check = |air: Air, tolerance: f64| {
            assert!((air.density - 1.0 - excess).abs() < tolerance);
            assert!((air.momentum - momentum).length() < tolerance);
            assert!((air.flux(normal) - flux).length() < tolerance);
        };
        check(Air::between(shares, double.each_ref()), 1e-16);
        check(Air::between(shares, single.each_ref()), 1e-8);
    }
}
