//! Newton's method for all layers together with the potential flow.
//!
//! Unknowns of a station are θ, s, u and the mass m = u δ*. The layers' equations give the changes of θ, s and u at a station from those before
//! it and from m there, so each is carried along as a linear function of all masses and of the stagnation point's shift ("given m" is well posed
//! in attached and in separated flow: Drela & Giles 1987). What remains is dense and small: the speeds have to be those of the potential flow with the
//! masses as sources, u = u₀ + D m. This is our own elimination in place of XFOIL's block solver; the step is the same exact Newton step.
//! Steps are shortened so that thicknesses change moderately; stress changes by a factor, as its equation is one for ln s.
//!
//! A station knows nothing of the masses downstream of it and on the other side, so that half of all coefficients are zero and are not stored.

use std::ops::Range;

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

/// Linear function of the changes of some stations' masses, of the stagnation point's shift, and of one.
struct Row {
    masses: Vec<f64>,
    shift: f64,
    one: f64,
}

/// Changes at a station, by the masses of these stations.
struct Rows {
    stations: Range<usize>,
    theta: Row,
    shear: Row,
    speed: Row,
}

impl Row {
    /// Of so many masses, zero.
    fn zero(masses: usize) -> Self {
        Self {
            masses: vec![0.0; masses],
            shift: 0.0,
            one: 0.0,
        }
    }

    /// Its value for changes of all masses, and a shift.
    fn at(&self, stations: &Range<usize>, masses: &[f64], shift: f64) -> f64 {
        let terms = self.masses.iter().zip(&masses[stations.clone()]);
        terms.map(|(a, b)| a * b).sum::<f64>() + self.shift * shift + self.one
    }
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
    // ξ grows with the stagnation point's place on the lower side and shrinks on the upper.
    let towards = -layers.sign(station);
    let mut own = [0.0; 3];
    let mut shift = [0.0; 3];
    let mut one = [0.0; 3];
    for (k, r) in equations.iter().enumerate() {
        own[k] = -r.slopes[6] / to.speed;
        shift[k] = -towards * (r.slopes[4] + r.slopes[9]);
        one[k] = -r.value;
    }
    let Some((b, rows)) = before else {
        let row = |weights: [f64; 3]| Row {
            masses: vec![weighted(weights, own)],
            shift: weighted(weights, shift),
            one: weighted(weights, one),
        };
        return Some(Rows {
            stations: station..station + 1,
            theta: row(inverse[0]),
            shear: row(inverse[1]),
            speed: row(inverse[2]),
        });
    };
    // What changes of θ, δ*, s and u before give to the three sides. u dδ* = dm − δ* du.
    let gives = equations.map(|r| [r.slopes[0], r.slopes[1], r.slopes[2], r.slopes[3]]);
    let thickness = -layers.displacement[b] / layers.speed[b];
    let side = |[theta, displacement, shear, speed]: [f64; 4]| {
        gives.map(|[a, b, c, d]| -(a * theta + b * displacement + c * shear + d * speed))
    };
    let [theta, shear, speed] = [&rows.theta, &rows.shear, &rows.speed];
    for (sum, of) in [
        (
            &mut shift,
            [
                theta.shift,
                thickness * speed.shift,
                shear.shift,
                speed.shift,
            ],
        ),
        (
            &mut one,
            [theta.one, thickness * speed.one, shear.one, speed.one],
        ),
    ] {
        for (sum, side) in sum.iter_mut().zip(side(of)) {
            *sum += side;
        }
    }
    let stations = rows.stations.start.min(station)..rows.stations.end.max(station + 1);
    let mut masses = [(); 3].map(|()| vec![0.0; stations.len()]);
    let first = rows.stations.start - stations.start;
    let among = first..first + rows.stations.len();
    let before = [&theta.masses[..], &shear.masses, &speed.masses];
    let after = masses.each_mut().map(|row| &mut row[among.clone()]);
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || carried_on(before, after, (&gives, thickness), &inverse),
    );
    let k = b - rows.stations.start;
    let displacement = thickness * speed.masses[k] + 1.0 / layers.speed[b];
    let at_before = side([
        theta.masses[k],
        displacement,
        shear.masses[k],
        speed.masses[k],
    ]);
    for (row, weights) in masses.iter_mut().zip(inverse) {
        row[first + k] = weighted(weights, at_before);
        row[station - stations.start] = weighted(weights, own);
    }
    let [theta, shear, speed] = masses;
    let row = |masses: Vec<f64>, weights: [f64; 3]| Row {
        masses,
        shift: weighted(weights, shift),
        one: weighted(weights, one),
    };
    Some(Rows {
        stations,
        theta: row(theta, inverse[0]),
        shear: row(shear, inverse[1]),
        speed: row(speed, inverse[2]),
    })
}

fn weighted([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

/// Coefficients of θ, s and u behind an interval from those before it; of δ* before it, `thickness` times those of u.
#[inline(always)]
fn carried_on(
    [theta, shear, speed]: [&[f64]; 3],
    [new_theta, new_shear, new_speed]: [&mut [f64]; 3],
    (gives, thickness): (&[[f64; 4]; 3], f64),
    inverse: &[[f64; 3]; 3],
) {
    let count = theta.len();
    let (shear, speed) = (&shear[..count], &speed[..count]);
    let (new_theta, new_shear) = (&mut new_theta[..count], &mut new_shear[..count]);
    let new_speed = &mut new_speed[..count];
    for k in 0..count {
        let displacement = thickness * speed[k];
        let mut sides = [0.0; 3];
        for (side, [a, b, c, d]) in sides.iter_mut().zip(gives) {
            *side = -(a * theta[k] + b * displacement + c * shear[k] + d * speed[k]);
        }
        new_theta[k] = weighted(inverse[0], sides);
        new_shear[k] = weighted(inverse[1], sides);
        new_speed[k] = weighted(inverse[2], sides);
    }
}

/// Rows of the wake's first station, where both sides meet.
fn join(
    setting: &Setting<'_>,
    layers: &Layers,
    rows: &[Option<Rows>],
    largest: &mut f64,
) -> Option<Rows> {
    let nodes = setting.nodes();
    let edges = [0, nodes - 1];
    let sides = [rows[0].as_ref()?, rows[nodes - 1].as_ref()?];
    let target = layers.join(setting);
    let [theta, displacement, shear] = target;
    let mut result = Rows {
        stations: 0..nodes + 1,
        theta: Row::zero(nodes + 1),
        shear: Row::zero(nodes + 1),
        speed: Row::zero(nodes + 1),
    };
    let mut displacement_change = Row::zero(nodes + 1);
    for (&edge, rows) in edges.iter().zip(sides) {
        let thickness = -layers.displacement[edge] / layers.speed[edge];
        let by_theta = (layers.shear[edge] - shear) / theta;
        let by_shear = layers.theta[edge] / theta;
        for (k, station) in rows.stations.clone().enumerate() {
            result.theta.masses[station] += rows.theta.masses[k];
            displacement_change.masses[station] += thickness * rows.speed.masses[k];
            result.shear.masses[station] +=
                by_theta * rows.theta.masses[k] + by_shear * rows.shear.masses[k];
        }
        displacement_change.masses[edge] += 1.0 / layers.speed[edge];
        result.theta.shift += rows.theta.shift;
        result.theta.one += rows.theta.one;
        displacement_change.shift += thickness * rows.speed.shift;
        displacement_change.one += thickness * rows.speed.one;
        result.shear.shift += by_theta * rows.theta.shift + by_shear * rows.shear.shift;
        result.shear.one += by_theta * rows.theta.one + by_shear * rows.shear.one;
    }
    let own = [
        layers.theta[nodes],
        layers.displacement[nodes],
        layers.shear[nodes],
    ];
    result.theta.one += theta - own[0];
    displacement_change.one += displacement - own[1];
    result.shear.one += shear - own[2];
    for (target, own) in target.iter().zip(own) {
        *largest = largest.max((target / own - 1.0).abs());
    }
    // δ* du = dm − u dδ*.
    let by_displacement = |change: f64| -layers.speed[nodes] * change / own[1];
    for (speed, change) in (result.speed.masses.iter_mut()).zip(&displacement_change.masses) {
        *speed = by_displacement(*change);
    }
    result.speed.shift = by_displacement(displacement_change.shift);
    result.speed.one = by_displacement(displacement_change.one);
    result.speed.masses[nodes] += 1.0 / own[1];
    Some(result)
}

/// Speeds less those of the potential flow with the masses, along the way of the nodes.
fn mismatch(setting: &Setting<'_>, layers: &Layers) -> Vec<f64> {
    let count = setting.stations();
    let mut sums = vec![0.0; count];
    for j in 0..count {
        let mass = layers.sign(j) * layers.speed[j] * layers.displacement[j];
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += setting.flow.response[(i, j)] * mass;
        }
    }
    let of =
        |(i, sum): (usize, f64)| layers.sign(i) * layers.speed[i] - setting.flow.speeds[i] - sum;
    sums.into_iter().enumerate().map(of).collect()
}

/// Solves for the masses and the stagnation point's shift, and from them everything.
fn close(setting: &Setting<'_>, layers: &Layers, rows: &[Rows], mismatch: &[f64]) -> Option<Step> {
    let count = setting.stations();
    let mut matrix = Mat::zeros(count + 1, count + 1);
    let mut side = Mat::zeros(count + 1, 1);
    for j in 0..count {
        let sign = layers.sign(j);
        for i in 0..count {
            matrix[(i, j)] = -setting.flow.response[(i, j)] * sign;
        }
    }
    for (i, rows) in rows.iter().enumerate() {
        let sign = layers.sign(i);
        for (j, speed) in rows.stations.clone().zip(&rows.speed.masses) {
            matrix[(i, j)] += sign * speed;
        }
        matrix[(i, count)] = sign * rows.speed.shift;
        side[(i, 0)] = -mismatch[i] - sign * rows.speed.one;
    }
    let (_, slopes) = layers.stagnation_place(setting.panels);
    for (k, slope) in slopes.into_iter().enumerate() {
        let rows = &rows[layers.stagnation + k];
        for (j, speed) in rows.stations.clone().zip(&rows.speed.masses) {
            matrix[(count, j)] -= slope * speed;
        }
        matrix[(count, count)] -= slope * rows.speed.shift;
        side[(count, 0)] += slope * rows.speed.one;
    }
    matrix[(count, count)] += 1.0;
    let solution = matrix.partial_piv_lu().solve(&side);
    let masses: Vec<f64> = (0..count).map(|k| solution[(k, 0)]).collect();
    let shift = solution[(count, 0)];
    if !shift.is_finite() || masses.iter().any(|p| !p.is_finite()) {
        return None;
    }
    let change = |of: fn(&Rows) -> &Row| -> Vec<f64> {
        rows.iter()
            .map(|rows| of(rows).at(&rows.stations, &masses, shift))
            .collect()
    };
    let speed = change(|rows| &rows.speed);
    Some(Step {
        theta: change(|rows| &rows.theta),
        shear: change(|rows| &rows.shear),
        displacement: (0..count)
            .map(|k| (masses[k] - layers.displacement[k] * speed[k]) / layers.speed[k])
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
