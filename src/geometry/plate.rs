//! A rectangular plate of fabric, clamped or pinned along one edge, with bending stiffness: a flag, a blade in a stream.
//!
//! A clamp is a row of held nodes beyond the edge, half a bend away: the curvature of a triangle at the edge takes the whole angle between
//! it and the clamp (`Structure::add_clamped_curvatures`). Those nodes carry neither fabric nor markers, so that the air meets the plate alone.

use glam::DVec3;

use super::sheet::{self, Diagonals, FabricModel, SheetShape};
use crate::cloth::Structure;
use crate::fabric::Fabric;
use crate::immersed::markers::Marker;

/// How the edge is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Support {
    /// Place and tangent.
    Clamped,
    /// Place alone: the plate turns freely about the edge.
    Pinned,
}

/// Where a plate is and how finely it is divided. Pairs are along the length, from the held edge to the free one, and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plate {
    /// Length and width [m].
    pub size_m: [f64; 2],
    /// Cells along length and width.
    pub divisions: [usize; 2],
    /// Middle of the held edge [m].
    pub held_edge_m: DVec3,
    /// Unit vector of the length (warp).
    pub along: DVec3,
    /// Unit vector of the width (weft).
    pub across: DVec3,
    /// How the edge is held.
    pub support: Support,
    /// Flexural rigidity D along the length [N m].
    pub flexural_rigidity_nm: f64,
}

impl Plate {
    /// Rows of nodes beyond the held edge.
    const fn rows_beyond(&self) -> usize {
        match self.support {
            Support::Clamped => 1,
            Support::Pinned => 0,
        }
    }

    fn sheet(&self) -> SheetShape {
        let rows = self.rows_beyond();
        let [length, width] = self.size_m;
        let cell = length / self.divisions[0] as f64;
        let before = rows as f64 * cell;
        SheetShape {
            size_m: [length + before, width],
            divisions: [self.divisions[0] + rows, self.divisions[1]],
            corner_m: self.held_edge_m - self.along * before - self.across * (0.5 * width),
            across: self.along,
            down: self.across,
        }
    }

    /// The node in the middle of the free edge, or next to it.
    #[must_use]
    pub fn tip(&self) -> u32 {
        let sheet = self.sheet();
        sheet.node(sheet.divisions[0], self.divisions[1] / 2)
    }

    /// Where that node is while the plate is flat [m].
    #[must_use]
    pub fn flat_tip_m(&self) -> DVec3 {
        let [length, width] = self.size_m;
        let off = (self.divisions[1] / 2) as f64 / self.divisions[1] as f64 - 0.5;
        self.held_edge_m + self.along * length + self.across * (off * width)
    }

    /// Normal of the flat plate.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.along.cross(self.across)
    }

    /// Length times width [m²].
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.size_m[0] * self.size_m[1]
    }

    /// Markers along length and width at most `spacing_m` apart, in the rectangle whose rim is `inset_m` inside the plate's.
    #[must_use]
    pub fn marker_counts(&self, spacing_m: f64, inset_m: f64) -> [usize; 2] {
        self.size_m
            .map(|size| (((size - 2.0 * inset_m) / spacing_m).ceil() as usize).max(1))
    }

    /// The markers: middles of equal rectangles. They do not depend on the triangles, which they only sit on.
    #[must_use]
    pub fn place_markers(&self, spacing_m: f64, inset_m: f64) -> Vec<Marker> {
        let counts = self.marker_counts(spacing_m, inset_m);
        let inner = self.size_m.map(|size| size - 2.0 * inset_m);
        let area_m2 = inner[0] * inner[1] / (counts[0] * counts[1]) as f64;
        let mut markers = Vec::with_capacity(counts[0] * counts[1]);
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let place = [i, j];
                let at = [0, 1].map(|a| {
                    let share = (place[a] as f64 + 0.5) / counts[a] as f64;
                    (inset_m + share * inner[a]) / self.size_m[a]
                });
                let (triangle, weights) = self.triangle_at(at);
                markers.push(Marker {
                    triangle,
                    weights,
                    area_m2,
                });
            }
        }
        markers
    }

    /// The triangle at shares of length and width, and the weights of its nodes there. The inverse of what [`sheet::build_cut`] does.
    fn triangle_at(&self, at: [f64; 2]) -> (u32, [f64; 3]) {
        let cell = [0, 1].map(|a| {
            let cells = self.divisions[a];
            ((at[a] * cells as f64) as usize).min(cells - 1)
        });
        let [x, y] = [0, 1].map(|a| at[a] * self.divisions[a] as f64 - cell[a] as f64);
        let first = 2 * (cell[1] * self.divisions[0] + cell[0]) as u32;
        if x >= y {
            (first, [1.0 - x, x - y, y])
        } else {
            (first + 1, [1.0 - y, x, y - x])
        }
    }
}

/// Builds the plate, flat and free of stress. Its flexural rigidities stand to each other as those of a solid sheet of the fabric; `None` if a
/// triangle would have no area.
#[must_use]
pub fn build(plate: &Plate, fabric: &Fabric) -> Option<Structure> {
    let solid_nm = fabric.rigidity_nm();
    let factor = plate.flexural_rigidity_nm / solid_nm[0][0];
    let rigidity_nm = solid_nm.map(|row| row.map(|d| d * factor));
    let shape = plate.sheet();
    let mut structure =
        sheet::build_cut(&shape, fabric, FabricModel::Membrane, Diagonals::Parallel)?;
    let rows = plate.rows_beyond();
    let column = |node: u32| node as usize % (shape.divisions[0] + 1);
    let is_beyond = |node: u32| column(node) < rows;
    let rest = structure.positions_m.clone();
    structure.add_clamped_curvatures(&rest, plate.along, rigidity_nm, is_beyond);
    structure
        .triangles
        .retain(|triangle| !triangle.nodes.into_iter().any(is_beyond));
    structure.masses_kg.fill(0.0);
    for triangle in &structure.triangles {
        for node in triangle.nodes {
            structure.masses_kg[node as usize] +=
                fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        }
    }
    for (node, held) in structure.held.iter_mut().enumerate() {
        *held = column(node as u32) <= rows;
    }
    Some(structure)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fabric() -> Fabric {
        Fabric {
            thickness_m: 1e-3,
            density_kg_m3: 1000.0,
            warp_modulus_pa: 1e6,
            weft_modulus_pa: 1e6,
            poisson_ratio: 0.3,
            shear_modulus_pa: 4e5,
            cubic_shear_compliance_1_pa3: None,
            residual_stiffness: 1.0,
            initial_strain: [0.0; 2],
            yield_stress_pa: None,
        }
    }

    /// Markers lie where the rectangle's middles are, whatever the triangles; their area is that of the rectangle, the mass that of the plate.
    #[test]
    fn markers_lie_on_a_grid_of_their_own() {
        for support in [Support::Clamped, Support::Pinned] {
            let fabric = fabric();
            let plate = Plate {
                size_m: [2.0, 0.7],
                divisions: [7, 4],
                held_edge_m: DVec3::new(1.0, 2.0, 3.0),
                along: DVec3::Z,
                across: DVec3::Y,
                support,
                flexural_rigidity_nm: fabric.rigidity_nm()[0][0],
            };
            let structure = build(&plate, &fabric).unwrap();
            let mass: f64 = structure.masses_kg.iter().sum();
            assert!((mass - 1.4).abs() < 1e-12, "{mass}");
            assert_eq!(
                structure.positions_m[plate.tip() as usize],
                plate.flat_tip_m()
            );
            let markers = plate.place_markers(0.11, 0.05);
            assert_eq!(plate.marker_counts(0.11, 0.05), [18, 6]);
            let area: f64 = markers.iter().map(|marker| marker.area_m2).sum();
            assert!((area - 1.9 * 0.6).abs() < 1e-12);
            for (k, marker) in markers.iter().enumerate() {
                let nodes = structure.triangles[marker.triangle as usize].nodes;
                let at: DVec3 = nodes
                    .iter()
                    .zip(marker.weights)
                    .map(|(&node, weight)| structure.positions_m[node as usize] * weight)
                    .sum();
                let expected = DVec3::new(
                    1.0,
                    1.65 + 0.05 + 0.1 * ((k / 18) as f64 + 0.5),
                    3.05 + 1.9 / 18.0 * ((k % 18) as f64 + 0.5),
                );
                assert!(at.distance(expected) < 1e-12, "{k}: {at} {expected}");
                assert!(marker.weights.iter().all(|w| *w >= -1e-12));
            }
        }
    }
}
