//! The answer of a run: its headline, what it is worth, and where the rest stands.

use std::path::Path;

use crate::measure::{declared_result, headline};
use crate::output::{
    ExpectedError, Quantity, Summary, UNRESOLVED, aligned, comparison_text, reference_text,
    with_interval,
};
use crate::run::Report;

/// What a run prints at its end.
pub(super) fn answer_text(report: &Report, out: &Path) -> String {
    let summary = &report.summary;
    let mut lines = vec![summary.case.title.clone()];
    let names = headline(summary.results.iter().map(|(name, _)| name));
    lines.extend(headline_lines(summary, &names));
    let trust = trust(summary, &names);
    lines.push(match report.interrupted {
        true => trust.replacen("trust: ", "trust: interrupted; ", 1),
        false => trust,
    });
    if !summary.comparison.is_empty() {
        lines.push("beside the values of others:".to_owned());
        lines.push(comparison_text(&summary.comparison).trim_end().to_owned());
    }
    // An equilibrium has no time.
    let when = match summary.steps {
        0 => String::new(),
        steps => format!("t = {:.4} s; {steps} steps ", summary.stop.when_s),
    };
    lines.push(format!(
        "stopped: {} ({when}in {:.1} s)",
        summary.stop.reason, summary.wall_s
    ));
    let notes = summary.notes.iter();
    lines.extend(notes.map(|note| format!("note: {note}")));
    if let Some(picture) = &report.last_picture {
        lines.push(format!("picture: {}", picture.display()));
    }
    let others = summary.results.iter().count() - names.len();
    let page = if report.interrupted {
        let folder = out.display();
        format!("folder: {folder}; `ripstop report {folder}` makes a page of it")
    } else {
        format!("report: {}", out.join(crate::report::FILE_NAME).display())
    };
    lines.push(format!(
        "{page}; --all prints {others} more results, their notes, what the set-up supports and what was solved"
    ));
    lines.join("\n") + "\n"
}

/// What a run prints that broke down: its results up to then.
pub(super) fn broken_down_text(summary: &Summary) -> String {
    let names = headline(summary.results.iter().map(|(name, _)| name));
    let title = format!("{}: until it broke down", summary.case.title);
    let mut lines = vec![title];
    lines.extend(headline_lines(summary, &names));
    lines.push(trust(summary, &names));
    lines.join("\n") + "\n"
}

/// Name, value with its interval, unit and meaning of each.
fn headline_lines(summary: &Summary, names: &[&str]) -> Vec<String> {
    let of = |name: &str| summary.results.iter().find(|(known, _)| *known == name);
    let rows: Vec<Vec<String>> = (names.iter())
        .filter_map(|name| of(name))
        .map(|(name, quantity)| {
            let declared = declared_result(name);
            let phrase = declared.map_or("", |row| row.phrase());
            let mut meaning = phrase.to_owned();
            let is_mean = quantity
                .note
                .as_deref()
                .is_some_and(|n| n.starts_with("mean"));
            if is_mean && phrase.contains("largest") {
                // Of the largest at every instant.
                meaning += ", mean over time";
            }
            if quantity.unresolved.is_some() {
                meaning += &format!(" ({UNRESOLVED})");
            }
            if let Some(reference) = reference_text(quantity) {
                meaning += &format!("; reference {reference}");
            }
            vec![
                format!("  {name}"),
                with_interval(quantity),
                unit(quantity),
                meaning,
            ]
        })
        .collect();
    aligned(&rows).lines().map(str::to_owned).collect()
}

fn unit(quantity: &Quantity) -> String {
    match &quantity.unit[..] {
        "1" => String::new(),
        unit => unit.to_owned(),
    }
}

/// One line on what the headline is worth.
fn trust(summary: &Summary, names: &[&str]) -> String {
    let of_headline = || {
        let results = summary.results.iter();
        results.filter(|(name, _)| names.contains(name))
    };
    let unresolved: Vec<&str> = of_headline()
        .filter(|(_, quantity)| quantity.unresolved.is_some())
        .map(|(name, _)| name)
        .collect();
    let reasons: Vec<&str> = {
        let mut all: Vec<&str> = of_headline()
            .filter_map(|(_, quantity)| quantity.unresolved.as_deref())
            .flat_map(|why| why.split("; "))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let missed: Vec<String> = (summary.account.iter())
        .filter(|row| row.reached == Some(false))
        .map(crate::output::AccountRow::line)
        .collect();
    // What was missed comes first: a set-up may be sound, and its solution is not.
    let mut text = if missed.is_empty() {
        "trust: ".to_owned()
    } else {
        format!("trust: NOT ALL WAS MET: {}; ", missed.join("; "))
    };
    let first = of_headline().find(|(name, _)| names.first() == Some(name));
    if let Some((name, quantity)) = first.filter(|(_, quantity)| quantity.value.is_none()) {
        let why = quantity.note.as_deref().unwrap_or("no value");
        text += &format!("{name} was not measured ({why}); ");
    }
    text += &if unresolved.is_empty() && summary.validity.is_empty() {
        "nothing in the set-up of such a case is judged".to_owned()
    } else if unresolved.is_empty() {
        "nothing in the set-up speaks against these".to_owned()
    } else if unresolved.len() == names.len() {
        format!("none of these is resolved: {}", reasons.join("; "))
    } else {
        format!(
            "{} of {} are not resolved ({}): {}",
            unresolved.len(),
            names.len(),
            unresolved.join(", "),
            reasons.join("; ")
        )
    };
    let others = summary
        .results
        .iter()
        .filter(|(name, quantity)| quantity.unresolved.is_some() && !names.contains(name));
    let others = others.count();
    if unresolved.is_empty() && others > 0 {
        text += &format!("; {others} other results are not resolved (--all says why)");
    }
    let expected: Vec<String> = summary
        .expected_errors
        .iter()
        .map(ExpectedError::line)
        .collect();
    if !expected.is_empty() {
        text += &format!("; error to be expected: {}", expected.join("; "));
    }
    text
}
