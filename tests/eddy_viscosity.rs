//! Eddy viscosity from the velocity gradient: its value, where it vanishes, what it does to the flow, and when it is evaluated.

use libtest_mimic::Trial;
use ripstop::lattice::Operator;
use ripstop::lattice::eddy_viscosity::{EddyViscosity, GradientModel, vreman, wale};
use ripstop::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use ripstop::lattice::nest::Nest;
use ripstop::simulation::{AirEngine, Levels};

use crate::engines::{Body, Engine, needs_device, on_every_engine, on_every_storage, states};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_storage("eddy_viscosity::of_linear_velocities", Linear),
        on_every_storage("eddy_viscosity::beyond_every_kind_of_face", AtFaces),
        on_every_engine("eddy_viscosity::none_in_couette_flow", Couette),
        on_every_storage("eddy_viscosity::dissipates_vortices", Dissipation),
        on_every_engine("eddy_viscosity::evaluated_when_due", Due),
        on_every_engine("eddy_viscosity::in_a_box_of_finer_cells", InABox),
        vec![needs_device(
            "eddy_viscosity::many_steps_at_once::gpu".to_owned(),
            many_steps_at_once,
        )],
    ]
    .into_iter()
    .flatten()
    .collect()
}

const WALE: f64 = 0.5;
const VREMAN: f64 = 0.07;

type Gradient = [[f64; 3]; 3];

type Formula = fn(&Gradient) -> f64;

type Velocity = dyn Fn([usize; 3]) -> [f64; 3] + Sync;

/// Both models with ν_t for a gradient [a][b] = ∂u_b/∂x_a.
fn models() -> [(EddyViscosity, Formula); 2] {
    [
        (EddyViscosity::wale(WALE), |g| WALE * WALE * wale(g)),
        (EddyViscosity::vreman(VREMAN), |g| VREMAN * vreman(g)),
    ]
}

fn periodic(cells: [usize; 3], eddy_viscosity: EddyViscosity) -> Setup {
    Setup {
        cells,
        ends: StreamwiseEnds::Periodic,
        sides: Sides::Periodic,
        relaxation_time: 0.52,
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator: Operator::RecursiveRegularised,
        eddy_viscosity: Some(eddy_viscosity),
    }
}

fn evaluated(engine: Engine, setup: Setup, u: &Velocity) -> Vec<f64> {
    let mut air = engine.air(setup, &|cell| (0.01, u(cell)));
    air.set_inlet_velocity(INLET);
    air.eddy_viscosity().unwrap();
    air.eddy_viscosities().unwrap().unwrap()
}

const INLET: [f64; 3] = [0.05, 0.01, 0.0];

#[derive(Clone, Copy)]
struct Linear;

impl Body for Linear {
    /// Away from the faces differences of a linear velocity are exact. Values by hand, for a rate of 0.004 per step and Δ = 1:
    /// pure shear 0; solid-body rotation C_w² (2/3)^¼ and c/√2; plane strain, S:S = 2, S^d:S^d = 2/3 and |α| = √2, has
    /// C_w² (2/3)^{3/2} / (2^{5/2} + (2/3)^{5/4}) and c/√2; axisymmetric strain (2, −1, −1), S:S = 6, S^d = (2, −1, −1), B_β = 9, has
    /// C_w² 6^{3/2} / (6^{5/2} + 6^{5/4}) and c √(9/6).
    fn run(self, engine: Engine) {
        let rate = 0.004;
        let root = 0.5f64.sqrt();
        let plane = (2f64 / 3.0).powf(1.5) / (2f64.powf(2.5) + (2f64 / 3.0).powf(1.25));
        let axial = 6f64.powf(1.5) / (6f64.powf(2.5) + 6f64.powf(1.25));
        let flows: [(&str, Gradient, [f64; 2]); 4] = [
            ("shear", [[0.0; 3], [0.0; 3], [0.0, 1.0, 0.0]], [0.0, 0.0]),
            (
                "rotation",
                [[0.0, 0.0, -1.0], [0.0; 3], [1.0, 0.0, 0.0]],
                [(2f64 / 3.0).powf(0.25), root],
            ),
            (
                "plane strain",
                [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
                [plane, root],
            ),
            (
                "axisymmetric strain",
                [[2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
                [axial, 1.5f64.sqrt()],
            ),
        ];
        // More cells along x than a vector has lanes, and a rest.
        let cells = [21, 6, 7];
        for (name, gradient, values) in flows {
            let velocity = move |cell: [usize; 3]| {
                let place = [
                    cell[0] as f64 - 10.0,
                    cell[1] as f64 - 2.5,
                    cell[2] as f64 - 3.0,
                ];
                std::array::from_fn(|b| {
                    rate * (0..3).map(|a| place[a] * gradient[a][b]).sum::<f64>()
                })
            };
            for ((eddy_viscosity, _), value) in models().into_iter().zip(values) {
                let constant = eddy_viscosity.relaxation_factor() / 3.0;
                let expected = constant * rate * value;
                let found = evaluated(engine, periodic(cells, eddy_viscosity), &velocity);
                for (i, found) in found.into_iter().enumerate() {
                    let cell = [i % 21, i / 21 % 6, i / 126];
                    if (0..3).all(|a| (1..cells[a] - 1).contains(&cell[a])) {
                        let error = (found - expected).abs() / (constant * rate);
                        assert!(
                            error < tolerances::velocity_gradient(engine),
                            "{name}, {:?}, {cell:?}: {found:e}, not {expected:e}",
                            eddy_viscosity.model
                        );
                    }
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
struct AtFaces;

impl Body for AtFaces {
    /// Every kind of face, with velocities beyond it written down here by hand, against the formulas in double precision.
    fn run(self, engine: Engine) {
        let cells = [19, 5, 6];
        let moving = Wall::NoSlip {
            velocity: [0.0, 0.0, 0.03],
        };
        let velocity = |cell: [usize; 3]| {
            let phase = (3 * cell[0] + 5 * cell[1] + 7 * cell[2]) as f64;
            [
                0.05 + 0.02 * phase.cos(),
                0.03 * (2.0 * phase).sin(),
                -0.02 * (0.5 * phase).cos(),
            ]
        };
        // Ends, sides, and the velocity beyond (axis, upper, velocity before the face, of the cell before that and of the one at the opposite face).
        type Outside = fn(usize, bool, [f64; 3], [f64; 3], [f64; 3]) -> [f64; 3];
        let tunnel: Outside = |axis, upper, u, _, _| match (axis, upper) {
            (0, false) => INLET,
            (0, true) => u,
            (1, _) => [u[0], -u[1], u[2]],
            _ => [u[0], u[1], -u[2]],
        };
        let channel: Outside = |axis, upper, u, _, opposite| match (axis, upper) {
            (0, _) => opposite,
            (1, false) => [-u[0], -u[1], 0.06 - u[2]],
            (1, true) => [u[0], -u[1], u[2]],
            _ => opposite,
        };
        let vessel: Outside = |axis, upper, u, _, _| match (axis, upper) {
            (0, false) => [-u[0], u[1], u[2]],
            (0, true) => [-u[0], -u[1], 0.06 - u[2]],
            _ => u.map(|v| -v),
        };
        let of_a_box: Outside = |_, _, u, next, _| std::array::from_fn(|b| 2.0 * u[b] - next[b]);
        let scenes = [
            (StreamwiseEnds::InletOutlet, Sides::FreeSlip, tunnel),
            (
                StreamwiseEnds::Periodic,
                Sides::Each([Faces::Walls([moving, Wall::FreeSlip]), Faces::Periodic]),
                channel,
            ),
            (
                StreamwiseEnds::Walls([Wall::FreeSlip, moving]),
                Sides::Each([Faces::Walls([Wall::AT_REST; 2]); 2]),
                vessel,
            ),
            (
                StreamwiseEnds::Walls([Wall::OfBox; 2]),
                Sides::Each([Faces::Walls([Wall::OfBox; 2]); 2]),
                of_a_box,
            ),
        ];
        for (ends, sides, outside) in scenes {
            for (eddy_viscosity, exact) in models() {
                let setup = Setup {
                    ends,
                    sides,
                    ..periodic(cells, eddy_viscosity)
                };
                let found = evaluated(engine, setup, &velocity);
                for (i, found) in found.into_iter().enumerate() {
                    let cell = [i % 19, i / 19 % 5, i / 95];
                    let gradient = std::array::from_fn(|a| {
                        let mut other = cell;
                        let mut side = |upper: bool| {
                            let at_face = cell[a] == if upper { cells[a] - 1 } else { 0 };
                            other[a] = match (at_face, upper) {
                                (true, true) => 0,
                                (true, false) => cells[a] - 1,
                                (false, true) => cell[a] + 1,
                                (false, false) => cell[a] - 1,
                            };
                            if at_face {
                                let mut next = cell;
                                next[a] = if upper { cell[a] - 1 } else { cell[a] + 1 };
                                let [here, next, opposite] = [cell, next, other].map(velocity);
                                outside(a, upper, here, next, opposite)
                            } else {
                                velocity(other)
                            }
                        };
                        let (below, above) = (side(false), side(true));
                        std::array::from_fn(|b| 0.5 * (above[b] - below[b]))
                    });
                    let expected = exact(&gradient);
                    assert!(
                        (found - expected).abs() < tolerances::velocity_gradient(engine) * 0.05,
                        "{ends:?}, {:?}, {cell:?}: {found:e}, not {expected:e}",
                        eddy_viscosity.model
                    );
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
struct InABox;

impl Body for InABox {
    /// Vortices that drift through the faces of a box: its eddy viscosity is that of finest cells throughout, up to its faces. So is that of the coarse
    /// cells at these faces, although the coarse air below the box is at rest at the start.
    fn run(self, engine: Engine) {
        let (cells, first) = (24, 7);
        let nest = Nest {
            first: [first; 3],
            cells: [10, 11, 12],
            spans: [false; 3],
        };
        // Over the length of the coarse lattice.
        let velocity = |place: [f64; 3]| {
            let [x, y, z] = place.map(|s| std::f64::consts::TAU * s);
            [
                0.06 + 0.03 * x.sin() * y.cos() * z.cos(),
                0.02 - 0.03 * x.cos() * y.sin() * z.cos(),
                0.02 * (x + y).sin(),
            ]
        };
        let of_size = |corner: usize, count: f64| {
            move |cell: [usize; 3]| {
                let place = cell.map(|c| ((corner + c) as f64 + 0.5) / count);
                (0.0, velocity(place))
            }
        };
        for (eddy_viscosity, _) in models() {
            let setup = |cells: [usize; 3], relaxation_time: f64, update_every: u32| Setup {
                relaxation_time,
                ..periodic(
                    cells,
                    EddyViscosity {
                        update_every,
                        ..eddy_viscosity
                    },
                )
            };
            let seen = of_size(0, cells as f64);
            let depth = |cell: [usize; 3]| nest_depth(&nest, cell);
            let coarse = engine.air(setup([cells; 3], 0.51, 2), &|cell| {
                if depth(cell) >= 3 {
                    (0.0, [0.0; 3])
                } else {
                    seen(cell)
                }
            });
            let of_box = Setup {
                ends: StreamwiseEnds::Walls([Wall::OfBox; 2]),
                sides: Sides::Each([Faces::Walls([Wall::OfBox; 2]); 2]),
                ..setup(nest.fine_cells(), 0.52, 2)
            };
            let count = 2.0 * cells as f64;
            let fine = engine.air(of_box, &of_size(2 * first, count));
            let mut levels = Levels::new(coarse).with(nest, Levels::new(fine)).unwrap();
            let throughout = setup([2 * cells; 3], 0.52, 2);
            let mut throughout = engine.air(throughout, &of_size(0, count));
            for _ in 0..6 {
                levels.whole_step(None).unwrap();
            }
            advance(&mut throughout, 12);
            let evaluated = |air: &mut AirEngine| {
                air.eddy_viscosity().unwrap();
                air.eddy_viscosities().unwrap().unwrap()
            };
            let found = evaluated(levels.finest_mut());
            let expected = evaluated(&mut throughout);
            let largest = expected.iter().copied().fold(0.0, f64::max);
            let [nx, ny, _] = nest.fine_cells();
            let at = |[x, y, z]: [usize; 3]| expected[x + 2 * cells * (y + 2 * cells * z)];
            let squares = found.iter().enumerate().map(|(i, found)| {
                let place = [i % nx, i / nx % ny, i / nx / ny];
                (found - at(place.map(|c| c + 2 * first))).powi(2)
            });
            let error = (squares.sum::<f64>() / found.len() as f64).sqrt();
            assert!(
                error < tolerances::EDDY_VISCOSITY_IN_A_BOX * largest,
                "{:?}: {error:e} of {largest:e}",
                eddy_viscosity.model
            );
            // Of coarse cells it is twice that of the fine ones they are made of: gradients per step are twice as large.
            let around = evaluated(levels.engine_mut());
            let squares: Vec<f64> = (0..around.len())
                .map(|i| [i % cells, i / cells % cells, i / cells / cells])
                .zip(&around)
                .filter(|(cell, _)| (0..=1).contains(&depth(*cell)))
                .map(|(cell, found)| {
                    let children = (0..8)
                        .map(|child| at(std::array::from_fn(|a| 2 * cell[a] + (child >> a & 1))));
                    (0.5 * found - children.sum::<f64>() / 8.0).powi(2)
                })
                .collect();
            let error = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            assert!(
                error < tolerances::EDDY_VISCOSITY_AT_A_BOX * largest,
                "{:?} at the faces: {error:e} of {largest:e}",
                eddy_viscosity.model
            );
        }
    }
}

/// Coarse cells between a cell and the nearest face of a box; negative outside.
fn nest_depth(nest: &Nest, cell: [usize; 3]) -> i64 {
    let along = |a: usize| {
        let place = cell[a] as i64 - nest.first[a] as i64;
        place.min(nest.cells[a] as i64 - 1 - place)
    };
    along(0).min(along(1)).min(along(2))
}

#[derive(Clone, Copy)]
struct Couette;

impl Body for Couette {
    /// Between a wall at rest and one that moves: no eddy viscosity, from wall to wall, and the profile stays what it is. Smagorinsky's
    /// would be C_s² times the shear rate.
    fn run(self, engine: Engine) {
        let (height, speed) = (10, 0.05);
        let moving = Wall::NoSlip {
            velocity: [speed, 0.0, 0.0],
        };
        let rate = speed / height as f64;
        let exact = move |[_, _, z]: [usize; 3]| rate * (z as f64 + 0.5);
        for (eddy_viscosity, _) in models() {
            // The regularised operator's third-order terms move the air at the walls a little.
            let setup = Setup {
                operator: Operator::TwoRelaxationTimes,
                sides: Sides::Each([Faces::Periodic, Faces::Walls([Wall::AT_REST, moving])]),
                ..periodic([5, 4, height], eddy_viscosity)
            };
            let mut air = engine.air(setup, &|cell| (0.0, [exact(cell), 0.0, 0.0]));
            advance(&mut air, 200);
            let constant = eddy_viscosity.relaxation_factor() / 3.0;
            for (i, found) in air.eddy_viscosities().unwrap().unwrap().iter().enumerate() {
                assert!(
                    found / (constant * rate) < tolerances::velocity_gradient(engine),
                    "{:?}, cell {i}: {found:e}",
                    eddy_viscosity.model
                );
            }
            for (i, (_, u)) in states(&air).iter().enumerate() {
                let error = (u[0] - exact([0, 0, i / 20])).abs() / speed;
                assert!(error < tolerances::exact_wall(engine), "{i}: {error:e}");
            }
        }
    }
}

fn advance(air: &mut AirEngine, steps: usize) {
    for _ in 0..steps {
        air.collide_stream(None, None).unwrap();
    }
}

#[derive(Clone, Copy)]
struct Dissipation;

impl Body for Dissipation {
    /// Vortices u = A sin kx cos ky, v = −A cos kx sin ky lose the energy ∫ 2 (ν + ν_t) S:S, as their state in the middle of the time says:
    /// ν_t by the central differences of the model, S by differences of fourth order.
    fn run(self, engine: Engine) {
        let n = 32;
        let k = std::f64::consts::TAU / n as f64;
        // Slow, with large constants: at 0.1 cells per step the varying viscosity makes two relaxation times err by 6 %.
        let speed = 0.02;
        let initial = move |[x, y, _]: [usize; 3]| {
            let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
            let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
            (
                excess,
                [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
            )
        };
        for operator in Operator::ALL {
            for eddy_viscosity in [EddyViscosity::wale(5.0), EddyViscosity::vreman(6.0)] {
                let setup = Setup {
                    operator,
                    relaxation_time: 0.52,
                    ..periodic([n, n, 4], eddy_viscosity)
                };
                let mut air = engine.air(setup, &initial);
                // The stress of the start lacks the eddy part; odd moments take their time with two relaxation times.
                advance(&mut air, 40);
                let (_, before) = air.mass_and_energy().unwrap();
                advance(&mut air, 8);
                let middle: Vec<[f64; 3]> = states(&air).into_iter().map(|(_, u)| u).collect();
                advance(&mut air, 8);
                let (_, after) = air.mass_and_energy().unwrap();
                let at = |x: usize, y: usize| middle[x % n + n * (y % n)];
                let (mut molecular, mut eddy) = (0.0, 0.0);
                for i in 0..n * n {
                    let (x, y) = (i % n + n, i / n + n);
                    let [x1, x2] = [1, 2].map(|d| {
                        let (above, below) = (at(x + d, y), at(x - d, y));
                        [0, 1, 2].map(|b| above[b] - below[b])
                    });
                    let [y1, y2] = [1, 2].map(|d| {
                        let (above, below) = (at(x, y + d), at(x, y - d));
                        [0, 1, 2].map(|b| above[b] - below[b])
                    });
                    let gradient = [x1.map(|d| 0.5 * d), y1.map(|d| 0.5 * d), [0.0; 3]];
                    let value = match eddy_viscosity.gradient_model() {
                        Some(GradientModel::Wale) => wale(&gradient),
                        Some(GradientModel::Vreman) => vreman(&gradient),
                        None => 0.0,
                    };
                    let fine =
                        |one: [f64; 3], two: [f64; 3], b: usize| (8.0 * one[b] - two[b]) / 12.0;
                    let shear = 0.5 * (fine(x1, x2, 1) + fine(y1, y2, 0));
                    let strain =
                        fine(x1, x2, 0).powi(2) + fine(y1, y2, 1).powi(2) + 2.0 * shear * shear;
                    molecular += 0.02 / 3.0 * 2.0 * strain;
                    eddy += eddy_viscosity.relaxation_factor() / 3.0 * value * 2.0 * strain;
                }
                assert!(
                    eddy > 0.5 * molecular,
                    "the test must be about the eddy viscosity: {eddy:e} {molecular:e}"
                );
                // Four layers, sixteen steps.
                let error = (before - after) / 64.0 / (molecular + eddy) - 1.0;
                assert!(
                    error.abs() < tolerances::EDDY_VISCOSITY,
                    "{operator:?}, {eddy_viscosity:?}: {error}"
                );
            }
        }
    }
}

fn swirl([x, y, z]: [usize; 3]) -> (f64, [f64; 3]) {
    let wave = |a: usize, b: usize| 0.03 * ((3 * a + 5 * b + 1) as f64).sin();
    (0.1 * wave(x, z), [wave(x, y), wave(y, z), wave(z, x)])
}

fn bits(air: &AirEngine) -> Vec<u64> {
    states(air)
        .iter()
        .flat_map(|(d, u)| [*d, u[0], u[1], u[2]])
        .map(f64::to_bits)
        .collect()
}

#[derive(Clone, Copy)]
struct Due;

impl Body for Due {
    /// Every third step, whether the caller asks for the stage or leaves it to `collide_stream`.
    fn run(self, engine: Engine) {
        let mut eddy_viscosity = EddyViscosity::wale(WALE);
        eddy_viscosity.update_every = 3;
        let new = || engine.air(periodic([9, 8, 7], eddy_viscosity), &swirl);
        let (mut asked, mut left) = (new(), new());
        let mut changes = Vec::new();
        for _ in 0..10 {
            let before = left.eddy_viscosities().unwrap();
            asked.eddy_viscosity().unwrap();
            // A second time changes nothing.
            asked.eddy_viscosity().unwrap();
            advance(&mut asked, 1);
            advance(&mut left, 1);
            changes.push(left.eddy_viscosities().unwrap() != before);
        }
        assert_eq!(bits(&asked), bits(&left));
        let expected: Vec<bool> = (0..10).map(|step| step % 3 == 0).collect();
        assert_eq!(changes, expected);
    }
}

/// On the device many steps go into one submission; the stage is among them.
fn many_steps_at_once() {
    let new = || Engine::Gpu.air(periodic([9, 8, 7], EddyViscosity::vreman(VREMAN)), &swirl);
    let (mut one_by_one, mut together) = (new(), new());
    // The first submissions are timed, one by one.
    for air in [&mut one_by_one, &mut together] {
        advance(air, 17);
    }
    advance(&mut one_by_one, 45);
    let AirEngine::Gpu(fluid) = &mut together else {
        panic!("not on the device");
    };
    fluid.collide_stream_steps(45).unwrap();
    assert_eq!(bits(&one_by_one), bits(&together));
    assert_eq!(
        one_by_one.eddy_viscosities().unwrap(),
        together.eddy_viscosities().unwrap()
    );
}
