//! Meshes that tests examine, and cases around them.

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use ripstop::case::{self, Choices, Scene};
use ripstop::rigid::Surface;

use crate::command_line::{Finished, ripstop};

/// A square of 1 m in 4 × 4 cells that hangs down from y = 0, z = 0.
pub fn sheet() -> Surface {
    let mut sheet = Surface::default();
    for j in 0..5 {
        for i in 0..5 {
            let place = DVec3::new(f64::from(i), 0.0, f64::from(-j)) * 0.25;
            sheet.positions_m.push(place);
        }
    }
    for j in 0..4 {
        for i in 0..4 {
            let a = 5 * j + i;
            sheet
                .triangles
                .extend([[a, a + 1, a + 6], [a, a + 6, a + 5]]);
        }
    }
    sheet
}

/// The sheet with the vertices across its middle doubled: 26 to 30 lie on 11 to 15 and belong to the lower half.
pub fn with_seam() -> Surface {
    let mut cut = sheet();
    let copies: Vec<DVec3> = cut.positions_m[10..15].to_vec();
    cut.positions_m.extend(copies);
    for nodes in &mut cut.triangles[16..] {
        for node in nodes.iter_mut().filter(|node| (10..15).contains(*node)) {
            *node += 15;
        }
    }
    cut
}

/// A sheet in two halves, of which the lower one has other vertices along the seam, `gap_m` away.
pub fn halves(upper: u32, lower: u32, gap_m: f64) -> Surface {
    let mut sheet = Surface::default();
    for (cells, top) in [(upper, 0.0), (lower, -0.5 - gap_m)] {
        let first = sheet.positions_m.len() as u32;
        for j in 0..3 {
            for i in 0..=cells {
                let across = f64::from(i) / f64::from(cells);
                sheet
                    .positions_m
                    .push(DVec3::new(across, 0.0, top - 0.25 * f64::from(j)));
            }
        }
        for j in 0..2 {
            for i in 0..cells {
                let a = first + (cells + 1) * j + i;
                let [b, c, d] = [a + 1, a + cells + 2, a + cells + 1];
                sheet.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    sheet
}

pub fn with_triangle(places: [[f64; 3]; 3]) -> Surface {
    let mut surface = sheet();
    surface.positions_m.extend(places.map(DVec3::from_array));
    surface.triangles.push([25, 26, 27]);
    surface
}

pub fn obj(surface: &Surface) -> String {
    let mut text = String::new();
    for p in &surface.positions_m {
        writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &surface.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

/// A case with a mesh that hangs from its upper edge; `more` goes into the table of the mesh.
pub fn hanging(more: &str) -> String {
    format!(
        "version = 1\n[structure.mesh]\nfile = \"mesh.obj\"\nscale = 1.0\n{more}\n[fabric]\nthickness_m = 1e-4\ndensity_kg_m3 = 500.0\n\
         youngs_modulus_pa = 1e8\npoisson_ratio = 0.2\n[gravity]\nacceleration_m_s2 = [0.0, 0.0, -9.81]\n[time]\nend_s = 0.05\nstep_s = 1e-3\n"
    )
}

pub const HELD: &str = "held_nodes = [1, 2, 3, 4, 5]";

pub fn write(folder: &Path, surface: &Surface, case: &str) -> String {
    std::fs::write(folder.join("mesh.obj"), obj(surface)).unwrap();
    let path = folder.join("case.toml");
    std::fs::write(&path, case).unwrap();
    path.to_str().unwrap().to_owned()
}

pub fn checked(surface: &Surface, more: &str) -> Finished {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), surface, &hanging(more));
    ripstop(&["check", &case])
}

/// Lines of an error without its frame.
pub fn unframed(errors: &str) -> String {
    let words = errors.split(|c: char| c.is_whitespace() || "│×╭─╰┬·".contains(c));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

pub fn parsed(source: &str, folder: &Path) -> Result<Scene, String> {
    case::parse("mesh", source, folder, &Choices::default())
        .map(|case| case.scene)
        .map_err(|error| format!("{error}"))
}
