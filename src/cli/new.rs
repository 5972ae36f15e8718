//! `ripstop new NAME`, `ripstop new --wing`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit;
use super::failure::Failure;
use super::log::{emit, say};
use crate::case::{
    self, Choices, DESIGN_TABLES, SCHEMA_DIRECTIVE, SCHEMA_FILE, SHIPPED, SHIPPED_FILES,
    did_you_mean, schema_text,
};
use crate::output::{OutputError, prepare_directory, write_atomically};

#[derive(Debug, Args)]
pub(super) struct NewArguments {
    /// Name of a shipped case; without it they are listed.
    name: Option<String>,

    /// A paraglider's case by its design in place of a shipped case; needs --span or --area.
    #[arg(long, conflicts_with = "name")]
    wing: bool,

    /// Flat span of the wing [m].
    #[arg(
        long,
        value_name = "M",
        requires = "wing",
        conflicts_with_all = ["area", "name"],
        allow_negative_numbers = true
    )]
    span: Option<f64>,

    /// Flat area of the wing [m²].
    #[arg(
        long,
        value_name = "M2",
        requires = "wing",
        conflicts_with = "name",
        allow_negative_numbers = true
    )]
    area: Option<f64>,

    /// Cells of the wing; by its class if left out.
    #[arg(long, value_name = "COUNT", requires = "wing", conflicts_with = "name")]
    cells: Option<usize>,

    /// Class of the wing (EN 926-2).
    #[arg(long, requires = "wing", value_enum, default_value_t = ClassArgument::EnB)]
    class: ClassArgument,

    /// Pilot, harness and all else that hangs on the risers [kg]; by the area if left out.
    #[arg(
        long,
        value_name = "KG",
        requires = "wing",
        conflicts_with = "name",
        allow_negative_numbers = true
    )]
    pilot: Option<f64>,

    /// Folder to write NAME.toml, the files that it names and the JSON schema for editors into, instead of printing the case.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Class of a paraglider, written as in case files.
#[derive(Debug, Clone, Copy, ValueEnum)]
#[value(rename_all = "snake_case")]
enum ClassArgument {
    EnA,
    EnB,
    EnC,
    EnD,
}

/// File of a wing by its design.
const WING_FILE: &str = "paraglider.toml";

/// The case of a wing by its design; what is wrong with it is told as of a case file.
fn wing_case(arguments: &NewArguments) -> Result<String, Failure> {
    let class = arguments.class.to_possible_value();
    let class = class.map_or_else(String::new, |value| value.get_name().to_owned());
    let mut text = format!(
        "# A paraglider by its design: plan, lines and trim follow from these lines. `ripstop check {WING_FILE}` lists all keys with their reasons, and\n\
         # each may be written here to change it.\n\nversion = 1\n\n[wing]\nclass = \"{class}\"\n"
    );
    for (key, number) in [
        ("span_m", arguments.span),
        ("area_m2", arguments.area),
        ("pilot_kg", arguments.pilot),
    ] {
        if let Some(number) = number {
            text += &format!("{key} = {number:?}\n");
        }
    }
    if let Some(cells) = arguments.cells {
        text += &format!("cells = {cells}\n");
    }
    match case::parse(WING_FILE, &text, Path::new("."), &Choices::default()) {
        Ok(_) => Ok(text),
        Err(error) => Err(Failure::Case(error)),
    }
}

pub(super) fn new(arguments: &NewArguments) -> Result<u8, Failure> {
    if arguments.wing {
        let text = wing_case(arguments)?;
        let Some(folder) = &arguments.out else {
            return emit(&text).map(|()| 0);
        };
        let text = format!("{SCHEMA_DIRECTIVE} {SCHEMA_FILE}\n{text}");
        return write(folder, (WING_FILE, &text), &[]);
    }
    let Some(wanted) = &arguments.name else {
        return emit(&listed()).map(|()| 0);
    };
    let Some((name, text)) = SHIPPED.iter().find(|(name, _)| name == wanted) else {
        let names = SHIPPED.iter().map(|(name, _)| *name);
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!(
                "there is no shipped case `{wanted}`; {}there are: {}",
                did_you_mean(wanted, names.clone()),
                names.collect::<Vec<_>>().join(", ")
            ),
        ));
    };
    let beside: Vec<(&str, &str)> = SHIPPED_FILES
        .iter()
        .filter(|(of, _, _)| of == name)
        .map(|&(_, path, text)| (path, text))
        .collect();
    // Where its schema is in the repository.
    let text = match text.split_once('\n') {
        Some((first, rest)) if first.starts_with(SCHEMA_DIRECTIVE) => rest,
        _ => text,
    };
    if let Some(folder) = &arguments.out {
        let case = format!("{name}.toml");
        let text = format!("{SCHEMA_DIRECTIVE} {SCHEMA_FILE}\n{text}");
        return write(folder, (&case, &text), &beside);
    }
    emit(text)?;
    if !beside.is_empty() {
        let paths: Vec<&str> = beside.iter().map(|(path, _)| *path).collect();
        say(&format!(
            "note: the case needs {} beside it; `ripstop new {name} --out DIR` writes all of them",
            paths.join(" and ")
        ));
    }
    Ok(0)
}

/// The shipped cases with the first sentence of each; those by a design first.
fn listed() -> String {
    let width = SHIPPED
        .iter()
        .map(|(name, _)| name.len())
        .max()
        .unwrap_or(0);
    let mut text = String::from(
        "ripstop new NAME prints a case to start from; --out DIR writes it with its files. ripstop new --wing --span 11 prints that of a paraglider.\n",
    );
    for (by_design, title) in [
        (true, "by their design:"),
        (false, "with all tables written:"),
    ] {
        text += &format!("\n{title}\n");
        let cases = SHIPPED.iter();
        for (name, case) in cases.filter(|(_, case)| is_by_design(case) == by_design) {
            text += &format!("  {name:width$}  {}\n", first_sentence(case));
        }
    }
    text
}

/// True for a case whose tables follow from a design.
fn is_by_design(case: &str) -> bool {
    DESIGN_TABLES
        .iter()
        .any(|table| case.contains(&format!("\n[{table}]\n")))
}

/// The first sentence of the comment that a case begins with.
fn first_sentence(case: &str) -> String {
    let comment = case
        .lines()
        .filter(|line| !line.starts_with(SCHEMA_DIRECTIVE));
    let comment: Vec<&str> = comment
        .map_while(|line| line.strip_prefix('#'))
        .map(str::trim)
        .collect();
    let text = comment.join(" ");
    // A point within a number ends nothing.
    let ends = |(at, mark): &(usize, char)| {
        let next = text[at + mark.len_utf8()..].chars().next();
        matches!(mark, '.' | '?' | ':') && next.is_none_or(char::is_whitespace)
    };
    let end = text.char_indices().find(ends);
    text[..end.map_or(text.len(), |(at, _)| at)]
        .trim()
        .to_owned()
}

/// Writes a case and the files that it names, given by their paths in a folder and their texts, and the schema, which other cases there may have. The
/// case must not be there already; a file beside it may, as another case's, if it is the same.
fn write(folder: &Path, case: (&str, &str), beside: &[(&str, &str)]) -> Result<u8, Failure> {
    let files = || beside.iter().copied().chain([case]);
    let would_be_lost = |(file, text): &(&str, &str)| {
        let path = folder.join(file);
        let same = || std::fs::read(&path).is_ok_and(|there| there == text.as_bytes());
        path.exists() && (*file == case.0 || !same())
    };
    if let Some((there, _)) = files().find(would_be_lost) {
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!(
                "{} is there already and would be lost: give another folder (--out), or remove it",
                folder.join(there).display()
            ),
        ));
    }
    let failed = |error: OutputError| Failure::Other(exit::OUTPUT_FAILED, error.to_string());
    let schema = schema_text();
    for (file, text) in files().chain([(SCHEMA_FILE, &schema[..])]) {
        let path = folder.join(file);
        prepare_directory(path.parent().unwrap_or(folder)).map_err(failed)?;
        write_atomically(&path, |out| out.write_all(text.as_bytes())).map_err(failed)?;
        emit(&format!("{}\n", path.display()))?;
    }
    Ok(0)
}
