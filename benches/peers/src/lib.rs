//! Shared code of the Rust peers: the exported scene, its lighting, the clock, the JSON row and the
//! picture.
//!
//! The settings are environment variables, as in `common.h`.

use std::env;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

pub const WIDTH: usize = 1920;
pub const HEIGHT: usize = 1080;
pub const LAYERS: u32 = 20;
/// 0x00RRGGBB of (0.1, 0.1, 0.15).
pub const BACKGROUND: u32 = 0x001a_1a26;

/// A vertex as stored in the mesh files.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub uv: [f32; 2],
}

fn setting(name: &str, otherwise: &str) -> String {
    env::var(name).ok().filter(|v| !v.is_empty()).unwrap_or_else(|| otherwise.to_owned())
}

fn scene_file(name: &str) -> Vec<u8> {
    let path = Path::new(&setting("PEERS_SCENE", ".")).join(name);
    fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns the corners of an exported mesh's triangles, three by three.
pub fn triangles(name: &str) -> Vec<Vertex> {
    let bytes = scene_file(name);
    let word = |i: usize| <[u8; 4]>::try_from(&bytes[4 * i..4 * i + 4]).expect("four bytes");
    let (vertex_count, triangle_count) = (u32::from_le_bytes(word(0)), u32::from_le_bytes(word(1)));
    let number = |v: usize, k: usize| f32::from_le_bytes(word(2 + 8 * v + k));
    let vertex = |v: usize| Vertex {
        position: [0, 1, 2].map(|k| number(v, k)),
        normal: [3, 4, 5].map(|k| number(v, k)),
        uv: [6, 7].map(|k| number(v, k)),
    };
    let first_index = 2 + 8 * vertex_count as usize;
    (0..3 * triangle_count as usize).map(|i| vertex(u32::from_le_bytes(word(first_index + i)) as usize)).collect()
}

/// Returns the texture as 0x00RRGGBB words, row 0 at t = 0.
pub fn texture() -> Vec<u32> {
    scene_file("texture.rgba").chunks_exact(4).map(|t| u32::from_be_bytes([0, t[0], t[1], t[2]])).collect()
}

/// Rows of a matrix that multiplies a column vector.
pub type Matrix = [[f32; 4]; 4];

pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..4).map(|k| a[r][k] * b[k][c]).sum()))
}

#[inline(always)]
pub fn apply(m: &Matrix, [x, y, z]: [f32; 3], w: f32) -> [f32; 4] {
    m.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3] * w)
}

/// Object to world space: a rotation about y by 0.4, then about x by 0.3.
pub fn model() -> Matrix {
    let ((s1, c1), (s2, c2)) = (0.3f32.sin_cos(), 0.4f32.sin_cos());
    let about_x = [[1.0, 0.0, 0.0, 0.0], [0.0, c1, -s1, 0.0], [0.0, s1, c1, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let about_y = [[c2, 0.0, s2, 0.0], [0.0, 1.0, 0.0, 0.0], [-s2, 0.0, c2, 0.0], [0.0, 0.0, 0.0, 1.0]];
    product(&about_x, &about_y)
}

/// World to clip space: the eye at (0, 0, 5.2), 60 degrees on the height, near 1, far 10.
pub fn camera() -> Matrix {
    let (near, far, cot) = (1.0f32, 10.0f32, 1.0 / (std::f32::consts::PI / 6.0).tan());
    let (a, b) = ((far + near) / (near - far), 2.0 * far * near / (near - far));
    [
        [cot * HEIGHT as f32 / WIDTH as f32, 0.0, 0.0, 0.0],
        [0.0, cot, 0.0, 0.0],
        [0.0, 0.0, a, b - 5.2 * a],
        [0.0, 0.0, -1.0, 5.2],
    ]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn unit(v: [f32; 3]) -> [f32; 3] {
    let share = 1.0 / dot(v, v).sqrt();
    v.map(|c| c * share)
}

/// Returns the colour of a point with a normal of any length; the specular term counts where N.L >
/// 0.
#[inline(always)]
pub fn lit(p: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    let n = unit(normal);
    let l = unit([3.0 - p[0], 4.0 - p[1], 5.0 - p[2]]);
    let v = unit([-p[0], -p[1], 5.2 - p[2]]);
    let d = dot(n, l);
    let r = [0, 1, 2].map(|i| 2.0 * d * n[i] - l[i]);
    let s2 = dot(r, v).max(0.0).powi(2);
    let s16 = s2 * s2 * s2 * s2 * s2 * s2 * s2 * s2;
    let shine = if d > 0.0 { 0.5 * s16 * s16 } else { 0.0 };
    [0.8, 0.4, 0.2].map(|base| base * (0.1 + 0.7 * d.max(0.0)) + shine)
}

/// Converts a colour in 0..1 to 0x00RRGGBB.
#[inline(always)]
pub fn word(color: [f32; 3]) -> u32 {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u32);
    r << 16 | g << 8 | b
}

/// Returns the colour and device depth of one of W3's layers.
pub fn layer(i: u32) -> ([f32; 3], f32) {
    let color = [i * 37, i * 91 + 40, i * 151 + 90].map(|c| (c % 256) as f32 / 255.0);
    (color, 0.95 - 0.09 * i as f32)
}

/// A line of W6.
#[derive(Clone, Copy, Debug)]
pub struct PackedLine {
    pub p0: [i16; 2],
    pub p1: [i16; 2],
    pub color: [u8; 3],
}

fn random(state: &mut u32) -> u32 {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    *state
}

/// Returns the lines and colours of fbptr's own W6.
pub fn lines(count: u32, is_short: bool) -> Vec<PackedLine> {
    let mut state = 0x1234_5678;
    let place = |r: u32| [(((r & 0xffff) * 1920) >> 16) as i16, (((r >> 16) * 1080) >> 16) as i16];
    (0..count)
        .map(|i| {
            let (a, b) = (random(&mut state), random(&mut state));
            let p0 = place(a);
            let reach = [(b % 23) as i16 - 11, ((b >> 16) % 23) as i16 - 11];
            let near = [(p0[0] + reach[0]).clamp(0, 1919), (p0[1] + reach[1]).clamp(0, 1079)];
            let [r, g, b_, _] = i.wrapping_mul(2_654_435_761).to_le_bytes();
            PackedLine { p0, p1: if is_short { near } else { place(b) }, color: [r, g, b_] }
        })
        .collect()
}

/// Calls `put` with W7's first `count` pixels.
#[inline(always)]
pub fn each_pixel(count: u32, mut put: impl FnMut(i32, i32, [u8; 3])) {
    let mut state = 0x1234_5678;
    for _ in 0..count {
        let r = random(&mut state);
        let [a, b, c, _] = r.to_le_bytes();
        put((((r & 0xffff) * 1920) >> 16) as i32, (((r >> 16) * 1080) >> 16) as i32, [a, b, c]);
    }
}

/// Returns whether PEERS_ONLY names the workload, such as W4.
pub fn is_wanted(group: &str) -> bool {
    setting("PEERS_ONLY", "W1,W2,W3,W4,W5,W6,W7").split(',').any(|g| g == group)
}

/// Times a frame as fbptr does and prints its row.
pub fn measure(peer: &str, workload: &str, mut frame: impl FnMut()) {
    let most: usize = setting("PEERS_FRAMES", "40").parse().unwrap_or(40).max(1);
    let begin = Instant::now();
    frame();
    let first = begin.elapsed().as_secs_f64() * 1e3;
    if first < 300.0 {
        (0..5).for_each(|_| frame());
    }
    let begin = Instant::now();
    // A frame that takes this long is not repeated.
    let mut times: Vec<f64> = Some(first).filter(|&t| t > 3000.0).into_iter().collect();
    while first <= 3000.0 && times.len() < most && (times.len() < 3 || begin.elapsed().as_secs() < 6) {
        let start = Instant::now();
        frame();
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let (median, min, cfg) = (times[times.len() / 2], times[0], setting("PEERS_CFG", "1T"));
    println!(
        "{{\"peer\":\"{peer}\",\"cfg\":\"{cfg}\",\"wl\":\"{workload}\",\"med_ms\":{median:.3},\"min_ms\":{min:.3},\"n\":{}}}",
        times.len()
    );
}

/// Writes 0x00RRGGBB words as the picture of a workload.
pub fn save_picture(peer: &str, workload: &str, words: &[u32]) {
    let Ok(folder) = env::var("PEERS_SHOTS") else { return };
    let path = Path::new(&folder).join(format!("{peer}_{}_{workload}.ppm", setting("PEERS_CFG", "1T")));
    let mut bytes = Vec::with_capacity(WIDTH * HEIGHT * 3 + 32);
    write!(bytes, "P6\n{WIDTH} {HEIGHT}\n255\n").expect("a Vec takes all bytes");
    bytes.extend(words.iter().flat_map(|w| [(w >> 16) as u8, (w >> 8) as u8, *w as u8]));
    fs::write(&path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}
