//! Ram-air wings: panels between ribs, ribs with holes, diagonals, tapes and lines, from one plan.
//!
//! * [`plan`] – what a designer states;
//! * [`section`] – profiles;
//! * [`frames`] – where the ribs stand;
//! * [`chord`] – where nodes stand along the chord;
//! * `panels`, `ribs`, `lines` – the mesh, part by part;
//! * [`carried_over`] – displacements from one mesh of a plan to another;
//! * [`planar`] – triangles inside an outline with holes;
//! * [`pressure`] – pressure jumps of a prescribed distribution;
//! * [`patterns`] – panels laid flat;
//! * [`measures`] – areas, lengths and masses;
//! * [`cells`] – what cells enclose, wherever the fabric is;
//! * `openings` – intakes and holes of ribs;
//! * `rods` – what stiffens the outline of ribs.
//!
//! # Rest shape
//!
//! A panel is cut wider than the distance of its ribs by its ballooning b: between two corresponding points of neighbouring ribs, a
//! distance w apart, it lies on a circular arc of length w (1 + b). Every triangle is free of stress in that shape. The surface is curved
//! twice where b or the ribs change along the chord, so flat cloth could take it only nearly; a sewer's flat panel keeps the seam lengths,
//! as here, and differs inside by strains of the order of b. Ribs and diagonals are free of stress as they are drawn, lines at their
//! designed lengths (with trim).
//!
//! The mesh of panels is structured, with nodes at the same chord places on every rib; ribs are filled by a constrained Delaunay
//! triangulation that keeps the outline's edges. All parts share nodes along their seams. Both halves are mirror images, node by node.

mod builder;
pub mod carried_over;
pub mod cells;
pub mod chord;
pub mod frames;
mod lines;
pub mod measures;
mod openings;
mod panels;
mod parts;
pub mod patterns;
pub mod plan;
pub mod planar;
pub mod pressure;
mod ribs;
mod rods;
pub mod section;
mod vh_ribs;

use std::collections::HashMap;

use crate::cloth::{SewnFabric, Structure};
use builder::Builder;
use chord::Places;
use frames::Frame;
use measures::Measures;
pub use parts::{LineKind, Part, Tag};
use plan::{Fineness, Plan, WingFault};

/// A wing as a mesh, with what reports need to know of it.
#[derive(Debug, Clone)]
pub struct BuiltWing {
    /// The structure at its start, free of stress; normals of panels point outwards, of ribs to the right.
    pub structure: Structure,
    /// What every triangle belongs to, `[triangle_count]`.
    pub tags: Vec<Tag>,
    /// What every cable segment is, `[cable_count]`.
    pub line_kinds: Vec<LineKind>,
    /// Stiffness of the pitch guide [N/m] and where its node is at rest along x [m]; `None`: there is none.
    pub pitch_guide: Option<[f64; 2]>,
    /// Held nodes: where the risers hang, right and left.
    pub hang_points: [u32; 2],
    /// Noses of the tip ribs, left and right.
    pub tip_noses: [u32; 2],
    /// Nose and trailing edge of the rib in the middle, or next to it on the right.
    pub middle_chord: [u32; 2],
    /// Number of cells.
    pub cells: usize,
    /// Middle of every cell along the arc over the half span, 0 in the middle and 1 at the tips, `[cells]`.
    pub cell_places: Vec<f64>,
    /// Where the part of the chord that brakes turn begins: the last row before the trailing edge, or three quarters without one.
    pub turning_place: f64,
    /// Names of the rows.
    pub row_names: Vec<String>,
    /// Nodes of the outline of every rib, from the left tip: nose, upper side, trailing edge, lower side back to the nose.
    pub outlines: Vec<Vec<u32>>,
    /// Nodes across every cell without those of its ribs, by place of the outline; none where the panel is open.
    pub rows_across: Vec<Vec<Vec<u32>>>,
    /// Places of those nodes along the chord.
    pub places: Places,
    /// The ribs as designed, from the left tip.
    pub frames: Vec<Frame>,
    /// Profiles that frames name by number.
    pub profiles: Vec<section::Profile>,
    /// Openings of the cells; `None`: the wing is closed.
    pub intakes: Option<plan::Intakes>,
    /// Sizes and masses.
    pub measures: Measures,
}

/// Distances of the ribs from the middle along the arc, from the left tip to the right one [m].
#[must_use]
pub fn rib_spans_m(cells: usize, half_span_m: f64, tip_cell_width_ratio: f64) -> Vec<f64> {
    // Widths change evenly with the distance of a cell from the middle.
    let reach = 0.5 * (cells - 1) as f64;
    let width = |i: usize| {
        let out = if reach > 0.0 {
            (i as f64 - reach).abs() / reach
        } else {
            0.0
        };
        1.0 + (tip_cell_width_ratio - 1.0) * out
    };
    let total: f64 = (0..cells).map(width).sum();
    let right: Vec<f64> = {
        // From the right tip inwards, so that both halves are built alike.
        let mut spans = vec![half_span_m];
        for i in (cells.div_ceil(2)..cells).rev() {
            let last = spans[spans.len() - 1];
            spans.push(last - 2.0 * half_span_m * width(i) / total);
        }
        if cells.is_multiple_of(2) {
            // Exactly in the middle.
            if let Some(last) = spans.last_mut() {
                *last = 0.0;
            }
        }
        spans.reverse();
        spans
    };
    mirrored(&right)
}

/// Places on both halves, from the left tip, of those on the right one.
fn mirrored(right: &[f64]) -> Vec<f64> {
    let left = right.iter().rev().filter(|s| **s > 0.0).map(|s| -s);
    left.chain(right.iter().copied()).collect()
}

/// Last row of lines before the trailing edge, per chord.
fn turning_place(plan: &Plan) -> f64 {
    let rows = plan.rows.iter();
    let before = rows.flat_map(|row| row.attachments().map(|(_, place)| place));
    let last = before.filter(|x| *x < 0.95).fold(0.0, f64::max);
    if last > 0.0 { last } else { 0.75 }
}

/// Builds the mesh of a wing.
pub fn build(plan: &Plan, fineness: Fineness) -> Result<BuiltWing, WingFault> {
    let half_span_m = plan.stations.last().map_or(0.0, |s| s.span_m);
    let spans = plan.rib_places_m.as_deref().map_or_else(
        || rib_spans_m(plan.cells, half_span_m, plan.tip_cell_width_ratio),
        mirrored,
    );
    let right: Vec<f64> = spans.iter().copied().filter(|s| *s >= 0.0).collect();
    let right = frames::frames(&plan.stations, &right);
    let left = right
        .iter()
        .rev()
        .filter(|f| f.span_m > 0.0)
        .map(Frame::mirrored);
    let frames: Vec<Frame> = left.chain(right.iter().copied()).collect();
    let mut builder = Builder {
        plan,
        fineness,
        places: Places::new(plan, fineness)?,
        frames,
        structure: Structure::default(),
        tags: Vec::new(),
        line_kinds: Vec::new(),
        fabrics: Vec::new(),
        outlines: Vec::new(),
        rows_across: Vec::new(),
        diagonal_edges: HashMap::new(),
        seam_nodes: HashMap::new(),
        rod_mass_kg: 0.0,
    };
    builder.add_panels()?;
    builder.add_ribs()?;
    builder.add_diagonals()?;
    builder.add_vh_ribs()?;
    builder.add_tapes();
    builder.add_rods();
    let hang_points = builder.add_lines()?;
    builder.add_guides();
    let measures = Measures::new(&builder);
    builder.structure.openings = builder.openings();
    let middle = &builder.outlines[plan.cells.div_ceil(2)];
    let middle_chord = [middle[0], middle[fineness.along_chord]];
    let tip_noses = [builder.outlines[0][0], builder.outlines[plan.cells][0]];
    let Builder {
        mut structure,
        tags,
        line_kinds,
        fabrics,
        outlines,
        rows_across,
        places,
        frames,
        ..
    } = builder;
    let (first, further) = (&fabrics[0], &fabrics[1..]);
    structure.membrane = Some(first.membrane());
    structure.thickness_m = first.thickness_m;
    structure.yield_stress_pa = first.yield_stress_pa;
    structure.further_fabrics = further.iter().map(SewnFabric::from).collect();
    let pitch_guide = plan
        .pitch_guide_n_m
        .map(|stiffness| [stiffness, structure.positions_m[middle_chord[0] as usize].x]);
    Ok(BuiltWing {
        structure,
        tags,
        line_kinds,
        pitch_guide,
        hang_points,
        tip_noses,
        middle_chord,
        cells: plan.cells,
        cell_places: spans
            .windows(2)
            .map(|pair| (0.5 * (pair[0] + pair[1])).abs() / half_span_m)
            .collect(),
        turning_place: turning_place(plan),
        row_names: plan.rows.iter().map(|row| row.name.clone()).collect(),
        outlines,
        rows_across,
        places,
        frames,
        profiles: plan.profiles.clone(),
        intakes: plan.intakes,
        measures,
    })
}
