//! Prints the checksums of pictures that the lean core draws: the frames of the tour, every scene and
//! mesh of a folder of test data, and random scenes. Two builds of it print the same lines if they
//! draw the same bytes.
//!
//! Usage: `crcs DATA [COUNT] [--spoil] [--portable]`, where `DATA` is `tests/data` and `COUNT` the
//! number of random scenes. Pictures that have a golden file in `DATA/x3d/golden` are compared with
//! it; a difference, as a scene that no longer loads, ends the program with status 1. With
//! `--spoil` the lowest bit of one pixel of each random picture is changed, so that a comparison of
//! the lines can be tested. With `--portable` the random pictures are drawn by the portable path;
//! otherwise by the widest vectors, whose name is printed to standard error.

mod files;
mod random;

use fbptr::eye::EyeScene;
use fbptr::load::{SandboxDir, x3d};
use fbptr::pipeline::{self, SceneOptions};
use fbptr::save::golden;
use fbptr::simd::Level;
use fbptr::{Framebuffer, Scene};
use files::files;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Size of the golden pictures.
const SIZE: [u32; 2] = [120, 90];
/// Times at which scenes are drawn, in seconds.
const TIMES: [f64; 3] = [0.0, 1.0, 2.5];

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let (flags, words): (Vec<_>, Vec<_>) =
        std::env::args_os().skip(1).partition(|word| word == "--spoil" || word == "--portable");
    let mut words = words.into_iter();
    let data = PathBuf::from(words.next().ok_or("expected: crcs DATA [COUNT]")?);
    let count = words.next().map_or(Ok(200), |word| word.to_string_lossy().parse())?;
    for (i, crc) in fbptr_lean::Tour::play()?.crcs().iter().enumerate() {
        println!("tour {} {crc:08x}", i + 1);
    }
    for path in files(&data.join("x3d"), "x3d")? {
        x3d_pictures(&path, &data)?;
    }
    for path in files(&data.join("meshes"), "obj")? {
        mesh_picture(&path, &data)?;
    }
    for path in files(&data.join("nd-cases"), "json")? {
        let scene = EyeScene::from_json(&std::fs::read(&path)?)?;
        let mut fb = Framebuffer::new(SIZE[0], SIZE[1])?;
        fbptr::eye::blit(&fbptr::eye::render(&scene), fb.memory_mut(), 0, 0, SIZE[0] as i32, SIZE[1] as i32);
        println!("eye {} {:08x}", name(&path, &data), fb.crc());
    }
    let is_given = |flag: &str| flags.iter().any(|given| given == flag);
    let level = if is_given("--portable") { Level::Portable } else { Level::best() };
    eprintln!("random pictures by {} vectors", level.as_str());
    for seed in 0..count {
        let mut fb = random::picture(seed, Some(level))?;
        if is_given("--spoil") {
            let offset = seed * 4 % fb.memory().bytes().len() as u64;
            let byte = fb.peek(offset, 1)?[0];
            fb.poke(offset, &[byte ^ 1])?;
        }
        println!("random {seed} {:08x}", fb.crc());
    }
    Ok(())
}

/// Returns a file's path below the folder of test data.
fn name(path: &Path, data: &Path) -> String {
    path.strip_prefix(data).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// Prints the pictures of a scene at several times, by the reference and by the tile renderer.
fn x3d_pictures(path: &Path, data: &Path) -> Outcome {
    let name = name(path, data);
    let folder = SandboxDir::open(path.parent().ok_or("a folder")?)?;
    let document = match x3d::parse(&std::fs::read(path)?, &name, &mut |file| folder.read(file, 1 << 20).ok())
    {
        Ok(document) => document,
        Err(refused) => {
            println!("{refused}");
            return Ok(());
        }
    };
    for time in TIMES {
        let scene = document.at(time);
        let reference = by_reference(&scene)?;
        let mut fast = Framebuffer::new(SIZE[0], SIZE[1])?;
        let _ = fast.draw_scene(&scene)?;
        println!("{name} at {time} {:08x} {:08x}", reference.crc(), fast.crc());
        let stem = name.trim_start_matches("x3d/").replace('/', "-").replace(".x3d", "");
        let golden = data.join("x3d/golden").join(format!("{stem}-at-{time}.png"));
        if golden.exists() && golden::read_png(&golden)?.bytes() != reference.memory().bytes() {
            return Err(format!("{}: the picture is another", golden.display()).into());
        }
    }
    Ok(())
}

fn by_reference(scene: &Scene) -> Result<Framebuffer, Box<dyn Error>> {
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1])?;
    pipeline::draw_scene(&mut fb.target(), scene, &SceneOptions::new(SIZE[0], SIZE[1]))?;
    Ok(fb)
}

/// Prints the picture of a mesh, or why it is refused.
fn mesh_picture(path: &Path, data: &Path) -> Outcome {
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1])?;
    match fb.load_obj(path) {
        Ok(mesh) => {
            fb.show_whole(&mesh);
            let _ = fb.draw(&mesh)?;
            println!("{} {:08x}", name(path, data), fb.crc());
        }
        Err(refused) => println!("{} {}", name(path, data), refused.kind),
    }
    Ok(())
}
