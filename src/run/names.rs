//! Names of the files that a run writes.

use std::path::Path;

use super::tables::{self, load_test, panel_shaping, trim};
use crate::checkpoint;
use crate::frame::{FabricQuantity, FlowQuantity};
use crate::ledger::{self, Ledger};
use crate::measure::{CHARTS, SAMPLES_FILE};
use crate::output::{FRAMES_FOLDER, files_of_run};
use crate::report;

/// The case as it is run, in its folder.
pub(super) const CASE_FILE: &str = "case_as_run.toml";

/// Most boxes of finer cells whose files are known by their names.
const LARGEST_BOX_NUMBER: usize = 64;

/// Name of a frame in the run's folder.
pub(super) fn frame(name: &str) -> String {
    format!("{FRAMES_FOLDER}/{name}")
}

/// Name of a frame in the folder of frames; `None` of other files.
pub(super) fn in_frames(name: &str) -> Option<&str> {
    name.strip_prefix(FRAMES_FOLDER)?.strip_prefix('/')
}

/// True for names of results; ledger and checkpoints are not among them.
pub(super) fn is_result(name: &str) -> bool {
    in_frames(name).map_or_else(|| is_beside_frames(name), is_frame)
}

fn is_numbered(name: &str, prefix: &str, suffix: &str) -> bool {
    name.strip_prefix(prefix)
        .and_then(|rest| rest.strip_suffix(suffix))
        .is_some_and(|digits| digits.len() >= 3 && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// True for names of frames in their folder.
fn is_frame(name: &str) -> bool {
    let numbered = |prefix: &str, suffix: &str| is_numbered(name, prefix, suffix);
    numbered("canopy_", ".vtp")
        || numbered("bodies_", ".vtp")
        || numbered("flow_", ".vti")
        || numbered("flow_", ".vtm")
        || (1..=LARGEST_BOX_NUMBER).any(|k| numbered("flow_", &format!("_box_{k}.vti")))
        || numbered("animation_", ".png")
}

fn is_beside_frames(name: &str) -> bool {
    let numbered = |prefix: &str, suffix: &str| is_numbered(name, prefix, suffix);
    numbered("snapshot_", ".png")
        || FlowQuantity::ALL.iter().any(|quantity| {
            numbered("snapshot_", &format!("_{}.png", quantity.name()))
                || numbered("snapshot_", &format!("_section_{}.png", quantity.name()))
        })
        || FabricQuantity::ALL
            .iter()
            .any(|quantity| numbered("snapshot_", &format!("_{}.png", quantity.name())))
        || [
            CASE_FILE,
            report::FILE_NAME,
            "summary.json",
            "history.csv",
            "canopy_last_good.vtp",
            "canopy.pvd",
            "bodies.pvd",
            "flow.pvd",
            "animation.png",
        ]
        .contains(&name)
        || tables::NAMES.contains(&name)
        || trim::TABLES.contains(&name)
        || load_test::TABLES.contains(&name)
        || panel_shaping::TABLES.contains(&name)
        || [
            load_test::PICTURE,
            load_test::SHAPE,
            panel_shaping::PATTERNS,
        ]
        .contains(&name)
        || tables::WING_CHARTS
            .iter()
            .any(|chart| name == format!("{chart}.svg") || name == format!("{chart}.png"))
        || trim::CHARTS
            .iter()
            .chain(&load_test::CHARTS)
            .chain(&panel_shaping::CHARTS)
            .any(|chart| name == format!("{chart}.svg") || name == format!("{chart}.png"))
        || CHARTS.iter().any(|column| {
            let chart = format!("history_{}", column.name);
            name == format!("{chart}.svg") || name == format!("{chart}.png")
        })
}

/// True for checkpoints and the samples that they refer to, whose checksums they hold.
fn is_of_checkpoints(name: &str) -> bool {
    name == SAMPLES_FILE || checkpoint::NAMES.contains(&name)
}

/// Name of a result or a checkpoint in `folder`, if there is one.
pub(super) fn first_in(folder: &Path) -> Option<String> {
    let names = files_of_run(folder).into_iter();
    let mut names = names.filter(|name| is_result(name) || is_of_checkpoints(name));
    names.next()
}

/// Removes what an earlier run left in the folder: mixing two runs would mislead. Other files stay.
pub(super) fn remove_earlier(folder: &Path) {
    // The ledger last: a folder that is only half empty is still that run's.
    checkpoint::remove(folder);
    let listed = Ledger::read(folder).ok().flatten();
    let listed = listed.iter().flat_map(|ledger| &ledger.files);
    let listed: Vec<&str> = listed.map(|entry| entry.name.as_str()).collect();
    for name in files_of_run(folder) {
        if is_result(&name) || name == SAMPLES_FILE || listed.contains(&name.as_str()) {
            // What cannot be removed will be overwritten or reported then.
            let _ = std::fs::remove_file(folder.join(&name));
        }
    }
    let _ = std::fs::remove_file(folder.join(ledger::FILE_NAME));
}
