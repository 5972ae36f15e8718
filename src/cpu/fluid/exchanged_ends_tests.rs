use super::*;
use crate::checkpoint::sections;
use crate::cpu::fluid::transfer::{Tie, take_down_ends};
use crate::cpu::fluid::{BodyForce, Fluid};
use crate::lattice::Operator;
use crate::lattice::grid::{Setup, Sides, StreamwiseEnds};

/// Air that repeats on all sides, with a velocity that differs from cell to cell.
fn air(cells: [usize; 3], relaxation_time: f64) -> Fluid<f64> {
    let setup = Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        inlet_profile: None,
        sides: Sides::Periodic,
        relaxation_time,
        sponge_cells: None,
        operator: Operator::StabilisedRegularised,
        eddy_viscosity: None,
    };
    let uneven = |cell: [usize; 3]| {
        let [x, y, z] = cell.map(|c| c as f64);
        let wave = |phase: f64| 0.03 * (0.9 * x + 1.3 * y + 0.7 * z + phase).sin();
        (0.01 * wave(3.0), [0.05 + wave(0.0), wave(1.0), wave(2.0)])
    };
    Fluid::new(setup, Some(&uneven))
}

/// A box and the lattice around it, which stand at one time after a whole step of both. Rows of 2 and of 3 cache lines, free and spanned sides.
fn exchanged(nest: Nest) -> (Tie<f64>, [Fluid<f64>; 2]) {
    let outer = [0, 1, 2].map(|a| nest.cells[a] + if nest.spans[a] { 0 } else { 8 });
    let (mut coarse, mut fine) = (air(outer, 0.51), air(nest.fine_cells(), 0.52));
    let mut tie = Tie::new(nest);
    tie.exchange(&mut coarse, &mut fine);
    for _ in 0..2 {
        fine.collide_stream(&BodyForce::default());
    }
    coarse.collide_stream(&BodyForce::default());
    tie.exchange(&mut coarse, &mut fine);
    (tie, [coarse, fine])
}

fn nests() -> [Nest; 4] {
    [
        ([8, 7, 6], [false; 3]),
        ([12, 6, 7], [false, false, true]),
        ([7, 6, 8], [false, true, false]),
        ([5, 5, 5], [false; 3]),
    ]
    .map(|(cells, spans)| Nest {
        first: spans.map(|spans| if spans { 0 } else { 4 }),
        cells,
        spans,
    })
}

fn saved(fluid: &Fluid<f64>) -> Vec<u8> {
    sections(|out| fluid.save(out)).unwrap()
}

/// Everything is read, and goes on, as if what waits were in its place.
#[test]
fn what_waits_counts_as_in_its_place() {
    for nest in nests() {
        let (_, [_, mut waiting]) = exchanged(nest);
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
            assert_ne!(
                placed.gather(cell),
                populations,
                "nothing arrived at {cell:?}"
            );
            for (direction, population) in populations.into_iter().enumerate() {
                let (array, element) = placed.grid.slot(index, direction, placed.odd);
                placed.populations[array][element] = population;
            }
        }
        let all = nest.fine_cells();
        assert_eq!(waiting.macroscopic(), placed.macroscopic());
        assert_eq!(waiting.mass_and_energy(), placed.mass_and_energy());
        let farthest = |fluid: &Fluid<f64>| format!("{:?}", fluid.extremes([0; 3], all));
        assert_eq!(farthest(&waiting), farthest(&placed));
        assert_eq!(saved(&waiting), saved(&placed));
        for _ in 0..3 {
            waiting.collide_stream(&BodyForce::default());
            placed.collide_stream(&BodyForce::default());
            assert_eq!(saved(&waiting), saved(&placed));
        }
    }
}

/// What a sweep takes down is what the band has after it.
#[test]
fn what_leaves_is_what_the_band_has() {
    for nest in nests() {
        let (_, [_, mut fine]) = exchanged(nest);
        for _ in 0..2 {
            fine.collide_stream(&BodyForce::default());
        }
        let taken_down = fine.exchanged_ends.clone().unwrap();
        assert!(taken_down.taken_down);
        fine.exchanged_ends = None;
        take_down_ends(&nest, &mut fine);
        let read = fine.exchanged_ends.unwrap();
        assert_eq!(taken_down.leaving, read.leaving);
        assert!(
            read.leaving
                .iter()
                .flatten()
                .flatten()
                .flatten()
                .any(|f| *f != 0.0)
        );
    }
}
