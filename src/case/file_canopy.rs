//! `[structure]` tables of canopies, and `[lines]`.

use serde::Deserialize;

/// A table of a canopy: what all have, and keys of its own.
macro_rules! canopy_table {
    ($(#[$about:meta])* $name:ident { $($key:ident: $kind:ty),* $(,)? }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(
            missing_docs,
            reason = "the keys are documented in docs/canopies.md and name quantity and unit"
        )]
        pub struct $name {
            $(pub $key: $kind,)*
            pub rings: usize,
            pub confluence_m: [f64; 3],
            pub apex_guide_n_m: Option<f64>,
            pub folding: Folding,
        }

        impl $name {
            /// What all canopies have.
            pub(super) fn common(&self) -> CanopyCommon {
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
pub(super) struct CanopyCommon {
    pub(super) confluence_m: [f64; 3],
    pub(super) apex_guide_n_m: Option<f64>,
    pub(super) folding: Folding,
}

canopy_table! {
    /// `[structure.flat_circular]`.
    FlatCircular {
        nominal_area_m2: f64,
        gores: usize,
        vent_diameter_m: Option<f64>,
    }
}

canopy_table! {
    /// `[structure.conical]`.
    Conical {
        nominal_area_m2: f64,
        gores: usize,
        vent_diameter_m: Option<f64>,
        cone_angle_deg: f64,
    }
}

canopy_table! {
    /// `[structure.slotted]`.
    Slotted {
        nominal_area_m2: f64,
        gores: usize,
        vent_diameter_m: Option<f64>,
        cone_angle_deg: Option<f64>,
        slots: usize,
        slot_width_m: f64,
        slot_from_m: f64,
        slot_to_m: f64,
    }
}

canopy_table! {
    /// `[structure.extended_skirt]`.
    ExtendedSkirt {
        nominal_area_m2: f64,
        gores: usize,
        vent_diameter_m: Option<f64>,
        extension_ratio: f64,
        skirt_width_ratio: Option<f64>,
    }
}

canopy_table! {
    /// `[structure.annular]`.
    Annular {
        nominal_area_m2: f64,
        gores: usize,
        opening_diameter_m: f64,
    }
}

canopy_table! {
    /// `[structure.disk_gap_band]`.
    DiskGapBand {
        nominal_area_m2: Option<f64>,
        nominal_diameter_m: Option<f64>,
        gores: usize,
        vent_diameter_m: f64,
        disk_diameter_m: Option<f64>,
        gap_width_m: Option<f64>,
        band_width_m: Option<f64>,
    }
}

canopy_table! {
    /// `[structure.cruciform]`.
    Cruciform {
        length_m: f64,
        width_m: f64,
    }
}

/// `[structure.CANOPY.folding]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/canopies.md and name quantity and unit"
)]
pub struct Folding {
    pub folded_diameter_ratio: f64,
    pub opened_diameter_ratio: f64,
    pub loading_pressure_pa: f64,
    /// Away from the wind, about the confluence.
    pub tilt_deg: Option<f64>,
    /// Of the pleats.
    pub asymmetry: Option<f64>,
}

/// `[lines]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Lines {
    pub count: usize,
    pub length_m: f64,
    /// Length beyond that, or less.
    pub slack_m: Option<f64>,
    /// Per line.
    pub segments: Option<usize>,
    /// Below the confluence, or above it if there are several.
    pub riser_length_m: Option<f64>,
    /// One if absent.
    pub riser_count: Option<usize>,
    pub area_m2: f64,
    pub density_kg_m3: f64,
    /// Or a table.
    pub youngs_modulus_pa: Option<f64>,
    pub force_strain: Option<Vec<[f64; 2]>>,
    pub damping_n_s: Option<f64>,
    /// With a diameter.
    pub drag_coefficient: Option<f64>,
    pub diameter_m: Option<f64>,
}
