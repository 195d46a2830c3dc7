//! The protocol as a table of requests and replies.

use crate::support::{Serving, Wire};

/// Requests, each on one connection to a fresh 20x10 server, and all replies. `~` stands for the
/// rest of a line.
const TABLE: &[(&str, &str)] = &[
    ("SIZE\n", "SIZE 20 10\n"),
    ("size\r\n", "SIZE 20 10\n"),
    ("PX 1 2 ff8040\nPX 1 2\n", "PX 1 2 ff8040\n"),
    ("PX 1 2 FF804080\nPEEK 164 4\n", "PEEK 164 ff804080\n"),
    ("PX 1 2 7f\nPX 1 2\n", "PX 1 2 7f7f7f\n"),
    ("PX   ff\nPX    ff\nPX 1   \nSIZE\n", "SIZE 20 10\n"),
    ("PX 1 2 tomato\nPX 1 2\n", "PX 1 2 ff6347\n"),
    ("OFFSET 3 4\nPX 1 2 0000ff\nPX 1 2\nOFFSET 0 0\nPX 4 6\n", "PX 1 2 0000ff\nPX 4 6 0000ff\n"),
    ("OFFSET -1 0\nPX 1 2 00ff00\nOFFSET 0 0\nPX 0 2\n", "PX 0 2 00ff00\n"),
    ("OFFSET 2147483647 0\nPX 2147483647 0 ff0000\nCRC 0 0 1 1\n", "CRC 0c463091\n"),
    ("POKE 4 01020304\nPEEK 3 6\n", "PEEK 3 ff0102030400\n"),
    ("PEEK 800 1\n", "ERR 1 0 ERANGE PEEK: ~"),
    ("PEEK 800 0\n", "PEEK 800\n"),
    ("POKE 799 0102\nPEEK 799 1\n", "ERR 1 0 ERANGE POKE: ~PEEK 799 ff\n"),
    ("POKE -1 01\n", "ERR 1 0 ERANGE POKE: ~"),
    ("BLIT 1 1 1 2 :8\nabcdefghREAD 1 1 1 2\n", "READ 1 1 1 2 :8\nabcdefgh"),
    ("BLIT -1 0 2 1 :8\nabcdefghREAD 0 0 1 1\n", "READ 0 0 1 1 :4\nefgh"),
    ("READ 19 9 2 1\n", "ERR 1 0 ERANGE READ: ~"),
    ("READ 0 0 0 5\n", "READ 0 0 0 5 :0\n"),
    ("COPY 0 0 30 1 0 0\n", "ERR 1 0 ERANGE COPY: ~"),
    ("FILLRECT 0 0 2 2 ff0000\nCOPY 0 0 2 2 18 9\nPX 19 9\nPX 19 8\n", "PX 19 9 ff0000\nPX 19 8 000000\n"),
    ("CLEAR ffffff\nCRC\nCLEAR 00000000\nCRC\n", "CRC ba33b6fc\nCRC 688fa2e3\n"),
    ("CRC 0 0 21 1\n", "ERR 1 0 ERANGE CRC: ~"),
    ("CRC 0 0 -1 1\n", "ERR 1 0 ERANGE CRC: ~"),
    ("SYNC hello\nSYNC 2\n", "SYNC hello\nSYNC 2\n"),
    ("HELLO\n", "HELLO fbptr 1 20 10 80 rgba\n"),
    ("DEPTHAT 0 0\n", "DEPTHAT 0 0 1.00000000\n"),
    ("DEPTHAT 20 0\n", "ERR 1 0 ERANGE DEPTHAT: ~"),
    ("PICK 0 0\n", "PICK 0 0 none -1\n"),
    ("PRESENT\nPRESENT wait\nPRESENT wait\n", "FRAME 2\nFRAME 3\n"),
    ("LINE 0 0 1\n", "ERR 1 0 EARGS LINE: ~"),
    ("LINE 0 0 1 1 nocolour\n", "ERR 1 0 ECOLOUR LINE: ~"),
    ("LINE 0 0 1.5 1 ff0000\n", "ERR 1 0 ENUM LINE: ~"),
    ("FILL 0 0 1e999 1 2 2 ff0000\nSYNC a\n", "ERR 1 0 ENUM FILL: ~SYNC a\n"),
    ("RECT 0 0 -1 1 ff0000\n", "ERR 1 0 ERANGE RECT: ~"),
    ("DRAW nothing\n", "ERR 1 0 ENOENT DRAW: ~"),
    ("FREE nothing\n", "ERR 1 0 ENOENT FREE: ~"),
    ("TEXTURE nothing\n", "ERR 1 0 ENOENT TEXTURE: ~"),
    ("DRAWSCENE\n", "ERR 1 0 ENOENT DRAWSCENE: ~"),
    ("DRAWEYE e 0 0 4 4\n", "ERR 1 0 ENOENT DRAWEYE: ~"),
    ("TEX t :4\nabcdSYNC a\n", "ERR 1 0 EFORMAT TEX: ~SYNC a\n"),
    ("SCENE X3D :4\n<X3>SYNC a\n", "ERR 1 0 EFORMAT SCENE: ~SYNC a\n"),
    ("EYE e :2\n{}SYNC a\n", "ERR 1 0 EFORMAT EYE: ~SYNC a\n"),
    ("MESH m OBJ :8\nf 1 2 9\nSYNC a\n", "ERR 1 0 EFORMAT MESH: ~SYNC a\n"),
    ("POP\n", "ERR 1 0 ERANGE POP: ~"),
    ("PUSH\nPOP\nSYNC a\n", "SYNC a\n"),
    ("ROTATE 0 0 0 1\n", "ERR 1 0 ERANGE ROTATE: ~"),
    ("MATRIX 1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1\n", "ERR 1 0 ERANGE MATRIX: ~"),
    ("LOOKAT 0 0 0 0 0 0 0 1 0\n", "ERR 1 0 ERANGE LOOKAT: ~"),
    ("LOOKAT 0 0 5 0 0 0 0 0 1\n", "ERR 1 0 ERANGE LOOKAT: ~"),
    ("PERSPECTIVE 1 2 1\n", "ERR 1 0 ERANGE PERSPECTIVE: ~"),
    ("LIGHT 100000 OFF\n", "ERR 1 0 ERANGE LIGHT: ~"),
    ("LIGHT -1 OFF\n", "ERR 1 0 ERANGE LIGHT: ~"),
    ("LIGHT 0 OFF\nSYNC a\n", "SYNC a\n"),
    ("VIEWPORT 0 0 0 0\nMESH b BOX\nDRAW b\nSYNC a\n", "WARN 3 28 DRAW: ~SYNC a\n"),
    ("QUALITY exact\nQUALITY max-error 2\nSYNC a\n", "SYNC a\n"),
    ("SNAP a.png\n", "ERR 1 0 EPERM SNAP: ~"),
    ("LOAD MESH m a.obj\n", "ERR 1 0 EPERM LOAD: ~"),
    ("SYNC a\nFOO :3\n123SYNC b\n", "SYNC a\nERR 2 7 EVERB FOO: unknown verb, got \"FOO\"\nSYNC b\n"),
    ("SYNC a\nSYNC :\n", "SYNC a\nSYNC :\n"),
    ("BLEND over\nPX 0 0 ffffff80\nPX 0 0\n", "PX 0 0 808080\n"),
    ("BLEND over\nBLEND replace\nPX 0 0 ffffff80\nPX 0 0\n", "PX 0 0 ffffff\n"),
    (
        "BLEND over\nBLIT 0 0 1 1 :4\n@@@@POINTS :8\n\x01\0\0\0@@@@COPY 0 0 1 1 2 0\nPEEK 0 12\n",
        "PEEK 0 404040404040404040404040\n",
    ),
    ("ERRORS report\nFOO\nSIZE\n", "ERR 2 14 EVERB FOO: unknown verb, got \"FOO\"\nSIZE 20 10\n"),
    ("ERRORS close\nFOO\nSIZE\n", "ERR 2 13 EVERB FOO: unknown verb, got \"FOO\"\n"),
    ("ERRORS count\nLINE\nSIZE\n", "SIZE 20 10\n"),
    ("SIZE\nQUIT\nSIZE\n", "SIZE 20 10\n"),
    ("FOO\nPX zz 1\nPX 1 1 zz\nOFFSET 1\n", ""),
    ("SYNC a\nSYNC b", "SYNC a\nERR 2 7 EPROTO SYNC: ~"),
    ("CLEAR\nLIGHT 0 DIR 0 0 -1 1 1 1\nMESH b BOX\nDRAW b\nPICK 10 5\n", "PICK 10 5 b ~"),
];

/// Returns whether `text` matches `pattern`, in which each `~` stands for the rest of a line.
fn matches(pattern: &str, text: &str) -> bool {
    let Some((before, after)) = pattern.split_once('~') else { return pattern == text };
    let Some(rest) = text.strip_prefix(before) else { return false };
    rest.split_once('\n').is_some_and(|(_, rest)| matches(after, rest))
}

#[test]
fn every_request_has_its_answer_in_one_write_and_byte_by_byte() {
    for (request, want) in TABLE {
        for is_trickled in [false, true] {
            let serving = Serving::start(20, 10);
            let mut wire = serving.connect();
            match is_trickled {
                false => wire.send(request.as_bytes()),
                true => request.bytes().for_each(|b| wire.send(&[b])),
            }
            let got = String::from_utf8_lossy(&wire.rest()).into_owned();
            assert!(
                matches(want, &got),
                "asked {request:?} (trickled: {is_trickled})\nwanted {want:?}\ngot    {got:?}"
            );
        }
    }
}

#[test]
fn the_table_s_checksums_are_those_of_the_pixels() {
    let crc = |pixel: [u8; 4]| crc32fast::hash(&pixel.repeat(200));
    assert_eq!((crc([255; 4]), crc([0; 4])), (0xba33_b6fc, 0x688f_a2e3));
    assert_eq!(crc32fast::hash(&[0, 0, 0, 255]), 0x0c46_3091);
}

#[test]
fn help_is_what_pixelflut_clients_look_for() {
    let serving = Serving::start(4, 4);
    let help = serving.say("HELP\n");
    assert!(help.lines().any(|l| l.starts_with("PX x y gg")));
    assert!(help.lines().any(|l| l.starts_with("OFFSET")));
    assert!(help.contains("PBxxyyrgba"));
}

#[test]
fn binary_pixels_and_runs_mix_with_text() {
    let serving = Serving::start(20, 10);
    let mut request =
        b"PX 0 0 010203\nPB\x01\x00\x00\x00abcdPXMULTI\x12\x00\x00\x00\x04\x00\x00\x000123456789abcdef"
            .to_vec();
    request.extend_from_slice(b"PEEK 0 8\nREAD 18 0 2 1\nREAD 0 1 2 1\n");
    let want = b"PEEK 0 010203ff61626364\nREAD 18 0 2 1 :8\n01234567READ 0 1 2 1 :8\n89abcdef";
    assert_eq!(serving.talk(&request), want);
}

#[test]
fn replies_come_in_order_and_after_what_was_asked_before() {
    let serving = Serving::start(64, 64);
    let mut request = String::new();
    let mut want = String::new();
    for i in 0..5000 {
        let (x, y) = (i % 64, i / 64 % 64);
        request += &format!("PX {x} {y} {i:06x}\nPX {x} {y}\nSYNC {i}\n");
        want += &format!("PX {x} {y} {i:06x}\nSYNC {i}\n");
    }
    assert!(serving.say(&request) == want);
}

#[test]
fn a_half_close_still_gets_every_reply() {
    let serving = Serving::start(500, 500);
    let replies = serving.talk("READ 0 0 500 500\n".repeat(20).as_bytes());
    assert_eq!(replies.len(), 20 * ("READ 0 0 500 500 :1000000\n".len() + 1_000_000));
}

#[test]
fn stats_are_one_line_of_keys_and_values() {
    let serving = Serving::start(20, 10);
    let mut wire = serving.connect();
    wire.send(b"PX 0 0 ff0000\nPX 99 0 ff0000\nPX 0 0 zz\nPRESENT\n");
    let line = wire.ask("STATS\n");
    let words: Vec<&str> = line.trim_end().split(' ').collect();
    assert_eq!(words[0], "STATS");
    let value = |key: &str| {
        let found = words[1..].iter().find_map(|w| w.strip_prefix(key)?.strip_prefix('='));
        found.unwrap_or_else(|| panic!("no {key} in {line}"))
    };
    assert!(
        words[1..].iter().all(|w| w.split_once('=').is_some_and(|(k, v)| !k.is_empty() && !v.is_empty()))
    );
    assert_eq!([value("bytes"), value("commands"), value("pixels"), value("errors")], ["47", "5", "1", "1"]);
    assert_eq!(
        [value("clipped"), value("frames"), value("shm_offset"), value("shm_stride")],
        ["1", "1", "4096", "80"]
    );
    for key in
        ["queue", "connections", "plan", "total_bytes", "total_commands", "total_pixels", "total_errors"]
    {
        value(key);
    }
    let mut other = Wire::connect(serving.address);
    assert!(other.ask("STATS\n").contains(" total_pixels=1 "));
}
