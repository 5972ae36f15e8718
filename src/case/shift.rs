//! `resolution.shift_cells`: the same case, with all that stands in the air moved against the lattice by parts of a cell.

use glam::DVec3;

use super::air::Air;
use super::body::{Body, BodyKind};
use super::file::{File, Motion};
use super::problem::Problem;
use super::values::readable;

/// The key.
const KEY: &str = "resolution.shift_cells";

/// How far everything is moved [m]; zero without the key.
pub(super) fn check(file: &File, air: Option<&Air>) -> Result<DVec3, Problem> {
    let written = file.resolution.as_ref().and_then(|r| r.shift_cells);
    let (Some(cells), Some(air)) = (written, air) else {
        return Ok(DVec3::ZERO);
    };
    if file.structure.is_none() && file.bodies.is_empty() {
        return Err(Problem::new(
            KEY,
            format!("{KEY} has no effect: the case has neither a structure nor a body to move"),
            format!("remove {KEY}"),
        ));
    }
    if !cells.iter().all(|cell| cell.abs() < 1.0) {
        return Err(Problem::new(
            KEY,
            format!(
                "{KEY} = [{}] is out of range",
                cells.map(readable).join(", ")
            ),
            "each part of a cell lies between -1 and 1: further on the lattice is the same again",
        ));
    }
    Ok(DVec3::from_array(cells) * air.units.cell_size_m)
}

/// Moves a structure with what holds and guides it.
pub(super) fn move_structure(by_m: DVec3, body: &mut Body) {
    for place in &mut body.structure.positions_m {
        *place += by_m;
    }
    for guide in &mut body.structure.guides {
        guide.anchor_m += by_m;
    }
    match &mut body.kind {
        BodyKind::Plate(plate) => plate.held_edge_m += by_m,
        BodyKind::Wing(wing) => {
            for place in wing.tunnel.iter_mut().flat_map(|t| &mut t.designed_m) {
                *place += by_m;
            }
        }
        _ => {}
    }
}

/// The file with its rigid bodies moved, and the centres of their motions and the points of their moments with them.
pub(super) fn with_moved_bodies(file: &File, by_m: DVec3) -> File {
    let moved = |place: [f64; 3]| (DVec3::from_array(place) + by_m).to_array();
    let mut file = file.clone();
    for body in file.bodies.values_mut() {
        body.position_m = body.position_m.map(moved);
        let moment_point_m = body
            .reference
            .as_mut()
            .and_then(|r| r.moment_point_m.as_mut());
        let centre_m = body.motion.as_mut().and_then(Motion::centre_m);
        for point in moment_point_m.into_iter().chain(centre_m) {
            *point = moved(*point);
        }
    }
    file
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case::{Case, Choices, SHIPPED, parse};

    fn load(name: &str, changes: &[&str]) -> Case {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == name).unwrap();
        let choices = Choices {
            variant: None,
            overrides: changes.iter().map(|&change| change.to_owned()).collect(),
        };
        parse(name, text, Path::new("cases"), &choices).unwrap()
    }

    const SHIFT: &str = "resolution.shift_cells=[0.5, -0.25, 0.125]";

    fn assert_moved(before: &[DVec3], after: &[DVec3], by_m: DVec3) {
        assert_eq!(before.len(), after.len());
        for (a, b) in before.iter().zip(after) {
            assert!((*a + by_m).distance(*b) < 1e-12, "{a} {b} {by_m}");
        }
    }

    #[test]
    fn structures_move_with_what_holds_and_guides_them() {
        for name in ["flat-circular-tunnel", "flexible-plate", "parafoil-brake"] {
            let (before, after) = (load(name, &[]).scene, load(name, &[SHIFT]).scene);
            let by_m =
                DVec3::new(0.5, -0.25, 0.125) * after.air.as_ref().unwrap().units.cell_size_m;
            let [a, b] = [&before, &after].map(|scene| scene.body.as_ref().unwrap());
            assert_moved(&a.structure.positions_m, &b.structure.positions_m, by_m);
            let anchors = |body: &Body| -> Vec<DVec3> {
                body.structure.guides.iter().map(|g| g.anchor_m).collect()
            };
            assert_moved(&anchors(a), &anchors(b), by_m);
            if let (Some(a), Some(b)) = (a.plate(), b.plate()) {
                assert_moved(&[a.flat_tip_m()], &[b.flat_tip_m()], by_m);
            }
            if let (Some(a), Some(b)) = (a.wing(), b.wing()) {
                let [a, b] = [a, b].map(|wing| wing.tunnel.as_ref().unwrap());
                assert_moved(&a.designed_m, &b.designed_m, by_m);
            }
        }
    }

    #[test]
    fn bodies_move_with_the_centres_of_their_motions() {
        let turning = [
            "bodies.sphere.motion.constant_rotation={ axis = [0.0, 0.0, 1.0], rate_rad_s = 1e-3, centre_m = [0.45, 0.5, 0.5] }",
            "bodies.sphere.reference.moment_point_m=[0.4, 0.5, 0.5]",
        ];
        let before = load("sphere", &turning).scene;
        let after = load("sphere", &[turning[0], turning[1], SHIFT]).scene;
        let by_m = DVec3::new(0.5, -0.25, 0.125) * after.air.as_ref().unwrap().units.cell_size_m;
        let [a, b] = [&before, &after].map(|scene| &scene.rigid_bodies[0]);
        assert_moved(&a.surface.positions_m, &b.surface.positions_m, by_m);
        assert_moved(
            &[a.motion.centre_m, a.moment_point_m],
            &[b.motion.centre_m, b.moment_point_m],
            by_m,
        );
    }

    #[test]
    fn on_coarser_grids_the_structure_stays_in_its_place() {
        let case = load(
            "flat-circular-tunnel",
            &["steady.grid_sequence=[2.0]", SHIFT],
        );
        let [a, b] = [&case.scene, &case.coarser[0]].map(|scene| scene.body.as_ref().unwrap());
        assert_moved(
            &a.structure.positions_m,
            &b.structure.positions_m,
            DVec3::ZERO,
        );
    }

    #[test]
    fn whole_cells_and_empty_air_are_refused() {
        let refused = |name: &str, change: &str| {
            let (_, text) = SHIPPED.iter().find(|(known, _)| *known == name).unwrap();
            let choices = Choices {
                variant: None,
                overrides: vec![change.to_owned()],
            };
            parse(name, text, Path::new("cases"), &choices)
                .unwrap_err()
                .to_string()
        };
        let far = refused("sphere", "resolution.shift_cells=[0.0, 1.0, 0.0]");
        assert!(far.contains("out of range"), "{far}");
        let empty = refused("taylor-green", SHIFT);
        assert!(empty.contains("neither a structure nor a body"), "{empty}");
    }
}
