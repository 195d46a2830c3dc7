//! glTF files, each with the scene, or the error with its pointer and reason, that it must give.

use super::material::encoded;
use super::*;
use fbptr_core::memory::MemoryBudget;
use fbptr_core::scene::{LightKind, LightingModel, Projection};
use glam::{DVec2, DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, PI};

/// One triangle: 36 bytes of positions, 3 bytes of indices, and two keyframes.
fn bytes() -> Vec<u8> {
    let mut bytes: Vec<u8> =
        [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0]);
    bytes.extend([0_f32, 2.0].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([0_f32, 0.0, 0.0, 4.0, 0.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// Returns a file of one triangle; `more` is JSON of further members, or of other values for some.
fn file(more: &str) -> String {
    let views = [(0, 36), (36, 3), (40, 8), (48, 24)]
        .map(|(offset, length)| format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
    let list = |name: &str, value: &str| match more.contains(&format!("\"{name}\"")) {
        true => String::new(),
        false => format!("\"{name}\":{value},"),
    };
    let members = [
        list("buffers", &format!(r#"[{{"uri":"b.bin","byteLength":{}}}]"#, bytes().len())),
        list("bufferViews", &format!("[{}]", views.join(","))),
        list(
            "accessors",
            r#"[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"},
            {"bufferView":2,"componentType":5126,"count":2,"type":"SCALAR"},
            {"bufferView":3,"componentType":5126,"count":2,"type":"VEC3"}]"#,
        ),
        list("meshes", r#"[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}]"#),
        list("materials", "[{}]"),
        list("nodes", r#"[{"mesh":0}]"#),
        list("scenes", r#"[{"nodes":[0]}]"#),
        list("asset", r#"{"version":"2.0"}"#),
    ];
    let text = format!("{{{}{more}}}", members.concat());
    text.replace(",}", "}")
}

fn load(text: &str) -> Result<GltfDocument, String> {
    let opener = &mut |name: &str| (name == "b.bin").then(bytes);
    parse(text.as_bytes(), "m.gltf", opener).map_err(|e| e.to_string())
}

fn document(more: &str) -> GltfDocument {
    let document = load(&file(more)).unwrap_or_else(|e| panic!("{e}\n{}", file(more)));
    assert!(document.warnings().is_empty(), "{:?}", document.warnings());
    document
}

fn scene(more: &str) -> Scene {
    document(more).at(0.0, 1.0)
}

#[test]
fn a_triangle_is_flat_framed_and_lit() {
    let scene = scene("");
    assert_eq!((scene.objects.len(), scene.lights.len()), (1, 1));
    let mesh = &scene.objects[0].geometry.mesh;
    assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!((mesh.normals.as_slice(), mesh.corners[2].normal), (&[DVec3::Z][..], 0));
    assert_eq!(scene.objects[0].name, "node0");
    assert!(scene.camera.is_some());
}

#[test]
fn what_several_primitives_share_is_warned_of_once() {
    let primitive = r#"{"attributes":{"POSITION":0},"indices":1,"material":0}"#;
    let more = format!(
        r#""meshes":[{{"primitives":[{primitive},{primitive}]}}],"materials":[{{"normalTexture":{{"index":0}}}}],
        "textures":[{{}}]"#
    );
    let document = load(&file(&more)).expect("a file with a warning");
    let warnings: Vec<String> = document.warnings().iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        ["m.gltf#/textures/0: warning: a texture without a picture that can be read is left out"]
    );
}

#[test]
fn bytes_are_refused_with_their_pointer() {
    for (more, expected) in [
        (r#""asset":{"version":"1.0"}"#, "m.gltf#/asset/version: version 2, found \"1.0\""),
        (
            r#""extensionsRequired":["KHR_texture_basisu"]"#,
            "m.gltf#/extensionsRequired/0: not a readable glTF: the file requires KHR_texture_basisu, which is \
             not supported: `gltf-transform ktxdecompress in.glb out.glb` writes its pictures as PNG",
        ),
        (
            r#""buffers":[{"uri":"c.bin","byteLength":4}]"#,
            "m.gltf#/buffers/0/uri: file \"c.bin\" cannot be found",
        ),
        (
            r#""buffers":[{"uri":"../b.bin","byteLength":4}]"#,
            "m.gltf#/buffers/0/uri: a file outside of the folder that it may be read from: \"../b.bin\" cannot be \
             found",
        ),
        (
            r#""buffers":[{"uri":"b.bin","byteLength":400}]"#,
            "m.gltf#/buffers/0/byteLength: not a readable glTF: a buffer of 400 bytes, and its file has 72",
        ),
        (
            r#""buffers":[{"uri":"data:;base64,!","byteLength":1}]"#,
            "m.gltf#/buffers/0/uri: not a readable URI: a data URI that is not base64",
        ),
        (
            r#""bufferViews":[{"buffer":0,"byteLength":80}]"#,
            "m.gltf#/bufferViews/0: not a readable glTF: 80 bytes from byte 0 on, and buffer 0 has 72",
        ),
        (
            r#""accessors":[{"bufferView":0,"componentType":5126,"count":4000000,"type":"VEC3"}]"#,
            "m.gltf#/accessors/0/bufferView: not a readable glTF: 4000000 elements need 48000000 bytes, and the \
             view has 36",
        ),
        (
            r#""accessors":[{"componentType":5126,"count":4000000000,"type":"VEC3"}]"#,
            "m.gltf#/accessors/0/count: numbers of all accessors: 12000000000 is over the limit of 268435456",
        ),
        (
            r#""accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}]"#,
            "m.gltf#/accessors/0/type: VEC3, found \"VEC2\"",
        ),
        (
            r#""accessors":[{"bufferView":0,"componentType":5124,"count":3,"type":"VEC3"}]"#,
            "m.gltf#/accessors/0/componentType: 5120 to 5123, 5125 or 5126, found \"5124\"",
        ),
    ] {
        assert_eq!(load(&file(more)).unwrap_err(), expected, "{more}");
    }
}

#[test]
fn indices_and_parents_are_refused_with_their_pointer() {
    for (more, expected) in [
        (
            r#""meshes":[{"primitives":[{"attributes":{"POSITION":7}}]}]"#,
            "m.gltf#/meshes/0/primitives/0/attributes/POSITION: accessor index 7 names none of the 4 there are",
        ),
        (r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":2}]}]"#, ""),
        (
            r#""nodes":[{"mesh":0,"children":[1]},{"children":[0]}]"#,
            "m.gltf#/nodes: not a readable glTF: a node is among its own descendants",
        ),
        (
            r#""nodes":[{"mesh":0,"scale":[1,2]}]"#,
            "m.gltf#/nodes/0/scale: a list of 3 numbers, found \"a list of 2\"",
        ),
        (
            r#""nodes":[{"mesh":0}],"scenes":[{"nodes":[1]}]"#,
            "m.gltf#/scenes/0/nodes/0: node index 1 names none of the 1 there are",
        ),
        (r#""scene":3"#, "m.gltf#/scene: scene index 3 names none of the 1 there are"),
        (
            r#""cameras":[{"type":"perspective","perspective":{"yfov":4,"znear":1}}]"#,
            "m.gltf#/cameras/0/perspective/yfov: an angle below pi, found \"4\"",
        ),
    ] {
        match load(&file(more)) {
            Err(found) => assert_eq!(found, expected, "{more}"),
            // Indices of any type of number are read.
            Ok(_) => assert_eq!(expected, "", "{more}"),
        }
    }
    assert_eq!(
        load("{\"asset\": {").unwrap_err(),
        "m.gltf:1:11: not a readable JSON: EOF while parsing an object"
    );
    let deep = format!("{{\"asset\":{}", "[".repeat(10_000));
    assert!(load(&deep).unwrap_err().contains("recursion limit exceeded"));
}

#[test]
fn what_exporters_write_beside_the_specification_is_drawn_with_a_warning() {
    let long = "A".repeat(200);
    for (more, objects, expected) in [
        (
            r#""meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":"TRIANGLES"}]}]"#,
            1,
            "/meshes/0/primitives/0/mode: warning: expected a mode from 0 to 6, found \"TRIANGLES\": triangles are taken",
        ),
        (
            r#""nodes":[{"children":[2]},{"children":[2]},{"mesh":0}],"scenes":[{"nodes":[0,1]}]"#,
            1,
            "/nodes/1/children/0: warning: node 2 has a second parent: the first counts",
        ),
        (
            r#""nodes":[{"children":[1]},{"mesh":0}],"scenes":[{"nodes":[1]}]"#,
            1,
            "/scenes/0/nodes/0: warning: node 1 has a parent, and is no root of a scene",
        ),
        (r#""nodes":[{"children":[1]},{"mesh":0}],"scenes":[{"nodes":[1,0]}]"#, 1, "/scenes/0/nodes/0: "),
        (
            r#""nodes":[{"mesh":0}],"scenes":[{"nodes":[0,0]}]"#,
            1,
            "/scenes/0/nodes/1: warning: node 0 is in the list twice",
        ),
        (
            &format!(r#""materials":[{{"alphaMode":"{long}"}}]"#),
            1,
            "/materials/0/alphaMode: warning: expected OPAQUE or MASK or BLEND, found \"AAAA",
        ),
        (r#""materials":[{"alphaMode":0,"name":7}]"#, 1, "/materials/0/alphaMode: "),
        (r#""materials":[{"doubleSided":1}]"#, 1, "/materials/0/doubleSided: warning: "),
        (
            r#""animations":[{"samplers":[{"input":2,"output":3,"interpolation":0}],
            "channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}]"#,
            1,
            "/animations/0/samplers/0/interpolation: warning: expected LINEAR or STEP or CUBICSPLINE, found \
             \"0\": LINEAR is taken",
        ),
        (r#""cameras":[{"type":1,"perspective":{"yfov":1,"znear":1}}]"#, 1, "/cameras/0/type: warning: "),
        (
            r#""cameras":[{"orthographic":{"xmag":1,"ymag":1,"znear":0,"zfar":9},"type":2}]"#,
            1,
            "/cameras/0/type: ",
        ),
        (
            r#""extensionsRequired":["KHR_materials_clearcoat"]"#,
            1,
            "/extensionsRequired/0: warning: the file requires KHR_materials_clearcoat, which is not supported: \
             it is drawn without",
        ),
    ] {
        let document = load(&file(more)).unwrap_or_else(|e| panic!("{e}\n{more}"));
        assert_eq!(document.at(0.0, 1.0).objects.len(), objects, "{more}");
        let said = document.warnings().first().map(ToString::to_string).unwrap_or_default();
        assert!(said.starts_with(&format!("m.gltf#{expected}")), "{more}\n{said}");
    }
    let moved = r#""nodes":[{"children":[1],"translation":[5,0,0]},{"mesh":0}],"scenes":[{"nodes":[1]}]"#;
    assert_eq!(load(&file(moved)).unwrap().at(0.0, 1.0).objects[0].model.w_axis.x, 5.0);
    // Zeros fill up the text, and a byte order mark begins it.
    assert_eq!(load(&format!("\u{feff}{}\n\0\0", file(""))).unwrap().warnings(), []);
}

#[test]
fn a_buffer_of_another_machines_path_is_read_beside_the_file() {
    let more = format!(r#""buffers":[{{"uri":"file:///C:/scans/b.bin","byteLength":{}}}]"#, bytes().len());
    let document = load(&file(&more)).unwrap();
    let said: Vec<String> = document.warnings().iter().map(ToString::to_string).collect();
    assert!(said.len() == 1 && said[0].contains("is of another machine: \"b.bin\" is read"), "{said:?}");
}

#[test]
fn what_is_below_the_cutoff_is_cut_away_by_the_alpha_of_vertices() {
    let mask = |factor: f64| {
        let more = format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":4}},"material":0}}]}}],
            "materials":[{{"alphaMode":"MASK","pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,{factor}]}}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{}},{{}},{{}},
            {{"bufferView":0,"componentType":5121,"normalized":true,"count":3,"type":"VEC4","byteOffset":12}}]"#
        );
        scene(&more).objects.first().map_or(0, |o| o.geometry.mesh.corners.len())
    };
    // Alphas 63/255, 0 and 0 of the three vertices: all are below a half; above a factor of 2 not.
    assert_eq!((mask(1.0), mask(4.0)), (0, 3));
}

#[test]
fn containers_are_refused_with_their_byte() {
    let glb = |length: u32, chunk: u32, kind: &[u8]| {
        let json = file("").replace(r#""uri":"b.bin","#, "");
        let json = format!("{json:<width$}", width = json.len().div_ceil(4) * 4);
        let body =
            [&length.to_le_bytes()[..], &(chunk.min(json.len() as u32)).to_le_bytes(), kind, json.as_bytes()]
                .concat();
        let body = [&body[..], &72_u32.to_le_bytes(), b"BIN\0", &bytes()].concat();
        let mut file = [b"glTF", &2_u32.to_le_bytes()[..], &body].concat();
        if length == 0 {
            let whole = file.len() as u32;
            file[8..12].copy_from_slice(&whole.to_le_bytes());
        }
        parse(&file, "m.glb", &mut |_| None).map_err(|e| e.to_string())
    };
    assert_eq!(glb(0, u32::MAX, b"JSON").unwrap().at(0.0, 1.0).objects.len(), 1);
    assert!(
        glb(9_999, u32::MAX, b"JSON")
            .unwrap_err()
            .starts_with("m.glb:byte 8: not a readable GLB: its length is 9999")
    );
    assert!(glb(0, 5, b"JSON").unwrap_err().contains("m.glb:byte 25: not a readable GLB: a chunk of "));
    assert_eq!(glb(0, u32::MAX, b"NOSJ").unwrap_err(), "m.glb:byte 12: not a readable GLB: no chunk of JSON");
    let of = |bytes: &[u8]| parse(bytes, "m.glb", &mut |_| None).unwrap_err().to_string();
    assert_eq!(of(b"glTF\x01\0\0\0"), "m.glb:byte 4: not a readable GLB: expected version 2, found 1");
    assert_eq!(of(b"glTF\x02\0\0\0"), "m.glb:byte 8: not a readable GLB: the file ends after 8 bytes");
}

#[test]
fn parents_carry_their_children_and_matrices_are_columns() {
    let nodes = r#""nodes":[{"children":[1],"translation":[1,2,3],"scale":[2,2,2]},
        {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},
        {"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 7,8,9,1]}],"scenes":[{"nodes":[2,0]}]"#;
    let objects = scene(nodes).objects;
    let at = |i: usize, p: DVec3| objects[i].model.transform_point3(p);
    assert_eq!((objects[0].name.as_str(), at(0, DVec3::ZERO)), ("node2", DVec3::new(7.0, 8.0, 9.0)));
    assert!((at(1, DVec3::X) - DVec3::new(1.0, 4.0, 3.0)).length() < 1e-12);
}

#[test]
fn materials_follow_the_formula() {
    let materials = |json: &str| scene(&format!("\"materials\":[{json}]")).objects[0].material.clone();
    let plastic = materials(
        r#"{"name":"p","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,0.25],"metallicFactor":0,"roughnessFactor":1}}"#,
    );
    assert_eq!(plastic.kd, DVec3::new(1.0, encoded(0.5), 0.0));
    assert_eq!((plastic.ka, plastic.ks, plastic.n), (plastic.kd, DVec3::ZERO, 0.0));
    assert_eq!((plastic.transparency, plastic.name.as_str()), (0.0, "p"));
    let default = materials("{}");
    assert_eq!((default.kd, default.ks), (DVec3::splat(0.5), DVec3::ZERO));
    let glass = materials(r#"{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}}"#);
    assert_eq!(glass.transparency, 0.75);
    let glow = materials(
        r#"{"emissiveFactor":[1,0,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":0.25}}}"#,
    );
    assert_eq!(glow.emissive, DVec3::new(encoded(0.25), 0.0, 0.0));
    let unlit = materials(
        r#"{"extensions":{"KHR_materials_unlit":{}},"pbrMetallicRoughness":{"baseColorFactor":[0,1,0,1]}}"#,
    );
    assert_eq!((unlit.model, unlit.emissive, unlit.kd), (LightingModel::Unlit, DVec3::Y, DVec3::ZERO));
    assert!((encoded(0.5) - 0.735_356_98).abs() < 1e-6 && encoded(-1.0) == 0.0 && encoded(1.0) == 1.0);
    let masked = r#""materials":[{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0]}}]"#;
    assert!(load(&file(masked)).unwrap().at(0.0, 1.0).objects.is_empty());
    let shadowed = r#""materials":[{"pbrMetallicRoughness":{"metallicFactor":0},"occlusionTexture":{"index":0,"strength":0.5}}],
        "textures":[{"source":0}],"images":[{"uri":"data:;base64,UDYgMSAxIDI1NQqA//8="}]"#;
    let material = scene(shadowed).objects[0].material.clone();
    let dimmed = encoded(1.0 + 0.5 * (128.0 / 255.0 - 1.0));
    assert_eq!((material.kd, material.ka), (DVec3::ONE, DVec3::splat(dimmed)));
    let is_double = |json: &str| scene(json).objects[0].two_sided_lighting;
    assert!(is_double(r#""materials":[{"doubleSided":true}]"#) && !is_double(""));
}

#[test]
fn a_texture_transform_is_the_specifications_example() {
    // The lower left quarter of the picture, turned clockwise.
    let text = r#"{"offset":[0,1],"rotation":1.5707963267948966,"scale":[0.5,0.5]}"#;
    let value = serde_json::from_str(text).unwrap();
    let transform = maps::TextureTransform::read(&Json::root(&value, "f", &json::Notes::default())).unwrap();
    for (from, to) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0])] {
        assert!((transform.apply(DVec2::from(from)) - DVec2::from(to)).length() < 1e-12, "{from:?}");
    }
}

#[test]
fn cameras_and_lights_stand_in_their_nodes() {
    let more = r#""cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},
        {"type":"orthographic","orthographic":{"xmag":2,"ymag":1,"znear":0,"zfar":9}}],
        "nodes":[{"mesh":0},{"camera":0,"translation":[0,0,5]},{"camera":1},
        {"extensions":{"KHR_lights_punctual":{"light":0}},"rotation":[0,0.7071067811865476,0,0.7071067811865476]},
        {"extensions":{"KHR_lights_punctual":{"light":1}},"translation":[1,2,3]}],"scenes":[{"nodes":[0,1,2,3,4]}],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"directional","intensity":3.141592653589793},
        {"type":"spot","color":[1,0,0],"intensity":12.566370614359172,"range":7,"spot":{"innerConeAngle":0.1}}]}}"#;
    let document = document(more);
    let scene = document.at(0.0, 1.5);
    let camera = scene.camera.unwrap();
    assert_eq!(camera.look_at.eye, DVec3::new(0.0, 0.0, 5.0));
    assert!((camera.look_at.reference - camera.look_at.eye).normalize().dot(DVec3::NEG_Z) > 0.999_999);
    let Projection::Perspective { fov_rad, near, far, .. } = camera.projection else { panic!("{camera:?}") };
    assert!(fov_rad == 0.5 && near == 0.1 && far > 5.0 && far < 10.0, "far {far}");
    assert!(document.has_camera() && document.has_lights() && !document.is_animated());
    let [sun, spot] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    let LightKind::Directional { direction } = sun.kind else { panic!("{sun:?}") };
    assert!((direction - DVec3::NEG_X).length() < 1e-12, "{direction}");
    assert_eq!(sun.color, DVec3::ONE);
    let LightKind::X3dSpot { position, cut_off_rad, beam_width_rad, radius, attenuation, .. } = spot.kind
    else {
        panic!("{spot:?}")
    };
    assert_eq!((position, radius, attenuation.l), (DVec3::new(1.0, 2.0, 3.0), 7.0, 1.0));
    assert_eq!((cut_off_rad, beam_width_rad), (PI / 4.0, 0.1));
    assert_eq!(spot.color, DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn animations_hold_move_and_begin_again() {
    let with = |mode: &str| {
        document(&format!(
            r#""animations":[{{"samplers":[{{"input":2,"output":3,"interpolation":"{mode}"}}],
            "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}]"#
        ))
    };
    let x = |document: &GltfDocument, time: f64| document.at(time, 1.0).objects[0].model.w_axis.x;
    let linear = with("LINEAR");
    assert!(linear.is_animated());
    assert_eq!([-1.0, 0.0, 0.5, 1.5, 2.0, 2.5].map(|t| x(&linear, t)), [0.0, 0.0, 1.0, 3.0, 0.0, 1.0]);
    assert_eq!(x(&linear, f64::NAN), 0.0);
    let step = with("STEP");
    assert_eq!([0.0, 1.9, 2.0].map(|t| x(&step, t)), [0.0, 0.0, 0.0]);
    let wrong = load(&file(
        r#""animations":[{"samplers":[{"input":2,"output":3,"interpolation":"CUBICSPLINE"}],
        "channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}]"#,
    ));
    assert_eq!(
        wrong.unwrap_err(),
        "m.gltf#/animations/0/samplers/0/output: not a readable glTF: 6 numbers for 2 keyframes of 3"
    );
    // The camera stands still: it frames the scene at all moments.
    assert_eq!(linear.at(0.0, 1.0).camera, linear.at(1.3, 1.0).camera);
}

#[test]
fn quaternions_go_the_shorter_way() {
    let a = nodes::quaternion([0.0, 0.0, 0.0, 1.0]);
    let half = FRAC_PI_2 / 2.0;
    let b = nodes::quaternion([0.0, 0.0, -half.sin(), -half.cos()]);
    let middle = animation::slerp(a, b, 0.5);
    let expected = nodes::quaternion([0.0, 0.0, (half / 2.0).sin(), (half / 2.0).cos()]);
    assert!(middle.dot(expected).abs() > 1.0 - 1e-12, "{middle}");
    assert_eq!(nodes::quaternion([0.0; 4]), glam::DQuat::IDENTITY);
}

#[test]
fn colours_of_vertices_are_encoded_and_their_alpha_counts_with_blend() {
    let colors = |mode: &str| {
        let more = format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":4}},"material":0}}]}}],
            "materials":[{{"alphaMode":"{mode}"}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{}},{{}},{{}},
            {{"bufferView":0,"componentType":5121,"normalized":true,"count":3,"type":"VEC4","byteOffset":12}}]"#
        );
        scene(&more).objects[0].geometry.mesh.colors.clone()
    };
    // 1.0 as f32 is 00 00 80 3f, so that the first colour is black with blue 128/255 and alpha 63/255.
    let blue = encoded(128.0 / 255.0);
    assert_eq!(colors("BLEND")[0], DVec4::new(0.0, 0.0, blue, 63.0 / 255.0));
    assert_eq!(colors("OPAQUE")[0], DVec4::new(0.0, 0.0, blue, 1.0));
}

#[test]
fn memory_is_reserved_before_it_is_used() {
    let text = file(
        r#""accessors":[{"componentType":5126,"count":4000000,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#,
    );
    let memory = &mut LoadMemory::new(&MemoryBudget::new(10 << 20), u64::MAX);
    let opener = &mut |_: &str| Some(bytes());
    let error = parse_in(text.as_bytes(), "m.gltf", LoadContext { folder: "", opener, memory }).unwrap_err();
    assert_eq!(error.code(), fbptr_core::error::Code::Quota, "{error}");
    assert!(error.to_string().starts_with("m.gltf#/accessors/0: "), "{error}");
}
