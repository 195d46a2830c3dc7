//! Validation of commands built as typed values, without a parser: each number, size, name and
//! payload is checked separately.
//!
//! Guards against a forgotten field, through which the library would accept a value that no line
//! can express.

use fbptr::command::{
    AreaColors, Command, Figure, LightCommand, MeshSource, Quality, RealRect, Rect, SnapTarget, Verb,
};
use fbptr::error::Code;
use fbptr::scene::{Attenuation, Material, ObliqueKind, Projection};
use glam::{DMat4, DVec3};

/// Returns the lines and areas that hold real numbers, each of them taken from `n`.
fn figures_with_reals(n: &mut dyn FnMut() -> f64) -> Vec<Command> {
    let color = [1, 2, 3, 4];
    let white = [[9; 4]; 3];
    vec![
        Command::Figure(Figure::Fill {
            points: [[n(), n()], [n(), n()], [n(), n()]],
            colors: AreaColors::Three(white),
        }),
        Command::Figure(Figure::FillRect { rect: RealRect { x: n(), y: n(), w: n(), h: n() }, color }),
        Command::Figure(Figure::FillCircle { cx: n(), cy: n(), r: n(), color }),
        Command::Figure(Figure::FillPoly { color, points: vec![[n(), n()], [n(), n()]] }),
        Command::Figure(Figure::LineAa { p0: [n(), n()], p1: [n(), n()], color }),
    ]
}

/// Returns every command that holds real numbers, each of them taken from `n`.
fn with_reals(n: &mut dyn FnMut() -> f64) -> Vec<Command> {
    fn v(n: &mut dyn FnMut() -> f64) -> DVec3 {
        DVec3::new(n(), n(), n())
    }
    fn fading(n: &mut dyn FnMut() -> f64) -> Attenuation {
        Attenuation { c: n(), l: n(), q: n() }
    }
    fn four(n: &mut dyn FnMut() -> f64) -> [f64; 4] {
        [n(), n(), n(), n()]
    }
    let mesh = |source| Command::Mesh { name: "m".into(), source: Box::new(source) };
    let view = |projection| Command::Projection(Box::new(projection));
    let light = |light| Command::Light { index: 0, light: Box::new(light) };
    let others = vec![
        mesh(MeshSource::Box(v(n))),
        mesh(MeshSource::Sphere(n())),
        mesh(MeshSource::Cone(n(), n())),
        mesh(MeshSource::Cylinder(n(), n())),
        Command::LookAt { eye: v(n), reference: v(n), up: v(n) },
        view(Projection::Perspective { fov_rad: n(), near: n(), far: n(), on_smaller_side: false }),
        view(Projection::Plane { d: n(), near: n(), far: n() }),
        view(Projection::Frustum { window: four(n), near: n(), far: n() }),
        view(Projection::Ortho { window: four(n), near: n(), far: n() }),
        view(Projection::OrthoContain { window: four(n), near: n(), far: n() }),
        view(Projection::Isometric { window: four(n), near: n(), far: n() }),
        view(Projection::PseudoIsometric { window: four(n), near: n(), far: n() }),
        view(Projection::Oblique {
            kind: ObliqueKind::Cavalier,
            angle_rad: n(),
            window: four(n),
            near: n(),
            far: n(),
        }),
        view(Projection::Window {
            vrp: v(n),
            p: v(n),
            vup: v(n),
            center: [n(), n()],
            half: [n(), n()],
            dp: n(),
            near: n(),
            far: n(),
        }),
        Command::Translate(v(n)),
        Command::Scale(v(n)),
        Command::Ambient(v(n)),
        Command::Rotate { axis: v(n), angle_rad: n() },
        Command::Shear(Box::new([n(), n(), n(), n(), n(), n()])),
        Command::Matrix(Box::new(DMat4::from_cols_array(&std::array::from_fn(|_| n())))),
        light(LightCommand::Point { position: v(n), color: v(n), attenuation: fading(n) }),
        light(LightCommand::Dir { direction: v(n), color: v(n) }),
        light(LightCommand::Spot {
            position: v(n),
            direction: v(n),
            angle_rad: n(),
            exponent: n(),
            color: v(n),
            attenuation: fading(n),
        }),
        Command::Material(Box::new(Material {
            ka: v(n),
            kd: v(n),
            ks: v(n),
            n: n(),
            emissive: v(n),
            transparency: n(),
            ..Material::default()
        })),
        Command::DrawScene { time: n(), sorted: true },
        Command::Quality(Quality::MaxError(n().into())),
    ];
    [figures_with_reals(n), others].concat()
}

/// Returns every command that holds sizes, each of them taken from `n`; values that may be negative
/// are.
fn with_sizes(n: &mut dyn FnMut() -> i32) -> Vec<Command> {
    fn rect(n: &mut dyn FnMut() -> i32) -> Rect {
        Rect { x: -5, y: -6, w: n(), h: n() }
    }
    fn real(n: &mut dyn FnMut() -> i32) -> f64 {
        f64::from(n())
    }
    let color = [1, 2, 3, 4];
    let mesh = |source| Command::Mesh { name: "m".into(), source: Box::new(source) };
    vec![
        Command::Read { rect: rect(n) },
        Command::Copy { source: rect(n), dx: -1, dy: -1 },
        Command::Crc { rect: Some(rect(n)) },
        Command::Figure(Figure::Rect { rect: rect(n), color }),
        Command::Viewport { rect: rect(n), rule: fbptr::scene::ViewportRule::Corners },
        Command::DrawEye { name: "e".into(), rect: rect(n) },
        Command::Figure(Figure::FillRect {
            rect: RealRect { x: -5.5, y: -6.5, w: real(n), h: real(n) },
            color,
        }),
        Command::Figure(Figure::Circle { cx: -7, cy: -8, r: n(), color }),
        Command::Figure(Figure::FillCircle { cx: -7.0, cy: -8.0, r: real(n), color }),
        Command::Peek { offset: 0, n: n() },
        Command::Light { index: n(), light: Box::new(LightCommand::Off) },
        Command::Quality(Quality::MaxError(real(n).into())),
        mesh(MeshSource::Box(DVec3::new(real(n), real(n), real(n)))),
        mesh(MeshSource::Sphere(real(n))),
        mesh(MeshSource::Cone(real(n), real(n))),
        mesh(MeshSource::Cylinder(real(n), real(n))),
    ]
}

/// Returns the verb and error code of each command that is refused.
fn refusals(commands: &[Command]) -> Vec<(&'static str, Code)> {
    commands.iter().filter_map(|c| c.validate().err().map(|fault| (c.verb(), fault.code))).collect()
}

/// Verifies that each single bad value makes its own command invalid, and no other.
fn each_alone<T: Copy>(build: impl Fn(&mut dyn FnMut() -> T) -> Vec<Command>, good: T, bad: T, code: Code) {
    let mut values = 0;
    let commands = build(&mut || {
        values += 1;
        good
    });
    assert_eq!(refusals(&commands), []);
    for wrong in 0..values {
        let mut at = 0;
        let commands = build(&mut || {
            at += 1;
            if at == wrong + 1 { bad } else { good }
        });
        let refused = refusals(&commands);
        assert!(matches!(refused[..], [(_, c)] if c == code), "value {wrong} of {values}: {refused:?}");
    }
}

#[test]
fn every_real_must_be_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        each_alone(with_reals, 1.0, bad, Code::Num);
    }
}

#[test]
fn every_size_must_be_from_zero() {
    for good in [0, 1, i32::MAX] {
        for bad in [-1, i32::MIN] {
            each_alone(with_sizes, good, bad, Code::Range);
        }
    }
}

#[test]
fn lengths_texts_and_names_are_checked_too() {
    let color = [1, 2, 3, 4];
    let blit = |w, h, bytes| Command::Blit { rect: Rect { x: 0, y: 0, w, h }, rgba: vec![0; bytes] };
    let text = |utf8: &[u8]| Command::Figure(Figure::Text { x: 0, y: 0, color, utf8: utf8.to_vec() });
    let named = |name: &str| {
        let name = name.to_owned();
        [
            Command::Draw { name: name.clone() },
            Command::Free { name: name.clone() },
            Command::Sync { tag: name.clone() },
            Command::Eye { name: name.clone(), json: Vec::new() },
            Command::Texture { name: name.clone(), file: Vec::new() },
            Command::Snap(SnapTarget::File(name)),
        ]
    };
    let good = [
        blit(3, 2, 24),
        blit(0, 9, 0),
        text("caf\u{e9}".as_bytes()),
        text(b""),
        Command::Points { packed: vec![0; 16] },
        Command::PixelRun { x: 0, y: 0, rgba: vec![0; 12] },
        Command::Poke { offset: 0, bytes: vec![0] },
        Command::Figure(Figure::Poly { color, points: vec![[0, 0]] }),
        Command::Figure(Figure::FillPoly { color, points: vec![[0.0, 0.0]] }),
        Command::Mesh { name: "m".into(), source: Box::new(MeshSource::Knot(i32::MAX as u32, 3)) },
    ];
    assert_eq!(refusals(&good), []);
    assert_eq!(refusals(&named("a:b-c")[..]), []);
    let bad = [
        (blit(3, 2, 23), Code::Format),
        (blit(3, 2, 25), Code::Format),
        (blit(-3, -2, 24), Code::Range),
        (blit(-3, 2, 0), Code::Range),
        (text(b"a\xff"), Code::Format),
        (Command::Points { packed: vec![0; 12] }, Code::Format),
        (Command::PixelRun { x: 0, y: 0, rgba: vec![0; 6] }, Code::Format),
        (Command::Poke { offset: 0, bytes: Vec::new() }, Code::Args),
        (Command::Figure(Figure::Poly { color, points: Vec::new() }), Code::Args),
        (Command::Figure(Figure::FillPoly { color, points: Vec::new() }), Code::Args),
        (Command::Mesh { name: "m".into(), source: Box::new(MeshSource::Knot(3, u32::MAX)) }, Code::Range),
        (Command::Mesh { name: "m".into(), source: Box::new(MeshSource::Teapot(u32::MAX)) }, Code::Range),
    ];
    for (command, code) in bad {
        assert_eq!(command.validate().map_err(|fault| fault.code), Err(code), "{command:?}");
    }
    for name in ["", "a b", "a\n", ":a"] {
        for command in named(name) {
            assert_eq!(command.validate().map_err(|fault| fault.code), Err(Code::Args), "{command:?}");
        }
    }
}

#[test]
fn verbs_are_equal_by_their_name_alone() {
    for (i, a) in Verb::all().iter().enumerate() {
        for (j, b) in Verb::all().iter().enumerate() {
            assert_eq!(a == b, i == j, "{a:?} {b:?}");
        }
        // A text line cannot begin with the name of a binary command.
        let found = (!["PB", "PXMULTI"].contains(&a.name)).then_some(a);
        assert_eq!(Verb::find(a.name.as_bytes()), found);
        assert_eq!(Verb::find(a.name.to_lowercase().as_bytes()), found);
    }
}
