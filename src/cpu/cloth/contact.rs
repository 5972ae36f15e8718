//! Part of stage `solve_cloth`: fabric that meets itself. The law and its sources are in [`crate::cloth::contact`].
//!
//! Pairs are searched for with some room, and again when a node has moved so far, beside what all have moved in common, that an unlisted
//! pair might have come closer than the thickness. Energies of pairs that push are added up in the order of the search, on one thread;
//! all else runs in parallel, so that results do not depend on the number of threads. They do depend, by rounding, on where the last search
//! was: that belongs to the state, and into checkpoints.
//!
//! The stiffness κ of a pair \[N/m\] is the mean, over its four nodes, of what holds a node in the step: inertia m/dt² and the air's K/dt,
//! the load over the thickness, and a thousandth of the fabric's tensile stiffness where nothing else does. A node that would be moved
//! through n thicknesses in a step is then stopped at a gap of about h/n, and one that its load presses on at about half the
//! thickness.

use std::time::{Duration, Instant};

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use super::initial_hessian::outer;
use super::loads::StepInput;
use super::pressure;
use crate::cloth::Structure;
use crate::cloth::contact::advance::free_share;
use crate::cloth::contact::barrier::{Push, push};
use crate::cloth::contact::pairs::{Pair, Surface};

/// Room of a search, as a share of the mean edge: more makes more pairs to look at in every evaluation, less makes more searches.
const ROOM: f64 = 0.1;

/// Pairs that may be looked at in vain, per pair of a search, before the next: about what a search costs.
const VAIN: f64 = 8.0;

/// Longest way of a node, beside what all move in common, in one trial, as a share of the mean edge.
const LONGEST_WAY: f64 = 0.5;

/// Share of the smallest distance that a step without a look at pairs may use up; less than what a pair may lose.
const SHORT_STEP: f64 = 0.8;

/// Share of the fabric's tensile stiffness that a pair has at least.
const FABRIC_SHARE: f64 = 1e-3;

/// Pairs that one task works on.
const AT_ONCE: usize = 512;

/// Up to so many pairs one thread is faster.
const ALONE: usize = 2048;

/// What contact does at the end of a solve.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactState {
    /// Forces on the nodes [N], `[node_count]`; they sum to zero.
    pub forces_n: Vec<DVec3>,
    /// Energy [J].
    pub energy_j: f64,
    /// Smallest distance of fabric from fabric [m]; infinite where none is closer than the thickness.
    pub smallest_gap_m: f64,
    /// Where pairs were searched for [m], `[node_count]`.
    pub searched_m: Vec<DVec3>,
    /// Farthest that a node may be from there, beside what all have moved in common [m]; negative before the first search.
    pub room_m: f64,
    /// Pairs looked at in vain since then.
    pub vain: f64,
}

/// Fabric that meets itself, during solves.
#[derive(Debug, Clone)]
pub(super) struct Contacts {
    surface: Surface,
    thickness_m: f64,
    /// Of all pairs, those that start close included [m].
    least_thickness_m: f64,
    room_m: f64,
    longest_way_m: f64,
    least_stiffness_n_m: f64,
    /// Pairs near enough to matter while nodes stay near where they were searched for, nearest first, with their distance there [m].
    pairs: Vec<(f64, Pair)>,
    /// What holds every node [N/m], `[node_count]`.
    stiffness_n_m: Vec<f64>,
    /// Where pushes were last evaluated [m], and a distance that no pair was below there [m]; spares the look at pairs before short steps.
    evaluated: (Vec<DVec3>, f64),
    /// Pushes where the initial Hessian was built.
    built: Vec<Push>,
    pub(super) state: ContactState,
    pub(super) time: Duration,
}

/// How far a step may go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Free {
    /// Share of the step, at most 1.
    pub(super) share: f64,
    /// True if fabric is in the way, not only that a trial may not go farther.
    pub(super) in_the_way: bool,
}

/// Stiffness of the pushes of one node, for the matrix of multigrid.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    starts: Vec<u32>,
    entries: Vec<(u32, DMat3)>,
}

impl Rows {
    /// (column, block [N/m]) of a row.
    pub(super) fn row(&self, node: usize) -> &[(u32, DMat3)] {
        match self.starts.get(node..node + 2) {
            Some(range) => &self.entries[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }
}

/// Longest of the displacements of some nodes, beside their mean [m].
fn farthest_m(nodes: &[u32], displacement: impl Fn(usize) -> DVec3) -> f64 {
    let mut common = DVec3::ZERO;
    for node in nodes {
        common += displacement(*node as usize);
    }
    common /= nodes.len().max(1) as f64;
    let farthest = nodes.iter().fold(0.0, |farthest: f64, node| {
        farthest.max((displacement(*node as usize) - common).length_squared())
    });
    farthest.sqrt()
}

/// What `of` finds for every chunk of pairs, in order.
fn of_chunks<R: Send>(
    pairs: &[(f64, Pair)],
    of: impl Fn(&[(f64, Pair)]) -> R + Sync + Send,
) -> Vec<R> {
    if pairs.len() <= ALONE {
        pairs.chunks(AT_ONCE).map(of).collect()
    } else {
        pairs.par_chunks(AT_ONCE).map(of).collect()
    }
}

impl Contacts {
    /// `None` for a structure that passes through itself.
    pub(super) fn new(structure: &Structure) -> Option<Self> {
        let thickness_m = structure.contact?.thickness_m;
        let surface = Surface::new(structure, thickness_m);
        let edge = surface.mean_edge_m();
        let tensile = match structure.laws() {
            // The softest: a stiff panel does not show how soft the others may be pushed.
            Some(laws) => laws
                .all()
                .map(|law| law.stiffness()[0][0])
                .fold(f64::INFINITY, f64::min),
            None => {
                let springs = structure.springs.iter().map(|s| s.stiffness_n_m);
                springs.sum::<f64>() / structure.springs.len().max(1) as f64
            }
        };
        Some(Self {
            least_thickness_m: surface.least_thickness_m(),
            surface,
            thickness_m,
            room_m: ROOM * edge,
            longest_way_m: LONGEST_WAY * edge,
            least_stiffness_n_m: FABRIC_SHARE * tensile,
            pairs: Vec::new(),
            stiffness_n_m: Vec::new(),
            evaluated: (structure.positions_m.clone(), 0.0),
            built: Vec::new(),
            state: ContactState {
                forces_n: vec![DVec3::ZERO; structure.node_count()],
                energy_j: 0.0,
                smallest_gap_m: f64::INFINITY,
                searched_m: structure.positions_m.clone(),
                room_m: -1.0,
                vain: 0.0,
            },
            time: Duration::ZERO,
        })
    }

    /// Goes on from a state, as if it had been reached here.
    pub(super) fn restore(&mut self, state: ContactState) {
        if state.room_m >= 0.0 {
            self.search(&state.searched_m, state.room_m);
        }
        self.state = state;
    }

    /// Prepares a solve: `loads` are those that stay [N].
    pub(super) fn begin(
        &mut self,
        structure: &Structure,
        start: &[DVec3],
        input: &StepInput,
        loads: &[DVec3],
    ) {
        let began = Instant::now();
        // What is spared decides when pairs are searched for again, and must not depend on what was solved before.
        self.evaluated.1 = -1.0;
        self.stiffness_n_m.clear();
        let mut loads = loads.to_vec();
        if input.pressure_follows() {
            pressure::add_forces(structure, start, input.pressure.following(), &mut loads);
        }
        let stiffness = loads
            .iter()
            .map(|load| self.least_stiffness_n_m + load.length() / self.thickness_m);
        self.stiffness_n_m.extend(stiffness);
        if let Some(dt) = input.time_step_s {
            for (k, mass) in self.stiffness_n_m.iter_mut().zip(&structure.masses_kg) {
                *k += mass / dt * (1.0 / dt + input.damping_1_s);
            }
            for marker in input.markers {
                let nodes = structure.triangles[marker.triangle as usize].nodes;
                for (node, weight) in nodes.into_iter().zip(marker.weights) {
                    self.stiffness_n_m[node as usize] += marker.stiffness_kg_s / dt * weight;
                }
            }
            for reaction in input.cut_triangles {
                let nodes = structure.triangles[reaction.triangle as usize].nodes;
                for (corner, node) in nodes.into_iter().enumerate() {
                    self.stiffness_n_m[node as usize] += reaction.stiffness_at(corner) / dt;
                }
            }
        }
        self.time += began.elapsed();
    }

    /// Farthest that a node of the fabric is from where pairs were searched for, beside what all have moved in common [m].
    fn excursion_m(&self, place: impl Fn(usize) -> DVec3) -> f64 {
        let searched = &self.state.searched_m;
        farthest_m(&self.surface.nodes, |node| place(node) - searched[node])
    }

    fn search(&mut self, positions: &[DVec3], room_m: f64) {
        // Two nodes may both use their room, towards each other.
        let reach = self.thickness_m + 2.0 * room_m;
        let found = self.surface.search(positions, reach);
        self.pairs.clear();
        self.pairs.extend(
            found
                .into_iter()
                .map(|pair| (pair.gap_m(&pair.places(positions)), pair)),
        );
        // Stable, so that the order depends on the positions alone.
        self.pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.state.searched_m.clear();
        self.state.searched_m.extend_from_slice(positions);
        self.state.room_m = room_m;
        self.state.vain = 0.0;
    }

    /// Searches anew if the pairs do not hold at these positions; returns how far nodes are from where the search was \[m\].
    fn ensure(&mut self, positions: &[DVec3]) -> f64 {
        let excursion_m = self.excursion_m(|node| positions[node]);
        if excursion_m <= self.state.room_m && self.state.vain <= VAIN * self.pairs.len() as f64 {
            return excursion_m;
        }
        self.search(positions, self.room_m);
        0.0
    }

    /// Pairs that may be closer than the thickness while no node is farther than this from where the search was \[m\].
    fn near(&self, excursion_m: f64) -> &[(f64, Pair)] {
        let reach = (self.thickness_m + 2.0 * excursion_m) * (1.0 + 1e-9);
        &self.pairs[..self.pairs.partition_point(|(gap, _)| *gap <= reach)]
    }

    /// Share of a step from `positions` that all pairs may go, at most 1.
    pub(super) fn free_share(
        &mut self,
        positions: &[DVec3],
        step: impl Fn(usize) -> DVec3 + Sync,
    ) -> Free {
        let began = Instant::now();
        let way_m = farthest_m(&self.surface.nodes, &step);
        let limit = if way_m > self.longest_way_m {
            self.longest_way_m / way_m
        } else {
            1.0
        };
        let (evaluated, gap_m) = &self.evaluated;
        let since_m = farthest_m(&self.surface.nodes, |node| {
            positions[node] - evaluated[node]
        });
        if 2.0 * (limit * way_m + since_m) <= SHORT_STEP * gap_m {
            // Too short for any pair to lose most of its distance.
            self.time += began.elapsed();
            return Free {
                share: limit,
                in_the_way: false,
            };
        }
        let there = |node: usize| positions[node] + step(node) * limit;
        let before = self.ensure(positions);
        let mut excursion_m = before.max(self.excursion_m(there));
        if excursion_m > self.state.room_m {
            // A little more, for rounding.
            excursion_m = way_m * limit * (1.0 + 1e-9);
            self.search(positions, self.room_m.max(excursion_m));
        }
        self.count_vain(excursion_m);
        // The others stay farther apart than the thickness on the whole way.
        let shares = of_chunks(self.near(excursion_m), |pairs| {
            pairs.iter().fold(limit, |share, (_, pair)| {
                free_share(pair, positions, &step, share)
            })
        });
        let share = shares.into_iter().fold(limit, f64::min);
        self.time += began.elapsed();
        Free {
            share,
            in_the_way: share < limit,
        }
    }

    /// Counts the pairs that are looked at only because nodes have moved since the search.
    fn count_vain(&mut self, excursion_m: f64) {
        let vain = self.near(excursion_m).len() - self.near(0.0).len();
        self.state.vain += vain as f64;
    }

    /// Pushes at some positions, in the order of the pairs.
    fn pushes(&mut self, positions: &[DVec3]) -> Vec<Push> {
        let excursion_m = self.ensure(positions);
        self.count_vain(excursion_m);
        let stiffness = |pair: &Pair| {
            0.25 * pair
                .nodes
                .iter()
                .map(|node| self.stiffness_n_m[*node as usize])
                .sum::<f64>()
        };
        let parts: Vec<Vec<Push>> = of_chunks(self.near(excursion_m), |pairs| {
            pairs
                .iter()
                .filter_map(|(_, pair)| push(pair, positions, stiffness(pair)))
                .collect()
        });
        let pushes = parts.concat();
        let gaps = pushes.iter().map(|push| push.gap_m);
        // Pairs that do not push are farther apart than their own thickness, which may be smaller.
        let least_m = gaps.fold(self.least_thickness_m, f64::min);
        self.evaluated.0.clear();
        self.evaluated.0.extend_from_slice(positions);
        self.evaluated.1 = least_m;
        pushes
    }

    /// Adds the gradient [N], and returns the energy [J].
    pub(super) fn add_gradient(&mut self, positions: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        let began = Instant::now();
        let mut energy_j = 0.0;
        for push in self.pushes(positions) {
            energy_j += push.energy_j;
            for (node, part) in push.nodes.into_iter().zip(push.gradient_n) {
                gradient[node as usize] += part;
            }
        }
        self.time += began.elapsed();
        energy_j
    }

    /// Keeps the pushes at the positions where an initial Hessian is built.
    pub(super) fn build(&mut self, positions: &[DVec3]) {
        let began = Instant::now();
        self.built = self.pushes(positions);
        self.time += began.elapsed();
    }

    /// Adds the diagonal blocks [N/m] where it was built.
    pub(super) fn add_blocks(&self, blocks: &mut [DMat3]) {
        for push in &self.built {
            let along = outer(push.normal, push.normal) * push.curvature_n_m;
            for (node, weight) in push.nodes.into_iter().zip(push.weights) {
                blocks[node as usize] += along * (weight * weight);
            }
        }
    }

    /// What multigrid's matrix takes: the blocks between nodes of the same side, which share an element. Those between the sides change
    /// from step to step, and with them the pattern of every level; the part kept is positive semidefinite and at least half of
    /// the whole.
    pub(super) fn rows(&self, node_count: usize) -> Rows {
        let mut entries = Vec::new();
        for (push, [row, column]) in self
            .built
            .iter()
            .flat_map(|push| same_side(push).map(move |places| (push, places)))
        {
            let weight = push.weights[row] * push.weights[column];
            if weight != 0.0 {
                let block = outer(push.normal, push.normal) * (push.curvature_n_m * weight);
                entries.push((push.nodes[row], push.nodes[column], block));
            }
        }
        entries.sort_by_key(|(row, ..)| *row);
        let mut starts = vec![0u32; node_count + 1];
        for (row, ..) in &entries {
            starts[*row as usize + 1] += 1;
        }
        for i in 0..node_count {
            starts[i + 1] += starts[i];
        }
        Rows {
            starts,
            entries: entries.into_iter().map(|(_, c, b)| (c, b)).collect(),
        }
    }

    /// Adds to a product with multigrid's matrix what it lacks: the blocks between the two sides of every pair.
    pub(super) fn add_between_sides(&self, held: &[bool], vector: &[Vec3], product: &mut [Vec3]) {
        for push in &self.built {
            let along: [f64; 4] = std::array::from_fn(|i| {
                let node = push.nodes[i] as usize;
                push.weights[i] * push.normal.dot(vector[node].as_dvec3())
            });
            for (i, node) in push.nodes.into_iter().enumerate() {
                if held[node as usize] {
                    continue;
                }
                let other: f64 = (0..4)
                    .filter(|j| (push.weights[*j] > 0.0) != (push.weights[i] > 0.0))
                    .map(|j| along[j])
                    .sum();
                let force = push.curvature_n_m * push.weights[i] * other;
                product[node as usize] += (push.normal * force).as_vec3();
            }
        }
    }

    /// Keeps what contact does at the end of a solve.
    pub(super) fn finish(&mut self, positions: &[DVec3]) {
        let began = Instant::now();
        let pushes = self.pushes(positions);
        let state = &mut self.state;
        state.forces_n.fill(DVec3::ZERO);
        (state.energy_j, state.smallest_gap_m) = (0.0, f64::INFINITY);
        for push in pushes {
            state.energy_j += push.energy_j;
            state.smallest_gap_m = state.smallest_gap_m.min(push.gap_m);
            for (node, part) in push.nodes.into_iter().zip(push.gradient_n) {
                state.forces_n[node as usize] -= part;
            }
        }
        self.time += began.elapsed();
    }
}

/// Places of two nodes of the same side.
fn same_side(push: &Push) -> impl Iterator<Item = [usize; 2]> + '_ {
    let side = |i: usize| push.weights[i] > 0.0;
    (0..4)
        .flat_map(|row| (0..4).map(move |column| [row, column]))
        .filter(move |[row, column]| side(*row) == side(*column))
}
