//! Maps of emission, normals and occlusion against the truth: random scenes that wear them, and glTF
//! files made here whose pictures are known.
//!
//! Guards against maps that are drawn at another place, in another frame, or otherwise at another
//! vector level; and against scenes without maps that are drawn by the path of those with.

use crate::fast_path::{case, draw, with};
use fbptr::load::gltf::{self, GltfDocument};
use fbptr::memory::VideoMemory;
use fbptr::pipeline::{Part, RenderOptions, RenderPath, Renderer, SceneOptions, Target, plan_scene};
use fbptr::scene::{
    Camera, Filter, Light, LookAt, NormalMap, OcclusionMap, Projection, Sampling, Scene, SurfaceMap,
    SurfaceMaps, Texture, Wrap, encoded,
};
use fbptr::simd::Level;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{Case, Random};
use fbptr::truth::{Settings, TruthPicture};
use glam::{DVec2, DVec3, DVec4};
use std::sync::Arc;

/// Returns a map of noise over the corners of a mesh.
fn map(dice: &mut Random, places: &[DVec3]) -> SurfaceMap {
    let [width, height] = dice.pick(&[[1, 1], [7, 5], [1, 6], [16, 16], [3, 1]]);
    let bytes = (0..width * height * 4).map(|_| dice.below(256) as u8).collect();
    let [u, v] = [dice.point(-1.0, 1.0), dice.point(-1.0, 1.0)];
    let wraps = [Wrap::Repeat, Wrap::Clamp];
    SurfaceMap {
        texture: Arc::new(Texture::new(width, height, bytes).unwrap()),
        sampling: Sampling {
            filter: dice.pick(Filter::ALL),
            wrap_s: dice.pick(&wraps),
            wrap_t: dice.pick(&wraps),
        },
        texcoords: places.iter().map(|p| DVec2::new(u.dot(*p), v.dot(*p))).collect(),
    }
}

/// Gives most objects of a case some maps.
fn wear_maps(case: &mut Case, seed: u64) {
    let dice = &mut Random::new(seed ^ 0x5eed);
    for object in &mut case.scene.objects {
        let mesh = &object.geometry.mesh;
        let places: Vec<DVec3> = mesh.corners.iter().map(|c| mesh.positions[c.position as usize]).collect();
        let mut maps = SurfaceMaps::default();
        if dice.one_in(2) {
            maps.emission = Some(map(dice, &places));
            object.material.emissive = dice.point(0.0, 1.5);
        }
        if !dice.one_in(3) {
            let (axis, map, scale) = (dice.point(-1.0, 1.0), map(dice, &places), dice.real(-0.5, 2.0));
            // Some corners have no tangent.
            let tangent = |_: &DVec3| match dice.one_in(9) {
                true => DVec4::ZERO,
                false => (axis + dice.point(-0.2, 0.2)).extend(dice.pick(&[1.0, -1.0])),
            };
            let tangents = places.iter().map(tangent).collect();
            maps.normal = Some(NormalMap { map, scale, tangents });
        }
        if dice.one_in(2) {
            let (map, strength, mean) = (map(dice, &places), dice.real(0.0, 1.0), dice.real(0.2, 1.0));
            maps.occlusion = Some(OcclusionMap { map, strength, mean });
        }
        let has_any = maps.all().next().is_some();
        object.style.maps = has_any.then(|| Arc::new(maps));
    }
}

#[test]
fn random_scenes_with_maps_are_right_at_every_level_and_by_every_path() {
    let mut fast = Renderer::default();
    let mut plain = Renderer::new(RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() });
    let mut others = Vec::new();
    for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
        others.extend([1, 3].map(|threads| (level, threads, with(level, threads))));
    }
    let (mut wrong, mut tiles) = (Vec::new(), 0);
    for seed in 1..150 {
        let mut case = case(seed);
        wear_maps(&mut case, seed);
        for renderer in [&mut fast, &mut plain] {
            let mut truth = TruthPicture::new(case.width, case.height, case.format);
            let drawn = draw(&case, renderer, Some(&mut truth));
            let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
            if !report.is_right() {
                println!("seed {seed} {:?} {:?}: {report}", case.settings, case.format);
                wrong.push(seed);
            }
        }
        let first = draw(&case, &mut fast, None);
        let picked = seed as usize % others.len();
        let (level, threads, renderer) = &mut others[picked];
        let other = draw(&case, renderer, None);
        assert!(other.words() == first.words(), "seed {seed}, {level:?} on {threads} threads");
        tiles += usize::from(plan_of(&case.scene).uses(Part::TileRenderer));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(tiles > 20, "only {tiles} scenes by the tile renderer");
}

/// Returns the plan of a scene on a small frame.
fn plan_of(scene: &Scene) -> fbptr::pipeline::Plan {
    let (mut memory, mut depth) = (VideoMemory::new(64, 64).unwrap(), None);
    let depth_format = Default::default();
    let target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    plan_scene(&target, scene, &SceneOptions::new(64, 64))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for some in bytes.chunks(3) {
        let word = some.iter().fold(0u32, |word, b| word << 8 | u32::from(*b)) << (8 * (3 - some.len()));
        let digits = (0..4).map(|k| DIGITS[(word >> (18 - 6 * k) & 63) as usize] as char);
        text.extend(digits.take(some.len() + 1));
        text.extend(std::iter::repeat_n('=', 3 - some.len()));
    }
    text
}

/// Returns a file's image of these texels.
fn image([width, height]: [usize; 2], texels: &[[u8; 3]]) -> String {
    let mut bytes = format!("P6 {width} {height} 255\n").into_bytes();
    bytes.extend((0..width * height).flat_map(|i| texels[i % texels.len()]));
    format!(r#"{{"uri":"data:;base64,{}"}}"#, base64(&bytes))
}

/// Picture coordinates of the quad's corners.
type Uv = [[f32; 2]; 4];

/// The whole picture, upright.
const UPRIGHT: Uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
/// The picture's mirror image.
const MIRRORED: Uv = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]];
/// One point of the picture.
const POINT: Uv = [[0.5, 0.5]; 4];

/// Returns a file of the quad from (-1, -1, 0) to (1, 1, 0), facing +z: its material, the images of its
/// textures 0, 1 .. (sampler 0: no filter), and its coordinates, if it has any.
fn file(material: &str, images: &[String], uv: Option<Uv>) -> String {
    let floats = |list: &[f32]| list.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = floats(&[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]);
    bytes.extend(floats(uv.unwrap_or_default().as_flattened()));
    bytes.extend([0, 1, 2, 0, 2, 3]);
    let texcoord = if uv.is_some() { r#","TEXCOORD_0":1"# } else { "" };
    let textures: Vec<String> =
        (0..images.len()).map(|i| format!(r#"{{"source":{i},"sampler":0}}"#)).collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "buffers":[{{"byteLength":{},"uri":"data:;base64,{}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
            {{"buffer":0,"byteOffset":80,"byteLength":6}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
            {{"bufferView":2,"componentType":5121,"count":6,"type":"SCALAR"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{texcoord}}},"indices":2,"material":0}}]}}],
        "materials":[{{{material}}}],"samplers":[{{"magFilter":9728,"minFilter":9728}}],
        "textures":[{}],"images":[{}]}}"#,
        bytes.len(),
        base64(&bytes),
        textures.join(","),
        images.join(",")
    )
}

fn document(text: &str) -> GltfDocument {
    gltf::parse(text.as_bytes(), "quad.gltf", &mut |_| None).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Returns a file's scene, seen straight on, lit by one light that travels in `direction`.
fn scene_of(text: &str, direction: DVec3) -> Scene {
    let document = document(text);
    assert!(document.warnings().is_empty(), "{:?}", document.warnings());
    seen(document.at(0.0, 1.0), direction)
}

fn seen(mut scene: Scene, direction: DVec3) -> Scene {
    let look_at = LookAt { eye: DVec3::Z * 5.0, reference: DVec3::ZERO, up: DVec3::Y };
    let projection = Projection::Ortho { window: [-1.0, 1.0, -1.0, 1.0], near: 1.0, far: 9.0 };
    scene.camera = Some(Camera { look_at, projection });
    scene.lights = vec![Light::directional(direction, DVec3::ONE)];
    scene
}

/// Returns the picture of a scene of 60 x 60 pixels, by the tile renderer, after comparing it with the
/// truth.
fn picture(scene: &Scene) -> Vec<[u8; 4]> {
    let case = Case {
        name: "quad".into(),
        scene: scene.clone(),
        settings: Settings {
            transparency: fbptr::truth::Transparency::AfterOpaque(Default::default()),
            ..Settings::default()
        },
        format: Default::default(),
        width: 60,
        height: 60,
    };
    let mut truth = TruthPicture::new(case.width, case.height, case.format);
    let drawn = draw(&case, &mut Renderer::default(), Some(&mut truth));
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    assert!(report.is_right(), "{report}");
    drawn.memory.bytes().as_chunks::<4>().0.to_vec()
}

/// A plastic without gloss.
const PLAIN: &str = r#""pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.2,0.2,0.2,1]}"#;

/// Returns the pixel in a column and row of a picture.
fn at(picture: &[[u8; 4]], x: usize, y: usize) -> [u8; 4] {
    picture[60 * y + x]
}

#[test]
fn emission_is_added_where_its_texels_are_bright() {
    let glow = format!(r#"{PLAIN},"emissiveFactor":[1,0.5,0],"emissiveTexture":{{"index":0}}"#);
    let texels = [[0, 0, 0], [255, 255, 255], [128, 128, 128], [255, 0, 0]];
    let light = DVec3::new(0.3, 0.0, -1.0);
    let dark = picture(&scene_of(&file(PLAIN, &[], Some(UPRIGHT)), light));
    let scene = scene_of(&file(&glow, &[image([2, 2], &texels)], Some(UPRIGHT)), light);
    let glowing = picture(&scene);
    let ke = [1.0, encoded(0.5), 0.0];
    // The first row of the picture is at the top.
    for (x, y, texel) in [(5, 5, texels[0]), (50, 5, texels[1]), (5, 50, texels[2]), (50, 50, texels[3])] {
        let (from, to) = (at(&dark, x, y), at(&glowing, x, y));
        for c in 0..3 {
            let expected = (f64::from(from[c]) + ke[c] * f64::from(texel[c])).min(255.0);
            assert!((f64::from(to[c]) - expected).abs() <= 1.0, "{x} {y}: {from:?} {to:?} {texel:?}");
        }
    }
    let text = plan_of(&scene).to_string();
    assert!(text.contains("+ surface maps       emission, pixel by pixel in f64; 2 faces"), "{text}");
    assert!(plan_of(&scene).uses(Part::TileRenderer) && !plan_of(&scene).uses(Part::SampleTextures));
}

#[test]
fn strong_emission_is_bounded_and_that_of_one_colour_needs_no_map() {
    let strong = r#""emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},
        "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":1e300}}"#;
    let scene = scene_of(&file(strong, &[image([2, 1], &[[0; 3], [9; 3]])], Some(UPRIGHT)), -DVec3::Z);
    let object = &scene.objects[0];
    assert_eq!(object.material.emissive, DVec3::splat(encoded(1e6)));
    assert!(object.style.maps.is_some());
    // Half of a metal's white, under a light of 1 + 0.15.
    assert_eq!((at(&picture(&scene), 50, 5), at(&picture(&scene), 5, 5)[0]), ([255; 4], 147));
    let even = scene_of(&file(strong, &[image([3, 3], &[[255, 51, 0]])], Some(UPRIGHT)), -DVec3::Z);
    assert_eq!(even.objects[0].material.emissive, DVec3::new(1.0, 0.2, 0.0) * encoded(1e6));
    assert!(even.objects[0].style.maps.is_none() && !plan_of(&even).uses(Part::SurfaceMaps));
}

/// Returns a material with a normal texture.
fn bumpy(more: &str) -> String {
    format!(r#"{PLAIN},"normalTexture":{{"index":0{more}}}"#)
}

#[test]
fn a_flat_normal_map_changes_nothing() {
    let light = DVec3::new(0.4, 0.2, -1.0);
    let without = picture(&scene_of(&file(PLAIN, &[], Some(UPRIGHT)), light));
    let with =
        picture(&scene_of(&file(&bumpy(""), &[image([5, 3], &[[128, 128, 255]])], Some(UPRIGHT)), light));
    for (a, b) in without.iter().zip(&with) {
        assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1), "{a:?} {b:?}");
    }
}

#[test]
fn a_tilted_map_tilts_to_the_right_and_up_of_its_picture() {
    // R = 1, B = 0.5: along the tangent. G likewise.
    let right = |uv| file(&bumpy(""), &[image([1, 1], &[[255, 128, 128]])], Some(uv));
    let up = |uv| file(&bumpy(""), &[image([1, 1], &[[128, 255, 128]])], Some(uv));
    let bright = |text: &str, direction: DVec3| at(&picture(&scene_of(text, direction)), 30, 30)[0];
    let (from_right, from_left) = (DVec3::new(-1.0, 0.0, -0.5), DVec3::new(1.0, 0.0, -0.5));
    let (from_above, from_below) = (DVec3::new(0.0, -1.0, -0.5), DVec3::new(0.0, 1.0, -0.5));
    assert!(bright(&right(UPRIGHT), from_right) > 100 && bright(&right(UPRIGHT), from_left) < 20);
    assert!(bright(&up(UPRIGHT), from_above) > 100 && bright(&up(UPRIGHT), from_below) < 20);
    // In the mirror image right is left, and above stays above.
    assert!(bright(&right(MIRRORED), from_left) > 100 && bright(&right(MIRRORED), from_right) < 20);
    assert!(bright(&up(MIRRORED), from_above) > 100 && bright(&up(MIRRORED), from_below) < 20);
    // Without area on the picture nothing is tilted.
    let straight = picture(&scene_of(&file(PLAIN, &[], Some(POINT)), from_right));
    assert_eq!(picture(&scene_of(&right(POINT), from_right)), straight);
    // A scale of 0 leaves the normal, one of -1 turns it round.
    let scaled = |scale: &str, direction| {
        let material = bumpy(&format!(",\"scale\":{scale}"));
        let text = file(&material, &[image([1, 1], &[[255, 128, 128]])], Some(UPRIGHT));
        bright(&text, direction)
    };
    assert!(scaled("0", from_right).abs_diff(scaled("0", from_left)) <= 1);
    assert!(scaled("-1", from_left) > 100 && scaled("-1", from_right) < 20);
}

#[test]
fn a_model_that_mirrors_and_a_back_side_keep_the_tilt() {
    let text = file(&bumpy(""), &[image([1, 1], &[[255, 128, 128]])], Some(UPRIGHT));
    let (from_right, from_left) = (DVec3::new(-1.0, 0.0, -0.5), DVec3::new(1.0, 0.0, -0.5));
    let mut mirrored = scene_of(&text, from_left);
    mirrored.objects[0].model = glam::DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    assert!(at(&picture(&mirrored), 30, 30)[0] > 100);
    // Turned about y the back is seen, whose right is the front's left.
    let double = text.replace("\"normalTexture\"", "\"doubleSided\":true,\"normalTexture\"");
    let back = |direction| {
        let mut scene = scene_of(&double, direction);
        scene.objects[0].model = glam::DMat4::from_rotation_y(std::f64::consts::PI);
        at(&picture(&scene), 30, 30)[0]
    };
    // The bump's outside is dented seen from behind: it tilts the other way.
    assert!(back(from_right) > 100 && back(from_left) < 20, "{} {}", back(from_right), back(from_left));
}

#[test]
fn occlusion_dims_the_ambient_light_alone() {
    let text = |more: &str| {
        let material = format!(r#"{PLAIN},"occlusionTexture":{{"index":0{more}}}"#);
        file(&material, &[image([2, 1], &[[0; 3], [255, 0, 0]])], Some(UPRIGHT))
    };
    let ambient_of = |text: &str| {
        let mut scene = scene_of(text, DVec3::Z);
        scene.ambient = DVec3::ONE;
        let picture = picture(&scene);
        [at(&picture, 5, 30)[0], at(&picture, 50, 30)[0]]
    };
    let full = ambient_of(&file(PLAIN, &[], Some(UPRIGHT)))[0];
    assert_eq!(ambient_of(&text("")), [0, full]);
    let half = ambient_of(&text(",\"strength\":0.5"));
    let expected = f64::from(full) * encoded(0.5);
    assert!(half[1] == full && (f64::from(half[0]) - expected).abs() <= 1.0, "{half:?}, {expected}");
    // Directed light is not dimmed.
    let mut lit = scene_of(&text(""), -DVec3::Z);
    lit.ambient = DVec3::ZERO;
    let lit = picture(&lit);
    assert_eq!(at(&lit, 5, 30), at(&lit, 50, 30));
}

#[test]
fn maps_without_coordinates_are_left_out_with_a_warning() {
    let material = format!(r#"{},"emissiveFactor":[1,1,1],"emissiveTexture":{{"index":0}}"#, bumpy(""));
    let text = file(&material, &[image([2, 1], &[[0; 3], [255; 3]])], None);
    let document = document(&text);
    let warnings: Vec<String> = document.warnings().iter().map(|w| w.to_string()).collect();
    let left_out = "without TEXCOORD_0, a texture is left out";
    assert_eq!(warnings, [format!("quad.gltf#/meshes/0/primitives/0/attributes: warning: {left_out}")]);
    let plain = scene_of(&file(PLAIN, &[], None), -DVec3::Z);
    assert_eq!(picture(&seen(document.at(0.0, 1.0), -DVec3::Z)), picture(&plain));
}

#[test]
fn an_unlit_material_has_no_maps() {
    let material = format!(r#"{},"extensions":{{"KHR_materials_unlit":{{}}}}"#, bumpy(""));
    let scene = scene_of(&file(&material, &[image([1, 1], &[[255, 128, 128]])], Some(UPRIGHT)), -DVec3::Z);
    assert!(scene.objects[0].style.maps.is_none() && !plan_of(&scene).uses(Part::SurfaceMaps));
}

#[test]
fn transparent_faces_with_maps_are_blended_by_the_plain_path() {
    let material = r#""alphaMode":"BLEND","pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[1,1,1,0.5]},
        "normalTexture":{"index":0}"#;
    let scene =
        scene_of(&file(material, &[image([2, 2], &[[255, 128, 128], [128; 3]])], Some(UPRIGHT)), -DVec3::Z);
    picture(&scene);
    let plan = plan_of(&scene);
    assert!(!plan.uses(Part::TileRenderer) && !plan.uses(Part::FacesInOrder));
    assert_eq!(
        plan.item(Part::FacesInOrder).reason,
        "maps of emission, normals or occlusion: the plain path"
    );
}
