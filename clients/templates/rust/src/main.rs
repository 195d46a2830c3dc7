use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;

/// Bytes of the shared file before the pixels, and places of its numbers.
const HEADER: usize = 4096;
const DOORBELL_AT: u64 = 40;

/// The window: a copy of its memory, which `present` writes to the shared file.
struct Fb {
    file: File,
    fbptr: Vec<u8>,
    width: i32,
    height: i32,
}

impl Fb {
    fn map(path: &str) -> io::Result<Fb> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let mut head = [0; 32];
        file.read_exact_at(&mut head, 0)?;
        if &head[..8] != b"FBPTRSHM" {
            return Err(io::Error::other("no shared file of fbptr"));
        }
        let number = |at: usize| i32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (width, height) = (number(16), number(20));
        let mut fbptr = vec![0; width as usize * height as usize * 4];
        file.read_exact_at(&mut fbptr, HEADER as u64)?;
        Ok(Fb { file, fbptr, width, height })
    }

    /// Writes the memory, and rings the doorbell.
    fn present(&self) -> io::Result<()> {
        self.file.write_all_at(&self.fbptr, HEADER as u64)?;
        let mut rings = [0; 8];
        self.file.read_exact_at(&mut rings, DOORBELL_AT)?;
        self.file.write_all_at(&(u64::from_le_bytes(rings) + 1).to_le_bytes(), DOORBELL_AT)
    }
}

/// Sets the pixel at column x and row y, counted from the upper left, to 0xRRGGBB.
fn put_pixel(fb: &mut Fb, x: i32, y: i32, color: u32) {
    if (0..fb.width).contains(&x) && (0..fb.height).contains(&y) {
        let at = (y * fb.width + x) as usize * 4;
        let [_, red, green, blue] = color.to_be_bytes();
        fb.fbptr[at..at + 4].copy_from_slice(&[red, green, blue, 255]);
    }
}

/// Draws a line, both ends lit (Bresenham).
fn draw_line(fb: &mut Fb, [mut x0, mut y0]: [i32; 2], [x1, y1]: [i32; 2], color: u32) {
    let (dx, dy) = ((x1 - x0).abs(), -(y1 - y0).abs());
    let (sx, sy) = (if x0 < x1 { 1 } else { -1 }, if y0 < y1 { 1 } else { -1 });
    let mut error = dx + dy;
    loop {
        put_pixel(fb, x0, y0, color);
        if (x0, y0) == (x1, y1) {
            return;
        }
        let twice = 2 * error;
        if twice >= dy {
            error += dy;
            x0 += sx;
        }
        if twice <= dx {
            error += dx;
            y0 += sy;
        }
    }
}

/// Draws a triangle's three lines.
fn draw_triangle(fb: &mut Fb, [a, b, c]: [[i32; 2]; 3], color: u32) {
    draw_line(fb, a, b, color);
    draw_line(fb, b, c, color);
    draw_line(fb, c, a, color);
}

/// Draws the triangles of a mesh: x to the right, y up; 3 units are as high as the window.
fn draw_mesh(fb: &mut Fb, vertices: &[[f64; 3]], faces: &[[usize; 3]], color: u32) {
    for face in faces {
        let (width, height) = (fb.width, f64::from(fb.height));
        let middle = [f64::from(width / 2), f64::from(fb.height / 2)];
        let at = face.map(|k| {
            let [x, y, _] = vertices[k];
            [(middle[0] + x * height / 3.0) as i32, (middle[1] - y * height / 3.0) as i32]
        });
        draw_triangle(fb, at, color);
    }
}

fn main() -> io::Result<()> {
    let octahedron = [
        [1.0, 0.25, 0.0],
        [-1.0, -0.25, 0.0],
        [0.125, 1.0, 0.0],
        [-0.125, -1.0, 0.0],
        [0.5, -0.375, 1.0],
        [-0.5, 0.375, -1.0],
    ];
    let faces =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let path = std::env::args().nth(1).unwrap_or_else(|| "/tmp/fb".to_owned());
    let mut fb = Fb::map(&path)?;
    let (width, height) = (fb.width, fb.height);
    put_pixel(&mut fb, 5, 5, 0xffffff);
    draw_line(&mut fb, [0, 0], [width - 1, height - 1], 0x404040);
    draw_triangle(&mut fb, [[20, 100], [120, 60], [80, 180]], 0xff8000);
    draw_mesh(&mut fb, &octahedron, &faces, 0x40c0ff);
    fb.present()
}
