//! The device engine: every stage of a step in WGSL, on any adapter of wgpu, with the CPU stages as its reference.
//!
//! | file | holds |
//! |---|---|
//! | [`adapters`] | the adapters of this machine, which one a run takes |
//! | [`device`] | an open device: buffers, submissions, late faults |
//! | `commands`, `transfer` | commands as they are recorded; ways back to the host |
//! | `meter`, `pass_clock`, `pass_times` | commands counted, and timed on request |
//! | [`bandwidth`], [`latency`], `tuning` | what a device can do, and choices that a benchmark compares |
//! | [`fluid`] | the air: collide–stream, boundaries, fields and balances |
//! | [`immersed`] | markers: interpolate, spread |
//! | [`pipeline`], [`shaders`], [`layouts`] | pipelines with bindings known by name; the texts of `shaders/`; structs shared with them |
//! | [`cloth`] | fabric and cables: nodal forces, initial Hessian, the minimiser's vectors |
//!
//! Nothing outside this room sees wgpu, and nothing inside panics: all failures are [`DeviceError`]s.

pub mod adapters;
pub mod bandwidth;
pub mod cloth;
mod commands;
pub mod device;
mod error;
pub mod fluid;
pub mod immersed;
pub mod latency;
pub mod layouts;
mod measure_latency;
mod meter;
pub mod multigrid;
mod pass_clock;
mod pass_times;
pub mod pipeline;
mod quiet;
mod recorded;
pub mod shaders;
mod transfer;
mod tuning;

pub use adapters::{AdapterChoice, AdapterInfo, AdapterKind};
pub use device::Device;
pub use error::DeviceError;
pub use meter::DeviceWork;
pub use pass_clock::PassTime;
pub use tuning::{Padding, Tuning};
