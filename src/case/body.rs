//! Fabric and cables of a scene, with what is known of their kind.

use glam::DVec3;

use super::wing::Wing;
use crate::cloth::Structure;
use crate::cloth::rims::RimInsets;
use crate::geometry::mesh::quality::{self, Quality};
use crate::geometry::parachute::shape;
use crate::geometry::plate::Plate;
use crate::immersed::markers;

/// Fabric and cables with what reports need to know of them.
#[derive(Debug, Clone)]
pub struct Body {
    /// The structure at its start.
    pub structure: Structure,
    /// Quality of the fabric's mesh at rest.
    pub quality: Option<Quality>,
    /// What kind of structure it is.
    pub kind: BodyKind,
}

impl Body {
    /// A structure of fabric, whose nodes are at these places at rest [m].
    pub(super) fn new(structure: Structure, rest_m: &[DVec3], kind: BodyKind) -> Self {
        let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
        Self {
            quality: quality::measure(rest_m, &triangles),
            kind,
            structure,
        }
    }

    /// A structure of fabric that is at rest where it starts.
    pub(super) fn at_rest(structure: Structure, kind: BodyKind) -> Self {
        let rest_m = structure.positions_m.clone();
        Self::new(structure, &rest_m, kind)
    }

    /// The canopy, if it is one.
    #[must_use]
    pub const fn canopy(&self) -> Option<&Canopy> {
        match &self.kind {
            BodyKind::Canopy(canopy) => Some(canopy),
            _ => None,
        }
    }

    /// The plate, if it is one.
    #[must_use]
    pub const fn plate(&self) -> Option<&Plate> {
        match &self.kind {
            BodyKind::Plate(plate) => Some(plate),
            _ => None,
        }
    }

    /// The wing, if it is one.
    #[must_use]
    pub fn wing(&self) -> Option<&Wing> {
        match &self.kind {
            BodyKind::Wing(wing) => Some(wing),
            _ => None,
        }
    }

    /// The wing of another program, if it is one.
    #[must_use]
    pub const fn imported_wing(&self) -> Option<&ImportedWing> {
        match &self.kind {
            BodyKind::ImportedWing(wing) => Some(wing),
            _ => None,
        }
    }

    /// Share of the fabric's area that has markers: those near rims end inside them.
    #[must_use]
    pub fn marked_share(&self, insets: &RimInsets) -> f64 {
        markers::marked_share(self.structure.extents(insets))
    }

    /// True for a canopy from a mesh file.
    #[must_use]
    pub const fn is_from_mesh(&self) -> bool {
        matches!(self.kind, BodyKind::Canopy(Canopy { loading: None, .. }))
    }

    /// Projected diameter of this canopy over the nominal one as it is released: opened by pressure, or as its mesh stands.
    #[must_use]
    pub fn released_diameter_ratio(&self, canopy: &Canopy) -> f64 {
        canopy.loading.map_or_else(
            || {
                let triangles = self.structure.triangles.iter().map(|t| t.nodes);
                shape::projected_diameter_m(&self.structure.positions_m, triangles)
                    / canopy.nominal_diameter_m
            },
            |loading| loading.opened_diameter_ratio,
        )
    }
}

/// Kinds of structures, with what is known of each beside nodes and elements.
#[derive(Debug, Clone)]
pub enum BodyKind {
    /// A parachute canopy.
    Canopy(Canopy),
    /// A sheet of fabric.
    Sheet,
    /// A plate of fabric, held along one edge.
    Plate(Plate),
    /// A hanging cable between two ends.
    Cable(HangingCable),
    /// A mesh from a file.
    Mesh,
    /// A square airbag.
    Airbag(Airbag),
    /// A strip that is pulled.
    Coupon(Coupon),
    /// A ram-air wing.
    Wing(Box<Wing>),
    /// A wing from a file of another program.
    ImportedWing(ImportedWing),
}

/// A cable between two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangingCable {
    /// Distance of the ends [m].
    pub span_m: f64,
    /// Rest length [m].
    pub length_m: f64,
    /// Weight per length [N/m].
    pub weight_n_m: f64,
    /// True while nothing but its weight acts between two held ends.
    pub hangs_by_itself: bool,
}

/// What is measured on a square airbag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Airbag {
    /// Nodes in the middle of the upper and of the lower sheet.
    pub middles: [u32; 2],
}

/// What is measured on a strip that is pulled along x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupon {
    /// Width times thickness [m²].
    pub cross_section_m2: f64,
    /// Nodes whose distance is measured.
    pub gauge: [u32; 2],
    /// Their distance at rest [m].
    pub gauge_length_m: f64,
}

/// What is measured on a canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Canopy {
    /// Nominal area S₀ [m²].
    pub nominal_area_m2: f64,
    /// Nominal diameter D₀ [m].
    pub nominal_diameter_m: f64,
    /// Nodes of fabric, which come first; then the confluence, or where the lines of a mesh end, then others.
    pub canopy_node_count: usize,
    /// Node farthest from the skirt; means nothing where there is a vent.
    pub apex: usize,
    /// Node that is held or carries the payload: the confluence, or the lower end of the riser. `None`: the lines of a mesh end in
    /// several places, and all are held.
    pub lower_end: Option<usize>,
    /// How the folded canopy is opened before the wind starts; `None`: it starts as its mesh stands.
    pub loading: Option<LoadingPressure>,
}

impl Canopy {
    /// Where the lines meet, or the middle of where those of a mesh end, for the positions of all nodes \[m\].
    #[must_use]
    pub fn confluence_m(&self, positions_m: &[DVec3]) -> DVec3 {
        let ends = &positions_m[self.canopy_node_count..];
        let count = if self.lower_end.is_some() {
            1
        } else {
            ends.len()
        };
        ends[..count].iter().sum::<DVec3>() / count as f64
    }
}

/// Opening of a folded canopy by pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadingPressure {
    /// Pressure inside [Pa].
    pub pressure_pa: f64,
    /// Projected-diameter ratio to which it opens the canopy.
    pub opened_diameter_ratio: f64,
}

/// What is known of an imported wing beside its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedWing {
    /// Row of every line, `[cable_count]`.
    pub rows: Vec<String>,
    /// Nodes where lines are held.
    pub held: Vec<u32>,
    /// Pressure inside, on the skin alone \[Pa\], `[triangle_count]`.
    pub inside_pa: Vec<f64>,
    /// Volume as drawn [m³].
    pub volume_m3: f64,
    /// Farthest that the end of a line or strap was moved to a node [m].
    pub moved_max_m: f64,
}
