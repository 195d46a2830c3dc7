//! Runs the Python client's own tests against the server of this build.

use crate::folder::Folder;
use crate::process::Process;
use crate::support::Wire;
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

#[test]
fn the_readmes_lines_run_as_printed_from_the_repositorys_root() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("README.md")).expect("there is a page");
    let blocks: Vec<&str> =
        page.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    // Those of the package are run by its own tests (python/tests), which have it installed.
    let (blocks, own): (Vec<&str>, Vec<&str>) =
        blocks.into_iter().partition(|block| block.contains("import Client"));
    assert!(!blocks.is_empty(), "the page has lines for the client");
    assert!(own.iter().all(|block| block.starts_with("import fbptr")), "{own:?}");
    if !tools::are_there(&["python3"]) {
        return;
    }
    let folder = Folder::new("readme");
    for block in blocks {
        let mut process = Process::start(&["--listen", ":0", "--size", "640x480"]);
        let address = process.address();
        let picture = folder.join("picture.png");
        assert!(block.contains("\"127.0.0.1:1234\"") && block.contains("\"picture.png\""), "{block}");
        // The port is the one in use here, and the picture goes to the temporary folder.
        let program = block
            .replace("127.0.0.1:1234", &address.to_string())
            .replace("picture.png", picture.to_str().expect("UTF-8"));
        let output = Command::new("python3")
            .args(["-B", "-c", &program])
            .current_dir(root)
            .output()
            .expect("python3 runs");
        assert!(output.status.success(), "{program}\n{}", String::from_utf8_lossy(&output.stderr));
        // The line that it draws, from one corner to the other, is in the frame and in the picture.
        assert_eq!(Wire::connect(address).ask("PX 639 479\n"), "PX 639 479 ffff00\n");
        let picture = image::open(&picture).expect("a picture").to_rgba8();
        assert_eq!((picture.dimensions(), picture.get_pixel(0, 0).0), ((640, 480), [255, 0, 0, 255]));
    }
}
