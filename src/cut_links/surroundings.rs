//! The cells around a cut link: what lies next to them, and which the mirror image of the one behind a wall is taken from ([`super::slide`]).

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;

use super::cell_states::CELLS_OF_AN_IMAGE;
use super::search::{CutAround, CutLink, CutLinks, Domain};
use super::slide::vector;
use crate::lattice::nest::CHANGED_BY_LAYERS;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS};

/// Length below which an image counts as lying on a cell's centre, to the fourth power [cells⁴].
const ON_A_CENTRE: f64 = 1e-3;

/// Cells from the one beside a wall to those whose velocities a model of the boundary layer takes. The first is two to three and a half cells off, so that the stress does not follow from
/// what it does to the first cell. The second tells the speed outside a layer that is thicker.
pub(super) const CELLS_OFF: [usize; 2] = [CHANGED_BY_LAYERS - 1, 5];

/// Free cells beyond the first that a wall needs before it for the air to slide.
const ROOM: usize = 2;

/// Cells off a wall, a near and a further one, and their distances from it [cells].
pub(super) type CellsOff = [([i32; 3], f64); 2];

/// What a cell may meet next.
#[derive(Debug, Clone, Copy)]
pub(super) enum Next {
    /// A cell of the air, or the one that it repeats.
    Cell([i32; 3]),
    /// A wall.
    Wall,
    /// The end of the air.
    End,
}

/// Links that are cut, and the air around them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) links: &'a CutLinks,
    pub(super) domain: &'a Domain,
}

/// A cell, and what is cut around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around {
    pub(super) cell: [i32; 3],
    pub(super) cut: CutAround,
    /// Its neighbours are all in the domain.
    inside: bool,
}

impl Around {
    #[inline]
    pub(super) fn new(air: &Surroundings<'_>, cell: [i32; 3]) -> Self {
        Self {
            cell,
            cut: air.links.cut_around(cell),
            inside: air.domain.is_inside(cell),
        }
    }

    /// The cell in a direction, whatever lies between; `None` where the air ends.
    #[inline]
    fn beside(&self, domain: &Domain, direction: usize) -> Option<[i32; 3]> {
        let c = DIRECTIONS[direction];
        let next = std::array::from_fn(|a| self.cell[a] + c[a]);
        if self.inside {
            Some(next)
        } else {
            domain.cell(next.map(i64::from))
        }
    }

    /// By direction, a bit of those that lead to a cell of the air, or stay.
    #[inline]
    fn free(&self, domain: &Domain) -> u32 {
        let open = !self.cut.directions();
        if self.inside {
            return open;
        }
        let leads = |direction: &usize| self.beside(domain, *direction).is_some();
        let lead = (0..DIRECTION_COUNT).filter(leads);
        open & lead.fold(0, |all, direction| all | 1 << direction)
    }

    /// What lies in a direction (not 0).
    #[inline]
    pub(super) fn next(&self, domain: &Domain, direction: usize) -> Next {
        match self.beside(domain, direction) {
            None => Next::End,
            Some(_) if self.cut.has(direction) => Next::Wall,
            Some(next) => Next::Cell(next),
        }
    }
}

impl Surroundings<'_> {
    /// Cells off a wall and their distances from it, straight `ahead` as far as that direction of the lattice leads, the [`straightest`] off the wall. They are fewer cells off where the way ends. It is `None` where other walls leave no room to slide. What is not `modelled` asks for that alone.
    pub(super) fn off(
        &self,
        (link, side): (&CutLink, usize),
        own: &Around,
        (away, ahead, modelled): (DVec3, usize, bool),
    ) -> Option<CellsOff> {
        // In a crease, or a gap of one cell.
        if own.cut.on_both_sides() {
            return None;
        }
        let off = |direction: usize| -vector(direction).dot(away);
        let mut at = *own;
        let mut height = link.distance(side) * -off(link.leaving(side));
        let mut found = [(at.cell, height); 2];
        let last = if modelled { CELLS_OFF[1] } else { ROOM };
        for done in 1..=last {
            match at.next(self.domain, ahead) {
                Next::Wall if done <= ROOM => return None,
                Next::Cell(next) => at = Around::new(self, next),
                Next::Wall | Next::End => break,
            }
            height += off(ahead);
            for (found, cells) in found.iter_mut().zip(CELLS_OFF) {
                if done <= cells {
                    *found = (at.cell, height);
                }
            }
        }
        Some(found)
    }

    /// The cells nearest to the mirror image of the cell behind a cut, among the side's own and its neighbours in the air, with their shares, and η.
    pub(super) fn cells_of_image(
        &self,
        (link, side): (&CutLink, usize),
        own: &Around,
        away: DVec3,
    ) -> ([(f64, [i32; 3]); CELLS_OF_AN_IMAGE], f64) {
        let d = vector(link.leaving(side));
        let across = d.dot(away);
        let height = (1.0 - link.distance(side)) * across;
        let image = d - away * (2.0 * height);
        let nearest = nearest(image, own.free(self.domain)).map(|direction| {
            let square = direction.map_or(f64::INFINITY, |direction| {
                (vector(direction) - image).length_squared()
            });
            (
                1.0 / (square * square + ON_A_CENTRE),
                direction.unwrap_or(0),
            )
        });
        let sum: f64 = nearest.iter().map(|(share, _)| share).sum();
        let lower = (nearest.iter())
            .map(|(share, direction)| share * vector(*direction).dot(away))
            .sum::<f64>()
            / sum;
        let of_cells = link.distance(side) * across - lower;
        let closer = if of_cells > height {
            height / of_cells
        } else {
            1.0
        };
        let cell = |direction| own.beside(self.domain, direction).unwrap_or(own.cell);
        let cells = nearest.map(|(share, direction)| (share / sum, cell(direction)));
        (cells, closer)
    }
}

/// The directions that lead nearest to a place beside a cell, of those that are `free`, a bit each; of equally near ones the first. `None` where there are not so many.
///
/// Without branches: which of them are nearest is as good as random.
#[inline]
fn nearest(place: DVec3, free: u32) -> [Option<usize>; CELLS_OF_AN_IMAGE] {
    /// Bits that number the directions; they take the place of the last ones of the square.
    const NUMBER: u64 = 31;
    let own = place.length_squared();
    let mut squares = [own; DIRECTION_COUNT];
    for pair in 0..DIRECTION_COUNT / 2 {
        let there = vector(2 * pair + 1);
        let (square, twice) = (own + there.length_squared(), 2.0 * there.dot(place));
        squares[2 * pair + 1] = (square - twice).max(0.0);
        squares[2 * pair + 2] = (square + twice).max(0.0);
    }
    let mut least = [u64::MAX; CELLS_OF_AN_IMAGE];
    for (direction, square) in squares.iter().enumerate() {
        // What is not negative has the order of its bits.
        let mut key = square.to_bits() & !NUMBER | direction as u64;
        if free >> direction & 1 == 0 {
            key = u64::MAX;
        }
        for held in &mut least {
            let nearer = key.min(*held);
            key = key.max(*held);
            *held = nearer;
        }
    }
    least.map(|key| (key != u64::MAX).then_some((key & NUMBER) as usize))
}

/// Direction (not 0) of the lattice nearest to a unit vector; of equally near ones the last.
pub(super) fn straightest(towards: DVec3) -> usize {
    let (mut best, mut nearest) = (0.0, 2);
    for pair in 0..DIRECTION_COUNT / 2 {
        // The first three lie along the axes.
        let over_length = if pair < 3 { 1.0 } else { FRAC_1_SQRT_2 };
        let along = vector(2 * pair + 1).dot(towards) * over_length;
        if along.abs() >= best {
            best = along.abs();
            nearest = 2 * pair + 1 + usize::from(along <= 0.0);
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As by sorting all of them, also where walls leave one or two.
    #[test]
    fn the_nearest_directions_are_found() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            (state >> 32) as f64 / 2.0_f64.powi(31) - 1.0
        };
        for k in 0..2000 {
            let place = DVec3::new(noise(), noise(), noise());
            let mut free = ((noise() + 1.0) * 2.0_f64.powi(18)) as u32 | 1;
            if k % 7 == 0 {
                free &= 0b1_0000_0001;
            }
            let mut all: Vec<usize> = (0..DIRECTION_COUNT)
                .filter(|d| free >> d & 1 == 1)
                .collect();
            let square = |d: &usize| (vector(*d) - place).length_squared();
            all.sort_by(|a, b| square(a).total_cmp(&square(b)));
            let wanted = std::array::from_fn(|k| all.get(k).copied());
            assert_eq!(nearest(place, free), wanted, "{place} {free:b}");
        }
        // As near as each other.
        assert_eq!(nearest(DVec3::ZERO, u32::MAX), [Some(0), Some(1), Some(2)]);
    }

    /// Every direction of the lattice is nearest to itself. The cube's diagonal is 35.3° from three of them, and nothing is farther; of those three the last counts.
    #[test]
    fn the_straightest_direction_is_near() {
        for direction in 1..DIRECTION_COUNT {
            assert_eq!(straightest(vector(direction).normalize()), direction);
        }
        let diagonal = DVec3::ONE.normalize();
        let last = (1..DIRECTION_COUNT).rfind(|d| vector(*d).normalize().dot(diagonal) > 0.8);
        assert_eq!(Some(straightest(diagonal)), last);
        let farthest = (2.0 / 3.0_f64).sqrt() - 1e-12;
        for i in 0..20 {
            for k in 0..40 {
                let (z, turn) = (-1.0 + 0.1 * f64::from(i) + 0.05, 0.157 * f64::from(k));
                let across = (1.0 - z * z).sqrt();
                let towards = DVec3::new(across * turn.cos(), across * turn.sin(), z);
                let own = vector(straightest(towards)).normalize().dot(towards);
                assert!(own >= farthest, "{towards} by {own}");
                let nearer =
                    (1..DIRECTION_COUNT).any(|d| vector(d).normalize().dot(towards) > own + 1e-12);
                assert!(!nearer, "{towards}");
            }
        }
    }
}
