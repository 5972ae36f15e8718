//! ParaView collections: which file shows which instant.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::atomic::{OutputError, invalid_data, write_atomically};
use super::xml::escaped;

/// One instant of a [`Pvd`] collection.
#[derive(Debug, Clone, PartialEq)]
pub struct PvdEntry {
    /// Simulated time in seconds.
    pub time_s: f64,
    /// File of that instant, relative to the collection's folder, `/` between folders.
    pub file_name: String,
}

/// A `.pvd` file, rewritten atomically whenever an instant is added, so ParaView can open or reload
/// it while the run goes on.
#[derive(Debug)]
pub struct Pvd {
    path: PathBuf,
    entries: Vec<PvdEntry>,
}

impl Pvd {
    /// Starts an empty collection and writes it, replacing the one of an earlier run.
    ///
    /// # Errors
    ///
    /// When the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let collection = Self {
            path: path.to_path_buf(),
            entries: Vec::new(),
        };
        collection.write()?;
        Ok(collection)
    }

    /// Adds the instant `time_s` (seconds), shown by `file_name` (relative to the collection's folder),
    /// and rewrites the file. Write the file it names first.
    ///
    /// # Errors
    ///
    /// When the time is not finite or the file cannot be written; the instant is then not added.
    pub fn append(&mut self, time_s: f64, file_name: &str) -> Result<(), OutputError> {
        if !time_s.is_finite() {
            let cause = invalid_data(format!("the time of {file_name} is {time_s}"));
            return Err(OutputError::new("write", &self.path, cause));
        }
        let file_name = file_name.to_owned();
        self.entries.push(PvdEntry { time_s, file_name });
        let written = self.write();
        if written.is_err() {
            self.entries.pop();
        }
        written
    }

    /// The instants so far, in the order they were added.
    pub fn entries(&self) -> &[PvdEntry] {
        &self.entries
    }

    /// Where the collection is written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn write(&self) -> Result<(), OutputError> {
        write_atomically(&self.path, |out| out.write_all(self.to_xml().as_bytes()))
    }

    fn to_xml(&self) -> String {
        let mut xml = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for PvdEntry { time_s, file_name } in &self.entries {
            let file = escaped(file_name);
            // Writing to a string cannot fail.
            let _ = writeln!(
                xml,
                "<DataSet timestep=\"{time_s:?}\" group=\"\" part=\"0\" file=\"{file}\"/>"
            );
        }
        xml.push_str("</Collection>\n</VTKFile>\n");
        xml
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn every_append_leaves_a_whole_collection() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("canopy.pvd");
        fs::write(&path, "an earlier run").unwrap();
        let mut pvd = Pvd::create(&path).unwrap();
        let empty = fs::read_to_string(&path).unwrap();
        assert!(empty.contains("<Collection>\n</Collection>"));
        pvd.append(0.0, "canopy_0000.vtp").unwrap();
        pvd.append(0.125, "a&\"b\".vtp").unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("timestep=\"0.0\" group=\"\" part=\"0\" file=\"canopy_0000.vtp\"/>"));
        assert!(text.contains("timestep=\"0.125\""));
        assert!(text.contains("file=\"a&amp;&quot;b&quot;.vtp\"/>"));
        assert!(text.ends_with("</VTKFile>\n"));
        assert_eq!(pvd.entries().len(), 2);
    }

    #[test]
    fn a_failed_append_is_not_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).unwrap();
        let mut pvd = Pvd::create(&inner.join("flow.pvd")).unwrap();
        assert!(pvd.append(f64::NAN, "flow_0000.vti").is_err());
        fs::remove_dir_all(&inner).unwrap();
        assert!(pvd.append(0.0, "flow_0000.vti").is_err());
        assert!(pvd.entries().is_empty());
    }
}
