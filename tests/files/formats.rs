//! glTF, STL and PLY files: golden pictures, refusals with their place, and damaged files.

use crate::support::{check as check_scene, draw};
use fbptr::load::gltf::{self, GltfDocument};
use fbptr::load::{LoadContext, LoadError, LoadMemory, MeshFormat, SandboxDir, Smoothing};
use fbptr::memory::MemoryBudget;
use fbptr::save::golden::{Mode, Tolerance, check};
use fbptr::scene::Scene;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Width over height of the pictures.
const ASPECT: f64 = 120.0 / 90.0;
/// Memory for reading any of the files.
const BUDGET: u64 = 256 << 20;

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/formats")
}

/// Returns the names of the test files in a folder, sorted.
fn files() -> Vec<String> {
    let mut found = Vec::new();
    for folder in ["gltf", "gltf/beside", "ply", "stl"] {
        for entry in fs::read_dir(data().join(folder)).expect("readable") {
            let name = entry.expect("an entry").file_name().into_string().expect("ASCII");
            if [".gltf", ".glb", ".ply", ".stl"].iter().any(|ending| name.ends_with(ending)) {
                found.push(format!("{folder}/{name}"));
            }
        }
    }
    found.sort();
    found
}

/// A file that was read.
enum Loaded {
    Gltf(Box<GltfDocument>),
    Mesh(Box<Scene>),
}

impl Loaded {
    fn at(&self, time: f64) -> Scene {
        match self {
            Loaded::Gltf(document) => document.at(time, ASPECT),
            Loaded::Mesh(scene) => (**scene).clone(),
        }
    }
}

/// Reads the bytes as the file with this name.
fn read(name: &str, bytes: &[u8]) -> Result<(Loaded, Vec<String>), LoadError> {
    let memory = &mut LoadMemory::new(&MemoryBudget::new(BUDGET), u64::MAX);
    let file = name.rsplit('/').next().expect("a name");
    if name.starts_with("gltf") {
        let folder = data().join(name);
        let folder = SandboxDir::open(folder.parent().expect("a folder")).expect("a folder");
        let opener = &mut |name: &str| folder.read(name, 1 << 20).ok();
        let document = gltf::parse_in(bytes, file, LoadContext { folder: "", opener, memory })?;
        let warnings = document.warnings().iter().map(|w| w.to_string()).collect();
        return Ok((Loaded::Gltf(Box::new(document)), warnings));
    }
    let format = if name.starts_with("stl") { MeshFormat::Stl } else { MeshFormat::Ply };
    let loaded = format.parse(bytes, &mut |_| None, file, memory, Smoothing::Angle(1.0))?;
    let warnings = loaded.warnings.iter().map(|w| w.to_string()).collect();
    let scene = Scene::of_mesh(Arc::new(loaded.geometry), "m", ASPECT, loaded.is_open);
    Ok((Loaded::Mesh(Box::new(scene)), warnings))
}

#[test]
fn every_file_looks_as_it_did() {
    let mut failures = Vec::new();
    for name in files().iter().filter(|name| !name.contains("broken")) {
        let (loaded, _) = read(name, &fs::read(data().join(name)).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        let is_animated = matches!(&loaded, Loaded::Gltf(document) if document.is_animated());
        let times: &[f64] = if is_animated { &[0.0, 0.6, 1.5] } else { &[0.0] };
        for time in times {
            let scene = loaded.at(*time);
            check_scene(&scene);
            let memory = draw(&scene, 120, 90);
            let file = format!("{}-at-{time}.png", name.replace(['/', '.'], "-"));
            let golden = data().join("golden").join(file);
            failures.extend(
                check(&memory, golden, Tolerance::EXACT, Mode::from_env()).err().map(|e| e.to_string()),
            );
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn files_of_several_spellings_look_the_same() {
    let picture = |name: &str| {
        let (loaded, _) = read(name, &fs::read(data().join(name)).unwrap()).unwrap();
        draw(&loaded.at(0.0), 120, 90).bytes().to_vec()
    };
    let cube = picture("stl/cube_text.stl");
    for name in ["cube_binary", "begins_with_solid", "upper_case_crlf", "bytes_after", "latin_name"] {
        assert!(picture(&format!("stl/{name}.stl")) == cube, "{name}");
    }
    assert!(picture("ply/cube_little_endian.ply") == picture("ply/cube_big_endian.ply"));
    assert!(picture("ply/cube_text.ply") == picture("ply/other_elements.ply"));
    assert!(picture("ply/cube_text.ply") == cube);
}

#[test]
fn broken_files_are_refused_and_odd_ones_warned_of_with_their_place() {
    for (name, expected) in [
        (
            "ply/broken_count.ply",
            "broken_count.ply:byte 148: not a readable PLY: 4000000000 rows of \"vertex\" need 48000000000 \
             bytes or more, and 0 are left",
        ),
        (
            "stl/broken_count.stl",
            "broken_count.stl:byte 80: not a readable STL: 4000000000 facets need 200000000084 bytes, and \
             the file has 684",
        ),
        ("ply/broken_index.ply", "broken_index.ply:19: vertex index 8 names none of the 8 there are"),
        (
            "gltf/broken_accessor.glb",
            "broken_accessor.glb#/meshes/0/primitives/0/attributes/POSITION: accessor index 7 names none of \
             the 0 there are",
        ),
        (
            "gltf/broken_index.gltf",
            "broken_index.gltf#/meshes/0/primitives/0/indices: vertex index 99 names none of the 24 there are",
        ),
        ("gltf/broken_length.glb", "broken_length.glb:byte 12: not a readable GLB: no chunk of JSON"),
    ] {
        let refused = read(name, &fs::read(data().join(name)).unwrap()).err().expect("an error");
        assert_eq!(refused.to_string(), expected);
    }
    for (name, expected) in [
        (
            "gltf/beside/outside.gltf",
            &["outside.gltf#/images/0/uri: warning: the picture is left out: a file outside of the folder \
               that it may be read from: \"../four_colors.png\" cannot be found"][..],
        ),
        (
            "gltf/left_out.gltf",
            &["left_out.gltf#/extensionsUsed/0: warning: KHR_materials_clearcoat is not supported: it is \
               ignored"],
        ),
        ("gltf/wraps.glb", &[]),
        (
            "stl/bytes_after.stl",
            &["bytes_after.stl:byte 684: warning: 21 bytes after the last of 12 facets are left out"],
        ),
    ] {
        let (_, warnings) = read(name, &fs::read(data().join(name)).unwrap()).unwrap();
        assert_eq!(warnings, expected, "{name}");
    }
}

/// A generator of numbers (PCG without output permutation: its high bits).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }
}

/// Reads damaged bytes. They are read, or refused with a place; what is read can be drawn.
fn survive(name: &str, bytes: &[u8], how: &str) {
    match read(name, bytes) {
        Ok((loaded, _)) => {
            [0.0, 0.7].iter().for_each(|time| check_scene(&loaded.at(*time)));
        }
        Err(error) => {
            let file = name.rsplit('/').next().expect("a name");
            let text = error.to_string();
            let rest = text.strip_prefix(file).unwrap_or_else(|| panic!("{how}: {text}"));
            let has_place = rest.starts_with('#')
                || rest.starts_with(":byte ")
                || rest[1..].starts_with(|c: char| c.is_ascii_digit());
            // An empty budget has no place: the whole file is too much.
            assert!(has_place || error.code() == fbptr::error::Code::Quota, "{how}: {text}");
        }
    }
}

#[test]
fn damaged_files_are_survived() {
    let mut random = Random(20_261_123);
    for name in files() {
        let bytes = fs::read(data().join(&name)).unwrap();
        for step in 0..40 {
            let cut = random.below(bytes.len());
            survive(&name, &bytes[..cut], &format!("{name} cut at {cut}"));
            let mut flipped = bytes.clone();
            let mut places = Vec::new();
            for _ in 0..1 + step % 4 {
                let at = random.below(bytes.len());
                flipped[at] = [flipped[at] ^ (1 << random.below(8)), random.below(256) as u8, 0xff, b'9']
                    [random.below(4)];
                places.push((at, flipped[at]));
            }
            survive(&name, &flipped, &format!("{name} with {places:?}"));
            let mut doubled = bytes.clone();
            let from = random.below(bytes.len());
            let to = from + random.below(bytes.len() - from);
            let piece = bytes[from..to].to_vec();
            doubled.splice(to..to, piece);
            survive(&name, &doubled, &format!("{name} with {from}..{to} twice"));
        }
    }
}

/// Replaces each number of a glTF file's JSON by hostile ones.
#[test]
fn hostile_numbers_are_survived() {
    for name in files().iter().filter(|name| name.ends_with(".gltf")) {
        let text = fs::read_to_string(data().join(name)).unwrap();
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '-' | '.');
        let mut at = 0;
        while let Some(start) = text[at..].find([' ', '[']).map(|i| at + i + 1) {
            let end = text[start..].find(|c| !is_number(c)).map_or(text.len(), |i| start + i);
            at = start;
            if end == start || text[start..end].starts_with('.') {
                continue;
            }
            for number in ["-1", "4294967295", "18446744073709551615", "1e308", "0.5", "null", "{}", "[]"] {
                let hostile = format!("{}{number}{}", &text[..start], &text[end..]);
                survive(name, hostile.as_bytes(), &format!("{name} with {number} at {start}"));
            }
        }
    }
}
