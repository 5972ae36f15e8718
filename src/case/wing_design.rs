//! Checks of `[equilibrium.load_test]`, `[equilibrium.panel_shaping]` and of a wing's profiles.

use std::path::Path;

use super::file::{self, File, ShapingAim};
use super::problem::Problem;
use super::usual;
use super::values::{absent, points, wing_key as key, within};
use crate::geometry::profile::{self, ProfileError};
use crate::geometry::wing::section::Profile;

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

/// Panels that fly as they were designed.
#[derive(Debug, Clone, PartialEq)]
pub struct PanelShaping {
    /// Ballooning to be flown, of the upper and the lower side; `None`: ribs are to fly as far apart as they were designed.
    pub target: Option<Ballooning>,
    /// Largest difference of the flown ballooning from it, or of the distance of ribs from the designed one over it.
    pub tolerance: f64,
    /// Share of the difference by which panels are changed.
    pub relaxation: f64,
    /// Changes allowed.
    pub iteration_limit: usize,
}

/// Points [x/c, b] of the upper and the lower side.
pub type Ballooning = [Vec<[f64; 2]>; 2];

/// Checks a table of ballooning.
pub(super) fn check_ballooning(
    key: &str,
    written: &file::Ballooning,
) -> Result<Ballooning, Problem> {
    const RANGE: [f64; 2] = [0.0, 0.5];
    Ok([
        points(&format!("{key}.upper"), &written.upper, RANGE)?,
        points(&format!("{key}.lower"), &written.lower, RANGE)?,
    ])
}

/// Checks the table of a panel shaping, if there is one.
pub(super) fn check_panel_shaping(file: &File) -> Result<Option<PanelShaping>, Problem> {
    const KEY: &str = "equilibrium.panel_shaping";
    let key = |name: &str| format!("{KEY}.{name}");
    let written = file
        .equilibrium
        .as_ref()
        .and_then(|e| e.panel_shaping.as_ref());
    let Some(written) = written else {
        return Ok(None);
    };
    needs_loads(
        file,
        KEY,
        "no loads of a wing are there to shape its panels",
    )?;
    let planned = file.wing().and_then(|wing| wing.ballooning.as_ref());
    let aim = usual::or(key("aim"), written.aim, ShapingAim::Ballooning);
    let target = match (aim, &written.target, planned) {
        (ShapingAim::CellWidth, None, _) => None,
        (ShapingAim::CellWidth, Some(_), _) => {
            return Err(Problem::new(
                key("target"),
                format!(
                    "{} has no effect: cells are to have their designed width",
                    key("target")
                ),
                "remove it, or give aim = \"ballooning\"",
            ));
        }
        (ShapingAim::Ballooning, Some(target), _) => {
            Some(check_ballooning(&key("target"), target)?)
        }
        (ShapingAim::Ballooning, None, Some(planned)) => {
            Some(check_ballooning("structure.wing.ballooning", planned)?)
        }
        (ShapingAim::Ballooning, None, None) => {
            return Err(absent(
                &key("target"),
                "the plan has flat panels, and panels under pressure are not flat",
            ));
        }
    };
    let limit = usual::or(key("iteration_limit"), written.iteration_limit, 10);
    if !(1..=100).contains(&limit) {
        return Err(Problem::new(
            key("iteration_limit"),
            format!("{} = {limit} is out of range", key("iteration_limit")),
            "allowed are 1 to 100",
        ));
    }
    Ok(Some(PanelShaping {
        target,
        tolerance: within(
            &key("tolerance"),
            usual::or(key("tolerance"), written.tolerance, 2e-3),
            1e-6,
            0.1,
        )?,
        relaxation: within(
            &key("relaxation"),
            usual::or(key("relaxation"), written.relaxation, 0.7),
            0.01,
            2.0,
        )?,
        iteration_limit: limit,
    }))
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
    let written: Option<&file::LoadTest> =
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

/// Reads or computes the profiles of a wing; files are looked up relative to `folder`.
pub(super) fn check_profiles(table: &file::Wing, folder: &Path) -> Result<Vec<Profile>, Problem> {
    table
        .profiles
        .iter()
        .map(|(name, written)| check_profile(&key(&format!("profiles.{name}")), written, folder))
        .collect()
}

/// Farthest that a cut of the nose may reach back, per chord.
const DEEPEST_CUT: f64 = 0.3;

fn check_profile(key: &str, written: &file::Profile, folder: &Path) -> Result<Profile, Problem> {
    let whole = whole_profile(key, written, folder)?;
    let Some([above, below]) = written.nose_cut else {
        return Ok(whole);
    };
    let allowed = 0.0..=DEEPEST_CUT;
    let cut = (allowed.contains(&above) && allowed.contains(&below))
        .then(|| whole.with_nose_cut(above, below));
    cut.flatten().ok_or_else(|| {
        Problem::new(
            format!("{key}.nose_cut"),
            format!("{key}.nose_cut = [{above}, {below}] does not cut a nose off: allowed are places from 0 to {DEEPEST_CUT} of the chord, the one below behind the one above"),
            "e.g. [0.02, 0.08]: from 2 % of the chord above to 8 % below",
        )
    })
}

fn whole_profile(key: &str, written: &file::Profile, folder: &Path) -> Result<Profile, Problem> {
    match (&written.naca, &written.file) {
        (Some(digits), None) => Profile::naca(digits).ok_or_else(|| {
            Problem::new(
                key,
                format!("`{digits}` is not a NACA four-digit profile"),
                "give four digits, such as \"2415\": camber, its place, and thickness in hundredths",
            )
        }),
        (None, Some(name)) => {
            let path = folder.join(name);
            let refused = |why: &ProfileError| {
                Problem::new(
                    format!("{key}.file"),
                    format!("cannot read the profile {}: {why}", path.display()),
                    "give a file in Selig's format, relative to the case file: a title, then x/c and y/c per line from the upper trailing edge around the nose to the lower one",
                )
            };
            let read = profile::Profile::read(&path).map_err(|why| refused(&why))?;
            Profile::sampled(&read).ok_or_else(|| {
                refused(&ProfileError::Points(
                    "a side turns back along the chord: every place must have one height above and one below".to_owned(),
                ))
            })
        }
        (Some(_), Some(_)) => Err(Problem::new(
            key,
            "a profile has `naca` and `file`: it needs exactly one of them",
            "remove one; where `naca` follows from a design, write naca = \"absent\" beside `file`",
        )),
        (None, None) => Err(Problem::new(
            key,
            "a profile needs `naca` or `file`",
            "give naca = \"2415\", or file = \"profile.dat\" with coordinates in Selig's format",
        )),
    }
}
