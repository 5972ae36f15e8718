//! What a canopy's shape, stresses and lines add to the history; each column is there only where the canopy has the part.

use std::f64::consts::PI;

use glam::DVec3;

use super::outline::Outline;
use super::read_out::Reduction::{LargestAndMean, Mean, SmallestAndMean};
use super::read_out::{When, columns};
use super::shared::{SHEAR_STRESS_MAX, VON_MISES_MAX};
use super::skirt::{Wrinkle, asymmetry, gap_width_m, mean_radius_m, slot_width_m, wrinkle};
use super::statistics::{average, largest};
use crate::case::scene::Canopy;
use crate::cloth::Structure;
use crate::frame::StructureFrame;
use crate::geometry::parachute::shape;
use crate::output::ReadOut;

static STRESSED: When<CanopyShape> = When {
    words: "not of springs",
    holds: |shape| shape.stressed,
};

static VENT: When<CanopyShape> = When {
    words: "with a vent",
    holds: |shape| !shape.outline.vent.is_empty(),
};

static STRESSED_VENT: When<CanopyShape> = When {
    words: "with a vent, not of springs",
    holds: |shape| shape.stressed && !shape.outline.vent.is_empty(),
};

static OPPOSITE_LINES: When<CanopyShape> = When {
    words: "with an even number of lines, at least four",
    holds: CanopyShape::has_opposite_lines,
};

static UPPER_LINES: When<CanopyShape> = When {
    words: "with lines that go on along the fabric",
    holds: |shape| {
        shape
            .outline
            .lines
            .iter()
            .any(|line| !line.upper.is_empty())
    },
};

static WRINKLES: When<CanopyShape> = When {
    words: "with nodes between the attachments of lines",
    holds: CanopyShape::has_wrinkles,
};

static GAPS: When<CanopyShape> = When {
    words: "with gaps",
    holds: |shape| !shape.outline.gaps.is_empty(),
};

static SLOTS: When<CanopyShape> = When {
    words: "with slots",
    holds: |shape| !shape.outline.slots.is_empty(),
};

columns! {
    /// Behind the columns of its forces.
    COLUMNS of Shape, in CanopyShape: "Canopies in air: shape, stresses and lines";
    PROJECTED_AREA: "projected_area_m2", "m2", "area of the canopy seen along the wind"
        => |now| now.projected_area_m2, reduced Mean;
    FABRIC_AREA: "fabric_area_m2", "m2", "area of the fabric; stretched"
        => |now| fabric_area_m2(&now.frame), reduced Mean;
    HEIGHT_TO_DIAMETER: "height_to_projected_diameter", "1", "height over projected diameter"
        => |now| now.height_m / (4.0 * now.projected_area_m2 / PI).sqrt(), reduced Mean;
    APEX_DENT: "apex_dent_m", "m", "depth of the apex upstream of the farthest node downstream"
        => |now| now.apex_dent_m;
    TOP_DIAMETER_RATIO: "top_projected_diameter_ratio", "1", "projected diameter of the inner half of the canopy; over that laid flat"
        => |now| now.top_diameter_ratio;
    VON_MISES_MAX
        => |now| largest(now.frame.von_mises_pa.iter().copied()), reduced LargestAndMean("von_mises_max_steady_pa"), when STRESSED;
    SHEAR_STRESS_MAX
        => |now| most(now.frame.shear_stress_pa.iter().copied()), reduced LargestAndMean("shear_stress_max_steady_pa"), when STRESSED;
    SHEAR_STRESS_MIN: "shear_stress_min_pa", "Pa", "smallest shear stress; between warp and weft"
        => |now| least(now.frame.shear_stress_pa.iter().copied()), reduced SmallestAndMean("shear_stress_min_steady_pa"), when STRESSED;
    SHEAR_STRAIN_MAX: "shear_strain_max", "1", "largest shear strain; between warp and weft"
        => |now| most(now.frame.shear_strain.iter().copied()), reduced LargestAndMean("shear_strain_max_steady"), when STRESSED;
    SHEAR_STRAIN_MIN: "shear_strain_min", "1", "smallest shear strain; between warp and weft"
        => |now| least(now.frame.shear_strain.iter().copied()), reduced SmallestAndMean("shear_strain_min_steady"), when STRESSED;
    PRINCIPAL_STRAIN_1_MAX: "principal_strain_1_max", "1", "largest first principal strain"
        => |now| most(now.principal_strains(0)), reduced LargestAndMean("principal_strain_1_max_steady"), when STRESSED;
    PRINCIPAL_STRAIN_1_MIN: "principal_strain_1_min", "1", "smallest first principal strain"
        => |now| least(now.principal_strains(0)), reduced SmallestAndMean("principal_strain_1_min_steady"), when STRESSED;
    PRINCIPAL_STRAIN_2_MAX: "principal_strain_2_max", "1", "largest second principal strain"
        => |now| most(now.principal_strains(1)), reduced LargestAndMean("principal_strain_2_max_steady"), when STRESSED;
    PRINCIPAL_STRAIN_2_MIN: "principal_strain_2_min", "1", "smallest second principal strain"
        => |now| least(now.principal_strains(1)), reduced SmallestAndMean("principal_strain_2_min_steady"), when STRESSED;
    VENT_RADIUS: "vent_radius_m", "m", "mean radius of the vent"
        => |now| now.vent_radius_m, reduced Mean, when VENT;
    VENT_STRESS_MAX: "vent_stress_max_pa", "Pa", "largest stress of the fabric at the vent"
        => |now| now.vent_stress_max_pa, reduced LargestAndMean("vent_stress_max_steady_pa"), when STRESSED_VENT;
    EDGE_DISTANCE: "edge_distance_m", "m", "distance of opposite attachments on the skirt; mean"
        => |now| average(&now.across_m), reduced Mean, when OPPOSITE_LINES;
    EDGE_DISTANCE_MIN: "edge_distance_min_m", "m", "smallest distance of opposite attachments on the skirt"
        => |now| least(now.across_m.iter().copied()), reduced Mean, when OPPOSITE_LINES;
    EDGE_DISTANCE_MAX: "edge_distance_max_m", "m", "largest distance of opposite attachments on the skirt"
        => |now| now.across_m.iter().copied().fold(0.0, f64::max), reduced Mean, when OPPOSITE_LINES;
    LINE_TENSION_MIN: "line_tension_min_n", "N", "smallest tension of a suspension line"
        => |now| least(now.tensions_n.iter().copied()), when OPPOSITE_LINES;
    LINE_TENSION_ASYMMETRY: "line_tension_asymmetry", "1", "asymmetry of opposite lines' tensions"
        => |now| asymmetry(&now.tensions_n), reduced Mean, when OPPOSITE_LINES;
    LINE_TENSION_LOWER_MEAN: "line_tension_lower_mean_n", "N", "mean tension of lines between attachment and confluence"
        => |now| average(&now.tensions_n), reduced Mean, when UPPER_LINES;
    LINE_TENSION_UPPER_MEAN: "line_tension_upper_mean_n", "N", "mean tension of lines along the fabric"
        => |now| average(&now.upper_tensions_n), reduced Mean, when UPPER_LINES;
    WRINKLE_HEIGHT: "wrinkle_height_m", "m", "mean height of the skirt's wrinkles"
        => |now| average(&now.wrinkle_heights_m()), reduced Mean, when WRINKLES;
    WRINKLE_HEIGHT_MAX: "wrinkle_height_max_m", "m", "largest height of a wrinkle of the skirt"
        => |now| now.wrinkle_heights_m().into_iter().fold(0.0, f64::max), reduced Mean, when WRINKLES;
    WRINKLE_HEIGHT_ASYMMETRY: "wrinkle_height_asymmetry", "1", "asymmetry of opposite wrinkles' heights"
        => |now| asymmetry(&now.wrinkle_heights_m()), reduced Mean, when WRINKLES;
    WRINKLE_RADIUS: "wrinkle_radius_m", "m", "radius of the skirt's wrinkles; one over their mean curvature"
        => |now| 1.0 / now.over_gores(|gore| gore.curvature_1_m), reduced Mean, when WRINKLES;
    WRINKLE_ANGLE: "wrinkle_angle_deg", "deg", "mean angle of the skirt's wrinkles; at their middle"
        => |now| now.over_gores(|gore| gore.angle_deg), reduced Mean, when WRINKLES;
    GAP_WIDTH: "gap_width_m", "m", "mean width of gaps"
        => |now| average(&now.gap_widths_m), reduced Mean, when GAPS;
    SLOT_WIDTH: "slot_width_m", "m", "mean width of slots"
        => |now| average(&now.slot_widths_m), reduced Mean, when SLOTS;
    SLOT_WIDTH_MAX: "slot_width_max_m", "m", "largest width of a slot"
        => |now| now.slot_widths_m.iter().copied().fold(0.0, f64::max), reduced LargestAndMean("slot_width_max_steady_m"), when SLOTS;
}

columns! {
    /// Columns of `gores.csv` for every line, behind those of the history in a record.
    OF_LINE of f64, in CanopyShape: "Canopies in air: every line, in `gores.csv`";
    ONE_LINE_TENSION: "line_{line}_tension_n", "N", "tension between attachment and confluence" => |tension_n| *tension_n;
}

columns! {
    /// And for every gore.
    OF_GORE of Gore, in CanopyShape: "Canopies in air: every gore, in `gores.csv`";
    GORE_WRINKLE_HEIGHT: "gore_{gore}_wrinkle_height_m", "m", "height of the wrinkle at the gore's skirt"
        => |gore| gore.height_m, when WRINKLES;
    GORE_WRINKLE_RADIUS: "gore_{gore}_wrinkle_radius_m", "m", "radius of that wrinkle"
        => |gore| 1.0 / gore.curvature_1_m, when WRINKLES;
    GORE_WRINKLE_ANGLE: "gore_{gore}_wrinkle_angle_deg", "deg", "angle at its middle"
        => |gore| gore.angle_deg, when WRINKLES;
    GORE_SKIRT_RADIUS: "gore_{gore}_skirt_radius_m", "m", "distance of the middle of the gore's skirt from the skirt's own middle"
        => |gore| gore.skirt_radius_m, when WRINKLES;
}

fn most(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

/// What is measured on a canopy besides its forces.
#[derive(Debug, Clone)]
pub(super) struct CanopyShape {
    canopy: Canopy,
    outline: Outline,
    /// Triangles and gores carry stresses: not a spring network.
    stressed: bool,
}

/// A canopy at a sample.
#[derive(Debug)]
pub(super) struct Shape {
    pub frame: StructureFrame,
    pub projected_area_m2: f64,
    pub height_m: f64,
    apex_dent_m: f64,
    top_diameter_ratio: f64,
    vent_radius_m: f64,
    vent_stress_max_pa: f64,
    /// Distances of opposite attachments [m].
    across_m: Vec<f64>,
    /// Of every line between attachment and confluence [N].
    tensions_n: Vec<f64>,
    /// Of those that go on along the fabric, there [N].
    upper_tensions_n: Vec<f64>,
    gores: Vec<Gore>,
    gap_widths_m: Vec<f64>,
    slot_widths_m: Vec<f64>,
}

/// The skirt of a gore at a sample; without a wrinkle its measures are not a number.
#[derive(Debug)]
pub(super) struct Gore {
    height_m: f64,
    curvature_1_m: f64,
    angle_deg: f64,
    skirt_radius_m: f64,
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

    pub fn has_wrinkles(&self) -> bool {
        !self.outline.gores.is_empty() && self.outline.gores.iter().all(|gore| gore.len() > 2)
    }

    /// Columns of `gores.csv`; lines and gores count from 1.
    pub fn detail_columns(&self) -> Vec<ReadOut> {
        let lines = (1..=self.outline.lines.len())
            .flat_map(|k| OF_LINE.read_outs_of(self, &format!("{k:02}")));
        let gores = (1..=self.outline.gores.len())
            .flat_map(|k| OF_GORE.read_outs_of(self, &format!("{k:02}")));
        lines.chain(gores).collect()
    }

    /// Their values.
    pub fn details(&self, now: &Shape) -> Vec<f64> {
        let lines = now.tensions_n.iter();
        let gores = now.gores.iter();
        lines
            .flat_map(|tension| OF_LINE.values(self, Some(tension)))
            .chain(gores.flat_map(|gore| OF_GORE.values(self, Some(gore))))
            .collect()
    }

    /// A sample.
    pub fn sample(&self, frame: StructureFrame) -> Shape {
        let outline = &self.outline;
        let positions_m = &frame.positions_m;
        let places = |nodes: &[u32]| -> Vec<DVec3> {
            nodes.iter().map(|&n| positions_m[n as usize]).collect()
        };
        let fabric = &positions_m[..self.canopy.canopy_node_count];
        let top = outline.top.iter().map(|&t| frame.triangles[t]);
        let top_area_m2 = shape::projected_area_m2(positions_m, top);
        let part = |segments: &[usize]| {
            let sum: f64 = segments.iter().map(|&s| frame.cable_tensions_n[s]).sum();
            sum / segments.len() as f64
        };
        let half = outline.lines.len() / 2;
        let across = |k: usize| {
            let [a, b] =
                [k, k + half].map(|line| positions_m[outline.lines[line].attachment as usize]);
            a.distance(b)
        };
        let upper = outline.lines.iter().filter(|line| !line.upper.is_empty());
        let widths = outline.gaps.iter().map(|[one, other]| {
            let [one, other] = [places(one), places(other)];
            0.5 * (gap_width_m(&one, &other) + gap_width_m(&other, &one))
        });
        let slots = outline.slots.iter();
        Shape {
            projected_area_m2: shape::projected_area_m2(
                positions_m,
                frame.triangles.iter().copied(),
            ),
            height_m: shape::height_m(fabric),
            apex_dent_m: most(fabric.iter().map(|p| p.x)) - outline.apex(positions_m).x,
            top_diameter_ratio: (top_area_m2 / outline.top_area_m2).sqrt(),
            vent_radius_m: match outline.vent.is_empty() {
                true => f64::NAN,
                false => mean_radius_m(&places(&outline.vent)),
            },
            vent_stress_max_pa: largest(outline.at_vent.iter().map(|&t| frame.stress_pa[t])),
            across_m: (0..half).map(across).collect(),
            tensions_n: outline.lines.iter().map(|line| part(&line.lower)).collect(),
            upper_tensions_n: upper.map(|line| part(&line.upper)).collect(),
            gores: match self.has_wrinkles() {
                true => self.gores(positions_m),
                false => Vec::new(),
            },
            gap_widths_m: widths.collect(),
            slot_widths_m: slots.map(|slot| slot_width_m(&places(slot))).collect(),
            frame,
        }
    }

    fn gores(&self, positions_m: &[DVec3]) -> Vec<Gore> {
        let places = |nodes: &[u32]| -> Vec<DVec3> {
            nodes.iter().map(|&n| positions_m[n as usize]).collect()
        };
        let skirt = places(&self.outline.skirt);
        let centre = skirt.iter().copied().sum::<DVec3>() / skirt.len() as f64;
        let gore = |gore: &Vec<u32>| {
            let middle = positions_m[gore[gore.len() / 2] as usize] - centre;
            let found = wrinkle(&places(gore));
            let of = |measure: fn(Wrinkle) -> f64| found.map_or(f64::NAN, measure);
            Gore {
                height_m: of(|wrinkle| wrinkle.height_m),
                curvature_1_m: of(|wrinkle| wrinkle.curvature_1_m),
                angle_deg: of(|wrinkle| wrinkle.angle_deg),
                skirt_radius_m: middle.y.hypot(middle.z),
            }
        };
        self.outline.gores.iter().map(gore).collect()
    }
}

impl Shape {
    fn principal_strains(&self, k: usize) -> impl Iterator<Item = f64> {
        self.frame.principal_strains.iter().map(move |e| e[k])
    }

    fn wrinkle_heights_m(&self) -> Vec<f64> {
        self.gores.iter().map(|gore| gore.height_m).collect()
    }

    /// Sum over the gores that have a wrinkle, over the number of all.
    fn over_gores(&self, of: fn(&Gore) -> f64) -> f64 {
        let number = self.gores.len() as f64;
        let known = self.gores.iter().map(of).filter(|value| !value.is_nan());
        known.fold(0.0, |sum, value| sum + value / number)
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
