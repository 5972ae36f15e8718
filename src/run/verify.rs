//! Whether what a checkpoint says was written is still there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::written::Written;
use crate::ledger::{FileEntry, Ledger};

/// Most files that a note names.
const TOLD: usize = 8;

/// Files that a run wrote and that are not as it wrote them.
#[derive(Debug, Default)]
pub(super) struct Lost {
    /// What is wrong with each, by name.
    files: BTreeMap<String, String>,
}

impl Lost {
    /// Looks at every file that `written` tells of; length and checksum are compared where the ledger knows them.
    pub(super) fn find(folder: &Path, written: &Written, ledger: Option<&Ledger>) -> Self {
        let listed = ledger.map_or(&[][..], |ledger| &ledger.files);
        let known: BTreeMap<&str, &FileEntry> = listed
            .iter()
            .map(|entry| (entry.name.as_str(), entry))
            .collect();
        let mut names: BTreeSet<String> = written.names().into_iter().collect();
        // Further pictures of the same instant, and further lattices.
        let further =
            (known.keys()).filter(|name| written.has_picture(name) || written.has_flow(name));
        names.extend(further.map(|name| (*name).to_owned()));
        let wrong = |name: &String| match known.get(name.as_str()) {
            Some(entry) => entry.verify(folder).err(),
            None if folder.join(name).exists() => None,
            None => Some("is not there".to_owned()),
        };
        let files = names
            .into_iter()
            .filter_map(|name| wrong(&name).map(|what| (name, what)))
            .collect();
        Self { files }
    }

    /// True if the file, or one that belongs to it (its name goes on where the extension begins), is lost.
    pub(super) fn has(&self, name: &str) -> bool {
        let stem = Path::new(name).with_extension("");
        let stem = stem.to_string_lossy();
        (self.files.keys()).any(|lost| {
            lost.strip_prefix(stem.as_ref())
                .is_some_and(|rest| rest.starts_with(['.', '_']))
        })
    }

    /// A line for who resumes the run; `None` if all is there.
    pub(super) fn note(&self) -> Option<String> {
        if self.files.is_empty() {
            return None;
        }
        let told = self.files.iter().take(TOLD);
        let mut told: Vec<String> = told.map(|(name, what)| format!("{name} {what}")).collect();
        if self.files.len() > TOLD {
            told.push(format!("and {} more", self.files.len() - TOLD));
        }
        Some(format!(
            "warning: files that the run had written are not as they were, and what lists them leaves them out: {}",
            told.join(", ")
        ))
    }
}
