//! Sheets that several tests of fabric share, and what they do to them.

use glam::DVec3;
use ripstop::cloth::Structure;
use ripstop::fabric::Fabric;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};

pub fn fabric(shear_modulus_pa: f64, residual_stiffness: f64) -> Fabric {
    Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 500.0,
        warp_modulus_pa: 4e7,
        weft_modulus_pa: 2e7,
        poisson_ratio: 0.2,
        shear_modulus_pa,
        residual_stiffness,
        cubic_shear_compliance_1_pa3: None,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// A square of 1 m that hangs from `corner_m`.
pub fn square_at(
    corner_m: DVec3,
    divisions: usize,
    model: FabricModel,
    fabric: &Fabric,
) -> Structure {
    let shape = SheetShape {
        size_m: [1.0, 1.0],
        divisions: [divisions, divisions],
        corner_m,
        across: DVec3::X,
        down: -DVec3::Z,
    };
    sheet::build(&shape, fabric, model).unwrap()
}

/// Deterministic numbers in −1 … 1.
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Kinds of [`hostile`] starts.
pub const HOSTILE: std::ops::Range<u64> = 0..4;

/// Scatters the nodes, puts all in one place, turns the sheet inside out, or folds it to a line; the first node is held.
pub fn hostile(structure: &mut Structure, kind: u64) {
    let mut random = noise(kind);
    for p in &mut structure.positions_m {
        *p = match kind {
            0 => DVec3::new(random(), random(), random()) * 3.0,
            1 => DVec3::ZERO,
            2 => -*p,
            _ => DVec3::new(p.x * 1e-9, 0.0, p.z),
        };
    }
    structure.held[0] = true;
}
