//! Pieces of cloth as one SVG file at true scale, in millimetres.

use std::fmt::Write;
use std::path::Path;

use super::atomic::{OutputError, write_atomically};
use super::provenance::Provenance;
use super::xml::escaped;

/// Room between pieces [mm].
const GAP_MM: f64 = 60.0;

/// Height of the words beside a piece [mm].
const TEXT_MM: f64 = 18.0;

/// Most width of a row of pieces [mm].
const SHEET_MM: f64 = 12_000.0;

/// A piece of cloth.
#[derive(Debug, Clone, PartialEq)]
pub struct PatternPiece {
    /// Closed outline [m].
    pub outline_m: Vec<[f64; 2]>,
    /// What is written on it, line by line.
    pub words: Vec<String>,
    /// Marks on the outline: place [m] and name.
    pub marks: Vec<([f64; 2], String)>,
}

/// Writes pieces side by side, row by row, whole or not at all, with where they are from; y of a piece points up the page.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_patterns(
    path: &Path,
    title: &str,
    pieces: &[PatternPiece],
    provenance: &Provenance,
) -> Result<(), OutputError> {
    let svg = provenance.put_into_svg(&svg(title, pieces));
    write_atomically(path, |out| out.write_all(svg.as_bytes()))
}

fn svg(title: &str, pieces: &[PatternPiece]) -> String {
    let mut body = String::new();
    let (mut x, mut y, mut row_height, mut sheet_width) = (GAP_MM, 2.0 * GAP_MM, 0.0_f64, 0.0_f64);
    for piece in pieces {
        let bounds = |axis: usize| {
            let ends = piece.outline_m.iter().map(|p| 1e3 * p[axis]);
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
                [a.min(v), b.max(v)]
            })
        };
        let ([left, right], [low, high]) = (bounds(0), bounds(1));
        let words = TEXT_MM * 1.3 * piece.words.len() as f64;
        // Words stand below their piece.
        let longest = piece
            .words
            .iter()
            .map(|w| w.chars().count())
            .max()
            .unwrap_or(0);
        let width = (right - left).max(0.6 * TEXT_MM * longest as f64);
        if x > GAP_MM && x + width > SHEET_MM {
            x = GAP_MM;
            y += row_height + GAP_MM;
            row_height = 0.0;
        }
        let at = |p: &[f64; 2]| [x + 1e3 * p[0] - left, y + high - 1e3 * p[1]];
        let mut outline = String::new();
        for (number, point) in piece.outline_m.iter().enumerate() {
            let [px, py] = at(point);
            let command = if number == 0 { 'M' } else { 'L' };
            let _ = write!(outline, "{command}{px:.2} {py:.2} ");
        }
        let _ = writeln!(body, "<path d=\"{outline}Z\"/>");
        for (point, name) in &piece.marks {
            let [px, py] = at(point);
            let _ = writeln!(
                body,
                "<circle cx=\"{px:.2}\" cy=\"{py:.2}\" r=\"4\"/><text x=\"{:.2}\" y=\"{py:.2}\">{}</text>",
                px + 6.0,
                escaped(name)
            );
        }
        for (number, line) in piece.words.iter().enumerate() {
            let line_y = y + high - low + TEXT_MM * 1.3 * (number as f64 + 1.0);
            let _ = writeln!(
                body,
                "<text x=\"{x:.2}\" y=\"{line_y:.2}\">{}</text>",
                escaped(line)
            );
        }
        x += width + GAP_MM;
        sheet_width = sheet_width.max(x);
        row_height = row_height.max(high - low + words);
    }
    let height = y + row_height + GAP_MM;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{sheet_width:.2}mm\" height=\"{height:.2}mm\" viewBox=\"0 0 {sheet_width:.2} {height:.2}\">\n<title>{0}</title>\n<g fill=\"none\" stroke=\"#000000\" stroke-width=\"1\" font-family=\"sans-serif\" font-size=\"{TEXT_MM}\">\n<style>text {{ fill: #0072B2; stroke: none; }} circle {{ stroke: #D55E00; }}</style>\n<text x=\"{GAP_MM}\" y=\"{GAP_MM}\">{0}</text>\n{body}</g>\n</svg>\n",
        escaped(title)
    )
}
