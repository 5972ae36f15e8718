//! Tables and charts of a panel shaping, and panels laid flat.

use crate::case::scene::Scene;
use crate::case::wing::Wing;
use crate::case::wing_design::Ballooning;
use crate::geometry::table::lookup;
use crate::geometry::wing::patterns::{self, Pattern};
use crate::output::{
    Chart, OutputError, PatternPiece, Series, write_atomically, write_patterns, write_table,
};
use crate::run::run_folder::RunFolder;
use crate::simulation::Simulation;
use crate::statics::{ShapingStep, Statics};
use std::fmt::Write;

/// Tables of a panel shaping, and the keys of the plan that it found.
pub(in crate::run) const TABLES: [&str; 3] = [
    "panel_shaping.csv",
    "panel_shaping_iterations.csv",
    "panel_shaping.toml",
];

/// Charts of a panel shaping, without their endings.
pub(in crate::run) const CHARTS: [&str; 2] = ["panel_shaping_upper", "panel_shaping_lower"];

/// Panels laid flat.
pub(in crate::run) const PATTERNS: &str = "panels.svg";

/// Writes tables and charts of a panel shaping, and the panels where they are asked for; nothing where there is none.
pub(in crate::run) fn write(
    folder: &RunFolder<'_>,
    scene: &Scene,
    simulation: &Simulation,
    statics: &Statics,
) -> Result<(), OutputError> {
    let Some(wing) = scene.wing() else {
        return Ok(());
    };
    let steps = statics.shaping_steps();
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
        let panels = patterns::patterns(&wing.built, &cloth.structure.positions_m);
        let pieces: Vec<PatternPiece> = panels.iter().map(|panel| piece(wing, panel)).collect();
        let path = folder.join(PATTERNS);
        write_patterns(&path, &scene.title, &pieces, folder.provenance())?;
    }
    Ok(())
}

fn iterations(folder: &RunFolder<'_>, steps: &[ShapingStep]) -> Result<(), OutputError> {
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
    folder: &RunFolder<'_>,
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
            colour: None,
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
        .write(&folder.join(CHARTS[side]), folder.provenance())?;
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
fn write_plan(folder: &RunFolder<'_>, last: &ShapingStep) -> Result<(), OutputError> {
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
