//! Host snapshot of one instant, in SI units: all that `output` and `render` ever see.

use glam::DVec3;

/// What a simulation shows of itself at one instant.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Simulated time since release [s].
    pub time_s: f64,
    /// Fluid (or, without air, cloth) steps done.
    pub step: u64,
    /// The air; `None` in a scene without air.
    pub fluid: Option<FluidFrame>,
    /// Fabric and cables; `None` in a scene without a structure.
    pub structure: Option<StructureFrame>,
    /// Rigid bodies; `None` in a scene without.
    pub bodies: Option<BodiesFrame>,
}

/// Surfaces of all rigid bodies.
#[derive(Debug, Clone, Default)]
pub struct BodiesFrame {
    /// Node positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Node velocities [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
    /// Node indices of every triangle, `[triangle_count]`.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the body that a triangle belongs to, in the order of names, `[triangle_count]`.
    pub numbers: Vec<u32>,
}

/// The air on its regular grid, x fastest, then y, then z.
#[derive(Debug, Clone)]
pub struct FluidFrame {
    /// Centre of the first cell [m].
    pub origin_m: DVec3,
    /// Edge length of a cell [m].
    pub cell_size_m: f64,
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Velocity [m/s], `[cell_count]`.
    pub velocity_m_s: Vec<[f32; 3]>,
    /// Pressure above the outlet's [Pa], `[cell_count]`.
    pub pressure_pa: Vec<f32>,
    /// Boxes of finer cells in it, each before those in it; their cells stand for those that they cover.
    pub finer: Vec<Self>,
}

/// How a piece of fabric carries its load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FabricState {
    /// Tension in every direction.
    Taut,
    /// Tension in one direction, wrinkled across it.
    Wrinkled,
    /// No tension.
    Slack,
}

/// What a picture of fabric shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FabricQuantity {
    /// Larger principal tension [N/m].
    #[default]
    Tension,
    /// Largest principal stress [Pa].
    Stress,
    /// Von Mises stress [Pa].
    VonMises,
    /// Shear stress between warp and weft [Pa].
    ShearStress,
    /// Taut, wrinkled or slack, with the direction of wrinkles.
    Wrinkles,
}

impl FabricQuantity {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Tension,
        Self::Stress,
        Self::VonMises,
        Self::ShearStress,
        Self::Wrinkles,
    ];

    /// The word of case files and file names.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Stress => "stress",
            Self::VonMises => "von_mises",
            Self::ShearStress => "shear_stress",
            Self::Wrinkles => "wrinkles",
        }
    }
}

/// What a picture shows of the air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FlowQuantity {
    /// Speed [m/s].
    #[default]
    Speed,
    /// Vorticity across the plane that is shown [1/s]; positive where it turns anticlockwise to the eye.
    Vorticity,
    /// Pressure above the outlet's [Pa].
    Pressure,
}

impl FlowQuantity {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Speed, Self::Vorticity, Self::Pressure];

    /// The word of case files and file names.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Vorticity => "vorticity",
            Self::Pressure => "pressure",
        }
    }
}

/// What a cable is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CableKind {
    /// Suspension line from the skirt to the confluence.
    SuspensionLine,
    /// Reinforcing belt sewn on the fabric, sharing its nodes, or tape across a slot.
    Belt,
    /// Line across a vent.
    VentLine,
    /// Part of a suspension line that crosses a gap in the canopy.
    GapLine,
    /// What all suspension lines of a canopy hang on.
    Riser,
    /// A free-standing cable, such as a hanging chain.
    Cable,
}

/// Fabric and cables.
#[derive(Debug, Clone)]
pub struct StructureFrame {
    /// Node positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Node velocities [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
    /// Forces with which supports hold the structure [N], `[node_count]`; zero where a node is free. The pull of the air on a held node
    /// itself is not in it.
    pub reactions_n: Vec<DVec3>,
    /// Forces with which fabric pushes fabric [N], `[node_count]`; `None` where it passes through itself.
    pub contact_forces_n: Option<Vec<DVec3>>,
    /// Node indices of every fabric triangle, `[triangle_count]`.
    pub triangles: Vec<[u32; 3]>,
    /// Principal membrane tensions, larger first [N/m], `[triangle_count]`.
    pub principal_tensions_n_m: Vec<[f64; 2]>,
    /// Unit vectors along the larger principal tension, along which wrinkles run, `[triangle_count]`; zero where there is no tension.
    pub tension_directions: Vec<DVec3>,
    /// Largest principal stress over the thickness at rest [Pa], `[triangle_count]`.
    pub stress_pa: Vec<f64>,
    /// The same over the thickness of fabric that has kept its volume [Pa], `[triangle_count]`.
    pub true_stress_pa: Vec<f64>,
    /// Von Mises stress of plane stress [Pa], `[triangle_count]`.
    pub von_mises_pa: Vec<f64>,
    /// Shear stress between warp and weft [Pa], `[triangle_count]`.
    pub shear_stress_pa: Vec<f64>,
    /// Shear strain 2ε₁₂ between warp and weft, `[triangle_count]`.
    pub shear_strain: Vec<f64>,
    /// Principal strains (Green), larger first, `[triangle_count]`.
    pub principal_strains: Vec<[f64; 2]>,
    /// Von Mises stress from which fabric counts as yielding [Pa]; `None`: never.
    pub yield_stress_pa: Option<f64>,
    /// Rest area [m²], `[triangle_count]`.
    pub rest_areas_m2: Vec<f64>,
    /// Taut, wrinkled or slack, `[triangle_count]`.
    pub states: Vec<FabricState>,
    /// Node indices of every cable segment, `[cable_count]`.
    pub cables: Vec<[u32; 2]>,
    /// Kind of every cable segment, `[cable_count]`.
    pub cable_kinds: Vec<CableKind>,
    /// Tension [N], `[cable_count]`.
    pub cable_tensions_n: Vec<f64>,
}

impl StructureFrame {
    /// Tensions of all segments of cables of some kinds [N].
    pub fn tensions_n(&self, kinds: &[CableKind]) -> impl Iterator<Item = f64> {
        let tensions = self.cable_tensions_n.iter().zip(&self.cable_kinds);
        (tensions.filter(move |(_, own)| kinds.contains(own))).map(|(tension, _)| *tension)
    }

    /// The largest of them; `None` where there is no such cable.
    #[must_use]
    pub fn largest_tension_n(&self, kinds: &[CableKind]) -> Option<f64> {
        self.tensions_n(kinds).reduce(f64::max)
    }
}
