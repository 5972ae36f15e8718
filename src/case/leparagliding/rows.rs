//! Rows of lines from the paths of the file.

use toml::{Table, Value};

use super::super::design::Keys;
use super::read::{Drawing, Path};
use super::{CENTIMETRE_M, has_middle_rib};

/// Number of the brakes among the rows of the file.
const BRAKES: usize = 6;

/// Names of the rows, by their numbers from 1.
const NAMES: [&str; 6] = ["A", "B", "C", "D", "E", "brake"];

/// Least height of a node over the riser, and distance of nodes above each other, over the height of the row.
const LOWEST: f64 = 0.1;
const APART: f64 = 0.05;

/// Row of the plan: its lines end at anchors of one row, whichever riser they begin at.
struct Row<'a> {
    number: usize,
    /// Riser and path of every anchor, and its rib as ours count.
    paths: Vec<(usize, &'a Path, usize)>,
}

pub(super) fn derive(drawing: &Drawing, scale_m: f64, keys: &mut Keys, left_out: &mut Vec<String>) {
    let mut strangers = 0;
    let mut between = 0;
    for number in 1..=NAMES.len() {
        let mut row = Row {
            number,
            paths: Vec::new(),
        };
        let plans = drawing.plans.iter().enumerate();
        let all = plans.flat_map(|(plan, paths)| paths.iter().map(move |path| (plan, path)));
        let brakes = drawing.brakes.iter().map(|path| (usize::MAX, path));
        for (plan, path) in all.chain(brakes).filter(|(_, path)| path.row == number) {
            // Plans are numbered as their rows are.
            strangers += usize::from(plan != usize::MAX && plan + 1 != number);
            between += usize::from(path.rib.fract() != 0.0);
            if let Some(rib) = our_rib(drawing, path.rib) {
                row.paths.push((plan, path, rib));
            }
        }
        row.paths.sort_by_key(|(_, _, rib)| *rib);
        row.paths.dedup_by_key(|(_, _, rib)| *rib);
        if !row.paths.is_empty() {
            put(drawing, &row, scale_m, keys);
        }
    }
    if strangers > 0 {
        left_out.push(format!(
            "{strangers} lines lead to an anchor of another row than their riser's: here every row has its own riser"
        ));
    }
    if between > 0 {
        left_out.push(format!(
            "{between} brake lines end between two ribs: here at the nearer one"
        ));
    }
}

/// Number of a rib as ours count; `None` of one that is not there.
fn our_rib(drawing: &Drawing, rib: f64) -> Option<usize> {
    let nearest = rib.round() as usize;
    if nearest == 0 || nearest > drawing.ribs.len() {
        return None;
    }
    Some(nearest - usize::from(has_middle_rib(drawing)))
}

/// The place of a row that most of its ribs have, over the chord.
fn position(drawing: &Drawing, row: &Row) -> f64 {
    if row.number == BRAKES {
        return 1.0;
    }
    let first = usize::from(!has_middle_rib(drawing));
    let ribs = row
        .paths
        .iter()
        .map(|(_, _, rib)| &drawing.ribs[rib - first]);
    let mut places: Vec<f64> = ribs
        .filter_map(|rib| rib.anchors.get(row.number - 1).copied())
        .collect();
    places.sort_by(f64::total_cmp);
    0.01 * places.get(places.len() / 2).copied().unwrap_or(50.0)
}

fn put(drawing: &Drawing, row: &Row, scale_m: f64, keys: &mut Keys) {
    let name = NAMES[row.number - 1];
    let of = |key: &str| format!("structure.wing.rows.{name}.{key}");
    let is_brake = row.number == BRAKES;
    keys.set(of("position"), position(drawing, row), "section 3");
    let ribs: Vec<Value> = (row.paths.iter())
        .map(|(_, _, rib)| Value::from(*rib as i64))
        .collect();
    let why = if is_brake { "section 10" } else { "section 9" };
    keys.set(of("ribs"), ribs, why);
    let levels = levels(drawing, row, scale_m);
    keys.set(of("levels"), levels, "sections 9 to 11");
    let riser_m = if is_brake {
        0.3
    } else {
        drawing.riser * CENTIMETRE_M
    };
    keys.set(of("riser_length_m"), riser_m, "section 8");
    keys.set(of("riser_material"), "webbing", "usual");
    if is_brake {
        keys.set(of("trim_m"), 0.1, "brakes hang loose");
    } else {
        keys.set(of("diagonals.foot"), 0.02, "usual");
        keys.set(of("diagonals.head"), 0.1, "usual");
    }
}

/// Levels of lines from the sail down: where fewer lines lead to an anchor than to others of the row, the uppermost is divided.
fn levels(drawing: &Drawing, row: &Row, scale_m: f64) -> Vec<Value> {
    let most = row.paths.iter().map(|(_, path, _)| path.lines.len());
    let most = most.max().unwrap_or(1).max(1);
    // What the line of a path is in a level from the sail, told by the orders from the riser up.
    let key = |(plan, path, rib): &(usize, &Path, usize), level: usize| {
        let own = path.lines.len();
        let below = most - 1 - level;
        let orders: Vec<usize> = path.lines.iter().take(below + 1).copied().collect();
        // A divided line is that of its anchor alone.
        let anchor = if below + 1 >= own { *rib } else { usize::MAX };
        (*plan, orders, anchor)
    };
    let branches = &drawing.branches[usize::from(row.number == BRAKES)];
    let lengths = if most >= 3 {
        &branches[1]
    } else {
        &branches[0]
    };
    let height_m = drawing.lines * scale_m;
    let mut levels = Vec::new();
    let mut carried: Vec<_> = row.paths.iter().collect();
    let mut above = 1.0;
    for level in 0..most - 1 {
        let mut joins: Vec<(i64, _)> = Vec::new();
        for path in &carried {
            let below = key(path, level + 1);
            match joins.last_mut() {
                Some((count, known)) if *known == below => *count += 1,
                _ => joins.push((1, below)),
            }
        }
        // The first of every group stands for it in the next level.
        let mut next = Vec::new();
        let mut at = 0;
        for (count, _) in &joins {
            next.push(carried[at]);
            at += *count as usize;
        }
        // Lengths from the sail are written from the lowest node up.
        let from_sail = lengths.len().checked_sub(level + 1).map(|k| lengths[k]);
        let usual = 1.0 - (level + 1) as f64 / most as f64;
        let height = from_sail.map_or(usual, |length| 1.0 - length * scale_m / height_m);
        let height = height.clamp(LOWEST, above - APART);
        above = height;
        let counts: Vec<Value> = joins.iter().map(|(count, _)| Value::from(*count)).collect();
        levels.push(Value::Table(Table::from_iter([
            ("material".to_owned(), Value::from("gallery")),
            ("joins".to_owned(), Value::from(counts)),
            ("height".to_owned(), Value::from(height)),
        ])));
        carried = next;
    }
    let main = ("material".to_owned(), Value::from("main"));
    levels.push(Value::Table(Table::from_iter([main])));
    levels
}
