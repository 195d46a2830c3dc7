//! Proven bounds on the colour error of cheaper settings, for any camera.
//!
//! In: the angles between a mesh's normals, measured once; a draw with its lights. Out: bounds in
//! units of colour (1 is 255 steps), or none where nothing is proven.
//!
//! With N the interpolated unit normal of a point, L the unit vector to a light of strength I:
//!
//! ```text
//! flat      |max(N.L,0) - max(F.L',0)| <= |N - F| + |L - L'| <= 2 sin(a/2) + s/d
//!           F the face's normal, a the largest angle between F and a corner's normal
//! Gouraud   |max(N.L,0) - sum b_i max(N_i.L_i,0)| <= max(1 - cos r, g/4 + 1 - cos r) + s/d
//!           g the largest angle between two corners' normals, r the radius of a cap that holds them
//! specular  at most Ks I, whatever the vectors
//! ```
//!
//! A directional light has L = L'; for a point light s is the largest extent of a face and d its
//! least distance. max(x,0) changes by no more than x. In the Gouraud row, where all N_i.L have one
//! sign the sum is |sum b_i N_i| times N.L, and |sum b_i N_i| >= cos r; where the signs differ, the
//! convex function max(x,0) on an interval of length g is at most g/4 below its chord. Textures,
//! vertex colours of at most 1 and fog multiply by at most 1.

use crate::cancel::NEVER;
use crate::math::matrix::unit;
use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::normals::{Normals, polygon_normal};
use crate::scene::{Attenuation, Cull, FillStyle, Light, LightKind, LightingModel, Material};
use crate::scene::{Geometry, Mesh, ShadeMode, Texture};
use glam::{DMat3, DVec3, DVec4};

/// Box of a mesh in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshBox {
    /// Low and high corner of the box around all positions.
    pub bounds: (DVec3, DVec3),
    /// True if no vertex colour is transparent, negative or above 1.
    pub has_plain_colors: bool,
}

impl MeshBox {
    /// Measures a mesh.
    pub fn of(mesh: &Mesh) -> MeshBox {
        let is_plain = |c: &DVec4| c.max_element() <= 1.0 && c.min_element() >= 0.0 && c.w == 1.0;
        MeshBox {
            bounds: mesh.bounds().unwrap_or_default(),
            has_plain_colors: mesh.colors.iter().all(is_plain),
        }
    }
}

/// Angles between the normals of a mesh, and the size of its faces in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshAngles {
    /// Least cosine between a polygon's normal and the normal of one of its corners.
    pub face_cos: f64,
    /// Least cosine between the normals of two corners of a triangle.
    pub spread_cos: f64,
    /// Upper bound on the distance between two points of a polygon.
    pub extent: f64,
}

impl MeshAngles {
    /// Measures a mesh. Returns `None` without triangles, for indices that are out of range, and for
    /// triangles of a polygon without area.
    pub fn of(mesh: &Mesh) -> Option<MeshAngles> {
        if mesh.triangles.is_empty() {
            return None;
        }
        let in_range = |c: &crate::scene::Corner| (c.position as usize) < mesh.positions.len();
        let polygon_in_range = |p: &crate::scene::Polygon| {
            (p.first_corner as usize + p.corner_count as usize) <= mesh.corners.len() && p.corner_count > 0
        };
        if !mesh.corners.iter().all(in_range) || !mesh.polygons.iter().all(polygon_in_range) {
            return None;
        }
        let has_own = |c: &crate::scene::Corner| mesh.normals.get(c.normal as usize).is_some();
        let normals = Normals::of(mesh, !mesh.corners.iter().all(has_own), &NEVER);
        let mut angles = MeshAngles { face_cos: 1.0, spread_cos: 1.0, extent: 0.0 };
        for (triangle, polygon) in mesh.triangles.iter().zip(&mesh.triangle_polygon) {
            let face = *normals.of_polygon.get(*polygon as usize)?;
            if face == DVec3::ZERO {
                // Nothing is seen of a triangle without area; one with area has no normal to go by.
                let points = triangle.map(|c| mesh.corners.get(c as usize).map(|c| c.position as usize));
                let points = points.into_iter().flatten().map(|i| mesh.positions[i]);
                match polygon_normal(points) {
                    None => continue,
                    Some(_) => return None,
                }
            }
            let mut own = [face; 3];
            for (own, corner) in own.iter_mut().zip(triangle) {
                let corner = mesh.corners.get(*corner as usize)?;
                let given = mesh.normals.get(corner.normal as usize).and_then(|n| unit(*n));
                let mean = normals.of_position.get(corner.position as usize).filter(|n| **n != DVec3::ZERO);
                *own = given.or(mean.copied()).unwrap_or(face);
            }
            let [a, b, c] = own;
            angles.face_cos = angles.face_cos.min(a.dot(face)).min(b.dot(face)).min(c.dot(face));
            angles.spread_cos = angles.spread_cos.min(a.dot(b)).min(b.dot(c)).min(c.dot(a));
        }
        for polygon in &mesh.polygons {
            let corners = &mesh.corners[polygon.first_corner as usize..][..polygon.corner_count as usize];
            let first = mesh.positions[corners[0].position as usize];
            let farthest = corners
                .iter()
                .fold(0.0f64, |far, c| far.max(mesh.positions[c.position as usize].distance(first)));
            angles.extent = angles.extent.max(2.0 * farthest);
        }
        (angles.extent.is_finite() && angles.face_cos.is_finite()).then_some(angles)
    }
}

/// A draw whose shading may be bounded: its mesh's shape in the world.
pub(super) struct ShadedObject<'c> {
    call: &'c DrawCall<'c>,
    pub(super) mesh_box: MeshBox,
    angles: Option<MeshAngles>,
    /// Factor from object to world lengths.
    pub(super) scale: f64,
    pub(super) materials: Vec<&'c Material>,
}

impl<'c> ShadedObject<'c> {
    /// Returns the draw if its cheaper settings can be bounded: opaque, drawn by the tile renderer
    /// under every shading mode, with a model that keeps angles. Without angles no other shading
    /// mode is.
    pub fn of(
        call: &'c DrawCall<'c>,
        mesh_box: MeshBox,
        angles: Option<MeshAngles>,
    ) -> Option<ShadedObject<'c>> {
        let scale = similarity(DMat3::from_mat4(call.model))?;
        let is_plain = call.back_material.is_none()
            && (!call.two_sided_lighting || call.cull == Cull::Back)
            && call.stages.is_none()
            && call.maps.is_none()
            && call.fill == FillStyle::default();
        let Geometry { mesh, textures } = call.geometry;
        let materials: Vec<&Material> = mesh.materials.iter().chain([call.material]).collect();
        let is_known = |m: &&Material| {
            [m.ka, m.kd, m.ks].iter().all(|c| c.is_finite() && c.min_element() >= 0.0)
                && m.transparency <= 0.0
        };
        let mut textures = textures.iter().filter_map(|t| t.as_deref()).chain(call.texture);
        let is_opaque = mesh_box.has_plain_colors && !textures.any(Texture::has_alpha);
        (is_plain && is_opaque && materials.iter().all(is_known)).then_some(ShadedObject {
            call,
            mesh_box,
            angles,
            scale,
            materials,
        })
    }

    /// Returns the draw.
    pub fn call(&self) -> &'c DrawCall<'c> {
        self.call
    }

    /// Returns a bound on the colour error of drawing in `shade` in place of the draw's own mode,
    /// under these lights; `None` where nothing is proven.
    pub fn of_shade(&self, shade: ShadeMode, lights: &[u32]) -> Option<f64> {
        let own = self.call.shade;
        if shade == own {
            return Some(0.0);
        }
        let angles = self.angles.filter(|_| own == ShadeMode::Phong)?;
        let mut error = 0.0;
        for light in lights {
            let light = self.call.lights.get(*light as usize)?;
            if light.color == DVec3::ZERO {
                continue;
            }
            let turn = self.turn_of(angles, light)?;
            let change = self.change_of(angles, shade, turn)?;
            // The largest sum of both terms, over materials and channels.
            let most = self.materials.iter().filter(|m| m.model != LightingModel::Unlit);
            error += most
                .fold(0.0f64, |most, m| most.max(((m.kd * change + m.ks) * light.color.abs()).max_element()));
        }
        (error.is_finite()).then_some(error)
    }

    /// Returns a bound on how much max(N.L,0) changes when L turns by `turn` over a face.
    fn change_of(&self, angles: MeshAngles, shade: ShadeMode, turn: f64) -> Option<f64> {
        // Cosines of equal unit normals are rounded.
        let angle = |cos: f64| if cos >= 1.0 - 1e-12 { 0.0 } else { libm::acos(cos.clamp(-1.0, 1.0)) };
        let has_colors = !self.call.geometry.mesh.colors.is_empty();
        match shade {
            ShadeMode::Flat => {
                let angle = angle(angles.face_cos);
                // Vertex colours become their mean.
                (!has_colors && angle < 1.5).then(|| 2.0 * libm::sin(angle / 2.0) + turn)
            }
            ShadeMode::Gouraud => {
                let spread = angle(angles.spread_cos);
                if spread >= 1.5 {
                    return None;
                }
                let sin_cap = (2.0 / 3f64.sqrt() * libm::sin(spread / 2.0)).min(1.0);
                let shorter = 1.0 - (1.0 - sin_cap * sin_cap).sqrt();
                // The product of colours and light is interpolated in place of its factors.
                let product = if has_colors { (spread + turn) / 4.0 } else { 0.0 };
                Some(spread / 4.0 + shorter + turn + product)
            }
            ShadeMode::Phong | ShadeMode::Wire => None,
        }
    }

    /// Returns the largest change of the direction to a light over a face; `None` where the light's
    /// strength changes too.
    fn turn_of(&self, angles: MeshAngles, light: &Light) -> Option<f64> {
        match light.kind {
            LightKind::Directional { .. } => Some(0.0),
            LightKind::Point { position, .. } if Self::has_equal_strength(light) => {
                let distance = self.distance(position)?;
                (distance > 0.0).then(|| angles.extent * self.scale / distance)
            }
            _ => None,
        }
    }

    /// Returns whether a point light is equally strong at every place.
    pub(super) fn has_equal_strength(light: &Light) -> bool {
        match light.kind {
            LightKind::Point { attenuation, radius, .. } => {
                attenuation == Attenuation::NONE && radius == f64::INFINITY && light.ambient == DVec3::ZERO
            }
            _ => false,
        }
    }

    /// Returns a lower bound on the distance of the object from a point of the world.
    fn distance(&self, point: DVec3) -> Option<f64> {
        let (low, high) = self.mesh_box.bounds;
        let inside = self.call.model.inverse().transform_point3(point);
        let distance = (inside - inside.clamp(low, high)).length() * self.scale;
        distance.is_finite().then_some(distance)
    }

    /// Returns a bound on the light that reaches the viewer from this light by way of the object.
    pub fn of_light(&self, light: &Light) -> Option<f64> {
        let (position, attenuation, radius) = match light.kind {
            LightKind::Directional { .. } => return Some(self.reflected(light)),
            LightKind::Point { position, attenuation, radius }
            | LightKind::X3dSpot { position, attenuation, radius, .. } => (position, attenuation, radius),
            LightKind::Spot { position, attenuation, .. } => (position, attenuation, f64::INFINITY),
        };
        let distance = self.distance(position)? * (1.0 - 1e-9);
        if distance > radius {
            return Some(0.0);
        }
        let Attenuation { c, l, q } = attenuation;
        let sum = c + l * distance + q * distance * distance;
        let sum = if light.clamp_attenuation { sum.max(1.0) } else { sum };
        (l >= 0.0 && q >= 0.0 && sum > 0.0).then(|| self.reflected(light) / sum)
    }

    /// Returns the most of a light at full strength that the object reflects.
    fn reflected(&self, light: &Light) -> f64 {
        let of =
            |m: &&Material| (m.ka * light.ambient.abs() + (m.kd + m.ks) * light.color.abs()).max_element();
        self.materials.iter().map(of).fold(0.0, f64::max)
    }
}

/// Returns the indices of the lights that reach a draw.
pub(super) fn light_indices<'a>(call: &DrawCall<'a>) -> impl Iterator<Item = u32> + use<'a> {
    let all = if call.light_subset.is_none() { call.lights.len() as u32 } else { 0 };
    (0..all).chain(call.light_subset.unwrap_or_default().iter().copied())
}

/// Returns the factor by which a matrix scales lengths, if it keeps all angles.
fn similarity(m: DMat3) -> Option<f64> {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let scale2 = x.length_squared();
    let is_equal = |v: f64| (v - scale2).abs() <= 1e-9 * scale2;
    let is_right = |v: f64| v.abs() <= 1e-9 * scale2;
    let is_similar = is_equal(y.length_squared())
        && is_equal(z.length_squared())
        && [x.dot(y), y.dot(z), z.dot(x)].into_iter().all(is_right);
    (scale2 > 0.0 && scale2.is_finite() && is_similar).then(|| scale2.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Corner;
    use crate::scene::shapes;
    use crate::truth::scenes::object;

    /// Returns the draw of an object.
    fn call_of(object: &crate::scene::Object) -> DrawCall<'_> {
        DrawCall::new(&object.geometry, &object.material, 64, 48)
    }

    #[test]
    fn a_box_has_one_normal_a_face_and_a_sphere_has_not() {
        let cuboid = MeshAngles::of(&shapes::cuboid(DVec3::ONE).unwrap()).unwrap();
        assert!(cuboid.face_cos > 1.0 - 1e-12 && cuboid.spread_cos > 1.0 - 1e-12, "{cuboid:?}");
        let sphere = MeshAngles::of(&shapes::sphere(1.0).unwrap()).unwrap();
        assert!(sphere.face_cos < 0.9999 && sphere.face_cos > 0.99, "{sphere:?}");
        assert!(sphere.spread_cos < sphere.face_cos, "{sphere:?}");
        let mut broken = shapes::cuboid(DVec3::ONE).unwrap();
        broken.corners[0].position = 99;
        assert_eq!(MeshAngles::of(&broken), None);
        assert_eq!(MeshAngles::of(&Mesh::default()), None);
        // Triangles without area do not count; one with area in a polygon without has no normal.
        let points = || vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 2.0];
        let flat = Mesh::from_triangles(points(), &[[0, 1, 2]]);
        let with_sliver = Mesh::from_triangles(points(), &[[0, 1, 2], [0, 1, 3]]);
        assert_eq!(MeshAngles::of(&with_sliver).unwrap().spread_cos, 1.0);
        let mut bow_tie = flat.clone();
        // The areas of the two halves of its outline cancel out.
        bow_tie.positions = vec![DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::X, DVec3::Y];
        bow_tie.corners = [0, 1, 2, 3].map(|i| Corner { position: i, ..flat.corners[0] }).to_vec();
        bow_tie.polygons[0].corner_count = 4;
        assert_eq!(MeshAngles::of(&bow_tie), None);
    }

    #[test]
    fn bounds_hold_for_normals_at_random_and_are_not_wide() {
        let mut random = crate::truth::scenes::Random::new(21);
        let mut widest = [0.0f64; 2];
        for _ in 0..20_000 {
            let face = random.point(-1.0, 1.0).normalize();
            let reach = random.real(0.0, 0.4);
            let corners = [0; 3].map(|_| (face + random.point(-1.0, 1.0).normalize() * reach).normalize());
            let light = random.point(-1.0, 1.0).normalize();
            let (mut b, c) = ([random.real(0.0, 1.0), random.real(0.0, 1.0), 0.0], corners);
            if b[0] + b[1] > 1.0 {
                b = [1.0 - b[0], 1.0 - b[1], 0.0];
            }
            b[2] = 1.0 - b[0] - b[1];
            let normal = (c[0] * b[0] + c[1] * b[1] + c[2] * b[2]).normalize();
            let lambert = |n: DVec3| n.dot(light).max(0.0);
            let phong = lambert(normal);
            let errors = [
                (lambert(face) - phong).abs(),
                ((0..3).map(|i| b[i] * lambert(c[i])).sum::<f64>() - phong).abs(),
            ];
            let angles = MeshAngles {
                face_cos: c.iter().map(|n| n.dot(face)).fold(1.0, f64::min),
                spread_cos: c[0].dot(c[1]).min(c[1].dot(c[2])).min(c[2].dot(c[0])),
                extent: 0.0,
            };
            let object = object("o", Mesh::default());
            let call = call_of(&object);
            let shaded = ShadedObject::of(&call, MeshBox::of(&Mesh::default()), Some(angles)).unwrap();
            for (i, shade) in [ShadeMode::Flat, ShadeMode::Gouraud].into_iter().enumerate() {
                let bound = shaded.change_of(angles, shade, 0.0).unwrap();
                assert!(errors[i] <= bound + 1e-12, "{shade:?}: {} > {bound}", errors[i]);
                widest[i] = widest[i].max(errors[i] / bound.max(1e-9));
            }
        }
        assert!(widest[0] > 0.9 && widest[1] > 0.5, "{widest:?}");
    }

    #[test]
    fn a_light_out_of_reach_reflects_nothing() {
        let object = object("o", shapes::cuboid(DVec3::ONE).unwrap());
        let call = call_of(&object);
        let shaded = ShadedObject::of(&call, MeshBox::of(&object.geometry.mesh), None).unwrap();
        let mut light = Light::point(DVec3::new(10.0, 0.0, 0.0), DVec3::ONE);
        assert_eq!(shaded.of_light(&light), Some(object.material.kd.max_element()));
        let LightKind::Point { attenuation, radius, .. } = &mut light.kind else { unreachable!() };
        (*radius, attenuation.q) = (9.6, 1.0);
        let attenuation = *attenuation;
        let faint = shaded.of_light(&light).unwrap();
        assert!(faint > 0.0 && faint < 0.01, "{faint}");
        let LightKind::Point { radius, .. } = &mut light.kind else { unreachable!() };
        *radius = 9.4;
        assert_eq!(shaded.of_light(&light), Some(0.0));
        // A spotlight reaches any distance.
        let spot = |position| Light {
            kind: LightKind::Spot {
                position,
                direction: DVec3::NEG_X,
                angle_rad: 0.5,
                exponent: 1.0,
                attenuation,
            },
            ..light
        };
        let near = shaded.of_light(&spot(DVec3::X * 2.0)).unwrap();
        let far = shaded.of_light(&spot(DVec3::X * 1000.0)).unwrap();
        assert!(near > 100.0 * far && far > 0.0, "{near} {far}");
    }

    #[test]
    fn colours_are_plain_within_0_and_1_and_opaque() {
        let has_plain = |color: [f64; 4]| {
            let mesh = Mesh { colors: vec![DVec4::ONE, color.into()], ..Mesh::default() };
            MeshBox::of(&mesh).has_plain_colors
        };
        assert!(has_plain([0.0, 0.5, 1.0, 1.0]));
        for color in [[1.25, 0.5, 0.5, 1.0], [-0.25, 0.5, 0.5, 1.0], [0.5, 0.5, 0.5, 0.5]] {
            assert!(!has_plain(color), "{color:?}");
        }
    }

    #[test]
    fn the_extent_bounds_the_diagonals_and_is_at_most_twice_as_long() {
        for size in [0.01, 1.0, 300.0] {
            let angles = MeshAngles::of(&shapes::cuboid(DVec3::splat(size)).unwrap()).unwrap();
            let diagonal = size * 2f64.sqrt();
            let part = angles.extent / diagonal;
            assert!((1.0..=2.0 + 1e-9).contains(&part), "{part} of a side of {size}");
        }
    }

    #[test]
    fn vertex_colours_widen_the_bound_of_gouraud_by_a_quarter_of_the_lights_change() {
        // The covariance of two numbers is at most a quarter of the product of their ranges; that of
        // a colour is 1.
        let angles = MeshAngles { face_cos: 1.0, spread_cos: libm::cos(0.2), extent: 0.0 };
        let change = |mesh: Mesh| {
            let object = object("o", mesh);
            let call = call_of(&object);
            let shaded = ShadedObject::of(&call, MeshBox::of(&Mesh::default()), Some(angles)).unwrap();
            shaded.change_of(angles, ShadeMode::Gouraud, 0.1).unwrap()
        };
        let colored = change(Mesh { colors: vec![DVec4::ONE], ..Mesh::default() });
        assert!((colored - change(Mesh::default()) - 0.3 / 4.0).abs() < 1e-9, "{colored}");
    }

    #[test]
    fn a_light_is_reflected_by_the_brightest_channel_of_the_brightest_material() {
        let mut mesh = shapes::cuboid(DVec3::ONE).unwrap();
        let material = |ka: f64, kd: [f64; 3], ks: f64| Material {
            ka: DVec3::splat(ka),
            kd: kd.into(),
            ks: DVec3::splat(ks),
            ..Material::default()
        };
        mesh.materials = vec![material(0.25, [0.5, 0.25, 0.0], 0.125)];
        let mut object = object("o", mesh);
        object.material = material(0.0, [0.0, 0.125, 0.25], 0.0);
        let call = call_of(&object);
        let shaded = ShadedObject::of(&call, MeshBox::of(&object.geometry.mesh), None).unwrap();
        let mut light = Light::directional(DVec3::Z, DVec3::new(1.0, 4.0, 0.0));
        light.ambient = DVec3::splat(0.5);
        // Green: 0.25 * 0.5 + (0.25 + 0.125) * 4.
        assert_eq!(shaded.of_light(&light), Some(1.625));
    }
}
