//! Sizes and masses of a wing as it is designed.

use super::builder::Builder;
use super::parts::{LineKind, Part};
use super::section::Side;

/// Sizes and masses of a wing as designed.
#[derive(Debug, Clone, PartialEq)]
pub struct Measures {
    /// Area of the unrolled wing, chord times span [m²].
    pub flat_area_m2: f64,
    /// Span along the arc [m].
    pub flat_span_m: f64,
    /// Area of the chord lines seen from above [m²].
    pub projected_area_m2: f64,
    /// Distance of the tips seen from above [m].
    pub projected_span_m: f64,
    /// Largest chord [m].
    pub largest_chord_m: f64,
    /// Volume between the ribs without ballooning: mean section times width of every cell [m³].
    pub section_volume_m3: f64,
    /// Per part: triangles, area, mass [m², kg].
    pub parts: Vec<(Part, usize, f64, f64)>,
    /// Length of all lines, both halves, without risers [m].
    pub line_length_m: f64,
    /// Mass of lines, risers and tapes [kg].
    pub cable_mass_kg: f64,
    /// Mass of all rods [kg].
    pub rod_mass_kg: f64,
    /// Number of lines on both halves, without risers.
    pub lines: usize,
}

impl Measures {
    /// Flat aspect ratio.
    #[must_use]
    pub fn flat_aspect_ratio(&self) -> f64 {
        self.flat_span_m * self.flat_span_m / self.flat_area_m2
    }

    /// Projected aspect ratio.
    #[must_use]
    pub fn projected_aspect_ratio(&self) -> f64 {
        self.projected_span_m * self.projected_span_m / self.projected_area_m2
    }

    pub(super) fn new(builder: &Builder) -> Self {
        let frames = &builder.frames;
        let mut measures = Self {
            flat_area_m2: 0.0,
            flat_span_m: frames[frames.len() - 1].span_m - frames[0].span_m,
            projected_area_m2: 0.0,
            projected_span_m: frames[frames.len() - 1].quarter_m.y - frames[0].quarter_m.y,
            largest_chord_m: frames.iter().map(|f| f.chord_m).fold(0.0, f64::max),
            section_volume_m3: 0.0,
            parts: Vec::new(),
            line_length_m: 0.0,
            cable_mass_kg: 0.0,
            rod_mass_kg: 0.0,
            lines: 0,
        };
        for (rib, pair) in frames.windows(2).enumerate() {
            let chord = 0.5 * (pair[0].chord_m + pair[1].chord_m);
            measures.flat_area_m2 += chord * (pair[1].span_m - pair[0].span_m);
            // Chord lines seen from above, a quadrilateral.
            let corners = [
                pair[0].point(0.0, 0.0),
                pair[0].point(1.0, 0.0),
                pair[1].point(1.0, 0.0),
                pair[1].point(0.0, 0.0),
            ];
            let twice: f64 = (0..4)
                .map(|i| {
                    let (a, b) = (corners[i], corners[(i + 1) % 4]);
                    a.x * b.y - a.y * b.x
                })
                .sum();
            measures.projected_area_m2 += 0.5 * twice.abs();
            let width = pair[1].quarter_m.distance(pair[0].quarter_m);
            let section = 0.5 * (section_m2(builder, rib) + section_m2(builder, rib + 1));
            measures.section_volume_m3 += section * width;
        }
        for part in Part::ALL {
            let (mut count, mut area, mut mass) = (0, 0.0, 0.0);
            let triangles = builder.structure.triangles.iter().zip(&builder.tags);
            for (triangle, _) in triangles.filter(|(_, tag)| tag.part == part) {
                count += 1;
                area += triangle.rest_area_m2;
                let fabric = &builder.fabrics[triangle.fabric as usize];
                mass += fabric.areal_density_kg_m2() * triangle.rest_area_m2;
            }
            if count > 0 {
                measures.parts.push((part, count, area, mass));
            }
        }
        let cables = builder.structure.cables.iter().zip(&builder.line_kinds);
        for (cable, kind) in cables {
            if matches!(kind, LineKind::Line { .. }) {
                measures.line_length_m += cable.rest_length_m;
                measures.lines += 1;
            }
        }
        let fabric: f64 = measures.parts.iter().map(|part| part.3).sum();
        measures.rod_mass_kg = builder.rod_mass_kg;
        let sewn = fabric + measures.rod_mass_kg;
        measures.cable_mass_kg = builder.structure.masses_kg.iter().sum::<f64>() - sewn;
        measures
    }
}

/// Area of a rib's outline [m²].
fn section_m2(builder: &Builder, rib: usize) -> f64 {
    let chord = builder.frames[rib].chord_m;
    let side = |side: Side| {
        let places = builder.places.of(side);
        let height = |x| builder.frames[rib].height(&builder.plan.profiles, side, x);
        places
            .windows(2)
            .map(|p| 0.5 * (height(p[0]) + height(p[1])) * (p[1] - p[0]))
            .sum::<f64>()
    };
    chord * chord * (side(Side::Upper) - side(Side::Lower))
}
