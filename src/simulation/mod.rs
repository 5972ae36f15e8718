//! Runs the plan: holds the engines' states and executes the stages of a step in the plan's order.

mod account;
mod across;
mod adaptive;
mod ahead;
mod air;
mod bodies;
mod cadence;
mod change_of_lattice;
mod checkpoint;
mod cloth;
mod cloth_engine;
mod cost;
mod coupled;
mod coupling_stages;
mod cut_bodies;
mod cut_fabric;
mod cut_surface;
mod descent;
mod device_alone;
mod drags;
mod energy;
mod energy_account;
mod failure;
mod frames;
mod impulses;
mod kernel_coupling;
mod levels;
mod link_coupling;
mod looks;
mod markers;
mod meeting;
mod moving_walls;
mod on_device;
mod opening;
mod own_steps;
mod panels;
mod parts;
mod permeable;
mod reach;
mod sliding;
mod standing_walls;
mod state;
mod statics;
mod structure_state;
mod supports;
mod surface_box;
mod wall_velocities;
mod watch;
mod whole_air;

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

pub use account::{Interval, LAST, SolverAccount, UNSOLVED_SHARE, Unsolved};
pub use adaptive::Adaptive;
pub use air::{AirEngine, Balance};
pub use bodies::Load;
pub use cadence::Cadence;
pub use checkpoint::POSITIONS_SECTION;
pub use cloth_engine::ClothEngine;
use cloth_engine::Met;
pub use cost::{Cost, StageCost};
pub use coupled::{Coupled, LeftTheAir};
pub use cut_surface::{CutReaction, CutSurface};
pub use descent::{Descent, Fall};
pub use energy_account::Energies;
use energy_account::EnergyAccount;
pub use failure::{Diverged, Failure};
use impulses::Acting;
pub use impulses::{BodyImpulse, ImpulseSample, Impulses};
pub use kernel_coupling::KernelCoupling;
pub use levels::Levels;
pub use link_coupling::LinkCoupling;
pub use markers::MarkerEngine;
pub use opening::Opening;
use own_steps::OwnSteps;
pub use structure_state::{StaticLoads, StructureState};
use watch::Watch;

use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow};
use crate::cpu::cloth::{Cloth, NodalDrag};
use crate::gpu::{Device, DeviceError};
use crate::plan::{Plan, PlannedStage, Stage, capabilities};

/// One step in so many is timed where a device works while the host goes on; a prime, to meet all cadences alike.
const TIMED_INTERVAL: u64 = 31;
const TIMED_INTERVAL_OF_OWN_STEPS: u64 = 251;

/// Where steps and time are counted from: the release, or the last change of the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Its step.
    pub step: u64,
    /// Time since release then [s].
    pub time_s: f64,
}

/// A scene in motion.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    plan: Plan,
    air: Option<Levels>,
    cloth: Option<Cloth>,
    cloth_engine: ClothEngine,
    device: Option<Arc<Device>>,
    coupled: Option<Coupled>,
    /// Present where several steps of the air may pass between solves of the fabric.
    cadence: Option<Cadence>,
    /// Present where steps of the fabric choose their own length.
    adaptive: Option<Adaptive>,
    /// Where supports are to be at the end of the solve.
    moved_supports: Vec<(u32, DVec3)>,
    impulses: Option<Impulses>,
    descent: Option<Descent>,
    /// Drag of payload and lines in the step.
    drags: Vec<NodalDrag>,
    /// Present where a device may make steps by itself.
    own_steps: Option<OwnSteps>,
    opening: Option<Opening>,
    origin: Origin,
    step: u64,
    /// Step at which the caller reads the air next; `None` where it has never said so.
    next_reading: Option<u64>,
    /// Looks for a flow that breaks down.
    watch: Watch,
    /// Last step at which all air was looked at and found sound.
    sound_step: u64,
    /// Farthest that a marker moved between two solves of the fabric [cells].
    largest_marker_motion: f64,
    /// What acts on the structure at rest; `None` until an equilibrium is sought.
    static_loads: Option<StaticLoads>,
    cost: Cost,
    account: SolverAccount,
    energy: EnergyAccount,
}

impl Simulation {
    /// Sets a scene up as planned; opens a folded canopy by the loading-pressure method.
    pub fn new(scene: Scene, plan: Plan, device: Option<Arc<Device>>) -> Result<Self, Failure> {
        let mut simulation = Self::as_drawn(scene, plan, device)?;
        simulation.open_canopy()?;
        Ok(simulation)
    }

    /// Sets a scene up as planned, with a folded canopy as it was drawn.
    pub fn as_drawn(
        scene: Scene,
        plan: Plan,
        device: Option<Arc<Device>>,
    ) -> Result<Self, Failure> {
        capabilities::check(&scene, &plan.placement)?;
        let device_before = device.as_ref().map(|d| d.work()).unwrap_or_default();
        let air = scene
            .air
            .as_ref()
            .map(|air| Levels::of_air(air, &plan, device.as_ref(), None))
            .transpose()?;
        let cloth = scene
            .body
            .as_ref()
            .map(|body| Cloth::new(body.structure.clone()));
        let mut simulation = Self::assemble(scene, plan, device, air, cloth)?;
        simulation.cost.device_before = device_before;
        if simulation.plan.start_steps == 0 {
            simulation.start_impulses()?;
        }
        Ok(simulation)
    }

    /// Opens a folded canopy by the loading-pressure method, where the case asks for it.
    pub fn open_canopy(&mut self) -> Result<(), Failure> {
        let settings = self.step_settings();
        let (Some(cloth), Some(body)) = (&mut self.cloth, &self.scene.body) else {
            return Ok(());
        };
        let BodyKind::Canopy(canopy) = &body.kind else {
            return Ok(());
        };
        let Some(loading) = &canopy.loading else {
            return Ok(());
        };
        // Small fabric has short loops: on one of the threads that compute, none has to wake another and wait for it.
        let opening = rayon::scope(|_| opening::open(cloth, canopy, loading, &settings));
        let opening = opening.map_err(Failure::Start)?;
        self.opening = Some(opening);
        if self.plan.start_steps == 0 {
            self.start_impulses()?;
        }
        Ok(())
    }

    /// Puts a simulation together from its air and its fabric, at step 0; markers and impulses follow from them.
    fn assemble(
        scene: Scene,
        plan: Plan,
        device: Option<Arc<Device>>,
        air: Option<Levels>,
        cloth: Option<Cloth>,
    ) -> Result<Self, Failure> {
        let mut coupled = match (&scene.air, &air, &scene.coupling) {
            (Some(air), Some(engine), Some(coupling)) => {
                let coupling = (coupling, &plan);
                Some(Coupled::new(&scene, air, engine.finest(), coupling)?)
            }
            _ => None,
        };
        let markers: Vec<_> = coupled
            .iter()
            .flat_map(Coupled::markers)
            .map(|marker| (marker.triangle, marker.weights))
            .collect();
        let kernel = coupled.as_ref().and_then(Coupled::kernel);
        let met = Met {
            markers: &markers,
            in_air: kernel
                .filter(|_| plan.reacts_on_device())
                .and_then(KernelCoupling::in_air),
            cut: matches!(coupled, Some(Coupled::Links(_))),
        };
        let mut cloth_engine =
            ClothEngine::new(plan.placement.cloth, cloth.as_ref(), met, device.as_ref())?;
        let impulses = match (&scene.air, &air, &coupled) {
            (Some(settings), Some(engine), Some(_)) => {
                let finest = engine.finest();
                Some(Impulses::new(settings, &scene, finest, cloth.as_ref())?)
            }
            _ => None,
        };
        let descent = match (&scene.descent, &scene.air) {
            (Some(settings), Some(air)) => {
                let speed_m_s = match air.flow {
                    Flow::WindTunnel { speed_m_s, .. } => speed_m_s,
                    Flow::TaylorGreen { .. } => 0.0,
                };
                Some(Descent::new(settings.clone(), &air.units, speed_m_s))
            }
            _ => None,
        };
        let fabric = (&mut cloth_engine, cloth.as_ref());
        let own_steps = OwnSteps::new((&scene, &plan), coupled.as_mut(), fabric)?;
        let adaptive = Adaptive::of(&scene);
        let every = plan.every(Stage::SolveCloth).unwrap_or(1);
        let cadence = (every > 1).then(|| Cadence::new(every, plan.start_steps));
        Ok(Self {
            origin: Origin {
                step: plan.start_steps,
                time_s: 0.0,
            },
            cadence,
            adaptive,
            moved_supports: Vec::new(),
            descent,
            drags: Vec::new(),
            own_steps,
            scene,
            plan,
            air,
            cloth,
            cloth_engine,
            device,
            coupled,
            impulses,
            opening: None,
            step: 0,
            next_reading: None,
            watch: Watch::default(),
            sound_step: 0,
            largest_marker_motion: 0.0,
            static_loads: None,
            cost: Cost::default(),
            account: SolverAccount::default(),
            energy: EnergyAccount::default(),
        })
    }

    /// Impulses and balances count from release.
    fn start_impulses(&mut self) -> Result<(), DeviceError> {
        if let (Some(air), Some(impulses)) = (&self.air, &mut self.impulses) {
            impulses.start(air.finest())?;
        }
        Ok(())
    }

    /// Impulses of the three force routes now; `None` before release and where nothing is coupled.
    pub fn impulse_sample(&mut self) -> Result<Option<ImpulseSample>, DeviceError> {
        let (released, time_s) = (self.released(), self.time_s());
        match (&mut self.impulses, &self.air) {
            (Some(impulses), Some(air)) if released => Ok(Some(impulses.sample(
                air.finest(),
                self.cloth.as_ref(),
                &self.scene.rigid_bodies,
                time_s,
            )?)),
            _ => Ok(None),
        }
    }

    /// [`Simulation::advance`] on one of the threads that compute: from any other every parallel loop would wake one, and wait for it.
    pub fn advance_among_threads(&mut self) -> Result<(), Failure> {
        rayon::scope(|_| self.advance())
    }

    /// One step: the plan's stages in the plan's order, or one of those that a device made by itself.
    pub fn advance(&mut self) -> Result<(), Failure> {
        if !self.own_steps_are_ahead() {
            self.begin_own_steps()?;
        }
        if self.own_steps_are_ahead() {
            return self.account_own_step();
        }
        let timed = self.times_step(self.step);
        if let (true, Some(device)) = (timed, &self.device) {
            // What earlier steps left in the queue is not this step's.
            device.wait()?;
        }
        // While the wind rises no fabric is solved, which is not what a step asks for.
        let counted = self.released();
        let mut asked = self.device_work();
        for i in 0..self.plan.stages.len() {
            let planned = self.plan.stages[i];
            let due = self.is_due(planned);
            let start = Instant::now();
            match planned.stage {
                Stage::EddyViscosity => self.eddy_viscosity()?,
                Stage::CollideStream => self.collide_stream()?,
                Stage::CoarserLevels => self.coarser_levels()?,
                Stage::FindLinks => self.find_links()?,
                Stage::ReadLinks => self.read_links()?,
                Stage::CollideAhead => self.collide_ahead()?,
                Stage::FetchLinks => self.fetch_links()?,
                Stage::Bounce => self.bounce()?,
                Stage::FetchWallForces => self.fetch_wall_forces()?,
                Stage::SendMarkers => self.send_markers()?,
                Stage::Interpolate => self.interpolate()?,
                Stage::FetchAirVelocities => self.fetch_air_velocities()?,
                Stage::SendNodes => self.send_nodes()?,
                Stage::SolveCloth => self.solve_cloth()?,
                Stage::FetchNodes => self.fetch_nodes()?,
                Stage::SendMarkerForces => self.send_marker_forces(),
                Stage::Spread => self.spread()?,
                Stage::RepeatForcing => self.repeat_forcing()?,
                Stage::FetchMarkerForces => self.fetch_marker_forces()?,
                Stage::Measure => self.accumulate()?,
                // Files belong to the caller, which sees frames.
                Stage::Output => {}
            }
            let asked_before = asked;
            asked = self.device_work();
            if counted {
                self.cost.stages[planned.stage as usize].device += asked.since(&asked_before);
            }
            if !timed {
                continue;
            }
            if let Some(device) = &self.device {
                device.wait()?;
                asked = device.work();
            }
            let elapsed = start.elapsed();
            let cost = &mut self.cost.stages[planned.stage as usize];
            cost.time += elapsed;
            cost.calls += u64::from(due);
            match planned.stage {
                Stage::EddyViscosity
                | Stage::CollideStream
                | Stage::CoarserLevels
                | Stage::CollideAhead => self.cost.fluid += elapsed,
                Stage::FindLinks
                | Stage::ReadLinks
                | Stage::FetchLinks
                | Stage::Bounce
                | Stage::FetchWallForces
                | Stage::SendMarkers
                | Stage::Interpolate
                | Stage::FetchAirVelocities
                | Stage::SendMarkerForces
                | Stage::Spread
                | Stage::RepeatForcing
                | Stage::FetchMarkerForces => self.cost.coupling += elapsed,
                Stage::SendNodes | Stage::SolveCloth | Stage::FetchNodes => {
                    self.cost.cloth += elapsed;
                }
                Stage::Measure | Stage::Output => self.cost.measure += elapsed,
            }
        }
        if timed {
            self.cost.timed_steps += 1;
            self.cost.timed_cells += self.plan.sizes.updates;
        }
        if let Some(descent) = self
            .descent
            .as_mut()
            .filter(|_| self.step >= self.plan.start_steps)
        {
            descent.end_step();
        }
        self.end_step(counted)
    }

    /// The step is done; it counts if the structure was solved in it.
    fn end_step(&mut self, counted: bool) -> Result<(), Failure> {
        self.step += 1;
        self.cost.steps += u64::from(counted);
        if self.step == self.plan.start_steps {
            self.start_impulses()?;
        }
        self.watch()
    }

    /// True if a stage has work in this step.
    fn is_due(&self, planned: PlannedStage) -> bool {
        match planned.stage {
            Stage::EddyViscosity => self.step.is_multiple_of(u64::from(planned.every)),
            Stage::SendNodes | Stage::SolveCloth | Stage::FetchNodes => self.solves_now(),
            _ => true,
        }
    }

    /// Without a device every step is timed. With one, timing has to wait for it after every stage, which costs time itself.
    fn times_step(&self, step: u64) -> bool {
        let interval = self.timed_interval();
        self.device.is_none() || step % interval == interval - 1
    }

    /// Where a device makes steps by itself, those that are timed are made with the host. They break its series, and are rarer.
    const fn timed_interval(&self) -> u64 {
        match self.own_steps {
            Some(_) => TIMED_INTERVAL_OF_OWN_STEPS,
            None => TIMED_INTERVAL,
        }
    }

    /// The first step from the present one on that is timed.
    const fn next_timed_step(&self) -> u64 {
        (self.step + 1).next_multiple_of(self.timed_interval()) - 1
    }

    /// True while a device has made steps by itself that are not accounted for.
    fn own_steps_are_ahead(&self) -> bool {
        self.own_steps.as_ref().is_some_and(OwnSteps::are_ahead)
    }

    /// The air counts its steps itself, and knows when the stage is due.
    fn eddy_viscosity(&mut self) -> Result<(), DeviceError> {
        let air = self.air.as_mut();
        air.map_or(Ok(()), |air| air.finest_mut().eddy_viscosity())
    }

    fn collide_stream(&mut self) -> Result<(), DeviceError> {
        if let (Some(descent), Some(air)) = (&mut self.descent, &self.scene.air)
            && self.step >= self.plan.start_steps
        {
            let density = air.units.density_kg_m3;
            descent.begin_step(self.cloth.as_ref(), self.coupled.as_ref(), density);
        }
        self.gather_drags();
        self.set_inlet_velocity(self.step);
        let acceleration = self.acceleration();
        let start_steps = self.plan.start_steps;
        let Some(air) = &mut self.air else {
            return Ok(());
        };
        let markers = self.coupled.as_ref().and_then(Coupled::immersed);
        air.collide_stream(acceleration, markers)?;
        if self.step >= start_steps {
            self.add_delivered();
        }
        Ok(())
    }

    /// The air has just got the forces of the markers that the last step spread.
    fn add_delivered(&mut self) {
        let time_s = self.time_s();
        if let (Some(impulses), Some(coupled @ Coupled::Kernel(_))) =
            (&mut self.impulses, &self.coupled)
        {
            impulses.add_delivered(coupled, time_s);
        }
    }

    /// Wind at the inlet of the outermost lattice in a `step` of the finest one.
    fn set_inlet_velocity(&mut self, step: u64) {
        // The ghosts of the inlet stand for cells after the collision of the outermost lattice, which ends with the wind of its next step.
        let outer = self.scene.air.as_ref().map_or(1, Air::steps_per_outer);
        let wind = DVec3::X * self.wind_speed_at((step / outer + 1) * outer);
        if let (Some(air), Some(settings)) = (&mut self.air, &self.scene.air)
            && let Flow::WindTunnel { .. } = settings.flow
        {
            let velocity = settings.units.velocity_to_lattice(wind);
            air.engine_mut().set_inlet_velocity(velocity);
        }
    }

    /// All air is accelerated alike (or as an inlet profile has it), so that the wind rises everywhere at once; and as a box that falls is
    /// [cells per step²].
    fn acceleration(&self) -> Option<[f64; 3]> {
        let settings = self.scene.air.as_ref()?;
        let Flow::WindTunnel { speed_m_s, .. } = settings.flow else {
            return None;
        };
        let start_steps = self.plan.start_steps;
        if let Some(descent) = self.descent.as_ref().filter(|_| self.step >= start_steps) {
            let gain = descent.apparent_m_s2() * settings.units.time_step_s;
            return Some(settings.units.velocity_to_lattice(gain));
        }
        let rises = self.step < start_steps && speed_m_s > 0.0;
        rises.then(|| {
            let wind = settings.units.velocity_to_lattice(DVec3::X * speed_m_s)[0];
            [wind / start_steps as f64, 0.0, 0.0]
        })
    }

    fn coarser_levels(&mut self) -> Result<(), DeviceError> {
        let acceleration = self.acceleration();
        if let Some(air) = &mut self.air {
            air.coarser_levels(acceleration)?;
        }
        Ok(())
    }

    fn accumulate(&mut self) -> Result<(), DeviceError> {
        if self.step < self.plan.start_steps {
            return Ok(());
        }
        let acting = Acting {
            gravity_m_s2: self.felt_gravity_m_s2(),
            apparent_m_s2: self.descent.as_ref().map(Descent::apparent_m_s2),
            damping_1_s: self.scene.solver.damping_1_s,
            drags: &self.drags,
        };
        let (Some(air), Some(coupled), Some(impulses)) =
            (&self.air, &self.coupled, &mut self.impulses)
        else {
            return Ok(());
        };
        // Solves that span several steps give it once.
        let given = self
            .cloth
            .as_mut()
            .map(|cloth| &mut cloth.momentum_given_kg_m_s);
        let given_kg_m_s = given.map(std::mem::take).unwrap_or_default();
        let cloth = (self.cloth.as_ref(), given_kg_m_s);
        impulses.add_step(air.finest(), cloth, &acting, coupled)
    }

    fn diverged(&self, what: String) -> Diverged {
        Diverged {
            time_s: self.time_s(),
            step: self.step,
            what,
        }
    }
}
