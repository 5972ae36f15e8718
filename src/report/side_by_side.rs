//! Results of several runs side by side.

use super::folder::Finished;
use crate::measure::headline;
use crate::output::Quantity;

/// One result of two or more runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Its name.
    pub name: String,
    /// SI unit, `1` for a plain number.
    pub unit: String,
    /// What each run found, in the order of the runs; `None` where it does not have it.
    pub values: Vec<Option<Quantity>>,
}

impl Difference {
    /// Relative difference of a run's value from that of the first; `None` where that is nothing, or cannot be told from it.
    #[must_use]
    pub fn relative(&self, run: usize) -> Option<f64> {
        let value = |run: usize| self.values.get(run)?.as_ref()?.value;
        let (first, other) = (value(0)?, value(run)?);
        let interval = self.values[0].as_ref()?.confidence.unwrap_or(0.0);
        (first.abs() > interval).then(|| (other - first) / first.abs())
    }

    /// Whether a run differs from the first by more than both intervals in quadrature; `None` without intervals, and where the set-up of either does not
    /// support the result: it has another error, which is not known.
    #[must_use]
    pub fn beyond_intervals(&self, run: usize) -> Option<bool> {
        let of = |run: usize| {
            let quantity = self.values.get(run)?.as_ref()?;
            let supported = quantity.unresolved.is_none();
            Some((quantity.value?, quantity.confidence.filter(|_| supported)?))
        };
        let ((first, a), (other, b)) = (of(0)?, of(run)?);
        Some((other - first).abs() > a.hypot(b))
    }
}

/// Results of the runs, those of the headline first, or alone.
#[must_use]
pub fn differences(runs: &[Finished], all: bool) -> Vec<Difference> {
    let mut names: Vec<&str> = Vec::new();
    for run in runs {
        for name in headline(run.summary.results.iter().map(|(name, _)| name)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    if all {
        for run in runs {
            for (name, _) in run.summary.results.iter() {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
    }
    let of = |run: &Finished, name: &str| {
        let found = run.summary.results.iter().find(|(known, _)| *known == name);
        found.map(|(_, quantity)| quantity.clone())
    };
    names
        .into_iter()
        .map(|name| {
            let values: Vec<Option<Quantity>> = runs.iter().map(|run| of(run, name)).collect();
            let unit = values
                .iter()
                .flatten()
                .next()
                .map_or("", |q| &q.unit)
                .to_owned();
            Difference {
                name: name.to_owned(),
                unit,
                values,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_count_beyond_both_intervals() {
        let of = |value: f64, half: f64| Some(Quantity::new(value).with_confidence(half));
        let row = |a, b| Difference {
            name: "drag_coefficient".to_owned(),
            unit: "1".to_owned(),
            values: vec![a, b],
        };
        let near = row(of(0.80, 0.03), of(0.84, 0.03));
        assert_eq!(near.beyond_intervals(1), Some(false));
        assert!((near.relative(1).unwrap() - 0.05).abs() < 1e-12);
        let far = row(of(0.80, 0.03), of(0.85, 0.03));
        assert_eq!(far.beyond_intervals(1), Some(true));
        assert_eq!(row(of(0.8, 0.1), None).relative(1), None);
        assert_eq!(row(of(1e-8, 3e-7), of(-1e-5, 3e-7)).relative(1), None);
        let mut unsupported = far;
        if let Some(Some(second)) = unsupported.values.get_mut(1) {
            second.mark_unresolved("two cells");
        }
        assert_eq!(unsupported.beyond_intervals(1), None);
        assert_eq!(
            row(Some(Quantity::new(1.0)), of(2.0, 0.1)).beyond_intervals(1),
            None
        );
    }
}
