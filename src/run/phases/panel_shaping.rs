//! Phase `panel_shaping`: the equilibrium sought again and again with other panels, until they fly as they were designed.
//!
//! Paper P0, section 3, has the panels shaped such that the flown wing is the designed one, without saying how. Here the ballooning b with which they are
//! cut goes by r (target − flown) at every place of the chord and on both sides, all cells alike, as a plan has one distribution for all; or, where the ribs are
//! to fly as far apart as they were designed, by r (1 + b) (designed/flown − 1) of their distances. Places where what is aimed at cannot be read (the nose,
//! over intakes, ballooning at mini-ribs) follow the nearest one where it can.

use super::stand::Next;
use crate::case::wing::Wing;
use crate::case::wing_design::Ballooning;
use crate::geometry::table::lookup;
use crate::geometry::wing::section::Side;
use crate::measure;
use crate::run::{Observer, Run, RunError};
use crate::simulation::Simulation;
use crate::statics::ShapingStep;

/// Widest panel that can be asked for.
const WIDEST: f64 = 0.5;

impl Run<'_> {
    /// Shapes the panels, from the equilibrium that was found.
    pub(super) fn shape_panels(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        let Some(wing) = self.case.scene.wing() else {
            return Ok(Next::Phase);
        };
        let Some(shaping) = &wing.panel_shaping else {
            return Ok(Next::Phase);
        };
        let target = shaping.target.as_ref();
        loop {
            if self.statics.has_unbalanced_cut() {
                match self.balance(observer)? {
                    Next::Phase => self.statics.cut_is_balanced(),
                    other => return Ok(other),
                }
            }
            let sewn = self.statics.cut().cloned();
            let mut cut = sewn.unwrap_or_else(|| at_nodes(wing, &wing.plan.ballooning));
            let step = read(wing, &self.simulation, &cut, target);
            let changes = self.statics.shaping_steps().len();
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
            self.statics.note_shaping(step.clone());
            if error <= shaping.tolerance {
                let text = format!("panels fly as designed after {changes} changes");
                observer.note(&text);
                self.stand.reason = format!("{}; {text}", self.stand.reason);
                return Ok(Next::Phase);
            }
            if changes >= shaping.iteration_limit {
                self.stand.unbalanced = true;
                let flat = cut
                    .iter()
                    .flatten()
                    .filter(|p| p[1] == 0.0 && p[0] < 1.0)
                    .count();
                self.stand.balance_notes.push(format!(
                    "panels do NOT fly as designed within {changes} changes: the largest difference is {error:.4} ({:.4} allowed){}; raise equilibrium.panel_shaping.iteration_limit or its tolerance, lower its relaxation, or ask for what this wing can fly",
                    shaping.tolerance,
                    if flat > 0 {
                        format!("; at {flat} places of the chord panels are cut flat already")
                    } else {
                        String::new()
                    }
                ));
                return Ok(Next::Phase);
            }
            let read = if target.is_some() {
                &step.flown
            } else {
                &step.widths
            };
            for (side, cut) in cut.iter_mut().enumerate() {
                let lacking = |place: f64, value: f64, b: f64| match target {
                    Some(target) => lookup(&target[side], place) - value,
                    None => (1.0 + b) * (1.0 / value - 1.0),
                };
                widen(cut, &read[side], shaping.relaxation, lacking);
            }
            self.statics.recut(&mut self.simulation, cut)?;
            // What was out of balance before is solved anew.
            self.stand.unbalanced = false;
            self.stand.balance_notes.clear();
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
        let places = wing.built.places.of(side).iter();
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
