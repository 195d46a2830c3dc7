//! The parts of the pipeline that a draw runs, without reasons and counts.
//!
//! In: decisions of the planner. Out: one bit per part. Every draw carries this set; a [`Plan`] with
//! reasons, counts and bytes is made only when somebody asks for it, by the same planner. Verified by
//! the tests of `plan`, which compare the two, and by tests/drawing/plan_paths.rs.

use super::{Part, Plan, PlanItem, Title};

/// A set of parts that run, or exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Parts(u32);

impl Parts {
    /// Returns whether `part` runs, or exists.
    pub fn uses(self, part: Part) -> bool {
        self.0 >> part as u32 & 1 != 0
    }

    /// Returns whether the draw depends on light.
    pub fn is_lit(self) -> bool {
        self.uses(Part::LightPixels) || self.uses(Part::LightVertices) || self.uses(Part::LightFaces)
    }
}

/// Record of the planner's decisions: of all that a [`Plan`] prints, or of the [`Parts`] alone.
pub(crate) trait PlanRecord {
    /// Creates the record of a frame alone, with `reason` for leaving out every other part.
    fn of_frame(title: Title, size: [u32; 2], reason: &'static str) -> Self;

    /// Marks a part as used, and adds `count` items and `bytes` bytes to it.
    fn add(&mut self, part: Part, reason: &'static str, count: u64, bytes: u64);

    /// Marks a part as unused for `reason`.
    fn leave_out(&mut self, part: Part, reason: &'static str);
}

impl PlanRecord for Parts {
    fn of_frame(_: Title, _: [u32; 2], _: &'static str) -> Self {
        Parts(1 << Part::VideoMemory as u32)
    }

    fn add(&mut self, part: Part, _: &'static str, _: u64, _: u64) {
        self.0 |= 1 << part as u32;
    }

    fn leave_out(&mut self, part: Part, _: &'static str) {
        self.0 &= !(1 << part as u32);
    }
}

impl PlanRecord for Plan {
    fn of_frame(title: Title, [width, height]: [u32; 2], reason: &'static str) -> Self {
        Plan::of_frame(title, width, height, reason)
    }

    fn add(&mut self, part: Part, reason: &'static str, count: u64, bytes: u64) {
        Plan::add(self, part, reason, count, bytes);
    }

    fn leave_out(&mut self, part: Part, reason: &'static str) {
        Plan::leave_out(self, part, reason);
    }
}

impl From<&Plan> for Parts {
    fn from(plan: &Plan) -> Self {
        let bit = |item: &PlanItem| u32::from(item.used) << item.part as u32;
        Parts(plan.items().iter().map(bit).sum())
    }
}
