//! The trim of a wing: air and fabric in turn, until speed, glide, pitch and shape stand still.
//!
//! An outer iteration takes the shape, finds its glide ([`crate::trim`]), turns the structure to the attitude that balances, lets the guide at the nose
//! rest there, and solves the fabric from where it is under the loads of that glide. The loads stand during the solve; pressure is renewed on the
//! turned triangles until it stands still. The solver's energy norm hardly sees what stiff lines carry, so fabric as a whole and lines are balanced after it
//! ([`Cloth::balance_as_a_whole`]), and where the risers still do not carry what acts, the fabric is solved to half the tolerance in the next
//! iteration. Coarser meshes of the same plan come first, each starting from the one before.

use std::time::Instant;

use glam::DVec3;

use super::{Failure, LoadTestState, Simulation};
use crate::case::wing::Wing;
use crate::cpu::cloth::{Cloth, Pressure, StepInput};
use crate::geometry::wing::carried_over::{Meshed, carried_over};
use crate::solve::lbfgs::{Outcome, Progress, Stop, Watch};
use crate::trim::{Flight, Glider, Loads};

/// Least share of the case's tolerance to which the fabric is solved.
const LEAST_TOLERANCE: f64 = 1.0 / 64.0;

/// Difference of a strip's lift from its polar's beyond which the sections count as not agreeing.
const SECTION_AGREEMENT: f64 = 1e-3;

/// What a trim lacks where the scene has none to be sought.
const NO_WING: &str = "there is no wing whose fabric could be solved";

/// One outer iteration.
#[derive(Debug, Clone, Copy)]
pub struct TrimIteration {
    /// Nodes of the mesh: coarser ones come first.
    pub nodes: usize,
    /// From 1.
    pub number: usize,
    /// Speed along the path [m/s].
    pub speed_m_s: f64,
    /// Speed of sinking [m/s].
    pub sink_m_s: f64,
    /// Horizontal over vertical speed.
    pub glide_ratio: f64,
    /// Angle of attack of the chord in the middle [rad].
    pub attack_rad: f64,
    /// Pitch of that chord after the solve [rad].
    pub pitch_rad: f64,
    /// By how much the balance turned the wing [rad].
    pub turn_rad: f64,
    /// Pull of the guide along x after the solve [N].
    pub guide_n: f64,
    /// How far the outlines moved beyond a turn about the hang points: root of the mean square, over the mean chord.
    pub shape_change: f64,
    /// Of the fabric's solve.
    pub outcome: Outcome,
    /// What the risers carry less what acts on the wing, over the weight.
    pub balance_error: f64,
    /// Largest difference of a strip's lift coefficient from its polar's.
    pub section_residual: f64,
    /// Energy norm of the fabric's forces at its end, over the loads'; NaN where nothing was left to solve.
    pub relative_norm: f64,
    /// Seconds for the air, and for the fabric.
    pub seconds: [f64; 2],
}

/// How a trim ended.
#[derive(Debug, Clone, PartialEq)]
pub enum TrimEnd {
    /// Everything stands still.
    Settled,
    /// The iterations allowed are used up; what still moves.
    Moving(String),
    /// The air, or the balance, has no answer.
    Refused(String),
    /// The watcher ended it.
    Interrupted,
}

/// A trim as far as it has come.
#[derive(Debug, Clone, Default)]
pub struct TrimState {
    /// The last glide; `None` before the first.
    pub flight: Option<Flight>,
    /// Outer iterations.
    pub iterations: Vec<TrimIteration>,
}

impl Simulation {
    /// The trim as far as it has come; `None` where none is sought.
    #[must_use]
    pub const fn trim_state(&self) -> Option<&TrimState> {
        self.trim.as_ref()
    }

    /// What acts in the static equilibrium: pressure, and further loads of nodes.
    pub(super) fn static_loads(&self) -> (Pressure<'_>, &[DVec3]) {
        let raised = self.load_test.as_ref().and_then(LoadTestState::loads);
        let flight = self.trim.as_ref().and_then(|trim| trim.flight.as_ref());
        if let Some(loads) = raised.or(flight.map(|flight| &flight.loads)) {
            return (pressure(loads), &loads.nodal_n);
        }
        (super::cloth::prescribed_pressure(&self.scene), &[])
    }

    /// Seeks the trim that the case asks for, from where the structure is; `None` if it asks for none. `watch` is told of every iteration of the
    /// fabric's solver and may end it, `report` of every outer iteration.
    pub fn seek_trim(
        &mut self,
        watch: Watch,
        report: &mut dyn FnMut(&TrimIteration),
    ) -> Option<Result<TrimEnd, Failure>> {
        let mut wing = self.scene.wing.take()?;
        let end = wing.trim.is_some().then(|| {
            self.pressure_acts = true;
            self.trim_from_coarser(&wing, watch, report)
        });
        // A trim that is sought again, of other panels, starts from this one.
        wing.coarser = None;
        self.scene.wing = Some(wing);
        end
    }

    /// Seeks the trim on the coarser mesh first, if there is one, and goes on from there: what takes most evaluations from the drawn shape, the way of whole
    /// panels and of the wing, is found where an evaluation is cheap.
    fn trim_from_coarser(
        &mut self,
        wing: &Wing,
        watch: Watch,
        report: &mut dyn FnMut(&TrimIteration),
    ) -> Result<TrimEnd, Failure> {
        let mut stream_rad = None;
        if let Some(coarser) = &wing.coarser {
            let fine = self.cloth.replace(Cloth::new(coarser.structure.clone()));
            let end = self.trim_from_coarser(&coarser.wing, watch, report);
            let coarse = std::mem::replace(&mut self.cloth, fine);
            if matches!(end, Err(_) | Ok(TrimEnd::Interrupted)) {
                self.trim = None;
                return end;
            }
            // From a wing that found no rest, or none that makes sense, the drawn shape is the better start.
            if let (Ok(TrimEnd::Settled), Some(coarse), Some(cloth)) =
                (end, coarse, &mut self.cloth)
            {
                let flight = self.trim.as_ref().and_then(|trim| trim.flight.as_ref());
                stream_rad = flight.map(|flight| flight.balance.glide_rad);
                let [from, to] =
                    [(&coarser.wing.wing, &coarse), (&wing.wing, &*cloth)].map(|(wing, cloth)| {
                        Meshed {
                            wing,
                            structure: &cloth.structure,
                        }
                    });
                if let Some(places) = carried_over(from, &coarse.positions_m, to) {
                    cloth.positions_m = places;
                }
            }
        }
        self.trim = Some(TrimState::default());
        self.iterate_trim(wing, stream_rad, watch, report)
    }

    fn iterate_trim(
        &mut self,
        wing: &Wing,
        mut stream_rad: Option<f64>,
        watch: Watch,
        report: &mut dyn FnMut(&TrimIteration),
    ) -> Result<TrimEnd, Failure> {
        let (Some(settings), Some(designed)) = (
            &wing.trim,
            self.cloth.as_ref().map(|cloth| cloth.structure.clone()),
        ) else {
            return Ok(TrimEnd::Refused(NO_WING.to_owned()));
        };
        let gravity = self.scene.gravity_m_s2.map_or(0.0, |g| -g.z);
        let glider = match Glider::new(
            &wing.wing,
            &designed,
            &wing.line_diameters_m,
            settings,
            gravity,
        ) {
            Ok(glider) => glider,
            Err(why) => return Ok(TrimEnd::Refused(why.to_string())),
        };
        let chord_m = wing.wing.measures.flat_area_m2 / wing.wing.measures.flat_span_m;
        let mut seen: Option<Vec<DVec3>> = None;
        let usual = self.scene.equilibrium.map_or(1.0, |e| e.tolerance);
        let mut tolerance = usual;
        loop {
            let began = Instant::now();
            let positions = self.positions_m();
            let flown = glider.panel_nodes_m(&positions);
            let nodes = match &seen {
                Some(old) => mixed(old, &flown, settings.relaxation),
                None => flown,
            };
            let flight = match glider.glide(&positions, &nodes, stream_rad) {
                Ok(flight) => flight,
                Err(why) => return Ok(TrimEnd::Refused(why.to_string())),
            };
            let balance = flight.balance;
            let turned = glider.turned_m(&positions, balance.turn_rad);
            seen = Some(glider.turned_m(&nodes, balance.turn_rad));
            stream_rad = Some(balance.glide_rad);
            let (attack_rad, section_residual) = (flight.attack_rad, flight.section_residual);
            let weight_n = flight.weight_n;
            let air_s = began.elapsed().as_secs_f64();
            self.place(&turned);
            if let Some(trim) = &mut self.trim {
                trim.flight = Some(flight);
            }
            let solved = Instant::now();
            let mut relative_norm = f64::NAN;
            let mut note = |progress: &Progress| {
                relative_norm = progress.relative_norm;
                watch(progress)
            };
            let outcome = match self.solve_static(tolerance, &mut note) {
                Some(outcome) => outcome?,
                None => return Ok(TrimEnd::Refused(NO_WING.to_owned())),
            };
            self.balance_as_a_whole();
            let now = self.positions_m();
            let pitch_rad = glider.pitch_rad(&now);
            // A turn about the hang points is the guide's matter, not the shape's.
            let upright = glider.turned_m(&now, glider.pitch_rad(&turned) - pitch_rad);
            let iteration = TrimIteration {
                nodes: now.len(),
                number: self.trim.as_ref().map_or(0, |t| t.iterations.len()) + 1,
                speed_m_s: balance.speed_m_s,
                sink_m_s: balance.speed_m_s * balance.glide_rad.sin(),
                glide_ratio: 1.0 / balance.glide_rad.tan(),
                attack_rad,
                pitch_rad,
                turn_rad: balance.turn_rad,
                guide_n: self.guide_pull_n(),
                shape_change: change(wing, &turned, &upright) / chord_m,
                outcome,
                balance_error: self.left_over_n().length() / weight_n,
                section_residual,
                relative_norm,
                seconds: [air_s, solved.elapsed().as_secs_f64()],
            };
            report(&iteration);
            let Some(trim) = &mut self.trim else {
                return Ok(TrimEnd::Refused(NO_WING.to_owned()));
            };
            let last = trim.iterations.last().copied();
            trim.iterations.push(iteration);
            if outcome.stop == Stop::Interrupted {
                return Ok(TrimEnd::Interrupted);
            }
            if iteration.balance_error > settings.tolerance.balance {
                tolerance = (0.5 * tolerance).max(LEAST_TOLERANCE * usual);
            }
            let moving = last.map(|last| moving(&last, &iteration, settings));
            match moving {
                Some(moving) if moving.is_empty() => return Ok(TrimEnd::Settled),
                _ if iteration.number >= settings.iteration_limit => {
                    let what = moving.map_or_else(
                        || "one iteration does not tell whether anything moves".to_owned(),
                        |moving| moving.join(", "),
                    );
                    return Ok(TrimEnd::Moving(what));
                }
                _ => {}
            }
        }
    }

    fn positions_m(&self) -> Vec<DVec3> {
        let cloth = self.cloth.as_ref();
        cloth.map_or_else(Vec::new, |cloth| cloth.positions_m.clone())
    }

    /// Puts the structure where it is to be solved from, with its guides at rest.
    fn place(&mut self, positions_m: &[DVec3]) {
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

    /// Shifts and turns the wing until the sum of what acts on it is nothing.
    pub(super) fn balance_as_a_whole(&mut self) {
        let Some(mut cloth) = self.cloth.take() else {
            return;
        };
        cloth.balance_as_a_whole(&self.static_input());
        self.cloth = Some(cloth);
    }

    /// What is left of loads, guides and the supports' forces together [N]: what free nodes lack to balance.
    pub(super) fn left_over_n(&self) -> DVec3 {
        let cloth = self.cloth.as_ref();
        cloth.map_or(DVec3::ZERO, |cloth| {
            cloth.unbalanced_forces_n(&self.static_input()).iter().sum()
        })
    }

    /// Sum of all loads where the structure is [N].
    pub(super) fn acting_n(&self) -> DVec3 {
        let cloth = self.cloth.as_ref();
        cloth.map_or(DVec3::ZERO, |cloth| {
            cloth.loads_n(&self.static_input()).iter().sum()
        })
    }

    fn static_input(&self) -> StepInput<'_> {
        let (pressure, nodal_loads_n) = self.static_loads();
        StepInput {
            gravity_m_s2: self.scene.gravity_m_s2.unwrap_or(DVec3::ZERO),
            pressure,
            nodal_loads_n,
            ..StepInput::default()
        }
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
}

fn pressure(loads: &Loads) -> Pressure<'_> {
    Pressure::Lagged(&loads.jumps_pa)
}

fn mixed(old: &[DVec3], new: &[DVec3], share: f64) -> Vec<DVec3> {
    old.iter()
        .zip(new)
        .map(|(a, b)| a.lerp(*b, share))
        .collect()
}

/// Root of the mean square of how far the nodes of the ribs' outlines move [m].
fn change(wing: &Wing, before: &[DVec3], after: &[DVec3]) -> f64 {
    let nodes = wing.wing.outlines.iter().flatten();
    let (sum, count) = nodes.fold((0.0, 0.0), |(sum, count), &node| {
        let node = node as usize;
        (
            sum + before[node].distance_squared(after[node]),
            count + 1.0,
        )
    });
    (sum / f64::max(count, 1.0)).sqrt()
}

/// What has not come to rest, in words.
fn moving(
    last: &TrimIteration,
    now: &TrimIteration,
    settings: &crate::trim::Settings,
) -> Vec<String> {
    let tolerance = &settings.tolerance;
    let mut moving = Vec::new();
    let mut relative = |name: &str, old: f64, new: f64, allowed: f64| {
        let change = (new / old - 1.0).abs();
        if change.is_nan() || change > allowed {
            moving.push(format!(
                "{name} changes by {change:.1e} of itself ({allowed:.0e} allowed)"
            ));
        }
    };
    relative("speed", last.speed_m_s, now.speed_m_s, tolerance.speed);
    relative(
        "glide ratio",
        last.glide_ratio,
        now.glide_ratio,
        tolerance.glide,
    );
    if now.turn_rad.abs() > tolerance.pitch_rad {
        moving.push(format!(
            "the balance turns the wing by {:.3} degrees ({:.3} allowed)",
            now.turn_rad.to_degrees(),
            tolerance.pitch_rad.to_degrees()
        ));
    }
    if now.shape_change > tolerance.shape {
        moving.push(format!(
            "outlines move by {:.1e} mean chords ({:.0e} allowed)",
            now.shape_change, tolerance.shape
        ));
    }
    if now.balance_error.is_nan() || now.balance_error > tolerance.balance {
        moving.push(format!(
            "the risers lack {:.1e} of the weight ({:.0e} allowed)",
            now.balance_error, tolerance.balance
        ));
    }
    if now.section_residual.is_nan() || now.section_residual > SECTION_AGREEMENT {
        moving.push(format!(
            "sections lift {:.1e} more or less than their polars say: they stall, or the wing has collapsed",
            now.section_residual
        ));
    }
    if now.outcome.stop != Stop::Converged {
        moving.push(format!(
            "the fabric is not in equilibrium (energy norm {:.1e} of the loads')",
            now.relative_norm
        ));
    }
    moving
}
