//! Surfaces that cut links of the lattice: exact flows, and what the air keeps.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::coupling::Friction;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::Setup;
use ripstop::simulation::{AirEngine, CutSurface};

use crate::engines::{Body, Engine, mass_and_momentum, on_every_engine, plain, states};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("cut_links::flow_between_planes_is_linear", Couette),
        on_every_engine("cut_links::walls_that_move_keep_the_mass", Closed),
        on_every_engine("cut_links::air_that_is_shut_in_gets_out", ShutIn),
        on_every_engine(
            "cut_links::it_does_not_matter_where_a_period_begins",
            Shifted,
        ),
        on_every_engine("cut_links::air_slides_along_turned_walls", Slides),
        plain("cut_links::air_in_a_body_at_rest_sticks", shut_in_at_rest),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub fn periodic(cells: [usize; 3], relaxation_time: f64) -> Setup {
    Setup::periodic(cells, relaxation_time, Operator::RecursiveRegularised)
}

/// One step of the air and the surface in it, which moves with `velocities`; the force on the air.
pub fn step(
    air: &mut AirEngine,
    surface: &mut CutSurface,
    positions: &[DVec3],
    velocities: &[DVec3],
) -> DVec3 {
    air.collide_stream(None, None).unwrap();
    surface.find_links(positions).unwrap();
    surface.read_links(air).unwrap();
    surface.fetch_links(air, velocities).unwrap();
    surface.bounce(air, velocities).unwrap();
    surface.forces().map(|(_, force)| force).sum()
}

#[derive(Clone, Copy)]
struct Couette;

impl Body for Couette {
    /// Between a plane at rest and one that slides, wherever they lie between cells, the velocity is linear, and so is the shear stress on both.
    fn run(self, engine: Engine) {
        const SPEED: f64 = 0.02;
        let (cells, relaxation_time) = ([4, 20, 4], 1.1);
        for [low, high] in [[4.3, 13.85], [4.0, 13.5], [4.72, 14.05]] {
            let share = |y: f64| {
                let inside = (y - low) / (high - low);
                if (0.0..=1.0).contains(&inside) {
                    inside
                } else {
                    // The other way round, over sides that repeat.
                    (y - low - if y > low { 20.0 } else { 0.0 }) / (high - low - 20.0)
                }
            };
            let initial = |cell: [usize; 3]| (0.0, [SPEED * share(cell[1] as f64), 0.0, 0.0]);
            let mut air = engine.air(periodic(cells, relaxation_time), &initial);
            let plane = |y: f64| {
                let corners = [[-0.5, -0.5], [3.5, -0.5], [3.5, 3.5], [-0.5, 3.5]];
                corners.map(|[x, z]| DVec3::new(x, y, z))
            };
            let positions = [plane(low), plane(high)].concat();
            let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
            let mut velocities = vec![DVec3::ZERO; 8];
            velocities[4..].fill(DVec3::X * SPEED);
            let mut surface = CutSurface::new(&air, triangles, 8, (0, None));
            for _ in 0..1500 {
                step(&mut air, &mut surface, &positions, &velocities);
            }
            let [nx, ny, _] = cells;
            for (i, (_, u)) in states(&air).into_iter().enumerate() {
                let y = (i / nx % ny) as f64;
                let error = (u[0] / SPEED - share(y)).abs();
                assert!(
                    error < tolerances::exact_wall(engine).max(tolerances::CUT_PLACE),
                    "{low} {high}: {error:e} at {y}"
                );
            }
            let viscosity = (relaxation_time - 0.5) / 3.0;
            let gap = high - low;
            let stress = viscosity * SPEED * (1.0 / gap + 1.0 / (20.0 - gap));
            let on_upper: f64 = (surface.forces())
                .filter(|(cut, _)| cut.triangle >= 2)
                .map(|(_, force)| force.x)
                .sum();
            let error = (on_upper / (16.0 * stress) - 1.0).abs();
            assert!(error < tolerances::CUT_SHEAR, "{low} {high}: {error:e}");
        }
    }
}

/// An octahedron of a radius [cells] around a place.
fn octahedron(middle: DVec3, radius: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let directions = [DVec3::X, DVec3::Y, DVec3::Z];
    let corners = directions.into_iter().flat_map(|axis| [axis, -axis]);
    let triangles = (0..8).map(|k| {
        let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1)];
        let mirrored = (x + y + z) % 2 == 1;
        if mirrored { [x, z, y] } else { [x, y, z] }
    });
    let positions = corners.map(|c| middle + radius * c).collect();
    (positions, triangles.collect())
}

#[derive(Clone, Copy)]
struct Shifted;

impl Body for Shifted {
    /// Where everything repeats, a body that moves in a swirl of air does the same in the middle of the domain and over its edges.
    fn run(self, engine: Engine) {
        const CELLS: usize = 10;
        let after = |shift: usize| {
            let initial = |cell: [usize; 3]| {
                let turn = |a: usize| {
                    let place = (cell[a] + CELLS - shift) % CELLS;
                    std::f64::consts::TAU * place as f64 / CELLS as f64
                };
                let [x, y, z] = [turn(0), turn(1), turn(2)];
                let u = [y.sin() + z.cos(), z.sin() - x.cos(), x.sin() + y.cos()];
                (0.01 * (x + 0.3).sin() * y.cos(), u.map(|u| 0.02 * u))
            };
            let mut air = engine.air(periodic([CELLS; 3], 0.6), &initial);
            let middle = DVec3::new(5.25, 4.875, 5.125) + DVec3::splat(shift as f64);
            let (mut positions, triangles) = octahedron(middle, 2.5);
            let velocities = [DVec3::new(0.03, -0.02, 0.01); 6];
            let mut surface = CutSurface::new(&air, triangles, 6, (0, None));
            let mut forces = Vec::new();
            for _ in 0..8 {
                for (position, velocity) in positions.iter_mut().zip(velocities) {
                    *position += velocity;
                }
                forces.push(step(&mut air, &mut surface, &positions, &velocities));
            }
            let states = states(&air);
            let shifted = |place: usize| (place + shift) % CELLS;
            let cells = (0..CELLS.pow(3)).map(|i| {
                let [x, y, z] = [i, i / CELLS, i / CELLS.pow(2)].map(|place| place % CELLS);
                states[shifted(x) + CELLS * (shifted(y) + CELLS * shifted(z))]
            });
            (forces, cells.collect::<Vec<_>>())
        };
        let (forces, states) = after(0);
        let largest = forces
            .iter()
            .map(|force| force.length())
            .fold(0.0, f64::max);
        assert!(largest > 0.01);
        for shift in [5, 7] {
            let (shifted_forces, shifted_states) = after(shift);
            for (force, shifted) in forces.iter().zip(shifted_forces) {
                let error = (*force - shifted).length() / largest;
                assert!(error < tolerances::MOVED_PERIOD, "{shift}: {error:e}");
            }
            for ((excess, u), (shifted_excess, shifted_u)) in states.iter().zip(shifted_states) {
                let errors = (u.iter().zip(shifted_u)).map(|(u, shifted)| (u - shifted).abs());
                let error = errors.fold((excess - shifted_excess).abs(), f64::max);
                assert!(error < tolerances::MOVED_PERIOD, "{shift}: {error:e}");
            }
        }
    }
}

#[derive(Clone, Copy)]
struct ShutIn;

impl Body for ShutIn {
    /// Of a cell that an octahedron shuts in, density far from that around gets out, be it too large or too small; a little stays. The mass is kept.
    fn run(self, engine: Engine) {
        let (cells, place) = ([10; 3], 5);
        let (positions, triangles) = octahedron(DVec3::splat(5.02), 0.7);
        let velocities = [DVec3::ZERO; 6];
        for (before, after) in [(0.4, 0.05), (-0.3, -0.05), (0.04, 0.04)] {
            let initial = |cell: [usize; 3]| {
                let excess = if cell == [place; 3] { before } else { 0.0 };
                (excess, [0.0; 3])
            };
            let mut air = engine.air(periodic(cells, 0.7), &initial);
            let mut surface = CutSurface::new(&air, triangles.clone(), 6, (0, None));
            let before_steps = mass_and_momentum(&air)[0];
            for _ in 0..60 {
                step(&mut air, &mut surface, &positions, &velocities);
            }
            let (excess, _) = states(&air)[place * 111];
            assert!(
                (excess - after).abs() < tolerances::SHUT_IN,
                "{before}: {excess}, not {after}"
            );
            let drift = (mass_and_momentum(&air)[0] - before_steps).abs() / 1000.0;
            let kept = 10.0 * tolerances::conservation(engine);
            assert!(drift < kept, "mass {drift:e} a cell");
        }
    }
}

#[derive(Clone, Copy)]
struct Closed;

impl Body for Closed {
    /// A box that tumbles and breathes, with a fold of two layers beside it: the air's mass stays, and its momentum changes by the surfaces' forces.
    fn run(self, engine: Engine) {
        let mut air = engine.air(periodic([20, 18, 16], 0.52), &|_| (0.0, [0.03, 0.01, 0.0]));
        let corners: Vec<DVec3> = (0..8)
            .map(|k: u32| DVec3::from_array([0, 1, 2].map(|a| f64::from(k >> a & 1) - 0.5)))
            .collect();
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for [a, b, c, d] in faces {
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.extend([[8, 9, 10], [8, 10, 11], [12, 14, 13], [12, 15, 14]]);
        let mut surface = CutSurface::new(&air, triangles, 16, (0, None));
        let place = |time: f64| -> Vec<DVec3> {
            let turn =
                glam::DQuat::from_rotation_x(0.01 * time) * glam::DQuat::from_rotation_z(0.4);
            let size = 6.0 + 0.8 * (0.05 * time).sin();
            let of_box = corners
                .iter()
                .map(|corner| DVec3::new(8.0 + 0.01 * time, 9.3, 8.2) + turn * *corner * size);
            let gap = 0.25 + 0.2 * (0.03 * time).sin();
            let leaf = [[5.3, 4.2], [12.4, 4.2], [12.4, 11.1], [5.3, 11.1]];
            let fold = [-gap, gap]
                .into_iter()
                .flat_map(|x| leaf.map(|[y, z]| DVec3::new(16.4 + x, y, z)));
            of_box.chain(fold).collect()
        };
        let before = mass_and_momentum(&air);
        let mut given = DVec3::ZERO;
        let mut doubled = 0;
        for number in 0..120 {
            let time = f64::from(number);
            let (positions, next) = (place(time), place(time + 1.0));
            let velocities: Vec<DVec3> =
                next.iter().zip(&positions).map(|(b, a)| *b - *a).collect();
            given += step(&mut air, &mut surface, &positions, &velocities);
            doubled += surface
                .links()
                .iter()
                .filter(|link| link.layers > 1)
                .count();
        }
        assert!(doubled > 1000, "{doubled} links with two layers");
        let after = mass_and_momentum(&air);
        let cells = (20 * 18 * 16) as f64;
        let kept = 10.0 * tolerances::conservation(engine);
        assert!(
            (after[0] - before[0]).abs() < kept * cells,
            "mass {:e} a cell",
            (after[0] - before[0]) / cells
        );
        for a in 0..3 {
            let gained = after[a + 1] - before[a + 1];
            assert!(
                (gained - given[a]).abs() < kept * cells,
                "{gained} {}",
                given[a]
            );
            assert!(a > 0 || gained.abs() > 0.1, "nothing happened");
        }
    }
}

/// A plane through a domain that repeats, spanned by `a` and `b` from a corner that lies on no cell, and its triangles.
fn plane_of([a, b]: [DVec3; 2]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = DVec3::new(0.13, 0.37, 0.21);
    let nodes = [DVec3::ZERO, a, a + b, b].map(|from| corner + from);
    (nodes.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

#[derive(Clone, Copy)]
struct Slides;

impl Body for Slides {
    /// A disturbed stream along a plane that lies anyhow in the lattice keeps what it has, where the air slides: the plane takes less than a twentieth
    /// of what it takes where the air sticks, and the disturbance does not grow.
    fn run(self, engine: Engine) {
        const SPEED: f64 = 0.1;
        const STEPS: usize = 400;
        let v = DVec3::new;
        let planes = [
            ([40, 20, 6], [v(40., 0., 0.), v(0., 0., 6.)], v(1., 0., 0.)),
            ([40, 20, 6], [v(40., 20., 0.), v(0., 0., 6.)], v(2., 1., 0.)),
            ([20, 20, 6], [v(20., 20., 0.), v(0., 0., 6.)], v(1., 1., 0.)),
            (
                [20, 10, 10],
                [v(20., 10., 0.), v(0., 10., 10.)],
                v(0., 1., 1.),
            ),
        ];
        for (cells, sides, along) in planes {
            let along = along.normalize();
            let noise = |cell: [usize; 3], a: usize| {
                let number = cell[0] * 7919 + cell[1] * 104_729 + cell[2] * 1_299_709 + a * 15_485;
                0.01 * ((number % 1009) as f64 / 1009.0 - 0.5)
            };
            let initial = |cell: [usize; 3]| {
                let stream = along * SPEED;
                let u = [stream.x, stream.y, stream.z];
                (0.0, [0, 1, 2].map(|a| u[a] + noise(cell, a)))
            };
            let setup = Setup {
                operator: Operator::StabilisedRegularised,
                ..periodic(cells, 0.5001)
            };
            let (positions, triangles) = plane_of(sides);
            let still = vec![DVec3::ZERO; positions.len()];
            let drag = [Friction::None, Friction::NoSlip].map(|friction| {
                let mut air = engine.air(setup.clone(), &initial);
                let mut surface = CutSurface::new(&air, triangles.clone(), 4, (0, None))
                    .with_friction(vec![friction; triangles.len()], 0.0, &positions);
                let mass = mass_and_momentum(&air)[0];
                let taken: f64 = (0..STEPS)
                    .map(|_| -step(&mut air, &mut surface, &positions, &still).dot(along))
                    .sum();
                let count = cells.iter().product::<usize>() as f64;
                // The air keeps its mass, as at walls to which it sticks.
                let lost = (mass - mass_and_momentum(&air)[0]).abs() / count;
                assert!(
                    lost < 10.0 * tolerances::conservation(engine),
                    "{cells:?} {lost:e}"
                );
                // What had to be given back in a step is little beside what streams past the wall.
                let returned = surface.mass_returned() / (STEPS as f64 * SPEED * count);
                assert!(returned < 1e-3, "{cells:?} {returned:e}");
                if friction == Friction::None {
                    for (excess, u) in states(&air) {
                        let off = (DVec3::from_array(u) - along * SPEED).length();
                        // The disturbance begins with up to 0.087 of the speed.
                        assert!(off < 0.1 * SPEED, "{cells:?} {off:e}");
                        assert!(excess.abs() < 0.01, "{cells:?} {excess:e}");
                    }
                }
                taken
            });
            assert!(
                drag[0].abs() < 0.05 * drag[1],
                "{cells:?} {along}: {drag:?}"
            );
        }
    }
}

/// The air that a body at rest shuts in stands. Whether it slides along the inside or sticks there, a pulse of pressure outside does the same.
fn shut_in_at_rest() {
    const PULSE: f64 = 0.05;
    // No cell lies on the surface.
    let (middle, radius) = (DVec3::splat(11.7), 7.15);
    let (positions, triangles) = octahedron(middle, radius);
    let off = |cell: [usize; 3]| DVec3::from_array(cell.map(|place| place as f64)) - middle;
    let is_inside = |cell| off(cell).abs().element_sum() < radius;
    let initial = |cell: [usize; 3]| {
        let from_corner = cell.map(|place| place.min(24 - place) as f64);
        let excess = PULSE * (-0.2 * DVec3::from_array(from_corner).length_squared()).exp();
        (if is_inside(cell) { 0.0 } else { excess }, [0.0; 3])
    };
    let setup = Setup {
        operator: Operator::StabilisedRegularised,
        ..periodic([24; 3], 0.51)
    };
    let still = vec![DVec3::ZERO; positions.len()];
    let [slides, sticks] = [false, true].map(|sticks| {
        let mut air = Engine::CpuF64.air(setup.clone(), &initial);
        let surface = CutSurface::new(&air, triangles.clone(), positions.len(), (0, None))
            .with_friction(vec![Friction::None; triangles.len()], 0.0, &positions);
        let mut surface = match sticks {
            true => {
                surface.sticking_inside(std::slice::from_ref(&(0..triangles.len())), &positions)
            }
            false => surface,
        };
        let force = (0..60).map(|_| step(&mut air, &mut surface, &positions, &still).length());
        let force = force.fold(0.0, f64::max);
        (states(&air), force)
    });
    let [force, same] = [slides.1, sticks.1];
    assert!(force > 1e-2, "{force}");
    assert!((force - same).abs() < 1e-12, "{force} {same}");
    for (number, ((_, u), (_, v))) in slides.0.iter().zip(&sticks.0).enumerate() {
        let cell = [number % 24, number / 24 % 24, number / 576];
        let apart = (DVec3::from_array(*u) - DVec3::from_array(*v)).length();
        assert!(apart < 1e-13, "{cell:?} {apart:e}");
        if is_inside(cell) {
            assert!(DVec3::from_array(*v).length() < 1e-13, "{cell:?} {v:?}");
        }
    }
}
