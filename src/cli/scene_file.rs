//! Scene files: an X3D or glTF document, a mesh or an N-dimensional scene, read with everything that
//! they refer to.

use super::magic::{self, Content};
use super::mesh_args::{self, MeshArgs};
use super::{Status, say_as_program};
pub(super) use crate::animation::SceneFile;
use crate::animation::{LoadedScene, SceneFormat, SceneSource};
use crate::load::{self, LoadMemory, SandboxDir};
use crate::memory::{MemoryBudget, Reservation};
use crate::models::{self, BuiltInModel};
use crate::scene::Texture;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Error of reading a scene file.
pub(super) enum SceneError {
    /// The file is missing, or its name has no known extension.
    NoFile(String),
    /// The contents were refused.
    Refused(String),
}

impl SceneError {
    /// Prints the error, and returns the exit status.
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

/// Size limit of scene files in bytes.
const MAX_BYTES: u64 = 4 << 30;

/// The files that a scene was read from, to detect changes, and the memory that it holds.
pub(super) struct Watch {
    files: Vec<(PathBuf, Stamp)>,
    budget: MemoryBudget,
    held: Option<Reservation>,
}

/// Length and modification time of a file; `None` if it does not exist.
type Stamp = Option<(u64, Option<SystemTime>)>;

/// Reads a file's stamp.
fn stamp(path: &Path) -> Stamp {
    std::fs::metadata(path).ok().map(|m| (m.len(), m.modified().ok()))
}

impl Watch {
    /// Creates a watch of no files, for a scene within a memory budget.
    pub fn new(budget: &MemoryBudget) -> Watch {
        Watch { files: Vec::new(), budget: budget.clone(), held: None }
    }

    /// Clears the list, and starts it with this file; the memory of what was read before is free for
    /// what is read now.
    pub fn begin(&mut self, path: &Path) {
        self.held = None;
        self.files.clear();
        self.add(path.to_owned());
    }

    /// Counts the memory of the scene that was read, until the next is.
    pub fn hold(&mut self, held: Reservation) {
        self.held = Some(held);
    }

    fn add(&mut self, path: PathBuf) {
        let stamp = stamp(&path);
        self.files.push((path, stamp));
    }

    /// Returns whether any file changed since it was read, or since the last call.
    pub fn has_changed(&mut self) -> bool {
        let mut has_changed = false;
        for (path, before) in &mut self.files {
            let now = stamp(path);
            has_changed |= std::mem::replace(before, now) != now;
        }
        has_changed
    }
}

/// Extensions of scene files, for messages.
const EXPECTED: &str = "a scene: .x3d, .x3dz, .x3dv, .wrl, .gltf, .glb, .obj, .stl, .ply or .json";

/// Options of reading a scene file.
#[derive(Clone, Copy)]
pub(super) struct ReadOptions<'a> {
    /// Folder that the scene may read other files from; `None` is the scene's own.
    pub root: Option<&'a Path>,
    pub meshes: &'a MeshArgs,
}

/// Returns a path's extension in lower case, or an empty string.
fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Returns the built-in model that a path names; a file of that name comes first.
fn built_in(path: &Path) -> Option<&'static BuiltInModel> {
    models::named(path.to_str()?).filter(|_| !path.exists())
}

/// Prints the built-in models.
pub(super) fn list_models() -> Status {
    super::output::print(models::list());
    Status::Success
}

/// Returns the error of a file that cannot be opened. A plain name may have been meant for a
/// built-in model.
fn unopened(path: &Path, error: &std::io::Error) -> SceneError {
    let name = path.display().to_string();
    let is_plain = !name.contains(['/', '\\', '.']);
    let hint = match error.kind() {
        std::io::ErrorKind::NotFound if is_plain => "; --list names the models that need no file",
        _ => "",
    };
    SceneError::NoFile(format!("{name}: {error}{hint}"))
}

/// Returns the error of `--smooth` for a scene that is no mesh.
fn not_smoothed(name: &str) -> SceneError {
    SceneError::NoFile(format!("--smooth is for .obj, .stl and .ply meshes: {name} is none"))
}

/// Returns whether a file is a scene, by its first bytes or by its name.
///
/// # Errors
/// Fails if it is a file of another kind, or cannot be read.
pub(super) fn is_scene(path: &Path) -> Result<bool, SceneError> {
    if built_in(path).is_some() {
        return Ok(true);
    }
    match magic::of_path(path).map_err(|e| unopened(path, &e))? {
        Some(Content::X3d | Content::Gltf | Content::Mesh(_)) => Ok(true),
        Some(Content::Other(what)) => Err(SceneError::NoFile(format!(
            "{}: {what}; expected {EXPECTED}; or a stream of commands",
            path.display()
        ))),
        None => Ok(has_scene_ending(path)),
    }
}

/// Returns whether a path has the extension of a scene.
pub(super) fn has_scene_ending(path: &Path) -> bool {
    SceneFormat::of_ending(&ending(path)).is_some()
}

/// The folder that a scene may read other files from, and the scene's position in it.
struct Root {
    /// `None` if it cannot be opened: then no files are found.
    folder: Option<SandboxDir>,
    /// Path of the folder, as given.
    path: PathBuf,
    /// Path of the scene's folder inside, ending with `/` unless empty.
    own: String,
}

impl Root {
    /// Opens the scene's own folder, or `asked` if given.
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

/// Reads the scene at `path`. Files that it refers to are searched in its folder, or in the root.
/// Warnings go to stderr. The files, and what is made of them, are charged to `budget`.
pub(super) fn read(
    path: &Path,
    options: ReadOptions,
    budget: &MemoryBudget,
) -> Result<LoadedScene, SceneError> {
    read_watched(path, options, &mut Watch::new(budget))
}

/// Reads the bytes of a scene file, and determines its format.
fn read_bytes(
    path: &Path,
    meshes: &MeshArgs,
    memory: &LoadMemory,
) -> Result<(SceneFormat, Vec<u8>, Reservation), SceneError> {
    let name = path.display().to_string();
    let no_file = |e: std::io::Error| unopened(path, &e);
    let format = match magic::of_path(path).map_err(no_file)? {
        Some(Content::X3d) => Some(SceneFormat::X3d),
        Some(Content::Gltf) => Some(SceneFormat::Gltf),
        Some(Content::Mesh(format)) => Some(SceneFormat::Mesh(format)),
        Some(Content::Other(what)) => {
            return Err(SceneError::NoFile(format!("{name}: {what}; expected {EXPECTED}")));
        }
        None => SceneFormat::of_ending(&ending(path)),
    };
    if meshes.smooth.is_some() && !matches!(format, Some(SceneFormat::Mesh(_))) {
        return Err(not_smoothed(&name));
    }
    if meshes.reading().is_some() && format != Some(SceneFormat::X3d) {
        return Err(SceneError::NoFile(format!("--dialect and --camera are for X3D: {name} is none")));
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
    let format = format.ok_or_else(|| {
        let stream = match ending(path) == "fbs" {
            true => format!("; `fbptr play {name} --headless --snap picture.png` plays a stream of commands"),
            false => String::new(),
        };
        SceneError::NoFile(format!("{name}: expected {EXPECTED}{stream}"))
    })?;
    let held = memory.work(meta.len()).map_err(|e| SceneError::Refused(format!("{name}: {e}")))?;
    Ok((format, crate::save::read_input(path, MAX_BYTES).map_err(no_file)?, held))
}

/// A picture for the whole of a mesh, and its file's checksum.
struct Cover {
    texture: Arc<Texture>,
    crc: u32,
}

/// Reads the picture of `--texture`.
fn read_cover(path: &Path, memory: &mut LoadMemory) -> Result<Cover, SceneError> {
    let name = path.display().to_string();
    let no_file = |e: std::io::Error| SceneError::NoFile(format!("--texture {name}: {e}"));
    let bytes = crate::save::read_input(path, MAX_BYTES).map_err(no_file)?;
    let texture = load::texture::decode_within(&bytes, &name, memory);
    let texture = texture.map_err(|e| SceneError::Refused(format!("--texture {e}")))?;
    Ok(Cover { texture: Arc::new(texture), crc: crc32fast::hash(&bytes) })
}

/// Covers the mesh of a scene that was read.
fn apply_cover(cover: &Cover, loaded: &mut LoadedScene, name: &str) -> Result<(), SceneError> {
    let geometry = match &mut loaded.file {
        SceneFile::Mesh { geometry, .. } if !geometry.mesh.texcoords.is_empty() => geometry,
        SceneFile::Mesh { .. } => {
            let message = format!("--texture: {name} has no texture coordinates");
            return Err(SceneError::NoFile(message));
        }
        _ => return Err(SceneError::NoFile(format!("--texture is for meshes: {name} is none"))),
    };
    mesh_args::cover(Arc::make_mut(geometry), &cover.texture);
    loaded.crc = crc32fast::hash(&[loaded.crc.to_le_bytes(), cover.crc.to_le_bytes()].concat());
    Ok(())
}

/// Reads a scene as [`read`] does, and adds every file that was read or searched to `watch`.
pub(super) fn read_watched(
    path: &Path,
    options: ReadOptions,
    watch: &mut Watch,
) -> Result<LoadedScene, SceneError> {
    watch.begin(path);
    let mut memory = LoadMemory::new(&watch.budget.clone(), u64::MAX);
    let cover = match &options.meshes.texture {
        Some(picture) => {
            watch.add(picture.clone());
            Some(read_cover(picture, &mut memory)?)
        }
        None => None,
    };
    let name = path.display().to_string();
    let mut loaded = match built_in(path) {
        Some(model) => {
            let smoothing = options.meshes.smoothing();
            let loaded = model.load(smoothing, memory).map_err(SceneError::Refused)?;
            if options.meshes.smooth.is_some() && !matches!(loaded.file, SceneFile::Mesh { .. }) {
                return Err(not_smoothed(&name));
            }
            loaded
        }
        None => read_file(path, options, watch, memory)?,
    };
    if let Some(cover) = &cover {
        apply_cover(cover, &mut loaded, &name)?;
    }
    Ok(loaded)
}

/// Reads the scene of a file.
fn read_file(
    path: &Path,
    ReadOptions { root, meshes }: ReadOptions,
    watch: &mut Watch,
    memory: LoadMemory,
) -> Result<LoadedScene, SceneError> {
    let name = path.display().to_string();
    let budget = watch.budget.clone();
    let (format, bytes, _held) = read_bytes(path, meshes, &memory)?;
    let has_root = root.is_some();
    let root = Root::of(path, root)?;
    let mut other_cases = Vec::new();
    let mut inside = |asked: &str| {
        // Watched even if it is missing, since it may be created.
        watch.add(root.path.join(asked));
        let folder = root.folder.as_ref()?;
        let read = |name: &str| folder.read(name, MAX_BYTES.min(budget.available())).ok();
        read(asked).or_else(|| {
            let other = folder.other_case(asked)?;
            let bytes = read(&other)?;
            watch.add(root.path.join(&other));
            let warning = format!("{name}: warning: there is no {asked:?}: {other:?} is read");
            if !other_cases.contains(&warning) {
                other_cases.push(warning);
            }
            Some(bytes)
        })
    };
    let source = SceneSource {
        bytes: &bytes,
        format,
        name: &name,
        folder: &root.own,
        opener: &mut inside,
        smoothing: meshes.smoothing(),
        memory,
    };
    let mut loaded = SceneFile::read(source).map_err(SceneError::Refused)?;
    if let (SceneFile::X3d(document), Some(reading)) = (&mut loaded.file, meshes.reading()) {
        document.set_reading(reading);
    }
    loaded.warnings.append(&mut other_cases);
    if let (true, [first, others @ ..]) = (meshes.strict, &loaded.warnings[..]) {
        let more = if others.is_empty() { String::new() } else { format!(" (and {} more)", others.len()) };
        let refusal = first.replacen(": warning: ", ": refused by --strict: ", 1);
        return Err(SceneError::Refused(format!("{refusal}{more}")));
    }
    loaded.warnings.iter().for_each(say_as_program);
    if loaded.names_outside && !has_root {
        say_as_program(format_args!("--root DIR lets {name} read files above its own folder"));
    }
    Ok(loaded)
}
