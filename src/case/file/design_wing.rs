//! What may be written in `[wing]`: a paraglider by a few lines, from which a whole plan and its trim follow.

use schemars::JsonSchema;
use serde::Deserialize;

use super::design::Quality;

/// A paraglider in its steady glide, by span, cells and class: plan, lines, materials and trim follow from it, and may be written to change what
/// follows (docs/design.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingDesign {
    /// Class of EN 926-2 whose proportions it has.
    pub class: WingClass,
    /// Flat span [m]. Exactly one of span and area.
    pub span_m: Option<f64>,
    /// `span_m` in another unit [ft].
    pub span_ft: Option<f64>,
    /// Flat area [m²].
    pub area_m2: Option<f64>,
    /// Cells from tip to tip, 6 to 200; 38, 48, 60 or 70 by the class if absent.
    pub cells: Option<usize>,
    /// Flat span squared over flat area, 2.5 to 9; by the class if absent.
    pub aspect_ratio: Option<f64>,
    /// Thickness of the profile in the middle over the chord [%], 10 to 22, a whole number; by the class if absent.
    pub thickness_percent: Option<u32>,
    /// Pilot, harness and all else that hangs on the risers [kg]; 3.9 kg per m² of flat area if absent.
    pub pilot_kg: Option<f64>,
    /// `pilot_kg` in another unit [lb].
    pub pilot_lb: Option<f64>,
    /// Altitude whose standard atmosphere is taken, −500 to 11000 [m]; 0 if absent.
    pub altitude_m: Option<f64>,
    /// `altitude_m` in another unit [ft].
    pub altitude_ft: Option<f64>,
    /// How fine mesh and panels are; `"normal"` if absent. `--quality` on the command line.
    pub quality: Option<Quality>,
}

/// Class of a paraglider (EN 926-2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WingClass {
    /// For beginners.
    EnA,
    /// For all pilots with some practice.
    EnB,
    /// For pilots who fly often.
    EnC,
    /// For experts.
    EnD,
}
