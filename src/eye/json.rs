//! Scenes as JSON text, in and out.
//!
//! In: the text of a SCENE, or of a case `{about, scene, expected}` that holds one. Out: an [`EyeScene`], or the place of what
//! is wrong with it. Unknown fields are refused; numbers are read to the last bit.
//!
//! SCENE: `dim` N; `pixels` [n_1..n_M]; `d`; `S` [S_1..S_M]; `aperture_tan` or `aperture_deg`, one a hidden axis; `I_d` number
//! or [r,g,b] in 0..1 (default 0); `view` {k,n} (default off); `background` (default black); `eye` {position, rotations
//! [[a,b,degrees]..]}; `lights`; `facets` [{v: N points, color}]. A light: `type` "parallel" with `direction` and perhaps `point`,
//! or "radial" with `position`; `k`, `n`, `color`. Defaults: n = 0 parallel and view, N-1 radial; k = 2^n; white. Any colour
//! may be a string: a CSS name, or hex with or without `#`, in which ff is the most that the field can be.

use super::error::EyeError;
use super::pose::{Pose, Rotation};
use super::scene::{EyeLight, EyeLightKind, EyeScene, Facet, Falloff, MAX_DIM, SceneParts};
use crate::memory::parse_color;
use serde_json::{Map, Value, json};

impl EyeScene {
    /// Reads a scene, or the scene of a case file.
    pub fn from_json(text: &[u8]) -> Result<Self, EyeError> {
        let value: Value = serde_json::from_slice(text).map_err(|e| EyeError::Json {
            line: e.line(),
            column: e.column(),
            message: e.to_string().split(" at line ").next().unwrap_or_default().to_owned(),
        })?;
        Self::from_value(&value)
    }

    /// Reads a scene, or the scene of a case file, from parsed JSON.
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

    /// The scene as JSON, which reads back as the same scene.
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
    let dim = node.field("dim")?.whole(MAX_DIM as u64)? as usize;
    if dim < 2 {
        let expected = format!("a whole number from 2 to {MAX_DIM}");
        return Err(EyeError::Range { path: node.at("dim"), expected, found: dim as f64 });
    }
    let mut pixels = Vec::new();
    for n in node.field("pixels")?.array()? {
        pixels.push(n.whole(u32::MAX.into())? as u32);
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
    // A scene inside a case file keeps its prefix in the place of the error.
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
        Ok(Rotation { a: a.whole(most)? as usize, b: b.whole(most)? as usize, angle_deg: angle.number()? })
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

/// A value and its place.
pub(super) struct Node<'a> {
    pub(super) value: &'a Value,
    pub(super) path: String,
}

impl<'a> Node<'a> {
    fn at(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn not(&self, expected: &str) -> EyeError {
        let text = match self.value {
            Value::Array(list) => format!("an array of {}", list.len()),
            Value::Object(_) => "an object".to_owned(),
            other => other.to_string(),
        };
        let found = text.chars().take(40).collect();
        let path = if self.path.is_empty() { "the scene".to_owned() } else { self.path.clone() };
        EyeError::Type { path, expected: expected.to_owned(), found }
    }

    /// An object with no other fields than these.
    pub(super) fn object(&self, known: &[&str]) -> Result<&'a Map<String, Value>, EyeError> {
        let map = self.value.as_object().ok_or_else(|| self.not("an object"))?;
        match map.keys().find(|key| !known.contains(&key.as_str())) {
            Some(key) => Err(EyeError::Unknown { path: self.at(key), expected: known.join(", ") }),
            None => Ok(map),
        }
    }

    pub(super) fn optional(&self, key: &str) -> Option<Node<'a>> {
        self.value.get(key).map(|value| Node { value, path: self.at(key) })
    }

    pub(super) fn field(&self, key: &str) -> Result<Node<'a>, EyeError> {
        self.optional(key).ok_or_else(|| EyeError::Missing { path: self.at(key) })
    }

    pub(super) fn array(&self) -> Result<Vec<Node<'a>>, EyeError> {
        let list = self.value.as_array().ok_or_else(|| self.not("an array"))?;
        let node = |(i, value)| Node { value, path: format!("{}[{i}]", self.path) };
        Ok(list.iter().enumerate().map(node).collect())
    }

    pub(super) fn number(&self) -> Result<f64, EyeError> {
        self.value.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.not("a finite number"))
    }

    /// A whole number from 0 to `most`.
    pub(super) fn whole(&self, most: u64) -> Result<u64, EyeError> {
        let found = self.number()?;
        if (0.0..=most as f64).contains(&found) && found.trunc() == found {
            Ok(found as u64)
        } else {
            let expected = format!("a whole number from 0 to {most}");
            Err(EyeError::Range { path: self.path.clone(), expected, found })
        }
    }

    pub(super) fn numbers(&self) -> Result<Vec<f64>, EyeError> {
        // No path is built for entries that are fine: facets are many.
        let list = self.value.as_array().ok_or_else(|| self.not("an array of numbers"))?;
        let read = |(i, value): (usize, &'a Value)| match value {
            Value::Number(_) => Node { value, path: String::new() }.number(),
            _ => Node { value, path: format!("{}[{i}]", self.path) }.number(),
        };
        list.iter().enumerate().map(read).collect()
    }

    /// A colour: R, G, B as three numbers, or as the name of a CSS colour or hex, scaled so that ff is `full`.
    fn color(&self, full: f64) -> Result<[f64; 3], EyeError> {
        const EXPECTED: &str = "three numbers, a CSS colour name, or gg or rrggbb in hex";
        let word = match self.value {
            Value::String(word) => word,
            Value::Array(_) => return self.triple(),
            _ => return Err(self.not(EXPECTED)),
        };
        let hex = word.strip_prefix('#').unwrap_or(word);
        match parse_color(hex.as_bytes()) {
            Some([r, g, b, 255]) if hex.len() == word.len() || hex.bytes().all(|b| b.is_ascii_hexdigit()) => {
                Ok([r, g, b].map(|c| f64::from(c) * full / 255.0))
            }
            _ => Err(self.not(EXPECTED)),
        }
    }

    pub(super) fn triple(&self) -> Result<[f64; 3], EyeError> {
        let list = self.numbers()?;
        list.as_slice().try_into().map_err(|_| EyeError::Length {
            path: self.path.clone(),
            expected: "3".into(),
            found: list.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Code;

    const GOOD: &str = r#"{"dim": 3, "pixels": [4], "d": 1, "S": [2], "aperture_tan": [0.5], "I_d": 0.2,
        "view": {"k": 2, "n": 1}, "background": [1, 2, 3], "eye": {"position": [0, 0, 1], "rotations": [[0, 2, 45]]},
        "lights": [{"type": "parallel", "direction": [0, -1, 0], "k": 1, "n": 0, "color": [1, 0.5, 0]},
                   {"type": "radial", "position": [1, 2, 3]},
                   {"type": "parallel", "direction": [0, 0, 2], "point": [0, 0, 5], "n": 1}],
        "facets": [{"v": [[1, 0, 0], [1, 1, 0], [1, 0, 1]], "color": [200, 100, 50]}]}"#;

    fn error_of(text: &str) -> String {
        EyeScene::from_json(text.as_bytes()).expect_err(text).to_string()
    }

    #[test]
    fn a_scene_is_read_with_its_defaults_and_written_back() {
        let scene = EyeScene::from_json(GOOD.as_bytes()).unwrap();
        assert_eq!(scene.lights[0].falloff, Falloff { k: 1.0, n: 0.0 });
        assert_eq!(scene.lights[1].falloff, Falloff { k: 4.0, n: 2.0 });
        assert_eq!(scene.lights[2].falloff, Falloff { k: 2.0, n: 1.0 });
        assert_eq!(scene.lights[1].color, [1.0; 3]);
        assert_eq!((scene.screen_dim(), scene.hidden_dim()), (1, 1));
        assert_eq!(EyeScene::from_json(scene.to_value().to_string().as_bytes()).unwrap(), scene);
        let short = r#"{"dim": 2, "pixels": [1], "d": 1, "S": [1], "facets": []}"#;
        let scene = EyeScene::from_json(short.as_bytes()).unwrap();
        assert_eq!((scene.view, scene.diffuse, scene.background), (Falloff::OFF, [0.0; 3], [0.0; 3]));
    }

    #[test]
    fn colours_may_be_words() {
        let read = |text: String| EyeScene::from_json(text.as_bytes());
        let scene = read(
            GOOD.replacen("0.2", "\"#33\"", 1)
                .replacen("[1, 2, 3], \"eye", "\"Tomato\", \"eye", 1)
                .replacen("[1, 0.5, 0]", "\"0033FF\"", 1)
                .replacen("[200, 100, 50]", "\"#c86432\"", 1),
        )
        .unwrap();
        assert_eq!((scene.diffuse, scene.background), ([0.2; 3], [255.0, 99.0, 71.0]));
        assert_eq!((scene.lights[0].color, scene.facets[0].color), ([0.0, 0.2, 1.0], [200.0, 100.0, 50.0]));
        for word in ["reddish", "#red", "", "#", "##ff", "ff000080", "transparent"] {
            assert_eq!(
                error_of(&GOOD.replacen("[200, 100, 50]", &format!("{word:?}"), 1)),
                format!(
                    "facets[0].color: expected three numbers, a CSS colour name, or gg or rrggbb in hex, found {word:?}"
                )
            );
        }
        assert!(error_of(&GOOD.replacen("0.2", "true", 1)).starts_with("I_d: expected three numbers, a CSS"));
    }

    #[test]
    fn every_mistake_is_refused_with_its_place() {
        for (from, to, want) in [
            (r#""dim": 3"#, r#""dim": 9"#, "dim: expected a whole number from 0 to 8, found 9"),
            (r#""dim": 3"#, r#""dim": 1"#, "dim: expected a whole number from 2 to 8, found 1"),
            (r#""dim": 3, "#, "", "dim: missing"),
            (r#""dim": 3"#, r#""dim": 2.5"#, "dim: expected a whole number from 0 to 8, found 2.5"),
            ("[4]", "[]", "pixels: expected 1 to 2 (one a screen axis) entries, found 0"),
            ("[4]", "[0]", "pixels[0]: expected a whole number from 1, found 0"),
            ("[4]", "[4000000000]", "pixels: 4000000000 is over the limit of 67108864"),
            (r#""d": 1"#, r#""d": 0"#, "d: expected a finite number over 0, found 0"),
            (r#""S": [2]"#, r#""S": [2, 2]"#, "S: expected 1 entries, found 2"),
            ("[0.5], ", "[0.5, 0.5], ", "aperture_tan: expected 1 entries, found 2"),
            ("[0.5], ", "[-0.5], ", "aperture_tan[0]: expected a finite tangent of at least 0, found -0.5"),
            (r#""aperture_tan": [0.5], "#, "", "aperture_tan: missing"),
            (
                r#""aperture_tan": [0.5]"#,
                r#""aperture_deg": [90]"#,
                "aperture_deg[0]: expected an angle from 0 to below 90, found 90",
            ),
            (r#""I_d": 0.2"#, r#""I_d": 1.2"#, "I_d[0]: expected 0 to 1, found 1.2"),
            (r#""I_d": 0.2"#, r#""I_d": [0, 1]"#, "I_d: expected 3 entries, found 2"),
            (r#""n": 1}, "b"#, r#""m": 1}, "b"#, "view.m: unknown field, expected one of k, n"),
            (r#""k": 2"#, r#""k": -2"#, "view.k: expected a finite number of at least 0, found -2"),
            ("[0, 0, 1], \"r", "[0, 1], \"r", "eye.position: expected 3 entries, found 2"),
            ("[0, 2, 45]", "[0, 3, 45]", "eye.rotations[0][1]: expected a whole number from 0 to 2, found 3"),
            (
                "[0, 2, 45]",
                "[2, 2, 45]",
                "eye.rotations[0][1]: expected another axis than the first, found 2",
            ),
            (
                "[0, 2, 45]",
                "[0, 2]",
                "eye.rotations[0]: expected 3 (two axes and an angle in degrees) entries, found 2",
            ),
            ("\"parallel\"", "\"spot\"", r#"lights[0].type: expected "parallel" or "radial", found "spot""#),
            ("[0, -1, 0]", "[0, 0, 0]", "lights[0].direction: expected a vector that is not zero, found 0"),
            (
                "\"n\": 0,",
                "\"n\": 2,",
                "lights[0].n: expected 0 (a parallel light without a point is infinitely far), found 2",
            ),
            ("[1, 0.5, 0]", "[1, 2, 0]", "lights[0].color[1]: expected 0 to 1, found 2"),
            (
                "[1, 2, 3]}",
                "[1, 2, 3], \"point\": 0}",
                "lights[1].point: unknown field, expected one of type, position, k, n, color",
            ),
            ("[1, 1, 0], ", "", "facets[0].v: expected 3 entries, found 2"),
            ("[1, 1, 0]", "[1, 1]", "facets[0].v[1]: expected 3 entries, found 2"),
            ("[1, 1, 0]", "[1, null, 0]", "facets[0].v[1][1]: expected a finite number, found null"),
            ("[200, 100, 50]", "[200, 256, 50]", "facets[0].color[1]: expected 0 to 255, found 256"),
            (", \"color\": [200, 100, 50]", "", "facets[0].color: missing"),
            (
                "\"facets\"",
                "\"faces\"",
                "faces: unknown field, expected one of dim, pixels, d, S, aperture_tan, aperture_deg, I_d, view, background, eye, lights, facets",
            ),
            ("[1, 1, 0]", "[1, 1e999, 0]", "line 6 column 46: number out of range"),
            ("[1, 1, 0]", "[1, NaN, 0]", "line 6 column 42: expected value"),
        ] {
            assert!(GOOD.contains(from), "{from}");
            assert_eq!(error_of(&GOOD.replacen(from, to, 1)), want);
        }
        assert_eq!(error_of("[]"), "the scene: expected an object, found an array of 0");
        let case = format!(r#"{{"about": "x", "scene": {}}}"#, GOOD.replacen("[1, 1, 0]", "[1, 1]", 1));
        assert_eq!(error_of(&case), "scene.facets[0].v[1]: expected 3 entries, found 2");
        let huge = GOOD.replacen("[4]", "[4000000000]", 1);
        assert_eq!(EyeScene::from_json(huge.as_bytes()).unwrap_err().code(), Code::TooBig);
    }
}
