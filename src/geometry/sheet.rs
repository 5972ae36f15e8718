//! A flat rectangular sheet of fabric.

use glam::DVec3;

use crate::cloth::{Bending, Spring, Structure, Triangle};
use crate::fabric::{Fabric, network};

/// How the fabric is modelled.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum FabricModel {
    /// Membrane triangles.
    Membrane,
    /// Mass–spring network of paper P0.
    Network,
}

/// Where a sheet lies and how finely it is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetShape {
    /// Width along `across` and height along `down` [m].
    pub size_m: [f64; 2],
    /// Cells along width and height.
    pub divisions: [usize; 2],
    /// Corner from which both directions start [m].
    pub corner_m: DVec3,
    /// Unit vector of the width (warp).
    pub across: DVec3,
    /// Unit vector of the height (weft).
    pub down: DVec3,
}

impl SheetShape {
    /// Index of the node at column `i`, row `j`.
    #[must_use]
    pub const fn node(&self, i: usize, j: usize) -> u32 {
        (j * (self.divisions[0] + 1) + i) as u32
    }
}

/// How cells are cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagonals {
    /// Like those of a chess board, so that the mesh has no preferred bias direction.
    Alternating,
    /// All alike, as bending stiffness wants it: twist and bending along a bias store the right energy, 2.9 and 1.65 times as much with
    /// alternating ones (ν = 0.3).
    Parallel,
}

/// Builds the sheet, stress-free and flat; `None` if a network spring would need a negative constant.
#[must_use]
pub fn build(shape: &SheetShape, fabric: &Fabric, model: FabricModel) -> Option<Structure> {
    build_cut(shape, fabric, model, Diagonals::Alternating)
}

/// The same, with cells cut as asked for.
#[must_use]
pub fn build_cut(
    shape: &SheetShape,
    fabric: &Fabric,
    model: FabricModel,
    diagonals: Diagonals,
) -> Option<Structure> {
    let [columns, rows] = shape.divisions;
    let cell = [
        shape.size_m[0] / columns as f64,
        shape.size_m[1] / rows as f64,
    ];
    let mut structure = Structure {
        thickness_m: fabric.thickness_m,
        yield_stress_pa: fabric.yield_stress_pa,
        ..Structure::default()
    };
    for j in 0..=rows {
        for i in 0..=columns {
            let offset = shape.across * (i as f64 * cell[0]) + shape.down * (j as f64 * cell[1]);
            structure.positions_m.push(shape.corner_m + offset);
        }
    }
    structure.held = vec![false; structure.node_count()];
    structure.masses_kg = vec![0.0; structure.node_count()];
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [
                shape.node(i, j),
                shape.node(i + 1, j),
                shape.node(i + 1, j + 1),
                shape.node(i, j + 1),
            ];
            let halves = if diagonals == Diagonals::Parallel || (i + j) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for nodes in halves {
                let rest = nodes.map(|n| structure.positions_m[n as usize]);
                let triangle =
                    Triangle::laid_out(nodes, rest, shape.across, fabric.initial_strain)?;
                for node in nodes {
                    structure.masses_kg[node as usize] +=
                        fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
                }
                structure.triangles.push(triangle);
            }
        }
    }
    match model {
        FabricModel::Membrane => {
            structure.membrane = Some(fabric.membrane());
        }
        FabricModel::Network => add_network(&mut structure, shape, fabric, cell)?,
    }
    Some(structure)
}

fn add_network(
    structure: &mut Structure,
    shape: &SheetShape,
    fabric: &Fabric,
    cell: [f64; 2],
) -> Option<()> {
    let [columns, rows] = shape.divisions;
    let stiffness = network::cell_stiffness(fabric, cell)?;
    let [warp, weft] = fabric.initial_strain;
    let rest = [cell[0] / (1.0 + warp), cell[1] / (1.0 + weft)];
    let diagonal = rest[0].hypot(rest[1]);
    let mut spring = |a: u32, b: u32, rest_length_m: f64, stiffness_n_m: f64| {
        structure.springs.push(Spring {
            nodes: [a, b],
            rest_length_m,
            stiffness_n_m,
            compressive_stiffness_n_m: stiffness_n_m * fabric.residual_stiffness,
        });
    };
    // An edge inside the sheet belongs to two cells, one on the border to a single one.
    let cells_at = |k: usize, n: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
    for j in 0..=rows {
        for i in 0..=columns {
            if i < columns {
                spring(
                    shape.node(i, j),
                    shape.node(i + 1, j),
                    rest[0],
                    stiffness.along_x * cells_at(j, rows),
                );
            }
            if j < rows {
                spring(
                    shape.node(i, j),
                    shape.node(i, j + 1),
                    rest[1],
                    stiffness.along_y * cells_at(i, columns),
                );
            }
            if i < columns && j < rows {
                spring(
                    shape.node(i, j),
                    shape.node(i + 1, j + 1),
                    diagonal,
                    stiffness.diagonal,
                );
                spring(
                    shape.node(i + 1, j),
                    shape.node(i, j + 1),
                    diagonal,
                    stiffness.diagonal,
                );
            }
        }
    }
    // Bending stiffness of a solid sheet, D = E h³ / 12 (1 − ν²), per direction.
    let flexural = fabric.rigidity_nm();
    for j in 0..=rows {
        for i in 0..=columns {
            if i + 2 <= columns {
                structure.bendings.push(Bending::second_difference(
                    [shape.node(i, j), shape.node(i + 1, j), shape.node(i + 2, j)],
                    flexural[0][0] * cell[1] / cell[0].powi(3) * cells_at(j, rows),
                ));
            }
            if j + 2 <= rows {
                structure.bendings.push(Bending::second_difference(
                    [shape.node(i, j), shape.node(i, j + 1), shape.node(i, j + 2)],
                    flexural[1][1] * cell[0] / cell[1].powi(3) * cells_at(i, columns),
                ));
            }
        }
    }
    Some(())
}
