//! Phases of a run without time: static equilibrium, trim, panel shaping, load test. Each goes part by part, and its state can be saved between two parts:
//! an interrupted part is taken back to its beginning.

mod load_test;
mod panel_shaping;
mod part;
mod trim;

use std::io;

use serde::{Deserialize, Serialize};

pub use load_test::{LoadStep, LoadTest, LoadTestPart};
pub use panel_shaping::{PanelShaping, ShapingStep};
pub use trim::{Trim, TrimEnd, TrimIteration, TrimPart};

use crate::case::Scene;
use crate::case::wing_design::Ballooning;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::gpu::DeviceError;
use crate::simulation::{Failure, Simulation, StaticLoads, StructureState};
use crate::solve::lbfgs::{Outcome, Stop};

/// States of these phases; those that a run has not reached, or does not have, are absent.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Statics {
    /// How the static equilibrium ended; `None` before it did, and while it is sought.
    pub equilibrium: Option<Outcome>,
    /// A trim has taken place, or does.
    pub trim: Option<Trim>,
    /// Panels that were cut anew, or are.
    pub shaping: Option<PanelShaping>,
    /// Loads were raised, or are.
    pub load_test: Option<LoadTest>,
}

/// Name of the states in a checkpoint.
const STATICS: &str = "statics";

/// Where guides rest, in a checkpoint.
const GUIDE_ANCHORS: &str = "guide_anchors";

/// What a checkpoint says whose lengths are not those of the case.
const OTHER_WING: &str = "its static phases are not those of the case's structure";

impl Statics {
    /// True if the states are those of the structure of `scene`.
    fn fits(&self, scene: &Scene) -> bool {
        let Some(body) = &scene.body else {
            return self.trim.is_none() && self.shaping.is_none() && self.load_test.is_none();
        };
        let structure = &body.structure;
        let mut cut = self.cut().into_iter().flatten();
        let is_cut = |side: &Vec<[f64; 2]>| {
            !side.is_empty() && side.iter().flatten().all(|number| number.is_finite())
        };
        cut.all(is_cut)
            && self.trim.as_ref().is_none_or(|trim| trim.fits(scene))
            && self
                .load_test
                .as_ref()
                .is_none_or(|test| test.fits(structure))
    }

    /// Seeks the static equilibrium that the case asks for; `None` if it asks for none. `watch` is told of every iteration and may end it; the structure
    /// then stays where it came to.
    pub fn equilibrate(
        &mut self,
        simulation: &mut Simulation,
        watch: crate::solve::lbfgs::Watch,
    ) -> Option<Result<Outcome, Failure>> {
        self.equilibrium = None;
        let solved = simulation.equilibrate(watch);
        let ended = solved.as_ref().and_then(|solved| solved.as_ref().ok());
        self.equilibrium = ended.copied().filter(|o| o.stop != Stop::Interrupted);
        solved
    }

    /// The trim that is under way; begun from the coarsest mesh if none is. One of panels that were cut anew starts on the wing's own mesh, from where it flew.
    pub fn trim(
        &mut self,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<&mut Trim, DeviceError> {
        let trim = match self.trim.take() {
            Some(trim) => trim,
            None => Trim::begin(scene, simulation, self.cut().is_none())?,
        };
        Ok(self.trim.insert(trim))
    }

    /// Ballooning of the panels that are sewn now; `None`: that of the plan.
    #[must_use]
    pub fn cut(&self) -> Option<&Ballooning> {
        self.shaping.as_ref()?.cut.as_ref()
    }

    /// Cuts of the panels whose flight was read.
    #[must_use]
    pub fn shaping_steps(&self) -> &[ShapingStep] {
        self.shaping.as_ref().map_or(&[], |shaping| &shaping.steps)
    }

    /// True while the equilibrium, or the trim, of the panels that were cut last is not found.
    #[must_use]
    pub fn has_unbalanced_cut(&self) -> bool {
        self.shaping
            .as_ref()
            .is_some_and(|shaping| shaping.is_unbalanced)
    }

    /// Notes that the equilibrium of the panels that were cut last is found, or cannot be.
    pub fn cut_is_balanced(&mut self) {
        if let Some(shaping) = &mut self.shaping {
            shaping.is_unbalanced = false;
        }
    }

    /// Notes what came of a cut.
    pub fn note_shaping(&mut self, step: ShapingStep) {
        let shaping = self.shaping.get_or_insert_default();
        shaping.steps.push(step);
    }

    /// Sews the wing with panels of another ballooning; what it comes to has to be found anew.
    pub fn recut(
        &mut self,
        simulation: &mut Simulation,
        ballooning: Ballooning,
    ) -> Result<(), Failure> {
        simulation.reshape_panels(ballooning.clone())?;
        self.trim = None;
        self.equilibrium = None;
        let shaping = self.shaping.get_or_insert_default();
        shaping.cut = Some(ballooning);
        shaping.is_unbalanced = true;
        Ok(())
    }

    /// The load test that is under way, begun if none is; `None` where there are no loads of an equilibrium.
    pub fn load_test(&mut self, scene: &Scene, simulation: &Simulation) -> Option<&mut LoadTest> {
        if self.load_test.is_none() {
            let wing = scene.wing()?;
            self.load_test = LoadTest::begin(self.trim.as_ref(), wing, simulation);
        }
        self.load_test.as_mut()
    }

    /// Ends a run that does not go on here: the wing's own mesh, and the loads of its equilibrium, for all that reads the structure. Of a trim on a coarser
    /// mesh nothing is left to be read.
    pub fn leave(&mut self, scene: &Scene, simulation: &mut Simulation) -> Result<(), DeviceError> {
        if let Some(trim) = self.trim.take_if(|trim| trim.coarser() > 0) {
            trim.leave_mesh(scene, simulation)?;
            simulation.set_static_loads(Some(StaticLoads::Prescribed));
        }
        if let Some(test) = &self.load_test {
            test.leave(simulation);
        }
        Ok(())
    }

    /// Writes the states.
    pub fn save(&self, simulation: &Simulation, out: &mut Writer) -> io::Result<()> {
        let bytes = postcard::to_stdvec(self).map_err(io::Error::other)?;
        out.put(STATICS, &bytes)?;
        out.put(GUIDE_ANCHORS, &simulation.structure_state().guide_anchors_m)
    }

    /// Takes the states from a checkpoint, and prepares a simulation to take its own: with the mesh, the panels and the loads that it had.
    pub fn restore(
        from: &Reader,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<Self, RestoreError> {
        let bytes: Vec<u8> = from.take(STATICS)?;
        let statics: Self = postcard::from_bytes(&bytes)
            .map_err(|error| from.damaged(format!("its static phases cannot be read: {error}")))?;
        if !statics.fits(scene) {
            return Err(from.damaged(OTHER_WING.to_owned()).into());
        }
        if let Some(cut) = statics.cut() {
            simulation.reshape_panels(cut.clone())?;
        }
        if let Some(trim) = &statics.trim {
            trim.take_mesh(scene, simulation).map_err(Failure::Device)?;
        }
        let loads = match (&statics.load_test, &statics.trim, &statics.equilibrium) {
            (Some(test), ..) => Some(test.loads()),
            (None, Some(trim), _) => Some(trim.loads()),
            (None, None, Some(_)) => Some(StaticLoads::Prescribed),
            (None, None, None) => None,
        };
        simulation.set_static_loads(loads);
        let anchors_m = from.take(GUIDE_ANCHORS)?;
        let state = simulation.structure_state();
        if anchors_m.len() != state.guide_anchors_m.len() {
            return Err(from.damaged(OTHER_WING.to_owned()).into());
        }
        simulation.put_back(&StructureState {
            guide_anchors_m: anchors_m,
            ..state
        });
        Ok(statics)
    }
}

/// Why states could not be taken from a checkpoint.
#[derive(Debug, thiserror::Error)]
pub enum RestoreError {
    /// The checkpoint does not hold them.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The structure could not be put together as it was.
    #[error(transparent)]
    Failure(#[from] Failure),
}
