//! Fabric without tension, and peaks of stress, found where they were put.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::frame::StructureFrame;
use ripstop::geometry::wing::Part;
use ripstop::measure::{concentrations, slack_regions};
use ripstop::plan::{Plan, Precision};
use ripstop::simulation::Simulation;

use crate::engines::plain;
use crate::wing_design::school;

pub fn trials() -> Vec<Trial> {
    [
        plain("sail_support::slack_fabric_is_found", slack_fabric),
        plain("sail_support::peaks_of_stress_are_found", peaks),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The school wing, all of it under a tension of 100 N/m and a stress of 1 MPa.
fn evenly_taut() -> (Simulation, StructureFrame) {
    let scene = school();
    let plan = Plan::new(&scene, Precision::F64);
    let simulation = Simulation::new(scene, plan, None).unwrap();
    let mut structure = simulation.structure_frame().structure.unwrap();
    structure.principal_tensions_n_m.fill([100.0, 50.0]);
    structure.stress_pa.fill(1e6);
    (simulation, structure)
}

/// A strip of an upper panel and, apart from it, one of a rib are without tension: these two are told, with their panel or rib, area and place.
fn slack_fabric() {
    let (simulation, mut structure) = evenly_taut();
    let wing = simulation.scene().wing().unwrap();
    assert!(slack_regions(wing, &structure).is_empty());
    let strips = [(Part::Upper, 5, [0.3, 0.7]), (Part::Rib, 12, [0.2, 0.8])];
    let mut areas_m2 = [0.0; 2];
    for (triangle, tag) in wing.built.tags.iter().enumerate() {
        for ((part, number, [from, to]), area_m2) in strips.iter().zip(&mut areas_m2) {
            if tag.part == *part && tag.number == *number && (*from..*to).contains(&tag.chord_place)
            {
                structure.principal_tensions_n_m[triangle] = [1.0, 0.0];
                *area_m2 += structure.rest_areas_m2[triangle];
            }
        }
    }
    let found = slack_regions(wing, &structure);
    assert_eq!(found.len(), 2, "{found:?}");
    for ((part, number, [from, to]), area_m2) in strips.into_iter().zip(areas_m2) {
        let region = found.iter().find(|region| region.part == part).unwrap();
        assert_eq!(region.number, number as usize);
        assert!((region.area_m2 / area_m2 - 1.0).abs() < 1e-12);
        assert!(region.chord[0] >= f64::from(from) && region.chord[1] < f64::from(to));
    }
    assert!(found[0].area_m2 >= found[1].area_m2);
}

/// Three triangles of lower panels stand out, two of them beside each other: two peaks, the higher first.
fn peaks() {
    let (simulation, mut structure) = evenly_taut();
    let wing = simulation.scene().wing().unwrap();
    let of_panel = |number: u32| {
        let tags = wing.built.tags.iter();
        tags.clone()
            .position(|tag| tag.part == Part::Lower && tag.number == number)
            .unwrap()
    };
    let middle = |triangle: usize| {
        let nodes = structure.triangles[triangle];
        nodes
            .map(|n| structure.positions_m[n as usize])
            .iter()
            .sum::<DVec3>()
            / 3.0
    };
    let [first, second] = [of_panel(2), of_panel(20)];
    // The nearest of the same panel.
    let beside = (0..structure.triangles.len())
        .filter(|&t| t != first && wing.built.tags[t].part == Part::Lower)
        .min_by(|&a, &b| {
            let distance = |t: usize| middle(t).distance(middle(first));
            distance(a).total_cmp(&distance(b))
        })
        .unwrap();
    structure.stress_pa[first] = 2e7;
    structure.stress_pa[beside] = 1.9e7;
    structure.stress_pa[second] = 1.5e7;
    let found = concentrations(wing, &structure, Part::Lower);
    let triangles: Vec<usize> = found.iter().map(|peak| peak.triangle).collect();
    assert_eq!(triangles, [first, second]);
    assert!(found[0].over_mean > found[1].over_mean);
    assert!(found[1].over_mean > 10.0 && found[1].over_mean < 15.0);
}
