//! `ripstop import FILE`: a wing of another program as a case.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit;
use super::failure::Failure;
use super::log::emit;
use crate::case::leparagliding::{self, Published};
use crate::case::{self, Case, Choices};
use crate::output::{
    NOTHING, OutputError, aligned, prepare_directory, significant, write_atomically,
};

#[derive(Debug, Args)]
pub(super) struct ImportArguments {
    /// `leparagliding.txt` of LEparagliding, with its airfoil files beside it.
    file: PathBuf,
    /// Folder for the case and the airfoil files.
    #[arg(long, value_name = "DIR", default_value = "imported")]
    out: PathBuf,
    /// Pilot, harness and all else that hangs on the risers [kg]; by the area if left out.
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    pilot: Option<f64>,
}

/// Name of the case.
const CASE: &str = "wing.toml";

/// Digits of measures.
const DIGITS: i32 = 4;

pub(super) fn import(arguments: &ImportArguments) -> Result<u8, Failure> {
    let bad = |why: String| Failure::Other(exit::BAD_CASE, why);
    let told = arguments.file.display();
    let text = read(&arguments.file).map_err(|why| bad(format!("cannot read {told}: {why}")))?;
    let imported = leparagliding::import(&text, arguments.pilot)
        .map_err(|why| bad(format!("{told}: {why}")))?;
    let folder = arguments.file.parent().unwrap_or_else(|| Path::new("."));
    let out = &arguments.out;
    let failed = |error: OutputError| Failure::Other(exit::OUTPUT_FAILED, error.to_string());
    let path = out.join(CASE);
    if path.exists() {
        return Err(bad(format!(
            "{} is there already and would be lost: give another folder (--out), or remove it",
            path.display()
        )));
    }
    prepare_directory(out).map_err(failed)?;
    for name in &imported.profiles {
        let airfoil = std::fs::read(folder.join(name)).map_err(|why| {
            bad(format!(
                "cannot read the airfoil {}: {why}; {told} names it",
                folder.join(name).display()
            ))
        })?;
        write_atomically(&out.join(name), |file| file.write_all(&airfoil)).map_err(failed)?;
    }
    write_atomically(&path, |file| file.write_all(imported.text.as_bytes())).map_err(failed)?;
    let case = case::load(&path, &Choices::default()).map_err(Failure::Case)?;
    emit(&format!("{}\n\n{}", imported.name, table(&case, folder)))?;
    for line in &imported.left_out {
        emit(&format!("not brought in: {line}\n"))?;
    }
    emit(&format!(
        "case: {}; `ripstop run {}` trims it\n",
        path.display(),
        path.display()
    ))?;
    Ok(0)
}

/// Text in any encoding: names may hold what is no UTF-8.
fn read(path: &Path) -> std::io::Result<String> {
    Ok(String::from_utf8_lossy(&std::fs::read(path)?).into_owned())
}

/// Measures of the plan beside those that LEparagliding found.
fn table(case: &Case, folder: &Path) -> String {
    let Some(wing) = case.scene.wing() else {
        return String::new();
    };
    let theirs = |name: &str| read(&folder.join(name)).unwrap_or_default();
    let published = Published::read(&theirs("lep-out.txt"), &theirs("lines.txt"));
    let measures = &wing.built.measures;
    let lines_m = leparagliding::line_length_m(case);
    let rows = [
        (
            "flat area",
            "m²",
            measures.flat_area_m2,
            published.flat_area_m2,
        ),
        (
            "flat span",
            "m",
            measures.flat_span_m,
            published.flat_span_m,
        ),
        (
            "projected area",
            "m²",
            measures.projected_area_m2,
            published.projected_area_m2,
        ),
        (
            "projected span",
            "m",
            measures.projected_span_m,
            published.projected_span_m,
        ),
        (
            "lines, without risers and brakes",
            "m",
            lines_m,
            published.lines_m,
        ),
    ];
    let head = ["", "unit", "here", "LEparagliding", "difference"].map(str::to_owned);
    let row = |(name, unit, ours, theirs): (&str, &str, f64, Option<f64>)| {
        let shown = |number: f64| significant(number, DIGITS);
        let theirs_text = theirs.map_or_else(|| NOTHING.to_owned(), shown);
        let difference = theirs.map_or_else(
            || NOTHING.to_owned(),
            |theirs| format!("{:+.2} %", 100.0 * (ours / theirs - 1.0)),
        );
        vec![
            name.to_owned(),
            unit.to_owned(),
            shown(ours),
            theirs_text,
            difference,
        ]
    };
    let lines: Vec<Vec<String>> = std::iter::once(head.to_vec())
        .chain(rows.into_iter().map(row))
        .collect();
    aligned(&lines)
}
