//! The vortex-lattice method: rings of vortices on the mean surface of a wing.
//!
//! Every panel carries a ring whose front edge is at its quarter chord and whose rear edge at the next panel's; the rings of the last row
//! reach far downstream. No flow passes through the points at three quarters of the panels' chords (Katz & Plotkin 2001, section 12.3).
//! Lift is the Kutta–Joukowski force of the strips' circulations, induced drag that of the Trefftz plane. It shares neither equations nor
//! surface with the panel method, which it checks; it is also the limit of vanishing thickness, and a quick estimate.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::AeroError;
use super::dense::Factors;
use super::surface::{Wing, mirrored};
use super::wake::{TrefftzForces, trefftz};

/// Length of the wake over the extent of the wing.
const WAKE_LENGTH: f64 = 1e3;

/// The factorised equations of a wing.
#[derive(Debug)]
pub struct VortexLattice {
    factors: Factors,
    normals: Vec<DVec3>,
    chordwise: usize,
    /// Points of the trailing edge [m].
    edge_m: Vec<DVec3>,
    is_symmetric: bool,
}

impl VortexLattice {
    /// The lattice on a wing with `chordwise` equal panels along the chord and a strip between neighbouring stations; the wake leaves
    /// along a direction.
    pub fn new(wing: &Wing, chordwise: usize, wake_direction: DVec3) -> Result<Self, AeroError> {
        wing.check()?;
        let Some(direction) = wake_direction.try_normalize() else {
            return Err(AeroError::Onset("the wake needs a direction".to_owned()));
        };
        if chordwise == 0 {
            return Err(AeroError::Surface(
                "a lattice needs at least one panel along the chord".to_owned(),
            ));
        }
        let places: Vec<f64> = (0..=chordwise)
            .map(|i| i as f64 / chordwise as f64)
            .collect();
        let sections: Vec<Vec<DVec3>> = wing
            .stations
            .iter()
            .map(|station| {
                station
                    .profile
                    .camber(&places)
                    .into_iter()
                    .zip(&places)
                    .map(|(height, &x)| station.place(DVec2::new(x, height), wing.chord_fraction))
                    .collect()
            })
            .collect();
        let strips = sections.len() - 1;
        let nodes = || sections.iter().flatten();
        let extent = nodes()
            .map(|node| node.distance(sections[0][0]))
            .fold(0.0, f64::max);
        let away = WAKE_LENGTH * extent * direction;
        // Ring corners: front edges at the quarter chords, the last row's rear edge far away.
        let corner = |section: &[DVec3], i: usize| {
            if i < chordwise {
                section[i].lerp(section[i + 1], 0.25)
            } else {
                section[chordwise] + away
            }
        };
        let mut rings = Vec::with_capacity(strips * chordwise);
        let mut points = Vec::with_capacity(strips * chordwise);
        let mut normals = Vec::with_capacity(strips * chordwise);
        for pair in sections.windows(2) {
            let [left, right] = [&pair[0], &pair[1]];
            for i in 0..chordwise {
                rings.push(Ring {
                    corners: [
                        corner(left, i),
                        corner(right, i),
                        corner(right, i + 1),
                        corner(left, i + 1),
                    ],
                });
                let at = |section: &[DVec3]| section[i].lerp(section[i + 1], 0.75);
                points.push(0.5 * (at(left) + at(right)));
                let area = (right[i + 1] - left[i]).cross(right[i] - left[i + 1]);
                normals.push(area.normalize_or_zero());
            }
        }
        let size = rings.len();
        let mut columns = vec![0.0; size * size];
        columns
            .par_chunks_mut(size)
            .zip(&rings)
            .for_each(|(column, ring)| {
                for ((entry, &point), normal) in column.iter_mut().zip(&points).zip(&normals) {
                    let mut velocity = ring.velocity(point);
                    if wing.is_symmetric {
                        velocity += mirrored(ring.velocity(mirrored(point)));
                    }
                    *entry = velocity.dot(*normal);
                }
            });
        Ok(Self {
            factors: Factors::new(columns, size)?,
            normals,
            chordwise,
            edge_m: sections.iter().map(|section| section[chordwise]).collect(),
            is_symmetric: wing.is_symmetric,
        })
    }

    /// Circulation of every strip under uniform streams [m²/s].
    #[must_use]
    pub fn circulations_m2_s(&self, streams_m_s: &[DVec3]) -> Vec<Vec<f64>> {
        let sides: Vec<f64> = streams_m_s
            .iter()
            .flat_map(|stream| self.normals.iter().map(move |normal| -stream.dot(*normal)))
            .collect();
        let rings = self.factors.solve(&sides);
        rings
            .chunks(self.normals.len())
            // The last ring of a strip has all of its circulation.
            .map(|rings| {
                rings
                    .chunks(self.chordwise)
                    .filter_map(|strip| strip.last().copied())
                    .collect()
            })
            .collect()
    }

    /// Forces from the far wake.
    #[must_use]
    pub fn trefftz_forces(
        &self,
        circulation_m2_s: &[f64],
        stream_m_s: DVec3,
        density_kg_m3: f64,
    ) -> TrefftzForces {
        trefftz(
            &self.edge_m,
            circulation_m2_s,
            stream_m_s,
            density_kg_m3,
            self.is_symmetric,
        )
    }
}

/// A ring of unit circulation, its front edge first from left to right.
struct Ring {
    corners: [DVec3; 4],
}

impl Ring {
    fn velocity(&self, point: DVec3) -> DVec3 {
        (0..4)
            .map(|k| segment(self.corners[k], self.corners[(k + 1) % 4], point))
            .sum()
    }
}

/// Velocity of a straight vortex of unit circulation from `a` to `b` (Biot & Savart); none on the segment itself.
fn segment(a: DVec3, b: DVec3, point: DVec3) -> DVec3 {
    let (from_a, from_b) = (point - a, point - b);
    let (la, lb) = (from_a.length(), from_b.length());
    let under = la * lb * (la * lb + from_a.dot(from_b));
    if under <= 1e-14 * (la * lb).powi(2) {
        return DVec3::ZERO;
    }
    from_a.cross(from_b) * ((la + lb) / (4.0 * std::f64::consts::PI * under))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::surface::Station;
    use super::*;
    use crate::geometry::profile::Profile;

    /// A long straight vortex turns the air with 1/(2πr), right-handed.
    #[test]
    fn a_long_vortex_is_a_plane_one() {
        let v = segment(-1e4 * DVec3::X, 1e4 * DVec3::X, 0.5 * DVec3::Y);
        let exact = DVec3::Z / std::f64::consts::PI;
        assert!((v - exact).length() < 1e-6, "{v}");
    }

    /// One panel along the chord of a very long flat wing: exactly 2π (Pistolesi's theorem), and both halves are the whole.
    #[test]
    fn a_long_flat_plate_has_its_slope() {
        let station = |y: f64| Station {
            position_m: DVec3::Y * y,
            chord_m: 1.0,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::new(Profile::naca("0012").unwrap()),
        };
        let half = Wing {
            stations: vec![station(0.0), station(1e4), station(2e4)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        let whole = Wing {
            stations: [-2e4, -1e4, 0.0, 1e4, 2e4].map(station).to_vec(),
            is_symmetric: false,
            ..half.clone()
        };
        let angle: f64 = 0.05;
        let stream = DVec3::new(angle.cos(), 0.0, angle.sin());
        let [half, whole] = [half, whole].map(|wing| {
            let lattice = VortexLattice::new(&wing, 1, DVec3::X).unwrap();
            lattice.circulations_m2_s(&[stream]).remove(0)
        });
        let exact = std::f64::consts::PI * angle.sin();
        assert!((half[0] / exact - 1.0).abs() < 1e-3, "{half:?}");
        assert!((half[0] / whole[2] - 1.0).abs() < 1e-9);
        assert!((half[1] / whole[0] - 1.0).abs() < 1e-9);
    }
}
