//! glTF, STL and PLY files on the command line, and what is refused or explained there.

use crate::folder::Folder;
use crate::play::{err, run};
use std::io::Write;

#[test]
fn scenes_are_known_by_their_content_whatever_their_name() {
    let folder = Folder::new("content");
    let out = folder.path("o.raw");
    let facet: Vec<u8> =
        [-1_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let stl = [&[0; 80][..], &1_u32.to_le_bytes(), &[0; 12], &facet, &[0; 2]].concat();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        -1 -1 0\n1 -1 0\n0 1 0\n3 0 1 2\n";
    for (name, bytes) in [
        ("scene.xml", &b"<X3D><Scene><Shape><Box/></Shape></Scene></X3D>"[..]),
        ("facet.obj", &stl),
        ("model.json", include_bytes!("../data/formats/gltf/box.glb")),
        ("scene.txt", include_bytes!("../data/formats/gltf/vertex_colors.gltf")),
        ("triangle", ply.as_bytes()),
        ("mesh", b"# three points\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"),
    ] {
        let scene = folder.file(name, bytes);
        for arguments in [
            &["render", &scene, "-o", &out, "--size", "9x9"][..],
            &["view", &scene, "--headless", "--snap", &out, "--size", "9x9"],
        ] {
            let output = run(arguments, b"");
            assert_eq!((output.status.code(), err(&output)), (Some(0), ""));
            assert!(std::fs::read(&out).unwrap()[(9 * 4 + 4) * 4] > 50, "{arguments:?}");
        }
        let played = run(&["play", &scene, "--headless"], b"");
        assert_eq!(played.status.code(), Some(2));
        assert!(err(&played).contains("`fbptr view`"), "{}", err(&played));
    }
}

#[test]
fn a_gltf_animation_is_a_movie_of_its_own_and_a_still_one_a_turn() {
    let folder = Folder::new("gltf-movie");
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/formats/gltf/");
    let out = folder.path("o.y4m");
    for (name, said) in [("animation.glb", ""), ("box.glb", "are one turn")] {
        let scene = format!("{data}{name}");
        let output =
            run(&["render", &scene, "-o", &out, "--size", "16x12", "--frames", "5", "--fps", "2"], b"");
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        assert!(err(&output).contains(said), "{}", err(&output));
        let movie = std::fs::read(&out).unwrap();
        let frames: Vec<&[u8]> =
            movie[movie.len() - 5 * (6 + 16 * 12 * 3)..].chunks(6 + 16 * 12 * 3).collect();
        assert!(frames.iter().all(|f| f.starts_with(b"FRAME\n")), "{name}");
        assert!(frames[0] != frames[1] && frames[1] != frames[2], "{name} moves");
        // Two seconds are the animation's length: it begins again.
        assert_eq!(frames[0] == frames[4], name == "animation.glb");
        let viewed = run(&["view", &scene, "--headless", "--frames", "2", "--size", "16x12"], b"");
        assert_eq!(viewed.status.code(), Some(0), "{}", err(&viewed));
    }
}

#[test]
fn scenes_are_read_within_the_memory_that_is_allowed() {
    let folder = Folder::new("memory");
    let text = format!("<X3D><Scene><Shape><Box/></Shape>{}</Scene></X3D>", " ".repeat(40 << 20));
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(text.as_bytes()).unwrap();
    let packed = folder.file("spaces.x3dz", encoder.finish().unwrap());
    let plain = folder.file("spaces.x3d", text);
    let picture = folder.path("o.raw");
    for file in [&packed, &plain] {
        for arguments in [&["render", file, "-o", &picture][..], &["view", file, "--headless"]] {
            let with = |memory: &str| run(&[arguments, &["--max-memory", memory]].concat(), b"");
            let refused = with("30M");
            let said = err(&refused);
            assert_eq!(refused.status.code(), Some(1), "{arguments:?}: {said}");
            assert!(said.starts_with("fbptr: ") && said.contains("of memory for"), "{said}");
            let drawn = with("1G");
            assert_eq!((drawn.status.code(), err(&drawn)), (Some(0), ""), "{arguments:?}");
        }
    }
}

#[test]
fn frames_of_an_n_dimensional_scene_that_does_not_turn_are_said_to_be_the_same() {
    let folder = Folder::new("still");
    let tesseract = folder.file("t.json", run(&["eye", "--make", "tesseract"], b"").stdout);
    let frames = folder.path("f.raw");
    let still = run(&["render", &tesseract, "-o", &frames, "--size", "16x12", "--frames", "2"], b"");
    let said = err(&still);
    assert_eq!(still.status.code(), Some(0), "{said}");
    assert!(said.starts_with("fbptr: the 2 frames are the same: --turn A,B,DEGREES turns"), "{said}");
    let turned =
        ["render", &tesseract, "-o", &frames, "--size", "16x12", "--frames", "2", "--turn", "0,1,90"];
    assert_eq!(err(&run(&turned, b"")), "");
}

#[test]
fn a_stream_that_states_its_size_is_viewed_as_it_is_played() {
    let folder = Folder::new("viewed");
    let [played, viewed, smaller] = ["p.png", "v.png", "s.raw"].map(|name| folder.path(name));
    // Each connection of a recording has settings of its own.
    let recording = "#!fbptr-record 2 40x30\n#@ 1 0.1 000000000029\nCLIP 0 0 9 9\nPX 20 20 ffffff\n\n\
        #@ 2 0.2 000000000016\nPX 39 29 ff0000\n\n#@ 1 0.3 end\n#@ 2 0.3 end\n#!end 0.4\n";
    for stream in ["# a remark\nSIZE 40 30\nPX 39 29 ff0000\n", recording] {
        let file = folder.file("s.fbs", stream);
        for arguments in [
            &["play", &file, "--headless", "--snap", &played][..],
            &["view", &file, "--headless", "--snap", &viewed],
            &["view", &file, "--headless", "--snap", &smaller, "--size", "8x6"],
        ] {
            let output = run(arguments, b"");
            assert_eq!((output.status.code(), err(&output)), (Some(0), ""), "{arguments:?}");
        }
        let picture = image::open(&viewed).unwrap().into_rgba8();
        assert_eq!((picture.dimensions(), picture[(39, 29)].0), ((40, 30), [255, 0, 0, 255]));
        assert!(std::fs::read(&played).unwrap() == std::fs::read(&viewed).unwrap());
        assert_eq!(std::fs::metadata(&smaller).unwrap().len(), 8 * 6 * 4);
    }
    let drawn = run(&["render", &folder.path("s.fbs"), "-o", &played], b"");
    assert_eq!(drawn.status.code(), Some(2));
    assert!(err(&drawn).contains("s.fbs --headless --snap picture.png` plays a stream"), "{}", err(&drawn));
    let refused = run(&["view", &folder.file("big.fbs", "SIZE 0 3\n"), "--headless"], b"");
    assert_eq!(refused.status.code(), Some(2), "{}", err(&refused));
}

#[test]
fn a_picture_without_anything_on_it_is_explained() {
    let folder = Folder::new("explained");
    let out = folder.path("o.raw");
    let far = folder.file(
        "far.x3d",
        "<X3D><Scene><Viewpoint position='0 0 3000'/><Shape><Box size='9 9 9'/></Shape></Scene></X3D>",
    );
    let drawn = run(&["render", &far, "-o", &out, "--size", "8x8"], b"");
    assert_eq!(drawn.status.code(), Some(0));
    assert!(err(&drawn).starts_with(&format!("fbptr: {far}: frame 0: ")), "{}", err(&drawn));
    assert!(err(&drawn).contains("the far plane is at 1000: see --far"), "{}", err(&drawn));
    let seen = run(&["render", &far, "-o", &out, "--size", "800x800", "--far", "9000"], b"");
    assert_eq!((seen.status.code(), err(&seen)), (Some(0), ""));
    let scene =
        |content: &str| format!("<X3D><Scene><NavigationInfo headlight='false'/>{content}</Scene></X3D>");
    let shape =
        |material: &str| format!("<Shape><Appearance><Material {material}/></Appearance><Box/></Shape>");
    let [red, clear] = ["diffuseColor='1 0 0'", "transparency='1'"].map(shape);
    let (behind, front) = ("<DirectionalLight direction='0 0 1'/>", "<DirectionalLight/>");
    let on_blue = "<Background skyColor='0 0 1'/>";
    let dark = "all of it is black: no light reaches it, and it emits none";
    let unlit = shape("emissiveColor='0 0 0' diffuseColor='0 0 0'");
    for (content, said) in [
        (format!("{front}{clear}"), "all of it is fully transparent"),
        (format!("{front}{clear}{red}"), ""),
        (format!("{behind}{red}"), dark),
        (format!("{behind}{red}{on_blue}"), dark),
        (format!("{front}{red}"), ""),
        (format!("{front}{red}{on_blue}"), ""),
        // A black material is black in any light.
        (format!("{front}{unlit}"), ""),
    ] {
        let file = folder.file("s.x3d", scene(&content));
        for background in ["black", "white"] {
            let arguments = ["render", &file, "-o", &out, "--size", "16x16", "--background", background];
            let drawn = run(&arguments, b"");
            let said =
                if said.is_empty() { String::new() } else { format!("fbptr: {file}: frame 0: {said}\n") };
            assert_eq!((drawn.status.code(), err(&drawn)), (Some(0), &*said), "{content} on {background}");
        }
    }
    // A mesh of which the unlit side is seen, and one without content: one message each.
    let behind = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes/assimp/concave_polygon.obj");
    let empty = folder.file("e.obj", "o nothing\n");
    let nothing = "warning: no faces, lines or points: nothing is drawn";
    for (file, said) in [(behind, format!("frame 0: {dark}")), (&*empty, nothing.to_owned())] {
        let drawn = run(&["render", file, "-o", &out, "--size", "16x16"], b"");
        assert_eq!((drawn.status.code(), err(&drawn)), (Some(0), &*format!("fbptr: {file}: {said}\n")));
    }
}

#[test]
fn options_and_outputs_that_cannot_serve_are_refused_at_once() {
    let folder = Folder::new("at-once");
    let stream = folder.file("s.fbs", "CLEAR red\n");
    let mesh = folder.file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let missing = folder.path("none/o");
    let [gif, html] = [".gif", ".html"].map(|ending| format!("{missing}{ending}"));
    for (arguments, said) in [
        (&["view", &stream, "--headless", "--cull", "back"][..], "--cull does nothing here"),
        (&["view", &stream, "--headless", "--turntable"], "--turntable does nothing here"),
        (&["view", &mesh, "--headless", "--load-dir", "."], "--load-dir does nothing here"),
        (&["view", &stream, "--headless", "--frames", "-1"], "invalid value '-1' for '--frames"),
        (&["play", &stream, "--headless", "--movie", &gif], "there is no folder"),
        (&["serve", "--headless", "--listen", ":0", "--movie", &gif], "there is no folder"),
        (&["eye", "--bench", "--out", &html], "there is no folder"),
        (&["eye", "--bench", "--out", "o.txt"], "expected .html or .svg"),
    ] {
        let refused = run(arguments, b"");
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {}", err(&refused));
        assert!(err(&refused).starts_with("fbptr: ") && err(&refused).contains(said), "{}", err(&refused));
    }
}

#[test]
fn strict_refuses_what_is_warned_of() {
    let folder = Folder::new("strict");
    let out = folder.path("o.raw");
    let whole = folder.file("whole.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let odd = folder.file("odd.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\nf 1 2\nf 1 2 9\n");
    let scene = folder.file("odd.x3d", "<X3D><Scene><Shape><Box size='1 1 1 1'/></Shape></Scene></X3D>");
    // A map of normals without texture coordinates.
    let bare = folder.file(
        "bare.gltf",
        r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "buffers":[{"byteLength":36,"uri":"data:;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "materials":[{"normalTexture":{"index":0}}],"textures":[{"source":0}],
        "images":[{"uri":"data:;base64,UDYgMSAxIDI1NQr/gIA="}]}"#,
    );
    for (command, more) in [("render", &["-o", &out][..]), ("view", &["--headless", "--snap", &out])] {
        for (file, strict, status) in [
            (&whole, true, 0),
            (&odd, false, 0),
            (&odd, true, 1),
            (&scene, false, 0),
            (&scene, true, 1),
            (&bare, false, 0),
            (&bare, true, 1),
        ] {
            let _ = std::fs::remove_file(&out);
            let flags: &[&str] = if strict { &["--strict"] } else { &[] };
            let arguments = [&[command, file.as_str(), "--size", "9x9"], more, flags].concat();
            let output = run(&arguments, b"");
            assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", err(&output));
            assert_eq!(std::path::Path::new(&out).exists(), status == 0, "{arguments:?}");
            let said = if status == 0 { "warning: " } else { "refused by --strict: " };
            assert_eq!(err(&output).contains(said), *file != whole, "{arguments:?}: {}", err(&output));
        }
    }
}

#[test]
fn a_texture_of_another_letter_case_is_found_with_a_warning() {
    let folder = Folder::new("letter-case");
    folder.file("WOOD.ppm", b"P6 1 1 255\n\xff\x01\x01");
    folder.file("m.MTL", "newmtl m\nmap_Kd C:\\work\\Wood.PPM\n");
    let text = "mtllib M.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let (scene, out) = (folder.file("m.obj", text), folder.path("o.raw"));
    let output = run(&["render", &scene, "-o", &out, "--size", "9x9"], b"");
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    for said in ["there is no \"M.mtl\": \"m.MTL\" is read", "\"WOOD.ppm\" is read", "of another machine"] {
        assert!(err(&output).contains(said), "{}", err(&output));
    }
    let middle = std::fs::read(&out).unwrap()[(9 * 4 + 4) * 4..][..4].to_vec();
    assert!(middle[0] < 20 || middle[2] < 20, "one channel alone: {middle:?}");
    let output = run(&["render", &scene, "-o", &out, "--size", "9x9", "--strict"], b"");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn points_have_the_size_that_is_asked_for() {
    let folder = Folder::new("point-size");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n-1 -1 0\n1 -1 0\n0 1 0\n";
    let (scene, out) = (folder.file("cloud.ply", ply), folder.path("o.raw"));
    let covered = |size: &str| {
        let output = run(&["render", &scene, "-o", &out, "--size", "64x64", "--point-size", size], b"");
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let pixels = std::fs::read(&out).unwrap();
        let background = pixels[..4].to_vec();
        pixels.chunks(4).filter(|p| **p != background[..]).count()
    };
    assert_eq!((covered("1"), covered("5")), (3, 75));
    let refused = run(&["render", &scene, "-o", &out, "--point-size", "65"], b"");
    assert_eq!(refused.status.code(), Some(2), "{}", err(&refused));
}

#[test]
fn the_classic_encoding_is_a_scene_and_a_course_s_reading_is_asked_for() {
    let folder = Folder::new("classic");
    let (out, other) = (folder.path("o.raw"), folder.path("other.raw"));
    let head = "#VRML V2.0 utf8\n";
    let line = "Shape { geometry Polyline2D { lineSegments [ 0.5 0.5 8.5 0.5 ] } appearance Appearance { material Material { emissiveColor 1 1 1 } } }";
    let flat = folder.file("flat.txt", format!("{head}{line}"));
    let solid = folder.file(
        "solid.wrl",
        format!("{head}Shape {{ appearance Appearance {{ material Material {{ }} }} geometry Box {{ }} }}"),
    );
    let old = folder.file("old.wrl", "#VRML V1.0 ascii\nCube { }\n");
    let draw = |arguments: &[&str], out: &str| {
        let output = run(&[arguments, &["-o", out, "--size", "9x9"]].concat(), b"");
        assert_eq!((output.status.code(), err(&output)), (Some(0), ""), "{arguments:?}");
        std::fs::read(out).unwrap()
    };
    let pixel = |picture: &[u8], x: usize, y: usize| picture[(y * 9 + x) * 4];
    let course = draw(&["render", &flat, "--dialect", "renderizador"], &out);
    assert!((0..8).all(|x| pixel(&course, x, 0) == 255 && pixel(&course, x, 4) == 0));
    assert_ne!(course, draw(&["render", &flat], &out));
    let shown = run(
        &["view", &flat, "--headless", "--snap", &other, "--size", "9x9", "--dialect", "renderizador"],
        b"",
    );
    assert_eq!((shown.status.code(), err(&shown)), (Some(0), ""));
    assert_eq!(std::fs::read(&other).unwrap(), course);
    let plain = draw(&["render", &solid], &out);
    assert!(pixel(&plain, 4, 4) > 50);
    assert_ne!(plain, draw(&["render", &solid, "--camera", "diagonal"], &out));
    assert_eq!(
        plain,
        draw(&["render", &solid, "--dialect", "renderizador"], &out),
        "it has three dimensions"
    );
    let mesh = folder.file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (arguments, expected) in [
        (&["render", &old, "-o", &out][..], "old.wrl: a VRML 1.0 scene; expected a scene"),
        (&["render", &mesh, "-o", &out, "--camera", "diagonal"], "--dialect and --camera are for X3D"),
        (&["render", &solid, "-o", &out, "--camera", "wide"], "expected diagonal"),
    ] {
        let output = run(arguments, b"");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(err(&output).contains(expected), "{}", err(&output));
    }
}
