//! A wing of XFLR5 (`.xwimp`) as a wing by itself: `[aero.wing]`.
//!
//! The first line is the name; every other one is a section, from the middle to the tip. Its numbers are, in order:
//!
//! 1. place along the developed span [m];
//! 2. chord [m];
//! 3. how far the nose lies behind that of the middle [m];
//! 4. dihedral of the part outside of it [°];
//! 5. twist about the quarter chord [°];
//! 6. panels along chord and span, with two codes of their spacing;
//! 7. names of the profiles on the right and on the left, with `/_/` for blanks.
//!
//! The format has no document; this is what XFLR5 6.62 reads and writes.

use std::fmt::Write;

/// Half of the span of the largest wing that is taken [m].
const WIDEST_M: f64 = 200.0;

/// Why a wing cannot be brought in.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Xflr5Fault {
    /// A line is no section.
    #[error(
        "line {line}: a section has nine numbers and the names of two profiles (place, chord, offset, dihedral, twist, panels along chord and span, two codes); names with blanks have `/_/` in their place"
    )]
    Section {
        /// Number of the line, from 1.
        line: usize,
    },
    /// There are too few of them, or they do not go outwards.
    #[error("{0}")]
    Wing(String),
}

/// A wing that was brought in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Imported {
    /// Its name.
    pub name: String,
    /// The case.
    pub text: String,
    /// Names of profiles whose coordinates it needs, as `NAME.dat`.
    pub profiles: Vec<String>,
    /// What the file says and the case does not.
    pub left_out: Vec<String>,
}

struct Section {
    place_m: f64,
    chord_m: f64,
    offset_m: f64,
    dihedral_deg: f64,
    twist_deg: f64,
    profiles: [String; 2],
}

/// Reads the text of an `.xwimp` and writes it as a case at a speed [m/s]; `has_file` tells whether the coordinates of a profile are there, which then count, not its name.
///
/// # Errors
///
/// Where a line is no section, or they make no wing.
pub fn import(
    text: &str,
    speed_m_s: f64,
    has_file: impl Fn(&str) -> bool,
) -> Result<Imported, Xflr5Fault> {
    let mut lines = text.lines().enumerate();
    let name = lines.next().map_or("", |(_, name)| name.trim()).to_owned();
    let sections: Vec<Section> = lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(number, line)| section(line).ok_or(Xflr5Fault::Section { line: number + 1 }))
        .collect::<Result<_, _>>()?;
    if sections.len() < 2 {
        return Err(Xflr5Fault::Wing(
            "the wing has fewer than two sections".to_owned(),
        ));
    }
    if sections
        .windows(2)
        .any(|pair| pair[1].place_m <= pair[0].place_m)
    {
        return Err(Xflr5Fault::Wing(
            "sections do not go outwards from the middle to the tip".to_owned(),
        ));
    }
    let half_span_m = sections[sections.len() - 1].place_m;
    if half_span_m > WIDEST_M {
        return Err(Xflr5Fault::Wing(format!(
            "its tip lies {half_span_m} m from the middle, where at most {WIDEST_M} m are taken: lengths of the file are metres"
        )));
    }
    let mut left_out = vec![
        "numbers and spacing of panels: panels_per_side and strips of [aero.wing] are ours"
            .to_owned(),
    ];
    if sections[0].place_m != 0.0 {
        left_out.push(format!(
            "the gap of {} m in the middle: the wing begins there",
            sections[0].place_m
        ));
    }
    if sections.iter().any(|s| s.profiles[0] != s.profiles[1]) {
        left_out.push("profiles of the left half where they differ from the right ones".to_owned());
    }
    let mut profiles: Vec<String> = sections.iter().map(|s| s.profiles[0].clone()).collect();
    profiles.sort();
    profiles.dedup();
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let mut case = format!(
        "# From XFLR5.\nversion = 1\ntitle = {}\n\n[aero.wing]\n# Not in the file; loads and Reynolds numbers follow from it.\nspeed_m_s = {speed_m_s:?}\nstations = [\n",
        quoted(&name)
    );
    let (mut y, mut z) = (0.0, 0.0);
    for (k, section) in sections.iter().enumerate() {
        if k > 0 {
            let before = &sections[k - 1];
            let length = section.place_m - before.place_m;
            let (sin, cos) = before.dihedral_deg.to_radians().sin_cos();
            (y, z) = (y + length * cos, z + length * sin);
        }
        let x = section.offset_m + 0.25 * section.chord_m;
        let _ = writeln!(
            case,
            "  {{ position_m = [{x:.6}, {y:.6}, {z:.6}], chord_m = {:?}, twist_deg = {:?}, profile = {} }},",
            section.chord_m,
            section.twist_deg,
            quoted(&section.profiles[0])
        );
    }
    case += "]\n";
    let mut files = Vec::new();
    for profile in profiles {
        let _ = write!(case, "\n[aero.wing.profiles.{}]\n", quoted(&profile));
        match naca_digits(&profile).filter(|_| !has_file(&profile)) {
            Some(digits) => {
                let _ = writeln!(case, "naca = \"{digits}\"");
            }
            None => {
                let _ = writeln!(case, "file = {}", quoted(&format!("{profile}.dat")));
                files.push(profile);
            }
        }
    }
    Ok(Imported {
        name,
        text: case,
        profiles: files,
        left_out,
    })
}

fn section(line: &str) -> Option<Section> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [numbers @ .., right, left] = words.as_slice() else {
        return None;
    };
    let numbers: Vec<f64> = numbers
        .iter()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let [
        place_m,
        chord_m,
        offset_m,
        dihedral_deg,
        twist_deg,
        _,
        _,
        _,
        _,
    ] = *numbers.as_slice()
    else {
        return None;
    };
    Some(Section {
        place_m,
        chord_m,
        offset_m,
        dihedral_deg,
        twist_deg,
        profiles: [right, left].map(|name| name.replace("/_/", " ").trim().to_owned()),
    })
}

/// Digits of a profile that XFLR5 names by its family.
fn naca_digits(name: &str) -> Option<&str> {
    let digits = name.trim().get(4..)?.trim();
    let is_naca = name.trim().get(..4)?.eq_ignore_ascii_case("naca");
    // Names of the six-series have five digits, too.
    let is_family = digits.len() == 4 || (digits.len() == 5 && digits.starts_with('2'));
    (is_naca && is_family && digits.bytes().all(|b| b.is_ascii_digit())).then_some(digits)
}
