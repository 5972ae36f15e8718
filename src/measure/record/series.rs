//! The series themselves.

use std::path::Path;

use super::samples::Samples;
use crate::measure::canopy_shape::CanopyShape;
use crate::measure::impulses::Impulses;
use crate::output::ReadOut;

/// Samples of a run.
#[derive(Debug, Default)]
pub struct Record {
    columns: Vec<ReadOut>,
    /// How many of the columns belong to the history; those behind describe single lines and gores.
    history_columns: usize,
    canopy: Option<CanopyShape>,
    pub(super) samples: Samples,
    /// What the forces since the last sample follow from.
    pub(in crate::measure) impulses: Impulses,
    /// When the run went on on a finer grid; `None` if it never did [s].
    pub(super) grid_changed_s: Option<f64>,
}

impl Record {
    /// An empty record with columns of the history and, behind them, details of a canopy.
    pub(in crate::measure) fn with(
        mut columns: Vec<ReadOut>,
        details: Vec<ReadOut>,
        canopy: Option<CanopyShape>,
    ) -> Self {
        let history_columns = columns.len();
        columns.extend(details);
        Self {
            history_columns,
            samples: Samples::new(columns.len()),
            columns,
            canopy,
            ..Self::default()
        }
    }

    /// Columns of the history.
    #[must_use]
    pub fn columns(&self) -> &[ReadOut] {
        &self.columns[..self.history_columns]
    }

    /// The column that a user names; `None` where the scene does not have it.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&ReadOut> {
        self.columns.iter().find(|column| column.name == name)
    }

    fn place(&self, column: &ReadOut) -> Option<usize> {
        self.columns.iter().position(|own| own.name == column.name)
    }

    /// Whether the scene has a column.
    #[must_use]
    pub fn has(&self, column: &ReadOut) -> bool {
        self.place(column).is_some()
    }

    /// One column, as long as there are samples; not a number where the scene does not have it.
    #[must_use]
    pub fn column(&self, column: &ReadOut) -> Vec<f64> {
        match self.place(column) {
            Some(place) => self.samples.column(place),
            None => vec![f64::NAN; self.sample_count()],
        }
    }

    /// Last value of a column; `None` without samples, or where the scene does not have it.
    #[must_use]
    pub fn latest(&self, column: &ReadOut) -> Option<f64> {
        let place = self.place(column)?;
        self.samples.last().map(|row| row[place])
    }

    /// Time and the columns of single lines and gores, which are not part of the history: names, then rows; `None` without any.
    #[must_use]
    pub fn details(&self) -> Option<(Vec<&str>, impl Iterator<Item = Vec<f64>>)> {
        let [time, ..] = self.columns() else {
            return None;
        };
        let own = &self.columns[self.history_columns..];
        (!own.is_empty()).then(|| {
            let names = std::iter::once(time).chain(own);
            let rows = self.samples.rows().map(move |row| {
                let own = row[self.history_columns..].iter().copied();
                std::iter::once(row[0]).chain(own).collect()
            });
            (names.map(|column| &*column.name).collect(), rows)
        })
    }

    /// Parts of the canopy, where there is one in air.
    pub(in crate::measure) const fn canopy(&self) -> Option<&CanopyShape> {
        self.canopy.as_ref()
    }

    /// A row of zeros.
    pub(in crate::measure) fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.columns.len()]
    }

    /// Adds a row, which holds a value for every column, and returns what of it belongs to the history.
    pub(in crate::measure) fn push(&mut self, row: Vec<f64>) -> &[f64] {
        debug_assert_eq!(row.len(), self.columns.len(), "a value for every column");
        self.samples.push(row);
        let newest = self.samples.last().unwrap_or_default();
        &newest[..self.history_columns.min(newest.len())]
    }

    /// The run goes on on a finer grid: what comes settles anew.
    pub const fn grid_changes(&mut self, time_s: f64) {
        self.grid_changed_s = Some(time_s);
    }

    /// When the run went on on a finer grid, if it did [s].
    #[must_use]
    pub const fn grid_changed_s(&self) -> Option<f64> {
        self.grid_changed_s
    }

    /// Samples so far.
    #[must_use]
    pub fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// Rows of the history, oldest first.
    pub fn history_rows(&self) -> impl Iterator<Item = Vec<f64>> {
        self.samples.rows().map(|mut row| {
            row.truncate(self.history_columns);
            row
        })
    }

    /// From now on older samples are kept in a file of that folder instead of in memory.
    pub fn keep_in(&mut self, folder: &Path) -> std::io::Result<()> {
        self.samples.keep_in(folder)
    }

    /// True where samples could not be read back from that file: they count as not known.
    #[must_use]
    pub fn unreadable(&self) -> bool {
        self.samples.unreadable()
    }
}
