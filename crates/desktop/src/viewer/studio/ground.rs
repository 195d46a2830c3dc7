//! The ground under a model: a grid that fades with the distance, and a contact shadow.
//!
//! In: the plane y = floor in world space, a camera, a frame that holds what lies behind. Out: the
//! frame with the ground over it. The model stands on the plane, and the eye is above it, so what
//! is drawn later covers the ground wherever both are seen: no depth is needed. From below nothing
//! is drawn.
//!
//! Formula: with M = projection * view, a point of the plane has the clip coordinates
//! M (X, floor, Z, 1). The rows x, y, w of M make a 3x3 matrix H with H (X, Z, 1) = w (x, y, 1) in
//! NDC, so (X, Z, 1) / w = H^-1 (x, y, 1): linear over the screen, one division a pixel. A grid
//! line covers a pixel by its distance in pixels, that is by the distance on the ground over the
//! length of the gradient of X (or Z) on the screen.

use super::contact_shadow::ContactShadow;
use fbptr_core::executor::Executor;
use fbptr_core::memory::VideoMemory;
use fbptr_core::scene::{Camera, Mesh};
use glam::{DMat3, DVec3};

/// Colour of the grid's lines: the lesser text of docs/look.md.
const LINE: [f32; 3] = [128.0, 140.0, 165.0];
/// Opacity of the lines below the model.
const OPACITY: f32 = 0.5;
/// Distance at which the grid has faded, in radii of the model.
const FADE: f64 = 4.0;
/// Part of the ground's light that the darkest shadow takes.
const SHADOW: f32 = 0.75;

/// The ground under one model.
pub(in crate::viewer) struct Ground {
    floor: f64,
    middle: [f64; 2],
    radius: f64,
    spacing: f64,
    shadow: ContactShadow,
}

impl Ground {
    /// Creates the ground under a mesh; `None` for a mesh without extent.
    pub fn under(mesh: &Mesh) -> Option<Ground> {
        let (low, high) = mesh.bounds()?;
        let size = high - low;
        let radius = size.length() / 2.0;
        if !(radius > 0.0 && radius < 1e30 && low.is_finite() && high.is_finite()) {
            return None;
        }
        Some(Ground {
            floor: low.y,
            middle: [(low.x + high.x) / 2.0, (low.z + high.z) / 2.0],
            radius,
            spacing: round_step(radius / 2.5),
            shadow: ContactShadow::of(mesh, (low, high)),
        })
    }

    /// Draws the ground over what lies behind it, as `camera` sees it.
    pub fn paint(&self, memory: &mut VideoMemory, camera: &Camera, pool: &Executor) {
        let (width, height) = (memory.width() as usize, memory.height() as usize);
        let Some(screen) = Screen::new(self, camera, [width, height]) else { return };
        let paint_row = |y: usize, row: &mut [u8]| {
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                if let Some((grid, dark)) = self.look(&screen, screen.at(x, y)) {
                    for (byte, line) in pixel.iter_mut().zip(LINE) {
                        let behind = f32::from(*byte) * (1.0 - SHADOW * dark);
                        *byte = (behind + (line - behind) * grid * (1.0 - dark) + 0.5) as u8;
                    }
                }
            }
        };
        pool.run(|| pool.chunks(memory.bytes_mut(), width * 4, paint_row));
    }

    /// Returns the coverage of the grid and the missing light where (X, Z, 1) / w is `place`, with
    /// X and Z from the model's middle in radii; `None` off the visible ground.
    fn look(&self, screen: &Screen, [u, v, w]: [f32; 3]) -> Option<(f32, f32)> {
        // As 1 / w of the clip coordinates: positive before the eye.
        if w <= 0.0 {
            return None;
        }
        let (x, z) = (u / w, v / w);
        let away = (x * x + z * z) / (FADE * FADE) as f32;
        if away >= 1.0 {
            return None;
        }
        let fade = (1.0 - away) * (1.0 - away);
        let line = |at: f32, axis: usize| {
            let (across, down) = (screen.across, screen.down);
            let slope = |step: [f32; 3]| (step[axis] - at * step[2]) / w;
            let (dx, dy) = (slope(across), slope(down));
            // Units of the ground for a pixel.
            let pixel = (dx * dx + dy * dy).sqrt().max(1e-12);
            let cells = (at + screen.middle[axis]) / screen.spacing;
            let off = (cells - cells.round()).abs() * screen.spacing / pixel;
            // Lines nearer to each other than four pixels are left out gently.
            let room = (screen.spacing / pixel / 4.0 - 1.0).clamp(0.0, 1.0);
            (1.0 - off).clamp(0.0, 1.0) * room
        };
        let grid = line(x, 0).max(line(z, 1)) * fade * OPACITY;
        let radius = self.radius as f32;
        let dark = self.shadow.at(x * radius + self.middle[0] as f32, z * radius + self.middle[1] as f32);
        Some((grid, dark))
    }
}

/// The ground on one screen, in radii of the model from its middle.
struct Screen {
    /// (X, Z, 1) / w at the centre of the first pixel.
    origin: [f32; 3],
    /// Its change from a pixel to the next on the right.
    across: [f32; 3],
    /// Its change from a row to the next below.
    down: [f32; 3],
    /// The model's middle, which grid lines are counted from the world's origin by.
    middle: [f32; 2],
    spacing: f32,
}

impl Screen {
    /// Returns `None` where the ground is not seen from above.
    fn new(ground: &Ground, camera: &Camera, [width, height]: [usize; 2]) -> Option<Screen> {
        let matrices = camera.matrices(width as f64 / height as f64).ok()?;
        let is_above = match matrices.is_parallel {
            true => matrices.to_viewer.y > 1e-6,
            false => matrices.eye.y > ground.floor,
        };
        if !is_above {
            return None;
        }
        let m = matrices.projection * matrices.view;
        let r = ground.radius;
        let at = DVec3::new(ground.middle[0], ground.floor, ground.middle[1]);
        let [x, y, z, w] = [m.x_axis, m.y_axis, m.z_axis, m.w_axis];
        let columns = [x * r, z * r, x * at.x + y * at.y + z * at.z + w];
        let [a, b, c] = columns.map(|column| DVec3::new(column.x, column.y, column.w));
        let h = DMat3::from_cols(a, b, c);
        if h.determinant().abs() < 1e-30 {
            return None;
        }
        let back = h.inverse();
        let (w, h) = (2.0 / width as f64, 2.0 / height as f64);
        let origin = back * DVec3::new(0.5 * w - 1.0, 1.0 - 0.5 * h, 1.0);
        let narrow = |v: DVec3| v.to_array().map(|v| v as f32);
        let screen = Screen {
            origin: narrow(origin),
            across: narrow(back.x_axis * w),
            down: narrow(back.y_axis * -h),
            middle: ground.middle.map(|v| (v / r).rem_euclid(ground.spacing / r) as f32),
            spacing: (ground.spacing / r) as f32,
        };
        let all = [screen.origin, screen.across, screen.down];
        all.as_flattened().iter().all(|v| v.is_finite()).then_some(screen)
    }

    /// Returns (X, Z, 1) / w at a pixel's centre.
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        std::array::from_fn(|i| self.origin[i] + self.down[i] * y as f32 + self.across[i] * x as f32)
    }
}

/// Rounds a positive length to 1, 2 or 5 times a power of ten.
fn round_step(length: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(length)));
    match length / unit {
        x if x < 1.5 => unit,
        x if x < 3.5 => 2.0 * unit,
        x if x < 7.5 => 5.0 * unit,
        _ => 10.0 * unit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::{LookAt, Projection, shapes};
    use fbptr_server::worker_pool;

    fn camera(eye: DVec3) -> Camera {
        let look_at = LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y };
        Camera { look_at, ..Camera::default() }
    }

    fn painted(camera: &Camera, pool: &Executor) -> Vec<u8> {
        let mesh = shapes::cuboid(DVec3::ONE).expect("a size");
        let ground = Ground::under(&mesh).expect("a size");
        let mut memory = VideoMemory::new(120, 90).expect("small");
        memory.clear([60, 60, 60, 255]);
        ground.paint(&mut memory, camera, pool);
        memory.bytes().to_vec()
    }

    #[test]
    fn lines_and_shadow_are_where_the_plane_is_and_nothing_else() {
        let camera = camera(DVec3::new(1.0, 2.0, 5.0));
        let bytes = painted(&camera, &Executor::default());
        let red = |x: usize, y: usize| bytes[(y * 120 + x) * 4];
        // A world point's pixel.
        let matrices = camera.matrices(120.0 / 90.0).expect("a camera");
        let floor = shapes::cuboid(DVec3::ONE).expect("a size").bounds().expect("points").0.y;
        let pixel = |x: f64, z: f64| {
            let clip = matrices.projection * (matrices.view * DVec3::new(x, floor, z).extend(1.0));
            let ndc = clip / clip.w;
            [((ndc.x + 1.0) * 60.0) as usize, ((1.0 - ndc.y) * 45.0) as usize]
        };
        let [x, y] = pixel(0.03, 0.03);
        assert!(red(x, y) < 45, "dark below the model: {}", red(x, y));
        let spacing = Ground::under(&shapes::cuboid(DVec3::ONE).expect("a size")).expect("one").spacing;
        let [x, y] = pixel(5.0 * spacing, 5.5 * spacing);
        assert!(red(x, y) > 62, "a line at a multiple of the spacing: {}", red(x, y));
        let [x, y] = pixel(5.5 * spacing, 5.5 * spacing);
        assert_eq!(red(x, y), 60, "nothing between lines");
        assert_eq!(red(60, 0), 60, "nothing above the horizon");
    }

    #[test]
    fn from_below_and_for_any_threads_it_is_right() {
        let above = camera(DVec3::new(1.0, 2.0, 5.0));
        let parallel = Camera {
            projection: Projection::Ortho { window: [-2.0, 2.0, -1.5, 1.5], near: -9.0, far: 9.0 },
            ..above
        };
        for camera in [above, parallel] {
            let serial = painted(&camera, &Executor::default());
            assert!(serial.iter().any(|&b| b != 60 && b != 255), "something is seen");
            assert!(serial == painted(&camera, &Executor::of_pool(worker_pool(Some(3)))));
        }
        let below = painted(&camera(DVec3::new(1.0, -2.0, 5.0)), &Executor::default());
        assert!(below.iter().all(|&b| b == 60 || b == 255));
    }
}
