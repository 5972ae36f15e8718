//! What may be written in `[air]` and `[resolution]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::refinement::Refinement;
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosityModel;

/// The undisturbed air, and exactly one flow of it: a wind tunnel, a descent, or decaying vortices.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Air {
    /// Density [kg/m³]. Required unless `air.descent.altitude_m` gives it.
    pub density_kg_m3: Option<f64>,
    /// Kinematic viscosity [m²/s].
    pub kinematic_viscosity_m2_s: f64,
    /// A box that falls with what it holds.
    pub descent: Option<Descent>,
    /// Wind along +x past what stands in it.
    pub wind_tunnel: Option<WindTunnel>,
    /// Decaying vortices in a periodic box: a test of the air alone.
    pub taylor_green: Option<TaylorGreen>,
    /// What lies beside, below and above a wind tunnel or a descent; absorbing sides if absent.
    pub faces: Option<Faces>,
    /// Boxes of finer cells.
    pub refinement: Option<Refinement>,
}

/// Sides of the box, and the wind at its inlet. The inlet and the outlet always let sound out.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Faces {
    /// All four sides that are not given by themselves; `"absorbing"` if absent.
    pub sides: Option<Side>,
    /// At the lower end of y.
    pub y_lower: Option<Side>,
    /// At the upper end of y.
    pub y_upper: Option<Side>,
    /// At the lower end of z.
    pub z_lower: Option<Side>,
    /// At the upper end of z.
    pub z_upper: Option<Side>,
    /// Wind that is not the same everywhere at the inlet; absent: it is. It rises everywhere as the profile has it. Coefficients refer to
    /// `air.wind_tunnel.speed_m_s`. Not in `[air.descent]`.
    pub inlet: Option<Inlet>,
}

/// Wind at the inlet over `air.wind_tunnel.speed_m_s`; exactly one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Inlet {
    /// The power law of a turbulent boundary layer on walls or on the ground.
    BoundaryLayer(BoundaryLayer),
    /// Ratios at distances from the lower side.
    Table(InletTable),
}

/// Speed (d/δ)^n at the distance d from the nearest of the sides, up to the thickness δ, and 1 beyond.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundaryLayer {
    /// Thickness δ [m].
    pub thickness_m: f64,
    /// Exponent n; 1/7 if absent.
    pub exponent: Option<f64>,
    /// Sides on which it lies; those that are `"no_slip"` if absent.
    pub sides: Option<Vec<BoxSide>>,
}

/// A side of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoxSide {
    /// At the lower end of y.
    YLower,
    /// At the upper end of y.
    YUpper,
    /// At the lower end of z.
    ZLower,
    /// At the upper end of z.
    ZUpper,
}

impl BoxSide {
    /// Distance of a place `[y, z]` in a box of the given size [m].
    pub(in crate::case) const fn distance_m(self, size_m: [f64; 3], [y_m, z_m]: [f64; 2]) -> f64 {
        match self {
            Self::YLower => y_m,
            Self::YUpper => size_m[1] - y_m,
            Self::ZLower => z_m,
            Self::ZUpper => size_m[2] - z_m,
        }
    }
}

/// Wind that changes along one axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InletTable {
    /// The axis.
    pub along: Across,
    /// Pairs of the distance from the lower side [m] and the ratio, 0 to 3; straight between them, constant beyond.
    pub points: Vec<[f64; 2]>,
}

/// An axis across the wind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Across {
    /// y.
    Y,
    /// z.
    Z,
}

/// What lies at a side of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// A frictionless wall for the flow that lets sound out: nothing flows through it in the mean.
    Absorbing,
    /// A frictionless solid wall: sound comes back from it.
    Frictionless,
    /// A plane of symmetry, which is a frictionless solid wall.
    Symmetry,
    /// A solid wall to which the air sticks; not in `[air.descent]`, where nothing stands still beside the box.
    NoSlip,
    /// The box repeats: both sides of an axis.
    Periodic,
}

/// Wind along +x between the sides of `[air.faces]`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindTunnel {
    /// Speed of the wind [m/s]. It may be 0, if `resolution.reference_speed_m_s` is given.
    pub speed_m_s: f64,
    /// Length, width and height of the box [m]. If absent of a drawn canopy or a single sphere, disk, plate or cylinder as large as it needs.
    pub size_m: Option<[f64; 3]>,
    /// Time in which the wind rises, uniformly, while the structure is held [s]. t = 0 is its end.
    pub start_time_s: f64,
    /// Length of a viscous layer before the outlet [m]; absent: none.
    pub sponge_length_m: Option<f64>,
}

/// A box that falls along −x with the payload, or with a body in free fall: the air comes along +x. Needs `[gravity]` along −x.
/// Coefficients refer to the speed of release, those of falls (docs/parachutes.md#falls) to the present one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Descent {
    /// Speed at release, at t = 0 [m/s].
    pub release_speed_m_s: f64,
    /// Length, width and height of the box [m]; as of a wind tunnel if absent.
    pub size_m: Option<[f64; 3]>,
    /// Time in which the air comes to the speed of release, before t = 0 [s].
    pub start_time_s: f64,
    /// Length of a viscous layer before the outlet [m]; absent: none.
    pub sponge_length_m: Option<f64>,
    /// Altitude whose standard density is used instead of `air.density_kg_m3` [m]. It stays the same on the way.
    pub altitude_m: Option<f64>,
}

impl Descent {
    /// The tunnel that the box is at release.
    pub(in crate::case) const fn tunnel(&self) -> WindTunnel {
        WindTunnel {
            speed_m_s: self.release_speed_m_s,
            size_m: self.size_m,
            start_time_s: self.start_time_s,
            sponge_length_m: self.sponge_length_m,
        }
    }
}

/// Decaying Taylor–Green vortices in a periodic box.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TaylorGreen {
    /// Largest speed at the start [m/s].
    pub speed_m_s: f64,
    /// Period along x and y [m].
    pub side_m: f64,
    /// Period along z [m].
    pub depth_m: f64,
}

/// Lattice of the air. Exactly one of `cell_size_m`, `cells_per_diameter` and `cells_per_chord`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resolution {
    /// Cells per nominal diameter of the canopy, or per diameter of the only rigid body.
    pub cells_per_diameter: Option<f64>,
    /// Cells per largest chord of a wing.
    pub cells_per_chord: Option<f64>,
    /// Side of a cell [m].
    pub cell_size_m: Option<f64>,
    /// Cells per step at the speed of the wind, at most 0.15; it sets the time step. In `[air.descent]` at the speed of release: as the
    /// speed falls, the time step grows with it, by a quarter of an octave at a time. If absent, sound on the lattice is as fast as in
    /// air: the lattice speed is the Mach number over √3, at most 0.08. Sound moves at 340.3 m/s, or as in the standard atmosphere at
    /// `air.descent.altitude_m`. Where that gives less than 0.03, and in liquids, 0.08 is taken: fewer steps, with slower sound.
    pub lattice_speed: Option<f64>,
    /// Speed that `lattice_speed` stands for [m/s]; the speed of the wind if absent. It sets the time step only: coefficients refer to
    /// the wind.
    pub reference_speed_m_s: Option<f64>,
    /// Collision operator of the lattice.
    pub operator: Operator,
    /// Eddy viscosity; absent: none.
    pub eddy_viscosity: Option<EddyViscosity>,
    /// Moves all that stands in the air against the lattice: parts of a cell along x, y, z, each between −1 and 1; 0 if absent. Walls
    /// come nearer by as much. `ripstop sweep --ensemble` tells by it what the place on the lattice does to a result
    /// (docs/parachutes.md#ensembles).
    pub shift_cells: Option<[f64; 3]>,
}

/// Eddy viscosity of a subgrid model.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EddyViscosity {
    /// Subgrid model. `wale` and `vreman` vanish in pure shear, and need a stage of their own.
    pub model: EddyViscosityModel,
    /// C_s, C_w or c of the model; published 0.1 to 0.2, 0.325 to 0.6, 0.025 to 0.07. With the regularised operator, which dissipates by
    /// itself, the smallest err least (`ripstop validate taylor-green-vortex`).
    pub constant: f64,
    /// Steps between evaluations, only of `wale` and `vreman`, 1 to 16; 4 if absent. With boxes of finer cells an odd number becomes the next even one.
    pub update_every: Option<u32>,
}
