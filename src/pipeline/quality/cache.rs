//! Choices kept from frame to frame, and what is known of meshes.
//!
//! In: the states that a stream of commands draws, one after the other. Out: their choices. A new
//! state gets what is proven for it, which costs microseconds, so a moving camera needs no search. A
//! state that was drawn [`TRY_AFTER`] times is tried out once. A mesh is measured the second time
//! that it is seen, so that meshes made for one frame cost nothing; meshes of more than
//! [`MOST_FACES`] faces, and of more than a seventh of the frame's pixels, are not measured: their
//! faces are too many for cheaper shading to pay.
//!
//! A choice depends on the scene, the exact options, the frame's size and depth format, and E. It
//! does not depend on the contents of the memory. Meshes and textures are compared by identity, and
//! a key does not keep them alive; everything else is compared by value.

use super::{Budget, BudgetKind, Choice, MeshShape, prove};
use crate::memory::DepthFormat;
use crate::pipeline::draw_call::SceneOptions;
use crate::scene::{Geometry, Object, Sampling, Scene, Texture};
use std::collections::VecDeque;
use std::sync::{Arc, Weak};

/// Number of draws of one state after which it is tried out: a trial draws two frames, and compares
/// them pixel by pixel.
pub const TRY_AFTER: u32 = 100;
/// Maximum number of faces of a mesh that is measured.
pub const MOST_FACES: usize = 100_000;
/// Maximum number of cached choices.
const KEPT: usize = 64;
/// Maximum number of objects in all keys together; the last choice is kept in any case.
const KEPT_OBJECTS: usize = 1 << 16;
/// Maximum number of meshes that are remembered.
const KEPT_MESHES: usize = 1024;

/// The most recent choices.
#[derive(Debug, Default)]
pub struct ChoiceCache {
    /// Newest first.
    kept: VecDeque<Kept>,
    meshes: Vec<(Weak<Geometry>, Known)>,
    trials: u64,
}

/// A state and its choice.
#[derive(Debug)]
struct Kept {
    key: CacheKey,
    choice: Choice,
    draws: u32,
    /// True if some mesh was seen for the first time.
    has_new_mesh: bool,
}

/// Knowledge of a mesh.
#[derive(Clone, Copy, Debug)]
enum Known {
    SeenOnce,
    Measured(Option<MeshShape>),
}

/// Result of a look-up.
#[derive(Clone, Debug, PartialEq)]
pub enum Search {
    /// The choice to draw with.
    Use(Choice),
    /// The choice so far; the state has been drawn so often that it is to be tried out.
    TryOut(Choice),
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
    /// Counts a draw of a state, and returns its choice.
    pub fn look_up(&mut self, budget: &Budget) -> Search {
        let is_alive = |kept: &Kept| kept.key.shared.iter().all(Shared::is_alive);
        if let Some(found) = self.kept.iter().position(|kept| kept.key.is_of(budget) && is_alive(kept))
            && let Some(mut kept) = self.kept.remove(found)
        {
            kept.draws = kept.draws.saturating_add(1);
            if kept.has_new_mesh {
                (kept.choice, kept.has_new_mesh) = self.prove(budget);
            }
            let choice = kept.choice.clone();
            let is_due = kept.draws == TRY_AFTER;
            self.kept.push_front(kept);
            return if is_due { Search::TryOut(choice) } else { Search::Use(choice) };
        }
        let (choice, has_new_mesh) = self.prove(budget);
        self.kept.retain(is_alive);
        self.kept.push_front(Kept {
            key: CacheKey::of(budget),
            choice: choice.clone(),
            draws: 1,
            has_new_mesh,
        });
        let mut objects = 0;
        let fits = |kept: &&Kept| {
            objects += kept.key.shared.len();
            objects <= KEPT_OBJECTS
        };
        let fitting = self.kept.iter().take(KEPT).take_while(fits).count();
        self.kept.truncate(fitting.max(1));
        Search::Use(choice)
    }

    /// Replaces the choice of a state that was tried out.
    pub fn replace(&mut self, budget: &Budget, choice: Choice) {
        self.trials += 1;
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.key.is_of(budget)) {
            kept.choice = choice;
        }
    }

    /// Returns the number of trials so far.
    pub fn trials(&self) -> u64 {
        self.trials
    }

    /// Returns what is proven for a state, and whether some mesh was seen for the first time.
    fn prove(&mut self, budget: &Budget) -> (Choice, bool) {
        let pixels = budget.width as usize * budget.height as usize;
        let most_faces = MOST_FACES.min(pixels / 7);
        let mut has_new_mesh = false;
        let choice = prove(budget, |geometry| match self.known_of(geometry, most_faces) {
            Known::Measured(shape) => shape,
            Known::SeenOnce => {
                has_new_mesh = true;
                None
            }
        });
        (choice, has_new_mesh)
    }

    /// Returns what is known of a mesh, which is measured the second time that it is seen.
    fn known_of(&mut self, geometry: &Arc<Geometry>, most_faces: usize) -> Known {
        if geometry.mesh.triangles.len() > most_faces {
            return Known::Measured(None);
        }
        let address = Arc::as_ptr(geometry);
        if let Some((_, known)) = self.meshes.iter_mut().find(|(mesh, _)| mesh.as_ptr() == address) {
            if let Known::SeenOnce = known {
                *known = Known::Measured(MeshShape::of(&geometry.mesh));
            }
            return *known;
        }
        if self.meshes.len() >= KEPT_MESHES {
            self.meshes.retain(|(mesh, _)| mesh.strong_count() > 0);
            self.meshes.truncate(KEPT_MESHES / 2);
        }
        self.meshes.push((Arc::downgrade(geometry), Known::SeenOnce));
        Known::SeenOnce
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{HiddenSurface, Light, shapes};
    use crate::truth::scenes::{lit_triangle, object};
    use glam::{DMat4, DVec3};

    /// Looks up the usual state with `change` applied to it; returns its choice, or `None` if it is
    /// to be tried out.
    fn look_up(
        cache: &mut ChoiceCache,
        scene: &Scene,
        change: impl FnOnce(&mut Scene, &mut SceneOptions, &mut f64),
    ) -> Option<Choice> {
        let (mut scene, mut options, mut max_error) = (scene.clone(), SceneOptions::new(64, 48), 4.0);
        change(&mut scene, &mut options, &mut max_error);
        let (kind, depth_format) = (BudgetKind::Scene, DepthFormat::F32);
        let budget =
            Budget { scene: &scene, options: &options, kind, depth_format, width: 64, height: 48, max_error };
        match cache.look_up(&budget) {
            Search::Use(choice) => Some(choice),
            Search::TryOut(choice) => {
                cache.replace(&budget, choice);
                None
            }
        }
    }

    #[test]
    fn a_mesh_pays_from_its_second_frame_on_wherever_it_is_seen_from() {
        let mut cache = ChoiceCache::default();
        let scene = lit_triangle();
        assert!(look_up(&mut cache, &scene, |_, _, _| {}).unwrap().is_exact());
        for i in 1..20 {
            let turn = DMat4::from_rotation_z(0.1 * f64::from(i));
            let choice = look_up(&mut cache, &scene, |s, _, _| s.objects[0].model = turn).unwrap();
            assert!(!choice.is_exact(), "{choice}");
        }
        // So does the state that it was first seen in.
        assert!(!look_up(&mut cache, &scene, |_, _, _| {}).unwrap().is_exact());
    }

    #[test]
    fn a_state_is_tried_out_once_after_its_hundredth_draw() {
        let mut cache = ChoiceCache::default();
        let mut scene = lit_triangle();
        scene.objects.push(object("ball", shapes::sphere(0.5).unwrap()));
        let due: Vec<u32> =
            (1..=250).filter(|_| look_up(&mut cache, &scene, |_, _, _| {}).is_none()).collect();
        assert_eq!((due, cache.trials()), (vec![TRY_AFTER], 1));
        // Any other state is counted by itself.
        let others: [fn(&mut Scene, &mut SceneOptions, &mut f64); 6] = [
            |_, _, e| *e = 5.0,
            |_, o, _| o.hide = HiddenSurface::Painter,
            |s, _, _| s.lights.push(Light::point(DVec3::ONE, DVec3::ONE)),
            |s, _, _| s.objects[0].material.kd.x = 0.3,
            |s, _, _| s.objects[1].model = DMat4::from_translation(DVec3::X),
            |s, _, _| s.objects[0].geometry = Arc::new((*s.objects[0].geometry).clone()),
        ];
        for change in others {
            for draw in 1..TRY_AFTER {
                // A geometry of its own does not outlive the draw.
                assert!(look_up(&mut cache, &scene, change).is_some(), "{draw}");
            }
        }
        // What is written to the pick buffer does not count.
        let due = (0..250).filter(|_| look_up(&mut cache, &scene, |_, o, _| o.first_name = 77).is_none());
        assert_eq!(due.count(), 0);
    }

    #[test]
    fn the_oldest_states_are_dropped() {
        let mut cache = ChoiceCache::default();
        let scene = lit_triangle();
        for i in 0..200 {
            look_up(&mut cache, &scene, |_, _, e| *e = 1.0 + f64::from(i));
        }
        assert_eq!(cache.kept.len(), KEPT);
    }
}
