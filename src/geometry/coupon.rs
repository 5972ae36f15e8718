//! A strip of fabric for tensile tests, cut at an angle to the warp, held at both ends, one of which is pulled.

use glam::DVec3;

use super::fabric_surface;
use crate::cloth::Structure;
use crate::fabric::Fabric;
use crate::rigid::Surface;

/// A coupon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupon {
    /// Length between the clamps, along x [m].
    pub length_m: f64,
    /// Width, along y [m].
    pub width_m: f64,
    /// Cells over the width; about square.
    pub cells_across: usize,
    /// Angle from the coupon's length to the warp [°].
    pub warp_angle_deg: f64,
    /// Way of the pulled clamp over the length.
    pub elongation: f64,
}

/// A coupon ready to be pulled.
#[derive(Debug, Clone)]
pub struct Strip {
    /// The structure; its free nodes stand where an even elongation puts them.
    pub structure: Structure,
    /// Where the nodes of the pulled clamp end up [m].
    pub moved: Vec<(u32, DVec3)>,
    /// Nodes in the middle of the width at a third and at two thirds of the length.
    pub gauge: [u32; 2],
    /// Their distance at rest [m].
    pub gauge_length_m: f64,
}

/// Builds the strip from the origin along +x; `None` without cells or size.
#[must_use]
pub fn build(coupon: &Coupon, fabric: &Fabric) -> Option<Strip> {
    let across = coupon.cells_across.checked_next_multiple_of(2)?.max(2);
    let cell = coupon.width_m / across as f64;
    let along = ((coupon.length_m / cell / 3.0).round() as usize).max(1) * 3;
    let mut surface = Surface::default();
    for j in 0..=across {
        for i in 0..=along {
            surface.positions_m.push(DVec3::new(
                coupon.length_m * i as f64 / along as f64,
                coupon.width_m * (j as f64 / across as f64 - 0.5),
                0.0,
            ));
        }
    }
    let node = |i: usize, j: usize| (j * (along + 1) + i) as u32;
    for j in 0..across {
        for i in 0..along {
            let [a, b] = [node(i, j), node(i + 1, j)];
            let [c, d] = [node(i + 1, j + 1), node(i, j + 1)];
            if (i + j) % 2 == 0 {
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                surface.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    let (sine, cosine) = coupon.warp_angle_deg.to_radians().sin_cos();
    let warp = DVec3::new(cosine, sine, 0.0);
    let mut structure = fabric_surface::build(&surface, warp, fabric).ok()?;
    let mut moved = Vec::new();
    for j in 0..=across {
        for i in [0, along] {
            structure.held[node(i, j) as usize] = true;
        }
        let end = node(along, j);
        let way = DVec3::X * (coupon.elongation * coupon.length_m);
        moved.push((end, structure.positions_m[end as usize] + way));
    }
    // Straight from the start, so that what is sought is near.
    for (place, held) in structure.positions_m.iter_mut().zip(&structure.held) {
        if !held {
            place.x *= 1.0 + coupon.elongation;
        }
    }
    let middle = across / 2;
    Some(Strip {
        structure,
        moved,
        gauge: [node(along / 3, middle), node(2 * along / 3, middle)],
        gauge_length_m: coupon.length_m / 3.0,
    })
}

impl Strip {
    /// Engineering strain between the gauge nodes.
    #[must_use]
    pub fn gauge_strain(&self, positions_m: &[DVec3]) -> f64 {
        let [a, b] = self.gauge.map(|n| positions_m[n as usize]);
        a.distance(b) / self.gauge_length_m - 1.0
    }
}
