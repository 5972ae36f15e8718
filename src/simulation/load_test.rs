//! The load test of a wing: the loads of its equilibrium several times over, with the risers held as on a test rig.
//!
//! Pressure, traction and drag of lines are those of the trim (or the prescribed ones) times the load factor, as if the air came faster by its square root
//! under the same angle; pressure turns with the triangles. Gravity stays as it is. Each step is solved from the shape of the one before, and fabric as a whole
//! and lines are balanced after it as in a trim. The air does not
//! answer to the change of shape, so nothing but the guide at the nose keeps the wing at its angle; what it carries is told.

use glam::DVec3;

use super::{Failure, Simulation};
use crate::case::wing::Wing;
use crate::solve::lbfgs::{Outcome, Progress, Stop, Watch};
use crate::trim::Loads;

/// Largest difference of what the risers carry from what acts, over it; where a step ends with more, it is solved on to half the tolerance.
const BALANCE: f64 = 1e-2;

/// Halvings of the case's tolerance in one step.
const HALVINGS: usize = 6;

/// The wing under a multiple of its loads.
#[derive(Debug, Clone)]
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
        let converged = self.outcome.is_none_or(|o| o.stop == Stop::Converged);
        converged && self.balance_error <= BALANCE
    }
}

/// A load test as far as it has come.
#[derive(Debug, Clone, Default)]
pub struct LoadTestState {
    /// What acts now; `None`: the loads of the equilibrium.
    loads: Option<Loads>,
    /// From the wing as it flies upwards.
    pub steps: Vec<LoadStep>,
}

impl LoadTestState {
    /// What acts now in place of the loads of the equilibrium.
    pub(super) const fn loads(&self) -> Option<&Loads> {
        self.loads.as_ref()
    }
}

impl Simulation {
    /// The load test as far as it has come; `None` where none was begun.
    #[must_use]
    pub const fn load_test_state(&self) -> Option<&LoadTestState> {
        self.load_test.as_ref()
    }

    /// Raises the loads of the equilibrium that was found, step by step, and goes back to it; `None` if the case asks for no load test, or nothing acts.
    /// `watch` is told of every iteration of the fabric's solver and may end it, `report` of every step, while the wing stands under its load. True: all
    /// steps were taken.
    pub fn test_loads(
        &mut self,
        watch: Watch,
        report: &mut dyn FnMut(&Self, &LoadStep) -> Result<(), Failure>,
    ) -> Option<Result<bool, Failure>> {
        let wing = self.scene.wing.take()?;
        let base = self.base_loads(&wing);
        let asked = wing.load_test.clone().zip(base);
        let ended = asked.map(|(test, base)| {
            let as_it_flies = self.state();
            self.load_test = Some(LoadTestState::default());
            let ended = self.raise_loads(&wing, &base, &test.load_factors, watch, report);
            if let Some(cloth) = &mut self.cloth {
                as_it_flies.put_back(cloth);
            }
            if let Some(state) = &mut self.load_test {
                state.loads = None;
            }
            ended
        });
        self.scene.wing = Some(wing);
        ended
    }

    /// Loads of the equilibrium, those of a trim if there is one.
    fn base_loads(&self, wing: &Wing) -> Option<Loads> {
        if wing.trim.is_some() {
            let flight = self.trim_state()?.flight.as_ref()?;
            return Some(flight.loads.clone());
        }
        wing.load_pa.as_ref().map(|jumps_pa| Loads {
            jumps_pa: jumps_pa.clone(),
            nodal_n: Vec::new(),
        })
    }

    fn raise_loads(
        &mut self,
        wing: &Wing,
        base: &Loads,
        load_factors: &[f64],
        watch: Watch,
        report: &mut dyn FnMut(&Self, &LoadStep) -> Result<(), Failure>,
    ) -> Result<bool, Failure> {
        for &load_factor in [1.0].iter().chain(load_factors) {
            if let Some(state) = &mut self.load_test {
                state.loads = Some(times(base, load_factor));
            }
            let mut evaluations = 0;
            let mut relative_norm = f64::NAN;
            let mut outcome = None;
            if load_factor > 1.0 {
                let mut tolerance = self.scene.equilibrium.map_or(1.0, |e| e.tolerance);
                for _ in 0..HALVINGS {
                    let mut note = |progress: &Progress| {
                        relative_norm = progress.relative_norm;
                        watch(progress)
                    };
                    let Some(solved) = self.solve_static(tolerance, &mut note) else {
                        return Ok(false);
                    };
                    let solved = solved?;
                    evaluations += solved.evaluations;
                    outcome = Some(solved);
                    if solved.stop == Stop::Interrupted {
                        return Ok(false);
                    }
                    self.balance_as_a_whole();
                    if solved.stop != Stop::Converged || self.balance_error() <= BALANCE {
                        break;
                    }
                    tolerance *= 0.5;
                }
            }
            let Some(structure) = self.structure_frame().structure else {
                return Ok(false);
            };
            let step = LoadStep {
                load_factor,
                outcome,
                evaluations,
                relative_norm,
                balance_error: self.balance_error(),
                guide_n: self.guide_pull_n(),
                riser_forces_n: wing
                    .wing
                    .hang_points
                    .map(|node| structure.reactions_n[node as usize]),
                positions_m: structure.positions_m,
                cable_tensions_n: structure.cable_tensions_n,
                stress_pa: structure.stress_pa,
            };
            report(self, &step)?;
            if let Some(state) = &mut self.load_test {
                state.steps.push(step);
            }
        }
        Ok(true)
    }

    /// What the risers carry less what acts, over what acts.
    fn balance_error(&self) -> f64 {
        let acts = self.acting_n().length();
        if acts > 0.0 {
            self.left_over_n().length() / acts
        } else {
            0.0
        }
    }
}

fn times(base: &Loads, factor: f64) -> Loads {
    Loads {
        jumps_pa: base.jumps_pa.iter().map(|jump| factor * jump).collect(),
        nodal_n: base.nodal_n.iter().map(|f| factor * *f).collect(),
    }
}
