//! The page of a wing's polar: what is read off it, its charts, and all angles.

use maud::html;

use super::charts::scalable;
use super::page::page;
use super::parts;
use crate::output::Chart;

/// A table for a page: its heading, and rows of cells, the first of which are the headings of columns.
#[derive(Debug, Clone)]
pub struct PageTable {
    /// Above it.
    pub heading: String,
    /// Rows.
    pub rows: Vec<Vec<String>>,
}

/// What stands on the page of a polar.
#[derive(Debug, Clone)]
pub struct PolarPage {
    /// Name of the wing.
    pub title: String,
    /// One line of how it was computed.
    pub line: String,
    /// Numbers with their meaning.
    pub numbers: Vec<[String; 2]>,
    /// Charts.
    pub charts: Vec<Chart>,
    /// Tables.
    pub tables: Vec<PageTable>,
    /// What a reader has to know.
    pub notes: Vec<String>,
    /// The case as it was computed.
    pub case: String,
}

pub(super) fn page_of(polar: &PolarPage) -> String {
    let charts = polar.charts.iter().filter_map(Chart::svg);
    let charts: Vec<String> = charts.map(|svg| scalable(&svg)).collect();
    let body = html! {
        h1 { (polar.title) }
        p.stand { (polar.line) }
        table {
            @for [meaning, value] in &polar.numbers { tr { td { (meaning) } td { (value) } } }
        }
        (parts::drawn(&charts))
        @for table in &polar.tables {
            h2 { (table.heading) }
            table {
                @for (number, row) in table.rows.iter().enumerate() {
                    tr { @for cell in row { @if number == 0 { th { (cell) } } @else { td { (cell) } } } }
                }
            }
        }
        @for note in &polar.notes { p.note { (note) } }
        details { summary { "The case as it was computed" } pre { (polar.case) } }
    };
    page(&polar.title, &body)
}
