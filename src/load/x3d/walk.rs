//! The walk through the graph at one moment: groups and transforms to world matrices, shapes to objects, lights with their
//! scope, and the bound viewpoint, background, fog and navigation info.

use super::camera::{self, rotation};
use super::graph::{NodeId, View};
use super::route::{Input, Output};
use super::shapes::{self, Shelf};
use crate::math::matrix::{scale, translate, unit};
use crate::scene::{Attenuation, Background, Fog, FogKind, Light, LightKind, Object, Scene};
use glam::{DMat4, DVec3};

/// The most lights of a scene; further ones are left out.
pub(super) const MAX_LIGHTS: usize = 1_000;

const VIEWPOINTS: &[&str] = &["Viewpoint", "OrthoViewpoint"];

/// What a walk gathers.
struct Walk<'a> {
    view: View<'a>,
    shelf: &'a Shelf,
    scene: Scene,
    /// The lights that reach everything.
    global: Vec<u32>,
    /// Bindable nodes in the order met, with their places.
    bindable: Vec<(NodeId, DMat4)>,
    /// Names of the groups around, innermost last.
    names: Vec<&'a str>,
    /// How many Inlines are around.
    inlines: usize,
}

/// The scene as `view` has it.
pub(super) fn scene(view: View, shelf: &Shelf) -> Scene {
    let mut walk = Walk::new(view, shelf);
    walk.group(view.graph.root, DMat4::IDENTITY, &[]);
    walk.finish()
}

/// Whether a viewpoint of the file is bound.
pub(super) fn has_viewpoint(view: View, shelf: &Shelf) -> bool {
    let mut walk = Walk::new(view, shelf);
    walk.group(view.graph.root, DMat4::IDENTITY, &[]);
    walk.bound(VIEWPOINTS, None).is_some()
}

impl<'a> Walk<'a> {
    fn new(view: View<'a>, shelf: &'a Shelf) -> Self {
        Walk {
            view,
            shelf,
            scene: Scene::default(),
            global: Vec::new(),
            bindable: Vec::new(),
            names: Vec::new(),
            inlines: 0,
        }
    }

    /// Everything in a group that stands at `model`, under the scoped lights `lights`.
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
        // Lights reach what stands before them too.
        let mut lights = lights.to_vec();
        for light in children() {
            self.light(light, model, &mut lights);
        }
        for child in children() {
            self.child(child, model, &lights);
        }
        if def.is_some() {
            self.names.pop();
        }
    }

    fn child(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let is_visible = || view.bool(id, "visible");
        match view.name(id) {
            "Group" | "StaticGroup" | "Switch" if is_visible() => self.group(id, model, lights),
            "Transform" if is_visible() => self.group(id, model * transform(&view, id), lights),
            "Inline" if is_visible() => {
                if let Some(scene) = view.graph.inlined.get(&id) {
                    let def = view.node(id).def.as_deref();
                    self.names.extend(def);
                    self.inlines += 1;
                    self.group(*scene, model, lights);
                    self.inlines -= 1;
                    if def.is_some() {
                        self.names.pop();
                    }
                }
            }
            "Shape" if is_visible() => self.shape(id, model, lights),
            // Bindable nodes of an Inline are never bound first.
            "Viewpoint" | "OrthoViewpoint" | "Background" | "Fog" | "NavigationInfo" if self.inlines == 0 => {
                self.bindable.push((id, model));
            }
            _ => {}
        }
    }

    fn shape(&mut self, id: NodeId, model: DMat4, lights: &[u32]) {
        let view = self.view;
        let Some(parts) = shapes::parts(&view, id) else { return };
        let fresh = match shapes::is_driven(&view, &parts) {
            // Where routes have made a geometry that cannot be, it stays as the file has it.
            true => shapes::prepare(&view, &parts).ok().map(|(prepared, _)| prepared),
            false => None,
        };
        let Some(prepared) = fresh.as_ref().or_else(|| shapes::kept(self.shelf, &parts)) else { return };
        let node = view.node(id);
        let name = node.def.as_deref().or(self.names.last().copied());
        let name = match name {
            Some(name) => name.replace(|c: char| c.is_whitespace() || c.is_control(), "_"),
            None => format!("Shape:{}", node.line),
        };
        if let Some(object) = shapes::object(&view, &parts, prepared, model, name) {
            self.scene.objects.push(Object { lights: Some(lights.to_vec()), ..object });
        }
    }

    /// Adds a light, if the node is one and is on; a scoped one joins `scope`.
    fn light(&mut self, id: NodeId, model: DMat4, scope: &mut Vec<u32>) {
        let view = self.view;
        if !matches!(view.name(id), "DirectionalLight" | "PointLight" | "SpotLight") || !view.bool(id, "on") {
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

    /// The first node of a kind that was met, unless routes from the bound viewpoint bind another.
    fn bound(&self, names: &[&str], viewpoint: Option<NodeId>) -> Option<(NodeId, DMat4)> {
        let met = || self.bindable.iter().filter(|(id, _)| names.contains(&self.view.name(*id)));
        let routed = viewpoint.and_then(|viewpoint| {
            let routes = self.view.graph.routes.iter();
            let binds = |r: &&super::route::Route| {
                (r.from, r.output, r.input) == (viewpoint, Output::Bound, Input::Bind)
            };
            routes.filter(binds).find_map(|r| met().find(|(id, _)| *id == r.to))
        });
        routed.or_else(|| met().next()).copied()
    }

    fn finish(mut self) -> Scene {
        let view = self.view;
        let viewpoint = self.bound(VIEWPOINTS, None);
        let by = viewpoint.map(|(id, _)| id);
        let bounds = viewpoint.filter(|(id, _)| view.bool(*id, "viewAll")).and_then(|_| self.scene.bounds());
        let camera = match viewpoint {
            Some((id, model)) => camera::camera(&view, id, model, bounds),
            None => camera::default_camera(),
        };
        self.scene.camera = Some(camera);
        let background = self.bound(&["Background"], by).map(|(id, _)| id);
        let sky = background.filter(|id| view.real(*id, "transparency") < 1.0).map(|id| {
            let sky = view.reals(id, "skyColor");
            std::array::from_fn(|i| sky.get(i).copied().unwrap_or(0.0)).into()
        });
        self.scene.background = Background { color: sky };
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

/// A Transform's matrix: T C R SR S -SR -C.
fn transform(view: &View, id: NodeId) -> DMat4 {
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

/// How much a matrix enlarges lengths, on the whole: the cube root of what it does to volumes.
fn enlargement(model: DMat4) -> f64 {
    let volume = glam::DMat3::from_mat4(model).determinant().abs();
    match volume == 1.0 {
        true => 1.0,
        false => libm::cbrt(volume),
    }
}

/// Products of finite fields may overflow; beyond this nothing looks different.
const HUGE: f64 = 1e100;

fn bounded(color: DVec3) -> DVec3 {
    color.clamp(DVec3::splat(-HUGE), DVec3::splat(HUGE))
}

/// A light's kind in world space; `None` where its matrix or direction leaves it nowhere.
fn light_kind(view: &View, id: NodeId, model: DMat4) -> Option<LightKind> {
    let direction = || unit(model.transform_vector3(view.vec3(id, "direction")));
    if view.name(id) == "DirectionalLight" {
        return direction().map(|direction| LightKind::Directional { direction });
    }
    let position = model.transform_point3(view.vec3(id, "location"));
    let size = enlargement(model);
    if !(position.is_finite() && size > 0.0 && size.is_finite()) {
        return None;
    }
    // Distances count in the light's own units: a world distance is `size` of them.
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

fn fog(view: &View, id: NodeId, model: DMat4) -> Option<Fog> {
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
