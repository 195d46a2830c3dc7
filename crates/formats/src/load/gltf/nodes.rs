//! Nodes of a glTF file: the tree, with transforms, cameras and lights.
//!
//! In: the JSON. Out: nodes with their parents, each at most one, and an order in which parents come
//! first; a cycle is refused, a second parent left out with a warning. Lights: the renderer adds
//! the numbers that pixels have (`material`), so a light's strength is encoded as well, with the
//! square root for the gamma of about 2: sqrt(k / d^2) = sqrt(k) / d.
//!
//! ```text
//! strength = sqrt(color * intensity / pi), and for points and spots 1 / d of it at the distance d
//! ```
//!
//! Sources: glTF 2.0 Specification, sections 3.5 (Scenes) and 3.10 (Cameras); extension
//! KHR_lights_punctual.

use super::json::Json;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Attenuation, Camera, Light, LightKind, LookAt, Projection};
use glam::{DMat4, DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Transform of a node relative to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Transform {
    Matrix(DMat4),
    Parts { translation: DVec3, rotation: DQuat, scale: DVec3 },
}

impl Transform {
    pub(super) fn matrix(&self) -> DMat4 {
        match *self {
            Transform::Matrix(matrix) => matrix,
            Transform::Parts { translation, rotation, scale } => {
                DMat4::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }
}

/// A node.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) children: Vec<usize>,
    pub(super) transform: Transform,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) camera: Option<usize>,
    pub(super) light: Option<usize>,
    /// Weights of the morph targets; empty for the mesh's own.
    pub(super) weights: Vec<f64>,
}

/// Returns a unit quaternion, or the identity for one without length.
pub(super) fn quaternion([x, y, z, w]: [f64; 4]) -> DQuat {
    let length = libm::sqrt(x * x + y * y + z * z + w * w);
    match length > 1e-12 && length.is_finite() {
        true => DQuat::from_xyzw(x / length, y / length, z / length, w / length),
        false => DQuat::IDENTITY,
    }
}

/// Returns a list of numbers, such as weights.
pub(super) fn numbers(json: &Json) -> Result<Vec<f64>, LoadError> {
    json.items()?.iter().map(Json::number).collect()
}

/// Reads all nodes.
pub(super) fn read_all(root: &Json) -> Result<Vec<Node>, LoadError> {
    let items = root.member("nodes").items()?;
    let lights = root.extension("KHR_lights_punctual").member("lights").count();
    let mut nodes = Vec::with_capacity(items.len());
    for json in &items {
        let children = json.member("children").items()?;
        let transform = match json.member("matrix").numbers::<16>()? {
            Some(columns) => Transform::Matrix(DMat4::from_cols_array(&columns)),
            None => Transform::Parts {
                translation: DVec3::from_array(json.member("translation").numbers()?.unwrap_or([0.0; 3])),
                rotation: quaternion(json.member("rotation").numbers()?.unwrap_or([0.0, 0.0, 0.0, 1.0])),
                scale: DVec3::from_array(json.member("scale").numbers()?.unwrap_or([1.0; 3])),
            },
        };
        let of = |name, list, what| json.member(name).index_if_there(what, root.member(list).count());
        let light = json.extension("KHR_lights_punctual").member("light");
        nodes.push(Node {
            name: json.member("name").word().unwrap_or("").to_owned(),
            parent: None,
            children: children.iter().map(|c| c.index("node", items.len())).collect::<Result<_, _>>()?,
            transform,
            mesh: of("mesh", "meshes", "mesh")?,
            skin: of("skin", "skins", "skin")?,
            camera: of("camera", "cameras", "camera")?,
            light: light.index_if_there("light", lights)?,
            weights: numbers(&json.member("weights"))?,
        });
    }
    let mut again = vec![Vec::new(); nodes.len()];
    for i in 0..nodes.len() {
        for (k, child) in nodes[i].children.clone().into_iter().enumerate() {
            if nodes[child].parent.is_some() {
                let place = items[i].member("children").item(k);
                place.note(place.warning(format!("node {child} has a second parent: the first counts")));
                again[i].push(k);
            } else {
                nodes[child].parent = Some(i);
            }
        }
    }
    for (node, again) in nodes.iter_mut().zip(again) {
        for k in again.into_iter().rev() {
            node.children.remove(k);
        }
    }
    // With one parent each, what cannot be reached from a node without one is in a cycle.
    let roots = (0..nodes.len()).filter(|i| nodes[*i].parent.is_none()).collect();
    if order(&nodes, roots).len() < nodes.len() {
        let reason = "a node is among its own descendants".to_owned();
        return Err(root.member("nodes").refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
    }
    Ok(nodes)
}

/// Returns these nodes and their descendants in the order of the file's tree, parents first.
pub(super) fn order(nodes: &[Node], mut roots: Vec<usize>) -> Vec<usize> {
    roots.reverse();
    let (mut stack, mut order) = (roots, Vec::new());
    while let Some(node) = stack.pop() {
        order.push(node);
        stack.extend(nodes[node].children.iter().rev());
    }
    order
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    projection: Projection,
    /// Set if there is no far plane.
    is_endless: bool,
}

impl Lens {
    pub(super) fn read(json: &Json) -> Result<Lens, LoadError> {
        let kind = json.member("type");
        let positive = |json: &Json| match json.number()? {
            n if n > 0.0 => Ok(n),
            _ => Err(json.wrong("a number above 0")),
        };
        let is_ortho = json.member("orthographic").is_object() && !json.member("perspective").is_object();
        let kinds = if is_ortho { ["orthographic", "perspective"] } else { ["perspective", "orthographic"] };
        let kind = kind.one_of(&kinds);
        let part = json.member(kind);
        let far = part.member("zfar");
        if kind == "perspective" {
            let fov = part.member("yfov");
            let fov_rad = positive(&fov)?;
            if fov_rad >= PI {
                return Err(fov.wrong("an angle below pi"));
            }
            let near = positive(&part.member("znear"))?;
            let is_endless = !far.is_there();
            let far_distance = if is_endless { near * 2.0 } else { positive(&far)? };
            if far_distance <= near {
                return Err(far.wrong("a distance beyond znear"));
            }
            let projection =
                Projection::Perspective { fov_rad, near, far: far_distance, on_smaller_side: false };
            return Ok(Lens { projection, is_endless });
        }
        let half = |name: &str| {
            let json = part.member(name);
            match json.number()?.abs() {
                n if n > 0.0 => Ok(n),
                _ => Err(json.wrong("a number that is not 0")),
            }
        };
        let (x, y) = (half("xmag")?, half("ymag")?);
        let (near, far_distance) = (part.member("znear").number()?, positive(&far)?);
        if far_distance <= near {
            return Err(far.wrong("a distance beyond znear"));
        }
        let projection = Projection::OrthoContain { window: [-x, x, -y, y], near, far: far_distance };
        Ok(Lens { projection, is_endless: false })
    }

    /// Returns the camera with world matrix `world` in a scene of these bounds.
    pub(super) fn camera(&self, world: DMat4, bounds: Option<(DVec3, DVec3)>) -> Camera {
        let z = unit(world.transform_vector3(DVec3::Z)).unwrap_or(DVec3::Z);
        let up = world.transform_vector3(DVec3::Y);
        let other = if z.y.abs() < 0.5 { DVec3::Y } else { DVec3::X };
        let up = unit(up - z * up.dot(z)).unwrap_or(other);
        let eye = world.transform_point3(DVec3::ZERO);
        let eye = if eye.is_finite() { eye } else { DVec3::ZERO };
        // As far as the eye from the origin, so that the direction keeps its precision.
        let reference = eye - z * eye.abs().max_element().max(1.0);
        let mut projection = self.projection;
        if self.is_endless {
            let [near, far] = projection.near_far_mut();
            let reach = bounds.map_or(0.0, |(low, high)| (low - eye).abs().max((high - eye).abs()).length());
            *far = (reach * 1.01).clamp(*near * 2.0, *near * 1e9);
        }
        Camera { look_at: LookAt { eye, reference, up }, projection }
    }
}

/// A light in its node's space, along -z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    color: DVec3,
    range: f64,
    kind: LampKind,
}

#[derive(Clone, Copy, Debug)]
enum LampKind {
    Directional,
    Point,
    Spot { inner_rad: f64, outer_rad: f64 },
}

impl Lamp {
    pub(super) fn read(json: &Json) -> Result<Lamp, LoadError> {
        let color: [f64; 3] = json.member("color").numbers()?.unwrap_or([1.0; 3]);
        let intensity = json.member("intensity").number_or(1.0)?.clamp(0.0, 1e12);
        let kind = json.member("type");
        let kind = match kind.one_of(&["point", "directional", "spot"]) {
            "directional" => LampKind::Directional,
            "spot" => {
                let spot = json.member("spot");
                let outer = spot.member("outerConeAngle").number_or(FRAC_PI_4)?.clamp(1e-6, FRAC_PI_2);
                let inner = spot.member("innerConeAngle").number_or(0.0)?.clamp(0.0, outer);
                LampKind::Spot { inner_rad: inner, outer_rad: outer }
            }
            _ => LampKind::Point,
        };
        let strength = |c: f64| libm::sqrt((c * intensity / PI).clamp(0.0, 1e12));
        let range = json.member("range");
        let range = if range.is_there() { range.number()?.max(0.0) } else { f64::INFINITY };
        Ok(Lamp { color: DVec3::from_array(color.map(strength)), range, kind })
    }

    /// Returns the light with world matrix `world`; `None` if its direction is degenerate.
    pub(super) fn light(&self, world: DMat4) -> Option<Light> {
        let position = world.transform_point3(DVec3::ZERO);
        if !position.is_finite() {
            return None;
        }
        let direction = unit(world.transform_vector3(DVec3::NEG_Z));
        let attenuation = Attenuation { c: 0.0, l: 1.0, q: 0.0 };
        let radius = self.range;
        let kind = match self.kind {
            LampKind::Directional => LightKind::Directional { direction: direction? },
            LampKind::Point => LightKind::Point { position, attenuation, radius },
            LampKind::Spot { inner_rad, outer_rad } => LightKind::X3dSpot {
                position,
                direction: direction?,
                beam_width_rad: inner_rad,
                cut_off_rad: outer_rad,
                attenuation,
                radius,
            },
        };
        Some(Light { kind, color: self.color, ambient: DVec3::ZERO, clamp_attenuation: false })
    }
}
