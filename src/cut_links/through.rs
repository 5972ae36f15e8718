//! Air through a sheet that cuts links: through its fabric, and through openings that are narrower than the cells.
//!
//! **Fabric.** The velocity v along the normal follows from A Δp(v) = F. F is the normal force of the air on the sheet with v passing, A the area that a node stands for, and
//! Δp(v) = r v + s v|v| the fabric's law. F and A are smoothed along the sheet over about a cell. So single links, which see the slip along the sheet, too, do not decide. The
//! fabric's own velocity is that of the last step.
//!
//! **Narrow openings** are shut by triangles between their rims, and air passes these by the law of a sharp edge. A jet of the velocity v_o in the opening, of area O, contracts to the
//! share C of it ([`CONTRACTION`]). The pressure that drives it is ½ ρ v_o²/C², and it has the momentum ρ O v_o²/C. Cells carry a part of both themselves. The flow O v_o is spread over about a cell, of
//! which O is the share φ, and has the velocity φ v_o there. The rest is put in:
//!
//! Δp = ½ ρ v_o² (1/C² − φ²), and the momentum ρ O v_o² (1/C − φ) for the air behind.
//!
//! The sheet feels the opposite of what the air gets. Of an opening far narrower than a cell that is (1 − 2C) Δp O, less than nothing. Its rim lies in the suction of the flow towards it.
//!
//! Links between two layers let nothing pass where there are openings: a pleat has no air of its own.

use glam::DVec3;

use super::bounce::SIDES;
use super::faces::{self, Seen};
use super::search::{Cut, CutLink};
use super::smoothing::{self, Smoothing};
use crate::immersed::permeable::Resistance;
use crate::lattice::WEIGHTS;

/// Share of a sharp-edged opening that its jet contracts to, far from other openings: 1/(1 + 0.707) (Idelchik, Handbook of Hydraulic Resistance, diagram 8-1, thin grids with little open area).
pub const CONTRACTION: f64 = 1.0 / 1.707;

/// Smoothing steps that the flow of an opening takes along edges of a cell; along others, over the square of the edge.
const FLOW_OF_OPENINGS: f64 = 2.0;

/// Area below which nothing is spread to a node [cells²].
const NO_AREA: f64 = 1e-12;

/// Share of a node's links, outside of pleats, below which nothing passes about it.
const LEAST_SHARE: f64 = 0.1;

/// Passes in which the flow through openings and the force on the sheet find each other.
const PASSES: usize = 4;

/// What lets air through a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Passage {
    /// Nothing.
    Shut,
    /// Fabric with these resistances r and s [lattice units].
    Fabric([f64; 2]),
    /// It stands in an opening.
    Opening,
}

/// Velocity of the air through the sheet along its normals, at every node.
#[derive(Debug, Clone)]
pub struct Through {
    /// About the nodes that air may pass at.
    smoothing: Smoothing,
    /// r and s of the fabric at every node [lattice units]; `None` where nothing passes it.
    laws: Vec<Option<[f64; 2]>>,
    /// Triangles in openings.
    openings: Vec<u32>,
    /// Triangles that touch nodes that air may pass at.
    touched: Vec<bool>,
    /// Corners of openings.
    rims: Vec<u32>,
    /// Σ K (w·), Σ K, A, O, and Σ K of both faces, smoothed.
    push: Vec<f64>,
    stiffness: Vec<f64>,
    area: Vec<f64>,
    open: Vec<f64>,
    of_faces: [Vec<f64>; 2],
    /// Σ K of links between two layers, which let nothing pass where there are openings.
    shut: Vec<f64>,
    /// A and O.
    own_area: Vec<f64>,
    own_open: Vec<f64>,
    /// Through the fabric.
    through_fabric: Vec<f64>,
    /// Through all [cells per step].
    velocities: Vec<f64>,
    /// Velocity over that of the sheet by which the air behind gets the rest of a jet's momentum, along the normal [cells per step].
    jets: Vec<f64>,
    /// Mean over the permeable fabric [cells per step]; `None` where none is.
    mean: Option<f64>,
}

/// A link's side that a node has a part in.
#[derive(Debug, Clone, Copy)]
struct Held {
    nodes: [u32; 3],
    weights: [f64; 3],
    /// Stiffness across the sheet.
    across: f64,
}

impl Through {
    /// Of a surface whose triangles, of these areas, let air pass so [cells²]; `None` where nothing passes.
    #[must_use]
    pub fn new(
        triangles: &[[u32; 3]],
        passages: &[Passage],
        count: usize,
        areas: &[f64],
    ) -> Option<Self> {
        let mut laws = vec![None; count];
        let mut is_rim = vec![false; count];
        let mut openings = Vec::new();
        for (number, (nodes, passage)) in triangles.iter().zip(passages).enumerate() {
            match passage {
                Passage::Shut => {}
                Passage::Fabric(law) => {
                    for node in nodes {
                        laws[*node as usize] = laws[*node as usize].or(Some(*law));
                    }
                }
                Passage::Opening => {
                    openings.push(number as u32);
                    for node in nodes {
                        is_rim[*node as usize] = true;
                    }
                }
            }
        }
        let permeable = laws.iter().any(Option::is_some);
        if !permeable && openings.is_empty() {
            return None;
        }
        let at_a_rim = |nodes: &[u32; 3]| nodes.iter().any(|node| is_rim[*node as usize]);
        // Square of the mean edge of fabric, all of it or at rims, as if it were of equilateral triangles.
        let edge_squared = |all: bool| {
            let fabric = (triangles.iter().zip(passages).zip(areas))
                .filter(|((nodes, passage), _)| {
                    **passage != Passage::Opening && (all || at_a_rim(nodes))
                })
                .map(|(_, area)| area);
            let (sum, count) = fabric.fold((0.0, 0.0), |(sum, n), area| (sum + area, n + 1.0));
            sum / f64::max(count, 1.0) * 4.0 / 3f64.sqrt()
        };
        let of_fabric = || Smoothing::steps(1.0 / edge_squared(true));
        let of_openings = || Smoothing::steps(FLOW_OF_OPENINGS / edge_squared(false));
        let steps = match (permeable, openings.is_empty()) {
            (true, true) => of_fabric(),
            (false, _) => of_openings(),
            (true, false) => of_fabric().max(of_openings()),
        };
        let rims = smoothing::numbers(&is_rim);
        let from = if permeable { vec![true; count] } else { is_rim };
        let smoothing = Smoothing::new(triangles, from, steps);
        let mut reached = vec![false; count];
        for node in smoothing.nodes() {
            reached[node] = true;
        }
        let touched = (triangles.iter())
            .map(|nodes| nodes.iter().any(|node| reached[*node as usize]))
            .collect();
        let zero = || vec![0.0; count];
        Some(Self {
            smoothing,
            laws,
            openings,
            touched,
            rims,
            push: zero(),
            stiffness: zero(),
            area: zero(),
            open: zero(),
            of_faces: [zero(), zero()],
            shut: zero(),
            own_area: zero(),
            own_open: zero(),
            through_fabric: zero(),
            velocities: zero(),
            jets: zero(),
            mean: permeable.then_some(0.0),
        })
    }

    /// What rims give, smoothed along the sheet, over the area that each node stands for.
    fn spread(&self, of_rims: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut field = vec![0.0; self.laws.len()];
        for &rim in &self.rims {
            field[rim as usize] = of_rims(rim as usize);
        }
        self.smoothing.smooth(&mut field);
        for node in self.smoothing.nodes() {
            field[node] = match self.own_area[node] {
                area if area > NO_AREA => field[node] / area,
                _ => 0.0,
            };
        }
        field
    }

    /// The force that a velocity through the sheet takes off it, smoothed.
    fn relief(&self, held: &[Held], velocities: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; self.laws.len()];
        for held in held {
            let passing: f64 = (held.nodes.iter().zip(held.weights))
                .map(|(node, share)| share * velocities[*node as usize])
                .sum();
            for (node, share) in held.nodes.into_iter().zip(held.weights) {
                field[node as usize] += share * held.across * passing;
            }
        }
        self.smoothing.smooth(&mut field);
        field
    }

    /// Works out what passes, from what the links of this step see and the sheet's `own` velocity at a cut and `areas` of triangles [lattice units].
    /// `inside` is the density excess between the layers of every link.
    pub fn take(
        &mut self,
        seen: &Seen<'_>,
        inside: &[f64],
        (own, areas): (impl Fn(&Cut) -> DVec3, &[f64]),
    ) {
        let held = self.sum(seen, inside, own);
        self.measure(seen.triangles, areas);
        self.smooth();
        let mut in_openings = vec![
            0.0;
            if self.rims.is_empty() {
                0
            } else {
                self.laws.len()
            }
        ];
        let response = match self.rims.is_empty() {
            true => Vec::new(),
            false => self.relief(&held, &self.spread(|rim| self.own_open[rim])),
        };
        self.through_fabric.fill(0.0);
        self.velocities.fill(0.0);
        for pass in 0..if self.rims.is_empty() { 1 } else { PASSES } {
            let relief = match pass {
                0 => vec![0.0; self.laws.len()],
                _ => self.relief(&held, &self.velocities),
            };
            self.pass_fabric(&relief);
            let relief = match (pass, self.mean) {
                (_, None) | (0, _) => relief,
                // The fabric answered already.
                _ => {
                    let passing =
                        self.all(&self.spread(|rim| self.own_open[rim] * in_openings[rim]));
                    self.relief(&held, &passing)
                }
            };
            for &rim in &self.rims {
                let rim = rim as usize;
                let (taken, resists) = (self.area[rim], response[rim]);
                if resists > 0.0 && self.own_open[rim] > 0.0 {
                    let share = self.share(rim);
                    let law = 0.5 * (CONTRACTION.powi(-2) - share * share);
                    let slip = (self.push[rim] - relief[rim]) / resists + in_openings[rim];
                    let resistance = Resistance {
                        viscous: 0.0,
                        inertial: law * taken / resists,
                    };
                    in_openings[rim] = resistance.through_velocity(slip);
                } else {
                    in_openings[rim] = 0.0;
                }
            }
            self.velocities = match self.rims.is_empty() {
                true => self.through_fabric.clone(),
                false => self.all(&self.spread(|rim| self.own_open[rim] * in_openings[rim])),
            };
        }
        self.add_jets(&in_openings);
        self.take_mean();
    }

    /// What passes the fabric, on its own area, and what passes the openings.
    fn all(&self, of_openings: &[f64]) -> Vec<f64> {
        let mut all = of_openings.to_vec();
        for node in self.smoothing.nodes() {
            let woven = (self.own_area[node] - self.own_open[node]).max(0.0);
            if self.own_area[node] > NO_AREA {
                all[node] += self.through_fabric[node] * woven / self.own_area[node];
            }
        }
        all
    }

    /// Share of the smoothed area that is open.
    fn share(&self, rim: usize) -> f64 {
        (self.open[rim] / self.area[rim]).min(1.0)
    }

    /// Smooths what was summed, and the areas.
    fn smooth(&mut self) {
        let of_all = [&mut self.push, &mut self.stiffness, &mut self.area];
        for field in of_all {
            self.smoothing.smooth(field);
        }
        if !self.rims.is_empty() {
            self.smoothing.smooth(&mut self.open);
            for field in &mut self.of_faces {
                self.smoothing.smooth(field);
            }
        }
    }

    /// Sums what links see by nodes; returns what they hold.
    fn sum(&mut self, seen: &Seen<'_>, inside: &[f64], own: impl Fn(&Cut) -> DVec3) -> Vec<Held> {
        self.push.fill(0.0);
        self.stiffness.fill(0.0);
        self.of_faces.iter_mut().for_each(|face| face.fill(0.0));
        self.shut.fill(0.0);
        let mut all = Vec::new();
        for ((link, returns), inside) in seen.links.iter().zip(seen.returns).zip(inside) {
            let weight = WEIGHTS[link.leaving(0)];
            for side in SIDES {
                let cut = &link.cuts[side];
                if !self.touched[cut.triangle as usize] {
                    continue;
                }
                let nodes = seen.triangles[cut.triangle as usize];
                let leaving = link.direction() * if side == 0 { 1.0 } else { -1.0 };
                let across = leaving.dot(seen.normals[cut.triangle as usize]);
                let stiffness = 6.0 * weight * returns[side].strength;
                let push = returns[side].push()
                    - 2.0 * weight * inside
                    - stiffness * leaving.dot(own(cut));
                let held = Held {
                    nodes,
                    weights: cut.weights,
                    across: across * across * stiffness,
                };
                if self.shuts(link) {
                    for (node, share) in nodes.into_iter().zip(cut.weights) {
                        self.shut[node as usize] += share * held.across;
                    }
                    continue;
                }
                for (node, share) in nodes.into_iter().zip(cut.weights) {
                    self.push[node as usize] += share * across * push;
                    self.stiffness[node as usize] += share * across * across * stiffness;
                }
                if !self.rims.is_empty() {
                    let face = faces::face(seen.normals[cut.triangle as usize], link, side);
                    for (node, share) in nodes.into_iter().zip(cut.weights) {
                        self.of_faces[face][node as usize] += share * held.across;
                    }
                    all.push(held);
                }
            }
        }
        all
    }

    /// True if a link lets nothing pass: there is no air between two layers, as in a pleat, that could come through an opening.
    #[must_use]
    pub fn shuts(&self, link: &CutLink) -> bool {
        link.layers > 1 && self.has_openings()
    }

    /// Areas that nodes stand for, all and in openings, but for the share that lies in pleats.
    fn measure(&mut self, triangles: &[[u32; 3]], areas: &[f64]) {
        self.own_area.fill(0.0);
        self.own_open.fill(0.0);
        for (nodes, area) in triangles.iter().zip(areas) {
            for node in nodes {
                self.own_area[*node as usize] += area / 3.0;
            }
        }
        for &number in &self.openings {
            for node in triangles[number as usize] {
                self.own_open[node as usize] += areas[number as usize] / 3.0;
            }
        }
        if !self.rims.is_empty() {
            for node in self.smoothing.nodes() {
                let all = self.stiffness[node] + self.shut[node];
                if all > 0.0 {
                    let share = self.stiffness[node] / all;
                    // The flow of all would else go through the last link.
                    let passes = if share < LEAST_SHARE { 0.0 } else { share };
                    self.own_area[node] *= passes;
                    self.own_open[node] *= passes;
                }
            }
        }
        self.area.copy_from_slice(&self.own_area);
        self.open.copy_from_slice(&self.own_open);
    }

    /// What passes the fabric, where `relief` is the force that what passes takes off it.
    fn pass_fabric(&mut self, relief: &[f64]) {
        for (node, law) in self.laws.iter().enumerate() {
            let Some([viscous, inertial]) = *law else {
                continue;
            };
            let (stiffness, area) = (self.stiffness[node], self.area[node]);
            let through = &mut self.through_fabric[node];
            if stiffness > 0.0 {
                let resistance = Resistance {
                    viscous: viscous * area / stiffness,
                    inertial: inertial * area / stiffness,
                };
                let slip = (self.push[node] - relief[node]) / stiffness + *through;
                *through = resistance.through_velocity(slip);
            } else {
                *through = 0.0;
            }
        }
    }

    /// The rest of the momentum of jets, as a velocity of the sheet for the air behind.
    fn add_jets(&mut self, in_openings: &[f64]) {
        if self.rims.is_empty() {
            return;
        }
        let momenta = self.spread(|rim| {
            let speed = in_openings[rim];
            self.own_open[rim] * speed * speed.abs() * (1.0 / CONTRACTION - self.share(rim))
        });
        for node in self.smoothing.nodes() {
            let momentum = momenta[node];
            let behind = self.of_faces[usize::from(momentum < 0.0)][node];
            self.jets[node] = match behind {
                stiffness if stiffness > 0.0 => momentum * self.area[node] / stiffness,
                _ => 0.0,
            };
        }
    }

    fn take_mean(&mut self) {
        if let Some(mean) = &mut self.mean {
            let (mut flow, mut whole) = (0.0, 0.0);
            for (node, law) in self.laws.iter().enumerate() {
                if law.is_some() {
                    flow += self.through_fabric[node] * self.area[node];
                    whole += self.area[node];
                }
            }
            *mean = if whole > 0.0 { flow / whole } else { 0.0 };
        }
    }

    fn of_nodes(field: &[f64], nodes: [u32; 3], weights: [f64; 3]) -> f64 {
        let parts = nodes.into_iter().zip(weights);
        parts
            .map(|(node, share)| share * field[node as usize])
            .sum()
    }

    /// Velocity through the sheet at a cut, along the normal.
    #[must_use]
    pub fn at(&self, nodes: [u32; 3], weights: [f64; 3]) -> f64 {
        Self::of_nodes(&self.velocities, nodes, weights)
    }

    /// What comes to it there for the air behind a jet, on a face of the sheet ([`super::faces::face`]).
    #[must_use]
    pub fn jet(&self, face: usize, nodes: [u32; 3], weights: [f64; 3]) -> f64 {
        let jet = Self::of_nodes(&self.jets, nodes, weights);
        if (jet > 0.0) == (face == 0) { jet } else { 0.0 }
    }

    /// True if air passes openings that are shut by triangles.
    #[must_use]
    pub fn has_openings(&self) -> bool {
        !self.openings.is_empty()
    }

    /// Mean over the permeable fabric [cells per step]; `None` where none is.
    #[must_use]
    pub const fn mean(&self) -> Option<f64> {
        self.mean
    }

    /// Goes on with it as it was [cells per step].
    pub const fn go_on(&mut self, mean: f64) {
        self.mean = Some(mean);
    }
}
