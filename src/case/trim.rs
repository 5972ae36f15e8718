//! Checks of `[equilibrium.trim]`.

use super::file::{self, File};
use super::problem::Problem;
use super::section_polar::{PolarRow, polar_of};
use super::usual;
use super::values::{absent, count_within, positive, within};
use super::wing_tunnel::USUAL_LINE_DRAG;
use crate::aero::polar::Polar;
use crate::trim::{SectionSettings, Settings, Tolerance};

const KEY: &str = "equilibrium.trim";

/// Stiffness of the guide that holds a nose while the fabric is solved, if the case names none [N/m].
pub(super) const GUIDE_N_M: f64 = 500.0;

fn key(name: &str) -> String {
    format!("{KEY}.{name}")
}

/// Checks the table of a wing whose profiles have the given names, in their order.
pub(super) fn check(
    file: &File,
    written: &file::Trim,
    table: &file::Wing,
) -> Result<Settings, Problem> {
    let gravity = file.gravity.as_ref().map(|g| g.acceleration_m_s2);
    if !gravity.is_some_and(|[x, y, z]| x == 0.0 && y == 0.0 && z < 0.0) {
        return Err(Problem::new(
            "gravity.acceleration_m_s2",
            "a trim needs weight that pulls straight down; it is the air's direction that is sought",
            "give [gravity] with acceleration_m_s2 = [0.0, 0.0, -9.81]",
        ));
    }
    let closed = table.intakes.as_ref().is_none_or(|intakes| {
        let closed = intakes.closed_tip_cells;
        2 * usual::or("structure.wing.intakes.closed_tip_cells", closed, 0) >= table.cells
    });
    if closed && written.internal_pressure_coefficient.is_none() {
        return Err(absent(
            &key("internal_pressure_coefficient"),
            "no cell has an intake whose pressure could be taken",
        ));
    }
    for name in written.polars.keys() {
        if !table.profiles.contains_key(name) {
            return Err(Problem::new(
                key(&format!("polars.{name}")),
                format!("there is no profile `{name}`"),
                "name one of [structure.wing.profiles]",
            ));
        }
    }
    let polars = table
        .profiles
        .keys()
        .map(|name| {
            let rows = written.polars.get(name);
            rows.map(|rows| check_polar(name, rows)).transpose()
        })
        .collect::<Result<_, _>>()?;
    let whole = |name: &str, value: Option<usize>, usual: usize, low: usize, high: usize| {
        count_within(&key(name), usual::or(key(name), value, usual), low, high)
    };
    let share = |name: &str, value: Option<f64>, usual: f64, low: f64, high: f64| {
        within(&key(name), usual::or(key(name), value, usual), low, high)
    };
    let intake = (!closed).then_some(()).and(table.intakes.as_ref());
    let intake = intake.map(|intakes| [intakes.from, intakes.to]);
    let place = |place: f64| within(&key("transition"), place, 0.0, 1.0);
    let transition = match written.transition {
        Some([above, below]) => [Some(place(above)?), Some(place(below)?)],
        None => [None; 2],
    };
    let reynolds = share("reynolds_number", written.reynolds_number, 1.5e6, 1e5, 1e8)?;
    let mut sections = SectionSettings::new(polars, reynolds);
    (sections.transition, sections.intake) = (transition, intake);
    let critical = written.critical_amplification;
    sections.critical_amplification = share("critical_amplification", critical, 9.0, 0.5, 20.0)?;
    let surface = written.surface_drag_coefficient;
    sections.surface_drag = share("surface_drag_coefficient", surface, 0.004, 0.0, 0.1)?;
    let tolerance = &written.tolerance;
    Ok(Settings {
        density_kg_m3: within(
            &key("air_density_kg_m3"),
            written.air_density_kg_m3,
            1e-3,
            1e2,
        )?,
        pilot_mass_kg: positive(&key("pilot_mass_kg"), written.pilot_mass_kg)?,
        pilot_drag_area_m2: within(
            &key("pilot_drag_area_m2"),
            written.pilot_drag_area_m2,
            0.0,
            100.0,
        )?,
        line_drag_coefficient: share(
            "line_drag_coefficient",
            written.line_drag_coefficient,
            USUAL_LINE_DRAG,
            0.0,
            10.0,
        )?,
        inside: written
            .internal_pressure_coefficient
            .map(|c| within(&key("internal_pressure_coefficient"), c, -5.0, 5.0))
            .transpose()?,
        sections,
        panels_per_side: whole("panels_per_side", written.panels_per_side, 20, 4, 200)?,
        strips: whole("strips", written.strips, 40, 2, 400)?,
        from_coarser_meshes: usual::or(
            key("from_coarser_meshes"),
            written.from_coarser_meshes,
            true,
        ),
        relaxation: share("relaxation", written.relaxation, 1.0, 0.01, 1.0)?,
        tolerance: Tolerance {
            speed: share("tolerance.speed", tolerance.speed, 2e-3, 1e-9, 1.0)?,
            glide: share("tolerance.glide", tolerance.glide, 5e-3, 1e-9, 1.0)?,
            pitch_rad: share("tolerance.pitch_deg", tolerance.pitch_deg, 0.1, 1e-6, 45.0)?
                .to_radians(),
            shape: share("tolerance.shape", tolerance.shape, 2e-3, 1e-9, 1.0)?,
            balance: share("tolerance.balance", tolerance.balance, 1e-2, 1e-9, 1.0)?,
        },
        iteration_limit: whole("iteration_limit", written.iteration_limit, 20, 1, 10_000)?,
    })
}

fn check_polar(name: &str, rows: &[[f64; 3]]) -> Result<Polar, Problem> {
    let rows: Vec<PolarRow> = rows.iter().map(|&row| (row, None)).collect();
    polar_of(&key(&format!("polars.{name}")), &rows)
}
