//! Checkpoints: the whole state of a run in one file, so that a resumed run continues with the same bits.
//!
//! Layout, little-endian: magic, format version, identity (hash of the physics, and precision), who computed it, then sections
//! `name length · name · data length · CRC-32 · data`, and a trailer that proves the file is whole. Files are written beside
//! their final place, synced and renamed; the one before is kept as `checkpoint.previous`, and taken where the newer one is damaged.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytemuck::Pod;

use crate::output::{OutputError, write_atomically};

const MAGIC: [u8; 8] = *b"RIPSTOP\0";
const TRAILER: [u8; 8] = *b"WHOLE\0\0\0";
const VERSION: u32 = 6;

/// Name of the file in a run's folder.
pub const FILE_NAME: &str = "checkpoint";

/// Name of the one before.
const PREVIOUS_NAME: &str = "checkpoint.previous";

/// A complete checkpoint about to take its place.
const NEXT_NAME: &str = "checkpoint.next";

/// The state at the end of a run.
pub const FINAL_NAME: &str = "final.checkpoint";

/// All of them, newest first: the next one is left where a run was killed just before it took its place, and a run that goes on after its end
/// begins with the final one.
pub const NAMES: [&str; 4] = [NEXT_NAME, FILE_NAME, PREVIOUS_NAME, FINAL_NAME];

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// There is none, or it cannot be read.
    #[error(
        "cannot read the checkpoint {path}: {cause}; begin anew, with --overwrite in place of --resume"
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: io::Error,
    },
    /// It is damaged, cut short, or no checkpoint.
    #[error(
        "the checkpoint {path} cannot be used: {what}; begin anew, with --overwrite in place of --resume"
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// It belongs to other physics, or another precision.
    #[error(
        "the checkpoint {path} belongs to another run ({found}, this is {expected}); give the same case, --variant, --set and --precision"
    )]
    OtherRun {
        /// The file.
        path: PathBuf,
        /// Identity in the file.
        found: String,
        /// Identity of this run.
        expected: String,
    },
}

/// Writes sections.
pub struct Writer<'a> {
    out: &'a mut dyn Write,
    /// Before the name of every section.
    prefix: String,
}

impl Writer<'_> {
    /// Adds a section.
    pub fn put<T: Pod>(&mut self, name: &str, data: &[T]) -> io::Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let name = format!("{}{name}", self.prefix);
        self.out.write_all(&(name.len() as u32).to_le_bytes())?;
        self.out.write_all(name.as_bytes())?;
        self.out.write_all(&(bytes.len() as u64).to_le_bytes())?;
        self.out.write_all(&crc32fast::hash(bytes).to_le_bytes())?;
        self.out.write_all(bytes)
    }

    /// Writes sections whose names begin with `prefix`, for [`Reader::within`].
    pub fn within(&mut self, prefix: &str) -> Writer<'_> {
        Writer {
            prefix: format!("{}{prefix}", self.prefix),
            out: &mut *self.out,
        }
    }

    /// Adds sections that [`sections`] has made; of two with one name the later one counts.
    pub fn put_all(&mut self, sections: &[u8]) -> io::Result<()> {
        self.out.write_all(sections)
    }
}

/// Sections in memory, for checkpoints that are written later.
pub fn sections(fill: impl FnOnce(&mut Writer) -> io::Result<()>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    fill(&mut Writer {
        out: &mut bytes,
        prefix: String::new(),
    })?;
    Ok(bytes)
}

/// Writes a checkpoint into `folder`; `fill` adds the sections.
pub fn write(
    folder: &Path,
    identity: &str,
    fill: impl FnOnce(&mut Writer) -> io::Result<()>,
) -> Result<(), OutputError> {
    let path = folder.join(FILE_NAME);
    // Complete before the older ones are touched: what is read on the way may fail.
    let next = folder.join(NEXT_NAME);
    write_atomically(&next, |out| {
        out.write_all(&MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        let mut writer = Writer {
            out,
            prefix: String::new(),
        };
        writer.put("identity", identity.as_bytes())?;
        fill(&mut writer)?;
        writer.put::<u8>("end", &TRAILER)
    })?;
    if path.exists() {
        // Losing the older of two checkpoints is no reason to fail.
        let _ = std::fs::rename(&path, folder.join(PREVIOUS_NAME));
    }
    std::fs::rename(&next, &path).map_err(|error| OutputError::new("replace", &path, error))
}

/// Makes the newest checkpoint of a run that is over the final one, and removes the others.
///
/// # Errors
///
/// When the file cannot be renamed.
pub fn keep_final(folder: &Path) -> Result<(), OutputError> {
    let path = folder.join(FINAL_NAME);
    std::fs::rename(folder.join(FILE_NAME), &path)
        .map_err(|error| OutputError::new("replace", &path, error))?;
    for name in [PREVIOUS_NAME, NEXT_NAME] {
        // There may be none.
        let _ = std::fs::remove_file(folder.join(name));
    }
    Ok(())
}

/// Removes all checkpoints of a run.
pub fn remove(folder: &Path) {
    for name in NAMES {
        // There may be none.
        let _ = std::fs::remove_file(folder.join(name));
    }
}

/// True if `folder` holds a checkpoint, usable or not.
#[must_use]
pub fn exists(folder: &Path) -> bool {
    NAMES.iter().any(|name| folder.join(name).exists())
}

/// All sections of a checkpoint.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    sections: Arc<HashMap<String, Vec<u8>>>,
    /// Before the name of every section.
    prefix: String,
}

/// A checkpoint to go on from.
#[derive(Debug)]
pub struct Found {
    /// Its sections.
    pub reader: Reader,
    /// Why newer ones in the folder could not be used.
    pub passed_over: Vec<String>,
}

/// Reads and verifies the newest usable checkpoint in `folder`.
pub fn open(folder: &Path, identity: &str) -> Result<Found, CheckpointError> {
    let mut passed_over = Vec::new();
    let mut first_error = None;
    for name in NAMES {
        let path = folder.join(name);
        match Reader::open(&path, identity) {
            Ok(reader) => {
                return Ok(Found {
                    reader,
                    passed_over,
                });
            }
            Err(CheckpointError::Unreadable { cause, .. })
                if cause.kind() == io::ErrorKind::NotFound => {}
            Err(error) => {
                passed_over.push(match &error {
                    CheckpointError::Damaged { what, .. } => format!("{name} is not used: {what}"),
                    _ => format!("{name} is not used: {error}"),
                });
                first_error.get_or_insert(error);
            }
        }
    }
    Err(first_error.unwrap_or_else(|| CheckpointError::Unreadable {
        path: folder.join(FILE_NAME),
        cause: io::ErrorKind::NotFound.into(),
    }))
}

impl Reader {
    fn open(path: &Path, identity: &str) -> Result<Self, CheckpointError> {
        let path = path.to_owned();
        let unreadable = |cause: io::Error| CheckpointError::Unreadable {
            path: path.clone(),
            cause,
        };
        let damaged = |what: &str| CheckpointError::Damaged {
            path: path.clone(),
            what: what.to_owned(),
        };
        let file = File::open(&path).map_err(unreadable)?;
        let total = file.metadata().map_err(unreadable)?.len();
        let mut input = BufReader::new(file);
        let mut magic = [0; 8];
        let mut version = [0; 4];
        input
            .read_exact(&mut magic)
            .and_then(|()| input.read_exact(&mut version))
            .map_err(|_| damaged("it is cut short"))?;
        if magic != MAGIC {
            return Err(damaged("it is no checkpoint of this program"));
        }
        match u32::from_le_bytes(version) {
            VERSION => {}
            newer if newer > VERSION => {
                return Err(damaged("a newer version of the program wrote it"));
            }
            _ => return Err(damaged("an older version of the program wrote it")),
        }
        let mut sections = HashMap::new();
        while !sections.contains_key("end") {
            let (name, data) = read_section(&mut input, total).map_err(|what| damaged(&what))?;
            sections.insert(name, data);
        }
        let reader = Self {
            path: path.clone(),
            sections: Arc::new(sections),
            prefix: String::new(),
        };
        let found =
            String::from_utf8_lossy(reader.sections.get("identity").map_or(&[], Vec::as_slice))
                .into_owned();
        if found != identity {
            return Err(CheckpointError::OtherRun {
                path,
                found,
                expected: identity.to_owned(),
            });
        }
        Ok(reader)
    }

    /// Reads sections whose names begin with `prefix`.
    #[must_use]
    pub fn within(&self, prefix: &str) -> Self {
        Self {
            path: self.path.clone(),
            sections: Arc::clone(&self.sections),
            prefix: format!("{}{prefix}", self.prefix),
        }
    }

    fn name(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// True if there is such a section.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.sections.contains_key(&self.name(name))
    }

    /// A section as numbers.
    pub fn take<T: Pod>(&self, name: &str) -> Result<Vec<T>, CheckpointError> {
        let name = &self.name(name);
        let bytes = self
            .sections
            .get(name)
            .ok_or_else(|| self.damaged(format!("section `{name}` is missing")))?;
        if bytes.len() % size_of::<T>() != 0 {
            return Err(self.damaged(format!("section `{name}` has a wrong length")));
        }
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    /// A section of exactly `length` numbers.
    pub fn take_exactly<T: Pod>(
        &self,
        name: &str,
        length: usize,
    ) -> Result<Vec<T>, CheckpointError> {
        let values = self.take(name)?;
        if values.len() == length {
            Ok(values)
        } else {
            Err(self.damaged(format!(
                "section `{name}` has {} entries instead of {length}",
                values.len()
            )))
        }
    }

    /// An error about this file.
    #[must_use]
    pub fn damaged(&self, what: String) -> CheckpointError {
        CheckpointError::Damaged {
            path: self.path.clone(),
            what,
        }
    }
}

fn read_section(input: &mut impl Read, total: u64) -> Result<(String, Vec<u8>), String> {
    let short = |_| "it is cut short".to_owned();
    let mut word = [0; 4];
    let mut long = [0; 8];
    input.read_exact(&mut word).map_err(short)?;
    let name_length = u64::from(u32::from_le_bytes(word));
    if name_length > 64 {
        return Err("a section has no sensible name".to_owned());
    }
    let mut name = vec![0; name_length as usize];
    input.read_exact(&mut name).map_err(short)?;
    let name = String::from_utf8(name).map_err(|_| "a section has no sensible name".to_owned())?;
    input.read_exact(&mut long).map_err(short)?;
    input.read_exact(&mut word).map_err(short)?;
    let length = u64::from_le_bytes(long);
    if length > total {
        return Err(format!("section `{name}` is longer than the file"));
    }
    let mut data = vec![0; length as usize];
    input.read_exact(&mut data).map_err(short)?;
    if crc32fast::hash(&data) != u32::from_le_bytes(word) {
        return Err(format!("section `{name}` does not match its checksum"));
    }
    Ok((name, data))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(folder: &Path) {
        write(folder, "case-f32", |out| {
            out.put("numbers", &[1.0_f64, f64::NAN, -0.0])?;
            out.put("flags", &[7_u64])
        })
        .unwrap();
    }

    #[test]
    fn sections_come_back_with_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        sample(folder.path());
        sample(folder.path());
        assert!(folder.path().join(PREVIOUS_NAME).exists());
        let reader = open(folder.path(), "case-f32").unwrap().reader;
        let bits: Vec<u64> = reader
            .take::<f64>("numbers")
            .unwrap()
            .iter()
            .map(|v| v.to_bits())
            .collect();
        assert_eq!(bits, [1.0_f64, f64::NAN, -0.0].map(f64::to_bits));
        assert!(reader.take_exactly::<u64>("flags", 2).is_err());
        assert!(reader.take::<u64>("absent").is_err());
        remove(folder.path());
        assert!(matches!(
            open(folder.path(), "case-f32"),
            Err(CheckpointError::Unreadable { .. })
        ));
    }

    /// Sections can be made before the checkpoint, and what has changed since is put behind them.
    #[test]
    fn the_later_of_two_sections_counts() {
        let folder = tempfile::tempdir().unwrap();
        let before = sections(|out| {
            out.put("number", &[1_u64])?;
            out.put("other", &[2_u64])
        })
        .unwrap();
        write(folder.path(), "this", |out| {
            out.put_all(&before)?;
            out.put("number", &[3_u64])
        })
        .unwrap();
        let reader = open(folder.path(), "this").unwrap().reader;
        let of = |name| reader.take_exactly::<u64>(name, 1).unwrap()[0];
        assert_eq!([of("number"), of("other")], [3, 2]);
    }

    /// The one before is taken where the newest is damaged, another program's, newer than this program or another run's; a complete one
    /// that had not taken its place yet is the newest.
    #[test]
    fn the_newest_usable_one_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let put = |identity: &str, number: u64| {
            write(folder.path(), identity, |out| out.put("number", &[number])).unwrap();
        };
        let number = || {
            let found = open(folder.path(), "this").unwrap();
            (
                found.reader.take::<u64>("number").unwrap()[0],
                found.passed_over.join(""),
            )
        };
        put("this", 1);
        put("this", 2);
        let path = folder.path().join(FILE_NAME);
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(number(), (2, String::new()));
        for (at, value, why) in [
            (0, b'X', "no checkpoint of this program"),
            (8, 99, "newer version"),
            (8, 0, "older version"),
            (whole.len() - 1, 7, "checksum"),
        ] {
            let mut broken = whole.clone();
            broken[at] = value;
            std::fs::write(&path, &broken).unwrap();
            let (number, passed_over) = number();
            assert_eq!(number, 1, "byte {at}");
            assert!(passed_over.contains(why), "{passed_over}");
        }
        std::fs::remove_file(&path).unwrap();
        assert_eq!(number(), (1, String::new()));
        std::fs::write(folder.path().join(NEXT_NAME), &whole).unwrap();
        assert_eq!(number(), (2, String::new()));
        std::fs::remove_file(folder.path().join(NEXT_NAME)).unwrap();
        put("other", 3);
        put("this", 4);
        put("other", 5);
        let (number, passed_over) = number();
        assert_eq!(number, 4);
        assert!(passed_over.contains("another run"), "{passed_over}");
        put("other", 6);
        assert!(matches!(
            open(folder.path(), "this"),
            Err(CheckpointError::OtherRun { .. })
        ));
    }

    /// Every single flipped or missing byte is noticed.
    #[test]
    fn damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        sample(folder.path());
        let path = folder.path().join(FILE_NAME);
        let whole = std::fs::read(&path).unwrap();
        for byte in 0..whole.len() {
            let mut broken = whole.clone();
            broken[byte] ^= 0x10;
            std::fs::write(&path, &broken).unwrap();
            let usable = open(folder.path(), "case-f32")
                .map(|found| found.reader)
                .is_ok_and(|r| r.take::<f64>("numbers").is_ok() && r.take::<u64>("flags").is_ok());
            assert!(!usable, "byte {byte}");
            std::fs::write(&path, &whole[..byte]).unwrap();
            assert!(open(folder.path(), "case-f32").is_err(), "cut at {byte}");
        }
        std::fs::write(&path, &whole).unwrap();
        assert!(matches!(
            open(folder.path(), "case-f64"),
            Err(CheckpointError::OtherRun { .. })
        ));
    }
}
