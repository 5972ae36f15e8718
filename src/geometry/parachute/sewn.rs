//! A canopy's fabric, cut and folded, before lines are rigged: the same for the flat circular canopy without a vent ([`super::gores`]), whose
//! rings are circles, and for every other ([`super::pattern`]).

use std::f64::consts::PI;

use glam::DVec3;

use super::designs::{Design, Shape};
use super::gores::{self, FlatCircular};
use super::pattern::{Path, Pattern, PatternMesh};
use super::{crossings, folding, pleats};
use crate::cloth::openings::Opening;
use crate::geometry::mesh::quality::{self, Quality};

/// What canopy it is.
#[derive(Debug, Clone, PartialEq)]
pub enum Cut {
    /// Flat circular without a vent.
    Circle(FlatCircular),
    /// Any other design, and its pattern.
    Gores(Design, Pattern),
}

impl Cut {
    /// Nominal area S₀ [m²].
    #[must_use]
    pub const fn nominal_area_m2(&self) -> f64 {
        match self {
            Self::Circle(circle) => circle.nominal_area_m2,
            Self::Gores(design, _) => design.nominal_area_m2,
        }
    }

    /// Nominal diameter D₀ [m].
    #[must_use]
    pub fn nominal_diameter_m(&self) -> f64 {
        (4.0 * self.nominal_area_m2() / PI).sqrt()
    }
}

/// Fabric cut and folded.
#[derive(Debug, Clone)]
pub struct Sewn {
    /// Folded, the apex on the axis, the skirt towards −x [m].
    pub positions_m: Vec<DVec3>,
    /// Triangles; normals out of the canopy.
    pub triangles: Vec<[u32; 3]>,
    /// Their corners in the flat pattern [m].
    pub rest_m: Vec<[DVec3; 3]>,
    /// Their warp directions in the flat pattern.
    pub warps: Vec<DVec3>,
    /// Nodes at the apex: one, or the edge of the vent.
    pub apex: Vec<u32>,
    /// By line, in the order in which they are rigged.
    pub radials: Vec<Radial>,
    /// Ends of vent lines on the edge of the vent, in opposite pairs, and the length from edge to edge [m].
    pub vent_lines: Option<VentLines>,
    /// The edge of the vent.
    pub vent: Option<Path>,
    /// The lower edge.
    pub skirt: Vec<Path>,
    /// Openings.
    pub openings: Vec<Opening>,
    /// Quality of the triangles at rest.
    pub quality: Option<Quality>,
}

/// What runs along a seam or a centre line.
#[derive(Debug, Clone, Default)]
pub struct Radial {
    /// Where a belt may be sewn.
    pub belts: Vec<Path>,
    /// Where a line runs over a gap.
    pub gaps: Vec<Path>,
    /// Where tapes run over gaps, between this seam and the next.
    pub tapes: Vec<Path>,
    /// Where a suspension line begins, if one does.
    pub line: Option<u32>,
}

/// Where vent lines end.
#[derive(Debug, Clone, PartialEq)]
pub struct VentLines {
    /// Nodes on the edge of the vent, one per seam.
    pub ends: Vec<u32>,
    /// From edge to edge [m].
    pub length_m: f64,
}

/// Places of lines on the lower edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinePlaces {
    /// At every seam.
    Seams,
    /// At every seam and every centre line.
    SeamsAndCentres,
    /// So many along each free end of a cruciform canopy.
    Ends(usize),
}

/// How a canopy is folded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Folding {
    /// Projected diameter over the nominal one.
    pub diameter_ratio: f64,
    /// Unevenness a of the pleats, 0 for even ones.
    pub asymmetry: f64,
}

/// Cuts and folds a canopy; `None` where no such folding exists.
#[must_use]
pub fn sew(cut: &Cut, lines: LinePlaces, folding: &Folding) -> Option<Sewn> {
    match cut {
        Cut::Circle(circle) => sew_circle(circle, lines, folding),
        Cut::Gores(design, pattern) => sew_gores(design, pattern, lines, folding),
    }
}

fn sew_circle(circle: &FlatCircular, lines: LinePlaces, folding: &Folding) -> Option<Sewn> {
    let mesh = gores::mesh(circle);
    let ratio = folding.diameter_ratio;
    let positions_m = if folding.asymmetry == 0.0 {
        folding::pleated_cone(circle, &mesh, ratio)?
    } else {
        folding::uneven_cone(circle, &mesh, ratio, folding.asymmetry)?
    };
    let distance = |pair: &[u32]| {
        mesh.flat_positions_m[pair[0] as usize].distance(mesh.flat_positions_m[pair[1] as usize])
    };
    let along = |nodes: &[u32]| Path {
        nodes: nodes.to_vec(),
        rest_m: nodes.windows(2).map(distance).collect(),
    };
    let radial = |nodes: &Vec<u32>| Radial {
        belts: vec![along(nodes)],
        line: nodes.last().copied(),
        ..Radial::default()
    };
    let with_centres = lines == LinePlaces::SeamsAndCentres;
    let radials = (mesh.seams.iter().zip(&mesh.centres))
        .flat_map(|(seam, centre)| [Some(seam), with_centres.then_some(centre)])
        .flatten()
        .map(radial)
        .collect();
    let around = 2 * circle.gores * circle.segments(circle.rings);
    let first = mesh.flat_positions_m.len() - around;
    let skirt: Vec<u32> = (0..=around).map(|k| (first + k % around) as u32).collect();
    Some(Sewn {
        rest_m: mesh
            .triangles
            .iter()
            .map(|nodes| nodes.map(|n| mesh.flat_positions_m[n as usize]))
            .collect(),
        quality: quality::measure(&mesh.flat_positions_m, &mesh.triangles),
        skirt: vec![along(&skirt)],
        positions_m,
        triangles: mesh.triangles,
        warps: mesh.warps,
        apex: vec![0],
        radials,
        vent_lines: None,
        vent: None,
        openings: Vec::new(),
    })
}

fn sew_gores(
    design: &Design,
    pattern: &Pattern,
    lines: LinePlaces,
    folding: &Folding,
) -> Option<Sewn> {
    let mesh = pattern.mesh();
    let target = folding.diameter_ratio.powi(2) * design.nominal_area_m2;
    let positions_m = pleats::pleat(pattern, &mesh, target, folding.asymmetry)?;
    let apex: Vec<u32> = match &mesh.vent {
        None => vec![0],
        Some(vent) => vent.nodes[..vent.nodes.len() - 1].to_vec(),
    };
    let vent_lines = match (&mesh.vent, design.shape) {
        (Some(_), shape) if shape != Shape::Annular => Some(VentLines {
            ends: (0..pattern.gores)
                .map(|gore| mesh.node(0, gore, 0))
                .collect(),
            length_m: 2.0 * mesh.rows[0].at.half_width_m / pattern.half_gore_rad().sin(),
        }),
        _ => None,
    };
    let quality = quality::measure_corners(mesh.rest_m.iter().copied());
    let radials = radials(&mesh, pattern, lines);
    Some(Sewn {
        positions_m,
        warps: vec![DVec3::X; mesh.triangles.len()],
        triangles: mesh.triangles,
        rest_m: mesh.rest_m,
        apex,
        radials,
        vent_lines,
        vent: mesh.vent,
        skirt: mesh.skirt,
        openings: mesh.openings,
        quality,
    })
}

fn radials(mesh: &PatternMesh, pattern: &Pattern, lines: LinePlaces) -> Vec<Radial> {
    let last = mesh.rows.len() - 1;
    let row = mesh.rows[last];
    let mut found = Vec::new();
    for gore in 0..pattern.gores {
        let seam = Radial {
            belts: mesh.seams[gore].clone(),
            gaps: crossings::along_seam(mesh, gore),
            tapes: crossings::tapes(mesh, gore, pattern.tapes_per_gore),
            line: Some(mesh.node(last, gore, 0)),
        };
        match lines {
            LinePlaces::Seams => found.push(seam),
            LinePlaces::SeamsAndCentres => {
                found.push(seam);
                found.push(Radial {
                    belts: mesh.centres[gore].clone(),
                    gaps: crossings::along_centre(mesh, gore),
                    tapes: Vec::new(),
                    line: Some(mesh.node(last, gore, row.segments)),
                });
            }
            LinePlaces::Ends(count) => {
                let spaces = (count - 1).max(1);
                let middle = Radial {
                    belts: mesh.seams[gore].clone(),
                    ..Radial::default()
                };
                found.push(middle);
                for line in 0..count {
                    let j = if count == 1 {
                        row.segments
                    } else {
                        line * 2 * row.segments / spaces
                    };
                    found.push(Radial {
                        line: Some(mesh.node(last, gore, j)),
                        ..Radial::default()
                    });
                }
            }
        }
    }
    found
}
