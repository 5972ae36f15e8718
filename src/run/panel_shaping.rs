//! Panel shaping: the equilibrium sought again and again with other panels, until they fly as they were designed; and the panels laid flat.
//!
//! Paper P0, section 3, has the panels shaped such that the flown wing is the designed one, without saying how. Here the ballooning b with which they are
//! cut goes by r (target − flown) at every place of the chord and on both sides, all cells alike, as a plan has one distribution for all; or, where the ribs are
//! to fly as far apart as they were designed, by r (1 + b) (designed/flown − 1) of their distances. Places where what is aimed at cannot be read (the nose,
//! over intakes, ballooning at mini-ribs) follow the nearest one where it can.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::{INTERRUPTED, Observer, Run, RunError};
use crate::case::scene::Scene;
use crate::case::wing::Wing;
use crate::case::wing_design::Ballooning;
use crate::geometry::wing::patterns::{self, Pattern};
use crate::geometry::wing::section::{Side, lookup};
use crate::measure;
use crate::output::{
    Chart, OutputError, PatternPiece, Series, write_atomically, write_patterns, write_table,
};
use crate::simulation::{ShapingStep, Simulation};

/// Tables of a panel shaping, and the keys of the plan that it found.
pub(super) const TABLES: [&str; 3] = [
    "panel_shaping.csv",
    "panel_shaping_iterations.csv",
    "panel_shaping.toml",
];

/// Charts of a panel shaping, without their endings.
pub(super) const CHARTS: [&str; 2] = ["panel_shaping_upper", "panel_shaping_lower"];

/// Panels laid flat.
pub(super) const PATTERNS: &str = "panels.svg";

/// Widest panel that can be asked for.
const WIDEST: f64 = 0.5;

impl Run<'_> {
    /// Shapes the panels if the case asks for it, from the equilibrium that was found for `reason`; returns why the run ended.
    pub(super) fn shape_panels(
        &mut self,
        mut reason: String,
        interrupt: &AtomicBool,
        observer: &mut dyn Observer,
    ) -> Result<String, RunError> {
        let Some(wing) = &self.case.scene.wing else {
            return Ok(reason);
        };
        let Some(shaping) = &wing.panel_shaping else {
            return Ok(reason);
        };
        let notes = self.notes.len();
        let mut cut = at_nodes(wing, &wing.plan.ballooning);
        loop {
            let target = shaping.target.as_ref();
            let step = read(wing, &self.simulation, &cut, target);
            let changes = self.simulation.shaping_steps().len();
            observer.note(&format!(
                "panels {changes}: {} by {:.4} at most, {:.4} in the mean square; cells at {:.4} of their width",
                match target {
                    Some(_) => "ballooning differs from what is to be flown",
                    None => "distances of ribs differ from the designed ones",
                },
                step.error_max,
                step.error_rms,
                step.cell_width_ratio
            ));
            let error = step.error_max;
            let (flown, widths) = (step.flown.clone(), step.widths.clone());
            self.simulation.note_shaping(step);
            if error <= shaping.tolerance {
                let text = format!("panels fly as designed after {changes} changes");
                observer.note(&text);
                return Ok(format!("{reason}; {text}"));
            }
            if changes >= shaping.iteration_limit {
                self.unbalanced = true;
                let flat = cut
                    .iter()
                    .flatten()
                    .filter(|p| p[1] == 0.0 && p[0] < 1.0)
                    .count();
                self.notes.push(format!(
                    "panels do NOT fly as designed within {changes} changes: the largest difference is {error:.4} ({:.4} allowed){}; raise equilibrium.panel_shaping.iteration_limit or its tolerance, lower its relaxation, or ask for what this wing can fly",
                    shaping.tolerance,
                    if flat > 0 {
                        format!("; at {flat} places of the chord panels are cut flat already")
                    } else {
                        String::new()
                    }
                ));
                return Ok(reason);
            }
            let read = if target.is_some() { &flown } else { &widths };
            for (side, cut) in cut.iter_mut().enumerate() {
                let lacking = |place: f64, value: f64, b: f64| match target {
                    Some(target) => lookup(&target[side], place) - value,
                    None => (1.0 + b) * (1.0 / value - 1.0),
                };
                widen(cut, &read[side], shaping.relaxation, lacking);
            }
            self.simulation.reshape_panels(cut.clone())?;
            // What was out of balance before is solved anew.
            self.notes.truncate(notes);
            self.unbalanced = false;
            reason = self.balance(interrupt, observer)?;
            if reason == INTERRUPTED {
                return Ok(reason);
            }
        }
    }
}

/// Changes a side's cut by a share of what it lacks where that was read, and by that of the nearest such place elsewhere, so that no step is cut into a panel; the
/// trailing edge stays.
fn widen(
    cut: &mut [[f64; 2]],
    read: &[[f64; 2]],
    share: f64,
    lacking: impl Fn(f64, f64, f64) -> f64,
) {
    let before = cut.to_vec();
    for point in cut.iter_mut().filter(|point| point[0] < 1.0) {
        let apart = |other: &&[f64; 2]| (other[0] - point[0]).abs();
        let nearest = read.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let Some([place, value]) = nearest else {
            continue;
        };
        let change = lacking(*place, *value, lookup(&before, *place));
        point[1] = (point[1] + share * change).clamp(0.0, WIDEST);
    }
}

/// A table of ballooning at the nodes of the mesh.
fn at_nodes(wing: &Wing, ballooning: &Ballooning) -> Ballooning {
    let of = |side: Side, table: &[[f64; 2]]| {
        let places = wing.wing.places.of(side).iter();
        places.map(|x| [*x, lookup(table, *x)]).collect()
    };
    [
        of(Side::Upper, &ballooning[0]),
        of(Side::Lower, &ballooning[1]),
    ]
}

fn read(
    wing: &Wing,
    simulation: &Simulation,
    cut: &Ballooning,
    target: Option<&Ballooning>,
) -> ShapingStep {
    let designed = simulation.scene().body.as_ref();
    let places = simulation.cloth().map(|cloth| &cloth.positions_m);
    let mut step = ShapingStep {
        cut: cut.clone(),
        flown: Ballooning::default(),
        widths: Ballooning::default(),
        error_max: f64::NAN,
        error_rms: f64::NAN,
        cell_width_ratio: f64::NAN,
    };
    if let (Some(body), Some(flown_m)) = (designed, places) {
        let designed_m = &body.structure.positions_m;
        let widths = measure::cell_widths_m(wing, flown_m);
        let as_drawn = measure::cell_widths_m(wing, designed_m);
        let ratios = widths.iter().zip(&as_drawn).map(|(a, b)| a / b);
        step.cell_width_ratio = ratios.sum::<f64>() / widths.len() as f64;
        step.flown = measure::flown_ballooning(wing, flown_m);
        step.widths = measure::cell_width_ratios(wing, designed_m, flown_m);
        let differences = match target {
            Some(_) => measure::ballooning_differences(&step.flown, target),
            None => measure::ballooning_differences(&step.widths, None),
        };
        [step.error_max, step.error_rms] = differences;
    }
    step
}

/// Writes tables and charts of a panel shaping, and the panels where they are asked for; nothing where there is none.
pub(super) fn write(
    folder: &Path,
    scene: &Scene,
    simulation: &Simulation,
) -> Result<(), OutputError> {
    let Some(wing) = &scene.wing else {
        return Ok(());
    };
    let steps = simulation.shaping_steps();
    if let (Some(shaping), Some(first), Some(last)) =
        (&wing.panel_shaping, steps.first(), steps.last())
    {
        iterations(folder, steps)?;
        distribution(folder, &scene.title, shaping.target.as_ref(), [first, last])?;
        write_plan(folder, last)?;
    }
    if wing.panel_shaping.is_some() || scene.output.wing_panels {
        let Some(cloth) = simulation.cloth() else {
            return Ok(());
        };
        // Free of stress as they are sewn.
        let panels = patterns::patterns(&wing.wing, &cloth.structure.positions_m);
        let pieces: Vec<PatternPiece> = panels.iter().map(|panel| piece(wing, panel)).collect();
        write_patterns(&folder.join(PATTERNS), &scene.title, &pieces)?;
    }
    Ok(())
}

fn iterations(folder: &Path, steps: &[ShapingStep]) -> Result<(), OutputError> {
    let columns = [
        "changes",
        "error_max",
        "error_rms",
        "cell_width_over_designed",
    ];
    let rows: Vec<Vec<f64>> = steps
        .iter()
        .enumerate()
        .map(|(n, s)| vec![n as f64, s.error_max, s.error_rms, s.cell_width_ratio])
        .collect();
    write_table(&folder.join(TABLES[1]), &columns, &rows)
}

fn distribution(
    folder: &Path,
    title: &str,
    target: Option<&Ballooning>,
    [first, last]: [&ShapingStep; 2],
) -> Result<(), OutputError> {
    let mut rows = Vec::new();
    for (side, name) in ["upper", "lower"].into_iter().enumerate() {
        let flown = |step: &ShapingStep, x: f64| {
            let point = step.flown[side].iter().find(|p| p[0] == x);
            point.map_or(f64::NAN, |p| p[1])
        };
        let width = |step: &ShapingStep, x: f64| {
            let point = step.widths[side].iter().find(|p| p[0] == x);
            point.map_or(f64::NAN, |p| p[1])
        };
        let wanted = |x: f64| target.map_or(f64::NAN, |target| lookup(&target[side], x));
        let points = |of: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
            first.cut[side].iter().map(|p| [p[0], of(p[0])]).collect()
        };
        for [x, _] in &first.cut[side] {
            rows.push(vec![
                if side == 0 { 1.0 } else { -1.0 },
                *x,
                wanted(*x),
                lookup(&first.cut[side], *x),
                flown(first, *x),
                lookup(&last.cut[side], *x),
                flown(last, *x),
                width(first, *x),
                width(last, *x),
            ]);
        }
        let series = |name: &str, points: Vec<[f64; 2]>, markers: bool| Series {
            name: name.to_owned(),
            points,
            bars: Vec::new(),
            markers,
        };
        Chart {
            title: format!("{title}: {name} panels"),
            labels: [
                "place along the chord, x/c".to_owned(),
                "ballooning: width of the panel over the distance of its ribs, less 1".to_owned(),
            ],
            categories: Vec::new(),
            series: vec![
                series("to be flown", points(&wanted), false),
                series(
                    "cut before",
                    points(&|x| lookup(&first.cut[side], x)),
                    false,
                ),
                series("flown before", points(&|x| flown(first, x)), true),
                series("cut after", points(&|x| lookup(&last.cut[side], x)), false),
                series("flown after", points(&|x| flown(last, x)), true),
            ],
        }
        .write(&folder.join(CHARTS[side]))?;
    }
    let columns = [
        "side",
        "chord_place",
        "to_be_flown",
        "cut_before",
        "flown_before",
        "cut_after",
        "flown_after",
        "rib_distance_over_designed_before",
        "rib_distance_over_designed_after",
    ];
    write_table(&folder.join(TABLES[0]), &columns, &rows)
}

/// The keys of the plan that give these panels.
fn write_plan(folder: &Path, last: &ShapingStep) -> Result<(), OutputError> {
    let mut text = "# Panels cut so that they fly as designed: to be put into the case.\n[structure.wing.ballooning]\n".to_owned();
    for (name, table) in ["upper", "lower"].into_iter().zip(&last.cut) {
        let points: Vec<String> = table
            .iter()
            .map(|p| format!("[{:?}, {:?}]", p[0], p[1]))
            .collect();
        let _ = writeln!(text, "{name} = [{}]", points.join(", "));
    }
    write_atomically(&folder.join(TABLES[2]), |out| {
        out.write_all(text.as_bytes())
    })
}

/// A panel with its words, and marks where rows of lines stand on its seams.
fn piece(wing: &Wing, panel: &Pattern) -> PatternPiece {
    let flat = &panel.flat;
    let left = flat.left.iter().rev().map(|p| p.to_array());
    let outline_m = flat
        .right
        .iter()
        .map(|p| p.to_array())
        .chain(left)
        .collect();
    let mut marks = Vec::new();
    if panel.part == crate::geometry::wing::Part::Lower {
        for row in &wing.plan.rows {
            let at = panel
                .chord_places
                .iter()
                .position(|x| (x - row.position).abs() < 1e-9);
            if let Some(k) = at.filter(|_| row.position < 1.0) {
                for ends in [&flat.left, &flat.right] {
                    marks.push((ends[k].to_array(), row.name.clone()));
                }
            }
        }
    }
    PatternPiece {
        outline_m,
        words: vec![
            format!("{} {}", panel.part.name(), panel.cell + 1),
            format!(
                "seams {:.1}, {:.1} mm",
                1e3 * panel.seams_m[0],
                1e3 * panel.seams_m[1]
            ),
            format!(
                "width {:.1} mm, strain {:.2} %",
                1e3 * panel.width_m,
                100.0 * flat.strain
            ),
        ],
        marks,
    }
}
