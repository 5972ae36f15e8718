//! Pages from their parts.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::charts::charts;
use super::folder::{Finished, names};
use super::parts;

/// Pictures of each run on a page of several.
const PICTURES_OF_EACH: usize = 2;

pub(super) fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ "ripstop " (env!("CARGO_PKG_VERSION")) };
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// The report of a run.
pub(super) fn of_run(run: &Finished) -> String {
    let runs = std::slice::from_ref(run);
    let title = &run.summary.case.title;
    let body = html! {
        h1 { (title) }
        p.stand { (run.summary.stop.state) ": " (run.summary.stop.reason) }
        (parts::headline_table(run))
        (parts::pictures(run, usize::MAX))
        (parts::drawn(&charts(runs)))
        (parts::comparison(run))
        (parts::validity(run))
        h2 { "All results" }
        details { summary { (run.summary.results.iter().count()) " results with their remarks" } (parts::all_results(run)) }
        (parts::provenance(run))
    };
    page(title, &body)
}

/// Several runs side by side.
pub(super) fn of_several(runs: &[Finished]) -> String {
    let names = names(runs);
    let title = names.join(" beside ");
    let body = html! {
        h1 { (title) }
        (parts::side_by_side(runs, false))
        (parts::drawn(&charts(runs)))
        @for (run, name) in runs.iter().zip(&names) {
            h2 { (name) ": " (run.summary.case.title) }
            (parts::pictures(run, PICTURES_OF_EACH))
            (parts::provenance(run))
        }
        h2 { "All results" }
        details { summary { "side by side" } (parts::side_by_side(runs, true)) }
    };
    page(&title, &body)
}
