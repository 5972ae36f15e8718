//! Rows of lines from the paths of the file: one row for every riser, and the brakes.

use toml::{Table, Value};

use super::super::design::Keys;
use super::read::{CENTIMETRE_M, Drawing, Path};

/// Number of the brakes among the rows of the file.
const BRAKES: usize = 6;

/// Names of the rows, by their risers from the nose.
const NAMES: [&str; 5] = ["A", "B", "C", "D", "E"];

/// Places that differ by less than this, over the chord, are one.
const SAME_PLACE: f64 = 0.015;

/// Places of rows at which diagonals have room, over the chord.
const DIAGONALS: std::ops::RangeInclusive<f64> = 0.02..=0.9;

/// Least height of a node over the riser, and distance of nodes above each other, over the height of the row.
const LOWEST: f64 = 0.1;
const APART: f64 = 0.05;

/// An attachment: rib as ours count, place over the chord, and the lines that lead there.
struct Attachment<'a> {
    rib: usize,
    place: f64,
    /// It is not quite where it is drawn.
    is_moved: bool,
    path: &'a Path,
}

/// Puts all rows, with `usual_diagonals` or without; says what the file has and they do not. The names of the risers' rows, from the nose; `None` where a riser has none.
pub(super) fn derive(
    drawing: &Drawing,
    (scale_m, usual_diagonals): (f64, bool),
    keys: &mut Keys,
    left_out: &mut Vec<String>,
) -> Vec<Option<&'static str>> {
    let mut risers_with_rows = Vec::new();
    let mut places: Vec<f64> = Vec::new();
    let (mut lost, mut moved) = (0, 0);
    let rows = NAMES.into_iter().zip(&drawing.plans);
    let brakes = std::iter::once(("brake", &drawing.brakes));
    for (name, paths) in rows.chain(brakes) {
        let mut row: Vec<Attachment> = Vec::new();
        for path in paths {
            let found = attachment(drawing, path, &mut places);
            moved += usize::from(found.as_ref().is_some_and(|one| one.is_moved));
            match found.filter(|new| !row.iter().any(|known| is_same(known, new))) {
                Some(new) => row.push(new),
                None => lost += 1,
            }
        }
        risers_with_rows.push((!row.is_empty()).then_some(name));
        if !row.is_empty() {
            put(drawing, (name, &row), (scale_m, usual_diagonals), keys);
        }
    }
    let between = drawing.brakes.iter().filter(|path| path.rib.fract() != 0.0);
    let between = between.count();
    if between > 0 {
        left_out.push(format!(
            "{between} brake lines end between two ribs: here at the nearer one"
        ));
    }
    if moved > 0 {
        left_out.push(format!(
            "{moved} lines end elsewhere by up to 1.5 % of the chord, or at the rear edge of the intake: places near each other are one here"
        ));
    }
    let risers = drawing.plans.len();
    if risers > NAMES.len() {
        left_out.push(format!("{} of {risers} risers", risers - NAMES.len()));
    }
    if lost > 0 {
        left_out.push(format!(
            "{lost} lines lead to an anchor that is not there, or where another one is"
        ));
    }
    // The last row is that of the brakes.
    risers_with_rows.pop();
    risers_with_rows
}

fn is_same(a: &Attachment, b: &Attachment) -> bool {
    a.rib == b.rib && a.place == b.place
}

/// Where a path leads; `None` where there is no such anchor. Places are those of `known` where they are near one.
fn attachment<'a>(
    drawing: &Drawing,
    path: &'a Path,
    known: &mut Vec<f64>,
) -> Option<Attachment<'a>> {
    let number = path.rib.round() as usize;
    let rib = drawing.ribs.get(number.checked_sub(1)?)?;
    let place = if path.row == BRAKES {
        1.0
    } else {
        let with_lines = &rib.anchors[..rib.anchor_count.min(rib.anchors.len())];
        0.01 * with_lines.get(path.row.checked_sub(1)?)?
    };
    if !(0.01..=1.0).contains(&place) {
        return None;
    }
    let drawn = place;
    // Cells at the tips may be closed there; the plan has one intake for all.
    let place = match drawing.intake() {
        Some([from, to]) if place > from && place < to => to,
        _ => place,
    };
    let near = known
        .iter()
        .find(|other| (place - **other).abs() < SAME_PLACE);
    let place = near.copied().unwrap_or_else(|| {
        known.push(place);
        place
    });
    Some(Attachment {
        rib: number - usize::from(drawing.has_middle_rib()),
        place,
        is_moved: (place - drawn).abs() > 1e-9,
        path,
    })
}

fn put(
    drawing: &Drawing,
    (name, row): (&str, &[Attachment]),
    (scale_m, usual_diagonals): (f64, bool),
    keys: &mut Keys,
) {
    let of = |key: &str| format!("structure.wing.rows.{name}.{key}");
    let is_brake = name == "brake";
    let why = if is_brake {
        "section 10"
    } else {
        "sections 3 and 9"
    };
    // That of most of its attachments.
    let count = |place: f64| row.iter().filter(|one| one.place == place).count();
    let position = row.iter().map(|one| one.place);
    let position = position.max_by_key(|place| count(*place)).unwrap_or(1.0);
    keys.set(of("position"), position, why);
    let ribs: Vec<Value> = row.iter().map(|one| Value::from(one.rib as i64)).collect();
    keys.set(of("ribs"), ribs, why);
    let positions: Vec<Value> = row.iter().map(|one| Value::from(one.place)).collect();
    keys.set(of("positions"), positions, why);
    keys.set(
        of("levels"),
        levels(drawing, is_brake, row, scale_m),
        "sections 9 to 11",
    );
    let riser_m = if is_brake {
        0.3
    } else {
        drawing.riser * CENTIMETRE_M
    };
    keys.set(of("riser_length_m"), riser_m, "section 8");
    keys.set(of("riser_material"), "webbing", "usual");
    if is_brake {
        keys.set(of("trim_m"), 0.1, "brakes hang loose");
    } else if usual_diagonals && DIAGONALS.contains(&position) {
        keys.set(of("diagonals.foot"), 0.02, "usual");
        keys.set(of("diagonals.head"), 0.1, "usual");
    }
}

/// Levels of lines from the sail down: where fewer lines lead to an attachment than to others of the row, the uppermost is divided.
fn levels(drawing: &Drawing, is_brake: bool, row: &[Attachment], scale_m: f64) -> Vec<Value> {
    let most = row.iter().map(|one| one.path.lines.len());
    let most = most.max().unwrap_or(1).max(1);
    // What the line of an attachment is in a level from the sail, told by the orders from the riser up.
    let line = |number: usize, level: usize| {
        let orders = &row[number].path.lines;
        let count = most - level;
        // A divided line is that of its attachment alone.
        let own = if count >= orders.len() {
            number
        } else {
            usize::MAX
        };
        (&orders[..count.min(orders.len())], own)
    };
    let branches = &drawing.branches[usize::from(is_brake)];
    let lengths = if most >= 3 {
        &branches[1]
    } else {
        &branches[0]
    };
    let height_m = drawing.lines * scale_m;
    let mut levels = Vec::new();
    let mut carried: Vec<usize> = (0..row.len()).collect();
    let mut above = 1.0;
    for level in 0..most - 1 {
        // Neighbours that one line carries join; the first of them stands for it below.
        let mut joins: Vec<(i64, usize)> = Vec::new();
        for &number in &carried {
            match joins.last_mut() {
                Some((count, first)) if line(*first, level + 1) == line(number, level + 1) => {
                    *count += 1;
                }
                _ => joins.push((1, number)),
            }
        }
        // Lengths from the sail are written from the lowest node up.
        let from_sail = lengths.len().checked_sub(level + 1).map(|k| lengths[k]);
        let usual = 1.0 - (level + 1) as f64 / most as f64;
        let height = from_sail.map_or(usual, |length| 1.0 - length * scale_m / height_m);
        let height = height.min(above - APART).max(LOWEST);
        above = height;
        let counts: Vec<Value> = joins.iter().map(|(count, _)| Value::from(*count)).collect();
        levels.push(Value::Table(Table::from_iter([
            ("material".to_owned(), Value::from("gallery")),
            ("joins".to_owned(), Value::from(counts)),
            ("height".to_owned(), Value::from(height)),
        ])));
        carried = joins.into_iter().map(|(_, first)| first).collect();
    }
    let main = ("material".to_owned(), Value::from("main"));
    levels.push(Value::Table(Table::from_iter([main])));
    levels
}
