//! Reading and writing of scenes as JSON.
//!
//! In: the text of a SCENE, or of a test case `{about, scene, expected}` that contains one. Out: an
//! [`EyeScene`], or an error with its path. Unknown fields are errors; numbers are read exactly to
//! the last bit.
//!
//! SCENE: `dim` N; `pixels` [n_1..n_M]; `d`; `S` [S_1..S_M]; `aperture_tan` or `aperture_deg`, one
//! for each hidden axis; `I_d` number or [r,g,b] in 0..1 (default 0); `view` {k,n} (default off);
//! `background` (default black); `eye` {position, rotations [[a,b,degrees]..]}; `lights`; `facets`
//! [{v: N points, color}]. A light: `type` "parallel" with `direction` and optionally `point`, or
//! "radial" with `position`; `k`, `n`, `color`. Defaults: n = 0 for parallel lights and the view,
//! N-1 for radial lights; k = 2^n; white. Any colour may be a string: a CSS name, or hex with or
//! without `#`, in which ff is the field's maximum.

mod node;
#[cfg(test)]
mod tests;

pub(super) use node::Node;

use super::error::EyeError;
use super::pose::{Pose, Rotation};
use super::scene::{EyeLight, EyeLightKind, EyeScene, Facet, Falloff, MAX_DIM, SceneParts};
use serde_json::{Value, json};

/// Returns an upper bound of the bytes that reading a scene from this text takes, including the
/// scene. The text is not parsed, only its brackets and commas are counted: each array has room for
/// at least 4 values, each object is a node of 11, and lists have room for twice their items while
/// they grow.
pub fn json_bytes(text: &[u8]) -> u64 {
    const VALUE: u64 = size_of::<Value>() as u64;
    let (mut arrays, mut objects, mut items) = (0, 0, 1);
    for byte in text {
        match byte {
            b'[' => arrays += 1,
            b'{' => objects += 1,
            b',' => items += 1,
            _ => {}
        }
    }
    // A number is 8 bytes of the scene, a point or facet a list of its own.
    2 * text.len() as u64
        + arrays * (4 * VALUE + 64)
        + objects * (11 * (VALUE + size_of::<String>() as u64) + 128)
        + items * (3 * VALUE + 3 * 24)
}

impl EyeScene {
    /// Reads a scene, or the scene of a test case.
    pub fn from_json(text: &[u8]) -> Result<Self, EyeError> {
        let value: Value = serde_json::from_slice(text).map_err(|e| EyeError::Json {
            line: e.line(),
            column: e.column(),
            message: e.to_string().split(" at line ").next().unwrap_or_default().to_owned(),
        })?;
        Self::from_value(&value)
    }

    /// Reads a scene, or the scene of a test case, from parsed JSON.
    pub fn from_value(value: &Value) -> Result<Self, EyeError> {
        let root = Node { value, path: String::new() };
        match value.get("scene") {
            Some(scene) => {
                root.object(&["about", "scene", "expected"])?;
                read_scene(&Node { value: scene, path: "scene".into() })
            }
            None => read_scene(&root),
        }
    }

    /// Returns the scene as JSON, which reads back as an equal scene.
    pub fn to_value(&self) -> Value {
        let rotations: Vec<Value> =
            self.pose.rotations.iter().map(|r| json!([r.a, r.b, r.angle_deg])).collect();
        let mut scene = json!({
            "dim": self.dim, "pixels": self.pixels, "d": self.distance, "S": self.size,
            "I_d": self.diffuse, "view": {"k": self.view.k, "n": self.view.n}, "background": self.background,
            "eye": {"position": self.pose.position, "rotations": rotations},
            "lights": self.lights.iter().map(light_value).collect::<Vec<_>>(),
            "facets": self.facets.iter().map(|f| json!({"v": f.v, "color": f.color})).collect::<Vec<_>>(),
        });
        if self.hidden_dim() > 0 {
            scene["aperture_tan"] = json!(self.aperture_tan);
        }
        scene
    }
}

fn light_value(light: &EyeLight) -> Value {
    let mut out = json!({"k": light.falloff.k, "n": light.falloff.n, "color": light.color});
    match &light.kind {
        EyeLightKind::Sun { direction } => {
            out["type"] = json!("parallel");
            out["direction"] = json!(direction);
        }
        EyeLightKind::Plane { direction, point } => {
            out["type"] = json!("parallel");
            out["direction"] = json!(direction);
            out["point"] = json!(point);
        }
        EyeLightKind::Radial { position } => {
            out["type"] = json!("radial");
            out["position"] = json!(position);
        }
    }
    out
}

fn read_scene(node: &Node) -> Result<EyeScene, EyeError> {
    node.object(&[
        "dim",
        "pixels",
        "d",
        "S",
        "aperture_tan",
        "aperture_deg",
        "I_d",
        "view",
        "background",
        "eye",
        "lights",
        "facets",
    ])?;
    let dim = node.field("dim")?.integer(MAX_DIM as u64)? as usize;
    if dim < 2 {
        let expected = format!("a whole number from 2 to {MAX_DIM}");
        return Err(EyeError::Range { path: node.at("dim"), expected, found: dim as f64 });
    }
    let mut pixels = Vec::new();
    for n in node.field("pixels")?.array()? {
        pixels.push(n.integer(u32::MAX.into())? as u32);
    }
    let hidden = (dim - 1).saturating_sub(pixels.len());
    let parts = SceneParts {
        dim,
        distance: node.field("d")?.number()?,
        size: node.field("S")?.numbers()?,
        aperture_tan: read_aperture(node, hidden)?,
        diffuse: match node.optional("I_d") {
            None => [0.0; 3],
            Some(n) if n.value.is_number() => [n.number()?; 3],
            Some(n) => n.color(1.0)?,
        },
        view: match node.optional("view") {
            None => Falloff::OFF,
            Some(view) => {
                view.object(&["k", "n"])?;
                read_falloff(&view, 0.0)?
            }
        },
        background: node.optional("background").map_or(Ok([0.0; 3]), |n| n.color(255.0))?,
        pose: node.optional("eye").map_or(Ok(Pose::identity(dim)), |eye| read_pose(&eye, dim))?,
        lights: read_list(node.optional("lights"), |light| read_light(light, dim))?,
        facets: read_list(Some(node.field("facets")?), |facet| {
            facet.object(&["v", "color"])?;
            let v = read_list(Some(facet.field("v")?), |point| point.numbers())?;
            Ok(Facet { v, color: facet.field("color")?.color(255.0)? })
        })?,
        pixels,
    };
    // In a test case the error's path keeps the prefix of the scene.
    EyeScene::new(parts).map_err(|e| prefixed(e, &node.path))
}

fn read_aperture(node: &Node, hidden: usize) -> Result<Vec<f64>, EyeError> {
    match (node.optional("aperture_tan"), node.optional("aperture_deg")) {
        (Some(_), Some(deg)) => Err(EyeError::Type {
            path: deg.path,
            expected: "either aperture_tan or aperture_deg".into(),
            found: "both".into(),
        }),
        (Some(tan), None) => tan.numbers(),
        (None, Some(deg)) => read_list(Some(deg), |angle| {
            let degrees = angle.number()?;
            if !(0.0..90.0).contains(&degrees) {
                let expected = "an angle from 0 to below 90".into();
                return Err(EyeError::Range { path: angle.path.clone(), expected, found: degrees });
            }
            Ok(match degrees {
                45.0 => 1.0,
                _ => libm::tan(degrees * (std::f64::consts::PI / 180.0)),
            })
        }),
        (None, None) if hidden == 0 => Ok(Vec::new()),
        (None, None) => Err(EyeError::Missing { path: node.at("aperture_tan") }),
    }
}

fn read_pose(eye: &Node, dim: usize) -> Result<Pose, EyeError> {
    eye.object(&["position", "rotations"])?;
    let mut pose = Pose::identity(dim);
    if let Some(position) = eye.optional("position") {
        pose.position = position.numbers()?;
    }
    pose.rotations = read_list(eye.optional("rotations"), |turn| {
        let entries = turn.array()?;
        let [a, b, angle] = &entries[..] else {
            let expected = "3 (two axes and an angle in degrees)".into();
            return Err(EyeError::Length { path: turn.path.clone(), expected, found: entries.len() });
        };
        let most = dim as u64 - 1;
        Ok(Rotation {
            a: a.integer(most)? as usize,
            b: b.integer(most)? as usize,
            angle_deg: angle.number()?,
        })
    })?;
    Ok(pose)
}

fn read_light(light: &Node, dim: usize) -> Result<EyeLight, EyeError> {
    let kind = light.field("type")?;
    let (kind, default_n) = match kind.value.as_str() {
        Some("parallel") => {
            light.object(&["type", "direction", "point", "k", "n", "color"])?;
            let direction = light.field("direction")?.numbers()?;
            match light.optional("point") {
                None => (EyeLightKind::Sun { direction }, 0.0),
                Some(point) => (EyeLightKind::Plane { direction, point: point.numbers()? }, 0.0),
            }
        }
        Some("radial") => {
            light.object(&["type", "position", "k", "n", "color"])?;
            let position = light.field("position")?.numbers()?;
            (EyeLightKind::Radial { position }, (dim - 1) as f64)
        }
        _ => return Err(kind.not("\"parallel\" or \"radial\"")),
    };
    let color = light.optional("color").map_or(Ok([1.0; 3]), |n| n.color(1.0))?;
    Ok(EyeLight { kind, falloff: read_falloff(light, default_n)?, color })
}

fn read_falloff(node: &Node, default_n: f64) -> Result<Falloff, EyeError> {
    let n = node.optional("n").map_or(Ok(default_n), |n| n.number())?;
    let k = node.optional("k").map_or(Ok(libm::exp2(n)), |k| k.number())?;
    Ok(Falloff { k, n })
}

fn read_list<T>(list: Option<Node>, read: impl Fn(&Node) -> Result<T, EyeError>) -> Result<Vec<T>, EyeError> {
    list.map_or(Ok(Vec::new()), |list| list.array()?.iter().map(read).collect())
}

fn prefixed(mut error: EyeError, prefix: &str) -> EyeError {
    if let EyeError::Type { path, .. }
    | EyeError::Missing { path }
    | EyeError::Unknown { path, .. }
    | EyeError::Length { path, .. }
    | EyeError::Range { path, .. }
    | EyeError::TooBig { path, .. } = &mut error
        && !prefix.is_empty()
    {
        *path = format!("{prefix}.{path}");
    }
    error
}
