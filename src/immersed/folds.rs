//! Kernels at faces of the box that a body passes through.
//!
//! A face lies half a cell beyond the last cell's centre. What of a kernel lies beyond it is folded back, axis by axis, so that a kernel
//! still is a product of three times four weights, of cells that all lie in the box:
//!
//! * at a side the weight of a cell beyond goes to that cell's mirror image; of the component along the face's normal it goes there with
//!   the opposite sign. Interpolation then reads u beyond the face as the image of u before it, and spreading adds the force of the
//!   marker's image: both are exactly those of a body and its image in a box twice as wide, and adjoint to each other;
//! * at the outlet the weight of a cell beyond goes to the last cell, of all components: the gradient along x is zero there.
//!
//! *A choice*: at a side to which the air sticks the components along the face keep their sign, too. The body rests, as the side does, so that
//! either sign aims at the same velocity; with this one the air gets the whole force along the face that the body feels, and Σ φ stays 1.

use super::kernel::{self, WIDTH};

/// The faces at which kernels are folded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Folds {
    /// Lower and upper side of y, then of z.
    pub sides: [[bool; 2]; 2],
    /// The upper end of x.
    pub outlet: bool,
}

/// What cells beyond the end of an axis stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fold {
    Image,
    LastCell,
}

/// A kernel along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisKernel {
    /// First of its four cells.
    pub first: i64,
    /// Weights of areas and of components along the other axes.
    pub weights: [f64; WIDTH],
    /// Weights of the component along this axis.
    pub normal: [f64; WIDTH],
}

impl Folds {
    /// True if kernels are folded at the lower and at the upper end of an axis.
    #[must_use]
    pub const fn at_ends(&self, axis: usize) -> [bool; 2] {
        match axis {
            0 => [false, self.outlet],
            1 => self.sides[0],
            _ => self.sides[1],
        }
    }

    fn fold(&self, axis: usize, upper: bool) -> Option<Fold> {
        let kind = if axis == 0 {
            Fold::LastCell
        } else {
            Fold::Image
        };
        self.at_ends(axis)[usize::from(upper)].then_some(kind)
    }

    /// The kernel of a marker at `position` along an axis of so many cells [cells, cell centres at whole numbers].
    #[must_use]
    pub fn on_axis(&self, axis: usize, position: f64, cells: usize) -> AxisKernel {
        let (first, plain) = kernel::weights(position);
        let begin = self.first(axis, first, cells);
        if begin == first {
            return AxisKernel {
                first,
                weights: plain,
                normal: plain,
            };
        }
        let cells = cells as i64;
        let (mut weights, mut normal) = ([0.0; WIDTH], [0.0; WIDTH]);
        for (i, weight) in plain.into_iter().enumerate() {
            let cell = first + i as i64;
            let outside = cell < 0 || cell >= cells;
            let (cell, sign) = match self.fold(axis, cell >= cells) {
                Some(Fold::Image) if cell < 0 => (-1 - cell, -1.0),
                Some(Fold::Image) if outside => (2 * cells - 1 - cell, -1.0),
                Some(Fold::LastCell) if outside => (cells - 1, 1.0),
                _ => (cell, 1.0),
            };
            let place = (cell - begin) as usize;
            weights[place] += weight;
            normal[place] += sign * weight;
        }
        AxisKernel {
            first: begin,
            weights,
            normal,
        }
    }

    /// First cell of the kernel that plainly begins at `first`, once it is folded.
    #[must_use]
    pub fn first(&self, axis: usize, first: i64, cells: usize) -> i64 {
        let [lower, upper] = self.at_ends(axis);
        let first = if lower { first.max(0) } else { first };
        if upper {
            first.min(cells as i64 - WIDTH as i64)
        } else {
            first
        }
    }

    /// How the kernel of a marker at `position` is folded, four bits an axis, as `shaders/folded_kernels.wgsl` reads it: 0 not; 1, 2 by so many cells
    /// at the lower side; 3, 4 by one or two at the upper side; 5, 6 by one or two at the outlet.
    #[must_use]
    pub fn code(&self, position: [f64; 3], cells: [usize; 3]) -> u32 {
        let mut code = 0;
        for axis in 0..3 {
            let first = position[axis].floor() as i64 - 1;
            let below = -first;
            let above = first + WIDTH as i64 - cells[axis] as i64;
            let own = if below > 0 && self.fold(axis, false).is_some() {
                below
            } else if above > 0 {
                match self.fold(axis, true) {
                    Some(Fold::Image) => 2 + above,
                    Some(Fold::LastCell) => 4 + above,
                    None => 0,
                }
            } else {
                0
            };
            code |= (own as u32) << (4 * axis);
        }
        code
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Folds = Folds {
        sides: [[true; 2]; 2],
        outlet: true,
    };

    /// At every place before a face the folded kernel reads a field beyond it as the image says, and keeps its sum.
    #[test]
    fn folded_kernels_see_the_image() {
        let cells = 9;
        let even = |x: f64| (0.7 * (x + 0.5)).cos();
        let odd = |x: f64| (0.7 * (x + 0.5)).sin();
        for k in 0..100 {
            let from_face = 0.02 * f64::from(k);
            for upper in [false, true] {
                let last = cells as f64 - 1.0;
                let turned = |x: f64| if upper { last - x } else { x };
                let position = turned(from_face - 0.5 + 1e-9);
                let (first, plain) = kernel::weights(position);
                let whole = |field: &dyn Fn(f64) -> f64| -> f64 {
                    let cell = |i: usize| (first + i as i64) as f64;
                    (0..WIDTH).map(|i| plain[i] * field(turned(cell(i)))).sum()
                };
                for axis in [1, 2] {
                    let folded = ALL.on_axis(axis, position, cells);
                    assert!(folded.first >= 0 && folded.first + 4 <= cells as i64);
                    let sum = |weights: [f64; WIDTH], field: &dyn Fn(f64) -> f64| -> f64 {
                        let cell = |i: usize| (folded.first + i as i64) as f64;
                        (0..WIDTH)
                            .map(|i| weights[i] * field(turned(cell(i))))
                            .sum()
                    };
                    assert!((sum(folded.weights, &even) - whole(&even)).abs() < 1e-14);
                    assert!((sum(folded.normal, &odd) - whole(&odd)).abs() < 1e-14);
                    assert!((folded.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                }
            }
            let position = 8.5 - from_face - 1e-9;
            let outlet = ALL.on_axis(0, position, cells);
            let (first, plain) = kernel::weights(position);
            let expected: f64 = (0..WIDTH)
                .map(|i| plain[i] * even(((first + i as i64) as f64).min(8.0)))
                .sum();
            let sum: f64 = (0..WIDTH)
                .map(|i| outlet.weights[i] * even((outlet.first + i as i64) as f64))
                .sum();
            assert!((sum - expected).abs() < 1e-14);
            assert_eq!(outlet.weights, outlet.normal);
        }
        // The inlet is no face to pass through, and far from all faces nothing is folded.
        assert_eq!(ALL.on_axis(0, 0.2, cells).first, -1);
        let (first, plain) = kernel::weights(4.3);
        let inside = ALL.on_axis(1, 4.3, cells);
        assert_eq!((inside.first, inside.weights), (first, plain));
    }

    #[test]
    fn codes_tell_the_fold() {
        let cells = [20, 10, 10];
        let code = |position| ALL.code(position, cells);
        assert_eq!(code([5.0, 5.0, 5.0]), 0);
        assert_eq!(code([5.0, 0.3, 5.0]), 1 << 4);
        assert_eq!(code([5.0, -0.3, 9.4]), 2 << 4 | 4 << 8);
        assert_eq!(code([18.2, 5.0, 8.9]), 5 | 3 << 8);
        assert_eq!(code([19.2, 5.0, 5.0]), 6);
    }
}
