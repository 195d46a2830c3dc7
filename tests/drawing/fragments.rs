//! Faces of a pixel or two, drawn as fragments, among larger ones: the visible face where depths
//! are equal.
//!
//! Guards against a face drawn out of order, so that another than the first of several equally near
//! faces is visible, and against a pixel at the edge of a tile that is lost or drawn twice.

use fbptr::memory::{DepthFormat, PickBuffer, VideoMemory};
use fbptr::pipeline::{DrawCall, DrawStats, RenderOptions, RenderPath, Renderer, Target};
use fbptr::scene::{Camera, Corner, Geometry, LookAt, Material, Mesh, NONE, Projection};
use fbptr::simd::Level;
use glam::{DMat4, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// Frame of two columns of tiles, the second one wider, and two and a half rows.
const WIDE: [u32; 2] = [300, 80];
/// Centres of the faces, from the lower left corner: twice where four tiles meet, once on the edge
/// of two tiles, and once close to such an edge.
const PLACES: [[f64; 2]; 4] = [[128.0, 48.0], [128.0, 16.0], [40.0, 16.0], [200.0, 50.0]];

/// Returns triangles in runs of one size, each run of another, around a few centres. Those of most
/// runs are parallel to the screen, many at equal depths; those of some are slanted, each at its
/// own depth. If all runs have one length, the runs come nearer, six by six.
fn heap(seed: u64, sizes: &[f64], places: &[[f64; 2]], run_faces: Range<u32>) -> Mesh {
    let comes_nearer = run_faces.len() == 1;
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut mesh = Mesh::default();
    for run in 0..240 {
        let side = sizes[run % sizes.len()];
        for _ in 0..run_faces.start + (next() * run_faces.len() as f64) as u32 {
            let [x, y] = places[(next() * places.len() as f64) as usize];
            let (x, y) = (x + (next() - 0.5) * 12.0, y + (next() - 0.5) * 12.0);
            let leans = run % 3 == 2 && !comes_nearer;
            let z = match () {
                () if leans => -0.2 - 0.7 * next(),
                // So that every run is visible for a while.
                () if comes_nearer => -0.9 + 0.01 * (run / 6) as f64,
                () => -0.25 - 0.125 * (next() * 4.0).floor(),
            };
            let turn = next() * 6.3;
            let corners = [0.0, 2.1, 4.2].map(|k: f64| {
                let (dx, dy) = ((turn + k).cos() * side, (turn + k).sin() * side);
                let dz = if leans { 0.006 * (next() - 0.5) * side } else { 0.0 };
                mesh.positions.push(DVec3::new(x + dx, y + dy, z + dz.clamp(-0.05, 0.05)));
                let position = mesh.positions.len() as u32 - 1;
                Corner { position, normal: NONE, texcoord: NONE, color: NONE }
            });
            mesh.push_polygon(&corners, NONE);
        }
    }
    mesh
}

/// Returns separate triangles, one in a cell of `pitch` pixels, with a horizontal and a vertical
/// side through the centres of pixels: the right angle in each of the four corners, sides of all
/// lengths that fit.
fn sides_through_centres(pitch: u32, [width, height]: [u32; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    for cell in 0..(width / pitch) * (height / pitch) {
        let [column, row] = [cell % (width / pitch), cell / (width / pitch)];
        let side = f64::from(1 + cell / 4 * 11 % (pitch - 2));
        let [x, y] = [column, row].map(|v| f64::from(v * pitch) + 0.5);
        let square = [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
        let corners = [0, 1, 2].map(|k| {
            let [x, y] = square[((cell + k) % 4) as usize];
            mesh.positions.push(DVec3::new(x, y, -0.5));
            let position = mesh.positions.len() as u32 - 1;
            Corner { position, normal: NONE, texcoord: NONE, color: NONE }
        });
        mesh.push_polygon(&corners, NONE);
    }
    mesh
}

/// Returns the counts of a draw, and the face seen at each pixel.
fn draw(
    options: RenderOptions,
    mesh: &Arc<Geometry>,
    format: DepthFormat,
    [width, height]: [u32; 2],
) -> (DrawStats, Vec<Option<(u32, u32)>>) {
    let (w, h) = (f64::from(width), f64::from(height));
    let mut memory = VideoMemory::new(width, height).unwrap();
    let (mut depth, mut ids) = (None, PickBuffer::new(width, height));
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: Some(&mut ids) };
    let white = Material::default();
    let camera = Camera {
        look_at: LookAt { eye: DVec3::ZERO, reference: -DVec3::Z, up: DVec3::Y },
        projection: Projection::Ortho { window: [0.0, w, 0.0, h], near: 0.0, far: 1.0 },
    };
    let call = DrawCall {
        shared: Some(mesh),
        model: DMat4::IDENTITY,
        camera,
        ..DrawCall::new(mesh, &white, width, height)
    };
    let stats = Renderer::new(options).draw(&mut target, &call).expect("drawn");
    (stats, (0..width * height).map(|i| ids.get((i % width) as i32, (i / width) as i32)).collect())
}

/// Returns the counts that both paths share.
fn counts(s: &DrawStats) -> [u64; 5] {
    [s.faces, s.faces_drawn, s.faces_empty, s.pixels_tested, s.pixels_written]
}

#[test]
fn the_files_first_of_equally_near_faces_is_seen_whatever_its_size() {
    // Frame size, centres, faces per run, least number of visible pixels, face sizes.
    type Case = ([u32; 2], &'static [[f64; 2]], Range<u32>, u64, &'static [f64]);
    let cases: [Case; 5] = [
        (WIDE, &PLACES, 1..41, 200, &[0.6]),
        (WIDE, &PLACES, 1..41, 200, &[0.5, 1.0]),
        (WIDE, &PLACES, 1..41, 1000, &[0.6, 2.5, 0.7, 12.0, 0.6, 40.0]),
        (WIDE, &PLACES, 1..41, 1000, &[1.2, 0.4, 3.0, 0.6, 200.0, 0.6]),
        // Faces that fill the only tile, with only fragments between them where vectors are narrow.
        ([16, 5], &[[8.0, 2.5]], 12..13, 80, &[0.6, 200.0]),
    ];
    for (seed, (size, places, run_faces, least, sizes)) in cases.into_iter().enumerate() {
        let mesh =
            Arc::new(Geometry { mesh: heap(seed as u64 + 1, sizes, places, run_faces), textures: vec![] });
        for format in DepthFormat::ALL {
            let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
            let plain = draw(plain, &mesh, format, size);
            assert!(plain.0.pixels_tested > plain.0.pixels_written && plain.0.pixels_written >= least);
            for simd in Level::ALL.into_iter().filter(|l| l.is_available()) {
                let numbers: &[usize] = if simd == Level::best() { &[1, 3] } else { &[1] };
                for &threads in numbers {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    let pool = (threads > 1).then(|| Arc::new(pool));
                    let options = RenderOptions {
                        path: RenderPath::Fast,
                        simd: Some(simd),
                        pool,
                        ..RenderOptions::default()
                    };
                    let fast = draw(options, &mesh, format, size);
                    let what = format!("{size:?} {sizes:?} {format:?} {simd:?}, {threads} threads");
                    assert_eq!(counts(&fast.0), counts(&plain.0), "{what}");
                    assert!(fast.1 == plain.1, "{what}");
                }
            }
        }
    }
}

#[test]
fn centres_on_an_edge_belong_to_the_face_below_or_to_the_right() {
    for pitch in [4, 9, 17, 40] {
        let mesh = Arc::new(Geometry { mesh: sides_through_centres(pitch, WIDE), textures: vec![] });
        // Sides of n pixels own n columns and n rows of centres: an off-by-one would change the
        // count by n.
        let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
        let plain = draw(plain, &mesh, DepthFormat::F32, WIDE);
        assert!(plain.0.pixels_written > 500, "{pitch}: {}", plain.0.pixels_written);
        for simd in Level::ALL.into_iter().filter(|l| l.is_available()) {
            let options =
                RenderOptions { path: RenderPath::Fast, simd: Some(simd), ..RenderOptions::default() };
            let fast = draw(options, &mesh, DepthFormat::F32, WIDE);
            let differ = fast.1.iter().zip(&plain.1).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "pixels, cells of {pitch}, {simd:?}");
        }
    }
}
