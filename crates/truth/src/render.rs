//! Rendering of a scene: every face, in order, at every pixel of its bounds.

use super::camera::Sight;
use super::coverage::Coverage;
use super::double_double::DoubleDouble;
use super::face::{Face, ObjectView};
use super::fragment::FragmentContext;
use super::light::ObjectLighting;
use super::lines::line_pixels_of;
use super::picture::{DepthUse, FaceKey, Layer, TruthPicture};
use super::pixel_mask::PixelMask;
pub use super::settings::{Settings, Transparency};
use super::texture::MipChain;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    CameraError, HiddenSurface, Scene, ShadeMode, Texture, TransparencyOrder, Viewport, ViewportRule,
};
use std::cmp::Ordering;
use std::collections::HashMap;
use std::rc::Rc;

/// Renders a scene into a cleared picture.
///
/// # Errors
/// If the scene's camera is unusable.
pub fn render(
    scene: &Scene,
    width: u32,
    height: u32,
    format: DepthFormat,
    settings: &Settings,
) -> Result<TruthPicture, CameraError> {
    let mut picture = TruthPicture::new(width, height, format);
    picture.draw(scene, settings)?;
    Ok(picture)
}

/// Relative difference of sorting keys up to which the layers of a run may come in any order.
const KEY_TURN: f64 = 1e-12;

/// Renders only the listed pixels (x, y) of a scene; the others keep the cleared or the background
/// colour.
///
/// # Errors
/// If the scene's camera is unusable.
pub fn render_pixels(
    scene: &Scene,
    width: u32,
    height: u32,
    format: DepthFormat,
    settings: &Settings,
    pixels: &[[u32; 2]],
) -> Result<TruthPicture, CameraError> {
    let mut picture = TruthPicture::new(width, height, format);
    picture.draw_at(scene, settings, Some(pixels))?;
    Ok(picture)
}

impl TruthPicture {
    /// Draws a scene over the picture: background, then faces, each at every pixel of its bounds.
    ///
    /// # Errors
    /// If the scene's camera is unusable; the picture is then unchanged.
    pub fn draw(&mut self, scene: &Scene, settings: &Settings) -> Result<(), CameraError> {
        self.draw_at(scene, settings, None)
    }

    /// Draws like [`TruthPicture::draw`], at the listed pixels only if there is a list; the
    /// background is drawn everywhere.
    ///
    /// # Errors
    /// If the scene's camera is unusable; the picture is then unchanged.
    pub fn draw_at(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        pixels: Option<&[[u32; 2]]>,
    ) -> Result<(), CameraError> {
        let (width, height) = (self.width(), self.height());
        let full_frame = Viewport { x: 0, y: 0, width, height, rule: ViewportRule::Corners };
        let viewport = settings.viewport.unwrap_or(full_frame);
        let sight = Sight::new(&scene.camera.unwrap_or_default(), &viewport)?;
        let clip = [
            (viewport.x as i64).max(0),
            (viewport.x as i64 + viewport.width as i64).min(width as i64),
            (viewport.y as i64).max(0),
            (viewport.y as i64 + viewport.height as i64).min(height as i64),
        ];
        match (&scene.sky, scene.background.color) {
            (Some(sky), _) => self.paint_sky(clip, &sight, sky),
            (None, Some(color)) => self.paint(clip, color),
            (None, None) => {}
        }
        if clip[0] >= clip[1] || clip[2] >= clip[3] {
            return Ok(());
        }
        let context =
            FragmentContext { sight: &sight, interpolation: settings.interpolation, fog: scene.fog };
        let mask = match pixels {
            None => PixelMask::all(clip),
            Some(pixels) => PixelMask::some(clip, [width, height], pixels),
        };
        let (faces, keys, line_pixels) = self.faces_in_order(scene, settings, &context, &mask);
        let mut rows = vec![Vec::new(); (clip[3] - clip[2]) as usize];
        for (i, face) in faces.iter().enumerate() {
            for y in face.bounds[2]..face.bounds[3] {
                rows[(y - clip[2]) as usize].push(i);
            }
        }
        for (y, row) in (clip[2]..).zip(&rows) {
            for x in (clip[0]..clip[1]).filter(|&x| mask.has(x, y)) {
                let ndc = sight.ndc_of_pixel(x, y);
                let mut ranked = Vec::new();
                for &i in row.iter().filter(|&&i| (faces[i].bounds[0]..faces[i].bounds[1]).contains(&x)) {
                    let coverage = faces[i].covers(x, y, ndc);
                    if coverage == Coverage::No {
                        continue;
                    }
                    if let Some(fragment) = context.fragment(&faces[i], x, y, coverage) {
                        let is_wire = faces[i].shade == ShadeMode::Wire;
                        let layer = Layer {
                            fragment,
                            face: keys[i],
                            depth_use: match is_wire {
                                true => DepthUse::DepthOnly,
                                false => depth_use(settings.hide, &faces[i]),
                            },
                            is_transparent: faces[i].is_transparent && !is_wire,
                            is_textured: faces[i].is_textured(),
                        };
                        let rank = match is_wire {
                            true => (false, faces[i].object, false),
                            false => face_rank(settings, &faces[i]),
                        };
                        ranked.push((rank, (sort_key(settings, &faces[i]), layer)));
                    }
                }
                for (object, layer) in line_pixels.get(&[x, y]).into_iter().flatten() {
                    ranked.push((line_rank(settings, *object), (None, layer.clone())));
                }
                // Stable: faces keep their order, and so do lines.
                ranked.sort_by_key(|r| r.0);
                let layers: Vec<_> = ranked.into_iter().map(|r| r.1).collect();
                if !layers.is_empty() {
                    self.resolve((width as i64 * y + x) as usize, &right_orders(&layers));
                }
            }
        }
        Ok(())
    }

    /// Returns all faces in drawing order, with their keys in this picture, and the layers of lines
    /// and points.
    fn faces_in_order<'a>(
        &mut self,
        scene: &'a Scene,
        settings: &'a Settings,
        context: &FragmentContext<'a>,
        mask: &PixelMask,
    ) -> (Vec<Face<'a>>, Vec<FaceKey>, LinePixels) {
        let sight = context.sight;
        let mut line_pixels = LinePixels::new();
        let mut mip_chains: HashMap<*const Texture, Rc<MipChain>> = HashMap::new();
        let mut mip_chain = |t: &'a Texture| {
            mip_chains.entry(std::ptr::from_ref(t)).or_insert_with(|| Rc::new(MipChain::new(t))).clone()
        };
        let mut faces = Vec::new();
        for (index, object) in scene.objects.iter().enumerate() {
            let lights = match &object.lights {
                None => scene.lights.iter().collect(),
                Some(some) => some.iter().filter_map(|&i| scene.lights.get(i as usize)).collect(),
            };
            let lighting = Rc::new(ObjectLighting { ambient: scene.ambient, lights, viewer: sight.viewer });
            let view = ObjectView { index: index as u32, object, sight, settings, lighting };
            let mesh = &object.geometry.mesh;
            let is_wire = object.shade.unwrap_or(settings.shade) == ShadeMode::Wire;
            // The edges of a wireframe depend on which faces are visible at all.
            let everywhere = PixelMask::all(mask.clip);
            let own = view.faces(if is_wire { &everywhere } else { mask }, &mut mip_chain);
            if is_wire || !mesh.lines.is_empty() || !mesh.points.is_empty() {
                let is_hidden = is_wire && settings.hide == HiddenSurface::ZBuffer;
                for pixel in line_pixels_of(&view, context, mask.clip, &own, is_wire, is_hidden) {
                    // A position whose depth never equals a face's: lines and faces have separate
                    // orders.
                    let aside =
                        [DoubleDouble::ZERO, DoubleDouble::ZERO, -DoubleDouble::ONE, DoubleDouble::new(-7.0)];
                    let face =
                        self.register(&object.name, index as u32, 0, [pixel.clip[0], pixel.clip[1], aside]);
                    let depth_use = match (settings.hide, pixel.is_transparent) {
                        _ if pixel.edge_z.is_some() => {
                            DepthUse::Edge(pixel.edge_z.unwrap_or(pixel.fragment.z))
                        }
                        (HiddenSurface::ZBuffer, true) => DepthUse::Test,
                        (HiddenSurface::ZBuffer, false) => DepthUse::TestAndWrite,
                        _ => DepthUse::Ignore,
                    };
                    let layer = Layer {
                        fragment: pixel.fragment,
                        face,
                        depth_use,
                        is_transparent: pixel.is_transparent,
                        is_textured: false,
                    };
                    line_pixels.entry([pixel.x, pixel.y]).or_default().push((index as u32, layer));
                }
            }
            if !is_wire || settings.hide == HiddenSurface::ZBuffer {
                faces.extend(own);
            }
        }
        // Stable: opaque before transparent if requested, then by sorting key if there is one.
        faces.sort_by(|a, b| {
            let late = |f: &Face| settings.transparency != Transparency::AtOnce && f.is_transparent;
            late(a).cmp(&late(b)).then_with(|| match (sort_key(settings, a), sort_key(settings, b)) {
                (Some(a), Some(b)) => a.partial_cmp(&b).unwrap_or(Ordering::Equal),
                _ => Ordering::Equal,
            })
        });
        let keys = faces
            .iter()
            .map(|f| {
                let name = &scene.objects[f.object as usize].name;
                self.register(name, f.object, f.triangle, [0, 1, 2].map(|i| f.corners[i].clip))
            })
            .collect();
        (faces, keys, line_pixels)
    }
}

/// Layers of lines and points by pixel, with their object's number, in drawing order.
type LinePixels = HashMap<[i64; 2], Vec<(u32, Layer)>>;

/// Returns a face's rank among lines and points: first by whether it is late, then by object.
fn face_rank(settings: &Settings, face: &Face) -> (bool, u32, bool) {
    match settings.transparency {
        Transparency::AtOnce => (false, face.object, false),
        Transparency::AfterOpaque(_) if face.is_transparent => (true, 0, false),
        Transparency::AfterOpaque(_) if settings.hide == HiddenSurface::Painter => (false, 0, false),
        Transparency::AfterOpaque(_) => (false, face.object, false),
    }
}

/// Returns the rank of an object's lines and points: after its opaque faces; for the painter's
/// algorithm, after those of all objects.
fn line_rank(settings: &Settings, object: u32) -> (bool, u32, bool) {
    match settings.transparency {
        Transparency::AfterOpaque(_) if settings.hide == HiddenSurface::Painter => {
            (false, object.saturating_add(1), true)
        }
        _ => (false, object, true),
    }
}

/// Sorting key of a face in a sorted draw.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct SortKey {
    /// Draw that the face belongs to: draws keep their order.
    draw: u32,
    /// View z of the face's centroid, farthest (smallest) first.
    center_z: DoubleDouble,
}

fn sort_key(settings: &Settings, face: &Face) -> Option<SortKey> {
    let painter = settings.hide == HiddenSurface::Painter;
    let (sorted, draw) = match settings.transparency {
        Transparency::AtOnce => (painter, face.object),
        Transparency::AfterOpaque(order) if face.is_transparent => (order == TransparencyOrder::Sorted, 0),
        Transparency::AfterOpaque(_) => (painter, 0),
    };
    sorted.then_some(SortKey { draw, center_z: face.center_z })
}

fn depth_use(hide: HiddenSurface, face: &Face) -> DepthUse {
    match hide {
        HiddenSurface::ZBuffer if face.is_transparent => DepthUse::Test,
        HiddenSurface::ZBuffer => DepthUse::TestAndWrite,
        HiddenSurface::Painter | HiddenSurface::None => DepthUse::Ignore,
    }
}

/// Returns the accepted orders of the layers: the given one, and variants within runs of equal
/// keys.
fn right_orders(layers: &[(Option<SortKey>, Layer)]) -> Vec<Vec<&Layer>> {
    let equal = |a: Option<SortKey>, b: Option<SortKey>| match (a, b) {
        (Some(a), Some(b)) if a.draw == b.draw => {
            let [p, q] = [a.center_z, b.center_z];
            (p - q).to_f64().abs() <= KEY_TURN * (1.0 + p.to_f64().abs().max(q.to_f64().abs()))
        }
        _ => false,
    };
    let mut orders: Vec<Vec<&Layer>> = vec![Vec::new()];
    for run in layers.chunk_by(|a, b| equal(a.0, b.0)) {
        // Each layer of the run may come last, which decides the visible one among opaque layers.
        let variants: Vec<Vec<&Layer>> = (0..run.len().min(6))
            .map(|last| {
                let mut v: Vec<&Layer> = run.iter().map(|l| &l.1).collect();
                let moved = v.remove(run.len() - 1 - last);
                v.push(moved);
                v
            })
            .collect();
        orders = orders
            .iter()
            .flat_map(|o| variants.iter().map(move |v| o.iter().chain(v).copied().collect()))
            .take(24)
            .collect();
    }
    orders
}
