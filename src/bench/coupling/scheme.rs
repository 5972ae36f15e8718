//! Schemes of coupling, and where they are compared.

/// Time from release [s]; nine D_0/U of the canopy.
pub(super) const END_S: f64 = 0.3;

/// Where the schemes are compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tunnel {
    /// Length, width and height [m].
    pub(super) size_m: [f64; 3],
    /// Of the lines' confluence, and of a disk in place of the canopy, from the inlet [m].
    pub(super) places_m: [f64; 2],
    pub(super) sponge_length_m: f64,
    /// Cells per D_0.
    pub(super) cells_per_diameter: f64,
}

/// Of the quick and of the full set; the second is that of the shipped case.
pub(super) const TUNNELS: [Tunnel; 2] = [
    Tunnel {
        size_m: [2.9915, 1.994, 1.994],
        places_m: [0.4, 1.2],
        sponge_length_m: 0.4,
        cells_per_diameter: 16.0,
    },
    Tunnel {
        size_m: [4.985, 2.991, 2.991],
        places_m: [0.6, 1.5],
        sponge_length_m: 0.75,
        cells_per_diameter: 24.0,
    },
];

/// Mass of fabric and lines over that of the air in a cell's thickness on the fabric, of the ladder.
pub(super) const MASS_RATIOS: [f64; 5] = [10.0, 1.0, 0.1, 0.01, 0.001];

/// Steps per solve of the ladder.
pub(super) const LADDER: [u32; 3] = [1, 4, 10];

/// A scheme of coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scheme {
    pub(super) over_relaxation: f64,
    pub(super) structure_every: u32,
    pub(super) averaging_steps: u32,
    pub(super) tolerance: f64,
    pub(super) marker_spacing_cells: f64,
    pub(super) passes: u32,
    /// `None` for the canopy's own.
    pub(super) mass_ratio: Option<f64>,
}

/// What the shipped cases have.
pub(super) const DEFAULT: Scheme = Scheme {
    over_relaxation: 1.6,
    structure_every: 1,
    averaging_steps: 1,
    tolerance: 1e-2,
    marker_spacing_cells: 1.0,
    passes: 1,
    mass_ratio: None,
};

pub(super) const OVER_RELAXATIONS: [f64; 3] = [1.0, 1.6, 8.0 / 3.0];

/// Schemes of the canopy, each once.
pub(super) fn schemes() -> Vec<Scheme> {
    let mut schemes = Vec::new();
    let mut add = |scheme| {
        if !schemes.contains(&scheme) {
            schemes.push(scheme);
        }
    };
    for over_relaxation in OVER_RELAXATIONS {
        for structure_every in [1, 2, 4, 10] {
            add(Scheme {
                over_relaxation,
                structure_every,
                ..DEFAULT
            });
        }
    }
    for over_relaxation in [1.6, 8.0 / 3.0] {
        for tolerance in [1e-1, 1e-3] {
            add(Scheme {
                over_relaxation,
                tolerance,
                ..DEFAULT
            });
        }
        for marker_spacing_cells in [0.75, 0.5] {
            add(Scheme {
                over_relaxation,
                marker_spacing_cells,
                ..DEFAULT
            });
        }
    }
    for averaging_steps in [2, 4] {
        add(Scheme {
            averaging_steps,
            ..DEFAULT
        });
    }
    schemes
}

/// Schemes of the rigid disk.
pub(super) fn rigid_schemes() -> Vec<Scheme> {
    let mut schemes = Vec::new();
    for over_relaxation in OVER_RELAXATIONS {
        for passes in [1, 2, 5] {
            schemes.push(Scheme {
                over_relaxation,
                passes,
                ..DEFAULT
            });
        }
    }
    schemes
}
