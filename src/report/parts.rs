//! Parts of a report: tables and pictures in HTML.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};

use super::folder::{Finished, names};
use super::side_by_side::differences;
use crate::measure::{declared_result, headline};
use crate::output::{NOTHING, Quantity, reference_text, significant, value_and_uncertainty};

/// Most pictures that a page holds.
const PICTURES: usize = 12;

/// Value, interval and unit.
pub(super) fn quantity(quantity: &Quantity) -> Markup {
    let [value, uncertainty] = value_and_uncertainty(quantity);
    let unit = Some(&quantity.unit[..]).filter(|unit| *unit != "1" && !unit.is_empty());
    html! {
        (value)
        @if uncertainty != NOTHING { " " span.interval { (uncertainty) } }
        @if let Some(unit) = unit && value != NOTHING { " " (unit) }
    }
}

/// First phrase of a result's meaning.
pub(super) fn meaning(name: &str) -> &'static str {
    declared_result(name).map_or("", |row| row.phrase())
}

/// The results that a reader looks for first.
pub(super) fn headline_table(run: &Finished) -> Markup {
    let results = &run.summary.results;
    let names = headline(results.iter().map(|(name, _)| name));
    let of = |name: &str| results.iter().find(|(known, _)| *known == name);
    html! {
        table.headline {
            @for (name, found) in names.iter().filter_map(|name| of(name)) {
                tr.unresolved[found.unresolved.is_some()] {
                    td.value { (quantity(found)) }
                    td { (meaning(name)) br; code { (name) } }
                    td {
                        @if let Some(why) = &found.unresolved { span.mark { "unresolved" } " " (why) ". " }
                        @if let Some(reference) = reference_text(found) { "Reference " (reference) "." }
                    }
                }
            }
        }
    }
}

/// All results, with their remarks.
pub(super) fn all_results(run: &Finished) -> Markup {
    html! {
        table {
            tr { th { "result" } th { "value" } th { "remark" } }
            @for (name, found) in run.summary.results.iter() {
                tr.unresolved[found.unresolved.is_some()] {
                    td { code { (name) } }
                    td { (quantity(found)) }
                    td {
                        @if let Some(why) = &found.unresolved { span.mark { "unresolved" } " " (why) ". " }
                        @if let Some(reference) = reference_text(found) { "Reference " (reference) ". " }
                        @if let Some(note) = &found.note { (note) }
                    }
                }
            }
        }
    }
}

/// Values of others.
pub(super) fn comparison(run: &Finished) -> Markup {
    let rows = &run.summary.comparison;
    let reference = |[low, high]: [f64; 2]| {
        let [low, high] = [low, high].map(|value| significant(value, 4));
        if low == high {
            low
        } else {
            format!("{low} to {high}")
        }
    };
    html! {
        @if !rows.is_empty() {
            h2 { "Beside the values of others" }
            table {
                tr { th { "result" } th { "ours" } th { "reference" } th { "difference" } th { "beyond what the run leaves open?" } th { "source" } }
                @for row in rows {
                    tr.unresolved[row.unresolved] {
                        td { code { (row.quantity) } }
                        td { (quantity(&Quantity { value: row.value, unit: row.unit.clone(), confidence: row.confidence, sampling_error: row.sampling_error, ..Quantity::default() })) }
                        td { (reference(row.reference)) }
                        td { @if let Some(share) = row.relative_difference { (format!("{:+.1} %", 100.0 * share)) } }
                        td { @match row.resolved { Some(true) => "yes", Some(false) => "no", None => "unknown" } ": " (row.why) }
                        td { (row.source) @if let Some(note) = &row.note { "; " (note) } }
                    }
                }
            }
        }
    }
}

/// Whether the set-up supports the results, and what was solved.
pub(super) fn validity(run: &Finished) -> Markup {
    let summary = &run.summary;
    let verdict = |valid: Option<bool>| match valid {
        Some(true) => "ok",
        Some(false) => "no",
        None => "not known",
    };
    html! {
        @if !summary.validity.is_empty() {
            h2 { "What the set-up supports" }
            table {
                tr { th { "" } th { "criterion" } th { "value" } th { "wanted" } th { "what to do" } }
                @for row in &summary.validity {
                    tr.missed[row.valid == Some(false)] {
                        td { (verdict(row.valid)) }
                        td { (row.name) }
                        td { @if let Some(value) = row.value { (significant(value, 3)) } }
                        td { (row.wanted()) }
                        td { @if row.valid == Some(false) { (row.remedy) } }
                    }
                }
            }
        }
        @if !summary.expected_errors.is_empty() {
            p { "Error to be expected: " @for error in &summary.expected_errors { (error.line()) ". " } }
        }
        @if !summary.account.is_empty() {
            h2 { "What was solved, and how well" }
            ul { @for row in &summary.account { li.missed[row.reached == Some(false)] { (row.line()) } } }
        }
    }
}

/// Pictures of the run, inside the page.
pub(super) fn pictures(run: &Finished, most: usize) -> Markup {
    let most = most.min(PICTURES);
    if most == 0 {
        return Markup::default();
    }
    let step = run.pictures.len().div_ceil(most.max(1)).max(1);
    // The last one always; of too many every few.
    let last = run.pictures.len().saturating_sub(1);
    let chosen = (run.pictures.iter().enumerate())
        .filter(|(number, _)| (last - number).is_multiple_of(step))
        .map(|(_, name)| name);
    html! {
        div.pictures {
            @for name in chosen {
                @if let Ok(bytes) = std::fs::read(run.folder.join(name)) {
                    figure {
                        img src={ "data:image/png;base64," (STANDARD.encode(bytes)) } alt=(name);
                        figcaption { (name) }
                    }
                }
            }
        }
    }
}

/// Charts, which are SVG.
pub(super) fn drawn(charts: &[String]) -> Markup {
    html! {
        div.charts { @for chart in charts { figure { (PreEscaped(chart)) } } }
    }
}

/// Who computed it, when, and from what.
pub(super) fn provenance(run: &Finished) -> Markup {
    let summary = &run.summary;
    html! {
        h2 { "Where it is from" }
        table {
            tr { td { "case" } td { (summary.case.file) @if let Some(variant) = &summary.case.variant { ", variant " (variant) } ", hash " (summary.case.hash) } }
            @if let Some(ledger) = &run.ledger {
                @if !ledger.case.overrides.is_empty() { tr { td { "changed by" } td { @for change in &ledger.case.overrides { code { "--set " (change) } " " } } } }
                @for session in &ledger.sessions {
                    tr { td { "computed" } td {
                        (session.began) @if let Some(ended) = &session.ended { " to " (ended) } ", by " (session.computed_by)
                        @if let Some(host) = &session.machine.host { " on " (host) }
                        "; ripstop " (session.program.version) @if let Some(commit) = &session.program.commit { " (" (commit) ")" }
                    } }
                }
            }
            tr { td { "size" } td {
                @if let Some([x, y, z]) = summary.cells { (x) " × " (y) " × " (z) " cells; " }
                (summary.nodes) " nodes, " (summary.triangles) " triangles; "
                @if summary.steps > 0 { (summary.steps) " steps " }
                "in " (format!("{:.1}", summary.wall_s)) " s; " (summary.precision)
            } }
            tr { td { "stopped" } td { (summary.stop.reason) @if summary.steps > 0 { " (t = " (format!("{:.4}", summary.stop.when_s)) " s)" } } }
            tr { td { "folder" } td { (run.folder.display()) } }
        }
        @for note in &summary.notes { p.note { (note) } }
        @if let Some(ledger) = &run.ledger {
            details { summary { "The case as it was run" } pre { (ledger.case.text) } }
        }
    }
}

/// Results of several runs side by side.
pub(super) fn side_by_side(runs: &[Finished], all: bool) -> Markup {
    let names = names(runs);
    html! {
        table {
            tr { th { "result" } @for (number, name) in names.iter().enumerate() { th { (name) } @if number > 0 { th { "against " (names[0]) } } } }
            @for row in differences(runs, all) {
                tr {
                    td { (meaning(&row.name)) br; code { (row.name) } }
                    @for (number, found) in row.values.iter().enumerate() {
                        td { @if let Some(found) = found { (quantity(found)) @if found.unresolved.is_some() { " " span.mark { "unresolved" } } } }
                        @if number > 0 {
                            td {
                                @if let Some(share) = row.relative(number) { (format!("{:+.1} %", 100.0 * share)) }
                                @match row.beyond_intervals(number) { Some(true) => " beyond the intervals (in quadrature)", Some(false) => " within the intervals", None => "" }
                            }
                        }
                    }
                }
            }
        }
    }
}
