//! The immersed boundary on the CPU: stages `interpolate`, `spread` and `repeat_forcing` (the crate's page tells of the coupling).
//!
//! All in lattice units. A marker k of area A_k [cells²] with locally normalised over-relaxation a_k gives the air the force
//! g_k = 2 a_k A_k (v_k − u*_k) [per step], where
//!
//! a_k = min(a_max, a · (3/8) / D_k),  D_k = Σ_x φ_k(x) Σ_j A_j φ_j(x).
//!
//! On a flat sheet D_k = 3/8 and a_k = a; where folds put several layers under one kernel D_k grows and a_k falls, which
//! keeps a_k D_k ≤ 1 and with it the exchange stable. *Departure from Inamuro's multi-direct forcing (paper P0)*: one pass, over-relaxed,
//! with the reaction inside the implicit step of the cloth instead of a prescribed marker velocity. Rigid bodies, whose markers' velocities
//! are prescribed, may have several passes (stage `repeat_forcing`).

mod interpolate;
mod repeat_forcing;
mod spread;

use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::fluid::ForcedCells;
use crate::immersed::touched::{Domain, TouchedCells};

/// Section of a checkpoint with the forces of the markers.
pub const FORCES: &str = "marker_forces";

/// Markers in the air.
#[derive(Debug, Clone)]
pub struct Immersed {
    /// Over-relaxation a on a flat sheet.
    over_relaxation: f64,
    /// Marker areas [cells²], `[marker_count]`.
    areas: Vec<[f64; 1]>,
    domain: Domain,
    touched: TouchedCells,
    /// a_k, `[marker_count]`.
    strengths: Vec<f64>,
    /// u* at markers [cells per step], `[marker_count]`.
    air_velocities: Vec<[f64; 3]>,
    /// Bare velocities of the touched cells, `[touched]`.
    cell_velocities: Vec<[f64; 3]>,
    /// Σ_j A_j φ_j of the touched cells, `[touched]`.
    cell_areas: Vec<[f64; 1]>,
    /// Bare velocities and Σ_j A_j φ_j side by side, `[touched]`.
    cell_states: Vec<[f64; 4]>,
    /// Body force of the touched cells, `[touched]`.
    cell_forces: Vec<[f64; 3]>,
    /// Forces of the markers on the air, `[marker_count]`.
    marker_forces: Vec<[f64; 3]>,
    /// False until the first `spread`.
    active: bool,
}

impl Immersed {
    /// Markers of the given areas [cells²] in a domain.
    #[must_use]
    pub fn new(areas: Vec<f64>, over_relaxation: f64, domain: impl Into<Domain>) -> Self {
        let count = areas.len();
        Self {
            over_relaxation,
            areas: areas.into_iter().map(|a| [a]).collect(),
            domain: domain.into(),
            touched: TouchedCells::default(),
            strengths: vec![0.0; count],
            air_velocities: vec![[0.0; 3]; count],
            cell_velocities: Vec::new(),
            cell_areas: Vec::new(),
            cell_states: Vec::new(),
            cell_forces: Vec::new(),
            marker_forces: vec![[0.0; 3]; count],
            active: false,
        }
    }

    /// Number of markers.
    #[must_use]
    pub const fn marker_count(&self) -> usize {
        self.areas.len()
    }

    /// u* at the markers [cells per step].
    #[must_use]
    pub fn air_velocities(&self) -> &[[f64; 3]] {
        &self.air_velocities
    }

    /// Immersed-boundary stiffness 2 a_k A_k of marker `k` [lattice units].
    #[must_use]
    pub fn stiffness(&self, k: usize) -> f64 {
        2.0 * self.strengths[k] * self.areas[k][0]
    }

    /// Area of marker `k` [cells²].
    #[must_use]
    pub fn area(&self, k: usize) -> f64 {
        self.areas[k][0]
    }

    /// Force of marker `k` on the air by the last `spread` [lattice units].
    #[must_use]
    pub fn force(&self, k: usize) -> [f64; 3] {
        self.marker_forces[k]
    }

    /// The body force for the next collision.
    #[must_use]
    pub fn forced_cells(&self) -> ForcedCells<'_> {
        if !self.active {
            return ForcedCells::default();
        }
        ForcedCells {
            rows: &self.touched.rows,
            x: &self.touched.x,
            force: &self.cell_forces,
        }
    }
}

impl Immersed {
    /// True if all touched cells lie in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        self.touched
            .cells
            .iter()
            .all(|cell| (0..3).all(|a| (first[a]..end[a]).contains(&(cell[a] as usize))))
    }
}

impl Immersed {
    /// Writes what the next step reads; the lists of touched cells follow from the positions.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        out.put("markers_active", &[u64::from(self.active)])?;
        out.put("marker_strengths", &self.strengths)?;
        out.put("marker_air_velocities", &self.air_velocities)?;
        out.put(FORCES, &self.marker_forces)?;
        out.put("cell_velocities", &self.cell_velocities)
    }

    /// Goes on with forces that another engine spread at the positions of the last interpolation [lattice units].
    pub fn take_forces(&mut self, forces: &[[f64; 3]]) {
        self.marker_forces.copy_from_slice(forces);
        self.gather_cell_forces();
        self.active = true;
    }

    /// Takes it from a checkpoint; `positions` are those of the last interpolation [cells].
    pub fn restore(
        &mut self,
        from: &Reader,
        positions: &[[f64; 3]],
    ) -> Result<(), CheckpointError> {
        let count = self.areas.len();
        self.active = from.take_exactly::<u64>("markers_active", 1)?[0] == 1;
        self.strengths = from.take_exactly("marker_strengths", count)?;
        self.air_velocities = from.take_exactly("marker_air_velocities", count)?;
        self.marker_forces = from.take_exactly(FORCES, count)?;
        if self.active {
            self.touched
                .rebuild(positions, self.domain)
                .map_err(|left| {
                    from.damaged(format!("marker {} lies outside the air", left.marker))
                })?;
            self.cell_velocities =
                from.take_exactly("cell_velocities", self.touched.cells.len())?;
            self.gather_cell_forces();
        }
        Ok(())
    }
}
