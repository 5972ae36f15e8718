//! Static equilibrium: `[equilibrium]`, but for what of it is for wings alone.

use super::file::File;
use super::problem::Problem;
use super::values::{PLAUSIBLE, at_least_one, within};

/// Static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium {
    /// Tolerance relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed.
    pub evaluation_limit: usize,
    /// Pressure jump along the triangle normals, which follows the fabric \[Pa\]; `None`: none.
    pub pressure_pa: Option<f64>,
}

/// Checks `[equilibrium]`.
pub(super) fn check(file: &File) -> Result<Option<Equilibrium>, Problem> {
    let Some(written) = &file.equilibrium else {
        return Ok(None);
    };
    if file.air.is_some() {
        return Err(Problem::new(
            "equilibrium",
            "a static equilibrium is not defined in moving air",
            "remove [equilibrium] or [air]",
        ));
    }
    Ok(Some(Equilibrium {
        tolerance: within("equilibrium.tolerance", written.tolerance, 1e-12, 0.5)?,
        evaluation_limit: at_least_one("equilibrium.evaluation_limit", written.evaluation_limit)?,
        pressure_pa: written
            .pressure_pa
            .map(|p| within("equilibrium.pressure_pa", p, -PLAUSIBLE, PLAUSIBLE))
            .transpose()?,
    }))
}
