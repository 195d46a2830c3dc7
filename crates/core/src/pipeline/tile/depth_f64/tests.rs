//! Tiles that exact faces fill, compared with words computed one by one.

use super::*;
use crate::math::coverage::{PixelRect, SnappedTriangle};
use crate::memory::DepthFormat;
use crate::pipeline::plane_equation::PlaneEquation;
use crate::pipeline::tile::bins::{Bin, BinEntry, Larger};
use crate::pipeline::tile::tile_buffers::{EXACT_FACE_BIT, ID_STRIDE, Ids, NO_FACE, Tile};
use crate::pipeline::tile::traverse::RasterKernel;
use crate::simd::Level;
use crate::truth::scenes::Random;

const TILE: PixelRect = PixelRect { x0: 128, y0: 32, x1: 256, y1: 64 };
const WIDTH: usize = 384;

/// Returns a face around the tile with depth z0 at its centre, and these steps; clamped to at least
/// `low`.
fn face(number: u32, [z0, zx, zy]: [f64; 3], low: f64) -> ExactFace {
    let bounds = PixelRect { x0: 0, y0: 0, x1: WIDTH as i32, y1: 96 };
    let outline = SnappedTriangle::new([[-500.0, -500.0], [-500.0, 900.0], [1200.0, -500.0]]);
    let range = [low, 0.999];
    ExactFace {
        face: number,
        bounds,
        outlines: [Some(outline), None],
        plane: PlaneEquation {
            origin: [191.3, 47.7],
            z: [z0, zx, zy],
            complement: [1.0 - z0, -zx, -zy],
            barycentrics: [[0.0; 3]; 3],
        },
        is_between: true,
        z_range: range.map(|z| z as f32),
        exact_ranges: [range, [1.0 - range[1], 1.0 - range[0]]],
        is_rough: false,
        is_cut: false,
        corner_w: [1.0; 3],
        is_gentle: true,
        is_smooth: true,
        is_back: false,
        is_normal_flipped: false,
    }
}

/// Computes the words, faces and passed fragments of the tile, one pixel and one face after the
/// other.
fn one_by_one(format: DepthFormat, faces: &[ExactFace]) -> (Vec<u32>, Vec<i32>, u64) {
    let (mut words, mut ids, mut passed) = (Vec::new(), Vec::new(), 0);
    for y in TILE.y0..TILE.y1 {
        for x in TILE.x0..TILE.x1 {
            let (mut word, mut id) = (format.encode(1.0, 0.0), NO_FACE);
            for face in faces {
                let at = |[base, dx, dy]: [f64; 3], [low, high]: [f64; 2]| {
                    let [ox, oy] = face.plane.origin;
                    (base + (dx * (f64::from(x) + 0.5 - ox) + dy * (f64::from(y) + 0.5 - oy)))
                        .clamp(low, high)
                };
                let z = at(face.plane.z, face.exact_ranges[0]);
                let new = format.encode(z, at(face.plane.complement, face.exact_ranges[1]));
                if new < word {
                    (word, id, passed) = (new, face.face as i32 | EXACT_FACE_BIT, passed + 1);
                }
            }
            words.push(word);
            ids.push(id);
        }
    }
    (words, ids, passed)
}

/// Computes them by the kernel, with words in a frame or in a tile's own buffer.
fn by_kernel(
    level: Level,
    format: DepthFormat,
    faces: &[ExactFace],
    stride: usize,
) -> (Vec<u32>, Vec<i32>, u64) {
    let larger = |i| Larger { fragments_before: 0, tiny_before: 0, entry: BinEntry::Exact(i) };
    let bin = Bin { larger: (0..faces.len() as u32).map(larger).collect(), ..Bin::default() };
    let mut ids: Box<Ids> = Box::new([NO_FACE; _]);
    let from = if stride == WIDTH { TILE.x0 as usize } else { 0 };
    let mut words = vec![format.encode(1.0, 0.0) as i32; stride * 32];
    let PixelRect { x0, y0, x1, y1 } = TILE;
    let depth = &mut words[from..];
    let mut tile = Tile {
        x0,
        x1,
        y0,
        y1,
        width: WIDTH,
        depth,
        depth_stride: stride,
        ids: &mut ids,
        tolerance: 0.0,
        depths: None,
    };
    let encoder = DepthEncoder::of(format).expect("a format with words of f64");
    let done = level.dispatch(RasterKernel {
        bin: &bin,
        exact_faces: faces,
        corners: &[],
        test: F64Depth { encoder, corners: &[], vertices: &[] },
        tile: &mut tile,
    });
    assert_eq!(done.tested, faces.len() as u64 * 128 * 32);
    let rows = |list: &[i32], stride: usize, from: usize| -> Vec<i32> {
        list.chunks(stride).flat_map(|row| row[from..from + 128].to_vec()).collect()
    };
    let (found, seen) = (rows(&words, stride, from), rows(&ids[..], ID_STRIDE, 0));
    (found.into_iter().map(|w| w as u32).collect(), seen, done.passed)
}

#[test]
fn words_of_filled_tiles_are_those_that_the_memory_encodes() {
    let mut random = Random::new(5);
    // More than are drawn at once: level and tilted ones, some clamped to their nearest corner's
    // depth, and ties.
    let mut level_faces: Vec<ExactFace> =
        (0..30).map(|i| face(i, [random.real(0.45, 0.55), 0.0, random.real(-1e-2, 1e-2)], 0.0)).collect();
    level_faces[17] = ExactFace { face: 17, ..level_faces[3].clone() };
    let slope = |random: &mut Random| random.real(-4e-3, 4e-3);
    let mut tilted: Vec<ExactFace> = (0..30)
        .map(|i| {
            let z = [random.real(0.3, 0.7), slope(&mut random), slope(&mut random)];
            face(i, z, if i % 3 == 0 { 0.45 } else { 0.0 })
        })
        .collect();
    tilted[20] = ExactFace { face: 20, ..tilted[5].clone() };
    for format in DepthFormat::ALL.into_iter().filter(|f| DepthEncoder::of(*f).is_some()) {
        for faces in [&level_faces, &tilted] {
            let right = one_by_one(format, faces);
            let seen: std::collections::BTreeSet<i32> = right.1.iter().copied().collect();
            assert!(seen.len() > 1, "{format:?}: faces cut through each other");
            for level in Level::ALL {
                for stride in [WIDTH, ID_STRIDE] {
                    let found = by_kernel(level, format, faces, stride);
                    assert!(found == right, "{format:?} at {level:?}, {stride} words in a row");
                }
            }
        }
    }
}
