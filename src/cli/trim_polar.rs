//! The polar of a wing of fabric: a trim for every brake, bar and mass.

use super::case_arguments::CaseArguments;
use super::exit;
use super::failure::Failure;
use super::log::emit;
use super::polar_arguments::PolarArguments;
use super::sweep::{BRAKE_PULL, SweepArguments, sweep_of};
use crate::case::{Case, Problem};
use crate::measure;
use crate::sweep::{Chosen, Vary};

/// Results of the table, before those of the rows.
const RESULTS: [&str; 12] = [
    "speed_m_s",
    "sink_m_s",
    "glide_ratio",
    "angle_of_attack_deg",
    "lift_coefficient",
    "drag_coefficient",
    "induced_drag_share",
    "section_drag_share",
    "line_drag_share",
    "pilot_drag_share",
    "internal_pressure_coefficient",
    "residual_stiffness_load_share",
];

/// Results that are drawn over another: that one first.
const PAIRS: [[&str; 2]; 3] = [
    ["speed_m_s", "sink_m_s"],
    ["speed_m_s", "glide_ratio"],
    ["drag_coefficient", "lift_coefficient"],
];

/// Bars where nothing is asked for.
const BARS: &str = "0,0.5,1";

/// Seconds of wall time between checkpoints of a trim.
const CHECKPOINT_EVERY_S: f64 = 300.0;

pub(super) fn polar(arguments: &PolarArguments, case: &Case) -> Result<u8, Failure> {
    let refused = |key: &str, what: String, help: &str| {
        Failure::Case(case.error(Problem::new(key, what, help)))
    };
    let trimmed = case
        .scene
        .wing()
        .and_then(|wing| Some((wing, wing.trim.as_ref()?)));
    let Some((wing, settings)) = trimmed else {
        return Err(refused(
            "version",
            format!(
                "in {}: there is no polar: the case has neither a wing by itself nor one of fabric in trim",
                case.name
            ),
            "give [aero.wing], or [structure.wing] with [equilibrium.trim]",
        ));
    };
    if arguments.angle.is_some() {
        return Err(Failure::Other(
            exit::BAD_CASE,
            "--angle is for a wing by itself ([aero.wing]); the angle of a glider follows from its trim: vary it by --bar, --brake, --mass, or a row's trim_m with --vary".to_owned(),
        ));
    }
    let mut varies = arguments.vary.clone();
    let bar = arguments.bar.clone();
    let has_bar = wing.has_speed_bar;
    let usual = || (has_bar && nothing_asked(arguments)).then(|| BARS.to_owned());
    if let Some(list) = bar.or_else(usual) {
        if !has_bar {
            return Err(refused(
                "structure.wing",
                format!("in {}: --bar needs a speed bar", case.name),
                "give [structure.wing.speed_bar] shortening_m = { A = 0.07, B = 0.047, C = 0.023 }: by how much it shortens the risers of each row at full travel",
            ));
        }
        varies.push(vary(&format!("structure.wing.speed_bar.used={list}"))?);
    }
    if let Some(list) = &arguments.brake {
        varies.push(vary(&format!("{BRAKE_PULL}={list}"))?);
    }
    if let Some(list) = &arguments.mass {
        varies.push(vary(&format!("equilibrium.trim.pilot_mass_kg={list}"))?);
    }
    if varies.is_empty() {
        return Err(Failure::Other(
            exit::BAD_CASE,
            "nothing varies: give --brake, --bar, --mass or --vary (a wing with [structure.wing.speed_bar] has --bar 0,0.5,1 by itself)".to_owned(),
        ));
    }
    let known = measure::result_names(&case.scene);
    let of_rows = known
        .iter()
        .filter(|name| name.starts_with("row_") && name.ends_with("_load_n"));
    let chosen = Chosen {
        results: RESULTS
            .iter()
            .map(|name| (*name).to_owned())
            .chain(of_rows.cloned())
            .collect(),
        pairs: PAIRS.map(|pair| pair.map(str::to_owned)).to_vec(),
        histories: Vec::new(),
    };
    emit(&format!(
        "inputs, not results: pilot C_D A = {} m2{}, C_d of lines {}{}\n",
        settings.pilot_drag_area_m2,
        if arguments.mass.is_some() {
            " for the case's own pilot, for others as of their mass unless the case writes it"
        } else {
            ""
        },
        settings.line_drag_coefficient,
        if settings.sections.polars.iter().any(Option::is_none) {
            ", drag of intakes (0.07 h/c) and of seams and wrinkles"
        } else {
            ""
        }
    ))?;
    let sweep = SweepArguments {
        case: CaseArguments::clone(&arguments.case),
        vary: varies,
        ensemble: None,
        result: Vec::new(),
        history: Vec::new(),
        out: arguments.out.clone(),
        overwrite: arguments.overwrite,
        checkpoint_every: CHECKPOINT_EVERY_S,
    };
    sweep_of(&sweep, Some(chosen))
}

fn nothing_asked(arguments: &PolarArguments) -> bool {
    arguments.brake.is_none() && arguments.mass.is_none() && arguments.vary.is_empty()
}

fn vary(text: &str) -> Result<Vary, Failure> {
    text.parse()
        .map_err(|why| Failure::Other(exit::BAD_CASE, why))
}
