//! How a run's folder is laid out.

use std::fs::{self, DirEntry};
use std::path::Path;

/// Folder of frames in a run's folder: what a run writes again and again, beside what a reader looks for.
pub const FRAMES_FOLDER: &str = "frames";

/// Names of all files in a run's folder and in its folder of frames, those with `frames/` before them; sorted. A folder that cannot be read has
/// none.
#[must_use]
pub fn files_of_run(folder: &Path) -> Vec<String> {
    let beside = names_in(folder).into_iter();
    let frames = names_in(&folder.join(FRAMES_FOLDER)).into_iter();
    let mut names: Vec<String> = beside
        .chain(frames.map(|name| format!("{FRAMES_FOLDER}/{name}")))
        .collect();
    names.sort();
    names
}

fn names_in(folder: &Path) -> Vec<String> {
    let is_file = |entry: &DirEntry| entry.metadata().is_ok_and(|found| found.is_file());
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter(is_file)
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_listed_with_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert!(files_of_run(&at("nowhere")).is_empty());
        for name in [FRAMES_FOLDER, "other", "frames/inner"] {
            fs::create_dir(at(name)).unwrap();
        }
        for name in ["z.csv", "frames/b.vtp", "frames/a.vtp", "other/c.vtp"] {
            fs::write(at(name), "").unwrap();
        }
        let names = files_of_run(folder.path());
        assert_eq!(names, ["frames/a.vtp", "frames/b.vtp", "z.csv"]);
    }
}
