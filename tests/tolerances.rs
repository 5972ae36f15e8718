//! Every tolerance with its reason, in one place.

use crate::engines::Engine;

/// Decay rate of Taylor–Green vortices at 32 cells: second-order error at this resolution (gate F1: 0.5 %).
pub const DECAY_RATE: f64 = 5e-3;

/// Convergence order of the air under diffusive scaling: second order, a little less where round-off or start-up enters.
pub const CONVERGENCE_ORDER: f64 = 1.9;

/// Mass and momentum kept over some hundred steps, relative to the sum of absolute populations: round-off.
pub const fn conservation(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-13,
        // 2⁻²⁴ ≈ 6e-8 per operation on populations shifted by their weights (values near 1e-2).
        Engine::CpuF32 | Engine::Gpu => 1e-7,
    }
}

/// Two descriptions of the same flow (mirrored or periodic): they differ only in the order of sums.
pub const fn same_flow(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-13,
        Engine::CpuF32 | Engine::Gpu => 2e-6,
    }
}

/// Markers against momentum box: exact but for round-off accumulated over the window.
pub const fn momentum_closure(engine: Engine) -> f64 {
    match engine {
        Engine::CpuF64 => 1e-9,
        Engine::CpuF32 | Engine::Gpu => 1e-3,
    }
}

/// Catenary of 100 segments (gate C2).
pub const CATENARY: f64 = 1e-3;

/// Analytic gradients against central differences of the energy: truncation of the difference.
pub const GRADIENT: f64 = 1e-6;

/// Affine boundary displacements must give affine interiors (gate C1, membrane).
pub const PATCH: f64 = 1e-6;

/// Spread force balance of the three routes (the gate is 2 %).
pub const FORCE_IMBALANCE: f64 = 0.02;
