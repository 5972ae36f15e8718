//! The boundary layers of a section and its wake: their stations' states, which side each is on, and where transition is.
//!
//! Stations are numbered as in `wake::Flow`: the surface's nodes from the lower trailing edge to the upper one, then the wake's. The
//! stagnation point lies where the speed along the surface, linear between two nodes, vanishes; first stations then have u/ξ alike on both sides.
//!
//! Departure: transition is found anew after each step, from the waves in the layers as they are. XFOIL solves all stations anew in their order instead.

use super::amplification::{self, Growth};
use super::closure::{Regime, least_shape};
use super::interval::Kind;
use super::panelling::Panels;
use super::station::{Air, State, Station};
use super::wake::Flow;

/// Turbulent share of the last interval of a side that is laminar up to there, tripped at the trailing edge.
const TRIPPED_SHARE: f64 = 0.01;

/// Speeds are at least this, for the logarithms' sake.
const LEAST_SPEED: f64 = 1e-9;

/// A node whose speed is this small may stay on the wrong side of the stagnation point, or it would change sides for ever.
const STILL: f64 = 5e-8;

/// The state of all layers.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// The stagnation point lies between this node and the next.
    pub stagnation: usize,
    /// Momentum thickness [chords].
    pub theta: Vec<f64>,
    /// Displacement thickness, with the dead air [chords].
    pub displacement: Vec<f64>,
    /// Root of the shear stress coefficient, or n.
    pub shear: Vec<f64>,
    /// Speed at the edge, positive.
    pub speed: Vec<f64>,
    /// Lower and upper side: at which of its intervals transition lies, and at which share of it.
    pub transition: [(usize, f64); 2],
    /// Whether each is forced.
    pub is_forced: [bool; 2],
}

/// What stays as it is while the layers are solved.
#[derive(Debug)]
pub struct Setting<'a> {
    /// Panels of the surface.
    pub panels: &'a Panels,
    /// Inviscid flow and response.
    pub flow: &'a Flow,
    /// The air.
    pub air: Air,
    /// x/c of forced transition on the lower and upper side.
    pub forced: [Option<f64>; 2],
}

impl Setting<'_> {
    /// Nodes of the surface.
    pub fn nodes(&self) -> usize {
        self.panels.count()
    }

    /// All stations.
    pub fn stations(&self) -> usize {
        self.flow.speeds.len()
    }
}

impl Layers {
    /// Stations of a side from the stagnation point to the trailing edge; 0 is the lower side.
    pub fn side(&self, side: usize, nodes: usize) -> Vec<usize> {
        if side == 0 {
            (0..=self.stagnation).rev().collect()
        } else {
            (self.stagnation + 1..nodes).collect()
        }
    }

    /// Whether speed along the way of the nodes counts against the layer's.
    pub fn sign(&self, station: usize) -> f64 {
        if station <= self.stagnation {
            -1.0
        } else {
            1.0
        }
    }

    /// Length along the surface from the first node to the stagnation point, and its derivatives by the speeds of the nodes beside it.
    pub fn stagnation_place(&self, panels: &Panels) -> (f64, [f64; 2]) {
        let k = self.stagnation;
        let [lower, upper] = [self.speed[k], self.speed[k + 1]];
        let step = panels.along[k + 1] - panels.along[k];
        let sum = lower + upper;
        (
            panels.along[k] + step * lower / sum,
            [step * upper / (sum * sum), -step * lower / (sum * sum)],
        )
    }

    /// A station as the equations see it.
    pub fn station(&self, setting: &Setting<'_>, station: usize) -> Station {
        let (stagnation, _) = self.stagnation_place(setting.panels);
        let nodes = setting.nodes();
        let (place, dead_air) = if station < nodes {
            (self.place(setting.panels, station, stagnation), 0.0)
        } else {
            // The wake goes on from the upper side.
            let k = station - nodes;
            let edge = setting.panels.along[nodes - 1] - stagnation;
            (edge + setting.flow.behind[k], setting.flow.dead_air[k])
        };
        Station {
            theta: self.theta[station],
            displacement: self.displacement[station],
            shear: self.shear[station],
            speed: self.speed[station],
            place,
            dead_air,
        }
    }

    /// Distance of a surface station from the stagnation point; beside it without a difference of nearly equal lengths.
    fn place(&self, panels: &Panels, station: usize, stagnation: f64) -> f64 {
        let k = self.stagnation;
        if station == k || station == k + 1 {
            let step = panels.along[k + 1] - panels.along[k];
            step * self.speed[station] / (self.speed[k] + self.speed[k + 1])
        } else {
            (panels.along[station] - stagnation) * self.sign(station)
        }
    }

    /// What lies before the k-th station of a side.
    pub fn kind(&self, side: usize, k: usize) -> Kind {
        let (at, share) = self.transition[side];
        match k {
            0 => Kind::Stagnation,
            1 if at > 1 => Kind::Start,
            _ if k < at => Kind::Laminar,
            _ if k == at => Kind::Transition(self.is_forced[side].then_some(share)),
            _ => Kind::Turbulent,
        }
    }

    /// Follows the waves along both sides through the layers as they are, and finds where each turns turbulent.
    pub fn find_transition(&mut self, setting: &Setting<'_>) {
        for side in 0..2 {
            let stations = self.side(side, setting.nodes());
            let forced = self.forced_interval(setting, side, &stations);
            let old = self.transition[side].0;
            let mut found = None;
            self.shear[stations[0]] = 0.0;
            for k in 1..stations.len() {
                let from = self.station(setting, stations[k - 1]);
                let to = self.station(setting, stations[k]);
                let mut n = setting.air.critical;
                let mut share = forced.and_then(|(at, share)| (at == k).then_some(share));
                let mut is_forced = share.is_some();
                match amplification::follow(&from, &to, &setting.air) {
                    Growth::Transition(free) => {
                        if share.is_none_or(|forced| free < forced) {
                            share = Some(free);
                            is_forced = false;
                        }
                    }
                    Growth::Laminar(exponent) => n = exponent,
                }
                if let Some(share) = share {
                    found = Some((k, share, is_forced));
                    break;
                }
                if k + 1 < stations.len() {
                    self.shear[stations[k]] = n;
                }
            }
            let (at, share, is_forced) =
                found.unwrap_or((stations.len() - 1, 1.0 - TRIPPED_SHARE, true));
            self.transition[side] = (at, share);
            self.is_forced[side] = is_forced;
            // Stations that were laminar until now get the stress with which turbulence begins.
            for &station in stations.iter().take(old.min(stations.len())).skip(at) {
                self.shear[station] = self.first_shear(setting, station);
            }
        }
    }

    /// Where a side turns turbulent at the latest: the forced place, or the end of its last interval.
    pub fn trip(&self, setting: &Setting<'_>, side: usize) -> (usize, f64) {
        let stations = self.side(side, setting.nodes());
        self.forced_interval(setting, side, &stations)
            .unwrap_or((stations.len() - 1, 1.0 - TRIPPED_SHARE))
    }

    /// Root of the shear stress coefficient with which a turbulent layer would begin here.
    pub fn first_shear(&self, setting: &Setting<'_>, station: usize) -> f64 {
        let state = State::variable(&self.station(setting, station), 0);
        let shear = state
            .relations(Regime::Turbulent, &setting.air)
            .shear_at_transition()
            .value;
        shear.clamp(1e-4, 0.3)
    }

    /// Interval and share of it where transition is forced; none where the stagnation point lies behind that place, so that the layer never passes.
    fn forced_interval(
        &self,
        setting: &Setting<'_>,
        side: usize,
        stations: &[usize],
    ) -> Option<(usize, f64)> {
        let place = setting.forced[side]?;
        let x = |k: usize| setting.panels.nodes[stations[k]].x;
        let last = stations.len() - 1;
        if place >= x(last) {
            return None;
        }
        for k in (1..=last).rev() {
            if x(k - 1) <= place && place < x(k) {
                let share = (place - x(k - 1)) / (x(k) - x(k - 1));
                return Some((k, share.clamp(TRIPPED_SHARE, 1.0 - TRIPPED_SHARE)));
            }
        }
        None
    }

    /// Station in the wake's first place: both sides' layers together.
    pub fn join(&self, setting: &Setting<'_>) -> [f64; 3] {
        let [lower, upper] = [0, setting.nodes() - 1];
        let theta = self.theta[lower] + self.theta[upper];
        let weighted =
            self.shear[lower] * self.theta[lower] + self.shear[upper] * self.theta[upper];
        [
            theta,
            self.displacement[lower] + self.displacement[upper] + setting.flow.dead_air[0],
            weighted / theta,
        ]
    }

    /// Keeps H, thickness and stress in bounds that the relations can bear.
    pub fn limit(&mut self, setting: &Setting<'_>) {
        let nodes = setting.nodes();
        for station in 0..setting.stations() {
            let (regime, dead_air) = if station < nodes {
                (Regime::Turbulent, 0.0)
            } else {
                (Regime::Wake, setting.flow.dead_air[station - nodes])
            };
            let least = 1.0 + 1.02 * (least_shape(regime) - 1.0);
            let floor = least * self.theta[station] + dead_air;
            self.displacement[station] = self.displacement[station].max(floor);
        }
    }

    /// Moves the stagnation point to where the speeds along the way of the nodes, signed, change sign nearest to where it was.
    pub fn move_stagnation(&mut self, signed: &[f64]) {
        let old = self.stagnation;
        let nodes = signed.len();
        let is_still_there = signed[old] < STILL && signed[old + 1] > -STILL;
        let nearest = (1..nodes - 2)
            .filter(|&k| signed[k] < 0.0 && signed[k + 1] >= 0.0)
            .min_by_key(|&k| k.abs_diff(old));
        let new = if is_still_there {
            old
        } else {
            nearest.unwrap_or(old)
        };
        for station in old.min(new)..=old.max(new) + 1 {
            // Stations that change sides take on the state of the first one of their new side.
            let from = if new > old && station <= new && station > old {
                old
            } else if new < old && station > new && station <= old {
                old + 1
            } else {
                continue;
            };
            self.theta[station] = self.theta[from];
            self.displacement[station] = self.displacement[from];
            self.shear[station] = self.shear[from];
        }
        for (station, speed) in signed.iter().enumerate() {
            let sign = if station <= new { -1.0 } else { 1.0 };
            // A wrong sign away from the stagnation point is a step too long; next to it, it is rounding.
            let beside = station == new || station == new + 1;
            self.speed[station] = if beside { sign * speed } else { speed.abs() }.max(LEAST_SPEED);
        }
        if new != old {
            let moved = new as isize - old as isize;
            for (side, by) in [(0, moved), (1, -moved)] {
                let (at, share) = self.transition[side];
                self.transition[side] = (at.saturating_add_signed(by).max(1), share);
            }
        }
        self.stagnation = new;
    }

    /// Skin friction coefficient by the local speed at a station; zero in the wake.
    pub fn friction(&self, setting: &Setting<'_>, station: usize, regime: Regime) -> f64 {
        let state = State::variable(&self.station(setting, station), 0);
        state.relations(regime, &setting.air).friction.value
    }
}
