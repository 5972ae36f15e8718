//! Balance of fabric on lines as a whole, after its solve.
//!
//! The solver ends by an energy norm, in which what stiff lines carry too much or too little weighs next to nothing: a hundredth of a millimetre of a whole
//! canopy against them is a percent of its weight. So the fabric is shifted and turned as a rigid body, and the nodes of the lines are moved one by
//! one, until the forces on each of the latter and the forces and moments on the fabric as a whole are nothing. It is Newton's method in six
//! unknowns and three for each node of the lines; cables and guides make its matrix, since nothing in the fabric changes. In terms of
//! multigrid it is a correction from a coarse space, solved exactly.

use faer::Mat;
use faer::linalg::solvers::Solve;
use glam::{DMat3, DVec3};

use super::initial_hessian::cable_block;
use super::{Cloth, StepInput};

/// Newton steps.
const STEP_LIMIT: usize = 8;

/// What may be left over, over the sum of the loads.
const TOLERANCE: f64 = 1e-6;

/// No node moves farther in a step [m].
const LONGEST_M: f64 = 0.01;

/// Halvings of a step that makes things worse.
const HALVINGS: usize = 6;

/// More unknowns are left to the solver: the matrix is dense.
const UNKNOWN_LIMIT: usize = 4_000;

/// Shifts of the fabric along the axes, and turns about them.
const RIGID: usize = 6;

/// How nodes move with the unknowns.
#[derive(Clone, Copy)]
enum Motion {
    Held,
    /// With the fabric.
    Rigid,
    /// By three unknowns of its own, the first of which has this number.
    Own(usize),
}

struct Unknowns {
    motions: Vec<Motion>,
    count: usize,
    /// Middle of the fabric [m], and the length that its turns are measured with.
    middle: DVec3,
    reach_m: f64,
}

impl Unknowns {
    fn new(cloth: &Cloth) -> Self {
        let structure = &cloth.structure;
        let mut motions = vec![Motion::Held; structure.node_count()];
        for node in structure.triangles.iter().flat_map(|t| t.nodes) {
            if !structure.held[node as usize] {
                motions[node as usize] = Motion::Rigid;
            }
        }
        let mut count = RIGID;
        for node in structure.cables.iter().flat_map(|c| c.nodes) {
            let node = node as usize;
            if matches!(motions[node], Motion::Held) && !structure.held[node] {
                motions[node] = Motion::Own(count);
                count += 3;
            }
        }
        let fabric = || {
            let nodes = motions.iter().zip(&cloth.positions_m);
            nodes.filter_map(|(motion, place)| matches!(motion, Motion::Rigid).then_some(*place))
        };
        let middle = fabric().sum::<DVec3>() / fabric().count().max(1) as f64;
        let reach_m = fabric().map(|x| x.distance(middle)).fold(0.0, f64::max);
        Self {
            count,
            middle,
            reach_m,
            motions,
        }
    }

    /// Unknowns that move a node, with its displacement per metre of each.
    fn of(&self, node: usize, place: DVec3) -> Vec<(usize, DVec3)> {
        match self.motions[node] {
            Motion::Held => Vec::new(),
            Motion::Own(first) => (0..3).map(|a| (first + a, DVec3::AXES[a])).collect(),
            Motion::Rigid => {
                let arm = (place - self.middle) / self.reach_m;
                let turns = (3..RIGID).map(|k| (k, DVec3::AXES[k - 3].cross(arm)));
                (0..3).map(|a| (a, DVec3::AXES[a])).chain(turns).collect()
            }
        }
    }

    /// Forces along the unknowns [N].
    fn forces_n(&self, cloth: &Cloth, input: &StepInput) -> Vec<f64> {
        let mut forces = vec![0.0; self.count];
        let unbalanced = cloth.unbalanced_forces_n(input);
        for (node, (force, place)) in unbalanced.iter().zip(&cloth.positions_m).enumerate() {
            for (unknown, way) in self.of(node, *place) {
                forces[unknown] += force.dot(way);
            }
        }
        forces
    }

    /// Stiffness of cables and guides against the unknowns [N/m].
    fn matrix(&self, cloth: &Cloth) -> Mat<f64> {
        let (structure, positions) = (&cloth.structure, &cloth.positions_m);
        let mut matrix = Mat::zeros(self.count, self.count);
        let mut add = |ways: &[(usize, DVec3)], block: DMat3| {
            for (i, a) in ways {
                let pulled = block * *a;
                for (j, b) in ways {
                    matrix[(*i, *j)] += pulled.dot(*b);
                }
            }
        };
        for cable in &structure.cables {
            let [a, b] = cable.nodes.map(|n| n as usize);
            if matches!(
                [self.motions[a], self.motions[b]],
                [Motion::Rigid, Motion::Rigid]
            ) {
                continue;
            }
            let edge = positions[b] - positions[a];
            let block = cable_block(structure, cable, edge, edge.length());
            let mut ways = self.of(b, positions[b]);
            // Of the edge; an unknown that moves both ends comes once for each, and adds up in the matrix.
            ways.extend(
                self.of(a, positions[a])
                    .into_iter()
                    .map(|(i, way)| (i, -way)),
            );
            add(&ways, block);
        }
        for guide in &structure.guides {
            let node = guide.node as usize;
            let stiffness = DMat3::from_diagonal(guide.stiffness_n_m);
            add(&self.of(node, positions[node]), stiffness);
        }
        matrix
    }

    fn moved(&self, start: &[DVec3], amounts_m: &Mat<f64>, share: f64) -> Vec<DVec3> {
        let nodes = start.iter().enumerate();
        nodes
            .map(|(node, &place)| {
                let ways = self.of(node, place).into_iter();
                let way: DVec3 = ways.map(|(i, way)| way * amounts_m[(i, 0)]).sum();
                place + way * share
            })
            .collect()
    }
}

fn size(forces: &[f64]) -> f64 {
    forces.iter().map(|f| f * f).sum::<f64>().sqrt()
}

impl Cloth {
    /// Brings the fabric as a whole, and every node of the lines, into balance under the loads of `input`; leaves them as they are where that fails.
    pub fn balance_as_a_whole(&mut self, input: &StepInput) {
        let unknowns = Unknowns::new(self);
        if unknowns.reach_m <= 0.0 || unknowns.count > UNKNOWN_LIMIT {
            return;
        }
        let loads_n: f64 = self.loads_n(input).iter().map(|f| f.length()).sum();
        let mut forces = unknowns.forces_n(self, input);
        for _ in 0..STEP_LIMIT {
            if size(&forces) <= TOLERANCE * loads_n {
                return;
            }
            let right = Mat::from_fn(unknowns.count, 1, |i, _| forces[i]);
            let amounts = unknowns.matrix(self).partial_piv_lu().solve(&right);
            let start = self.positions_m.clone();
            let whole = unknowns.moved(&start, &amounts, 1.0);
            let ways = whole.iter().zip(&start).map(|(a, b)| a.distance(*b));
            let longest_m = ways.fold(0.0, f64::max);
            if whole.iter().any(|place| !place.is_finite()) {
                return;
            }
            let mut share = (LONGEST_M / longest_m).min(1.0);
            let mut better = None;
            for _ in 0..HALVINGS {
                self.positions_m = unknowns.moved(&start, &amounts, share);
                let now = unknowns.forces_n(self, input);
                if size(&now) < size(&forces) {
                    better = Some(now);
                    break;
                }
                share *= 0.5;
            }
            let Some(now) = better else {
                self.positions_m = start;
                return;
            };
            forces = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{InitialHessian, SolverSettings};
    use super::*;
    use crate::cloth::{Structure, Triangle};
    use crate::fabric::membrane::Membrane;
    use crate::frame::CableKind;
    use crate::lines::Cable;

    /// A sheet on forked lines, out of its equilibrium by a tenth of a millimetre: it and the fork are left in balance, the sheet's shape as it was.
    #[test]
    fn sheet_and_forks_come_to_rest_under_its_weight() {
        let mut structure = Structure::default();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for [x, y] in corners {
            structure.positions_m.push(DVec3::new(x, y, 0.0));
        }
        structure.positions_m.push(DVec3::new(0.0, -0.5, 2.0));
        structure.positions_m.push(DVec3::new(0.0, 0.0, 4.0));
        structure.masses_kg = vec![0.5, 1.0, 1.5, 1.0, 0.01, 0.0];
        structure.held = vec![false, false, false, false, false, true];
        structure.membrane = Some(Membrane::new(
            [[1e5, 0.0, 0.0], [0.0, 1e5, 0.0], [0.0, 0.0, 5e4]],
            0.5,
        ));
        for nodes in [[0, 1, 2], [0, 2, 3]] {
            let rest = nodes.map(|n: u32| glam::DVec2::from_array(corners[n as usize]));
            structure
                .triangles
                .push(Triangle::new(nodes, rest).unwrap());
        }
        let line = Cable::linear(1e-6, 1e-3, 1e9);
        for [a, b] in [[0, 4], [1, 4], [2, 5], [3, 5], [4, 5]] {
            let [x, y] = [a, b].map(|n: u32| structure.positions_m[n as usize]);
            structure.add_cable(&[a, b], &[x.distance(y)], &line, CableKind::SuspensionLine);
        }
        let mut cloth = Cloth::new(structure);
        let input = StepInput {
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-3,
            displacement_floor_m: 0.0,
            evaluation_limit: 10_000,
            history: 8,
            refresh_every: Some(10),
            initial_hessian: InitialHessian::BlockJacobi,
        };
        cloth.solve_cloth(&input, &settings);
        for node in [0, 1, 2, 3] {
            cloth.positions_m[node] += DVec3::new(3e-5, -5e-5, -1e-4);
        }
        cloth.positions_m[4] += DVec3::new(1e-4, 0.0, 1e-4);
        let edges = |cloth: &Cloth| {
            let x = &cloth.positions_m;
            [
                x[0].distance(x[1]),
                x[1].distance(x[2]),
                x[0].distance(x[2]),
            ]
        };
        let before = edges(&cloth);
        let force = |cloth: &Cloth| -> [f64; 2] {
            let forces = cloth.unbalanced_forces_n(&input);
            [forces[..4].iter().sum::<DVec3>(), forces[4]].map(DVec3::length)
        };
        let [sheet, fork] = force(&cloth);
        assert!(sheet > 0.05 && fork > 0.05, "{sheet} {fork}");
        cloth.balance_as_a_whole(&input);
        let [sheet, fork] = force(&cloth);
        // `TOLERANCE` of a weight of 39 N.
        assert!(sheet < 1e-4 && fork < 1e-4, "{sheet} {fork}");
        for (a, b) in before.iter().zip(edges(&cloth)) {
            assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
        }
        let supports: DVec3 = cloth.reactions_n(&input).iter().map(|(_, f)| *f).sum();
        assert!((supports.z - 4.01 * 9.81).abs() < 1e-3, "{supports}");
    }
}
