//! MultiTexture, LineProperties and FillProperties as an object's style.
//!
//! Textures are combined pixel by pixel (`scene::TextureStages`), never baked into one: pictures of
//! different sizes and coordinates stay exact. Texture i uses the coordinates of entry i of a
//! MultiTextureCoordinate, the last one if there are too few; all use those of any other node, and
//! the default coordinates without one. Transform i applies to texture i; without an entry there is
//! none, and a plain TextureTransform applies to all. Words of `mode`, `source` and `function`
//! belong to the textures in order; where they end, textures are multiplied. A texture that could
//! not be loaded is off. Limit: eight textures.
//!
//! Sources: ISO/IEC 19775-1 clauses 18.4.3 to 18.4.5 (MultiTexture, MultiTextureCoordinate,
//! MultiTextureTransform), 12.4.3 (FillProperties) and 12.4.4 (LineProperties).

use super::appearance::TextureMap;
use super::generate::{self, Generator, Mode, SurfaceFrame};
use super::geometry::vec2s;
use super::graph::{GraphView, NodeId};
use fbptr_core::scene::{
    FillStyle, Hatch, LineKind, LineStyle, MAX_STAGES, Mesh, Sampling, StageFunction, StageMode, StageSource,
    TextureStage, TextureStages, Wrap,
};
use glam::{DVec2, DVec4};
use std::sync::Arc;

/// Returns the texture nodes of a MultiTexture, up to the limit.
fn textures(view: &GraphView, multi: NodeId) -> Vec<NodeId> {
    let all = view.node(multi).children.iter().filter(|c| c.container == "texture");
    all.map(|c| c.node).take(MAX_STAGES).collect()
}

/// Reads the stages of a MultiTexture on a geometry whose mesh is `mesh`, with the texture transform
/// of its appearance.
pub(super) fn read(
    view: &GraphView,
    multi: NodeId,
    geometry: NodeId,
    transform: Option<NodeId>,
    mesh: &Mesh,
    place: &SurfaceFrame,
) -> TextureStages {
    let word = |field: &str, i: usize| view.texts(multi, field).get(i).map_or("", |w| w.trim());
    let stage = |(i, node): (usize, &NodeId)| {
        let mut modes = word("mode", i).split(',').map(str::trim);
        let color = modes.next().and_then(StageMode::from_word).unwrap_or_default();
        let alpha = modes.next().and_then(StageMode::from_word).unwrap_or(color.of_alpha());
        TextureStage {
            texture: view.graph.textures.get(node).cloned(),
            sampling: sampling(view, *node),
            texcoords: texcoords(view, geometry, i, transform_of(view, transform, i), mesh, place),
            color,
            alpha,
            source: match word("source", i).to_ascii_uppercase().as_str() {
                "DIFFUSE" => StageSource::Diffuse,
                "SPECULAR" => StageSource::Specular,
                "FACTOR" => StageSource::Factor,
                _ => StageSource::Before,
            },
            function: match word("function", i).to_ascii_uppercase().as_str() {
                "COMPLEMENT" => StageFunction::Complement,
                "ALPHAREPLICATE" => StageFunction::AlphaReplicate,
                _ => StageFunction::None,
            },
        }
    };
    let factor: DVec4 = view.vec3(multi, "color").extend(view.real(multi, "alpha"));
    TextureStages { stages: textures(view, multi).iter().enumerate().map(stage).collect(), factor }
}

/// Returns the wrap modes of a texture node.
pub(super) fn sampling(view: &GraphView, node: NodeId) -> Sampling {
    let wrap = |field| match view.node(node).ty.field(field).is_none() || view.bool(node, field) {
        true => Wrap::Repeat,
        false => Wrap::Clamp,
    };
    Sampling { wrap_s: wrap("repeatS"), wrap_t: wrap("repeatT"), ..Sampling::default() }
}

/// Returns the coordinate transform of texture `i`.
fn transform_of(view: &GraphView, transform: Option<NodeId>, i: usize) -> Option<TextureMap> {
    let node = transform?;
    let own = match view.name(node) {
        "MultiTextureTransform" => view.node(node).children.get(i).map(|c| c.node)?,
        _ => node,
    };
    (view.name(own) == "TextureTransform").then(|| TextureMap::read(view, own))?
}

/// Returns the coordinates of texture `i` at each corner of the mesh.
fn texcoords(
    view: &GraphView,
    geometry: NodeId,
    i: usize,
    map: Option<TextureMap>,
    mesh: &Mesh,
    place: &SurfaceFrame,
) -> Arc<[DVec2]> {
    let mapped = |tc: DVec2| map.as_ref().map_or(tc, |map| map.apply(tc));
    let node = entry(view, geometry, i);
    if let Some(generator) = node.and_then(|node| generator(view, node)) {
        return generate::texcoords(&generator, mesh, place).into_iter().map(mapped).collect();
    }
    // Corners index any list of coordinates; without a list the mesh has computed its own.
    let own = node.filter(|n| view.name(*n) == "TextureCoordinate").map(|n| vec2s(view.reals(n, "point")));
    let has_lists =
        view.child(geometry, "texCoord").is_some_and(|n| view.name(n) != "TextureCoordinateGenerator");
    let list = match own.filter(|list| has_lists && !list.is_empty()) {
        Some(list) => list,
        None => mesh.texcoords.clone(),
    };
    let at = |corner: &fbptr_core::scene::Corner| {
        list.get(corner.texcoord as usize).copied().unwrap_or(DVec2::ZERO)
    };
    mesh.corners.iter().map(|c| mapped(at(c))).collect()
}

/// Returns the node with the coordinates of texture `i`.
pub(super) fn entry(view: &GraphView, geometry: NodeId, i: usize) -> Option<NodeId> {
    let node = view.child(geometry, "texCoord")?;
    match view.name(node) {
        "MultiTextureCoordinate" => {
            let all = &view.node(node).children;
            all.get(i).or(all.last()).map(|c| c.node)
        }
        _ => Some(node),
    }
}

/// Returns the parameters of a TextureCoordinateGenerator; `None` for other nodes.
pub(super) fn generator<'a>(view: &GraphView<'a>, node: NodeId) -> Option<Generator<'a>> {
    (view.name(node) == "TextureCoordinateGenerator").then(|| Generator {
        mode: Mode::from_word(view.text(node, "mode")).unwrap_or(Mode::Sphere),
        parameter: view.reals(node, "parameter"),
    })
}

/// Largest width of a line in pixels.
const MAX_LINE_WIDTH: f64 = 256.0;

/// Returns the line style of an appearance.
pub(super) fn line_style(view: &GraphView, appearance: Option<NodeId>) -> LineStyle {
    let node = appearance.and_then(|a| view.child(a, "lineProperties")).filter(|n| view.bool(*n, "applied"));
    let Some(node) = node else { return LineStyle::default() };
    let width = (view.real(node, "linewidthScaleFactor") + 0.5).floor().clamp(1.0, MAX_LINE_WIDTH) as u32;
    LineStyle { width, kind: line_kind(view.ints(node, "linetype").first().copied().unwrap_or(1)).0 }
}

/// Returns the kind for a registered line type, and whether it is that type or only a similar one.
pub(super) fn line_kind(linetype: i64) -> (LineKind, bool) {
    match linetype {
        1 => (LineKind::Solid, true),
        2 => (LineKind::Dashed, true),
        3 => (LineKind::Dotted, true),
        4 => (LineKind::DashDot, true),
        5 => (LineKind::DashDotDot, true),
        // Chain, center, hidden and phantom lines of technical drawings.
        10 | 11 => (LineKind::DashDot, false),
        12 => (LineKind::Dashed, false),
        13 => (LineKind::DashDotDot, false),
        _ => (LineKind::Solid, false),
    }
}

/// Returns the fill style of an appearance.
pub(super) fn fill_style(view: &GraphView, appearance: Option<NodeId>) -> FillStyle {
    let Some(node) = appearance.and_then(|a| view.child(a, "fillProperties")) else {
        return FillStyle::default();
    };
    let style = view.ints(node, "hatchStyle").first().copied().unwrap_or(1);
    let hatch = (hatch(style).0, view.vec3(node, "hatchColor"));
    FillStyle { is_filled: view.bool(node, "filled"), hatch: view.bool(node, "hatched").then_some(hatch) }
}

/// Returns the hatch for a registered style, and whether it is that style or only a similar one.
pub(super) fn hatch(style: i64) -> (Hatch, bool) {
    match style {
        1 => (Hatch::Horizontal, true),
        2 => (Hatch::Vertical, true),
        3 => (Hatch::Rising, true),
        4 => (Hatch::Falling, true),
        5 => (Hatch::Square, true),
        6 => (Hatch::Diamond, true),
        _ => (Hatch::Rising, false),
    }
}
