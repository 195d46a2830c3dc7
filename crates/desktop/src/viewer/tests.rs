use super::*;
use fbptr_core::executor::Executor;
use fbptr_core::eye::shapes::{DemoScene, cube};
use fbptr_core::memory::Rgba;
use fbptr_core::pipeline;
use fbptr_core::scene::{Scene, shapes};
use fbptr_formats::load;
use fbptr_server::Engine;
use glam::DVec3;

const SIZE: [u32; 2] = [96, 72];

fn options(name: &str) -> ViewerOptions {
    ViewerOptions {
        name: name.to_owned(),
        size: SIZE,
        time: 0.0,
        fps: 25.0,
        cull: None,
        point_size: None,
        studio: false,
        turntable: false,
        split: None,
        renderer: Renderer::default(),
        pool: Executor::default(),
    }
}

fn teapot() -> Arc<Geometry> {
    Arc::new(Geometry { mesh: shapes::teapot(4).expect("a level"), textures: Vec::new() })
}

fn closed(geometry: Arc<Geometry>) -> Model {
    Model::Mesh { geometry, is_open: false }
}

fn mesh_viewer() -> Viewer {
    Viewer::new(closed(teapot()), options("teapot")).expect("a viewer")
}

const SPINNING: &str = r#"<?xml version="1.0"?><X3D version="3.3" profile="Interchange"><Scene>
<Viewpoint position="0 0 6"/>
<TimeSensor DEF="T" cycleInterval="4" loop="true"/>
<OrientationInterpolator DEF="O" key="0 0.5 1" keyValue="0 1 0 0 0 1 0 3.14 0 1 0 6.28"/>
<Transform DEF="X"><Shape><Appearance><Material diffuseColor="1 0.5 0.2"/></Appearance><Box size="2 1 3"/></Shape></Transform>
<ROUTE fromNode="T" fromField="fraction_changed" toNode="O" toField="set_fraction"/>
<ROUTE fromNode="O" fromField="value_changed" toNode="X" toField="set_rotation"/></Scene></X3D>"#;

fn x3d_viewer() -> Viewer {
    let document = load::x3d::parse(SPINNING.as_bytes(), "spin.x3d", &mut |_| None).expect("a document");
    Viewer::new(Model::X3d(Box::new(document)), options("spin")).expect("a viewer")
}

fn nd_viewer() -> Viewer {
    let turns = vec![(0, 1, 20.0), (1, 3, 30.0), (0, 2, 15.0)];
    let demo = DemoScene { pixels: vec![48, 36], aperture_tan: 0.3, turns };
    let scene = demo.scene(cube(4).expect("a cube")).expect("a scene");
    Viewer::new(Model::Eye(Box::new(scene)), options("tesseract")).expect("a viewer")
}

const STREAM: &str = "CLEAR 203040\nMESH m TEAPOT 4\nLOOKAT 0 2 8 0 1 0 0 1 0\nLIGHT 0 DIR -1 -1 -1 1 1 1\n\
    DRAW m\nPRESENT\nROTATE 0 1 0 1\nCLEAR\nDRAW m\nPRESENT\nNONSENSE\nFILLRECT 3 3 9 9 ff0000\n";

fn stream_viewer(text: &str) -> Viewer {
    let make_engine: MakeEngine = Arc::new(|| Engine::new(SIZE[0], SIZE[1]).map_err(|e| e.message));
    let bytes: Arc<[u8]> = text.as_bytes().into();
    Viewer::new(Model::Stream(bytes, make_engine), options("stream")).expect("a viewer")
}

fn viewers() -> Vec<Viewer> {
    vec![mesh_viewer(), x3d_viewer(), nd_viewer(), stream_viewer(STREAM)]
}

fn picture(viewer: &mut Viewer) -> Vec<u8> {
    viewer.refresh();
    assert_eq!(viewer.failure(), None);
    viewer.shown().bytes().to_vec()
}

fn tap(viewer: &mut Viewer, key: Key) -> Option<Request> {
    let request = viewer.key(key, true);
    viewer.key(key, false);
    request
}

fn lit(bytes: &[u8]) -> usize {
    bytes.as_chunks::<4>().0.iter().filter(|p: &&Rgba| p[..3] != [0; 3]).count()
}

#[test]
fn what_is_shown_at_the_start_is_what_rendering_the_file_gives() {
    let scene = Scene::of_mesh(teapot(), "teapot", 96.0 / 72.0, false);
    let (mut memory, mut depth) = (VideoMemory::new(SIZE[0], SIZE[1]).expect("small"), None);
    let mut target = pipeline::Target {
        memory: &mut memory,
        depth: &mut depth,
        depth_format: Default::default(),
        ids: None,
    };
    let options = pipeline::SceneOptions::new(SIZE[0], SIZE[1]);
    pipeline::draw_scene(&mut target, &scene, &options).expect("drawn");
    let mut viewer = mesh_viewer();
    assert!(picture(&mut viewer) == memory.bytes());
    assert!(!viewer.refresh(), "nothing changed: nothing is drawn");
    // Wherever the camera went, R resets it.
    for key in [Key::A, Key::Left, Key::Equal, Key::PageUp, Key::Up, Key::W] {
        let before = picture(&mut viewer);
        tap(&mut viewer, key);
        assert_ne!(picture(&mut viewer), before, "{key:?}");
    }
    tap(&mut viewer, Key::R);
    assert!(picture(&mut viewer) == memory.bytes());
}

#[test]
fn every_key_changes_picture_overlay_or_asks_for_something() {
    for mut viewer in viewers() {
        viewer.pointer(Some([48.0, 36.0]), 0);
        for binding in BINDINGS {
            let name = viewer.name.clone();
            let before = (picture(&mut viewer), viewer.overlay());
            let request = tap(&mut viewer, binding.key);
            let after = (picture(&mut viewer), viewer.overlay());
            // 0 after 5 changes only the overlay's text if the scene has no texture; R has an
            // effect only after a movement.
            let is_changed = before != after || request.is_some() || matches!(binding.action, Action::Reset);
            assert!(is_changed, "{name}: {} does nothing", binding.name);
            viewer.message = None;
            if matches!(binding.action, Action::Help | Action::Status | Action::Depth | Action::Difference) {
                // These would cover what other keys change.
                tap(&mut viewer, binding.key);
            }
        }
    }
}

#[test]
fn each_look_of_a_mesh_is_a_picture_of_its_own_and_stays_in_the_frame() {
    for mut viewer in [mesh_viewer(), nd_viewer(), stream_viewer(STREAM)] {
        let mut seen: Vec<(Key, Vec<u8>)> = Vec::new();
        for key in [Key::One, Key::Two, Key::Three, Key::Four] {
            tap(&mut viewer, key);
            let now = picture(&mut viewer);
            assert!(lit(&now) > 300, "{} {key:?} shows next to nothing", viewer.name);
            for (other, bytes) in &seen {
                assert!(*bytes != now, "{}: {other:?} and {key:?} look the same", viewer.name);
            }
            seen.push((key, now));
        }
    }
}

#[test]
fn projections_culling_and_hiding_go_round() {
    for mut viewer in [mesh_viewer(), x3d_viewer(), stream_viewer(STREAM)] {
        for (key, rounds) in [(Key::P, 3), (Key::C, 4), (Key::H, 4)] {
            if viewer.name == "spin" && key == Key::H {
                // A box that shows only its front has no hidden faces: every method is right.
                continue;
            }
            let first = picture(&mut viewer);
            let mut differ = 0;
            for _ in 0..rounds - 1 {
                tap(&mut viewer, key);
                differ += usize::from(picture(&mut viewer) != first);
            }
            assert!(differ > 0, "{} {key:?}", viewer.name);
            tap(&mut viewer, key);
            assert!(picture(&mut viewer) == first, "{} {key:?} comes back", viewer.name);
        }
    }
}

#[test]
fn depth_is_a_picture_and_the_exact_picture_differs_nowhere() {
    for mut viewer in viewers() {
        let plain = picture(&mut viewer);
        tap(&mut viewer, Key::Z);
        let depth = picture(&mut viewer);
        assert!(lit(&depth) > 300 && depth != plain, "{}", viewer.name);
        assert!(viewer.overlay().bottom.iter().any(|l| l.contains("white")), "{}", viewer.name);
        tap(&mut viewer, Key::E);
        viewer.wait_for_exact();
        let overlay = viewer.overlay();
        assert!(
            overlay.bottom.iter().any(|l| l.starts_with("no pixel differs")),
            "{}: {overlay:?}",
            viewer.name
        );
        assert_eq!(lit(viewer.shown().bytes()), 0);
        tap(&mut viewer, Key::E);
        assert!(picture(&mut viewer) == plain);
        // A style is seen at once, from the depths as well.
        tap(&mut viewer, Key::Z);
        tap(&mut viewer, Key::One);
        assert!(picture(&mut viewer) != depth, "{}", viewer.name);
    }
}

#[test]
fn a_fan_differs_from_exact_fibres_and_that_is_seen() {
    let mut viewer = nd_viewer();
    tap(&mut viewer, Key::H);
    tap(&mut viewer, Key::E);
    viewer.wait_for_exact();
    assert!(lit(viewer.shown().bytes()) > 0);
    assert!(viewer.overlay().bottom.iter().any(|l| l.contains("pixels differ from exact fibres")));
}

#[test]
fn a_view_of_n_dimensions_is_the_picture_that_its_json_gives() {
    let mut viewer = nd_viewer();
    for key in [
        Key::RightBracket,
        Key::Tab,
        Key::RightBracket,
        Key::Equal,
        Key::W,
        Key::Left,
        Key::Tab,
        Key::LeftBracket,
    ] {
        tap(&mut viewer, key);
    }
    viewer.pointer(Some([10.0, 10.0]), 1);
    viewer.pointer(Some([17.0, 31.5]), 1);
    let shown = picture(&mut viewer);
    let Some(Request::Save { ending: "json", bytes }) = tap(&mut viewer, Key::J) else { panic!("a scene") };
    let scene = EyeScene::from_json(&bytes).expect("a scene");
    let again = Viewer::new(Model::Eye(Box::new(scene)), options("again")).expect("a viewer");
    assert!(again.shown().bytes() == shown);
    assert!(viewer.overlay().bottom.iter().any(|l| l.contains("plane ")), "the plane is on the screen");
}

#[test]
fn the_camera_printed_as_commands_gives_the_same_picture_in_a_stream() {
    let mut viewer = stream_viewer(STREAM);
    for key in [Key::Left, Key::Left, Key::Up, Key::D] {
        tap(&mut viewer, key);
    }
    let shown = picture(&mut viewer);
    let Some(Request::Print(text)) = tap(&mut viewer, Key::J) else { panic!("commands") };
    let moved = STREAM.replace("LOOKAT 0 2 8 0 1 0 0 1 0\n", &text);
    assert!(picture(&mut stream_viewer(&moved)) == shown, "{text}");
}

#[test]
fn time_runs_stops_and_goes_back() {
    let mut viewer = x3d_viewer();
    let at_start = picture(&mut viewer);
    viewer.advance(Duration::from_millis(500));
    assert!((viewer.time() - 0.48).abs() < 1e-9, "whole frames: {}", viewer.time());
    assert!(picture(&mut viewer) != at_start);
    tap(&mut viewer, Key::Space);
    viewer.advance(Duration::from_secs(9));
    assert!((viewer.time() - 0.48).abs() < 1e-9);
    for _ in 0..12 {
        tap(&mut viewer, Key::Comma);
    }
    assert!(picture(&mut viewer) == at_start);
    tap(&mut viewer, Key::Period);
    assert!((viewer.time() - 0.04).abs() < 1e-12);
}

#[test]
fn a_scene_that_was_paused_is_paused_again_after_the_turntable() {
    let mut viewer = x3d_viewer();
    for (is_paused, keys) in [(true, &[Key::Space][..]), (false, &[Key::Space])] {
        keys.iter().for_each(|key| drop(tap(&mut viewer, *key)));
        assert_eq!(viewer.is_paused, is_paused);
        tap(&mut viewer, Key::T);
        assert!(viewer.wishes.turns && !viewer.is_paused);
        tap(&mut viewer, Key::T);
        assert!(!viewer.wishes.turns && viewer.is_paused == is_paused);
    }
}

#[test]
fn a_stream_is_seen_frame_by_frame_and_complains_once() {
    let mut viewer = stream_viewer(STREAM);
    let first = picture(&mut viewer);
    tap(&mut viewer, Key::Period);
    let second = picture(&mut viewer);
    assert!(first != second);
    tap(&mut viewer, Key::Period);
    let third = picture(&mut viewer);
    assert!(second != third, "what follows the last PRESENT is seen");
    tap(&mut viewer, Key::Period);
    assert!(picture(&mut viewer) == third);
    let notices: Vec<String> = viewer.take_notices().iter().map(|notice| notice.play_line("s.fbs")).collect();
    assert_eq!(notices.len(), 1, "{notices:?}");
    tap(&mut viewer, Key::Comma);
    assert!(picture(&mut viewer) == second, "one step back from the end");
    tap(&mut viewer, Key::Left);
    tap(&mut viewer, Key::Period);
    picture(&mut viewer);
    assert_eq!(viewer.take_notices(), []);
}

#[test]
fn the_inspector_says_address_bytes_depth_and_face() {
    for mut viewer in viewers() {
        tap(&mut viewer, Key::I);
        picture(&mut viewer);
        viewer.pointer(Some([48.2, 40.9]), 0);
        let zoom = viewer.overlay().zoom.expect("a zoom");
        let [r, g, b, a] = viewer.shown().get_pixel(48, 40).expect("inside");
        let wanted = [format!("FBptr[{}]", (96 * 40 + 48) * 4), format!("{r:02x} {g:02x} {b:02x} {a:02x}")];
        for line in wanted {
            assert!(zoom.lines.contains(&line), "{}: {line} in {:?}", viewer.name, zoom.lines);
        }
        assert_eq!(zoom.colors[zoom.side * zoom.side / 2], Some([r, g, b, a]));
        assert!(zoom.lines.len() >= 7, "{:?}", zoom.lines);
        viewer.pointer(Some([0.0, 0.0]), 0);
        assert_eq!(viewer.overlay().zoom.expect("a zoom").colors[0], None, "off the frame");
        for at in [Some([-1.0, 3.0]), Some([1e300, f64::NAN]), None] {
            viewer.pointer(at, 1);
            assert_eq!(viewer.overlay().zoom, None);
        }
    }
}

#[test]
fn drags_orbit_and_pan_and_the_wheel_comes_nearer() {
    for mut viewer in viewers() {
        for buttons in [1, 4] {
            let before = picture(&mut viewer);
            viewer.pointer(Some([40.0, 30.0]), 0);
            viewer.pointer(Some([40.0, 30.0]), buttons);
            assert!(picture(&mut viewer) == before, "a press alone moves nothing");
            viewer.pointer(Some([52.0, 35.0]), buttons);
            viewer.pointer(Some([52.0, 35.0]), 0);
            assert!(picture(&mut viewer) != before, "{} button {buttons}", viewer.name);
        }
        let before = picture(&mut viewer);
        viewer.wheel(2.0);
        assert!(picture(&mut viewer) != before, "{}", viewer.name);
    }
}

#[test]
fn a_changed_file_is_seen_from_where_the_user_stands() {
    let mut viewer = mesh_viewer();
    tap(&mut viewer, Key::Left);
    let before = picture(&mut viewer);
    let knot = Geometry { mesh: shapes::knot(20, 6).expect("a knot"), textures: Vec::new() };
    viewer.reload(closed(Arc::new(knot)));
    assert!(picture(&mut viewer) != before);
    viewer.reload(closed(teapot()));
    assert!(picture(&mut viewer) == before);
}

#[test]
fn a_held_key_walks_on_and_toggles_once() {
    let mut viewer = mesh_viewer();
    viewer.key(Key::B, true);
    viewer.key(Key::B, true);
    assert!(viewer.overlay().list.iter().any(|l| l.contains("plan")));
    let before = picture(&mut viewer);
    viewer.key(Key::W, true);
    let one = picture(&mut viewer);
    viewer.key(Key::W, true);
    assert!(before != one && picture(&mut viewer) != one);
}

#[test]
fn no_rain_of_keys_ends_it() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for mut viewer in viewers() {
        for _ in 0..150 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let roll = (state >> 33) as usize;
            let key = BINDINGS[roll % BINDINGS.len()].key;
            if !matches!(key, Key::E) {
                tap(&mut viewer, key);
            }
            let at = [(roll % 200) as f64 - 50.0, (roll / 200 % 150) as f64 - 40.0];
            viewer.pointer(Some(at), (roll >> 7) as u8 & 7);
            viewer.advance(Duration::from_millis(37));
            viewer.refresh();
            viewer.overlay();
        }
    }
}

#[test]
fn the_help_names_the_keys_that_do_something_here() {
    let lines = |viewer: &mut Viewer| {
        tap(viewer, Key::F1);
        viewer.overlay().list
    };
    let has = |lines: &[String], key: &str| lines.iter().any(|l| l.split(' ').next() == Some(key));
    let still = lines(&mut mesh_viewer());
    assert!(
        has(&still, "P") && has(&still, "F11") && !has(&still, "Space") && !has(&still, "."),
        "{still:?}"
    );
    let moving = lines(&mut x3d_viewer());
    assert!(has(&moving, "Space") && has(&moving, "."), "{moving:?}");
    let flat = lines(&mut stream_viewer("LINE 0 0 9 9 ff0000\nPRESENT\n"));
    assert!(has(&flat, "I") && !has(&flat, "P") && !has(&flat, "1") && !has(&flat, "J"), "{flat:?}");
    let nd = lines(&mut nd_viewer());
    assert!(has(&nd, "Tab") && has(&nd, "H") && !has(&nd, "P"), "{nd:?}");
}

#[test]
fn the_horizon_stays_level_on_the_way_round() {
    let level = |viewer: &mut Viewer| {
        let Some(Request::Print(text)) = viewer.key(Key::J, true) else {
            panic!("{} has a camera", viewer.name)
        };
        viewer.key(Key::J, false);
        let numbers: Vec<f64> =
            text.lines().next().unwrap().split(' ').skip(1).map(|n| n.parse().unwrap()).collect();
        let v = |i: usize| DVec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
        (v(3) - v(0)).cross(v(6)).normalize()
    };
    // A camera whose up vector tilts with it, as that of a framed mesh; and a stream's, upright
    // along z.
    let upright_z = "MESH m BOX\nLOOKAT 3 3 2 0 0 0 0 0 1\nLIGHT 0 DIR -1 -1 -1 1 1 1\nDRAW m\nPRESENT\n";
    for (mut viewer, up) in [(mesh_viewer(), DVec3::Y), (stream_viewer(upright_z), DVec3::Z)] {
        for _ in 0..9 {
            tap(&mut viewer, Key::Left);
            let right = level(&mut viewer);
            assert!(right.dot(up).abs() < 1e-9, "{}: {right}", viewer.name);
        }
    }
}

#[test]
fn levels_and_billboards_follow_whoever_looks() {
    let text = "<X3D><Scene><Viewpoint position='0 0 6'/><LOD range='20'><Shape><Box/></Shape><Group/></LOD></Scene></X3D>";
    let document = load::x3d::parse(text.as_bytes(), "lod.x3d", &mut |_| None).expect("a document");
    let mut viewer = Viewer::new(Model::X3d(Box::new(document)), options("lod")).expect("a viewer");
    let lit = |bytes: &[u8]| bytes.chunks(4).filter(|p| p[..3] != [0; 3]).count();
    assert!(lit(&picture(&mut viewer)) > 300);
    // Farther than 20 from the box there is nothing.
    let Subject::Space(space) = &mut viewer.subject else { panic!("a space") };
    let home = space.given_camera(0.0);
    viewer.wishes.navigator.walk(&home, [0.0, 0.0, -20.0]);
    viewer.is_stale = true;
    assert_eq!(lit(&picture(&mut viewer)), 0);
}

mod studio;

#[test]
fn a_figure_is_stepped_through_with_its_decision_variable() {
    let text = "CLEAR navy\nFILLRECT 0 0 9 9 lime\nLINE 12 8 2 5 red\nFILLRECT 0 0 2 2 white\n";
    let mut viewer = stream_viewer(text);
    let whole = picture(&mut viewer);
    assert!(viewer.overlay().zoom.is_none());
    let red = |bytes: &[u8]| bytes.as_chunks::<4>().0.iter().filter(|p| **p == [255, 0, 0, 255]).count();
    // What is drawn after the line is not there, and each key draws one pixel of it.
    let mut pictures = Vec::new();
    for count in 1..=11 {
        tap(&mut viewer, Key::N);
        assert!(viewer.refresh());
        pictures.push(viewer.shown().bytes().to_vec());
        assert_eq!(red(viewer.shown().bytes()), count);
    }
    assert_eq!(viewer.shown().get_pixel(0, 0).unwrap(), [0, 255, 0, 255]);
    tap(&mut viewer, Key::N);
    let overlay = viewer.overlay();
    assert!(overlay.bottom.iter().any(|line| line == "the figure is whole"), "{overlay:?}");
    assert!(overlay.bottom.iter().any(|line| line == "LINE, line 3: pixel 11 of 11"), "{overlay:?}");
    for count in (0..11_usize).rev() {
        tap(&mut viewer, Key::U);
        let before = count.checked_sub(1).map(|at| &pictures[at]);
        assert!(before.is_none_or(|before| picture(&mut viewer) == *before), "{count}");
    }
    assert!(viewer.overlay().zoom.is_none() && red(&picture(&mut viewer)) == 0);
    (0..3).for_each(|_| _ = tap(&mut viewer, Key::N));
    // d = 2m - n = -4 at first; 2m = 6, 2m - 2n = -14.
    let zoom = viewer.overlay().zoom.unwrap();
    assert_eq!(
        (zoom.lines, zoom.belongs_left),
        (vec!["x 10 y 7".into(), "step 2".into(), "d -12".into()], false)
    );
    tap(&mut viewer, Key::R);
    assert!(picture(&mut viewer) == whole && viewer.overlay().zoom.is_none());
    // Only what has figures is stepped through.
    for mut viewer in [mesh_viewer(), nd_viewer(), stream_viewer(STREAM), stream_viewer("LINE 1 2 3")] {
        let whole = picture(&mut viewer);
        tap(&mut viewer, Key::N);
        assert!(viewer.message.is_some() && (viewer.is_animated() || picture(&mut viewer) == whole));
    }
}
