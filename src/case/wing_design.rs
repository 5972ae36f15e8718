//! Checks of `[equilibrium.load_test]`.

use super::Problem;
use super::file::{self, File};

/// Most steps of a load test.
const STEP_LIMIT: usize = 50;

/// Largest multiple of the loads.
const LARGEST_FACTOR: f64 = 100.0;

/// Loads of an equilibrium, several times over.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTest {
    /// Multiples of the loads, growing, above 1.
    pub load_factors: Vec<f64>,
}

/// Refuses tables that act on a wing's loads where there are none.
fn needs_loads(file: &File, key: &str, what: &str) -> Result<(), Problem> {
    let equilibrium = file.equilibrium.as_ref();
    if equilibrium.is_some_and(|e| e.wing_pressure.is_some() || e.trim.is_some()) {
        return Ok(());
    }
    Err(Problem::new(
        key,
        format!("[{key}] has no effect: {what}"),
        "add [equilibrium.trim] or [equilibrium.wing_pressure] to a case with [structure.wing], or remove the table",
    ))
}

/// Checks the table of a load test, if there is one.
pub(super) fn check_load_test(file: &File) -> Result<Option<LoadTest>, Problem> {
    const KEY: &str = "equilibrium.load_test";
    const FACTORS: &str = "equilibrium.load_test.load_factors";
    let written: Option<&file::LoadTestTable> =
        file.equilibrium.as_ref().and_then(|e| e.load_test.as_ref());
    let Some(written) = written else {
        return Ok(None);
    };
    needs_loads(file, KEY, "no loads of a wing are there to be raised")?;
    let factors = &written.load_factors;
    let grow = factors.windows(2).all(|pair| pair[1] > pair[0]);
    let fit = factors.iter().all(|f| *f > 1.0 && *f <= LARGEST_FACTOR);
    if factors.is_empty() || factors.len() > STEP_LIMIT || !grow || !fit {
        return Err(Problem::new(
            FACTORS,
            format!("{FACTORS} = {factors:?} is not a list of growing load factors above 1"),
            format!(
                "the wing as it flies has 1; give up to {STEP_LIMIT} steps of at most {LARGEST_FACTOR}, such as [2.0, 3.0, 4.0, 6.0, 8.0]"
            ),
        ));
    }
    Ok(Some(LoadTest {
        load_factors: factors.clone(),
    }))
}
