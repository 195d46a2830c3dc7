//! Maps of emission, normals and occlusion of a glTF material, for the mesh that wears it.
//!
//! In: the material's textures and a mesh with its vertices' texture coordinates and tangents. Out:
//! [`SurfaceMaps`], with coordinates and tangents for each corner. A picture of one colour needs no
//! map: the material has it as a number.
//!
//! Tangents of the file count with normals of the file. Others are derived: dP/du of each triangle,
//! perpendicular to the corner's normal, weighted by the corner's angle, and added up at corners that
//! agree in position, normal, coordinates and orientation. That is MikkTSpace's mean, except that it
//! is also taken over triangles that do not share an edge. A triangle without area on the picture has
//! no tangents, and its normals stand.
//!
//! Source: glTF 2.0 Specification, sections 3.7.2.1 (Overview of meshes) and 3.9.3 (Additional
//! Textures); M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 3.3.

use super::attributes::vertex_attribute;
use super::image::{AlphaUse, Images, MadeTexture, Source};
use super::json::Json;
use crate::load::{LoadError, LoadErrorKind};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Mesh, NormalMap, OcclusionMap, SurfaceMap, SurfaceMaps, encoded};
use glam::{DVec2, DVec3, DVec4};
use std::collections::HashMap;
use std::sync::Arc;

/// Least encoded mean of an occlusion texture that divides: below, no ambient light is seen.
const LEAST_MEAN: f64 = 1e-4;

/// KHR_texture_transform: T R S applied to coordinates whose v runs down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextureTransform {
    offset: DVec2,
    rotation_rad: f64,
    scale: DVec2,
}

impl TextureTransform {
    pub(super) fn read(extension: &Json) -> Result<Self, LoadError> {
        let pair = |name: &str, default: [f64; 2]| {
            Ok::<_, LoadError>(DVec2::from_array(extension.member(name).numbers()?.unwrap_or(default)))
        };
        Ok(TextureTransform {
            offset: pair("offset", [0.0; 2])?,
            rotation_rad: extension.member("rotation").number_or(0.0)?,
            scale: pair("scale", [1.0; 2])?,
        })
    }

    /// Returns transformed coordinates. A positive angle turns them counter-clockwise as seen, with
    /// v down.
    pub(super) fn apply(&self, uv: DVec2) -> DVec2 {
        let p = uv * self.scale;
        let (sin, cos) = libm::sincos(self.rotation_rad);
        self.offset + DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x)
    }
}

/// A texture of a material with the set of coordinates that it uses.
pub(super) struct MapTexture {
    pub(super) made: MadeTexture,
    texcoord: u64,
    transform: TextureTransform,
}

impl MapTexture {
    /// Reads a texture's info; `None` if there is none, or no picture that can be read.
    pub(super) fn read(
        source: &mut Source,
        images: &mut Images,
        info: &Json,
        alpha: AlphaUse,
    ) -> Result<Option<MapTexture>, LoadError> {
        if !info.is_object() {
            return Ok(None);
        }
        let made = images.texture(source, &info.member("index"), alpha)?;
        let extension = info.extension("KHR_texture_transform");
        let transform = TextureTransform::read(&extension)?;
        let own = info.member("texCoord").whole_or(0)?;
        let texcoord = extension.member("texCoord").whole_or(own)?;
        Ok(made.map(|made| MapTexture { made, texcoord, transform }))
    }

    /// Returns the coordinates of the vertices, v turned up; empty if they have none.
    pub(super) fn texcoords(
        &self,
        source: &mut Source,
        attributes: &Json,
        count: usize,
    ) -> Result<Vec<DVec2>, LoadError> {
        let name = format!("TEXCOORD_{}", self.texcoord);
        let numbers = vertex_attribute(source, &attributes.member(&name), &[2], count)?;
        let half = self.made.is_mirrored.map(|is| if is { 0.5 } else { 1.0 });
        let place = |uv: [f64; 2]| {
            let uv = self.transform.apply(DVec2::from_array(uv)) * DVec2::from_array(half);
            let uv = DVec2::new(uv.x, 1.0 - uv.y);
            if uv.is_finite() { uv } else { DVec2::ZERO }
        };
        Ok(numbers.map_or(Vec::new(), |uv| uv.elements(0.0).map(place).collect()))
    }
}

/// Textures of a material's maps.
#[derive(Default)]
pub(super) struct MapTextures {
    pub(super) emission: Option<MapTexture>,
    /// Normals, with their scale.
    pub(super) normal: Option<(MapTexture, f64)>,
    /// Occlusion, with its strength and encoded mean.
    pub(super) occlusion: Option<(MapTexture, f64, f64)>,
}

impl MapTextures {
    /// Returns whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.emission.is_none() && self.normal.is_none() && self.occlusion.is_none()
    }

    /// Reads the textures of a material that emits `emission` (linear), and replaces that by its
    /// product with an emission texture of one colour, and by nothing where the texture cannot be
    /// read. `occlusion` is the encoded mean of the occlusion texture.
    pub(super) fn read(
        source: &mut Source,
        images: &mut Images,
        json: &Json,
        emission: &mut DVec3,
        occlusion: f64,
    ) -> Result<MapTextures, LoadError> {
        let mut maps = MapTextures::default();
        let info = json.member("emissiveTexture");
        if info.is_object() && *emission != DVec3::ZERO {
            let index = info.member("index");
            match images.tone(source, &index)? {
                None => *emission = DVec3::ZERO,
                Some(tone) if tone.is_uniform == [true; 3] => *emission *= DVec3::from(tone.mean),
                Some(_) => maps.emission = MapTexture::read(source, images, &info, AlphaUse::Opaque)?,
            }
        }
        let info = json.member("normalTexture");
        let scale = info.member("scale").number_or(1.0)?;
        let normal = MapTexture::read(source, images, &info, AlphaUse::Opaque)?;
        maps.normal = normal.map(|map| (map, scale));
        let info = json.member("occlusionTexture");
        if info.is_object() && occlusion > LEAST_MEAN {
            let strength = strength(&info)?;
            let tone = images.tone(source, &info.member("index"))?;
            if strength > 0.0 && tone.is_some_and(|tone| !tone.is_uniform[0]) {
                let map = MapTexture::read(source, images, &info, AlphaUse::Opaque)?;
                maps.occlusion = map.map(|map| (map, strength, occlusion));
            }
        }
        Ok(maps)
    }

    /// Returns the maps for the corners of a mesh whose vertices have these attributes. A map whose
    /// coordinates the vertices lack is left out, with a warning.
    pub(super) fn worn_by(
        self,
        source: &mut Source,
        attributes: &Json,
        mesh: &Mesh,
    ) -> Result<Option<Arc<SurfaceMaps>>, LoadError> {
        let count = mesh.positions.len();
        let bytes = mesh.corners.len() as u64 * (3 * size_of::<DVec2>() + size_of::<DVec4>()) as u64;
        source.context.memory.reserve_result(bytes).map_err(|kind| attributes.refuse(kind))?;
        let map = |source: &mut Source, map: MapTexture| {
            let uv = map.texcoords(source, attributes, count)?;
            if uv.is_empty() {
                let message = format!("without TEXCOORD_{}, a texture is left out", map.texcoord);
                source.warn(attributes.warning(message));
                return Ok::<_, LoadError>(None);
            }
            let texcoords = mesh.corners.iter().map(|c| uv[c.position as usize]).collect();
            let MadeTexture { texture, sampling, .. } = map.made;
            Ok(Some(SurfaceMap { texture, sampling, texcoords }))
        };
        let mut maps = SurfaceMaps::default();
        if let Some(texture) = self.emission {
            maps.emission = map(source, texture)?;
        }
        if let Some((texture, strength, mean)) = self.occlusion {
            maps.occlusion = map(source, texture)?.map(|map| OcclusionMap { map, strength, mean });
        }
        if let Some((texture, scale)) = self.normal
            && let Some(map) = map(source, texture)?
        {
            let tangents = tangents(source, attributes, mesh, &map.texcoords)?.into();
            maps.normal = Some(NormalMap { map, scale, tangents });
        }
        let has_any = maps.all().next().is_some();
        Ok(has_any.then(|| Arc::new(maps)))
    }
}

/// Returns the strength of an occlusion texture.
pub(super) fn strength(info: &Json) -> Result<f64, LoadError> {
    Ok(info.member("strength").number_or(1.0)?.clamp(0.0, 1.0))
}

/// Returns the encoded part of the ambient light that reaches a surface: the mean of its occlusion
/// texture.
pub(super) fn mean_occlusion(
    source: &mut Source,
    images: &mut Images,
    json: &Json,
) -> Result<f64, LoadError> {
    let info = json.member("occlusionTexture");
    let strength = strength(&info)?;
    let tone = if info.is_object() { images.tone(source, &info.member("index"))? } else { None };
    // The picture is linear, as a factor of light is.
    Ok(tone.map_or(1.0, |tone| encoded(1.0 + strength * (tone.mean[0] - 1.0))))
}

/// Returns the tangent of each corner: the file's, else derived from the coordinates `uv`.
fn tangents(
    source: &mut Source,
    attributes: &Json,
    mesh: &Mesh,
    uv: &[DVec2],
) -> Result<Vec<DVec4>, LoadError> {
    let given = attributes.member("TANGENT");
    if given.is_there()
        && attributes.member("NORMAL").is_there()
        && let Some(numbers) = vertex_attribute(source, &given, &[4], mesh.positions.len())?
    {
        let tangents: Vec<DVec4> = numbers.elements(0.0).map(DVec4::from_array).collect();
        let finite = |t: DVec4| if t.is_finite() { t } else { DVec4::ZERO };
        return Ok(mesh.corners.iter().map(|c| finite(tangents[c.position as usize])).collect());
    }
    let bytes = mesh.corners.len() as u64 * 2 * size_of::<(Place, DVec3)>() as u64;
    let refused = |kind: LoadErrorKind| attributes.refuse(kind);
    let _work = source.context.memory.work(bytes).map_err(refused)?;
    Ok(derived(mesh, uv))
}

/// A place at which tangents are added up: bits of position, normal and coordinates, and whether the
/// picture is mirrored.
type Place = ([u64; 8], bool);

/// Returns the tangents of all corners, derived from the coordinates `uv` of the corners.
fn derived(mesh: &Mesh, uv: &[DVec2]) -> Vec<DVec4> {
    let position = |c: u32| mesh.positions[mesh.corners[c as usize].position as usize];
    let normal = |c: u32| {
        let given = mesh.normals.get(mesh.corners[c as usize].normal as usize);
        given.and_then(|n| unit(*n)).unwrap_or(DVec3::Z)
    };
    let place = |c: u32, is_mirrored: bool| -> Place {
        let ([p, n], t) = ([position(c), normal(c)], uv[c as usize]);
        // 0 and -0 are one place.
        ([p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y].map(|x| (x + 0.0).to_bits()), is_mirrored)
    };
    let mut sums: HashMap<Place, DVec3> = HashMap::with_capacity(mesh.positions.len());
    let mut signs = vec![0.0; mesh.corners.len()];
    for t in &mesh.triangles {
        let (p, st) = (t.map(position), t.map(|c| uv[c as usize]));
        let (d1, d2) = (st[1] - st[0], st[2] - st[0]);
        let area = d1.perp_dot(d2);
        let along = ((p[1] - p[0]) * d2.y - (p[2] - p[0]) * d1.y) * area.signum();
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        for k in 0..3 {
            let n = normal(t[k]);
            let flat = |v: DVec3| unit(v - n * n.dot(v));
            let edges = [1, 2].map(|i| flat(p[(k + i) % 3] - p[k]).unwrap_or(DVec3::ZERO));
            let angle = libm::acos(edges[0].dot(edges[1]).clamp(-1.0, 1.0));
            *sums.entry(place(t[k], area < 0.0)).or_default() += flat(along).unwrap_or(DVec3::ZERO) * angle;
            signs[t[k] as usize] = area.signum();
        }
    }
    let tangent = |(c, sign): (usize, &f64)| {
        let sum = if *sign == 0.0 { None } else { sums.get(&place(c as u32, *sign < 0.0)) };
        sum.and_then(|sum| unit(*sum)).map_or(DVec4::ZERO, |t| t.extend(*sign))
    };
    signs.iter().enumerate().map(tangent).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::{Corner, NONE};

    /// Returns a mesh of these triangles with the normal +z, and a corner's coordinates for each.
    fn mesh(triangles: &[[(DVec3, DVec2); 3]]) -> (Mesh, Vec<DVec2>) {
        let mut mesh = Mesh { normals: vec![DVec3::Z], ..Mesh::default() };
        for t in triangles {
            let corners = t.map(|(p, _)| {
                mesh.positions.push(p);
                let position = mesh.positions.len() as u32 - 1;
                Corner { position, normal: 0, texcoord: NONE, color: NONE }
            });
            mesh.push_polygon(&corners, NONE);
        }
        (mesh, triangles.iter().flatten().map(|(_, uv)| *uv).collect())
    }

    fn corner(x: f64, y: f64, u: f64, v: f64) -> (DVec3, DVec2) {
        (DVec3::new(x, y, 0.0), DVec2::new(u, v))
    }

    #[test]
    fn a_tangent_points_where_u_grows() {
        let turned = [corner(0., 0., 0., 0.), corner(1., 0., 0., -1.), corner(0., 1., 1., 0.)];
        let (mesh, uv) = mesh(&[turned]);
        for t in derived(&mesh, &uv) {
            assert!((t - DVec4::new(0.0, 1.0, 0.0, 1.0)).length() < 1e-15, "{t}");
        }
    }

    #[test]
    fn mirrored_triangles_have_their_own_sign_and_those_without_area_none() {
        let right = [corner(0., 0., 0., 0.), corner(1., 0., 1., 0.), corner(0., 1., 0., 1.)];
        let left = [corner(0., 0., 0., 0.), corner(0., 1., 0., 1.), corner(-1., 0., 1., 0.)];
        let none = [corner(0., 0., 0.5, 0.5), corner(1., 0., 0.5, 0.5), corner(0., 1., 0.5, 0.5)];
        let (mesh, uv) = mesh(&[right, left, none]);
        let found = derived(&mesh, &uv);
        assert!(found[..3].iter().all(|t| *t == DVec4::new(1.0, 0.0, 0.0, 1.0)), "{found:?}");
        assert!(found[3..6].iter().all(|t| *t == DVec4::new(-1.0, 0.0, 0.0, -1.0)), "{found:?}");
        assert!(found[6..].iter().all(|t| *t == DVec4::ZERO), "{found:?}");
    }

    #[test]
    fn triangles_that_meet_share_the_mean_by_angles() {
        // u runs along x in one, at 45 degrees in the other; their right angles meet at the origin.
        let plain = [corner(0., 0., 0., 0.), corner(1., 0., 1., 0.), corner(0., 1., 0., 1.)];
        let skew = [corner(0., 0., 0., 0.), corner(-1., 0., -1., 1.), corner(0., -1., -1., -1.)];
        let (mesh, uv) = mesh(&[plain, skew]);
        let found = derived(&mesh, &uv);
        let half = (DVec3::X + DVec3::new(1.0, 1.0, 0.0).normalize()).normalize();
        for corner in [0, 3] {
            assert!((found[corner].truncate() - half).length() < 1e-15, "{found:?}");
        }
        assert_eq!(found[1], DVec4::new(1.0, 0.0, 0.0, 1.0));
    }
}
