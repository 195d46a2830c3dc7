//! glTF 2.0 files (`.gltf`, `.glb`) to scenes, at any moment of their animation.
//!
//! In: a file's bytes and a function that returns the files it refers to. Out: a [`GltfDocument`],
//! which gives the [`Scene`] at a time; or a [`LoadError`] with the JSON pointer of the value, or the
//! line or byte, and the reason. The JSON is read by `serde_json` and each value is checked where it
//! is used. Shown is the file's default scene (else the first), seen by its first camera, lit by its
//! lights; a file without a camera is framed, one without lights is lit from the viewer's upper
//! left.
//!
//! Refused: values of a wrong type, indices out of range, views that reach beyond their buffer,
//! buffers that cannot be found, nodes in a cycle, and compression that the file requires. Warnings:
//! other extensions that are not in [`SUPPORTED`], words that are none of a list's, roots and parents
//! that the specification does not allow, and pictures that cannot be read. docs/formats.md has the
//! list and the formulas.
//!
//! ```text
//! bytes -> container (JSON, binary) -> json (values with pointers)
//!       -> buffers (accessors) -> mesh, material, image, nodes, animation
//!       at(time): animation -> world matrices -> pose -> Scene
//! ```
//!
//! Source: Khronos Group, glTF 2.0 Specification (ISO/IEC 12113:2022).

mod animation;
mod attributes;
mod buffers;
mod container;
mod cutoff;
mod image;
mod json;
mod maps;
mod material;
mod mesh;
mod nodes;
mod pose;
mod scenes;
#[cfg(test)]
mod tests;

#[doc(hidden)]
pub use container::MAGIC;

use super::error::short;
use super::{FilePosition, LoadContext, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use animation::Channel;
use fbptr_core::scene::{Object, Scene};
use glam::DVec3;
use image::{Images, Source};
use json::{Json, Notes};
use mesh::Primitive;
use nodes::{Lamp, Lens, Node};
use pose::Skin;

/// Extensions that are read, or that change nothing that is drawn.
pub const SUPPORTED: [&str; 8] = [
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions without which a file that requires them has no vertices or no pictures.
const COMPRESSED: [&str; 4] = [
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
];

/// Returns a program that writes a file without a compression.
fn converter(extension: &str) -> &'static str {
    match extension {
        "KHR_texture_basisu" => "`gltf-transform ktxdecompress in.glb out.glb` writes its pictures as PNG",
        "KHR_draco_mesh_compression" => "`gltf-pipeline -i in.glb -o out.glb` writes it without Draco",
        _ => "import it in a program that reads it, such as Blender, and export it uncompressed",
    }
}

/// Most warnings of a file.
const MAX_WARNINGS: usize = 100;
/// Most primitives of all nodes that are shown.
const MAX_OBJECTS: usize = 200_000;

/// A parsed glTF file, with everything it refers to.
#[derive(Debug)]
pub struct GltfDocument {
    nodes: Vec<Node>,
    /// All nodes, parents first.
    order: Vec<usize>,
    /// The nodes of the scene that is shown, in the order of its tree.
    shown: Vec<usize>,
    meshes: Vec<Vec<Primitive>>,
    /// Weights of each mesh's morph targets.
    weights: Vec<Vec<f64>>,
    skins: Vec<Skin>,
    lenses: Vec<Lens>,
    lamps: Vec<Lamp>,
    channels: Vec<Channel>,
    /// Box around the scene at all moments.
    bounds: Option<(DVec3, DVec3)>,
    warnings: Vec<LoadWarning>,
    names_outside: bool,
}

/// Parses the glTF file `file_name` from its bytes. `opener` is called with the names of the files
/// it refers to, relative to its folder; see [`LoadContext::opener`].
///
/// # Errors
/// If the file has one of the errors listed in the module's documentation.
pub fn parse(
    bytes: &[u8],
    file_name: &str,
    opener: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
) -> Result<GltfDocument, LoadError> {
    let memory = &mut LoadMemory::unlimited();
    parse_in(bytes, file_name, LoadContext { folder: "", opener, memory })
}

/// [`parse`] for a file in a folder below the root, within the limits of the context's memory.
///
/// # Errors
/// Those of [`parse`], and one if the memory has no room or is cancelled.
pub fn parse_in(bytes: &[u8], file_name: &str, context: LoadContext) -> Result<GltfDocument, LoadError> {
    let mut warnings = Vec::new();
    let parts = container::split(bytes, file_name, &mut warnings)?;
    let refused = |kind| LoadError::new(FilePosition::file(file_name), kind);
    let _values = context.memory.work(json::value_bytes(parts.json)).map_err(refused)?;
    let value = serde_json::from_slice(parts.json).map_err(|e| {
        let place = FilePosition::column(file_name, e.line() as u32, e.column() as u32);
        let text = e.to_string();
        let reason = short(text.split(" at line").next().unwrap_or(&text));
        LoadError::new(place, LoadErrorKind::Undecodable { format: "JSON", reason })
    })?;
    let notes = Notes::new(warnings);
    let root = Json::root(&value, file_name, &notes);
    check_asset(&root)?;
    let (mut context, mut names_outside) = (context, false);
    let buffers = buffers::Buffers::read(&root, parts.binary, &mut context, &mut names_outside)?;
    let mut source = Source { root, buffers, context, names_outside };
    let mut document = read(&mut source)?;
    document.names_outside = source.names_outside;
    drop(source);
    document.warnings = notes.into_inner();
    Ok(document)
}

/// Checks the version and the extensions.
fn check_asset(root: &Json) -> Result<(), LoadError> {
    let version = root.member("asset").member("version");
    match version.text()? {
        Some(text) if text.starts_with("2.") => {}
        _ => return Err(version.wrong("version 2")),
    }
    let mut names = Vec::new();
    for item in root.member("extensionsRequired").items()? {
        let name = item.text()?.unwrap_or_default();
        if COMPRESSED.contains(&name) {
            let reason = format!("the file requires {name}, which is not supported: {}", converter(name));
            return Err(item.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
        }
        if !SUPPORTED.contains(&name) {
            let message =
                format!("the file requires {}, which is not supported: it is drawn without", short(name));
            root.note(item.warning(message));
        }
        names.push(name);
    }
    for item in root.member("extensionsUsed").items()? {
        let name = item.text()?.unwrap_or_default();
        if !SUPPORTED.contains(&name) && !names.contains(&name) && names.len() < 2 * MAX_WARNINGS {
            names.push(name);
            root.note(item.warning(format!("{} is not supported: it is ignored", short(name))));
        }
    }
    Ok(())
}

/// Reads everything behind the buffers.
fn read(source: &mut Source) -> Result<GltfDocument, LoadError> {
    let root = source.root.clone();
    let nodes = nodes::read_all(&root)?;
    let shown = scenes::shown(&root, &nodes)?;
    let (mut images, mut meshes, mut weights) = (Images::default(), Vec::new(), Vec::new());
    let mut is_used = vec![false; root.member("meshes").count()];
    nodes.iter().filter_map(|n| n.mesh).for_each(|mesh| is_used[mesh] = true);
    for (mesh, is_used) in root.member("meshes").items()?.iter().zip(is_used) {
        let mut primitives = Vec::new();
        for json in mesh.member("primitives").items()?.iter().filter(|_| is_used) {
            primitives.extend(mesh::read(source, &mut images, json)?);
        }
        weights.push(nodes::numbers(&mesh.member("weights"))?);
        meshes.push(primitives);
    }
    let objects: usize = shown.iter().filter_map(|n| nodes[*n].mesh).map(|m| meshes[m].len()).sum();
    if objects > MAX_OBJECTS {
        let (found, limit) = (objects as u64, MAX_OBJECTS as u64);
        return Err(root.member("nodes").refuse(LoadErrorKind::TooBig { what: "primitives", found, limit }));
    }
    let skins = root.member("skins").items()?;
    let skins = skins.iter().map(|s| Skin::read(source, s, nodes.len())).collect::<Result<Vec<_>, _>>()?;
    let lights = root.extension("KHR_lights_punctual").member("lights").items()?;
    let targets = |node: usize| {
        let primitives = nodes[node].mesh.map(|m| &meshes[m]);
        primitives.and_then(|p| p.first()).map_or(0, |p| p.morphs.len())
    };
    let channels = animation::read_all(source, nodes.len(), targets)?;
    let roots = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    let mut document = GltfDocument {
        order: nodes::order(&nodes, roots),
        shown,
        meshes,
        weights,
        skins,
        lenses: root.member("cameras").items()?.iter().map(Lens::read).collect::<Result<_, _>>()?,
        lamps: lights.iter().map(Lamp::read).collect::<Result<_, _>>()?,
        channels,
        bounds: None,
        warnings: Vec::new(),
        names_outside: false,
        nodes,
    };
    document.check_skins(&root)?;
    let refused = |kind| root.refuse(kind);
    let nodes = (document.nodes.len() * size_of::<Node>()) as u64;
    source.context.memory.reserve_result(2 * nodes).map_err(refused)?;
    let _work = source.context.memory.work(document.scene_bytes()).map_err(refused)?;
    document.bounds = document.bounds_of_all();
    if document.bounds.is_none() {
        source.warn(root.warning("no primitives: nothing is drawn"));
    }
    Ok(document)
}

impl GltfDocument {
    /// Returns the scene `time` seconds after its start, for a picture of `aspect` = width / height.
    /// The same time gives the same bits on every machine; a time that is not finite is the start.
    ///
    /// There always is a camera: the first of the file's scene or, without one, one that frames the
    /// scene at all moments.
    pub fn at(&self, time: f64, aspect: f64) -> Scene {
        self.scene(time, aspect)
    }

    /// Returns an upper bound of the bytes of the scene that [`GltfDocument::at`] returns: its
    /// objects, and the meshes that bend.
    pub fn scene_bytes(&self) -> u64 {
        let moment = self.nodes.len() * 3 * size_of::<[f64; 16]>();
        let primitives = self.shown.iter().filter_map(|n| self.nodes[*n].mesh).flat_map(|m| &self.meshes[m]);
        let bytes = primitives.map(|primitive| {
            let bends = !primitive.morphs.is_empty() || primitive.skinning.is_some();
            let mesh =
                if bends { primitive.geometry.mesh.size_bytes() + primitive.tangent_bytes() } else { 0 };
            3 * size_of::<Object>() + 1024 + mesh
        });
        (moment + bytes.sum::<usize>()) as u64
    }

    /// Returns whether the scene may change with time.
    pub fn is_animated(&self) -> bool {
        !self.channels.is_empty()
    }

    /// Returns whether the camera is the author's.
    pub fn has_camera(&self) -> bool {
        self.shown.iter().any(|n| self.nodes[*n].camera.is_some())
    }

    /// Returns whether the lights are the author's.
    pub fn has_lights(&self) -> bool {
        self.shown.iter().any(|n| self.nodes[*n].light.is_some())
    }

    /// Returns the warnings about parts that were left out.
    pub fn warnings(&self) -> &[LoadWarning] {
        &self.warnings
    }

    /// Returns whether a file was left out because its name leads out of the root.
    pub fn names_outside(&self) -> bool {
        self.names_outside
    }
}
