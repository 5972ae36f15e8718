//! Stage `solve_cloth`: the implicit step as a minimisation, with the immersed-boundary reaction inside.
//!
//! Over the new positions x, with v = (x − xⁿ)/dt,
//!
//! Π(x) = ½ (v − v̂)ᵀ M (v − v̂) + E(x) − f·x + ½ dt β vᵀMv + ½ dt Σ_k K_k |v_k − u*_k|²  \[J\],
//!
//! v̂ = vⁿ, f gravity and (lagged) pressure, β mass-proportional damping, v_k the velocity of marker k and K_k its
//! immersed-boundary stiffness \[kg/s\]; the fluid later gets exactly K_k (v_k − u*_k). The inertia and reaction terms are
//! absent in the static limit. Paper P0 (eqs. 5, 6) writes the objective for dt²·Π with the signs of E and β mixed up;
//! this is derived anew (gradient = M (v − vⁿ)/dt + ∇E − f + β M v + Σ K (v_k − u*_k)).

use std::convert::Infallible;

use glam::{DMat3, DVec3};

use super::{Cloth, initial_hessian, nodal_forces};
use crate::cloth::Structure;
use crate::solve::lbfgs::{self, Options, Outcome, Watch};
use crate::solve::{Attempt, Landing, Refreshed, Start, Step, VectorSpace};

/// How hard the minimiser tries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverSettings {
    /// Tolerance of the energy norm √(gᵀH₀g), relative to that of the applied loads (fluid impulse, gravity, pressure).
    pub tolerance: f64,
    /// Stop when the largest displacement H₀g is below this, whatever the loads [m].
    pub displacement_floor_m: f64,
    /// Evaluations of the objective allowed in one solve.
    pub evaluation_limit: usize,
    /// Pairs kept by L-BFGS.
    pub history: usize,
    /// Iterations between refreshes of the initial Hessian within one solve.
    pub refresh_every: Option<usize>,
}

/// One marker as the cloth feels it.
#[derive(Debug, Clone, Copy)]
pub struct MarkerReaction {
    /// Triangle it sits on.
    pub triangle: u32,
    /// Barycentric weights.
    pub weights: [f64; 3],
    /// Immersed-boundary stiffness K [kg/s].
    pub stiffness_kg_s: f64,
    /// Velocity u* of the air at the marker [m/s].
    pub air_velocity_m_s: DVec3,
}

/// What acts during one step.
#[derive(Debug, Clone, Copy, Default)]
pub struct StepInput<'a> {
    /// Time step [s]; `None` asks for the static equilibrium.
    pub time_step_s: Option<f64>,
    /// Gravity [m/s²].
    pub gravity_m_s2: DVec3,
    /// Pressure jump along the triangle normals [Pa].
    pub pressure_pa: f64,
    /// Mass-proportional damping β [1/s].
    pub damping_1_s: f64,
    /// Markers; empty without air.
    pub markers: &'a [MarkerReaction],
}

/// What one trial found; for comparing engines.
#[derive(Debug, Clone)]
pub struct Probe {
    /// At the start of the step.
    pub start: Start,
    /// Of the trial; the only stored vector is H₀ g of the start.
    pub attempt: Attempt,
    /// Gradient at the trial [N].
    pub gradient: Vec<DVec3>,
    /// H₀ times the gradient [m].
    pub preconditioned: Vec<DVec3>,
    /// Positions of the trial [m].
    pub positions_m: Vec<DVec3>,
}

/// The objective, on host vectors.
struct Objective<'a> {
    structure: &'a Structure,
    start: &'a [DVec3],
    velocities: &'a [DVec3],
    input: &'a StepInput<'a>,
    /// Dead loads [N].
    loads: Vec<DVec3>,
    inverse_blocks: Vec<DMat3>,
}

/// Stiffness below which a node counts as held by nothing [N/m].
pub const FREE_NODE_STIFFNESS: f64 = 1e-9;

/// Below this relative change, differences of the objective are round-off.
const ROUND_OFF: f64 = 1e-10;

impl<'a> Objective<'a> {
    fn new(
        structure: &'a Structure,
        start: &'a [DVec3],
        velocities: &'a [DVec3],
        input: &'a StepInput<'a>,
    ) -> Self {
        Self {
            structure,
            start,
            velocities,
            input,
            loads: dead_loads(structure, start, input),
            inverse_blocks: Vec::new(),
        }
    }

    fn evaluate(&self, point: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        gradient.fill(DVec3::ZERO);
        let structure = self.structure;
        let mut value = nodal_forces::add_elastic_gradient(structure, point, gradient);
        for (i, load) in self.loads.iter().enumerate() {
            value -= load.dot(point[i] - self.start[i]);
            gradient[i] -= *load;
        }
        if let Some(dt) = self.input.time_step_s {
            for i in 0..point.len() {
                let mass = structure.masses_kg[i];
                let velocity = (point[i] - self.start[i]) / dt;
                let change = velocity - self.velocities[i];
                let damping = self.input.damping_1_s;
                value += 0.5
                    * mass
                    * (change.length_squared() + dt * damping * velocity.length_squared());
                gradient[i] += (change / dt + velocity * damping) * mass;
            }
            for marker in self.input.markers {
                let nodes = structure.triangles[marker.triangle as usize]
                    .nodes
                    .map(|n| n as usize);
                let mut displacement = DVec3::ZERO;
                for (&node, weight) in nodes.iter().zip(marker.weights) {
                    displacement += (point[node] - self.start[node]) * weight;
                }
                let slip = displacement / dt - marker.air_velocity_m_s;
                value += 0.5 * dt * marker.stiffness_kg_s * slip.length_squared();
                let force = slip * marker.stiffness_kg_s;
                for (&node, weight) in nodes.iter().zip(marker.weights) {
                    gradient[node] += force * weight;
                }
            }
        }
        for (g, &held) in gradient.iter_mut().zip(&structure.held) {
            if held {
                *g = DVec3::ZERO;
            }
        }
        value
    }

    fn rebuild_blocks(&mut self, point: &[DVec3]) {
        let structure = self.structure;
        self.inverse_blocks.clear();
        self.inverse_blocks
            .resize(structure.node_count(), DMat3::ZERO);
        initial_hessian::add_elastic_blocks(structure, point, &mut self.inverse_blocks);
        if let Some(dt) = self.input.time_step_s {
            for (block, &mass) in self.inverse_blocks.iter_mut().zip(&structure.masses_kg) {
                let stiffness = mass / dt * (1.0 / dt + self.input.damping_1_s);
                *block += DMat3::from_diagonal(DVec3::splat(stiffness));
            }
            for marker in self.input.markers {
                let nodes = structure.triangles[marker.triangle as usize].nodes;
                for (node, weight) in nodes.into_iter().zip(marker.weights) {
                    let stiffness = marker.stiffness_kg_s / dt * weight * weight;
                    self.inverse_blocks[node as usize] +=
                        DMat3::from_diagonal(DVec3::splat(stiffness));
                }
            }
        }
        initial_hessian::invert(
            &mut self.inverse_blocks,
            &structure.held,
            FREE_NODE_STIFFNESS,
        );
    }

    fn precondition(&self, vector: &[DVec3], result: &mut [DVec3]) {
        for ((r, v), block) in result.iter_mut().zip(vector).zip(&self.inverse_blocks) {
            *r = *block * *v;
        }
    }

    /// √(bᵀ H₀ b) of the applied loads b: dead loads plus the pull of the air on a sheet at rest.
    fn load_norm(&self) -> f64 {
        let mut loads = self.loads.clone();
        add_pull_of_the_air(self.structure, self.input.markers, &mut loads);
        loads
            .iter()
            .zip(&self.inverse_blocks)
            .map(|(b, h)| b.dot(*h * *b))
            .sum::<f64>()
            .max(0.0)
            .sqrt()
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Dot products of two vectors with a third, in one pass.
fn dot_both(a: &[DVec3], b: &[DVec3], with: &[DVec3]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for ((a, b), v) in a.iter().zip(b).zip(with) {
        sums[0] += a.dot(*v);
        sums[1] += b.dot(*v);
    }
    sums
}

/// Longest displacement [m]; NaN if an element is not finite.
fn longest_m(step: &[DVec3]) -> f64 {
    let mut longest: f64 = 0.0;
    for v in step {
        if !v.is_finite() {
            return f64::NAN;
        }
        longest = longest.max(v.length_squared());
    }
    longest.sqrt()
}

impl VectorSpace for Objective<'_> {
    type Point = Vec<DVec3>;
    type Vector = Vec<DVec3>;
    type Error = Infallible;

    fn point(&mut self) -> Result<Vec<DVec3>, Infallible> {
        self.vector()
    }

    fn vector(&mut self) -> Result<Vec<DVec3>, Infallible> {
        Ok(vec![DVec3::ZERO; self.structure.node_count()])
    }

    fn start(
        &mut self,
        point: &Vec<DVec3>,
        gradient: &mut Vec<DVec3>,
        preconditioned: &mut Vec<DVec3>,
    ) -> Result<Start, Infallible> {
        self.rebuild_blocks(point);
        let objective = self.evaluate(point, gradient);
        self.precondition(gradient, preconditioned);
        Ok(Start {
            objective,
            round_off: ROUND_OFF * objective.abs(),
            norm_square: dot(gradient, preconditioned),
            longest_m: longest_m(preconditioned),
            reference: self.load_norm(),
        })
    }

    fn attempt(
        &mut self,
        from: &Step<'_, Vec<DVec3>, Vec<DVec3>>,
        to: &mut Landing<'_, Vec<DVec3>, Vec<DVec3>>,
        stored: &[&Vec<DVec3>],
    ) -> Result<Attempt, Infallible> {
        let reach = from.length * longest_m(from.direction);
        let length = if reach > from.step_limit_m {
            from.length * (from.step_limit_m / reach)
        } else {
            from.length
        };
        for ((new, old), d) in to.point.iter_mut().zip(from.point).zip(from.direction) {
            *new = *old + *d * length;
        }
        let objective = self.evaluate(to.point, to.gradient);
        self.precondition(to.gradient, to.preconditioned);
        let (gradient, preconditioned) = (&*to.gradient, &*to.preconditioned);
        let change: Vec<DVec3> = gradient
            .iter()
            .zip(from.gradient)
            .map(|(new, old)| *new - *old)
            .collect();
        let preconditioned_change: Vec<DVec3> = preconditioned
            .iter()
            .zip(from.preconditioned)
            .map(|(new, old)| *new - *old)
            .collect();
        let [slope, slope_change] = dot_both(gradient, &change, from.direction);
        let [gradient_change, change_square] = dot_both(gradient, &change, &preconditioned_change);
        Ok(Attempt {
            objective,
            round_off: ROUND_OFF * objective.abs(),
            length,
            slope,
            slope_change,
            norm_square: dot(gradient, preconditioned),
            gradient_change,
            change_square,
            longest_m: longest_m(preconditioned),
            stored: stored
                .iter()
                .map(|vector| dot_both(gradient, &change, vector))
                .collect(),
        })
    }

    fn refresh(
        &mut self,
        point: &Vec<DVec3>,
        gradient: &Vec<DVec3>,
        preconditioned: &mut Vec<DVec3>,
        pairs: &mut [(&Vec<DVec3>, &mut Vec<DVec3>)],
    ) -> Result<Refreshed, Infallible> {
        self.rebuild_blocks(point);
        self.precondition(gradient, preconditioned);
        for (change, preconditioned_change) in &mut *pairs {
            self.precondition(change, preconditioned_change);
        }
        Ok(Refreshed {
            norm_square: dot(gradient, preconditioned),
            longest_m: longest_m(preconditioned),
            gradient_change: pairs.iter().map(|(_, z)| dot(gradient, z)).collect(),
            change_change: (0..pairs.len())
                .flat_map(|i| (0..=i).map(move |j| (i, j)))
                .map(|(i, j)| dot(pairs[i].0, pairs[j].1))
                .collect(),
        })
    }

    fn combine(
        &mut self,
        result: &mut Vec<DVec3>,
        terms: &[(f64, &Vec<DVec3>)],
    ) -> Result<(), Infallible> {
        result.fill(DVec3::ZERO);
        for &(coefficient, vector) in terms {
            for (r, v) in result.iter_mut().zip(vector) {
                *r += *v * coefficient;
            }
        }
        Ok(())
    }
}

impl Cloth {
    /// Advances positions and velocities by one implicit step, or to the static equilibrium.
    pub fn solve_cloth(&mut self, input: &StepInput, settings: &SolverSettings) -> Outcome {
        self.solve_cloth_watched(input, settings, &mut |_| true)
    }

    /// [`Cloth::solve_cloth`] that tells `watch` of every iteration.
    pub fn solve_cloth_watched(
        &mut self,
        input: &StepInput,
        settings: &SolverSettings,
        watch: Watch,
    ) -> Outcome {
        let start = std::mem::take(&mut self.positions_m);
        let structure = &self.structure;
        let mut point = prediction(structure, &start, &self.velocities_m_s, input);
        let mut objective = Objective::new(structure, &start, &self.velocities_m_s, input);
        let options = options(structure, settings);
        let Ok(outcome) = lbfgs::minimise_watched(&mut objective, &mut point, &options, watch);
        match input.time_step_s {
            Some(dt) => {
                for ((v, new), old) in self.velocities_m_s.iter_mut().zip(&point).zip(&start) {
                    *v = (*new - *old) / dt;
                }
            }
            None => self.velocities_m_s.fill(DVec3::ZERO),
        }
        self.positions_m = point;
        outcome
    }

    /// One trial from the start of a step along `direction` [m], `[node_count]`: its `length`, and the longest way of a node [m].
    #[must_use]
    pub fn probe(
        &self,
        input: &StepInput,
        direction: &[DVec3],
        [length, step_limit_m]: [f64; 2],
    ) -> Probe {
        let (structure, start) = (&self.structure, &self.positions_m);
        let point = prediction(structure, start, &self.velocities_m_s, input);
        let mut objective = Objective::new(structure, start, &self.velocities_m_s, input);
        let zeros = vec![DVec3::ZERO; structure.node_count()];
        let [mut g, mut h, mut landed, mut new_g, mut new_h] =
            std::array::from_fn(|_| zeros.clone());
        let Ok(start) = objective.start(&point, &mut g, &mut h);
        let from = Step {
            point: &point,
            gradient: &g,
            preconditioned: &h,
            direction: &direction.to_vec(),
            length,
            step_limit_m,
        };
        let mut to = Landing {
            point: &mut landed,
            gradient: &mut new_g,
            preconditioned: &mut new_h,
        };
        let Ok(attempt) = objective.attempt(&from, &mut to, &[&h]);
        Probe {
            start,
            attempt,
            gradient: new_g,
            preconditioned: new_h,
            positions_m: landed,
        }
    }
}

/// Loads that do not change during a step [N]: gravity, and pressure on the positions at its start.
#[must_use]
pub fn dead_loads(structure: &Structure, positions: &[DVec3], input: &StepInput) -> Vec<DVec3> {
    let mut loads: Vec<DVec3> = structure
        .masses_kg
        .iter()
        .map(|&mass| input.gravity_m_s2 * mass)
        .collect();
    if input.pressure_pa != 0.0 {
        nodal_forces::add_pressure(structure, positions, input.pressure_pa, &mut loads);
    }
    loads
}

/// Adds to `loads` the pull of the air on a sheet at rest [N].
pub fn add_pull_of_the_air(structure: &Structure, markers: &[MarkerReaction], loads: &mut [DVec3]) {
    for marker in markers {
        let nodes = structure.triangles[marker.triangle as usize].nodes;
        for (node, weight) in nodes.into_iter().zip(marker.weights) {
            loads[node as usize] += marker.air_velocity_m_s * (marker.stiffness_kg_s * weight);
        }
    }
}

/// Where the minimisation starts [m]: every node that is not held goes on as it moved. H₀ is built there too, which for long
/// steps of drapes halves the evaluations against the old positions.
#[must_use]
pub fn prediction(
    structure: &Structure,
    start: &[DVec3],
    velocities: &[DVec3],
    input: &StepInput,
) -> Vec<DVec3> {
    let mut point = start.to_vec();
    if let Some(dt) = input.time_step_s {
        for ((x, v), &held) in point.iter_mut().zip(velocities).zip(&structure.held) {
            if !held {
                *x += *v * dt;
            }
        }
    }
    point
}

/// The minimiser's options for a structure: no node moves farther than two element lengths in one iteration.
#[must_use]
pub fn options(structure: &Structure, settings: &SolverSettings) -> Options {
    let size = structure
        .triangles
        .iter()
        .flat_map(|t| t.rest_squares_m2)
        .chain(
            structure
                .cables
                .iter()
                .map(|c| c.rest_length_m * c.rest_length_m),
        )
        .fold(0.0, f64::max)
        .sqrt();
    Options {
        history: settings.history,
        tolerance: settings.tolerance,
        displacement_floor_m: settings.displacement_floor_m,
        evaluation_limit: settings.evaluation_limit,
        refresh_every: settings.refresh_every,
        step_limit_m: if size > 0.0 {
            2.0 * size
        } else {
            f64::INFINITY
        },
    }
}
