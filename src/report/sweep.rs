//! The report of a sweep: its table, its charts, what its lattices tell, and every run in short.

use std::path::Path;

use maud::{Markup, html};

use super::charts::scalable;
use super::folder::Finished;
use super::page::page;
use super::parts;
use crate::output::{Quantity, significant};
use crate::sweep::{Chosen, Ladder, Status, Sweep, charts, ladders};

/// Most runs that are shown with a picture.
const PICTURED: usize = 12;

/// Digits of what results tend to.
const DIGITS: i32 = 4;

pub(super) fn page_of(folder: &Path, sweep: &Sweep, chosen: &Chosen) -> String {
    let done = sweep.runs.iter().filter(|run| run.status == Status::Done);
    let drawn = charts(folder, sweep, chosen).into_iter();
    let drawn: Vec<String> = (drawn.filter_map(|(_, chart)| chart.svg()))
        .map(|svg| scalable(&svg))
        .collect();
    let case = Path::new(&sweep.case).file_stem().unwrap_or_default();
    let title = format!(
        "{} over {}",
        case.to_string_lossy(),
        sweep.leading_keys.join(", ")
    );
    let body = html! {
        h1 { (title) }
        p.stand {
            (done.count()) " of " (sweep.runs.len()) " runs done; " (sweep.case)
            @if let Some(variant) = &sweep.variant { ", variant " (variant) }
            "; the first: " (sweep.title)
        }
        (table(sweep, chosen))
        (parts::drawn(&drawn))
        @for ladder in ladders(sweep) { (ladder_table(&ladder, &chosen.results)) }
        (runs(folder, sweep))
    };
    page(&title, &body)
}

/// One row for each run.
fn table(sweep: &Sweep, chosen: &Chosen) -> Markup {
    html! {
        table {
            tr {
                @for key in &sweep.leading_keys { th { (key) } }
                th { "run" }
                @for name in &chosen.results { th { (parts::meaning(name)) br; code { (name) } } }
            }
            @for run in &sweep.runs {
                tr.missed[run.status == Status::Failed] {
                    @for key in &sweep.leading_keys { td { (sweep.value(run, key)) } }
                    td { (run.status.name()) @if let Some(message) = &run.message { ": " (message) }
                        @if !run.missed.is_empty() { " " span.mark title=(run.missed.join("; ")) { "not all was met" } } }
                    @for name in &chosen.results { td { @if let Some(found) = run.results.get(name) { (cell(found)) } } }
                }
            }
        }
    }
}

fn cell(found: &Quantity) -> Markup {
    html! {
        (parts::quantity(found))
        @if let Some(why) = &found.unresolved { " " span.mark title=(why) { "unresolved" } }
    }
}

/// What the lattices of a series tell of the chosen results.
fn ladder_table(ladder: &Ladder, results: &[String]) -> Markup {
    let shown = |number: Option<f64>| number.map_or_else(String::new, |n| significant(n, DIGITS));
    html! {
        h2 { "What the lattices tell" @if !ladder.series.is_empty() { ": " (ladder.series) } }
        table {
            tr {
                th { "result" }
                @for (lattice, starts) in ladder.lattices.iter().zip(&ladder.starts) {
                    th { (lattice) @if *starts > 1 { " (" (starts) " starts)" } }
                }
                th { "order" } th { "tends to" } th { "error" } th { "verdict" }
            }
            @for rung in ladder.rungs.iter().filter(|rung| results.contains(&rung.result)) {
                tr.unresolved[rung.resolved == Some(false)] {
                    td { code { (rung.result) } @if rung.unit != "1" { " [" (rung.unit) "]" } }
                    @for value in &rung.values { td { (shown(*value)) } }
                    td { (shown(rung.order)) } td { (shown(rung.tends_to)) } td { (shown(rung.error)) } td { (rung.verdict) }
                }
            }
        }
    }
}

/// Every run that is done: its picture, its first results, and where it is from.
fn runs(folder: &Path, sweep: &Sweep) -> Markup {
    let done = sweep.runs.iter().filter(|run| run.status == Status::Done);
    let found = done.filter_map(|run| Some((run, Finished::read(&folder.join(&run.folder)).ok()?)));
    html! {
        h2 { "Runs" }
        @for (number, (run, finished)) in found.enumerate() {
            details open[number < PICTURED] {
                summary { (run.folder) }
                (parts::pictures(&finished, usize::from(number < PICTURED)))
                details { summary { "results, and where they are from" } (parts::headline_table(&finished)) (parts::provenance(&finished)) }
            }
        }
    }
}
