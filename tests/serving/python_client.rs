//! The Python client's own tests, against the server that this build made.

use crate::tools;
use std::path::Path;
use std::process::Command;

#[test]
fn the_python_client_draws_reads_and_maps() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python");
    if !tools::are_there(&["python3"]) {
        return;
    }
    let output = Command::new("python3")
        .args(["-B", "-m", "unittest", "-v"])
        .current_dir(folder)
        .env("FBPTR", env!("CARGO_BIN_EXE_fbptr"))
        .output()
        .expect("python3 runs");
    let report = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{report}");
    let ran = report.lines().any(|l| l.starts_with("Ran ") && !l.starts_with("Ran 0 "));
    assert!(ran, "no test ran:\n{report}");
}
