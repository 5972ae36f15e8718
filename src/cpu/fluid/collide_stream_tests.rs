use super::super::Fluid;
use super::{BodyForce, ForcedCells};
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::lattice::grid::{Setup, Sides, StreamwiseEnds};
use crate::lattice::{DIRECTION_COUNT, Operator, Real};

/// Instruction sets of this CPU, plain scalars first.
fn instruction_sets() -> Vec<pulp::Arch> {
    let mut sets = vec![pulp::Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        sets.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        sets.extend(pulp::x86::V4::try_new().map(pulp::Arch::V4));
    }
    #[cfg(not(target_arch = "x86_64"))]
    sets.push(pulp::Arch::new());
    sets
}

/// None, and every model.
fn eddy_viscosities() -> [Option<EddyViscosity>; 4] {
    [
        None,
        Some(EddyViscosity::smagorinsky(0.15)),
        Some(EddyViscosity::wale(0.5)),
        Some(EddyViscosity::vreman(0.07)),
    ]
}

fn setup(operator: Operator, eddy: Option<EddyViscosity>, tunnel: bool) -> Setup {
    Setup {
        // One block of single precision, one vector and a rest; the sponge begins within a block.
        cells: [37, 7, 9],
        ends: if tunnel {
            StreamwiseEnds::InletOutlet
        } else {
            StreamwiseEnds::Periodic
        },
        sides: if tunnel {
            Sides::FreeSlip
        } else {
            Sides::Periodic
        },
        relaxation_time: 0.52,
        sponge_cells: tunnel.then_some(13.0),
        operator,
        eddy_viscosity: eddy,
    }
}

/// Populations of all cells after some steps with force on a few.
fn populations<T: Real>(
    setup: &Setup,
    instructions: pulp::Arch,
    acceleration: Option<[f64; 3]>,
) -> Vec<Vec<T>> {
    let mut air = Fluid::<T>::new(
        setup.clone(),
        Some(&|[x, y, z]: [usize; 3]| {
            let wave = |a: usize, b: usize| 0.03 * ((3 * a + 5 * b + 1) as f64).sin();
            (wave(x, z), [wave(x, y), wave(y, z), wave(z, x)])
        }),
    );
    air.instructions = instructions;
    air.set_inlet_velocity([0.02, 0.0, 0.0]);
    // Rows 10 and 31: touched blocks apart, side by side, and in the rest behind whole vectors.
    let x = [0, 3, 16, 20, 36, 33];
    let force = [[1e-3, -2e-3, 5e-4]; 6];
    let cells = ForcedCells {
        rows: &[(10, 0, 5), (31, 5, 6)],
        x: &x,
        force: &force,
    };
    for _ in 0..21 {
        air.collide_stream(&BodyForce {
            acceleration,
            cells,
        });
    }
    (0..DIRECTION_COUNT)
        .map(|array| {
            let rows = air.grid.rows();
            rows.flat_map(|row| air.populations[array][row].to_vec())
                .collect()
        })
        .collect()
}

fn same_bits<T: Real>() {
    for operator in Operator::ALL {
        for eddy in eddy_viscosities() {
            for tunnel in [false, true] {
                for acceleration in [None, Some([1e-4, 0.0, -2e-4])] {
                    let setup = setup(operator, eddy, tunnel);
                    let sets = instruction_sets();
                    let scalar = populations::<T>(&setup, sets[0], acceleration);
                    assert!(scalar.iter().flatten().any(|f| f.to_f64() != 0.0));
                    for set in &sets[1..] {
                        let vector = populations::<T>(&setup, *set, acceleration);
                        for (array, (one, lanes)) in scalar.iter().zip(&vector).enumerate() {
                            assert!(
                                bytemuck::cast_slice::<T, u8>(one)
                                    == bytemuck::cast_slice::<T, u8>(lanes),
                                "{set:?} {operator:?} {eddy:?} {tunnel}: array {array}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn same_bits_under_all_instruction_sets() {
    same_bits::<f32>();
    same_bits::<f64>();
}

/// Leaving out the force terms where no force acts is exact.
#[test]
fn a_force_of_zero_changes_nothing() {
    fn check<T: Real>() {
        for operator in Operator::ALL {
            let setup = setup(operator, Some(EddyViscosity::wale(0.5)), true);
            let without = populations::<T>(&setup, pulp::Arch::new(), None);
            let with = populations::<T>(&setup, pulp::Arch::new(), Some([0.0; 3]));
            for (a, b) in without.iter().flatten().zip(with.iter().flatten()) {
                assert!(a == b, "{operator:?}: {a:?} {b:?}");
            }
        }
    }
    check::<f32>();
    check::<f64>();
}
