//! Surfaces from STL files, as programs write them.
//!
//! The crate `stl_io` reads the triangles. What it does not know is settled before: binary files whose header begins with "solid", several
//! solids in one text (it would stop after the first), names that are missing, capitals, and normals that are not numbers.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use crate::rigid::Surface;

/// Bytes before the first triangle of a binary file, and of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads a file, in its unit times `scale` [m].
pub(super) fn read(path: &Path, scale: f64) -> Result<Surface, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let mesh =
        stl_io::read_stl(&mut Cursor::new(plain(bytes)?)).map_err(|error| error.to_string())?;
    Ok(Surface {
        positions_m: mesh
            .vertices
            .iter()
            .map(|v| DVec3::from_array(v.0.map(f64::from)) * scale)
            .collect(),
        triangles: mesh
            .faces
            .iter()
            .map(|face| face.vertices.map(|node| node as u32))
            .collect(),
    })
}

/// The same triangles, such that the crate sees what they are.
fn plain(mut bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let count = bytes.get(HEADER - 4..HEADER).map(|count| {
        count
            .iter()
            .rev()
            .fold(0, |sum, byte| (sum << 8) | usize::from(*byte))
    });
    let length = count.map(|count| HEADER + TRIANGLE * count);
    if length != Some(bytes.len()) && is_text(&bytes) {
        return Ok(plain_text(&String::from_utf8_lossy(&bytes)).into_bytes());
    }
    match (count, length) {
        (Some(_), Some(length)) if length <= bytes.len() => {
            bytes[..5].fill(b' ');
            Ok(bytes)
        }
        (Some(count), Some(length)) => Err(format!(
            "it should have {count} triangles in {length} bytes, but ends after {}: it is cut off, or no STL file",
            bytes.len()
        )),
        _ => Err(format!(
            "it has {} bytes, which is too few for an STL file",
            bytes.len()
        )),
    }
}

fn is_text(bytes: &[u8]) -> bool {
    let begin = String::from_utf8_lossy(&bytes[..bytes.len().min(512)]).to_ascii_lowercase();
    let begin = begin.trim_start_matches(|c: char| c == '\u{feff}' || c.is_whitespace());
    begin.starts_with("solid") && !begin.contains('\0')
}

/// All facets as those of one solid.
fn plain_text(text: &str) -> String {
    let text = text.to_ascii_lowercase().replace('\r', "\n");
    let mut plain = String::with_capacity(text.len());
    plain.push_str("solid mesh\n");
    for line in text.trim_start_matches('\u{feff}').lines() {
        let line = line.trim();
        if line.starts_with("facet") {
            plain.push_str("facet normal 0 0 0\n");
        } else if !line.is_empty() && !line.starts_with("solid") && !line.starts_with("endsolid") {
            plain.push_str(line);
            plain.push('\n');
        }
    }
    plain.push_str("endsolid mesh\n");
    plain
}
