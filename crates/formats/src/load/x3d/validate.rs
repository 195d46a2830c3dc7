//! Last step of parsing: every shape's mesh is computed once, and fields that depend on each other
//! are checked. Files of Inlines and prototypes of other files come first, each when it is read:
//! one with an error is left out.

use super::build::Builder;
use super::cost;
use super::flatten::MAX_LIGHTS;
use super::generate::Mode;
use super::geometry::{Fault, LeftOut, elevation};
use super::graph::{GraphView, NodeId, Origin, Overrides};
use super::shapes::{self, MeshCache, ShapeKey};
use super::stages;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::scene::{MAX_STAGES, StageMode};

/// Most faces of Text and Extrusion nodes, of grids that lack heights, and of geometries in
/// instances of prototypes, in one scene.
const MAX_MADE_FACES: u64 = 4 << 20;

/// Bytes of a computed mesh without its vectors.
const SHAPE_BYTES: u64 = 1024;

/// Meshes of the nodes that are checked already.
#[derive(Default)]
pub(super) struct Meshes {
    cache: MeshCache,
    /// Keys of `cache` in the order of their nodes.
    keys: Vec<ShapeKey>,
    /// Number of faces that count towards [`MAX_MADE_FACES`].
    made_faces: u64,
}

impl Meshes {
    /// Returns the number of meshes.
    pub(super) fn count(&self) -> usize {
        self.keys.len()
    }

    /// Removes all but the first `count` meshes.
    pub(super) fn truncate(&mut self, count: usize) {
        for key in self.keys.drain(count..) {
            self.cache.remove(&key);
        }
    }
}

/// Computes the meshes of a graph. An invalid geometry is an error at its field, and so is the first
/// part that was left out if nothing at all is left.
pub(super) fn document(builder: &mut Builder<'_, '_>) -> Result<MeshCache, LoadError> {
    nodes(builder, 0)?;
    let mut meshes = builder.meshes.keys.iter().filter_map(|key| builder.meshes.cache.get(key));
    if meshes.all(|prepared| prepared.geometry.mesh.corners.is_empty())
        && let Some(error) = builder.first_left_out()
    {
        return Err(error);
    }
    let graph = &builder.graph;
    let lights = graph.nodes.iter().filter(|n| n.ty.name.ends_with("Light")).count();
    if lights > MAX_LIGHTS {
        let origin = graph.nodes[graph.root as usize].origin;
        builder.warn_at(origin, format!("of {lights} lights, the first {MAX_LIGHTS} are used"));
    }
    Ok(std::mem::take(&mut builder.meshes.cache))
}

/// Computes the meshes of the nodes from `first` on, except for those that are checked already. An
/// invalid geometry is an error at its field.
pub(super) fn nodes(builder: &mut Builder<'_, '_>, first: NodeId) -> Result<(), LoadError> {
    // Taken out, so that it can change while the graph is viewed.
    let mut meshes = std::mem::take(&mut builder.meshes);
    let checked = unchecked(builder, first, &mut meshes);
    builder.meshes = meshes;
    let (remarks, left_out) = checked?;
    for LeftOut { first, count } in left_out {
        if let Some(fault) = first {
            let error = refused(builder, &fault);
            builder.leave_out(builder.graph.nodes[fault.node as usize].origin.source, error, count);
        }
    }
    builder.graph.nodes[first as usize..].iter_mut().for_each(|node| node.is_checked = true);
    for (id, remark) in remarks {
        let origin = builder.graph.nodes[id as usize].origin;
        builder.warn_at(origin, remark);
    }
    Ok(())
}

/// Remarks on nodes, and what was left out of geometries.
type Found = (Vec<(NodeId, String)>, Vec<LeftOut>);

/// Adds the meshes of nodes that are not checked yet, and returns remarks on nodes, and what was left
/// out of geometries.
fn unchecked(builder: &mut Builder<'_, '_>, first: NodeId, meshes: &mut Meshes) -> Result<Found, LoadError> {
    let still = Overrides::new();
    let mut remarks: Vec<(NodeId, String)> = Vec::new();
    let mut left_out = Vec::new();
    let view = GraphView { graph: &builder.graph, overrides: &still };
    for id in first..builder.graph.nodes.len() as NodeId {
        if view.node(id).is_checked {
            continue;
        }
        if view.name(id) != "Shape" {
            let remark = node(&view, id).map_err(|f| refused(builder, &f))?;
            remarks.extend(remark.map(|r| (id, r)));
            continue;
        }
        let Some(parts) = shapes::parts(&view, id) else { continue };
        remarks.extend(shapes::size_remark(&view, &parts).map(|r| (parts.geometry, r)));
        if shapes::cached(&meshes.cache, &parts).is_some() {
            continue;
        }
        let node = parts.geometry;
        let of_memory = |kind| refused(builder, &Fault { node, field: "", kind });
        let work = builder.context.memory.work(cost::geometry_bytes(&view, node)).map_err(of_memory)?;
        let (prepared, of_mesh, without) =
            shapes::prepare(&view, &parts).map_err(|f| refused(builder, &f))?;
        remarks.extend(of_mesh.into_iter().map(|r| (parts.geometry, r)));
        if without.count > 0 {
            left_out.push(without);
        }
        let is_made = matches!(view.name(node), "Text" | "Extrusion") || elevation::lacking(&view, node) > 0;
        if is_made || view.node(parts.geometry).is_expanded {
            let mesh = &prepared.geometry.mesh;
            // A letter is one polygon with many corners.
            let faces = if view.name(node) == "Text" { mesh.triangles.len() } else { mesh.polygons.len() };
            meshes.made_faces += faces as u64;
            if meshes.made_faces > MAX_MADE_FACES {
                let kind = LoadErrorKind::TooBig {
                    what: "faces of all nodes",
                    found: meshes.made_faces,
                    limit: MAX_MADE_FACES,
                };
                return Err(refused(builder, &Fault { node: parts.geometry, field: "", kind }));
            }
        }
        drop(work);
        let kept =
            builder.context.memory.reserve_result(prepared.geometry.mesh.size_bytes() as u64 + SHAPE_BYTES);
        kept.map_err(|kind| refused(builder, &Fault { node, field: "", kind }))?;
        meshes.keys.push(shapes::store(&mut meshes.cache, &parts, prepared));
    }
    Ok((remarks, left_out))
}

/// Returns the error of a geometry, at the position of the offending field.
fn refused(builder: &Builder, fault: &Fault) -> LoadError {
    let node = &builder.graph.nodes[fault.node as usize];
    let byte = node.ty.field(fault.field).map_or(node.origin.byte, |i| node.written[i]);
    LoadError::new(builder.place(Origin { byte, ..node.origin }), fault.kind.clone())
}

/// Checks the fields of a node together: a remark if a value is replaced, an error if none can be
/// used.
fn node(view: &GraphView, id: NodeId) -> Result<Option<String>, Fault> {
    let name = view.name(id);
    let remark = match name {
        _ if view.node(id).ty.field("key").is_some() => return interpolator(view, id),
        "TimeSensor" if view.real(id, "cycleInterval") <= 0.0 => {
            Some("<TimeSensor> never runs: its cycleInterval must be positive".into())
        }
        "Viewpoint"
            if !(view.real(id, "fieldOfView") > 0.0
                && view.real(id, "fieldOfView") < std::f64::consts::PI) =>
        {
            Some("<Viewpoint> fieldOfView must lie between 0 and pi: pi/4 is taken".into())
        }
        "OrthoViewpoint" => {
            let [l, b, r, t] = view.array::<4>(id, "fieldOfView");
            (l >= r || b >= t)
                .then(|| "<OrthoViewpoint> fieldOfView bounds no area: -1 -1 1 1 is taken".into())
        }
        "PhysicalMaterial" => unused_textures(view, id, "baseTexture"),
        "CommonSurfaceShader" => beyond_material(view, id),
        "MultiTexture" => multi_texture(view, id),
        "LineProperties" => {
            let linetype = view.ints(id, "linetype").first().copied().unwrap_or(1);
            let remark =
                || format!("<LineProperties> linetype {linetype} is drawn like one of the types 1 to 5");
            (!stages::line_kind(linetype).1).then(remark)
        }
        "FillProperties" => {
            let style = view.ints(id, "hatchStyle").first().copied().unwrap_or(1);
            let remark = || format!("<FillProperties> hatchStyle {style} is drawn like style 3");
            (!stages::hatch(style).1).then(remark)
        }
        "TextureCoordinateGenerator" => {
            let mode = view.text(id, "mode");
            let remark =
                || format!("<TextureCoordinateGenerator> mode {mode:?} is not known: SPHERE is taken");
            Mode::from_word(mode).is_none().then(remark)
        }
        "Material" => unused_textures(view, id, "diffuseTexture"),
        "UnlitMaterial" => unused_textures(view, id, "emissiveTexture"),
        "LayerSet" => Some("<LayerSet>: its layers are drawn in one space, seen through one camera".into()),
        "Fog" if !matches!(view.text(id, "fogType").trim(), "LINEAR" | "EXPONENTIAL") => {
            Some(format!("<Fog> fogType {:?} is not known: LINEAR is taken", view.text(id, "fogType")))
        }
        _ => None,
    };
    Ok(remark)
}

/// Returns a remark on a material's textures other than `used`, the one that is drawn.
fn unused_textures(view: &GraphView, id: NodeId, used: &str) -> Option<String> {
    let unused: Vec<&str> =
        view.node(id).children.iter().map(|c| c.container).filter(|c| *c != used).collect();
    (!unused.is_empty()).then(|| format!("<{}> is drawn without its {}", view.name(id), unused.join(", ")))
}

/// Returns a remark on the parts of a CommonSurfaceShader that no Material has.
fn beyond_material(view: &GraphView, id: NodeId) -> Option<String> {
    let factors = ["reflectionFactor", "transmissionFactor"].into_iter();
    let factors = factors.filter(|field| view.vec3(id, field) != glam::DVec3::ZERO);
    let textures = view.node(id).children.iter().map(|c| c.container).filter(|c| *c != "diffuseTexture");
    let unused: Vec<&str> = factors.chain(textures).collect();
    (!unused.is_empty()).then(|| format!("<CommonSurfaceShader> is drawn without its {}", unused.join(", ")))
}

/// Returns a remark on unknown words of a MultiTexture, or on textures beyond the limit.
fn multi_texture(view: &GraphView, id: NodeId) -> Option<String> {
    let count = view.node(id).children.len();
    if count > MAX_STAGES {
        return Some(format!("<MultiTexture> is drawn with {MAX_STAGES} of its {count} textures"));
    }
    let is_mode = |word: &str| word.trim().is_empty() || StageMode::from_word(word.trim()).is_some();
    let words = view.texts(id, "mode").iter().flat_map(|m| m.split(','));
    let wrong: Vec<&str> = words.map(str::trim).filter(|w| !is_mode(w)).collect();
    (!wrong.is_empty())
        .then(|| format!("<MultiTexture> mode {} is not known: MODULATE is taken", wrong.join(", ")))
}

/// Checks that an interpolator's keys ascend and match its values.
fn interpolator(view: &GraphView, id: NodeId) -> Result<Option<String>, Fault> {
    let (name, key) = (view.name(id), view.reals(id, "key"));
    let fault = |field, expected: String, found: usize| Fault {
        node: id,
        field,
        kind: LoadErrorKind::Syntax { expected, found: format!("{found} numbers") },
    };
    if let Some(i) = key.windows(2).position(|w| w[1] < w[0]) {
        let kind = LoadErrorKind::Range {
            what: "each key",
            expected: "at least the one before it",
            found: format!("{} after {}", key[i + 1], key[i]),
        };
        return Err(Fault { node: id, field: "key", kind });
    }
    let values = view.reals(id, "keyValue").len();
    let tuple = match name {
        "ScalarInterpolator" => 1,
        "OrientationInterpolator" => 4,
        _ => 3,
    };
    let is_right = match name {
        // Any number of points, equal for each key.
        "CoordinateInterpolator" | "NormalInterpolator" => {
            key.is_empty() || (values / tuple).is_multiple_of(key.len())
        }
        _ => key.is_empty() || values == tuple * key.len(),
    };
    if !is_right {
        let expected = format!("expected {tuple} numbers in keyValue for each of the {} keys", key.len());
        return Err(fault("keyValue", expected, values));
    }
    if name == "SplinePositionInterpolator" {
        let velocities = view.reals(id, "keyVelocity").len() / 3;
        if velocities != 0 && velocities != 2 && velocities != key.len() {
            let expected = format!("expected 2 or {} velocities in keyVelocity", key.len());
            return Err(fault("keyVelocity", expected, velocities * 3));
        }
    }
    Ok(key.is_empty().then(|| format!("<{name}> has no keys and sends nothing")))
}
