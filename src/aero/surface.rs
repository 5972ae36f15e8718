//! Surfaces of panels: wings from span-wise stations, and closed bodies.
//!
//! Axes: x downstream, y along the span, z up. A panel surface is a grid of nodes, chord-wise from the trailing edge along the lower side
//! around the nose and along the upper side to the trailing edge, and span-wise towards positive y. Of a symmetric scene only the half y ≥ 0
//! is kept, with its first section in the plane of symmetry. Open tips are closed by a flat cap.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::AeroError;
use super::influence::Panel;
use crate::geometry::profile::Profile;

/// Points per side that stand for a blend of two profiles.
const BLEND_POINTS_PER_SIDE: usize = 120;

/// A section narrower than this share of the surface's extent is a point.
const POINT_SIZE: f64 = 1e-9;

/// A section of a wing.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Point of the chord at the wing's chord fraction [m].
    pub position_m: DVec3,
    /// Chord [m]; may be zero at a tip.
    pub chord_m: f64,
    /// Angle of the chord to the x axis, nose up [rad].
    pub twist_rad: f64,
    /// Angle of the section's span-wise direction (0, cos, sin) to the y axis [rad]: the local dihedral.
    pub roll_rad: f64,
    /// Profile.
    pub profile: Arc<Profile>,
}

/// A wing by its sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Wing {
    /// Sections in order of the span: from the plane of symmetry to the tip at positive y, or from tip to tip.
    pub stations: Vec<Station>,
    /// Where along the chord the stations' positions are, 0 at the nose; 0.25 is usual.
    pub chord_fraction: f64,
    /// Whether the stations are half of a wing that is symmetric about y = 0.
    pub is_symmetric: bool,
}

impl Wing {
    /// Sets every roll angle from the positions: perpendicular to the span's polygon, half-way at its corners.
    pub fn roll_along_span(&mut self) {
        let across = |a: &Station, b: &Station| {
            let step = b.position_m - a.position_m;
            DVec2::new(step.y, step.z).normalize_or_zero()
        };
        let count = self.stations.len();
        let directions: Vec<DVec2> = (0..count)
            .map(|k| {
                let before = (k > 0).then(|| across(&self.stations[k - 1], &self.stations[k]));
                let after =
                    (k + 1 < count).then(|| across(&self.stations[k], &self.stations[k + 1]));
                match (before, after) {
                    (None, Some(_)) if self.is_symmetric => DVec2::X,
                    (a, b) => a.unwrap_or_default() + b.unwrap_or_default(),
                }
            })
            .collect();
        for (station, direction) in self.stations.iter_mut().zip(directions) {
            station.roll_rad = direction.y.atan2(direction.x);
        }
    }

    /// The same wing cut into `strips` strips; everything varies linearly between stations. `clustering` from 0 (equal strips) to 1
    /// (cosine spacing) narrows them towards tips.
    pub fn divided(&self, strips: usize, clustering: f64) -> Result<Self, AeroError> {
        self.check()?;
        if strips == 0 {
            return Err(AeroError::Surface(
                "a wing needs at least one strip".to_owned(),
            ));
        }
        let lengths = self.lengths_m();
        let stations = self
            .strip_ends_m(strips, clustering)
            .into_iter()
            .map(|at| {
                let k = lengths
                    .partition_point(|&l| l <= at)
                    .saturating_sub(1)
                    .min(self.stations.len() - 2);
                let t = ((at - lengths[k]) / (lengths[k + 1] - lengths[k])).clamp(0.0, 1.0);
                between(&self.stations[k], &self.stations[k + 1], t)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            stations,
            ..self.clone()
        })
    }

    /// Lengths along the span's polygon up to every station [m].
    #[must_use]
    pub fn lengths_m(&self) -> Vec<f64> {
        let mut passed = 0.0;
        let steps = self.stations.windows(2).map(|pair| {
            let step = pair[1].position_m - pair[0].position_m;
            passed += DVec2::new(step.y, step.z).length();
            passed
        });
        std::iter::once(0.0).chain(steps).collect()
    }

    /// Lengths along the span's polygon at which the strips of [`Self::divided`] end [m], `[strips + 1]`. Between them is more than the distance of
    /// their ends where the polygon has a corner within a strip.
    #[must_use]
    pub fn strip_ends_m(&self, strips: usize, clustering: f64) -> Vec<f64> {
        let whole = self.lengths_m().last().copied().unwrap_or(0.0);
        let share = |k: usize| {
            let u = k as f64 / strips as f64;
            let cosine = if self.is_symmetric {
                (0.5 * std::f64::consts::PI * u).sin()
            } else {
                0.5 * (1.0 - (std::f64::consts::PI * u).cos())
            };
            clustering * cosine + (1.0 - clustering) * u
        };
        (0..=strips).map(|k| whole * share(k)).collect()
    }

    /// Area of the chords, the wing laid flat [m²]; of a symmetric one both halves.
    #[must_use]
    pub fn flat_area_m2(&self) -> f64 {
        let half: f64 = self
            .stations
            .windows(2)
            .map(|pair| {
                let step = pair[1].position_m - pair[0].position_m;
                0.5 * (pair[0].chord_m + pair[1].chord_m) * DVec2::new(step.y, step.z).length()
            })
            .sum();
        if self.is_symmetric { 2.0 * half } else { half }
    }

    /// Extent along y [m]; of a symmetric wing both halves.
    #[must_use]
    pub fn projected_span_m(&self) -> f64 {
        let y = |station: Option<&Station>| station.map_or(0.0, |s| s.position_m.y);
        let half = y(self.stations.last()) - y(self.stations.first());
        if self.is_symmetric { 2.0 * half } else { half }
    }

    /// The surface with `per_side` panels along each side of a section and a strip between neighbouring stations.
    pub fn panels(&self, per_side: usize) -> Result<PanelSurface, AeroError> {
        self.check()?;
        if per_side < 2 {
            return Err(AeroError::Surface(
                "a section needs at least two panels per side".to_owned(),
            ));
        }
        let mut last: Option<(&Arc<Profile>, Vec<DVec2>)> = None;
        let mut nodes_m = Vec::with_capacity(self.stations.len() * (2 * per_side + 1));
        for station in &self.stations {
            let points = match last.take() {
                Some((profile, points)) if Arc::ptr_eq(profile, &station.profile) => points,
                _ => station.profile.resampled(per_side),
            };
            nodes_m.extend(
                points
                    .iter()
                    .map(|p| station.place(*p, self.chord_fraction)),
            );
            last = Some((&station.profile, points));
        }
        PanelSurface::new(nodes_m, 2 * per_side, true, self.is_symmetric)
    }

    /// Whether the stations make sense.
    pub fn check(&self) -> Result<(), AeroError> {
        let wrong = |what: String| Err(AeroError::Surface(what));
        if self.stations.len() < 2 {
            return wrong("a wing needs at least two stations".to_owned());
        }
        for (k, s) in self.stations.iter().enumerate() {
            let numbers = [s.chord_m, s.twist_rad, s.roll_rad];
            if !s.position_m.is_finite() || numbers.iter().any(|n| !n.is_finite()) {
                return wrong(format!("station {k} of the wing is not finite"));
            }
            let is_tip = k + 1 == self.stations.len() || (k == 0 && !self.is_symmetric);
            if s.chord_m < 0.0 || (s.chord_m == 0.0 && !is_tip) {
                return wrong(format!("station {k} of the wing needs a positive chord"));
            }
        }
        for (k, pair) in self.stations.windows(2).enumerate() {
            let step = pair[1].position_m - pair[0].position_m;
            if DVec2::new(step.y, step.z).length() <= 0.0 {
                return wrong(format!("stations {k} and {} of the wing coincide", k + 1));
            }
        }
        if self.is_symmetric && self.stations[0].position_m.y != 0.0 {
            return wrong("the first station of a symmetric wing has to be at y = 0".to_owned());
        }
        Ok(())
    }
}

impl Station {
    /// Point of the section given in chords from the nose [m].
    #[must_use]
    pub fn place(&self, point: DVec2, chord_fraction: f64) -> DVec3 {
        let along = (point.x - chord_fraction) * self.chord_m;
        let up = point.y * self.chord_m;
        let (sin, cos) = self.twist_rad.sin_cos();
        let normal = DVec3::new(0.0, -self.roll_rad.sin(), self.roll_rad.cos());
        self.position_m + DVec3::X * (along * cos + up * sin) + normal * (up * cos - along * sin)
    }
}

/// The section between two.
fn between(a: &Station, b: &Station, t: f64) -> Result<Station, AeroError> {
    let mix = |x: f64, y: f64| x + t * (y - x);
    let profile = if t <= 0.0 || Arc::ptr_eq(&a.profile, &b.profile) {
        Arc::clone(&a.profile)
    } else if t >= 1.0 {
        Arc::clone(&b.profile)
    } else {
        let [p, q] = [a, b].map(|s| s.profile.resampled(BLEND_POINTS_PER_SIDE));
        let points = p.iter().zip(&q).map(|(p, q)| p.lerp(*q, t)).collect();
        Arc::new(Profile::new(points)?)
    };
    Ok(Station {
        position_m: a.position_m.lerp(b.position_m, t),
        chord_m: mix(a.chord_m, b.chord_m),
        twist_rad: mix(a.twist_rad, b.twist_rad),
        roll_rad: mix(a.roll_rad, b.roll_rad),
        profile,
    })
}

/// What closes an open end of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cap {
    /// The strip that it closes.
    pub strip: usize,
    /// Index of its first panel; one panel for each pair of panels of the strip that face each other, from the trailing edge on.
    pub first: usize,
}

/// A surface of panels.
#[derive(Debug, Clone, PartialEq)]
pub struct PanelSurface {
    /// Panels around a section.
    pub chordwise: usize,
    /// Strips along the span.
    pub spanwise: usize,
    /// Nodes [m], chord-wise first; `chordwise + 1` per section.
    pub nodes_m: Vec<DVec3>,
    /// Panels, chord-wise first, strip by strip, then those of the caps.
    pub panels: Vec<Panel>,
    /// Caps.
    pub caps: Vec<Cap>,
    /// Whether the sections end in a trailing edge that sheds a wake; else they are closed curves.
    pub has_trailing_edge: bool,
    /// Whether this is half of a surface symmetric about y = 0.
    pub is_symmetric: bool,
}

impl PanelSurface {
    /// A surface through nodes given section by section, `chordwise + 1` in each [m], `chordwise` even. The first and the last node of a
    /// section have to be the same, but for rounding.
    pub fn new(
        mut nodes_m: Vec<DVec3>,
        chordwise: usize,
        has_trailing_edge: bool,
        is_symmetric: bool,
    ) -> Result<Self, AeroError> {
        let wrong = |what: String| Err(AeroError::Surface(what));
        if chordwise < 4 || !chordwise.is_multiple_of(2) {
            return wrong(
                "a surface needs an even number of panels around it, at least 4".to_owned(),
            );
        }
        let row = chordwise + 1;
        if nodes_m.len() < 2 * row || !nodes_m.len().is_multiple_of(row) {
            return wrong("a surface needs at least two sections of equally many nodes".to_owned());
        }
        if nodes_m.iter().any(|node| !node.is_finite()) {
            return wrong("a node of the surface is not finite".to_owned());
        }
        let sections = nodes_m.len() / row;
        let (low, high) = nodes_m
            .iter()
            .fold((nodes_m[0], nodes_m[0]), |(low, high), node| {
                (low.min(*node), high.max(*node))
            });
        let extent = (high - low).length();
        for (k, section) in nodes_m.chunks_mut(row).enumerate() {
            if section[0].distance(section[chordwise]) > 1e-6 * extent {
                return wrong(format!("section {k} of the surface is not closed"));
            }
            section[chordwise] = section[0];
            if k == 0 && is_symmetric {
                for node in section {
                    if node.y.abs() > 1e-6 * extent {
                        return wrong(
                            "the first section of a symmetric surface has to lie at y = 0"
                                .to_owned(),
                        );
                    }
                    node.y = 0.0;
                }
            }
        }
        let node = |i: usize, j: usize| nodes_m[j * row + i];
        let mut panels = Vec::with_capacity(chordwise * sections);
        for j in 0..sections - 1 {
            for i in 0..chordwise {
                panels.push(Panel::new([
                    node(i, j),
                    node(i + 1, j),
                    node(i + 1, j + 1),
                    node(i, j + 1),
                ]));
            }
        }
        if let Some(k) = panels
            .iter()
            .position(|p| p.normal == DVec3::ZERO || p.diameter_m < POINT_SIZE * extent)
        {
            return wrong(format!(
                "panel {} of strip {} has no area: two sections or two points of a section coincide",
                k % chordwise,
                k / chordwise
            ));
        }
        let mut caps = Vec::new();
        for (section, strip) in [(0, 0), (sections - 1, sections - 2)] {
            let is_point =
                (1..row).all(|i| node(i, section).distance(node(0, section)) < POINT_SIZE * extent);
            if is_point || (section == 0 && is_symmetric) {
                continue;
            }
            caps.push(Cap {
                strip,
                first: panels.len(),
            });
            for i in 0..chordwise / 2 {
                let opposite = chordwise - i;
                let mut corners = [
                    node(i + 1, section),
                    node(opposite - 1, section),
                    node(opposite, section),
                    node(i, section),
                ];
                if section == 0 {
                    corners.reverse();
                }
                panels.push(Panel::new(corners));
            }
        }
        Ok(Self {
            chordwise,
            spanwise: sections - 1,
            nodes_m,
            panels,
            caps,
            has_trailing_edge,
            is_symmetric,
        })
    }

    /// A node [m].
    #[must_use]
    pub fn node_m(&self, chordwise: usize, section: usize) -> DVec3 {
        self.nodes_m[section * (self.chordwise + 1) + chordwise]
    }

    /// The strip that a panel belongs to; of a panel of a cap, the strip that it closes.
    #[must_use]
    pub fn strip_of(&self, panel: usize) -> usize {
        self.caps
            .iter()
            .rev()
            .find(|cap| panel >= cap.first)
            .map_or(panel / self.chordwise, |cap| cap.strip)
    }

    /// Mean chord of a strip, from its trailing edge to the node farthest from it [m].
    #[must_use]
    pub fn chord_m(&self, strip: usize) -> f64 {
        let chord = |section: usize| {
            let edge = self.node_m(0, section);
            (1..self.chordwise)
                .map(|i| self.node_m(i, section).distance(edge))
                .fold(0.0, f64::max)
        };
        0.5 * (chord(strip) + chord(strip + 1))
    }

    /// Mean place of the nodes of a section [m].
    fn middle_m(&self, section: usize) -> DVec3 {
        (0..self.chordwise)
            .map(|i| self.node_m(i, section))
            .sum::<DVec3>()
            / self.chordwise as f64
    }

    /// Span-wise step of a strip across the stream, its x component left out [m].
    #[must_use]
    pub fn span_m(&self, strip: usize) -> DVec3 {
        let step = self.middle_m(strip + 1) - self.middle_m(strip);
        DVec3::new(0.0, step.y, step.z)
    }

    /// Volume inside [m³]; of a symmetric surface both halves.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        let volume: f64 = self
            .panels
            .iter()
            .map(|p| p.centre_m.dot(p.area_m2) / 3.0)
            .sum();
        if self.is_symmetric {
            2.0 * volume
        } else {
            volume
        }
    }
}

/// The point mirrored at the plane of symmetry.
#[must_use]
pub fn mirrored(point: DVec3) -> DVec3 {
    DVec3::new(point.x, -point.y, point.z)
}

/// An ellipsoid with the given semi-axes as a closed surface without a trailing edge, poles on the y axis; `chordwise` panels around it
/// and `spanwise` strips from pole to pole.
pub fn ellipsoid(
    semi_axes_m: DVec3,
    chordwise: usize,
    spanwise: usize,
) -> Result<PanelSurface, AeroError> {
    use std::f64::consts::PI;
    let nodes = (0..=spanwise)
        .flat_map(|j| {
            (0..=chordwise).map(move |i| {
                let polar = PI * j as f64 / spanwise as f64;
                // From downstream below around the nose.
                let around = 2.0 * PI * (i % chordwise) as f64 / chordwise as f64;
                let (sin, cos) = if j == 0 || j == spanwise {
                    (0.0, polar.cos().signum())
                } else {
                    polar.sin_cos()
                };
                semi_axes_m * DVec3::new(sin * around.cos(), -cos, -sin * around.sin())
            })
        })
        .collect();
    PanelSurface::new(nodes, chordwise, false, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn station(y: f64, chord_m: f64) -> Station {
        Station {
            position_m: DVec3::new(0.0, y, 0.0),
            chord_m,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::new(Profile::naca("0012").unwrap()),
        }
    }

    /// The volume of a box of constant section is area times length whichever way it is closed, and normals point outwards.
    #[test]
    fn wings_are_closed() {
        let wing = Wing {
            stations: vec![station(0.0, 2.0), station(3.0, 2.0)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        let half = wing.divided(7, 0.8).unwrap().panels(40).unwrap();
        // ∫ of the thickness: 0.0822 t/0.12 chords².
        let area = 4.0 * 0.0816;
        assert!(
            (half.volume_m3() / (6.0 * area) - 1.0).abs() < 0.01,
            "{}",
            half.volume_m3()
        );
        assert_eq!((half.spanwise, half.caps.len()), (7, 1));
        let whole = Wing {
            stations: vec![station(-3.0, 2.0), station(3.0, 2.0)],
            is_symmetric: false,
            ..wing
        };
        let whole = whole.panels(40).unwrap();
        // The half's inner sections are blends of two profiles, which pass through another spline.
        assert!((whole.volume_m3() / half.volume_m3() - 1.0).abs() < 1e-7);
        let sum: DVec3 = whole.panels.iter().map(|p| p.area_m2).sum();
        assert!(sum.length() < 1e-12);
        assert_eq!(whole.caps.len(), 2);
        assert_eq!(whole.strip_of(whole.caps[1].first), 0);
    }

    #[test]
    fn twist_is_nose_up_and_roll_is_dihedral() {
        let mut s = station(1.0, 2.0);
        s.twist_rad = 0.1;
        let nose = s.place(DVec2::ZERO, 0.25);
        assert!(nose.z > 0.0 && nose.x < 0.0);
        s.twist_rad = 0.0;
        s.roll_rad = 0.2;
        let above = s.place(DVec2::new(0.25, 0.1), 0.25);
        assert!(above.y < 1.0 && above.z > 0.0);
        let mut wing = Wing {
            stations: vec![station(0.0, 1.0), station(1.0, 1.0), station(2.0, 1.0)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        wing.stations[2].position_m.z = -1.0;
        wing.roll_along_span();
        let rolls: Vec<f64> = wing
            .stations
            .iter()
            .map(|s| s.roll_rad.to_degrees())
            .collect();
        assert!(
            rolls[0].abs() < 1e-9
                && (rolls[1] + 22.5).abs() < 1e-9
                && (rolls[2] + 45.0).abs() < 1e-9
        );
    }

    #[test]
    fn an_ellipsoid_has_its_volume_and_triangles_at_its_poles() {
        let body = ellipsoid(DVec3::new(2.0, 1.0, 1.0), 40, 40).unwrap();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 2.0;
        assert!((body.volume_m3() / exact - 1.0).abs() < 0.01);
        assert!(body.caps.is_empty());
    }

    #[test]
    fn faults_are_named() {
        let wing = |stations: Vec<Station>| Wing {
            stations,
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        for (wing, part) in [
            (wing(vec![station(0.0, 1.0)]), "two stations"),
            (wing(vec![station(0.0, 1.0), station(0.0, 1.0)]), "coincide"),
            (
                wing(vec![station(0.0, 0.0), station(1.0, 1.0)]),
                "positive chord",
            ),
            (wing(vec![station(0.1, 1.0), station(1.0, 1.0)]), "y = 0"),
            (
                wing(vec![station(0.0, f64::NAN), station(1.0, 1.0)]),
                "finite",
            ),
        ] {
            let error = wing.panels(10).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        let open = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
        let open = [open.clone(), open].concat();
        assert!(PanelSurface::new(open, 4, true, false).is_err());
    }
}
