//! `ripstop check CASE.toml`

use std::path::PathBuf;

use clap::Args;

use super::bare_polar;
use super::case_arguments::CaseArguments;
use super::failure::Failure;
use super::log::emit;
use super::run::{exit_code, strict, validity_text};
use crate::case::{self, Derived, ExaminedMesh};
use crate::measure;
use crate::output::{aligned, significant};
use crate::plan;
use crate::run;
use crate::validity;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    case: CaseArguments,
    /// End with exit code 1 where the set-up does not support its results.
    #[arg(long)]
    strict: bool,
    /// Print the case with all keys that follow from its design, and why, in place of the plan.
    #[arg(long)]
    expand: bool,
    /// Draw what is found in meshes, and their open borders, into a folder.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<u8, Failure> {
    let loaded = arguments.case.load(&[]);
    if let Ok(case) = &loaded
        && let Some(wing) = &case.scene.bare_wing
    {
        arguments.case.refuse_device_of_bare_wing(case)?;
        let text = if arguments.expand {
            case::expanded(&case.text, &case.derived)
        } else {
            bare_polar::outlook(case, wing)
        };
        emit(&text)?;
        return Ok(0);
    }
    let prepared = match arguments.case.prepare() {
        Ok(prepared) => prepared,
        Err(failure) => {
            tell_refused(arguments)?;
            return Err(failure);
        }
    };
    let case = &prepared.case;
    if arguments.expand {
        emit(&case::expanded(&case.text, &case.derived))?;
        return Ok(0);
    }
    let threads = rayon::current_num_threads();
    let report = prepared.plan.report(&case.scene, &case.coarser, threads);
    emit(&report)?;
    if !case.derived.is_empty() {
        emit(&derived_text(&case.derived))?;
    }
    if let Some(averaging) = measure::averaging(&case.scene) {
        emit(&format!("\n{averaging}\n"))?;
    }
    let validity = validity::beforehand(&case.scene, &prepared.plan);
    let expected = validity::expected_errors(&case.scene);
    let text = validity_text(&validity, &expected);
    if !text.is_empty() {
        emit(&format!("\n{text}\n"))?;
    }
    draw(arguments, &case.scene.meshes)?;
    if arguments.strict {
        return strict(&validity, std::iter::empty());
    }
    Ok(0)
}

/// What follows from a design, a key a line.
fn derived_text(derived: &[Derived]) -> String {
    let mut text = format!(
        "\nderived from the design ({} keys; each may be written to change it; --expand prints the whole case)\n",
        derived.len()
    );
    let row = |one: &Derived| {
        let value = shortened(short(&one.value));
        vec![format!("  {}", one.key), value, one.why.clone()]
    };
    let rows: Vec<Vec<String>> = derived.iter().map(row).collect();
    text += &aligned(&rows);
    text
}

/// Longest value that stands in a line.
const LONGEST: usize = 60;

/// A value that is not too long for its line.
fn shortened(value: String) -> String {
    if value.chars().count() <= LONGEST {
        return value;
    }
    let begin: String = value.chars().take(LONGEST - 2).collect();
    format!("{} …", begin.trim_end())
}

/// A value in few digits.
fn short(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) => significant(*number, 5),
        toml::Value::Array(all) if all.iter().any(toml::Value::is_table) => {
            format!("{} tables", all.len())
        }
        toml::Value::Array(all) => {
            let all: Vec<String> = all.iter().map(short).collect();
            format!("[{}]", all.join(", "))
        }
        toml::Value::Table(table) => {
            let all = table.iter().filter(|(key, _)| *key != "source");
            let all: Vec<String> = all
                .map(|(key, value)| format!("{key} {}", short(value)))
                .collect();
            all.join(", ")
        }
        other => other.to_string().trim_matches('"').to_owned(),
    }
}

/// Of a case that is refused: what its meshes are made of, where they or the way they stand may be the reason.
fn tell_refused(arguments: &CheckArguments) -> Result<(), Failure> {
    let meshes = arguments.case.examine_meshes();
    let meshes = meshes.unwrap_or_default();
    let is_across = |mesh: &ExaminedMesh| mesh.heading.is_some_and(|heading| heading.is_odd());
    let is_reason = |mesh: &ExaminedMesh| mesh.refused().next().is_some() || is_across(mesh);
    if !meshes.iter().any(is_reason) {
        return Ok(());
    }
    emit(&plan::mesh_report(&meshes))?;
    draw(arguments, &meshes)
}

fn draw(arguments: &CheckArguments, meshes: &[ExaminedMesh]) -> Result<(), Failure> {
    let Some(folder) = &arguments.pictures else {
        return Ok(());
    };
    if meshes.is_empty() {
        return emit("\npictures: none, because the case has no mesh of a file\n");
    }
    let files = run::draw_findings(meshes, folder)
        .map_err(|error| Failure::Other(exit_code(&error), error.to_string()))?;
    let lines = files
        .iter()
        .map(|file| format!("picture: {}\n", file.display()));
    emit(&format!("\n{}", lines.collect::<String>()))
}
