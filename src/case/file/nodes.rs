//! What may be written in `[nodes.NAME]` and `[springs.NAME]`: what a structure has beside what its kind gives it.

use schemars::JsonSchema;
use serde::Deserialize;

/// Masses, loads, velocities and supports of single nodes, not of wings. Exactly one of `at_m`, `box_m` and `nodes` chooses them, where they stand at the start.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Nodes {
    /// The node nearest to this place, at most an element away [m].
    pub at_m: Option<[f64; 3]>,
    /// Two opposite corners of a box: the nodes that start inside it [m].
    pub box_m: Option<[[f64; 3]; 2]>,
    /// Numbers of nodes, from 1.
    pub nodes: Option<Vec<u32>>,
    /// Mass that they have in addition, shared evenly [kg]; none if absent.
    pub mass_kg: Option<f64>,
    /// Force that pulls them, shared evenly, which stays as it is [N]; none if absent.
    pub load_n: Option<[f64; 3]>,
    /// Velocity at the start [m/s], only with `[time]` and without air; 0 if absent.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Angular velocity at the start about the middle of the nodes [rad/s], only with `[time]` and without air; 0 if absent.
    pub angular_velocity_rad_s: Option<[f64; 3]>,
    /// Whether they are held, not of canopies; as their kind has it if absent.
    pub held: Option<bool>,
}

/// A spring between two nodes, not of wings. Exactly one of `ends_m` and `nodes`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeSpring {
    /// The nodes nearest to these places at the start, at most an element away [m].
    pub ends_m: Option<[[f64; 3]; 2]>,
    /// Numbers of its nodes, from 1.
    pub nodes: Option<[u32; 2]>,
    /// Stiffness while it is longer than at rest [N/m].
    pub stiffness_n_m: f64,
    /// Stiffness while it is shorter [N/m]; 0 if absent.
    pub compressive_stiffness_n_m: Option<f64>,
    /// Length at rest [m]; the distance of its ends at the start if absent.
    pub rest_length_m: Option<f64>,
}
