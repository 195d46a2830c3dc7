//! A whole scene: background, opaque objects, then the transparent faces.

use super::call::{DepthUse, DrawCall, DrawStats, PipelineError, SceneOptions, Target};
use super::derive::{SORTED_BY_PAINTER, nothing_can_hide};
use super::known::Known;
use super::light::Lamp;
use super::plan::{Part, Plan, Title};
use super::prepare::{Layer, Prepared};
use super::raster::opaque;
use super::viewport::Screen;
use crate::scene::{HiddenSurface, Scene, ShadeMode, TransparencyOrder};
use std::fmt;
use std::sync::Arc;

/// Draws a scene: its background over the viewport, the opaque faces, lines and points, then the transparent faces in
/// file order or far to near.
///
/// # Errors
/// As [`super::draw`]; every object is looked at before anything is written, so the memories are then untouched.
pub fn draw_scene(
    target: &mut Target,
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawStats, PipelineError> {
    draw_scene_with(&mut Plain::default(), target, scene, options)
}

/// Lists that one scene leaves to the next, all of them empty.
#[derive(Default)]
pub(crate) struct SceneLists {
    calls: Vec<DrawCall<'static>>,
    prepared: Vec<Prepared<'static>>,
    /// Of each object, its lights.
    lamps: Vec<Vec<Lamp>>,
}

impl fmt::Debug for SceneLists {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SceneLists of {} bytes", self.size_bytes())
    }
}

impl SceneLists {
    /// Bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.calls.capacity() * size_of::<DrawCall>()
            + self.prepared.capacity() * size_of::<Prepared>()
            + self.lamps.capacity() * size_of::<Vec<Lamp>>()
            + self.lamps.iter().map(|l| l.capacity() * size_of::<Lamp>()).sum::<usize>()
    }
}

/// Who draws the parts of a scene.
pub(crate) trait Painter {
    /// What the last scene has left.
    fn lists(&mut self) -> &mut SceneLists;

    /// What is known of a draw's geometry.
    fn known(&mut self, call: &DrawCall) -> Arc<Known>;

    /// Draws the faces of one object that belong to a layer, in order; a wireframe whole.
    fn faces(&mut self, prepared: &mut Prepared, layer: Layer, target: &mut Target, stats: &mut DrawStats);

    /// Draws faces of several objects - object, triangle - in the list's order.
    fn listed(
        &mut self,
        all: &[&Prepared],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    );
}

/// The plain path.
#[derive(Default)]
struct Plain {
    lists: SceneLists,
}

impl Painter for Plain {
    fn lists(&mut self) -> &mut SceneLists {
        &mut self.lists
    }

    fn known(&mut self, call: &DrawCall) -> Arc<Known> {
        Arc::new(Known::of(call.geometry))
    }

    fn faces(&mut self, prepared: &mut Prepared, layer: Layer, target: &mut Target, stats: &mut DrawStats) {
        prepared.transform_all();
        if prepared.call.shade == ShadeMode::Wire {
            prepared.draw_wire(target, stats);
            return;
        }
        for triangle in prepared.face_order() {
            prepared.draw_face(triangle, layer, target, stats);
        }
    }

    fn listed(
        &mut self,
        all: &[&Prepared],
        list: &[(usize, u32)],
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        list.iter().for_each(|&(o, t)| all[o].draw_any_face(t, target, stats));
    }
}

/// [`draw_scene`] by a painter.
pub(crate) fn draw_scene_with(
    painter: &mut impl Painter,
    target: &mut Target,
    scene: &Scene,
    options: &SceneOptions,
) -> Result<DrawStats, PipelineError> {
    let SceneLists { calls, prepared: mut all, mut lamps } = std::mem::take(painter.lists());
    let mut calls: Vec<DrawCall> = calls;
    calls.extend(each_call(scene, options));
    let mut stats = DrawStats::default();
    let keeps_depth = !leaves_depth_out(&calls, options);
    // 1 to 3 for every object that is sorted with others, or that comes again for its transparent faces
    all.reserve(calls.len());
    lamps.resize_with(calls.len(), Vec::new);
    for (call, lamps) in calls.iter().zip(&mut lamps) {
        let lamps = std::mem::take(lamps);
        let mut prepared = Prepared::with(call, target, painter.known(call), lamps, &mut stats)?;
        if !keeps_depth {
            prepared.plan.leave_out(Part::DepthMemory, NOTHING_HIDDEN);
            prepared.plan.leave_out(Part::IdMemory, NOTHING_HIDDEN);
        }
        all.push(prepared);
    }
    if let Some(color) = scene.background.color {
        paint(target, options, opaque(color));
    }
    for prepared in &all {
        prepared.open_memories(target);
    }
    if options.hide == HiddenSurface::Painter {
        all.iter_mut().for_each(Prepared::transform_all);
        let opaque_faces = faces(&all, |p, t| !p.is_transparent(t));
        let list = sorted(&all, opaque_faces);
        painter.listed(&all.iter().collect::<Vec<_>>(), &list, target, &mut stats);
    }
    for prepared in &mut all {
        if prepared.call.shade == ShadeMode::Wire || options.hide != HiddenSurface::Painter {
            painter.faces(prepared, Layer::Opaque, target, &mut stats);
        }
        prepared.draw_lines(target, &mut stats);
        prepared.draw_points(target, &mut stats);
    }
    for prepared in all.iter_mut().filter(|p| p.plan.uses(Part::ReadBack)) {
        prepared.transform_all();
    }
    let through = faces(&all, |p, t| p.is_transparent(t));
    let through = match options.transparency {
        TransparencyOrder::Sorted => sorted(&all, through),
        TransparencyOrder::FileOrder => through,
    };
    if !through.is_empty() {
        painter.listed(&all.iter().collect::<Vec<_>>(), &through, target, &mut stats);
    }
    for (prepared, lamps) in all.drain(..).zip(&mut lamps) {
        *lamps = prepared.lighting.into_lamps();
    }
    calls = {
        let prepared = emptied(all);
        calls.clear();
        *painter.lists() = SceneLists { calls: Vec::new(), prepared, lamps };
        calls
    };
    painter.lists().calls = emptied(calls);
    Ok(stats)
}

/// An empty list's own memory for items of another life.
fn emptied<T, U>(list: Vec<T>) -> Vec<U> {
    debug_assert!(list.is_empty() && size_of::<T>() == size_of::<U>());
    list.into_iter().map(|_| -> U { unreachable!("the list is empty") }).collect()
}

const NOTHING_HIDDEN: &str = "the scene is known whole, and nothing in it can be hidden";

/// The plan of a whole scene: what any of its objects needs, and what they share.
///
/// # Errors
/// Never for the camera or the meshes: a plan can be printed of what [`draw_scene`] refuses.
pub fn plan_scene(target: &Target, scene: &Scene, options: &SceneOptions) -> Plan {
    let calls = calls_of(scene, options);
    let (width, height) = (target.memory.width(), target.memory.height());
    let title = Title::Scene { objects: calls.len() };
    let mut plan = Plan::of_frame(title, width, height, "nothing is drawn in 3-D");
    for call in &calls {
        plan.merge(&Plan::of_draw(call, target));
    }
    if leaves_depth_out(&calls, options) {
        plan.leave_out(Part::DepthMemory, NOTHING_HIDDEN);
        plan.leave_out(Part::IdMemory, NOTHING_HIDDEN);
    } else if options.depth_use == DepthUse::SceneOnly && plan.uses(Part::DepthMemory) {
        plan.explain(Part::DepthMemory, "HIDE zbuffer; faces may hide each other");
    }
    if options.hide == HiddenSurface::Painter && plan.uses(Part::SortFaces) {
        plan.explain(Part::SortFaces, SORTED_BY_PAINTER);
    } else if options.transparency == TransparencyOrder::Sorted && plan.uses(Part::ReadBack) {
        let (count, _) = (plan.item(Part::ReadBack).count, ());
        plan.add(Part::SortFaces, "transparent faces far to near, on request", count, count * 16);
    }
    plan
}

/// One call an object.
pub(super) fn calls_of<'a>(scene: &'a Scene, options: &SceneOptions) -> Vec<DrawCall<'a>> {
    each_call(scene, options).collect()
}

fn each_call<'a>(scene: &'a Scene, options: &SceneOptions) -> impl Iterator<Item = DrawCall<'a>> {
    let call = move |(index, object)| DrawCall {
        name: options.first_name.wrapping_add(index as u32),
        ..DrawCall::of_object(object, scene, options)
    };
    scene.objects.iter().enumerate().map(call)
}

fn leaves_depth_out(calls: &[DrawCall], options: &SceneOptions) -> bool {
    let one = match calls {
        [one] => one,
        _ => return false,
    };
    options.depth_use == DepthUse::SceneOnly
        && options.hide == HiddenSurface::ZBuffer
        && nothing_can_hide(one)
}

/// The faces of all objects that are wanted, in file order.
fn faces(all: &[Prepared], wanted: impl Fn(&Prepared, u32) -> bool) -> Vec<(usize, u32)> {
    let mut found = Vec::new();
    for (object, p) in all.iter().enumerate().filter(|(_, p)| p.call.shade != ShadeMode::Wire) {
        let triangles = 0..p.call.geometry.mesh.triangles.len() as u32;
        found.extend(triangles.filter(|&t| wanted(p, t)).map(|t| (object, t)));
    }
    found
}

/// The faces of all objects in the order in which [`draw_scene`] draws them.
pub(super) fn drawing_order(all: &[Prepared], options: &SceneOptions) -> Vec<(usize, u32)> {
    let sorted = |mut faces: Vec<(usize, u32)>| {
        faces.sort_by(|a, b| all[a.0].center_z(a.1).total_cmp(&all[b.0].center_z(b.1)));
        faces
    };
    let (mut order, through) =
        (faces(all, |p, t| !p.is_transparent(t)), faces(all, |p, t| p.is_transparent(t)));
    if options.hide == HiddenSurface::Painter {
        order = sorted(order);
    }
    order.extend(match options.transparency {
        TransparencyOrder::Sorted => sorted(through),
        TransparencyOrder::FileOrder => through,
    });
    order
}

/// Faces far to near by view z of their centres; equals stay in file order.
fn sorted(all: &[Prepared], faces: Vec<(usize, u32)>) -> Vec<(usize, u32)> {
    let mut keyed: Vec<_> = faces.into_iter().map(|(o, t)| (all[o].center_z(t), o, t)).collect();
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
    keyed.into_iter().map(|(_, object, triangle)| (object, triangle)).collect()
}

/// The background over the viewport.
fn paint(target: &mut Target, options: &SceneOptions, color: crate::memory::Rgba) {
    let width = target.memory.width();
    let clip = Screen::new(options.viewport, width, target.memory.height()).clip;
    if clip.is_empty() {
        return;
    }
    let pixels = target.memory.bytes_mut().as_chunks_mut::<4>().0;
    for y in clip.y0..clip.y1 {
        let row = width as usize * y as usize;
        pixels[row + clip.x0 as usize..row + clip.x1 as usize].fill(color);
    }
    target.memory.mark_rows(clip.y0 as u32..clip.y1 as u32);
}
