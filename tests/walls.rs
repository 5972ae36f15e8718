//! No-slip walls on all faces, at rest and moving: exact solutions, symmetry, mass.

use libtest_mimic::Trial;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};

use crate::engines::{Body, Engine, mass_and_momentum, on_every_engine, states};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("walls::poiseuille_is_exact", Poiseuille),
        on_every_engine("walls::couette_is_exact_on_every_face", Couette),
        on_every_engine("walls::a_box_under_a_lid_keeps_its_mass", Lid),
        on_every_engine("walls::the_lid_may_be_any_face", Turned),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const REST: Faces = Faces::Walls([Wall::AT_REST; 2]);

fn setup(cells: [usize; 3], faces: [Faces; 3], relaxation_time: f64, operator: Operator) -> Setup {
    Setup {
        cells,
        ends: match faces[0] {
            Faces::Periodic => StreamwiseEnds::Periodic,
            Faces::Walls(walls) => StreamwiseEnds::Walls(walls),
        },
        sides: Sides::Each([faces[1], faces[2]]),
        relaxation_time,
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator,
        eddy_viscosity: None,
    }
}

#[derive(Clone, Copy)]
struct Poiseuille;

impl Body for Poiseuille {
    /// With two relaxation times and Λ = 3/16 the parabola between walls half a cell beyond the outermost centres is the discrete
    /// solution, whatever τ is.
    fn run(self, engine: Engine) {
        let n = 12;
        for tau in [0.7, 1.1] {
            let nu = (tau - 0.5) / 3.0;
            let height = n as f64;
            let force = 8.0 * nu * 0.05 / (height * height);
            let setup = setup(
                [5, 4, n],
                [Faces::Periodic, Faces::Periodic, REST],
                tau,
                Operator::TwoRelaxationTimes,
            );
            let mut air = engine.air(setup, &|_| (0.0, [0.0; 3]));
            // What the start lacks decays with exp(−π²νt/H²).
            for _ in 0..(3.5 * height * height / nu) as usize {
                air.collide_stream(Some([0.0, force, 0.0]), None).unwrap();
            }
            for (i, (_, u)) in states(&air).iter().enumerate() {
                let z = (i / 20) as f64 + 0.5;
                let exact = 0.5 * force / nu * z * (height - z);
                let error = (u[1] + 0.5 * force - exact).abs().max(u[0].abs()) / 0.05;
                assert!(
                    error < tolerances::exact_wall(engine),
                    "τ = {tau}, z = {z}: {error:e}"
                );
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Couette;

impl Body for Couette {
    /// A wall that moves drives a linear profile, on each of the six faces and for all operators.
    fn run(self, engine: Engine) {
        let speed = 0.04;
        for operator in Operator::ALL {
            for axis in 0..3 {
                for upper in [false, true] {
                    let along = (axis + 1) % 3;
                    let mut velocity = [0.0; 3];
                    velocity[along] = speed;
                    let mut walls = [Wall::AT_REST; 2];
                    walls[usize::from(upper)] = Wall::NoSlip { velocity };
                    let mut faces = [Faces::Periodic; 3];
                    faces[axis] = Faces::Walls(walls);
                    let mut cells = [4; 3];
                    cells[axis] = 10;
                    let share = |cell: [usize; 3]| {
                        let from_lower = (cell[axis] as f64 + 0.5) / 10.0;
                        if upper { from_lower } else { 1.0 - from_lower }
                    };
                    let exact = move |cell: [usize; 3]| {
                        let mut u = [0.0; 3];
                        u[along] = speed * share(cell);
                        u
                    };
                    let mut air = engine.air(setup(cells, faces, 0.9, operator), &|cell| {
                        (0.0, exact(cell))
                    });
                    for _ in 0..1500 {
                        air.collide_stream(None, None).unwrap();
                    }
                    for (i, (excess, u)) in states(&air).iter().enumerate() {
                        let [nx, ny, _] = cells;
                        let e = exact([i % nx, i / nx % ny, i / nx / ny]);
                        // The regularised operator's third-order terms keep the velocity, but move the density at the walls a little.
                        let off_density = match operator {
                            Operator::SingleRelaxationTime | Operator::TwoRelaxationTimes => {
                                excess.abs()
                            }
                            Operator::RecursiveRegularised | Operator::StabilisedRegularised => 0.0,
                        };
                        let error = (0..3)
                            .map(|a| (u[a] - e[a]).abs())
                            .fold(off_density, f64::max)
                            / speed;
                        let mut allowed = tolerances::exact_wall(engine);
                        if operator == Operator::StabilisedRegularised {
                            allowed = allowed.max(tolerances::WALL_WITH_RESIDUAL);
                        }
                        assert!(
                            error < allowed,
                            "{operator:?}, axis {axis}, upper {upper}, cell {i}: {error:e}"
                        );
                    }
                }
            }
        }
    }
}

/// A closed box whose wall at the end of `axis` moves along the next axis.
fn lid(axis: usize, speed: f64) -> Setup {
    let mut velocity = [0.0; 3];
    velocity[(axis + 1) % 3] = speed;
    let mut faces = [REST; 3];
    faces[axis] = Faces::Walls([Wall::AT_REST, Wall::NoSlip { velocity }]);
    setup([12; 3], faces, 0.62, Operator::RecursiveRegularised)
}

#[derive(Clone, Copy)]
struct Lid;

impl Body for Lid {
    fn run(self, engine: Engine) {
        let mut air = engine.air(lid(1, 0.08), &|_| (0.0, [0.0; 3]));
        for _ in 0..600 {
            air.collide_stream(None, None).unwrap();
        }
        let [mass, x, y, z] = mass_and_momentum(&air);
        let cells = 1728.0;
        assert!(
            mass.abs() / cells < tolerances::conservation(engine),
            "{mass:e}"
        );
        assert!(z > 0.0, "the lid drags the air along: {z}");
        assert!(x.abs() + y.abs() < 0.1 * z, "{x} {y} {z}");
    }
}

#[derive(Clone, Copy)]
struct Turned;

impl Body for Turned {
    /// The same box turned: axes exchanged in turn leave the lattice as it is, so the flows agree cell by cell.
    fn run(self, engine: Engine) {
        let flows: Vec<_> = (0..3)
            .map(|axis| {
                let mut air = engine.air(lid(axis, 0.08), &|_| (0.0, [0.0; 3]));
                for _ in 0..200 {
                    air.collide_stream(None, None).unwrap();
                }
                states(&air)
            })
            .collect();
        let n = 12;
        for axis in 1..3 {
            for i in 0..n * n * n {
                let cell = [i % n, i / n % n, i / n / n];
                let turned: [usize; 3] = std::array::from_fn(|a| cell[(a + 3 - axis) % 3]);
                let (p, u) = flows[0][i];
                let (q, v) = flows[axis][turned[0] + n * (turned[1] + n * turned[2])];
                let difference = (0..3)
                    .map(|a| (u[a] - v[(a + axis) % 3]).abs())
                    .fold((p - q).abs(), f64::max);
                assert!(
                    difference < tolerances::same_flow(engine),
                    "lid at the end of axis {axis}, cell {cell:?}: {difference:e}"
                );
            }
        }
    }
}
