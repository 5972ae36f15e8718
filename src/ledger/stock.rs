//! Which files lie in a folder, how long they are, and what their checksums are.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::output::files_of_run;

/// Bytes read at a time.
const BLOCK_BYTES: usize = 256 * 1024;

/// A file of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Its name in the run's folder.
    pub name: String,
    /// Its length.
    pub bytes: u64,
    /// CRC-32 of its content, in hexadecimal.
    pub crc32: String,
    /// When it was changed last, if this process has looked at it.
    #[serde(skip)]
    changed: Option<SystemTime>,
}

impl FileEntry {
    /// Compares it with what lies in `folder` now.
    ///
    /// # Errors
    ///
    /// What is wrong with the file there, as the end of a sentence about it.
    pub fn verify(&self, folder: &Path) -> Result<(), String> {
        let path = folder.join(&self.name);
        match fs::metadata(&path) {
            Ok(found) if found.len() != self.bytes => {
                return Err(format!("has {} bytes of {}", found.len(), self.bytes));
            }
            Ok(_) => {}
            Err(_) => return Err("is not there".to_owned()),
        }
        match checksum(&path) {
            Ok(found) if found == self.crc32 => Ok(()),
            Ok(_) => Err("does not match its checksum".to_owned()),
            Err(error) => Err(format!("cannot be read: {error}")),
        }
    }
}

/// CRC-32 of a file, in hexadecimal.
pub(super) fn checksum(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = crc32fast::Hasher::new();
    let mut block = vec![0; BLOCK_BYTES];
    loop {
        match file.read(&mut block) {
            Ok(0) => return Ok(format!("{:08x}", hasher.finalize())),
            Ok(length) => hasher.update(&block[..length]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Lists the files in a run's folder, frames included, whose names are `ours`, by name. Files that have not changed since `earlier` are not read again; those that
/// cannot be read are left out.
#[must_use]
pub fn take_stock(
    folder: &Path,
    earlier: &[FileEntry],
    ours: impl Fn(&str) -> bool,
) -> Vec<FileEntry> {
    let mut found = Vec::new();
    for name in files_of_run(folder) {
        if !ours(&name) {
            continue;
        }
        let path = folder.join(&name);
        let Ok(metadata) = fs::metadata(&path) else {
            continue;
        };
        let changed = metadata.modified().ok();
        let known = earlier.binary_search_by(|old| old.name.as_str().cmp(&name));
        let known = known.ok().map(|at| &earlier[at]).filter(|old| {
            old.changed.is_some() && old.changed == changed && old.bytes == metadata.len()
        });
        match known {
            Some(known) => found.push(known.clone()),
            None => {
                if let Ok(crc32) = checksum(&path) {
                    found.push(FileEntry {
                        name,
                        bytes: metadata.len(),
                        crc32,
                        changed,
                    });
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stock_tells_length_and_checksum_and_notices_every_change() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        put("b.csv", "123456789");
        put("a.vtp", "");
        put("foreign.txt", "mine");
        let stock = take_stock(folder.path(), &[], |name| name != "foreign.txt");
        let names: Vec<&str> = stock.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["a.vtp", "b.csv"]);
        // The check value of CRC-32.
        assert_eq!(
            (stock[1].bytes, stock[1].crc32.as_str()),
            (9, "cbf43926"),
            "{stock:?}"
        );
        assert_eq!(stock[1].verify(folder.path()), Ok(()));
        put("b.csv", "123456780");
        let broken = stock[1].verify(folder.path()).unwrap_err();
        assert!(broken.contains("checksum"), "{broken}");
        put("b.csv", "1234");
        let short = stock[1].verify(folder.path()).unwrap_err();
        assert!(short.contains("4 bytes of 9"), "{short}");
        let again = take_stock(folder.path(), &stock, |name| name == "b.csv");
        assert_eq!((again.len(), again[0].bytes), (1, 4));
        fs::remove_file(folder.path().join("b.csv")).unwrap();
        assert_eq!(stock[1].verify(folder.path()).unwrap_err(), "is not there");
    }
}
