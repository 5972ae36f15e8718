//! `ripstop import FILE`: a wing of another program as a case, or every wing of a folder.

use std::path::{Path, PathBuf};

use clap::Args;

use super::bare_polar;
use super::exit;
use super::failure::Failure;
use super::log::emit;
use crate::case::leparagliding::{self, Imported, Published};
use crate::case::xflr5;
use crate::case::{self, Case, Choices};
use crate::output::{
    NOTHING, OutputError, aligned, prepare_directory, significant, write_atomically,
};

#[derive(Debug, Args)]
pub(super) struct ImportArguments {
    /// `leparagliding.txt` of LEparagliding, with its airfoil files beside it, or a folder with such folders, up to four deep; or a wing of XFLR5 (`.xwimp`), with the
    /// coordinates of its profiles beside it (`NAME.dat`).
    file: PathBuf,
    /// Folder for the case and the airfoil files; of several wings each has a folder there.
    #[arg(long, value_name = "DIR", default_value = "imported")]
    out: PathBuf,
    /// Pilot, harness and all else that hangs on the risers of a wing of LEparagliding [kg]; by the area if left out.
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    pilot: Option<f64>,
    /// Speed of a wing of XFLR5, which the file does not tell [m/s]; 10 if left out.
    #[arg(long, value_name = "M_S")]
    speed: Option<f64>,
}

/// Name of the case.
const CASE: &str = "wing.toml";

/// Name of the other program's file.
const THEIRS: &str = "leparagliding.txt";

/// Speed of a wing of XFLR5, if none is given [m/s].
const USUAL_SPEED_M_S: f64 = 10.0;

/// Digits of measures.
const DIGITS: i32 = 4;

pub(super) fn import(arguments: &ImportArguments) -> Result<u8, Failure> {
    let end = arguments.file.extension().unwrap_or_default();
    if end.eq_ignore_ascii_case("xwimp") {
        return of_xflr5(arguments);
    }
    if arguments.speed.is_some() {
        return Err(bad(
            "--speed has no effect on wings of LEparagliding, whose speed is found by their trim: leave it out"
                .to_owned(),
        ));
    }
    if arguments.file.is_dir() {
        return several(arguments);
    }
    if ["ods", "json"]
        .iter()
        .any(|other| end.eq_ignore_ascii_case(other))
    {
        return Err(bad(format!(
            "{} is neither a {THEIRS} nor a wing of XFLR5 (.xwimp): other formats cannot be read, such as those of OpenGlider (.ods, .json)",
            arguments.file.display()
        )));
    }
    let (imported, case) = one(&arguments.file, &arguments.out, arguments.pilot)?;
    let folder = folder_of(&arguments.file);
    emit(&format!("{}\n\n{}", imported.name, table(&case, folder)))?;
    for line in &imported.left_out {
        emit(&format!("not brought in: {line}\n"))?;
    }
    let path = arguments.out.join(CASE);
    emit(&format!(
        "case: {}; `ripstop run {}` trims it\n",
        path.display(),
        path.display()
    ))?;
    Ok(0)
}

fn bad(why: String) -> Failure {
    Failure::Other(exit::BAD_CASE, why)
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or_else(|| Path::new("."))
}

/// Brings one wing in, and checks it.
fn one(file: &Path, out: &Path, pilot_kg: Option<f64>) -> Result<(Imported, Case), Failure> {
    let told = file.display();
    let text = read(file).map_err(|why| bad(format!("cannot read {told}: {why}")))?;
    let folder = folder_of(file);
    let airfoil = |name: &str| {
        let text = read(&folder.join(name)).ok()?;
        leparagliding::airfoil(&text)
    };
    let imported = leparagliding::import(&text, pilot_kg, airfoil)
        .map_err(|why| bad(format!("{told}: {why}")))?;
    // All airfoils are read before anything is written.
    let mut files = Vec::new();
    for name in &imported.profiles {
        let airfoil = profile(folder, name, file)?;
        files.push((out.join(name), airfoil));
    }
    let case = put(&imported.text, folder, out, &files)?;
    Ok((imported, case))
}

/// A wing of XFLR5.
fn of_xflr5(arguments: &ImportArguments) -> Result<u8, Failure> {
    let file = &arguments.file;
    let told = file.display();
    let text = read(file).map_err(|why| bad(format!("cannot read {told}: {why}")))?;
    if arguments.pilot.is_some() {
        return Err(bad(
            "--pilot has no effect on a wing of XFLR5, which flies by itself: leave it out"
                .to_owned(),
        ));
    }
    let speed_m_s = arguments.speed.unwrap_or(USUAL_SPEED_M_S);
    if !(speed_m_s > 0.0 && speed_m_s < 1e3) {
        return Err(bad(format!(
            "--speed {speed_m_s} is no speed of a wing: give it in m/s"
        )));
    }
    let imported = xflr5::import(&text, speed_m_s, |name| {
        folder_of(file).join(format!("{name}.dat")).is_file()
    })
    .map_err(|why| bad(format!("{told}: {why}")))?;
    let folder = folder_of(file);
    let files = imported.profiles.iter().map(|name| {
        let name = format!("{name}.dat");
        let bytes = profile(folder, &name, file)?;
        Ok((arguments.out.join(&name), bytes))
    });
    let files: Vec<(PathBuf, Vec<u8>)> = files.collect::<Result<_, Failure>>()?;
    let case = put(&imported.text, folder, &arguments.out, &files)?;
    let path = arguments.out.join(CASE);
    if let Some(wing) = &case.scene.bare_wing {
        emit(&bare_polar::outlook(&case, wing))?;
    }
    for line in &imported.left_out {
        emit(&format!("not brought in: {line}\n"))?;
    }
    emit(&format!(
        "case: {}; `ripstop polar {}` computes it\n",
        path.display(),
        path.display()
    ))?;
    Ok(0)
}

/// The file of a profile that another file names.
fn profile(folder: &Path, name: &str, named_by: &Path) -> Result<Vec<u8>, Failure> {
    let told = named_by.display();
    let is_name = Path::new(name).components().count() == 1
        && Path::new(name).file_name().is_some_and(|own| own == name);
    if !is_name {
        return Err(bad(format!(
            "{told} names the airfoil {name}: it must lie beside it, under a plain name"
        )));
    }
    std::fs::read(folder.join(name)).map_err(|why| {
        bad(format!(
            "cannot read the airfoil {}: {why}; {told} names it",
            folder.join(name).display()
        ))
    })
}

/// Checks a case and writes it with its files, which nothing that is there may be lost for.
fn put(
    text: &str,
    folder: &Path,
    out: &Path,
    files: &[(PathBuf, Vec<u8>)],
) -> Result<Case, Failure> {
    let failed = |error: OutputError| Failure::Other(exit::OUTPUT_FAILED, error.to_string());
    let path = out.join(CASE);
    // What is wrong with the case is told before it is there.
    let case = case::parse(CASE, text, folder, &Choices::default());
    let case = case.map_err(Failure::Case)?;
    let is_other = |(path, text): &&(PathBuf, Vec<u8>)| {
        path.exists() && std::fs::read(path).ok().as_ref() != Some(text)
    };
    let there = files.iter().find(is_other).map(|(path, _)| path);
    if let Some(there) = there.or_else(|| path.exists().then_some(&path)) {
        return Err(bad(format!(
            "{} is there already and would be lost: give another folder (--out), or remove it",
            there.display()
        )));
    }
    prepare_directory(out).map_err(failed)?;
    for (path, airfoil) in files {
        write_atomically(path, |file| file.write_all(airfoil)).map_err(failed)?;
    }
    write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(failed)?;
    Ok(case)
}

/// How deep folders with wings may lie in the one that is given.
const DEEPEST: usize = 4;

/// Folders that hold a wing: this one, and those within, but hidden ones.
fn find_wings(folder: &Path, deepest: usize, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    if folder.join(THEIRS).is_file() {
        found.push(folder.to_owned());
    }
    if deepest == 0 {
        return Ok(());
    }
    let unreadable = |why: std::io::Error| bad(format!("cannot read {}: {why}", folder.display()));
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        let path = entry.path();
        if path.is_dir() && !is_hidden {
            find_wings(&path, deepest - 1, found)?;
        }
    }
    Ok(())
}

/// Brings in the wing of every folder in a folder, and tells of each in a line.
fn several(arguments: &ImportArguments) -> Result<u8, Failure> {
    let told = arguments.file.display();
    let mut folders = Vec::new();
    find_wings(&arguments.file, DEEPEST, &mut folders)?;
    folders.sort();
    if folders.is_empty() {
        return Err(bad(format!(
            "no folder in {told} holds a {THEIRS}: give the file of one wing, or a folder of such folders"
        )));
    }
    let head = [
        "wing",
        "cells",
        "area m²",
        "span m",
        "projected m²",
        "lines m",
        "",
    ];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    let (mut notes, mut failures) = (Vec::new(), 0);
    for folder in folders {
        // Folders within folders have all their names, the wing of the folder itself none.
        let name = folder.strip_prefix(&arguments.file).unwrap_or(&folder);
        let found = one(
            &folder.join(THEIRS),
            &arguments.out.join(name),
            arguments.pilot,
        );
        let name = if name.as_os_str().is_empty() {
            folder.display().to_string()
        } else {
            name.display().to_string()
        };
        let wing = found
            .as_ref()
            .ok()
            .and_then(|(_, case)| Some((case, case.scene.wing()?)));
        lines.push(match (&found, wing) {
            (Ok(_), Some((case, wing))) => {
                let measures = &wing.built.measures;
                let shown = |number: f64| significant(number, DIGITS);
                vec![
                    name,
                    wing.plan.cells.to_string(),
                    shown(measures.flat_area_m2),
                    shown(measures.flat_span_m),
                    shown(measures.projected_area_m2),
                    shown(
                        leparagliding::lines_m(&leparagliding::rows_of_lines_m(case))
                            .unwrap_or(0.0),
                    ),
                    "brought in".to_owned(),
                ]
            }
            (Err(why), _) => {
                let why = match why {
                    Failure::Case(error) => error.to_string(),
                    Failure::NoDevice(why) | Failure::Other(_, why) => why.clone(),
                };
                let nothing = std::iter::repeat_n(NOTHING.to_owned(), head.len() - 2);
                std::iter::once(name).chain(nothing).chain([why]).collect()
            }
            (Ok(_), None) => vec![name],
        });
        match found {
            Ok((imported, _)) => notes.push((imported.name.clone(), imported)),
            Err(_) => failures += 1,
        }
    }
    emit(&aligned(&lines))?;
    for (name, imported) in &notes {
        for line in &imported.left_out {
            emit(&format!("{name}: not brought in: {line}\n"))?;
        }
    }
    if failures > 0 {
        return Err(bad(format!("{failures} wings could not be brought in")));
    }
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
    let of_rows = leparagliding::rows_of_lines_m(case);
    let mut rows = vec![
        (
            "flat area".to_owned(),
            "m²",
            measures.flat_area_m2,
            published.flat_area_m2,
        ),
        (
            "flat span".to_owned(),
            "m",
            measures.flat_span_m,
            published.flat_span_m,
        ),
        (
            "projected area".to_owned(),
            "m²",
            measures.projected_area_m2,
            published.projected_area_m2,
        ),
        (
            "projected span".to_owned(),
            "m",
            measures.projected_span_m,
            published.projected_span_m,
        ),
        (
            "lines, without risers and brakes".to_owned(),
            "m",
            leparagliding::lines_m(&of_rows).unwrap_or(0.0),
            leparagliding::lines_m(&published.rows_m),
        ),
    ];
    for (name, ours_m) in of_rows {
        let theirs = published.rows_m.iter().find(|(theirs, _)| *theirs == name);
        let told = match &name[..] {
            "brake" => "  brakes, without their main line".to_owned(),
            _ => format!("  row {name}"),
        };
        rows.push((told, "m", ours_m, theirs.map(|(_, length_m)| *length_m)));
    }
    let head = ["", "unit", "here", "LEparagliding", "difference"].map(str::to_owned);
    let row = |(name, unit, ours, theirs): (String, &str, f64, Option<f64>)| {
        let shown = |number: f64| significant(number, DIGITS);
        let theirs_text = theirs.map_or_else(|| NOTHING.to_owned(), shown);
        let difference = theirs.map_or_else(
            || NOTHING.to_owned(),
            |theirs| format!("{:+.2} %", 100.0 * (ours / theirs - 1.0)),
        );
        vec![name, unit.to_owned(), shown(ours), theirs_text, difference]
    };
    let lines: Vec<Vec<String>> = std::iter::once(head.to_vec())
        .chain(rows.into_iter().map(row))
        .collect();
    aligned(&lines)
}
