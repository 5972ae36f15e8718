//! Every file in `cases/bad/` must be refused with exit code 2 and exactly the message that stands beside it.
//!
//! `{any}` in an expected message stands for text that depends on the machine. `RIPSTOP_BLESS=1` writes the messages anew.

use libtest_mimic::{Failed, Trial};

use crate::command_line::{ripstop, root};

pub fn trials() -> Vec<Trial> {
    let mut files: Vec<_> = std::fs::read_dir(root().join("cases/bad"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    assert!(files.len() >= 15, "cases/bad has lost files");
    files
        .into_iter()
        .map(|path| {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            Trial::test(format!("bad_case::{name}"), move || {
                let expected_path = path.with_extension("expected");
                let output = ripstop(&["check", &format!("cases/bad/{name}.toml")]);
                if output.code != 2 {
                    return Err(Failed::from(format!(
                        "exit code {} instead of 2",
                        output.code
                    )));
                }
                if std::env::var_os("RIPSTOP_BLESS").is_some_and(|v| v == "1") {
                    std::fs::write(&expected_path, &output.errors)?;
                }
                let expected = std::fs::read_to_string(&expected_path)?;
                if !matches(&expected, &output.errors) {
                    return Err(Failed::from(format!(
                        "expected\n{expected}\ngot\n{}",
                        output.errors
                    )));
                }
                Ok(())
            })
        })
        .collect()
}

/// Compares with `{any}` as a wildcard within lines.
fn matches(expected: &str, got: &str) -> bool {
    let mut parts = expected.split("{any}");
    let Some(mut rest) = parts.next().and_then(|first| got.strip_prefix(first)) else {
        return false;
    };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.is_empty()
}
