//! Charts of lines and points, as SVG and PNG.

use std::io;
use std::path::Path;

use kuva::prelude::{Layout, LinePlot, Plot, ScatterPlot};

use super::atomic::{OutputError, write_atomically};
use super::provenance::Provenance;

/// Colours that differ also in grey and for colour-blind readers (Okabe & Ito).
pub(crate) const COLOURS: [&str; 8] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442",
];

/// Resolution of PNG files against the chart's own units.
pub(crate) const SCALE: f32 = 1.5;

/// Largest over smallest x of markers from which the axis is logarithmic.
const WIDE: f64 = 30.0;

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend calls it; empty: nothing.
    pub name: String,
    /// Points; those that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// Half lengths of vertical bars, one for each point; empty without bars.
    pub bars: Vec<f64>,
    /// Points with a marker each, joined by a thin line, rather than a line alone.
    pub markers: bool,
    /// Number of its colour; by its place among all series if absent.
    pub colour: Option<usize>,
}

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Above it.
    pub title: String,
    /// Name and unit of the axes, x first.
    pub labels: [String; 2],
    /// Names at x = 1, 2, … in place of numbers; empty: numbers. Markers over more than one and a half decades get a logarithmic axis.
    pub categories: Vec<String>,
    /// What it shows.
    pub series: Vec<Series>,
}

impl Chart {
    fn parts(&self) -> Option<(Vec<Plot>, Layout)> {
        let mut plots: Vec<Plot> = Vec::new();
        for (number, series) in self.series.iter().enumerate() {
            let colour = COLOURS[series.colour.unwrap_or(number) % COLOURS.len()];
            let finite = |p: &[f64; 2]| p.iter().all(|v| v.is_finite());
            let points: Vec<(f64, f64)> = (series.points.iter())
                .filter(|p| finite(p))
                .map(|p| (p[0], p[1]))
                .collect();
            if points.is_empty() {
                continue;
            }
            let mut line = LinePlot::new()
                .with_data(points.clone())
                .with_color(colour)
                .with_stroke_width(if series.markers { 0.8 } else { 1.8 });
            if !series.name.is_empty() {
                line = line.with_legend(series.name.clone());
            }
            // Between rows, or other things with names, lies nothing; a legend needs the line.
            if self.categories.is_empty() || !series.name.is_empty() {
                plots.push(line.into());
            }
            if series.markers {
                let mut markers = ScatterPlot::new()
                    .with_data(points)
                    .with_color(colour)
                    .with_size(4.0);
                if !series.bars.is_empty() {
                    let pairs = series.points.iter().zip(&series.bars);
                    let bars = pairs.filter(|(p, _)| finite(p)).map(|(_, bar)| *bar);
                    markers = markers.with_y_err(bars);
                }
                plots.push(markers.into());
            }
        }
        if plots.is_empty() {
            return None;
        }
        let mut layout = Layout::auto_from_plots(&plots)
            .with_title(self.title.clone())
            .with_x_label(self.labels[0].clone())
            .with_y_label(self.labels[1].clone());
        if !self.categories.is_empty() {
            layout = layout.with_x_categories(self.categories.clone());
        } else if self.is_wide() {
            layout = layout.with_log_x();
        }
        Some((plots, layout))
    }

    fn is_wide(&self) -> bool {
        let points = self.series.iter().flat_map(|series| &series.points);
        let places = || points.clone().map(|p| p[0]).filter(|x| x.is_finite());
        let least = places().fold(f64::INFINITY, f64::min);
        let most = places().fold(0.0, f64::max);
        self.series.iter().all(|series| series.markers) && least > 0.0 && most >= WIDE * least
    }

    /// The chart as SVG; `None` where there is no point to show.
    #[must_use]
    pub fn svg(&self) -> Option<String> {
        let (plots, layout) = self.parts()?;
        Some(kuva::render_to_svg(plots, layout))
    }

    /// Writes `PATH.svg` and `PATH.png`, each whole or not at all and with where it is from; nothing where there is no point to show, and then `false`.
    ///
    /// # Errors
    ///
    /// When a file cannot be drawn or written.
    pub fn write(&self, path: &Path, provenance: &Provenance) -> Result<bool, OutputError> {
        let (Some(for_svg), Some((plots, layout))) = (self.parts(), self.parts()) else {
            return Ok(false);
        };
        let svg = provenance.put_into_svg(&kuva::render_to_svg(for_svg.0, for_svg.1));
        write_atomically(&path.with_extension("svg"), |out| {
            out.write_all(svg.as_bytes())
        })?;
        let png = path.with_extension("png");
        let bytes = kuva::render_to_png(plots, layout, SCALE)
            .map_err(|why| OutputError::new("draw", &png, io::Error::other(why)))?;
        let bytes = provenance.put_into_png(&bytes);
        write_atomically(&png, |out| out.write_all(&bytes))?;
        Ok(true)
    }
}
