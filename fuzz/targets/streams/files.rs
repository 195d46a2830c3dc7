//! Makes a folder of odd files for `LOAD`, and one for `SNAP`.

use super::payloads::PICTURES;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;

/// Arguments of LOAD: files that exist, that do not, and that must not be reached.
pub const NAMES: [&str; 24] = [
    "box.obj",
    "quad.obj",
    "empty.obj",
    "cut.png",
    "good.png",
    "huge.png",
    "scene.x3d",
    "inline.x3d",
    "loop.x3d",
    "folder",
    "link.obj",
    "chain.obj",
    "itself.obj",
    "nowhere.obj",
    "linked/in.obj",
    "linked.x3d",
    "outside",
    "fifo",
    "missing.obj",
    "../box.obj",
    "folder/in.obj",
    "/etc/passwd",
    "binary.obj",
    "textured.x3d",
];

/// File beside the folders, the target of a link in the snapshot folder.
const ELSEWHERE: &str = "elsewhere.png";

/// Folders of this process, within a temporary one.
pub struct Folders {
    root: PathBuf,
}

impl Folders {
    /// Creates the folders and their files.
    pub fn new() -> std::io::Result<Folders> {
        let root = std::env::temp_dir().join(format!("fbptr-fuzz-{}", std::process::id()));
        let load = root.join("load");
        fs::create_dir_all(load.join("folder"))?;
        fs::create_dir_all(root.join("snap"))?;
        let put = |name: &str, bytes: &[u8]| fs::write(load.join(name), bytes);
        let quad = include_bytes!("../../../tests/data/meshes/tobj/quad.obj");
        put("box.obj", include_bytes!("../../../tests/data/meshes/assimp/box.obj"))?;
        put("quad.obj", quad)?;
        put("folder/in.obj", quad)?;
        put("empty.obj", b"")?;
        put("binary.obj", &(0..=255).cycle().take(3000).collect::<Vec<u8>>())?;
        put("good.png", PICTURES[0])?;
        put("cut.png", &PICTURES[1][..PICTURES[1].len() / 2])?;
        put("huge.png", &huge_png())?;
        put("scene.x3d", include_bytes!("../../../tests/data/x3d/lecture-003/transparent.x3d"))?;
        put("inline.x3d", x3d("<Inline url='\"scene.x3d\"'/><Inline url='\"missing.x3d\"'/>").as_bytes())?;
        put("loop.x3d", x3d("<Inline url='\"loop.x3d\"'/>").as_bytes())?;
        let textured =
            "<Shape><Appearance><ImageTexture url='\"good.png\" \"huge.png\"'/></Appearance><Box/></Shape>";
        put("textured.x3d", x3d(textured).as_bytes())?;
        put("linked.x3d", x3d("<Inline url='\"link.x3d\"'/><Inline url='\"outside/passwd\"'/>").as_bytes())?;
        let links = [
            ("box.obj", "link.obj"),
            ("link.obj", "chain.obj"),
            ("itself.obj", "itself.obj"),
            ("missing.obj", "nowhere.obj"),
            ("folder", "linked"),
            ("scene.x3d", "link.x3d"),
        ];
        for (to, name) in links {
            let _ = symlink(to, load.join(name));
        }
        let _ = symlink("/etc", load.join("outside"));
        let _ = symlink(root.join(ELSEWHERE), root.join("snap/link.png"));
        for fifo in [load.join("fifo"), root.join("snap/fifo.png")] {
            let _ = fs::remove_file(&fifo);
            std::process::Command::new("mkfifo").arg(&fifo).status()?;
        }
        Ok(Folders { root })
    }

    /// Returns the folder that LOAD reads.
    pub fn load(&self) -> PathBuf {
        self.root.join("load")
    }

    /// Returns the folder that SNAP writes.
    pub fn snap(&self) -> PathBuf {
        self.root.join("snap")
    }

    /// Panics if something was written outside the snapshot folder.
    pub fn check(&self) {
        for name in ["a.png", ELSEWHERE] {
            assert!(!self.root.join(name).exists(), "{name} was written outside the snapshot folder");
        }
    }
}

fn x3d(nodes: &str) -> String {
    format!("<X3D profile='Interchange' version='3.3'><Scene>{nodes}</Scene></X3D>")
}

/// Returns the first picture with a header of 60,000 x 60,000 pixels and a valid checksum of that
/// header.
fn huge_png() -> Vec<u8> {
    let mut bytes = PICTURES[0].to_vec();
    bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let crc = bytes[12..29].iter().fold(!0u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    });
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}
