//! Text within XML.

/// A text as it may stand between marks or in an attribute; what XML has no way to write is replaced.
pub(super) fn escaped(text: &str) -> String {
    let is_barred = |c: char| {
        c < ' ' && !['\t', '\n', '\r'].contains(&c) || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace(is_barred, "\u{fffd}")
}
