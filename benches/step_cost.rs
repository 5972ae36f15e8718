//! tmp
use ripstop::cpu::fluid::*;
fn main() {
    for rep in 0..2 {
        for (ends, sides, sponge) in [
            (StreamwiseEnds::Periodic, Sides::Periodic, None),
            (StreamwiseEnds::Periodic, Sides::FreeSlip, None),
            (StreamwiseEnds::Periodic, Sides::FreeSlip, Some(18.0)),
            (StreamwiseEnds::InletOutlet, Sides::Periodic, None),
            (StreamwiseEnds::InletOutlet, Sides::FreeSlip, None),
            (StreamwiseEnds::InletOutlet, Sides::FreeSlip, Some(18.0)),
        ] {
            let mut f = Fluid::<f32>::new(
                Setup {
                    cells: [120, 72, 72],
                    ends,
                    sides,
                    relaxation_time: 0.500003,
                    sponge_cells: sponge,
                    operator: Operator::RecursiveRegularised,
                    smagorinsky_constant: Some(0.15),
                },
                |c| {
                    (
                        0.0,
                        [
                            0.08,
                            0.01 * ((c[0] + c[1]) as f64 * 0.3).sin(),
                            0.01 * ((c[0] + c[2]) as f64 * 0.2).cos(),
                        ],
                    )
                },
            );
            f.set_inlet_velocity([0.08, 0.0, 0.0]);
            for _ in 0..10 {
                f.collide_stream(&BodyForce::default());
            }
            let t = std::time::Instant::now();
            for _ in 0..150 {
                f.collide_stream(&BodyForce::default());
            }
            let s = t.elapsed().as_secs_f64() / 150.0;
            println!(
                "{rep} {ends:?} {sides:?} {sponge:?} {:.3} ms {:.1} MLUPS",
                s * 1e3,
                622080.0 / s / 1e6
            );
        }
    }
}
