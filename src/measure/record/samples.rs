//! Rows of numbers, kept in blocks: the newest in memory, older ones in a file where a run has a folder. Memory does not grow with the run.
//!
//! A block holds [`BLOCK_ROWS`] rows, column after column, so that one column is read without the others. The file only grows, by whole blocks;
//! a checkpoint holds the rows of the block begun, how many blocks the file has, and their CRC-32.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Rows of a block.
pub(super) const BLOCK_ROWS: usize = 256;

/// Name of the file in a run's folder.
pub const SAMPLES_FILE: &str = "samples.f64";

/// The rows.
#[derive(Debug, Default)]
pub(super) struct Samples {
    width: usize,
    /// Rows that are in no block yet.
    recent: Vec<f64>,
    /// Whole blocks, column after column, of a record without a file.
    kept: Vec<f64>,
    file: Option<Blocks>,
    last: Vec<f64>,
    /// A block could not be read back; its rows count as not known.
    unreadable: AtomicBool,
}

/// Blocks in a file.
#[derive(Debug)]
struct Blocks {
    file: File,
    path: PathBuf,
    count: usize,
    checksum: crc32fast::Hasher,
}

impl Samples {
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            ..Self::default()
        }
    }

    /// Rows so far.
    pub(super) fn len(&self) -> usize {
        self.block_count() * BLOCK_ROWS + self.recent.len() / self.width.max(1)
    }

    pub(super) fn last(&self) -> Option<&[f64]> {
        (!self.last.is_empty()).then_some(&self.last)
    }

    /// True where a block could not be read back.
    pub(super) fn unreadable(&self) -> bool {
        self.unreadable.load(Ordering::Relaxed)
    }

    fn block_values(&self) -> usize {
        BLOCK_ROWS * self.width
    }

    fn block_count(&self) -> usize {
        let in_file = self.file.as_ref().map_or(0, |blocks| blocks.count);
        in_file + self.kept.len() / self.block_values().max(1)
    }

    /// Adds a row. A disk that is full keeps nothing from being added: the rows wait in memory for [`Samples::flush`].
    pub(super) fn push(&mut self, row: Vec<f64>) {
        self.recent.extend_from_slice(&row);
        self.last = row;
        if self.recent.len() >= self.block_values() {
            // Tried again with the next row, and reported by the next checkpoint.
            let _ = self.flush();
        }
    }

    /// Begins a file in a folder for the blocks to come, in place of one that is there.
    pub(super) fn keep_in(&mut self, folder: &Path) -> io::Result<()> {
        let path = folder.join(SAMPLES_FILE);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&path)?;
        self.file = Some(Blocks {
            file,
            path,
            count: 0,
            checksum: crc32fast::Hasher::new(),
        });
        Ok(())
    }

    /// Moves whole blocks out of the rows in memory.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        let values = self.block_values();
        while values > 0 && self.recent.len() >= values {
            let mut block: Vec<f64> = Vec::with_capacity(values);
            for column in 0..self.width {
                block.extend(
                    self.recent[..values]
                        .iter()
                        .skip(column)
                        .step_by(self.width),
                );
            }
            match &mut self.file {
                None => self.kept.extend(block),
                Some(blocks) => blocks.append(bytemuck::cast_slice(&block))?,
            }
            self.recent.drain(..values);
        }
        Ok(())
    }

    /// One column.
    pub(super) fn column(&self, column: usize) -> Vec<f64> {
        let mut found = Vec::with_capacity(self.len());
        for block in 0..self.block_count() {
            self.extend_by(&mut found, block, column * BLOCK_ROWS, BLOCK_ROWS);
        }
        found.extend(self.recent.iter().skip(column).step_by(self.width.max(1)));
        found
    }

    /// All rows, one block at a time in memory.
    pub(super) fn rows(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        let blocks = (0..self.block_count()).flat_map(move |block| {
            let mut values = Vec::with_capacity(self.block_values());
            self.extend_by(&mut values, block, 0, self.block_values());
            (0..BLOCK_ROWS).map(move |row| {
                let of_row = values.iter().skip(row).step_by(BLOCK_ROWS);
                of_row.copied().collect()
            })
        });
        let recent = self.recent.chunks_exact(self.width.max(1));
        blocks.chain(recent.map(<[f64]>::to_vec))
    }

    /// Appends `count` values of a block, from `first` on; not a number where the file cannot be read.
    fn extend_by(&self, found: &mut Vec<f64>, block: usize, first: usize, count: usize) {
        let from = block * self.block_values() + first;
        let Some(blocks) = &self.file else {
            found.extend_from_slice(&self.kept[from..from + count]);
            return;
        };
        let before = found.len();
        found.resize(before + count, f64::NAN);
        if blocks.read(from, &mut found[before..]).is_err() {
            found[before..].fill(f64::NAN);
            self.unreadable.store(true, Ordering::Relaxed);
        }
    }

    /// What a checkpoint must hold: the rows that are in no block, the newest row, and blocks with the CRC-32 of their bytes.
    pub(super) fn for_checkpoint(&mut self) -> io::Result<(&[f64], &[f64], [u64; 2])> {
        self.flush()?;
        let in_file = match &mut self.file {
            None => [0, 0],
            Some(blocks) => {
                blocks.file.sync_data()?;
                let checksum = blocks.checksum.clone().finalize();
                [blocks.count as u64, u64::from(checksum)]
            }
        };
        Ok((&self.recent, &self.last, in_file))
    }

    /// Blocks kept in memory, for the checkpoint of a record without a file.
    pub(super) fn kept(&self) -> &[f64] {
        &self.kept
    }

    /// Goes on from a checkpoint: `folder` holds the file, which must begin with the blocks that the checkpoint names; what is behind them is cut
    /// off. An error says what is wrong.
    pub(super) fn restore(
        &mut self,
        (kept, recent, last): (Vec<f64>, Vec<f64>, Vec<f64>),
        [count, checksum]: [u64; 2],
        folder: &Path,
    ) -> Result<(), String> {
        self.kept = kept;
        self.recent = recent;
        self.last = last;
        let path = folder.join(SAMPLES_FILE);
        let wrong = |what: &str| format!("{} {what}", path.display());
        let open = |create| {
            OpenOptions::new()
                .read(true)
                .write(true)
                .create(create)
                .truncate(false)
                .open(&path)
                .map_err(|cause| wrong(&format!("cannot be opened: {cause}")))
        };
        let file = open(count == 0)?;
        let mut blocks = Blocks {
            file,
            path: path.clone(),
            count: 0,
            checksum: crc32fast::Hasher::new(),
        };
        let mut bytes = vec![0; 8 * self.block_values()];
        for _ in 0..count {
            let read = blocks.file.read_exact(&mut bytes);
            read.map_err(|_| wrong("is shorter than the checkpoint says"))?;
            blocks.checksum.update(&bytes);
            blocks.count += 1;
        }
        if count > 0 && u64::from(blocks.checksum.clone().finalize()) != checksum {
            return Err(wrong("is not what the checkpoint says was written"));
        }
        let cut = blocks.file.set_len(count * bytes.len() as u64);
        cut.map_err(|cause| wrong(&format!("cannot be cut: {cause}")))?;
        self.file = Some(blocks);
        Ok(())
    }
}

impl Blocks {
    /// Writes a block behind the others; a part of one that could not be written whole is written over by the next try.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let at = (self.count * bytes.len()) as u64;
        let mut file = &self.file;
        file.seek(SeekFrom::Start(at))?;
        file.write_all(bytes).map_err(|cause| {
            io::Error::new(cause.kind(), format!("{}: {cause}", self.path.display()))
        })?;
        self.checksum.update(bytes);
        self.count += 1;
        Ok(())
    }

    fn read(&self, from: usize, values: &mut [f64]) -> io::Result<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(8 * from as u64))?;
        file.read_exact(bytemuck::cast_slice_mut(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 3;

    fn row(i: usize) -> Vec<f64> {
        (0..WIDTH).map(|c| (i * 10 + c) as f64).collect()
    }

    fn filled(samples: &mut Samples, rows: std::ops::Range<usize>) {
        for i in rows {
            samples.push(row(i));
        }
    }

    fn assert_holds(samples: &Samples, count: usize) {
        assert_eq!(samples.len(), count);
        for column in 0..WIDTH {
            let expected: Vec<f64> = (0..count).map(|i| row(i)[column]).collect();
            assert_eq!(samples.column(column), expected);
        }
        assert!(samples.rows().eq((0..count).map(row)));
        assert_eq!(samples.last(), Some(&row(count - 1)[..]));
        assert!(!samples.unreadable());
    }

    #[test]
    fn rows_come_back_from_memory_and_from_a_file() {
        let count = 3 * BLOCK_ROWS + 17;
        let mut in_memory = Samples::new(WIDTH);
        filled(&mut in_memory, 0..count);
        assert_holds(&in_memory, count);
        let folder = tempfile::tempdir().unwrap();
        let mut in_file = Samples::new(WIDTH);
        in_file.keep_in(folder.path()).unwrap();
        filled(&mut in_file, 0..count);
        assert_holds(&in_file, count);
        assert_eq!(in_file.recent.len(), 17 * WIDTH);
    }

    #[test]
    fn a_checkpoint_is_gone_on_from_and_what_came_after_it_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let at_checkpoint = 2 * BLOCK_ROWS + 5;
        let mut first = Samples::new(WIDTH);
        first.keep_in(folder.path()).unwrap();
        filled(&mut first, 0..at_checkpoint);
        let (recent, last, in_file) = first.for_checkpoint().unwrap();
        let stored = (Vec::new(), recent.to_vec(), last.to_vec());
        filled(&mut first, at_checkpoint..5 * BLOCK_ROWS);
        drop(first);
        let mut second = Samples::new(WIDTH);
        second
            .restore(stored.clone(), in_file, folder.path())
            .unwrap();
        assert_holds(&second, at_checkpoint);
        filled(&mut second, at_checkpoint..4 * BLOCK_ROWS);
        assert_holds(&second, 4 * BLOCK_ROWS);
        drop(second);
        // A byte changed, and a file that is too short.
        let path = folder.path().join(SAMPLES_FILE);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[100] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        let mut third = Samples::new(WIDTH);
        let why = third.restore(stored.clone(), in_file, folder.path());
        assert!(why.unwrap_err().contains("not what the checkpoint says"));
        std::fs::write(&path, &bytes[..1000]).unwrap();
        let why = third.restore(stored, in_file, folder.path());
        assert!(why.unwrap_err().contains("shorter"));
    }

    #[test]
    fn what_cannot_be_read_is_not_a_number() {
        let folder = tempfile::tempdir().unwrap();
        let mut samples = Samples::new(WIDTH);
        samples.keep_in(folder.path()).unwrap();
        filled(&mut samples, 0..BLOCK_ROWS + 2);
        OpenOptions::new()
            .write(true)
            .open(folder.path().join(SAMPLES_FILE))
            .unwrap()
            .set_len(10)
            .unwrap();
        let column = samples.column(1);
        assert!(column[..BLOCK_ROWS].iter().all(|v| v.is_nan()));
        assert_eq!(
            column[BLOCK_ROWS..],
            [row(BLOCK_ROWS)[1], row(BLOCK_ROWS + 1)[1]]
        );
        assert!(samples.unreadable());
    }
}
