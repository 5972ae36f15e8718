//! Low-order aerodynamics: what panels cost and how wrong they are, and the polar of Belloc's wing beside the measurement.
//!
//! The error is that of the lift of Belloc's wing at 8 degrees against a Richardson extrapolation of the two finest surfaces, whose panels are
//! alike in shape; times are of the equations set up, factorised and solved for one stream, pressures included.

use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use kuva::prelude::{Layout, LinePlot, Plot, ScatterPlot};

use super::{Stop, Watch, go_on, plots, write_rows};
use crate::aero::AeroError;
use crate::aero::belloc;
use crate::aero::decambering::{Branch, Decambering, Section};
use crate::aero::potential_flow::{MEMORY_LIMIT, PotentialFlow};

/// Panels per side of a section and strips per half span, finest last.
const SIZES: [[usize; 2]; 6] = [[6, 6], [10, 10], [15, 15], [20, 20], [30, 30], [40, 40]];

/// The same and a surface of 7 260 unknowns, as many as a paraglider of 60 cells has with two strips per cell.
const FULL_SIZES: [[usize; 2]; 7] = [
    [6, 6],
    [10, 10],
    [15, 15],
    [20, 20],
    [30, 30],
    [40, 40],
    [60, 60],
];

/// Surface of the polar.
const POLAR_SIZE: [usize; 2] = [30, 30];

const ANGLE_DEGREES: f64 = 8.0;

/// One size.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Point {
    /// Panels along each side of a section.
    pub per_side: usize,
    /// Strips of the half wing.
    pub strips: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Lift coefficient at 8 degrees.
    pub lift: f64,
    /// Relative error of it; `None` for the two sizes that the reference comes from.
    pub error: Option<f64>,
    /// Time of one flow [s].
    pub seconds: f64,
}

/// One angle of the polar.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
struct Angle {
    angle_degrees: f64,
    lift_inviscid: f64,
    drag_induced_inviscid: f64,
    lift: f64,
    drag_induced: f64,
    drag_profile: f64,
    residual: f64,
}

impl From<AeroError> for Stop {
    fn from(error: AeroError) -> Self {
        Self::Refused(error.to_string())
    }
}

/// Computes both; writes `aerodynamics.csv`, `belloc-polar.csv` and plots into `folder`.
pub fn measure(full: bool, folder: &Path, watch: &mut Watch) -> Result<Vec<Point>, Stop> {
    let sizes: &[_] = if full { &FULL_SIZES } else { &SIZES };
    let mut points = Vec::new();
    for (done, &[per_side, strips]) in sizes.iter().enumerate() {
        go_on(watch.interrupt)?;
        points.push(point(per_side, strips)?);
        watch
            .observer
            .progress(done as u64 + 1, sizes.len() as u64 + 1, "aerodynamics");
    }
    // Second order in the size of the panels.
    if let [.., coarse, fine] = points.as_slice() {
        let ratio = (fine.per_side as f64 / coarse.per_side as f64).powi(2);
        let exact = fine.lift + (fine.lift - coarse.lift) / (ratio - 1.0);
        let judged = points.len() - 2;
        for point in &mut points[..judged] {
            point.error = Some((point.lift / exact - 1.0).abs());
        }
    }
    let polar = polar()?;
    write_rows(&folder.join("aerodynamics.csv"), &points)?;
    write_rows(&folder.join("belloc-polar.csv"), &polar)?;
    plot_errors(&folder.join("aerodynamics.png"), &points)?;
    plot_polar(folder, &polar)?;
    Ok(points)
}

/// The sizes as an aligned table.
#[must_use]
pub fn table(points: &[Point]) -> String {
    let mut text = "per side  strips  unknowns  lift at 8 deg  error      seconds\n".to_owned();
    for p in points {
        let error = p
            .error
            .map_or_else(|| "-".to_owned(), |e| format!("{:.2} %", 100.0 * e));
        text.push_str(&format!(
            "{:8}  {:6}  {:8}  {:13.5}  {error:9}  {:.3}\n",
            p.per_side, p.strips, p.unknowns, p.lift, p.seconds
        ));
    }
    text
}

/// Dynamic pressure times area at unit density.
fn dynamic() -> f64 {
    0.5 * belloc::SPEED_M_S.powi(2) * belloc::REFERENCE_AREA_M2
}

fn point(per_side: usize, strips: usize) -> Result<Point, Stop> {
    let surface = belloc::wing()?.divided(strips, 0.6)?.panels(per_side)?;
    let stream = belloc::stream_m_s(ANGLE_DEGREES.to_radians());
    let began = Instant::now();
    let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT)?
        .solve(&[stream])?
        .remove(0);
    std::hint::black_box(flow.pressure_coefficients(&surface));
    Ok(Point {
        per_side,
        strips,
        unknowns: surface.panels.len(),
        lift: flow.trefftz_forces(&surface, 1.0).lift_n / dynamic(),
        error: None,
        seconds: began.elapsed().as_secs_f64(),
    })
}

fn polar() -> Result<Vec<Angle>, Stop> {
    let [per_side, strips] = POLAR_SIZE;
    let surface = belloc::wing()?.divided(strips, 0.6)?.panels(per_side)?;
    let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT)?;
    let (polar, section) = belloc::section()?;
    let sections = vec![
        Section {
            polar: &polar,
            flow: section
        };
        strips
    ];
    let degrees: Vec<f64> = (-5..=20).map(f64::from).collect();
    let streams: Vec<DVec3> = degrees
        .iter()
        .map(|a| belloc::stream_m_s(a.to_radians()))
        .collect();
    let inviscid = flow.solve(&streams)?;
    let viscous = Decambering::new(&flow, sections)?.solve(&streams, Branch::Attached, 1.0)?;
    Ok(degrees
        .into_iter()
        .zip(inviscid.iter().zip(&viscous))
        .map(|(angle_degrees, (inviscid, viscous))| {
            let without = inviscid.trefftz_forces(&surface, 1.0);
            let [lift, induced, profile] = viscous
                .lift_and_drags_n(&surface, 1.0)
                .map(|force| force / dynamic());
            Angle {
                angle_degrees,
                lift_inviscid: without.lift_n / dynamic(),
                drag_induced_inviscid: without.induced_drag_n / dynamic(),
                lift,
                drag_induced: induced,
                drag_profile: profile,
                residual: viscous.residual,
            }
        })
        .collect())
}

fn plot_errors(path: &Path, points: &[Point]) -> Result<(), Stop> {
    let data: Vec<(f64, f64)> = points
        .iter()
        .filter_map(|p| Some((p.seconds, p.error?)))
        .collect();
    if data.iter().any(|p| !(p.0 > 0.0 && p.1 > 0.0)) {
        // Logarithmic axes have no place for them.
        return Ok(());
    }
    let plots: Vec<Plot> = vec![
        LinePlot::new()
            .with_data(data.clone())
            .with_color(plots::COLOURS[0])
            .with_legend("panels, symmetric half")
            .into(),
        ScatterPlot::new()
            .with_data(data)
            .with_color(plots::COLOURS[0])
            .with_size(5.0)
            .into(),
    ];
    let layout = Layout::auto_from_plots(&plots)
        .with_log_scale()
        .with_title("Lift of Belloc's wing at 8 degrees without viscosity")
        .with_x_label("time of one flow [s]")
        .with_y_label("error against the extrapolated lift");
    plots::write(path, plots, layout)
}

fn plot_polar(folder: &Path, polar: &[Angle]) -> Result<(), Stop> {
    let measured = belloc::measured();
    let line = |data: Vec<(f64, f64)>, colour: usize, name: &str| -> Plot {
        LinePlot::new()
            .with_data(data)
            .with_color(plots::COLOURS[colour])
            .with_stroke_width(2.0)
            .with_legend(name)
            .into()
    };
    let dots = |data: Vec<(f64, f64)>| -> Plot {
        ScatterPlot::new()
            .with_data(data)
            .with_color(plots::COLOURS[6])
            .with_size(3.0)
            .with_legend("measured, Belloc 2015")
            .into()
    };
    let lift: Vec<Plot> = vec![
        line(
            polar
                .iter()
                .map(|a| (a.angle_degrees, a.lift_inviscid))
                .collect(),
            5,
            "panels without viscosity",
        ),
        line(
            polar.iter().map(|a| (a.angle_degrees, a.lift)).collect(),
            1,
            "panels with the section's polar",
        ),
        dots(
            measured
                .iter()
                .map(|p| (p.angle_rad.to_degrees(), p.lift))
                .collect(),
        ),
    ];
    let layout = Layout::auto_from_plots(&lift)
        .with_title("Belloc's wing: lift")
        .with_x_label("angle of attack [degrees]")
        .with_y_label("lift coefficient");
    plots::write(&folder.join("belloc-lift.png"), lift, layout)?;
    let drag: Vec<Plot> = vec![
        line(
            polar.iter().map(|a| (a.drag_induced, a.lift)).collect(),
            5,
            "induced drag alone",
        ),
        line(
            polar
                .iter()
                .map(|a| (a.drag_induced + a.drag_profile, a.lift))
                .collect(),
            1,
            "induced and profile drag",
        ),
        dots(measured.iter().map(|p| (p.drag, p.lift)).collect()),
    ];
    let layout = Layout::auto_from_plots(&drag)
        .with_title("Belloc's wing: polar")
        .with_x_label("drag coefficient")
        .with_y_label("lift coefficient");
    plots::write(&folder.join("belloc-polar.png"), drag, layout)
}
