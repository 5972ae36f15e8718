//! Columns that a canopy's shape, stresses and lines add to the history; each is there only where the canopy has the part.

use std::f64::consts::PI;

use glam::DVec3;

use super::outline::Outline;
use super::record::largest;
use super::skirt::{asymmetry, gap_width_m, mean_radius_m, slot_width_m, wrinkle};
use crate::case::scene::Canopy;
use crate::cloth::Structure;
use crate::frame::StructureFrame;
use crate::geometry::parachute::shape;

/// Of every canopy.
const ALWAYS: [&str; 14] = [
    "projected_area_m2",
    "fabric_area_m2",
    "height_to_projected_diameter",
    "apex_dent_m",
    "top_projected_diameter_ratio",
    "von_mises_max_pa",
    "shear_stress_max_pa",
    "shear_stress_min_pa",
    "shear_strain_max",
    "shear_strain_min",
    "principal_strain_1_max",
    "principal_strain_1_min",
    "principal_strain_2_max",
    "principal_strain_2_min",
];

/// With a vent.
const VENT: [&str; 2] = ["vent_radius_m", "vent_stress_max_pa"];

/// With an even number of lines on the skirt, at least four.
const ACROSS: [&str; 5] = [
    "edge_distance_m",
    "edge_distance_min_m",
    "edge_distance_max_m",
    "line_tension_min_n",
    "line_tension_asymmetry",
];

/// With suspension lines that go on along the fabric.
const PARTS: [&str; 2] = ["line_tension_lower_mean_n", "line_tension_upper_mean_n"];

/// With nodes between the attachments of lines.
const WRINKLES: [&str; 5] = [
    "wrinkle_height_m",
    "wrinkle_height_max_m",
    "wrinkle_height_asymmetry",
    "wrinkle_radius_m",
    "wrinkle_angle_deg",
];

/// Largest and smallest.
fn extremes(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    [
        values.clone().fold(f64::NEG_INFINITY, f64::max),
        values.fold(f64::INFINITY, f64::min),
    ]
}

/// What is measured on a canopy besides its forces.
#[derive(Debug, Clone)]
pub(super) struct CanopyShape {
    canopy: Canopy,
    outline: Outline,
    /// Triangles and gores carry stresses: not a spring network.
    stressed: bool,
}

impl CanopyShape {
    pub fn new(structure: &Structure, canopy: &Canopy) -> Self {
        Self {
            canopy: *canopy,
            outline: Outline::new(structure, canopy),
            stressed: structure.membrane.is_some(),
        }
    }

    pub const fn outline(&self) -> &Outline {
        &self.outline
    }

    fn has_opposite_lines(&self) -> bool {
        let count = self.outline.lines.len();
        count >= 4 && count.is_multiple_of(2)
    }

    fn has_upper_lines(&self) -> bool {
        self.outline.lines.iter().any(|line| !line.upper.is_empty())
    }

    fn has_wrinkles(&self) -> bool {
        !self.outline.gores.is_empty() && self.outline.gores.iter().all(|gore| gore.len() > 2)
    }

    /// Columns of the history.
    pub fn columns(&self) -> Vec<String> {
        let mut names: Vec<&str> = ALWAYS.to_vec();
        let stresses = |name: &str| name.ends_with("_pa");
        if !self.stressed {
            names.retain(|name| !(stresses(name) || name.contains("strain")));
        }
        if !self.outline.vent.is_empty() {
            names.extend(VENT.iter().filter(|n| self.stressed || !stresses(n)));
        }
        if self.has_opposite_lines() {
            names.extend(ACROSS);
        }
        if self.has_upper_lines() {
            names.extend(PARTS);
        }
        if self.has_wrinkles() {
            names.extend(WRINKLES);
        }
        if !self.outline.gaps.is_empty() {
            names.push("gap_width_m");
        }
        if !self.outline.slots.is_empty() {
            names.extend(["slot_width_m", "slot_width_max_m"]);
        }
        names.into_iter().map(str::to_owned).collect()
    }

    /// Columns of `gores.csv`, behind those of the history in a record: tension of every line, and of every gore the wrinkle at its
    /// skirt and the distance of the middle of its skirt from the skirt's own middle.
    pub fn detail_columns(&self) -> Vec<String> {
        let lines = (1..=self.outline.lines.len()).map(|k| format!("line_{k:02}_tension_n"));
        let mut names: Vec<String> = lines.collect();
        if self.has_wrinkles() {
            for k in 1..=self.outline.gores.len() {
                names.extend(
                    [
                        "wrinkle_height_m",
                        "wrinkle_radius_m",
                        "wrinkle_angle_deg",
                        "skirt_radius_m",
                    ]
                    .map(|name| format!("gore_{k:02}_{name}")),
                );
            }
        }
        names
    }

    /// Values of [`Self::columns`], and of [`Self::detail_columns`], of a canopy with the given projected area [m²].
    pub fn row(&self, frame: &StructureFrame, projected_area_m2: f64) -> (Vec<f64>, Vec<f64>) {
        let outline = &self.outline;
        let places = |nodes: &[u32]| -> Vec<DVec3> {
            nodes
                .iter()
                .map(|&n| frame.positions_m[n as usize])
                .collect()
        };
        let fabric = &frame.positions_m[..self.canopy.canopy_node_count];
        let height = shape::height_m(fabric);
        let downstream = fabric.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
        let apex = outline.apex(&frame.positions_m);
        let top = outline.top.iter().map(|&t| frame.triangles[t]);
        let top_area = shape::projected_area_m2(&frame.positions_m, top);
        let mut row = vec![
            projected_area_m2,
            fabric_area_m2(frame),
            height / (4.0 * projected_area_m2 / PI).sqrt(),
            downstream - apex.x,
            (top_area / outline.top_area_m2).sqrt(),
        ];
        if self.stressed {
            row.push(largest(frame.von_mises_pa.iter().copied()));
            row.extend(extremes(frame.shear_stress_pa.iter().copied()));
            row.extend(extremes(frame.shear_strain.iter().copied()));
            for k in 0..2 {
                row.extend(extremes(frame.principal_strains.iter().map(|e| e[k])));
            }
        }
        if !outline.vent.is_empty() {
            row.push(mean_radius_m(&places(&outline.vent)));
            if self.stressed {
                row.push(largest(outline.at_vent.iter().map(|&t| frame.stress_pa[t])));
            }
        }
        let part = |segments: &[usize]| {
            let sum: f64 = segments.iter().map(|&s| frame.cable_tensions_n[s]).sum();
            sum / segments.len() as f64
        };
        let tensions: Vec<f64> = outline.lines.iter().map(|line| part(&line.lower)).collect();
        if self.has_opposite_lines() {
            let half = outline.lines.len() / 2;
            let across: Vec<f64> = (0..half)
                .map(|k| {
                    let [a, b] = [k, k + half]
                        .map(|line| frame.positions_m[outline.lines[line].attachment as usize]);
                    a.distance(b)
                })
                .collect();
            row.extend([
                across.iter().sum::<f64>() / half as f64,
                across.iter().copied().fold(f64::INFINITY, f64::min),
                across.iter().copied().fold(0.0, f64::max),
                tensions.iter().copied().fold(f64::INFINITY, f64::min),
                asymmetry(&tensions),
            ]);
        }
        if self.has_upper_lines() {
            let upper = outline.lines.iter().filter(|line| !line.upper.is_empty());
            let upper: Vec<f64> = upper.map(|line| part(&line.upper)).collect();
            row.extend([&tensions, &upper].map(|t| t.iter().sum::<f64>() / t.len() as f64));
        }
        let mut details = tensions;
        if self.has_wrinkles() {
            let (mean, of_gores) = self.wrinkles(frame, &places);
            row.extend(mean);
            details.extend(of_gores);
        }
        if !outline.gaps.is_empty() {
            let widths = outline.gaps.iter().map(|[one, other]| {
                let [one, other] = [places(one), places(other)];
                0.5 * (gap_width_m(&one, &other) + gap_width_m(&other, &one))
            });
            row.push(widths.sum::<f64>() / outline.gaps.len() as f64);
        }
        if !outline.slots.is_empty() {
            let widths: Vec<f64> = outline
                .slots
                .iter()
                .map(|slot| slot_width_m(&places(slot)))
                .collect();
            row.extend([
                widths.iter().sum::<f64>() / widths.len() as f64,
                widths.iter().copied().fold(0.0, f64::max),
            ]);
        }
        (row, details)
    }

    /// Values of [`WRINKLES`], and those of every gore.
    fn wrinkles(
        &self,
        frame: &StructureFrame,
        places: &dyn Fn(&[u32]) -> Vec<DVec3>,
    ) -> ([f64; 5], Vec<f64>) {
        let gores = &self.outline.gores;
        let skirt = places(&self.outline.skirt);
        let centre = skirt.iter().copied().sum::<DVec3>() / skirt.len() as f64;
        let mut details = Vec::with_capacity(4 * gores.len());
        let (mut heights, mut curvature, mut angle) = (Vec::new(), 0.0, 0.0);
        for gore in gores {
            let middle = frame.positions_m[gore[gore.len() / 2] as usize] - centre;
            let radius = middle.y.hypot(middle.z);
            let Some(found) = wrinkle(&places(gore)) else {
                heights.push(f64::NAN);
                details.extend([f64::NAN, f64::NAN, f64::NAN, radius]);
                continue;
            };
            heights.push(found.height_m);
            curvature += found.curvature_1_m / gores.len() as f64;
            angle += found.angle_deg / gores.len() as f64;
            details.extend([
                found.height_m,
                1.0 / found.curvature_1_m,
                found.angle_deg,
                radius,
            ]);
        }
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let highest = heights.iter().copied().fold(0.0, f64::max);
        let row = [mean, highest, asymmetry(&heights), 1.0 / curvature, angle];
        (row, details)
    }
}

/// Area of the fabric as it is stretched [m²].
fn fabric_area_m2(frame: &StructureFrame) -> f64 {
    let area = |nodes: &[u32; 3]| {
        let [a, b, c] = nodes.map(|n| frame.positions_m[n as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    frame.triangles.iter().map(area).sum()
}
