//! Rigid bodies whose surfaces cut the lattice: where their nodes are, and which of them stand.

use std::ops::Range;

use glam::DVec3;

use crate::rigid::PrescribedMotion;

/// A rigid body's part of the surface.
#[derive(Debug)]
pub(super) struct Body {
    pub motion: PrescribedMotion,
    /// Places of its nodes before it moves [m].
    pub positions_m: Vec<DVec3>,
    pub moment_point_m: DVec3,
    /// Its nodes among all.
    pub nodes: Range<usize>,
}

/// Puts the nodes of bodies where they are at `time_s`; `lattice` converts from metres.
pub(super) fn place(
    bodies: &[Body],
    time_s: f64,
    lattice: impl Fn(DVec3) -> DVec3,
    positions: &mut [DVec3],
) {
    for body in bodies {
        let placement = body.motion.at(time_s);
        let nodes = &mut positions[body.nodes.clone()];
        for (position, &place_m) in nodes.iter_mut().zip(&body.positions_m) {
            *position = lattice(placement.position_m(place_m));
        }
    }
}

/// Triangles of bodies that do not move and have nothing else within the box around them; those of bodies begin at `first`.
pub(super) fn standing(
    bodies: &[Body],
    body_of: &[u32],
    first: usize,
    positions: &[DVec3],
) -> Vec<Range<usize>> {
    let is_alone = |body: &Body| {
        let own = &positions[body.nodes.clone()];
        let (low, high) = own.iter().fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(low, high), &position| (low.min(position), high.max(position)),
        );
        let is_within = |position: &DVec3| position.cmpge(low).all() && position.cmple(high).all();
        let mut others = positions[..body.nodes.start]
            .iter()
            .chain(&positions[body.nodes.end..]);
        !others.any(is_within)
    };
    (0..)
        .zip(bodies)
        .filter(|(_, body)| !body.motion.moves() && is_alone(body))
        .map(|(number, _)| {
            let start = body_of.partition_point(|of| *of < number);
            let end = body_of.partition_point(|of| *of <= number);
            first + start..first + end
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind three triangles of fabric stand a body alone, one with a node of the fabric in it, and one that turns.
    #[test]
    fn those_alone_and_at_rest_stand() {
        let node = |place: f64| DVec3::splat(place);
        let positions = [5.5, 0.0, 1.0, 5.0, 6.0, 8.0, 9.0].map(node);
        let body = |nodes: Range<usize>, motion: PrescribedMotion| Body {
            motion,
            positions_m: positions[nodes.clone()].to_vec(),
            moment_point_m: DVec3::ZERO,
            nodes,
        };
        let turns = PrescribedMotion {
            motion: crate::rigid::Motion::ConstantRotation {
                rate_rad_s: 1.0,
                rise_s: 0.0,
            },
            ..PrescribedMotion::held()
        };
        let bodies = [
            body(1..3, PrescribedMotion::held()),
            body(3..5, PrescribedMotion::held()),
            body(5..7, turns),
        ];
        let stand = standing(&bodies, &[0, 0, 1, 2, 2], 3, &positions);
        assert!(stand.iter().eq([&(3..5)]), "{stand:?}");
        let apart = [4.5, 0.0, 1.0, 5.0, 6.0, 8.0, 9.0].map(node);
        let stand = standing(&bodies, &[0, 0, 1, 2, 2], 3, &apart);
        assert_eq!(stand, [3..5, 5..6]);
    }
}
