//! Compares replies with the commands: every query is answered once, in order, or refused; every
//! error names a command.

use super::case::Connection;

/// Removes replies to `STATS` and refusals of it, and the bytes in use of a refusal for memory: they
/// depend on time and on other connections. They may follow a payload, so they are searched at any
/// position.
pub fn without_usage(replies: &[u8]) -> Vec<u8> {
    const LINES: [&[u8]; 2] = [b"STATS bytes=", b"EQUOTA STATS:"];
    const BEFORE_USED: &[u8] = b" are needed, and ";
    let mut out = Vec::new();
    let mut rest = replies;
    while let Some((&byte, after)) = rest.split_first() {
        if LINES.iter().any(|mark| rest.starts_with(mark)) {
            rest = &rest[rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())..];
        } else if let Some(after) = rest.strip_prefix(BEFORE_USED) {
            out.extend_from_slice(BEFORE_USED);
            rest = &after[after.iter().take_while(|b| b.is_ascii_digit()).count()..];
        } else {
            out.push(byte);
            rest = after;
        }
    }
    out
}

/// Panics if the replies of a connection do not match its commands.
pub fn check(connection: &Connection, replies: &[u8], is_ended: bool) {
    let text = || replies.escape_ascii().to_string();
    let mut rest = replies;
    // Index of the first command without a reply or an error so far.
    let mut next = 0usize;
    while !rest.is_empty() {
        let end =
            rest.iter().position(|&b| b == b'\n').unwrap_or_else(|| panic!("no LF at the end: {}", text()));
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        let words: Vec<&str> = line.split(' ').collect();
        // A warning about a draw has the position of its command, as an error would.
        if matches!(words[0], "ERR" | "WARN") {
            assert!(line.len() < 1000 && line.bytes().all(|b| (b' '..=b'~').contains(&b)), "{line:?}");
            assert!(!line.contains("defect"), "{line}");
            let byte: u64 = words[2].parse().expect("a place");
            let last = next.checked_sub(1).map(|last| connection.commands[last].0);
            if last == Some(byte) && words[3] == "EPROTO" {
                // The stream ended within the payload of a refused command.
                rest = &rest[end + 1..];
                continue;
            }
            let found = connection.commands[next..].iter().position(|c| c.0 == byte);
            let at =
                next + found.unwrap_or_else(|| panic!("no command at {byte} from {next} on: {}", text()));
            let skipped = connection.commands[next..at].iter().find(|c| c.1.is_some());
            assert!(skipped.is_none(), "{line:?} before a reply to {skipped:?}: {}", text());
            next = at + 1;
            rest = &rest[end + 1..];
            continue;
        }
        let found = connection.commands[next..].iter().position(|c| c.1.is_some());
        let at = next + found.unwrap_or_else(|| panic!("{line:?} was not asked for: {}", text()));
        let verb = connection.commands[at].1.expect("it was looked for");
        next = at + 1;
        if verb == "HELP" {
            rest = rest.strip_prefix(fbptr::command::help_text().as_bytes()).expect("the help");
            continue;
        }
        assert_eq!(words[0], verb, "{line:?}: {}", text());
        let payload = words.last().and_then(|w| w.strip_prefix(':')).filter(|n| !n.is_empty());
        let payload: usize = payload.map_or(0, |n| n.parse().expect("a length"));
        rest = &rest[end + 1 + payload..];
    }
    if !is_ended && connection.is_finished {
        let left = connection.commands[next..].iter().find(|c| c.1.is_some());
        assert!(left.is_none(), "{left:?} was not answered: {}", text());
    }
}
