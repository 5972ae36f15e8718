//! Fabric in a picture: what its colours show.

use glam::DVec3;

use super::colour::ColourScale;
use super::content::{INK, range_from_zero};
use super::picture::{LineStyle, Polyline, Surface, Tick, nice_ticks};
use crate::frame::{FabricQuantity, FabricState, StructureFrame};

/// Length of the stroke along a wrinkle, over the root of its triangle's rest area.
const STROKE_LENGTH: f64 = 0.9;

/// Strain up to which round-off of places explains it.
const ROUND_OFF: f64 = 1e-9;

/// True for fabric that is as it was cut, as that of a wing which is held rigid: its tensions and states are round-off.
fn is_unstrained(structure: &StructureFrame) -> bool {
    let mut strains = structure.principal_strains.iter().flatten();
    !structure.principal_strains.is_empty() && strains.all(|strain| strain.abs() <= ROUND_OFF)
}

/// Title of the colour bar.
pub(super) const fn title(quantity: FabricQuantity) -> &'static str {
    match quantity {
        FabricQuantity::Tension => "Tension [N/m]",
        FabricQuantity::Stress => "Stress [MPa]",
        FabricQuantity::VonMises => "Von Mises [MPa]",
        FabricQuantity::ShearStress => "Shear [MPa]",
        FabricQuantity::Wrinkles => "Fabric",
    }
}

/// Colours of the values.
pub(super) const fn scale(quantity: FabricQuantity) -> ColourScale {
    match quantity {
        FabricQuantity::Tension | FabricQuantity::Stress | FabricQuantity::VonMises => {
            ColourScale::Plasma
        }
        FabricQuantity::ShearStress => ColourScale::Viridis,
        FabricQuantity::Wrinkles => ColourScale::States,
    }
}

/// Marks of the colour bar.
pub(super) fn ticks(quantity: FabricQuantity, range: [f64; 2]) -> Vec<Tick> {
    if quantity != FabricQuantity::Wrinkles {
        return nice_ticks(range, 6);
    }
    let states = [
        (FabricState::Taut, "taut"),
        (FabricState::Wrinkled, "wrinkled"),
        (FabricState::Slack, "slack"),
    ];
    states
        .map(|(state, text)| Tick {
            value: place(state),
            text: text.to_owned(),
        })
        .to_vec()
}

/// Where a state lies on the scale from 0 to 3.
const fn place(state: FabricState) -> f64 {
    match state {
        FabricState::Taut => 0.5,
        FabricState::Wrinkled => 1.5,
        FabricState::Slack => 2.5,
    }
}

/// Values of the triangles in the unit of [`title`], NaN where the frame has none, and of fabric without strain.
pub(super) fn values(quantity: FabricQuantity, structure: &StructureFrame) -> Vec<f64> {
    let megapascal = |values: &[f64]| -> Vec<f64> { values.iter().map(|v| 1e-6 * v).collect() };
    let mut values = match quantity {
        _ if is_unstrained(structure) => Vec::new(),
        FabricQuantity::Tension => {
            let tensions = structure.principal_tensions_n_m.iter();
            tensions.map(|pair| pair[0]).collect()
        }
        FabricQuantity::Stress => megapascal(&structure.stress_pa),
        FabricQuantity::VonMises => megapascal(&structure.von_mises_pa),
        FabricQuantity::ShearStress => megapascal(&structure.shear_stress_pa),
        FabricQuantity::Wrinkles => structure.states.iter().map(|s| place(*s)).collect(),
    };
    values.resize(structure.triangles.len(), f64::NAN);
    values
}

/// Ends of the scale, if nobody gave them: from 0 to the 98th percentile, for shear of both signs.
pub(super) fn range(quantity: FabricQuantity, values: &[f64]) -> [f64; 2] {
    match quantity {
        FabricQuantity::Wrinkles => [0.0, 3.0],
        FabricQuantity::ShearStress => {
            let [_, top] = range_from_zero(values.iter().map(|v| v.abs()));
            [-top, top]
        }
        _ => range_from_zero(values.iter().copied()),
    }
}

/// Most triangles whose edges are drawn: in a picture of a megapixel the edges of more would cover the colours.
const MOST_WITH_EDGES: usize = 40_000;

/// The fabric, coloured by `values` over `range`; `None` without fabric.
pub(super) fn surface(
    structure: &StructureFrame,
    quantity: FabricQuantity,
    values: &[f64],
    range: [f64; 2],
    mesh_edges: bool,
    zoom: f64,
) -> Option<Surface> {
    let style = |width: f64, opacity| LineStyle {
        width_px: width * zoom,
        colour: INK,
        opacity,
    };
    (!structure.triangles.is_empty()).then(|| Surface {
        vertices_m: structure.positions_m.clone(),
        triangles: structure.triangles.clone(),
        values: if quantity == FabricQuantity::Wrinkles {
            values.to_vec()
        } else {
            smoothed(values, structure)
        },
        range,
        scale: scale(quantity),
        mesh_edges: (mesh_edges && structure.triangles.len() <= MOST_WITH_EDGES)
            .then(|| style(0.6, 0.22)),
        boundary: Some(style(1.4, 0.9)),
    })
}

/// A stroke along the wrinkles of every wrinkled triangle.
pub(super) fn wrinkle_strokes(structure: &StructureFrame, zoom: f64) -> Vec<Polyline> {
    if is_unstrained(structure) {
        return Vec::new();
    }
    let style = LineStyle {
        width_px: 1.1 * zoom,
        colour: INK,
        opacity: 0.8,
    };
    let count = structure.triangles.len();
    let wrinkled = (0..count).filter(|&t| structure.states.get(t) == Some(&FabricState::Wrinkled));
    wrinkled
        .filter_map(|t| {
            let direction = *structure.tension_directions.get(t)?;
            let area_m2 = structure.rest_areas_m2.get(t)?;
            let corners = structure.triangles[t].map(|n| structure.positions_m.get(n as usize));
            let [a, b, c] = corners;
            let middle: DVec3 = (*a? + *b? + *c?) / 3.0;
            let half = direction * (0.5 * STROKE_LENGTH * area_m2.sqrt());
            Some(Polyline {
                points_m: vec![middle - half, middle + half],
                style,
            })
        })
        .collect()
}

/// Values of triangles as means over their nodes' means: linear triangles alternate around the true tension, which hides its
/// course in a picture (the files keep the triangles' own values). Values that are not finite stay out.
fn smoothed(values: &[f64], structure: &StructureFrame) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); structure.positions_m.len()];
    for (nodes, value) in structure.triangles.iter().zip(values) {
        for &node in nodes {
            if let Some(sum) = sums.get_mut(node as usize)
                && value.is_finite()
            {
                sum.0 += value;
                sum.1 += 1.0;
            }
        }
    }
    let mean = |node: &u32| {
        sums.get(*node as usize)
            .map_or(f64::NAN, |(sum, count)| sum / count)
    };
    structure
        .triangles
        .iter()
        .map(|nodes| nodes.iter().map(mean).sum::<f64>() / 3.0)
        .collect()
}
