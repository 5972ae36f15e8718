//! A square airbag: two flat sheets joined along their edges.

use glam::DVec3;

use super::fabric_surface;
use crate::cloth::{Guide, Structure};
use crate::fabric::Fabric;
use crate::rigid::Surface;

/// How far apart the sheets stand in the middle at the start, over the side.
const START_BULGE: f64 = 0.02;

/// An airbag and its nodes of interest.
#[derive(Debug, Clone)]
pub struct Airbag {
    /// The structure; normals point outwards.
    pub structure: Structure,
    /// Nodes in the middle of the upper and of the lower sheet.
    pub middles: [u32; 2],
    /// Nodes in the middle of the four sides: at −x, +x, −y, +y.
    pub sides: [u32; 4],
    /// Corners.
    pub corners: [u32; 4],
}

/// Builds the bag about the origin, flat in the plane z = 0 but for a small start bulge; `cells` per side, even. Guides in the middles and
/// at the corners keep it from drifting; by symmetry they carry nothing. `None` for an odd or zero number of cells.
#[must_use]
pub fn build(side_m: f64, cells: usize, fabric: &Fabric) -> Option<Airbag> {
    if cells < 2 || !cells.is_multiple_of(2) {
        return None;
    }
    let n = cells;
    let row = n + 1;
    let mut surface = Surface::default();
    let mut bulges = Vec::new();
    let mut lower = vec![0; row * row];
    let coordinate = |i: usize| side_m * (i as f64 / n as f64 - 0.5);
    let bulge = |i: usize, j: usize| {
        let across = |i: usize| (std::f64::consts::PI * i as f64 / n as f64).sin();
        0.5 * START_BULGE * side_m * across(i) * across(j)
    };
    for j in 0..row {
        for i in 0..row {
            surface
                .positions_m
                .push(DVec3::new(coordinate(i), coordinate(j), 0.0));
            bulges.push(bulge(i, j));
        }
    }
    for j in 0..row {
        for i in 0..row {
            lower[j * row + i] = if i == 0 || j == 0 || i == n || j == n {
                (j * row + i) as u32
            } else {
                surface
                    .positions_m
                    .push(DVec3::new(coordinate(i), coordinate(j), 0.0));
                bulges.push(-bulge(i, j));
                surface.positions_m.len() as u32 - 1
            };
        }
    }
    for j in 0..n {
        for i in 0..n {
            let place = |i: usize, j: usize| j * row + i;
            let quad = [
                place(i, j),
                place(i + 1, j),
                place(i + 1, j + 1),
                place(i, j + 1),
            ];
            // Alternate diagonals, mirrored about both middles, so that the bag stays symmetric.
            let halves = if (i + j) % 2 == 0 {
                [[0, 1, 2], [0, 2, 3]]
            } else {
                [[0, 1, 3], [1, 2, 3]]
            };
            for [a, b, c] in halves {
                let [a, b, c] = [quad[a], quad[b], quad[c]];
                surface.triangles.push([a, b, c].map(|k| k as u32));
                surface.triangles.push([lower[a], lower[c], lower[b]]);
            }
        }
    }
    let mut structure = fabric_surface::build(&surface, DVec3::X, fabric).ok()?;
    for (place, bulge) in structure.positions_m.iter_mut().zip(bulges) {
        place.z = bulge;
    }
    let middle = n / 2 * row + n / 2;
    let corners = [0, n, n * row, n * row + n].map(|k| k as u32);
    let stiffness = 1e-3 * fabric.stiffness_n_m()[0][0];
    for node in [middle as u32, lower[middle]] {
        structure.guides.push(Guide {
            node,
            anchor_m: DVec3::ZERO,
            stiffness_n_m: DVec3::new(stiffness, stiffness, 0.0),
        });
    }
    for node in corners {
        structure.guides.push(Guide {
            node,
            anchor_m: DVec3::ZERO,
            stiffness_n_m: DVec3::new(0.0, 0.0, stiffness),
        });
    }
    // Turning about the normal through the middles.
    let sides = [n / 2 * row, n / 2 * row + n, n / 2, n * row + n / 2].map(|k| k as u32);
    for (node, axis) in [(sides[0], DVec3::Y), (sides[1], DVec3::Y)] {
        structure.guides.push(Guide {
            node,
            anchor_m: DVec3::ZERO,
            stiffness_n_m: axis * stiffness,
        });
    }
    Some(Airbag {
        structure,
        middles: [middle as u32, lower[middle]],
        sides,
        corners,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bag_is_closed_and_encloses_its_start_bulge() {
        let fabric = Fabric {
            thickness_m: 1e-4,
            density_kg_m3: 500.0,
            warp_modulus_pa: 1e8,
            weft_modulus_pa: 1e8,
            poisson_ratio: 0.3,
            shear_modulus_pa: 4e7,
            cubic_shear_compliance_1_pa3: None,
            residual_stiffness: 0.0,
            initial_strain: [0.0; 2],
            yield_stress_pa: None,
        };
        let bag = build(1.0, 20, &fabric).unwrap();
        let surface = Surface {
            positions_m: bag.structure.positions_m.clone(),
            triangles: bag.structure.triangles.iter().map(|t| t.nodes).collect(),
        };
        assert!(surface.is_closed());
        // ∫∫ b sin(πx) sin(πy) = b (2/π)², b the distance in the middle.
        let exact = START_BULGE * (2.0 / std::f64::consts::PI).powi(2);
        let (volume, _) = surface.volume_m3();
        assert!((volume / exact - 1.0).abs() < 0.01, "{volume} {exact}");
        assert!((bag.structure.rest_area_m2() - 2.0).abs() < 1e-12);
        assert!(build(1.0, 3, &fabric).is_none());
    }
}
