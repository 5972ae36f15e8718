//! Newton's method with a direct factorisation, on an objective that is stiffened step by step: for structures that hardly stretch and easily turn.
//!
//! Stretching may be a hundred thousand times as stiff as the tension that holds an element straight. Then a straight step turns an element by no more than
//! the root of a strain: beyond, its second-order stretch outweighs what the step gains. Softened elements turn further. So the objective is first minimised
//! with a thousandth of the tensile stiffness, then with more and more of it, each time from the last minimum and to a loose tolerance. What resists
//! compression of membranes is not softened, so that wrinkles and folds are those of the true structure. This is a continuation in a parameter of the objective
//! (Nocedal & Wright 2006, section 11.3).
//!
//! Within a level, a step solves (H + λ M) d = −g with a positive semidefinite H, its masses M and a Levenberg–Marquardt shift λ. It is bent by the
//! second-order correction c of (H + λ M) c = −Q(d), where Q is the force of the stretch that turning by d costs ("geodesic acceleration", Transtrum &
//! Sethna 2012, arXiv:1201.5885). Trials lie along x + l d + l² c; Armijo's condition and cubic interpolation give the length l.
//!
//! Norms are those of H itself: √(gᵀ H⁻¹ g), exact up to λ, which is at its smallest where a level ends.

use super::lbfgs::{Options, Outcome, Progress, Stop, Watch, relative};

/// What is minimised. Vectors hold three numbers per node.
pub trait Stiffened {
    /// Makes tensile stiffness this share of the true one; with 1 the objective is that to be minimised.
    fn soften(&mut self, share: f64);

    /// The objective; writes its gradient, which is zero where nodes are held.
    fn evaluate(&mut self, point: &[f64], gradient: &mut [f64]) -> f64;

    /// Estimate of the error of an objective by round-off.
    fn round_off(&self, objective: f64) -> f64;

    /// Factorises H + `shift` · M at a point; false if that is not positive definite.
    fn factorise(&mut self, point: &[f64], shift: f64) -> bool;

    /// Overwrites a vector with (H + shift · M)⁻¹ times it.
    fn solve(&mut self, vector: &mut [f64]);

    /// Writes Q(d), the part of the gradient at `point` + l d that grows with l², for the tangent at `point`.
    fn second_order(&mut self, point: &[f64], direction: &[f64], force: &mut [f64]);

    /// What the structure carries, zero where nodes are held: tolerances are relative to √(bᵀ H⁻¹ b).
    fn loads(&mut self, point: &[f64], loads: &mut [f64]);

    /// vᵀ M v.
    fn square(&self, vector: &[f64]) -> f64;

    /// Where the nodes are, for who watches.
    fn positions_m(&self, point: &[f64]) -> Option<Vec<glam::DVec3>>;
}

/// Levels of stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    /// Share of the tensile stiffness on the first level; 1: there is one level only.
    pub first: f64,
    /// Each level is so many times as stiff as the last.
    pub ratio: f64,
    /// Tolerance of all levels but the last; that of the options holds there if it is wider.
    pub tolerance: f64,
    /// Steps on the true objective before it is softened, which end the solve where it starts near its minimum; 0: none.
    pub direct_steps: usize,
}

impl Default for Levels {
    /// Measured on sheets of ripstop that hang slack: a ratio of 10 takes twice as many evaluations as 10^¼ and may not get there; a tolerance of 0.3 neither,
    /// and with 0.1 the evaluations scatter three times as much as with 0.03.
    fn default() -> Self {
        Self {
            first: 1e-3,
            ratio: 1.778_279_410_038_922_8,
            tolerance: 0.03,
            direct_steps: 0,
        }
    }
}

/// The stiffest level that is not yet the last.
const LAST_BUT_ONE: f64 = 0.8;

/// Steps on a level that is not the last; then the next one is tried.
const STEPS_PER_LEVEL: usize = 60;

/// Smallest λ, that of the first level's start, and the largest [1/s²].
const SHIFTS: [f64; 3] = [1e-2, 1e2, 1e12];

/// λ grows by this where steps are cut short, and shrinks by it where they do what the model foretold.
const SHIFT_FACTOR: f64 = 4.0;

/// Share of the foretold decrease above which λ shrinks, and below which it doubles.
const GAINS: [f64; 2] = [0.75, 0.25];

/// A bend longer than this share of the step is left out, since the expansion does not hold that far (Transtrum & Sethna 2012 take 0.75 for twice the ratio).
const LONGEST_BEND: f64 = 0.5;

const ARMIJO: f64 = 1e-4;

/// Trials in one line search, and the range of the next trial's length over the last one's.
const LINE_SEARCH_LIMIT: usize = 4;
const CUTS: [f64; 2] = [0.1, 0.8];

/// Steps cut to less than this grow λ.
const CUT_SHORT: f64 = 0.4;

/// Steps in a row without a measurable change of the objective and without a norm lower by a tenth.
const STAGNATION_LIMIT: usize = 30;

/// A point with what is known there.
#[derive(Clone)]
struct State {
    point: Vec<f64>,
    gradient: Vec<f64>,
    objective: f64,
}

/// Room that steps work in.
struct Room {
    direction: Vec<f64>,
    bend: Vec<f64>,
    displacement: Vec<f64>,
    trial: State,
}

/// What ended a level.
enum End {
    Reached,
    Spent,
    Stopped(Stop),
}

/// A solve in progress.
struct Solve<'a, 'w, S> {
    space: &'a mut S,
    options: &'a Options,
    watch: Watch<'w>,
    state: State,
    room: Room,
    shift: f64,
    outcome: Outcome,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Minimises from `point`, in place; tells `watch` of every step, and ends when it answers false. The history, refreshes and step limit of the options are
/// not used. If the true objective ends higher than it began, or than direct steps
/// brought it, the solve goes on from there without softening.
pub fn minimise_watched<S: Stiffened>(
    space: &mut S,
    point: &mut Vec<f64>,
    levels: &Levels,
    options: &Options,
    watch: Watch,
) -> Outcome {
    space.soften(1.0);
    let size = point.len();
    let mut state = State {
        point: point.clone(),
        gradient: vec![0.0; size],
        objective: 0.0,
    };
    state.objective = space.evaluate(&state.point, &mut state.gradient);
    let start = state.clone();
    let mut solve = Solve {
        outcome: Outcome {
            stop: Stop::Stalled,
            iterations: 0,
            evaluations: 1,
            energy_norm: f64::NAN,
            relative_norm: f64::NAN,
            objective: state.objective,
        },
        room: Room {
            direction: vec![0.0; size],
            bend: vec![0.0; size],
            displacement: vec![0.0; size],
            trial: state.clone(),
        },
        space,
        options,
        watch,
        state,
        shift: SHIFTS[1],
    };
    if !start.objective.is_finite() || !start.gradient.iter().all(|g| g.is_finite()) {
        solve.outcome.stop = Stop::NotFinite;
        return solve.outcome;
    }
    let mut before = start.clone();
    let mut end = End::Spent;
    if levels.direct_steps > 0 {
        end = solve.level(options.tolerance, levels.direct_steps);
        before = solve.state.clone();
    }
    if matches!(end, End::Spent) {
        if levels.direct_steps > 0 {
            solve.state = start.clone();
            solve.shift = SHIFTS[1];
        }
        end = solve.climb(levels);
    }
    let allowed = before.objective + solve.space.round_off(before.objective);
    let higher = solve.state.objective > allowed || solve.state.objective.is_nan();
    if higher && !matches!(end, End::Stopped(Stop::Interrupted)) {
        solve.state = before;
        solve.shift = SHIFTS[1];
        end = solve.level(options.tolerance, usize::MAX);
    } else if higher {
        solve.state = before;
    }
    solve.outcome.stop = match end {
        End::Reached => Stop::Converged,
        End::Spent => Stop::Stalled,
        End::Stopped(stop) => stop,
    };
    solve.outcome.objective = solve.state.objective;
    std::mem::swap(point, &mut solve.state.point);
    solve.outcome
}

impl<S: Stiffened> Solve<'_, '_, S> {
    /// All levels, softest first; ends with the true objective.
    fn climb(&mut self, levels: &Levels) -> End {
        let mut share = levels.first.clamp(f64::MIN_POSITIVE, 1.0);
        let loose = levels.tolerance.max(self.options.tolerance);
        while share < LAST_BUT_ONE && levels.ratio > 1.0 {
            self.set_share(share);
            if let End::Stopped(stop @ (Stop::Interrupted | Stop::LimitReached)) =
                self.level(loose, STEPS_PER_LEVEL)
            {
                self.set_share(1.0);
                return End::Stopped(stop);
            }
            share *= levels.ratio;
        }
        self.set_share(1.0);
        self.level(self.options.tolerance, usize::MAX)
    }

    /// Softens, and evaluates anew where the solve is.
    fn set_share(&mut self, share: f64) {
        self.space.soften(share);
        if self.shift > SHIFTS[2] {
            self.shift = SHIFTS[1];
        }
        let State {
            point, gradient, ..
        } = &mut self.state;
        self.state.objective = self.space.evaluate(point, gradient);
        self.outcome.evaluations += 1;
    }

    /// Newton's method on one level.
    fn level(&mut self, tolerance: f64, step_limit: usize) -> End {
        let mut norm_at_start = None;
        let mut loads = vec![0.0; self.state.point.len()];
        let (mut steps, mut stagnant, mut lowest) = (0, 0, f64::INFINITY);
        // Below this the Hessian is not positive definite here, by round-off.
        let mut floor = SHIFTS[0];
        while steps < step_limit {
            if !self.space.factorise(&self.state.point, self.shift) {
                floor = floor.max(self.shift * SHIFT_FACTOR);
                self.shift *= SHIFT_FACTOR;
                if self.shift > SHIFTS[2] {
                    return End::Stopped(Stop::Indefinite);
                }
                continue;
            }
            let direction = &mut self.room.direction;
            for (d, g) in direction.iter_mut().zip(&self.state.gradient) {
                *d = -g;
            }
            self.space.solve(direction);
            let slope = dot(&self.state.gradient, direction);
            if !slope.is_finite() {
                return End::Stopped(Stop::Stalled);
            }
            self.space.loads(&self.state.point, &mut loads);
            let mut sag = loads.clone();
            self.space.solve(&mut sag);
            let norm = (-slope).max(0.0).sqrt();
            let norm_at_start = *norm_at_start.get_or_insert(norm);
            let reference = dot(&loads, &sag).max(0.0).sqrt();
            let scale = self.options.scale(reference, norm_at_start);
            self.outcome.energy_norm = norm;
            self.outcome.relative_norm = relative(norm, scale);
            let largest = direction.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            if norm <= tolerance * scale || largest <= self.options.displacement_floor_m {
                if self.shift <= floor {
                    return End::Reached;
                }
                // A shift shortens the norm.
                self.shift = (0.1 * self.shift).max(floor);
                continue;
            }
            if self.outcome.evaluations >= self.options.evaluation_limit {
                return End::Stopped(Stop::LimitReached);
            }
            stagnant = if norm < 0.9 * lowest { 0 } else { stagnant };
            lowest = lowest.min(norm);
            if stagnant >= STAGNATION_LIMIT {
                let round_off = self.space.round_off(self.state.objective);
                let hidden = self.options.time_step && 0.5 * norm * norm <= round_off;
                return End::Stopped(if hidden {
                    Stop::RoundOff
                } else {
                    Stop::Stalled
                });
            }
            let progress = Progress {
                evaluations: self.outcome.evaluations,
                relative_norm: self.outcome.relative_norm,
                read: &|| self.space.positions_m(&self.state.point),
            };
            if !(self.watch)(&progress) {
                return End::Stopped(Stop::Interrupted);
            }
            self.bend();
            let before = self.state.objective;
            if self.search(slope) {
                self.outcome.iterations += 1;
                steps += 1;
                let change = (before - self.state.objective).abs();
                let measurable = change > self.space.round_off(before);
                stagnant = if measurable { 0 } else { stagnant + 1 };
            } else if self.shift > SHIFTS[2] {
                return End::Stopped(Stop::Stalled);
            }
        }
        End::Spent
    }

    /// Finds the bend of the present direction; zero where it is too long to be trusted.
    fn bend(&mut self) {
        let Room {
            direction, bend, ..
        } = &mut self.room;
        self.space.second_order(&self.state.point, direction, bend);
        for b in bend.iter_mut() {
            *b = -*b;
        }
        self.space.solve(bend);
        let limit = LONGEST_BEND * LONGEST_BEND * self.space.square(direction);
        // Not a number is left out, too.
        let trusted = self.space.square(bend) <= limit;
        if !trusted {
            bend.fill(0.0);
        }
    }

    /// Goes to the first trial that is low enough, and sets the next shift; false, without a move, if none is.
    fn search(&mut self, slope: f64) -> bool {
        let mut length = 1.0;
        for attempt in 0..LINE_SEARCH_LIMIT {
            let Room {
                direction,
                bend,
                displacement,
                trial,
            } = &mut self.room;
            for (i, u) in displacement.iter_mut().enumerate() {
                *u = length * (direction[i] + length * bend[i]);
            }
            for (i, x) in trial.point.iter_mut().enumerate() {
                *x = self.state.point[i] + displacement[i];
            }
            trial.objective = self.space.evaluate(&trial.point, &mut trial.gradient);
            self.outcome.evaluations += 1;
            let change = trial.objective - self.state.objective;
            let along = dot(&trial.gradient, direction) + 2.0 * length * dot(&trial.gradient, bend);
            let round_off = self.space.round_off(self.state.objective);
            let low_enough = if change.abs() > round_off {
                change <= ARMIJO * length * slope
            } else {
                // Differences drown in round-off: by the slope alone (Hager & Zhang 2005).
                along <= -0.8 * slope
            };
            if change.is_finite() && along.is_finite() && low_enough {
                if attempt == 0 {
                    let gain = change / (0.5 * slope);
                    if gain > GAINS[0] {
                        self.shift = (self.shift / SHIFT_FACTOR).max(SHIFTS[0]);
                    } else if gain < GAINS[1] {
                        self.shift *= 2.0;
                    }
                } else if length < CUT_SHORT {
                    self.shift *= SHIFT_FACTOR;
                }
                std::mem::swap(&mut self.state, trial);
                return true;
            }
            length = shorter(length, change, slope, along);
        }
        self.shift *= SHIFT_FACTOR * SHIFT_FACTOR;
        false
    }
}

/// Next length after one that was too long, by the minimum of the cubic through both ends (Nocedal & Wright, eq. 3.59).
fn shorter(length: f64, change: f64, slope: f64, along: f64) -> f64 {
    let first = slope + along - 3.0 * change / length;
    let root = (first * first - slope * along).sqrt();
    let cubic = length * (1.0 - (along + root - first) / (along - slope + 2.0 * root));
    if cubic.is_finite() {
        cubic.clamp(CUTS[0] * length, CUTS[1] * length)
    } else {
        CUTS[0] * length
    }
}

#[cfg(test)]
#[path = "stiffening_tests.rs"]
mod tests;
