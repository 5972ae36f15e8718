//! Section 21: nylon rods ("joncs") in the noses of ribs.

use toml::Value;

use super::super::design::Keys;
use super::sections::{MOST_RIBS, ReadFault, Sections};

/// What the file does not tell of its rods: nylon of 2.4 mm.
const DIAMETER_M: f64 = 0.0024;

/// Kinds of rods in the file: around the nose, an arc within the rib, and two along a nose that is curved inwards.
const AROUND_NOSE: usize = 1;
const ARC: usize = 2;
const SHARK_NOSE: usize = 3;

/// Rods of some ribs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RodGroup {
    kind: usize,
    /// First and last rib, by the numbers of the file.
    ribs: [usize; 2],
    /// Where they end on the upper and on the lower side, per cent of the chord; nothing of an arc.
    ends: [f64; 2],
}

pub(super) fn read(sections: &Sections) -> Result<Vec<RodGroup>, ReadFault> {
    let mut section = sections.get(21, "rods")?;
    let scheme = section.count()?;
    let blocks = match scheme {
        0 => 0,
        1 => 1,
        2 => section.count()?,
        _ => return Err(section.fault(&scheme.to_string())),
    };
    let mut groups = Vec::new();
    for _ in 0..blocks {
        let kind = if scheme == 1 {
            AROUND_NOSE
        } else {
            section.numbers(2)?[1] as usize
        };
        for _ in 0..section.count()? {
            let ribs = section.numbers(3)?;
            let ribs = [ribs[1], ribs[2]].map(|rib| rib.clamp(0.0, MOST_RIBS) as usize);
            // Of both sides the place where the rod leaves the outline to be slid in, and where it ends.
            let ends = match kind {
                ARC => {
                    section.numbers(5)?;
                    [0.0; 2]
                }
                SHARK_NOSE => {
                    let upper = section.numbers(4)?[1];
                    section.numbers(4)?;
                    section.numbers(4)?;
                    [upper, section.numbers(4)?[1]]
                }
                AROUND_NOSE => [section.numbers(4)?[1], section.numbers(4)?[1]],
                _ => return Err(section.fault(&kind.to_string())),
            };
            section.numbers(4)?;
            groups.push(RodGroup { kind, ribs, ends });
        }
    }
    Ok(groups)
}

/// Puts the rods around noses into so many ribs of a half, of which the first may stand in the middle; says what is left out.
pub(super) fn derive(
    groups: &Result<Vec<RodGroup>, ReadFault>,
    (ribs, has_middle_rib): (usize, bool),
    keys: &mut Keys,
    left_out: &mut Vec<String>,
) {
    let groups = match groups {
        Ok(groups) => groups,
        Err(fault) => {
            left_out.push(format!("rods: {fault}"));
            return;
        }
    };
    let mut taken: Vec<usize> = Vec::new();
    let mut number = 0;
    for group in groups {
        let per_chord = group.ends.map(|end| 0.01 * end);
        if group.kind == ARC || !per_chord.iter().all(|end| (0.01..1.0).contains(end)) {
            left_out.push(format!(
                "rods within ribs {} to {}: only those around noses are brought in",
                group.ribs[0], group.ribs[1]
            ));
            continue;
        }
        if group.kind == SHARK_NOSE {
            left_out.push(format!(
                "the two rods in each of the ribs {} to {}: one around the nose stands in their place",
                group.ribs[0], group.ribs[1]
            ));
        }
        // A rib has the rod of the first group that names it.
        let named = group.ribs[0].max(1)..=group.ribs[1].min(ribs);
        let free: Vec<usize> = named.filter(|rib| !taken.contains(rib)).collect();
        let asked = (group.ribs[1] + 1).saturating_sub(group.ribs[0]);
        if free.len() < asked {
            left_out.push(format!(
                "rods of {} of the ribs {} to {}: they are not there, or have others",
                asked - free.len(),
                group.ribs[0],
                group.ribs[1]
            ));
        }
        if free.is_empty() {
            continue;
        }
        number += 1;
        let of = |name: &str| format!("structure.wing.rods.nose_{number}.{name}");
        for (side, end) in ["upper", "lower"].into_iter().zip(per_chord) {
            keys.set(
                of(side),
                vec![Value::from(0.0), Value::from(end)],
                "section 21",
            );
        }
        let why = "usual: nylon of 2.4 mm; the file does not tell";
        keys.set(of("diameter_m"), DIAMETER_M, why);
        let first = usize::from(has_middle_rib);
        let numbers = free.iter().map(|rib| Value::from((rib - first) as i64));
        keys.set(of("ribs"), numbers.collect::<Vec<Value>>(), "section 21");
        taken.extend(free);
    }
}
