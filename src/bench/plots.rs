//! Plots of the benchmarks.

use std::path::Path;

use kuva::prelude::{Layout, LinePlot, MarkerShape, Plot, ScatterPlot};

use super::{Stop, measurement};
use crate::lattice::stability::Point;
use crate::output::write_atomically;
pub(super) use crate::output::{COLOURS, SCALE};

pub(super) fn write(path: &Path, plots: Vec<Plot>, layout: Layout) -> Result<(), Stop> {
    let bytes = kuva::render_to_png(plots, layout, SCALE).map_err(Stop::Plot)?;
    write_atomically(path, |out| out.write_all(&bytes))?;
    Ok(())
}

/// Shapes that tell engines or schemes apart.
pub(super) const SHAPES: [MarkerShape; 7] = [
    MarkerShape::Circle,
    MarkerShape::Triangle,
    MarkerShape::Square,
    MarkerShape::Diamond,
    MarkerShape::Cross,
    MarkerShape::Plus,
    MarkerShape::Star,
];

/// Place of `entry` among the entries met so far.
pub(super) fn position<T: PartialEq>(known: &mut Vec<T>, entry: T) -> usize {
    known.iter().position(|e| *e == entry).unwrap_or_else(|| {
        known.push(entry);
        known.len() - 1
    })
}

/// Error against seconds: one series per engine (shape) and operator (colour); those that none beats stand in rings, joined by a line. Points
/// whose errors cancel by chance are hollow.
pub(super) fn work_precision(
    path: &Path,
    name: &str,
    error: &str,
    points: &[measurement::Point],
) -> Result<(), Stop> {
    let results = || points.iter().filter(|p| p.is_result());
    let title = if points.iter().any(|p| p.cancels) {
        format!("{name} (hollow: errors cancel by chance)")
    } else {
        name.to_owned()
    };
    let (mut engines, mut operators) = (Vec::new(), Vec::new());
    let mut series: Vec<(_, Vec<(f64, f64)>)> = Vec::new();
    for point in results() {
        let key = (
            point.cancels,
            position(&mut engines, point.engine.as_str()),
            position(&mut operators, point.operator.name()),
        );
        let place = (point.seconds, point.error);
        match series.iter_mut().find(|(known, _)| *known == key) {
            Some((_, data)) => data.push(place),
            None => series.push((key, vec![place])),
        }
    }
    series.sort_by_key(|(key, _)| *key);
    let mut front: Vec<(f64, f64)> = results()
        .filter(|p| p.pareto)
        .map(|p| (p.seconds, p.error))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    if front.is_empty() {
        // Logarithmic axes need a point.
        return Ok(());
    }
    let mut plots: Vec<Plot> = Vec::new();
    let spans = |value: f64, pick: fn(&measurement::Point) -> f64| {
        results().any(|p| pick(p) <= value) && results().any(|p| pick(p) >= value)
    };
    let (first, last) = results().fold((f64::INFINITY, 0.0_f64), |(first, last), p| {
        (first.min(p.seconds), last.max(p.seconds))
    });
    for limit in measurement::ERROR_LIMITS {
        if spans(limit, |p| p.error) {
            plots.push(
                LinePlot::new()
                    .with_data([(first, limit), (last, limit)])
                    .with_color("#888888")
                    .with_stroke_width(1.0)
                    .with_dashed()
                    .with_legend(format!("{:.0} %", 100.0 * limit))
                    .into(),
            );
        }
    }
    plots.push(
        LinePlot::new()
            .with_data(front.clone())
            .with_color("#444444")
            .with_legend("front: none is faster and better")
            .into(),
    );
    plots.push(
        ScatterPlot::new()
            .with_data(front)
            .with_color("#444444")
            .with_size(8.0)
            .with_marker_opacity(0.0)
            .with_marker_stroke_width(1.5)
            .into(),
    );
    for ((cancels, engine, operator), data) in series {
        let series = ScatterPlot::new()
            .with_data(data)
            .with_color(COLOURS[operator % COLOURS.len()])
            .with_marker(SHAPES[engine % SHAPES.len()])
            .with_size(4.0);
        let name = format!("{}, {}", engines[engine], operators[operator]);
        plots.push(if cancels {
            series
                .with_marker_opacity(0.0)
                .with_marker_stroke_width(1.0)
                .into()
        } else {
            series.with_legend(name).into()
        });
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_log_scale()
        .with_title(title)
        .with_x_label("time of the steps [s]")
        .with_y_label(error);
    write(path, plots, layout)
}

/// Largest Mach number survived at every angle and on every engine, over τ − ½; models of an operator that agree share a line.
pub(super) fn stability(path: &Path, points: &[Point]) -> Result<(), Stop> {
    struct Line {
        operator: &'static str,
        models: Vec<&'static str>,
        data: Vec<(f64, f64)>,
    }
    let mut single: Vec<Line> = Vec::new();
    for point in points {
        let operator = point.operator.name();
        let model = point.eddy_viscosity.map_or("none", |model| model.name());
        let known = single
            .iter()
            .position(|line| line.operator == operator && line.models == [model]);
        let index = known.unwrap_or_else(|| {
            single.push(Line {
                operator,
                models: vec![model],
                data: Vec::new(),
            });
            single.len() - 1
        });
        let data = &mut single[index].data;
        match data.iter_mut().find(|(tau, _)| *tau == point.viscous_part) {
            Some((_, mach)) => *mach = mach.min(point.mach),
            None => data.push((point.viscous_part, point.mach)),
        }
    }
    let mut lines: Vec<Line> = Vec::new();
    for one in single {
        let same = |line: &&mut Line| line.operator == one.operator && line.data == one.data;
        match lines.iter_mut().find(same) {
            Some(line) => line.models.extend(one.models),
            None => lines.push(one),
        }
    }
    let plots: Vec<Plot> = lines
        .into_iter()
        .enumerate()
        .map(|(i, line)| {
            // Lines that coincide must all be seen.
            let width = 8.0 - 1.2 * i as f64;
            LinePlot::new()
                .with_data(line.data)
                .with_color(COLOURS[i % COLOURS.len()])
                .with_stroke_width(width.max(1.5))
                .with_legend(format!("{} ({})", line.operator, line.models.join(", ")))
                .into()
        })
        .collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_log_x()
        .with_title("Largest Mach number survived, by operator (model of eddy viscosity)")
        .with_x_label("relaxation time - 1/2")
        .with_y_label("Mach number");
    write(path, plots, layout)
}
