//! `fbptr playground`: the page as it is checked in, for this machine alone; and the links to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_page_is_served_to_names_of_this_machine_alone() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbptr"));
    let mut child = Running(command.arg("playground").stdout(Stdio::piped()).spawn().expect("it starts"));
    let mut link = String::new();
    let output = child.0.stdout.take().expect("its output");
    BufReader::new(output).read_line(&mut link).expect("a line");
    let address = link.trim().trim_start_matches("http://").trim_end_matches('/');
    assert!(address.starts_with("127.0.0.1:"), "{link}");
    let ask = |request: String| {
        let mut connection = TcpStream::connect(address).expect("a connection");
        connection.write_all(request.as_bytes()).expect("it is read");
        let mut answer = Vec::new();
        connection.read_to_end(&mut answer).expect("an answer");
        answer
    };
    let page = std::fs::read("docs/playground/index.html").expect("the page");
    let found = ask(format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n"));
    assert!(found.starts_with(b"HTTP/1.1 200 OK\r\n") && found.ends_with(&page));
    let request = |line: &str, host: &str| ask(format!("{line}\r\nHost: {host}\r\n\r\n"));
    assert!(request("GET /etc/passwd HTTP/1.1", address).starts_with(b"HTTP/1.1 404 "));
    assert!(request("GET / HTTP/1.1", "example.org").starts_with(b"HTTP/1.1 400 "));
    assert!(request("POST / HTTP/1.1", address).starts_with(b"HTTP/1.1 400 "));
}

/// Decodes `%XX`.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        match (first, tail) {
            (b'%', [a, b, tail @ ..]) => {
                let hex = std::str::from_utf8(&[*a, *b]).ok().and_then(|s| u8::from_str_radix(s, 16).ok());
                bytes.push(hex.expect("two hex digits"));
                rest = tail;
            }
            _ => bytes.push(*first),
        }
    }
    String::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn links_behind_recipes_have_their_text() {
    let page = std::fs::read_to_string("docs/protocol.md").expect("the page");
    let (_, recipes) = page.split_once("\n## Recipes\n").expect("the recipes");
    let (recipes, _) = recipes.split_once("\n## ").expect("a section behind them");
    let mut count = 0;
    for part in recipes.split("```text\n").skip(1) {
        let (text, behind) = part.split_once("```\n").expect("its end");
        let link =
            behind.trim_start().strip_prefix("[try it](playground/index.html#").expect("a link behind it");
        assert_eq!(decoded(link.split_once(')').expect("its end").0), text);
        count += 1;
    }
    assert!(count >= 5, "{count} recipes");
}
