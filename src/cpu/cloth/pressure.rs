//! Pressure jumps across fabric, which follow its surface.
//!
//! A triangle with the jump p along its normal pulls each of its nodes with p A n/3. In a time step the load is that at the start of the
//! step. In the static limit it follows: −p V, with V the volume under the triangle as seen from a point o, has these pulls as its
//! gradient, but for terms along the edges of a patch of equal pressure, which cancel where the edge is held. They are taken from the
//! last iterate and corrected until they stand still (`edge_correction`).
//!
//! A load that is not the same all around a body ([`Pressure::Lagged`], a wing's) has such terms everywhere, and as a whole turns with the
//! body: a wing on its lines would find nothing to stand by. It is taken from the last iterate, in the direction that it had there, until
//! it stands still. It must be taken as a whole: where pressure inside and outside nearly cancel, as below the nose, one that follows against one that
//! lags leaves, on fabric that turns by θ, a pull of the order of either times sin θ, which folds what the small difference of both holds.

use glam::DVec3;

use super::gather::Gather;
use super::vectors::{chunked_sum, each};
use crate::cloth::Structure;

/// Pressure jumps, positive along the normals of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pressure<'a> {
    /// None.
    #[default]
    None,
    /// The same everywhere [Pa].
    Uniform(f64),
    /// One for every triangle [Pa], `[triangle_count]`.
    PerTriangle(&'a [f64]),
    /// One for every triangle [Pa], `[triangle_count]`, whose pull in the static limit stays as it was at the last iterate, and is renewed until
    /// it stands still.
    Lagged(&'a [f64]),
}

impl<'a> Pressure<'a> {
    /// Jump at a triangle [Pa].
    #[inline]
    #[must_use]
    pub fn at(&self, triangle: usize) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Uniform(pressure_pa) => *pressure_pa,
            Self::PerTriangle(pressures_pa) | Self::Lagged(pressures_pa) => pressures_pa[triangle],
        }
    }

    /// True if no triangle is loaded.
    #[must_use]
    pub fn is_none(&self) -> bool {
        match self {
            Self::None => true,
            Self::Uniform(pressure_pa) => *pressure_pa == 0.0,
            Self::PerTriangle(pressures_pa) | Self::Lagged(pressures_pa) => {
                pressures_pa.iter().all(|p| *p == 0.0)
            }
        }
    }

    /// The part that follows the fabric within a static solve.
    #[must_use]
    pub const fn following(self) -> Self {
        match self {
            Self::Lagged(_) => Self::None,
            all => all,
        }
    }

    /// The part that stays as it was at the last iterate.
    #[must_use]
    pub const fn lagged(self) -> Self {
        match self {
            Self::Lagged(_) => self,
            _ => Self::None,
        }
    }
}

/// Adds the pulls of pressure to `forces` [N].
pub fn add_forces(
    structure: &Structure,
    positions: &[DVec3],
    pressure: Pressure,
    forces: &mut [DVec3],
) {
    if pressure.is_none() {
        return;
    }
    for (index, triangle) in structure.triangles.iter().enumerate() {
        let share = triangle.doubled_area_vector(positions) * (pressure.at(index) / 6.0);
        for node in triangle.nodes {
            forces[node as usize] += share;
        }
    }
}

/// −∂(−pV)/∂x of one corner.
fn corner_force(
    structure: &Structure,
    positions: &[DVec3],
    origin: DVec3,
    (triangle, corner): (usize, usize),
    pressure: Pressure,
) -> DVec3 {
    let nodes = structure.triangles[triangle].nodes;
    let place = |k: usize| positions[nodes[k % 3] as usize] - origin;
    place(corner + 1).cross(place(corner + 2)) * (pressure.at(triangle) / 6.0)
}

/// Adds the gradient of −pV, seen from `origin`, to `gradient` [N], and returns −pV [J].
pub(super) fn add_potential(
    structure: &Structure,
    gather: &Gather,
    positions: &[DVec3],
    origin: DVec3,
    pressure: Pressure,
    gradient: &mut [DVec3],
) -> f64 {
    each(gradient, |node, gradient| {
        for corner in gather.triangles.at(node) {
            *gradient -= corner_force(structure, positions, origin, corner, pressure);
        }
    });
    let [energy] = chunked_sum(structure.triangles.len(), |range| {
        let volume = |t: usize| {
            let [a, b, c] = structure.triangles[t]
                .nodes
                .map(|n| positions[n as usize] - origin);
            -pressure.at(t) / 6.0 * a.dot(b.cross(c))
        };
        [range.map(volume).sum()]
    });
    energy
}

/// What the gradient of −pV lacks to the pulls of pressure [N], `[node_count]`: zero but along edges of patches of equal pressure.
pub(super) fn edge_correction(
    structure: &Structure,
    gather: &Gather,
    positions: &[DVec3],
    origin: DVec3,
    pressure: Pressure,
) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; structure.node_count()];
    if pressure.is_none() {
        return forces;
    }
    add_forces(structure, positions, pressure, &mut forces);
    for (node, force) in forces.iter_mut().enumerate() {
        let mut size = force.length();
        for corner in gather.triangles.at(node) {
            let pull = corner_force(structure, positions, origin, corner, pressure);
            size += pull.length();
            *force -= pull;
        }
        if structure.held[node] || force.length() <= 1e-9 * size {
            // Held, or round-off.
            *force = DVec3::ZERO;
        }
    }
    forces
}

/// How far loads have changed: the largest change of a node over the largest pull of pressure, or the root of the mean squares of both,
/// where single nodes, of slack fabric under a load that lags, need not stand still.
pub(super) fn relative_change(
    [old, new]: [&[DVec3]; 2],
    pulls: &[DVec3],
    in_the_mean: bool,
) -> f64 {
    let size = |squares: &mut dyn Iterator<Item = f64>| {
        if in_the_mean {
            squares.sum::<f64>().sqrt()
        } else {
            squares.fold(0.0, f64::max).sqrt()
        }
    };
    let change = size(&mut old.iter().zip(new).map(|(a, b)| (*b - *a).length_squared()));
    let all = size(&mut pulls.iter().map(|p| p.length_squared()));
    if all > 0.0 { change / all } else { 0.0 }
}

/// −pV at `positions`, seen from the middle of `start` [J].
#[must_use]
pub fn potential_j(
    structure: &Structure,
    start: &[DVec3],
    positions: &[DVec3],
    pressure: Pressure,
) -> f64 {
    let origin = middle(start);
    let triangles = structure.triangles.iter().enumerate();
    triangles
        .map(|(index, triangle)| {
            let [a, b, c] = triangle.nodes.map(|n| positions[n as usize] - origin);
            -pressure.at(index) / 6.0 * a.dot(b.cross(c))
        })
        .sum()
}

/// The first node that moves at an edge of a patch of equal pressure, if there is one.
#[must_use]
pub fn first_open_edge(
    structure: &Structure,
    positions: &[DVec3],
    pressure: Pressure,
) -> Option<usize> {
    let gather = Gather::new(structure);
    let origin = middle(positions);
    let missing = edge_correction(structure, &gather, positions, origin, pressure);
    missing.iter().position(|force| *force != DVec3::ZERO)
}

/// A point in the middle of the structure [m], from which volumes are seen.
#[must_use]
pub fn middle(positions: &[DVec3]) -> DVec3 {
    let sum: DVec3 = positions.iter().sum();
    sum / positions.len().max(1) as f64
}
