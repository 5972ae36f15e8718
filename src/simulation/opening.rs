//! Opening of a folded canopy by the *loading-pressure method* (paper P4): with the confluence fixed, a small pressure inside pushes the
//! pleats apart until there is room for the flow; the canopy is then held until release. No air takes part.

use crate::case::scene::{Canopy, LoadingPressure};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, Pressure, SolverSettings, StepInput};
use crate::geometry::parachute::shape;
use crate::solve::lbfgs::Stop;

/// Time step of the opening over √(m D₀/p), in which the pressure p moves fabric of the mass m per area by half a nominal diameter D₀.
const STEP: f64 = 0.0097;

/// Mass-proportional damping during the opening times √(m D₀/p); strong, since only the shape matters.
const DAMPING: f64 = 5.16;

/// Steps after which the opening counts as failed.
const STEP_LIMIT: usize = 1000;

/// Evaluations per step: a shape that is not quite settled is good enough to start from.
const EVALUATION_LIMIT: usize = 500;

/// How the canopy was opened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Projected-diameter ratio of the folded canopy.
    pub folded_ratio: f64,
    /// Projected-diameter ratio reached.
    pub opened_ratio: f64,
    /// Pressure-loaded steps taken.
    pub steps: usize,
    /// Those whose solve missed its tolerance.
    pub unsolved: usize,
}

/// Name in a checkpoint.
const OPENING: &str = "opening";

impl Opening {
    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        let counts = [self.steps, self.unsolved].map(|count| count as f64);
        out.put(
            OPENING,
            &[self.folded_ratio, self.opened_ratio, counts[0], counts[1]],
        )
    }

    /// Takes it from a checkpoint; `None` where no canopy was opened.
    pub(super) fn restore(from: &Reader) -> Result<Option<Self>, CheckpointError> {
        if !from.has(OPENING) {
            return Ok(None);
        }
        let numbers: Vec<f64> = from.take_exactly(OPENING, 4)?;
        Ok(Some(Self {
            folded_ratio: numbers[0],
            opened_ratio: numbers[1],
            steps: numbers[2] as usize,
            unsolved: numbers[3] as usize,
        }))
    }
}

/// Opens a folded canopy as `loading` says.
pub(super) fn open(
    cloth: &mut Cloth,
    canopy: &Canopy,
    loading: &LoadingPressure,
    settings: &SolverSettings,
) -> Result<Opening, String> {
    let ratio = |cloth: &Cloth| {
        let triangles = cloth.structure.triangles.iter().map(|t| t.nodes);
        shape::projected_diameter_m(&cloth.positions_m, triangles) / canopy.nominal_diameter_m
    };
    // A payload that is to fall is held as long.
    let lower_end = canopy.lower_end;
    let falls = lower_end.filter(|&node| !std::mem::replace(&mut cloth.structure.held[node], true));
    let folded_ratio = ratio(cloth);
    let fabric = &cloth.structure.masses_kg[..canopy.canopy_node_count];
    let areal_density_kg_m2 = fabric.iter().sum::<f64>() / canopy.nominal_area_m2;
    let scale_s = (areal_density_kg_m2 * canopy.nominal_diameter_m / loading.pressure_pa).sqrt();
    let input = StepInput {
        time_step_s: Some(STEP * scale_s),
        pressure: Pressure::Uniform(loading.pressure_pa),
        damping_1_s: DAMPING / scale_s,
        ..StepInput::default()
    };
    let settings = SolverSettings {
        evaluation_limit: settings.evaluation_limit.min(EVALUATION_LIMIT),
        ..*settings
    };
    let (mut steps, mut unsolved) = (0, 0);
    let mut opened_ratio = folded_ratio;
    while opened_ratio < loading.opened_diameter_ratio {
        let outcome = cloth.solve_cloth(&input, &settings);
        steps += 1;
        unsolved += usize::from(!outcome.stop.reached());
        opened_ratio = ratio(cloth);
        if outcome.stop == Stop::NotFinite || steps >= STEP_LIMIT {
            let to_do = if 2 * unsolved > steps {
                format!(
                    "{unsolved} of their solves missed the tolerance: raise solver.evaluation_limit or solver.tolerance"
                )
            } else {
                "raise loading_pressure_pa of the canopy's folding, ask for less (opened_diameter_ratio), or fold it less (folded_diameter_ratio)".to_owned()
            };
            return Err(format!(
                "the loading pressure of {} Pa opened the folded canopy only to D_p/D_0 = {opened_ratio:.3} of {} in {steps} steps; {to_do}",
                loading.pressure_pa, loading.opened_diameter_ratio
            ));
        }
    }
    if let Some(lower_end) = falls {
        // What was prepared for the solves so far knows the node as held.
        let mut structure = std::mem::take(&mut cloth.structure);
        structure.held[lower_end] = false;
        let positions_m = std::mem::take(&mut cloth.positions_m);
        *cloth = Cloth::new(structure);
        cloth.positions_m = positions_m;
    }
    cloth.velocities_m_s.fill(glam::DVec3::ZERO);
    cloth.step_before = None;
    Ok(Opening {
        folded_ratio,
        opened_ratio,
        steps,
        unsolved,
    })
}
