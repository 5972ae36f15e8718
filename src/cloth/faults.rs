//! What makes a structure impossible to solve.

use super::Structure;

/// The first fault found, with the number of the node or element, from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A position is not finite.
    #[error("node {0} has no finite position")]
    NotFinite(usize),
    /// A mass is negative or not finite.
    #[error("node {0} has a mass that is negative or not finite")]
    Mass(usize),
    /// Nothing holds a free node: neither an element nor, in motion, inertia.
    #[error(
        "node {0} is not held, belongs to no element and has no inertia: nothing says where it is"
    )]
    Loose(usize),
    /// A cable segment without rest length.
    #[error("cable segment {0} has a rest length that is not positive")]
    RestLength(usize),
    /// Both ends of a cable segment or spring are the same node.
    #[error("{0} {1} begins and ends at the same node")]
    OneEnd(&'static str, usize),
}

impl Structure {
    /// Looks for what would keep a solve from making sense; `moves`: with inertia, not the static limit alone.
    pub fn check(&self, moves: bool) -> Result<(), Fault> {
        let mut has_element = vec![false; self.node_count()];
        let triangles = self.triangles.iter().flat_map(|t| t.nodes);
        let carried = triangles.filter(|_| self.membrane.is_some());
        let lines = self.cables.iter().flat_map(|c| c.nodes);
        let lines = lines.chain(self.springs.iter().flat_map(|s| s.nodes));
        for node in carried
            .chain(lines)
            .chain(self.bendings.iter().flat_map(|b| b.nodes))
            .chain(self.curvatures.iter().flat_map(|b| b.nodes))
            .chain(self.guides.iter().map(|g| g.node))
        {
            has_element[node as usize] = true;
        }
        for node in 0..self.node_count() {
            if !self.positions_m[node].is_finite() {
                return Err(Fault::NotFinite(node));
            }
            let mass = self.masses_kg[node];
            if !(mass >= 0.0 && mass.is_finite()) {
                return Err(Fault::Mass(node));
            }
            let inert = moves && mass > 0.0;
            if !(has_element[node] || self.held[node] || inert) {
                return Err(Fault::Loose(node));
            }
        }
        for (index, spring) in self.springs.iter().enumerate() {
            if spring.nodes[0] == spring.nodes[1] {
                return Err(Fault::OneEnd("spring", index));
            }
        }
        for (index, cable) in self.cables.iter().enumerate() {
            if cable.nodes[0] == cable.nodes[1] {
                return Err(Fault::OneEnd("cable segment", index));
            }
            if !(cable.rest_length_m > 0.0 && cable.rest_length_m.is_finite()) {
                return Err(Fault::RestLength(index));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::cloth::CableSegment;
    use crate::frame::CableKind;

    #[test]
    fn every_fault_is_told_with_its_number() {
        let sound = Structure {
            positions_m: vec![DVec3::ZERO, DVec3::X],
            masses_kg: vec![1.0, 1.0],
            held: vec![true, false],
            cables: vec![CableSegment {
                nodes: [0, 1],
                rest_length_m: 1.0,
                law: 0,
                damping_n_s: 0.0,
                breaking_load_n: None,
                drag: None,
                kind: CableKind::Cable,
            }],
            ..Structure::default()
        };
        assert_eq!(sound.check(false), Ok(()));
        let broken = |change: fn(&mut Structure)| {
            let mut structure = sound.clone();
            change(&mut structure);
            [false, true].map(|moves| structure.check(moves).err())
        };
        let nan = broken(|s| s.positions_m[1].y = f64::NAN);
        assert_eq!(nan, [Some(Fault::NotFinite(1)); 2]);
        assert_eq!(broken(|s| s.masses_kg[1] = -1.0), [Some(Fault::Mass(1)); 2]);
        assert_eq!(broken(|s| s.cables.clear()), [Some(Fault::Loose(1)), None]);
        let light = broken(|s| {
            s.cables.clear();
            s.masses_kg[1] = 0.0;
        });
        assert_eq!(light, [Some(Fault::Loose(1)); 2]);
        let short = broken(|s| s.cables[0].rest_length_m = 0.0);
        assert_eq!(short, [Some(Fault::RestLength(0)); 2]);
        let loop_ = broken(|s| s.cables[0].nodes = [1, 1]);
        assert_eq!(loop_, [Some(Fault::OneEnd("cable segment", 0)); 2]);
    }
}
