//! Tests of [`super`].

use std::sync::Arc;

use super::super::polar::PolarPoint;
use super::super::potential_flow::MEMORY_LIMIT;
use super::super::surface::{Station, Wing};
use super::*;
use crate::geometry::profile::Profile;

fn stream(degrees: f64) -> DVec3 {
    let angle = degrees.to_radians();
    20.0 * DVec3::new(angle.cos(), 0.0, angle.sin())
}

fn rectangle(half_span: f64) -> (Wing, Arc<Profile>) {
    let profile = Arc::new(Profile::naca("2412").unwrap());
    let station = |y: f64| Station {
        position_m: DVec3::Y * y,
        chord_m: 1.0,
        twist_rad: 0.0,
        roll_rad: 0.0,
        profile: Arc::clone(&profile),
    };
    let wing = Wing {
        stations: vec![station(0.0), station(half_span)],
        chord_fraction: 0.25,
        is_symmetric: true,
    };
    (wing, Arc::clone(&profile))
}

fn polar_of(lift: impl Fn(f64) -> f64) -> Polar {
    let points = (-100..=300).map(|tenths| {
        let angle_rad = (0.1 * f64::from(tenths)).to_radians();
        PolarPoint {
            angle_rad,
            lift: lift(angle_rad),
            drag: 0.01,
            moment: None,
        }
    });
    Polar::new(points.collect()).unwrap()
}

/// A polar that is potential flow's own changes nothing; one with less lift everywhere takes that share from a wing so long that its
/// sections are alone; and every strip has the lift of its polar.
#[test]
fn sections_have_the_lift_of_their_polars() {
    for (half_span, share) in [(4.0, 1.0), (5e3, 0.8), (4.0, 0.8)] {
        let (wing, profile) = rectangle(half_span);
        let surface = wing.divided(4, 0.8).unwrap().panels(60).unwrap();
        let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
        let section = SectionFlow::of(&profile).unwrap();
        let polar =
            polar_of(|angle| share * section.slope_per_rad * (angle - section.zero_lift_rad).sin());
        let sections = vec![
            Section {
                polar: &polar,
                flow: section
            };
            4
        ];
        let viscous = Decambering::new(&flow, sections).unwrap();
        let results = viscous
            .solve(&[stream(2.0), stream(6.0)], Branch::Attached, 1.2)
            .unwrap();
        for (result, angle) in results.iter().zip([2.0, 6.0]) {
            assert!(
                result.residual < AGREEMENT && result.is_covered,
                "{result:?}"
            );
            let lifts = result.flow.section_lift_coefficients(&surface);
            let inviscid = flow.solve(&[stream(angle)]).unwrap().remove(0);
            let before = inviscid.section_lift_coefficients(&surface);
            for ((lift, before), angle) in lifts.iter().zip(before).zip(&result.effective_rad) {
                assert!((lift - polar.lift(*angle).0).abs() < 1e-5);
                let ratio = lift / before;
                if half_span > 1e3 || share == 1.0 {
                    assert!((ratio - share).abs() < 2e-3, "{ratio}");
                } else {
                    // Less lift, less downwash: more than its share is kept.
                    assert!(ratio > share && ratio < 1.0, "{ratio}");
                }
            }
            // 0.01 × area.
            let area = 2.0 * half_span;
            // The chord is that of the nodes.
            assert!((result.profile_drag_n / (0.01 * 240.0 * area) - 1.0).abs() < 1e-3);
        }
    }
}

/// Sections that lose lift beyond ten degrees make the wing stall.
#[test]
fn a_wing_stalls_with_its_sections() {
    let (wing, profile) = rectangle(4.0);
    let surface = wing.divided(6, 0.8).unwrap().panels(12).unwrap();
    let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
    let section = SectionFlow::of(&profile).unwrap();
    let polar = polar_of(|angle| {
        let degrees = angle.to_degrees();
        if degrees < 10.0 {
            0.1 * degrees + 0.2
        } else {
            1.2 - 0.005 * (degrees - 10.0).powi(2).min(40.0)
        }
    });
    let sections = vec![
        Section {
            polar: &polar,
            flow: section
        };
        6
    ];
    let viscous = Decambering::new(&flow, sections).unwrap();
    let streams: Vec<DVec3> = (0..=26).map(|a| stream(f64::from(a))).collect();
    let lifts = |branch: Branch, streams: &[DVec3]| -> Vec<f64> {
        let results = viscous.solve(streams, branch, 1.2).unwrap();
        let of = |result: &ViscousFlow| {
            assert!(result.residual < AGREEMENT, "{}", result.residual);
            result.lift_and_drags_n(&surface, 1.2)[0] / (240.0 * 8.0)
        };
        results.iter().map(of).collect()
    };
    let all = lifts(Branch::Attached, &streams);
    let highest = all.iter().copied().fold(0.0, f64::max);
    assert!((1.0..1.2).contains(&highest), "{all:?}");
    assert!(all[24] < highest - 0.02, "{all:?}");
    // Alone, or in a sweep that begins anywhere: the same.
    for degrees in [4, 14, 22] {
        let alone = lifts(Branch::Attached, &streams[degrees..=degrees]);
        assert!((alone[0] - all[degrees]).abs() < 1e-9, "{degrees}");
    }
    let other = lifts(Branch::Separated, &streams);
    assert!(
        (other[4] - all[4]).abs() < 1e-6,
        "one solution at small angles"
    );
}

/// A section that loses half of its lift at once has two branches over some degrees, and sweeps that begin there or elsewhere agree.
#[test]
fn a_sudden_stall_has_two_branches() {
    let (wing, profile) = rectangle(4.0);
    let surface = wing.divided(10, 0.8).unwrap().panels(10).unwrap();
    let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
    let section = SectionFlow::of(&profile).unwrap();
    let polar = polar_of(|angle| {
        let degrees = angle.to_degrees();
        (0.1 * degrees + 0.2).min((1.4 - 0.3 * (degrees - 12.0)).max(0.7))
    });
    let sections = vec![
        Section {
            polar: &polar,
            flow: section
        };
        10
    ];
    let viscous = Decambering::new(&flow, sections).unwrap();
    let lift = |branch: Branch, degrees: f64| {
        let result = viscous.solve(&[stream(degrees)], branch, 1.2).unwrap();
        assert!(result[0].residual < AGREEMENT, "{branch:?} {degrees}");
        result[0].lift_and_drags_n(&surface, 1.2)[0] / (240.0 * 8.0)
    };
    for degrees in [5.0, 10.0] {
        let [one, other] = [Branch::Attached, Branch::Separated].map(|b| lift(b, degrees));
        assert!((one - other).abs() < 1e-5, "{degrees}: {one} {other}");
    }
    // Downwash keeps the wing below the stall of its sections, once it lifts; separated, there is less of it.
    let [one, other] = [Branch::Attached, Branch::Separated].map(|b| lift(b, 15.0));
    assert!(one > 1.2 && other < 1.0, "{one} {other}");
    let [one, other] = [Branch::Attached, Branch::Separated].map(|b| lift(b, 24.0));
    assert!(one < 0.9 && other < 0.9, "{one} {other}");
}

#[test]
fn sections_are_counted() {
    let (wing, _) = rectangle(4.0);
    let surface = wing.divided(3, 0.8).unwrap().panels(6).unwrap();
    let flow = PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT).unwrap();
    assert!(matches!(
        Decambering::new(&flow, Vec::new()),
        Err(AeroError::Polar(_))
    ));
}

/// What is not a number must not count as agreement.
#[test]
fn the_largest_of_nan_is_none() {
    for numbers in [[f64::NAN, 1.0], [1.0, f64::NAN]] {
        assert!(largest_of(&numbers).is_nan());
    }
    assert_eq!(largest_of(&[-3.0, 2.0]), 3.0);
}
