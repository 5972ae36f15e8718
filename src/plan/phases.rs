//! The order of a run: the only place that knows it.

use std::fmt::Write;

use super::Plan;
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow, LoadingPressure};
use crate::case::wing::Wing;

/// A phase of a run. Its name is the same in the plan, in the file that executes it, in checkpoints and in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Loading pressure pushes a folded canopy open; no air takes part.
    OpenCanopy,
    /// The wind rises while the structure is held.
    RaiseWind,
    /// Steps of air and structure on one lattice.
    March {
        /// Grids of the sequence that are left until the case's own.
        coarser: usize,
    },
    /// The flow is carried over to the next finer grid of the sequence.
    ChangeLattice {
        /// Grids that are left from here.
        coarser: usize,
    },
    /// Static equilibrium of the structure.
    Equilibrium,
    /// Steady glide of a wing: air and fabric in turn.
    Trim,
    /// Panels are cut anew until they fly as they were designed.
    PanelShaping,
    /// The loads of the equilibrium several times over.
    LoadTest,
}

impl Phase {
    /// Name in files, labels and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::OpenCanopy => "open_canopy",
            Self::RaiseWind => "raise_wind",
            Self::March { .. } => "march",
            Self::ChangeLattice { .. } => "change_lattice",
            Self::Equilibrium => "equilibrium",
            Self::Trim => "trim",
            Self::PanelShaping => "panel_shaping",
            Self::LoadTest => "load_test",
        }
    }
}

/// The phases of a run of `scene`, in order; `coarser` are the grids that it begins on, coarsest first. What the scene lacks is not in the list.
#[must_use]
pub fn phases(scene: &Scene, coarser: &[Scene]) -> Vec<Phase> {
    let mut phases = Vec::new();
    if loading(scene).is_some() {
        phases.push(Phase::OpenCanopy);
    }
    if scene.time.is_some() {
        let first = coarser.first().unwrap_or(scene);
        if Plan::step_counts(first).0 > 0 {
            phases.push(Phase::RaiseWind);
        }
        for left in (0..=coarser.len()).rev() {
            if left < coarser.len() {
                phases.push(Phase::ChangeLattice { coarser: left });
            }
            phases.push(Phase::March { coarser: left });
        }
    }
    if scene.equilibrium.is_none() {
        return phases;
    }
    let wing = scene.wing();
    let has = |what: fn(&Wing) -> bool| wing.is_some_and(what);
    phases.push(if has(|wing| wing.trim.is_some()) {
        Phase::Trim
    } else {
        Phase::Equilibrium
    });
    if has(|wing| wing.panel_shaping.is_some()) {
        phases.push(Phase::PanelShaping);
    }
    if has(|wing| wing.load_test.is_some()) {
        phases.push(Phase::LoadTest);
    }
    phases
}

fn loading(scene: &Scene) -> Option<LoadingPressure> {
    match scene.body.as_ref()?.kind {
        BodyKind::Canopy(canopy) => canopy.loading,
        _ => None,
    }
}

/// The phases as text, a line each.
pub(super) fn write(out: &mut String, scene: &Scene, coarser: &[Scene]) -> std::fmt::Result {
    writeln!(out, "\nphases of the run")?;
    for phase in phases(scene, coarser) {
        writeln!(
            out,
            "  {:<19} {}",
            phase.name(),
            describe(phase, scene, coarser)
        )?;
    }
    Ok(())
}

/// What a phase does in this scene, and when it ends.
fn describe(phase: Phase, scene: &Scene, coarser: &[Scene]) -> String {
    let grid = |left: usize| {
        let number = coarser.len().checked_sub(left);
        let found = number.and_then(|number| coarser.get(number));
        found.unwrap_or(scene)
    };
    let wing = scene.wing();
    match phase {
        Phase::OpenCanopy => loading(scene).map_or_else(String::new, |loading| {
            format!(
                "loading pressure of {} Pa until D_p/D_0 = {}",
                loading.pressure_pa, loading.opened_diameter_ratio
            )
        }),
        Phase::RaiseWind => {
            let first = coarser.first().unwrap_or(scene);
            match first.air.as_ref().map(|air| &air.flow) {
                Some(Flow::WindTunnel {
                    speed_m_s,
                    start_time_s,
                    ..
                }) => format!(
                    "{} steps: the wind rises to {speed_m_s} m/s in {start_time_s} s, the structure is held",
                    Plan::step_counts(first).0
                ),
                _ => String::new(),
            }
        }
        Phase::March { coarser: left } => march(grid(left), left, coarser.len()),
        Phase::ChangeLattice { coarser: left } => match &grid(left).air {
            Some(air) => format!(
                "to {} of {:.4} m, steps of {:.4e} s",
                cells(air),
                air.units.cell_size_m,
                air.units.time_step_s
            ),
            None => String::new(),
        },
        Phase::Equilibrium => scene.equilibrium.map_or_else(String::new, |equilibrium| {
            format!(
                "static, to {:e} of the loads, at most {} evaluations",
                equilibrium.tolerance, equilibrium.evaluation_limit
            )
        }),
        Phase::Trim => wing.map_or_else(String::new, |wing| trim(wing, scene)),
        Phase::PanelShaping => wing
            .and_then(|wing| wing.panel_shaping.as_ref())
            .map_or_else(String::new, |shaping| {
                format!(
                    "to {} within {}, at most {} changes, each with {} of its own",
                    match shaping.target {
                        Some(_) => "flown ballooning",
                        None => "designed width of cells",
                    },
                    shaping.tolerance,
                    shaping.iteration_limit,
                    if wing.is_some_and(|wing| wing.trim.is_some()) {
                        "a trim"
                    } else {
                        "an equilibrium"
                    }
                )
            }),
        Phase::LoadTest => wing
            .and_then(|wing| wing.load_test.as_ref())
            .map_or_else(String::new, |test| {
                format!("{:?} times the loads of the equilibrium", test.load_factors)
            }),
    }
}

fn cells(air: &Air) -> String {
    let [nx, ny, nz] = air.cells;
    format!("{nx} x {ny} x {nz} cells")
}

fn march(scene: &Scene, left: usize, grids: usize) -> String {
    let Some(time) = scene.time else {
        return String::new();
    };
    let steps = Plan::step_counts(scene).1;
    let place = scene
        .air
        .as_ref()
        .filter(|_| grids > 0)
        .map_or_else(String::new, |air| format!(" on {}", cells(air)));
    let changing = if scene.descent.is_some() {
        " at first: they follow the speed of the fall"
    } else {
        ""
    };
    let length = format!("steps of {:.4e} s{changing}{place}", time.step_s);
    if left > 0 {
        let until = if left == grids {
            "the wake has settled"
        } else {
            "the change of the grid is over"
        };
        return format!("{length}, until {until}");
    }
    let steady = if scene.steady_drag_confidence.is_some() {
        ", or until the means are steady"
    } else {
        ""
    };
    format!("{steps} {length}, to t = {} s{steady}", time.end_s)
}

fn trim(wing: &Wing, scene: &Scene) -> String {
    let mut nodes: Vec<usize> = scene
        .body
        .iter()
        .map(|body| body.structure.node_count())
        .collect();
    let mut finer = wing;
    while let Some(coarser) = &finer.coarser {
        nodes.push(coarser.structure.node_count());
        finer = &coarser.wing;
    }
    let meshes: Vec<String> = nodes.iter().rev().map(usize::to_string).collect();
    let limit = wing.trim.as_ref().map_or(0, |trim| trim.iteration_limit);
    let tolerance = scene.equilibrium.map_or(f64::NAN, |e| e.tolerance);
    format!(
        "steady glide by panel method and fabric in turn (fabric to {tolerance:e} of the loads), at most {limit} outer iterations on {} nodes",
        meshes.join(", then as many on ")
    )
}
