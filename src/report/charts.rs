//! Charts of histories, with the mean over the window that it was taken over.

use super::folder::Finished;
use crate::measure::CHARTS;
use crate::output::{Chart, Quantity, ReadOut, Series};

/// One chart for each column that the runs have, as SVG; several runs are drawn over each other.
pub(super) fn charts(runs: &[Finished]) -> Vec<String> {
    CHARTS
        .iter()
        .filter_map(|column| chart(runs, column))
        .collect()
}

fn chart(runs: &[Finished], column: &ReadOut) -> Option<String> {
    let mut series = Vec::new();
    for run in runs {
        let (Some(times), Some(values)) = (run.column("time_s"), run.column(&column.name)) else {
            continue;
        };
        let points = times.iter().zip(values).map(|(t, v)| [*t, *v]).collect();
        series.push(Series {
            name: if runs.len() > 1 {
                run.name()
            } else {
                String::new()
            },
            points,
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
fn scalable(svg: &str) -> String {
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
            mean_name(value, quantity)
        },
        points: vec![[first, value], [last, value]],
        bars: Vec::new(),
        markers: false,
    })
}

fn mean_name(value: f64, quantity: &Quantity) -> String {
    let half = quantity.confidence.unwrap_or(0.0);
    format!("mean {value:.3} ± {half:.3} over its window")
}
