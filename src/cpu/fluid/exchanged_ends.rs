//! Cells at both ends of the rows of a box of finer cells, through which it exchanges states with the lattice around it
//! ([`crate::lattice::nest`]).
//!
//! Of a cache line of 16 cells two are of the shell, in all 19 arrays of every row. By themselves they took two thirds of an exchange; a sweep has
//! these lines at hand. It puts in place what has arrived just before it collides these cells. What leaves for the band it takes down when it has
//! collided a row.
//!
//! Until the sweep, populations of these cells are here alone. Single cells, checkpoints, extremes, eddy viscosities and images of cut links heed that
//! ([`ExchangedEnds::waiting_at`]). All else reads further from the faces, or in lattices without boxes.

use std::ops::Range;
use std::slice::ChunksMut;

use super::Stored;
use super::slabs::{self, Arrays};
use crate::lattice::grid::{Grid, LINE_BYTES};
use crate::lattice::nest::{BAND, Nest, SHELL};
use crate::lattice::operators::Populations;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, opposite};

/// Cells at each end of a row that arrive, or leave.
const WIDTH: usize = 2;

/// Populations at both ends of a row: by directions, lower end and upper end, cells.
pub(super) type EndsOfRow<P> = [[[P; WIDTH]; 2]; DIRECTION_COUNT];

/// Rows along x whose y and z lie in ranges.
#[derive(Debug, Clone)]
struct Rows([Range<usize>; 2]);

impl Rows {
    /// Those whose coarse cells are deeper than `depth` by y and z, and `beyond` fine rows around them.
    fn deeper(nest: &Nest, depth: i64, beyond: usize) -> Self {
        Self([1, 2].map(|axis| {
            let cells = 2 * nest.cells[axis];
            let margin = match nest.spans[axis] {
                true => 0,
                false => 2 * (depth + 1) as usize - beyond,
            };
            margin..cells.saturating_sub(margin)
        }))
    }

    #[inline(always)]
    fn hold(&self, y: usize, z: usize) -> bool {
        self.0[0].contains(&y) && self.0[1].contains(&z)
    }
}

/// Populations of the cells at both ends of rows, by rows (y fastest).
#[derive(Debug, Clone)]
pub(super) struct ExchangedEnds<P> {
    cells: [usize; 3],
    /// Of the shell, as they are about to be collided.
    arriving: Vec<EndsOfRow<P>>,
    arriving_rows: Rows,
    /// They are not in place yet.
    waiting: bool,
    /// What the cells next to the band have sent in its directions: populations of the band are found in the rows that they come from.
    leaving: Vec<EndsOfRow<P>>,
    leaving_rows: Rows,
    /// They belong to the lattice as it stands.
    taken_down: bool,
}

/// Which end of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Lower,
    Upper,
}

impl End {
    /// That of a line of coarse cells along y: `x` counts from the lower face.
    pub const fn of(x: i64) -> Self {
        match x {
            0 | 1 => Self::Lower,
            _ => Self::Upper,
        }
    }
}

impl<P: Stored> ExchangedEnds<P> {
    /// Of a box; `None` where rows go round, and have no ends.
    pub fn new(nest: &Nest) -> Option<Self> {
        if nest.spans[0] {
            return None;
        }
        let cells = nest.fine_cells();
        let rows = vec![EndsOfRow::<P>::default(); cells[1] * cells[2]];
        Some(Self {
            cells,
            arriving: rows.clone(),
            arriving_rows: Rows::deeper(nest, *SHELL.end(), 0),
            waiting: false,
            leaving: rows,
            leaving_rows: Rows::deeper(nest, *BAND.end(), 1),
            taken_down: false,
        })
    }

    /// Takes down what left for the band as the lattice stands, with the populations of its cells, unless a sweep has.
    pub fn take_down_from(&mut self, populations: impl Fn([usize; 3]) -> Populations<P::Real>) {
        if self.taken_down {
            return;
        }
        let [rows, planes] = self.leaving_rows.0.clone();
        let n = [1, 2].map(|a| self.cells[a] as i64);
        for (z, y) in planes.flat_map(|z| rows.clone().map(move |y| (z, y))) {
            let row = self.row(y, z);
            for (direction, c) in DIRECTIONS.iter().enumerate() {
                let y_to = (y as i64 + i64::from(c[1])).rem_euclid(n[0]) as usize;
                let z_to = (z as i64 + i64::from(c[2])).rem_euclid(n[1]) as usize;
                for end in [End::Lower, End::Upper] {
                    let first = self.place(end, 1);
                    self.leaving[row][direction][end as usize] =
                        [0, 1].map(|i| P::packed(populations([first + i, y_to, z_to])[direction]));
                }
            }
        }
        self.taken_down = true;
    }

    /// Number of a row.
    #[inline(always)]
    const fn row(&self, y: usize, z: usize) -> usize {
        y + self.cells[1] * z
    }

    /// x of the cells at an end whose populations arrive there, or lie in the band (`depth` 0 or 1).
    const fn place(&self, end: End, depth: usize) -> usize {
        match end {
            End::Lower => depth * WIDTH,
            End::Upper => self.cells[0] - (depth + 1) * WIDTH,
        }
    }

    /// Takes populations of the shell in two neighbouring columns of a plane along y, from `y` on, direction after direction, each `stride` long.
    /// They are put in place by the next sweep.
    #[inline(always)]
    pub fn arrive(
        plane: &mut [EndsOfRow<P>],
        end: End,
        y: usize,
        length: usize,
        populations: [&[P::Real]; 2],
        stride: usize,
    ) {
        for direction in 0..DIRECTION_COUNT {
            let [left, right] = populations.map(|side| &side[direction * stride..][..length]);
            for ((left, right), row) in left.iter().zip(right).zip(&mut plane[y..]) {
                row[direction][end as usize] = [*left, *right].map(P::packed);
            }
        }
    }

    /// What arrives, by planes.
    pub fn planes_that_arrive(&mut self) -> ChunksMut<'_, EndsOfRow<P>> {
        self.waiting = true;
        self.arriving.chunks_mut(self.cells[1])
    }

    /// Populations of the band in two neighbouring columns of `length` cells along y from (y, z) on, direction after direction, each `stride` long.
    #[inline(always)]
    pub fn read_band(
        &self,
        end: End,
        [y, z]: [i64; 2],
        length: usize,
        into: &mut [Vec<P::Real>; 2],
        stride: usize,
    ) {
        let [ny, nz] = [1, 2].map(|a| self.cells[a] as i64);
        let [left, right] = into;
        for (direction, c) in DIRECTIONS.iter().enumerate() {
            let left = &mut left[direction * stride..][..length];
            let right = &mut right[direction * stride..][..length];
            let z = (z - i64::from(c[2])).rem_euclid(nz) as usize;
            let mut row = (y - i64::from(c[1])).rem_euclid(ny) as usize;
            let plane = &self.leaving[self.row(0, z)..];
            for (left, right) in left.iter_mut().zip(right) {
                [*left, *right] = plane[row][direction][end as usize].map(P::unpacked);
                row = if row + 1 == self.cells[1] { 0 } else { row + 1 };
            }
        }
    }

    /// Populations that a cell has as soon as what arrives is in place; `None` where nothing waits.
    #[inline(always)]
    pub fn waiting_at(&self, [x, y, z]: [usize; 3]) -> Option<Populations<P::Real>> {
        if !self.waiting || !self.arriving_rows.hold(y, z) {
            return None;
        }
        [End::Lower, End::Upper].into_iter().find_map(|end| {
            let place = x.checked_sub(self.place(end, 0))?;
            (place < WIDTH).then(|| {
                let row = &self.arriving[self.row(y, z)];
                row.map(|ends| ends[end as usize][place].unpacked())
            })
        })
    }

    /// True if a cell, or one beside it, lies at an end of a row.
    #[inline(always)]
    pub fn is_near(&self, [x, ..]: [i32; 3]) -> bool {
        let x = i64::from(x);
        x <= WIDTH as i64 || x >= (self.cells[0] - WIDTH) as i64 - 1
    }

    /// What has arrived beside a cell in a direction, where it waits.
    #[inline(always)]
    pub fn waiting_beside(&self, cell: [i32; 3], direction: usize) -> Option<P::Real> {
        let c = DIRECTIONS[direction];
        let x = usize::try_from(cell[0] + c[0]).ok()?;
        let [y, z] = [1, 2].map(|a| (cell[a] + c[a]).rem_euclid(self.cells[a] as i32) as usize);
        Some(self.waiting_at([x, y, z])?[direction])
    }

    /// Cells whose populations wait.
    pub fn waiting_cells(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        let [rows, planes] = &self.arriving_rows.0;
        let planes = if self.waiting { planes.clone() } else { 0..0 };
        planes.flat_map(move |z| {
            rows.clone().flat_map(move |y| {
                [End::Lower, End::Upper]
                    .into_iter()
                    .flat_map(move |end| (0..WIDTH).map(move |i| [self.place(end, 0) + i, y, z]))
            })
        })
    }

    /// What each run of `planes` planes, the last of fewer, does in a step of the given parity.
    pub fn of_slabs(
        &mut self,
        grid: Grid,
        planes: usize,
        odd: bool,
    ) -> impl Iterator<Item = EndsOfSlab<'_, P>> {
        let arriving = (self.waiting).then_some((&self.arriving[..], &self.arriving_rows));
        let [_, ny, nz] = self.cells;
        let leaving_rows = &self.leaving_rows;
        let runs = self.leaving.chunks_mut(ny * planes);
        (0..).zip(runs).map(move |(number, run)| EndsOfSlab {
            grid,
            first_plane: number * planes,
            planes: planes.min(nz - number * planes),
            arriving,
            leaving: odd.then_some((run, leaving_rows)),
        })
    }

    /// After a step of the given parity.
    pub const fn stepped(&mut self, odd: bool) {
        self.waiting = false;
        self.taken_down = odd;
    }

    /// Forgets what waits and what was taken down: the lattice has other populations now.
    pub const fn forget(&mut self) {
        self.waiting = false;
        self.taken_down = false;
    }
}

/// What a run of planes of a sweep does at the ends of its rows.
pub(super) struct EndsOfSlab<'a, P> {
    grid: Grid,
    first_plane: usize,
    planes: usize,
    /// What is to be put in place, of all rows, and where.
    arriving: Option<(&'a [EndsOfRow<P>], &'a Rows)>,
    /// Where what leaves is taken down, of the run's rows.
    leaving: Option<(&'a mut [EndsOfRow<P>], &'a Rows)>,
}

impl<P: Stored> EndsOfSlab<'_, P> {
    /// y and z of a row of the run, and where it begins in the run's arrays.
    #[inline(always)]
    const fn row(&self, row: usize) -> ([usize; 2], usize) {
        let ny = self.grid.cells[1];
        let (y, plane) = (row % ny, row / ny);
        let start = slabs::lead::<P>() + y * self.grid.stride_y + plane * self.grid.stride_z;
        ([y, self.first_plane + plane], start)
    }

    /// Where a row is parted. Its upper end is put in place before the second part, one block before its turn where the row is long enough. With it
    /// goes the lower end of the next row. By then these lines were asked for. Earlier, they would be asked for out of order, and the CPU would lose
    /// the streams that it follows: a quarter of the sweep's speed on 96³ cells. Later, vectors would be read right after single values were
    /// written into them.
    #[inline(always)]
    pub const fn parts_of_row(&self) -> [Range<usize>; 2] {
        let nx = self.grid.cells[0];
        let block = LINE_BYTES / size_of::<P>();
        let parted = ((nx - WIDTH) / block * block).saturating_sub(block);
        [0..parted, parted..nx]
    }

    /// Before the first part of a row is collided, or the second.
    #[inline(always)]
    pub fn put_in_place_before(&self, arrays: &mut Arrays<'_, P>, row: usize, part: usize) {
        let Some((arriving, rows)) = self.arriving else {
            return;
        };
        if part == 0 {
            if row == 0 {
                self.put_in_place(arrays, arriving, rows, row, End::Lower);
            }
            return;
        }
        self.put_in_place(arrays, arriving, rows, row, End::Upper);
        if row + 1 < self.planes * self.grid.cells[1] {
            self.put_in_place(arrays, arriving, rows, row + 1, End::Lower);
        }
    }

    #[inline(always)]
    fn put_in_place(
        &self,
        arrays: &mut Arrays<'_, P>,
        arriving: &[EndsOfRow<P>],
        rows: &Rows,
        row: usize,
        end: End,
    ) {
        let ([y, z], start) = self.row(row);
        if !rows.hold(y, z) {
            return;
        }
        let [nx, ny, _] = self.grid.cells;
        let first = match end {
            End::Lower => start,
            End::Upper => start + nx - WIDTH,
        };
        for (array, ends) in arrays.iter_mut().zip(&arriving[y + ny * z]) {
            if let Some(cells) = array[first..].first_chunk_mut() {
                *cells = ends[end as usize];
            }
        }
    }

    /// After a row of the run was collided.
    #[inline(always)]
    pub fn take_down(&mut self, arrays: &Arrays<'_, P>, row: usize) {
        let ([y, z], start) = self.row(row);
        let Some((leaving, rows)) = &mut self.leaving else {
            return;
        };
        if !rows.hold(y, z) {
            return;
        }
        let nx = self.grid.cells[0];
        for (direction, ends) in leaving[row].iter_mut().enumerate() {
            // What was sent in a direction lies where its opposite is read, at the cell that sent it.
            let array = &arrays[opposite(direction)][start..start + nx];
            let from = |place: usize| (place as i32 - DIRECTIONS[direction][0]) as usize;
            for (end, first) in ends.iter_mut().zip([from(WIDTH), from(nx - 2 * WIDTH)]) {
                if let Some(cells) = array[first..].first_chunk() {
                    *end = *cells;
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "exchanged_ends_tests.rs"]
mod tests;
