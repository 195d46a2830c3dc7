//! Verifies that an encoded command decodes to an equal command, bit for bit.

use crate::recorder::{Event, hear};
use crate::table_lines::described;
use fbptr::command::{
    AreaColors, Command, EncodeError, ErrorMode, Figure, FileKind, LightCommand, MeshSource, Quality,
    RampColor, RealRect, Rect, SnapTarget, Verb, encode,
};
use fbptr::memory::DepthFormat;
use fbptr::scene::{
    Attenuation, Cull, Filter, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling,
    ShadeMode, ViewportRule, Wrap,
};
use glam::{DMat4, DVec3};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn real() -> BoxedStrategy<f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |n| n.is_finite()),
        (-1000..1000i32).prop_map(|n| f64::from(n) / 8.0),
        prop::sample::select(vec![0.0, -0.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, 1.0 / 3.0]),
    ]
    .boxed()
}

fn size() -> BoxedStrategy<f64> {
    real().prop_map(f64::abs).boxed()
}

fn vector() -> BoxedStrategy<DVec3> {
    [real(), real(), real()].prop_map(DVec3::from_array).boxed()
}

fn color() -> BoxedStrategy<[u8; 4]> {
    prop_oneof![any::<[u8; 4]>(), any::<[u8; 3]>().prop_map(|[r, g, b]| [r, g, b, 255])].boxed()
}

fn rect() -> BoxedStrategy<Rect> {
    (any::<i32>(), any::<i32>(), 0..=i32::MAX, 0..=i32::MAX)
        .prop_map(|(x, y, w, h)| Rect { x, y, w, h })
        .boxed()
}

fn name() -> BoxedStrategy<String> {
    prop_oneof![
        "[@a-zA-Z0-9._/-]{1,20}".prop_filter("OFF is no name", |n| !n.eq_ignore_ascii_case("off")),
        "[^:\\x00-\\x20\\x7f][^\\x00-\\x20\\x7f]{0,40}"
            .prop_filter("OFF is no name", |n| !n.eq_ignore_ascii_case("off")),
    ]
    .boxed()
}

fn bytes() -> BoxedStrategy<Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..100).boxed()
}

fn blit() -> BoxedStrategy<Command> {
    (any::<i32>(), any::<i32>(), 0..9i32, 0..9i32, any::<u8>())
        .prop_map(|(x, y, w, h, seed)| Command::Blit {
            rect: Rect { x, y, w, h },
            rgba: (0..w * h * 4).map(|i| (i as u8).wrapping_mul(37).wrapping_add(seed)).collect(),
        })
        .boxed()
}

fn mesh() -> BoxedStrategy<MeshSource> {
    prop_oneof![
        bytes().prop_map(MeshSource::Obj),
        [size(), size(), size()].prop_map(|s| MeshSource::Box(DVec3::from_array(s))),
        size().prop_map(MeshSource::Sphere),
        (size(), size()).prop_map(|(r, h)| MeshSource::Cone(r, h)),
        (size(), size()).prop_map(|(r, h)| MeshSource::Cylinder(r, h)),
        (0..=i32::MAX as u32).prop_map(MeshSource::Teapot),
        (0..=i32::MAX as u32, 0..=i32::MAX as u32).prop_map(|(u, v)| MeshSource::Knot(u, v)),
    ]
    .boxed()
}

fn projection() -> BoxedStrategy<Projection> {
    let window = || [real(), real(), real(), real()];
    prop_oneof![
        (real(), real(), real(), any::<bool>()).prop_map(|(fov_rad, near, far, on_smaller_side)| {
            Projection::Perspective { fov_rad, near, far, on_smaller_side }
        }),
        (real(), real(), real()).prop_map(|(d, near, far)| Projection::Plane { d, near, far }),
        (window(), real(), real()).prop_map(|(window, near, far)| Projection::Frustum { window, near, far }),
        (window(), real(), real()).prop_map(|(window, near, far)| Projection::Ortho { window, near, far }),
        (any::<bool>(), real(), window(), real(), real()).prop_map(
            |(cabinet, angle_rad, window, near, far)| {
                let kind = if cabinet { ObliqueKind::Cabinet } else { ObliqueKind::Cavalier };
                Projection::Oblique { kind, angle_rad, window, near, far }
            }
        ),
        (window(), real(), real()).prop_map(|(window, near, far)| Projection::Isometric {
            window,
            near,
            far
        }),
        (window(), real(), real()).prop_map(|(window, near, far)| Projection::PseudoIsometric {
            window,
            near,
            far
        }),
        ([vector(), vector(), vector()], window(), [real(), real(), real()]).prop_map(
            |([vrp, p, vup], [a, b, c, d], [dp, near, far])| Projection::Window {
                vrp,
                p,
                vup,
                center: [a, b],
                half: [c, d],
                dp,
                near,
                far
            }
        ),
    ]
    .boxed()
}

fn attenuation() -> BoxedStrategy<Attenuation> {
    prop_oneof![
        Just(Attenuation::NONE),
        (real(), real(), real()).prop_map(|(c, l, q)| Attenuation { c, l, q })
    ]
    .boxed()
}

/// Returns colours of light: none of their channels is negative.
fn light_color() -> BoxedStrategy<DVec3> {
    vector().prop_map(DVec3::abs).boxed()
}

fn light() -> BoxedStrategy<LightCommand> {
    prop_oneof![
        (vector(), light_color(), attenuation())
            .prop_map(|(position, color, attenuation)| LightCommand::Point { position, color, attenuation }),
        (vector(), light_color()).prop_map(|(direction, color)| LightCommand::Dir { direction, color }),
        (vector(), vector(), real(), real(), light_color(), attenuation()).prop_map(
            |(position, direction, angle_rad, exponent, color, attenuation)| LightCommand::Spot {
                position,
                direction,
                angle_rad,
                exponent,
                color,
                attenuation
            }
        ),
        Just(LightCommand::Off),
    ]
    .boxed()
}

fn area() -> BoxedStrategy<AreaColors> {
    prop_oneof![color().prop_map(AreaColors::One), [color(), color(), color()].prop_map(AreaColors::Three)]
        .boxed()
}

fn choice<T: Clone + std::fmt::Debug + 'static>(all: &[T]) -> BoxedStrategy<T> {
    prop::sample::select(all.to_vec()).boxed()
}

/// Generates every variant of the enum.
fn command() -> BoxedStrategy<Command> {
    let kinds = [plain_commands(), figures(), curves(), three_d_commands(), control_commands()];
    prop::strategy::Union::new(kinds.concat()).boxed()
}

/// Generates the commands without arguments, and those of pixels and bytes.
fn plain_commands() -> Vec<BoxedStrategy<Command>> {
    let xy = || (any::<i32>(), any::<i32>());
    vec![
        choice(&[
            Command::Help,
            Command::Size,
            Command::Quit,
            Command::Stats,
            Command::Identity,
            Command::Push,
            Command::Pop,
            Command::Hello,
            Command::Version,
            Command::Quality(Quality::Exact),
            Command::Snap(SnapTarget::Connection),
        ]),
        xy().prop_map(|(x, y)| Command::GetPixel { x, y }).boxed(),
        (xy(), color()).prop_map(|((x, y), color)| Command::Pixel { x, y, color }).boxed(),
        xy().prop_map(|(x, y)| Command::Offset { x, y }).boxed(),
        (any::<u16>(), any::<u16>(), color())
            .prop_map(|(x, y, color)| Command::BinaryPixel { x, y, color })
            .boxed(),
        (any::<u16>(), any::<u16>(), prop::collection::vec(color(), 0..20))
            .prop_map(|(x, y, run)| Command::PixelRun { x, y, rgba: run.concat() })
            .boxed(),
        (any::<i32>(), prop::collection::vec(any::<u8>(), 1..1000))
            .prop_map(|(offset, bytes)| Command::Poke { offset, bytes })
            .boxed(),
        (any::<i32>(), 0..=i32::MAX).prop_map(|(offset, n)| Command::Peek { offset, n }).boxed(),
        blit(),
        rect().prop_map(|rect| Command::Read { rect }).boxed(),
        (rect(), xy()).prop_map(|(source, (dx, dy))| Command::Copy { source, dx, dy }).boxed(),
        prop::collection::vec(any::<[u8; 8]>(), 0..20)
            .prop_map(|p| Command::Points { packed: p.concat() })
            .boxed(),
        prop::option::of(rect()).prop_map(|rect| Command::Crc { rect }).boxed(),
        color().prop_map(|color| Command::Clear { color }).boxed(),
    ]
}

/// Generates the commands of lines, areas and text.
fn figures() -> Vec<BoxedStrategy<Command>> {
    let xy = || (any::<i32>(), any::<i32>());
    let point = || any::<[i32; 2]>();
    let real2 = || [real(), real()];
    vec![
        (point(), point(), color(), prop::option::of(color()))
            .prop_map(|(p0, p1, from, to)| {
                Command::Figure(Figure::Line { p0, p1, color: RampColor { from, to } })
            })
            .boxed(),
        ([point(), point(), point()], area())
            .prop_map(|(points, colors)| Command::Figure(Figure::Triangle { points, colors }))
            .boxed(),
        ([real2(), real2(), real2()], area())
            .prop_map(|(points, colors)| Command::Figure(Figure::Fill { points, colors }))
            .boxed(),
        (rect(), color()).prop_map(|(rect, color)| Command::Figure(Figure::Rect { rect, color })).boxed(),
        (real2(), size(), size(), color())
            .prop_map(|([x, y], w, h, color)| {
                Command::Figure(Figure::FillRect { rect: RealRect { x, y, w, h }, color })
            })
            .boxed(),
        (xy(), 0..=i32::MAX, color())
            .prop_map(|((cx, cy), r, color)| Command::Figure(Figure::Circle { cx, cy, r, color }))
            .boxed(),
        (real2(), size(), color())
            .prop_map(|([cx, cy], r, color)| Command::Figure(Figure::FillCircle { cx, cy, r, color }))
            .boxed(),
        (color(), prop::collection::vec(point(), 1..100))
            .prop_map(|(color, points)| Command::Figure(Figure::Poly { color, points }))
            .boxed(),
        (color(), prop::collection::vec(real2(), 1..60))
            .prop_map(|(color, points)| Command::Figure(Figure::FillPoly { color, points }))
            .boxed(),
        (xy(), color(), any::<String>())
            .prop_map(|((x, y), color, text)| {
                Command::Figure(Figure::Text { x, y, color, utf8: text.into_bytes() })
            })
            .boxed(),
        (real2(), real2(), color())
            .prop_map(|(p0, p1, color)| Command::Figure(Figure::LineAa { p0, p1, color }))
            .boxed(),
        any::<bool>().prop_map(|over| Command::Blend { over }).boxed(),
    ]
}

/// Generates the commands of curves, lines of text and pictures.
fn curves() -> Vec<BoxedStrategy<Command>> {
    let real2 = || [real(), real()];
    let text = || "[ -~é]{0,30}[!-~é][ -~é]{0,30}";
    vec![
        (any::<[i32; 2]>(), color(), text())
            .prop_map(|([x, y], color, text)| Command::Figure(Figure::Print { x, y, color, text }))
            .boxed(),
        (real2(), real2(), size(), color())
            .prop_map(|(p0, p1, width, color)| Command::Figure(Figure::WideLine { p0, p1, width, color }))
            .boxed(),
        (real2(), [size(), size()], color())
            .prop_map(|(center, radii, color)| Command::Figure(Figure::Ellipse { center, radii, color }))
            .boxed(),
        (real2(), [size(), size()], color())
            .prop_map(|(center, radii, color)| Command::Figure(Figure::FillEllipse { center, radii, color }))
            .boxed(),
        (real2(), [size(), size()], real2(), color())
            .prop_map(|(center, radii, angles, color)| {
                Command::Figure(Figure::Arc { center, radii, angles, color })
            })
            .boxed(),
        ([real2(), real2(), real2(), real2()], size(), color())
            .prop_map(|(points, width, color)| Command::Figure(Figure::Bezier { points, width, color }))
            .boxed(),
        (0.0..=60.0).prop_map(|seconds| Command::Wait { seconds }).boxed(),
        prop::option::of(rect()).prop_map(|rect| Command::Clip { rect }).boxed(),
        (1..=8i32).prop_map(|size| Command::TextSize { size }).boxed(),
        (any::<[i32; 2]>(), prop::collection::vec(any::<u8>(), 0..50))
            .prop_map(|([x, y], file)| Command::Image { x, y, file })
            .boxed(),
    ]
}

/// Generates the commands of resources, cameras, matrices, lights and materials.
fn three_d_commands() -> Vec<BoxedStrategy<Command>> {
    vec![
        (name(), mesh()).prop_map(|(name, source)| Command::Mesh { name, source: Box::new(source) }).boxed(),
        (name(), bytes()).prop_map(|(name, file)| Command::Texture { name, file }).boxed(),
        bytes().prop_map(|x3d| Command::Scene { x3d }).boxed(),
        (name(), bytes()).prop_map(|(name, json)| Command::Eye { name, json }).boxed(),
        name().prop_map(|name| Command::Free { name }).boxed(),
        (name(), name(), 0..3)
            .prop_map(|(name, path, kind)| match kind {
                0 => Command::Load { kind: FileKind::Mesh, name, path },
                1 => Command::Load { kind: FileKind::Texture, name, path },
                _ => Command::Load { kind: FileKind::Scene, name: String::new(), path },
            })
            .boxed(),
        (vector(), vector(), vector())
            .prop_map(|(eye, reference, up)| Command::LookAt { eye, reference, up })
            .boxed(),
        projection().prop_map(|p| Command::Projection(Box::new(p))).boxed(),
        (rect(), choice(&[ViewportRule::Corners, ViewportRule::Centres]))
            .prop_map(|(rect, rule)| Command::Viewport { rect, rule })
            .boxed(),
        vector().prop_map(Command::Translate).boxed(),
        (vector(), real()).prop_map(|(axis, angle_rad)| Command::Rotate { axis, angle_rad }).boxed(),
        vector().prop_map(Command::Scale).boxed(),
        [real(), real(), real(), real(), real(), real()].prop_map(|s| Command::Shear(Box::new(s))).boxed(),
        prop::collection::vec(real(), 16)
            .prop_map(|m| Command::Matrix(Box::new(DMat4::from_cols_slice(&m))))
            .boxed(),
        light_color().prop_map(Command::Ambient).boxed(),
        (0..=i32::MAX, light())
            .prop_map(|(index, light)| Command::Light { index, light: Box::new(light) })
            .boxed(),
        ([vector(), vector(), vector(), vector()], real(), real())
            .prop_map(|([ka, kd, ks, emissive], n, transparency)| {
                Command::Material(Box::new(Material {
                    ka,
                    kd,
                    ks,
                    n,
                    emissive,
                    transparency,
                    ..Material::default()
                }))
            })
            .boxed(),
        (prop::option::of(name()), choice(Filter::ALL), choice(Wrap::ALL))
            .prop_map(|(name, filter, wrap)| Command::UseTexture {
                name,
                sampling: Sampling { filter, wrap_s: wrap, wrap_t: wrap },
            })
            .boxed(),
    ]
}

/// Generates the commands of modes, drawing, queries and settings.
fn control_commands() -> Vec<BoxedStrategy<Command>> {
    let xy = || (any::<i32>(), any::<i32>());
    vec![
        choice(ShadeMode::ALL).prop_map(Command::Shade).boxed(),
        choice(Cull::ALL).prop_map(Command::Cull).boxed(),
        choice(HiddenSurface::ALL).prop_map(Command::Hide).boxed(),
        choice(&DepthFormat::ALL).prop_map(Command::Depth).boxed(),
        choice(Interpolation::ALL).prop_map(Command::Interp).boxed(),
        name().prop_map(|name| Command::Draw { name }).boxed(),
        (real(), any::<bool>()).prop_map(|(time, sorted)| Command::DrawScene { time, sorted }).boxed(),
        (name(), rect()).prop_map(|(name, rect)| Command::DrawEye { name, rect }).boxed(),
        size().prop_map(|e| Command::Quality(Quality::MaxError(e.into()))).boxed(),
        xy().prop_map(|(x, y)| Command::DepthAt { x, y }).boxed(),
        xy().prop_map(|(x, y)| Command::Pick { x, y }).boxed(),
        name().prop_map(|tag| Command::Sync { tag }).boxed(),
        any::<bool>().prop_map(Command::Auto).boxed(),
        any::<bool>().prop_map(|wait| Command::Present { wait }).boxed(),
        any::<bool>().prop_map(Command::Events).boxed(),
        choice(&[ErrorMode::Count, ErrorMode::Report, ErrorMode::Close]).prop_map(Command::Errors).boxed(),
        name().prop_map(|n| Command::Snap(SnapTarget::File(n))).boxed(),
    ]
}

/// Returns the only command of a stream; a pixel is converted back to a command.
fn heard_once(bytes: &[u8]) -> Command {
    let mut heard = hear(bytes);
    assert_eq!(heard.len(), 1, "{heard:?}");
    match heard.remove(0) {
        Event::Command(command, _) => command,
        Event::Pixel(x, y, color) => Command::Pixel { x, y, color },
        Event::Binary(x, y, color) => Command::BinaryPixel { x, y, color },
        Event::Error(error) => panic!("{}", error.wire_line()),
    }
}

/// Returns whether two commands are equal, including the sign of zero, which Debug shows.
fn same(a: &Command, b: &Command) -> bool {
    a == b && format!("{a:?}") == format!("{b:?}")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6000))]

    #[test]
    fn decoding_an_encoded_command_gives_it_back(command in command()) {
        let mut bytes = b"before".to_vec();
        encode(&command, &mut bytes).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(&bytes[..6], b"before");
        let heard = heard_once(&bytes[6..]);
        prop_assert!(same(&heard, &command), "{:?}\n{:?}", command, heard);
        // Encoding the decoded command gives the same bytes.
        let mut again = Vec::new();
        encode(&heard, &mut again).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(&bytes[6..], &again[..]);
    }
}

#[test]
fn the_strategy_makes_every_verb_that_the_table_does_not_describe() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let strategy = command();
    let made: BTreeSet<&str> =
        (0..3000).map(|_| strategy.new_tree(&mut runner).unwrap().current().verb()).collect();
    let described: BTreeSet<&str> = described().map(|v| v.name).collect();
    let all: BTreeSet<&str> = Verb::all().iter().map(|v| v.name).collect();
    assert_eq!(&made | &described, all);
}

#[test]
fn what_has_no_bytes_says_why_and_leaves_the_buffer_alone() {
    type IsRight = fn(&EncodeError) -> bool;
    let cases: [(Command, IsRight); 10] = [
        (Command::Translate(DVec3::new(0.0, f64::NAN, 0.0)), |e| e.code().as_str() == "ENUM"),
        (Command::Read { rect: Rect { x: 0, y: 0, w: -1, h: 0 } }, |e| e.code().as_str() == "ERANGE"),
        (Command::Blit { rect: Rect { x: 0, y: 0, w: 1, h: 1 }, rgba: vec![0; 5] }, |e| {
            e.code().as_str() == "EFORMAT"
        }),
        (Command::Draw { name: "two words".into() }, |e| e.code().as_str() == "EARGS"),
        (Command::Draw { name: ":5".into() }, |e| e.code().as_str() == "EARGS"),
        (Command::Figure(Figure::Poly { color: [0; 4], points: vec![] }), |e| e.code().as_str() == "EARGS"),
        (Command::Figure(Figure::Poly { color: [0; 4], points: vec![[-1_000_000, 0]; 400] }), |e| {
            matches!(e, EncodeError::LineTooLong { verb: "POLY", .. })
        }),
        (Command::UseTexture { name: Some("Off".into()), sampling: Sampling::default() }, |e| {
            matches!(e, EncodeError::NoText { verb: "TEXTURE", .. })
        }),
        (Command::Snap(SnapTarget::File(":".into())), |e| {
            matches!(e, EncodeError::NoText { verb: "SNAP", .. })
        }),
        (Command::Material(Box::new(Material { name: "x".into(), ..Material::default() })), |e| {
            matches!(e, EncodeError::NoText { verb: "MATERIAL", .. })
        }),
    ];
    for (command, is_right) in cases {
        let mut bytes = b"before".to_vec();
        let error = encode(&command, &mut bytes).unwrap_err();
        assert!(is_right(&error), "{command:?}: {error:?}");
        assert_eq!(bytes, b"before");
    }
}
