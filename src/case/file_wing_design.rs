//! The parts of a case file that a designer asks of a wing beyond its equilibrium.

use serde::Deserialize;

/// `[equilibrium.load_test]`: the loads of the equilibrium, several times over.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTestTable {
    /// Multiples of the loads, growing, above 1.
    pub load_factors: Vec<f64>,
}
