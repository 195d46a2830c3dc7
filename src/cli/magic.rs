//! Detection of a file's format by its first bytes, not by its name.
//!
//! In: the first bytes of a file and its length. Out: the format of a scene, or the name of an
//! unsupported format; `None` for everything else, which is classified by name. Otherwise a file of
//! another format would be refused line by line.

use super::say_as_program;
use crate::load::{MeshFormat, gltf, x3d};
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of bytes examined.
const FIRST_BYTES: u64 = 64 << 10;

/// Detected format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// X3D in XML or the classic encoding, or VRML 97, plain or compressed.
    X3d,
    /// glTF 2.0, as JSON or binary.
    Gltf,
    /// A mesh of a format that its bytes tell.
    Mesh(MeshFormat),
    /// An unsupported format, described in words.
    Other(&'static str),
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            Content::Other(what) => return f.write_str(what),
            Content::X3d => "an X3D scene",
            Content::Gltf => "a glTF scene",
            Content::Mesh(MeshFormat::Obj) => "an OBJ model",
            Content::Mesh(MeshFormat::Stl) => "an STL model",
            Content::Mesh(MeshFormat::Ply) => "a PLY model",
        };
        write!(f, "{what}, which `fbptr view` and `fbptr render` show")
    }
}

/// Formats by their files' first bytes.
const BEGINNINGS: &[(&[u8], &str)] = &[
    (b"\x89PNG\r\n\x1a\n", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF87a", "a GIF picture"),
    (b"GIF89a", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"8BPS", "a Photoshop picture"),
    (b"v/1\x01", "an OpenEXR picture"),
    (b"#?RADIANCE", "a Radiance picture"),
    (b"qoif", "a QOI picture"),
    (b"Kaydara FBX Binary", "an FBX model"),
    (b"; FBX", "an FBX model"),
    (b"BLENDER", "a Blender file"),
    (b"#USDA", "a USD scene"),
    (b"PXR-USDC", "a USD scene"),
    (b"#VRML V1", "a VRML 1.0 scene"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"BZh", "a bzip2 file"),
    (b"\xfd7zXZ\0", "an xz file"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard file"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"\0asm", "a WebAssembly module"),
];

/// Formats by a tag near the beginning of an XML file.
const TAGS: &[(&str, Content)] = &[
    ("<X3D", Content::X3d),
    ("<Scene", Content::X3d),
    ("<COLLADA", Content::Other("a COLLADA model")),
    ("<svg", Content::Other("an SVG drawing")),
    ("<html", Content::Other("an HTML page")),
    ("<HTML", Content::Other("an HTML page")),
];

/// First words of OBJ files, none of which is a verb of the protocol.
const OBJ_STATEMENTS: &[&[u8]] = &[b"mtllib", b"o", b"g", b"v", b"vt", b"vn", b"usemtl", b"f"];

/// Detects the format of the file at `path`. Pipes are not read.
pub(super) fn of_path(path: &Path) -> io::Result<Option<Content>> {
    match std::fs::metadata(path)?.is_file() {
        true => of_file(&File::open(path)?),
        false => Ok(None),
    }
}

/// Detects the format of an open regular file by its next bytes, which are consumed.
fn of_file(file: &File) -> io::Result<Option<Content>> {
    let mut first = Vec::new();
    file.take(FIRST_BYTES).read_to_end(&mut first)?;
    Ok(of_bytes(&first, file.metadata()?.len()))
}

/// Detects what an open regular file is that should be a stream of commands, by its next bytes,
/// which are consumed; `None` if it can be one.
pub(super) fn other_than_commands(file: &File) -> io::Result<Option<Content>> {
    let mut first = Vec::new();
    file.take(FIRST_BYTES).read_to_end(&mut first)?;
    Ok(of_bytes(&first, file.metadata()?.len()).or_else(|| of_no_text(&first)))
}

/// Standard input as a stream of commands. It ends, with a message, at first bytes that are those of
/// another format.
pub(super) struct CommandInput<R> {
    input: R,
    state: InputState,
    has_failed: Arc<AtomicBool>,
}

/// Result of the look at the first bytes of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InputState {
    /// Nothing was read.
    New,
    /// It is a stream of commands.
    Commands,
    /// It has another format: the rest is not read.
    Refused,
}

impl<R: Read> CommandInput<R> {
    /// Wraps an input that nothing was read from. `has_failed` is set if it has another format.
    pub(super) fn new(input: R, has_failed: Arc<AtomicBool>) -> Self {
        CommandInput { input, state: InputState::New, has_failed }
    }
}

impl<R: Read> Read for CommandInput<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.state {
            InputState::Commands => return self.input.read(buffer),
            InputState::Refused => return Ok(0),
            InputState::New => {}
        }
        let count = self.read_first(buffer)?;
        self.state = InputState::Commands;
        // A pipe has no length. Only the detection of binary STL uses it.
        let first = &buffer[..count];
        if let Some(content) = of_bytes(first, u64::MAX).or_else(|| of_no_text(first)) {
            say_as_program(format_args!("-: {content}; expected a stream of commands"));
            self.has_failed.store(true, Ordering::Release);
            self.state = InputState::Refused;
            return Ok(0);
        }
        Ok(count)
    }
}

impl<R: Read> CommandInput<R> {
    /// Reads the first bytes: more than come at once only while they may begin another format.
    fn read_first(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut count = 0;
        while count < buffer.len() {
            match self.input.read(&mut buffer[count..]) {
                Ok(0) => break,
                Ok(n) => count += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted && count > 0 => {}
                Err(e) => return Err(e),
            }
            if !may_begin(&buffer[..count]) {
                break;
            }
        }
        Ok(count)
    }
}

/// Returns whether these bytes are fewer than tell a format, all of whose files begin with them.
fn may_begin(first: &[u8]) -> bool {
    let begins = |magic: &[u8]| magic.len() > first.len() && magic.starts_with(first);
    let scenes = x3d::CLASSIC_HEADERS.into_iter().chain([gltf::MAGIC]);
    BEGINNINGS.iter().map(|(magic, _)| *magic).chain(scenes).any(begins)
}

/// Detects the format of a file of `length` bytes that begins with `first`.
fn of_bytes(first: &[u8], length: u64) -> Option<Content> {
    if first.starts_with(&[0x1f, 0x8b]) {
        return Some(of_gzip(first));
    }
    if let Some((_, what)) = BEGINNINGS.iter().find(|(magic, _)| first.starts_with(magic)) {
        return Some(Content::Other(what));
    }
    if is_classic_x3d(first) {
        return Some(Content::X3d);
    }
    let what = match first {
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("a WebP picture"),
        [b'B', b'M', _, _, _, _, 0, 0, 0, 0, ..] => Some("a BMP picture"),
        [b'P', b'1'..=b'7', b' ' | b'\n' | b'\r' | b'\t', ..] => Some("a PNM picture"),
        [_, _, _, _, b'f', b't', b'y', b'p', ..] => Some("a film or a HEIF picture"),
        _ => None,
    };
    if first.starts_with(gltf::MAGIC) || is_gltf(first) {
        return Some(Content::Gltf);
    }
    let mesh = || MeshFormat::recognize(first, length).map(Content::Mesh);
    let obj = || is_obj(first).then_some(Content::Mesh(MeshFormat::Obj));
    what.map(Content::Other).or_else(|| of_xml(first)).or_else(mesh).or_else(obj)
}

/// Detects bytes that begin no stream of commands, whatever they are: text in UTF-16, and a first
/// line with NUL bytes, unless it begins with a binary command.
fn of_no_text(first: &[u8]) -> Option<Content> {
    if first.starts_with(b"\xff\xfe") || first.starts_with(b"\xfe\xff") {
        return Some(Content::Other("text in UTF-16"));
    }
    let line = first.split(|&b| b == b'\n').next().unwrap_or(first);
    let is_command = line.starts_with(b"PB") || line.starts_with(b"PXMULTI");
    (line.contains(&0) && !is_command).then_some(Content::Other("a binary file of an unknown format"))
}

/// Detects what the first bytes of a gzip file contain.
fn of_gzip(first: &[u8]) -> Content {
    let mut text = Vec::new();
    // The file goes on, and may be damaged: what is inflated until then decides.
    let _ = flate2::read::GzDecoder::new(first).take(FIRST_BYTES).read_to_end(&mut text);
    let ascii = text.iter().filter(|b| b.is_ascii_graphic());
    match ascii.copied().next() {
        None | Some(b'<') => Content::X3d,
        Some(_) if is_classic_x3d(&text) => Content::X3d,
        Some(_) => Content::Other("a gzip file, and what it contains is no X3D scene"),
    }
}

/// Returns whether a file is X3D in the classic encoding, or VRML 97.
fn is_classic_x3d(first: &[u8]) -> bool {
    let text = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first);
    x3d::CLASSIC_HEADERS.iter().any(|header| text.starts_with(header))
}

/// Returns whether the first line that is neither empty nor a comment is a statement of OBJ.
fn is_obj(first: &[u8]) -> bool {
    let text = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first);
    let lines = text.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let statement = { lines }.find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let word = statement.and_then(|line| line.split(u8::is_ascii_whitespace).next());
    word.is_some_and(|word| OBJ_STATEMENTS.contains(&word))
}

/// Returns whether a file is JSON with keys specific to glTF.
fn is_gltf(first: &[u8]) -> bool {
    let has = |key: &[u8]| contains(first, key);
    let is_json = first.trim_ascii_start().starts_with(b"{");
    is_json
        && (has(b"\"bufferViews\"") || has(b"\"accessors\"") || (has(b"\"asset\"") && has(b"\"version\"")))
}

/// Detects XML formats by their tags; `None` for other text.
fn of_xml(first: &[u8]) -> Option<Content> {
    // Of UTF-16 the ASCII letters of tags remain; a byte order mark is dropped.
    let mut graphic = first.iter().copied().filter(u8::is_ascii_graphic).peekable();
    if graphic.peek() != Some(&b'<') {
        return None;
    }
    let text: String = graphic.map(char::from).collect();
    let found = TAGS.iter().filter_map(|(tag, content)| Some((text.find(tag)?, *content)));
    found.min_by_key(|(at, _)| *at).map(|(_, content)| content)
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|w| w == part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Verb;
    use std::io::Write;

    fn of(bytes: &[u8]) -> Option<Content> {
        of_bytes(bytes, bytes.len() as u64)
    }

    #[test]
    fn foreign_formats_are_known_by_their_bytes() {
        for (bytes, what) in [
            (&b"\x89PNG\r\n\x1a\n\0\0"[..], "a PNG picture"),
            (b"\xff\xd8\xff\xe0", "a JPEG picture"),
            (b"P6 1 1 255\nabc", "a PNM picture"),
            (b"BM\x46\0\0\0\0\0\0\0", "a BMP picture"),
            (b"<?xml version='1.0'?>\n<COLLADA>", "a COLLADA model"),
            (b"#VRML V1.0 ascii", "a VRML 1.0 scene"),
        ] {
            assert_eq!(of(bytes), Some(Content::Other(what)));
        }
    }

    /// Gives one byte at a time.
    struct Slow(&'static [u8]);

    impl Read for Slow {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = self.0.len().min(1);
            self.0.read(&mut buffer[..count])
        }
    }

    #[test]
    fn an_input_of_another_format_ends_however_its_bytes_arrive() {
        let failed = || Arc::new(AtomicBool::new(false));
        for bytes in [&b"\x89PNG\r\n\x1a\n\0\0CLEAR red\n"[..], b"glTF\x02\0\0\0more", b"%PDF-1.7\nSIZE\n"] {
            let (at_once, slowly) = (failed(), failed());
            let mut read = Vec::new();
            let mut input = CommandInput::new(bytes, at_once.clone());
            input.read_to_end(&mut read).unwrap();
            assert_eq!(input.read(&mut [0; 9]).unwrap(), 0, "it is over");
            CommandInput::new(Slow(bytes), slowly.clone()).read_to_end(&mut read).unwrap();
            assert_eq!(read, b"");
            assert!(at_once.load(Ordering::Acquire) && slowly.load(Ordering::Acquire));
        }
        for bytes in [&b"ID3\x03\0\0\nCLEAR red\n"[..], b"\xff\xfeC\0L\0E\0A\0R\0\n\0"] {
            let (has_failed, mut read) = (failed(), Vec::new());
            CommandInput::new(bytes, has_failed.clone()).read_to_end(&mut read).unwrap();
            assert!(read.is_empty() && has_failed.load(Ordering::Acquire));
        }
        for commands in [&b"PB\0\0\x01\0abcd"[..], b"PXMULTI\0\0\0\0\0\0\0\0", b"\n\0\n", b"# A\n\0"] {
            let (has_failed, mut read) = (failed(), Vec::new());
            CommandInput::new(commands, has_failed.clone()).read_to_end(&mut read).unwrap();
            assert!(read == commands && !has_failed.load(Ordering::Acquire));
        }
        for commands in [&b"GRID\nPX 1 1\n"[..], b"%\n", b"", b"\x89P"] {
            let (mut read, has_failed) = (Vec::new(), failed());
            CommandInput::new(Slow(commands), has_failed.clone()).read_to_end(&mut read).unwrap();
            assert_eq!(read, commands);
            assert!(!has_failed.load(Ordering::Acquire));
        }
    }

    #[test]
    fn gltf_is_known_by_its_magic_number_and_its_keys() {
        for bytes in [&b"glTF\x02\0\0\0"[..], b" {\n \"asset\": {\"version\": \"2.0\"}}"] {
            assert_eq!(of(bytes), Some(Content::Gltf));
        }
    }

    #[test]
    fn meshes_are_known_by_their_bytes() {
        let binary_stl = [&[b's'; 80][..], &2_u32.to_le_bytes(), &[7; 100]].concat();
        for (bytes, format) in [
            (&b"solid cube\n facet normal 0 0 1\n"[..], MeshFormat::Stl),
            (&binary_stl, MeshFormat::Stl),
            (b"ply\nformat ascii 1.0\n", MeshFormat::Ply),
            (b"ply\r\n", MeshFormat::Ply),
            (b"v 0 0 0\nf 1 1 1\n", MeshFormat::Obj),
            (b"\xef\xbb\xbf# made by hand\r\n\r\n  mtllib a.mtl\r\n", MeshFormat::Obj),
            (b"g\rv 1 2 3\r", MeshFormat::Obj),
        ] {
            assert_eq!(of(bytes), Some(Content::Mesh(format)));
        }
    }

    #[test]
    fn x3d_is_known_by_its_tags_and_by_gzip() {
        assert_eq!(of(b"\x1f\x8b\x08"), Some(Content::X3d));
        let gzip = |text: &str| {
            let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
            packer.write_all(text.as_bytes()).unwrap();
            packer.finish().unwrap()
        };
        assert_eq!(of(&gzip("\u{feff}<?xml version='1.0'?><X3D/>")), Some(Content::X3d));
        assert!(matches!(of(&gzip("SIZE 30 20\n")), Some(Content::Other(_))));
        assert_eq!(of(b"\xef\xbb\xbf<?xml version='1.0'?>\n<X3D profile='Full'>"), Some(Content::X3d));
        let utf16: Vec<u8> = "\u{feff}<?xml?><X3D>".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(of(&utf16), Some(Content::X3d));
        for classic in ["#VRML V2.0 utf8\nBox {}", "\u{feff}#X3D V3.3 utf8\r\n"] {
            assert_eq!([of(classic.as_bytes()), of(&gzip(classic))], [Some(Content::X3d); 2]);
        }
    }

    #[test]
    fn no_verb_is_a_statement_of_obj() {
        for word in OBJ_STATEMENTS {
            let word = std::str::from_utf8(word).unwrap();
            assert!(Verb::all().iter().all(|verb| !verb.name.eq_ignore_ascii_case(word)), "{word}");
        }
    }

    #[test]
    fn streams_and_own_json_are_left_to_their_names() {
        for text in [
            "PX 1 1 ff0000\nLINE 0 0 9 5 00ff00\n",
            "# v 0 0 0\n",
            "# a stream\nVERSION\nv 0 0 0\n",
            "{\"dim\": 4, \"objects\": []}",
            "solid",
            "BMP",
            "PNG",
            "",
            "P3D",
            "MM",
        ] {
            assert_eq!(of(text.as_bytes()), None, "{text}");
        }
    }
}
