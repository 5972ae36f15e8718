//! Sound at inlet, outlet and sides: what leaves the air does not come back, and nothing flows in its place.

use libtest_mimic::Trial;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};

use crate::air::{advance, periodic};
use crate::engines::{Body, Engine, on_every_engine, states};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("sound::leaves_through_the_outlet", Pulse),
        on_every_engine("sound::leaves_through_inlet_and_sides", Echo),
        on_every_engine("sound::nothing_flows_through_sides_in_the_mean", Leak),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[derive(Clone, Copy)]
struct Echo;

impl Body for Echo {
    /// A plane packet of sound of 48 cells' length meets the inlet in wind, there at 30° to its normal, too, and an absorbing side.
    fn run(self, engine: Engine) {
        let sound = (1f64 / 3.0).sqrt();
        let (wind, length, width) = (0.05, 48.0, 48.0);
        let cells = 400;
        for (axis, angle_deg) in [(0, 0.0), (0, 30.0_f64), (1, 0.0), (2, 0.0)] {
            let absorbing = Faces::Walls([Wall::Absorbing, Wall::FreeSlip]);
            let (along, normal) = angle_deg.to_radians().sin_cos();
            let mut setup = Setup {
                cells: [3; 3],
                ends: StreamwiseEnds::Periodic,
                sides: Sides::Periodic,
                ..periodic([1; 3], 0.5001, Operator::StabilisedRegularised)
            };
            setup.cells[axis] = cells;
            match axis {
                0 => setup.ends = StreamwiseEnds::InletOutlet,
                1 => setup.sides = Sides::Each([absorbing, Faces::Periodic]),
                _ => setup.sides = Sides::Each([Faces::Periodic, absorbing]),
            }
            // One wave along the face; nothing changes along the third axis.
            let other = (axis + 1) % 3;
            if along > 0.0 {
                setup.cells[other] = (length / along).round() as usize;
                setup.cells[3 - axis - other] = 1;
            }
            let packet = |cell: [usize; 3]| {
                let place = cell[axis] as f64 + 0.5 - 192.0;
                let beside = cell[other] as f64 + 0.5;
                let phase = std::f64::consts::TAU * (normal * place - along * beside) / length;
                let excess = 1e-3 * (-0.5 * (place / width).powi(2)).exp() * phase.cos();
                let mut u = [wind, 0.0, 0.0];
                u[axis] -= sound * excess * normal;
                u[other] += sound * excess * along;
                (excess, u)
            };
            let mut air = engine.air(setup, &packet);
            air.set_inlet_velocity([wind, 0.0, 0.0]);
            let against = if axis == 0 { wind } else { 0.0 };
            let speed = sound * normal;
            // All of it has been there, and what came back is still before the other end.
            let steps = 192.0 / (speed - against) + 192.0 / (speed + against);
            advance(&mut air, steps as usize);
            let back = states(&air)
                .iter()
                .map(|(excess, _)| excess.abs())
                .fold(0.0, f64::max);
            assert!(
                back / 1e-3 < tolerances::FACE_REFLECTION,
                "axis {axis}, {angle_deg} deg: {back:e}"
            );
        }
    }
}

#[derive(Clone, Copy)]
struct Leak;

impl Body for Leak {
    /// All air is pressed towards a side for long. At first some leaves there and enters opposite; once the running means know the pressure, it
    /// stands as between solid walls. Without them it would go on to flow, at κ times the density excess at the sides.
    fn run(self, engine: Engine) {
        let n = 24;
        let acceleration = 1e-5;
        let absorbing = Faces::Walls([Wall::Absorbing; 2]);
        let setup = Setup {
            cells: [4, n, 4],
            ends: StreamwiseEnds::Periodic,
            sides: Sides::Each([absorbing, Faces::Periodic]),
            ..periodic([1; 3], 0.6, Operator::StabilisedRegularised)
        };
        let mut air = engine.air(setup, &|_| (0.0, [0.0; 3]));
        for _ in 0..12_000 {
            air.collide_stream(Some([0.0, acceleration, 0.0]), None)
                .unwrap();
        }
        let states = states(&air);
        let excess = |y: usize| states[4 * y].0;
        // δρ = 3 p, and p rises by a per cell.
        let rise = (excess(n - 1) - excess(0)) / (3.0 * acceleration * (n - 1) as f64);
        assert!((rise - 1.0).abs() < 0.02, "{rise}");
        // The bare velocity lacks half of what the step adds.
        let through = states
            .iter()
            .map(|(_, u)| (u[1] + 0.5 * acceleration).abs())
            .fold(0.0, f64::max);
        assert!(through < tolerances::THROUGH_SIDES, "{through:e}");
    }
}

#[derive(Clone, Copy)]
struct Pulse;

impl Body for Pulse {
    /// A plane pulse of sound meets the outlet in wind, with an edge of frictionless walls around it (F7).
    fn run(self, engine: Engine) {
        let n = 160;
        let (wind, sound) = (0.08, (1f64 / 3.0).sqrt());
        let setup = Setup {
            cells: [n, 5, 4],
            ends: StreamwiseEnds::InletOutlet,
            sides: Sides::FreeSlip,
            ..periodic([1; 3], 0.501, Operator::RecursiveRegularised)
        };
        let pulse = |[x, _, _]: [usize; 3]| {
            let excess = 1e-3 * (-0.5 * ((x as f64 + 0.5 - 90.0) / 10.0).powi(2)).exp();
            (excess, [wind + sound * excess, 0.0, 0.0])
        };
        let mut air = engine.air(setup, &pulse);
        air.set_inlet_velocity([wind, 0.0, 0.0]);
        // At the outlet after 70 cells, back in the middle after 80 more.
        let steps = 70.0 / (sound + wind) + 80.0 / (sound - wind);
        advance(&mut air, steps as usize);
        let back = states(&air)
            .iter()
            .map(|(excess, u)| (0.5 * (excess - (u[0] - wind) / sound)).abs())
            .fold(0.0, f64::max);
        assert!(back / 1e-3 < tolerances::OUTLET_REFLECTION, "{back:e}");
    }
}
