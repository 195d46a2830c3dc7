//! Attributes of the faces that a vector of pixels shows: barycentrics, vertices and materials.
//!
//! The barycentrics of faces with screen vertices are computed from those; a face that was set up
//! in f64 has its own. From there on both take one path ([`super::interpolate`]). The kernel that
//! iterates over the pixels is [`super::resolve`].

use super::attribute_fetch::{Corners, Few, MOST_FEW, blend, gather3, most_few};
use super::exact_faces::{self, ExactFace};
use super::interpolate::{Barycentrics, FragmentInputs, add};
use super::light_grid::{self, BlockInputs, LightGrid, LightInputs};
use super::lighting::{MaterialLighting, light_by_normal, pack, splat3};
use super::shading_state::{ColorSource, Eye, MaterialBinding, Shading};
use super::tile_buffers::{EXACT_FACE_BIT, NO_FACE};
use super::vertex::ScreenVertex;
use crate::math::coverage::PixelRect;
use crate::simd::{F32, I32, Mask, Simd, prefetch};

/// Function that finds the set-up of a face in f64.
pub type ExactFaceLookup<'a> = dyn Fn(u32) -> Option<&'a ExactFace> + Sync + 'a;

/// Faces that pixels are shaded from.
#[derive(Clone, Copy)]
pub struct Faces<'a> {
    /// State that all pixels share.
    pub shading: &'a Shading<'a>,
    /// Bits of the three vertex indices of each face, and of its material's index.
    pub corners: &'a [[f32; 4]],
    /// Vertices on the screen.
    pub screen_vertices: &'a [ScreenVertex],
    /// True if the mesh is larger than the nearer caches.
    pub is_far_flung: bool,
    /// Finds the set-up of a face in f64.
    pub exact_face: &'a ExactFaceLookup<'a>,
}

impl<'a> Faces<'a> {
    /// Prefetches the vertices that the next block will gather.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, s: S, ids: S::I) {
        let narrow = ids.gt(s.splat_i(NO_FACE)) & s.splat_i(EXACT_FACE_BIT).gt(ids);
        let mut faces = [0; 16];
        let count = s.compress_i(narrow, ids, &mut faces[..S::LANES]);
        let mut last = NO_FACE;
        for &face in &faces[..count] {
            if face != last {
                last = face;
                let [c0, c1, c2, _] = self.corners[face as usize];
                for corner in [c0, c1, c2] {
                    let vertex = corner.to_bits() as usize;
                    prefetch::for_read(self.screen_vertices, vertex);
                    if let ColorSource::Pixels(table) | ColorSource::Vertices(table, _) =
                        self.shading.shader.source
                    {
                        prefetch::for_read(table, vertex);
                    }
                }
            }
        }
    }

    /// Returns the packed colours of pixels whose faces have screen vertices, if no barycentrics
    /// are needed.
    #[inline(always)]
    pub fn unweighed_color<S: Simd>(&self, s: S, mask: S::M, faces: S::I) -> Option<S::I> {
        let shading = self.shading;
        if let (Some(binding), None) = (self.is_plain_color(), shading.shader.fog) {
            return Some(pack(s, add::<S>(splat3(s, binding.diffuse), splat3(s, binding.specular))));
        }
        if let (ColorSource::Faces(diffuse, []), [], None, 0) =
            (shading.shader.source, shading.shader.colors, shading.shader.fog, shading.back)
        {
            let [r, g, b, _] = s.gather4(mask, diffuse, faces);
            return Some(pack(s, [r, g, b]));
        }
        None
    }

    /// Returns the shading inputs of pixels whose faces have screen vertices, and the indices of
    /// their materials.
    #[inline(always)]
    pub(super) fn fragment_inputs<'f, S: Simd>(
        &self,
        s: S,
        mask: S::M,
        faces: S::I,
        at: (S::I, S::I),
        few: &'f mut Few<S>,
    ) -> (FragmentInputs<'f, S>, S::I) {
        let shading = self.shading;
        let none = s.mask(0);
        let faces = s.select_i(mask, faces, s.splat_i(0));
        let (corners, mut materials) = self.corners_of(s, mask, faces, few);
        let [r0, r1, r2] = gather3(s, mask, self.screen_vertices, &corners);
        let px = at.0.shl::<16>() + s.splat_i(1 << 15);
        let py = at.1.shl::<16>() + s.splat_i(1 << 15);
        let (d0, d1, d2) = (offset(s, r0, px, py), offset(s, r1, px, py), offset(s, r2, px, py));
        let (e0, e1, e2) = (cross::<S>(d1, d2), cross::<S>(d2, d0), cross::<S>(d0, d1));
        let area = (e0 + e1) + e2;
        // Inside a face that is seen from its other side all of these are negative: their ratios
        // are unaffected.
        let zero = s.splat(0.0);
        let is_normal_flipped = area.lt(zero);
        let f = [e0, e1, e2];
        // Beside the face: clamped to it, as in the plain path.
        let (least, most) = (area.min(zero), area.max(zero));
        let (e0, e1, e2) = (e0.max(least).min(most), e1.max(least).min(most), e2.max(least).min(most));
        let [i0, i1, i2] = match shading.is_affine {
            true => [s.splat(1.0); 3],
            false => [r0[3], r1[3], r2[3]],
        };
        let p = [e0 * i0, e1 * i1, e2 * i2];
        let inverse = s.splat(1.0) / ((p[0] + p[1]) + p[2]);
        let w = ((e0 + e1) + e2) * inverse;
        let (mut right, mut below) = (p, p);
        if shading.bindings.iter().any(|m| m.texture.is_some()) {
            // One pixel further, an edge function has changed by the edge's extent on the other
            // axis.
            let unit = s.splat(65536.0);
            let steps = [(d1, d2), (d2, d0), (d0, d1)];
            let i = [i0, i1, i2];
            right = [
                (f[0] + unit * (steps[0].0[1] - steps[0].1[1])) * i[0],
                (f[1] + unit * (steps[1].0[1] - steps[1].1[1])) * i[1],
                (f[2] + unit * (steps[2].0[1] - steps[2].1[1])) * i[2],
            ];
            below = [
                (f[0] + unit * (steps[0].1[0] - steps[0].0[0])) * i[0],
                (f[1] + unit * (steps[1].1[0] - steps[1].0[0])) * i[1],
                (f[2] + unit * (steps[2].1[0] - steps[2].0[0])) * i[2],
            ];
        }
        let turn = match shading.flip_normal {
            0 => none,
            1 => !is_normal_flipped,
            _ => is_normal_flipped,
        };
        if shading.back > 0 {
            let back_facing = if shading.back_facing > 0 { !is_normal_flipped } else { is_normal_flipped };
            materials = s.select_i(back_facing, materials + s.splat_i(shading.back), materials);
        }
        let barycentrics = Barycentrics { p, inverse, w, right, below };
        (FragmentInputs { faces, corners, barycentrics, turn, at }, materials)
    }

    /// Returns the vertices of the pixels' faces, and the indices of their materials.
    #[inline(always)]
    fn corners_of<'f, S: Simd>(
        &self,
        s: S,
        mask: S::M,
        faces: S::I,
        few: &'f mut Few<S>,
    ) -> (Corners<'f, S>, S::I) {
        let mut numbers = [0; 16];
        s.store_i(faces, &mut numbers[..S::LANES]);
        // Found all at once, so that none has to wait for the one before it.
        let mut left = s.first_occurrences(mask, faces).bits();
        let count = left.count_ones() as usize;
        if count == 0 || count > most_few::<S>() {
            let [c0, c1, c2, materials] = s.gather4(mask, self.corners, faces);
            return (Corners::Many([c0.bits(), c1.bits(), c2.bits()]), materials.bits());
        }
        few.count = count.min(MOST_FEW);
        let mut materials = s.splat_i(0);
        let mut slot = 0;
        while slot < few.count {
            let face = numbers[left.trailing_zeros() as usize & 15];
            left &= left - 1;
            let same = mask & faces.eq(s.splat_i(face));
            let [c0, c1, c2, material] = self.corners[face as usize];
            few.pixels[slot] = same;
            few.vertices[slot] = [c0.to_bits() as usize, c1.to_bits() as usize, c2.to_bits() as usize];
            materials = s.select_i(same, s.splat_i(material.to_bits() as i32), materials);
            slot += 1;
        }
        (Corners::Few(few), materials)
    }

    /// Returns the packed colours of pixels of one face that was set up in f64, and the lanes where
    /// f32 lacks the digits.
    #[inline(always)]
    pub(super) fn exact_face<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        exact_face: &ExactFace,
        [x, y]: [i32; 2],
    ) -> (S::I, S::M) {
        let shading = self.shading;
        let [b0, b1, b2] = exact_faces::weights(s, exact_face, [x, y], 1);
        let p = match exact_face.is_cut {
            true => [b0, b1, b2],
            false => exact_faces::clamped(s, exact_face, [b0, b1, b2]),
        };
        let sum = (p[0] + p[1]) + p[2];
        let mut barycentrics = Barycentrics::new(p, s.splat(1.0) / sum);
        let (binding, shader) = (self.binding_of(exact_face), &shading.shader);
        if binding.texture.is_some() {
            let [g0, g1, g2] = &exact_face.plane.barycentrics;
            barycentrics.right =
                [b0 + s.splat(g0[1] as f32), b1 + s.splat(g1[1] as f32), b2 + s.splat(g2[1] as f32)];
            barycentrics.below =
                [b0 + s.splat(g0[2] as f32), b1 + s.splat(g1[2] as f32), b2 + s.splat(g2[2] as f32)];
        }
        let off = mask & !s.splat(exact_faces::LEAST_SUM).lt(sum);
        if shading.is_affine {
            barycentrics.w = s.splat(1.0);
        }
        let inputs = self.inputs_of(s, exact_face, barycentrics, [x, y], 1);
        let (mut lit, mut needs_f64) = shader.lit(s, mask, &binding.lighting, &inputs);
        if let Some(texture) = &binding.texture {
            needs_f64 = needs_f64 | shader.texture(s, mask, texture, &inputs, &mut lit);
        }
        let needs_w =
            shading.is_affine && (matches!(shader.source, ColorSource::Pixels(_)) || shader.fog.is_some());
        (shader.finish(s, &lit), if needs_w { mask } else { needs_f64 | off })
    }

    /// Lights LANES corners of a grid, from a row and a column of them on, the first of which is a pixel;
    /// the grid keeps their light.
    #[inline(always)]
    pub(super) fn light_corners<S: Simd>(
        &self,
        s: S,
        exact_face: &ExactFace,
        pixel: [i32; 2],
        grid: &mut LightGrid,
        at: [usize; 2],
    ) {
        let ColorSource::Pixels(normals) = self.shading.shader.source else { return };
        let step = grid.cell() as i32;
        let p = exact_faces::weights(s, exact_face, pixel, step);
        let sum = (p[0] + p[1]) + p[2];
        let barycentrics = Barycentrics::new(p, s.splat(1.0) / sum);
        let inputs = self.inputs_of(s, exact_face, barycentrics, pixel, step);
        let all = s.mask(u32::MAX);
        let normal = blend(s, all, normals, &inputs.corners, inputs.barycentrics.weights());
        let lighting = &self.binding_of(exact_face).lighting;
        let ([diffuse, specular], needs_f64) =
            self.shading.shader.lit_along(s, all, lighting, &inputs, normal);
        let is_known = exact_faces::inside(s, exact_face, p) & s.splat(exact_faces::LEAST_SUM).lt(sum);
        grid.keep(s, at, add::<S>(diffuse, specular), is_known & !needs_f64);
    }

    /// Returns the inputs of fragments of one face, LANES pixels from (x, y) on, one in `step` columns.
    #[inline(always)]
    fn inputs_of<S: Simd>(
        &self,
        s: S,
        exact_face: &ExactFace,
        barycentrics: Barycentrics<S>,
        [x, y]: [i32; 2],
        step: i32,
    ) -> FragmentInputs<'static, S> {
        FragmentInputs {
            faces: s.splat_i(exact_face.face as i32),
            corners: Corners::One(self.vertices(exact_face.face as usize)),
            barycentrics,
            turn: s.mask(if exact_face.is_normal_flipped { u32::MAX } else { 0 }),
            at: (s.iota() * s.splat_i(step) + s.splat_i(x), s.splat_i(y)),
        }
    }

    /// Returns the vertices of a face.
    #[inline(always)]
    pub(super) fn vertices(&self, face: usize) -> [usize; 3] {
        let [c0, c1, c2, _] = self.corners[face];
        [c0, c1, c2].map(|corner| corner.to_bits() as usize)
    }

    /// Returns the material of a face that was set up in f64.
    #[inline(always)]
    pub(super) fn binding_of(&self, exact_face: &ExactFace) -> &'a MaterialBinding<'a> {
        let [_, _, _, material] = self.corners[exact_face.face as usize];
        let back = if exact_face.is_back { self.shading.back } else { 0 };
        &self.shading.bindings[(material.to_bits() as i32 + back) as usize]
    }

    /// Returns whether faces may have grids of light: they are lit per pixel, nothing but light makes
    /// their colour, and some of it depends on the place.
    pub(super) fn may_have_grids(&self) -> bool {
        let shader = &self.shading.shader;
        matches!(shader.source, ColorSource::Pixels(_))
            && shader.fog.is_none()
            && shader.colors.is_empty()
            && !self.shading.is_affine
            && self.shading.bindings.iter().any(is_light_of_places)
    }

    /// Returns whether a face may have a grid of light in a tile that pays, where some face may.
    pub(super) fn may_have_grid(&self, exact_face: &ExactFace, tile: PixelRect) -> bool {
        is_light_of_places(self.binding_of(exact_face)) && light_grid::may_pay(exact_face.bounds, tile)
    }

    /// Decides which cells of a face's grid in a tile are interpolated.
    pub(super) fn decide_cells(&self, grid: &mut LightGrid, exact_face: &ExactFace, tile: PixelRect) {
        let to_viewer = match self.shading.shader.eye {
            Eye::Parallel { to_viewer } => Some(to_viewer),
            _ => None,
        };
        let inputs = BlockInputs::new(tile, to_viewer, |at| self.light_inputs(exact_face, at));
        grid.decide(&inputs, &self.binding_of(exact_face).lighting, self.shading.light_error);
    }

    /// Returns what the light of a pixel is computed from.
    fn light_inputs(&self, exact_face: &ExactFace, [x, y]: [i32; 2]) -> LightInputs {
        let (shader, corners) = (&self.shading.shader, self.vertices(exact_face.face as usize));
        let b = exact_faces::weights_at(exact_face, [x, y]);
        let normals = if let ColorSource::Pixels(normals) = shader.source { normals } else { &[] };
        let turn = if exact_face.is_normal_flipped { -1.0 } else { 1.0 };
        let point = match shader.eye {
            Eye::Perspective { ray: [first, right, below] } => {
                [0, 1, 2].map(|axis| first[axis] + (right[axis] * x as f32 + below[axis] * y as f32))
            }
            _ => weighted(shader.positions, corners, b),
        };
        let normal = weighted(normals, corners, b).map(|v| v * turn);
        LightInputs { q: (b[0] + b[1]) + b[2], point, normal }
    }

    /// Returns the packed colour of a face that was set up in f64, if a cheap test shows that it has
    /// only one.
    #[inline(always)]
    pub fn only_color<S: Simd>(&self, s: S, face: usize, exact_face: Option<&ExactFace>) -> Option<S::I> {
        if let ColorSource::Pixels(normals) = self.shading.shader.source {
            return self.evenly_lit_color(s, normals, face, exact_face?.is_normal_flipped);
        }
        let color = self.stored_color(face)?;
        Some(pack(s, splat3(s, color)))
    }

    /// Returns the packed colour of a face whose corners have one normal, if no light or highlight
    /// depends on the place.
    #[inline(always)]
    fn evenly_lit_color<S: Simd>(
        &self,
        s: S,
        normals: &[[f32; 4]],
        face: usize,
        is_normal_flipped: bool,
    ) -> Option<S::I> {
        let shading = self.shading;
        let [only] = shading.bindings else { return None };
        let lighting = &only.lighting;
        let has_one_color = only.texture.is_none() && shading.shader.fog.is_none() && !lighting.needs_place;
        if !has_one_color || !shading.shader.colors.is_empty() {
            return None;
        }
        let normal = self.common_value(normals, face)?;
        let length2 = (normal[0] * normal[0] + normal[1] * normal[1]) + normal[2] * normal[2];
        if lighting.lights.is_empty() || length2.is_nan() || length2 < 1e-4 {
            return None;
        }
        let length = length2.sqrt();
        let normal = normal.map(|v| if is_normal_flipped { -(v / length) } else { v / length });
        let diffuse = light_by_normal(s, lighting, splat3(s, normal));
        Some(pack(s, add::<S>(diffuse, splat3(s, lighting.specular))))
    }

    /// Returns the values of a table at a face's corners, if they are equal.
    #[inline(always)]
    fn common_value(&self, table: &[[f32; 4]], face: usize) -> Option<[f32; 3]> {
        let [c0, c1, c2, _] = self.corners[face];
        let [v0, v1, v2] =
            [table[c0.to_bits() as usize], table[c1.to_bits() as usize], table[c2.to_bits() as usize]];
        (v0 == v1 && v1 == v2).then_some([v0[0], v0[1], v0[2]])
    }

    /// Returns the one colour of a face that the tables have, if they have only one.
    #[inline(always)]
    fn stored_color(&self, face: usize) -> Option<[f32; 3]> {
        let shading = self.shading;
        let [only] = shading.bindings else { return None };
        if only.texture.is_some() || shading.shader.fog.is_some() {
            return None;
        }
        let (diffuse, specular) = (only.lighting.diffuse, only.lighting.specular);
        match shading.shader.source {
            ColorSource::Constant if shading.shader.colors.is_empty() => {
                Some([diffuse[0] + specular[0], diffuse[1] + specular[1], diffuse[2] + specular[2]])
            }
            ColorSource::Constant => {
                let c = self.common_value(shading.shader.colors, face)?;
                Some([
                    diffuse[0] * c[0] + specular[0],
                    diffuse[1] * c[1] + specular[1],
                    diffuse[2] * c[2] + specular[2],
                ])
            }
            ColorSource::Vertices(table, []) if shading.shader.colors.is_empty() => {
                self.common_value(table, face)
            }
            ColorSource::Faces(table, []) if shading.shader.colors.is_empty() => {
                let [r, g, b, _] = table[face];
                Some([r, g, b])
            }
            _ => None,
        }
    }

    /// Returns the material whose colour all pixels have, if there is one.
    #[inline(always)]
    fn is_plain_color(&self) -> Option<&MaterialLighting> {
        let s = self.shading;
        match (s.shader.source, s.bindings) {
            (ColorSource::Constant, [only]) if s.shader.colors.is_empty() && only.texture.is_none() => {
                Some(&only.lighting)
            }
            _ => None,
        }
    }
}

/// Returns whether a material has no texture, and light that depends on the place: other light is
/// computed in less time than it is interpolated.
fn is_light_of_places(binding: &MaterialBinding<'_>) -> bool {
    binding.texture.is_none() && binding.lighting.needs_place && !binding.lighting.lights.is_empty()
}

/// Returns the sum of the vectors of three vertices, weighted by `b`; 0 if there is no table.
fn weighted(table: &[[f32; 4]], corners: [usize; 3], b: [f32; 3]) -> [f32; 3] {
    if table.is_empty() {
        return [0.0; 3];
    }
    let [v0, v1, v2] = corners.map(|corner| table[corner]);
    [0, 1, 2].map(|axis| (v0[axis] * b[0] + v1[axis] * b[1]) + v2[axis] * b[2])
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

/// Returns the vector from the pixel's centre to a vertex, in 1/65536 pixel; the floor in the
/// vertex is half a unit low.
#[inline(always)]
fn offset<S: Simd>(s: S, r: [S::F; 4], px: S::I, py: S::I) -> [S::F; 2] {
    let half = s.splat(0.5);
    [(r[0].bits() - px).to_f32() + half, (r[1].bits() - py).to_f32() + half]
}

#[inline(always)]
fn cross<S: Simd>(a: [S::F; 2], b: [S::F; 2]) -> S::F {
    a[0] * b[1] - b[0] * a[1]
}
