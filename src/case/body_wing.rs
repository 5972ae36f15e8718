//! A closed wing as a rigid body: `[bodies.NAME.wing]`.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::bare_wing::{MeanChord, check_outline};
use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{positive, vector, within};
use crate::aero::AeroError;
use crate::aero::surface::{Station, Wing};
use crate::geometry::profile::Profile;
use crate::rigid::Surface;

/// Most triangles that a body is divided into, this or another.
pub(super) const TRIANGLE_LIMIT: f64 = 2e7;

/// Fewest points along each side of a section, and strips.
const FEWEST: f64 = 8.0;

/// A wing that is drawn.
pub(super) struct DrawnWing {
    /// Its skin, with flat tips.
    pub(super) surface: Surface,
    /// Area of the chords, the wing laid flat [m²].
    pub(super) area_m2: f64,
    /// Mean aerodynamic chord [m].
    pub(super) chord_m: f64,
}

/// Draws the wing of the table `key`, with edges of about `edge_m`.
pub(super) fn check(
    key: &str,
    written: &file::WingShape,
    folder: &Path,
    edge_m: f64,
) -> Result<DrawnWing, Problem> {
    let profile = Arc::new(check_outline(key, (&written.naca, &written.file), folder)?);
    let name = |name: &str| format!("{key}.{name}");
    let stations = (written.stations.iter())
        .map(|station| {
            Ok(Station {
                position_m: vector(&name("stations"), station.position_m)?,
                chord_m: positive(&name("stations"), station.chord_m)?,
                twist_rad: {
                    let twist = usual::or(name("stations.twist_deg"), station.twist_deg, 0.0);
                    within(&name("stations"), twist, -90.0, 90.0)?.to_radians()
                },
                roll_rad: 0.0,
                profile: Arc::clone(&profile),
            })
        })
        .collect::<Result<_, Problem>>()?;
    let chord_fraction = usual::or(name("chord_fraction"), written.chord_fraction, 0.25);
    let mut wing = Wing {
        stations,
        chord_fraction: within(&name("chord_fraction"), chord_fraction, 0.0, 1.0)?,
        is_symmetric: usual::or(name("symmetric"), written.symmetric, true),
    };
    let wrong = |why: AeroError| {
        Problem::new(
            name("stations"),
            format!("{key}: {why}"),
            "give at least two stations by growing y, of a symmetric wing from y = 0 on",
        )
    };
    wing.check().map_err(wrong)?;
    wing.roll_along_span();
    let whole = whole(&wing);
    let y = |station: &Station| station.position_m.y;
    if (whole.stations.windows(2)).any(|pair| y(&pair[1]) < y(&pair[0])) {
        return Err(Problem::new(
            name("stations"),
            format!("{key}: the stations do not run to the right"),
            "give the right half, y > 0, from the middle outwards; or, with symmetric = false, the whole wing from the left tip to the right one",
        ));
    }
    let parts = Parts::of(&whole, edge_m);
    if 4.0 * parts.per_side * parts.strips > TRIANGLE_LIMIT {
        return Err(Problem::new(
            key,
            format!("{key}: the wing's surface is too large for triangles of {edge_m:e} m"),
            "choose larger cells or a smaller wing",
        ));
    }
    Ok(DrawnWing {
        area_m2: wing.flat_area_m2(),
        chord_m: MeanChord::of(&wing).chord_m,
        surface: skin(&whole, &profile, parts).map_err(wrong)?,
    })
}

/// How a wing is divided.
#[derive(Debug, Clone, Copy)]
struct Parts {
    /// Along each side of a section.
    per_side: f64,
    /// Along the span.
    strips: f64,
}

impl Parts {
    /// With edges of about `edge_m`.
    fn of(wing: &Wing, edge_m: f64) -> Self {
        let parts = |length: f64| (length / edge_m).ceil().max(FEWEST);
        let chords = wing.stations.iter().map(|station| station.chord_m);
        let along_span = wing.stations.windows(2).map(|pair| {
            let step = pair[1].position_m - pair[0].position_m;
            step.y.hypot(step.z)
        });
        Self {
            per_side: parts(chords.fold(0.0, f64::max)),
            strips: parts(along_span.sum()),
        }
    }
}

/// Both halves, from tip to tip.
fn whole(wing: &Wing) -> Wing {
    if !wing.is_symmetric {
        return wing.clone();
    }
    let mirrored = |station: &Station| Station {
        position_m: station.position_m * DVec3::new(1.0, -1.0, 1.0),
        roll_rad: -station.roll_rad,
        ..station.clone()
    };
    let left = wing.stations.iter().skip(1).rev().map(mirrored);
    Wing {
        stations: left.chain(wing.stations.iter().cloned()).collect(),
        is_symmetric: false,
        ..wing.clone()
    }
}

/// Triangles of the skin and of flat tips, normals outwards.
fn skin(wing: &Wing, profile: &Profile, parts: Parts) -> Result<Surface, AeroError> {
    let [per_side, strips] = [parts.per_side, parts.strips].map(|count| count as usize);
    let around = 2 * per_side;
    let mut surface = Surface::default();
    let points = profile.resampled(per_side);
    for station in wing.divided(strips, 0.0)?.stations {
        // The last point is the first.
        let places = points[..around].iter();
        (surface.positions_m).extend(places.map(|p| station.place(*p, wing.chord_fraction)));
    }
    let node = |i: usize, strip: usize| (strip * around + i % around) as u32;
    for strip in 0..strips {
        for i in 0..around {
            let [a, b] = [node(i, strip), node(i + 1, strip)];
            let [c, d] = [node(i + 1, strip + 1), node(i, strip + 1)];
            surface.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (strip, left) in [(0, true), (strips, false)] {
        for i in 0..per_side {
            // Below, and above it.
            let [a, b] = [node(i, strip), node(i + 1, strip)];
            let [c, d] = [node(around - i - 1, strip), node(around - i, strip)];
            for [p, q, r] in [[a, b, c], [a, c, d]] {
                // At the trailing edge and at the nose both sides have the same node.
                if p != q && q != r && r != p {
                    surface
                        .triangles
                        .push(if left { [p, r, q] } else { [p, q, r] });
                }
            }
        }
    }
    Ok(surface)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_skin_encloses_the_volume_of_its_sections() {
        let profile = Arc::new(Profile::naca("2412").unwrap());
        let station = |y: f64, chord_m: f64| Station {
            position_m: DVec3::new(0.1 * y, y, 0.2 * y),
            chord_m,
            twist_rad: 0.1,
            roll_rad: 0.0,
            profile: Arc::clone(&profile),
        };
        let mut wing = Wing {
            stations: vec![station(0.0, 1.0), station(2.0, 0.5)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        wing.roll_along_span();
        let whole = whole(&wing);
        let surface = skin(&whole, &profile, Parts::of(&whole, 0.05)).unwrap();
        assert!(surface.is_closed());
        // The sections' area is 0.685 t/c c² (four digits, thickness only), mean of c² 7/12. The sections lean, and follow each other along y / cos roll.
        let exact = 0.685 * 0.12 * 7.0 / 12.0 * 4.0;
        let volume: f64 = (surface.triangles.iter())
            .map(|nodes| {
                let [a, b, c] = surface.corners(*nodes);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        assert!((volume / exact - 1.0).abs() < 0.05, "{volume} {exact}");
        let (low, high) = (surface.positions_m.iter())
            .fold((0.0_f64, 0.0_f64), |(low, high), p| {
                (low.min(p.y), high.max(p.y))
            });
        assert!((low + high).abs() < 1e-12 && (high - 2.0).abs() < 0.03);
    }
}
