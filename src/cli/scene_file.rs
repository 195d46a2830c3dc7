//! Scene files by name: an X3D document, an OBJ mesh or an N-dimensional scene, read with everything that they refer to.

use super::magic::{self, Content};
use super::mesh_args::MeshArgs;
use super::{Status, say_as_program};
use crate::eye::EyeScene;
use crate::load::x3d::X3dDocument;
use crate::load::{self, LoadContext, LoadError, LoadMemory, SandboxDir, path_inside};
use crate::scene::Geometry;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// A scene file, read.
pub(super) enum SceneFile {
    X3d(Box<X3dDocument>),
    Obj {
        geometry: Arc<Geometry>,
        /// Whether its back can be seen.
        is_open: bool,
    },
    Eye(Box<EyeScene>),
}

/// Why a scene file is no use.
pub(super) enum SceneError {
    /// There is none, or its name says no format.
    NoFile(String),
    /// It was refused.
    Refused(String),
}

impl SceneError {
    /// Says it; the exit status.
    pub(super) fn say(self) -> Status {
        match self {
            SceneError::NoFile(message) => {
                say_as_program(message);
                Status::BadArguments
            }
            SceneError::Refused(message) => {
                say_as_program(message);
                Status::Failed
            }
        }
    }
}

/// The largest scene file that is read.
const MAX_BYTES: u64 = 4 << 30;

/// What a scene was read from, so that a change of it is seen.
#[derive(Default)]
pub(super) struct Watch {
    files: Vec<(PathBuf, Stamp)>,
}

/// What changes when a file does: whether it is there, its length, when it was written.
type Stamp = Option<(u64, Option<SystemTime>)>;

fn stamp(path: &Path) -> Stamp {
    std::fs::metadata(path).ok().map(|m| (m.len(), m.modified().ok()))
}

impl Watch {
    /// Forgets what was read, and begins with this file.
    pub fn begin(&mut self, path: &Path) {
        self.files.clear();
        self.add(path.to_owned());
    }

    fn add(&mut self, path: PathBuf) {
        let stamp = stamp(&path);
        self.files.push((path, stamp));
    }

    /// Whether anything changed since it was read, or since the last call.
    #[cfg(feature = "window")]
    pub fn has_changed(&mut self) -> bool {
        let mut has_changed = false;
        for (path, before) in &mut self.files {
            let now = stamp(path);
            has_changed |= std::mem::replace(before, now) != now;
        }
        has_changed
    }
}

const ENDINGS: [&str; 4] = ["x3d", "x3dz", "obj", "json"];

/// How a scene file is read.
#[derive(Clone, Copy)]
pub(super) struct ReadOptions<'a> {
    /// The folder that the scene may read others from, where it is not its own.
    pub root: Option<&'a Path>,
    pub meshes: &'a MeshArgs,
}

fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Whether a file is a scene, by its first bytes or by its name.
///
/// # Errors
/// When it is a file of another kind, or cannot be read.
pub(super) fn is_scene(path: &Path) -> Result<bool, SceneError> {
    let no_file = |e: std::io::Error| SceneError::NoFile(format!("{}: {e}", path.display()));
    match magic::of_path(path).map_err(no_file)? {
        Some(Content::X3d) => Ok(true),
        Some(Content::Other(what)) => Err(SceneError::NoFile(format!(
            "{}: {what}; expected a scene (.x3d, .obj or .json) or a stream of commands",
            path.display()
        ))),
        None => Ok(has_scene_ending(path)),
    }
}

/// Whether a name is that of a scene.
pub(super) fn has_scene_ending(path: &Path) -> bool {
    ENDINGS.contains(&ending(path).as_str())
}

/// The folder that a scene's file may read others from, and where in it the scene stands.
struct Root {
    /// `None` where it cannot be opened: nothing is found in it.
    folder: Option<SandboxDir>,
    /// Its path, as it was given.
    path: PathBuf,
    /// The scene's folder inside, with `/` at its end unless empty.
    own: String,
}

impl Root {
    /// The scene's own folder, or the one that was asked for.
    fn of(scene: &Path, asked: Option<&Path>) -> Result<Root, SceneError> {
        let beside = |p: &Path| if p.as_os_str().is_empty() { PathBuf::from(".") } else { p.to_owned() };
        let own = beside(scene.parent().unwrap_or(Path::new("")));
        let Some(asked) = asked else {
            let path = scene.parent().unwrap_or(Path::new("")).to_owned();
            return Ok(Root { folder: SandboxDir::open(&own).ok(), path, own: String::new() });
        };
        let bad = |what: String| SceneError::NoFile(format!("--root {}: {what}", asked.display()));
        let folder = SandboxDir::open(asked).map_err(|e| bad(e.to_string()))?;
        let real = std::fs::canonicalize(&own).map_err(|e| bad(format!("{}: {e}", own.display())))?;
        let inside = real.strip_prefix(folder.root());
        let inside = inside.map_err(|_| bad(format!("{} does not lie in it", scene.display())))?;
        let steps = inside.iter().map(|step| step.to_str().map(|step| format!("{step}/")));
        let own = steps.collect::<Option<String>>();
        let own = own.ok_or_else(|| bad(format!("the path to {} is no UTF-8", scene.display())))?;
        Ok(Root { folder: Some(folder), path: asked.to_owned(), own })
    }
}

/// Reads the scene at `path`; what it refers to is looked for in its folder, or in the root. Warnings
/// go to stderr.
pub(super) fn read(path: &Path, options: ReadOptions) -> Result<SceneFile, SceneError> {
    read_watched(path, options, &mut Watch::default())
}

/// The bytes of a scene file, and the ending that its format has.
fn read_bytes(path: &Path, meshes: &MeshArgs) -> Result<(String, Vec<u8>), SceneError> {
    let name = path.display().to_string();
    let no_file = |e: std::io::Error| SceneError::NoFile(format!("{name}: {e}"));
    let ending = match magic::of_path(path).map_err(no_file)? {
        Some(Content::X3d) => "x3d".to_owned(),
        Some(Content::Other(what)) => {
            return Err(SceneError::NoFile(format!("{name}: {what}; expected a scene: .x3d, .obj or .json")));
        }
        None => ending(path),
    };
    if meshes.smooth.is_some() && ending != "obj" {
        return Err(SceneError::NoFile(format!("--smooth is for .obj meshes: {name} is none")));
    }
    let meta = std::fs::metadata(path).map_err(no_file)?;
    if meta.is_dir() {
        return Err(SceneError::NoFile(format!("{name}: is a folder")));
    }
    if meta.len() > MAX_BYTES {
        return Err(SceneError::Refused(format!(
            "{name}: {} bytes are over the limit of {MAX_BYTES}",
            meta.len()
        )));
    }
    if !ENDINGS.contains(&ending.as_str()) {
        return Err(SceneError::NoFile(format!(
            "{name}: expected a name that ends in .x3d, .x3dz, .obj or .json"
        )));
    }
    Ok((ending, std::fs::read(path).map_err(no_file)?))
}

/// [`read`], and notes every file that was read or looked for.
pub(super) fn read_watched(
    path: &Path,
    ReadOptions { root, meshes }: ReadOptions,
    watch: &mut Watch,
) -> Result<SceneFile, SceneError> {
    watch.begin(path);
    let name = path.display().to_string();
    let (ending, bytes) = read_bytes(path, meshes)?;
    let has_root = root.is_some();
    let root = Root::of(path, root)?;
    let mut inside = |name: &str| {
        // Looked for and not found: it may come.
        watch.add(root.path.join(name));
        root.folder.as_ref()?.read(name, MAX_BYTES).ok()
    };
    let refused = |e: LoadError| SceneError::Refused(e.to_string());
    match ending.as_str() {
        "x3d" | "x3dz" => {
            let memory = &mut LoadMemory::unlimited();
            let context = LoadContext { folder: &root.own, opener: &mut inside, memory };
            let document = load::x3d::parse_in(&bytes, &name, context).map_err(refused)?;
            document.warnings().iter().for_each(say_as_program);
            if document.names_outside() && !has_root {
                say_as_program(format_args!("--root DIR lets {name} read files above its own folder"));
            }
            Ok(SceneFile::X3d(Box::new(document)))
        }
        "obj" => {
            let mut beside = |name: &str| inside(&path_inside(&root.own, name)?);
            let memory = &mut LoadMemory::unlimited();
            let loaded = load::obj::parse_smooth(&bytes, &mut beside, &name, memory, meshes.smoothing());
            let loaded = loaded.map_err(refused)?;
            loaded.warnings.iter().for_each(say_as_program);
            Ok(SceneFile::Obj { geometry: Arc::new(loaded.geometry), is_open: loaded.is_open })
        }
        _ => {
            let scene =
                EyeScene::from_json(&bytes).map_err(|e| SceneError::Refused(format!("{name}: {e}")))?;
            Ok(SceneFile::Eye(Box::new(scene)))
        }
    }
}
