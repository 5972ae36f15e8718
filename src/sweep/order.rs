//! Observed order of convergence over lattices, and the error that is left on the finest.
//!
//! Three lattices make an order p of f(h) = f₀ + C h^p: it solves (f₃ − f₂)/(f₂ − f₁) = (h₃^p − h₂^p)/(h₂^p − h₁^p), with h₁ the finest cell, which
//! is what the fixed-point iteration of Celik et al. (2008), "Procedure for estimation and reporting of uncertainty due to discretization in CFD
//! applications", J. Fluids Eng. 130, 078001, solves where convergence is monotone. The right side grows with p, so that halving an interval finds
//! it for any ratios of cells. The error is the grid convergence index of Roache (1994), J. Fluids Eng. 116, 405–413, as a half width.

/// Factor of safety of the grid convergence index on three lattices.
const SAFETY: f64 = 1.25;

/// Without an order the error is the spread of three lattices times this: the next lattice often lies outside of what three have shown. The filling
/// time of `cases/flat-circular-tunnel.toml` spreads over 1.8 ms at 12, 16 and 24 cells, and falls by another 2.4 ms at 32.
const BEYOND_SPREAD: f64 = 1.5;

/// Orders that are believed. Slower convergence says nothing of its limit; a faster one than that is a change of sign nearby.
const ORDERS: [f64; 2] = [0.5, 4.0];

/// Order of the lattice itself: a faster observed order does not make the error smaller than this one would.
const FORMAL_ORDER: f64 = 2.0;

/// Largest order looked for.
const HIGHEST_ORDER: f64 = 20.0;

/// Differences below this share of the value are round-off: the lattice does not enter.
pub(super) const SAME: f64 = 1e-6;

/// A value on one lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnLattice {
    /// Size of a cell, in any unit.
    pub cell: f64,
    /// The value.
    pub value: f64,
    /// Half width of its 95 % interval; `None` where it is not known.
    pub interval: Option<f64>,
}

/// What several lattices tell of a value.
#[derive(Debug, Clone, PartialEq)]
pub struct Convergence {
    /// Observed order of the three finest lattices; `None` where there is none.
    pub order: Option<f64>,
    /// What the value tends to with that order, if that is no farther from the finest lattice's value than the three lie apart.
    pub tends_to: Option<f64>,
    /// Error of the lattice on the finest one, a half width; `None` with a single lattice.
    pub error: Option<f64>,
    /// Where the error comes from, in a few words.
    pub basis: String,
}

/// Order, limit and error from values that are sorted from the coarsest lattice to the finest.
#[must_use]
pub fn convergence(values: &[OnLattice]) -> Convergence {
    let told = |error: Option<f64>, basis: &str| Convergence {
        order: None,
        tends_to: None,
        error,
        basis: basis.to_owned(),
    };
    let [coarse, middle, fine] = match values {
        [.., a, b, c] => [*a, *b, *c],
        [a, b] => return told(Some((a.value - b.value).abs()), "spread of two lattices"),
        _ => return told(None, "one lattice"),
    };
    let three = [coarse, middle, fine];
    let extreme =
        |pick: fn(f64, f64) -> f64, from: f64| three.iter().map(|on| on.value).fold(from, pick);
    let spread = extreme(f64::max, f64::NEG_INFINITY) - extreme(f64::min, f64::INFINITY);
    if spread <= SAME * fine.value.abs() {
        return told(Some(spread), "the same on all lattices");
    }
    let unordered = Some(BEYOND_SPREAD * spread);
    let [first, second] = [middle.value - coarse.value, fine.value - middle.value];
    let noise = |a: OnLattice, b: OnLattice| {
        let [a, b] = [a, b].map(|on| on.interval.unwrap_or(0.0));
        a.hypot(b)
    };
    if first.abs() <= noise(coarse, middle) || second.abs() <= noise(middle, fine) {
        return told(unordered, "no order: differences lie within the intervals");
    }
    if first * second <= 0.0 {
        return told(unordered, "no order: it swings");
    }
    let cells = three.map(|on| on.cell);
    match observed_order(cells, first / second) {
        None => told(unordered, "no order: differences do not shrink"),
        Some(order) if order < ORDERS[0] => Convergence {
            order: Some(order),
            ..told(
                unordered,
                &format!("order {order:.1} is too low to tell a limit"),
            )
        },
        Some(order) if order > ORDERS[1] => Convergence {
            order: Some(order),
            ..told(
                unordered,
                &format!("order {order:.1} is too high to be one"),
            )
        },
        Some(order) => {
            let ratio = middle.cell / fine.cell;
            let error = SAFETY * second.abs() / (ratio.powf(order.min(FORMAL_ORDER)) - 1.0);
            let beyond = second / (ratio.powf(order) - 1.0);
            Convergence {
                order: Some(order),
                tends_to: (beyond.abs() <= spread * (1.0 + SAME)).then_some(fine.value + beyond),
                error: Some(error),
                basis: format!("order {order:.1}"),
            }
        }
    }
}

/// The order with which differences between successive lattices, from coarse to fine, have the ratio `shrinks`; `None` if they grow faster than any
/// positive order lets them.
fn observed_order([coarse, middle, fine]: [f64; 3], shrinks: f64) -> Option<f64> {
    let [outer, inner] = [(coarse / middle).ln(), (middle / fine).ln()];
    // (h₃^p − h₂^p)/(h₂^p − h₁^p), which is the ratio of the logarithms at p = 0.
    let ratio = |p: f64| (outer * p).exp_m1() / -(-inner * p).exp_m1();
    let [mut low, mut high] = [0.0, HIGHEST_ORDER];
    if !(outer > 0.0 && inner > 0.0) || shrinks <= outer / inner {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < shrinks {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(cells: &[f64], value: impl Fn(f64) -> f64, interval: Option<f64>) -> Vec<OnLattice> {
        let own = |&n: &f64| OnLattice {
            cell: 1.0 / n,
            value: value(1.0 / n),
            interval,
        };
        cells.iter().map(own).collect()
    }

    #[test]
    fn order_and_limit_of_a_known_error_are_found_for_any_ratios() {
        for cells in [[8.0, 16.0, 32.0], [12.0, 16.0, 24.0], [10.0, 31.0, 37.0]] {
            for order in [0.6, 1.0, 1.7, 2.0, 3.3] {
                let found = convergence(&on(&cells, |h| 3.0 - 5.0 * h.powf(order), None));
                let own = found.order.unwrap();
                assert!((own - order).abs() < 1e-6, "{cells:?}, {order}: {own}");
                assert!(found.tends_to.is_some() || order < 1.0);
                let limit = found.tends_to.unwrap_or(3.0);
                assert!((limit - 3.0).abs() < 1e-6, "{cells:?}, {order}: {limit}");
                let own_error = 5.0 * (1.0 / cells[2]).powf(order);
                let error = found.error.unwrap();
                // Clipped at the lattice's own order, never below 1.25 times what is left.
                assert!(error > 1.2499 * own_error, "{cells:?}, {order}: {error}");
                if order <= 2.0 {
                    assert!((error / own_error - 1.25).abs() < 1e-6, "{order}: {error}");
                }
            }
        }
    }

    #[test]
    fn only_the_three_finest_count() {
        let mut values = on(&[8.0, 16.0, 32.0], |h| 1.0 + h, None);
        let alone = convergence(&values);
        values.insert(
            0,
            OnLattice {
                cell: 0.5,
                value: 77.0,
                interval: None,
            },
        );
        assert_eq!(convergence(&values), alone);
    }

    #[test]
    fn without_an_order_the_error_follows_from_the_spread() {
        let told = |values: [f64; 3], interval: Option<f64>| {
            let cells = [1.0 / 12.0, 1.0 / 16.0, 1.0 / 24.0];
            let values: Vec<OnLattice> = (cells.into_iter().zip(values))
                .map(|(cell, value)| OnLattice {
                    cell,
                    value,
                    interval,
                })
                .collect();
            convergence(&values)
        };
        let swings = told([14.1, 28.0, 18.2], None);
        assert_eq!((swings.order, swings.tends_to), (None, None));
        assert!((swings.error.unwrap() - 1.5 * 13.9).abs() < 1e-12);
        assert!(swings.basis.contains("swings"), "{}", swings.basis);
        let grows = told([1.0, 1.1, 1.4], None);
        assert!(grows.order.is_none() && grows.basis.contains("shrink"));
        assert!((grows.error.unwrap() - 1.5 * 0.4).abs() < 1e-12);
        // Order 0.2.
        let slow = told([12.0, 16.0, 24.0].map(|n: f64| 1.0 + n.powf(-0.2)), None);
        assert!(slow.tends_to.is_none() && slow.basis.contains("too low"));
        let fast = told([1.2, 1.001, 1.0], None);
        assert!(fast.tends_to.is_none() && fast.basis.contains("too high"));
        assert!((fast.error.unwrap() - 1.5 * 0.2).abs() < 1e-12);
        // Monotone, but within the noise.
        let noise = told([1.0, 1.1, 1.15], Some(0.2));
        assert!(noise.order.is_none() && noise.basis.contains("within the intervals"));
        assert!((noise.error.unwrap() - 1.5 * 0.15).abs() < 1e-12);
        assert!(told([1.0, 1.1, 1.15], Some(0.01)).order.is_some());
        // What lies farther off than anything that was seen is no limit.
        let far = [(16.0, 28.0), (24.0, 18.2), (32.0, 12.7)].map(|(n, value)| OnLattice {
            cell: 1.0 / n,
            value,
            interval: None,
        });
        let far = convergence(&far);
        assert!(far.order.is_some() && far.tends_to.is_none(), "{far:?}");
        assert!(far.error.unwrap() > 5.5);
        let same = told([0.2; 3], None);
        assert_eq!((same.error, same.order), (Some(0.0), None));
    }

    #[test]
    fn two_lattices_give_a_spread_and_one_nothing() {
        let two = convergence(&on(&[8.0, 16.0], |h| h, None));
        assert_eq!((two.error, two.order), (Some(0.0625), None));
        let one = convergence(&on(&[8.0], |h| h, None));
        assert_eq!((one.error, one.basis.as_str()), (None, "one lattice"));
        assert_eq!(convergence(&[]).error, None);
    }
}
