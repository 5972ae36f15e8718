//! Exit codes.

/// A gate of `ripstop validate` fails, or `--strict` finds results that are not supported.
pub const GATE_FAILED: u8 = 1;
/// Bad case or usage.
pub const BAD_CASE: u8 = 2;
/// No usable device.
pub const NO_DEVICE: u8 = 3;
/// The run diverged, its static equilibrium was not reached, or steps of the fabric were not solved.
pub const DIVERGED: u8 = 20;
/// The program failed by a fault of its own; what was kept is told.
pub const FAULT: u8 = 70;
/// The folder holds another run, one that is not over, or one that goes on.
pub const OCCUPIED: u8 = 73;
/// A file could not be written, or memory ran out.
pub const OUTPUT_FAILED: u8 = 74;
/// Interrupted; what was computed is written and can be resumed.
pub const INTERRUPTED: u8 = 75;
/// Interrupted at once, with nothing to resume from.
pub const ABORTED: u8 = 130;
