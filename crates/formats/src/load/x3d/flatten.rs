//! Flattening of the graph at one moment: groups and transforms to world matrices, shapes to
//! objects, lights with their scope, and the bound viewpoint, background, fog and navigation info.
//!
//! Sources, clauses of ISO/IEC 19775-1: 10 (Group, StaticGroup, Switch, Transform), 9.4.2 (Inline),
//! 9.4.1 (Anchor: its children; links are not followed), 23.4.2 (Collision: its children are shown,
//! its proxy never is), 23.4.1 and .3 (`facing`), 17 (lights), 7.2.2 (bindable nodes: the first one
//! in traversal order is bound; hidden levels of a LOD count, hidden choices of a Switch do not),
//! 35 (layering).
//!
//! Layers (35.4): those that `order` lists are shown, 0 being the scene outside all layers;
//! bindable nodes of the active layer take precedence over others. Limits: all layers are one
//! space, seen through one camera, with one depth buffer; a layer's viewport does not clip it (its
//! children, like those of any Viewport, are shown).
//!
//! If something depends on the viewer there are two passes: the first one finds the camera, with
//! all levels of every LOD shown and no Billboard turned; the second one is seen from there.

use super::camera::{self, rotation};
use super::graph::{Graph, GraphView, NodeId, Overrides};
use super::route::{Output, RouteInput};
use super::shapes::{self, MeshCache};
use super::{facing, sky, stages};
use fbptr_core::math::matrix::{scale, translate, unit};
use fbptr_core::scene::{Attenuation, Camera, Fog, FogKind, Light, LightKind, Object, Scene};
use glam::{DMat4, DVec3};

/// Most lights of a scene; further ones are left out.
pub(super) const MAX_LIGHTS: usize = 1_000;

/// Names of the viewpoint types.
const VIEWPOINTS: &[&str] = &["Viewpoint", "OrthoViewpoint"];

/// State of one pass over the graph, and the scene that it builds.
struct Flattener<'a> {
    view: GraphView<'a>,
    mesh_cache: &'a MeshCache,
    scene: Scene,
    /// Indices of the lights that affect every object.
    global: Vec<u32>,
    /// Bindable nodes in traversal order, with their world matrices and layers.
    bindable: Vec<(NodeId, DMat4, i64)>,
    /// Viewer of LOD and Billboard; `None` shows every level and turns nothing.
    viewer: Option<Camera>,
    /// Current layer, and the active one.
    layer: i64,
    active_layer: i64,
    /// Number of enclosing parts that are hidden: levels of a LOD, layers.
    hidden: usize,
    /// DEF names of the enclosing groups, innermost last.
    names: Vec<&'a str>,
    /// Number of enclosing Inlines.
    inlines: usize,
}

/// Returns the scene of `view`, seen by `viewer` or by its own camera.
pub(super) fn scene(view: GraphView, mesh_cache: &MeshCache, viewer: Option<&Camera>) -> Scene {
    if !view.graph.depends_on_viewer {
        return Flattener::of(view, mesh_cache, None).finish(None);
    }
    let own = Flattener::of(view, mesh_cache, None).camera();
    Flattener::of(view, mesh_cache, Some(viewer.copied().unwrap_or(own))).finish(Some(own))
}

/// Returns whether a scene depends on the position of the viewer.
pub(super) fn depends_on_viewer(graph: &Graph) -> bool {
    let view = GraphView { graph, overrides: &Overrides::new() };
    let depends = |id: &NodeId| match view.name(*id) {
        "LOD" | "Billboard" => true,
        _ => stages::generator(&view, *id).is_some_and(|g| g.mode.depends_on_viewer()),
    };
    (0..graph.nodes.len() as NodeId).any(|id| depends(&id))
}

/// Returns whether a viewpoint of the file is bound.
pub(super) fn has_viewpoint(view: GraphView, mesh_cache: &MeshCache) -> bool {
    Flattener::of(view, mesh_cache, None).bound(VIEWPOINTS, None).is_some()
}

impl<'a> Flattener<'a> {
    /// Traverses the whole graph.
    fn of(view: GraphView<'a>, mesh_cache: &'a MeshCache, viewer: Option<Camera>) -> Self {
        let mut flattener = Flattener {
            view,
            mesh_cache,
            scene: Scene::default(),
            global: Vec::new(),
            bindable: Vec::new(),
            viewer,
            layer: 0,
            active_layer: 0,
            hidden: 0,
            names: Vec::new(),
            inlines: 0,
        };
        let root = view.graph.root;
        let layers = view.children(root).find(|id| view.name(*id) == "LayerSet");
        if let Some(layers) = layers {
            flattener.active_layer = view.ints(layers, "activeLayer").first().copied().unwrap_or(0);
            flattener.hidden += usize::from(!view.ints(layers, "order").contains(&0));
        }
        flattener.group(root, DMat4::IDENTITY, &[]);
        flattener
    }

    /// Adds the contents of a group with world matrix `model`, affected by the scoped lights
    /// `lights`.
    fn group(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let def = view.node(id).def.as_deref();
        self.names.extend(def);
        let chosen = match view.name(id) {
            "Switch" => Some(view.ints(id, "whichChoice").first().copied().unwrap_or(-1)),
            _ => None,
        };
        let children = || {
            let all = (0..).zip(view.children(id));
            all.filter(move |(i, _)| chosen.is_none_or(|c| c == *i)).map(|(_, child)| child)
        };
        let shown = self.level_of(id, model);
        let is_shown = |i: usize| shown.is_none_or(|shown| shown == i);
        // A light also affects siblings before it.
        let mut lights = lights.to_vec();
        for (_, light) in children().enumerate().filter(|(i, _)| is_shown(*i)) {
            self.light(light, model, &mut lights);
        }
        for (i, child) in children().enumerate() {
            self.hidden += usize::from(!is_shown(i));
            self.child(child, model, &lights);
            self.hidden -= usize::from(!is_shown(i));
        }
        if def.is_some() {
            self.names.pop();
        }
    }

    /// Returns the index of the one child that a LOD shows the viewer; `None` for other nodes, and
    /// if there is no viewer yet.
    fn level_of(&self, id: NodeId, model: DMat4) -> Option<usize> {
        let (view, camera) = (self.view, self.viewer.as_ref()?);
        if view.name(id) != "LOD" {
            return None;
        }
        let children = view.children(id).count();
        facing::level(camera, model, view.vec3(id, "center"), view.reals(id, "range"), children)
    }

    fn child(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let is_visible = || view.bool(id, "visible");
        match view.name(id) {
            "Group" | "StaticGroup" | "Switch" | "Collision" | "Anchor" | "LOD" | "Viewport" | "Layer"
            | "LayoutLayer"
                if is_visible() =>
            {
                self.group(id, model, lights);
                for viewport in view.child(id, "viewport").into_iter() {
                    self.child(viewport, model, lights);
                }
            }
            "Transform" if is_visible() => self.group(id, model * transform(&view, id), lights),
            "Billboard" if is_visible() => {
                let axis = view.vec3(id, "axisOfRotation");
                let turn = self.viewer.as_ref().map(|camera| facing::billboard(camera, model, axis));
                self.group(id, turn.map_or(model, |turn| model * turn), lights);
            }
            "LayerSet" => self.layers(id, model, lights),
            "Inline" if is_visible() => {
                if let Some((scene, enlarged)) = view.graph.inlined.get(&id) {
                    let def = view.node(id).def.as_deref();
                    self.names.extend(def);
                    self.inlines += 1;
                    let own = if *enlarged == 1.0 { model } else { model * scale(DVec3::splat(*enlarged)) };
                    self.group(*scene, own, lights);
                    self.inlines -= 1;
                    if def.is_some() {
                        self.names.pop();
                    }
                }
            }
            "Shape" if is_visible() && self.hidden == 0 => self.shape(id, model, lights),
            // Bindable nodes of an Inline are never bound initially.
            "Viewpoint" | "OrthoViewpoint" | "Background" | "Fog" | "NavigationInfo" if self.inlines == 0 => {
                self.bindable.push((id, model, self.layer));
            }
            _ => {}
        }
    }

    /// Adds the layers that `order` lists, with the world matrix and lights of the LayerSet.
    fn layers(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let order = view.ints(id, "order");
        // Hiding the scene outside all layers does not hide the layers.
        let (around, hidden) = (self.layer, std::mem::take(&mut self.hidden));
        let layers = view.node(id).children.iter().filter(|c| c.container == "layers");
        for (number, layer) in (1..).zip(layers) {
            self.layer = number;
            self.hidden = usize::from(!order.contains(&number));
            self.child(layer.node, model, lights);
        }
        (self.layer, self.hidden) = (around, hidden);
    }

    fn shape(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let Some(parts) = shapes::parts(&view, id) else { return };
        let fresh = match shapes::is_driven(&view, &parts) {
            // If routes have made the geometry invalid, it stays as in the file.
            true => shapes::prepare(&view, &parts).ok().map(|(prepared, _)| prepared),
            false => None,
        };
        let Some(prepared) = fresh.as_ref().or_else(|| shapes::cached(self.mesh_cache, &parts)) else {
            return;
        };
        let node = view.node(id);
        let name = node.def.as_deref().or(self.names.last().copied());
        let name = match name {
            Some(name) => name.replace(|c: char| c.is_whitespace() || c.is_control(), "_"),
            None => format!("Shape:{}", node.line),
        };
        if let Some(object) = shapes::object(&view, &parts, prepared, model, self.viewer.as_ref(), name) {
            self.scene.objects.push(Object { lights: Some(lights.to_vec()), ..object });
        }
    }

    /// Adds a light, if the node is one and is on; the index of a scoped one is pushed to `scope`.
    fn light(&mut self, id: NodeId, model: DMat4, scope: &mut Vec<u32>) {
        let view = self.view;
        let is_light = matches!(view.name(id), "DirectionalLight" | "PointLight" | "SpotLight");
        if !is_light || self.hidden > 0 || !view.bool(id, "on") {
            return;
        }
        let Some(kind) = light_kind(&view, id, model) else { return };
        if self.scene.lights.len() >= MAX_LIGHTS {
            return;
        }
        let color = view.vec3(id, "color");
        let index = self.scene.lights.len() as u32;
        self.scene.lights.push(Light {
            kind,
            color: bounded(color * view.real(id, "intensity")),
            ambient: bounded(color * view.real(id, "ambientIntensity")),
            clamp_attenuation: true,
        });
        match view.bool(id, "global") {
            true => self.global.push(index),
            false => scope.push(index),
        }
    }

    /// Returns the bound node of the types `names` with its world matrix: one that a route from the
    /// bound viewpoint binds, else the first of the active layer, else the first.
    fn bound(&self, names: &[&str], viewpoint: Option<NodeId>) -> Option<(NodeId, DMat4)> {
        let met = || self.bindable.iter().filter(|(id, ..)| names.contains(&self.view.name(*id)));
        let routed = viewpoint.and_then(|viewpoint| {
            let routes = self.view.graph.routes.iter();
            let binds = |r: &&super::route::Route| {
                (r.from, r.output, r.input) == (viewpoint, Output::Bound, RouteInput::Bind)
            };
            routes.filter(binds).find_map(|r| met().find(|(id, ..)| *id == r.to))
        });
        let active = || met().find(|(.., layer)| *layer == self.active_layer);
        routed.or_else(active).or_else(|| met().next()).map(|(id, model, _)| (*id, *model))
    }

    /// Returns the bound viewpoint's camera, or the standard's default.
    fn camera(&self) -> Camera {
        let Some((id, model)) = self.bound(VIEWPOINTS, None) else { return camera::default_camera() };
        let bounds = self.view.bool(id, "viewAll").then(|| self.scene.bounds()).flatten();
        camera::camera(&self.view, id, model, bounds)
    }

    /// Completes the scene with `camera`, or with that of the bound viewpoint.
    fn finish(mut self, camera: Option<Camera>) -> Scene {
        let view = self.view;
        let by = self.bound(VIEWPOINTS, None).map(|(id, _)| id);
        let camera = camera.unwrap_or_else(|| self.camera());
        self.scene.camera = Some(camera);
        if let Some((id, model)) = self.bound(&["Background"], by) {
            (self.scene.background, self.scene.sky) = sky::read(&view, id, model);
        }
        self.scene.fog = self.bound(&["Fog"], by).and_then(|(id, model)| fog(&view, id, model));
        let own = by.and_then(|id| view.child(id, "navigationInfo"));
        let navigation = own.or_else(|| self.bound(&["NavigationInfo"], by).map(|(id, _)| id));
        if navigation.is_none_or(|id| view.bool(id, "headlight")) {
            self.global.push(self.scene.lights.len() as u32);
            self.scene.lights.push(Light {
                kind: LightKind::Directional {
                    direction: unit(camera.look_at.reference - camera.look_at.eye).unwrap_or(DVec3::NEG_Z),
                },
                color: DVec3::ONE,
                ambient: DVec3::ZERO,
                clamp_attenuation: true,
            });
        }
        let all = self.scene.lights.len();
        for object in &mut self.scene.objects {
            let mut lights = object.lights.take().unwrap_or_default();
            lights.extend(&self.global);
            lights.sort_unstable();
            object.lights = (lights.len() < all).then_some(lights);
        }
        self.scene
    }
}

/// Returns a Transform's matrix: T C R SR S -SR -C.
fn transform(view: &GraphView, id: NodeId) -> DMat4 {
    let vec3 = |field| view.vec3(id, field);
    let center = vec3("center");
    let turn = rotation(view.array(id, "rotation"));
    let size = vec3("scale");
    let mut matrix = translate(vec3("translation") + center) * turn;
    if size != DVec3::ONE {
        let [x, y, z, angle] = view.array(id, "scaleOrientation");
        matrix = match angle == 0.0 {
            true => matrix * scale(size),
            false => matrix * rotation([x, y, z, angle]) * scale(size) * rotation([x, y, z, -angle]),
        };
    }
    match center == DVec3::ZERO {
        true => matrix,
        false => matrix * translate(-center),
    }
}

/// Returns the mean scale factor of a matrix: the cube root of its volume factor.
fn enlargement(model: DMat4) -> f64 {
    let volume = glam::DMat3::from_mat4(model).determinant().abs();
    match volume == 1.0 {
        true => 1.0,
        false => libm::cbrt(volume),
    }
}

/// Bound for products of finite fields, which may overflow; a larger value looks no different.
const HUGE: f64 = 1e100;

fn bounded(color: DVec3) -> DVec3 {
    color.clamp(DVec3::splat(-HUGE), DVec3::splat(HUGE))
}

/// Returns a light's kind in world space; `None` if its matrix or direction is degenerate.
fn light_kind(view: &GraphView, id: NodeId, model: DMat4) -> Option<LightKind> {
    let direction = || unit(model.transform_vector3(view.vec3(id, "direction")));
    if view.name(id) == "DirectionalLight" {
        return direction().map(|direction| LightKind::Directional { direction });
    }
    let position = model.transform_point3(view.vec3(id, "location"));
    let size = enlargement(model);
    if !(position.is_finite() && size > 0.0 && size.is_finite()) {
        return None;
    }
    // Distances are in the light's own units: a world distance d is d / `size`.
    let [c, l, q] = view.array(id, "attenuation");
    let attenuation =
        Attenuation { c, l: (l / size).clamp(-HUGE, HUGE), q: (q / size / size).clamp(-HUGE, HUGE) };
    let radius = view.real(id, "radius") * size;
    if view.name(id) == "PointLight" {
        return Some(LightKind::Point { position, attenuation, radius });
    }
    let cut_off_rad = view.real(id, "cutOffAngle");
    let beam_width_rad = view.real(id, "beamWidth").min(cut_off_rad);
    let direction = direction()?;
    Some(LightKind::X3dSpot { position, direction, beam_width_rad, cut_off_rad, attenuation, radius })
}

/// Reads a Fog with world matrix `model`; `None` if its visibility range is not positive.
fn fog(view: &GraphView, id: NodeId, model: DMat4) -> Option<Fog> {
    let kind = match view.text(id, "fogType").trim() {
        "EXPONENTIAL" => FogKind::Exponential,
        _ => FogKind::Linear,
    };
    let visibility_range = view.real(id, "visibilityRange") * enlargement(model);
    (visibility_range > 0.0 && visibility_range.is_finite()).then(|| Fog {
        color: view.vec3(id, "color"),
        kind,
        visibility_range,
    })
}
