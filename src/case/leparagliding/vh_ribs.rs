//! Section 12: V- and H-ribs.

use toml::{Table, Value};

use super::super::design::Keys;
use super::super::wing_vh_ribs::{HEIGHTS_BETWEEN_SEAMS, PLACES_BETWEEN_SEAMS};
use super::read::{CENTIMETRE_M, Drawing};
use super::sections::{ReadFault, Sections};

/// Kinds: a strap along the lower seams; V-ribs that end below the upper seam, and at it; a strap on two V-ribs; a V-rib along the whole chord with holes; any
/// piece between two ribs. From ten on the same, with widths per cent of the chord.
const STRAP: usize = 1;
const PARTIAL: usize = 2;
const FULL: usize = 3;
const ON_TWO: usize = 4;
const CONTINUOUS: usize = 5;
const GENERAL: usize = 6;
const PER_CHORD: usize = 10;

/// Heights up to which an end is on the lower seam, and from which on the upper one.
const ON_SEAM: [f64; 2] = [0.05, 0.95];

/// Upper edges that do not lean [°].
const UPRIGHT_DEG: f64 = 90.0;

/// Least width, per chord.
const NARROWEST: f64 = 1e-3;

/// A line of the section: kind, and the numbers behind it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    kind: usize,
    numbers: Vec<f64>,
}

/// An end of a piece: rib by the numbers of the file, place, widths before and behind it and height, per chord and per height.
#[derive(Debug, Clone, Copy)]
struct End {
    rib: i64,
    place: f64,
    widths: [f64; 2],
    height: f64,
}

pub(super) fn read(text: &str) -> Result<Vec<Piece>, ReadFault> {
    let sections = Sections::new(text);
    let mut section = sections.get(12, "H V and VH ribs")?;
    let count = section.count()?;
    if count == 0 {
        return Ok(Vec::new());
    }
    section.numbers(2)?;
    (0..count)
        .map(|_| {
            let row = section.numbers(8)?;
            let kind = row[1] as usize;
            // Of kinds that are not known nothing is.
            let known = (STRAP..=GENERAL).contains(&(kind % PER_CHORD)) && kind < 2 * PER_CHORD;
            let kind = if known { kind } else { 0 };
            let numbers = row[2..].to_vec();
            let least = if kind % PER_CHORD == GENERAL { 10 } else { 8 };
            if numbers.len() < least {
                return Err(
                    section.fault(&row.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
                );
            }
            Ok(Piece { kind, numbers })
        })
        .collect()
}

/// Puts the pieces; says what is left out. True where the file tells of them: the plan needs no usual diagonals then.
pub(super) fn derive(
    pieces: &Result<Vec<Piece>, ReadFault>,
    (drawing, scale_m): (&Drawing, f64),
    keys: &mut Keys,
    left_out: &mut Vec<String>,
) -> bool {
    let pieces = match pieces {
        Ok(pieces) => pieces,
        Err(fault) => {
            left_out.push(format!(
                "V- and H-ribs: {fault}; usual diagonals stand in their place"
            ));
            return false;
        }
    };
    let mut all = Vec::new();
    let mut lost = 0;
    for piece in pieces {
        for ends in piece.ends(drawing, scale_m) {
            match ends.and_then(|ends| written(drawing, ends)) {
                Some(ends) => all.push(ends),
                None => lost += 1,
            }
        }
    }
    let count = |is: &dyn Fn(&Piece) -> bool| pieces.iter().filter(|piece| is(piece)).count();
    let continuous = count(&|piece| piece.kind % PER_CHORD == CONTINUOUS);
    if continuous > 0 {
        left_out.push(format!(
            "holes of the continuous V-ribs in {continuous} lines of section 12: here a V-rib with straight edges stands on every anchor, and they meet at the upper seam"
        ));
    }
    let leaning = count(&|piece| {
        [PARTIAL, ON_TWO].contains(&(piece.kind % PER_CHORD))
            && ![0.0, UPRIGHT_DEG].contains(&piece.numbers[7])
    });
    if leaning > 0 {
        left_out.push(format!(
            "the lean of the upper edges of {leaning} V-ribs: here they run at one height over the lower seam"
        ));
    }
    if lost > 0 {
        left_out.push(format!(
            "{lost} V- and H-ribs lead to an anchor or a rib that is not there, or past a neighbour, or are of an unknown kind"
        ));
    }
    let any = !all.is_empty();
    if any {
        keys.set("structure.wing.vh_ribs", all, "section 12");
    }
    any || pieces.is_empty()
}

/// As the plan has it; `None` where the ribs are no neighbours, or there is no room.
fn written(drawing: &Drawing, ends: [End; 2]) -> Option<Value> {
    let first = i64::from(drawing.has_middle_rib());
    // The rib on the other side of a cell in the middle has no number of its own in the file, either.
    let ribs = ends.map(|end| end.rib - first);
    if ribs[0].abs_diff(ribs[1]) != 1 {
        return None;
    }
    let heights = ends.map(|end| {
        if end.height <= ON_SEAM[0] {
            0.0
        } else if end.height >= ON_SEAM[1] {
            1.0
        } else {
            end.height
                .clamp(*HEIGHTS_BETWEEN_SEAMS.start(), *HEIGHTS_BETWEEN_SEAMS.end())
        }
    });
    let [one, other] = [0, 1].map(|k| {
        let (end, on_seam) = (ends[k], heights[k] == 0.0 || heights[k] == 1.0);
        let [before, behind] = end.widths.map(|width| width.max(NARROWEST));
        let [from, to] = [end.place - before, end.place + behind];
        let allowed = if on_seam {
            0.0..=1.0
        } else {
            PLACES_BETWEEN_SEAMS
        };
        let places = [from, to].map(|place| place.clamp(*allowed.start(), *allowed.end()));
        (places[1] > places[0]).then(|| Value::from(places.map(Value::from).to_vec()))
    });
    let (one, other) = (one?, other?);
    Some(Value::Table(Table::from_iter([
        (
            "ribs".to_owned(),
            Value::from(ribs.map(Value::from).to_vec()),
        ),
        ("between".to_owned(), Value::from(vec![one, other])),
        (
            "heights".to_owned(),
            Value::from(heights.map(Value::from).to_vec()),
        ),
    ])))
}

impl Piece {
    /// Ends of what it is sewn of; `None` where an anchor or a rib is not there.
    fn ends(&self, drawing: &Drawing, scale_m: f64) -> Vec<Option<[End; 2]>> {
        let numbers = &self.numbers;
        // Numbers of ribs and rows are small; what is not leads nowhere.
        let whole = |number: usize| numbers[number].clamp(-1e6, 1e6) as i64;
        // A whole V-rib may say so by a mark of its own.
        let per_chord = self.kind > PER_CHORD || (self.kind == FULL && numbers[6] == 1.0);
        // Widths in centimetres of the drawing, or per cent of the chord.
        let width = |number: usize, rib: i64| {
            let chord_m = scale_m * chord(drawing, rib)?;
            Some(if per_chord {
                0.01 * numbers[number]
            } else {
                numbers[number] * CENTIMETRE_M * drawing.scale / chord_m
            })
        };
        // About the anchor of a row.
        let about = |rib: i64, row: i64, number: usize, height: f64| {
            let width = width(number, rib)?;
            let place = anchor(drawing, rib, row)?;
            Some(End {
                rib,
                place,
                widths: [width; 2],
                height,
            })
        };
        let both = |one: Option<End>, other: Option<End>| Some([one?, other?]);
        let (rib, row) = (whole(0), whole(1));
        // To the middle and to the tip, where they are asked for.
        let sides = [(2, rib - 1), (3, rib + 1)];
        let asked = || sides.into_iter().filter(|(flag, _)| whole(*flag) == 1);
        match self.kind % PER_CHORD {
            STRAP => {
                let other = about(whole(2), whole(3), 4, 0.0);
                vec![both(about(rib, row, 4, 0.0), other)]
            }
            kind @ (PARTIAL | FULL) => {
                let height = if kind == FULL { 1.0 } else { 0.01 * numbers[6] };
                asked()
                    .map(|(_, to)| both(about(rib, row, 4, 0.0), about(to, row, 5, height)))
                    .collect()
            }
            ON_TWO => {
                let upper = |at| about(at, row, 5, 0.01 * numbers[6]);
                let mut pieces = vec![both(upper(rib), upper(rib + 1))];
                for (flag, at, foot) in [(2, rib, rib - 1), (3, rib + 1, rib + 2)] {
                    if whole(flag) == 1 {
                        pieces.push(both(about(foot, row, 4, 0.0), upper(at)));
                    }
                }
                pieces
            }
            CONTINUOUS => {
                let head = |to| {
                    Some(End {
                        widths: to_neighbours(drawing, to, row)?,
                        ..about(to, row, 7, 1.0)?
                    })
                };
                asked()
                    .map(|(_, to)| both(about(rib, row, 7, 0.0), head(to)))
                    .collect()
            }
            GENERAL => {
                let end = |first: usize| {
                    let rib = whole(first);
                    Some(End {
                        rib,
                        place: 0.01 * numbers[first + 1],
                        // Backward first.
                        widths: [width(first + 4, rib)?, width(first + 3, rib)?],
                        height: 0.01 * numbers[first + 2],
                    })
                };
                vec![both(end(0), end(5))]
            }
            _ => vec![None],
        }
    }
}

/// Number of the rib of the file that stands for another: that on the other side of a cell in the middle is the first one.
fn index(drawing: &Drawing, rib: i64) -> Option<usize> {
    let number = if rib == 0 && !drawing.has_middle_rib() {
        1
    } else {
        rib
    };
    usize::try_from(number - 1)
        .ok()
        .filter(|index| *index < drawing.ribs.len())
}

/// Chord of a rib, in units of the drawing.
fn chord(drawing: &Drawing, rib: i64) -> Option<f64> {
    let rib = &drawing.ribs[index(drawing, rib)?];
    Some(rib.edges[1] - rib.edges[0])
}

/// Place of an anchor, per chord.
fn anchor(drawing: &Drawing, rib: i64, row: i64) -> Option<f64> {
    let anchors = &drawing.ribs[index(drawing, rib)?].anchors;
    let place = anchors.get(usize::try_from(row - 1).ok()?)?;
    (*place > 0.0).then_some(0.01 * place)
}

/// From an anchor to the middle between it and the one before, and the one behind; as far to where there is none as to the other.
fn to_neighbours(drawing: &Drawing, rib: i64, row: i64) -> Option<[f64; 2]> {
    let here = anchor(drawing, rib, row)?;
    let to = |row| anchor(drawing, rib, row).map(|other| 0.5 * (other - here).abs());
    let (before, behind) = (to(row - 1), to(row + 1));
    let any = before.or(behind)?;
    Some([before.unwrap_or(any), behind.unwrap_or(any)])
}
