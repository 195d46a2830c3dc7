//! Makes payloads: meshes, textures, scenes and worlds, generated or taken from small files, and
//! mutated.

use super::data::DataProvider;
use super::words::{Extremes, Words};

const OBJS: [&[u8]; 8] = [
    include_bytes!("../../../tests/data/meshes/assimp/box.obj"),
    include_bytes!("../../../tests/data/meshes/tobj/quad.obj"),
    include_bytes!("../../../tests/data/meshes/tobj/quad_colored_merge.obj"),
    include_bytes!("../../../tests/data/meshes/tobj/lines.obj"),
    include_bytes!("../../../tests/data/meshes/assimp/number_formats.obj"),
    include_bytes!("../../../tests/data/meshes/assimp/cube_with_vertexcolors.obj"),
    include_bytes!("../../../tests/data/meshes/tinyobjloader/smoothing-normal.obj"),
    include_bytes!("../../../tests/data/meshes/tinyobjloader/line-prim.obj"),
];
const X3DS: [&[u8]; 16] = [
    include_bytes!("../../../tests/data/x3d/classic/scene.x3dv"),
    include_bytes!("../../../tests/data/x3d/classic/scene.wrl"),
    include_bytes!("../../../tests/data/x3d/lecture-003/transparent.x3d"),
    include_bytes!("../../../tests/data/x3d/lecture-003/mipmap.x3d"),
    include_bytes!("../../../tests/data/x3d/lecture-003/two_triangles.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/triangle.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/hero_primitives.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/lit_scene.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/transparent_scene.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/demos/anim_color.x3d"),
    include_bytes!("../../../tests/data/x3d/x3d-cpp/demos/anim_orientation.x3d"),
    include_bytes!("../../../tests/data/x3d/x_ite/Texturing/PixelTexture.x3d"),
    include_bytes!("../../../tests/data/x3d/x_ite/Rendering/IndexedLineSet.x3d"),
    include_bytes!("../../../tests/data/x3d/x_ite/Extrusion/Scales.x3d"),
    include_bytes!("../../../tests/data/x3d/x_ite/Shape/TwoSidedMaterial.x3d"),
    include_bytes!("../../../tests/data/x3d/x_ite/Interpolation/CoordinateInterpolator.x3d"),
];
const WORLDS: [&[u8]; 4] = [
    include_bytes!("../../../tests/data/nd-cases/c01_2to1_parallel.json"),
    include_bytes!("../../../tests/data/nd-cases/c02_2to1_radial.json"),
    include_bytes!("../../../tests/data/nd-cases/c05_3to1_cubes.json"),
    include_bytes!("../../../tests/data/nd-cases/h01_edge_on.json"),
];
pub const PICTURES: [&[u8]; 3] = [
    include_bytes!("../../../tests/data/x3d/x3d-cpp/checker.png"),
    include_bytes!("../../../tests/data/x3d/golden/lecture-003-mipmap-at-0.png"),
    include_bytes!("../../../tests/data/x3d/golden/x_ite-Rendering-Normals-at-0.png"),
];

/// Returns an OBJ file, generated, or stored and sometimes mutated.
pub fn obj(data: &mut DataProvider, extremes: Extremes) -> Vec<u8> {
    if data.below(3) > 0 {
        return made_obj(data, extremes);
    }
    let base = data.of(&OBJS);
    changed(base, data)
}

/// Returns a stored X3D file, sometimes mutated.
pub fn x3d(data: &mut DataProvider) -> Vec<u8> {
    let base = data.of(&X3DS);
    changed(base, data)
}

/// Returns a stored scene of the eye, sometimes mutated.
pub fn world(data: &mut DataProvider) -> Vec<u8> {
    let base = data.of(&WORLDS);
    changed(base, data)
}

/// Returns a stored picture, sometimes mutated.
pub fn picture(data: &mut DataProvider) -> Vec<u8> {
    let base = data.of(&PICTURES);
    changed(base, data)
}

/// Generates a few corners and faces, near the origin or at the ends of the range.
fn made_obj(data: &mut DataProvider, extremes: Extremes) -> Vec<u8> {
    let mut words = Words { data, extremes, line: String::new() };
    let corners = 3 + words.data.below(8);
    let has_more = words.data.below(4);
    for _ in 0..corners {
        words.line += "v";
        words.reals(3, 0.0, 2.0);
        if has_more == 1 {
            words.reals(3, 0.5, 0.5);
        }
        words.line += "\n";
        if has_more == 2 {
            words.line += "vt";
            words.reals(2, 0.0, 2.0).line += "\nvn";
            words.reals(3, 0.0, 1.0).line += "\n";
        }
    }
    for _ in 0..1 + words.data.below(10) {
        words.line += ["f", "f", "f", "f", "l", "p"][words.data.below(6)];
        for _ in 0..[3, 3, 4, 3, 5, 2][words.data.below(6)] {
            let corner = 1 + words.data.below(corners);
            let word = match has_more {
                2 => format!("{corner}/{corner}/{corner}"),
                _ => corner.to_string(),
            };
            words.word(&word);
        }
        words.line += "\n";
    }
    words.line.into_bytes()
}

/// Returns the bytes, in half of the cases with some of them flipped, repeated or removed, or with
/// numbers replaced.
fn changed(bytes: &[u8], data: &mut DataProvider) -> Vec<u8> {
    let mut out = bytes.to_vec();
    if data.below(2) == 0 {
        return out;
    }
    for _ in 0..1 + data.below(6) {
        if out.is_empty() {
            break;
        }
        let at = data.below(out.len().min(65_536));
        let to = (at + 1 + data.below(40)).min(out.len());
        match data.below(8) {
            0 => out[at] ^= 1 << data.below(8),
            1 => drop(out.drain(at..to)),
            2 => {
                let span = out[at..to].to_vec();
                out.splice(at..at, span);
            }
            3 => out.truncate(at),
            _ => exchange_number(&mut out, at, data),
        }
    }
    out
}

/// Replaces the first number from `at` on.
fn exchange_number(out: &mut Vec<u8>, at: usize, data: &mut DataProvider) {
    let is_digit = |b: &u8| b.is_ascii_digit() || b".-+eE".contains(b);
    let Some(start) = (at..out.len()).find(|&i| out[i].is_ascii_digit()) else { return };
    let end = (start..out.len()).find(|&i| !is_digit(&out[i])).unwrap_or(out.len());
    let extremes = Extremes { real: 2, junk: 40 };
    let mut words = Words { data, extremes, line: String::new() };
    words.real(0.0, 3.0);
    out.splice(start..end, words.line.trim_start().bytes());
}
