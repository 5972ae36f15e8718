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
    let chart = Chart {
        title: String::new(),
        labels: ["time since release [s]".to_owned(), column.label()],
        categories: Vec::new(),
        series: curves(runs, column),
    };
    chart.svg().map(|svg| scalable(&svg))
}

/// The column of every run that has it, of each rigid body where bodies have it, each followed by its mean. Where there are several, both have the colour
/// of their owner, which is the same in all charts.
fn curves(runs: &[Finished], column: &ReadOut) -> Vec<Series> {
    let of_run = |(run, name): (_, String)| {
        let owners = Finished::owners(run).into_iter();
        owners.map(move |owner| (run, name.clone(), owner))
    };
    let owners: Vec<(&Finished, String, String)> =
        runs.iter().zip(names(runs)).flat_map(of_run).collect();
    let drawn: Vec<_> = (owners.iter().enumerate())
        .filter_map(|(number, (run, name, owner))| {
            let column = format!("{owner}{}", column.name);
            let samples = run.column(TIME).zip(run.column(&column))?;
            let of_body = owner.strip_suffix('_').map(str::to_owned);
            let name = match (runs.len() > 1, of_body) {
                (true, None) => name.clone(),
                (true, Some(body)) => format!("{name}, {body}"),
                (false, body) => body.unwrap_or_else(|| "fabric".to_owned()),
            };
            Some((number, *run, name, column, samples))
        })
        .collect();
    let several = drawn.len() > 1;
    let mut series = Vec::new();
    for (number, run, name, column, (times, values)) in drawn {
        let points: Vec<[f64; 2]> = times.iter().zip(values).map(|(t, v)| [*t, *v]).collect();
        let colour = several.then_some(number);
        series.push(Series {
            name: if several { name } else { String::new() },
            points: thinned(&points),
            bars: Vec::new(),
            markers: false,
            colour,
        });
        let mean = mean(run, &column, several);
        series.extend(mean.map(|mean| Series { colour, ..mean }));
    }
    series
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
fn mean(run: &Finished, column: &str, named: bool) -> Option<Series> {
    let [first, last] = run.summary.averaging_window_s?;
    let found = run.summary.results.iter().find(|(name, _)| *name == column);
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
        colour: None,
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
    use serde_json::json;

    use super::*;
    use crate::measure::shared::DRAG_COEFFICIENT;
    use crate::output::Summary;

    /// A run in a folder of that name, with a mean drag coefficient.
    fn run(name: &str, mean: f64) -> Finished {
        let summary = json!({
            "schema_version": 1, "ripstop_version": "", "engine": "cpu", "device": "", "precision": "f32", "threads": 1, "markers": 0,
            "nodes": 0, "triangles": 0, "steps": 1, "simulated_s": 1.0, "wall_s": 1.0, "milliseconds_per_step": {}, "skipped": [], "notes": [],
            "case": { "title": "", "file": "", "hash": "" },
            "stop": { "reason": "", "when_s": 1.0 },
            "averaging_window_s": [0.5, 1.0],
            "results": { "drag_coefficient": { "value": mean, "unit": "1", "confidence": 0.1 } },
        });
        let summary: Summary = serde_json::from_value(summary).unwrap();
        let column = |name: &str, samples: [f64; 3]| (name.to_owned(), samples.to_vec());
        Finished {
            folder: name.into(),
            summary,
            ledger: None,
            history: vec![
                column(TIME, [0.0, 0.5, 1.0]),
                column("drag_coefficient", [0.0, mean, mean]),
            ],
            pictures: Vec::new(),
        }
    }

    /// A mean has the colour of its run; a run without the column takes no other's colour.
    #[test]
    fn means_have_the_colours_of_their_runs() {
        let mut runs = [run("a", 0.7), run("b", 0.8), run("c", 0.9)];
        runs[1].history.pop();
        let curves = curves(&runs, &DRAG_COEFFICIENT);
        let drawn: Vec<(&str, Option<usize>)> = (curves.iter())
            .map(|series| (&series.name[..], series.colour))
            .collect();
        let expected = [("a", Some(0)), ("", Some(0)), ("c", Some(2)), ("", Some(2))];
        assert_eq!(drawn, expected);
        assert_eq!(curves[3].points, [[0.5, 0.9], [1.0, 0.9]]);
        // Drawn: two colours for four lines.
        let svg = chart(&runs, &DRAG_COEFFICIENT).unwrap();
        for (colour, is_there) in [("#0072B2", true), ("#009E73", true), ("#D55E00", false)] {
            let found = svg.to_uppercase().contains(&colour.to_uppercase());
            assert_eq!(found, is_there, "{colour}");
        }
        // Of one run the legend tells the mean by another colour.
        let alone = super::curves(&runs[..1], &DRAG_COEFFICIENT);
        assert!(alone.len() == 2 && alone.iter().all(|series| series.colour.is_none()));
    }

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
