//! A pendulum of stiff springs, which is let go where it stands out sideways; it ends straight below its pivot.

use super::*;

const LINKS: usize = 4;
const STIFFNESS_N_M: f64 = 1e5;
const WEIGHT_N: f64 = 1.0;

struct Pendulum {
    share: f64,
    /// Dense lower Cholesky factor, row by row.
    factor: Vec<f64>,
    objectives: Vec<f64>,
}

impl Pendulum {
    const SIZE: usize = 3 * LINKS;

    fn new() -> Self {
        Self {
            share: 1.0,
            factor: Vec::new(),
            objectives: Vec::new(),
        }
    }

    fn start() -> Vec<f64> {
        (1..=LINKS)
            .flat_map(|i| [i as f64, 0.0, 1e-3 * i as f64])
            .collect()
    }

    /// Vector from the inner end of a link to its outer end.
    fn link(point: &[f64], i: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| point[3 * i + k] - if i > 0 { point[3 * i - 3 + k] } else { 0.0 })
    }

    fn add(force: &mut [f64], i: usize, pull: [f64; 3]) {
        for k in 0..3 {
            force[3 * i + k] += pull[k];
            if i > 0 {
                force[3 * i - 3 + k] -= pull[k];
            }
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    dot(&v, &v).sqrt()
}

impl Stiffened for Pendulum {
    fn soften(&mut self, share: f64) {
        self.share = share;
    }

    fn evaluate(&mut self, point: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut sum = 0.0;
        for i in 0..LINKS {
            let edge = Self::link(point, i);
            let stretch = length(edge) - 1.0;
            let k = self.share * STIFFNESS_N_M;
            sum += 0.5 * k * stretch * stretch + WEIGHT_N * point[3 * i + 2];
            Self::add(gradient, i, edge.map(|e| k * stretch * e / length(edge)));
            gradient[3 * i + 2] += WEIGHT_N;
        }
        self.objectives.push(sum);
        sum
    }

    fn round_off(&self, objective: f64) -> f64 {
        1e-12 * objective.abs()
    }

    fn factorise(&mut self, point: &[f64], shift: f64) -> bool {
        let n = Self::SIZE;
        let mut a = vec![0.0; n * n];
        for i in 0..LINKS {
            let edge = Self::link(point, i);
            let k = self.share * STIFFNESS_N_M;
            let across = (k * (1.0 - 1.0 / length(edge))).max(0.0);
            for p in 0..3 {
                for q in 0..3 {
                    let along = edge[p] * edge[q] / dot(&edge, &edge);
                    let unit = if p == q { 1.0 } else { 0.0 };
                    let value = k * along + across * (unit - along);
                    a[(3 * i + p) * n + 3 * i + q] += value;
                    if i > 0 {
                        let j = i - 1;
                        a[(3 * j + p) * n + 3 * j + q] += value;
                        a[(3 * i + p) * n + 3 * j + q] -= value;
                        a[(3 * j + p) * n + 3 * i + q] -= value;
                    }
                }
            }
        }
        for i in 0..n {
            a[i * n + i] += shift;
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
                let left = a[i * n + j] - sum;
                if i == j && (left <= 0.0 || left.is_nan()) {
                    return false;
                }
                a[i * n + j] = if i == j {
                    left.sqrt()
                } else {
                    left / a[j * n + j]
                };
            }
        }
        self.factor = a;
        true
    }

    fn solve(&mut self, v: &mut [f64]) {
        let (n, l) = (Self::SIZE, &self.factor);
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| l[i * n + k] * v[k]).sum();
            v[i] = (v[i] - sum) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * v[k]).sum();
            v[i] = (v[i] - sum) / l[i * n + i];
        }
    }

    fn second_order(&mut self, point: &[f64], direction: &[f64], force: &mut [f64]) {
        force.fill(0.0);
        for i in 0..LINKS {
            let (edge, turn) = (Self::link(point, i), Self::link(direction, i));
            let along = edge.map(|e| e / length(edge));
            let stretch = dot(&along, &turn);
            let across: [f64; 3] = std::array::from_fn(|k| turn[k] - stretch * along[k]);
            let second = 0.5 * dot(&across, &across) / length(edge);
            let k = self.share * STIFFNESS_N_M;
            let pull = |j: usize| k * (second * along[j] + stretch * across[j] / length(edge));
            Self::add(force, i, [0, 1, 2].map(pull));
        }
    }

    fn loads(&mut self, _: &[f64], loads: &mut [f64]) {
        for (i, load) in loads.iter_mut().enumerate() {
            *load = if i % 3 == 2 { -WEIGHT_N } else { 0.0 };
        }
    }

    fn square(&self, vector: &[f64]) -> f64 {
        dot(vector, vector)
    }

    fn positions_m(&self, _: &[f64]) -> Option<Vec<glam::DVec3>> {
        None
    }
}

fn options() -> Options {
    Options {
        history: 0,
        tolerance: 1e-4,
        displacement_floor_m: 0.0,
        time_step: false,
        evaluation_limit: 2000,
        refresh_every: None,
        step_limit_m: f64::INFINITY,
    }
}

/// Straight down, every link stretched by the weight below it.
fn assert_hangs(point: &[f64]) {
    let mut height = 0.0;
    for i in 0..LINKS {
        height -= 1.0 + (LINKS - i) as f64 * WEIGHT_N / STIFFNESS_N_M;
        for (k, expected) in [0.0, 0.0, height].into_iter().enumerate() {
            assert!((point[3 * i + k] - expected).abs() < 1e-3, "{point:?}");
        }
    }
}

#[test]
fn a_stiff_pendulum_falls_in_few_evaluations() {
    let mut point = Pendulum::start();
    let levels = Levels::default();
    let outcome = minimise_watched(
        &mut Pendulum::new(),
        &mut point,
        &levels,
        &options(),
        &mut |_| true,
    );
    assert_eq!(outcome.stop, Stop::Converged);
    assert_hangs(&point);
    assert!(outcome.evaluations < 200, "{}", outcome.evaluations);
    let mut point = Pendulum::start();
    let stiff = Levels {
        first: 1.0,
        ..levels
    };
    let alone = minimise_watched(
        &mut Pendulum::new(),
        &mut point,
        &stiff,
        &options(),
        &mut |_| true,
    );
    assert!(
        alone.evaluations > outcome.evaluations,
        "{}",
        alone.evaluations
    );
}

#[test]
fn what_is_not_finite_is_told() {
    let mut point = vec![f64::NAN; Pendulum::SIZE];
    let outcome = minimise_watched(
        &mut Pendulum::new(),
        &mut point,
        &Levels::default(),
        &options(),
        &mut |_| true,
    );
    assert_eq!(outcome.stop, Stop::NotFinite);
}

/// An interrupted solve leaves no point whose true objective is higher than at the start.
#[test]
fn an_interruption_is_heeded() {
    let mut point = Pendulum::start();
    let mut left = 5;
    let mut space = Pendulum::new();
    let outcome = minimise_watched(
        &mut space,
        &mut point,
        &Levels::default(),
        &options(),
        &mut |_| {
            left -= 1;
            left > 0
        },
    );
    assert_eq!(outcome.stop, Stop::Interrupted);
    let start = Pendulum::new().evaluate(&Pendulum::start(), &mut [0.0; Pendulum::SIZE]);
    let end = space.evaluate(&point, &mut [0.0; Pendulum::SIZE]);
    assert!(end <= start);
}
