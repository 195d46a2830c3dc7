//! Cache of choices, so that an unchanged scene is not searched twice.
//!
//! A choice depends on the scene, the exact options, the frame's size and depth format, and E. It
//! does not depend on the contents of the memory. Meshes and textures are compared by identity, and
//! a key does not keep them alive; everything else is compared by value.

use super::{Budget, BudgetKind, Choice, choose};
use crate::memory::DepthFormat;
use crate::pipeline::draw_call::{PipelineError, SceneOptions};
use crate::pipeline::renderer::Renderer;
use crate::scene::{Geometry, Object, Sampling, Scene, Texture};
use std::collections::VecDeque;
use std::sync::{Arc, Weak};

/// Maximum number of cached choices.
const KEPT: usize = 64;
/// Maximum number of objects in all keys together; the last choice is kept in any case.
const KEPT_OBJECTS: usize = 1 << 16;

/// The most recent choices.
#[derive(Debug, Default)]
pub struct ChoiceCache {
    /// Newest first.
    kept: VecDeque<(CacheKey, Choice)>,
    searches: u64,
}

/// The shared data of an object, by identity.
#[derive(Debug)]
struct Shared {
    geometry: Weak<Geometry>,
    texture: Option<(Weak<Texture>, Sampling)>,
}

impl Shared {
    fn of(object: &Object) -> Shared {
        let texture = object.texture.as_ref().map(|(t, s)| (Arc::downgrade(t), *s));
        Shared { geometry: Arc::downgrade(&object.geometry), texture }
    }

    fn is_of(&self, object: &Object) -> bool {
        let same_texture = match (&self.texture, &object.texture) {
            (None, None) => true,
            (Some((a, sampling)), Some((b, other))) => std::ptr::eq(a.as_ptr(), &**b) && sampling == other,
            _ => false,
        };
        same_texture && std::ptr::eq(self.geometry.as_ptr(), &*object.geometry)
    }

    /// Returns whether both are still alive.
    fn is_alive(&self) -> bool {
        self.geometry.strong_count() > 0 && self.texture.as_ref().is_none_or(|t| t.0.strong_count() > 0)
    }
}

/// Everything that a choice depends on.
#[derive(Debug)]
struct CacheKey {
    /// The scene, without its objects' shared data.
    scene: Scene,
    shared: Vec<Shared>,
    options: SceneOptions,
    kind: BudgetKind,
    depth_format: DepthFormat,
    /// Width and height of the frame.
    size: [u32; 2],
    max_error: f64,
}

impl CacheKey {
    fn of(budget: &Budget) -> CacheKey {
        let nothing = Arc::default();
        let bare = |o: &Object| Object { geometry: Arc::clone(&nothing), texture: None, ..o.clone() };
        let from = budget.scene;
        let scene = Scene {
            camera: from.camera,
            ambient: from.ambient,
            lights: from.lights.clone(),
            objects: from.objects.iter().map(bare).collect(),
            background: from.background,
            sky: from.sky.clone(),
            fog: from.fog,
        };
        CacheKey {
            scene,
            shared: from.objects.iter().map(Shared::of).collect(),
            options: SceneOptions { first_name: 0, ..budget.options.clone() },
            kind: budget.kind,
            depth_format: budget.depth_format,
            size: [budget.width, budget.height],
            max_error: budget.max_error,
        }
    }

    fn is_of(&self, budget: &Budget) -> bool {
        let Scene { camera, ambient, lights, objects, background, sky, fog } = budget.scene;
        (self.kind, self.depth_format, self.size, self.max_error)
            == (budget.kind, budget.depth_format, [budget.width, budget.height], budget.max_error)
            && self.options == SceneOptions { first_name: 0, ..budget.options.clone() }
            && (self.scene.camera, self.scene.ambient) == (*camera, *ambient)
            && (self.scene.background, self.scene.fog) == (*background, *fog)
            && self.scene.sky == *sky
            && self.scene.lights == *lights
            && self.shared.len() == objects.len()
            && self.shared.iter().zip(objects).all(|(s, o)| s.is_of(o))
            && self.scene.objects.iter().zip(objects).all(|(a, b)| is_same_state(a, b))
    }
}

/// Returns whether two objects are drawn alike, apart from their shared data.
fn is_same_state(a: &Object, b: &Object) -> bool {
    (&a.material, &a.back_material, a.model) == (&b.material, &b.back_material, b.model)
        && (a.cull, a.two_sided_lighting, a.shade, &a.lights)
            == (b.cull, b.two_sided_lighting, b.shade, &b.lights)
        && a.style == b.style
}

impl ChoiceCache {
    /// Returns the cached choice for this budget, or searches by [`choose`] and caches the result.
    ///
    /// # Errors
    /// As [`choose`].
    pub fn choose(&mut self, renderer: &mut Renderer, budget: &Budget) -> Result<Choice, PipelineError> {
        if let Some(choice) = self.get(budget) {
            return Ok(choice);
        }
        let choice = choose(renderer, budget)?;
        self.insert(budget, choice.clone());
        Ok(choice)
    }

    /// Returns the cached choice for this budget, if there is one.
    pub fn get(&mut self, budget: &Budget) -> Option<Choice> {
        self.kept.retain(|(key, _)| key.shared.iter().all(Shared::is_alive));
        let found = self.kept.iter().position(|(key, _)| key.is_of(budget))?;
        let entry = self.kept.remove(found)?;
        let choice = entry.1.clone();
        self.kept.push_front(entry);
        Some(choice)
    }

    /// Caches a choice, and drops the oldest ones beyond the limits.
    pub fn insert(&mut self, budget: &Budget, choice: Choice) {
        self.searches += 1;
        self.kept.push_front((CacheKey::of(budget), choice));
        let mut objects = 0;
        let fits = |(key, _): &&(CacheKey, Choice)| {
            objects += key.shared.len();
            objects <= KEPT_OBJECTS
        };
        let fitting = self.kept.iter().take(KEPT).take_while(fits).count();
        self.kept.truncate(fitting.max(1));
    }

    /// Returns the number of searches so far.
    pub fn searches(&self) -> u64 {
        self.searches
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{HiddenSurface, Light, shapes};
    use crate::truth::scenes::{lit_triangle, object};
    use glam::{DMat4, DVec3};

    /// Requests a choice with `change` applied to the usual state; returns whether it was searched.
    fn is_searched(
        memo: &mut ChoiceCache,
        scene: &Scene,
        change: impl FnOnce(&mut Scene, &mut SceneOptions, &mut f64),
    ) -> bool {
        let (mut scene, mut options, mut max_error) = (scene.clone(), SceneOptions::new(24, 18), 4.0);
        change(&mut scene, &mut options, &mut max_error);
        let (kind, depth_format) = (BudgetKind::Scene, DepthFormat::F32);
        let budget =
            Budget { scene: &scene, options: &options, kind, depth_format, width: 24, height: 18, max_error };
        let before = memo.searches();
        let choice = memo.choose(&mut Renderer::default(), &budget).unwrap();
        assert_eq!(
            choice,
            choose(&mut Renderer::default(), &budget).unwrap(),
            "kept or searched, it is the same"
        );
        memo.searches() > before
    }

    #[test]
    fn the_same_state_is_searched_once_and_any_change_anew() {
        let mut scene = lit_triangle();
        scene.objects.push(object("ball", shapes::cuboid(DVec3::ONE).unwrap()));
        let mut memo = ChoiceCache::default();
        assert!(is_searched(&mut memo, &scene, |_, _, _| {}));
        assert!(!is_searched(&mut memo, &scene, |_, _, _| {}));
        // Neither an object's name nor its pick-buffer id changes a pixel.
        assert!(!is_searched(&mut memo, &scene, |s, o, _| (s.objects[0].name, o.first_name) =
            ("other".into(), 7)));
        type Change = fn(&mut Scene, &mut SceneOptions, &mut f64);
        let changes: [Change; 8] = [
            |s, _, _| s.objects[1].model = DMat4::from_translation(DVec3::X * 0.1),
            |s, _, _| s.objects[1].material.n = 3.0,
            |s, _, _| s.lights.push(Light::directional(DVec3::NEG_Z, DVec3::ONE)),
            |s, _, _| s.ambient = DVec3::splat(0.25),
            |s, _, _| s.objects.truncate(1),
            |s, _, _| s.objects[1].geometry = Arc::new(Geometry::clone(&s.objects[1].geometry)),
            |_, o, _| o.hide = HiddenSurface::None,
            |_, _, e| *e = 5.0,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            assert!(is_searched(&mut memo, &scene, change), "change {i}");
            assert!(!is_searched(&mut memo, &scene, |_, _, _| {}), "and back, after change {i}");
        }
    }

    #[test]
    fn a_mesh_that_is_gone_is_not_kept_alive_and_the_oldest_goes_first() {
        let mut memo = ChoiceCache::default();
        let scene = lit_triangle();
        let weak = Arc::downgrade(&scene.objects[0].geometry);
        assert!(is_searched(&mut memo, &scene, |_, _, _| {}));
        drop(scene);
        assert_eq!(weak.strong_count(), 0);
        let scene = lit_triangle();
        assert!(is_searched(&mut memo, &scene, |_, _, _| {}));
        assert_eq!(memo.kept.len(), 1);
        for i in 0..KEPT {
            assert!(is_searched(&mut memo, &scene, |_, _, e| *e = 100.0 + i as f64));
        }
        assert_eq!(memo.kept.len(), KEPT);
        assert!(is_searched(&mut memo, &scene, |_, _, _| {}));
    }
}
