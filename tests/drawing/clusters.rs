//! Meshes of many faces by the fast path and by the plain one, from all directions: which clusters
//! are culled, and where vertices land.
//!
//! Guards against an unusual view (mirrored, slanted, far away, tiny) that loses a face or moves a
//! corner.

use crate::fast_forms::from_env;
use fbptr::memory::{DepthFormat, PickBuffer, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, RenderPath, Renderer, Target};
use fbptr::scene::{
    Camera, Cull, Geometry, LookAt, Material, Mesh, ObliqueKind, Projection, Viewport, ViewportRule, shapes,
};
use glam::{DMat3, DMat4, DQuat, DVec3};
use proptest::prelude::*;

/// Size of the frame in pixels.
const SIZE: [u32; 2] = [150, 110];

/// Largest error of a depth of the fast path: closer to the far plane it may round to the depth that
/// the memory is cleared to, in one path alone.
const DEPTH_ERROR: f64 = 4e-7;

/// Counts of a draw, and the depth of each pixel that a face is seen at; or the error.
type Shown = Result<(DrawStats, Vec<Option<f64>>), String>;

fn draw(path: RenderPath, call: &DrawCall<'_>, format: DepthFormat) -> Shown {
    let [width, height] = SIZE;
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, mut ids) = (None, PickBuffer::new(width, height));
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: Some(&mut ids) };
    let mut renderer = Renderer::new(RenderOptions { path, ..RenderOptions::default() });
    let stats = renderer.draw(&mut target, call).map_err(|e| e.to_string())?;
    let depth = depth.ok_or("there is no depth memory")?;
    let at = |i: u32| {
        let (x, y) = ((i % width) as i32, (i / width) as i32);
        ids.get(x, y).and(depth.z(x, y))
    };
    Ok((stats, (0..width * height).map(at).collect()))
}

/// Faces around a corner of the knot. Where a corner decides whether faces are outside, and one path
/// rounds it to the other side, all of them are counted differently.
const FACES_AROUND_CORNER: u64 = 6;

/// Draws by both paths and verifies equal counts and coverage.
///
/// A corner beyond the far plane by less than an f32 tells apart, or within 1/65536 pixel of the line
/// one pixel beside the view, may have its faces counted as drawn or culled by the fast path, and as
/// outside by the plain one. A pixel that one path alone shows is at the far plane, where the depth
/// test decides by rounding.
fn both_paths_agree(call: &DrawCall<'_>, format: DepthFormat) -> Option<DrawStats> {
    let (fast, plain) = (draw(RenderPath::Fast, call, format), draw(RenderPath::Plain, call, format));
    let (fast, plain) = match (fast, plain) {
        (Ok(fast), Ok(plain)) => (fast, plain),
        (fast, plain) => {
            assert_eq!(fast.err(), plain.err());
            return None;
        }
    };
    let kinds = |s: &DrawStats| [s.faces_drawn, s.faces_empty, s.faces_culled, s.faces_outside];
    let counts = |s: &DrawStats| [s.faces, kinds(s).iter().sum(), s.pixels_tested];
    assert_eq!(counts(&fast.0), counts(&plain.0));
    let [fast_kinds, plain_kinds] = [&fast, &plain].map(|shown| kinds(&shown.0));
    let is_close = fast_kinds.iter().zip(plain_kinds).all(|(f, p)| f.abs_diff(p) <= FACES_AROUND_CORNER);
    assert!(is_close, "drawn, empty, culled, outside: {fast_kinds:?} and {plain_kinds:?}");
    let is_unlike = |(fast, plain): &(&Option<f64>, &Option<f64>)| match (fast, plain) {
        (Some(z), None) | (None, Some(z)) => *z < 1.0 - DEPTH_ERROR,
        _ => false,
    };
    assert_eq!(fast.1.iter().zip(&plain.1).filter(is_unlike).count(), 0);
    Some(fast.0)
}

fn knot() -> Mesh {
    shapes::knot(72, 16).expect("a knot")
}

/// Returns flat faces about as large as `side`, rotated at random: many almost edge-on, alone in
/// their clusters and with others.
fn slivers(seed: u64, side: f64, flatness: f64) -> Mesh {
    use fbptr::scene::{Corner, NONE};
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut mesh = Mesh::default();
    for group in 0..80u32 {
        let turn = DMat3::from_quat(DQuat::from_euler(
            glam::EulerRot::XYZ,
            next() * std::f64::consts::PI,
            next() * std::f64::consts::PI,
            0.0,
        ));
        let at = DVec3::new(next(), next(), next());
        for face in 0..16u32 {
            let about = at + turn * DVec3::new(next() * side, next() * side, next() * side * flatness);
            let corners = [0, 1, 2].map(|k| {
                let angle = f64::from(k) * 2.1 + next();
                let p = DVec3::new(angle.cos(), angle.sin(), next() * flatness) * side;
                mesh.positions.push(about + turn * p);
                let position = (group * 16 + face) * 3 + k;
                Corner { position, normal: NONE, texcoord: NONE, color: NONE }
            });
            mesh.push_polygon(&corners, NONE);
        }
    }
    mesh
}

fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    low..high
}

fn window() -> impl Strategy<Value = [f64; 4]> {
    (number(-2.5, -0.1), number(0.1, 2.5), number(-2.5, -0.1), number(0.1, 2.5), 0..6u8).prop_map(
        |(left, right, bottom, top, kind)| match kind {
            // Mirrored, and off the axis.
            0 => [right, left, bottom, top],
            1 => [left, right, top, bottom],
            2 => [left, right + 3.0, bottom - 1.0, top],
            3 => [0.1, right + 0.2, 0.1, top + 0.2],
            _ => [left, right, bottom, top],
        },
    )
}

fn projection() -> impl Strategy<Value = Projection> {
    let near_far = (number(0.01, 2.5), number(3.0, 9.0));
    (0..9u8, window(), near_far, number(0.1, 2.6)).prop_map(|(kind, window, (near, far), angle_rad)| {
        // In perspective an f32 resolves few depths near the far plane: the fast path counts a
        // small face just beyond it as drawn.
        let far = if matches!(kind, 0..=3 | 8) { far * 10.0 } else { far };
        match kind {
            0 | 1 => Projection::Perspective { fov_rad: angle_rad, near, far, on_smaller_side: kind == 1 },
            2 => Projection::Plane { d: angle_rad, near, far },
            3 => Projection::Frustum { window: window.map(|w| w * near * 0.4), near, far },
            4 => Projection::Ortho { window, near, far },
            5 => Projection::Oblique { kind: ObliqueKind::Cavalier, angle_rad, window, near, far },
            6 => Projection::Isometric { window, near, far },
            7 => Projection::PseudoIsometric { window, near: -4.0, far },
            _ => Projection::Window {
                vrp: DVec3::new(0.1, 0.2, 0.3),
                p: DVec3::new(angle_rad, 0.4, 4.0),
                vup: DVec3::Y,
                center: [window[0] * 0.2, window[3] * 0.2],
                half: [window[1], window[3]],
                dp: near + 0.5,
                near,
                far,
            },
        }
    })
}

fn viewport() -> impl Strategy<Value = Viewport> {
    let [width, height] = SIZE;
    (0..4u8, -40i32..60, -40i32..60, 1u32..220, 1u32..180, any::<bool>()).prop_map(
        move |(kind, x, y, w, h, centres)| {
            let rule = if centres { ViewportRule::Centres } else { ViewportRule::Corners };
            match kind {
                0 => Viewport { x, y, width: w, height: h, rule },
                _ => Viewport { x: 0, y: 0, width, height, rule },
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(from_env("CLUSTER_CASES", 300)))]
    #[test]
    fn both_paths_agree_from_everywhere(
        turn in prop::array::uniform3(-3.2f64..3.2),
        scale in prop::array::uniform3(prop_oneof![-2.0f64..-0.2, 0.2f64..2.0, Just(1.0)]),
        size in prop::sample::select(vec![1.0, 1.0, 1.0, 1e-22, 1e-12, 1e9, 1e18]),
        far_away in prop::sample::select(vec![0.0, 0.0, 3.0, 1e3, 1e6]),
        eye in prop::array::uniform3(-5.0f64..5.0),
        (projection, viewport) in (projection(), viewport()),
        (cull, format) in (0..5u8, 0..4u8),
        (mesh, flatness, side) in (0u64..1000, prop::sample::select(vec![0.0, 1e-4, 0.02]), prop::sample::select(vec![0.02, 0.1, 0.6])),
    ) {
        let mut mesh = if mesh.is_multiple_of(2) { knot() } else { slivers(mesh, side, flatness) };
        mesh.normals.clear();
        for corner in &mut mesh.corners {
            corner.normal = fbptr::scene::NONE;
        }
        mesh.positions.iter_mut().for_each(|p| *p *= size);
        let away = DVec3::new(far_away, -far_away, 0.5 * far_away);
        let model = DMat4::from_translation(away)
            * DMat4::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]))
            * DMat4::from_scale(DVec3::from_array(scale) / size);
        let look_at = LookAt { eye: DVec3::from_array(eye) + away, reference: away, up: DVec3::Y };
        let geometry = Geometry { mesh, textures: Vec::new() };
        let [width, height] = SIZE;
        let material = Material::default();
        let call = DrawCall {
            model,
            camera: Camera { look_at, projection },
            viewport,
            cull: [Cull::Back, Cull::Back, Cull::Back, Cull::Front, Cull::None][cull as usize],
            ..DrawCall::new(&geometry, &material, width, height)
        };
        let formats = [DepthFormat::F32, DepthFormat::F32, DepthFormat::Reversed, DepthFormat::U16];
        both_paths_agree(&call, formats[format as usize]);
    }
}

/// An edge-on face across the near plane: the centre of one pixel lies beside it, where its plane
/// is before the near plane and its nearest point behind.
#[test]
fn a_pixel_beside_a_face_across_the_near_plane_is_decided_alike() {
    let turn =
        DQuat::from_euler(glam::EulerRot::XYZ, 2.94434715025621, -3.0096642224609362, 1.9413474536158226);
    let scale = DVec3::new(-0.28434525489217144, -1.6337470244104293, -0.2561055071710803);
    let projection = Projection::Oblique {
        kind: ObliqueKind::Cavalier,
        angle_rad: 0.5208980362501114,
        window: [-0.8492065646135962, 0.7738648695252266, -0.7365155129610936, 1.9087374786072389],
        near: 2.3061244401067076,
        far: 3.0,
    };
    let eye = DVec3::new(-1.854972005880202, 0.38490673675389275, -0.6579608113051009);
    let mut mesh = slivers(117, 0.02, 0.0);
    mesh.normals.clear();
    let geometry = Geometry { mesh, textures: Vec::new() };
    let material = Material::default();
    let call = DrawCall {
        model: DMat4::from_quat(turn) * DMat4::from_scale(scale),
        camera: Camera { look_at: LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y }, projection },
        viewport: Viewport { x: 0, y: 0, width: 142, height: 3, rule: ViewportRule::Corners },
        ..DrawCall::new(&geometry, &material, SIZE[0], SIZE[1])
    };
    for format in [DepthFormat::F32, DepthFormat::Reversed, DepthFormat::U16] {
        assert!(both_paths_agree(&call, format).is_some_and(|stats| stats.pixels_tested > 0));
    }
}

/// A pixel whose depth is less than an f32's half step before the far plane: it rounds to 1, which is
/// not in front of the cleared depth, in the plain path alone.
#[test]
fn a_pixel_on_the_far_plane_is_tested_by_both_paths() {
    let turn =
        DQuat::from_euler(glam::EulerRot::XYZ, -0.5504535824452511, -2.626798587326556, 0.8107015896116783);
    let projection = Projection::Ortho {
        window: [2.493160659629819, -1.9973259929516018, -0.3344328975286584, 0.4044955216920015],
        near: 0.01,
        far: 4.829139195077896,
    };
    let eye = DVec3::new(2.393489506687668, -4.228007891321803, 1.0445416602510242);
    let geometry = Geometry { mesh: knot(), textures: Vec::new() };
    let material = Material::default();
    let call = DrawCall {
        model: DMat4::from_quat(turn) * DMat4::from_scale(DVec3::new(1.0, 0.9883140515310312, 1.0)),
        camera: Camera { look_at: LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y }, projection },
        viewport: Viewport { x: 0, y: 0, width: SIZE[0], height: SIZE[1], rule: ViewportRule::Centres },
        cull: Cull::Back,
        ..DrawCall::new(&geometry, &material, SIZE[0], SIZE[1])
    };
    for format in [DepthFormat::F32, DepthFormat::Reversed, DepthFormat::U16] {
        assert!(both_paths_agree(&call, format).is_some_and(|stats| stats.pixels_tested == 11_087));
    }
}
