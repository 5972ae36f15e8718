//! Charts of histories, with the mean over the window that it was taken over.

use super::folder::{Finished, TIME, names};
use crate::measure::CHARTS;
use crate::output::{Chart, ReadOut, Series, with_interval};

/// One chart for each column that the runs have, as SVG; several runs are drawn over each other.
pub(super) fn charts(runs: &[Finished]) -> Vec<String> {
    CHARTS
        .iter()
        .filter_map(|column| chart(runs, column))
        .collect()
}

fn chart(runs: &[Finished], column: &ReadOut) -> Option<String> {
    let mut series = Vec::new();
    for (run, name) in runs.iter().zip(names(runs)) {
        let (Some(times), Some(values)) = (run.column(TIME), run.column(&column.name)) else {
            continue;
        };
        let points: Vec<[f64; 2]> = times.iter().zip(values).map(|(t, v)| [*t, *v]).collect();
        series.push(Series {
            name: if runs.len() > 1 { name } else { String::new() },
            points: thinned(&points),
            bars: Vec::new(),
            markers: false,
        });
        series.extend(mean(run, column, runs.len() > 1));
    }
    let chart = Chart {
        title: String::new(),
        labels: ["time since release [s]".to_owned(), column.label()],
        categories: Vec::new(),
        series,
    };
    chart.svg().map(|svg| scalable(&svg))
}

/// An SVG that fits the width that a page gives it: with a view box as large as it is drawn.
pub(super) fn scalable(svg: &str) -> String {
    let Some((head, rest)) = svg.split_once('>') else {
        return svg.to_owned();
    };
    let size = |name: &str| {
        let value = head.split_once(&format!(" {name}=\""))?.1;
        value.split_once('"').map(|(value, _)| value)
    };
    match (size("width"), size("height")) {
        (Some(width), Some(height)) if !head.contains("viewBox") => {
            format!("{head} viewBox=\"0 0 {width} {height}\">{rest}")
        }
        _ => svg.to_owned(),
    }
}

/// The mean of a column over the window of the run's means.
fn mean(run: &Finished, column: &ReadOut, named: bool) -> Option<Series> {
    let [first, last] = run.summary.averaging_window_s?;
    let found = run
        .summary
        .results
        .iter()
        .find(|(name, _)| *name == column.name);
    let (_, quantity) = found?;
    // The largest or last value of a column under its name is no mean.
    let is_mean = quantity.confidence.is_some();
    let value = quantity.value.filter(|_| is_mean)?;
    Some(Series {
        name: if named {
            String::new()
        } else {
            format!("mean {} over its window", with_interval(quantity))
        },
        points: vec![[first, value], [last, value]],
        bars: Vec::new(),
        markers: false,
    })
}

/// Most points of a curve.
const POINTS: usize = 2000;

/// A curve in few enough points for a page: of long ones the least and the largest value of every part, in order.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() <= POINTS {
        return points.to_vec();
    }
    let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
    let extremes = |part: &[[f64; 2]]| {
        let known = || part.iter().filter(|point| point[1].is_finite());
        let ends = [known().min_by(by_value), known().max_by(by_value)];
        let mut ends: Vec<[f64; 2]> = ends.into_iter().flatten().copied().collect();
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        ends
    };
    let parts = points.chunks(points.len().div_ceil(POINTS / 2));
    parts.flat_map(extremes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sample of a million stands out: it is drawn, and the page stays small.
    #[test]
    fn long_curves_keep_their_peaks() {
        let mut points: Vec<[f64; 2]> = (0..1_000_000)
            .map(|k| [k as f64, (k as f64 * 1e-3).sin()])
            .collect();
        points[123_456][1] = 9.0;
        points[654_321][1] = f64::NAN;
        let few = thinned(&points);
        assert!(few.len() <= POINTS);
        assert!(few.contains(&[123_456.0, 9.0]));
        assert!(few.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
        assert_eq!(thinned(&points[..50]), points[..50]);
    }

    #[test]
    fn charts_have_a_view_box_once() {
        let svg = "<svg a=\"b\" width=\"6.5\" height=\"4\"><rect width=\"1\"/></svg>";
        let scaled = scalable(svg);
        assert!(
            scaled
                .starts_with("<svg a=\"b\" width=\"6.5\" height=\"4\" viewBox=\"0 0 6.5 4\"><rect")
        );
        assert_eq!(scalable(&scaled), scaled);
    }
}
