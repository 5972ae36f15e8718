//! Validation: problems with known answers, computed through the public interface of the crate, one file per problem.
//!
//! Each problem computes a few flows and adds rows to a [`Report`]: a quantity, its reference, its error, and the gate that it must pass.
//! The quick set takes about a minute and a half on two CPU cores; coarse grids have gates of their own there, which the row says. `--full` takes
//! the sizes for which the reference gates are meant.

mod acoustic_pulse;
mod aero;
mod beltrami;
mod cavity;
mod cloth;
mod couette;
mod coupling;
mod disk;
mod drag;
mod falling_disk;
mod flows;
mod levels;
mod openings;
mod permeable_screen;
mod poiseuille;
mod report;
mod session;
mod shear_layer;
mod sliding_wall;
mod soak;
mod sphere;
mod taylor_green;
mod taylor_green_vortex;
mod wall_friction;
mod wing_lift;

use std::sync::atomic::AtomicBool;
use std::time::Instant;

pub use report::{Gate, Machine, Report, Row};
use session::Session;
pub use session::{Order, Problem, Stop};

use crate::run::Observer;

/// All problems, cheap ones first.
pub const PROBLEMS: [Problem; 45] = [
    Problem {
        name: "poiseuille",
        updates: [92.0, 800.0],
        compute: poiseuille::compute,
    },
    Problem {
        name: "couette",
        updates: [7.0, 60.0],
        compute: couette::compute,
    },
    Problem {
        name: "taylor-green",
        updates: [27.0, 435.0],
        compute: taylor_green::compute,
    },
    Problem {
        name: "beltrami",
        updates: [280.0, 8_900.0],
        compute: beltrami::compute,
    },
    Problem {
        name: "acoustic-pulse",
        updates: [110.0, 110.0],
        compute: acoustic_pulse::compute,
    },
    Problem {
        name: "levels",
        updates: [20.0, 700.0],
        compute: levels::compute,
    },
    Problem {
        name: "soak",
        updates: [41.0, 410.0],
        compute: soak::compute,
    },
    Problem {
        name: "permeable-screen",
        updates: [60.0, 60.0],
        compute: permeable_screen::compute,
    },
    Problem {
        name: "openings",
        updates: [240.0, 9_600.0],
        compute: openings::compute,
    },
    Problem {
        name: "sliding-wall",
        updates: [1_580.0, 23_000.0],
        compute: sliding_wall::compute,
    },
    Problem {
        name: "wall-friction",
        updates: [80.0, 15_500.0],
        compute: wall_friction::compute,
    },
    Problem {
        name: "wing-lift",
        updates: [250.0, 28_000.0],
        compute: wing_lift::compute,
    },
    Problem {
        name: "sphere",
        updates: [500.0, 35_000.0],
        compute: sphere::compute,
    },
    Problem {
        name: "disk",
        updates: [680.0, 21_000.0],
        compute: disk::compute,
    },
    Problem {
        name: "falling-disk",
        updates: [360.0, 5_800.0],
        compute: falling_disk::compute,
    },
    Problem {
        name: "shear-layer",
        updates: [130.0, 73_000.0],
        compute: shear_layer::compute,
    },
    Problem {
        name: "taylor-green-vortex",
        updates: [2_140.0, 34_200.0],
        compute: taylor_green_vortex::compute,
    },
    Problem {
        name: "cavity",
        updates: [800.0, 80_000.0],
        compute: cavity::compute,
    },
    Problem {
        name: "immersed-boundary",
        updates: [5.0, 5.0],
        compute: coupling::immersed_boundary::compute,
    },
    Problem {
        name: "spherical-couette",
        updates: [80.0, 2_000.0],
        compute: coupling::spherical_couette::compute,
    },
    Problem {
        name: "marker-spacing",
        updates: [1_160.0, 190_000.0],
        compute: coupling::marker_spacing::compute,
    },
    Problem {
        name: "force-routes",
        updates: [178.0, 25_000.0],
        compute: coupling::force_routes::compute,
    },
    Problem {
        name: "levels-around-bodies",
        updates: [900.0, 60_000.0],
        compute: coupling::levels_around_bodies::compute,
    },
    Problem {
        name: "canopy-opening",
        updates: [700.0, 60_000.0],
        compute: coupling::canopy_opening::compute,
    },
    Problem {
        name: "flexible-plate",
        updates: [76.0, 44_700.0],
        compute: coupling::flexible_plate::compute,
    },
    Problem {
        name: "flag",
        updates: [187.0, 444_000.0],
        compute: coupling::flag::compute,
    },
    Problem {
        name: "light-canopies",
        updates: [138.0, 32_600.0],
        compute: coupling::light_canopies::compute,
    },
    Problem {
        name: "potential-bodies",
        updates: [30.0, 600.0],
        compute: aero::potential_bodies::compute,
    },
    Problem {
        name: "plane-section",
        updates: [10.0, 60.0],
        compute: aero::plane_section::compute,
    },
    Problem {
        name: "rectangular-wings",
        updates: [120.0, 500.0],
        compute: aero::rectangular_wings::compute,
    },
    Problem {
        name: "elliptic-wing",
        updates: [60.0, 800.0],
        compute: aero::elliptic_wing::compute,
    },
    Problem {
        name: "viscous-sections",
        updates: [60.0, 400.0],
        compute: aero::viscous_sections::compute,
    },
    Problem {
        name: "wing-stall",
        updates: [60.0, 400.0],
        compute: aero::wing_stall::compute,
    },
    Problem {
        name: "belloc-wing",
        updates: [60.0, 400.0],
        compute: aero::belloc_wing::compute,
    },
    Problem {
        name: "trim",
        updates: [60.0, 300.0],
        compute: aero::trim::compute,
    },
    Problem {
        name: "membrane-patch",
        updates: [5.0, 30.0],
        compute: cloth::patch::compute,
    },
    Problem {
        name: "catenary",
        updates: [5.0, 5.0],
        compute: cloth::catenary::compute,
    },
    Problem {
        name: "hencky",
        updates: [60.0, 1000.0],
        compute: cloth::hencky::compute,
    },
    Problem {
        name: "airbag",
        updates: [200.0, 1500.0],
        compute: cloth::airbag::compute,
    },
    Problem {
        name: "pressure-vessels",
        updates: [60.0, 1000.0],
        compute: cloth::pressure_vessels::compute,
    },
    Problem {
        name: "shear-panel",
        updates: [40.0, 300.0],
        compute: cloth::shear_panel::compute,
    },
    Problem {
        name: "heavy-cantilever",
        updates: [60.0, 300.0],
        compute: cloth::heavy_cantilever::compute,
    },
    Problem {
        name: "drum",
        updates: [60.0, 500.0],
        compute: cloth::drum::compute,
    },
    Problem {
        name: "free-oscillations",
        updates: [60.0, 300.0],
        compute: cloth::free_oscillations::compute,
    },
    Problem {
        name: "hostile-starts",
        updates: [60.0, 500.0],
        compute: cloth::hostile_starts::compute,
    },
];

/// The problem of the name `filter`, or else all whose name contains it; all without one.
#[must_use]
pub fn chosen(filter: Option<&str>) -> Vec<Problem> {
    let named = |name: &str| filter == Some(name);
    let exact = PROBLEMS.iter().any(|problem| named(problem.name));
    PROBLEMS
        .into_iter()
        .filter(|problem| match filter {
            _ if exact => named(problem.name),
            Some(text) => problem.name.contains(text),
            None => true,
        })
        .collect()
}

/// Computes the problems of an order; also returns what ended it early.
pub fn validate(
    order: &Order,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> (Report, Result<(), Stop>) {
    let size = usize::from(order.full);
    let mut session = Session {
        order,
        interrupt,
        observer,
        report: Report::new(order.full, order.placement, order.device.as_deref()),
        problem: "",
        planned: order.problems.iter().map(|p| p.updates[size]).sum(),
        done: 0.0,
        problem_end: 0.0,
        began: Instant::now(),
    };
    let mut end = Ok(());
    for problem in &order.problems {
        let start = session.problem_end;
        session.problem = problem.name;
        session.done = start;
        session.problem_end = start + problem.updates[size];
        session.began = Instant::now();
        match (problem.compute)(&mut session) {
            // The others can be computed all the same.
            Err(Stop::Refused(why)) => {
                let what = format!("cannot be computed: {why}");
                let row = session.row([0; 3], what, f64::NAN);
                // In 16 bits, too, where flows are only stated.
                row.is_judged = true;
                row.gate(Gate::AtMost(0.0));
            }
            ended => end = ended,
        }
        if end.is_err() {
            break;
        }
    }
    let mut report = session.report;
    // Whatever ended it, problems are missing.
    report.interrupted = end.is_err();
    (report, end)
}

#[cfg(test)]
mod tests {
    use super::session::tests::Nobody;
    use super::*;
    use crate::plan::{AirPlacement, Precision};

    /// A problem that cannot be set up fails, and the next one is computed.
    #[test]
    fn a_refusal_is_a_failed_row() {
        for (precision, of_the_other) in
            [(Precision::F32, Some(true)), (Precision::F16Storage, None)]
        {
            let refused = Problem {
                name: "refused",
                updates: [1.0; 2],
                compute: |_| Err(Stop::Refused("the sheet cannot be built".to_owned())),
            };
            let computed = Problem {
                name: "computed",
                updates: [1.0; 2],
                compute: |session| {
                    session.row([1; 3], "error", 0.0).gate(Gate::AtMost(1.0));
                    Ok(())
                },
            };
            let order = Order {
                problems: vec![refused, computed],
                full: false,
                placement: AirPlacement::Cpu(precision),
                device: None,
            };
            let (report, end) = validate(&order, &AtomicBool::new(false), &mut Nobody);
            assert!(end.is_ok() && !report.interrupted);
            let holds: Vec<_> = report.rows.iter().map(|row| row.holds).collect();
            assert_eq!(holds, [Some(false), of_the_other], "{}", report.table());
            assert!(!report.holds());
        }
    }

    #[test]
    fn a_name_means_one_problem_and_a_part_of_it_all() {
        let names =
            |filter| -> Vec<&str> { chosen(filter).iter().map(|problem| problem.name).collect() };
        assert_eq!(names(Some("taylor-green")), ["taylor-green"]);
        assert_eq!(
            names(Some("taylor")),
            ["taylor-green", "taylor-green-vortex"]
        );
        assert_eq!(names(None).len(), PROBLEMS.len());
        assert!(names(Some("warp-drive")).is_empty());
    }
}
