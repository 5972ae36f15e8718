//! Plots of the benchmarks.

use std::path::Path;

use kuva::prelude::{Layout, LinePlot, MarkerShape, Plot, ScatterPlot};

use super::stability::describe;
use super::{Stop, work_precision};
use crate::lattice::stability::Point;
use crate::output::write_atomically;

/// Colours that differ also in grey and for colour-blind readers (Okabe & Ito).
const COLOURS: [&str; 8] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442",
];

/// Resolution of the pictures against the plot's own units.
const SCALE: f32 = 1.5;

fn write(path: &Path, plots: Vec<Plot>, layout: Layout) -> Result<(), Stop> {
    let bytes = kuva::render_to_png(plots, layout, SCALE).map_err(Stop::Plot)?;
    write_atomically(path, |out| out.write_all(&bytes))?;
    Ok(())
}

/// Error against seconds, one series per engine and operator, the front as a line.
pub(super) fn work_precision(
    path: &Path,
    name: &str,
    error: &str,
    points: &[work_precision::Point],
) -> Result<(), Stop> {
    let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for point in points.iter().filter(|p| p.error.is_finite()) {
        let label = format!("{}, {}", point.engine, point.operator.name());
        let place = (point.seconds, point.error);
        match series.iter_mut().find(|(known, _)| *known == label) {
            Some((_, data)) => data.push(place),
            None => series.push((label, vec![place])),
        }
    }
    let mut front: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| p.pareto)
        .map(|p| (p.seconds, p.error))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut plots: Vec<Plot> = vec![
        LinePlot::new()
            .with_data(front)
            .with_color("#888888")
            .with_legend("none beats these")
            .into(),
    ];
    for (i, (label, data)) in series.into_iter().enumerate() {
        let shape = if i % 2 == 0 {
            MarkerShape::Circle
        } else {
            MarkerShape::Triangle
        };
        plots.push(
            ScatterPlot::new()
                .with_data(data)
                .with_color(COLOURS[i % COLOURS.len()])
                .with_marker(shape)
                .with_size(4.0)
                .with_legend(label)
                .into(),
        );
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_log_scale()
        .with_title(name)
        .with_x_label("seconds")
        .with_y_label(error);
    write(path, plots, layout)
}

/// Largest Mach number survived at every angle, over τ − ½.
pub(super) fn stability(path: &Path, points: &[Point]) -> Result<(), Stop> {
    struct Series {
        operator: String,
        engines: Vec<String>,
        data: Vec<(f64, f64)>,
    }
    let mut series: Vec<Series> = Vec::new();
    for point in points {
        let operator = describe(point);
        let known = series
            .iter()
            .position(|s| s.operator == operator && s.engines == [point.engine.as_str()]);
        let index = known.unwrap_or_else(|| {
            series.push(Series {
                operator,
                engines: vec![point.engine.clone()],
                data: Vec::new(),
            });
            series.len() - 1
        });
        let data = &mut series[index].data;
        match data.iter_mut().find(|(tau, _)| *tau == point.viscous_part) {
            Some((_, mach)) => *mach = mach.min(point.mach),
            None => data.push((point.viscous_part, point.mach)),
        }
    }
    // Engines that agree share a line.
    let mut lines: Vec<Series> = Vec::new();
    for one in series {
        match lines
            .iter_mut()
            .find(|line| line.operator == one.operator && line.data == one.data)
        {
            Some(line) => line.engines.extend(one.engines),
            None => lines.push(one),
        }
    }
    let plots: Vec<Plot> = lines
        .into_iter()
        .enumerate()
        .map(|(i, line)| {
            // Lines that coincide must all be seen.
            let width = 8.0 - 1.5 * i as f64;
            LinePlot::new()
                .with_data(line.data)
                .with_color(COLOURS[i % COLOURS.len()])
                .with_stroke_width(width.max(1.5))
                .with_legend(format!("{} ({})", line.operator, line.engines.join(", ")))
                .into()
        })
        .collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_log_x()
        .with_title("Largest Mach number survived at every flow angle")
        .with_x_label("relaxation time - 1/2")
        .with_y_label("Mach number");
    write(path, plots, layout)
}
