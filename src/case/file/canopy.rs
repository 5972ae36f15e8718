//! What may be written in `[structure]` tables of canopies, and in `[lines]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// A table of a canopy: what all have, and keys of its own.
macro_rules! canopy_table {
    ($(#[$about:meta])* $name:ident { $($(#[$meaning:meta])* $key:ident: $kind:ty),* $(,)? }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[$meaning])* pub $key: $kind,)*
            /// Rings of triangles from vent or apex to the skirt; at least 12 for results.
            pub rings: usize,
            /// Where all lines meet [m]. It is held, unless it carries a payload.
            pub confluence_m: [f64; 3],
            /// Stiffness of a lateral spring at the apex, or where vent lines cross [N/m]; absent: none.
            pub apex_guide_n_m: Option<f64>,
            /// How the canopy is folded at the start.
            pub folding: Folding,
        }

        impl $name {
            /// What all canopies have.
            pub(in crate::case) fn common(&self) -> CanopyCommon {
                CanopyCommon {
                    confluence_m: self.confluence_m,
                    apex_guide_n_m: self.apex_guide_n_m,
                    folding: self.folding.clone(),
                }
            }
        }
    };
}

/// Keys that every canopy has.
#[derive(Debug, Clone)]
pub(in crate::case) struct CanopyCommon {
    pub(in crate::case) confluence_m: [f64; 3],
    pub(in crate::case) apex_guide_n_m: Option<f64>,
    pub(in crate::case) folding: Folding,
}

canopy_table! {
    /// A circle of fabric; with a vent a polygon.
    FlatCircular {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
    }
}

canopy_table! {
    /// A cone of gores.
    Conical {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Rise of the gores' centre lines from the plane of the skirt, 0 to 60 [°].
        cone_angle_deg: f64,
    }
}

canopy_table! {
    /// A flat or conical canopy with slots along seams.
    Slotted {
        /// Nominal area S_0, vent and slots included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Rise of the gores' centre lines from the plane of the skirt, 0 to 60 [°]; 0 if absent.
        cone_angle_deg: Option<f64>,
        /// Number of slots, a divisor of `gores`.
        slots: usize,
        /// Width of a slot [m]; 0 for cuts along seams.
        slot_width_m: f64,
        /// Where slots begin, along the centre line from the constructed apex [m].
        slot_from_m: f64,
        /// Where they end [m].
        slot_to_m: f64,
    }
}

canopy_table! {
    /// A flat circular part with a ring sewn to its edge.
    ExtendedSkirt {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Width of the ring over the diameter of the flat part, 0.01 to 0.5.
        extension_ratio: f64,
        /// Width of a gore at the skirt over that at the edge of the flat part, 0.5 to 1; 1 if absent.
        skirt_width_ratio: Option<f64>,
    }
}

canopy_table! {
    /// A ring of fabric. No lines run across its opening or to the edge of it, and there is no guide.
    Annular {
        /// Nominal area S_0 of the fabric alone [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the opening's area [m].
        opening_diameter_m: f64,
    }
}

canopy_table! {
    /// A disk, a gap and a band. What is absent has the proportions of the Viking type (docs/canopies.md). Exactly one of
    /// `nominal_area_m2` and `nominal_diameter_m`.
    DiskGapBand {
        /// Nominal area S_0 of disk, vent, gap and band [m²].
        nominal_area_m2: Option<f64>,
        /// Diameter D_0 of a circle of that area [m].
        nominal_diameter_m: Option<f64>,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m].
        vent_diameter_m: f64,
        /// Diameter of a circle of the disk's area [m]; 0.7224 D_0 if absent.
        disk_diameter_m: Option<f64>,
        /// Width of the gap [m]; 0.0432 D_0 if absent.
        gap_width_m: Option<f64>,
        /// Width of the band [m]; what the nominal area leaves if absent.
        band_width_m: Option<f64>,
    }
}

canopy_table! {
    /// Two crossed rectangles, one layer where they cross: S_0 = width · (2 length − width).
    Cruciform {
        /// Length of one whole rectangle [m].
        length_m: f64,
        /// Its width [m].
        width_m: f64,
    }
}

/// How a canopy is folded at the start: pleats that keep all lengths (docs/canopies.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Folding {
    /// D_p/D_0 of the pleats, seams outward and centre lines inward; 0.02 to 0.95.
    pub folded_diameter_ratio: f64,
    /// D_p/D_0 to which pressure opens the canopy before the wind starts.
    pub opened_diameter_ratio: f64,
    /// That pressure [Pa].
    pub loading_pressure_pa: f64,
    /// Turn of the folded canopy towards +y about the confluence, −45 to 45 [°]; 0 if absent. Not with `apex_guide_n_m`.
    pub tilt_deg: Option<f64>,
    /// a of pleats that are not alike, at most 0.8: gore g takes the azimuth 2π/N (1 + a cos(2π (g + ½)/N)); 0 if absent.
    pub asymmetry: Option<f64>,
}

/// Suspension lines of a canopy. Exactly one of `youngs_modulus_pa` and `force_strain`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// Number of lines: one per seam (`gores`), or one more on every centre line (twice that). Cruciform: a multiple of 4, shared out over
    /// the four ends from corner to corner.
    pub count: usize,
    /// Length of the line that reaches farthest from the folded canopy [m]; all have the same unstretched length.
    pub length_m: f64,
    /// Unstretched length beyond `length_m` [m]; negative for tight lines; 0 if absent.
    pub slack_m: Option<f64>,
    /// Straight pieces of a line, with its mass and drag along it, 1 to 200; 1 if absent.
    pub segments: Option<usize>,
    /// Length of a riser below the confluence, as strong and heavy as all lines together [m]; absent: none. Its lower end is held or
    /// carries the payload. With several risers, of those above it.
    pub riser_length_m: Option<f64>,
    /// Risers above the confluence, a divisor of `count`: so many neighbouring lines join into each; 1, below it, if absent.
    pub riser_count: Option<usize>,
    /// Cross section of a line [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: Option<f64>,
    /// Points [strain, force in N] of a tensile test, rising from (0, 0); beyond the last it goes on straight.
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// c of T = f(ε) + c dε/dt while taut [N s]; 0 if absent.
    pub damping_n_s: Option<f64>,
    /// C_d of drag across the lines, ½ ρ C_d d |u_n| u_n per length, in the undisturbed wind and not given to the air; absent: none.
    pub drag_coefficient: Option<f64>,
    /// Diameter d that it refers to [m].
    pub diameter_m: Option<f64>,
}
