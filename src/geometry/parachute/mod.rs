//! Parachute canopies: patterns of gores, their folding, and the complete rigged canopy.

pub mod crossings;
pub mod designs;
#[cfg(test)]
mod designs_tests;
pub mod folding;
pub mod gores;
pub mod pattern;
pub mod pleats;
pub mod sewn;
pub mod shape;

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::cloth::{Guide, Structure, Triangle};
use crate::fabric::Fabric;
use crate::frame::CableKind;
use crate::geometry::mesh::quality::Quality;
use crate::lines::{Cable, CableLaw};
use sewn::{Cut, Folding, LinePlaces, Sewn};

/// A rigged canopy: fabric, belts, suspension lines, confluence, riser.
///
/// The wind blows along +x: the confluence is upstream, the apex downstream. Triangle normals point out of the canopy.
#[derive(Debug, Clone)]
pub struct Rigging {
    /// The canopy.
    pub cut: Cut,
    /// Fabric.
    pub fabric: Fabric,
    /// Belts along every seam, and along every centre line that carries a suspension line, if any; tapes across slots are of the same material.
    pub belts: Option<Cable>,
    /// Band along the lower edge, if any.
    pub skirt_band: Option<Cable>,
    /// Band around the vent, if any.
    pub vent_band: Option<Cable>,
    /// Lines across the vent; of the suspension lines' material if absent.
    pub vent_lines: Option<Cable>,
    /// Suspension lines; they run on over gaps.
    pub lines: Cable,
    /// Where they are.
    pub line_places: LinePlaces,
    /// Length of the longest from the folded canopy to the confluence [m].
    pub line_length_m: f64,
    /// What the unstretched length of every line is beyond `line_length_m` [m].
    pub line_slack_m: f64,
    /// Segments of a line.
    pub line_segments: usize,
    /// Risers, if any.
    pub risers: Option<Risers>,
    /// Where all lines, or all of several risers, meet; held fixed, or without hold where a single riser follows [m].
    pub confluence_m: DVec3,
    /// How it is folded.
    pub folding: Folding,
    /// How far the canopy is turned from the wind about the confluence, towards +y [rad].
    pub tilt_rad: f64,
    /// Lateral stiffness of a guide at the apex (the crossing of the vent lines), if any [N/m].
    pub apex_guide_n_m: Option<f64>,
}

/// What lines join into: a single riser below the confluence, or several above it, each for as many neighbouring lines. A riser is as strong
/// and heavy as its lines together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Risers {
    /// A divisor of the number of lines.
    pub count: usize,
    /// Length of each [m].
    pub length_m: f64,
}

/// A canopy as built.
#[derive(Debug, Clone)]
pub struct Rigged {
    /// All of it; nodes of fabric first, then the confluence, then others.
    pub structure: Structure,
    /// Nodes of fabric; also the number of the confluence.
    pub canopy_node_count: usize,
    /// Node that is held: the confluence, or the lower end of the riser.
    pub lower_end: usize,
    /// Quality of the triangles at rest.
    pub quality: Option<Quality>,
}

/// Why a canopy cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BuildFault {
    /// The folding does not exist.
    #[error("the canopy cannot be pleated to this diameter")]
    Folding,
    /// Lines do not reach from the skirt to the axis.
    #[error("lines are too short for the folded skirt")]
    ShortLines,
    /// A triangle without area.
    #[error("triangle {0} of the pattern has no area")]
    Degenerate(usize),
}

/// Relative difference of lengths below which lines count as equally long.
const SAME_LENGTH: f64 = 1e-9;

/// Halvings of the range in which a canopy with several risers is placed.
const BISECTIONS: usize = 60;

/// Builds the canopy folded, with its lines straight.
pub fn build(rigging: &Rigging) -> Result<Rigged, BuildFault> {
    let sewn = sewn::sew(&rigging.cut, rigging.line_places, &rigging.folding)
        .ok_or(BuildFault::Folding)?;
    let groups = groups(rigging, &sewn);
    let shift = place(rigging, &sewn, &groups)?;
    let mut structure = Structure {
        positions_m: sewn.positions_m.iter().map(|p| *p + shift).collect(),
        membrane: Some(rigging.fabric.membrane()),
        yield_stress_pa: rigging.fabric.yield_stress_pa,
        thickness_m: rigging.fabric.thickness_m,
        openings: sewn.openings.clone(),
        ..Structure::default()
    };
    structure.positions_m.push(rigging.confluence_m);
    let canopy_node_count = sewn.positions_m.len();
    let confluence = canopy_node_count as u32;
    structure.masses_kg = vec![0.0; canopy_node_count + 1];
    structure.held = vec![false; canopy_node_count + 1];
    for (number, (nodes, rest)) in sewn.triangles.iter().zip(&sewn.rest_m).enumerate() {
        let warp = sewn.warps[number];
        let triangle = Triangle::laid_out(*nodes, *rest, warp, rigging.fabric.initial_strain)
            .ok_or(BuildFault::Degenerate(number))?;
        for node in nodes {
            structure.masses_kg[*node as usize] +=
                rigging.fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        }
        structure.triangles.push(triangle);
    }
    let length_m = rigging.line_length_m + rigging.line_slack_m;
    let several = rigging.risers.filter(|risers| risers.count > 1);
    for radial in &sewn.radials {
        if let Some(belt) = &rigging.belts {
            for path in radial.belts.iter().chain(&radial.tapes) {
                structure.add_cable(&path.nodes, &path.rest_m, belt, CableKind::Belt);
            }
        }
        for gap in &radial.gaps {
            structure.add_cable(&gap.nodes, &gap.rest_m, &rigging.lines, CableKind::GapLine);
        }
        if let (None, Some(skirt)) = (several, radial.line) {
            let kind = CableKind::SuspensionLine;
            add_line(&mut structure, [skirt, confluence], length_m, rigging, kind);
        }
    }
    for (risers, group) in several
        .iter()
        .flat_map(|risers| groups.iter().map(move |g| (risers, g)))
    {
        let attachment_m = |node: u32| structure.positions_m[node as usize] - rigging.confluence_m;
        let place = rigging.confluence_m + junction_m(risers, group, attachment_m);
        let junction = structure.add_node(place);
        let riser = together(&rigging.lines, group.len() as f64);
        let kind = CableKind::Riser;
        structure.add_cable(&[junction, confluence], &[risers.length_m], &riser, kind);
        for &skirt in group {
            let kind = CableKind::SuspensionLine;
            add_line(&mut structure, [skirt, junction], length_m, rigging, kind);
        }
    }
    for (band, paths) in [
        (&rigging.skirt_band, &sewn.skirt[..]),
        (&rigging.vent_band, sewn.vent.as_slice()),
    ] {
        for path in paths {
            if let Some(band) = band {
                structure.add_cable(&path.nodes, &path.rest_m, band, CableKind::Belt);
            }
        }
    }
    let crossing = add_vent_lines(&mut structure, rigging, &sewn);
    let guided = match (crossing, sewn.apex[..].len()) {
        (Some(node), _) => Some(node),
        (None, 1) => Some(sewn.apex[0]),
        (None, _) => None,
    };
    if let (Some(stiffness), Some(node)) = (rigging.apex_guide_n_m, guided) {
        structure.guides.push(Guide {
            node,
            anchor_m: rigging.confluence_m,
            stiffness_n_m: DVec3::new(0.0, stiffness, stiffness),
        });
    }
    if rigging.tilt_rad != 0.0 {
        let turn = DQuat::from_rotation_z(rigging.tilt_rad);
        for position in &mut structure.positions_m {
            *position = rigging.confluence_m + turn * (*position - rigging.confluence_m);
        }
    }
    let lower_end = add_riser(&mut structure, rigging, confluence);
    structure.held[lower_end] = true;
    Ok(Rigged {
        structure,
        canopy_node_count,
        lower_end,
        quality: sewn.quality,
    })
}

/// Attachments of the lines that join into one riser, all around; in the order of rigging if there are not several risers.
fn groups(rigging: &Rigging, sewn: &Sewn) -> Vec<Vec<u32>> {
    let mut lines: Vec<u32> = sewn
        .radials
        .iter()
        .filter_map(|radial| radial.line)
        .collect();
    let count = rigging.risers.map_or(1, |risers| risers.count);
    if count > 1 {
        // What rounding puts just before the first belongs to it.
        let azimuth = |node: &u32| {
            let place = sewn.positions_m[*node as usize];
            (place.z.atan2(place.y) + SAME_LENGTH).rem_euclid(TAU)
        };
        lines.sort_by(|a, b| azimuth(a).total_cmp(&azimuth(b)));
    }
    let size = lines.len().div_ceil(count).max(1);
    lines.chunks(size).map(<[u32]>::to_vec).collect()
}

/// Upper end of a riser, from the confluence: towards the mean of its attachments [m].
fn junction_m(risers: &Risers, group: &[u32], attachment_m: impl Fn(u32) -> DVec3) -> DVec3 {
    let sum: DVec3 = group.iter().map(|&node| attachment_m(node)).sum();
    sum.normalize_or(DVec3::X) * risers.length_m
}

/// Where the folded canopy goes so that the line that reaches farthest is just straight [m].
fn place(rigging: &Rigging, sewn: &Sewn, groups: &[Vec<u32>]) -> Result<DVec3, BuildFault> {
    let several = rigging.risers.filter(|risers| risers.count > 1);
    let reach_m = rigging.line_length_m + several.map_or(0.0, |risers| risers.length_m);
    let mut nearest: Option<f64> = None;
    for &node in groups.iter().flatten() {
        let attached = sewn.positions_m[node as usize];
        let reach = reach_m.powi(2) - attached.y.powi(2) - attached.z.powi(2);
        if reach <= 0.0 {
            return Err(BuildFault::ShortLines);
        }
        let shift = reach.sqrt() - attached.x;
        let nearer = nearest.is_none_or(|last| shift < last - SAME_LENGTH * rigging.line_length_m);
        if nearer {
            nearest = Some(shift);
        }
    }
    let mut shift = nearest.ok_or(BuildFault::ShortLines)?;
    if let Some(risers) = several {
        // Lines of one riser spread from its upper end, so none may be as far away as if it went straight on.
        let longest = |shift: f64| {
            let place = |node: u32| sewn.positions_m[node as usize] + DVec3::X * shift;
            let of_group = |group: &Vec<u32>| {
                let junction = junction_m(&risers, group, place);
                let lengths = group.iter().map(|&node| place(node).distance(junction));
                lengths.fold(0.0, f64::max)
            };
            groups.iter().map(of_group).fold(0.0, f64::max)
        };
        let (mut low, mut high) = (shift - 0.5 * rigging.line_length_m, shift);
        if longest(low) > rigging.line_length_m {
            return Err(BuildFault::ShortLines);
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if longest(middle) > rigging.line_length_m {
                high = middle;
            } else {
                low = middle;
            }
        }
        shift = low;
    }
    Ok(rigging.confluence_m + DVec3::X * shift)
}

/// A straight line of several segments between two nodes; the first of them is its upper end.
fn add_line(
    structure: &mut Structure,
    [from, to]: [u32; 2],
    length_m: f64,
    rigging: &Rigging,
    kind: CableKind,
) {
    let segments = rigging.line_segments;
    let ends = [from, to].map(|node| structure.positions_m[node as usize]);
    let mut nodes = vec![from];
    for k in 1..segments {
        nodes.push(structure.add_node(ends[0].lerp(ends[1], k as f64 / segments as f64)));
    }
    nodes.push(to);
    let rest = vec![length_m / segments as f64; segments];
    structure.add_cable(&nodes, &rest, &rigging.lines, kind);
}

/// Lines from the edge of the vent to where they all cross, and are joined; that node.
fn add_vent_lines(structure: &mut Structure, rigging: &Rigging, sewn: &Sewn) -> Option<u32> {
    let lines = sewn.vent_lines.as_ref()?;
    let mut middle = DVec3::ZERO;
    for &end in &lines.ends {
        middle += structure.positions_m[end as usize] / lines.ends.len() as f64;
    }
    let crossing = structure.add_node(middle);
    let cable = rigging.vent_lines.as_ref().unwrap_or(&rigging.lines);
    for &end in &lines.ends {
        let half = 0.5 * lines.length_m;
        structure.add_cable(&[end, crossing], &[half], cable, CableKind::VentLine);
    }
    Some(crossing)
}

/// A cable as strong and heavy as so many lines.
fn together(line: &Cable, count: f64) -> Cable {
    Cable {
        area_m2: count * line.area_m2,
        density_kg_m3: line.density_kg_m3,
        law: match &line.law {
            CableLaw::Linear { axial_stiffness_n } => CableLaw::Linear {
                axial_stiffness_n: count * axial_stiffness_n,
            },
            CableLaw::Table(table) => CableLaw::Table(table.times(count)),
        },
        damping_n_s: count * line.damping_n_s,
        breaking_load_n: line.breaking_load_n.map(|load_n| count * load_n),
    }
}

/// The node that is held: the lower end of a single riser, or the confluence without one.
fn add_riser(structure: &mut Structure, rigging: &Rigging, confluence: u32) -> usize {
    let Some(riser) = rigging.risers.filter(|risers| risers.count == 1) else {
        return confluence as usize;
    };
    let cables = structure.cables.iter();
    let lines = cables.filter(|c| c.nodes.contains(&confluence)).count() as f64;
    let lower = structure.add_node(rigging.confluence_m - DVec3::X * riser.length_m);
    let cable = together(&rigging.lines, lines);
    structure.add_cable(
        &[confluence, lower],
        &[riser.length_m],
        &cable,
        CableKind::Riser,
    );
    lower as usize
}
