//! What may be written in `[canopy]`: a canopy by its design, from which all other tables follow.

use schemars::JsonSchema;
use serde::Deserialize;

/// A canopy by its design: all other tables follow from it, and may be written to change what follows (docs/design.md). With a speed it opens in a
/// wind tunnel; with a payload and a speed behind the falling payload; with a payload alone its steady descent is found. Lengths, speeds and
/// masses may be in other units, where the key says so.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CanopyDesign {
    /// How it is cut.
    #[serde(rename = "type")]
    pub kind: CanopyType,
    /// Nominal diameter D_0, of a circle of the nominal area [m].
    pub diameter_m: Option<f64>,
    /// `diameter_m` in another unit [ft].
    pub diameter_ft: Option<f64>,
    /// Speed of the wind; with a payload that of release [m/s]. With a payload alone the wind is as fast as payload and drag balance by the
    /// handbook's drag coefficient.
    pub speed_m_s: Option<f64>,
    /// `speed_m_s` in another unit [km/h].
    pub speed_km_h: Option<f64>,
    /// `speed_m_s` in another unit [ft/s].
    pub speed_ft_s: Option<f64>,
    /// `speed_m_s` in another unit [kt].
    pub speed_kt: Option<f64>,
    /// Mass that hangs on the canopy [kg].
    pub payload_kg: Option<f64>,
    /// `payload_kg` in another unit [lb].
    pub payload_lb: Option<f64>,
    /// C_D S of the payload itself [m²]; 0 if absent.
    pub payload_drag_area_m2: Option<f64>,
    /// Altitude whose standard atmosphere is taken, −500 to 11000 [m]; 0 if absent.
    pub altitude_m: Option<f64>,
    /// `altitude_m` in another unit [ft].
    pub altitude_ft: Option<f64>,
    /// Gores, 3 to 200; 8 to 64 by the diameter if absent. A cruciform canopy has none.
    pub gores: Option<usize>,
    /// Suspension lines, one or two per gore, of a cruciform canopy a multiple of 4; one per gore, or 16, if absent.
    pub line_count: Option<usize>,
    /// Diameter of the vent over D_0 [%]; 0, of a ringslot 10, of a disk-gap-band canopy 7 if absent. Not of a cruciform
    /// canopy.
    pub vent_percent: Option<f64>,
    /// Length of the lines over D_0; 1, of a disk-gap-band canopy 1.7 if absent.
    pub line_length_ratio: Option<f64>,
    /// Rise of a conical canopy's gores from the plane of the skirt [°]; 25 if absent.
    pub cone_angle_deg: Option<f64>,
    /// Width of an extended skirt over the diameter of the flat part [%]; 10 if absent.
    pub extension_percent: Option<f64>,
    /// Width over length of a cruciform canopy's rectangles; 0.27 if absent.
    pub arm_width_ratio: Option<f64>,
    /// Slots of a ringslot canopy; 6 if absent.
    pub slots: Option<usize>,
    /// Area of its slots over the nominal area [%]; 15 if absent.
    pub slot_percent: Option<f64>,
    /// Cloth by its name (docs/design.md); `"ripstop 40 g/m²"` if absent. A `[fabric]` table changes single constants.
    pub fabric: Option<String>,
    /// Suspension lines by their name; a nylon cord of 95 lbf up to a diameter of 1.5 m, of 400 lbf up to 4 m, of 550 lbf beyond if absent, or the
    /// weakest stronger one that bears three times its share of the opening load.
    pub lines: Option<String>,
    /// Tape on the seams by its name; `"nylon tape 13 mm, 250 lbf"` if absent.
    pub tapes: Option<String>,
    /// State at release; `"folded"` if absent, with a payload alone `"hemispherical"`, of a cruciform canopy `"open"`.
    pub start: Option<CanopyStart>,
    /// Whether a lateral spring keeps the apex on the axis, as tunnels do; a free canopy glides and swings. `true` if
    /// absent.
    pub guided: Option<bool>,
    /// Cells, rings of triangles, and how well the mean drag is to be known; `"normal"` if absent. `--quality` on the command line.
    pub quality: Option<Quality>,
}

/// How a canopy is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CanopyType {
    /// A circle of fabric.
    FlatCircular,
    /// A cone of gores.
    Conical,
    /// A flat circular part with a ring sewn to its edge.
    ExtendedSkirt,
    /// A disk, a gap and a band, in the proportions of the Viking type.
    DiskGapBand,
    /// Rings of fabric with slots between them.
    Ringslot,
    /// Two crossed rectangles.
    Cruciform,
}

/// State of a canopy as it is released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CanopyStart {
    /// Pleats that pressure has opened to D_p/D_0 = 0.2.
    Folded,
    /// Blown up by pressure to D_p/D_0 = 0.6.
    Hemispherical,
    /// A pleated cone of D_p/D_0 = 0.6.
    Open,
}

/// How fine a design is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// 16 cells per D_0, mean drag to 10 %. A wing has 14 edges along the chord, 2 across a cell.
    Draft,
    /// 24 cells, 5 %. A wing has 24 edges and 4.
    Normal,
    /// 32 cells, 3 %. A wing has 40 edges and 8.
    Fine,
}
