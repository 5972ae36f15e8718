use super::super::{Fluid, Stored};
use super::{BodyForce, ForcedCells};
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::lattice::grid::{Setup, Sides, StreamwiseEnds};
use crate::lattice::{DIRECTION_COUNT, Operator, Real};

/// Instruction sets of this CPU that round products and sums once.
fn fused_sets() -> Vec<pulp::Arch> {
    #[cfg(target_arch = "x86_64")]
    {
        let mut sets = Vec::new();
        sets.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        sets.extend(pulp::x86::V4::try_new().map(pulp::Arch::V4));
        sets
    }
    #[cfg(not(target_arch = "x86_64"))]
    vec![pulp::Arch::new()]
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
        inlet_profile: None,
        sponge_cells: tunnel.then_some(13.0),
        idle: None,
        operator,
        eddy_viscosity: eddy,
    }
}

/// Populations of all cells after some steps with force on a few.
fn populations<P: Stored>(
    setup: &Setup,
    instructions: pulp::Arch,
    acceleration: Option<[f64; 3]>,
) -> Vec<Vec<P>> {
    let mut air = Fluid::<P>::new(
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

/// All vectors give the same bits; scalars, which round products by themselves, differ by rounding: `tolerance`, in populations of up to
/// 0.03, after 21 steps.
fn same_under_all_instruction_sets<P: Stored>(tolerance: f64) {
    for operator in Operator::ALL {
        for eddy in eddy_viscosities() {
            for tunnel in [false, true] {
                for acceleration in [None, Some([1e-4, 0.0, -2e-4])] {
                    let setup = setup(operator, eddy, tunnel);
                    let scalar = populations::<P>(&setup, pulp::Arch::Scalar, acceleration);
                    assert!(
                        scalar
                            .iter()
                            .flatten()
                            .any(|f| f.unpacked().to_f64() != 0.0)
                    );
                    let mut first: Option<Vec<Vec<P>>> = None;
                    for set in fused_sets() {
                        let what = format!("{set:?} {operator:?} {eddy:?} {tunnel}");
                        let vector = populations::<P>(&setup, set, acceleration);
                        let pairs = scalar.iter().flatten().zip(vector.iter().flatten());
                        let difference = pairs
                            .map(|(a, b)| (a.unpacked().to_f64() - b.unpacked().to_f64()).abs())
                            .fold(0.0, |largest: f64, d| {
                                if d > largest || d.is_nan() {
                                    d
                                } else {
                                    largest
                                }
                            });
                        assert!(difference < tolerance, "{what}: {difference:e}");
                        if let Some(first) = &first {
                            for (array, (one, other)) in first.iter().zip(&vector).enumerate() {
                                let same = bytemuck::cast_slice::<P, u8>(one)
                                    == bytemuck::cast_slice::<P, u8>(other);
                                assert!(same, "{what}: array {array}");
                            }
                        }
                        first.get_or_insert(vector);
                    }
                }
            }
        }
    }
}

#[test]
fn same_populations_under_all_instruction_sets() {
    same_under_all_instruction_sets::<f32>(1e-7);
    same_under_all_instruction_sets::<f64>(2e-16);
    // Two neighbours among the numbers of 16 bits, now and then.
    same_under_all_instruction_sets::<half::f16>(6e-5);
}

/// Leaving out the force terms where no force acts is exact.
#[test]
fn a_force_of_zero_changes_nothing() {
    fn check<P: Stored>() {
        for operator in Operator::ALL {
            let setup = setup(operator, Some(EddyViscosity::wale(0.5)), true);
            let without = populations::<P>(&setup, pulp::Arch::new(), None);
            let with = populations::<P>(&setup, pulp::Arch::new(), Some([0.0; 3]));
            for (a, b) in without.iter().flatten().zip(with.iter().flatten()) {
                assert!(a == b, "{operator:?}: {a:?} {b:?}");
            }
        }
    }
    check::<f32>();
    check::<f64>();
    check::<half::f16>();
}
