//! Steady potential flow around closed surfaces with wakes.
//!
//! Of the perturbation potential φ outside, with φ = 0 inside, Green's identity at a point just inside the surface says
//!
//! ```text
//! Σ_j D_ij φ_j + Σ_w W_iw Γ_w = Σ_j S_ij (∂φ/∂n)_j,    (∂φ/∂n)_j = −V·n_j
//! Γ_w = φ_upper − φ_lower + V·(x_upper − x_lower)
//! ```
//!
//! (Morino & Kuo, AIAA J. 12, 1974; Katz & Plotkin 2001, sections 9.4 and 12.2.) The second line is the Kutta condition: the wake is as strong
//! as the jump of the potential at the trailing edge. Departure: the jump is that of the whole potential, the onset flow's share between the
//! centres of the two panels included, as in propeller panel methods; both sides leave the edge at the same speed, so their centres'
//! distances from it cancel.
//!
//! Doublets are linear along the chord: φ over a panel is φ_j + ξ φ′_j, its slope φ′_j from the centres of the neighbours (`chordwise`). Unknowns stay one per
//! panel, and errors of lift at 20 panels per side fall from 2–4 % to 0.3 % (constant doublets are of first order at noses and trailing edges).
//!
//! The matrix depends on the surface and on the wake's direction alone: any number of onset flows, which may differ from strip to strip, are
//! solved from one factorisation.

use glam::DVec3;
use rayon::prelude::*;

use super::AeroError;
use super::chordwise;
use super::dense::Factors;
use super::forces::{self, Forces};
use super::surface::{PanelSurface, mirrored};
use super::velocity;
use super::wake::{TrefftzForces, Wake, trefftz};

/// How far inside the surface the equations hold, over a panel's width.
const INSIDE: f64 = 1e-6;

/// Centres from which the slope of the potential along a panel is taken.
const SLOPE_POINTS: usize = 3;

/// Memory allowed without a setting of its own [bytes].
pub const MEMORY_LIMIT: u64 = 4 << 30;

/// The factorised equations of a surface.
#[derive(Debug)]
pub struct PotentialFlow<'a> {
    surface: &'a PanelSurface,
    factors: Factors,
    /// Σ_j S_ij n_j over the panels of a group [m], group by group: a strip's panels, or a cap's.
    group_sources_m: Vec<DVec3>,
    /// W_iw, strip by strip.
    wake: Vec<f64>,
}

/// A flow around a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    /// Velocity far ahead [m/s].
    pub stream_m_s: DVec3,
    /// Velocity ahead as each strip feels it [m/s].
    pub onset_m_s: Vec<DVec3>,
    /// Perturbation potential outside, per panel [m²/s].
    pub potential_m2_s: Vec<f64>,
    /// Circulation of each strip, positive where it lifts [m²/s]; empty without trailing edge.
    pub circulation_m2_s: Vec<f64>,
}

/// Memory that a surface of so many panels and strips needs [bytes].
#[must_use]
pub const fn memory_bytes(panels: usize, strips: usize) -> u64 {
    let (n, strips) = (panels as u64, strips as u64);
    8 * n * n + 32 * n * (strips + 2)
}

impl<'a> PotentialFlow<'a> {
    /// Sets up and factorises the equations of a surface whose wake leaves along a direction; refuses what needs more than `memory_limit`
    /// bytes.
    pub fn new(
        surface: &'a PanelSurface,
        wake_direction: DVec3,
        memory_limit: u64,
    ) -> Result<Self, AeroError> {
        let size = surface.panels.len();
        let needed = memory_bytes(size, surface.spanwise);
        if needed > memory_limit {
            return Err(AeroError::TooLarge {
                unknowns: size,
                needed_mib: needed >> 20,
                limit_mib: memory_limit >> 20,
            });
        }
        let Some(direction) = wake_direction.try_normalize() else {
            return Err(AeroError::Onset("the wake needs a direction".to_owned()));
        };
        check_symmetry(surface, direction)?;
        let points: Vec<DVec3> = surface
            .panels
            .iter()
            .map(|p| p.centre_m - INSIDE * p.area_m2.length() / p.diameter_m * p.normal)
            .collect();
        let wake_strips = Wake::new(surface, direction);
        let groups = surface.spanwise + surface.caps.len();
        let mut columns = vec![0.0; size * size];
        let mut group_sources_m = vec![DVec3::ZERO; groups * size];
        let mut wake = vec![0.0; wake_strips.len() * size];
        let (strips, caps) = columns.split_at_mut(surface.spanwise * surface.chordwise * size);
        let strips = strips.par_chunks_mut(surface.chordwise * size);
        // An open surface has no caps, and a chunk cannot be empty.
        let caps = caps.par_chunks_mut(surface.chordwise / 2 * size);
        strips
            .chain(caps)
            .zip(group_sources_m.par_chunks_mut(size))
            .enumerate()
            .for_each(|(group, (columns, sources))| {
                let first = if group < surface.spanwise {
                    group * surface.chordwise
                } else {
                    surface.caps[group - surface.spanwise].first
                };
                // Strengths of a strip's panels grow along the chord as those of their neighbours do; a cap's panels are constant.
                let slopes = if group < surface.spanwise {
                    chordwise::derivatives(surface, group, SLOPE_POINTS)
                } else {
                    Vec::new()
                };
                for k in 0..columns.len() / size {
                    let panel = &surface.panels[first + k];
                    for (i, (sum, &point)) in sources.iter_mut().zip(&points).enumerate() {
                        let mut here = panel.influence(point);
                        if surface.is_symmetric {
                            let image = panel.influence(mirrored(point));
                            here.doublet += image.doublet;
                            here.doublet_slope_m += image.doublet_slope_m;
                            here.source_m += image.source_m;
                        }
                        columns[k * size + i] += here.doublet;
                        for &(neighbour, weight) in slopes.get(k).into_iter().flatten() {
                            columns[neighbour * size + i] += weight * here.doublet_slope_m;
                        }
                        *sum += here.source_m * panel.normal;
                    }
                }
            });
        wake.par_chunks_mut(size)
            .zip(columns.par_chunks_mut(surface.chordwise * size))
            .enumerate()
            .for_each(|(strip, (wake, columns))| {
                let (lower, rest) = columns.split_at_mut(size);
                let upper = &mut rest[(surface.chordwise - 2) * size..];
                for (i, &point) in points.iter().enumerate() {
                    wake[i] = wake_strips.influence(strip, point);
                    upper[i] += wake[i];
                    lower[i] -= wake[i];
                }
            });
        Ok(Self {
            surface,
            factors: Factors::new(columns, size)?,
            group_sources_m,
            wake,
        })
    }

    /// The surface.
    #[must_use]
    pub const fn surface(&self) -> &'a PanelSurface {
        self.surface
    }

    /// Flows under uniform streams.
    pub fn solve(&self, streams_m_s: &[DVec3]) -> Result<Vec<Flow>, AeroError> {
        for &stream in streams_m_s {
            if stream == DVec3::ZERO || !stream.is_finite() {
                return Err(AeroError::Onset(
                    "the stream needs a finite velocity other than zero".to_owned(),
                ));
            }
            check_symmetry(self.surface, stream)?;
        }
        let onsets = streams_m_s
            .iter()
            .map(|&stream| (stream, vec![stream; self.surface.spanwise]))
            .collect();
        Ok(self.solve_strips(onsets))
    }

    /// Flows under streams that feel different to every strip: each a velocity far ahead and one per strip [m/s].
    #[must_use]
    pub fn solve_strips(&self, onsets: Vec<(DVec3, Vec<DVec3>)>) -> Vec<Flow> {
        let size = self.surface.panels.len();
        let sides: Vec<f64> = onsets
            .par_iter()
            .flat_map_iter(|(_, onset)| self.side(onset))
            .collect();
        let potentials = self.factors.solve(&sides);
        onsets
            .into_iter()
            .zip(potentials.chunks(size))
            .map(|((stream_m_s, onset_m_s), potential)| Flow {
                circulation_m2_s: self.circulation(potential, &onset_m_s),
                stream_m_s,
                onset_m_s,
                potential_m2_s: potential.to_vec(),
            })
            .collect()
    }

    /// The right-hand side.
    fn side(&self, onset: &[DVec3]) -> Vec<f64> {
        let size = self.surface.panels.len();
        let mut side = vec![0.0; size];
        let caps = self.surface.caps.iter().map(|cap| onset[cap.strip]);
        for (sources, velocity) in self
            .group_sources_m
            .chunks(size)
            .zip(onset.iter().copied().chain(caps))
        {
            for (entry, source) in side.iter_mut().zip(sources) {
                *entry -= source.dot(velocity);
            }
        }
        for (strip, wake) in self.wake.chunks(size).enumerate() {
            let jump = onset[strip].dot(self.edge_step(strip));
            for (entry, wake) in side.iter_mut().zip(wake) {
                *entry -= wake * jump;
            }
        }
        side
    }

    /// From the centre of a strip's last lower panel to that of its last upper one.
    fn edge_step(&self, strip: usize) -> DVec3 {
        let first = strip * self.surface.chordwise;
        self.surface.panels[first + self.surface.chordwise - 1].centre_m
            - self.surface.panels[first].centre_m
    }

    fn circulation(&self, potential: &[f64], onset: &[DVec3]) -> Vec<f64> {
        if !self.surface.has_trailing_edge {
            return Vec::new();
        }
        (0..self.surface.spanwise)
            .map(|strip| {
                let first = strip * self.surface.chordwise;
                potential[first + self.surface.chordwise - 1] - potential[first]
                    + onset[strip].dot(self.edge_step(strip))
            })
            .collect()
    }
}

/// A symmetric surface needs a flow along its plane.
fn check_symmetry(surface: &PanelSurface, direction: DVec3) -> Result<(), AeroError> {
    if surface.is_symmetric && direction.y.abs() > 1e-12 * direction.length() {
        return Err(AeroError::Onset(
            "a symmetric half needs a stream without a y component; give the whole wing for sideslip"
                .to_owned(),
        ));
    }
    Ok(())
}

impl Flow {
    /// Velocity along the surface at the panels' centres [m/s].
    #[must_use]
    pub fn velocities_m_s(&self, surface: &PanelSurface) -> Vec<DVec3> {
        velocity::on_surface(surface, &self.potential_m2_s, &self.onset_m_s)
    }

    /// Pressure coefficients at the panels' centres, 1 − u²/V².
    #[must_use]
    pub fn pressure_coefficients(&self, surface: &PanelSurface) -> Vec<f64> {
        let square = self.stream_m_s.length_squared();
        self.velocities_m_s(surface)
            .iter()
            .map(|u| 1.0 - u.length_squared() / square)
            .collect()
    }

    /// Force and moment of the surface pressure.
    #[must_use]
    pub fn pressure_forces(
        &self,
        surface: &PanelSurface,
        density_kg_m3: f64,
        about_m: DVec3,
    ) -> Forces {
        let dynamic_pa = 0.5 * density_kg_m3 * self.stream_m_s.length_squared();
        let pressures = self.pressure_coefficients(surface);
        forces::of_pressure(surface, &pressures, dynamic_pa, about_m)
    }

    /// Forces from the far wake.
    #[must_use]
    pub fn trefftz_forces(&self, surface: &PanelSurface, density_kg_m3: f64) -> TrefftzForces {
        let edge: Vec<DVec3> = (0..=surface.spanwise)
            .map(|section| surface.node_m(0, section))
            .collect();
        trefftz(
            &edge,
            &self.circulation_m2_s,
            self.stream_m_s,
            density_kg_m3,
            surface.is_symmetric,
        )
    }

    /// Lift coefficient of every strip on its own chord, 2 Γ/(V c).
    #[must_use]
    pub fn section_lift_coefficients(&self, surface: &PanelSurface) -> Vec<f64> {
        let speed = self.stream_m_s.length();
        self.circulation_m2_s
            .iter()
            .enumerate()
            .map(|(strip, circulation)| 2.0 * circulation / (speed * surface.chord_m(strip)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::surface::{Station, Wing, ellipsoid};
    use super::*;
    use crate::geometry::profile::Profile;

    fn wing(is_symmetric: bool) -> Wing {
        let station = |y: f64| Station {
            position_m: DVec3::new(0.1 * y.abs(), y, -0.05 * y * y),
            chord_m: 1.0 - 0.1 * y.abs(),
            twist_rad: 0.02 * y.abs(),
            roll_rad: -0.1 * y,
            profile: Arc::new(Profile::naca("2412").unwrap()),
        };
        let half = [0.0, 0.6, 1.2, 1.7, 2.0];
        Wing {
            stations: if is_symmetric {
                half.map(station).to_vec()
            } else {
                let left = half.iter().skip(1).rev().map(|y| -y);
                left.chain(half).map(station).collect()
            },
            chord_fraction: 0.25,
            is_symmetric,
        }
    }

    fn stream(angle: f64) -> DVec3 {
        10.0 * DVec3::new(angle.cos(), 0.0, angle.sin())
    }

    /// A sphere: φ = −½ V·x R³/r³, speed 1.5 V at the equator.
    #[test]
    fn the_sphere_has_its_potential() {
        let body = ellipsoid(DVec3::ONE, 24, 24).unwrap();
        let flow = PotentialFlow::new(&body, DVec3::X, MEMORY_LIMIT).unwrap();
        let direction = DVec3::new(0.8, 0.36, 0.48);
        let flow = flow.solve(&[direction]).unwrap().remove(0);
        assert!(flow.circulation_m2_s.is_empty());
        for (panel, potential) in body.panels.iter().zip(&flow.potential_m2_s) {
            let exact = 0.5 * direction.dot(panel.centre_m);
            assert!((potential - exact).abs() < 0.02, "{potential} {exact}");
        }
        let drag = flow.pressure_forces(&body, 1.0, DVec3::ZERO);
        assert!(drag.force_n.length() < 1e-3, "d'Alembert: {drag:?}");
    }

    /// Half of a symmetric wing is the whole one; both sides of a factorisation serve several streams.
    #[test]
    fn a_symmetric_half_is_the_whole() {
        let [half, whole] = [true, false].map(|s| wing(s).panels(8).unwrap());
        let streams = [stream(0.0), stream(0.1)];
        let of = |surface: &PanelSurface| {
            PotentialFlow::new(surface, DVec3::X, MEMORY_LIMIT)
                .unwrap()
                .solve(&streams)
                .unwrap()
        };
        let (halves, wholes) = (of(&half), of(&whole));
        for (a, b) in halves.iter().zip(&wholes) {
            for strip in 0..4 {
                let [x, y, z] = [
                    a.circulation_m2_s[strip],
                    b.circulation_m2_s[4 + strip],
                    b.circulation_m2_s[3 - strip],
                ];
                // The wakes differ in length.
                assert!((x - y).abs() < 1e-6 && (x - z).abs() < 1e-6, "{x} {y} {z}");
            }
            let [p, q] = [
                a.pressure_forces(&half, 1.2, DVec3::ZERO),
                b.pressure_forces(&whole, 1.2, DVec3::ZERO),
            ];
            assert!((p.force_n - q.force_n).length() < 1e-6 * p.force_n.length());
            assert!((p.moment_n_m - q.moment_n_m).length() < 1e-6 * p.moment_n_m.length());
            let [s, t] = [a.trefftz_forces(&half, 1.2), b.trefftz_forces(&whole, 1.2)];
            assert!((s.induced_drag_n - t.induced_drag_n).abs() < 1e-6 * t.induced_drag_n.abs());
        }
        assert!(halves[1].circulation_m2_s[0] > halves[0].circulation_m2_s[0]);
    }

    /// Onset flows per strip add up: turning every strip is turning the stream.
    #[test]
    fn strips_add_up() {
        let surface = wing(true).panels(6).unwrap();
        let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
        let whole = flow.solve(&[stream(0.2)]).unwrap().remove(0);
        let parts: Vec<Flow> = flow.solve_strips(
            (0..4)
                .map(|strip| {
                    let mut onset = vec![DVec3::ZERO; 4];
                    onset[strip] = stream(0.2);
                    (stream(0.2), onset)
                })
                .collect(),
        );
        for strip in 0..4 {
            let sum: f64 = parts.iter().map(|p| p.circulation_m2_s[strip]).sum();
            assert!((sum - whole.circulation_m2_s[strip]).abs() < 1e-10);
        }
    }

    #[test]
    fn faults_are_named() {
        let surface = wing(true).panels(6).unwrap();
        let refused = PotentialFlow::new(&surface, DVec3::X, 1 << 10).unwrap_err();
        assert!(
            matches!(refused, AeroError::TooLarge { unknowns: 54, .. }),
            "{refused}"
        );
        let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
        for stream in [DVec3::ZERO, DVec3::Y, DVec3::NAN] {
            assert!(matches!(flow.solve(&[stream]), Err(AeroError::Onset(_))));
        }
        let still = PotentialFlow::new(&surface, DVec3::ZERO, MEMORY_LIMIT);
        assert!(matches!(still, Err(AeroError::Onset(_))));
    }
}
