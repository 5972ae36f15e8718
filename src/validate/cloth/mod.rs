//! Validation of fabric and cables alone, with multigrid, in the static limit where nothing else is said.

pub(super) mod airbag;
pub(super) mod catenary;
pub(super) mod drum;
pub(super) mod free_oscillations;
pub(super) mod heavy_cantilever;
pub(super) mod hencky;
pub(super) mod hostile_starts;
pub(super) mod patch;
pub(super) mod pressure_vessels;
pub(super) mod shear_panel;

use super::report::Row;
use super::session::{Session, Stop};
use crate::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use crate::fabric::Fabric;
use crate::gpu::cloth::Cloth as DeviceCloth;
use crate::plan::AirPlacement;
use crate::solve::lbfgs::{HISTORY, Outcome, Progress};

/// How hard equilibria are sought.
const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-6,
    displacement_floor_m: 0.0,
    evaluation_limit: 20_000,
    history: HISTORY,
    refresh_every: Some(10),
    initial_hessian: InitialHessian::Multigrid,
};

/// The same on a device, whose forces are good to 1e-6 of the largest.
const DEVICE_TOLERANCE: f64 = 1e-4;

/// What a builder made, or the error that it refused: a problem without it would pass with fewer gates.
fn built<T>(made: Option<T>, what: &str) -> Result<T, Stop> {
    made.ok_or_else(|| Stop::Refused(format!("{what} cannot be built")))
}

/// Where values in a row change their sign, straight between them.
fn crossings(values: &[f64]) -> Vec<f64> {
    let pairs = values.windows(2).enumerate();
    let pairs = pairs.filter(|(_, pair)| pair[0].signum() != pair[1].signum());
    pairs
        .map(|(i, pair)| i as f64 + pair[0] / (pair[0] - pair[1]))
        .collect()
}

/// An isotropic fabric without compressive stiffness.
fn isotropic(youngs_modulus_pa: f64, poisson_ratio: f64, thickness_m: f64) -> Fabric {
    Fabric {
        thickness_m,
        density_kg_m3: 500.0,
        warp_modulus_pa: youngs_modulus_pa,
        weft_modulus_pa: youngs_modulus_pa,
        poisson_ratio,
        shear_modulus_pa: Fabric::isotropic_shear_modulus_pa(youngs_modulus_pa, poisson_ratio),
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 0.0,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// A structure, and who computes it.
struct Sheet {
    cloth: Cloth,
    device: Option<DeviceCloth>,
}

impl Sheet {
    /// Who computes, and in which precision.
    const fn engine(&self) -> &'static str {
        if self.device.is_some() {
            "gpu f32"
        } else {
            "cpu f64"
        }
    }
}

impl Session<'_> {
    /// A structure on the engine of the order: on the device, unless only the CPU can compute what is asked for.
    fn sheet(&self, cloth: Cloth, needs_host: bool) -> Result<Sheet, Stop> {
        let device = match (self.order.placement, &self.order.device) {
            (AirPlacement::Gpu(_), Some(device)) if !needs_host => Some(DeviceCloth::new(
                std::sync::Arc::clone(device),
                &cloth.structure,
                &[],
            )?),
            _ => None,
        };
        Ok(Sheet { cloth, device })
    }

    /// One step, or the equilibrium. Ends early when the session is interrupted.
    fn solve(
        &self,
        sheet: &mut Sheet,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, Stop> {
        let mut go_on =
            |_: &Progress<'_>| !self.interrupt.load(std::sync::atomic::Ordering::Relaxed);
        let outcome = match &mut sheet.device {
            Some(device) => {
                let settings = SolverSettings {
                    tolerance: settings.tolerance.max(DEVICE_TOLERANCE),
                    ..*settings
                };
                let cloth = &mut sheet.cloth;
                if input.time_step_s.is_some() {
                    device.solve(cloth, input, &settings)?
                } else {
                    device.solve_watched(cloth, input, &settings, &mut go_on)?
                }
            }
            None => sheet.cloth.solve_cloth_watched(input, settings, &mut go_on),
        };
        let interrupted = self.interrupt.load(std::sync::atomic::Ordering::Relaxed);
        if interrupted || outcome.stop == crate::solve::lbfgs::Stop::Interrupted {
            return Err(Stop::Interrupted);
        }
        Ok(outcome)
    }

    /// The equilibrium; refused where it is not reached, since a state before it may lie within any band. A device is not asked for as much.
    fn solve_to_rest(
        &self,
        sheet: &mut Sheet,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<(), Stop> {
        let outcome = self.solve(sheet, input, settings)?;
        if outcome.stop.reached() || sheet.device.is_some() {
            return Ok(());
        }
        Err(Stop::Refused(format!(
            "no equilibrium after {} evaluations ({:?}): energy norm {:.1e} of the loads'",
            outcome.evaluations, outcome.stop, outcome.relative_norm
        )))
    }

    /// Adds a row about a sheet.
    fn sheet_row(&mut self, sheet: &Sheet, quantity: impl Into<String>, value: f64) -> &mut Row {
        let nodes = sheet.cloth.structure.node_count();
        let row = self.row([0; 3], quantity, value);
        row.nodes = Some(nodes);
        row.engine = Some(sheet.engine());
        row.is_judged = true;
        row
    }
}
