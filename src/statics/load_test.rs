//! The load test of a wing: the loads of its equilibrium several times over, with the risers held as on a test rig.
//!
//! Pressure, traction and drag of lines are those of the trim (or the prescribed ones) times the load factor, as if the air came faster by its square root
//! under the same angle; pressure turns with the triangles. Gravity stays as it is. Each step is solved from the shape of the one before, and fabric as a whole
//! and lines are balanced after it as in a trim. The air does not
//! answer to the change of shape, so nothing but the guide at the nose keeps the wing at its angle; what it carries is told.

use glam::DVec3;

use serde::{Deserialize, Serialize};

use super::part::Ended;
use super::trim::Trim;
use crate::case::Scene;
use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::simulation::{Failure, Simulation, StaticLoads, StructureState};
use crate::solve::lbfgs::{Outcome, Progress, Stop, Watch};
use crate::trim::Loads;

/// Largest difference of what the risers carry from what acts, over it; where a step ends with more, it is solved on to half the tolerance.
const BALANCE: f64 = 1e-2;

/// Halvings of the case's tolerance in one step.
const HALVINGS: usize = 6;

/// The wing under a multiple of its loads.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LoadStep {
    /// Multiple of the loads.
    pub load_factor: f64,
    /// How the solve ended; `None` for the wing as it flies, which is not solved anew.
    pub outcome: Option<Outcome>,
    /// Evaluations of all solves of the step.
    pub evaluations: usize,
    /// Energy norm of the fabric's forces at the end, over the loads'; NaN where nothing was solved.
    pub relative_norm: f64,
    /// What the risers carry less what acts, over it.
    pub balance_error: f64,
    /// Pull of the guide along x [N].
    pub guide_n: f64,
    /// Positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Tensions of cables [N], `[cable_count]`.
    pub cable_tensions_n: Vec<f64>,
    /// Largest principal stress [Pa], `[triangle_count]`.
    pub stress_pa: Vec<f64>,
    /// Forces with which the risers are held, right and left [N].
    pub riser_forces_n: [DVec3; 2],
}

impl LoadStep {
    /// True if the solve reached its tolerance, and the risers carry what acts.
    #[must_use]
    pub fn is_balanced(&self) -> bool {
        let converged = self.outcome.is_none_or(|o| o.stop.reached());
        converged && self.balance_error <= BALANCE
    }
}

/// What came of a part of a load test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadTestPart {
    /// The wing stands under the load of the last of [`LoadTest::steps`].
    Loaded,
    /// All loads were tested; the wing flies again as before.
    Ended,
    /// The watcher ended the step: the wing is back where that began.
    Interrupted,
}

/// A load test as far as it has come.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct LoadTest {
    /// From the wing as it flies upwards.
    pub steps: Vec<LoadStep>,
    /// Loads of the equilibrium.
    base: Loads,
    /// Where the wing is in it.
    as_it_flies: StructureState,
}

impl LoadTest {
    /// Begins at the equilibrium that was found; `None` where nothing acts in it.
    pub(super) fn begin(trim: Option<&Trim>, wing: &Wing, simulation: &Simulation) -> Option<Self> {
        let base = if wing.trim.is_some() {
            trim?.flight.as_ref()?.loads.clone()
        } else {
            Loads {
                jumps_pa: wing.load_pa.clone()?,
                nodal_n: Vec::new(),
            }
        };
        Some(Self {
            steps: Vec::new(),
            base,
            as_it_flies: simulation.structure_state(),
        })
    }

    /// True if the test is one of this structure.
    pub(super) fn fits(&self, structure: &Structure) -> bool {
        let nodes = structure.node_count();
        let is_complete = |step: &LoadStep| {
            step.positions_m.len() == nodes
                && step.cable_tensions_n.len() == structure.cables.len()
                && step.stress_pa.len() == structure.triangles.len()
        };
        self.base.fits(structure)
            && self.as_it_flies.fits(structure)
            && self.steps.iter().all(is_complete)
    }

    /// Load factors to come, that of the wing as it flies first.
    fn load_factors(scene: &Scene) -> impl Iterator<Item = f64> {
        let test = scene.wing().and_then(|wing| wing.load_test.as_ref());
        let raised = test.map_or(&[][..], |test| &test.load_factors);
        std::iter::once(1.0).chain(raised.iter().copied())
    }

    /// Loads of the last step that was taken.
    pub(super) fn loads(&self) -> StaticLoads {
        let factor = self.steps.last().map_or(1.0, |step| step.load_factor);
        StaticLoads::Given(times(&self.base, factor))
    }

    /// Raises the loads by one step, or goes back to the equilibrium after the last. `watch` is told of every iteration of the fabric's solver and may end it.
    pub fn advance(
        &mut self,
        scene: &Scene,
        simulation: &mut Simulation,
        watch: Watch,
    ) -> Result<LoadTestPart, Failure> {
        let (Some(load_factor), Some(wing)) = (
            Self::load_factors(scene).nth(self.steps.len()),
            scene.wing(),
        ) else {
            self.leave(simulation);
            return Ok(LoadTestPart::Ended);
        };
        let before = simulation.structure_state();
        let loads = StaticLoads::Given(times(&self.base, load_factor));
        simulation.set_static_loads(Some(loads));
        let solved = if load_factor > 1.0 {
            match solve(scene, simulation, watch)? {
                Ended::With(solved) => solved,
                Ended::NotYet => return Ok(LoadTestPart::Ended),
                Ended::Interrupted => {
                    simulation.put_back(&before);
                    simulation.set_static_loads(Some(self.loads()));
                    return Ok(LoadTestPart::Interrupted);
                }
            }
        } else {
            Solved::default()
        };
        let Some(structure) = simulation.structure_frame().structure else {
            return Ok(LoadTestPart::Ended);
        };
        self.steps.push(LoadStep {
            load_factor,
            outcome: solved.outcome,
            evaluations: solved.evaluations,
            relative_norm: solved.relative_norm,
            balance_error: balance_error(simulation),
            guide_n: simulation.guide_pull_n(),
            riser_forces_n: wing
                .built
                .hang_points
                .map(|node| structure.reactions_n[node as usize]),
            positions_m: structure.positions_m,
            cable_tensions_n: structure.cable_tensions_n,
            stress_pa: structure.stress_pa,
        });
        Ok(LoadTestPart::Loaded)
    }

    /// Goes back to the equilibrium from which the loads were raised.
    pub(super) fn leave(&self, simulation: &mut Simulation) {
        simulation.put_back(&self.as_it_flies);
        simulation.set_static_loads(Some(StaticLoads::Given(self.base.clone())));
    }
}

/// What the solves of a step came to.
struct Solved {
    outcome: Option<Outcome>,
    evaluations: usize,
    relative_norm: f64,
}

impl Default for Solved {
    fn default() -> Self {
        Self {
            outcome: None,
            evaluations: 0,
            relative_norm: f64::NAN,
        }
    }
}

/// Solves to half the tolerance again and again until the risers carry what acts.
fn solve(
    scene: &Scene,
    simulation: &mut Simulation,
    watch: Watch,
) -> Result<Ended<Solved>, Failure> {
    let mut found = Solved::default();
    let mut tolerance = scene.equilibrium.map_or(1.0, |e| e.tolerance);
    for _ in 0..HALVINGS {
        let mut note = |progress: &Progress| {
            found.relative_norm = progress.relative_norm;
            watch(progress)
        };
        let Some(solved) = simulation.solve_static(tolerance, &mut note) else {
            return Ok(Ended::NotYet);
        };
        let solved = solved?;
        if solved.stop == Stop::Interrupted {
            return Ok(Ended::Interrupted);
        }
        found.evaluations += solved.evaluations;
        found.outcome = Some(solved);
        simulation.balance_as_a_whole();
        if solved.stop != Stop::Converged || balance_error(simulation) <= BALANCE {
            break;
        }
        tolerance *= 0.5;
    }
    Ok(Ended::With(found))
}

/// What the risers carry less what acts, over what acts.
fn balance_error(simulation: &Simulation) -> f64 {
    let acts = simulation.acting_n().length();
    if acts > 0.0 {
        simulation.left_over_n().length() / acts
    } else {
        0.0
    }
}

fn times(base: &Loads, factor: f64) -> Loads {
    Loads {
        jumps_pa: base.jumps_pa.iter().map(|jump| factor * jump).collect(),
        nodal_n: base.nodal_n.iter().map(|f| factor * *f).collect(),
    }
}
