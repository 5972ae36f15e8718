//! Plots of the schemes of coupling.

use std::path::Path;

use kuva::backend::png::PngBackend;
use kuva::prelude::{Figure, Layout, LinePlot, Plot, ScatterPlot};

use super::point::Point;
use super::scheme::{DEFAULT, LADDER};
use crate::bench::Stop;
use crate::bench::plots::{COLOURS, SCALE, SHAPES, position};
use crate::output::write_atomically;

fn write(
    path: &Path,
    panels: Vec<(Vec<Plot>, Layout)>,
    [rows, columns]: [usize; 2],
) -> Result<(), Stop> {
    let (plots, layouts) = panels.into_iter().unzip();
    let figure = Figure::new(rows, columns)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(520.0, 380.0)
        .with_shared_legend_bottom();
    let bytes = PngBackend::new()
        .with_scale(SCALE)
        .render_scene(&figure.render())
        .map_err(Stop::Plot)?;
    write_atomically(path, |out| out.write_all(&bytes))?;
    Ok(())
}

/// What marks a scheme beside its over-relaxation.
fn variation(point: &Point) -> String {
    if point.averaging_steps > 1 {
        "running mean of u*, k = 1".to_owned()
    } else if point.tolerance != DEFAULT.tolerance {
        "tolerance 0.1 or 0.001, k = 1".to_owned()
    } else if point.marker_spacing_cells != DEFAULT.marker_spacing_cells {
        "denser markers, k = 1".to_owned()
    } else {
        format!("k = {}", point.structure_every)
    }
}

/// A panel over the cost: one series per over-relaxation (colour) and variation (shape); those that none beats stand in rings.
fn panel(
    points: &[Point],
    title: &str,
    label: &str,
    pick: fn(&Point) -> f64,
) -> (Vec<Plot>, Layout) {
    let finite = || {
        points
            .iter()
            .filter(|p| pick(p).is_finite() && pick(p) > 0.0 && p.cost_ms() > 0.0)
    };
    let (mut strengths, mut variations) = (Vec::new(), Vec::new());
    let mut plots: Vec<Plot> = Vec::new();
    let rings: Vec<(f64, f64)> = finite()
        .filter(|p| p.unbeaten)
        .map(|p| (p.cost_ms(), 100.0 * pick(p)))
        .collect();
    plots.push(
        ScatterPlot::new()
            .with_data(rings)
            .with_color("#444444")
            .with_size(9.0)
            .with_marker_opacity(0.0)
            .with_marker_stroke_width(1.5)
            .with_legend("in rings: beaten by none in cost, slip and noise together")
            .into(),
    );
    for point in finite() {
        let colour = position(&mut strengths, point.over_relaxation.to_bits());
        let shape = position(&mut variations, variation(point));
        plots.push(
            ScatterPlot::new()
                .with_data([(point.cost_ms(), 100.0 * pick(point))])
                .with_color(COLOURS[colour % COLOURS.len()])
                .with_marker(SHAPES[shape % SHAPES.len()])
                .with_size(5.0)
                .with_legend(format!(
                    "a = {:.2}, {}",
                    point.over_relaxation,
                    variation(point)
                ))
                .into(),
        );
    }
    let layout = Layout::auto_from_plots(&plots)
        .with_log_scale()
        .with_title(title)
        .with_x_label("fabric and coupling [ms per step]")
        .with_y_label(label);
    (plots, layout)
}

/// Slip and noise of the schemes over their cost.
pub(super) fn schemes(path: &Path, points: &[Point]) -> Result<(), Stop> {
    if !points.iter().any(|p| p.slip > 0.0 && p.drag_noise > 0.0) {
        // Logarithmic axes need a point.
        return Ok(());
    }
    let panels = vec![
        panel(points, "Slip", "slip over the wind [%]", |p| p.slip),
        panel(
            points,
            "Noise of the drag",
            "change of the drag from step to step [%]",
            |p| p.drag_noise,
        ),
    ];
    write(path, panels, [1, 2])
}

/// Largest speed, slip and noise over the mass of the sheet; one line per k.
pub(super) fn light_canopies(path: &Path, points: &[Point]) -> Result<(), Stop> {
    type Pick = fn(&Point) -> f64;
    let shown: [(&str, &str, Pick); 3] = [
        ("Fastest node", "over the wind", |p| p.fastest),
        ("Slip", "over the wind [%]", |p| 100.0 * p.slip),
        ("Noise of the drag", "from step to step [%]", |p| {
            100.0 * p.drag_noise
        }),
    ];
    let mut panels = Vec::new();
    for (title, label, pick) in shown {
        let mut plots: Vec<Plot> = Vec::new();
        let mut largest: f64 = 0.0;
        for (i, every) in LADDER.into_iter().enumerate() {
            let line: Vec<(f64, f64)> = points
                .iter()
                .filter(|p| p.structure_every == every && pick(p).is_finite())
                .map(|p| (p.mass_ratio, pick(p)))
                .collect();
            largest = line.iter().map(|(_, y)| *y).fold(largest, f64::max);
            plots.push(
                LinePlot::new()
                    .with_data(line.clone())
                    .with_color(COLOURS[i])
                    .into(),
            );
            plots.push(
                ScatterPlot::new()
                    .with_data(line)
                    .with_color(COLOURS[i])
                    .with_marker(SHAPES[i])
                    .with_size(5.0)
                    .with_legend(format!("solved every {every}"))
                    .into(),
            );
        }
        if largest == 0.0 {
            // All broke down: the table says so.
            return Ok(());
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_log_x()
            .with_y_axis_min(0.0)
            .with_y_axis_max(1.1 * largest)
            .with_title(title)
            .with_x_label("mass of the sheet over that of the air in a cell")
            .with_y_label(label);
        panels.push((plots, layout));
    }
    write(path, panels, [1, 3])
}
