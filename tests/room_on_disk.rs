//! Folders that cannot be written, and disks without room.

use std::process::Command;

use libtest_mimic::Trial;

use crate::command_line::{files, finished, program, ripstop, root};
use crate::engines::plain;
use crate::folders::canopy;

pub fn trials() -> Vec<Trial> {
    let mut trials = plain("room_on_disk::unwritable_folder", unwritable);
    // A shell that can limit file sizes and send signals.
    if cfg!(unix) {
        trials.extend(plain("room_on_disk::full", full_disk));
        trials.extend(plain("room_on_disk::none_for_frames", no_room_for_frames));
    }
    trials
}

const QUICK_SHEET: [&str; 4] = [
    "run",
    "cases/cloth/hanging-sheet.toml",
    "--variant",
    "quick",
];

fn unwritable() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("taken");
    std::fs::write(&file, "a file").unwrap();
    let output = ripstop(&[&QUICK_SHEET[..], &["--out", file.to_str().unwrap()]].concat());
    assert_eq!(output.code, 74, "{}", output.errors);
    assert!(output.errors.contains("taken"), "{}", output.errors);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "a file");
}

/// A limit on file sizes stands in for a full disk: writing fails in the middle of a file.
fn full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{}' {} --out '{}'",
        program().display(),
        QUICK_SHEET.join(" "),
        out.display()
    );
    let output = finished(
        Command::new("sh")
            .args(["-c", &script])
            .current_dir(root())
            .output()
            .unwrap(),
    );
    assert_eq!(output.code, 74, "{}{}", output.printed, output.errors);
    assert!(output.errors.contains("cannot write"), "{}", output.errors);
    // Whatever is there is whole: no temporary files, and every VTK file ends with its closing tag.
    for path in files(&out) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(
            [
                "csv", "pvd", "vtp", "png", "json", "log", "f64", "toml", "html"
            ]
            .iter()
            .any(|e| name.ends_with(e)),
            "left over: {name}"
        );
        if name.ends_with("vtp") || name.ends_with("pvd") {
            assert!(
                std::fs::read(&path)
                    .unwrap()
                    .trim_ascii_end()
                    .ends_with(b"</VTKFile>"),
                "{name}"
            );
        }
    }
}

/// Frames, pictures and checkpoints that there is no room for end nothing: the run says so once, delivers every result, and names what is missing.
fn no_room_for_frames() {
    let folder = tempfile::tempdir().unwrap();
    let more = [
        "--set",
        "time.end_s=0.03",
        "--set",
        "output.flow_interval_s=0.01",
    ];
    let [whole, canopies, none] = ["whole", "canopies", "none"].map(|n| folder.path().join(n));
    let output = finished(canopy(&whole, &more).output().unwrap());
    assert_eq!(output.code, 0, "{}", output.errors);
    // Blocks of 512 bytes: room for canopies, but neither air nor states; room for tables alone.
    for (out, blocks) in [(&canopies, 400), (&none, 128)] {
        let run = canopy(out, &more);
        let mut limited = Command::new("sh");
        limited
            .args(["-c", "trap '' XFSZ; ulimit -f $0; exec \"$@\""])
            .arg(blocks.to_string())
            .arg(run.get_program())
            .args(run.get_args())
            .current_dir(root());
        let output = finished(limited.output().unwrap());
        assert_eq!(output.code, 0, "{}", output.errors);
        let said = |needle: &str| output.errors.matches(needle).count();
        assert_eq!(said("goes on without it"), 1, "{}", output.errors);
        assert_eq!(said("next checkpoint"), 1, "{}", output.errors);
        assert_eq!(said("no room for the state at the end"), 1);
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let missing = "files are missing that there was no room for: the ";
        assert!(summary.contains(missing), "{summary}");
        for text in [&summary, &output.printed] {
            assert!(text.contains("the air at t = 0.0"), "{text}");
        }
        for name in ["history.csv", "gores.csv"] {
            let [a, b] = [&whole, out].map(|f| std::fs::read(f.join(name)).unwrap());
            assert!(a == b, "{name} differs");
        }
        // What is listed is there, and nothing lies about.
        for path in files(out) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            assert!(
                !name.contains("checkpoint") && !name.starts_with(".ripstop"),
                "left over: {name}"
            );
        }
        let list = std::fs::read_to_string(out.join("canopy.pvd")).unwrap();
        let frames = files(out)
            .iter()
            .filter(|p| p.extension().is_some_and(|e| e == "vtp"))
            .count();
        assert_eq!(list.matches("DataSet").count(), frames);
        assert_eq!(frames > 0, blocks == 400);
        assert!(!out.join("frames/flow_00000.vti").exists());
    }
}
