//! Coordinates from 1e154, whose squares overflow, to 1e308: drawn or refused, and alike everywhere.

use super::{HardRow, Ways};
use crate::picture::Buffers;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Cull, Scene};
use fbptr_truth::scenes::{Case, lit_triangle};
use fbptr_truth::{Settings, Transparency};
use glam::DVec3;

/// Returns a row for each size.
pub(super) fn rows(ways: &Ways) -> Vec<HardRow> {
    let sizes = [1e150, 1e154, 1e160, 1e200, 1e300, 1e308];
    sizes.into_iter().flat_map(|size| [row(ways, size, false), row(ways, size, true)]).collect()
}

/// Returns a lit triangle with one corner, or all, at this distance from the origin.
fn case(size: f64, is_all: bool) -> Case {
    let mut scene: Scene = lit_triangle();
    for object in &mut scene.objects {
        object.cull = Cull::None;
        let mesh = &mut std::sync::Arc::make_mut(&mut object.geometry).mesh;
        let moved = if is_all { 3 } else { 1 };
        mesh.positions.iter_mut().take(moved).for_each(|p| *p *= DVec3::new(size, size, 1.0));
    }
    Case {
        name: format!("{} at {size:e}", if is_all { "all corners" } else { "one corner" }),
        scene,
        settings: Settings { transparency: Transparency::AtOnce, ..Settings::default() },
        format: DepthFormat::F32,
        width: 48,
        height: 36,
    }
}

fn row(ways: &Ways, size: f64, is_all: bool) -> HardRow {
    let case = case(size, is_all);
    let (drawn, others) = ways.draw(|renderer| Buffers::of_case(renderer, &case));
    let depths = drawn.depth.iter().flat_map(|d| (0..48 * 36).map(|i| d.z(i % 48, i / 48)));
    let bad = depths.filter(|z| !z.is_some_and(|z| (0.0..=1.0).contains(&z))).count();
    let drawn = match drawn.refusal {
        Some(refusal) => format!("refused: {refusal}"),
        None => "drawn".to_owned(),
    };
    HardRow {
        case: case.name,
        promise:
            "drawn or refused without a panic, depths in 0..1, the same by every level and number of threads"
                .into(),
        measured: format!("{drawn}; {bad} depths are none; {}", ways.described(&others)),
        passed: bad == 0 && others.is_empty(),
    }
}
