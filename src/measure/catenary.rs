//! Exact catenary of an inextensible cable between level ends.

/// Exact equilibrium values of a hanging cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Catenary {
    /// Sag below the ends [m].
    pub sag_m: f64,
    /// Horizontal tension [N].
    pub horizontal_tension_n: f64,
    /// Tension at the ends [N].
    pub end_tension_n: f64,
}

/// Catenary of the given span, length and weight per length; `None` unless the cable is longer than the span.
#[must_use]
pub fn solve(span_m: f64, length_m: f64, weight_n_m: f64) -> Option<Catenary> {
    if !(length_m > span_m && span_m > 0.0 && weight_n_m > 0.0) {
        return None;
    }
    // sinh(q)/q = length/span with q = w span / (2 H).
    let ratio = length_m / span_m;
    let (mut low, mut high) = (1e-9, 1.0);
    while f64::sinh(high) / high < ratio {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f64::sinh(middle) / middle < ratio {
            low = middle
        } else {
            high = middle
        }
    }
    let q = 0.5 * (low + high);
    let horizontal_tension_n = 0.5 * weight_n_m * span_m / q;
    Some(Catenary {
        sag_m: horizontal_tension_n / weight_n_m * (q.cosh() - 1.0),
        horizontal_tension_n,
        end_tension_n: horizontal_tension_n * q.cosh(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table values for length/span = 1.2 (DESIGN C2): sag 0.29234, H 0.46954 w·span, end tension 0.76189 w·span.
    #[test]
    fn table_values() {
        let catenary = solve(1.0, 1.2, 1.0).unwrap();
        assert!((catenary.sag_m - 0.29234).abs() < 1e-5);
        assert!((catenary.horizontal_tension_n - 0.46954).abs() < 1e-5);
        assert!((catenary.end_tension_n - 0.76189).abs() < 1e-5);
    }
}
