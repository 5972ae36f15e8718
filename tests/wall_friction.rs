//! Friction of surfaces by a model of the boundary layer, and surfaces along which the air slides in whole scenes.

use glam::{DQuat, DVec3};
use libtest_mimic::Trial;
use ripstop::case::coupling::Friction;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::Setup;
use ripstop::plan::Plan;
use ripstop::run::without_files;
use ripstop::simulation::CutSurface;

use crate::cut_canopies::{canopy, goes_on_alike};
use crate::cut_links::{periodic, step};
use crate::engines::{Body, Engine, mass_and_momentum, on_every_engine, plain};
use crate::read_outs::latest;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine(
            "wall_friction::of_a_turned_plate",
            TurnedPlate { moves: false },
        ),
        on_every_engine(
            "wall_friction::of_a_plate_that_moves",
            TurnedPlate { moves: true },
        ),
        on_every_engine("wall_friction::a_light_canopy_opens", LightCanopy),
        plain(
            "wall_friction::a_run_taken_up_goes_on_alike",
            taken_up_alike,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// That with which the air slides along cut links.
const OPERATOR: &str = "resolution.operator=stabilised_regularised";

#[derive(Clone, Copy)]
struct TurnedPlate {
    /// Through air at rest, in place of a stream along it.
    moves: bool,
}

impl Body for TurnedPlate {
    /// A plate of 16 cells that lies anyhow in the lattice has the friction of Prandtl and Schlichting's law, though its layer is a fortieth of a cell thick; the air loses what the plate
    /// gets, and no mass.
    fn run(self, engine: Engine) {
        const CELLS: u32 = 16;
        const SPEED: f64 = 0.1;
        const REYNOLDS: f64 = 1e6;
        let length = f64::from(CELLS);
        let along = DQuat::from_rotation_z(20_f64.to_radians()) * DVec3::X;
        let grid = [48, 32, 4];
        let setup = Setup {
            operator: Operator::StabilisedRegularised,
            ..periodic(grid, 0.5 + 3.0 * SPEED * length / REYNOLDS)
        };
        let [stream, motion] = if self.moves {
            [DVec3::ZERO, along * -SPEED]
        } else {
            [along * SPEED, DVec3::ZERO]
        };
        let mut air = engine.air(setup, &|_| (0.0, stream.to_array()));
        let front = DVec3::new(16.37, 15.69, -0.5) - along * (0.5 * length);
        let mut positions = Vec::new();
        for i in 0..=CELLS {
            positions
                .extend((0..=4).map(|j| front + along * f64::from(i) + DVec3::Z * f64::from(j)));
        }
        let mut triangles = Vec::new();
        for (i, j) in (0..CELLS).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let [a, b] = [i * 5 + j, (i + 1) * 5 + j];
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
        let friction = vec![Friction::Model; triangles.len()];
        let mut surface = CutSurface::new(&air, triangles, positions.len(), (0, None))
            .with_friction(friction, 0.0, &positions);
        let velocities = vec![motion; positions.len()];
        let before = mass_and_momentum(&air);
        let (mut given, mut drag) = (DVec3::ZERO, 0.0);
        // Two and a half lengths, of which the last is judged.
        for number in 0..400 {
            let force = step(&mut air, &mut surface, &positions, &velocities);
            for position in &mut positions {
                *position += motion;
            }
            given += force;
            if number >= 240 {
                drag -= force.dot(along);
            }
        }
        let coefficient = drag / (0.5 * SPEED * SPEED * 2.0 * length * 4.0 * 160.0);
        let law = 0.455 / REYNOLDS.log10().powf(2.58);
        let off = coefficient / law - 1.0;
        assert!(
            off.abs() < tolerances::FRICTION_OF_A_PLATE,
            "{coefficient} {law}"
        );
        let after = mass_and_momentum(&air);
        let cells = grid.iter().product::<usize>() as f64;
        let kept = 10.0 * tolerances::conservation(engine) * cells;
        assert!((after[0] - before[0]).abs() < kept, "mass");
        for a in 0..3 {
            let gained = after[a + 1] - before[a + 1];
            assert!((gained - given[a]).abs() < kept, "{gained} {}", given[a]);
        }
    }
}

#[derive(Clone, Copy)]
struct LightCanopy;

impl Body for LightCanopy {
    /// A folded canopy of a hundredth of its weight opens where the air slides along it, with the model and without: stable at once, the routes of the force agree, and the air keeps its mass.
    fn run(self, engine: Engine) {
        for friction in ["none", "model"] {
            let friction = format!("fabric.friction={friction}");
            let case = canopy(&[&friction, OPERATOR, "coupling.mass_factor=0.01"]);
            let plan = Plan::new(&case.scene, engine.plan_placement());
            let record = without_files(&case, plan, engine.device()).unwrap().1;
            let [links, momentum_box, defect, open] = [
                "impulse_markers_n_s",
                "impulse_momentum_box_n_s",
                "mass_defect",
                "projected_diameter_ratio",
            ]
            .map(|name| latest(&record, name).unwrap());
            assert!(
                (momentum_box / links - 1.0).abs() < tolerances::cut_momentum_box(engine),
                "{friction}: {momentum_box} against {links}"
            );
            assert!(
                defect.abs() < tolerances::cut_mass(engine),
                "{friction}: {defect:e}"
            );
            assert!(open > 0.25 && open < 1.0, "{friction}: {open}");
        }
    }
}

/// A run with boundary layers, stored and taken up, goes on bit by bit.
fn taken_up_alike() {
    let case = canopy(&["time.end_s=0.02", "fabric.friction=model", OPERATOR]);
    goes_on_alike(&case);
}
