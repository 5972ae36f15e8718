//! Slots of vectors and points, and what stands in their place (`shaders/vector.wgsl`).

/// In place of a slot: none.
pub(super) const NONE: u32 = u32::MAX;
/// In place of a slot: the energies.
pub(super) const ENERGY: u32 = u32::MAX - 1;
/// Error of the energy by round-off, over the sum of its parts' magnitudes: a few roundings of 6e-8 per part.
pub(super) const ROUND_OFF: f64 = 1e-6;

/// Slot of the loads that set the scale of the tolerance.
pub(super) const DRIVE: u32 = 0;
/// Slot of H₀ times these.
pub(super) const DRIVE_STEP: u32 = 1;
/// Present point and trial.
pub(super) const POINTS: u64 = 2;
/// First slot of vectors that is not taken by the loads.
pub(super) const FIRST_FREE: u32 = 2;
