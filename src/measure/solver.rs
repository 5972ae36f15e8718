//! Read-outs of the fabric's solver: what it did since the last sample, and the account of the whole run.

use super::contact::SMALLEST_GAP;
use super::read_out::{When, columns};
use super::residual;
use super::shared::{FORCE_IMBALANCE, MASS_DRIFT, SLIP_MEAN};
use crate::case::scene::Scene;
use crate::output::{AccountRow, Results};
use crate::simulation::{Interval, LAST, Simulation, SolverAccount, UNSOLVED_SHARE};
use crate::statics::Statics;

static HAS_SOLVES: When<Scene> = When {
    words: "",
    holds: |scene| scene.fabric_is_solved() && scene.time.is_some(),
};

columns! {
    /// Of the solves since the last sample.
    COLUMNS of Interval, in Scene: "Fabric that moves: its solver since the last sample";
    UNSOLVED: "unsolved_solves", "1", "solves that missed their tolerance; at the limit of evaluations, or stalled"
        => |interval| interval.unsolved as f64, when HAS_SOLVES;
    RESIDUAL: "solver_residual", "1", "energy norm that the worst of them left, over what the tolerance allows; above 1 it is unsolved"
        => |interval| interval.worst_residual, when HAS_SOLVES;
    EVALUATIONS: "evaluations_per_solve", "1", "evaluations of the energy and its gradient, mean"
        => |interval| interval.evaluations as f64 / interval.solves as f64, when HAS_SOLVES;
}

/// Difference of the force routes beyond which a run says so.
pub const FORCE_IMBALANCE_LIMIT: f64 = 0.02;

/// Slip of the air past a surface, over the reference speed, beyond which the forcing has not done what it is for: usual runs show 0.02.
const SLIP_LIMIT: f64 = 0.05;

/// Share of the contact thickness that fabric may enter: beyond, its barrier has become so stiff that solves stall.
const CONTACT_LIMIT: f64 = 0.9;

/// Defect of the mass balance of a box of air, over its mass.
const MASS_DEFECT_LIMIT: f64 = 1e-3;

/// The account of a run: every solver and every balance that it has.
#[must_use]
pub fn account(simulation: &Simulation, statics: &Statics, results: &Results) -> Vec<AccountRow> {
    let mut rows = Vec::new();
    let account = simulation.solver_account();
    if account.solves() > 0 {
        rows.push(steps(account));
    }
    rows.extend(simulation.opening().map(|opening| {
        AccountRow {
            limit: None,
            reached: None,
            ..AccountRow::at_most(
                "opening by loading pressure",
                "steps that missed the tolerance",
                "1",
                opening.unsolved as f64,
                0.0,
            )
        }
        .with_detail(format!(
            "{} steps; the shape reached is where the run starts, whether at rest or not",
            opening.steps
        ))
    }));
    rows.extend(equilibrium(simulation, statics));
    rows.extend(trim(simulation, statics));
    rows.extend(load_test(statics));
    rows.extend(contact(simulation, results));
    let coupling = simulation.scene().coupling;
    if let (Some(slip), Some(coupling)) = (results.value(&SLIP_MEAN), coupling) {
        let row = AccountRow::at_most(
            "forcing of the air",
            "mean slip past the surface over the reference speed",
            "1",
            slip,
            SLIP_LIMIT,
        );
        rows.push(row.with_detail(format!("passes {}", coupling.passes)));
    }
    for (name, result, meaning, limit) in [
        (
            "force routes",
            &FORCE_IMBALANCE,
            "largest difference over the drag",
            FORCE_IMBALANCE_LIMIT,
        ),
        (
            "mass balance of the air",
            &MASS_DRIFT,
            "largest defect over the mass of the box",
            MASS_DEFECT_LIMIT,
        ),
    ] {
        match (results.value(result), results.get(&result.name)) {
            (Some(found), _) => rows.push(AccountRow::at_most(name, meaning, "1", found, limit)),
            // Nobody may take a balance for kept that was not looked at.
            (None, Some(missing)) => rows.push(AccountRow {
                name: name.to_owned(),
                meaning: meaning.to_owned(),
                unit: "1".to_owned(),
                limit: Some(limit),
                detail: missing.note.clone().unwrap_or_default(),
                ..AccountRow::default()
            }),
            (None, None) => {}
        }
    }
    rows.extend(residual::account(results, simulation.scene()));
    rows
}

/// Steps of the fabric.
fn steps(account: &SolverAccount) -> AccountRow {
    let unsolved = account.unsolved();
    let mut detail = format!(
        "{} of {} solves missed their tolerance ({} at the limit of evaluations, {} stalled), {} of the last {LAST}",
        unsolved,
        account.solves(),
        account.limit_reached(),
        account.stalled(),
        account.unsolved_at_end()
    );
    if let Some(worst) = account.worst() {
        detail += &format!(
            "; the worst left {:.3} times what it may, at {:.4} s",
            worst.residual, worst.time_s
        );
    }
    if account.round_off() > 0 {
        detail += &format!("; {} ended at round-off", account.round_off());
    }
    let share = account.worst_share();
    let row = AccountRow::at_most(
        "steps of the fabric",
        "largest share of unsolved solves in 1000 in a row",
        "1",
        share,
        UNSOLVED_SHARE,
    );
    AccountRow {
        reached: Some(!account.out_of_balance()),
        ..row
    }
    .with_detail(detail)
}

/// The static equilibrium that the case asks for.
fn equilibrium(simulation: &Simulation, statics: &Statics) -> Option<AccountRow> {
    let outcome = statics.equilibrium.as_ref()?;
    let row = AccountRow::at_most(
        "static equilibrium",
        "energy norm left over that of the loads",
        "1",
        outcome.relative_norm,
        simulation.scene().equilibrium?.tolerance,
    );
    let reached = Some(outcome.stop.reached());
    let detail = format!("{} evaluations", outcome.evaluations);
    Some(AccountRow { reached, ..row }.with_detail(detail))
}

/// The last iteration of a trim.
fn trim(simulation: &Simulation, statics: &Statics) -> Option<AccountRow> {
    let settings = simulation.scene().wing()?.trim.as_ref()?;
    let last = statics.trim.as_ref()?.iterations.last()?;
    let row = AccountRow::at_most(
        "trim",
        "what the risers lack over the weight",
        "1",
        last.balance_error,
        settings.tolerance.balance,
    );
    let solved = last.outcome.stop.reached();
    Some(
        AccountRow {
            reached: row.reached.map(|balanced| balanced && solved),
            ..row
        }
        .with_detail(format!(
            "{} iterations on the last mesh; energy norm of the fabric {}{}",
            last.number,
            if last.relative_norm.is_finite() {
                format!("{:.1e} of the loads'", last.relative_norm)
            } else {
                "not known".to_owned()
            },
            if solved { "" } else { ", not its tolerance" }
        )),
    )
}

/// Contact of fabric with itself; `None` where none came near.
fn contact(simulation: &Simulation, results: &Results) -> Option<AccountRow> {
    let body = simulation.scene().body.as_ref()?;
    let thickness_m = body.structure.contact?.thickness_m;
    let gap_m = results.value(&SMALLEST_GAP)?;
    let row = AccountRow::at_most(
        "contact of fabric",
        "how far the nearest fabric came into the contact thickness (1 = touching)",
        "1",
        1.0 - gap_m / thickness_m,
        CONTACT_LIMIT,
    );
    Some(row.with_detail(format!("smallest gap {gap_m:.2e} m")))
}

/// Loads of a load test that were not balanced.
fn load_test(statics: &Statics) -> Option<AccountRow> {
    let tested = &statics.load_test.as_ref()?.steps;
    let missed = tested.iter().filter(|step| !step.is_balanced()).count();
    let row = AccountRow::at_most(
        "load test",
        "loads that were not balanced",
        "1",
        missed as f64,
        0.0,
    );
    Some(row.with_detail(format!("{} loads", tested.len())))
}
