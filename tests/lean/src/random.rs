//! Random pictures: figures of two dimensions under meshes in random states.

use fbptr::draw2d::Blend;
use fbptr::glam::{DMat4, DVec3};
use fbptr::memory::DepthFormat;
use fbptr::pipeline::{RenderOptions, Renderer};
use fbptr::scene::{
    Attenuation, Cull, Filter, HiddenSurface, Interpolation, LightKind, Sampling, ShadeMode, Wrap, shapes,
};
use fbptr::simd::Level;
use fbptr::{Framebuffer, Light, Material, Mesh};
use std::error::Error;
use std::sync::Arc;

/// Width and height of a picture.
const SIZE: [u32; 2] = [160, 120];

/// Numbers of a linear congruential generator; whole numbers alone, so the same everywhere.
struct Random(u64);

impl Random {
    /// Returns a number below `n`.
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (((self.0 >> 32) * u64::from(n)) >> 32) as u32
    }

    /// Returns a multiple of 1/4096 in `low..high`.
    fn real(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(4096)) / 4096.0
    }

    fn point(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.real(low, high)))
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u32) as usize]
    }

    fn color(&mut self) -> [u8; 4] {
        [(); 4].map(|()| self.below(256) as u8)
    }

    fn pixel(&mut self) -> [i32; 2] {
        [self.below(200) as i32 - 20, self.below(160) as i32 - 20]
    }
}

/// Returns the picture of a seed, drawn by a level of vectors or by the widest one.
pub fn picture(seed: u64, simd: Option<Level>) -> Result<Framebuffer, Box<dyn Error>> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut fb = Framebuffer::new(SIZE[0], SIZE[1])?;
    fb.set_renderer(Renderer::new(RenderOptions { simd, ..RenderOptions::default() }));
    fb.state.depth_format = random.pick(&DepthFormat::ALL);
    for _ in 0..8 {
        figure(&mut fb, &mut random)?;
    }
    for _ in 0..1 + random.below(4) {
        state(&mut fb, &mut random)?;
        let mesh = mesh(&mut random)?;
        let _ = fb.draw(&mesh)?;
    }
    figure(&mut fb, &mut random)?;
    Ok(fb)
}

/// Draws a figure.
fn figure(fb: &mut Framebuffer, random: &mut Random) -> Result<(), Box<dyn Error>> {
    fb.set_blend(random.pick(&[Blend::Replace, Blend::Over]));
    let [p, q, r] = [(); 3].map(|()| random.pixel());
    let real = |p: [i32; 2], random: &mut Random| p.map(|v| f64::from(v) + random.real(0.0, 1.0));
    let colors = [(); 3].map(|()| random.color());
    match random.below(7) {
        0 => fb.line(p, q, [colors[0], colors[1]]),
        1 => fb.line_aa(real(p, random), real(q, random), colors[0]),
        2 => fb.fill([p, q, r].map(|p| real(p, random)), colors),
        3 => fb.fill_circle(real(p, random), random.real(0.0, 60.0), colors[0])?,
        4 => fb.circle(p, random.below(60) as i32, colors[0])?,
        5 => fb.fill_poly(&[p, q, r, random.pixel()].map(|p| real(p, random)), colors[0]),
        _ => fb.text(p, "random", colors[0]),
    }
    Ok(())
}

/// Sets the states of the next draw.
fn state(fb: &mut Framebuffer, random: &mut Random) -> Result<(), Box<dyn Error>> {
    let texture = [(); 64].map(|()| random.color());
    let texture = Arc::new(fbptr::scene::Texture::new(8, 8, texture.as_flattened().to_vec())?);
    let filter = random.pick(Filter::ALL);
    let [wrap_s, wrap_t] = [(); 2].map(|()| random.pick(Wrap::ALL));
    let sampling = Sampling { filter, wrap_s, wrap_t };
    let state = &mut fb.state;
    state.texture = (random.below(2) == 0).then_some((texture, sampling));
    state.shade = random.pick(ShadeMode::ALL);
    state.cull = random.pick(Cull::ALL);
    state.hide = random.pick(HiddenSurface::ALL);
    state.interp = random.pick(Interpolation::ALL);
    state.ambient = random.point(0.0, 0.5);
    state.lights = (0..random.below(4)).map(|_| light(random)).collect();
    state.material = Material {
        ka: random.point(0.0, 1.0),
        kd: random.point(0.0, 1.0),
        ks: random.point(0.0, 1.0),
        n: random.real(1.0, 90.0),
        transparency: if random.below(3) == 0 { random.real(0.0, 1.0) } else { 0.0 },
        ..Material::default()
    };
    let axis = random.point(-1.0, 1.0) + DVec3::new(0.0, 0.0, 3.0);
    let turn = fbptr::math::matrix::rotate(axis, random.real(-3.0, 3.0)).ok_or("an axis")?;
    state.model = DMat4::from_translation(random.point(-1.5, 1.5)) * turn;
    state.camera.look_at.eye = DVec3::new(0.0, 0.0, 6.0) + random.point(-1.0, 1.0);
    Ok(())
}

fn light(random: &mut Random) -> Light {
    let (at, color) = (random.point(-6.0, 6.0), random.point(0.0, 1.2));
    let direction = random.point(-1.0, 1.0) - DVec3::new(0.0, 0.0, 3.0);
    let attenuation = Attenuation { c: 1.0, l: random.real(0.0, 0.1), q: random.real(0.0, 0.05) };
    let kind = LightKind::Spot {
        position: at,
        direction,
        angle_rad: random.real(0.2, 1.2),
        exponent: random.real(0.0, 9.0),
        attenuation,
    };
    match random.below(3) {
        0 => Light::point(at, color),
        1 => Light::directional(direction, color),
        _ => Light { kind, ..Light::point(at, color) },
    }
}

fn mesh(random: &mut Random) -> Result<Mesh, Box<dyn Error>> {
    Ok(match random.below(6) {
        0 => shapes::sphere(random.real(0.3, 2.0))?,
        1 => shapes::cuboid(random.point(0.3, 3.0))?,
        2 => shapes::cone(random.real(0.3, 2.0), random.real(0.3, 3.0))?,
        3 => shapes::cylinder(random.real(0.3, 1.5), random.real(0.3, 3.0))?,
        4 => shapes::teapot(1 + random.below(6))?,
        _ => shapes::knot(20 + random.below(60), 3 + random.below(12))?,
    })
}
