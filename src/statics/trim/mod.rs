//! The trim of a wing: air and fabric in turn, until speed, glide, pitch and shape stand still.
//!
//! An outer iteration takes the shape, finds its glide ([`crate::trim`]), turns the structure to the attitude that balances, lets the guide at the nose
//! rest there, and solves the fabric from where it is under the loads of that glide. The loads stand during the solve; pressure is renewed on the
//! turned triangles until it stands still. The solver's energy norm hardly sees what stiff lines carry, so fabric as a whole and lines are balanced after it
//! ([`Simulation::balance_as_a_whole`]), and where the risers still do not carry what acts, the fabric is solved to half the tolerance in the next
//! iteration. Coarser meshes of the same plan come first, each starting from the one before: what takes most evaluations from the drawn shape, the
//! way of whole panels and of the wing, is found where an evaluation is cheap.

mod changes;
mod iteration;

use std::time::Instant;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::part::Ended;
use crate::case::Scene;
use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::geometry::wing::carried_over::{Meshed, carried_over};
use crate::gpu::DeviceError;
use crate::simulation::{Failure, Simulation, StaticLoads, StructureState};
use crate::solve::lbfgs::{Progress, Stop, Watch};
use crate::trim::{Flight, Glider, Settings};
use changes::{changes, moving};
pub use iteration::TrimIteration;

/// Least share of the case's tolerance to which the fabric is solved.
const LEAST_TOLERANCE: f64 = 1.0 / 64.0;

/// A fall of the coefficient of the pressure inside, from the first iteration to the last, of which a refusal tells. That of one wing differs by as much at most between
/// panels and meshes (docs/results/2026-11-27-pressure-inside-ram-air-wings.md).
const LOST_PRESSURE: f64 = 0.2;

/// What a trim lacks where the scene has none to be sought.
const NO_WING: &str = "there is no wing whose fabric could be solved";

/// How a trim ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrimEnd {
    /// Everything stands still.
    Settled,
    /// The iterations allowed are used up; what still moves.
    Moving(String),
    /// The air, or the balance, has no answer.
    Refused(String),
}

/// What came of a part of a trim.
#[derive(Debug, Clone, PartialEq)]
pub enum TrimPart {
    /// An outer iteration; more are to come.
    Iterated,
    /// The trim on a coarser mesh is over; the next finer one has begun.
    Refined,
    /// The trim is over.
    Ended(TrimEnd),
    /// The watcher ended the iteration: the wing is back where that began.
    Interrupted,
}

/// A trim as far as it has come.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Trim {
    /// The last glide on this mesh; `None` before the first.
    pub flight: Option<Flight>,
    /// Outer iterations on this mesh.
    pub iterations: Vec<TrimIteration>,
    /// Meshes left until the wing's own.
    coarser: usize,
    /// Where the wing's own mesh stood when the trim began, while a coarser one is in its place.
    begun_from: Option<StructureState>,
    /// Nodes of the panels that the air saw last [m].
    seen_m: Option<Vec<DVec3>>,
    /// Angle of the stream at which the next glide is searched for from [rad].
    stream_rad: Option<f64>,
    /// To which the fabric is solved next, over that of the case.
    tolerance_share: f64,
    /// How the trim on this mesh ended.
    ended: Option<TrimEnd>,
}

impl Trim {
    /// Begins a trim on the coarsest mesh that there is, or on the one that there is now.
    pub(super) fn begin(
        scene: &Scene,
        simulation: &mut Simulation,
        from_coarser: bool,
    ) -> Result<Self, DeviceError> {
        simulation.set_static_loads(Some(StaticLoads::Prescribed));
        let coarser = scene
            .wing()
            .filter(|_| from_coarser)
            .map_or(0, coarser_meshes);
        let trim = Self {
            coarser,
            begun_from: (coarser > 0).then(|| simulation.structure_state()),
            tolerance_share: 1.0,
            ..Self::default()
        };
        trim.take_mesh(scene, simulation)?;
        Ok(trim)
    }

    /// True if the trim is one of the wing of `scene`.
    pub(super) fn fits(&self, scene: &Scene) -> bool {
        let (Some(wing), Some(body)) = (scene.wing(), &scene.body) else {
            return false;
        };
        let own = &body.structure;
        let present = mesh(wing, self.coarser).1.unwrap_or(own);
        let begun = self.begun_from.as_ref();
        self.coarser <= coarser_meshes(wing)
            && (0.0..=1.0).contains(&self.tolerance_share)
            && begun.is_some() == (self.coarser > 0)
            && begun.is_none_or(|state| state.fits(own))
            && self.flight.as_ref().is_none_or(|flight| {
                let outer = &flight.outer;
                flight.loads.fits(present)
                    && outer.coefficients.len() >= flight.strips.len() * outer.around.len()
            })
    }

    /// Puts the coarser mesh that the trim is on into the simulation; leaves the wing's own where it is.
    pub(super) fn take_mesh(
        &self,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<(), DeviceError> {
        let found = scene.wing().map(|wing| mesh(wing, self.coarser));
        match found {
            Some((_, Some(structure))) => simulation.replace_fabric(structure.clone()),
            _ => Ok(()),
        }
    }

    /// Brings the wing's own mesh back, as it was before the trim.
    pub(super) fn leave_mesh(
        &self,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<(), DeviceError> {
        let (Some(begun_from), Some(body)) = (&self.begun_from, &scene.body) else {
            return Ok(());
        };
        simulation.replace_fabric(body.structure.clone())?;
        simulation.put_back(begun_from);
        Ok(())
    }

    /// Loads of the last glide.
    pub(super) fn loads(&self) -> StaticLoads {
        match &self.flight {
            Some(flight) => StaticLoads::Given(flight.loads.clone()),
            None => StaticLoads::Prescribed,
        }
    }

    /// Meshes left until the wing's own.
    #[must_use]
    pub const fn coarser(&self) -> usize {
        self.coarser
    }

    /// How much of the way to rest is done on this mesh, from 0 to 1: what moves most falls roughly by a constant factor in every iteration.
    #[must_use]
    pub fn share_done(&self, settings: Option<&Settings>) -> f64 {
        let (Some(settings), [first, second, .., before, now]) = (settings, &self.iterations[..])
        else {
            return 0.0;
        };
        let worst = |last, now| {
            let changes = changes(last, now, settings);
            let ratios = changes.iter().map(|change| change.value / change.allowed);
            ratios.fold(1.0, f64::max)
        };
        let (at_first, now) = (worst(first, second), worst(before, now));
        let share = 1.0 - now.ln() / at_first.ln();
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// One outer iteration; after the last, the change to a finer mesh, or the end. `watch` is told of every iteration of the fabric's solver and may end it.
    pub fn advance(
        &mut self,
        scene: &Scene,
        simulation: &mut Simulation,
        watch: Watch,
    ) -> Result<TrimPart, Failure> {
        let Some(wing) = scene.wing() else {
            return Ok(TrimPart::Ended(TrimEnd::Refused(NO_WING.to_owned())));
        };
        if self.ended.is_none() {
            let (wing, _) = mesh(wing, self.coarser);
            match self.iterate(wing, scene, simulation, watch)? {
                Ended::NotYet => return Ok(TrimPart::Iterated),
                Ended::Interrupted => return Ok(TrimPart::Interrupted),
                Ended::With(end) => {
                    let is_refused = matches!(end, TrimEnd::Refused(_));
                    self.ended = Some(end);
                    if !is_refused {
                        return Ok(TrimPart::Iterated);
                    }
                }
            }
        }
        match self.ended.clone() {
            Some(end) if self.coarser == 0 => Ok(TrimPart::Ended(end)),
            end => {
                self.refine(end == Some(TrimEnd::Settled), scene, simulation)?;
                Ok(TrimPart::Refined)
            }
        }
    }

    /// Goes on to the next finer mesh. From a wing that found no rest, or none that makes sense, the drawn shape is the better start.
    fn refine(
        &mut self,
        settled: bool,
        scene: &Scene,
        simulation: &mut Simulation,
    ) -> Result<(), Failure> {
        let Some(own) = scene.wing() else {
            return Ok(());
        };
        let (coarse_wing, coarse) = mesh(own, self.coarser);
        let flown_m = simulation.structure_state().positions_m;
        self.coarser -= 1;
        let (fine_wing, fine) = mesh(own, self.coarser);
        if self.coarser == 0 {
            self.leave_mesh(scene, simulation)?;
            self.begun_from = None;
        } else {
            self.take_mesh(scene, simulation)?;
        }
        let flight = self.flight.take().filter(|_| settled);
        let fine = fine.or_else(|| scene.body.as_ref().map(|body| &body.structure));
        if let (true, Some(coarse), Some(fine)) = (settled, coarse, fine) {
            let from = Meshed {
                wing: &coarse_wing.built,
                structure: coarse,
            };
            let to = Meshed {
                wing: &fine_wing.built,
                structure: fine,
            };
            if let Some(places) = carried_over(from, &flown_m, to) {
                simulation.move_nodes(places);
            }
        }
        simulation.set_static_loads(Some(StaticLoads::Prescribed));
        *self = Self {
            coarser: self.coarser,
            begun_from: self.begun_from.take(),
            stream_rad: flight.map(|flight| flight.balance.glide_rad),
            tolerance_share: 1.0,
            ..Self::default()
        };
        Ok(())
    }

    /// What is told beside a refusal where the wing has lost the pressure in it on the way; nothing elsewhere.
    fn lost_pressure(&self, settings: &Settings) -> String {
        let [first, .., last] = &self.iterations[..] else {
            return String::new();
        };
        if settings.inside.is_some() || last.inside > first.inside - LOST_PRESSURE {
            return String::new();
        }
        format!(
            "; before that the pressure inside fell from {:.2} to {:.2} of the dynamic pressure, with which noses fold: move the intakes towards the nose, pull or shorten less, or give equilibrium.trim.internal_pressure_coefficient",
            first.inside, last.inside
        )
    }

    fn iterate(
        &mut self,
        wing: &Wing,
        scene: &Scene,
        simulation: &mut Simulation,
        watch: Watch,
    ) -> Result<Ended<TrimEnd>, Failure> {
        let refused = |why: String| Ok(Ended::With(TrimEnd::Refused(why)));
        let (Some(settings), Some(designed)) = (
            &wing.trim,
            simulation.cloth().map(|cloth| cloth.structure.clone()),
        ) else {
            return refused(NO_WING.to_owned());
        };
        let gravity = scene.gravity_m_s2.map_or(0.0, |g| -g.z);
        let diameters_m = &wing.line_diameters_m;
        let glider = match Glider::new(&wing.built, &designed, diameters_m, settings, gravity) {
            Ok(glider) => glider,
            Err(why) => return refused(why.to_string()),
        };
        let before = (simulation.structure_state(), self.loads());
        let usual = scene.equilibrium.map_or(1.0, |e| e.tolerance);
        let began = Instant::now();
        let positions = &before.0.positions_m;
        let flown = glider.panel_nodes_m(positions);
        let nodes = match &self.seen_m {
            Some(old) if old.len() == flown.len() => mixed(old, &flown, settings.relaxation),
            _ => flown,
        };
        let flight = match glider.glide(positions, &nodes, self.stream_rad) {
            Ok(flight) => flight,
            Err(why) => return refused(format!("{why}{}", self.lost_pressure(settings))),
        };
        let balance = flight.balance;
        let turned = glider.turned_m(positions, balance.turn_rad);
        let (attack_rad, section_residual) = (flight.attack_rad, flight.section_residual);
        let inside = flight.inside;
        let weight_n = flight.weight_n;
        let air_s = began.elapsed().as_secs_f64();
        simulation.place(&turned);
        simulation.set_static_loads(Some(StaticLoads::Given(flight.loads.clone())));
        let solved = Instant::now();
        let mut relative_norm = f64::NAN;
        let mut note = |progress: &Progress| {
            relative_norm = progress.relative_norm;
            watch(progress)
        };
        let tolerance = self.tolerance_share * usual;
        let outcome = match simulation.solve_static(tolerance, &mut note) {
            Some(outcome) => outcome?,
            None => return refused(NO_WING.to_owned()),
        };
        if outcome.stop == Stop::Interrupted {
            simulation.put_back(&before.0);
            simulation.set_static_loads(Some(before.1));
            return Ok(Ended::Interrupted);
        }
        simulation.balance_as_a_whole();
        let now = simulation.structure_state().positions_m;
        let pitch_rad = glider.pitch_rad(&now);
        // A turn about the hang points is the guide's matter, not the shape's.
        let upright = glider.turned_m(&now, glider.pitch_rad(&turned) - pitch_rad);
        let chord_m = wing.built.measures.flat_area_m2 / wing.built.measures.flat_span_m;
        let iteration = TrimIteration {
            nodes: now.len(),
            number: self.iterations.len() + 1,
            speed_m_s: balance.speed_m_s,
            sink_m_s: balance.speed_m_s * balance.glide_rad.sin(),
            glide_ratio: 1.0 / balance.glide_rad.tan(),
            attack_rad,
            inside,
            pitch_rad,
            turn_rad: balance.turn_rad,
            guide_n: simulation.guide_pull_n(),
            shape_change: change(wing, &turned, &upright) / chord_m,
            outcome,
            balance_error: simulation.left_over_n().length() / weight_n,
            section_residual,
            relative_norm,
            seconds: [air_s, solved.elapsed().as_secs_f64()],
        };
        self.seen_m = Some(glider.turned_m(&nodes, balance.turn_rad));
        self.stream_rad = Some(balance.glide_rad);
        self.flight = Some(flight);
        if iteration.balance_error > settings.tolerance.balance {
            self.tolerance_share = (0.5 * self.tolerance_share).max(LEAST_TOLERANCE);
        }
        let last = self.iterations.last().copied();
        self.iterations.push(iteration);
        let moving = last.map(|last| moving(&last, &iteration, settings));
        Ok(match moving {
            Some(moving) if moving.is_empty() => Ended::With(TrimEnd::Settled),
            _ if iteration.number >= settings.iteration_limit => {
                let what = moving.map_or_else(
                    || "one iteration does not tell whether anything moves".to_owned(),
                    |moving| moving.join(", "),
                );
                Ended::With(TrimEnd::Moving(what))
            }
            _ => Ended::NotYet,
        })
    }
}

/// Coarser meshes of a wing.
fn coarser_meshes(wing: &Wing) -> usize {
    let next = wing.coarser.as_ref();
    next.map_or(0, |coarser| 1 + coarser_meshes(&coarser.wing))
}

/// The wing on the mesh from which so many are left to its own, and the structure of that mesh; `None` for its own.
fn mesh(wing: &Wing, coarser: usize) -> (&Wing, Option<&Structure>) {
    let mut found = (wing, None);
    for _ in 0..coarser {
        if let Some(next) = &found.0.coarser {
            found = (&next.wing, Some(&next.structure));
        }
    }
    found
}

fn mixed(old: &[DVec3], new: &[DVec3], share: f64) -> Vec<DVec3> {
    old.iter()
        .zip(new)
        .map(|(a, b)| a.lerp(*b, share))
        .collect()
}

/// Root of the mean square of how far the nodes of the ribs' outlines move [m].
fn change(wing: &Wing, before: &[DVec3], after: &[DVec3]) -> f64 {
    let nodes = wing.built.outlines.iter().flatten();
    let (sum, count) = nodes.fold((0.0, 0.0), |(sum, count), &node| {
        let node = node as usize;
        (
            sum + before[node].distance_squared(after[node]),
            count + 1.0,
        )
    });
    (sum / f64::max(count, 1.0)).sqrt()
}
