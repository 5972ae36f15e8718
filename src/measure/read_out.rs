//! What a column of the history, and the result of the same name, is.

use crate::case::Scene;

/// One read-out of what is known as `Of` at a sample.
pub(super) struct ReadOut<Of> {
    /// Its name, unit included.
    pub(super) name: &'static str,
    /// SI unit, `1` for a plain number.
    pub(super) unit: &'static str,
    /// What it is, for notes of results.
    pub(super) meaning: &'static str,
    /// In which scenes.
    pub(super) when: fn(&Scene) -> bool,
    /// Its value; NaN where there is none.
    pub(super) how: fn(&Of) -> f64,
}

/// Those of a table that a scene has.
pub(super) fn of_scene<'a, Of>(
    table: &'a [ReadOut<Of>],
    scene: &'a Scene,
) -> impl Iterator<Item = &'a ReadOut<Of>> {
    table.iter().filter(|row| (row.when)(scene))
}

/// Names of the columns of a table.
pub(super) fn columns<Of>(table: &[ReadOut<Of>], scene: &Scene) -> Vec<String> {
    of_scene(table, scene)
        .map(|row| row.name.to_owned())
        .collect()
}
