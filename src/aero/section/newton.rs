//! Newton's method for all layers together with the potential flow.
//!
//! Unknowns of a station are θ, s, u and the mass m = u δ*. The layers' equations give the changes of θ, s and u at a station from those before
//! it and from m there, so each is carried along as a linear function of all masses and of the stagnation point's shift ("given m" is well posed
//! in attached and in separated flow: Drela & Giles 1987). What remains is dense and small: the speeds have to be those of the potential flow with the
//! masses as sources, u = u₀ + D m. This is our own elimination in place of XFOIL's block solver; the step is the same exact Newton step.
//! Steps are shortened so that thicknesses change moderately; stress changes by a factor, as its equation is one for ln s.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::interval::{Kind, residuals};
use super::layers::{Layers, Setting};
use super::march::solve_3;
use super::station::Station;

/// Steps before giving up.
const STEPS: usize = 60;

/// Largest residual of a solution; the layers' are relative, the speeds' refer to the stream.
pub const TOLERANCE: f64 = 1e-7;

/// Linear function of all masses' changes, the stagnation point's shift, and one.
type Row = Vec<f64>;

/// Changes at a station.
struct Rows {
    theta: Row,
    shear: Row,
    speed: Row,
}

/// Changes of all quantities.
struct Step {
    theta: Vec<f64>,
    displacement: Vec<f64>,
    shear: Vec<f64>,
    speed: Vec<f64>,
}

/// How an attempt ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Whether the residuals are within the tolerance.
    pub is_solved: bool,
    /// Largest residual.
    pub residual: f64,
    /// Steps done.
    pub steps: usize,
}

/// Brings layers to a solution.
pub fn solve(setting: &Setting<'_>, layers: &mut Layers) -> Outcome {
    let mut residual = f64::INFINITY;
    let mut done = 0;
    for steps in 0..STEPS {
        let (step, largest) = linearised(setting, layers);
        residual = largest;
        if largest < TOLERANCE {
            return Outcome {
                is_solved: true,
                residual,
                steps,
            };
        }
        done = steps;
        let Some(step) = step else { break };
        if !apply(setting, layers, &step) {
            break;
        }
        done += 1;
    }
    Outcome {
        is_solved: false,
        residual,
        steps: done,
    }
}

/// Row of δ* from those of u and the mass: u dδ* = dm − δ* du.
fn displacement_row(layers: &Layers, station: usize, speed: &Row) -> Row {
    let factor = layers.displacement[station] / layers.speed[station];
    let mut row: Row = speed.iter().map(|v| -factor * v).collect();
    row[station] += 1.0 / layers.speed[station];
    row
}

/// Newton step and the largest residual before it.
fn linearised(setting: &Setting<'_>, layers: &Layers) -> (Option<Step>, f64) {
    let nodes = setting.nodes();
    let count = setting.stations();
    let mut rows: Vec<Option<Rows>> = (0..count).map(|_| None).collect();
    let mut largest = 0.0f64;
    for side in 0..2 {
        let mut before: Option<usize> = None;
        for (k, &station) in layers.side(side, nodes).iter().enumerate() {
            let next = interval(
                setting,
                layers,
                layers.kind(side, k),
                before.and_then(|b| rows[b].as_ref().map(|rows| (b, rows))),
                station,
                &mut largest,
            );
            if next.is_none() {
                return (None, f64::INFINITY);
            }
            rows[station] = next;
            before = Some(station);
        }
    }
    let Some(joined) = join(setting, layers, &rows, &mut largest) else {
        return (None, f64::INFINITY);
    };
    rows[nodes] = Some(joined);
    for station in nodes + 1..count {
        let before = rows[station - 1].as_ref().map(|rows| (station - 1, rows));
        let next = interval(setting, layers, Kind::Wake, before, station, &mut largest);
        if next.is_none() {
            return (None, f64::INFINITY);
        }
        rows[station] = next;
    }
    let rows: Vec<Rows> = rows.into_iter().flatten().collect();
    let mismatch = mismatch(setting, layers);
    largest = mismatch.iter().fold(largest, |m, r| m.max(r.abs()));
    if !largest.is_finite() || mismatch.iter().any(|r| !r.is_finite()) {
        return (None, f64::INFINITY);
    }
    (close(setting, layers, &rows, &mismatch), largest)
}

/// Rows of the station behind an interval.
fn interval(
    setting: &Setting<'_>,
    layers: &Layers,
    kind: Kind,
    before: Option<(usize, &Rows)>,
    station: usize,
    largest: &mut f64,
) -> Option<Rows> {
    let count = setting.stations();
    let to: Station = layers.station(setting, station);
    let from = before.map_or(to, |(b, _)| layers.station(setting, b));
    let equations = residuals(kind, &from, &to, &setting.air);
    let mut matrix = [[0.0; 3]; 3];
    for (row, r) in matrix.iter_mut().zip(&equations) {
        let by_displacement = r.slopes[6] / to.speed;
        *row = [
            r.slopes[5],
            r.slopes[7],
            r.slopes[8] - by_displacement * to.displacement,
        ];
        // A maximum alone would pass over what is no number.
        if !r.value.is_finite() {
            return None;
        }
        *largest = largest.max(r.value.abs());
    }
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inverse = solve_3(matrix, identity)?;
    let previous = before.map(|(b, rows)| (rows, displacement_row(layers, b, &rows.speed)));
    // ξ grows with the stagnation point's place on the lower side and shrinks on the upper.
    let towards = -layers.sign(station);
    let sides: Vec<Row> = equations
        .iter()
        .map(|r| {
            let mut side = vec![0.0; count + 2];
            if let Some((rows, displacement)) = &previous {
                for k in 0..count + 2 {
                    side[k] = -(r.slopes[0] * rows.theta[k]
                        + r.slopes[1] * displacement[k]
                        + r.slopes[2] * rows.shear[k]
                        + r.slopes[3] * rows.speed[k]);
                }
            }
            side[station] -= r.slopes[6] / to.speed;
            side[count] -= towards * (r.slopes[4] + r.slopes[9]);
            side[count + 1] -= r.value;
            side
        })
        .collect();
    let combined = |weights: [f64; 3]| -> Row {
        (0..count + 2)
            .map(|k| weights[0] * sides[0][k] + weights[1] * sides[1][k] + weights[2] * sides[2][k])
            .collect()
    };
    Some(Rows {
        theta: combined(inverse[0]),
        shear: combined(inverse[1]),
        speed: combined(inverse[2]),
    })
}

/// Rows of the wake's first station, where both sides meet.
fn join(
    setting: &Setting<'_>,
    layers: &Layers,
    rows: &[Option<Rows>],
    largest: &mut f64,
) -> Option<Rows> {
    let nodes = setting.nodes();
    let count = setting.stations();
    let edges = [0, nodes - 1];
    let sides = [rows[0].as_ref()?, rows[nodes - 1].as_ref()?];
    let target = layers.join(setting);
    let [theta, displacement, shear] = target;
    let mut result = Rows {
        theta: vec![0.0; count + 2],
        shear: vec![0.0; count + 2],
        speed: vec![0.0; count + 2],
    };
    let mut displacement_change = vec![0.0; count + 2];
    for (&edge, rows) in edges.iter().zip(sides) {
        let by_displacement = displacement_row(layers, edge, &rows.speed);
        let by_theta = (layers.shear[edge] - shear) / theta;
        let by_shear = layers.theta[edge] / theta;
        for k in 0..count + 2 {
            result.theta[k] += rows.theta[k];
            displacement_change[k] += by_displacement[k];
            result.shear[k] += by_theta * rows.theta[k] + by_shear * rows.shear[k];
        }
    }
    let own = [
        layers.theta[nodes],
        layers.displacement[nodes],
        layers.shear[nodes],
    ];
    result.theta[count + 1] += theta - own[0];
    displacement_change[count + 1] += displacement - own[1];
    result.shear[count + 1] += shear - own[2];
    for (target, own) in target.iter().zip(own) {
        *largest = largest.max((target / own - 1.0).abs());
    }
    // δ* du = dm − u dδ*.
    for k in 0..count + 2 {
        result.speed[k] = -layers.speed[nodes] * displacement_change[k] / own[1];
    }
    result.speed[nodes] += 1.0 / own[1];
    Some(result)
}

/// Speeds less those of the potential flow with the masses, along the way of the nodes.
fn mismatch(setting: &Setting<'_>, layers: &Layers) -> Vec<f64> {
    let masses: Vec<f64> = (0..setting.stations())
        .map(|j| layers.sign(j) * layers.speed[j] * layers.displacement[j])
        .collect();
    (0..setting.stations())
        .map(|i| {
            let sum: f64 = masses
                .iter()
                .enumerate()
                .map(|(j, mass)| setting.flow.response[(i, j)] * mass)
                .sum();
            layers.sign(i) * layers.speed[i] - setting.flow.speeds[i] - sum
        })
        .collect()
}

/// Solves for the masses and the stagnation point's shift, and from them everything.
fn close(setting: &Setting<'_>, layers: &Layers, rows: &[Rows], mismatch: &[f64]) -> Option<Step> {
    let count = setting.stations();
    let mut matrix = Mat::zeros(count + 1, count + 1);
    let mut side = Mat::zeros(count + 1, 1);
    for i in 0..count {
        let sign = layers.sign(i);
        for j in 0..count {
            matrix[(i, j)] =
                sign * rows[i].speed[j] - setting.flow.response[(i, j)] * layers.sign(j);
        }
        matrix[(i, count)] = sign * rows[i].speed[count];
        side[(i, 0)] = -mismatch[i] - sign * rows[i].speed[count + 1];
    }
    let (_, slopes) = layers.stagnation_place(setting.panels);
    for (k, slope) in slopes.into_iter().enumerate() {
        let speed = &rows[layers.stagnation + k].speed;
        for j in 0..=count {
            matrix[(count, j)] -= slope * speed[j];
        }
        side[(count, 0)] += slope * speed[count + 1];
    }
    matrix[(count, count)] += 1.0;
    let solution = matrix.partial_piv_lu().solve(&side);
    let mut parameters: Vec<f64> = (0..=count).map(|k| solution[(k, 0)]).collect();
    parameters.push(1.0);
    if parameters.iter().any(|p| !p.is_finite()) {
        return None;
    }
    let change = |row: &Row| row.iter().zip(&parameters).map(|(a, b)| a * b).sum::<f64>();
    let speed: Vec<f64> = rows.iter().map(|r| change(&r.speed)).collect();
    Some(Step {
        theta: rows.iter().map(|r| change(&r.theta)).collect(),
        shear: rows.iter().map(|r| change(&r.shear)).collect(),
        displacement: (0..count)
            .map(|k| (parameters[k] - layers.displacement[k] * speed[k]) / layers.speed[k])
            .collect(),
        speed,
    })
}

/// Takes as much of a step as keeps changes moderate, then finds the stagnation point and transition anew.
fn apply(setting: &Setting<'_>, layers: &mut Layers, step: &Step) -> bool {
    let nodes = setting.nodes();
    let count = setting.stations();
    let mut share = 1.0f64;
    let mut limit = |change: f64, least: f64, most: f64| {
        if change * share > most {
            share = most / change;
        } else if change * share < least {
            share = least / change;
        }
    };
    for k in 0..count {
        limit(step.theta[k] / layers.theta[k], -0.5, 1.5);
        limit(step.displacement[k] / layers.displacement[k], -0.5, 1.5);
        limit(step.speed[k], -0.2, 0.2);
    }
    if share.is_nan() || share < 1e-9 {
        return false;
    }
    for k in 0..count {
        layers.theta[k] += share * step.theta[k];
        layers.displacement[k] += share * step.displacement[k];
        // The lag equation is one for ln s: a turbulent layer's stress changes by a factor, within bounds of its own.
        let old = layers.shear[k];
        layers.shear[k] = old
            * (share * step.shear[k] / old.max(1e-5))
                .clamp(-1.5, 1.5)
                .exp();
    }
    let signed: Vec<f64> = (0..nodes)
        .map(|k| layers.sign(k) * (layers.speed[k] + share * step.speed[k]))
        .collect();
    for k in nodes..count {
        layers.speed[k] = (layers.speed[k] + share * step.speed[k]).max(1e-3);
    }
    layers.move_stagnation(&signed);
    layers.limit(setting);
    layers.find_transition(setting);
    true
}
