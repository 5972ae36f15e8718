use super::*;
use crate::checkpoint::sections;
use crate::cpu::fluid::transfer::{Tie, take_down_ends};
use crate::cpu::fluid::{BodyForce, Fluid, ForcedCells};
use crate::lattice::Operator;
use crate::lattice::grid::Setup;

/// Air that repeats on all sides, with a velocity that differs from cell to cell.
fn air<P: Stored>(cells: [usize; 3], relaxation_time: f64) -> Fluid<P> {
    let setup = Setup::periodic(cells, relaxation_time, Operator::StabilisedRegularised);
    let uneven = |cell: [usize; 3]| {
        let [x, y, z] = cell.map(|c| c as f64);
        let wave = |phase: f64| 0.03 * (0.9 * x + 1.3 * y + 0.7 * z + phase).sin();
        (0.01 * wave(3.0), [0.05 + wave(0.0), wave(1.0), wave(2.0)])
    };
    Fluid::new(setup, Some(&uneven))
}

/// A box that stands at the time of the lattice around it, after a whole step of both.
fn exchanged<P: Stored>(nest: Nest) -> Fluid<P> {
    let outer = [0, 1, 2].map(|a| nest.cells[a] + if nest.spans[a] { 0 } else { 8 });
    let (mut coarse, mut fine) = (air(outer, 0.51), air(nest.fine_cells(), 0.52));
    let mut tie = Tie::new(nest, &coarse);
    tie.exchange(&mut coarse, &mut fine);
    for _ in 0..2 {
        fine.collide_stream(&BodyForce::default());
    }
    coarse.collide_stream(&BodyForce::default());
    tie.exchange(&mut coarse, &mut fine);
    fine
}

/// Rows of one to four cache lines; sides that the box ends before, and such as it spans.
fn nests() -> [Nest; 5] {
    [
        ([8, 7, 6], [false; 3]),
        ([19, 6, 7], [false, false, true]),
        ([25, 6, 8], [false, true, false]),
        ([12, 6, 5], [false, true, true]),
        ([5, 5, 5], [false; 3]),
    ]
    .map(|(cells, spans)| Nest {
        first: spans.map(|spans| if spans { 0 } else { 4 }),
        cells,
        spans,
    })
}

fn saved<P: Stored>(fluid: &Fluid<P>) -> Vec<u8> {
    sections(|out| fluid.save(out)).unwrap()
}

/// The same with what waits in its place.
fn placed<P: Stored>(waiting: &Fluid<P>, nest: &Nest) -> Fluid<P> {
    let mut placed = waiting.clone();
    let ends = placed.exchanged_ends.take().unwrap();
    let cells: Vec<[usize; 3]> = ends.waiting_cells().collect();
    let inner = [1, 2].map(|a| {
        let all = 2 * nest.cells[a];
        if nest.spans[a] { all } else { all - 4 }
    });
    assert_eq!(cells.len(), 4 * inner[0] * inner[1]);
    for cell in cells {
        let populations = ends.waiting_at(cell).unwrap();
        let index = placed.grid.index(cell.map(|c| c as i64));
        assert!(
            placed.gather(cell) != populations,
            "nothing arrived at {cell:?}"
        );
        for (direction, population) in populations.into_iter().enumerate() {
            let (array, element) = placed.grid.slot(index, direction, placed.odd);
            placed.populations[array][element] = P::packed(population);
        }
    }
    placed
}

fn counts_as_in_its_place<P: Stored>() {
    for nest in nests() {
        let mut waiting = exchanged::<P>(nest);
        let mut placed = placed(&waiting, &nest);
        let [nx, ny, nz] = nest.fine_cells();
        assert_eq!(waiting.macroscopic(), placed.macroscopic());
        assert_eq!(waiting.stresses(), placed.stresses());
        assert_eq!(waiting.mass_and_energy(), placed.mass_and_energy());
        let farthest = |fluid: &Fluid<P>| format!("{:?}", fluid.extremes([0; 3], [nx, ny, nz]));
        assert_eq!(farthest(&waiting), farthest(&placed));
        // Cells off the faces that images may be taken from.
        let cells: Vec<[i32; 3]> = (1..nx - 1)
            .flat_map(|x| (1..ny - 1).map(move |y| [x, y, nz / 2].map(|c| c as i32)))
            .collect();
        let left = |fluid: &Fluid<P>| {
            let mut leaving = Vec::new();
            fluid.read_images(&cells, &mut leaving);
            leaving
        };
        assert_eq!(left(&waiting), left(&placed));
        assert_eq!(saved(&waiting), saved(&placed));
        // A force on both parts of a row.
        let row = (ny / 2 + nz / 2 * ny) as u32;
        let x = [3, 4, nx as u32 - 5];
        let force = BodyForce {
            acceleration: None,
            cells: ForcedCells {
                rows: &[(row, 0, 3)],
                x: &x,
                force: &[[1e-3, 2e-3, -1e-3], [0.0, 1e-3, 0.0], [2e-3, 0.0, 1e-3]],
            },
        };
        for _ in 0..3 {
            waiting.collide_stream(&force);
            placed.collide_stream(&force);
            assert_eq!(saved(&waiting), saved(&placed));
        }
    }
}

/// Everything is read, and goes on, as if what waits were in its place.
#[test]
fn what_waits_counts_as_in_its_place() {
    counts_as_in_its_place::<f64>();
    counts_as_in_its_place::<f32>();
    counts_as_in_its_place::<half::f16>();
}

/// What a sweep takes down is what the band has after it.
#[test]
fn what_leaves_is_what_the_band_has() {
    for nest in nests() {
        let mut fine = exchanged::<f64>(nest);
        for _ in 0..2 {
            fine.collide_stream(&BodyForce::default());
        }
        let by_sweep = fine.exchanged_ends.take().unwrap();
        assert!(by_sweep.taken_down);
        take_down_ends(&nest, &mut fine);
        let read = fine.exchanged_ends.unwrap();
        assert_eq!(by_sweep.leaving, read.leaving);
        let mut all = read.leaving.iter().flatten().flatten().flatten();
        assert!(all.any(|f| *f != 0.0));
    }
}

/// Rows that go round have no ends.
#[test]
fn rows_that_go_round_have_none() {
    let nest = Nest {
        first: [0, 4, 4],
        cells: [9, 6, 7],
        spans: [true, false, false],
    };
    assert!(exchanged::<f64>(nest).exchanged_ends.is_none());
}
