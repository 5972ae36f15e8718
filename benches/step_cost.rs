//! tmp
use ripstop::cpu::fluid::*;
fn main() {
    for (op, les) in [
        (Operator::TwoRelaxationTimes, None),
        (Operator::RecursiveRegularised, Some(0.15)),
    ] {
        for ends in [StreamwiseEnds::Periodic, StreamwiseEnds::InletOutlet] {
            let mut f = Fluid::<f32>::new(
                Setup {
                    cells: [120, 72, 72],
                    ends,
                    sides: if ends == StreamwiseEnds::Periodic {
                        Sides::Periodic
                    } else {
                        Sides::FreeSlip
                    },
                    relaxation_time: 0.500003,
                    sponge_cells: if ends == StreamwiseEnds::Periodic {
                        None
                    } else {
                        Some(18.0)
                    },
                    operator: op,
                    smagorinsky_constant: les,
                },
                |_| (0.0, [0.08, 0.0, 0.0]),
            );
            f.set_inlet_velocity([0.08, 0.0, 0.0]);
            for _ in 0..10 {
                f.collide_stream(&BodyForce::default());
            }
            let t = std::time::Instant::now();
            for _ in 0..100 {
                f.collide_stream(&BodyForce::default());
            }
            let s = t.elapsed().as_secs_f64() / 100.0;
            println!(
                "{op:?} {ends:?} {:.3} ms {:.1} MLUPS {:?}",
                s * 1e3,
                622080.0 / s / 1e6,
                f.breakdown(0.3)
            );
            let t = std::time::Instant::now();
            for _ in 0..20 {
                f.breakdown(0.3);
            }
            println!("  scan {:.3} ms", t.elapsed().as_secs_f64() / 20.0 * 1e3);
        }
    }
}
