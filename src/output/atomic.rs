//! Files that appear whole or not at all, and errors that say what to do.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::folder::files_of_run;

/// How names of temporary files begin and end.
const TEMPORARY: [&str; 2] = [".ripstop-", ".tmp"];

/// Bytes gathered before they go to the operating system.
const BUFFER_BYTES: usize = 256 * 1024;

/// A file or folder that could not be written.
///
/// The message is one complete sentence: what failed, the path, the cause and a remedy. The cause
/// is part of the message and therefore *not* repeated as [`std::error::Error::source`]; use
/// [`OutputError::cause`] to inspect it.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}: {cause}; {}", path.display(), advice(cause))]
pub struct OutputError {
    action: &'static str,
    path: PathBuf,
    cause: io::Error,
}

impl OutputError {
    /// Error for `action` (an infinitive, such as `"write"`) on `path`.
    pub(crate) fn new(action: &'static str, path: &Path, cause: io::Error) -> Self {
        let path = path.to_path_buf();
        Self {
            action,
            path,
            cause,
        }
    }

    /// The file or folder concerned.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The underlying error; its kind tells a full disk from a missing permission.
    pub fn cause(&self) -> &io::Error {
        &self.cause
    }

    /// True if room is wanting on the disk, or the number of open files is too large: another attempt may succeed.
    #[must_use]
    pub fn is_no_room(&self) -> bool {
        let full = matches!(
            self.cause.kind(),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge
        );
        // Too many files are open, in the system or in the process.
        let open = cfg!(unix) && matches!(self.cause.raw_os_error(), Some(23 | 24));
        full || open
    }
}

/// What the user can do about `cause`.
fn advice(cause: &io::Error) -> &'static str {
    match cause.kind() {
        ErrorKind::StorageFull => "no space left: free space or choose another folder with --out",
        ErrorKind::QuotaExceeded => {
            "the disk quota is used up: free space or choose another folder with --out"
        }
        ErrorKind::FileTooLarge => {
            "a file size limit was reached: raise it (ulimit -f) or choose another folder with --out"
        }
        ErrorKind::PermissionDenied => {
            "permission is missing: change the folder's permissions or choose another with --out"
        }
        ErrorKind::ReadOnlyFilesystem => {
            "the file system is read-only: choose another folder with --out"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file is in the way: move it or choose another folder with --out"
        }
        ErrorKind::IsADirectory | ErrorKind::DirectoryNotEmpty => {
            "a folder is in the way: move it or choose another folder with --out"
        }
        ErrorKind::NotFound => "the folder does not exist: create it or choose another with --out",
        ErrorKind::InvalidData => {
            "this is a fault in the program, not in your files: please report it"
        }
        _ => "check the disk or choose another folder with --out",
    }
}

/// An error about data that do not fit together, for [`OutputError::new`] or a writing closure.
pub(super) fn invalid_data(message: impl Into<String>) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, message.into())
}

/// Writes `path` as a whole: after an error, or a crash at any moment, `path` holds what it held
/// before.
///
/// `write` fills a buffered temporary file (`.ripstop-*.tmp`) in the same folder, which is flushed,
/// synchronised to the disk and then renamed over `path`. The new file has the permissions of any
/// freshly created file (`0666` less the umask), whatever the old one had; a symbolic link at
/// `path` is replaced, not followed. On an error the temporary file is removed; only a killed
/// process can leave one behind.
///
/// # Errors
///
/// When the temporary file cannot be created, written, flushed or renamed, or when `write` fails.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    replace(path, write).map_err(|cause| OutputError::new("write", path, cause))
}

/// Removes temporary files that killed runs left in `folder`, and in that of its frames.
pub fn remove_leftovers(folder: &Path) {
    for name in files_of_run(folder) {
        let path = folder.join(name);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(TEMPORARY[0]) && name.ends_with(TEMPORARY[1]) {
            // What cannot be removed does no harm.
            let _ = fs::remove_file(&path);
        }
    }
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // The rename would refuse a folder too, but only after all the work.
    if path.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    let mut temporary = temporary_file(folder)?;
    let mut buffer = BufWriter::with_capacity(BUFFER_BYTES, temporary.as_file_mut());
    if let Err(error) = write(&mut buffer) {
        // Take the buffer apart: dropping it would try the disk once more.
        drop(buffer.into_parts());
        return Err(error);
    }
    match buffer.into_inner() {
        Ok(file) => file.sync_all()?,
        Err(failed) => {
            let (error, buffer) = failed.into_parts();
            drop(buffer.into_parts());
            return Err(error);
        }
    }
    temporary
        .persist(path)
        .map(drop)
        .map_err(|failed| failed.error)
}

/// A new file with ordinary permissions, removed when dropped.
fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new()
        .prefix(TEMPORARY[0])
        .suffix(TEMPORARY[1])
        // `tempfile_in` would make the file private (0600); this one respects the umask.
        .make_in(folder, |path| {
            OpenOptions::new().write(true).create_new(true).open(path)
        })
}

/// Creates the folder `path`, with its parents, and proves by a trial file that it can be written.
///
/// Meant for the start of a run, so that an unusable `--out` shows before hours of computing. The
/// trial file is removed again.
///
/// # Errors
///
/// When `path` or one of its parents is a file, when it cannot be created, or when nothing can be
/// written in it.
pub fn prepare_directory(path: &Path) -> Result<(), OutputError> {
    if path.exists() && !path.is_dir() {
        let cause = ErrorKind::NotADirectory.into();
        return Err(OutputError::new("use as output folder", path, cause));
    }
    fs::create_dir_all(path)
        .map_err(|cause| OutputError::new("create output folder", path, cause))?;
    prove_writable(path).map_err(|cause| OutputError::new("write into output folder", path, cause))
}

fn prove_writable(folder: &Path) -> io::Result<()> {
    let mut trial = temporary_file(folder)?;
    trial.as_file_mut().write_all(b"ripstop\n")?;
    trial.as_file_mut().sync_all()?;
    trial.close()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn a_written_file_is_complete_and_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let text = "0123456789".repeat(100_000);
        write_atomically(&path, |out| out.write_all(text.as_bytes())).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failing_closure_leaves_the_old_file_and_no_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let error = write_atomically(&path, |out| {
            out.write_all(b"half of the new te")?;
            Err(ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
        assert_eq!(error.path(), path);
        assert_eq!(error.cause().kind(), ErrorKind::StorageFull);
        let message = error.to_string();
        assert!(message.starts_with(&format!("cannot write {}: ", path.display())));
        assert!(message.ends_with("choose another folder with --out"));
    }

    #[test]
    fn a_target_that_cannot_be_replaced_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing/a.txt");
        let error = write_atomically(&missing, |_| Ok(())).unwrap_err();
        assert_eq!(error.cause().kind(), ErrorKind::NotFound);
        let error = write_atomically(folder.path(), |_| Ok(())).unwrap_err();
        assert_eq!(error.cause().kind(), ErrorKind::IsADirectory);
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, atomic) = (folder.path().join("plain"), folder.path().join("atomic"));
        fs::write(&plain, "").unwrap();
        write_atomically(&atomic, |_| Ok(())).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&atomic), mode(&plain));
    }

    #[test]
    fn an_output_folder_is_created_and_left_empty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er");
        prepare_directory(&path).unwrap();
        prepare_directory(&path).unwrap();
        assert!(names(&path).is_empty());
    }

    #[test]
    fn a_file_in_the_way_of_the_output_folder_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "mine").unwrap();
        for path in [file.clone(), file.join("below")] {
            let error = prepare_directory(&path).unwrap_err();
            assert_eq!(error.cause().kind(), ErrorKind::NotADirectory);
            assert!(error.to_string().contains("a file is in the way"));
        }
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    }
}
