//! From a prepared draw to the tile renderer's job: which draws it serves, and the tables that hold for all of their faces.
//!
//! Colours are worked in the shading frame: its origin is the eye (or, in parallel projections, the mesh's middle), its axes
//! are the mesh's own where the model turns, moves and scales evenly, so that normals need no work, and the world's
//! otherwise. What is found here is found in f64.

use super::assemble::Side;
use super::call::{DrawCall, DrawStats, Target};
use super::light::SurfacePoint;
use super::plan::{Part, Plan};
use super::prepare::Prepared;
use super::raster::opaque;
use super::shade::LightMode;
use super::tile::{
    self, Exponent, Eye, FRAME_LIMITS, Frame, Job, Keep, Lighting, PreparedMesh, Scratch, Shading, Source,
    Surface, TableKernel, TextureShade, ToScreen, View, WideFace, Workers,
};
use crate::memory::{DepthFormat, DepthWords};
use crate::scene::{Cull, HiddenSurface, Interpolation, ShadeMode};
use crate::simd::Level;
use glam::{DMat3, DVec3};

/// What the fast path works with.
pub(crate) struct Tools<'t> {
    pub level: Level,
    pub crew: &'t Workers,
    pub memories: &'t mut Memories,
}

/// Memories that are kept from draw to draw.
#[derive(Debug, Default)]
pub(crate) struct Memories {
    scratch: Scratch,
    tables: Tables,
}

#[derive(Debug, Default)]
struct Tables {
    normals: Vec<[f32; 4]>,
    positions: Vec<[f32; 4]>,
    matte: Vec<[f32; 4]>,
    gloss: Vec<[f32; 4]>,
}

impl Memories {
    /// Bytes that the memories take.
    pub fn size_bytes(&self) -> usize {
        let t = &self.tables;
        let records = t.normals.capacity() + t.positions.capacity() + t.matte.capacity() + t.gloss.capacity();
        self.scratch.size_bytes() + records * 16
    }
}

/// The most texels that a face may run over: beyond, f32 does not know which.
const LONGEST_RUN: f64 = 8192.0;

/// Points that one piece of table work takes.
const CHUNK_POINTS: usize = 4096;

/// Numbers that f32 and their squares carry.
const LARGEST: f64 = 1e15;

/// Why the tile renderer does not serve a draw, as far as the plan tells; `None` when it does.
pub(crate) fn obstacle(call: &DrawCall, target: &Target, plan: &Plan) -> Option<&'static str> {
    let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
    let mesh = &call.geometry.mesh;
    if mesh.triangles.is_empty() {
        return Some("no face");
    }
    if call.shade == ShadeMode::Wire {
        return Some("SHADE wire is drawn line by line");
    }
    if call.hide == HiddenSurface::Painter {
        return Some("HIDE painter sorts its faces");
    }
    if plan.uses(Part::DepthMemory) && target.depth_format != DepthFormat::F32 {
        return Some("only the f32 depth format has a fast form");
    }
    if plan.uses(Part::ReadBack) {
        return Some("transparent faces are blended one after the other");
    }
    if plan.uses(Part::Fog) {
        return Some("fog has no fast form");
    }
    if call.back_material.is_some() && call.cull != Cull::Front {
        return Some("a material for faces seen from behind has no fast form");
    }
    if width < FRAME_LIMITS.0 || width > FRAME_LIMITS.1 || height > FRAME_LIMITS.1 {
        return Some("the frame is too narrow, too wide or too high for vectors");
    }
    let is_lit = plan.uses(Part::LightVertices) || plan.uses(Part::LightFaces);
    if call.two_sided_lighting && call.cull != Cull::Back && is_lit {
        return Some("two-sided light at vertices or faces has no fast form");
    }
    if mesh.triangles.len() >= 1 << 30 || mesh.corners.len() >= 1 << 30 {
        return Some("the mesh is too large for vectors");
    }
    None
}

/// What a draw's shading rests on.
struct ShadingFrame {
    /// World to frame axes.
    axes: DMat3,
    /// Its origin in the world.
    origin: DVec3,
    /// Whether the mesh's normals are those of the frame.
    has_own_normals: bool,
    eye: Eye,
}

impl Prepared<'_> {
    /// Draws the opaque faces by the tile renderer; `false` when they turn out to be beyond it, and nothing was drawn.
    pub fn draw_fast(&self, tools: Tools<'_>, target: &mut Target, stats: &mut DrawStats) -> bool {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let is_lit = self.plan.uses(Part::LightPixels)
            || self.plan.uses(Part::LightVertices)
            || self.plan.uses(Part::LightFaces);
        let Some(frame) = self.shading_frame() else { return false };
        let prepared = self.known.prepared(mesh, is_lit && call.shade != ShadeMode::Flat);
        let Some(surfaces) = self.surfaces(prepared, &frame) else { return false };
        let Memories { scratch, tables } = tools.memories;
        let (level, crew) = (tools.level, tools.crew);
        let screen = self.transform().screen;
        let clip = screen.clip;
        if clip.is_empty() {
            // Everything is outside; the plain path counts it.
            return false;
        }
        let keep = match (call.cull, self.assembler.mirrored) {
            (Cull::None, _) => Keep::Both,
            (Cull::Back, false) | (Cull::Front, true) => Keep::CounterClockwise,
            (Cull::Back, true) | (Cull::Front, false) => Keep::Clockwise,
        };
        // Faces seen from behind turn: clockwise ones, unless something mirrors.
        let turned = match (call.two_sided_lighting, self.assembler.mirrored) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        };
        let needs_positions = call.shade == ShadeMode::Phong
            && is_lit
            && (call.interp == Interpolation::Affine || matches!(frame.eye, Eye::Parallel { .. }));
        let plain = |face: u32, own: &mut DrawStats| self.wide_face(face, own);
        let pixel = |face: u32, x: i32, y: i32| self.shaded_pixel(face, x, y);
        let result = crew.run(|| {
            let source = self.source(prepared, &frame, &surfaces, is_lit, level, crew, tables);
            let Tables { normals, positions, matte, gloss } = tables;
            if needs_positions {
                self.position_table(prepared, &frame, crew, positions);
            }
            let source = match source {
                Light::Pixels if frame.has_own_normals => Source::Pixels(&prepared.normals),
                Light::Pixels => Source::Pixels(normals),
                Light::Vertices => Source::Vertices(matte, gloss),
                Light::Faces => Source::Faces(matte, gloss),
                Light::Constant => Source::Constant,
            };
            let runs_colors =
                !mesh.colors.is_empty() && matches!(source, Source::Pixels(_) | Source::Constant);
            let job = Job {
                mesh: prepared,
                to_screen: self.to_screen(),
                keep,
                view: View { x0: clip.x0, y0: clip.y0, x1: clip.x1, y1: clip.y1 },
                shading: Shading {
                    source,
                    eye: frame.eye,
                    surfaces: &surfaces,
                    colors: if runs_colors { &prepared.colors } else { &[] },
                    texcoords: &prepared.texcoords,
                    positions: if needs_positions { positions } else { &[] },
                    is_affine: call.interp == Interpolation::Affine
                        && self.plan.uses(Part::PerspectiveDivision),
                    turned,
                    plain: &pixel,
                },
                plain: &plain,
                name: call.name,
            };
            let (width, size) = (target.memory.width(), (target.memory.width(), target.memory.height()));
            let has_depth = self.plan.uses(Part::DepthMemory);
            let depth = match target.depth.as_mut().filter(|_| has_depth).map(|d| d.words_mut()) {
                Some(DepthWords::Wide(words)) => words,
                _ => &mut [],
            };
            let pick = match target.ids.as_deref_mut().filter(|i| (i.width(), i.height()) == size) {
                Some(ids) if has_depth => ids.ids_mut(),
                _ => &mut [],
            };
            let bytes = target.memory.bytes_mut();
            tile::render(level, crew, scratch, &job, Frame { width: width as usize, bytes, depth, pick })
        });
        target.memory.mark_rows(result.rows.0..result.rows.1);
        let mut draw = result.draw;
        // Counted as the plain path does it, which lights what is overdrawn too.
        if self.plan.uses(Part::LightPixels) {
            draw.pixels_lit = draw.pixels_written;
        } else if self.plan.uses(Part::LightVertices) {
            draw.vertices_lit = draw.faces_drawn * 3;
        } else if self.plan.uses(Part::LightFaces) {
            draw.vertices_lit = draw.faces_drawn;
        }
        *stats += draw;
        true
    }

    /// The steps of an object's points to the screen.
    pub fn to_screen(&self) -> ToScreen {
        let t = self.transform();
        let rows = |m: &glam::DMat4| m.transpose().to_cols_array_2d();
        let three = |m: [[f64; 4]; 4]| [m[0], m[1], m[2]];
        let clip = t.screen.clip;
        let sides = [[clip.x0 as f64, clip.x1 as f64], [clip.y0 as f64, clip.y1 as f64]];
        let (center, half) = t.screen.map();
        ToScreen {
            model: three(rows(&t.model)),
            view: three(rows(&t.camera.view)),
            projection: rows(&t.camera.projection),
            center,
            half,
            sides,
        }
    }

    /// The shading frame; `None` where numbers leave f32.
    fn shading_frame(&self) -> Option<ShadingFrame> {
        let t = self.transform();
        let linear = DMat3::from_mat4(t.model);
        let own = evenly_turned(&linear);
        let axes = own.unwrap_or(DMat3::IDENTITY);
        let (low, high) = self.known.bounds?;
        let center = t.world((low + high) * 0.5);
        let reach = (t.model.transform_vector3(high - low)).abs().max_element()
            + linear.to_cols_array().iter().fold(0.0f64, |m, v| m.max(v.abs())) * (high - low).max_element();
        let origin = if t.camera.is_parallel { center } else { t.camera.eye };
        let farthest = (center - origin).length() + reach;
        if !(1e-12..LARGEST).contains(&farthest) {
            return None;
        }
        let eye = match t.camera.is_parallel {
            true => Eye::Parallel { to_viewer: f32s(axes * t.camera.to_viewer) },
            false => Eye::Perspective { ray: self.rays(&axes)? },
        };
        Some(ShadingFrame { axes, origin, has_own_normals: own.is_some(), eye })
    }

    /// The point that a pixel shows is its ray times w, from the eye: at pixel (0,0), per column, per row.
    fn rays(&self, axes: &DMat3) -> Option<[[f32; 3]; 3]> {
        let t = self.transform();
        let whole = t.camera.projection * t.camera.view;
        let [x, y, _, w] = [0, 1, 2, 3].map(|r| whole.row(r));
        let rows = [x, y, w].map(|r| r.truncate());
        let from_eye = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        // Points reach the eye itself with w = 0, in every perspective that has its eye where the camera says.
        let at_eye = [x, y, w].map(|r| r.dot(t.camera.eye.extend(1.0)).abs());
        let size = from_eye.to_cols_array().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let slack = 1e-9 * size * (1.0 + t.camera.eye.abs().max_element());
        if at_eye.iter().any(|v| v.is_nan() || *v > slack) {
            return None;
        }
        let back = from_eye.inverse();
        if !back.is_finite() {
            return None;
        }
        let ray = |x: i32, y: i32| {
            let ndc = t.screen.ndc_of_pixel(x, y);
            *axes * (back * DVec3::new(ndc[0], ndc[1], 1.0))
        };
        let first = ray(0, 0);
        let rays = [first, ray(1, 0) - first, ray(0, 1) - first];
        rays.iter().all(|r| r.is_finite() && r.length() < LARGEST).then(|| rays.map(f32s))
    }

    /// The materials as the kernels want them; `None` where f32 does not carry one.
    fn surfaces<'s>(&'s self, prepared: &PreparedMesh, frame: &ShadingFrame) -> Option<Vec<Surface<'s>>> {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let side = if call.cull == Cull::Front { Side::Back } else { Side::Front };
        let mut surfaces = Vec::with_capacity(prepared.materials.len());
        for &polygon in &prepared.materials {
            let (material, texture) = call.material_of(&mesh.polygons[polygon as usize], side);
            let is_lit = self.lighting.depends_on_point(material);
            let constant = self.lighting.constant(material);
            let mut lighting = Lighting {
                matte: f32s(constant.base),
                gloss: f32s(constant.extra),
                lights: Vec::new(),
                exponent: Exponent::Whole(0),
                model: material.model,
            };
            if is_lit {
                if material.ks != DVec3::ZERO {
                    lighting.exponent = Exponent::new(material.n)?;
                }
                lighting.lights =
                    self.lighting.fast(material, |p| frame.axes * (p - frame.origin), |d| frame.axes * d)?;
            }
            let finite = |v: [f32; 3]| v.iter().all(|c| c.abs() < 1e30);
            if !(finite(lighting.matte) && finite(lighting.gloss)) {
                return None;
            }
            let texture = match texture {
                // A file may leave out what the texture needs: then the face has none.
                Some(_) if !prepared.has_all_texcoords => return None,
                Some(texture) => {
                    let texels = texture.width().max(texture.height()) as f64;
                    let run = prepared.longest_texcoord_run * texels;
                    if run.is_nan() || run > LONGEST_RUN {
                        return None;
                    }
                    Some(TextureShade { texture, sampling: call.sampling })
                }
                None => None,
            };
            surfaces.push(Surface { lighting, texture });
        }
        Some(surfaces)
    }

    /// Works out the tables that the light needs, and says where colours come from.
    #[expect(clippy::too_many_arguments, reason = "one call, in one place")]
    fn source(
        &self,
        prepared: &PreparedMesh,
        frame: &ShadingFrame,
        surfaces: &[Surface<'_>],
        is_lit: bool,
        level: Level,
        crew: &Workers,
        tables: &mut Tables,
    ) -> Light {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let is_textured = surfaces.iter().any(|s| s.texture.is_some());
        let model = self.transform().model;
        let linear = frame.axes * DMat3::from_mat4(model);
        let moved = frame.axes * (model.w_axis.truncate() - frame.origin);
        let to_frame = [0, 1, 2].map(|r| {
            let row = linear.row(r);
            [row.x, row.y, row.z, moved[r]]
        });
        match call.shade {
            ShadeMode::Flat if is_lit || !mesh.colors.is_empty() => {
                let table = self.known.faces(mesh);
                let normals = match frame.has_own_normals {
                    true => &table.normals,
                    false => {
                        self.turn_normals(&table.normals, crew, &mut tables.normals);
                        &tables.normals
                    }
                };
                let gloss_len = if is_textured { table.normals.len() } else { 0 };
                tables.matte.resize(table.normals.len(), [0.0; 4]);
                tables.gloss.resize(gloss_len, [0.0; 4]);
                let exact = |i: usize| {
                    self.exact_light(
                        [0, 1, 2].map(|a| table.centers[a][i]),
                        table.normals[i],
                        prepared.face_materials.get(i).copied(),
                        prepared,
                    )
                };
                let runs = |first: usize, end: usize| runs_of_faces(&prepared.face_materials, first, end);
                let points = Points { positions: &table.centers, normals, colors: &table.colors };
                light_points(
                    level,
                    crew,
                    frame.eye,
                    to_frame,
                    points,
                    surfaces,
                    &runs,
                    &exact,
                    &mut tables.matte,
                    &mut tables.gloss,
                );
                Light::Faces
            }
            ShadeMode::Gouraud if is_lit => {
                let normals = match frame.has_own_normals {
                    true => &prepared.normals,
                    false => {
                        self.turn_normals(&prepared.normals, crew, &mut tables.normals);
                        &tables.normals
                    }
                };
                let count = prepared.vertex_count();
                tables.matte.resize(count, [0.0; 4]);
                tables.gloss.resize(if is_textured { count } else { 0 }, [0.0; 4]);
                let material = |i: usize| {
                    let run = prepared.vertex_runs.partition_point(|(end, _)| *end <= i);
                    prepared.vertex_runs.get(run).map(|r| r.1 as i32)
                };
                let exact = |i: usize| {
                    self.exact_light(
                        [0, 1, 2].map(|a| prepared.positions[a][i]),
                        prepared.normals[i],
                        material(i),
                        prepared,
                    )
                };
                let runs = |first: usize, _: usize| {
                    let run = prepared.vertex_runs.partition_point(|(end, _)| *end <= first);
                    prepared.vertex_runs[run]
                };
                let points = Points { positions: &prepared.positions, normals, colors: &prepared.colors };
                light_points(
                    level,
                    crew,
                    frame.eye,
                    to_frame,
                    points,
                    surfaces,
                    &runs,
                    &exact,
                    &mut tables.matte,
                    &mut tables.gloss,
                );
                Light::Vertices
            }
            ShadeMode::Phong if is_lit => {
                if !frame.has_own_normals {
                    self.turn_normals(&prepared.normals, crew, &mut tables.normals);
                }
                Light::Pixels
            }
            _ => Light::Constant,
        }
    }

    /// Object-space normals to unit normals in the world.
    fn turn_normals(&self, from: &[[f32; 4]], crew: &Workers, to: &mut Vec<[f32; 4]>) {
        to.resize(from.len(), [0.0; 4]);
        crew.chunks(to, CHUNK_POINTS, |i, run| {
            let from = &from[i * CHUNK_POINTS..][..run.len()];
            for (to, n) in run.iter_mut().zip(from) {
                let n = DVec3::new(n[0] as f64, n[1] as f64, n[2] as f64);
                let n = self.normal_matrix.apply(n).unwrap_or(DVec3::ZERO);
                *to = n.extend(0.0).as_vec4().to_array();
            }
        });
    }

    /// Positions in the shading frame.
    fn position_table(
        &self,
        prepared: &PreparedMesh,
        frame: &ShadingFrame,
        crew: &Workers,
        to: &mut Vec<[f32; 4]>,
    ) {
        to.resize(prepared.vertex_count(), [0.0; 4]);
        crew.chunks(to, CHUNK_POINTS, |i, run| {
            for (k, to) in run.iter_mut().enumerate() {
                let at = i * CHUNK_POINTS + k;
                let [x, y, z] = [0, 1, 2].map(|axis| prepared.positions[axis][at]);
                let p = frame.axes * (self.transform().world(DVec3::new(x, y, z)) - frame.origin);
                *to = p.extend(0.0).as_vec4().to_array();
            }
        });
    }

    /// The light at a point in f64, in its two parts, without vertex colours.
    fn exact_light(
        &self,
        position: [f64; 3],
        normal: [f32; 4],
        material: Option<i32>,
        prepared: &PreparedMesh,
    ) -> [[f32; 3]; 2] {
        let polygon = prepared.materials[material.unwrap_or(0) as usize];
        let side = if self.call.cull == Cull::Front { Side::Back } else { Side::Front };
        let (material, _) = self.call.material_of(&self.call.geometry.mesh.polygons[polygon as usize], side);
        let n = DVec3::new(normal[0] as f64, normal[1] as f64, normal[2] as f64);
        let point = SurfacePoint {
            position: self.transform().world(DVec3::from(position)),
            normal: self.normal_matrix.apply(n).unwrap_or(DVec3::ZERO),
        };
        let lit = self.lighting.at(point, material);
        [f32s(lit.base), f32s(lit.extra)]
    }

    /// A face as the plain path sets it up.
    fn wide_face(&self, triangle: u32, stats: &mut DrawStats) -> Option<WideFace> {
        let corners = self.corner_vertices(triangle);
        let face = self.assembler.face(corners.each_ref(), stats)?;
        let screen = &self.transform().screen;
        let is_cut = corners.iter().any(|v| v.clip.w.is_nan() || v.clip.w <= 0.0);
        let bounds = self.bounds_of(triangle);
        let plane = face.plane.linear(screen, self.call.interp);
        // How far the shares run over 16 columns: weight b times w is a share.
        let runs = |k: usize| 16.0 * plane.shares[k][1].abs() * corners[k].clip.w.abs();
        let is_gentle = !is_cut && (0..3).all(|k| runs(k) < 16.0);
        Some(WideFace {
            face: triangle,
            bounds,
            plane,
            is_between: face.wholly_between_near_and_far,
            z_range: match is_cut {
                true => [f32::NEG_INFINITY, f32::INFINITY],
                false => {
                    let z = corners.map(|v| (v.clip.z / v.clip.w) as f32);
                    [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])]
                }
            },
            is_cut,
            is_gentle,
            is_turned: self.call.two_sided_lighting && face.side == Side::Back,
            outlines: face.outlines,
        })
    }

    /// The bytes of one pixel of a face, as the plain path shades it.
    fn shaded_pixel(&self, triangle: u32, x: i32, y: i32) -> [u8; 4] {
        let stats = &mut DrawStats::default();
        let Some(face) = self.assemble(triangle, stats) else { return [0, 0, 0, 255] };
        let shade = self.shade(triangle, face.side, stats);
        let divide = self.plan.uses(Part::PerspectiveDivision);
        match face.pixel(
            &shade,
            [x, y],
            &self.transform().screen,
            &self.lighting,
            (self.call.interp, divide),
            stats,
        ) {
            Some((rgb, _)) => opaque(rgb),
            // Beyond the horizon of its plane: the face's colour at its middle.
            None => match shade.light {
                LightMode::Constant(lit) => opaque(lit.base + lit.extra),
                _ => {
                    let third = [1.0 / 3.0; 3];
                    opaque(shade.at(third, |_| super::sample::Footprint::Horizon, &self.lighting, stats).0)
                }
            },
        }
    }
}

/// Where colours come from, before the tables are lent out.
enum Light {
    Pixels,
    Vertices,
    Faces,
    Constant,
}

/// Points to be lit.
struct Points<'a> {
    positions: &'a [Vec<f64>; 3],
    normals: &'a [[f32; 4]],
    colors: &'a [[f32; 4]],
}

/// Lights points, run by run of one material. `runs` gives the end and the material of the run that begins at a point.
#[expect(clippy::too_many_arguments, reason = "one call for two kinds of points")]
fn light_points(
    level: Level,
    crew: &Workers,
    eye: Eye,
    to_frame: [[f64; 4]; 3],
    points: Points<'_>,
    surfaces: &[Surface<'_>],
    runs: &(impl Fn(usize, usize) -> (usize, usize) + Sync),
    exact: &(dyn Fn(usize) -> [[f32; 3]; 2] + Sync),
    matte: &mut [[f32; 4]],
    gloss: &mut [[f32; 4]],
) {
    let work = |i: usize, matte: &mut [[f32; 4]], gloss: &mut [[f32; 4]]| {
        let (first, end) = (i * CHUNK_POINTS, i * CHUNK_POINTS + matte.len());
        let mut at = first;
        while at < end {
            let (until, material) = runs(at, end);
            let until = until.min(end);
            let own = at - first..until - first;
            let gloss: &mut [[f32; 4]] = if gloss.is_empty() { &mut [] } else { &mut gloss[own.clone()] };
            level.dispatch(TableKernel {
                lighting: &surfaces[material].lighting,
                eye,
                to_frame,
                positions: [0, 1, 2].map(|a| &points.positions[a][at..until]),
                normals: &points.normals[at..until],
                colors: points.colors.get(at..until).unwrap_or(&[]),
                first: at,
                exact,
                matte: &mut matte[own],
                gloss,
            });
            at = until;
        }
    };
    match gloss.is_empty() {
        true => crew.chunks(matte, CHUNK_POINTS, |i, matte| work(i, matte, &mut [])),
        false => crew.pairs(matte, gloss, CHUNK_POINTS, work),
    }
}

/// The run of faces of one material from `first` on: its end, and the material.
fn runs_of_faces(materials: &[i32], first: usize, end: usize) -> (usize, usize) {
    let Some(&own) = materials.get(first) else { return (end, 0) };
    let length = materials[first..end].iter().take_while(|m| **m == own).count();
    (first + length, own as usize)
}

/// The turn that takes the world's axes to a mesh's own, where its model turns, moves and scales evenly.
fn evenly_turned(linear: &DMat3) -> Option<DMat3> {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let s2 = x.length_squared();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * s2;
    let even = s2 > 1e-200
        && s2 < 1e200
        && close(y.length_squared(), s2)
        && close(z.length_squared(), s2)
        && close(x.dot(y), 0.0)
        && close(y.dot(z), 0.0)
        && close(z.dot(x), 0.0)
        && linear.determinant() > 0.0;
    even.then(|| (*linear * (1.0 / s2.sqrt())).transpose())
}

fn f32s(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
