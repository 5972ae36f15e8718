//! Schemes of the coupling compared: what each leaves of slip, leakage and noise, and what it costs.
//!
//! The shipped canopy (`cases/flat-circular-tunnel.toml`) inflates with every scheme, the quick set in a short and narrow tunnel; means run
//! over the second half of 0.3 s from release.
//! What is varied, one thing at a time around the default (a = 1.6, k = 1, tolerance 1e-2, markers at most one cell apart):
//!
//! * over-relaxation a and the steps k of the air per solve of the fabric, in all pairs; for k > 1 the fabric feels the mean ū
//!   ([`crate::simulation::Coupled`]), and k is lowered where a marker would move too far ([`crate::simulation::Cadence`]);
//! * tolerance of the solver; largest spacing of markers on a triangle;
//! * a running mean of u* over n steps with k = 1, by which the fabric feels K (v − ū) and the air K (v − u*);
//! * passes of multi-direct forcing (Wang, Fan & Luo 2008), on a rigid disk alone: fabric feels the air inside its implicit step, once.
//!
//! [`light_canopies`] does the same over the mass of the sheet.

mod canopy;
mod disk;
mod plots;

use std::path::Path;

use serde::Serialize;

use super::front::unbeaten;
use super::{Engine, Stop, Watch, go_on};
use crate::output::write_atomically;

/// Time from release [s]; nine D_0/U of the canopy.
const END_S: f64 = 0.3;

/// Where the schemes are compared.
#[derive(Debug, Clone, Copy)]
struct Tunnel {
    /// Length, width and height [m].
    size_m: [f64; 3],
    /// Of the lines' confluence, and of a disk in place of the canopy, from the inlet [m].
    places_m: [f64; 2],
    sponge_length_m: f64,
    /// Cells per D_0.
    cells_per_diameter: f64,
}

/// Of the quick and of the full set; the second is that of the shipped case.
const TUNNELS: [Tunnel; 2] = [
    Tunnel {
        size_m: [2.9915, 1.994, 1.994],
        places_m: [0.4, 1.2],
        sponge_length_m: 0.4,
        cells_per_diameter: 16.0,
    },
    Tunnel {
        size_m: [4.985, 2.991, 2.991],
        places_m: [0.6, 1.5],
        sponge_length_m: 0.75,
        cells_per_diameter: 24.0,
    },
];

/// Mass of fabric and lines over that of the air in a cell's thickness on the fabric, of the ladder.
const MASS_RATIOS: [f64; 5] = [10.0, 1.0, 0.1, 0.01, 0.001];

/// Steps per solve of the ladder.
const LADDER: [u32; 3] = [1, 4, 10];

/// A scheme of coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scheme {
    over_relaxation: f64,
    structure_every: u32,
    averaging_steps: u32,
    tolerance: f64,
    marker_spacing_cells: f64,
    passes: u32,
    /// `None` for the canopy's own.
    mass_ratio: Option<f64>,
}

/// What the shipped cases have.
const DEFAULT: Scheme = Scheme {
    over_relaxation: 1.6,
    structure_every: 1,
    averaging_steps: 1,
    tolerance: 1e-2,
    marker_spacing_cells: 1.0,
    passes: 1,
    mass_ratio: None,
};

const OVER_RELAXATIONS: [f64; 3] = [1.0, 1.6, 8.0 / 3.0];

/// Schemes of the canopy, each once.
fn schemes() -> Vec<Scheme> {
    let mut schemes = Vec::new();
    let mut add = |scheme| {
        if !schemes.contains(&scheme) {
            schemes.push(scheme);
        }
    };
    for over_relaxation in OVER_RELAXATIONS {
        for structure_every in [1, 2, 4, 10] {
            add(Scheme {
                over_relaxation,
                structure_every,
                ..DEFAULT
            });
        }
    }
    for over_relaxation in [1.6, 8.0 / 3.0] {
        for tolerance in [1e-1, 1e-3] {
            add(Scheme {
                over_relaxation,
                tolerance,
                ..DEFAULT
            });
        }
        for marker_spacing_cells in [0.75, 0.5] {
            add(Scheme {
                over_relaxation,
                marker_spacing_cells,
                ..DEFAULT
            });
        }
    }
    for averaging_steps in [2, 4] {
        add(Scheme {
            averaging_steps,
            ..DEFAULT
        });
    }
    schemes
}

/// Schemes of the rigid disk.
fn rigid_schemes() -> Vec<Scheme> {
    let mut schemes = Vec::new();
    for over_relaxation in OVER_RELAXATIONS {
        for passes in [1, 2, 5] {
            schemes.push(Scheme {
                over_relaxation,
                passes,
                ..DEFAULT
            });
        }
    }
    schemes
}

/// One scheme, measured. Means run over the second half of the time from release; not finite where the run broke down.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// `canopy` or `disk`.
    pub body: &'static str,
    /// Over-relaxation a on a flat sheet.
    pub over_relaxation: f64,
    /// Steps k of the air per solve of the fabric, at most.
    pub structure_every: u32,
    /// The same in the mean.
    pub mean_structure_every: f64,
    /// Steps of the running mean of u*; 1 without.
    pub averaging_steps: u32,
    /// Tolerance of the solver.
    pub tolerance: f64,
    /// Largest spacing of markers on a triangle [cells].
    pub marker_spacing_cells: f64,
    /// Passes of forcing.
    pub passes: u32,
    /// Mass of fabric and lines over that of the air in a cell's thickness on the fabric; not finite for the disk.
    pub mass_ratio: f64,
    /// Cells per D_0, or per diameter of the disk.
    pub cells_per_diameter: f64,
    /// Engine and precision.
    pub engine: String,
    /// Markers.
    pub markers: usize,
    /// Root of the area of a marker [cells].
    pub marker_distance_cells: f64,
    /// Steps.
    pub steps: u64,
    /// Fastest node of the whole run over the wind; zero for the disk.
    pub fastest: f64,
    /// Root mean square slip over the wind.
    pub slip: f64,
    /// Mean normal velocity of the air through the surface, downstream, over the wind.
    pub leakage: f64,
    /// Root mean square of the drag's change from step to step over the mean drag.
    pub drag_noise: f64,
    /// Largest difference of the force routes over the drag.
    pub force_imbalance: f64,
    /// Mean drag coefficient.
    pub drag_coefficient: f64,
    /// Mean D_p/D_0; not finite for the disk.
    pub projected_diameter_ratio: f64,
    /// Evaluations of the fabric's energy per step.
    pub evaluations_per_step: f64,
    /// Time of the fabric per step [ms]: medians, which other work on the machine disturbs little.
    pub cloth_ms: f64,
    /// The same of the stages between air and markers [ms].
    pub coupling_ms: f64,
    /// True if no other scheme of the body is as good in cost, slip and noise and better in one.
    pub unbeaten: bool,
}

impl Point {
    fn new(body: &'static str, scheme: &Scheme, cells_per_diameter: f64, engine: &Engine) -> Self {
        Self {
            body,
            over_relaxation: scheme.over_relaxation,
            structure_every: scheme.structure_every,
            mean_structure_every: f64::NAN,
            averaging_steps: scheme.averaging_steps,
            tolerance: scheme.tolerance,
            marker_spacing_cells: scheme.marker_spacing_cells,
            passes: scheme.passes,
            mass_ratio: f64::NAN,
            cells_per_diameter,
            engine: engine.name(),
            markers: 0,
            marker_distance_cells: f64::NAN,
            steps: 0,
            fastest: f64::INFINITY,
            slip: f64::NAN,
            leakage: f64::NAN,
            drag_noise: f64::NAN,
            force_imbalance: f64::NAN,
            drag_coefficient: f64::NAN,
            projected_diameter_ratio: f64::NAN,
            evaluations_per_step: f64::NAN,
            cloth_ms: f64::NAN,
            coupling_ms: f64::NAN,
            unbeaten: false,
        }
    }

    fn cost_ms(&self) -> f64 {
        self.cloth_ms + self.coupling_ms
    }

    /// What is not as in the default.
    fn name(&self) -> String {
        let mut parts = vec![format!("a {:.3}", self.over_relaxation)];
        if self.body == disk::NAME {
            parts.push(format!("passes {}", self.passes));
            return parts.join(", ");
        }
        parts.push(format!("k {}", self.structure_every));
        if self.averaging_steps > 1 {
            parts.push(format!("u* over {} steps", self.averaging_steps));
        }
        if self.tolerance != DEFAULT.tolerance {
            parts.push(format!("tolerance {:e}", self.tolerance));
        }
        if self.marker_spacing_cells != DEFAULT.marker_spacing_cells {
            parts.push(format!("markers {} cells", self.marker_spacing_cells));
        }
        parts.join(", ")
    }
}

/// Middle one of some values; not finite without any.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Marks the points of a body that none other beats.
fn mark_unbeaten(points: &mut [Point]) {
    let coordinates: Vec<[f64; 3]> = points
        .iter()
        .map(|p| [p.cost_ms(), p.slip, p.drag_noise])
        .collect();
    for (point, mark) in points.iter_mut().zip(unbeaten(&coordinates)) {
        point.unbeaten = mark;
    }
}

fn table(points: &[Point]) -> String {
    let mut text = format!(
        "{:<36} {:>5} {:>7} {:>7} {:>8} {:>7} {:>8} {:>6} {:>8} {:>6} {:>8} {:>8} {:>8}\n",
        "scheme (* beaten by none)",
        "k",
        "markers",
        "slip",
        "leakage",
        "noise",
        "routes",
        "C_D",
        "D_p/D_0",
        "evals",
        "cloth",
        "coupling",
        "fastest"
    );
    for p in points {
        text.push_str(&format!(
            "{:<36} {:>5.2} {:>7} {:>5.2} % {:>6.2} % {:>5.2} % {:>6.2} % {:>6.3} {:>8.3} {:>6.2} {:>5.3} ms {:>5.3} ms {:>8.3}\n",
            format!("{}{}", p.name(), if p.unbeaten { " *" } else { "" }),
            p.mean_structure_every,
            p.markers,
            100.0 * p.slip,
            100.0 * p.leakage,
            100.0 * p.drag_noise,
            100.0 * p.force_imbalance,
            p.drag_coefficient,
            p.projected_diameter_ratio,
            p.evaluations_per_step,
            p.cloth_ms,
            p.coupling_ms,
            p.fastest
        ));
    }
    text
}

fn write_csv(path: &Path, points: &[Point]) -> Result<(), Stop> {
    write_atomically(path, |out| {
        let mut table = csv::Writer::from_writer(out);
        for point in points {
            table.serialize(point).map_err(std::io::Error::other)?;
        }
        table.flush()
    })?;
    Ok(())
}

/// Runs some schemes; every scheme that breaks down keeps its row.
fn compute(
    schemes: &[Scheme],
    (full, engine): (bool, &Engine),
    run: fn(&Scheme, &Tunnel, &Engine, &Watch) -> Result<Point, Stop>,
    (folder, name): (&Path, &str),
    watch: &mut Watch,
) -> Result<Vec<Point>, Stop> {
    let mut points = Vec::new();
    for scheme in schemes {
        go_on(watch.interrupt)?;
        points.push(run(scheme, &TUNNELS[usize::from(full)], engine, watch)?);
        mark_unbeaten(&mut points);
        // What an interrupt leaves is worth keeping.
        write_csv(&folder.join(format!("{name}.csv")), &points)?;
        let done = points.len() as u64;
        watch.observer.progress(done, schemes.len() as u64, name);
    }
    Ok(points)
}

/// Compares schemes on the canopy; writes `coupling-schemes.csv` and `.png` into `folder`, and returns the points with a table.
pub fn schemes_compared(
    full: bool,
    engine: &Engine,
    folder: &Path,
    watch: &mut Watch,
) -> Result<(Vec<Point>, String), Stop> {
    let files = (folder, "coupling-schemes");
    let points = compute(&schemes(), (full, engine), canopy::run, files, watch)?;
    plots::schemes(&folder.join("coupling-schemes.png"), &points)?;
    let text = format!("canopy\n{}", table(&points));
    Ok((points, text))
}

/// Compares passes of forcing on a rigid disk; writes `coupling-passes.csv` into `folder`.
pub fn passes_compared(
    full: bool,
    engine: &Engine,
    folder: &Path,
    watch: &mut Watch,
) -> Result<(Vec<Point>, String), Stop> {
    let files = (folder, "coupling-passes");
    let points = compute(&rigid_schemes(), (full, engine), disk::run, files, watch)?;
    let text = format!("rigid disk\n{}", table(&points));
    Ok((points, text))
}

/// Sheets ever lighter than the air around them, with solves every 1, 4 and 10 steps; writes `light-canopies.csv` and `.png` into `folder`.
pub fn light_canopies(
    full: bool,
    engine: &Engine,
    folder: &Path,
    watch: &mut Watch,
) -> Result<(Vec<Point>, String), Stop> {
    let mut schemes = Vec::new();
    for structure_every in LADDER {
        for ratio in MASS_RATIOS {
            schemes.push(Scheme {
                structure_every,
                mass_ratio: Some(ratio),
                ..DEFAULT
            });
        }
    }
    let files = (folder, "light-canopies");
    let points = compute(&schemes, (full, engine), canopy::run, files, watch)?;
    let mut text = String::new();
    for ratio in MASS_RATIOS {
        let own: Vec<Point> = points
            .iter()
            .filter(|p| p.mass_ratio == ratio)
            .cloned()
            .collect();
        text.push_str(&format!("mass ratio {ratio}\n{}", table(&own)));
    }
    plots::light_canopies(&folder.join("light-canopies.png"), &points)?;
    Ok((points, text))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::plan::Precision;
    use crate::run::Observer;

    struct Silent;

    impl Observer for Silent {
        fn progress(&mut self, _: u64, _: u64, _: &str) {}
        fn note(&mut self, _: &str) {}
    }

    #[test]
    fn every_scheme_comes_once() {
        let schemes = schemes();
        assert!(schemes.contains(&DEFAULT));
        assert_eq!(schemes.len(), 22);
        assert_eq!(rigid_schemes().len(), 9);
    }

    /// Inside a flat disk a pass leaves 1 − (3/8) a of the slip, so that more passes and a stronger one leave less; what is left of a
    /// single pass leaks.
    #[test]
    fn passes_take_slip_away() {
        let interrupt = AtomicBool::new(false);
        let watch = Watch {
            interrupt: &interrupt,
            observer: &mut Silent,
        };
        let engine = Engine::cpu(Precision::F32);
        let coarse = Tunnel {
            cells_per_diameter: 12.0,
            ..TUNNELS[0]
        };
        let point = |over_relaxation, passes| {
            let scheme = Scheme {
                over_relaxation,
                passes,
                ..DEFAULT
            };
            disk::run_for(&scheme, &coarse, 0.02, &engine, &watch).unwrap()
        };
        let [weak, strong, repeated] = [point(1.0, 1), point(8.0 / 3.0, 1), point(1.0, 5)];
        assert!(weak.slip > 1.3 * strong.slip && weak.slip > 2.0 * repeated.slip);
        assert!(weak.leakage > 0.0 && weak.leakage < weak.slip);
        assert!(weak.leakage > 1.3 * repeated.leakage.abs());
        assert!(weak.force_imbalance < 1e-3, "{}", weak.force_imbalance);
    }
}
