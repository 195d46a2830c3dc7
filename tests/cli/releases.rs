//! Recordings of earlier releases replay to the bytes that they drew then: `tests/data/releases`.

use crate::play::{err, run};
use std::path::Path;

#[test]
fn recordings_of_releases_replay_to_the_same_bytes() {
    let mut count = 0;
    let releases = std::fs::read_dir("tests/data/releases").expect("there are releases");
    for release in releases.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir()) {
        for file in std::fs::read_dir(release).expect("a folder").map(|e| e.expect("an entry").path()) {
            if file.extension().is_some_and(|e| e == "fbs") {
                let word = |path: &Path| path.to_str().expect("UTF-8").to_owned();
                let picture = word(&file.with_extension("png"));
                let output = run(&["play", &word(&file), "--headless", "--expect", &picture], b"");
                assert!(output.status.success(), "{}: {}", file.display(), err(&output));
                count += 1;
            }
        }
    }
    assert!(count >= 2, "{count} recordings");
}
