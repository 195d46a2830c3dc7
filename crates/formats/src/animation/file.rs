//! Scene files of every format, from their bytes.

use crate::load::gltf::GltfDocument;
use crate::load::x3d::X3dDocument;
use crate::load::{self, LoadContext, LoadMemory, MeshFormat, Smoothing, path_inside};
use fbptr_core::eye::EyeScene;
use fbptr_core::memory::Reservation;
use fbptr_core::scene::Geometry;
use std::sync::Arc;

/// Format of a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFormat {
    /// X3D in XML or the classic encoding, or VRML 97, plain or compressed.
    X3d,
    /// glTF 2.0, as JSON or binary.
    Gltf,
    /// A mesh.
    Mesh(MeshFormat),
    /// A scene of N dimensions, as JSON.
    Eye,
}

impl SceneFormat {
    /// Returns the format for the extension of a file name, in either case.
    pub fn of_ending(ending: &str) -> Option<Self> {
        Some(match ending.to_ascii_lowercase().as_str() {
            "x3d" | "x3dz" | "x3dv" | "x3dvz" | "wrl" | "wrz" => SceneFormat::X3d,
            "gltf" | "glb" => SceneFormat::Gltf,
            "obj" => SceneFormat::Mesh(MeshFormat::Obj),
            "stl" => SceneFormat::Mesh(MeshFormat::Stl),
            "ply" => SceneFormat::Mesh(MeshFormat::Ply),
            "json" => SceneFormat::Eye,
            _ => return None,
        })
    }
}

/// The contents of a scene file.
pub enum SceneFile {
    /// An X3D document.
    X3d(Box<X3dDocument>),
    /// A glTF document.
    Gltf(Box<GltfDocument>),
    /// A mesh.
    Mesh {
        /// The mesh with its materials.
        geometry: Arc<Geometry>,
        /// True if the back faces can be seen.
        is_open: bool,
    },
    /// A scene of N dimensions.
    Eye(Box<EyeScene>),
}

/// Source of a scene: the file's bytes and what it may read beside them.
pub struct SceneSource<'a> {
    /// Bytes of the file.
    pub bytes: &'a [u8],
    /// Format of the file.
    pub format: SceneFormat,
    /// Name of the file, for messages.
    pub name: &'a str,
    /// Folder of the file below the root that `opener` reads from, with a final `/` unless empty.
    pub folder: &'a str,
    /// Returns the bytes of a file by its name below the root, or `None`.
    pub opener: &'a mut dyn FnMut(&str) -> Option<Vec<u8>>,
    /// Source of normals for meshes without.
    pub smoothing: Smoothing,
    /// Limits of the memory that reading takes, and of what it makes.
    pub memory: LoadMemory,
}

/// A scene that was read.
pub struct LoadedScene {
    /// Its contents.
    pub file: SceneFile,
    /// Messages about skipped parts, in the file's order.
    pub warnings: Vec<String>,
    /// True if the scene names files above the root.
    pub names_outside: bool,
    /// CRC-32 of the file's bytes and of those of every file that it read, in order.
    pub crc: u32,
    /// The memory that the contents hold.
    pub held: Reservation,
}

impl SceneFile {
    /// Reads a scene with everything that it refers to.
    ///
    /// # Errors
    /// The message of the parser, with file and place.
    pub fn read(source: SceneSource) -> Result<LoadedScene, String> {
        let SceneSource { bytes, format, name, folder, opener, smoothing, mut memory } = source;
        let mut crc = crc32fast::Hasher::new();
        crc.update(bytes);
        let mut open = |name: &str| {
            let found = opener(name);
            // A missing file counts too: it may be there on another machine.
            crc.update(&found.as_ref().map_or(u64::MAX, |bytes| bytes.len() as u64).to_le_bytes());
            crc.update(found.as_deref().unwrap_or_default());
            found
        };
        let limits = &mut memory;
        let texts = |warnings: &[load::LoadWarning]| warnings.iter().map(ToString::to_string).collect();
        let (file, warnings, names_outside) = match format {
            SceneFormat::X3d => {
                let context = LoadContext { folder, opener: &mut open, memory: limits };
                let document = load::x3d::parse_in(bytes, name, context).map_err(|e| e.to_string())?;
                let (warnings, outside) = (texts(document.warnings()), document.names_outside());
                (SceneFile::X3d(Box::new(document)), warnings, outside)
            }
            SceneFormat::Gltf => {
                let context = LoadContext { folder, opener: &mut open, memory: limits };
                let document = load::gltf::parse_in(bytes, name, context).map_err(|e| e.to_string())?;
                let (warnings, outside) = (texts(document.warnings()), document.names_outside());
                (SceneFile::Gltf(Box::new(document)), warnings, outside)
            }
            SceneFormat::Mesh(format) => {
                let mut names_outside = false;
                let mut beside = |name: &str| {
                    let path = path_inside(folder, name);
                    names_outside |= path.is_none() && name.split(['/', '\\']).any(|step| step == "..");
                    open(&path?)
                };
                let loaded = format.parse(bytes, &mut beside, name, limits, smoothing);
                let loaded = loaded.map_err(|e| e.to_string())?;
                let mesh = SceneFile::Mesh { geometry: Arc::new(loaded.geometry), is_open: loaded.is_open };
                (mesh, texts(&loaded.warnings), names_outside)
            }
            SceneFormat::Eye => {
                let scene = EyeScene::from_json(bytes).map_err(|e| format!("{name}: {e}"))?;
                (SceneFile::Eye(Box::new(scene)), Vec::new(), false)
            }
        };
        Ok(LoadedScene { file, warnings, names_outside, crc: crc.finalize(), held: memory.into_kept() })
    }

    /// Returns whether the scene changes with time.
    pub fn is_animated(&self) -> bool {
        match self {
            SceneFile::X3d(document) => document.is_animated(),
            SceneFile::Gltf(document) => document.is_animated(),
            SceneFile::Mesh { .. } | SceneFile::Eye(_) => false,
        }
    }
}
