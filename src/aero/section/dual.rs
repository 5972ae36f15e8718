//! Numbers that carry their derivatives: forward-mode differentiation (Griewank & Walther, Evaluating Derivatives, 2008, chapter 3).
//!
//! The boundary layers' equations are written once, with these; Newton's method then has their exact Jacobian. A number knows its derivatives by
//! the ten quantities of an interval, five at each end, and by one more, the place of transition inside.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Derivatives per number.
pub const WIDTH: usize = 11;

/// A value with derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// Value.
    pub value: f64,
    /// Derivatives.
    pub slopes: [f64; WIDTH],
}

impl Dual {
    /// A constant.
    pub const fn constant(value: f64) -> Self {
        Self {
            value,
            slopes: [0.0; WIDTH],
        }
    }

    /// The independent quantity with this index.
    pub const fn variable(value: f64, index: usize) -> Self {
        let mut slopes = [0.0; WIDTH];
        slopes[index] = 1.0;
        Self { value, slopes }
    }

    /// A function of this number, from its value and its derivative there.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            slopes: self.slopes.map(|s| s * slope),
        }
    }

    pub fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }

    pub fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }

    pub fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.chain(value, 1.0 - value * value)
    }

    pub fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, 0.5 / value)
    }

    pub fn powf(self, exponent: f64) -> Self {
        let value = self.value.powf(exponent);
        self.chain(value, exponent * value / self.value)
    }

    pub fn square(self) -> Self {
        self * self
    }

    /// The larger of two.
    pub fn max(self, other: Self) -> Self {
        if self.value >= other.value {
            self
        } else {
            other
        }
    }

    /// Not less than a constant.
    pub fn at_least(self, floor: f64) -> Self {
        self.max(Self::constant(floor))
    }

    /// Not more than a constant.
    pub fn at_most(self, ceiling: f64) -> Self {
        -((-self).at_least(-ceiling))
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slopes: std::array::from_fn(|k| self.slopes[k] + other.slopes[k]),
        }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            slopes: std::array::from_fn(|k| self.slopes[k] - other.slopes[k]),
        }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.value * other.value;
        // The product's rule.
        self.chain(product, other.value) + other.chain(0.0, self.value)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        Self {
            value,
            slopes: std::array::from_fn(|k| (self.slopes[k] - value * other.slopes[k]) * inverse),
        }
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self {
            value: self.value + other,
            ..self
        }
    }
}

impl Sub<f64> for Dual {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl Div<f64> for Dual {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        self * (1.0 / other)
    }
}

impl Add<Dual> for f64 {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        other + self
    }
}

impl Sub<Dual> for f64 {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        -other + self
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        other * self
    }
}

impl Div<Dual> for f64 {
    type Output = Dual;
    fn div(self, other: Dual) -> Dual {
        Dual::constant(self) / other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against central differences.
    #[test]
    fn derivatives_are_those_of_the_operations() {
        let all = |a: Dual, b: Dual| {
            let sum = (a + b - 0.5) * a / (b + 3.0) - b.ln() * a.exp() + (a - b).tanh();
            let more = (2.0 - a.sqrt()) * (1.0 + b.powf(1.7)) / 1.3 + (0.3 / a).square() - 2.0 * -b;
            sum + more + a.max(b) + a.at_least(0.1) * b.at_most(0.2)
        };
        for (x, y) in [(0.7, 1.9), (2.5, 0.4), (0.05, 0.1)] {
            let exact = all(Dual::variable(x, 0), Dual::variable(y, 10));
            let value = |x: f64, y: f64| all(Dual::constant(x), Dual::constant(y)).value;
            let h = 1e-6;
            let by_x = (value(x + h, y) - value(x - h, y)) / (2.0 * h);
            let by_y = (value(x, y + h) - value(x, y - h)) / (2.0 * h);
            assert!((exact.slopes[0] / by_x - 1.0).abs() < 1e-6, "{x} {y}");
            assert!((exact.slopes[10] / by_y - 1.0).abs() < 1e-6, "{x} {y}");
            assert!(exact.slopes[1..10].iter().all(|&s| s == 0.0));
        }
    }
}
