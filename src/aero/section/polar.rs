//! Polars: forces and layers of a section over the angle of attack.
//!
//! Lift and moment are those of the surface pressures 1 − u². Drag is the momentum lost far behind, from the wake's end by Squire and Young's
//! formula, C_d = 2 θ u^((H + 5)/2) (Drela 1989).

use super::closure::Regime;
use super::error::SectionError;
use super::inviscid::{Inviscid, pressure_forces};
use super::layers::{Layers, Setting};
use super::march::first_guess;
use super::newton;
use super::panelling::Panels;
use super::station::Air;
use super::wake::Flow;
use glam::DVec2;

/// What the air is like, and where layers are tripped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Reynolds number of chord and stream.
    pub reynolds: f64,
    /// Exponent of the waves' amplification at which a layer turns turbulent, about 9 in a quiet wind tunnel.
    pub critical_amplification: f64,
    /// x/c of forced transition on the upper and lower side.
    pub forced_transition: [Option<f64>; 2],
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            reynolds: 1e6,
            critical_amplification: 9.0,
            forced_transition: [None; 2],
        }
    }
}

/// A section's flow without viscosity.
#[derive(Debug, Clone, PartialEq)]
pub struct InviscidState {
    /// Angle of attack [rad].
    pub angle_rad: f64,
    /// Lift coefficient.
    pub lift: f64,
    /// Moment coefficient about the quarter chord, nose up.
    pub moment_quarter_chord: f64,
    /// Pressure coefficients at [`Section::nodes`].
    pub pressures: Vec<f64>,
}

/// A section's flow with viscosity.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionState {
    /// Angle of attack [rad].
    pub angle_rad: f64,
    /// Lift coefficient.
    pub lift: f64,
    /// Drag coefficient.
    pub drag: f64,
    /// Moment coefficient about the quarter chord, nose up.
    pub moment_quarter_chord: f64,
    /// Friction's part of the drag coefficient.
    pub friction_drag: f64,
    /// x/c of transition on the upper and lower side.
    pub transition: [f64; 2],
    /// x/c on the upper and lower side from which on the turbulent layer runs backwards at the wall, to the trailing edge.
    pub separation: [Option<f64>; 2],
    /// Pressure coefficients at [`Section::nodes`].
    pub pressures: Vec<f64>,
}

/// A section, ready to be solved at any angle.
#[derive(Debug)]
pub struct Section {
    inviscid: Inviscid,
}

/// Angles may be this large [rad].
const LARGEST_ANGLE_RAD: f64 = 0.8;

/// Where a first solution is looked for when there is none at the angle itself [rad].
const DETOURS_RAD: [f64; 6] = [-0.01, 0.01, -0.03, 0.03, -0.06, 0.06];

/// Angles in a row without a solution after which those farther out are not tried: each of them costs a second.
const GIVEN_UP_AFTER: usize = 4;

/// Halvings of the step from one angle to the next.
const HALVINGS: u32 = 2;

impl Section {
    /// A section from its outline: points from the trailing edge along the lower side around the nose and along the upper side to the trailing
    /// edge, over the chord. It is covered with panels anew; 160 are enough.
    pub fn new(outline: &[DVec2], panels: usize) -> Result<Self, SectionError> {
        Ok(Self {
            inviscid: Inviscid::new(Panels::new(outline, panels)?)?,
        })
    }

    /// Ends of the panels, in the outline's order.
    #[must_use]
    pub fn nodes(&self) -> &[DVec2] {
        &self.inviscid.panels.nodes
    }

    /// The flow without viscosity.
    #[must_use]
    pub fn inviscid(&self, angle_rad: f64) -> InviscidState {
        let speeds = self.inviscid.speeds(angle_rad);
        let pressures: Vec<f64> = speeds.iter().map(|u| 1.0 - u * u).collect();
        let [lift, moment_quarter_chord] =
            pressure_forces(&self.inviscid.panels, &pressures, angle_rad);
        InviscidState {
            angle_rad,
            lift,
            moment_quarter_chord,
            pressures,
        }
    }

    /// The flow at several angles, in their order. The sweep begins at the angle nearest zero lift and goes outwards, each angle started from its
    /// neighbour; one that fails is tried from a first guess of its own, then in smaller steps.
    #[must_use]
    pub fn polar(
        &self,
        angles_rad: &[f64],
        conditions: &Conditions,
    ) -> Vec<Result<SectionState, SectionError>> {
        self.polar_while(angles_rad, conditions, |outwards| {
            let failures = outwards.iter().rev().take_while(|state| state.is_none());
            failures.count() < GIVEN_UP_AFTER
        })
    }

    /// The same as far outwards as `more` asks for it, which is told what was found on this side of zero lift, nearest first; `None` where nothing was. Angles farther out count as given up.
    #[must_use]
    pub fn polar_while(
        &self,
        angles_rad: &[f64],
        conditions: &Conditions,
        more: impl Fn(&[Option<&SectionState>]) -> bool + Sync,
    ) -> Vec<Result<SectionState, SectionError>> {
        if let Err(error) = check(angles_rad, conditions) {
            return angles_rad.iter().map(|_| Err(error.clone())).collect();
        }
        let [at_zero, beyond] = [0.0, 0.1].map(|angle| self.inviscid(angle).lift);
        let zero_lift = -0.1 * at_zero / (beyond - at_zero);
        let mut order: Vec<usize> = (0..angles_rad.len()).collect();
        order.sort_by(|&a, &b| angles_rad[a].total_cmp(&angles_rad[b]));
        let first = order.partition_point(|&k| angles_rad[k] < zero_lift);
        let upwards = &order[first..];
        let downwards: Vec<usize> = order[..first].iter().rev().copied().collect();
        let given_up = |k: usize| SectionError::GivenUp {
            degrees: angles_rad[k].to_degrees(),
        };
        // Both ways from the same solution.
        let nearest = upwards
            .first()
            .map(|&k| self.solve(angles_rad[k], conditions, None));
        let start = nearest
            .as_ref()
            .and_then(|(_, layers)| Some((angles_rad[upwards[0]], layers.clone()?)));
        let sweep = |list: &[usize], mut found: Vec<Result<SectionState, SectionError>>| {
            let mut last = start.clone();
            for &k in &list[found.len()..] {
                let outwards: Vec<_> = found.iter().map(|state| state.as_ref().ok()).collect();
                if !more(&outwards) {
                    break;
                }
                let (state, layers) = self.solve(angles_rad[k], conditions, last.as_ref());
                last = layers.map(|layers| (angles_rad[k], layers)).or(last);
                found.push(state);
            }
            found
        };
        let nearest = nearest.map(|(state, _)| state).into_iter().collect();
        let (above, below) =
            rayon::join(|| sweep(upwards, nearest), || sweep(&downwards, Vec::new()));
        let mut results: Vec<_> = (0..angles_rad.len()).map(|k| Err(given_up(k))).collect();
        for (list, found) in [(upwards, above), (&downwards[..], below)] {
            for (k, state) in list.iter().zip(found) {
                results[*k] = state;
            }
        }
        results
    }

    /// Solves one angle, from a solution at another if there is one.
    fn solve(
        &self,
        angle_rad: f64,
        conditions: &Conditions,
        last: Option<&(f64, Layers)>,
    ) -> (Result<SectionState, SectionError>, Option<Layers>) {
        let mut worst = newton::Outcome {
            is_solved: false,
            residual: f64::INFINITY,
            steps: 0,
        };
        let mut attempt = |angle: f64, start: Option<&Layers>| {
            let flow = Flow::new(&self.inviscid, angle);
            let setting = self.setting(&flow, conditions);
            let mut layers = match start {
                Some(layers) => {
                    let mut layers = layers.clone();
                    layers.find_transition(&setting);
                    layers
                }
                None => first_guess(&setting),
            };
            let outcome = newton::solve(&setting, &mut layers);
            if angle == angle_rad && !outcome.is_solved && outcome.residual <= worst.residual {
                worst = outcome;
            }
            outcome
                .is_solved
                .then(|| (self.state(angle, &setting, &layers), layers))
        };
        let mut solved = last
            .and_then(|(_, layers)| attempt(angle_rad, Some(layers)))
            .or_else(|| attempt(angle_rad, None));
        if solved.is_none() {
            // Without a neighbour, one is made.
            let made = if last.is_none() {
                DETOURS_RAD.iter().find_map(|step| {
                    let angle = angle_rad + step;
                    attempt(angle, None).map(|(_, layers)| (angle, layers))
                })
            } else {
                None
            };
            solved = last
                .or(made.as_ref())
                .and_then(|(from, layers)| in_steps(*from, layers, angle_rad, &mut attempt));
        }
        match solved {
            Some((state, layers)) => (Ok(state), Some(layers)),
            None => (
                Err(SectionError::NotConverged {
                    degrees: angle_rad.to_degrees(),
                    residual: worst.residual,
                    steps: worst.steps,
                }),
                None,
            ),
        }
    }

    fn setting<'a>(&'a self, flow: &'a Flow, conditions: &Conditions) -> Setting<'a> {
        let [upper, lower] = conditions.forced_transition;
        Setting {
            panels: &self.inviscid.panels,
            flow,
            air: Air {
                reynolds: conditions.reynolds,
                critical: conditions.critical_amplification,
            },
            forced: [lower, upper],
        }
    }

    /// Forces and places from solved layers.
    fn state(&self, angle_rad: f64, setting: &Setting<'_>, layers: &Layers) -> SectionState {
        let panels = &self.inviscid.panels;
        let nodes = panels.count();
        let pressures: Vec<f64> = layers.speed[..nodes].iter().map(|u| 1.0 - u * u).collect();
        let [lift, moment_quarter_chord] = pressure_forces(panels, &pressures, angle_rad);
        let last = layers.station(setting, setting.stations() - 1);
        let shape = last.displacement / last.theta;
        let drag = 2.0 * last.theta * last.speed.powf(0.5 * (shape + 5.0));
        let along = DVec2::from_angle(angle_rad);
        let mut friction_drag = 0.0;
        let mut transition = [0.0; 2];
        let mut separation = [None; 2];
        for side in 0..2 {
            let stations = layers.side(side, nodes);
            let (at, share) = layers.transition[side];
            let [a, b] = [stations[at - 1], stations[at]].map(|k| panels.nodes[k].x);
            transition[1 - side] = a + share * (b - a);
            let stress: Vec<f64> = stations
                .iter()
                .enumerate()
                .map(|(k, &station)| {
                    let regime = if k < at {
                        Regime::Laminar
                    } else {
                        Regime::Turbulent
                    };
                    let friction = layers.friction(setting, station, regime);
                    friction * layers.speed[station] * layers.speed[station]
                })
                .collect();
            for k in 1..stations.len() {
                let step = panels.nodes[stations[k]] - panels.nodes[stations[k - 1]];
                friction_drag += 0.5 * (stress[k - 1] + stress[k]) * step.dot(along);
            }
            let attached = stress.iter().rposition(|&s| s >= 0.0);
            // A layer that separated laminar and stays so counts from transition on.
            if let Some(k) = attached
                .map(|k| k.max(at))
                .filter(|&k| k + 1 < stress.len())
            {
                let share = (stress[k] / (stress[k] - stress[k + 1])).clamp(0.0, 1.0);
                let [a, b] = [stations[k], stations[k + 1]].map(|k| panels.nodes[k].x);
                separation[1 - side] = Some(a + share * (b - a));
            }
        }
        SectionState {
            angle_rad,
            lift,
            drag,
            moment_quarter_chord,
            friction_drag,
            transition,
            separation,
            pressures,
        }
    }
}

/// Goes from a solution at one angle to another in 2, 4, ... steps.
fn in_steps<T>(
    from_rad: f64,
    layers: &Layers,
    to_rad: f64,
    attempt: &mut impl FnMut(f64, Option<&Layers>) -> Option<(T, Layers)>,
) -> Option<(T, Layers)> {
    (1..=HALVINGS).find_map(|halvings| {
        let parts = 1u32 << halvings;
        let mut current = layers.clone();
        for part in 1..parts {
            let angle = from_rad + (to_rad - from_rad) * f64::from(part) / f64::from(parts);
            current = attempt(angle, Some(&current))?.1;
        }
        attempt(to_rad, Some(&current))
    })
}

/// Refuses conditions and angles that make no sense.
fn check(angles_rad: &[f64], conditions: &Conditions) -> Result<(), SectionError> {
    let wrong = |what: String| Err(SectionError::Conditions(what));
    if let Some(angle) = angles_rad
        .iter()
        .find(|a| a.is_nan() || a.abs() > LARGEST_ANGLE_RAD)
    {
        return wrong(format!(
            "an angle of {angle} rad is beyond ±{LARGEST_ANGLE_RAD} rad"
        ));
    }
    let reynolds = conditions.reynolds;
    if !(1e4..=1e9).contains(&reynolds) {
        return wrong(format!(
            "the Reynolds number has to be from 1e4 to 1e9, not {reynolds}"
        ));
    }
    let critical = conditions.critical_amplification;
    if !(0.5..=20.0).contains(&critical) {
        return wrong(format!(
            "the critical amplification has to be from 0.5 to 20, not {critical}"
        ));
    }
    let places = conditions.forced_transition.iter().flatten();
    if let Some(place) = places.into_iter().find(|p| !(0.0..=1.0).contains(*p)) {
        return wrong(format!(
            "transition can be forced from x/c = 0 to 1, not at {place}"
        ));
    }
    Ok(())
}
