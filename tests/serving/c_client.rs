//! The client in C and C++, and the templates of programs that draw into the shared memory.

use crate::folder::Folder;
use crate::process::Process;
use crate::tools;
use std::path::Path;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn output_of(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    assert_eq!(said, "", "{command:?}");
    String::from_utf8(output.stdout).expect("a text")
}

#[test]
fn the_client_draws_reads_and_maps_as_c_and_as_cpp() {
    let folder = Folder::new("c-client");
    let source = Path::new(ROOT).join("tests/serving/c_client.c");
    for (compiler, language) in
        [("cc", &["-std=c99", "-pedantic", "-xc"]), ("c++", &["-std=c++11", "-g", "-xc++"])]
    {
        if !tools::are_there(&[compiler]) {
            continue;
        }
        let program = folder.join(compiler);
        let mut command = Command::new(compiler);
        command
            .args(language)
            .args(["-Wall", "-Wextra", "-Werror", "-I"])
            .arg(Path::new(ROOT).join("clients/c"));
        output_of(command.arg(&source).arg("-o").arg(&program));
        let shared = folder.join("memory");
        let mut process =
            Process::start(&["--listen", ":0", "--size", "64x48", "--shm", shared.to_str().unwrap()]);
        let address = process.address().to_string();
        let said = output_of(Command::new(program).arg(&shared).arg(address));
        let expected = "64x48 stride 256\n24 bytes, 255 0 0, 3\nFBptr 255 255 9\n15 PEEK 0 ff0000ff\n12 CRC  1\n-1 2\n0 1\n";
        assert_eq!(said, expected, "{compiler}");
    }
}

#[test]
fn the_templates_draw_the_same_picture_in_every_language() {
    let folder = Folder::new("templates");
    let templates = Path::new(ROOT).join("clients/templates");
    let include = format!("-I{}", Path::new(ROOT).join("clients/c").display());
    let shared = folder.join("memory");
    let mut process =
        Process::start(&["--listen", ":0", "--size", "320x240", "--shm", shared.to_str().unwrap()]);
    process.address();
    let pixels = || std::fs::read(&shared).unwrap()[4096..].to_vec();
    let black = pixels();
    let mut pictures = Vec::new();
    for (language, compiler) in [("c", "cc"), ("cpp", "c++"), ("rust", "rustc"), ("python", "python3")] {
        if !tools::are_there(&[compiler]) {
            continue;
        }
        let (program, source) = (folder.join(language), templates.join(language));
        let mut command = Command::new(compiler);
        match language {
            "c" => command.args(["-std=c99", "-Wall", "-Wextra", &include]).arg(source.join("main.c")),
            "cpp" => command.args(["-std=c++11", "-Wall", "-Wextra", &include]).arg(source.join("main.cpp")),
            "rust" => command.args(["--edition", "2021"]).arg(source.join("src/main.rs")),
            _ => command.arg("-B").arg(source.join("main.py")),
        };
        let mut drawn = match language {
            "python" => command,
            _ => {
                output_of(command.arg("-o").arg(&program));
                Command::new(program)
            }
        };
        output_of(drawn.arg(&shared));
        let picture = pixels();
        let lit = |x: usize, y: usize| &picture[4 * (y * 320 + x)..][..3];
        assert_eq!(
            (lit(5, 5), lit(20, 100), lit(319, 239)),
            (&[255; 3][..], &[255, 128, 0][..], &[64; 3][..])
        );
        pictures.push((language, picture));
        // The next one begins with the same memory.
        let file = std::fs::OpenOptions::new().write(true).open(&shared).unwrap();
        std::os::unix::fs::FileExt::write_all_at(&file, &black, 4096).unwrap();
    }
    for pair in pictures.windows(2) {
        assert!(pair[0].1 == pair[1].1, "{} and {} differ", pair[0].0, pair[1].0);
    }
}
