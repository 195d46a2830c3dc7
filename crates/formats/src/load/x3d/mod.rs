//! X3D files (XML and classic encoding, and VRML 97) to scenes, at any moment of their animation.
//!
//! In: a file's bytes and a function that returns the files it refers to. Out: an [`X3dDocument`],
//! which gives the [`Scene`] at a time; or a [`LoadError`] with file, line and column. Nodes,
//! fields and defaults are those of ISO/IEC 19775-1; the set of nodes is fixed (`schema`), others
//! are skipped with a warning that gives node and line.
//!
//! Errors: XML that is not well-formed, a root that is neither X3D nor Scene; a field whose text is
//! not of its type (NaN and infinities included); USE of an enclosing node; Inlines in a cycle,
//! prototypes that contain themselves; sizes over the limits. Warnings: unknown nodes and fields (the
//! children of an unknown grouping node are shown), text among elements, misplaced nodes, wrong counts
//! of numbers, faces and lines with indices out of range (one warning a file), USE before its DEF or
//! without one, ROUTEs between missing fields, shapes without extent; files of Inlines and
//! prototypes that cannot be found, are outside the root, or have an error other than a cycle or a
//! size.
//!
//! The expected result for each family of nodes is in the head of its module, with the clause of
//! ISO/IEC 19775-1: `proto` and `instance` (prototypes), `units`, `flatten` (groups, lights,
//! layers, binding), `facing` (LOD, Billboard), `camera`, `sky` (Background), `appearance`,
//! `geometry`, `interpolate`, `time`, `route`.
//!
//! ```text
//! bytes (classic -> XML) -> xml (text, checked) -> build (graph: nodes with typed fields, routes)
//!       -> shapes (meshes, made once)
//!       at(time): route, time, interpolate -> flatten -> Scene
//! ```

mod appearance;
mod build;
mod camera;
mod classic;
mod connect;
mod cost;
mod course;
mod external_refs;
mod facing;
mod fields;
mod flatten;
mod generate;
mod geometry;
mod graph;
mod instance;
mod interpolate;
mod kept;
mod names;
mod nodes;
mod proto;
mod remarks;
mod route;
mod schema;
mod shapes;
mod sky;
mod stages;
mod texture;
mod time;
mod units;
mod unknown;
mod unusable;
use super::url;
mod validate;
mod value;
mod xml;

#[cfg(test)]
mod defaults;

use super::{LoadContext, LoadError, LoadMemory, LoadWarning};
pub use classic::HEADERS as CLASSIC_HEADERS;
pub use course::{Dialect, FieldOfView, Reading};
use fbptr_core::scene::{Camera, Scene};
use graph::{Graph, GraphView, Overrides};
use kept::Kept;
use shapes::MeshCache;

/// A parsed X3D file, with everything it refers to.
#[derive(Debug)]
pub struct X3dDocument {
    graph: Graph,
    mesh_cache: MeshCache,
    warnings: Vec<LoadWarning>,
    names_outside: bool,
    /// True if the scene is drawn in pixels, as its dialect has it.
    is_in_pixels: bool,
    field_of_view: FieldOfView,
}

/// Parses an X3D file, which may be compressed (gzip).
///
/// `file_name` is used in messages, and its last component counts against cycles of Inlines.
/// `opener` is called for Inline files and textures with their names relative to the scene's folder
/// (`/` between folders; never absolute, never with `..`); it returns `None` if there is no such
/// file, or it may not be read, as [`SandboxDir`](super::SandboxDir) decides.
///
/// # Errors
/// If the file has one of the errors listed in the module's documentation, or a file that it
/// inlines is in a cycle or over a limit.
pub fn parse(
    bytes: &[u8],
    file_name: &str,
    opener: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
) -> Result<X3dDocument, LoadError> {
    parse_within(bytes, file_name, opener, &mut LoadMemory::unlimited())
}

/// [`parse`] within the limits of `memory`. Memory is reserved for the tables of each file before
/// it is read, for inflated bytes, for each node and mesh, and for each picture once its header
/// gives its size.
///
/// # Errors
/// Those of [`parse`], and one if `memory` has no room or is cancelled.
pub fn parse_within(
    bytes: &[u8],
    file_name: &str,
    opener: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
    memory: &mut LoadMemory,
) -> Result<X3dDocument, LoadError> {
    parse_in(bytes, file_name, LoadContext { folder: "", opener, memory })
}

/// [`parse_within`] for a file in a folder below the root.
///
/// # Errors
/// Those of [`parse_within`].
pub fn parse_in(bytes: &[u8], file_name: &str, context: LoadContext) -> Result<X3dDocument, LoadError> {
    let (texts, documents) = (Kept::new(), Kept::new());
    let mut builder = build::Builder::new(context, &texts, &documents);
    builder.main_file(bytes, file_name)?;
    builder.graph.depends_on_viewer = flatten::depends_on_viewer(&builder.graph);
    let mesh_cache = validate::document(&mut builder)?;
    Ok(X3dDocument {
        warnings: builder.sorted_warnings(),
        names_outside: builder.remarks.names_outside,
        is_in_pixels: false,
        field_of_view: FieldOfView::default(),
        graph: builder.graph,
        mesh_cache,
    })
}

impl X3dDocument {
    /// Returns the scene `time` seconds after its start. The same time gives the same bits on every
    /// machine; a time that is not finite is before the start of everything.
    ///
    /// There always is a camera: that of the bound viewpoint (the first one in the file) or,
    /// without one, the standard's default (from 0 0 10 along -z).
    pub fn at(&self, time: f64) -> Scene {
        self.seen_at(time, None)
    }

    /// [`X3dDocument::at`], with everything that depends on the viewer (LOD, Billboard, generated
    /// texture coordinates) computed for `viewer`; `None` stands for the scene's own camera. The
    /// camera of the returned scene is the scene's own in both cases.
    pub fn seen_at(&self, time: f64, viewer: Option<&Camera>) -> Scene {
        let overrides = route::overrides(&self.graph, time);
        flatten::scene(GraphView { graph: &self.graph, overrides: &overrides }, &self.mesh_cache, viewer)
    }

    /// Returns whether the scene depends on the position of the viewer.
    pub fn depends_on_viewer(&self) -> bool {
        self.graph.depends_on_viewer && !self.is_in_pixels
    }

    /// Returns an upper bound of the bytes of the scene that [`X3dDocument::at`] returns: its
    /// objects, each with its lights, and the meshes that routes have changed.
    pub fn scene_bytes(&self) -> u64 {
        let root = &self.graph.nodes[self.graph.root as usize].totals;
        let lights = self.graph.nodes.iter().filter(|n| n.ty.name.ends_with("Light")).count() + 1;
        let lists = 8 * lights.min(flatten::MAX_LIGHTS + 1) as u64;
        let has = |name: &str| self.graph.nodes.iter().any(|n| n.ty.name == name);
        let mut meshes = if self.is_animated() { root.geometry_bytes } else { 0 };
        let mut object = cost::OBJECT_BYTES + root.name_bytes + lists;
        // A surface with generated coordinates has its own mesh, and a stage has its own
        // coordinates for each corner.
        if has("TextureCoordinateGenerator") {
            meshes = meshes.saturating_add(root.geometry_bytes);
        }
        if has("MultiTexture") {
            meshes = meshes.saturating_add(root.geometry_bytes);
            object += cost::STAGES_BYTES;
        }
        root.shapes.saturating_mul(object).saturating_add(meshes)
    }

    /// Returns the warnings about skipped or repaired parts, in the order of the file, Inline files
    /// after it.
    pub fn warnings(&self) -> &[LoadWarning] {
        &self.warnings
    }

    /// Returns whether a file was left out because its name leads out of the root.
    pub fn names_outside(&self) -> bool {
        self.names_outside
    }

    /// Returns whether the scene may change with time.
    pub fn is_animated(&self) -> bool {
        self.graph.routes.iter().any(|r| !matches!(r.input, route::RouteInput::Bind))
    }

    /// Returns whether the file has a viewpoint, or is drawn in pixels, so that the camera is the
    /// author's.
    pub fn has_viewpoint(&self) -> bool {
        let still = Overrides::new();
        self.is_in_pixels
            || flatten::has_viewpoint(GraphView { graph: &self.graph, overrides: &still }, &self.mesh_cache)
    }
}
