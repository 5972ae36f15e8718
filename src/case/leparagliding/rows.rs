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

/// Foremost place of an attachment, over the chord.
const FOREMOST: f64 = 0.01;

/// Places of rows at which diagonals have room, over the chord.
const DIAGONALS: std::ops::RangeInclusive<f64> = 0.02..=0.9;

/// Least weight of an attachment: means of such that carry nothing are those of their places.
const LEAST_WEIGHT: f64 = 1e-6;

/// Control parameter of section 9 by which lines point to the mean of the loads.
const BY_LOAD: i64 = 3;

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
    let (mut lost, mut moved): (Vec<String>, usize) = (Vec::new(), 0);
    let rows = NAMES.into_iter().zip(&drawing.plans);
    let brakes = std::iter::once(("brake", &drawing.brakes));
    for (name, paths) in rows.chain(brakes) {
        let mut row: Vec<Attachment> = Vec::new();
        for path in paths {
            let found = attachment(drawing, path, &mut places);
            moved += usize::from(found.as_ref().is_some_and(|one| one.is_moved));
            match found.filter(|new| !row.iter().any(|known| is_same(known, new))) {
                Some(new) => row.push(new),
                None => lost.push(format!("to row {} of rib {}", path.row, path.rib)),
            }
        }
        risers_with_rows.push((!row.is_empty()).then_some(name));
        if !row.is_empty() {
            put(
                drawing,
                (name, &row),
                (scale_m, usual_diagonals),
                keys,
                left_out,
            );
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
    if !(0..=BY_LOAD).contains(&drawing.aim) {
        left_out.push(format!(
            "what lines point to by the control parameter {} of section 9: here to the mean of the attachments",
            drawing.aim
        ));
    }
    if drawing.brakes_are_spread {
        left_out.push("the brake distribution of section 10: brakes are drawn without".to_owned());
    }
    let risers = drawing.plans.len();
    if risers > NAMES.len() {
        left_out.push(format!("{} of {risers} risers", risers - NAMES.len()));
    }
    if !lost.is_empty() {
        left_out.push(format!(
            "lines that lead to an anchor that is not there, or where another one is: {}",
            lost.join(", ")
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
    if !(0.0..=1.0).contains(&place) {
        return None;
    }
    let drawn = place;
    let place = place.max(FOREMOST);
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
    left_out: &mut Vec<String>,
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
    if drawing.aim == BY_LOAD && !is_brake {
        let weights: Option<Vec<f64>> = row.iter().map(|one| weight(drawing, one.path)).collect();
        if let Some(weights) = weights {
            let weights: Vec<Value> = weights.into_iter().map(Value::from).collect();
            let why = "sections 9 and 18: what lines point to";
            keys.set(of("weights"), weights, why);
        } else {
            left_out.push(format!(
                "loads that lines of row {name} point to: section 18 does not tell them; they point to the mean of the attachments"
            ));
        }
    }
    keys.set(
        of("levels"),
        levels(drawing, is_brake, row, scale_m),
        "sections 9 to 11",
    );
    let (riser_m, riser_material, why) = if is_brake {
        // The main line begins where the last riser ends.
        let length_m = drawing.brake_main * scale_m + drawing.riser * CENTIMETRE_M;
        (length_m, "main", "main line and riser, sections 10 and 8")
    } else {
        (drawing.riser * CENTIMETRE_M, "webbing", "section 8")
    };
    keys.set(of("riser_length_m"), riser_m, why);
    keys.set(of("riser_material"), riser_material, "usual");
    if is_brake {
        keys.set(of("trim_m"), 0.1, "brakes hang loose");
    } else if usual_diagonals && DIAGONALS.contains(&position) {
        keys.set(of("diagonals.foot"), 0.02, "usual");
        keys.set(of("diagonals.head"), 0.1, "usual");
    }
}

/// Weight of an attachment where lines point to the mean of the loads; `None` where section 18 does not tell it.
fn weight(drawing: &Drawing, path: &Path) -> Option<f64> {
    let number = (path.rib.round() as usize).checked_sub(1)?;
    let rib = drawing.ribs.get(number)?;
    let chord = rib.edges[1] - rib.edges[0];
    let by_chord = chord / (drawing.ribs[0].edges[1] - drawing.ribs[0].edges[0]);
    let share = match rib.anchor_count {
        0 | 1 => 1.0,
        rows => 0.01 * drawing.row_shares.get(rows - 2)?.get(path.row - 1)?,
    };
    Some((by_chord * rib.weight * share).max(LEAST_WEIGHT))
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
    let ways = &drawing.branches[usize::from(is_brake)];
    // Way to the sail of the node below a level of an attachment's path.
    let way_m = |number: usize, level: usize| {
        let lines = row[number].path.lines.len();
        let divided = most - lines;
        let ways = match lines {
            2 => &ways[0][..],
            3 => &ways[1][..],
            _ => &[],
        };
        // Ways are written from the lowest node up.
        let of_node = |node: usize| Some(ways.get(ways.len().checked_sub(node + 1)?)? * scale_m);
        if level >= divided
            && let Some(way) = of_node(level - divided)
        {
            return way;
        }
        // Its uppermost line is divided evenly.
        let whole = of_node(0).unwrap_or(drawing.lines * scale_m);
        whole * (level + 1) as f64 / (divided + 1) as f64
    };
    let mut levels = Vec::new();
    let mut carried: Vec<usize> = (0..row.len()).collect();
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
        let counts: Vec<Value> = joins.iter().map(|(count, _)| Value::from(*count)).collect();
        let ways: Vec<Value> = joins
            .iter()
            .map(|(_, first)| Value::from(way_m(*first, level)))
            .collect();
        levels.push(Value::Table(Table::from_iter([
            ("material".to_owned(), Value::from("gallery")),
            ("joins".to_owned(), Value::from(counts)),
            ("to_sail_m".to_owned(), Value::from(ways)),
        ])));
        carried = joins.into_iter().map(|(_, first)| first).collect();
    }
    let main = ("material".to_owned(), Value::from("main"));
    levels.push(Value::Table(Table::from_iter([main])));
    levels
}
