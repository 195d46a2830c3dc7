//! Fear: a method of the framebuffer draws other pixels than the verb that its documentation names.

use fbptr::command::{
    Command, Decoder, EndOfInput, Figure, Flow, Group, Limits, Sink, StreamError, StreamPosition, Verb,
    binary_pixel,
};
use fbptr::draw2d::{self, Blend, Rect};
use fbptr::glam::DVec3;
use fbptr::math::matrix;
use fbptr::pipeline::{DrawStats, EmptyDraw};
use fbptr::scene::{Cull, LightKind, ShadeMode, shapes};
use fbptr::server::{Audience, Engine, Session};
use fbptr::{Camera, Framebuffer, Geometry, Light, Material, Mesh, Scene, VideoMemory, glam};
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 64];

/// Runs the commands of a text on an engine.
struct Verbs {
    engine: Engine,
    session: Session,
    replies: Vec<u8>,
}

impl Verbs {
    fn run(commands: &[u8]) -> Verbs {
        let engine = Engine::new(SIZE[0], SIZE[1]).expect("a frame");
        let mut verbs = Verbs { engine, session: Session::new(1, Audience::Owner), replies: Vec::new() };
        let mut decoder = Decoder::new(Limits::default());
        assert_eq!(decoder.feed(commands, &mut verbs), Flow::Continue);
        assert_eq!(decoder.finish(EndOfInput::Stream, &mut verbs), Flow::Continue);
        verbs
    }
}

impl Sink for Verbs {
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        let _ = self.command(Command::Pixel { x, y, color }, StreamPosition::START);
    }

    fn binary_pixels(&mut self, records: &[u8]) {
        for record in records.as_chunks().0 {
            let (x, y, color) = binary_pixel(record);
            let _ = self.command(Command::BinaryPixel { x, y, color }, StreamPosition::START);
        }
    }

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        let verb = command.verb();
        if let Err(refused) = self.engine.run(&mut self.session, command, &mut self.replies) {
            panic!("{verb}: {refused}");
        }
        Flow::Continue
    }

    fn error(&mut self, error: StreamError) -> Flow {
        panic!("{}", error.wire_line())
    }
}

/// Returns the picture of the verbs, and that of the methods, each over the same background.
fn both(verbs: &str, methods: impl FnOnce(&mut Framebuffer)) -> (VideoMemory, VideoMemory) {
    const BACKGROUND: &str = "CLEAR 204060\nFILL 0 0 96 10 30 64 ff0000 00ff0080 0000ff\n";
    let drawn = Verbs::run(format!("{BACKGROUND}{verbs}\n").as_bytes()).engine.memory().clone();
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
    fb.clear([0x20, 0x40, 0x60, 255]);
    fb.fill([[0.0, 0.0], [96.0, 10.0], [30.0, 64.0]], [[255, 0, 0, 255], [0, 255, 0, 128], [0, 0, 255, 255]]);
    let before = fb.memory().clone();
    methods(&mut fb);
    assert!(fb.memory().bytes() != before.bytes(), "{verbs} changes nothing");
    (drawn, fb.into())
}

const ORANGE: [u8; 4] = [255, 128, 0, 160];
const WHITE: [u8; 4] = [255; 4];

#[test]
fn every_method_draws_as_its_verb() {
    type Methods = fn(&mut Framebuffer);
    let cases: &[(&str, Methods)] = &[
        ("CLEAR 102030", |fb| fb.clear([16, 32, 48, 255])),
        ("PX 5 6 ff8000a0", |fb| fb.put_pixel(5, 6, ORANGE)),
        ("POKE 1602 a1b2c3d4e5", |fb| fb.poke(1602, &[0xa1, 0xb2, 0xc3, 0xd4, 0xe5]).expect("inside")),
        ("BLIT -1 62 2 2 :16\nabcdefghijklmnop", |fb| {
            fb.blit([-1, 62, 2, 2], b"abcdefghijklmnop").expect("16 bytes");
        }),
        ("COPY 0 0 40 30 50 40", |fb| fb.copy([0, 0, 40, 30], [50, 40]).expect("inside")),
        ("POINTS :8\n\u{5}\0\u{6}\0abcd", |fb| fb.points(b"\x05\0\x06\0abcd").expect("one pixel")),
        ("PXMULTI\u{5e}\0\u{6}\0\u{3}\0\0\0abcdefghijkl", |fb| fb.pixel_run(94, 6, b"abcdefghijkl")),
        ("LINE -10 3 200 70 ff8000a0", |fb| fb.line([-10, 3], [200, 70], ORANGE)),
        ("LINE 2 60 90 3 ff8000a0 ffffff", |fb| fb.line([2, 60], [90, 3], [ORANGE, WHITE])),
        ("LINEAA 2.5 60 90 3.25 ff8000a0", |fb| fb.line_aa([2.5, 60.0], [90.0, 3.25], ORANGE)),
        ("TRI 2 3 90 20 40 70 ffffff", |fb| fb.triangle([[2, 3], [90, 20], [40, 70]], WHITE)),
        ("TRI 2 3 90 20 40 70 ffffff ff8000a0 ffffff", |fb| {
            fb.triangle([[2, 3], [90, 20], [40, 70]], [WHITE, ORANGE, WHITE]);
        }),
        ("FILL 2.5 3 90 20 40 70 ff8000a0", |fb| fb.fill([[2.5, 3.0], [90.0, 20.0], [40.0, 70.0]], ORANGE)),
        ("WIDELINE 2.5 60 90 3.25 7 ff8000a0", |fb| {
            fb.wide_line([2.5, 60.0], [90.0, 3.25], 7.0, ORANGE).expect("positive");
        }),
        ("ELLIPSE 40 30 37.5 20 ff8000a0", |fb| {
            fb.ellipse([40.0, 30.0], [37.5, 20.0], ORANGE).expect("positive");
        }),
        ("FILLELLIPSE 40 30 37.5 20 ff8000a0", |fb| {
            fb.fill_ellipse([40.0, 30.0], [37.5, 20.0], ORANGE).expect("positive");
        }),
        ("ARC 40 30 10 25 -90deg 0.5 ff8000a0", |fb| {
            let arc = draw2d::Arc {
                center: [40.0, 30.0],
                radii: [10.0, 25.0],
                angles: [-std::f64::consts::FRAC_PI_2, 0.5],
            };
            fb.arc(arc, ORANGE).expect("positive");
        }),
        ("BEZIER 3 60 20 -40 60 90 90 5 4 ff8000a0", |fb| {
            let points = [[3.0, 60.0], [20.0, -40.0], [60.0, 90.0], [90.0, 5.0]];
            fb.bezier(points, 4.0, ORANGE).expect("near");
        }),
        ("TEXTSIZE 3\nPRINT -5 8 ff8000a0  two words :5", |fb| {
            fb.set_text_size(3);
            fb.text([-5, 8], " two words :5", ORANGE);
        }),
        ("RECT 5 6 70 80 ff8000a0", |fb| fb.rect([5, 6, 70, 80], ORANGE).expect("positive")),
        ("FILLRECT 5 6 70 8 ff8000a0", |fb| fb.fill_rect([5, 6, 70, 8], ORANGE).expect("positive")),
        ("FILLRECT 5.5 6 70.25 8 ff8000a0", |fb| {
            fb.fill_rect([5.5, 6.0, 70.25, 8.0], ORANGE).expect("positive")
        }),
        ("CIRCLE 40 30 25 ff8000a0", |fb| fb.circle([40, 30], 25, ORANGE).expect("positive")),
        ("FILLCIRCLE 40.5 30 25.25 ff8000a0", |fb| {
            fb.fill_circle([40.5, 30.0], 25.25, ORANGE).expect("positive");
        }),
        ("POLY ff8000a0 5 5 80 10 60 60 20 50", |fb| {
            fb.poly(&[[5, 5], [80, 10], [60, 60], [20, 50]], ORANGE)
        }),
        ("FILLPOLY ff8000a0 5 5 80 10 60.5 60 20 50", |fb| {
            fb.fill_poly(&[[5.0, 5.0], [80.0, 10.0], [60.5, 60.0], [20.0, 50.0]], ORANGE);
        }),
        ("TEXT 3 4 ff8000a0 :12\nhell\u{f6},\nworl", |fb| fb.text([3, 4], "hell\u{f6},\nworl", ORANGE)),
    ];
    for (verbs, methods) in cases {
        for blend in [Blend::Replace, Blend::Over] {
            let word = if blend == Blend::Over { "over" } else { "replace" };
            let (expected, found) = both(&format!("BLEND {word}\n{verbs}"), |fb| {
                fb.set_blend(blend);
                methods(fb);
            });
            assert!(expected.bytes() == found.bytes(), "{verbs:?} with BLEND {word}");
        }
    }
}

/// Takes the figures of decoded commands.
#[derive(Default)]
struct Figures(Vec<Figure>);

impl Sink for Figures {
    fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {}

    fn binary_pixels(&mut self, _: &[u8]) {}

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        if let Command::Figure(figure) = command {
            self.0.push(figure);
        }
        Flow::Continue
    }

    fn error(&mut self, error: StreamError) -> Flow {
        panic!("{}", error.wire_line())
    }
}

#[test]
fn the_example_of_every_figure_is_drawn_as_the_engine_draws_it() {
    let mut count = 0;
    for verb in Verb::all().iter().filter(|verb| verb.group == Group::TwoD) {
        let example = format!("{}\n", verb.example);
        let mut decoded = Figures::default();
        let mut decoder = Decoder::new(Limits::default());
        assert_eq!(decoder.feed(example.as_bytes(), &mut decoded), Flow::Continue);
        // The others set a mode, or need a file.
        let [figure] = &decoded.0[..] else { continue };
        count += 1;
        let (expected, found) = both(&example, |fb| fb.figure(figure).expect("it is valid"));
        assert!(expected.bytes() == found.bytes(), "{example:?}");
    }
    assert!(count >= 17, "{count} figures");
}

#[test]
fn replies_are_those_of_the_verbs() {
    let verbs = Verbs::run(b"PX 1 2 a0b0c0\nPX 1 2\nPEEK 772 3\nREAD 1 2 1 1\nCRC\n");
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
    fb.put_pixel(1, 2, [0xa0, 0xb0, 0xc0, 255]);
    assert_eq!(fb.get_pixel(1, 2).expect("inside"), [0xa0, 0xb0, 0xc0, 255]);
    assert_eq!(fb.peek(772, 3).expect("inside"), [0xa0, 0xb0, 0xc0]);
    let mut expected = b"PX 1 2 a0b0c0\nPEEK 772 a0b0c0\nREAD 1 2 1 1 :4\n".to_vec();
    expected.extend(fb.read([1, 2, 1, 1]).expect("inside"));
    expected.extend(format!("CRC {:08x}\n", fb.crc()).as_bytes());
    assert_eq!(String::from_utf8_lossy(&verbs.replies), String::from_utf8_lossy(&expected));
    assert!(
        fb.get_pixel(96, 0).is_err() && fb.peek(96 * 64 * 4, 1).is_err() && fb.read([95, 0, 2, 1]).is_err()
    );
}

#[test]
fn a_mesh_is_drawn_as_draw_does_from_every_kind_of_mesh() {
    let verbs = Verbs::run(
        b"MESH pot TEAPOT 4\nLOOKAT 0 4.2 9 0.2 1.3 0 0 1 0\nMATERIAL .9 .55 .2 .9 .55 .2 .7 .7 .7 60\n\
          AMBIENT .15 .15 .15\nLIGHT 0 POINT 5 9 7 1 1 1\nSHADE gouraud\nCULL none\nROTATE 0 1 0 -.5\nDRAW pot\n\
          DEPTHAT 48 32\nPICK 48 32\n",
    );
    let draw = |draw_mesh: &dyn Fn(&mut Framebuffer) -> DrawStats| {
        let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
        let mut camera = Camera::default();
        camera.look_at.eye = DVec3::new(0.0, 4.2, 9.0);
        camera.look_at.reference = DVec3::new(0.2, 1.3, 0.0);
        let copper = DVec3::new(0.9, 0.55, 0.2);
        fb.state.camera = camera;
        fb.state.material =
            Material { ka: copper, kd: copper, ks: DVec3::splat(0.7), n: 60.0, ..Material::default() };
        fb.state.ambient = DVec3::splat(0.15);
        fb.state.lights = vec![Light::point(DVec3::new(5.0, 9.0, 7.0), DVec3::ONE)];
        fb.state.shade = ShadeMode::Gouraud;
        fb.state.cull = Cull::None;
        fb.state.model = matrix::rotate(DVec3::Y, -0.5).expect("an axis");
        fb.enable_picking();
        assert!(draw_mesh(&mut fb).faces_drawn > 0);
        fb
    };
    let teapot = shapes::teapot(4).expect("a level");
    let geometry = Geometry::from(teapot.clone());
    let shared = Arc::new(geometry.clone());
    let pictures = [
        draw(&|fb| fb.draw(&teapot).expect("a camera").stats),
        draw(&|fb| fb.draw(&geometry).expect("a camera").stats),
        draw(&|fb| fb.draw(&shared).expect("a camera").stats),
    ];
    for fb in &pictures {
        assert!(fb.memory().bytes() == verbs.engine.memory().bytes());
        let z = fb.depth_at(48, 32).expect("inside");
        let (_, triangle) = fb.pick(48, 32).expect("the teapot is there");
        let replies = String::from_utf8(verbs.replies.clone()).expect("text");
        let words: Vec<&str> = replies.split_whitespace().collect();
        assert!((words[3].parse::<f64>().expect("a depth") - z).abs() < 1e-8, "{z}: {replies}");
        assert_eq!(words[8], triangle.to_string());
    }
}

#[test]
fn show_whole_lights_a_mesh_and_brings_it_into_the_frame() {
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
    let mesh = shapes::cuboid(DVec3::new(4000.0, 2000.0, 3000.0)).expect("a size");
    fb.show_whole(&mesh);
    assert!(matches!(fb.state.lights[..], [Light { kind: LightKind::Directional { .. }, .. }]));
    fb.draw(&mesh).expect("a camera").visible().expect("it is seen");
    let is_lit = |x: u32, y: u32| fb.get_pixel(x as i32, y as i32).expect("inside")[0] > 20;
    let columns: Vec<u32> = (0..SIZE[0]).filter(|&x| (0..SIZE[1]).any(|y| is_lit(x, y))).collect();
    let rows: Vec<u32> = (0..SIZE[1]).filter(|&y| (0..SIZE[0]).any(|x| is_lit(x, y))).collect();
    // Lit without a gap, inside the frame, and over most of one of its sides.
    for (lit, side) in [(&columns, SIZE[0]), (&rows, SIZE[1])] {
        assert!(lit[0] > 0 && lit[lit.len() - 1] < side - 1, "{lit:?}");
        assert_eq!(lit.len() as u32, lit[lit.len() - 1] - lit[0] + 1, "{lit:?}");
    }
    assert!(columns.len() > 60 || rows.len() > 40, "{columns:?} {rows:?}");
}

#[test]
fn a_draw_that_shows_nothing_says_why() {
    let sphere = shapes::sphere(1.0).expect("a size");
    type Change = fn(&mut Framebuffer);
    let cases: [(EmptyDraw, Change); 7] = [
        (EmptyDraw::NoLight, |fb| {
            fb.state.lights.clear();
            fb.state.ambient = DVec3::ZERO;
        }),
        (EmptyDraw::Culled, |fb| {
            // From inside, all faces are seen from the back.
            fb.state.cull = Cull::Back;
            fb.state.model = glam::DMat4::from_scale(DVec3::splat(100.0));
            fb.state.camera = Camera::default();
        }),
        (EmptyDraw::BehindEye, |fb| {
            let eye = fb.state.camera.look_at.eye;
            fb.state.model = glam::DMat4::from_translation(eye * 3.0);
        }),
        (EmptyDraw::OutsideView, |fb| {
            let look_at = fb.state.camera.look_at;
            let right = (look_at.reference - look_at.eye).cross(look_at.up);
            fb.state.model = glam::DMat4::from_translation(right * 9.0);
        }),
        (EmptyDraw::TooSmall, |fb| fb.state.model = glam::DMat4::from_scale(DVec3::splat(1e-9))),
        (EmptyDraw::Hidden, |fb| {
            fb.draw(&shapes::sphere(1.0).expect("a size")).expect("a camera").visible().expect("it is seen");
            fb.state.model = glam::DMat4::from_scale(DVec3::splat(0.2));
        }),
        (EmptyDraw::Clipped, |fb| fb.set_clip(Some(Rect { x: 0, y: 0, w: 3, h: 2 }))),
    ];
    for (reason, set) in cases {
        let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
        fb.show_whole(&sphere);
        set(&mut fb);
        let report = fb.draw(&sphere).expect("a camera");
        assert_eq!(report.empty, Some(reason), "{report:?}");
        let refused = report.visible().expect_err("nothing is seen").to_string();
        assert_eq!(refused, format!("the draw shows nothing: {reason}"));
        if reason != EmptyDraw::Hidden {
            let scene = Scene { ambient: DVec3::ZERO, ..Scene::default() };
            assert_eq!(fb.draw_scene(&scene).expect("a camera").empty, Some(EmptyDraw::NoContent));
        }
    }
    // A new framebuffer has no light.
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1]).expect("a frame");
    assert_eq!(fb.draw(&sphere).expect("a camera").empty, Some(EmptyDraw::NoLight));
    assert_eq!(fb.draw(&Mesh::default()).expect("a camera").empty, Some(EmptyDraw::NoContent));
}
