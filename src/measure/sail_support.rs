//! Where a wing's fabric lacks tension, where ribs stand out from their neighbours, and where stress gathers: read-outs of an equilibrium that say where
//! to look before anything is sewn.
//!
//! Paper P0, section 3, reads missing sail support and stress concentrations from maps of stress; here they are found and told with their places. Thresholds
//! are heuristic: they draw the eye, they do not judge.

use std::collections::HashMap;

use glam::DVec3;

use super::load_test::parts;
use super::read_out::results;
use super::wing::{key, place};
use super::wing_lines::{from_the_middle, half_of};
use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::frame::StructureFrame;
use crate::geometry::wing::section::Side;
use crate::geometry::wing::{LineKind, Part};
use crate::output::{Quantity, Results};

/// Fabric counts as without tension below this share of the mean tension of its part.
const SLACK_SHARE: f64 = 0.05;

/// Fewest triangles of a region that is told.
const LEAST_TRIANGLES: usize = 6;

/// Least share of a panel or rib that a region takes to be warned of.
const LEAST_SHARE: f64 = 0.15;

/// Distance over the chord by which a rib stands out between attachments, from which it is warned of.
const STANDING_OUT: f64 = 0.015;

/// Stress over the mean of its part from which it is warned of.
const CONCENTRATION: f64 = 5.0;

/// Distance over the mean chord within which two peaks of stress count as one.
const APART: f64 = 0.1;

/// Most places of one kind that are told.
const MOST_TOLD: usize = 4;

/// Connected triangles of a panel or rib that carry next to nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct SlackRegion {
    /// What they are part of.
    pub part: Part,
    /// Number of the cell or rib, from the left tip, from 0.
    pub number: usize,
    /// How many.
    pub triangles: usize,
    /// Their area at rest [m²].
    pub area_m2: f64,
    /// That over the area of the panel or rib.
    pub share: f64,
    /// From where to where along the chord.
    pub chord: [f64; 2],
}

/// A rib that stands out between the attachments of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingRib {
    /// Number, from the left tip, from 0.
    pub rib: usize,
    /// Number of the row.
    pub row: usize,
    /// The attached ribs on both sides.
    pub between: [usize; 2],
    /// By how much, over its chord; outwards is positive.
    pub out: f64,
}

/// A peak of stress.
#[derive(Debug, Clone, PartialEq)]
pub struct Concentration {
    /// The triangle.
    pub triangle: usize,
    /// Its largest principal stress [Pa].
    pub stress_pa: f64,
    /// That over the mean of its part.
    pub over_mean: f64,
}

/// An edge, as part of one panel or rib.
type EdgeOfPart = ([u32; 2], (usize, u32));

/// Mean over the area at rest of a part's tension (false) or stress (true).
fn mean_of(wing: &Wing, structure: &StructureFrame, part: Part, of: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (triangle, tag) in wing.built.tags.iter().enumerate() {
        if tag.part == part {
            let own = structure.rest_areas_m2[triangle];
            sum += own * of(triangle).max(0.0);
            area += own;
        }
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

/// Regions without tension of panels and ribs, largest first.
#[must_use]
pub fn slack_regions(wing: &Wing, structure: &StructureFrame) -> Vec<SlackRegion> {
    let tags = &wing.built.tags;
    let tension = |triangle: usize| structure.principal_tensions_n_m[triangle][0];
    let parts = [Part::Upper, Part::Lower, Part::Rib];
    let limits = parts.map(|part| SLACK_SHARE * mean_of(wing, structure, part, tension));
    let is_slack = |triangle: usize| {
        let place = parts.iter().position(|part| *part == tags[triangle].part);
        place.is_some_and(|p| tension(triangle) < limits[p])
    };
    let mut areas: HashMap<(usize, u32), f64> = HashMap::new();
    let id = |triangle: usize| (tags[triangle].part as usize, tags[triangle].number);
    for triangle in 0..tags.len() {
        *areas.entry(id(triangle)).or_default() += structure.rest_areas_m2[triangle];
    }
    // Neighbours across edges, within one panel or rib.
    let mut beside: HashMap<EdgeOfPart, Vec<usize>> = HashMap::new();
    for (triangle, nodes) in structure.triangles.iter().enumerate() {
        if is_slack(triangle) {
            for i in 0..3 {
                let (a, b) = (nodes[i], nodes[(i + 1) % 3]);
                let edge = ([a.min(b), a.max(b)], id(triangle));
                beside.entry(edge).or_default().push(triangle);
            }
        }
    }
    let mut seen = vec![false; tags.len()];
    let mut regions = Vec::new();
    for seed in 0..tags.len() {
        if seen[seed] || !is_slack(seed) {
            continue;
        }
        seen[seed] = true;
        let mut members = vec![seed];
        let mut next = 0;
        while next < members.len() {
            let triangle = members[next];
            next += 1;
            let nodes = structure.triangles[triangle];
            for i in 0..3 {
                let (a, b) = (nodes[i], nodes[(i + 1) % 3]);
                let edge = ([a.min(b), a.max(b)], id(triangle));
                for &other in beside.get(&edge).into_iter().flatten() {
                    if !seen[other] {
                        seen[other] = true;
                        members.push(other);
                    }
                }
            }
        }
        if members.len() < LEAST_TRIANGLES {
            continue;
        }
        let area_m2: f64 = members.iter().map(|t| structure.rest_areas_m2[*t]).sum();
        let places = || members.iter().map(|t| f64::from(tags[*t].chord_place));
        regions.push(SlackRegion {
            part: tags[seed].part,
            number: tags[seed].number as usize,
            triangles: members.len(),
            area_m2,
            share: area_m2 / areas[&id(seed)],
            chord: [
                places().fold(f64::INFINITY, f64::min),
                places().fold(f64::NEG_INFINITY, f64::max),
            ],
        });
    }
    regions.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
    regions
}

/// Ribs attached to lines of every row, from the left tip; those of brakes are none.
fn attached_ribs(wing: &Wing, cables: &[[u32; 2]]) -> Vec<Vec<usize>> {
    let mut rows = vec![Vec::new(); wing.built.row_names.len()];
    for (cable, kind) in cables.iter().zip(&wing.built.line_kinds) {
        if let LineKind::Line { row, level: 0 } = kind
            && wing.plan.rows[*row].position < 1.0
            && let Some(rib) = wing
                .built
                .outlines
                .iter()
                .position(|o| o.contains(&cable[0]))
        {
            rows[*row].push(rib);
        }
    }
    for row in &mut rows {
        row.sort_unstable();
        row.dedup();
    }
    rows
}

/// How far ribs stand out at the rows between attached ribs: their displacement from the designed place along their own height, less that of the attached
/// ribs on both sides, interpolated between them, over the chord. Rigid motion and a smooth change of the arc give next to nothing over so few cells.
#[must_use]
pub fn standing_ribs(
    wing: &Wing,
    designed: &Structure,
    structure: &StructureFrame,
) -> Vec<StandingRib> {
    let outlines = &wing.built.outlines;
    let mut standing = Vec::new();
    for (row, attached) in attached_ribs(wing, &structure.cables).iter().enumerate() {
        let k = outlines[0].len()
            - wing
                .built
                .places
                .nearest(Side::Lower, wing.plan.rows[row].position);
        let moved = |rib: usize| {
            let node = outlines[rib][k % outlines[rib].len()] as usize;
            structure.positions_m[node] - designed.positions_m[node]
        };
        for pair in attached.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            for rib in a + 1..b {
                let share = (rib - a) as f64 / (b - a) as f64;
                let expected = moved(a).lerp(moved(b), share);
                let frame = &wing.built.frames[rib];
                standing.push(StandingRib {
                    rib,
                    row,
                    between: [a, b],
                    out: (moved(rib) - expected).dot(frame.up) / frame.chord_m,
                });
            }
        }
    }
    standing
}

/// Peaks of stress of a part, largest first, at most `MOST_TOLD`, each apart from those before.
#[must_use]
pub fn concentrations(wing: &Wing, structure: &StructureFrame, part: Part) -> Vec<Concentration> {
    let stress = |triangle: usize| structure.stress_pa[triangle];
    let mean = mean_of(wing, structure, part, stress);
    if mean.is_nan() || mean <= 0.0 {
        return Vec::new();
    }
    let measures = &wing.built.measures;
    let near_m = APART * measures.flat_area_m2 / measures.flat_span_m;
    let middle = |triangle: usize| {
        let nodes = structure.triangles[triangle];
        nodes
            .map(|n| structure.positions_m[n as usize])
            .iter()
            .sum::<DVec3>()
            / 3.0
    };
    let tags = wing.built.tags.iter().enumerate();
    let mut own: Vec<usize> = tags
        .filter(|(_, tag)| tag.part == part)
        .map(|(triangle, _)| triangle)
        .collect();
    own.sort_by(|a, b| stress(*b).total_cmp(&stress(*a)));
    let mut peaks: Vec<Concentration> = Vec::new();
    for triangle in own {
        let over_mean = stress(triangle) / mean;
        if peaks.len() == MOST_TOLD || (over_mean < CONCENTRATION && !peaks.is_empty()) {
            break;
        }
        let apart =
            |peak: &Concentration| middle(peak.triangle).distance(middle(triangle)) > near_m;
        if peaks.iter().all(apart) {
            peaks.push(Concentration {
                triangle,
                stress_pa: stress(triangle),
                over_mean,
            });
        }
    }
    peaks
}

/// The attachment nearest to a triangle, in words.
fn nearest_attachment(wing: &Wing, structure: &StructureFrame, triangle: usize) -> Option<String> {
    let nodes = structure.triangles[triangle].map(|n| structure.positions_m[n as usize]);
    let middle = nodes.iter().sum::<DVec3>() / 3.0;
    let attachments = structure
        .cables
        .iter()
        .zip(&wing.built.line_kinds)
        .filter_map(|(cable, kind)| match kind {
            LineKind::Line { row, level: 0 } => Some((*row, cable[0])),
            _ => None,
        });
    let distance = |node: u32| structure.positions_m[node as usize].distance(middle);
    let (row, node) = attachments.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
    let rib = wing.built.outlines.iter().position(|o| o.contains(&node))?;
    Some(format!(
        "{:.2} m from the attachment {} of rib {} on the {}",
        distance(node),
        wing.built.row_names[row],
        from_the_middle(wing.built.cells, rib),
        half_of(structure.positions_m[node as usize].y)
    ))
}

fn number_in_words(wing: &Wing, part: Part, number: usize) -> String {
    let cells = wing.built.cells;
    match part {
        Part::Upper | Part::Lower | Part::MiniRib => {
            format!("cell {} of {cells} from the left tip", number + 1)
        }
        Part::Rib | Part::Diagonal => format!(
            "rib {} of {} from the left tip ({} from the middle)",
            number + 1,
            cells + 1,
            from_the_middle(cells, number)
        ),
    }
}

fn standing_in_words(wing: &Wing, rib: &StandingRib) -> String {
    format!(
        "{} by {:.1} % of its chord at row {}, between the attachments of ribs {} and {}",
        number_in_words(wing, Part::Rib, rib.rib),
        100.0 * rib.out,
        wing.built.row_names[rib.row],
        rib.between[0] + 1,
        rib.between[1] + 1
    )
}

fn region_in_words(wing: &Wing, region: &SlackRegion) -> String {
    format!(
        "{}, {}, {:.2} to {:.2} of the chord: {:.0} % of it, {} triangles",
        region.part.name(),
        number_in_words(wing, region.part, region.number),
        region.chord[0],
        region.chord[1],
        100.0 * region.share,
        region.triangles
    )
}

/// What a designer should look at, in words; nothing where the sail is held everywhere.
#[must_use]
pub fn warnings(wing: &Wing, designed: &Structure, structure: &StructureFrame) -> Vec<String> {
    let mut warnings = Vec::new();
    let regions = slack_regions(wing, structure);
    let large: Vec<&SlackRegion> = regions.iter().filter(|r| r.share >= LEAST_SHARE).collect();
    if !large.is_empty() {
        let told: Vec<String> = large
            .iter()
            .take(MOST_TOLD)
            .map(|region| region_in_words(wing, region))
            .collect();
        warnings.push(format!(
            "sail support: {} regions of panels or ribs are without tension (below {SLACK_SHARE} of their part's mean); the largest: {}",
            large.len(),
            told.join("; ")
        ));
    }
    let mut standing = standing_ribs(wing, designed, structure);
    standing.retain(|rib| rib.out >= STANDING_OUT);
    standing.sort_by(|a, b| b.out.total_cmp(&a.out));
    if !standing.is_empty() {
        let told: Vec<String> = standing
            .iter()
            .take(MOST_TOLD)
            .map(|rib| standing_in_words(wing, rib))
            .collect();
        warnings.push(format!(
            "sail support: at {} places a rib stands out between the attachments of its row: {}",
            standing.len(),
            told.join("; ")
        ));
    }
    for part in Part::ALL {
        let peaks = concentrations(wing, structure, part);
        let told: Vec<String> = peaks
            .iter()
            .filter(|peak| peak.over_mean >= CONCENTRATION)
            .map(|peak| {
                let near = nearest_attachment(wing, structure, peak.triangle);
                format!(
                    "{:.1} MPa, {:.1} times the mean, in {}{}",
                    1e-6 * peak.stress_pa,
                    peak.over_mean,
                    place(wing, &wing.built.tags[peak.triangle]),
                    near.map_or_else(String::new, |near| format!(", {near}"))
                )
            })
            .collect();
        if !told.is_empty() {
            warnings.push(format!("stress concentration: {}", told.join("; ")));
        }
    }
    warnings
}

results! {
    /// The figures behind the warnings.
    RESULTS: "Support of a wing's sail";
    REGION_AREA_MAX: "slack_region_area_max_m2", "m2", "area of the largest region without tension";
    REGIONS: "slack_regions", "1", "number of regions; without tension and taking at least 15 % of their panel or rib";
    STANDING_OUT_MAX: "rib_standing_out_max", "1", "farthest that a rib stands out between the attachments of its row; over its chord";
    STRESS_OVER_MEAN: "{part}_stress_max_over_mean", "1", "largest stress of the part over its mean";
}

/// Adds the figures behind the warnings.
pub(super) fn results(
    results: &mut Results,
    wing: &Wing,
    designed: &Structure,
    structure: &StructureFrame,
) {
    let regions = slack_regions(wing, structure);
    results.insert(
        &REGION_AREA_MAX,
        match regions.first() {
            Some(region) => Quantity::new(region.area_m2).with_note(&region_in_words(wing, region)),
            None => Quantity::new(0.0).with_note("no region without tension has six triangles"),
        },
    );
    let count = regions.iter().filter(|r| r.share >= LEAST_SHARE).count();
    results.tell(&REGIONS, count as f64);
    let standing = standing_ribs(wing, designed, structure);
    let most = standing.iter().max_by(|a, b| a.out.total_cmp(&b.out));
    results.insert(
        &STANDING_OUT_MAX,
        match most {
            Some(most) => Quantity::new(most.out).with_note(&standing_in_words(wing, most)),
            None => Quantity::missing("no rib stands between attached ones"),
        },
    );
    for part in parts(wing) {
        let peaks = concentrations(wing, structure, part);
        results.insert(
            &STRESS_OVER_MEAN.of(key(part)),
            match peaks.first() {
                Some(peak) => {
                    let near = nearest_attachment(wing, structure, peak.triangle);
                    Quantity::new(peak.over_mean).with_note(&format!(
                        "{}{}",
                        place(wing, &wing.built.tags[peak.triangle]),
                        near.map_or_else(String::new, |near| format!(", {near}"))
                    ))
                }
                None => Quantity::missing("the part carries nothing"),
            },
        );
    }
}
