//! The history of a run: a CSV file that grows by one row per sample.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::atomic::{OutputError, invalid_data, write_atomically};

/// Rows after which the file is brought up to date.
const FLUSH_ROWS: usize = 64;

/// Time after which the next row brings the file up to date.
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);

/// Writes a CSV file with one row per sample.
///
/// Names of columns carry their SI unit (`time_s`, `drag_n`). Numbers are written with as many
/// digits as reading them back exactly takes; NaN is an empty field, infinity is `inf` or `-inf`.
///
/// Rows are gathered and appended at least every 64 rows, and by the first row that comes more than
/// a second after the last flush, so the file can be watched. How complete it is:
///
/// - After [`HistoryWriter::finish`] it holds every row and is synchronised to the disk.
/// - After an error it holds whole rows only: what was written of the last batch is cut off. The
///   batch stays in memory and is tried again by the next flush, so after freeing disk space
///   nothing is missing and nothing is there twice.
/// - After a killed process it holds whole rows up to the last flush, unless the kill hit a flush
///   the system was carrying out in parts; after a power failure the last line may be torn too, so
///   a reader should ignore a last line without a line end.
/// - Dropping the writer without `finish` flushes as well, but cannot report an error.
#[derive(Debug)]
pub struct HistoryWriter {
    path: PathBuf,
    file: File,
    columns: usize,
    /// Length of the whole rows in the file, in bytes.
    length: u64,
    /// Whole rows not yet in the file.
    pending: Vec<u8>,
    pending_rows: usize,
    last_flush: Instant,
    /// The last flush failed: the next one waits, for it costs as much as there are rows.
    failed: bool,
}

impl HistoryWriter {
    /// Starts a history with the header `columns`, replacing the one of an earlier run.
    ///
    /// # Errors
    ///
    /// When there are no columns, two have the same name, or the file cannot be written.
    pub fn create(path: &Path, columns: &[&str]) -> Result<Self, OutputError> {
        let fail = |cause| OutputError::new("write", path, cause);
        let mut seen = HashSet::new();
        if columns.is_empty() || !columns.iter().all(|column| seen.insert(column)) {
            let message = format!("the columns {columns:?} are not distinct names");
            return Err(fail(invalid_data(message)));
        }
        let header = csv_line(columns.iter()).map_err(fail)?;
        // A new file, so whoever still reads the old one is not disturbed.
        write_atomically(path, |out| out.write_all(&header))?;
        let file = OpenOptions::new().write(true).open(path).map_err(fail)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            columns: columns.len(),
            length: header.len() as u64,
            pending: Vec::new(),
            pending_rows: 0,
            last_flush: Instant::now(),
            failed: false,
        })
    }

    /// Adds a row: one number per column, in the units the header names.
    ///
    /// # Errors
    ///
    /// When the number of values is wrong (the row is then dropped), or when the rows gathered so
    /// far cannot be written (they are then kept; see [`HistoryWriter`]).
    pub fn push(&mut self, row: &[f64]) -> Result<(), OutputError> {
        self.gather(row).map_err(|cause| self.error(cause))?;
        let many = self.pending_rows >= FLUSH_ROWS && !self.failed;
        if many || self.last_flush.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    /// Brings the file up to date with all rows pushed so far.
    ///
    /// # Errors
    ///
    /// When the rows cannot be written; the file then ends with the last row that was there before.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        self.last_flush = Instant::now();
        let appended = self.append_pending();
        self.failed = appended.is_err();
        if let Err(cause) = appended {
            // Cut off the part of the rows that got through. Should even that fail, the next flush
            // overwrites it.
            let _ = self.file.set_len(self.length);
            return Err(self.error(cause));
        }
        self.length += self.pending.len() as u64;
        self.pending.clear();
        self.pending_rows = 0;
        Ok(())
    }

    /// Writes what is left and synchronises the file to the disk.
    ///
    /// # Errors
    ///
    /// When the file could not be completed.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.flush()?;
        self.file.sync_all().map_err(|cause| self.error(cause))
    }

    fn gather(&mut self, row: &[f64]) -> io::Result<()> {
        if row.len() != self.columns {
            let (found, expected) = (row.len(), self.columns);
            let message = format!("a row has {found} values for {expected} columns");
            return Err(invalid_data(message));
        }
        let line = csv_line(row.iter().map(|&value| field(value)))?;
        self.pending.extend_from_slice(&line);
        self.pending_rows += 1;
        Ok(())
    }

    fn append_pending(&mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.length))?;
        self.file.write_all(&self.pending)
    }

    fn error(&self, cause: io::Error) -> OutputError {
        OutputError::new("write", &self.path, cause)
    }
}

impl Drop for HistoryWriter {
    fn drop(&mut self) {
        // Whoever wants to know of errors calls `finish`, after which nothing is left to do here.
        let _ = self.flush();
    }
}

/// One value as text; the shortest that reads back as the same number.
pub(super) fn field(value: f64) -> String {
    if value.is_nan() {
        String::new()
    } else {
        format!("{value:?}")
    }
}

/// One line of CSV with its line end.
fn csv_line<T: AsRef<[u8]>>(fields: impl Iterator<Item = T>) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(fields)?;
    writer.into_inner().map_err(|failed| failed.into_error())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn rows(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let header = reader
            .headers()
            .unwrap()
            .iter()
            .map(str::to_owned)
            .collect();
        let rows = reader.records().map(|record| {
            let record = record.unwrap();
            let value = |field: &str| match field {
                "" => f64::NAN,
                number => number.parse().unwrap(),
            };
            record.iter().map(value).collect()
        });
        (header, rows.collect())
    }

    #[test]
    fn numbers_read_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.csv");
        fs::write(&path, "an earlier run, longer than this one\n".repeat(99)).unwrap();
        let mut history = HistoryWriter::create(&path, &["time_s", "drag, total_n"]).unwrap();
        let samples = [
            [0.0, f64::NAN],
            [0.1 + 0.2, -1e-300],
            [1e300, f64::INFINITY],
            [f64::MIN_POSITIVE, -0.0],
        ];
        for row in &samples {
            history.push(row).unwrap();
        }
        history.finish().unwrap();
        let (header, read) = rows(&path);
        assert_eq!(header, ["time_s", "drag, total_n"]);
        assert_eq!(read.len(), samples.len());
        for (read, row) in read.iter().zip(&samples) {
            let bits = |row: &[f64]| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(read), bits(row));
        }
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("\n0.0,\n") && text.ends_with('\n'));
    }

    #[test]
    fn rows_show_while_the_run_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.csv");
        let mut history = HistoryWriter::create(&path, &["time_s"]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "time_s\n");
        for row in 0..FLUSH_ROWS + 1 {
            history.push(&[row as f64]).unwrap();
        }
        assert!(rows(&path).1.len() >= FLUSH_ROWS);
        drop(history);
        assert_eq!(rows(&path).1.len(), FLUSH_ROWS + 1);
    }

    #[test]
    fn a_row_of_the_wrong_length_is_refused_and_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.csv");
        let mut history = HistoryWriter::create(&path, &["time_s", "drag_n"]).unwrap();
        let error = history.push(&[1.0]).unwrap_err();
        assert!(error.to_string().contains("1 values for 2 columns"));
        history.push(&[1.0, 2.0]).unwrap();
        history.finish().unwrap();
        assert_eq!(rows(&path).1, [[1.0, 2.0]]);
        assert!(HistoryWriter::create(&path, &["time_s", "time_s"]).is_err());
        assert!(HistoryWriter::create(&path, &[]).is_err());
    }

    #[test]
    fn a_failed_flush_keeps_the_rows_for_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.csv");
        let mut history = HistoryWriter::create(&path, &["time_s"]).unwrap();
        history.push(&[1.0]).unwrap();
        history.flush().unwrap();
        // A handle that cannot write stands in for a full disk.
        let broken = File::open(&path).unwrap();
        let working = std::mem::replace(&mut history.file, broken);
        history.push(&[2.0]).unwrap();
        assert!(history.flush().is_err());
        assert_eq!(rows(&path).1, [[1.0]]);
        history.file = working;
        history.push(&[3.0]).unwrap();
        history.finish().unwrap();
        assert_eq!(rows(&path).1, [[1.0], [2.0], [3.0]]);
    }
}
