//! Fabric and cables at rest: what acts on them in a static equilibrium, its solve, and where they are put for it.

use std::time::Instant;

use glam::DVec3;

use super::cloth::REFRESH_EVERY;
use super::cloth_engine::Met;
use super::coupled::Coupled;
use super::{ClothEngine, Failure, Simulation, StaticLoads, StructureState};
use crate::case::Scene;
use crate::cloth::Structure;
use crate::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use crate::gpu::DeviceError;
use crate::solve::lbfgs::{HISTORY, Outcome, Stop, Watch};

impl Simulation {
    /// Seeks the static equilibrium asked for by the case under the pressure that it prescribes, from where the structure is; `None` if it asks for none.
    /// `watch` is told of every iteration and may end it.
    pub fn equilibrate(&mut self, watch: Watch) -> Option<Result<Outcome, Failure>> {
        let tolerance = self.scene.equilibrium?.tolerance;
        self.place_supports(self.time_s());
        self.static_loads = Some(StaticLoads::Prescribed);
        self.solve_static(tolerance, watch)
    }

    /// Solves the structure at rest under the [`StaticLoads`] that were set; `None` where the case seeks no equilibrium, or has no structure.
    pub fn solve_static(
        &mut self,
        tolerance: f64,
        watch: Watch,
    ) -> Option<Result<Outcome, Failure>> {
        let equilibrium = self.scene.equilibrium?;
        let mut cloth = self.cloth.take()?;
        let mut engine = std::mem::replace(&mut self.cloth_engine, ClothEngine::Host);
        let start = Instant::now();
        let input = StepInput {
            moved_supports: &self.moved_supports,
            ..self.static_input()
        };
        let settings = SolverSettings {
            tolerance,
            displacement_floor_m: if input.gravity_m_s2 == DVec3::ZERO && input.pressure.is_none() {
                // Nothing to be relative to but the mesh: supports drive the structure.
                tolerance * cloth.structure.smallest_element_m()
            } else {
                0.0
            },
            evaluation_limit: equilibrium.evaluation_limit,
            history: HISTORY,
            refresh_every: Some(REFRESH_EVERY),
            initial_hessian: InitialHessian::Multigrid,
        };
        let outcome = engine.solve_watched(&mut cloth, &input, &settings, watch);
        (self.cloth, self.cloth_engine) = (Some(cloth), engine);
        self.cost.equilibrium += start.elapsed();
        Some(match outcome {
            Err(error) => Err(error.into()),
            Ok(outcome) if outcome.stop == Stop::NotFinite => {
                let what = "the fabric's energy is no longer finite".to_owned();
                Err(self.diverged(what).into())
            }
            Ok(outcome) => Ok(outcome),
        })
    }

    /// What acts from here on in static solves and in what frames tell; `None`: nothing but gravity.
    pub fn set_static_loads(&mut self, loads: Option<StaticLoads>) {
        self.static_loads = loads;
    }

    /// Gravity and the [`StaticLoads`] that were set.
    pub(super) fn static_input(&self) -> StepInput<'_> {
        let (pressure, nodal_loads_n) = match &self.static_loads {
            None => (Pressure::None, &[][..]),
            Some(StaticLoads::Prescribed) => (prescribed_pressure(&self.scene), &[][..]),
            Some(StaticLoads::Given(loads)) => {
                (Pressure::Lagged(&loads.jumps_pa), &loads.nodal_n[..])
            }
        };
        StepInput {
            gravity_m_s2: self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO),
            pressure,
            nodal_loads_n,
            ..StepInput::default()
        }
    }

    /// Where the structure is.
    #[must_use]
    pub fn structure_state(&self) -> StructureState {
        self.cloth
            .as_ref()
            .map_or_else(StructureState::default, |cloth| StructureState {
                positions_m: cloth.positions_m.clone(),
                velocities_m_s: cloth.velocities_m_s.clone(),
                guide_anchors_m: cloth.structure.guides.iter().map(|g| g.anchor_m).collect(),
                step_before: cloth.step_before.clone(),
            })
    }

    /// Puts the structure back to where it was.
    pub fn put_back(&mut self, state: &StructureState) {
        if let Some(cloth) = &mut self.cloth {
            state.put_back(cloth);
        }
    }

    /// Puts the nodes that are not held where they are to be solved from, with the guides at rest.
    pub fn place(&mut self, positions_m: &[DVec3]) {
        if let Some(cloth) = &mut self.cloth {
            for (node, place) in positions_m.iter().enumerate() {
                if !cloth.structure.held[node] {
                    cloth.positions_m[node] = *place;
                }
            }
            for guide in &mut cloth.structure.guides {
                let place = cloth.positions_m[guide.node as usize];
                guide.anchor_m = DVec3::new(place.x, guide.anchor_m.y, place.z);
            }
        }
    }

    /// Moves all nodes, held ones too.
    pub fn move_nodes(&mut self, positions_m: Vec<DVec3>) {
        if let Some(cloth) = &mut self.cloth {
            cloth.positions_m = positions_m;
        }
    }

    /// Shifts and turns the structure until the sum of what acts on it is nothing.
    pub fn balance_as_a_whole(&mut self) {
        let Some(mut cloth) = self.cloth.take() else {
            return;
        };
        cloth.balance_as_a_whole(&self.static_input());
        self.cloth = Some(cloth);
    }

    /// What is left of loads, guides and the supports' forces together [N]: what free nodes lack to balance.
    #[must_use]
    pub fn left_over_n(&self) -> DVec3 {
        let cloth = self.cloth.as_ref();
        cloth.map_or(DVec3::ZERO, |cloth| {
            cloth.unbalanced_forces_n(&self.static_input()).iter().sum()
        })
    }

    /// Sum of all loads where the structure is [N].
    #[must_use]
    pub fn acting_n(&self) -> DVec3 {
        let cloth = self.cloth.as_ref();
        cloth.map_or(DVec3::ZERO, |cloth| {
            cloth.loads_n(&self.static_input()).iter().sum()
        })
    }

    /// Sum of the guides' pulls along x [N].
    #[must_use]
    pub fn guide_pull_n(&self) -> f64 {
        let Some(cloth) = &self.cloth else {
            return 0.0;
        };
        let pulls = cloth.structure.guides.iter().map(|guide| {
            guide.stiffness_n_m.x * (guide.anchor_m.x - cloth.positions_m[guide.node as usize].x)
        });
        pulls.sum()
    }

    /// Puts another structure in the place of this one, as it was drawn and at rest.
    pub fn replace_fabric(&mut self, structure: Structure) -> Result<(), DeviceError> {
        self.take_fabric(Cloth::new(structure))?;
        self.haul_risers(self.time_s());
        Ok(())
    }

    /// Goes on with other fabric, on the device too where that solves it.
    pub(super) fn take_fabric(&mut self, cloth: Cloth) -> Result<(), DeviceError> {
        let placement = self.plan.placement.cloth;
        let met = Met {
            cut: matches!(self.coupled, Some(Coupled::Links(_))),
            ..Met::default()
        };
        self.cloth_engine = ClothEngine::new(placement, Some(&cloth), met, self.device.as_ref())?;
        self.cloth = Some(cloth);
        Ok(())
    }
}

/// Pressure that acts in the equilibrium that the case asks for.
fn prescribed_pressure(scene: &Scene) -> Pressure<'_> {
    if let Some(jumps_pa) = scene.wing().and_then(|wing| wing.load_pa.as_ref()) {
        return Pressure::Lagged(jumps_pa);
    }
    if let Some(wing) = scene.imported_wing() {
        return Pressure::PerTriangle(&wing.inside_pa);
    }
    scene
        .equilibrium
        .and_then(|equilibrium| equilibrium.pressure_pa)
        .map_or(Pressure::None, Pressure::Uniform)
}
