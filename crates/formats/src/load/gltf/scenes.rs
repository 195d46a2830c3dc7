//! Scenes of a glTF document: the one that is shown, at a moment.

use super::GltfDocument;
use super::animation::Path;
use super::json::Json;
use super::nodes::{self, Node, Transform, quaternion};
use super::pose::posed;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::scene::{self, Cull, LightingModel, Object, Scene, Style, viewers_light};
use glam::{DMat4, DVec3};

/// Moments at which an animated scene is measured, to frame it.
const MOMENTS: u32 = 16;
/// Ambient light, in place of the surroundings that the file does not have.
const AMBIENT: f64 = 0.15;

/// Returns the nodes of the default scene, else of the first, else of all nodes without a parent.
pub(super) fn shown(root: &Json, nodes: &[Node]) -> Result<Vec<usize>, LoadError> {
    let scenes = root.member("scenes");
    let number = root.member("scene").index_if_there("scene", scenes.count())?;
    if scenes.count() == 0 {
        let roots = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
        return Ok(nodes::order(nodes, roots));
    }
    let (mut roots, mut is_root) = (Vec::new(), vec![false; nodes.len()]);
    for json in scenes.item(number.unwrap_or(0)).member("nodes").items()? {
        let node = json.index("node", nodes.len())?;
        let message = match (nodes[node].parent, std::mem::replace(&mut is_root[node], true)) {
            (None, false) => None,
            (_, true) => Some(format!("node {node} is in the list twice: once is enough")),
            // Its parents still move it.
            (Some(_), false) => Some(format!("node {node} has a parent, and is no root of a scene")),
        };
        if !message.as_ref().is_some_and(|m| m.contains("twice")) {
            roots.push(node);
        }
        if let Some(message) = message {
            json.note(json.warning(message));
        }
    }
    // One below another in the list is drawn once.
    let (mut shown, mut is_shown) = (Vec::new(), vec![false; nodes.len()]);
    roots.reverse();
    while let Some(node) = roots.pop() {
        if !std::mem::replace(&mut is_shown[node], true) {
            shown.push(node);
            roots.extend(nodes[node].children.iter().rev());
        }
    }
    Ok(shown)
}

/// Nodes at a moment.
struct Moment {
    /// World matrix of each node.
    world: Vec<DMat4>,
    /// Weights of each node's morph targets.
    weights: Vec<Vec<f64>>,
}

impl GltfDocument {
    /// Verifies that vertices name joints that their skins have.
    pub(super) fn check_skins(&self, root: &Json) -> Result<(), LoadError> {
        for (i, node) in self.nodes.iter().enumerate() {
            let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { continue };
            let count = self.skins[skin].joints.len();
            let greatest =
                self.meshes[mesh].iter().filter_map(|p| p.skinning.as_ref()?.greatest_joint()).max();
            if let Some(index) = greatest.filter(|g| usize::from(*g) >= count) {
                let (index, count) = (i64::from(index), count as u64);
                let place = root.member("nodes").item(i).member("skin");
                return Err(place.refuse(LoadErrorKind::Index { what: "joint", index, count }));
            }
        }
        Ok(())
    }

    fn moment(&self, time: f64) -> Moment {
        let mut transforms: Vec<Transform> = self.nodes.iter().map(|n| n.transform).collect();
        let own = |n: &Node| match (n.mesh, n.weights.is_empty()) {
            (Some(mesh), true) => self.weights[mesh].clone(),
            _ => n.weights.clone(),
        };
        let mut weights: Vec<Vec<f64>> = self.nodes.iter().map(own).collect();
        for channel in &self.channels {
            let value = channel.at(time);
            // A node with a matrix is not moved, as the specification says.
            match (channel.path, &mut transforms[channel.node]) {
                (Path::Weights, _) => weights[channel.node] = value,
                (_, Transform::Matrix(_)) => {}
                (Path::Translation, Transform::Parts { translation, .. }) => {
                    *translation = DVec3::from_slice(&value);
                }
                (Path::Scale, Transform::Parts { scale, .. }) => *scale = DVec3::from_slice(&value),
                (Path::Rotation, Transform::Parts { rotation, .. }) => {
                    *rotation = quaternion([value[0], value[1], value[2], value[3]]);
                }
            }
        }
        let mut world = vec![DMat4::IDENTITY; self.nodes.len()];
        for &i in &self.order {
            let local = transforms[i].matrix();
            world[i] = self.nodes[i].parent.map_or(local, |parent| world[parent] * local);
        }
        Moment { world, weights }
    }

    /// Returns the objects that are shown.
    fn objects(&self, moment: &Moment) -> Vec<Object> {
        let mut objects = Vec::new();
        for &i in &self.shown {
            let node = &self.nodes[i];
            let Some(mesh) = node.mesh else { continue };
            let joints = node.skin.map(|skin| self.skins[skin].matrices(&moment.world));
            for (k, primitive) in self.meshes[mesh].iter().enumerate() {
                let is_skinned = joints.is_some() && primitive.skinning.is_some();
                let model = if is_skinned { DMat4::IDENTITY } else { moment.world[i] };
                if !model.is_finite() {
                    continue;
                }
                // The last row of a file's matrix may be anything.
                let [x, y, z, w] = [0, 1, 2, 3].map(|c| model.col(c).truncate());
                let model = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), w.extend(1.0));
                let (geometry, maps) = posed(primitive, &moment.weights[i], joints.as_deref());
                objects.push(Object {
                    name: name(node, i, k),
                    geometry,
                    model,
                    material: primitive.material.clone(),
                    back_material: None,
                    cull: if primitive.is_double_sided { Cull::None } else { Cull::Back },
                    two_sided_lighting: primitive.is_double_sided
                        && primitive.material.model != LightingModel::Unlit,
                    shade: None,
                    texture: primitive.texture.clone(),
                    lights: None,
                    light_error: None,
                    style: Style { maps, ..Style::default() },
                });
            }
        }
        objects
    }

    /// Returns the scene at a time; see [`GltfDocument::at`].
    pub(super) fn scene(&self, time: f64, aspect: f64) -> Scene {
        let moment = self.moment(time);
        let lights =
            self.shown.iter().filter_map(|&i| self.lamps[self.nodes[i].light?].light(moment.world[i]));
        let mut scene = Scene {
            ambient: DVec3::splat(AMBIENT),
            lights: lights.collect(),
            objects: self.objects(&moment),
            ..Scene::default()
        };
        let own = self.shown.iter().find_map(|&i| Some((self.nodes[i].camera?, moment.world[i])));
        let camera = match (own, self.bounds) {
            (Some((camera, world)), _) => self.lenses[camera].camera(world, scene.bounds()),
            (None, Some(bounds)) => scene::frame(bounds, aspect),
            (None, None) => scene::Camera::default(),
        };
        if !self.has_lights() {
            scene.lights.push(viewers_light(&camera));
        }
        scene.camera = Some(camera);
        scene
    }

    /// Returns a box around the scene at several moments of its longest animation.
    pub(super) fn bounds_of_all(&self) -> Option<(DVec3, DVec3)> {
        let period = self.channels.iter().map(|c| c.period()).fold(0.0, f64::max);
        let moments = if self.is_animated() { MOMENTS } else { 1 };
        let at = |k: u32| {
            let objects = self.objects(&self.moment(period * f64::from(k) / f64::from(moments)));
            Scene { objects, ..Scene::default() }.bounds()
        };
        (0..moments).filter_map(at).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

/// Returns an object's name: that of its node, or the node's number, and the primitive's.
fn name(node: &Node, number: usize, primitive: usize) -> String {
    let name = match node.name.is_empty() {
        true => format!("node{number}"),
        false => node.name.chars().take(200).collect(),
    };
    let name = name.replace(|c: char| c.is_whitespace() || c.is_control(), "_");
    if primitive == 0 { name } else { format!("{name}.{primitive}") }
}
