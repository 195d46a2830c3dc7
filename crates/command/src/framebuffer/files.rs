//! Files: meshes in, pictures out, and the comparison with golden pictures.

use super::Framebuffer;
use fbptr_core::scene::Geometry;
use fbptr_formats::load::gltf::GltfDocument;
use fbptr_formats::load::{
    self, FilePosition, LoadError, LoadErrorKind, LoadMemory, MeshFormat, SandboxDir, Smoothing, path_inside,
};
use fbptr_formats::save::golden::{self, Tolerance};
use fbptr_formats::save::{self, SaveError};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Size limit of a mesh file and of each file that it names, in bytes.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// Name of a file for messages, its bytes, and the function that reads other files of its folder.
type Opened<F> = (String, Vec<u8>, F);

/// Reads a file. Returns its name for messages, its bytes, and the function that reads other files
/// of its folder.
fn open(path: &Path) -> Result<Opened<impl FnMut(&str) -> Option<Vec<u8>> + use<>>, LoadError> {
    let name = path.display().to_string();
    let bytes = fbptr_formats::save::read_input(path, MAX_FILE_BYTES).map_err(|e| {
        let kind = match e.kind() {
            io::ErrorKind::NotFound => LoadErrorKind::Missing { what: "file", name: name.clone() },
            _ => LoadErrorKind::Undecodable { format: "file", reason: e.to_string() },
        };
        LoadError::new(FilePosition::file(name.as_str()), kind)
    })?;
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let folder = SandboxDir::open(folder).ok();
    let beside = move |name: &str| {
        let inside = path_inside("", name)?;
        let folder = folder.as_ref()?;
        let read = |name: &str| folder.read(name, MAX_FILE_BYTES).ok();
        read(&inside).or_else(|| read(&folder.other_case(&inside)?))
    };
    Ok((name, bytes, beside))
}

impl Framebuffer {
    /// Reads a mesh from an OBJ, STL or PLY file, which its bytes tell apart. The facets of STL files
    /// are flat; see [`MeshFormat::parse`] for smooth ones.
    ///
    /// # Errors
    /// If the file cannot be read, or has an error.
    pub fn load_mesh(&self, path: impl AsRef<Path>) -> Result<Arc<Geometry>, LoadError> {
        let (name, bytes, mut beside) = open(path.as_ref())?;
        let memory = &mut LoadMemory::unlimited();
        let loaded =
            MeshFormat::of(&bytes).parse(&bytes, &mut beside, &name, memory, Smoothing::default())?;
        Ok(Arc::new(loaded.geometry))
    }

    /// Reads a mesh from an OBJ file, with the materials and textures that it names in its own
    /// folder. Parts that a renderer can do without (a missing texture, an unknown statement) are
    /// left out; [`load::obj::parse`] returns them as warnings.
    ///
    /// # Errors
    /// If the file cannot be read, or has an error.
    pub fn load_obj(&self, path: impl AsRef<Path>) -> Result<Arc<Geometry>, LoadError> {
        let (name, bytes, mut beside) = open(path.as_ref())?;
        load::obj::parse(&bytes, &mut beside, &name).map(|loaded| Arc::new(loaded.geometry))
    }

    /// Reads a glTF file (`.gltf` or `.glb`) with the buffers and pictures that it names in its own
    /// folder; [`GltfDocument::at`] gives the scene for [`Framebuffer::draw_scene`].
    ///
    /// # Errors
    /// If the file cannot be read, or has an error.
    pub fn load_gltf(&self, path: impl AsRef<Path>) -> Result<GltfDocument, LoadError> {
        let (name, bytes, mut beside) = open(path.as_ref())?;
        load::gltf::parse(&bytes, &name, &mut beside)
    }

    /// Writes the frame to a file, in the format of its name's ending: `.png`, `.ppm` or `.raw`.
    /// The file is replaced atomically.
    ///
    /// # Errors
    /// If the ending stands for no format, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        save::to_path(&self.memory, path.as_ref())
    }

    /// Compares the frame with the PNG file at `golden`, byte for byte; for tests. See
    /// [`save::golden`] for the files that a failure leaves, and for `BLESS=1`.
    ///
    /// # Panics
    /// If the frame does not pass, with what to do: how many pixels differ and where they can be
    /// seen, or how to make the first golden file.
    #[track_caller]
    pub fn assert_golden(&self, golden: impl AsRef<Path>) {
        self.assert_golden_within(golden, Tolerance::EXACT);
    }

    /// [`Framebuffer::assert_golden`], with a tolerance.
    ///
    /// # Panics
    /// If the frame does not pass.
    #[track_caller]
    pub fn assert_golden_within(&self, golden: impl AsRef<Path>, tolerance: Tolerance) {
        golden::assert_golden(&self.memory, golden, tolerance);
    }
}
