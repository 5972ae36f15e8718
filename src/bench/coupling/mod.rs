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
mod point;
mod scheme;

use std::path::Path;

use super::front::unbeaten;
use super::{Engine, Stop, Watch, go_on, write_rows};
pub use point::Point;
use scheme::{DEFAULT, LADDER, MASS_RATIOS, Scheme, TUNNELS, Tunnel, rigid_schemes, schemes};

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
        write_rows(&folder.join(format!("{name}.csv")), &points)?;
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
