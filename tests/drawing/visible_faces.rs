//! The visible face of each pixel within a draw: that of the plain path, also where two faces are
//! closer than the error of their depths in f32.
//!
//! Guards against a fast path that shows the face behind.

use super::fast_path::with;
use fbptr::load;
use fbptr::memory::{DepthFormat, DepthMemory, MemoryBudget, PickBuffer, VideoMemory};
use fbptr::pipeline::{
    CoarseDepth, DrawCall, PipelineError, Preemption, RenderOptions, RenderPath, Renderer, Target,
    TargetOwner,
};
use fbptr::scene::{
    Camera, Corner, Cull, Geometry, LookAt, Material, Mesh, NONE, Projection, ShadeMode, shapes,
};
use fbptr::simd::Level;
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// A mesh and the states of its draw.
struct Subject {
    name: &'static str,
    geometry: Geometry,
    model: DMat4,
    camera: Camera,
    cull: Cull,
    size: [u32; 2],
}

/// A frame with a pick buffer.
struct Frame {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    ids: PickBuffer,
}

impl Frame {
    fn new([width, height]: [u32; 2]) -> Frame {
        let memory = VideoMemory::new(width, height).unwrap();
        Frame { memory, depth: None, ids: PickBuffer::new(width, height) }
    }

    /// Draws a call, changed by `set`.
    fn call(
        &mut self,
        renderer: &mut Renderer,
        geometry: &Geometry,
        set: impl Fn(&mut DrawCall<'_>),
    ) -> Result<(), PipelineError> {
        let (width, height) = (self.memory.width(), self.memory.height());
        let (memory, depth, ids) = (&mut self.memory, &mut self.depth, Some(&mut self.ids));
        let mut target = Target { memory, depth, depth_format: DepthFormat::F32, ids };
        let material = Material::default();
        let mut call =
            DrawCall { shade: ShadeMode::Flat, ..DrawCall::new(geometry, &material, width, height) };
        set(&mut call);
        renderer.draw(&mut target, &call).map(|_| ())
    }

    /// Draws a geometry from a camera.
    fn draw(&mut self, renderer: &mut Renderer, name: u32, geometry: &Geometry, camera: Camera) {
        self.call(renderer, geometry, |call| {
            (call.name, call.camera, call.cull) = (name, camera, Cull::None);
        })
        .unwrap();
    }

    /// Returns name and triangle of each pixel.
    fn visible(&self) -> Vec<Option<(u32, u32)>> {
        let (width, height) = (self.memory.width(), self.memory.height());
        (0..width * height).map(|i| self.ids.get((i % width) as i32, (i / width) as i32)).collect()
    }
}

/// Returns name and triangle of each pixel; `None` if the draw is refused.
fn try_visible(renderer: &mut Renderer, subject: &Subject) -> Option<Vec<Option<(u32, u32)>>> {
    let mut frame = Frame::new(subject.size);
    let drawn = frame.call(renderer, &subject.geometry, |call| {
        (call.camera, call.model, call.cull) = (subject.camera, subject.model, subject.cull);
    });
    drawn.ok().map(|()| frame.visible())
}

/// Returns name and triangle of each pixel.
fn visible(renderer: &mut Renderer, subject: &Subject) -> Vec<Option<(u32, u32)>> {
    try_visible(renderer, subject).unwrap()
}

fn look(eye: DVec3, near: f64, far: f64) -> Camera {
    Camera {
        look_at: LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y },
        projection: Projection::Perspective {
            fov_rad: 60f64.to_radians(),
            near,
            far,
            on_smaller_side: false,
        },
    }
}

fn of(mesh: Mesh) -> Geometry {
    Geometry { mesh, textures: Vec::new() }
}

/// Adds a sheet of `side` x `side` squares of two triangles: the corners are at `at(u, v)`.
fn add_sheet(mesh: &mut Mesh, side: u32, at: impl Fn(f64, f64) -> DVec3) {
    let first = mesh.positions.len() as u32;
    for j in 0..=side {
        for i in 0..=side {
            mesh.positions.push(at(f64::from(i) / f64::from(side), f64::from(j) / f64::from(side)));
        }
    }
    let corner = |i: u32, j: u32| Corner {
        position: first + j * (side + 1) + i,
        normal: NONE,
        texcoord: NONE,
        color: NONE,
    };
    for j in 0..side {
        for i in 0..side {
            mesh.push_polygon(&[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)], NONE);
            mesh.push_polygon(&[corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)], NONE);
        }
    }
}

/// Returns sheets through each other, each `apart` of their distance from the eye off the plane
/// between them.
fn sheet_meshes(sides: [u32; 2], eye: f64, apart: f64) -> [Mesh; 2] {
    [(sides[0], -1.0), (sides[1], 1.0)].map(|(side, sign)| {
        let (mut mesh, half) = (Mesh::default(), eye * 0.5);
        add_sheet(&mut mesh, side, |u, v| {
            let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            let bump = (7.0 * x).sin() * (5.0 * y).cos();
            DVec3::new(x, y, 0.3 * x + 0.2 * y) * half + DVec3::Z * (sign * bump * apart * eye)
        });
        mesh
    })
}

/// Returns a mesh with the faces of both meshes, a few of one after a few of the other.
fn interleaved(meshes: &[Mesh; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    let firsts = meshes.each_ref().map(|m| {
        mesh.positions.extend(&m.positions);
        (mesh.positions.len() - m.positions.len()) as u32
    });
    let faces = |k: usize| meshes[k].triangles.len().div_ceil(37);
    for run in 0..faces(0).max(faces(1)) {
        for (own, first) in meshes.iter().zip(firsts) {
            for triangle in own.triangles.iter().skip(run * 37).take(37) {
                let corner = |c: u32| {
                    let position = first + own.corners[c as usize].position;
                    Corner { position, normal: NONE, texcoord: NONE, color: NONE }
                };
                mesh.push_polygon(&triangle.map(corner), NONE);
            }
        }
    }
    mesh
}

/// Returns two sheets as one mesh.
fn sheets(name: &'static str, sides: [u32; 2], eye: f64, apart: f64, [near, far]: [f64; 2]) -> Subject {
    let mesh = interleaved(&sheet_meshes(sides, eye, apart));
    let (model, camera) = (DMat4::IDENTITY, look(DVec3::Z * eye, near, far));
    Subject { name, geometry: of(mesh), model, camera, cull: Cull::None, size: [320, 240] }
}

fn knot(name: &'static str, steps: [u32; 2], cull: Cull) -> Subject {
    let model = DMat4::from_rotation_x(0.3) * DMat4::from_rotation_y(0.4);
    let mesh = shapes::knot(steps[0], steps[1]).unwrap();
    Subject {
        name,
        geometry: of(mesh),
        model,
        camera: look(DVec3::Z * 5.2, 1.0, 10.0),
        cull,
        size: [960, 720],
    }
}

fn suzanne(name: &'static str, cull: Cull, near: f64, far: f64) -> Subject {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes/suzanne-sphere/monkey_head2.obj");
    let loaded = load::obj::parse(&std::fs::read(path).unwrap(), &mut |_| None, "suzanne").unwrap();
    let camera = look(DVec3::new(0.9, 0.5, 2.6), near, far);
    Subject { name, geometry: loaded.geometry, model: DMat4::IDENTITY, camera, cull, size: [960, 720] }
}

/// Returns the sheets, of faces of each kind that the tile renderer knows.
fn close_sheets() -> Vec<Subject> {
    vec![
        sheets("one pixel a face", [400, 390], 5.0, 1e-7, [1.0, 10.0]),
        sheets("a few pixels a face", [150, 130], 5.0, 1e-7, [1.0, 10.0]),
        sheets("some of them farther apart", [150, 130], 5.0, 1e-5, [1.0, 10.0]),
        sheets("small faces", [23, 21], 5.0, 1e-7, [1.0, 10.0]),
        sheets("faces set up in f64", [2, 3], 5.0, 1e-7, [1.0, 10.0]),
        sheets("far away", [60, 50], 300.0, 1e-3, [0.01, 1000.0]),
        sheets("far away, faces set up in f64", [3, 2], 300.0, 1e-3, [0.01, 1000.0]),
        filled(),
        repeated("small faces, each four times", [23, 21]),
        repeated("faces set up in f64, each four times", [2, 3]),
        level(),
    ]
}

/// Returns sheets through each other of which each face is there several times: with the same corners
/// in another order, and with corners of its own at the same places.
fn repeated(name: &'static str, sides: [u32; 2]) -> Subject {
    let mut subject = sheets(name, sides, 5.0, 1e-7, [1.0, 10.0]);
    let once = std::mem::take(&mut subject.geometry.mesh);
    let mut mesh = Mesh { positions: once.positions.clone(), ..Mesh::default() };
    let corner = |position: u32| Corner { position, normal: NONE, texcoord: NONE, color: NONE };
    for (i, triangle) in once.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|c| once.corners[c as usize].position);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([b, c, a].map(|p| once.positions[p as usize]));
        let own = [first, first + 1, first + 2];
        for order in [[a, b, c], [c, a, b], own, [b, a, c]].into_iter().cycle().skip(i % 4).take(4) {
            mesh.push_polygon(&order.map(corner), NONE);
        }
    }
    Subject { geometry: of(mesh), ..subject }
}

/// Returns level triangles, many of the same or nearly the same depth.
fn level() -> Subject {
    let mut mesh = Mesh::default();
    for k in 0..200u32 {
        let z = f64::from(k * 7 % 11) * 1e-8;
        let (sin, cos) = (f64::from(k) * 0.7).sin_cos();
        let corner = |x: f64, y: f64| DVec3::new(x * cos - y * sin, x * sin + y * cos, z);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([corner(-4.0, -2.0), corner(4.0, -2.0), corner(0.3, 2.5)]);
        let corner = |k: u32| Corner { position: first + k, normal: NONE, texcoord: NONE, color: NONE };
        mesh.push_polygon(&[corner(0), corner(1), corner(2)], NONE);
    }
    let (name, model) = ("level faces", DMat4::IDENTITY);
    let camera = look(DVec3::Z * 3.0, 1.0, 10.0);
    Subject { name, geometry: of(mesh), model, camera, cull: Cull::None, size: [320, 240] }
}

/// Returns planes through each other that fill the frame.
fn filled() -> Subject {
    let mut mesh = Mesh::default();
    for k in 0..60u32 {
        let slope = |i: u32| f64::from((k * i) % 17) * 1e-8 - 8e-8;
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1e-8 * f64::from(k % 5) + slope(5) * x + slope(7) * y);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([corner(-40.0, -40.0), corner(40.0, -40.0), corner(0.0, 60.0)]);
        let corner = |k: u32| Corner { position: first + k, normal: NONE, texcoord: NONE, color: NONE };
        mesh.push_polygon(&[corner(0), corner(1), corner(2)], NONE);
    }
    let camera = look(DVec3::Z * 3.0, 1.0, 10.0);
    let (name, model) = ("faces that fill tiles", DMat4::IDENTITY);
    Subject { name, geometry: of(mesh), model, camera, cull: Cull::None, size: [320, 240] }
}

/// Returns meshes with some pixels of close faces.
fn models() -> Vec<Subject> {
    vec![
        suzanne("Suzanne", Cull::None, 0.1, 100.0),
        suzanne("Suzanne, near and far apart", Cull::Back, 0.001, 1000.0),
        knot("W1", [500, 70], Cull::Back),
        knot("a knot of slivers", [2000, 9], Cull::None),
    ]
}

fn plain() -> Renderer {
    Renderer::new(RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() })
}

/// Returns the number of pixels that differ.
fn unlike<T: PartialEq>(a: &[T], b: &[T]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Returns how many pixels of a subject show another face than the plain path's, for each of these
/// renderers for which some do.
fn wrong(subject: &Subject, renderers: &[(Level, usize, CoarseDepth)]) -> Vec<String> {
    let right = visible(&mut plain(), subject);
    assert!(right.iter().flatten().count() > 40_000, "{}", subject.name);
    let mut wrong = Vec::new();
    for &(level, threads, coarse) in renderers {
        let options = RenderOptions { coarse, ..with(level, threads).options().clone() };
        let unlike = unlike(&visible(&mut Renderer::new(options), subject), &right);
        if unlike > 0 {
            wrong.push(format!("{} {level:?} {threads} {coarse:?}: {unlike}", subject.name));
        }
    }
    wrong
}

#[test]
fn close_faces_of_a_draw_are_those_of_the_plain_path() {
    let mut renderers = vec![(Level::best(), 1, CoarseDepth::On)];
    for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
        renderers.extend([(level, 1, CoarseDepth::Off), (level, 3, CoarseDepth::On)]);
    }
    let wrong: Vec<_> = close_sheets().iter().flat_map(|subject| wrong(subject, &renderers)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn models_show_the_faces_of_the_plain_path() {
    let renderers = [(Level::best(), 2, CoarseDepth::Off)];
    let wrong: Vec<_> = models().iter().flat_map(|subject| wrong(subject, &renderers)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Always wants its target back, and leaves it where it is.
struct Impatient;

impl TargetOwner for Impatient {
    fn is_due(&self) -> bool {
        true
    }
    fn release(&self, _: &mut Target) {}
    fn acquire(&self, _: &mut Target) {}
}

/// A tile is then visited several times.
#[test]
fn close_faces_are_decided_across_slices_and_pieces_of_a_draw() {
    let subject = sheets("a few pixels a face", [150, 130], 5.0, 1e-7, [1.0, 10.0]);
    let right = visible(&mut plain(), &subject);
    for threads in [1, 3] {
        let mut renderer = with(Level::best(), threads);
        renderer.set_preemption(Preemption::by(Arc::new(Impatient)));
        assert_eq!(unlike(&visible(&mut renderer, &subject), &right), 0, "preempted, {threads} threads");
    }
    // The smallest budgets that suffice.
    let mut pieces = 0;
    for megabytes in 8..200u64 {
        let mut renderer = with(Level::best(), 2);
        renderer.set_budget(&MemoryBudget::new(megabytes << 20));
        if let Some(found) = try_visible(&mut renderer, &subject) {
            assert_eq!(unlike(&found, &right), 0, "{megabytes} MiB");
            pieces += 1;
        }
        if pieces == 3 {
            return;
        }
    }
    panic!("no budget suffices");
}

/// In two draws the f32 depths decide: so many pixels need more.
#[test]
fn f32_depths_alone_show_the_other_face_in_many_pixels() {
    for (sides, eye, apart, [near, far]) in [
        ([150, 130], 5.0, 1e-7, [1.0, 10.0]),
        ([23, 21], 5.0, 1e-7, [1.0, 10.0]),
        ([60, 50], 300.0, 1e-3, [0.01, 1000.0]),
    ] {
        let geometries = sheet_meshes(sides, eye, apart).map(of);
        let [fast, right] = [Renderer::default(), plain()].map(|mut renderer| {
            let mut frame = Frame::new([320, 240]);
            for (name, geometry) in (0..).zip(&geometries) {
                frame.draw(&mut renderer, name, geometry, look(DVec3::Z * eye, near, far));
            }
            frame.visible()
        });
        let unlike = unlike(&fast, &right);
        assert!(unlike > 2_000, "{sides:?}: {unlike}");
    }
}
