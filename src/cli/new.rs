//! `ripstop new NAME`

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit;
use super::failure::Failure;
use super::log::{emit, say};
use crate::case::{
    SCHEMA_DIRECTIVE, SCHEMA_FILE, SHIPPED, SHIPPED_FILES, did_you_mean, schema_text,
};
use crate::output::{OutputError, prepare_directory, write_atomically};

#[derive(Debug, Args)]
pub(super) struct NewArguments {
    /// Name of a shipped case; without it they are listed.
    name: Option<String>,

    /// Folder to write NAME.toml, the files that it names and the JSON schema for editors into, instead of printing the case.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) fn new(arguments: &NewArguments) -> Result<u8, Failure> {
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
        let mut files = beside;
        files.push((&case, &text));
        return write(folder, &files);
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
        "ripstop new NAME prints a case to start from; --out DIR writes it with its files.\n",
    );
    for (by_design, title) in [
        (true, "by their design:"),
        (false, "with all tables written:"),
    ] {
        text += &format!("\n{title}\n");
        let cases = SHIPPED.iter();
        for (name, case) in cases.filter(|(_, case)| case.contains("\n[canopy]") == by_design) {
            text += &format!("  {name:width$}  {}\n", first_sentence(case));
        }
    }
    text
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
    let end = text.find(['.', '?', ':']).map_or(text.len(), |at| at);
    text[..end].trim().to_owned()
}

/// Writes files, given by their paths in a folder and their texts, none of which may be there already; and the schema, which other cases
/// there may have.
fn write(folder: &Path, files: &[(&str, &str)]) -> Result<u8, Failure> {
    let paths = || files.iter().map(|(file, _)| folder.join(file));
    if let Some(there) = paths().find(|path| path.exists()) {
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!(
                "{} is there already and would be lost: give another folder (--out), or remove it",
                there.display()
            ),
        ));
    }
    let failed = |error: OutputError| Failure::Other(exit::OUTPUT_FAILED, error.to_string());
    let schema = schema_text();
    let schema = (folder.join(SCHEMA_FILE), &(SCHEMA_FILE, &schema[..]));
    for (path, (_, text)) in paths().zip(files).chain([schema]) {
        prepare_directory(path.parent().unwrap_or(folder)).map_err(failed)?;
        write_atomically(&path, |out| out.write_all(text.as_bytes())).map_err(failed)?;
        emit(&format!("{}\n", path.display()))?;
    }
    Ok(0)
}
