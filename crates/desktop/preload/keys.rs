//! The keys of a US keyboard: their codes in `linux/input-event-codes.h`, which are also those of
//! the console's medium raw mode, the names that windows give them, and what a console makes of
//! them.
//!
//! The program and the preload library include this file.

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Its code.
    pub code: u8,
    /// Its name in an `EVENT key` line of the protocol.
    pub name: &'static str,
    /// The character that it types, without and with shift; zero if it types none.
    pub characters: [u8; 2],
    /// The bytes that the console sends for a key that types no character.
    pub sequence: &'static str,
    /// Entry of the keyboard's table for a key that types no character: type and value.
    pub entry: u16,
}

const fn typed(code: u8, name: &'static str, plain: char, shifted: char) -> Key {
    Key { code, name, characters: [plain as u8, shifted as u8], sequence: "", entry: 0 }
}

const fn special(code: u8, name: &'static str, sequence: &'static str, entry: u16) -> Key {
    Key { code, name, characters: [0, 0], sequence, entry }
}

/// All keys, by code.
pub const KEYS: &[Key] = &[
    special(1, "escape", "\x1b", 0x1b),
    typed(2, "1", '1', '!'),
    typed(3, "2", '2', '@'),
    typed(4, "3", '3', '#'),
    typed(5, "4", '4', '$'),
    typed(6, "5", '5', '%'),
    typed(7, "6", '6', '^'),
    typed(8, "7", '7', '&'),
    typed(9, "8", '8', '*'),
    typed(10, "9", '9', '('),
    typed(11, "0", '0', ')'),
    typed(12, "minus", '-', '_'),
    typed(13, "equal", '=', '+'),
    special(14, "backspace", "\x7f", 0x7f),
    special(15, "tab", "\t", 0x9),
    typed(16, "q", 'q', 'Q'),
    typed(17, "w", 'w', 'W'),
    typed(18, "e", 'e', 'E'),
    typed(19, "r", 'r', 'R'),
    typed(20, "t", 't', 'T'),
    typed(21, "y", 'y', 'Y'),
    typed(22, "u", 'u', 'U'),
    typed(23, "i", 'i', 'I'),
    typed(24, "o", 'o', 'O'),
    typed(25, "p", 'p', 'P'),
    typed(26, "leftbracket", '[', '{'),
    typed(27, "rightbracket", ']', '}'),
    special(28, "enter", "\r", 0x201),
    special(29, "leftctrl", "", 0x702),
    typed(30, "a", 'a', 'A'),
    typed(31, "s", 's', 'S'),
    typed(32, "d", 'd', 'D'),
    typed(33, "f", 'f', 'F'),
    typed(34, "g", 'g', 'G'),
    typed(35, "h", 'h', 'H'),
    typed(36, "j", 'j', 'J'),
    typed(37, "k", 'k', 'K'),
    typed(38, "l", 'l', 'L'),
    typed(39, "semicolon", ';', ':'),
    typed(40, "apostrophe", '\'', '"'),
    typed(41, "backquote", '`', '~'),
    special(42, "leftshift", "", 0x700),
    typed(43, "backslash", '\\', '|'),
    typed(44, "z", 'z', 'Z'),
    typed(45, "x", 'x', 'X'),
    typed(46, "c", 'c', 'C'),
    typed(47, "v", 'v', 'V'),
    typed(48, "b", 'b', 'B'),
    typed(49, "n", 'n', 'N'),
    typed(50, "m", 'm', 'M'),
    typed(51, "comma", ',', '<'),
    typed(52, "period", '.', '>'),
    typed(53, "slash", '/', '?'),
    special(54, "rightshift", "", 0x700),
    special(55, "numpadasterisk", "*", 0x30c),
    special(56, "leftalt", "", 0x703),
    typed(57, "space", ' ', ' '),
    special(58, "capslock", "", 0x207),
    special(59, "f1", "\x1b[[A", 0x100),
    special(60, "f2", "\x1b[[B", 0x101),
    special(61, "f3", "\x1b[[C", 0x102),
    special(62, "f4", "\x1b[[D", 0x103),
    special(63, "f5", "\x1b[[E", 0x104),
    special(64, "f6", "\x1b[17~", 0x105),
    special(65, "f7", "\x1b[18~", 0x106),
    special(66, "f8", "\x1b[19~", 0x107),
    special(67, "f9", "\x1b[20~", 0x108),
    special(68, "f10", "\x1b[21~", 0x109),
    special(69, "numlock", "", 0x208),
    special(70, "scrolllock", "", 0x209),
    special(71, "numpad7", "7", 0x307),
    special(72, "numpad8", "8", 0x308),
    special(73, "numpad9", "9", 0x309),
    special(74, "numpadminus", "-", 0x30b),
    special(75, "numpad4", "4", 0x304),
    special(76, "numpad5", "5", 0x305),
    special(77, "numpad6", "6", 0x306),
    special(78, "numpadplus", "+", 0x30a),
    special(79, "numpad1", "1", 0x301),
    special(80, "numpad2", "2", 0x302),
    special(81, "numpad3", "3", 0x303),
    special(82, "numpad0", "0", 0x300),
    special(83, "numpaddot", ".", 0x310),
    special(87, "f11", "\x1b[23~", 0x10a),
    special(88, "f12", "\x1b[24~", 0x10b),
    special(96, "numpadenter", "\r", 0x30e),
    special(97, "rightctrl", "", 0x702),
    special(98, "numpadslash", "/", 0x30d),
    special(100, "rightalt", "", 0x701),
    special(102, "home", "\x1b[1~", 0x114),
    special(103, "up", "\x1b[A", 0x603),
    special(104, "pageup", "\x1b[5~", 0x118),
    special(105, "left", "\x1b[D", 0x601),
    special(106, "right", "\x1b[C", 0x602),
    special(107, "end", "\x1b[4~", 0x117),
    special(108, "down", "\x1b[B", 0x600),
    special(109, "pagedown", "\x1b[6~", 0x119),
    special(110, "insert", "\x1b[2~", 0x115),
    special(111, "delete", "\x1b[3~", 0x116),
    special(119, "pause", "", 0x11d),
    special(125, "leftsuper", "", 0x200),
    special(126, "rightsuper", "", 0x200),
    special(127, "menu", "", 0x11e),
];

/// Code of the left shift key.
pub const LEFT_SHIFT: u8 = 42;

/// Returns the key of this name.
pub fn by_name(name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.name == name)
}

/// Returns the key that types this character or control character, and whether with shift.
pub fn by_character(character: char) -> Option<(&'static Key, bool)> {
    let byte = u8::try_from(character).ok()?;
    let name = match byte {
        b'\n' | b'\r' => "enter",
        b'\t' => "tab",
        0x1b => "escape",
        8 | 0x7f => "backspace",
        _ => "",
    };
    let typed = |shift: usize| {
        KEYS.iter().find(move |key| byte != 0 && key.characters[shift] == byte).map(|key| (key, shift == 1))
    };
    by_name(name).map(|key| (key, false)).or_else(|| typed(0)).or_else(|| typed(1))
}

/// Returns the entry of the keyboard's table (0 plain, 1 with shift, 4 with control) for a code:
/// type in the high byte, value in the low one. `None` for a table that there is not.
pub fn entry(table: u8, code: u8) -> Option<u16> {
    // K_NOSUCHMAP, K_HOLE
    const NO_TABLE: u16 = 0x27f;
    const HOLE: u16 = 0x200;
    if code > 127 {
        return None;
    }
    let Some(key) = KEYS.iter().find(|key| key.code == code) else { return Some(HOLE) };
    let letter =
        |byte: u8| if byte.is_ascii_alphabetic() { 0xb00 | u16::from(byte) } else { u16::from(byte) };
    Some(match (table, key.characters) {
        (0 | 1 | 4, [0, _]) => key.entry,
        (0, [plain, _]) => letter(plain),
        (1, [_, shifted]) => letter(shifted),
        (4, [plain, _]) if plain.is_ascii_alphabetic() => u16::from(plain & 0x1f),
        (4, _) => HOLE,
        _ => NO_TABLE,
    })
}
