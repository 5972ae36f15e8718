//! Where a key stands in a case file.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// Byte range of `key.path` in `source`: from the key to the end of its value. Falls back to the longest existing prefix.
#[must_use]
pub fn span_of(source: &str, path: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(source).ok()?;
    let mut table = document.get_ref();
    let mut found = None;
    for part in path.split('.') {
        let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == part) else {
            break;
        };
        found = Some(key.span().start..value.span().end.max(key.span().end));
        match value.get_ref() {
            DeValue::Table(inner) => {
                found = Some(key.span());
                table = inner;
            }
            _ => break,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_nested_keys_and_falls_back_to_tables() {
        let source = "version = 1\n[air]\ndensity_kg_m3 = 1.2\n[air.wind_tunnel]\nspeed_m_s = -3\n";
        let text = |path: &str| span_of(source, path).map(|range| &source[range]);
        assert_eq!(text("air.density_kg_m3"), Some("density_kg_m3 = 1.2"));
        assert_eq!(text("air.wind_tunnel.speed_m_s"), Some("speed_m_s = -3"));
        assert_eq!(text("air.wind_tunnel.absent"), Some("wind_tunnel"));
        assert_eq!(text("nothing"), None);
    }
}
