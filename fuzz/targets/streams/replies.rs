//! Replies against what was asked: every query is answered once, in order, or refused; every error names a command.

use super::case::Life;

/// Panics where the replies of a life are not those that its commands get.
pub fn check(life: &Life, replies: &[u8], is_ended: bool, is_cut: bool) {
    let text = || replies.escape_ascii().to_string();
    let mut rest = replies;
    // Commands before this one are answered or refused for good.
    let mut next = 0;
    while !rest.is_empty() {
        let end =
            rest.iter().position(|&b| b == b'\n').unwrap_or_else(|| panic!("no LF at the end: {}", text()));
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        let words: Vec<&str> = line.split(' ').collect();
        if words[0] == "ERR" {
            assert!(line.len() < 1000 && line.bytes().all(|b| (b' '..=b'~').contains(&b)), "{line:?}");
            assert!(!line.contains("defect"), "{line}");
            let byte: u64 = words[2].parse().expect("a place");
            let found = life.commands[next..].iter().position(|c| c.0 == byte);
            let at =
                next + found.unwrap_or_else(|| panic!("no command at {byte} from {next} on: {}", text()));
            let skipped = life.commands[next..at].iter().find(|c| c.1.is_some());
            assert!(skipped.is_none(), "{line:?} before a reply to {skipped:?}: {}", text());
            next = at + 1;
            rest = &rest[end + 1..];
            continue;
        }
        let found = life.commands[next..].iter().position(|c| c.1.is_some());
        let at = next + found.unwrap_or_else(|| panic!("{line:?} was not asked for: {}", text()));
        let verb = life.commands[at].1.expect("it was looked for");
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
    if !is_ended && !is_cut {
        let left = life.commands[next..].iter().find(|c| c.1.is_some());
        assert!(left.is_none(), "{left:?} was not answered: {}", text());
    }
}
