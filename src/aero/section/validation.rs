//! The method against XFOIL, wind tunnels and itself.

use std::collections::BTreeMap;

use glam::DVec2;

use super::shapes;
use super::{Conditions, Section, SectionError, SectionState};

fn conditions(reynolds: f64, forced: Option<f64>) -> Conditions {
    Conditions {
        reynolds,
        critical_amplification: 9.0,
        forced_transition: [forced; 2],
    }
}

fn solve(
    outline: &[DVec2],
    degrees: &[f64],
    conditions: &Conditions,
) -> Vec<Result<SectionState, SectionError>> {
    let angles: Vec<f64> = degrees.iter().map(|d| d.to_radians()).collect();
    Section::new(outline, 160)
        .unwrap()
        .polar(&angles, conditions)
}

/// XFOIL 6.99, 160 panels, computed 2026-11-25 on the same outlines: section, Reynolds number, whether transition is forced at x/c = 0.03 on both
/// sides; angle [degrees], C_l, C_d, C_m, x/c of transition on the upper and lower side.
const XFOIL: &[(&str, f64, bool, [f64; 6])] = &[
    (
        "0012",
        0.5e6,
        false,
        [0.0, 0.0, 0.00616, -0.0, 0.7921, 0.7921],
    ),
    (
        "0012",
        0.5e6,
        false,
        [2.0, 0.2081, 0.00695, 0.006, 0.5806, 0.936],
    ),
    (
        "0012",
        0.5e6,
        false,
        [6.0, 0.7214, 0.01167, -0.0099, 0.1006, 1.0],
    ),
    (
        "0012",
        0.5e6,
        false,
        [8.0, 0.8852, 0.01477, 0.0008, 0.0493, 1.0],
    ),
    ("0012", 6.0e6, true, [0.0, 0.0, 0.00806, -0.0, 0.03, 0.03]),
    (
        "0012",
        6.0e6,
        true,
        [4.0, 0.4565, 0.00845, -0.0011, 0.03, 0.03],
    ),
    (
        "0012",
        6.0e6,
        true,
        [8.0, 0.9036, 0.00987, -0.0009, 0.0235, 0.03],
    ),
    (
        "2412",
        1.0e6,
        false,
        [-4.0, -0.1932, 0.00759, -0.0552, 0.8887, 0.1304],
    ),
    (
        "2412",
        1.0e6,
        false,
        [0.0, 0.2411, 0.00562, -0.0517, 0.6571, 0.6809],
    ),
    (
        "2412",
        1.0e6,
        false,
        [4.0, 0.7167, 0.007, -0.0566, 0.3858, 0.9999],
    ),
    (
        "2412",
        1.0e6,
        false,
        [8.0, 1.0886, 0.01251, -0.0437, 0.0591, 0.9999],
    ),
    (
        "2412",
        1.0e6,
        false,
        [11.0, 1.3467, 0.01788, -0.0326, 0.025, 0.9999],
    ),
    (
        "2412",
        6.0e6,
        false,
        [0.0, 0.2471, 0.00525, -0.0526, 0.4596, 0.3021],
    ),
    (
        "2412",
        6.0e6,
        false,
        [6.0, 0.9108, 0.00729, -0.0516, 0.0658, 0.9975],
    ),
    (
        "4412",
        2.0e6,
        false,
        [-2.0, 0.2604, 0.00633, -0.1032, 0.6592, 0.1402],
    ),
    (
        "4412",
        2.0e6,
        false,
        [2.0, 0.6985, 0.00535, -0.1013, 0.4795, 0.9279],
    ),
    (
        "4412",
        2.0e6,
        false,
        [6.0, 1.1346, 0.00806, -0.0999, 0.2615, 0.9998],
    ),
    (
        "4418",
        1.0e6,
        true,
        [0.0, 0.4148, 0.01347, -0.0845, 0.03, 0.03],
    ),
    (
        "4418",
        1.0e6,
        true,
        [5.0, 0.8905, 0.0161, -0.0697, 0.03, 0.03],
    ),
    (
        "23015",
        1.0e6,
        false,
        [-3.0, -0.1945, 0.0072, -0.0095, 0.7114, 0.3598],
    ),
    (
        "23015",
        1.0e6,
        false,
        [3.0, 0.4499, 0.00771, -0.0012, 0.2773, 0.9105],
    ),
    (
        "23015",
        1.0e6,
        false,
        [8.0, 1.0838, 0.01148, -0.0184, 0.1572, 0.9995],
    ),
];

/// C_l to 0.003, C_d to 0.6 % and C_m to 0.0008 in attached flow, transition to 0.002 chords.
#[test]
fn polars_are_those_of_xfoil() {
    let mut groups: BTreeMap<(&str, u64, bool), Vec<[f64; 6]>> = BTreeMap::new();
    for &(name, reynolds, is_forced, row) in XFOIL {
        let key = (name, reynolds as u64, is_forced);
        groups.entry(key).or_default().push(row);
    }
    for ((name, reynolds, is_forced), rows) in groups {
        let degrees: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        let conditions = conditions(reynolds as f64, is_forced.then_some(0.03));
        let states = solve(&shapes::naca(name), &degrees, &conditions);
        for (row, state) in rows.iter().zip(states) {
            let s = state.unwrap();
            let [_, lift, drag, moment, upper, lower] = *row;
            let about = format!("{name} {reynolds} {row:?}: {s:?}");
            assert!((s.lift - lift).abs() < 0.003, "{about}");
            assert!((s.drag / drag - 1.0).abs() < 0.006, "{about}");
            assert!((s.moment_quarter_chord - moment).abs() < 0.0008, "{about}");
            assert!((s.transition[0] - upper).abs() < 0.002, "{about}");
            assert!((s.transition[1] - lower).abs() < 0.002, "{about}");
        }
    }
}

/// Largest lift at Re 6e6, smooth: Abbott, von Doenhoff & Stivers, NACA Report 824 (1945), digitised by others. The method finds up to a fifth more.
#[test]
fn largest_lift_is_somewhat_above_the_tunnel() {
    let degrees: Vec<f64> = (10..=22).map(f64::from).collect();
    for (name, measured) in [("2412", 1.69), ("23015", 1.70), ("4412", 1.64)] {
        let states = solve(&shapes::naca(name), &degrees, &conditions(6e6, None));
        let lifts: Vec<f64> = states.iter().flatten().map(|s| s.lift).collect();
        let most = lifts.iter().copied().fold(0.0, f64::max);
        assert!(
            (0.98..1.2).contains(&(most / measured)),
            "{name} {most} {measured}"
        );
        // The sweep goes past it.
        assert!(lifts[lifts.len() - 1] < most - 0.005, "{name} {lifts:?}");
    }
}

/// From 0 to 18 degrees, beyond the largest lift of most: at least 95 % of the angles have a solution, and those hang together.
#[test]
fn sweeps_go_through() {
    let degrees: Vec<f64> = (0..=18).map(f64::from).collect();
    let (mut solved, mut tried) = (0, 0);
    let flap = shapes::with_flap(&shapes::paraglider(), 15.0);
    for (outline, reynolds) in [
        (shapes::naca("0012"), 5e5),
        (shapes::naca("4412"), 1e6),
        (shapes::naca("23015"), 2e6),
        (shapes::paraglider(), 1e6),
        (flap, 1e6),
        (shapes::naca("2421"), 2e6),
    ] {
        let states = solve(&outline, &degrees, &conditions(reynolds, None));
        tried += states.len();
        solved += states.iter().flatten().count();
        let states: Vec<&SectionState> = states.iter().flatten().collect();
        for pair in states.windows(2) {
            // Potential flow's slope is 0.11 per degree; a jump between solutions would exceed it.
            let rise = (pair[1].lift - pair[0].lift)
                / (pair[1].angle_rad - pair[0].angle_rad).to_degrees();
            assert!((-0.13..0.2).contains(&rise), "{reynolds} {pair:?}");
            assert!(pair[0].drag > pair[0].friction_drag && pair[0].friction_drag > 0.0);
        }
    }
    assert!(
        solved as f64 >= 0.95 * f64::from(tried as u32),
        "{solved} of {tried}"
    );
}

/// A symmetric section has a symmetric polar, also at zero, where the stagnation point lies on a node.
#[test]
fn symmetric_sections_have_symmetric_polars() {
    let states = solve(
        &shapes::naca("0012"),
        &[-4.0, 0.0, 4.0],
        &conditions(1e6, None),
    );
    let [down, level, up] = [0, 1, 2].map(|k| states[k].clone().unwrap());
    assert!(level.lift.abs() < 1e-5 && level.moment_quarter_chord.abs() < 1e-5);
    assert!((down.lift + up.lift).abs() < 1e-4 && (down.drag - up.drag).abs() < 1e-6);
    assert!((down.transition[0] - up.transition[1]).abs() < 1e-4);
}

/// A closed trailing edge is the limit of an open one.
#[test]
fn closed_trailing_edges_are_a_limit() {
    let lift = |gap: f64| {
        let mut outline = shapes::naca("2412");
        let last = outline.len() - 1;
        let open = outline[last].y - outline[0].y;
        for (k, p) in outline.iter_mut().enumerate() {
            let side = if 2 * k < last { -0.5 } else { 0.5 };
            p.y += side * (gap - open) * p.x;
        }
        if gap == 0.0 {
            outline[0] = DVec2::X;
            outline[last] = DVec2::X;
        }
        let states = solve(&outline, &[4.0], &conditions(1e6, Some(0.03)));
        states[0].as_ref().unwrap().lift
    };
    let [closed, narrow, wider] = [0.0, 2e-4, 2.2e-3].map(lift);
    assert!((closed - narrow).abs() < 0.003, "{closed} {narrow}");
    assert!((closed - wider).abs() > 0.005, "{closed} {wider}");
}

/// Angles may come in any order; conditions without sense are refused.
#[test]
fn orders_and_conditions_are_handled() {
    let section = Section::new(&shapes::naca("2412"), 100).unwrap();
    let angles = [0.1, -0.02, 0.05];
    let states = section.polar(&angles, &Conditions::default());
    for (angle, state) in angles.iter().zip(&states) {
        assert_eq!(state.as_ref().unwrap().angle_rad, *angle);
    }
    assert!(section.polar(&[], &Conditions::default()).is_empty());
    let refused = |angle: f64, conditions: Conditions| {
        let states = section.polar(&[angle], &conditions);
        assert!(matches!(states[0], Err(SectionError::Conditions(_))));
    };
    refused(f64::NAN, Conditions::default());
    refused(1.5, Conditions::default());
    refused(0.0, conditions(f64::NAN, None));
    refused(0.0, conditions(-1e6, None));
    refused(0.0, conditions(1e6, Some(1.5)));
    let critical_amplification = 0.0;
    refused(
        0.0,
        Conditions {
            critical_amplification,
            ..Conditions::default()
        },
    );
}

/// Far beyond the largest lift a thin section has no solution, and that is what is said.
#[test]
fn what_has_no_solution_is_an_error() {
    let degrees = [0.0, 45.0];
    let states = solve(&shapes::naca("0012"), &degrees, &conditions(5e5, None));
    states[0].as_ref().unwrap();
    match &states[1] {
        Err(SectionError::NotConverged { degrees, .. }) => assert!((degrees - 45.0).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
}
