//! Faces of the reference: one triangle of a draw with its corners, its plane, and its lighting.

use super::camera::{Sight, transform};
use super::coverage::{Coverage, Outline, distance_to_tie};
use super::double_double::{DoubleDouble, DoubleDouble3, DoubleDouble4, cross, narrow3};
use super::light::{LitColor, ObjectLighting, light_point};
use super::maps::FaceMaps;
use super::normals::{Normals, area_normal, is_mirrored, normal_matrix};
use super::pixel_mask::PixelMask;
pub use super::render::Settings;
use super::texture::{MipChain, UvFootprint};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{
    Cull, FillStyle, LightingModel, Material, NONE, Object, Sampling, ShadeMode, TextureStages,
};
use glam::{DVec2, DVec3, DVec4};
use std::cmp::Ordering;
use std::rc::Rc;

/// Distance in pixels from the outline of a face with some w <= 0 within which either coverage is
/// accepted.
const CUT_MARGIN_PX: f64 = 1.5 / 256.0;

/// Distance in pixels beyond which a corner's place is known to 1/256 pixel only, however far it is.
const FAR_PX: f64 = (1u64 << 41) as f64;

/// Corner of a face.
#[derive(Clone, Debug)]
pub struct FaceCorner {
    /// Position in clip space.
    pub clip: DoubleDouble4,
    /// Position in world space.
    pub world: DoubleDouble3,
    /// Unit world normal, turned to the viewer if the object asks for it.
    pub normal: DVec3,
    /// Texture coordinates, if the mesh has them.
    pub uv: Option<[f64; 2]>,
    /// Vertex colour; 1 1 1 1 if the file gives none.
    pub color: DVec4,
    /// Accepted colours of the corner for Gouraud shading; else empty.
    pub lit: Vec<LitColor>,
}

/// Multitexture stages of one triangle.
#[derive(Clone, Debug)]
pub struct FaceStages<'a> {
    /// Stages of the object.
    pub stages: &'a TextureStages,
    /// Mip chain of each stage's texture.
    pub mip_chains: Vec<Option<Rc<MipChain>>>,
    /// Corner numbers of the triangle.
    pub corners: [usize; 3],
}

impl FaceStages<'_> {
    /// Applies the stages to the lit colour and opacity, at weights `a` of the corners.
    pub fn colored(&self, a: [f64; 3], (base, opacity): (DVec3, f64), extra: DVec3) -> (DVec3, f64) {
        self.stages.combine((base, opacity), extra, |number| {
            let (stage, mip_chain) = (&self.stages.stages[number], &self.mip_chains[number]);
            let uv = (0..3).fold(DVec2::ZERO, |sum, i| sum + stage.texcoords[self.corners[i]] * a[i]);
            let none = UvFootprint::Steps([[0.0; 2]; 2]);
            let texels = mip_chain.as_ref().map(|p| p.sample(stage.sampling, uv.to_array(), none));
            texels.map_or([1.0; 4], |texels| texels[0])
        })
    }
}

/// Triangle prepared for queries pixel by pixel.
#[derive(Clone, Debug)]
pub struct Face<'a> {
    /// Corners in the file's order.
    pub corners: [FaceCorner; 3],
    /// Number of its object in the scene.
    pub object: u32,
    /// Number of the triangle in the object, in file order.
    pub triangle: u32,
    /// Material of the side that is seen.
    pub material: &'a Material,
    /// Texture with its sampling.
    pub texture: Option<(Rc<MipChain>, Sampling)>,
    /// Multitexture stages in place of one texture.
    pub stages: Option<FaceStages<'a>>,
    /// Maps of emission, normals and occlusion.
    pub maps: Option<FaceMaps<'a>>,
    /// Fill pattern.
    pub fill: FillStyle,
    /// Shading mode.
    pub shade: ShadeMode,
    /// Unit geometric normal in world space.
    pub normal: DVec3,
    /// Accepted flat-shading colours at the centroid; empty in other modes.
    pub flat: Vec<LitColor>,
    /// Mean vertex colour, for flat shading.
    pub flat_color: DVec4,
    /// True if the face is blended with the pixels behind it.
    pub is_transparent: bool,
    /// View z of the centroid, the painter's sorting key; larger is nearer.
    pub center_z: DoubleDouble,
    /// Lights that reach the face.
    pub lighting: Rc<ObjectLighting<'a>>,
    shape: Shape,
    /// Screen pixels per unit of NDC.
    pixels_per_ndc: [f64; 2],
    /// Pixels that the outline can reach, x0..x1 and y0..y1, within the viewport.
    pub bounds: [i64; 4],
}

/// Weights b_i of the corners at a pixel's centre.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Solution of sum b_i (x_i, y_i, w_i) = (x_ndc, y_ndc, 1).
    pub b: DoubleDouble3,
}

impl Weights {
    /// Returns 1/w at this point of the plane.
    pub fn inverse_w(&self) -> DoubleDouble {
        self.b[0] + self.b[1] + self.b[2]
    }

    /// Returns whether the point lies inside the true face.
    pub fn is_inside(&self) -> bool {
        self.b.iter().all(|&b| b >= DoubleDouble::ZERO)
    }
}

impl<'a> Face<'a> {
    /// Returns whether the colour depends on a texture.
    pub fn is_textured(&self) -> bool {
        self.texture.is_some() || self.stages.is_some() || self.maps.is_some()
    }

    /// Returns whether the true corners are collinear to 24 digits: only snapping gives such a face
    /// an area.
    pub fn is_degenerate(&self) -> bool {
        self.shape.is_degenerate
    }

    /// Returns the plane's weights at NDC (x, y).
    pub fn weights(&self, [x, y]: [DoubleDouble; 2]) -> Weights {
        Weights { b: self.shape.plane.map(|p| p[0] * x + p[1] * y + p[2]) }
    }

    /// Returns the depth of the face's plane at NDC (x, y), within the depths of its corners in front
    /// of the eye; `None` for a face without area.
    pub fn depth_in_plane(&self, ndc: [DoubleDouble; 2]) -> Option<DoubleDouble> {
        let b = self.weights(ndc).b;
        let z = (0..3).fold(DoubleDouble::ZERO, |sum, i| sum + b[i] * self.corners[i].clip[2]);
        let in_front = self.corners.iter().filter(|c| c.clip[3] > DoubleDouble::ZERO);
        let depths: Vec<DoubleDouble> = in_front.map(|c| c.clip[2] / c.clip[3]).collect();
        let near = depths.iter().copied().reduce(DoubleDouble::min)?;
        let far = depths.iter().copied().reduce(DoubleDouble::max)?;
        if !z.is_finite() || self.is_degenerate() {
            return None;
        }
        Some(if depths.len() == 3 { z.max(near).min(far) } else { z.max(near) })
    }

    /// Returns the coverage of the centre of pixel (x, y), at NDC `ndc`.
    pub fn covers(&self, x: i64, y: i64, ndc: [DoubleDouble; 2]) -> Coverage {
        let Some(outline) = &self.shape.outline else { return self.covers_cut(ndc) };
        let sure = match (outline.covers(x, y), self.is_degenerate()) {
            (false, _) => Coverage::No,
            (true, false) => Coverage::Yes,
            // A degenerate face that snapping gave an area: both drawing and omitting it are
            // accepted.
            (true, true) => Coverage::Maybe,
        };
        if self.shape.wobble_px == [0.0; 3] {
            return sure;
        }
        // An uncertain corner moves its edges, in proportion along each edge.
        let mut low = f64::INFINITY;
        let mut high = f64::INFINITY;
        for (i, (distance, along)) in outline.distances(x, y).into_iter().enumerate() {
            let margin = (1.0 - along).abs() * self.shape.wobble_px[i]
                + along.abs() * self.shape.wobble_px[(i + 1) % 3];
            low = low.min(distance - margin);
            high = high.min(distance + margin);
        }
        if low <= 0.0 && high >= 0.0 { Coverage::Maybe } else { sure }
    }

    /// Returns the coverage of a face with some w <= 0: by the signs of the weights, either near
    /// the outline.
    fn covers_cut(&self, [x, y]: [DoubleDouble; 2]) -> Coverage {
        let nearest = self.shape.plane.iter().fold(f64::INFINITY, |nearest, p| {
            let value = (p[0] * x + p[1] * y + p[2]).to_f64();
            let slope = (p[0].to_f64() / self.pixels_per_ndc[0], p[1].to_f64() / self.pixels_per_ndc[1]);
            let slope = (slope.0 * slope.0 + slope.1 * slope.1).sqrt();
            let distance = if slope > 0.0 { value / slope } else { value * f64::INFINITY };
            nearest.min(distance)
        });
        match nearest {
            d if d > CUT_MARGIN_PX => Coverage::Yes,
            d if d < -CUT_MARGIN_PX => Coverage::No,
            _ => Coverage::Maybe,
        }
    }
}

/// Plane and outline of a face.
#[derive(Clone, Debug)]
struct Shape {
    /// Plane of each weight: b_i = plane[i] . (x_ndc, y_ndc, 1) with sum b_i = 1/w, sum b_i w_i =
    /// 1, all >= 0 inside.
    plane: [DoubleDouble3; 3],
    /// Snapped outline; `None` for a face with some w <= 0, whose plane decides.
    outline: Option<Outline>,
    /// Uncertainty of each snapped corner in pixels, from plain f64 rounding; 0 if its snapping is
    /// certain.
    wobble_px: [f64; 3],
    /// True if the true corners are collinear to 24 digits.
    is_degenerate: bool,
    /// True if the corners are seen counterclockwise.
    is_ccw: bool,
}

impl Shape {
    /// Returns the shape of a face with these corners, or `None` if nothing of it can be seen.
    fn new(at: [&TransformedVertex; 3]) -> Option<Shape> {
        // The plane through the unsnapped corners: rows (x_i, y_i, w_i), inverted by cofactors.
        let rows: [DoubleDouble3; 3] = at.map(|p| [p.clip[0], p.clip[1], p.clip[3]]);
        let cofactors = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])];
        let det = super::double_double::dot3(rows[0], cofactors[0]);
        let scale =
            rows.iter().fold(1.0, |s, r| s * (0..3).fold(0.0, |m: f64, k| m.max(r[k].to_f64().abs())));
        let is_degenerate = det.to_f64().abs() <= 1e-24 * scale;
        if at.iter().all(|p| p.clip[3].to_f64() <= -p.slack[3]) || det == DoubleDouble::ZERO {
            return None;
        }
        let mut wobble_px = [0.0; 3];
        let (outline, is_ccw) = if let [Some(a), Some(b), Some(c)] = at.map(|p| p.screen) {
            wobble_px = [a.1, b.1, c.1];
            let outline = Outline::new([a.0, b.0, c.0])?;
            let turn = outline.turn();
            if turn == Ordering::Equal && wobble_px == [0.0; 3] {
                return None;
            }
            (Some(outline), turn == Ordering::Less)
        } else {
            (None, det > DoubleDouble::ZERO)
        };
        let plane = cofactors.map(|c| c.map(|v| v / det));
        Some(Shape { plane, outline, wobble_px, is_degenerate, is_ccw })
    }
}

/// State of one object that all its faces share.
pub struct ObjectView<'a> {
    /// Number of the object in the scene.
    pub index: u32,
    /// The object.
    pub object: &'a Object,
    /// Camera of the draw.
    pub sight: &'a Sight,
    /// Modes of the draw.
    pub settings: &'a Settings,
    /// Lights that reach the object.
    pub lighting: Rc<ObjectLighting<'a>>,
}

impl<'a> ObjectView<'a> {
    /// Returns the faces of the object that may be visible in pixels of `mask`, in file order.
    pub fn faces(
        &self,
        mask: &PixelMask,
        mip_chain: &mut impl FnMut(&'a fbptr_core::scene::Texture) -> Rc<MipChain>,
    ) -> Vec<Face<'a>> {
        let mesh = &self.object.geometry.mesh;
        let normals = Normals::new(mesh);
        let vertices: Vec<TransformedVertex> = mesh.positions.iter().map(|&p| self.vertex(p)).collect();
        (0..mesh.triangles.len()).filter_map(|t| self.face(t, mask, &normals, &vertices, mip_chain)).collect()
    }

    /// Transforms a position from object to world, view and clip space, with a bound on the error
    /// of plain f64 in clip space.
    pub fn vertex(&self, p: DVec3) -> TransformedVertex {
        let m = self.object.model;
        let rows: [[f64; 4]; 4] = std::array::from_fn(|r| m.row(r).to_array());
        let object: DoubleDouble4 = [p.x.into(), p.y.into(), p.z.into(), DoubleDouble::ONE];
        let world = transform(&rows.map(|r| r.map(DoubleDouble::new)), object);
        let view = transform(&self.sight.view, world);
        let clip = transform(&self.sight.projection, view);
        let magnitudes = |m: &[[DoubleDouble; 4]; 4], p: [f64; 4]| -> [f64; 4] {
            std::array::from_fn(|r| (0..4).map(|c| m[r][c].to_f64().abs() * p[c]).sum())
        };
        let size =
            magnitudes(&rows.map(|r| r.map(DoubleDouble::new)), [p.x.abs(), p.y.abs(), p.z.abs(), 1.0]);
        let size = magnitudes(&self.sight.projection, magnitudes(&self.sight.view, size));
        let slack = size.map(|s| 16.0 * f64::EPSILON * s);
        let is_in_front = clip[3].to_f64() > slack[3];
        let screen = is_in_front.then(|| {
            let at = self.sight.to_screen(clip[0] / clip[3], clip[1] / clip[3]);
            (at, self.wobble(clip, slack, at))
        });
        TransformedVertex { world: [world[0], world[1], world[2]], view, clip, slack, screen }
    }

    /// Returns the pixels that a face's outline can reach, within the viewport: all of it if a
    /// corner has w <= 0.
    fn bounds(at: [&TransformedVertex; 3], clip: [i64; 4]) -> [i64; 4] {
        let [Some(a), Some(b), Some(c)] = at.map(|p| p.screen) else { return clip };
        let mut found = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for (vertex, wobble_px) in [a, b, c] {
            let [x, y] = vertex.map(DoubleDouble::to_f64);
            // Snapping moves a corner by at most half a step, in addition to its uncertainty.
            let room = wobble_px + 1.0 / 256.0;
            let ends = [x - room, x + room, y - room, y + room];
            found =
                std::array::from_fn(
                    |k| if k % 2 == 0 { found[k].min(ends[k]) } else { found[k].max(ends[k]) },
                );
        }
        // Pixels whose centres are in range; the casts saturate.
        let low = |v: f64, lo: i64, hi: i64| ((v - 0.5).ceil() as i64).clamp(lo, hi);
        let high = |v: f64, lo: i64, hi: i64| (((v - 0.5).floor() as i64).saturating_add(1)).clamp(lo, hi);
        [
            low(found[0], clip[0], clip[1]),
            high(found[1], clip[0], clip[1]),
            low(found[2], clip[2], clip[3]),
            high(found[3], clip[2], clip[3]),
        ]
    }

    /// Returns triangle `t`, or `None` if it is culled, has no area or lies outside the mask.
    fn face(
        &self,
        t: usize,
        mask: &PixelMask,
        normals: &Normals,
        vertices: &[TransformedVertex],
        mip_chain: &mut impl FnMut(&'a fbptr_core::scene::Texture) -> Rc<MipChain>,
    ) -> Option<Face<'a>> {
        let object = self.object;
        let mesh = &object.geometry.mesh;
        let ids = mesh.triangles[t].map(|c| c as usize);
        let at = ids.map(|c| &vertices[mesh.corners[c].position as usize]);
        if !at.iter().all(|p| p.clip.iter().all(|c| c.is_finite())) {
            return None;
        }
        let bounds = Self::bounds(at, mask.clip);
        if !mask.is_any_in(bounds) {
            return None;
        }
        let shape = Shape::new(at)?;
        let is_front = shape.is_ccw != is_mirrored(&object.model);
        match self.settings.cull.unwrap_or(object.cull) {
            Cull::Back if !is_front => return None,
            Cull::Front if is_front => return None,
            _ => {}
        }
        let polygon = &mesh.polygons[mesh.triangle_polygon[t] as usize];
        let own = (polygon.material != NONE).then_some(polygon.material as usize);
        let material = self.material(own, is_front);
        let (normal, corners) = self.corners(t, at, normals, is_front);
        let texture = self.texture(own, &corners);
        let is_transparent = material.transparency > 0.0
            || texture.is_some_and(|t| t.has_alpha())
            || object.style.stages.as_ref().is_some_and(|s| s.may_be_transparent())
            || corners.iter().any(|c| c.color.w < 1.0);
        let rules = object.texture.as_ref().map(|t| t.1).unwrap_or_default();
        let texture =
            texture.filter(|_| object.style.stages.is_none()).map(|t| (mip_chain(t), t.sampling(rules)));
        let stages = object.style.stages.as_deref().map(|stages| FaceStages {
            stages,
            mip_chains: stages.stages.iter().map(|s| s.texture.as_deref().map(&mut *mip_chain)).collect(),
            corners: ids,
        });
        let turn = if object.two_sided_lighting && !is_front { -1.0 } else { 1.0 };
        let maps = match material.model {
            LightingModel::Unlit => None,
            _ => FaceMaps::of(object, ids, turn, mip_chain),
        };
        let mut face = Face {
            corners,
            object: self.index,
            triangle: t as u32,
            material,
            texture,
            stages,
            maps,
            fill: object.style.fill,
            shade: object.shade.unwrap_or(self.settings.shade),
            normal,
            flat: Vec::new(),
            flat_color: DVec4::ONE,
            is_transparent,
            center_z: (at[0].view[2] + at[1].view[2] + at[2].view[2]) / DoubleDouble::new(3.0),
            lighting: self.lighting.clone(),
            shape,
            pixels_per_ndc: self.sight.pixels_per_ndc(),
            bounds,
        };
        self.light_ahead(&mut face, polygon, vertices);
        Some(face)
    }

    /// Returns the material of the side that is seen; `own` is the number of the polygon's own.
    fn material(&self, own: Option<usize>, is_front: bool) -> &'a Material {
        let object = self.object;
        match (&object.back_material, own) {
            (Some(back), _) if !is_front => back,
            (_, Some(own)) => &object.geometry.mesh.materials[own],
            _ => &object.material,
        }
    }

    /// Returns the texture of a face whose corners all have coordinates: that of the polygon's own
    /// material, else the object's.
    fn texture(
        &self,
        own: Option<usize>,
        corners: &[FaceCorner; 3],
    ) -> Option<&'a fbptr_core::scene::Texture> {
        let object = self.object;
        let own_texture = own.and_then(|m| object.geometry.textures.get(m)).and_then(Option::as_deref);
        own_texture
            .or(object.texture.as_ref().map(|t| &*t.0))
            .filter(|_| corners.iter().all(|c| c.uv.is_some()))
    }

    /// Returns the world normal of triangle `t`, towards the side that is lit, and its corners.
    fn corners(
        &self,
        t: usize,
        at: [&TransformedVertex; 3],
        normals: &Normals,
        is_front: bool,
    ) -> (DVec3, [FaceCorner; 3]) {
        let object = self.object;
        let mesh = &object.geometry.mesh;
        let ids = mesh.triangles[t].map(|c| c as usize);
        let to_world = normal_matrix(&object.model);
        let turn = if object.two_sided_lighting && !is_front { -1.0 } else { 1.0 };
        let mut face_normal = normals.polygon[mesh.triangle_polygon[t] as usize];
        if face_normal == DVec3::ZERO {
            face_normal = area_normal(&ids.map(|c| mesh.positions[mesh.corners[c].position as usize]));
        }
        let world_face = turn * unit(to_world * face_normal).unwrap_or(DVec3::ZERO);
        let corners = std::array::from_fn(|i| {
            let c = &mesh.corners[ids[i]];
            let n = normals.at_corner(mesh, ids[i], face_normal);
            FaceCorner {
                clip: at[i].clip,
                world: at[i].world,
                normal: unit(to_world * n).map_or(world_face, |n| n * turn),
                uv: (c.texcoord != NONE).then(|| mesh.texcoords[c.texcoord as usize].to_array()),
                color: if c.color == NONE { DVec4::ONE } else { mesh.colors[c.color as usize] },
                lit: Vec::new(),
            }
        });
        (world_face, corners)
    }

    /// Computes the lighting of flat and Gouraud shading: at the centroid, or at the corners.
    fn light_ahead(
        &self,
        face: &mut Face<'a>,
        polygon: &fbptr_core::scene::Polygon,
        vertices: &[TransformedVertex],
    ) {
        let mesh = &self.object.geometry.mesh;
        match face.shade {
            ShadeMode::Flat => {
                let run =
                    polygon.first_corner as usize..(polygon.first_corner + polygon.corner_count) as usize;
                let share = 1.0 / polygon.corner_count as f64;
                let mut center = DVec3::ZERO;
                let mut color = DVec4::ZERO;
                for c in &mesh.corners[run] {
                    center += share * narrow3(vertices[c.position as usize].world);
                    color += share * if c.color == NONE { DVec4::ONE } else { mesh.colors[c.color as usize] };
                }
                face.flat_color = color;
                face.flat = light_point(face.material, color.truncate(), center, face.normal, &face.lighting);
            }
            ShadeMode::Gouraud => {
                for c in &mut face.corners {
                    let (p, albedo) = (narrow3(c.world), c.color.truncate());
                    c.lit = light_point(face.material, albedo, p, c.normal, &face.lighting);
                }
            }
            ShadeMode::Phong | ShadeMode::Wire => {}
        }
    }

    /// Returns the uncertainty of a snapped corner in pixels: 0 unless a snapping tie is within the
    /// rounding error of f64.
    fn wobble(&self, clip: DoubleDouble4, slack: [f64; 4], screen: [DoubleDouble; 2]) -> f64 {
        let w = clip[3].to_f64();
        let scale = self.sight.pixels_per_ndc();
        (0..2)
            .map(|k| {
                let ndc = (clip[k] / clip[3]).to_f64();
                // Farther out the renderer, too, places corners with two f64 a number: by a linear
                // map whose error is far below a pixel on the screen, but that may snap elsewhere.
                if screen[k].to_f64().abs() > FAR_PX {
                    return 1.0 / 256.0;
                }
                let off = scale[k] * (slack[k] + ndc.abs() * slack[3]) / w.abs()
                    + 4.0 * f64::EPSILON * screen[k].to_f64().abs();
                if distance_to_tie(screen[k]) <= off * 256.0 { off + 1.0 / 256.0 } else { 0.0 }
            })
            .fold(0.0, f64::max)
    }
}

/// Transformed position of a mesh.
pub struct TransformedVertex {
    /// Position in world space.
    pub world: DoubleDouble3,
    view: DoubleDouble4,
    /// Position in clip space.
    pub clip: DoubleDouble4,
    /// Bounds on the error of each clip coordinate in plain f64.
    slack: [f64; 4],
    /// Screen pixels, and the uncertainty of a corner snapped here; `None` if w <= 0 to the
    /// accuracy of f64.
    screen: Option<([DoubleDouble; 2], f64)>,
}
