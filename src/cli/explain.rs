//! `ripstop explain WORD` and `ripstop results CASE`: what keys, columns and results mean.

use std::fmt::Write;

use clap::Args;

use super::bare_polar;
use super::case_arguments::CaseArguments;
use super::exit;
use super::failure::Failure;
use super::log::emit;
use crate::case::{KeyMeaning, key_meanings, nearest};
use crate::measure::{self, headline, read_out_tables};
use crate::output::{ReadOut, aligned};

#[derive(Debug, Args)]
pub(super) struct ExplainArguments {
    /// A key of case files or a part of its path (`operator`, `resolution.operator`), or a column or result (`drag_coefficient`).
    word: String,
}

#[derive(Debug, Args)]
pub(super) struct ResultsArguments {
    #[command(flatten)]
    case: CaseArguments,
}

pub(super) fn explain(arguments: &ExplainArguments) -> Result<u8, Failure> {
    let word = arguments.word.trim().trim_matches(['[', ']', '`']);
    let keys = key_meanings();
    let mut text = String::new();
    for key in keys.iter().filter(|key| is_named(&key.path, word)) {
        text += &key_text(key);
        let inner = keys.iter().filter_map(|other| {
            let rest = other.path.strip_prefix(&key.path)?.strip_prefix('.')?;
            (!rest.contains('.')).then_some(rest)
        });
        let inner: Vec<&str> = inner.collect();
        if !inner.is_empty() {
            text += &format!("  its keys: {}\n", inner.join(", "));
        }
    }
    for (kind, groups) in ["column of history.csv", "result"]
        .iter()
        .zip(read_out_tables())
    {
        for group in groups {
            // What is a column of a wing by itself is no body's of such a name.
            let is_polar = bare_polar::COLUMNS.iter().any(|row| row.name == word);
            let is_meant = |row: &&ReadOut| {
                (row.covers(word) && !is_polar) || row.of("").name == word || row.name == word
            };
            for row in group.read_outs().filter(is_meant) {
                text += &read_out_text(kind, group.title(), row);
            }
        }
    }
    for row in bare_polar::COLUMNS.iter().filter(|row| row.name == word) {
        text += &read_out_text("column of polar.csv", "A wing by itself", row);
    }
    // A result that is made of a column has another name than that.
    if text.is_empty()
        && let Some(row) = measure::declared_result(word)
    {
        text += &read_out_text("result", "made of a column", &row);
    }
    if text.is_empty() {
        let columns = read_out_tables().into_iter().flatten();
        let names: Vec<String> = columns
            .flat_map(|group| group.read_outs().collect::<Vec<_>>())
            .map(|row| row.name.to_string())
            .collect();
        let last = |key: &KeyMeaning| key.path.rsplit('.').next().unwrap_or_default().to_owned();
        let keys = keys.iter().map(last);
        let known: Vec<String> = keys.chain(names).collect();
        let hint = nearest(word, known.iter().map(String::as_str))
            .map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!("`{word}` is no key of case files, no column and no result{hint}"),
        ));
    }
    emit(&text)?;
    Ok(0)
}

/// True if a path, or its end, is the word; `NAME` in it stands for any name.
fn is_named(path: &str, word: &str) -> bool {
    let (parts, words) = (path.split('.').rev(), word.split('.').rev());
    let count = words.clone().count();
    let same = |(part, word): (&str, &str)| part == word || (part == "NAME" && count > 1);
    parts.clone().count() >= count && parts.zip(words).all(same)
}

fn key_text(key: &KeyMeaning) -> String {
    let mut text = format!("key {}", key.path);
    let _ = writeln!(
        text,
        " ({}{})",
        key.kind,
        if key.is_optional {
            ", may be left out"
        } else {
            ", required"
        }
    );
    let _ = writeln!(text, "  {}", key.meaning);
    text
}

fn read_out_text(kind: &str, heading: &str, row: &ReadOut) -> String {
    format!(
        "{kind} {} [{}] ({heading})\n  {}\n",
        row.name, row.unit, row.meaning
    )
}

pub(super) fn results(arguments: &ResultsArguments) -> Result<u8, Failure> {
    let case = arguments.case.load(&[])?;
    if case.scene.bare_wing.is_some() {
        emit(&format!(
            "a wing by itself is not run; columns that `ripstop polar` writes to polar.csv:\n{}",
            aligned(&bare_polar::COLUMNS.each_ref().map(|row| vec![
                format!("  {}", row.name),
                row.unit.to_owned(),
                row.meaning.to_owned()
            ]))
        ))?;
        return Ok(0);
    }
    let names = measure::result_names(&case.scene);
    let first = headline(names.iter().map(String::as_str));
    let others: Vec<&str> = (names.iter().map(String::as_str))
        .filter(|name| !first.contains(name))
        .collect();
    let mut text = String::new();
    for (title, names) in [
        ("what a run of this case prints first:", first),
        ("and with --all, in summary.json:", others),
    ] {
        let row = |name: &&str| {
            let (unit, meaning) =
                measure::declared_result(name).map_or(("", ""), |row| (row.unit, row.meaning));
            vec![format!("  {name}"), unit.to_owned(), meaning.to_owned()]
        };
        let rows: Vec<Vec<String>> = names.iter().map(row).collect();
        let _ = write!(text, "{title}\n{}", aligned(&rows));
    }
    emit(&text)?;
    Ok(0)
}
