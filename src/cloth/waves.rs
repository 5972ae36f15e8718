//! How far elastic waves get: what decides how stiff an implicit step is.

use super::Structure;

impl Structure {
    /// Elements that a stretching wave crosses in a time step [s]: ½ dt √(Σk/m) of the middlemost free node, Σk the stiffness of the
    /// taut elements that meet there [N/m]. On a regular sheet this is dt √(C₁₁/ρ) over the mesh size. Zero without elastic elements.
    #[must_use]
    pub fn elements_crossed(&self, time_step_s: f64) -> f64 {
        let mut stiffness = vec![0.0; self.node_count()];
        if let Some(laws) = self.laws() {
            for triangle in &self.triangles {
                let law = laws.of(triangle).stiffness();
                let along = law[0][0].max(law[1][1]);
                // A linear triangle resists the motion of a corner by C l²/4A, l the opposite edge.
                let shares = triangle.nodes.iter().zip(triangle.rest_squares_m2);
                for (&node, square) in shares {
                    stiffness[node as usize] += along * square / (4.0 * triangle.rest_area_m2);
                }
            }
        }
        for spring in &self.springs {
            for node in spring.nodes {
                stiffness[node as usize] += spring.stiffness_n_m;
            }
        }
        for cable in &self.cables {
            for node in cable.nodes {
                stiffness[node as usize] +=
                    self.cable_laws[cable.law as usize].initial_stiffness_n() / cable.rest_length_m;
            }
        }
        let mut squares: Vec<f64> = (0..self.node_count())
            .filter(|&i| !self.held[i] && self.masses_kg[i] > 0.0)
            .map(|i| stiffness[i] / self.masses_kg[i])
            .collect();
        if squares.is_empty() {
            return 0.0;
        }
        let middle = squares.len() / 2;
        let (_, square, _) = squares.select_nth_unstable_by(middle, f64::total_cmp);
        0.5 * time_step_s * square.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::cloth::{Spring, Structure};

    /// A chain of springs k and masses m, each a distance h apart: the wave goes at h √(k/m).
    #[test]
    fn a_chain_passes_on_its_wave() {
        let (k, m) = (200.0, 0.5);
        let structure = Structure {
            positions_m: (0..9).map(|i| DVec3::X * f64::from(i)).collect(),
            masses_kg: vec![m; 9],
            held: vec![false; 9],
            springs: (0..8)
                .map(|i| Spring {
                    nodes: [i, i + 1],
                    rest_length_m: 1.0,
                    stiffness_n_m: k,
                    compressive_stiffness_n_m: k,
                })
                .collect(),
            ..Structure::default()
        };
        // Σk of an inner node is 2k.
        let expected = 0.5 * 0.1 * (2.0 * k / m).sqrt();
        assert!((structure.elements_crossed(0.1) - expected).abs() < 1e-12);
        assert_eq!(Structure::default().elements_crossed(0.1), 0.0);
    }
}
