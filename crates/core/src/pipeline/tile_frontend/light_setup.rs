//! Material bindings in the kernels' format, and tables of light at vertices or faces.

use crate::executor::Executor;
use crate::pipeline::assemble::Facing;
use crate::pipeline::indexed_mesh::IndexedMesh;
use crate::pipeline::light::{Lighting, PreparedLight, SurfacePoint};
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shading_space::f32s;
use crate::pipeline::tile::{
    Cone, Exponent, FaintLight, FastLight, LightPosition, MaterialBinding, MaterialLighting,
    RecycledBindings, TextureSampler, VertexLightingKernel,
};
use crate::scene::{Attenuation, Cull, LightKind, Material, ShadeMode};
use crate::simd::Level;
use crate::simd::allocator::resize_in_huge_pages;
use glam::{DMat3, DVec3};

/// Points per piece of table work.
const CHUNK_POINTS: usize = 4096;

/// Tables that all faces of a draw share, with one record per point or face.
#[derive(Debug, Default)]
pub(super) struct Tables {
    pub normals: Vec<[f32; 4]>,
    pub positions: Vec<[f32; 4]>,
    pub diffuse: Vec<[f32; 4]>,
    pub specular: Vec<[f32; 4]>,
}

impl Tables {
    /// Returns the bytes that the tables take.
    pub fn size_bytes(&self) -> usize {
        [&self.normals, &self.positions, &self.diffuse, &self.specular]
            .iter()
            .map(|t| t.capacity() * 16)
            .sum()
    }
}

/// Source of colours; selects the draw's [`ColorSource`](crate::pipeline::tile::ColorSource).
pub(super) enum Light {
    /// Lit per pixel, from normals.
    Pixels,
    /// Lit per vertex, from tables.
    Vertices,
    /// Lit per face, from tables.
    Faces,
    /// One colour per material.
    Constant,
}

/// Inputs of the table computation, and its executor.
pub(super) struct TableWork<'a> {
    pub prepared: &'a IndexedMesh,
    pub bindings: &'a [MaterialBinding<'a>],
    pub is_lit: bool,
    pub level: Level,
    pub executor: &'a Executor,
}

/// Points to be lit, in object space.
struct Points<'a> {
    positions: &'a [Vec<f64>; 3],
    normals: &'a [[f32; 4]],
    colors: &'a [[f32; 4]],
    /// Returns the run of points with one material that begins at the first argument: its end,
    /// searched no further than the second argument, and the material's index.
    run: &'a (dyn Fn(usize, usize) -> (usize, usize) + Sync),
}

impl PreparedDraw<'_> {
    /// Returns the materials in the kernels' format: those of the front, then those of the back if
    /// it has its own.
    pub(super) fn bindings<'s>(
        &'s self,
        prepared: &IndexedMesh,
        recycled: &mut RecycledBindings,
    ) -> Vec<MaterialBinding<'s>> {
        let (lighting, space) = (&self.lighting, &self.space);
        let mut bindings: Vec<MaterialBinding<'s>> = std::mem::take(&mut recycled.bindings);
        bindings.extend(self.materials(&prepared.materials).map(|(material, texture)| {
            let lights = match lighting.depends_on_point(material) {
                true => recycled.lights.pop().unwrap_or_default(),
                false => Vec::new(),
            };
            MaterialBinding {
                lighting: lighting.of_material(
                    material,
                    self.may_lack(FaintLight::WITHIN_A_STEP),
                    |p| space.point(p),
                    |d| space.axes * d,
                    lights,
                ),
                texture: texture.map(|t| TextureSampler::new(t, t.sampling(self.call.sampling))),
            }
        }));
        bindings
    }

    /// Returns `tolerance`, but no faded light where vertex colours multiply light: they may make it
    /// brighter.
    pub(super) fn may_lack(&self, tolerance: FaintLight) -> FaintLight {
        match self.call.geometry.mesh.colors.is_empty() {
            true => tolerance,
            false => FaintLight { faded: 0.0, ..tolerance },
        }
    }

    /// Computes the tables that lighting needs, and returns the source of colours.
    pub(super) fn light_tables(&self, work: &TableWork<'_>, tables: &mut Tables) -> Light {
        let (prepared, mesh) = (work.prepared, &self.call.geometry.mesh);
        match self.call.shade {
            ShadeMode::Flat if work.is_lit || !mesh.colors.is_empty() => {
                let faces = self.geometry_info.faces(mesh);
                let points = Points {
                    positions: &faces.centers,
                    normals: &faces.normals,
                    colors: &faces.colors,
                    run: &|first, end| run_of_faces(&prepared.face_materials, first, end),
                };
                self.light_points(work, &points, tables);
                Light::Faces
            }
            ShadeMode::Gouraud if work.is_lit => {
                let points = Points {
                    positions: &prepared.positions,
                    normals: &prepared.normals,
                    colors: &prepared.colors,
                    run: &|first, _| {
                        let run = prepared.vertex_runs.partition_point(|(end, _)| *end <= first);
                        prepared.vertex_runs[run]
                    },
                };
                self.light_points(work, &points, tables);
                Light::Vertices
            }
            ShadeMode::Phong if work.is_lit => {
                if !self.space.has_own_normals {
                    self.turn_normals(&prepared.normals, work.executor, &mut tables.normals);
                }
                Light::Pixels
            }
            _ => Light::Constant,
        }
    }

    /// Lights points into the table `diffuse` and, if a texture requires the two parts of light
    /// apart, `specular`.
    fn light_points(&self, work: &TableWork<'_>, points: &Points<'_>, tables: &mut Tables) {
        let TableWork { prepared, bindings, level, executor, .. } = *work;
        let frame = &self.space;
        let Tables { normals: flip_normal, diffuse, specular, .. } = tables;
        let model = self.transform().model;
        let linear = frame.axes * DMat3::from_mat4(model);
        let moved = frame.axes * (model.w_axis.truncate() - frame.origin);
        let to_frame = [0, 1, 2].map(|r| {
            let row = linear.row(r);
            [row.x, row.y, row.z, moved[r]]
        });
        let normals = match frame.has_own_normals {
            true => points.normals,
            false => {
                self.turn_normals(points.normals, executor, flip_normal);
                flip_normal
            }
        };
        let is_textured = bindings.iter().any(|s| s.texture.is_some());
        resize_in_huge_pages(diffuse, points.normals.len(), [0.0; 4]);
        resize_in_huge_pages(specular, if is_textured { points.normals.len() } else { 0 }, [0.0; 4]);
        let exact = |i: usize| {
            let position = [0, 1, 2].map(|a| points.positions[a][i]);
            let (_, material) = (points.run)(i, i + 1);
            self.exact_light(position, points.normals[i], prepared.materials[material])
        };
        let light = |i: usize, diffuse: &mut [[f32; 4]], specular: &mut [[f32; 4]]| {
            let (first, end) = (i * CHUNK_POINTS, i * CHUNK_POINTS + diffuse.len());
            let mut at = first;
            while at < end {
                let (until, material) = (points.run)(at, end);
                let until = until.min(end);
                let own = at - first..until - first;
                let specular: &mut [[f32; 4]] =
                    if specular.is_empty() { &mut [] } else { &mut specular[own.clone()] };
                level.dispatch(VertexLightingKernel {
                    lighting: &bindings[material].lighting,
                    eye: frame.eye,
                    to_frame,
                    positions: [0, 1, 2].map(|a| &points.positions[a][at..until]),
                    normals: &normals[at..until],
                    colors: points.colors.get(at..until).unwrap_or(&[]),
                    first: at,
                    exact: &exact,
                    diffuse: &mut diffuse[own],
                    specular,
                });
                at = until;
            }
        };
        match specular.is_empty() {
            true => executor.chunks(diffuse, CHUNK_POINTS, |i, diffuse| light(i, diffuse, &mut [])),
            false => executor.pairs(diffuse, specular, CHUNK_POINTS, light),
        }
    }

    /// Transforms object-space normals to unit normals in world space.
    fn turn_normals(&self, from: &[[f32; 4]], executor: &Executor, to: &mut Vec<[f32; 4]>) {
        resize_in_huge_pages(to, from.len(), [0.0; 4]);
        executor.chunks(to, CHUNK_POINTS, |i, run| {
            let from = &from[i * CHUNK_POINTS..][..run.len()];
            for (to, n) in run.iter_mut().zip(from) {
                let n = DVec3::new(n[0] as f64, n[1] as f64, n[2] as f64);
                let n = self.normal_matrix.apply(n).unwrap_or(DVec3::ZERO);
                *to = n.extend(0.0).as_vec4().to_array();
            }
        });
    }

    /// Fills `to` with the vertices' positions in shading space.
    pub(super) fn position_table(&self, work: &TableWork<'_>, to: &mut Vec<[f32; 4]>) {
        let TableWork { prepared, executor, .. } = *work;
        resize_in_huge_pages(to, prepared.vertex_count(), [0.0; 4]);
        executor.chunks(to, CHUNK_POINTS, |i, run| {
            for (k, to) in run.iter_mut().enumerate() {
                let at = i * CHUNK_POINTS + k;
                let [x, y, z] = [0, 1, 2].map(|axis| prepared.positions[axis][at]);
                let p = self.space.point(self.transform().world(DVec3::new(x, y, z)));
                *to = p.extend(0.0).as_vec4().to_array();
            }
        });
    }

    /// Returns both parts of the light at a point, computed in f64, without vertex colours.
    fn exact_light(&self, position: [f64; 3], normal: [f32; 4], polygon: u32) -> [[f32; 3]; 2] {
        let side = if self.call.cull == Cull::Front { Facing::Back } else { Facing::Front };
        let (material, _) = self.call.material_of(&self.call.geometry.mesh.polygons[polygon as usize], side);
        let n = DVec3::new(normal[0] as f64, normal[1] as f64, normal[2] as f64);
        let point = SurfacePoint {
            position: self.transform().world(DVec3::from(position)),
            normal: self.normal_matrix.apply(n).unwrap_or(DVec3::ZERO),
        };
        let lit = self.lighting.at(point, material);
        [f32s(lit.diffuse_ambient), f32s(lit.specular_emissive)]
    }
}

impl Lighting {
    /// Returns whether f32 kernels represent the lighting of a material. `point` and `direction`
    /// transform to the space in which they compute.
    pub(super) fn is_in_range(
        &self,
        material: &Material,
        point: impl Fn(DVec3) -> DVec3,
        direction: impl Fn(DVec3) -> DVec3,
    ) -> bool {
        let constant = self.constant(material);
        let parts = [constant.diffuse_ambient, constant.specular_emissive].map(f32s);
        parts.iter().flatten().all(|c| c.abs() < 1e30)
            && (!self.depends_on_point(material)
                || exponent(material).is_some()
                    && self.lights().iter().all(|l| l.fast(material, &point, &direction).is_some()))
    }

    /// Returns the lighting of a material that [`is_in_range`](Self::is_in_range), with its lights
    /// in a recycled list. Light up to `tolerance` is left out.
    pub(super) fn of_material(
        &self,
        material: &Material,
        tolerance: FaintLight,
        point: impl Fn(DVec3) -> DVec3,
        direction: impl Fn(DVec3) -> DVec3,
        mut lights: Vec<FastLight>,
    ) -> MaterialLighting {
        let constant = self.constant(material);
        let is_lit = self.depends_on_point(material);
        lights.clear();
        if is_lit {
            lights.extend(self.lights().iter().filter_map(|l| l.fast(material, &point, &direction)));
        }
        let mut material_lighting = MaterialLighting {
            diffuse: f32s(constant.diffuse_ambient),
            specular: f32s(constant.specular_emissive),
            lights,
            exponent: exponent(material).filter(|_| is_lit).unwrap_or(Exponent::Integer(0)),
            model: material.model,
            needs_place: self.depends_on_place(material),
        };
        material_lighting.find_dark_cosines(tolerance);
        material_lighting.find_least_cosines();
        if tolerance.faded > 0.0 {
            material_lighting.find_faded_distances(tolerance);
        }
        material_lighting
    }
}

/// Returns the specular exponent of a material; `None` if it is out of range.
fn exponent(material: &Material) -> Option<Exponent> {
    match material.ks == DVec3::ZERO {
        true => Some(Exponent::Integer(0)),
        false => Exponent::new(material.n),
    }
}

impl PreparedLight {
    /// Returns the light in the kernels' format. `point` and `direction` transform to the space in
    /// which they compute. Returns `None` if a value is out of range for f32.
    fn fast(
        &self,
        material: &Material,
        point: impl Fn(DVec3) -> DVec3,
        direction: impl Fn(DVec3) -> DVec3,
    ) -> Option<FastLight> {
        let light = &self.light;
        let at = |p: DVec3| LightPosition::At(f32s(point(p)));
        let axis = f32s(direction(self.direction));
        let (position, cone, radius, attenuation) = match light.kind {
            LightKind::Directional { .. } => {
                (LightPosition::Toward(axis), Cone::None, f64::INFINITY, Attenuation::NONE)
            }
            LightKind::Point { position, attenuation, radius } => {
                (at(position), Cone::None, radius, attenuation)
            }
            LightKind::Spot { position, exponent, attenuation, .. } => {
                let exponent = Exponent::new(exponent)?;
                let cone = Cone::Power { axis, cos_angle: self.cos_angle as f32, exponent };
                (at(position), cone, f64::INFINITY, attenuation)
            }
            LightKind::X3dSpot { position, beam_width_rad, cut_off_rad, attenuation, radius, .. } => {
                let (beam, cut_off) = (beam_width_rad as f32, cut_off_rad as f32);
                (at(position), Cone::Linear { axis, beam, cut_off }, radius, attenuation)
            }
        };
        let fast = FastLight {
            position,
            cone,
            // A negative radius reaches nothing, and has no square.
            reach2: if radius < 0.0 { -1.0 } else { (radius * radius) as f32 },
            is_reach_faded: false,
            ambient: f32s(material.ka * light.ambient),
            diffuse: f32s(material.kd * light.color),
            specular: f32s(material.ks * light.color),
            dark_cosine: -1.0,
            least_cosine2: -1.0,
            attenuation: (attenuation != Attenuation::NONE)
                .then(|| [attenuation.c, attenuation.l, attenuation.q].map(|v| v as f32)),
            is_clamped: light.clamp_attenuation,
        };
        let (LightPosition::At(p) | LightPosition::Toward(p)) = position;
        let values = [p, fast.ambient, fast.diffuse, fast.specular, fast.attenuation.unwrap_or_default()];
        (values.iter().flatten().all(|c| c.abs() < 1e15) && !radius.is_nan()).then_some(fast)
    }
}

/// Returns the run of faces with one material from `first` on: its end, and the material.
fn run_of_faces(materials: &[i32], first: usize, end: usize) -> (usize, usize) {
    let Some(&own) = materials.get(first) else { return (end, 0) };
    let length = materials[first..end].iter().take_while(|m| **m == own).count();
    (first + length, own as usize)
}
