//! The parts of a case file that a designer asks of a wing beyond its equilibrium.

use serde::{Deserialize, Serialize};

use super::file::CableMaterial;
use super::file_wing::BallooningTable;

/// `[equilibrium.load_test]`: the loads of the equilibrium, several times over.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTestTable {
    /// Multiples of the loads, growing, above 1.
    pub load_factors: Vec<f64>,
}

/// `[equilibrium.panel_shaping]`: widths of panels with which the flown shape is the designed one.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelShapingTable {
    /// What is to come out; the ballooning if absent.
    pub aim: Option<ShapingAim>,
    /// Ballooning to be flown; that of the plan if absent.
    pub target: Option<BallooningTable>,
    /// Largest difference of the flown ballooning from it; 0.002 if absent.
    pub tolerance: Option<f64>,
    /// Share of the difference by which panels are changed; 0.7 if absent.
    pub relaxation: Option<f64>,
    /// Changes allowed; 10 if absent.
    pub iteration_limit: Option<usize>,
}

/// What panels are shaped for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapingAim {
    /// Ribs fly as far apart as they were designed.
    CellWidth,
    /// Panels stand out as far as is wanted.
    Ballooning,
}

/// `[structure.lep_sim]`: a wing that LEparagliding Studio has drawn.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LepSimTable {
    /// Its `lep-sim.json`, relative to the case file.
    pub file: String,
    /// What all its lines are made of.
    pub line_material: CableMaterial,
}
