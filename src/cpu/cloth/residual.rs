//! What the residual stiffness of tension-only fabric carries.

use glam::DVec3;

use super::nodal_forces::elastic_gradient;
use super::{Cloth, Pulls};
use crate::cloth::elements::EDGES;

impl Cloth {
    /// Σ|rᵢ|/Σ|fᵢ| over all nodes: r the forces of the tensions that the residual stiffness alone makes
    /// ([`crate::fabric::membrane::Membrane::residual_tension`]), f those of all elements, which in balance are the loads of free nodes and the
    /// reactions of held ones. `None` without tension-only membranes; NaN where nothing pulls.
    #[must_use]
    pub fn residual_load_share(&self) -> Option<f64> {
        let structure = &self.structure;
        let laws = structure.laws().filter(|_| structure.is_tension_only())?;
        let positions = &self.positions_m;
        let mut residual = vec![DVec3::ZERO; structure.node_count()];
        for triangle in &structure.triangles {
            let edges = triangle.edge_vectors(positions);
            let tension = laws.of(triangle).residual_tension(&triangle.strain(&edges));
            for (i, [from, to]) in EDGES.into_iter().enumerate() {
                let rows = triangle.strain_from_squares.iter().zip(tension);
                let pull: f64 = rows.map(|(row, tension)| row[i] * tension).sum();
                let force = edges[i] * (2.0 * triangle.rest_area_m2 * pull);
                residual[triangle.nodes[to] as usize] += force;
                residual[triangle.nodes[from] as usize] -= force;
            }
        }
        let mut forces = vec![DVec3::ZERO; structure.node_count()];
        let gather = &self.prepared.gather;
        elastic_gradient(
            structure,
            gather,
            positions,
            &mut Pulls::default(),
            &mut forces,
        );
        let sum = |forces: &[DVec3]| forces.iter().map(|force| force.length()).sum::<f64>();
        Some(sum(&residual) / sum(&forces))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::{Structure, Triangle};
    use crate::fabric::membrane::Membrane;

    /// One triangle, pushed together along x and stretched along y: the residual forces are r times those of a sheet that pushes.
    fn squeezed(residual: f64) -> Cloth {
        let rest = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(glam::DVec2::from_array);
        let stiffness = [[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 500.0]];
        let structure = Structure {
            positions_m: rest.map(|p| p.extend(0.0)).to_vec(),
            masses_kg: vec![1.0; 3],
            held: vec![false; 3],
            triangles: Triangle::new([0, 1, 2], rest).into_iter().collect(),
            membrane: Some(Membrane::new(stiffness, residual)),
            ..Structure::default()
        };
        let mut cloth = Cloth::new(structure);
        for x in &mut cloth.positions_m {
            *x *= DVec3::new(0.9, 1.1, 1.0);
        }
        cloth
    }

    #[test]
    fn the_share_is_that_of_the_forces() {
        // Strains −0.095 and 0.105; each pulls two nodes with ½ · 1e3 · strain · stretch.
        let (pushed, pulled): (f64, f64) = (0.095 * 0.9, 0.105 * 1.1);
        for residual in [1e-3_f64, 1e-2, 0.05] {
            let r = residual * pushed;
            // The corner at the right angle feels both.
            let expected = 2.0 * r / (r + pulled + r.hypot(pulled));
            let share = squeezed(residual).residual_load_share().unwrap();
            assert!((share / expected - 1.0).abs() < 1e-12, "{share} {expected}");
        }
        assert_eq!(squeezed(0.0).residual_load_share(), Some(0.0));
        // What is meant to push is not judged.
        assert_eq!(squeezed(1.0).residual_load_share(), None);
    }
}
