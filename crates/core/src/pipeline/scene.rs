//! The draw calls of a scene, and the order of its faces.

use super::depth_sort::FaceOrder;
use super::draw_call::{DepthUse, DrawCall, SceneOptions};
use super::geometry_cache::GeometryInfo;
use super::planner::cannot_self_occlude;
use super::prepared_draw::PreparedDraw;
use crate::cancel::CancelToken;
use crate::scene::{HiddenSurface, Scene, TransparencyOrder};

/// Reason printed when a scene needs no depth.
pub(crate) const NOTHING_HIDDEN: &str = "the scene is known whole, and nothing in it can be hidden";

/// Returns the draw calls of a scene, one per object.
pub(crate) fn calls_of<'a>(scene: &'a Scene, options: &SceneOptions) -> Vec<DrawCall<'a>> {
    each_call(scene, options).collect()
}

/// Iterates over the draw calls of a scene, one per object, with consecutive pick-buffer values.
pub(crate) fn each_call<'a>(scene: &'a Scene, options: &SceneOptions) -> impl Iterator<Item = DrawCall<'a>> {
    let call = move |(index, object)| DrawCall {
        name: options.first_name.wrapping_add(index as u32),
        ..DrawCall::of_object(object, scene, options)
    };
    scene.objects.iter().enumerate().map(call)
}

/// Returns whether depth is unnecessary: a single object that cannot hide itself, and no later use
/// of depth. `geometry_info` are the facts about the first object's mesh, if there are any.
pub(crate) fn leaves_depth_out(
    calls: &[DrawCall],
    geometry_info: Option<&GeometryInfo>,
    options: &SceneOptions,
) -> bool {
    let one = match calls {
        [one] => one,
        _ => return false,
    };
    options.depth_use == DepthUse::SceneOnly
        && options.hide == HiddenSurface::ZBuffer
        && cannot_self_occlude(one, geometry_info)
}

/// Returns the faces of all objects in the order in which a scene draws them.
pub(crate) fn drawing_order(all: &[PreparedDraw], options: &SceneOptions) -> Vec<(usize, u32)> {
    let mut order = FaceOrder::default();
    let mut face_list = |is_through: bool, is_sorted: bool| {
        order.collect_faces(all, |p, t| p.is_transparent(t) == is_through);
        if is_sorted {
            order.sort(all, &CancelToken::default());
        }
        order.list().to_vec()
    };
    let mut list = face_list(false, options.hide == HiddenSurface::Painter);
    list.extend(face_list(true, options.transparency == TransparencyOrder::Sorted));
    list
}
