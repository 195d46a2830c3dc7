//! The protocol page's shell examples, run as printed by a shell in an empty folder.
#![cfg(unix)]

use crate::folder::Folder;
use crate::process::Process;
use crate::tools;
use std::process::Command;

const PAGE: &str = include_str!("../../docs/protocol.md");

/// Returns the commands of the page's console session, each with its expected output.
fn session() -> Vec<(String, String)> {
    let text = PAGE.split("```console\n").nth(1).unwrap().split("```").next().unwrap();
    let mut session: Vec<(String, String)> = Vec::new();
    for line in text.lines() {
        match line.strip_prefix("$ ") {
            Some(command) => session.push((command.to_owned(), String::new())),
            None => session.last_mut().unwrap().1.push_str(&format!("{line}\n")),
        }
    }
    session
}

#[test]
fn the_shell_examples_print_what_the_page_says() {
    let help = Command::new("nc").arg("-h").output().map(|o| [o.stdout, o.stderr].concat());
    if !help.is_ok_and(|text| String::from_utf8_lossy(&text).contains("OpenBSD")) {
        return tools::skip("OpenBSD's nc is not installed");
    }
    let folder = Folder::new("shell");
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_fbptr")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let (mut server, mut port, mut count) = (None, String::new(), 0);
    for (command, expected) in session() {
        if let Some(arguments) = command.strip_prefix("fbptr serve --headless ") {
            // On a free port, and with its socket in the folder.
            let arguments = arguments.trim_end_matches(" &").replace(":1234", ":0");
            let socket = folder.join("fb.sock").display().to_string();
            let arguments: Vec<&str> =
                arguments.split(' ').map(|a| if a == "fb.sock" { &socket } else { a }).collect();
            let mut process = Process::start(&arguments);
            port = process.address().port().to_string();
            server = Some(process);
            continue;
        }
        let typed = command
            .replace("127.0.0.1 1234", &format!("127.0.0.1 {port}"))
            .replace("127.0.0.1:1234", &format!("127.0.0.1:{port}"));
        let out =
            Command::new("sh").args(["-c", &typed]).current_dir(&folder).env("PATH", &path).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&out.stdout), expected, "{command}");
        assert!(out.status.success() && out.stderr.is_empty(), "{command}: {out:?}");
        count += 1;
    }
    assert!(count >= 10 && server.is_some(), "the page's session is short: {count} commands");
    for file in ["picture.png", "disc.png"] {
        let picture = image::open(folder.join(file)).unwrap();
        assert_eq!((picture.width(), picture.height()), (640, 480), "{file}");
    }
}
