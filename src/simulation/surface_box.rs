//! Boxes around surfaces that cut links, in cells.

use glam::DVec3;

use crate::cut_links::search::GENERAL_POSITION;

/// Least and largest places of no cell.
pub(super) const NOWHERE: [[i32; 3]; 2] = [[i32::MAX; 3], [i32::MIN + 1; 3]];

/// Corners of the box around places [cells].
pub(super) fn corners_of(places: impl IntoIterator<Item = DVec3>) -> [DVec3; 2] {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let with = |[low, high]: [DVec3; 2], place: DVec3| [low.min(place), high.max(place)];
    places.into_iter().fold(nothing, with)
}

/// Least and largest places of the cells whose links a surface between two corners may cut.
pub(super) fn cells_of([low, high]: [DVec3; 2]) -> [[i32; 3]; 2] {
    let [low, high] = [low, high].map(|corner| (corner + GENERAL_POSITION).to_array());
    [
        low.map(|place| place.floor() as i32),
        high.map(|place| place.ceil() as i32),
    ]
}

/// First cell and size of a box of cells, with so many cells of room around it, in a lattice of `cells`.
pub(super) fn within(
    [low, high]: [[i32; 3]; 2],
    room: i32,
    cells: [usize; 3],
) -> ([i32; 3], [u32; 3]) {
    let first: [i32; 3] = std::array::from_fn(|a| (low[a] - room).clamp(0, cells[a] as i32 - 1));
    let size = std::array::from_fn(|a| {
        let end = (high[a] + room + 1).clamp(first[a] + 1, cells[a] as i32);
        (end - first[a]) as u32
    });
    (first, size)
}
