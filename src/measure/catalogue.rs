//! All tables of read-outs, for the documentation and for tests.

use super::read_out::Group;
use super::{
    air, bodies, canopy, canopy_shape, contact, energy, fabric, falling, flown_ballooning,
    imported_wing, line_drag, load_test, opening, payload_bodies, permeable, plate, residual,
    sail_support, shared, solver, supports, wing, wing_trim, wing_walls, wing_wind,
};
use crate::output::ReadOut;

/// Columns of the history with a chart each, where the history has them.
pub static CHARTS: [&ReadOut; 10] = [
    &shared::LIFT_COEFFICIENT,
    &wing_wind::VOLUME_RATIO,
    &wing_wind::REVERSE_FLOW_AREA,
    &shared::DRAG_COEFFICIENT,
    &shared::FORCE_X,
    &shared::PROJECTED_DIAMETER_RATIO,
    &shared::LINE_TENSION_MAX,
    &falling::DESCENT_SPEED,
    &falling::LOAD_FACTOR,
    &canopy_shape::SLOT_WIDTH,
];

/// All tables: those of columns of the history, then those of results.
#[must_use]
pub fn read_out_tables() -> [Vec<Group>; 2] {
    let columns = vec![
        canopy::COLUMNS.group(),
        canopy_shape::COLUMNS.group(),
        canopy_shape::OF_LINE.group(),
        canopy_shape::OF_GORE.group(),
        fabric::IN_WIND.group(),
        plate::COLUMNS.group(),
        wing_wind::COLUMNS.group(),
        wing_wind::OF_ROW.group(),
        wing_wind::OF_PULL.group(),
        wing_wind::PRESSURE_OF_CELL.group(),
        wing_wind::VOLUME_OF_CELL.group(),
        bodies::OF_SCENE.group(),
        bodies::COLUMNS.group(),
        falling::COLUMNS.group(),
        payload_bodies::COLUMNS.group(),
        line_drag::COLUMNS.group(),
        permeable::COLUMNS.group(),
        air::COLUMNS.group(),
        fabric::ALONE.group(),
        supports::COLUMNS.group(),
        contact::COLUMNS.group(),
        energy::COLUMNS.group(),
        residual::COLUMNS.group(),
        solver::COLUMNS.group(),
    ];
    let results = vec![
        shared::RESULTS.group(),
        canopy::RESULTS.group(),
        opening::RESULTS.group(),
        plate::RESULTS.group(),
        bodies::RESULTS.group(),
        falling::RESULTS.group(),
        air::RESULTS.group(),
        fabric::RESULTS.group(),
        wing::RESULTS.group(),
        wing_wind::RESULTS.group(),
        wing_walls::RESULTS.group(),
        wing_trim::RESULTS.group(),
        sail_support::RESULTS.group(),
        flown_ballooning::RESULTS.group(),
        load_test::RESULTS.group(),
        imported_wing::RESULTS.group(),
    ];
    [columns, results]
}

/// The declared result of a name, or the one that covers it, such as `row_{row}_load_n`.
#[must_use]
pub fn declared_result(name: &str) -> Option<ReadOut> {
    let all = declared_results();
    let itself = all.iter().find(|row| row.name == name);
    itself
        .or_else(|| all.iter().find(|row| row.covers(name)))
        .cloned()
}

/// The results that are declared: by themselves, or as what becomes of a column.
#[must_use]
pub fn declared_results() -> Vec<ReadOut> {
    let groups = read_out_tables();
    let rows = groups.iter().flatten().flat_map(Group::results);
    rows.collect()
}
