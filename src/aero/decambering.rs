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
//! there is, give its whole dependence; α_e of all strips then follows by Newton's method with damping. Mukherjee & Gopalarathnam (2006, J.
//! Aircraft 43) turn the mean line behind two hinges instead, and meet the polar's moment as well; this does not.
//!
//! Past the highest lift a section has two angles for a lift, and the equations more than one solution. The one that follows from smaller
//! angles is taken; where there is none, [`ViscousFlow::residual`] says so.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};
use glam::DVec3;

use super::AeroError;
use super::polar::{Polar, SectionFlow};
use super::potential_flow::{Flow, PotentialFlow};
use super::surface::PanelSurface;

/// Largest difference of lift coefficients that counts as agreement.
pub const AGREEMENT: f64 = 1e-6;

/// Newton steps per stream.
const STEPS: usize = 60;

/// No angle changes more per step [rad].
const STEP_LIMIT_RAD: f64 = 0.03;

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
    /// By how much each strip's stream is turned, negative where lift is lost [rad].
    pub turned_rad: Vec<f64>,
    /// Drag of the sections [N]; of a symmetric wing both halves.
    pub profile_drag_n: f64,
    /// Largest difference of a strip's lift coefficient from its polar's; beyond [`AGREEMENT`] there is no solution near.
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

    /// Flows under several streams [m/s], each started from the one before: give them in steps of a few degrees, smallest angle first.
    pub fn solve(
        &self,
        streams_m_s: &[DVec3],
        density_kg_m3: f64,
    ) -> Result<Vec<ViscousFlow>, AeroError> {
        // The streams are checked there.
        let inviscid = self.flow.solve(streams_m_s)?;
        let mut last: Option<Vec<f64>> = None;
        Ok(inviscid
            .iter()
            .map(|flow| {
                let viscous = self.solve_one(flow, last.take(), density_kg_m3);
                last = Some(viscous.effective_rad.clone());
                viscous
            })
            .collect())
    }

    fn solve_one(
        &self,
        inviscid: &Flow,
        start: Option<Vec<f64>>,
        density_kg_m3: f64,
    ) -> ViscousFlow {
        let surface = self.flow.surface();
        let strips = surface.spanwise;
        let speed = inviscid.stream_m_s.length();
        let chords: Vec<f64> = (0..strips).map(|j| surface.chord_m(j)).collect();
        let mut effective = start.unwrap_or_else(|| {
            inviscid
                .section_lift_coefficients(surface)
                .iter()
                .zip(&self.sections)
                .map(|(lift, s)| {
                    (lift / s.flow.slope_per_rad).clamp(-1.0, 1.0).asin() + s.flow.zero_lift_rad
                })
                .collect()
        });
        let residual_of = |effective: &[f64]| -> (Vec<f64>, f64) {
            let onset = self.onset(inviscid.stream_m_s, effective);
            let residual: Vec<f64> = (0..strips)
                .map(|j| {
                    let lift = 2.0 * self.circulation(j, &onset) / (speed * chords[j]);
                    lift - self.sections[j].polar.lift(effective[j]).0
                })
                .collect();
            let largest = residual.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            (residual, largest)
        };
        let (mut residual, mut largest) = residual_of(&effective);
        for _ in 0..STEPS {
            if largest < AGREEMENT {
                break;
            }
            let step = self.newton_step(inviscid.stream_m_s, &effective, &residual, &chords);
            let longest = step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if !longest.is_finite() {
                break;
            }
            let mut length = (STEP_LIMIT_RAD / longest).min(1.0);
            // Polars have kinks: a shorter step is tried a few times, then the last is taken to get across.
            for halving in 0..6 {
                let trial: Vec<f64> = effective
                    .iter()
                    .zip(&step)
                    .map(|(angle, step)| angle + length * step)
                    .collect();
                let (trial_residual, trial_largest) = residual_of(&trial);
                if trial_largest < largest || halving == 5 {
                    (effective, residual, largest) = (trial, trial_residual, trial_largest);
                    break;
                }
                length *= 0.5;
            }
        }
        self.finish(inviscid, effective, largest, density_kg_m3)
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
            turned_rad: (0..effective_rad.len())
                .map(|j| self.turned(j, effective_rad[j]).0)
                .collect(),
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

    /// −J⁻¹ r with J the derivative of the residual by the effective angles.
    fn newton_step(
        &self,
        stream: DVec3,
        effective: &[f64],
        residual: &[f64],
        chords: &[f64],
    ) -> Vec<f64> {
        let strips = effective.len();
        let speed = stream.length();
        // By how much a strip's stream changes with its angle.
        let change: Vec<DVec3> = (0..strips)
            .map(|k| {
                let (turned, slope) = self.turned(k, effective[k]);
                let (sin, cos) = turned.sin_cos();
                let span = self.flow.surface().span_m(k).normalize_or_zero();
                let across = stream - span * span.dot(stream);
                slope * (stream.cross(span) * cos - across * sin)
            })
            .collect();
        let jacobian = Mat::from_fn(strips, strips, |j, k| {
            let lift = 2.0 * self.response(j * strips + k).dot(change[k]) / (speed * chords[j]);
            if j == k {
                lift - self.sections[j].polar.lift(effective[j]).1
            } else {
                lift
            }
        });
        let side = MatRef::from_column_major_slice(residual, strips, 1);
        let step = jacobian.partial_piv_lu().solve(side);
        (0..strips).map(|j| -step[(j, 0)]).collect()
    }
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
mod tests {
    use std::sync::Arc;

    use super::super::polar::PolarPoint;
    use super::super::potential_flow::MEMORY_LIMIT;
    use super::super::surface::{Station, Wing};
    use super::*;
    use crate::geometry::profile::Profile;

    fn stream(degrees: f64) -> DVec3 {
        let angle = degrees.to_radians();
        20.0 * DVec3::new(angle.cos(), 0.0, angle.sin())
    }

    fn rectangle(half_span: f64) -> (Wing, Arc<Profile>) {
        let profile = Arc::new(Profile::naca("2412").unwrap());
        let station = |y: f64| Station {
            position_m: DVec3::Y * y,
            chord_m: 1.0,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::clone(&profile),
        };
        let wing = Wing {
            stations: vec![station(0.0), station(half_span)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        (wing, Arc::clone(&profile))
    }

    fn polar_of(lift: impl Fn(f64) -> f64) -> Polar {
        let points = (-100..=300).map(|tenths| {
            let angle_rad = (0.1 * f64::from(tenths)).to_radians();
            PolarPoint {
                angle_rad,
                lift: lift(angle_rad),
                drag: 0.01,
            }
        });
        Polar::new(points.collect()).unwrap()
    }

    /// A polar that is potential flow's own changes nothing; one with less lift everywhere takes that share from a wing so long that its
    /// sections are alone; and every strip has the lift of its polar.
    #[test]
    fn sections_have_the_lift_of_their_polars() {
        for (half_span, share) in [(4.0, 1.0), (5e3, 0.8), (4.0, 0.8)] {
            let (wing, profile) = rectangle(half_span);
            let surface = wing.divided(4, 0.8).unwrap().panels(60).unwrap();
            let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
            let section = SectionFlow::of(&profile).unwrap();
            let polar = polar_of(|angle| {
                share * section.slope_per_rad * (angle - section.zero_lift_rad).sin()
            });
            let sections = vec![
                Section {
                    polar: &polar,
                    flow: section
                };
                4
            ];
            let viscous = Decambering::new(&flow, sections).unwrap();
            let results = viscous.solve(&[stream(2.0), stream(6.0)], 1.2).unwrap();
            for (result, angle) in results.iter().zip([2.0, 6.0]) {
                assert!(
                    result.residual < AGREEMENT && result.is_covered,
                    "{result:?}"
                );
                let lifts = result.flow.section_lift_coefficients(&surface);
                let inviscid = flow.solve(&[stream(angle)]).unwrap().remove(0);
                let before = inviscid.section_lift_coefficients(&surface);
                for ((lift, before), angle) in lifts.iter().zip(before).zip(&result.effective_rad) {
                    assert!((lift - polar.lift(*angle).0).abs() < 1e-5);
                    let ratio = lift / before;
                    if half_span > 1e3 || share == 1.0 {
                        assert!((ratio - share).abs() < 2e-3, "{ratio}");
                    } else {
                        // Less lift, less downwash: more than its share is kept.
                        assert!(ratio > share && ratio < 1.0, "{ratio}");
                    }
                }
                // 0.01 × area.
                let area = 2.0 * half_span;
                assert!((result.profile_drag_n / (0.01 * 240.0 * area) - 1.0).abs() < 1e-9);
            }
        }
    }

    /// Sections that lose lift beyond ten degrees make the wing stall.
    #[test]
    fn a_wing_stalls_with_its_sections() {
        let (wing, profile) = rectangle(4.0);
        let surface = wing.divided(6, 0.8).unwrap().panels(12).unwrap();
        let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
        let section = SectionFlow::of(&profile).unwrap();
        let polar = polar_of(|angle| {
            let degrees = angle.to_degrees();
            if degrees < 10.0 {
                0.1 * degrees + 0.2
            } else {
                1.2 - 0.005 * (degrees - 10.0).powi(2).min(40.0)
            }
        });
        let sections = vec![
            Section {
                polar: &polar,
                flow: section
            };
            6
        ];
        let viscous = Decambering::new(&flow, sections).unwrap();
        let streams: Vec<DVec3> = (0..=26).map(|a| stream(f64::from(a))).collect();
        let lifts: Vec<f64> = viscous
            .solve(&streams, 1.2)
            .unwrap()
            .iter()
            .map(|result| result.lift_and_drags_n(&surface, 1.2)[0] / (240.0 * 8.0))
            .collect();
        let highest = lifts.iter().copied().fold(0.0, f64::max);
        assert!((1.0..1.2).contains(&highest), "{lifts:?}");
        assert!(lifts[24] < highest - 0.02, "{lifts:?}");
    }

    #[test]
    fn sections_are_counted() {
        let (wing, _) = rectangle(4.0);
        let surface = wing.divided(3, 0.8).unwrap().panels(6).unwrap();
        let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
        assert!(matches!(
            Decambering::new(&flow, Vec::new()),
            Err(AeroError::Polar(_))
        ));
    }
}
