//! `ripstop check CASE.toml`

use std::path::PathBuf;

use clap::Args;

use super::case_arguments::CaseArguments;
use super::failure::Failure;
use super::log::emit;
use super::run::{exit_code, strict, validity_text};
use crate::case::ExaminedMesh;
use crate::measure;
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
    /// Draw what is found in meshes, and their open borders, into a folder.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<u8, Failure> {
    let prepared = match arguments.case.prepare() {
        Ok(prepared) => prepared,
        Err(failure) => {
            tell_refused(arguments)?;
            return Err(failure);
        }
    };
    let case = &prepared.case;
    let threads = rayon::current_num_threads();
    let report = prepared.plan.report(&case.scene, &case.coarser, threads);
    emit(&report)?;
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
