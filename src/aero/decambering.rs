//! Viscous lift and profile drag by turning the stream that each section feels.
//!
//! A section that the panel method alone would see at the effective angle α_e has in potential flow the lift a sin(α_e − α₀). Its polar has
//! less, C_l(α_e). The strip's onset flow is turned by Δ, about the strip's span, until both agree:
//!
//! ```text
//! a sin(α_e + Δ − α₀) = C_l(α_e) = 2 Γ(Δ)/(V c)
//! ```
//!
//! which is van Dam's correction of the angle (van Dam 2002, Prog. Aerospace Sci. 38; Gallay & Laurendeau 2015, AIAA J. 53), here on a panel
//! method in place of a lifting line. Γ is linear in the onset flows of the strips, so a few solutions per strip, from the factorisation that
//! there is, give its whole dependence. Mukherjee & Gopalarathnam (2006, J.
//! Aircraft 43) turn the mean line behind two hinges instead, and meet the polar's moment as well; this does not.
//!
//! Past the highest lift a section has two angles for a lift, and the equations have more than one solution. Two are told apart, and neither depends
//! on what was solved before: the [`Branch::Attached`] one, followed from the stream without lift up to the one asked for, and the [`Branch::Separated`] one, which
//! begins where no strip feels the others. Where a wing has only one of them, both are the same. The way there is pseudo-transient: α_e follows the lift that
//! the wing has over that of the polar,
//!
//! ```text
//! dα_e/dt = 2 Γ(Δ)/(V c) − C_l(α_e) + a μ ∂²α_e/∂k²
//! ```
//!
//! in implicit steps that grow as the difference falls, so that it ends in a solution that is stable. Where the polar falls, neighbouring strips would stall in
//! turns, however many there are; μ, over the number k of the strip, is just large enough to forbid that (an artificial viscosity as Chattot, AIAA 2004-220, has it), and nothing
//! elsewhere. Our departure: its size follows from the downwash of two strips in turns, π c |C_l′|/(32 w) for strips of width w.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};
use glam::DVec3;

use super::AeroError;
use super::polar::{Polar, SectionFlow};
use super::potential_flow::{Flow, PotentialFlow};
use super::surface::PanelSurface;

/// Largest difference of lift coefficients that counts as agreement.
pub const AGREEMENT: f64 = 1e-6;

/// Steps per stream.
const STEPS: usize = 400;

/// No angle changes more per step [rad].
const STEP_LIMIT_RAD: f64 = 0.03;

/// Longest piece of the way from the stream without lift [rad].
const PIECE_RAD: f64 = 0.0175;

/// First pseudo-time step, and the bounds of the others.
const FIRST_STEP: f64 = 1.0;
const STEP_BOUNDS: [f64; 2] = [1e-3, 1e8];

/// Share of π c |C_l′|/(32 w) by which the artificial viscosity is more than just enough.
const VISCOSITY_MARGIN: f64 = 2.5;

/// Which of the solutions past the highest lift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// That which follows from the stream without lift as the angle grows.
    Attached,
    /// That which follows from sections which do not feel each other.
    Separated,
}

/// What a strip's section does.
#[derive(Debug, Clone, Copy)]
pub struct Section<'a> {
    /// With viscosity.
    pub polar: &'a Polar,
    /// Without.
    pub flow: SectionFlow,
}

/// The response of a wing's circulation to the stream of each strip.
#[derive(Debug)]
pub struct Decambering<'a> {
    flow: &'a PotentialFlow<'a>,
    sections: Vec<Section<'a>>,
    /// Circulation of strip j for a unit stream at strip k along each axis [m], row by row.
    response_m: [Vec<f64>; 3],
}

/// A flow with viscosity.
#[derive(Debug, Clone, PartialEq)]
pub struct ViscousFlow {
    /// The potential flow whose sections have the lift of their polars; pressures follow from it.
    pub flow: Flow,
    /// Effective angle of each strip's section [rad].
    pub effective_rad: Vec<f64>,
    /// Drag of the sections [N]; of a symmetric wing both halves.
    pub profile_drag_n: f64,
    /// Largest difference of a strip's lift coefficient from its polar's, artificial viscosity included; beyond [`AGREEMENT`] nothing was found.
    pub residual: f64,
    /// Whether every section is at an angle that its polar covers.
    pub is_covered: bool,
}

impl<'a> Decambering<'a> {
    /// Learns how the strips act on each other; one section per strip.
    pub fn new(flow: &'a PotentialFlow<'a>, sections: Vec<Section<'a>>) -> Result<Self, AeroError> {
        let surface = flow.surface();
        let strips = surface.spanwise;
        if !surface.has_trailing_edge || sections.len() != strips {
            return Err(AeroError::Polar(format!(
                "{} sections were given for the {strips} strips of a wing",
                sections.len()
            )));
        }
        let response_m = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let onsets = (0..strips)
                .map(|k| {
                    let mut onset = vec![DVec3::ZERO; strips];
                    onset[k] = axis;
                    (axis, onset)
                })
                .collect();
            let columns = flow.solve_strips(onsets);
            (0..strips * strips)
                .map(|at| columns[at % strips].circulation_m2_s[at / strips])
                .collect()
        });
        Ok(Self {
            flow,
            sections,
            response_m,
        })
    }

    /// What the strips' sections do.
    #[must_use]
    pub fn sections(&self) -> &[Section<'a>] {
        &self.sections
    }

    /// The flow under each of several streams [m/s], on its own.
    pub fn solve(
        &self,
        streams_m_s: &[DVec3],
        branch: Branch,
        density_kg_m3: f64,
    ) -> Result<Vec<ViscousFlow>, AeroError> {
        // The streams are checked there.
        let inviscid = self.flow.solve(streams_m_s)?;
        Ok(inviscid
            .iter()
            .map(|flow| {
                let (effective, residual) = match branch {
                    Branch::Attached => self.attached(flow),
                    Branch::Separated => {
                        self.settled(flow.stream_m_s, self.geometric_rad(flow.stream_m_s))
                    }
                };
                self.finish(flow, effective, residual, density_kg_m3)
            })
            .collect())
    }

    fn attached(&self, inviscid: &Flow) -> (Vec<f64>, f64) {
        let stream = inviscid.stream_m_s;
        let surface = self.flow.surface();
        let start = inviscid
            .section_lift_coefficients(surface)
            .iter()
            .zip(&self.sections)
            .map(|(lift, s)| {
                (lift / s.flow.slope_per_rad).clamp(-1.0, 1.0).asin() + s.flow.zero_lift_rad
            })
            .collect();
        let at_once = self.settled(stream, start);
        // Where all polars rise there is only one solution.
        let is_only = at_once
            .0
            .iter()
            .zip(&self.sections)
            .all(|(&angle, s)| s.polar.is_below_stall(angle) && s.polar.lift(angle).1 > 0.0);
        if at_once.1 < AGREEMENT && is_only {
            return at_once;
        }
        let (from, to) = (self.without_lift_rad(), stream.z.atan2(stream.x));
        let pieces = ((to - from).abs() / PIECE_RAD).ceil().max(1.0);
        let in_plane = stream.x.hypot(stream.z);
        let mut last: Option<(Vec<f64>, f64)> = None;
        for piece in 0..=pieces as usize {
            let angle = from + (to - from) * piece as f64 / pieces;
            let on_the_way = DVec3::new(in_plane * angle.cos(), stream.y, in_plane * angle.sin());
            let start = last.map_or_else(
                || self.sections.iter().map(|s| s.flow.zero_lift_rad).collect(),
                |(effective, _)| effective,
            );
            last = Some(self.settled(on_the_way, start));
        }
        last.unwrap_or(at_once)
    }

    /// Angle of the stream to the x axis at which the wing as a whole has no lift in potential flow [rad].
    fn without_lift_rad(&self) -> f64 {
        let strips = self.sections.len();
        let lift = |axis: usize| -> f64 {
            (0..strips * strips)
                .map(|at| self.response_m[axis][at] * self.flow.surface().span_m(at / strips).y)
                .sum()
        };
        -(lift(0) / lift(2)).atan()
    }

    /// Angle of every strip's chord to a stream, in the plane across its span [rad].
    fn geometric_rad(&self, stream: DVec3) -> Vec<f64> {
        let surface = self.flow.surface();
        (0..self.sections.len())
            .map(|j| {
                let at = |i: usize| surface.node_m(i, j).midpoint(surface.node_m(i, j + 1));
                let chord = (at(0) - at(surface.chordwise / 2)).normalize_or_zero();
                let up = chord.cross(surface.span_m(j)).normalize_or_zero();
                stream.dot(up).atan2(stream.dot(chord))
            })
            .collect()
    }

    /// Effective angles that the pseudo-transient comes to from a start, and the largest difference left.
    fn settled(&self, stream: DVec3, start: Vec<f64>) -> (Vec<f64>, f64) {
        let first = self.settled_once(stream, start);
        // Viscosity of the way here is not that of this place.
        let again = self.settled_once(stream, first.0.clone());
        if again.1 < AGREEMENT { again } else { first }
    }

    fn settled_once(&self, stream: DVec3, start: Vec<f64>) -> (Vec<f64>, f64) {
        let mut effective = start;
        let mut viscosities = vec![0.0; effective.len()];
        let mut time_step = FIRST_STEP;
        let mut largest = f64::INFINITY;
        for _ in 0..STEPS {
            // It never falls on the way: polars have kinks, at which it would come and go.
            for (known, needed) in viscosities.iter_mut().zip(self.viscosities(&effective)) {
                *known = needed.max(*known);
            }
            let residual = self.residual(stream, &effective, &viscosities);
            largest = largest_of(&residual);
            if largest.is_nan() {
                largest = f64::INFINITY;
                break;
            }
            if largest < AGREEMENT {
                break;
            }
            let step = self.implicit_step(stream, (&effective, &viscosities), &residual, time_step);
            let longest = largest_of(&step);
            if !longest.is_finite() {
                break;
            }
            let length = (STEP_LIMIT_RAD / longest).min(1.0);
            let trial: Vec<f64> = effective
                .iter()
                .zip(&step)
                .map(|(angle, step)| angle + length * step)
                .collect();
            let is_worse = largest_of(&self.residual(stream, &trial, &viscosities)) > largest;
            let factor = if is_worse { 0.25 } else { 2.0 };
            time_step = (time_step * factor).clamp(STEP_BOUNDS[0], STEP_BOUNDS[1]);
            // Over a highest lift the difference may have to grow; with small steps it may.
            if !is_worse || time_step < 0.1 * FIRST_STEP {
                effective = trial;
            }
        }
        (effective, largest)
    }

    /// What drives the effective angles.
    fn residual(&self, stream: DVec3, effective: &[f64], viscosities: &[f64]) -> Vec<f64> {
        let surface = self.flow.surface();
        let onset = self.onset(stream, effective);
        let speed = stream.length();
        (0..effective.len())
            .map(|j| {
                let lift = 2.0 * self.circulation(j, &onset) / (speed * surface.chord_m(j));
                let [before, after] = self.beside(j);
                let bend = effective[before] - 2.0 * effective[j] + effective[after];
                lift - self.sections[j].polar.lift(effective[j]).0 + viscosities[j] * bend
            })
            .collect()
    }

    /// The strips beside one; at a plane of symmetry and at tips the strip itself.
    fn beside(&self, strip: usize) -> [usize; 2] {
        [
            strip.saturating_sub(1),
            (strip + 1).min(self.sections.len() - 1),
        ]
    }

    /// a μ of every strip: what it or a strip beside it needs, so that none is forbidden to stall beside one that has.
    fn viscosities(&self, effective: &[f64]) -> Vec<f64> {
        let surface = self.flow.surface();
        let falls: Vec<f64> = effective
            .iter()
            .zip(&self.sections)
            .map(|(&angle, section)| (-section.polar.lift(angle).1).max(0.0))
            .collect();
        (0..effective.len())
            .map(|j| {
                let [before, after] = self.beside(j);
                let steepest = falls[before].max(falls[j]).max(falls[after]);
                let slenderness = surface.chord_m(j) / surface.span_m(j).length();
                let enough = std::f64::consts::PI / 32.0 * steepest * slenderness;
                VISCOSITY_MARGIN * self.sections[j].flow.slope_per_rad * enough
            })
            .collect()
    }

    fn finish(
        &self,
        inviscid: &Flow,
        effective_rad: Vec<f64>,
        residual: f64,
        density_kg_m3: f64,
    ) -> ViscousFlow {
        let surface = self.flow.surface();
        let onset = self.onset(inviscid.stream_m_s, &effective_rad);
        let flow = self
            .flow
            .solve_strips(vec![(inviscid.stream_m_s, onset)])
            .remove(0);
        let dynamic_pa = 0.5 * density_kg_m3 * inviscid.stream_m_s.length_squared();
        let half: f64 = effective_rad
            .iter()
            .enumerate()
            .map(|(j, &angle)| {
                let area = surface.chord_m(j) * surface.span_m(j).length();
                dynamic_pa * area * self.sections[j].polar.drag(angle)
            })
            .sum();
        ViscousFlow {
            flow,
            is_covered: effective_rad
                .iter()
                .zip(&self.sections)
                .all(|(&angle, section)| section.polar.covers(angle)),
            effective_rad,
            profile_drag_n: if surface.is_symmetric {
                2.0 * half
            } else {
                half
            },
            residual,
        }
    }

    /// Turn Δ of a strip's stream at an effective angle, and its slope.
    fn turned(&self, strip: usize, effective_rad: f64) -> (f64, f64) {
        let Section { polar, flow } = self.sections[strip];
        let (lift, slope) = polar.lift(effective_rad);
        let sine = (lift / flow.slope_per_rad).clamp(-0.95, 0.95);
        (
            sine.asin() + flow.zero_lift_rad - effective_rad,
            slope / (flow.slope_per_rad * (1.0 - sine * sine).sqrt()) - 1.0,
        )
    }

    /// Every strip's stream, turned about its span.
    fn onset(&self, stream: DVec3, effective: &[f64]) -> Vec<DVec3> {
        (0..effective.len())
            .map(|j| {
                let (sin, cos) = self.turned(j, effective[j]).0.sin_cos();
                let span = self.flow.surface().span_m(j).normalize_or_zero();
                let along_span = span * span.dot(stream);
                along_span + (stream - along_span) * cos + stream.cross(span) * sin
            })
            .collect()
    }

    fn circulation(&self, strip: usize, onset: &[DVec3]) -> f64 {
        let row = strip * onset.len();
        onset
            .iter()
            .enumerate()
            .map(|(k, velocity)| self.response(row + k).dot(*velocity))
            .sum()
    }

    fn response(&self, at: usize) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| self.response_m[axis][at]))
    }

    /// (1/Δt − J)⁻¹ r with J the derivative of what drives the effective angles.
    fn implicit_step(
        &self,
        stream: DVec3,
        (effective, viscosities): (&[f64], &[f64]),
        residual: &[f64],
        time_step: f64,
    ) -> Vec<f64> {
        let strips = effective.len();
        let speed = stream.length();
        let surface = self.flow.surface();
        // By how much a strip's stream changes with its angle.
        let change: Vec<DVec3> = (0..strips)
            .map(|k| {
                let (turned, slope) = self.turned(k, effective[k]);
                let (sin, cos) = turned.sin_cos();
                let span = surface.span_m(k).normalize_or_zero();
                let across = stream - span * span.dot(stream);
                slope * (stream.cross(span) * cos - across * sin)
            })
            .collect();
        let mut matrix = Mat::from_fn(strips, strips, |j, k| {
            let lift =
                2.0 * self.response(j * strips + k).dot(change[k]) / (speed * surface.chord_m(j));
            if j == k {
                1.0 / time_step + self.sections[j].polar.lift(effective[j]).1 - lift
            } else {
                -lift
            }
        });
        for (j, &viscosity) in viscosities.iter().enumerate() {
            matrix[(j, j)] += 2.0 * viscosity;
            for beside in self.beside(j) {
                matrix[(j, beside)] -= viscosity;
            }
        }
        let side = MatRef::from_column_major_slice(residual, strips, 1);
        let step = matrix.partial_piv_lu().solve(side);
        (0..strips).map(|j| step[(j, 0)]).collect()
    }
}

/// Largest magnitude; not a number where one is not.
fn largest_of(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest: f64, number| {
        // Of NaN and a number `max` takes the number.
        if largest.is_nan() || number.is_nan() {
            f64::NAN
        } else {
            largest.max(number.abs())
        }
    })
}

impl ViscousFlow {
    /// Lift, induced and profile drag [N].
    #[must_use]
    pub fn lift_and_drags_n(&self, surface: &PanelSurface, density_kg_m3: f64) -> [f64; 3] {
        let far = self.flow.trefftz_forces(surface, density_kg_m3);
        [far.lift_n, far.induced_drag_n, self.profile_drag_n]
    }
}

#[cfg(test)]
#[path = "decambering_tests.rs"]
mod tests;
