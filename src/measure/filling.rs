//! When a canopy is full: what of its opening does not depend on how it stands later.
//!
//! The filling ends where the projected area first reaches [`FULL_SHARE`] of its value at the first peak, between two samples along a straight
//! line. That share lies where the area grows fastest. On `cases/flat-circular-tunnel.toml` at 12 and 16 cells, halving the lattice speed moves
//! this time by −1.9 and +1.5 %, that of 90 % of the area by −2.8 and +3.2 %, and that of 95 % by −3.6 and +18 %, since the area there grows in two
//! steps. Waiting for the mean of the later diameter makes it +27 and +35 %.

/// Share of the projected area at its first peak at which the filling is over.
pub(super) const FULL_SHARE: f64 = 0.80;

/// Least projected diameter, over that of the same fabric laid flat, that a canopy counts as open with: folded ones have 0.1 to 0.3, full ones
/// 0.6 to 0.8.
const LEAST_OPEN: f64 = 0.5;

/// A peak is not exceeded while the air goes so many D₀ past the canopy: breathing takes about 1.8, the steps of an opening some 0.3.
const PEAK_SPAN: f64 = 0.5;

/// The filling of a canopy, or of its top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filling {
    /// Sample of the first peak of the projected diameter.
    pub peak: usize,
    /// When the projected area reached [`FULL_SHARE`] of that [s].
    pub time_s: f64,
}

/// Filling from the diameters of samples from release on, and the way of the air past the canopy until each, in D₀. That is not the time where a canopy
/// falls: it slows down, and a step of its opening takes longer. `None` before the first peak is over.
pub(super) fn filling(times_s: &[f64], diameters: &[f64], ways: &[f64]) -> Option<Filling> {
    let peak = first_peak(diameters, ways)?;
    let full = FULL_SHARE * diameters[peak].powi(2);
    let area = |i: usize| diameters[i].powi(2);
    let after = (0..=peak).find(|&i| area(i) >= full)?;
    let time_s = match after.checked_sub(1) {
        None => times_s[0],
        Some(before) => {
            let part = (full - area(before)) / (area(after) - area(before));
            times_s[before] + part * (times_s[after] - times_s[before])
        }
    };
    Some(Filling { peak, time_s })
}

/// First diameter of an open canopy that is not exceeded in the next [`PEAK_SPAN`], one sample at least. It depends on nothing that comes later.
fn first_peak(diameters: &[f64], ways: &[f64]) -> Option<usize> {
    (0..diameters.len()).find_map(|i| {
        if diameters[i] < LEAST_OPEN {
            return None;
        }
        let end = ways[i] + PEAK_SPAN;
        // Without one it is not known yet, neither of this diameter nor of a later one.
        let behind = (i + 1..ways.len()).find(|&k| ways[k] > end)?;
        let next = &diameters[i + 1..behind.max(i + 2)];
        next.iter().all(|&later| later <= diameters[i]).then_some(i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diameter that grows, stays a little, grows again to its first peak after 2 D₀/U, and breathes about `later` from there on.
    fn history(later: f64, interval: f64) -> (Vec<f64>, Vec<f64>) {
        let at = |time: f64| {
            if time < 1.6 {
                0.2 + 0.53 * (0.5 * std::f64::consts::PI * time / 1.6).sin()
            } else if time < 2.0 {
                0.73 + 0.05 * (time - 1.6) / 0.4
            } else {
                let over = (time - 2.0) / 1.8;
                let mean = 0.74 + (later - 0.74) * (0.5 * (over - 1.0)).clamp(0.0, 1.0);
                mean + 0.04 * (std::f64::consts::TAU * over).cos()
            }
        };
        let count = (30.0 / interval) as usize;
        let times = (0..count).map(|k| k as f64 * interval);
        times.map(|time| (time, at(time))).unzip()
    }

    #[test]
    fn what_comes_later_moves_nothing() {
        let filled = |later: f64| {
            let (times, diameters) = history(later, 0.03);
            filling(&times, &diameters, &times).unwrap()
        };
        let usual = filled(0.74);
        assert!((usual.peak as f64 * 0.03 - 2.0).abs() < 0.04, "{usual:?}");
        for later in [0.99 * 0.74, 1.01 * 0.74, 0.6, 0.9, 1.2] {
            let other = filled(later);
            assert_eq!(other.peak, usual.peak, "{later}");
            assert!((other.time_s - usual.time_s).abs() < 1e-12, "{later}");
        }
    }

    #[test]
    fn samples_are_joined_by_straight_lines() {
        // sqrt(0.8) · 0.78 is reached where the sine is 0.93913.
        let exact =
            1.6 * (2.0 / std::f64::consts::PI) * ((0.8_f64.sqrt() * 0.78 - 0.2) / 0.53).asin();
        for interval in [0.01, 0.03, 0.1] {
            let (times, diameters) = history(0.74, interval);
            let found = filling(&times, &diameters, &times).unwrap();
            assert!(
                (found.time_s - exact).abs() < 0.1 * interval,
                "{interval}: {} for {exact}",
                found.time_s
            );
        }
    }

    #[test]
    fn what_is_not_over_has_no_filling() {
        let (times, diameters) = history(0.74, 0.03);
        let until = |end: f64| {
            let end = (end / 0.03) as usize;
            filling(&times[..end], &diameters[..end], &times[..end])
        };
        assert_eq!(until(2.3), None);
        assert!(until(2.7).is_some());
        assert_eq!(filling(&times[..1], &diameters[..1], &times[..1]), None);
        // A canopy that never opens.
        let folded: Vec<f64> = diameters.iter().map(|d| 0.5 * d).collect();
        assert_eq!(filling(&times, &folded, &times), None);
        // One that is open from the start.
        let at = [0.0, 1.0, 2.0];
        let open = filling(&at, &[0.7, 0.69, 0.68], &at).unwrap();
        assert_eq!((open.peak, open.time_s), (0, 0.0));
    }

    /// A canopy that brakes as it falls stands at half its diameter for a while: in time for longer than a peak must last, on its way for less.
    #[test]
    fn a_step_of_an_opening_that_brakes_is_no_peak() {
        let times: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        // D₀ per unit of time, 1 at release and 0.4 after 0.5.
        let ways: Vec<f64> = (times.iter())
            .map(|t| t.min(0.5) - 0.6 * t.min(0.5).powi(2) + 0.4 * (t - 0.5).max(0.0))
            .collect();
        let diameters: Vec<f64> = (times.iter())
            .map(|t| match t {
                t if *t < 0.5 => 0.1 + 0.82 * t,
                t if *t < 1.3 => 0.51 - 0.01 * (t - 0.5),
                t if *t < 2.0 => 0.502 + 0.4 * (t - 1.3),
                t => 0.78 - 0.02 * (t - 2.0),
            })
            .collect();
        let at = |filling: Option<Filling>| filling.unwrap().peak;
        assert_eq!(at(filling(&times, &diameters, &ways)), 200);
        // As if the speed of release went on.
        assert_eq!(at(filling(&times, &diameters, &times)), 50);
    }
}
