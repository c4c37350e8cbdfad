//! The guide's page has what its program makes of the campaigns' tables.

#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

use std::path::Path;
use std::process::Command;

#[test]
fn the_page_on_accuracy_is_of_the_tables_that_are_kept() {
    let part = |page: &str| {
        let from = page.split_once("## On random systems").unwrap().1;
        from.split_once("## On systems from public code").unwrap().0.to_owned()
    };
    let written = Path::new(env!("CARGO_TARGET_TMPDIR")).join("accuracy.md");
    let mut program = Command::new(env!("CARGO_BIN_EXE_expoly-measure"));
    let output = program.args(["accuracy", "--only", "campaigns", "--out"]).arg(&written).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src/guide/accuracy.md");
    let [written, page] = [written.as_path(), page.as_path()].map(|path| std::fs::read_to_string(path).unwrap());
    assert_eq!(part(&page), part(&written), "run expoly-measure -- accuracy");
    // What is promised of densities without a warning, and of wells and linear systems.
    for promise in ["Of the random oscillators 0 have", "300 have a density"] {
        assert!(part(&page).contains(promise), "{promise}");
    }
}
