//! The renderer's workspace: every buffer that one draw leaves to the next.

use crate::pipeline::depth_sort::FaceOrder;
use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::geometry_cache::GeometryInfo;
use crate::pipeline::ordered::FaceList;
use crate::pipeline::prepared_draw::{PreparedDraw, RecycledLists};
use crate::pipeline::tile_frontend::DrawBatch;
use std::fmt;
use std::sync::Arc;

/// Buffers that one draw leaves to the next, so that a steady frame allocates nothing large.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    /// Lists of the last single draw.
    pub recycled: RecycledLists,
    /// Faces of one object that are drawn in submission order.
    pub order: FaceOrder,
    /// Prepared faces of such lists.
    pub face_list: FaceList,
    /// Buffers of the tile renderer.
    pub draw_batch: DrawBatch,
    /// Lists of the last scene.
    pub scene: SceneLists,
}

impl Workspace {
    /// Returns the bytes that the buffers take.
    pub fn size_bytes(&self) -> usize {
        self.scene.size_bytes()
            + self.recycled.size_bytes()
            + self.order.size_bytes()
            + self.draw_batch.size_bytes()
            + self.face_list.size_bytes()
    }
}

/// Empty lists that one scene leaves to the next for reuse.
#[derive(Default)]
pub(super) struct SceneLists {
    pub calls: Vec<DrawCall<'static>>,
    pub prepared: Vec<PreparedDraw<'static>>,
    pub geometry_infos: Vec<Arc<GeometryInfo>>,
    /// Per object, its lights and its vertices.
    pub recycled: Vec<RecycledLists>,
    pub order: FaceOrder,
}

impl fmt::Debug for SceneLists {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SceneLists of {} bytes", self.size_bytes())
    }
}

impl SceneLists {
    /// Returns the bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.calls.capacity() * size_of::<DrawCall>()
            + self.prepared.capacity() * size_of::<PreparedDraw>()
            + self.geometry_infos.capacity() * size_of::<Arc<GeometryInfo>>()
            + self.recycled.capacity() * size_of::<RecycledLists>()
            + self.recycled.iter().map(RecycledLists::size_bytes).sum::<usize>()
            + self.order.size_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_list_of_a_scene_counts_with_its_capacity() {
        let bytes = |fill: &dyn Fn(&mut SceneLists)| {
            let mut lists = SceneLists::default();
            fill(&mut lists);
            lists.size_bytes()
        };
        assert_eq!(bytes(&|_| {}), 0);
        let calls = bytes(&|lists| lists.calls.reserve_exact(2));
        assert_eq!(calls, 2 * size_of::<DrawCall>());
        let prepared = bytes(&|lists| lists.prepared.reserve_exact(3));
        assert_eq!(prepared, 3 * size_of::<PreparedDraw>());
        let infos = bytes(&|lists| lists.geometry_infos.reserve_exact(5));
        assert_eq!(infos, 5 * size_of::<usize>());
        let recycled = bytes(&|lists| lists.recycled.reserve_exact(7));
        assert_eq!(recycled, 7 * size_of::<RecycledLists>());
        let all = bytes(&|lists| {
            lists.calls.reserve_exact(2);
            lists.prepared.reserve_exact(3);
            lists.geometry_infos.reserve_exact(5);
            lists.recycled.reserve_exact(7);
        });
        assert_eq!(all, calls + prepared + infos + recycled);
    }
}
