//! The tunnel, and the place in it, that a case leaves out: large enough for what stands in the wind, which stands in the middle of the section.
//!
//! Distances are in nominal diameters D_0 of a canopy, or in the largest extent of a rigid body. What they are from: drag of a rigid hemispherical
//! shell in tunnels of growing length and width (docs/results/2026-11-24-quiet-and-stable-air.md).

use std::borrow::Cow;

use super::file::{Around, File, Refinement, Structure};
use super::problem::Problem;
use super::usual;
use super::values::absent;

/// Room that a tunnel leaves.
struct Room {
    /// From the inlet to the middle of what stands in the wind, at least.
    upstream: f64,
    /// From there to the outlet.
    downstream: f64,
    /// Width and height of the tunnel.
    width: f64,
}

/// Of cells that are all alike.
const ALIKE: Room = Room {
    upstream: 2.5,
    downstream: 5.5,
    width: 4.0,
};

/// With boxes of finer cells around what stands in the wind, where far cells cost little: S_0 is 2.2 % of the section.
const WITH_BOXES: Room = Room {
    upstream: 3.0,
    downstream: 6.5,
    width: 6.0,
};

/// From the inlet to the lower end of lines and riser, at least.
const BEFORE_LINES: f64 = 0.3;

/// Of an inflated canopy: radius of its skirt, and from there to its middle.
const SKIRT_RADIUS: f64 = 0.34;
const HALF_HEIGHT: f64 = 0.15;

/// What stands in the wind, as far as its tunnel is concerned.
struct Standing {
    /// Key of its place.
    key: String,
    /// Its place, if it is written [m].
    place_m: Option<[f64; 3]>,
    /// D_0, or the largest extent [m].
    diameter_m: f64,
    /// From its place to its middle, along x [m].
    reach_m: f64,
    /// Length of what lies before its place [m].
    before_m: f64,
}

impl Standing {
    /// The drawn canopy, or the only rigid body, if its size is known.
    fn of(file: &mut File) -> Option<Self> {
        let lines = file.lines.as_ref().map_or([0.0; 2], |lines| {
            let riser_m = lines.riser_length_m.unwrap_or(0.0);
            let joined = lines.riser_count.is_some_and(|count| count > 1);
            let above_m = if joined { riser_m } else { 0.0 };
            [lines.length_m + above_m, riser_m - above_m]
        });
        if let Some(structure) = &mut file.structure {
            let canopy = structure.drawn_canopy()?;
            let [line_m, riser_m] = lines;
            let diameter_m = canopy.diameter_m?;
            let across = line_m.powi(2) - (SKIRT_RADIUS * diameter_m).powi(2);
            return Some(Self {
                key: format!("structure.{}.confluence_m", canopy.name),
                place_m: *canopy.confluence_m,
                diameter_m,
                reach_m: across.max(0.0).sqrt() + HALF_HEIGHT * diameter_m,
                before_m: riser_m,
            });
        }
        let mut bodies = file.bodies.iter();
        let (Some((name, body)), None) = (bodies.next(), bodies.next()) else {
            return None;
        };
        Some(Self {
            key: format!("bodies.{name}.position_m"),
            place_m: body.position_m,
            diameter_m: body.extent_m()?,
            reach_m: 0.0,
            before_m: 0.0,
        })
    }

    /// From the inlet to its place, where that is left out [m].
    fn usual_distance_m(&self, room: &Room) -> f64 {
        let of_middle = room.upstream * self.diameter_m - self.reach_m;
        of_middle.max(BEFORE_LINES * self.diameter_m + self.before_m)
    }
}

/// The file with the size of its tunnel and the place of what stands in it, as far as they follow from the rest. What does not is refused where it is
/// read.
pub(super) fn complete(file: &File) -> Cow<'_, File> {
    let Some(air) = &file.air else {
        return Cow::Borrowed(file);
    };
    let written_m = match (&air.wind_tunnel, &air.descent) {
        (Some(tunnel), None) => tunnel.size_m,
        (None, Some(descent)) => descent.size_m,
        _ => return Cow::Borrowed(file),
    };
    let mut completed = file.clone();
    let Some(one) = Standing::of(&mut completed) else {
        return Cow::Borrowed(file);
    };
    if written_m.is_some() && one.place_m.is_some() {
        return Cow::Borrowed(file);
    }
    let room = &refined(&mut completed, written_m.is_none());
    let place_m = one.place_m.unwrap_or_else(|| {
        let [width, height] =
            written_m.map_or([room.width * one.diameter_m; 2], |size| [size[1], size[2]]);
        let place = [one.usual_distance_m(room), 0.5 * width, 0.5 * height];
        usual::noted(one.key.as_str(), place)
    });
    if let (None, Some(air)) = (written_m, completed.air.as_mut()) {
        let length = place_m[0] + one.reach_m + room.downstream * one.diameter_m;
        let size = [length, 2.0 * place_m[1], 2.0 * place_m[2]];
        match (&mut air.wind_tunnel, &mut air.descent) {
            (Some(tunnel), _) => {
                tunnel.size_m = Some(usual::noted("air.wind_tunnel.size_m", size));
            }
            (None, Some(descent)) => {
                descent.size_m = Some(usual::noted("air.descent.size_m", size));
            }
            (None, None) => {}
        }
    }
    let canopy = completed
        .structure
        .as_mut()
        .and_then(Structure::drawn_canopy);
    match (canopy, completed.bodies.values_mut().next()) {
        (Some(canopy), _) => *canopy.confluence_m = Some(place_m),
        (None, Some(body)) => body.position_m = Some(place_m),
        (None, None) => {}
    }
    Cow::Owned(completed)
}

/// The room that its tunnel leaves; a file that leaves out the tunnel's size has boxes of finer cells, unless it says otherwise or its air cannot
/// have them.
fn refined(file: &mut File, finds_size: bool) -> Room {
    let plain =
        (file.resolution.as_ref()).is_some_and(|resolution| resolution.operator.is_recursive());
    let Some(air) = &mut file.air else {
        return ALIKE;
    };
    if finds_size && plain && air.refinement.is_none() {
        usual::noted("air.refinement.around", Around::Structure);
        air.refinement = Some(Refinement {
            around: Some(Around::Structure),
            ..Refinement::default()
        });
    }
    match &air.refinement {
        Some(boxes) if boxes.around != Some(Around::Nothing) => WITH_BOXES,
        _ => ALIKE,
    }
}

/// A size that is left out, and does not follow from what stands in the wind.
pub(super) fn unknown_size(key: &str) -> Problem {
    absent(
        key,
        "a tunnel finds its size only around a drawn canopy, or a single sphere, disk, plate or cylinder",
    )
}

/// A place that is left out, and does not follow from the tunnel.
pub(super) fn unknown_place(key: &str) -> Problem {
    absent(
        key,
        "only a drawn canopy, or a single sphere, disk, plate or cylinder in a tunnel finds its place by itself",
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::case::{Case, Choices, SHIPPED, parse};

    fn load(name: &str, changes: &[&str]) -> Result<Case, String> {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == name).unwrap();
        let choices = Choices {
            variant: None,
            overrides: changes.iter().map(|&change| change.to_owned()).collect(),
        };
        parse(name, text, Path::new("cases"), &choices).map_err(|error| error.to_string())
    }

    const NO_SIZE: &str = "air.wind_tunnel.size_m=absent";
    const NO_CONFLUENCE: &str = "structure.flat_circular.confluence_m=absent";

    /// Distances from the middle of the fabric, as it is drawn, to the faces of the box: x, y, z from the first cell and to the last [m].
    fn distances_m(case: &Case) -> [[f64; 2]; 3] {
        let air = case.scene.air.as_ref().unwrap();
        let structure = &case.scene.body.as_ref().unwrap().structure;
        let places = &structure.positions_m;
        std::array::from_fn(|a| {
            let middle = places.iter().map(|p| p[a]).sum::<f64>() / places.len() as f64;
            let size = air.cells[a] as f64 * air.units.cell_size_m;
            [middle, size - middle]
        })
    }

    #[test]
    fn a_canopy_without_a_tunnel_has_room_on_all_sides() {
        const ALIKE: &str = "air.refinement={around=\"nothing\"}";
        for changes in [&[NO_SIZE, NO_CONFLUENCE, ALIKE][..], &[NO_SIZE, ALIKE]] {
            let case = load("flat-circular-tunnel", changes).unwrap();
            let [x, y, z] = distances_m(&case);
            assert!(x[0] > 1.0 && x[1] > 4.5, "{x:?}");
            for side in [y, z] {
                assert!((side[0] - side[1]).abs() < 0.05, "{side:?}");
            }
            // Where a place is written, the section is around it.
            let half = if changes.len() == 2 { 2.991 } else { 1.993 };
            assert!((y[0] - half).abs() < 0.05, "{y:?}");
            let shape = if changes.len() == 2 { 6.0 } else { 4.0 };
            let air = case.scene.air.as_ref().unwrap();
            assert_eq!(air.cells[1], (24.0 * shape) as usize);
        }
    }

    #[test]
    fn a_place_is_found_in_a_tunnel_that_is_written() {
        let case = load("flat-circular-tunnel", &[NO_CONFLUENCE]).unwrap();
        let [_, y, z] = distances_m(&case);
        assert!((y[0] - 2.991).abs() < 0.05 && (z[0] - 2.991).abs() < 0.05);
        let sphere = load("sphere", &["bodies.sphere.position_m=absent", NO_SIZE]).unwrap();
        let air = sphere.scene.air.as_ref().unwrap();
        let body = &sphere.scene.rigid_bodies[0];
        let cells = air.units.cell_size_m / body.reference_length_m;
        assert!((air.cells[1] as f64 * cells - super::WITH_BOXES.width).abs() < 0.3);
        assert!(air.depth() > 0);
    }

    #[test]
    fn what_does_not_follow_is_refused() {
        let told = load("hemispherical-mesh", &[NO_SIZE]).unwrap_err();
        assert!(told.contains("size_m"), "{told}");
        let told = load("taylor-green", &["air.taylor_green.side_m=absent"]).unwrap_err();
        assert!(!told.contains("size_m"), "{told}");
    }
}
