//! Trim of a glider: the steady glide in which aerodynamic forces, weight and lines are in balance.
//!
//! A pilot hangs at the points where the risers are held, and may turn there, so his weight and drag pull through them. Unknown are the speed V,
//! the glide angle γ of the path below the horizon, and by how much the wing turns about the hang points. The air comes along (cos γ, 0, sin γ).
//! For a given shape of the wing ([`balance`]):
//!
//! ```text
//! M(φ) + weight of the wing about the hang points = 0        φ = γ + θ, stream against the shape, θ the turn, nose up
//! tan γ = D/L                                                D and L of wing, lines and pilot along and across the stream
//! ½ ρ V² √(C_L² + C_D²) S = W
//! ```
//!
//! Forces of a shape ([`glider`]) are those that its fabric feels: pressures of the panel method ([`skin`], [`outer`]) on triangles, drag of
//! sections, and drag of lines. Since pressures over few panels miss a part of the induced drag, a traction along the stream makes up the difference
//! to the far wake's. So what balances here are the very loads that the fabric is then solved under, in force and in moment.
//!
//! Paper P0, section 3: external pressure from a steady method of low fidelity, internal pressure prescribed, loosely coupled. Departures: the paper does
//! not say how the attitude follows; here it is that of the balance of moments, and a soft guide at the nose holds the fabric while it is solved, moved to
//! where the balance wants the wing, until it carries nothing.

pub mod balance;
mod flown_sections;
pub mod glider;
mod mouth;
pub mod outer;
pub mod skin;

use crate::aero::AeroError;

pub use balance::Balance;
pub use flown_sections::SectionSettings;
pub use glider::{Flight, Glider, Loads};

/// What a trim needs to know beside the wing.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Density of the air [kg/m³].
    pub density_kg_m3: f64,
    /// What hangs at the hang points [kg].
    pub pilot_mass_kg: f64,
    /// Its drag area C_D A [m²].
    pub pilot_drag_area_m2: f64,
    /// Drag coefficient of lines and risers across the stream.
    pub line_drag_coefficient: f64,
    /// Coefficient of the pressure inside all cells; `None`: by what stands before their mouths.
    pub inside: Option<f64>,
    /// Polars of the wing's sections.
    pub sections: SectionSettings,
    /// Panels along each side of a section.
    pub panels_per_side: usize,
    /// Most strips of the half wing.
    pub strips: usize,
    /// Share of the new shape that the air sees in every outer iteration.
    pub relaxation: f64,
    /// Whether the trim is sought on coarser meshes first.
    pub from_coarser_meshes: bool,
    /// When the wing stands still.
    pub tolerance: Tolerance,
    /// Outer iterations allowed.
    pub iteration_limit: usize,
}

/// Changes from one outer iteration to the next below which the wing stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Of the speed, over it.
    pub speed: f64,
    /// Of the glide ratio, over it.
    pub glide: f64,
    /// By how much the balance still turns the wing [rad].
    pub pitch_rad: f64,
    /// Root of the mean square of how far the outlines move, over the mean chord.
    pub shape: f64,
    /// What the risers carry less what acts on the wing, over the weight.
    pub balance: f64,
}

/// Why there is no trim.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrimError {
    /// The air cannot be computed.
    #[error("the flow around the wing cannot be computed: {0}")]
    Aero(#[from] AeroError),
    /// There is no angle at which moments are in balance.
    #[error(
        "moments about the hang points are in balance at no angle between stream and wing from {from_deg:.0} to {to_deg:.0} degrees (at the ends {from_n_m:.0} and {to_n_m:.0} N m): move structure.wing.hang_point_m or trim the rows"
    )]
    NoAngle {
        /// Where the search began [°].
        from_deg: f64,
        /// Where it ended [°].
        to_deg: f64,
        /// Moment there, nose up [N m].
        from_n_m: f64,
        /// And there.
        to_n_m: f64,
    },
    /// The air does not lift.
    #[error(
        "the wing does not lift at {angle_deg:.1} degrees between stream and wing: turn it, or check its profiles"
    )]
    NoLift {
        /// Angle [°].
        angle_deg: f64,
    },
    /// Moments jump over their balance.
    #[error(
        "moments about the hang points are in balance at no angle between stream and wing: at {angle_deg:.1} degrees they jump, to {moment_n_m:.0} N m on one side. The wing is at its stall there, or the stream stagnates at the lip of a mouth"
    )]
    Jump {
        /// Where they jump [°].
        angle_deg: f64,
        /// The smaller of the moments on both sides, nose up [N m].
        moment_n_m: f64,
    },
    /// Sections and wing do not agree on their lift.
    #[error(
        "at {angle_deg:.1} degrees between stream and wing the sections have no lift that agrees with the wing's (C_l differs by {residual:.1e}): the wing is beyond its stall or has collapsed, or a polar of [equilibrium.trim.polars] jumps"
    )]
    SectionsDisagree {
        /// Angle [°].
        angle_deg: f64,
        /// Largest difference of lift coefficients.
        residual: f64,
    },
}
