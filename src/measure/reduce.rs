//! What becomes of columns: means, largest values, mean forces of impulses.

use super::read_out::{ReadOut, Reduction};
use super::record::Record;
use super::shared::TIME;
use super::statistics::{Mean, largest};
use crate::output::{Quantity, Results};

/// First sample of the second half of what was recorded after t = 0; `None` without any.
pub(super) fn second_half(times: &[f64]) -> Option<usize> {
    let first = times.iter().position(|&t| t > 0.0)?;
    Some(first.midpoint(times.len()))
}

/// First sample from the release on.
pub(super) fn released(times: &[f64]) -> usize {
    times.iter().position(|&t| t >= 0.0).unwrap_or(0)
}

/// A mean with its interval.
pub(super) fn quantity(mean: Mean) -> Quantity {
    let quantity = Quantity::new(mean.value);
    match mean.confidence {
        Some(confidence) => quantity.with_confidence(confidence),
        None => quantity,
    }
}

/// (time, value) of the largest entry from `first` on.
pub(super) fn column_max(record: &Record, column: &ReadOut, first: usize) -> (f64, f64) {
    let times = record.column(&TIME);
    let values = record.column(column).into_iter();
    values
        .zip(times)
        .skip(first)
        .fold((0.0, f64::NEG_INFINITY), |best, (value, time)| {
            if value > best.1 { (time, value) } else { best }
        })
}

/// Puts in what the reductions of columns of a canopy ask for: extremes from `first` on, means as `mean` finds them.
pub(super) fn reduce(
    results: &mut Results,
    record: &Record,
    columns: impl Iterator<Item = (&'static ReadOut, Reduction)>,
    first: usize,
    mean: impl Fn(&ReadOut) -> Quantity,
) {
    let of_extreme = |column: &ReadOut| {
        mean(column).with_note("mean over the window of the extreme over the fabric")
    };
    let largest_of = |column: &ReadOut| {
        let (time, value) = column_max(record, column, first);
        Quantity::new(value).with_note(&format!("largest of the run, at {time:.4} s"))
    };
    for (column, reduction) in columns {
        match reduction {
            Reduction::None | Reduction::Last | Reduction::Smallest | Reduction::LargestAs(_) => {}
            Reduction::Mean => results.insert(column, mean(column)),
            Reduction::Largest => results.insert(column, largest_of(column)),
            Reduction::LargestAndMean(steady) => {
                results.insert(column, largest_of(column));
                results.insert(&column.named(steady), of_extreme(column));
            }
            Reduction::SmallestAndMean(steady) => {
                let values = record.column(column);
                let lowest = values[first..]
                    .iter()
                    .copied()
                    .fold(f64::INFINITY, f64::min);
                let lowest = Quantity::new(lowest).with_note("smallest of the run");
                results.insert(column, lowest);
                results.insert(&column.named(steady), of_extreme(column));
            }
        }
    }
}

/// Mean forces between two samples, from columns of impulses [N].
pub(super) fn mean_forces_n<const N: usize>(
    record: &Record,
    impulses: [&ReadOut; N],
    [first, last]: [usize; 2],
) -> [f64; N] {
    let times = record.column(&TIME);
    let span_s = times[last] - times[first];
    impulses.map(|column| {
        let impulse = record.column(column);
        (impulse[last] - impulse[first]) / span_s
    })
}

/// Largest defect of the mass balance of the momentum box, of the samples that know it.
pub(super) fn mass_drift(defects: &[f64]) -> Quantity {
    let known: Vec<f64> = (defects.iter().copied())
        .filter(|defect| !defect.is_nan())
        .collect();
    if known.is_empty() {
        return Quantity::missing("the mass of the momentum box was not known in any sample");
    }
    Quantity::new(largest(known.into_iter().map(f64::abs)))
}
