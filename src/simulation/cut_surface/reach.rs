//! Which cells a surface that cuts links touches.

use glam::DVec3;

use super::super::surface_box::{NOWHERE, cells_of, corners_of};
use super::CutSurface;
use crate::cut_links::OutOfAir;

impl CutSurface {
    /// True if the cells of all links, those behind them, and those that lose the stress of boundary layers, lie in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        let [low, high] = self.reach;
        (0..3).all(|a| low[a] > first[a] as i32 && high[a] + 1 < end[a] as i32)
    }

    /// First cell and end of the box of cells whose populations the stage `bounce` may write, those that leave for a neighbour among them; `None` where nothing is cut.
    #[must_use]
    pub fn touched(&self) -> Option<[[i32; 3]; 2]> {
        let [low, high] = self.reach;
        (low[0] <= high[0]).then(|| [low.map(|place| place - 1), high.map(|place| place + 2)])
    }

    /// Least and largest places of these cells; [`NOWHERE`] if there are none.
    pub(super) fn find_reach(&self) -> [[i32; 3]; 2] {
        let both = |one: [[i32; 3]; 2], other: [[i32; 3]; 2]| {
            [
                std::array::from_fn(|a| one[0][a].min(other[0][a])),
                std::array::from_fn(|a| one[1][a].max(other[1][a])),
            ]
        };
        let of_links = self.links.reach().unwrap_or(NOWHERE);
        let changed = self.changed().1.iter().flatten();
        (changed.map(|change| [change.cell; 2])).fold(of_links, both)
    }

    /// Least and largest places of the cells that it touches.
    pub(in crate::simulation) const fn reach(&self) -> [[i32; 3]; 2] {
        self.reach
    }

    /// First cell and end of the cells that surfaces may touch: none beyond the faces of the air, nor what a box of finer cells exchanges with the lattice around it.
    pub(in crate::simulation) fn cells_for_surfaces(&self) -> [[i32; 3]; 2] {
        let kept = self.domain.kept as i32;
        [
            [kept; 3],
            self.domain.cells.map(|cells| cells as i32 - kept),
        ]
    }

    /// Takes the density excess on both faces of its first nodes, which a device has carried on.
    pub(in crate::simulation) fn take_face_pressures(&mut self, mut excess: Vec<[f64; 2]>) {
        excess.resize(self.positions.len(), [0.0; 2]);
        self.faces.go_on(excess);
    }

    /// Its nodes are at `positions` [cells] now; a device finds the links. What it touches is taken from the nodes, by a cell more than from the links at most.
    pub(in crate::simulation) fn move_to(&mut self, positions: &[DVec3]) -> Result<(), OutOfAir> {
        self.found = false;
        self.positions.copy_from_slice(positions);
        self.domain.holds(positions, &self.triangles)?;
        let nodes = self.triangles.iter().flatten();
        self.reach = cells_of(corners_of(nodes.map(|node| positions[*node as usize])));
        Ok(())
    }
}
