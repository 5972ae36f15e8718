//! Checks of a wing's lines: `[structure.wing.line_materials]` and `[structure.wing.rows]`.

use std::collections::BTreeMap;

use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{LINE_DIAMETERS_M, absent, positive, wing_key as key, within};
use crate::geometry::wing::plan::{Diagonals, JoinPlace, LEAST_LINE_M, Level, Row};
use crate::lines::{Cable, CableLaw, ForceStrainTable};

/// Cables by name.
pub(super) type Materials = BTreeMap<String, Cable>;

pub(super) fn check_materials(table: &file::Wing) -> Result<Materials, Problem> {
    let mut materials = Materials::new();
    for (name, written) in &table.line_materials {
        let key = key(&format!("line_materials.{name}"));
        let diameter_m = within(
            &format!("{key}.diameter_m"),
            written.diameter_m,
            LINE_DIAMETERS_M[0],
            LINE_DIAMETERS_M[1],
        )?;
        let mass = positive(
            &format!("{key}.mass_per_length_kg_m"),
            written.mass_per_length_kg_m,
        )?;
        let area_m2 = std::f64::consts::FRAC_PI_4 * diameter_m * diameter_m;
        let law = check_law(&key, written)?;
        let breaking = written
            .breaking_load_n
            .map(|load| positive(&format!("{key}.breaking_load_n"), load))
            .transpose()?;
        let cable = Cable {
            area_m2,
            density_kg_m3: mass / area_m2,
            law,
            damping_n_s: 0.0,
            breaking_load_n: breaking,
        };
        materials.insert(name.clone(), cable);
    }
    Ok(materials)
}

fn check_law(key: &str, written: &file::LineMaterial) -> Result<CableLaw, Problem> {
    let key = |name: &str| format!("{key}.{name}");
    match (written.axial_stiffness_n, &written.force_strain) {
        (Some(stiffness), None) => Ok(CableLaw::Linear {
            axial_stiffness_n: positive(&key("axial_stiffness_n"), stiffness)?,
        }),
        (None, Some(points)) => ForceStrainTable::new(points.clone())
            .map(CableLaw::Table)
            .map_err(|why| {
                Problem::new(
                    key("force_strain"),
                    format!("{} is no force–strain curve: {why}", key("force_strain")),
                    "give points [strain, force in N] that rise, such as [[0.01, 100.0], [0.03, 500.0]]",
                )
            }),
        _ => Err(Problem::new(
            key("axial_stiffness_n"),
            format!(
                "needs exactly one of {} and {}",
                key("axial_stiffness_n"),
                key("force_strain")
            ),
            "keep the stiffness EA of a linear line, or the table of a tensile test",
        )),
    }
}

pub(super) fn material(materials: &Materials, key: &str, name: &str) -> Result<Cable, Problem> {
    materials.get(name).cloned().ok_or_else(|| {
        let known: Vec<&str> = materials.keys().map(String::as_str).collect();
        Problem::new(
            key,
            format!("{key}: there is no line material `{name}`"),
            format!(
                "known are {}; add [structure.wing.line_materials.{name}]",
                known.join(", ")
            ),
        )
    })
}

pub(super) fn check_row(
    table: &file::Wing,
    (name, written): (&String, &file::LineRow),
    materials: &Materials,
) -> Result<Row, Problem> {
    let row_key = key(&format!("rows.{name}"));
    let key = |name: &str| format!("{row_key}.{name}");
    let last = table.cells / 2 + table.cells % 2;
    let grows = written.positions.is_some() || written.ribs.windows(2).all(|p| p[1] > p[0]);
    // A rib in the middle belongs to both halves.
    let first = table.cells % 2;
    let inside = written.ribs.iter().all(|rib| (first..=last).contains(rib));
    if written.ribs.is_empty() || !grows || !inside {
        return Err(Problem::new(
            key("ribs"),
            format!(
                "{} = {:?} is not a list of ribs of the right half",
                key("ribs"),
                written.ribs
            ),
            format!(
                "count ribs from the middle and list them outwards, {first} to {last} (the tip)"
            ),
        ));
    }
    let position = within(&key("position"), written.position, 0.01, 1.0)?;
    if let Some(intakes) = &table.intakes
        && position > intakes.from
        && position < intakes.to
    {
        return Err(Problem::new(
            key("position"),
            format!("{} = {position} lies in the intakes", key("position")),
            "attach lines before or behind them",
        ));
    }
    let positions = check_positions(&key("positions"), table, written)?;
    let weights = check_weights(&key("weights"), written)?;
    let levels = check_levels(&key("levels"), written, materials)?;
    if levels.is_empty() {
        return Err(absent(&key("levels"), "a row has lines"));
    }
    let diagonals = written
        .diagonals
        .as_ref()
        .map(|shape| {
            Ok(Diagonals {
                foot: within(&key("diagonals.foot"), shape.foot, 0.0, 0.3)?,
                head: within(&key("diagonals.head"), shape.head, 0.0, 0.5)?,
            })
        })
        .transpose()?;
    if diagonals.is_some() && !(0.02..=0.9).contains(&position) {
        return Err(Problem::new(
            key("diagonals"),
            format!("diagonals at {position} of the chord have no room"),
            "rows with diagonals lie between 0.02 and 0.9 of the chord",
        ));
    }
    let riser_length_m = positive(&key("riser_length_m"), written.riser_length_m)?;
    let by_bar_m = by_speed_bar_m(table, name)?;
    let by_brakes_m = by_brakes_m(table, written)?;
    let trim_m = usual::or(key("trim_m"), written.trim_m, 0.0) - by_bar_m - by_brakes_m;
    if !(trim_m > -0.9 * riser_length_m && trim_m < 100.0) {
        let taken = [
            (by_bar_m, "the speed bar"),
            (by_brakes_m, "the pull on the brakes"),
        ];
        let taken = taken.iter().filter(|(by_m, _)| *by_m > 0.0);
        let taken: String = taken
            .map(|(by_m, what)| format!("; {what} takes {by_m} m"))
            .collect();
        return Err(Problem::new(
            key("trim_m"),
            format!(
                "{} comes to {trim_m:.4} m, of a riser of {riser_length_m} m{taken}",
                key("trim_m"),
            ),
            "shorten the riser by less than nine tenths, lengthen it by less than 100 m",
        ));
    }
    Ok(Row {
        name: name.clone(),
        position,
        ribs: written.ribs.clone(),
        positions,
        weights,
        levels,
        riser_length_m,
        riser: material(materials, &key("riser_material"), &written.riser_material)?,
        trim_m,
        diagonals,
    })
}

/// Longest way from a node to the sail [m].
const LONGEST_M: f64 = 100.0;

fn check_weights(key: &str, written: &file::LineRow) -> Result<Vec<f64>, Problem> {
    let Some(weights) = &written.weights else {
        return Ok(Vec::new());
    };
    if weights.len() != written.ribs.len() {
        return Err(Problem::new(
            key,
            format!(
                "{key} has {} numbers for {} ribs",
                weights.len(),
                written.ribs.len()
            ),
            "give one number for each rib in `ribs`",
        ));
    }
    let all = weights.iter().map(|weight| positive(key, *weight));
    all.collect()
}

/// Levels of lines, from the sail down.
fn check_levels(
    key: &str,
    written: &file::LineRow,
    materials: &Materials,
) -> Result<Vec<Level>, Problem> {
    let mut carried = written.ribs.len();
    let mut height = 1.0;
    // Ways to the sail from what stands above, by the lines that come down.
    let mut above_m: Vec<f64> = vec![0.0; carried];
    let mut levels = Vec::new();
    for (number, level) in written.levels.iter().enumerate() {
        let is_last = number + 1 == written.levels.len();
        let refuse = |message: String| {
            Err(Problem::new(
                key,
                format!("{key}: level {} {message}", number + 1),
                "list levels from the attachments down; all but the last have `joins` (how many lines join at each node below) and either `height` (share of the way from the riser up, falling) or `to_sail_m` (way from each node to the sail in m, growing), the last has neither",
            ))
        };
        let (joins, place) = match (&level.joins, level.height, &level.to_sail_m) {
            (None, None, None) if is_last => (Vec::new(), JoinPlace::Height(0.0)),
            (Some(joins), Some(at), None) if !is_last => (joins.clone(), JoinPlace::Height(at)),
            (Some(joins), None, Some(ways)) if !is_last => {
                (joins.clone(), JoinPlace::ToSail(ways.clone()))
            }
            _ => return refuse("has the wrong keys".to_owned()),
        };
        let kind = |level: &file::LineLevel| level.to_sail_m.is_some();
        if !is_last && kind(level) != kind(&written.levels[0]) {
            return refuse(
                "has not the kind of place that the first has: all by `height`, or all by `to_sail_m`"
                    .to_owned(),
            );
        }
        if !is_last {
            // None alone may exceed what there is: their sum has to be a number.
            let fits = joins.iter().all(|count| (1..=carried).contains(count));
            if !fits || joins.iter().sum::<usize>() != carried {
                return refuse(format!(
                    "joins {joins:?} lines, but {carried} lines reach it"
                ));
            }
            let ways_m = match &place {
                JoinPlace::Height(at) => {
                    if !(*at > 0.05 && *at < height - 0.02) {
                        return refuse(format!("has height {at}"));
                    }
                    height = *at;
                    vec![0.0; joins.len()]
                }
                JoinPlace::ToSail(ways) => {
                    if ways.len() != joins.len() {
                        return refuse(format!(
                            "has {} ways to the sail for {} nodes",
                            ways.len(),
                            joins.len()
                        ));
                    }
                    ways.clone()
                }
            };
            let mut rest = &above_m[..];
            for (&count, &way_m) in joins.iter().zip(&ways_m) {
                let (own, others) = rest.split_at(count);
                rest = others;
                let least = own.iter().copied().fold(0.0, f64::max) + LEAST_LINE_M;
                let is_given = matches!(place, JoinPlace::ToSail(_));
                if is_given && !(least..LONGEST_M).contains(&way_m) {
                    return refuse(format!(
                        "has a node {way_m} m below the sail, where {least:.3} to {LONGEST_M} m are possible"
                    ));
                }
            }
            above_m = ways_m;
            carried = joins.len();
        }
        levels.push(Level {
            joins,
            place,
            material: level.material.clone(),
            cable: material(materials, key, &level.material)?,
        });
    }
    Ok(levels)
}

/// By how much the speed bar shortens the riser of a row [m].
fn by_speed_bar_m(table: &file::Wing, row: &str) -> Result<f64, Problem> {
    let Some(bar) = &table.speed_bar else {
        return Ok(0.0);
    };
    let bar_key = |name: &str| key(&format!("speed_bar.{name}"));
    let unknown = bar
        .shortening_m
        .keys()
        .find(|name| !table.rows.contains_key(*name));
    if let Some(unknown) = unknown {
        return Err(Problem::new(
            bar_key("shortening_m"),
            format!("there is no row `{unknown}` that the speed bar could shorten"),
            "name rows of [structure.wing.rows]",
        ));
    }
    let used = usual::or(bar_key("used"), bar.used, 0.0);
    let used = within(&bar_key("used"), used, 0.0, 1.0)?;
    let full = bar.shortening_m.get(row).copied().unwrap_or(0.0);
    Ok(used * within(&bar_key("shortening_m"), full, 0.0, 1.0)?)
}

/// A row whose attachments all lie behind this share of the chord is a brake.
const TRAILING_EDGE: f64 = 0.99;

fn is_brake(row: &file::LineRow) -> bool {
    let places = row.positions.as_deref().unwrap_or(&[]);
    let places = if places.is_empty() {
        std::slice::from_ref(&row.position)
    } else {
        places
    };
    places.iter().all(|place| *place >= TRAILING_EDGE)
}

/// By how much the pull on the brakes shortens the riser of a row [m].
fn by_brakes_m(table: &file::Wing, row: &file::LineRow) -> Result<f64, Problem> {
    let pull_m = usual::or(key("brake_pull_m"), table.brake_pull_m, 0.0);
    let pull_m = within(&key("brake_pull_m"), pull_m, 0.0, 2.0)?;
    if table.brake_pull_m.is_some() && !table.rows.values().any(is_brake) {
        return Err(Problem::new(
            key("brake_pull_m"),
            format!(
                "{} needs a row of lines at the trailing edge",
                key("brake_pull_m")
            ),
            "give a row with position = 1.0",
        ));
    }
    Ok(if is_brake(row) { pull_m } else { 0.0 })
}

/// Places of single attachments.
fn check_positions(
    key: &str,
    table: &file::Wing,
    written: &file::LineRow,
) -> Result<Vec<f64>, Problem> {
    let Some(positions) = &written.positions else {
        return Ok(Vec::new());
    };
    let refuse = |why: String, what: &str| Err(Problem::new(key, why, what));
    if positions.len() != written.ribs.len() {
        return refuse(
            format!(
                "{key} has {} places for {} ribs",
                positions.len(),
                written.ribs.len()
            ),
            "give one place for each rib in `ribs`",
        );
    }
    let mut places: Vec<(usize, f64)> = Vec::new();
    for (rib, position) in written.ribs.iter().zip(positions) {
        let position = within(key, *position, 0.01, 1.0)?;
        let in_intake = (table.intakes.as_ref())
            .is_some_and(|intakes| position > intakes.from && position < intakes.to);
        if in_intake || places.contains(&(*rib, position)) {
            return refuse(
                format!("{key}: {position} of rib {rib} lies in the intakes, or is there twice"),
                "attach every line at a place of its own, before or behind the intakes",
            );
        }
        places.push((*rib, position));
    }
    Ok(places.into_iter().map(|(_, place)| place).collect())
}
