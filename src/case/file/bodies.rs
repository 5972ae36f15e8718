//! What may be written in `[bodies.NAME]`: rigid bodies and their motions.

use schemars::JsonSchema;
use serde::Deserialize;

use super::fabric::Permeability;
use super::friction::Friction;
use crate::geometry::mesh::doctor::Kind;

/// A rigid body in the air (docs/rigid-bodies.md). Exactly one shape: `sphere`, `disk`, `plate`, `cylinder`, `wing` or `mesh`. Its name has letters,
/// digits, - and _.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Middle of its shape at t = 0; of a wing or a mesh the origin of its places [m]. If absent of a single sphere, disk, plate or cylinder it stands in the middle
    /// of the tunnel's section. A held body may pass through sides that are not periodic and through the outlet: what lies outside is left out
    /// (docs/rigid-bodies.md#bodies-that-pass-through-a-face).
    pub position_m: Option<[f64; 3]>,
    /// Turns the shape about its `position_m`; absent: not at all.
    pub rotation: Option<Rotation>,
    /// A sphere.
    pub sphere: Option<SphereShape>,
    /// A disk without thickness, normal along x.
    pub disk: Option<DiskShape>,
    /// A rectangle without thickness, normal along x.
    pub plate: Option<PlateShape>,
    /// A circular cylinder along z.
    pub cylinder: Option<CylinderShape>,
    /// A closed wing by its sections.
    pub wing: Option<WingShape>,
    /// A surface from a file.
    pub mesh: Option<SurfaceFile>,
    /// How it moves; absent: it is held.
    pub motion: Option<Motion>,
    /// What coefficients refer to; absent: what follows from the shape. Required of a mesh.
    pub reference: Option<Reference>,
    /// How air passes an open surface, such as a panel in an opening; absent: not at all. Not together with `coupling.passes`.
    pub permeability: Option<Permeability>,
    /// How the air passes along the surface; `no_slip` if absent.
    pub friction: Option<Friction>,
}

impl Body {
    /// Its diameter as written, if it has one [m].
    pub(in crate::case) fn diameter_m(&self) -> Option<f64> {
        let sphere = self.sphere.as_ref().map(|s| s.diameter_m);
        let disk = self.disk.as_ref().map(|d| d.diameter_m);
        let cylinder = self.cylinder.as_ref().map(|c| c.diameter_m);
        sphere.or(disk).or(cylinder).filter(|d| *d > 0.0)
    }

    /// Its largest extent as written; `None` of a mesh [m].
    pub(in crate::case) fn extent_m(&self) -> Option<f64> {
        let plate = self.plate.as_ref().map(|p| p.size_m[0].max(p.size_m[1]));
        let length = self.cylinder.as_ref().map(|c| c.length_m);
        let extent = [self.diameter_m(), plate, length]
            .into_iter()
            .flatten()
            .fold(0.0, f64::max);
        Some(extent).filter(|extent| *extent > 0.0)
    }

    /// Its free fall, if it has one.
    pub(in crate::case) const fn free_fall(&self) -> Option<&FreeFall> {
        match &self.motion {
            Some(Motion::FreeFall(fall)) => Some(fall),
            _ => None,
        }
    }
}

/// A turn.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Axis, of any length.
    pub axis: [f64; 3],
    /// Angle about it [°].
    pub angle_deg: f64,
}

/// A sphere.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereShape {
    /// Diameter [m].
    pub diameter_m: f64,
}

/// A disk.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiskShape {
    /// Diameter [m].
    pub diameter_m: f64,
}

/// A rectangle.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlateShape {
    /// Width along y, height along z [m].
    pub size_m: [f64; 2],
}

/// A circular cylinder.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// Diameter [m].
    pub diameter_m: f64,
    /// Length [m].
    pub length_m: f64,
    /// Whether it has flat ends.
    pub closed: bool,
}

/// A closed wing by its sections. x runs downstream, y to the right, z up; `rotation` about y by a positive angle lifts its nose.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingShape {
    /// Four or five digits of the NACA profile of all sections. Exactly one of `naca` and `file`.
    pub naca: Option<String>,
    /// File of the profile's coordinates in Selig's format, relative to the case file.
    pub file: Option<String>,
    /// Sections in order of the span; everything varies linearly between them.
    pub stations: Vec<WingStation>,
    /// Where along the chord the positions of the stations are, 0 at the nose; 0.25 if absent.
    pub chord_fraction: Option<f64>,
    /// Whether the stations are the right half of a wing that is symmetric about y = 0; `true` if absent. Else they run from the left tip to the right one.
    pub symmetric: Option<bool>,
}

/// A section of a wing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingStation {
    /// Point of the chord at `chord_fraction` [m].
    pub position_m: [f64; 3],
    /// Chord [m].
    pub chord_m: f64,
    /// Turn about that point, nose up [°]; 0 if absent.
    pub twist_deg: Option<f64>,
}

/// A surface from a file, closed or open.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// OBJ, STL or PLY file, relative to the case file.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f64,
    /// Vertices nearer than this are joined [m]; 0 if absent (docs/meshes.md#joining-seams).
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours (docs/meshes.md#turning-triangles-alike); `false` if absent.
    #[serde(default)]
    pub orient_triangles: bool,
    /// Findings that are meant; others refuse the case (docs/meshes.md). None if absent.
    #[serde(default)]
    pub accept: Vec<Kind>,
}

/// What coefficients refer to.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Area [m²]. If absent it is that of the shape, however it is turned: πD²/4, diameter times length of a cylinder, all of a plate, the chords of a wing laid flat. A mesh needs it. Of a body that passes through a face it is the part in the box.
    pub area_m2: Option<f64>,
    /// Length [m]; diameter or smaller side if absent.
    pub length_m: Option<f64>,
    /// Point of the body that moments are about [m]; `position_m` if absent.
    pub moment_point_m: Option<[f64; 3]>,
}

/// A motion; exactly one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// At constant velocity from t = 0.
    ConstantVelocity(ConstantVelocity),
    /// Turning at constant rate from t = 0.
    ConstantRotation(ConstantRotation),
    /// `displacement_m` · sin and `angle_deg` · sin about `axis` through `centre_m`.
    Oscillation(Oscillation),
    /// Places and angles over time, joined by a natural cubic spline.
    Table(MotionRows),
    /// Falls along −x, only in `[air.descent]`, of open surfaces only, without turning; the box stays with it. Not of supports.
    FreeFall(FreeFall),
}

impl Motion {
    /// The point that it turns about, where it names one [m].
    pub(in crate::case) const fn centre_m(&mut self) -> Option<&mut [f64; 3]> {
        match self {
            Self::ConstantRotation(given) => given.centre_m.as_mut(),
            Self::Oscillation(given) => given.centre_m.as_mut(),
            Self::Table(given) => given.centre_m.as_mut(),
            Self::ConstantVelocity(_) | Self::FreeFall(_) => None,
        }
    }
}

/// Constant velocity.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantVelocity {
    /// Velocity [m/s].
    pub velocity_m_s: [f64; 3],
    /// Time in which the velocity rises, from t = 0 [s]; 0 if absent.
    pub start_time_s: Option<f64>,
}

/// Constant rotation.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantRotation {
    /// Axis, of any length.
    pub axis: [f64; 3],
    /// Angular velocity about it [rad/s].
    pub rate_rad_s: f64,
    /// Point on the axis [m]; if absent `position_m` of a body, the middle of the nodes of a support.
    pub centre_m: Option<[f64; 3]>,
    /// Time in which the rate rises, from t = 0 [s]; 0 if absent.
    pub start_time_s: Option<f64>,
}

/// Harmonic motion.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Oscillation {
    /// Frequency [Hz].
    pub frequency_hz: f64,
    /// Phase at t = 0 [°]; 0 if absent.
    pub phase_deg: Option<f64>,
    /// Amplitude of the displacement [m]; 0 if absent.
    pub displacement_m: Option<[f64; 3]>,
    /// Amplitude of the angle [°]; 0 if absent.
    pub angle_deg: Option<f64>,
    /// Axis of the angle, of any length; required where it turns.
    pub axis: Option<[f64; 3]>,
    /// Point on the axis [m]; if absent `position_m` of a body, the middle of the nodes of a support.
    pub centre_m: Option<[f64; 3]>,
}

/// Motion by a table, which must cover the run.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionRows {
    /// Times, ascending [s].
    pub times_s: Vec<f64>,
    /// Displacement at each of `times_s` [m]; 0 if absent.
    pub displacements_m: Option<Vec<[f64; 3]>>,
    /// Angle about `axis` at each of `times_s` [°]; 0 if absent.
    pub angles_deg: Option<Vec<f64>>,
    /// Axis of the angles, of any length; required with them.
    pub axis: Option<[f64; 3]>,
    /// Point on the axis [m]; if absent `position_m` of a body, the middle of the nodes of a support.
    pub centre_m: Option<[f64; 3]>,
}

/// Free fall.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeFall {
    /// Mass [kg].
    pub mass_kg: f64,
}
