//! Built-in models: scenes that are asked for by a name and need no file.
//!
//! In: a name, as `teapot`. Out: what reading a file of that scene would give, a [`LoadedScene`].
//! Right is the mesh that [`shapes`] makes, the scene of the data file, or the one that
//! `fbptr eye --make` prints: the tests compare with these.

use crate::animation::{LoadedScene, SceneFile, SceneFormat, SceneSource};
use crate::load::{LoadMemory, MeshFormat, Smoothing};
use fbptr_core::eye::EyeScene;
use fbptr_core::eye::shapes::{
    DemoScene, Shape, ShapeError as PolytopeError, cell24, cross_polytope, cube, simplex,
};
use fbptr_core::scene::Mesh;
use fbptr_core::scene::shapes::{self, DEFAULT_TEAPOT_LEVEL, ShapeError};

/// Blender's monkey of 968 faces, an OBJ file, whose licence lies beside it in the source.
#[doc(hidden)]
pub const SUZANNE: &[u8] = include_bytes!("../../data/suzanne/monkey_head2.obj");

/// A room after the Cornell box, an X3D file.
const CORNELL: &[u8] = include_bytes!("../../data/cornell.x3d");

/// A model that is part of the program.
pub struct BuiltInModel {
    /// Name in lower case.
    pub name: &'static str,
    /// Further name, or an empty string.
    pub alias: &'static str,
    /// Description in a few words.
    pub about: &'static str,
    source: Source,
}

/// Origin of a model.
enum Source {
    /// A generated mesh.
    Shape(fn() -> Result<Mesh, ShapeError>),
    /// The bytes of a file.
    File(SceneFormat, &'static [u8]),
    /// A polytope of four dimensions.
    Polytope(fn(usize) -> Result<Shape, PolytopeError>),
}

const fn model(name: &'static str, about: &'static str, source: Source) -> BuiltInModel {
    BuiltInModel { name, alias: "", about, source }
}

/// Returns all models, in the order in which they are listed.
pub fn all() -> &'static [BuiltInModel] {
    MODELS
}

static MODELS: &[BuiltInModel] = &[
    model("teapot", "Newell's teapot", Source::Shape(|| shapes::teapot(DEFAULT_TEAPOT_LEVEL))),
    model("suzanne", "Blender's monkey", Source::File(SceneFormat::Mesh(MeshFormat::Obj), SUZANNE)),
    model("knot", "a torus knot (2,3)", Source::Shape(|| shapes::knot(300, 32))),
    model("sphere", "a sphere", Source::Shape(|| shapes::sphere(1.0))),
    model("box", "a cube of three dimensions", Source::Shape(|| shapes::cuboid([2.0; 3].into()))),
    model("cone", "a cone", Source::Shape(|| shapes::cone(1.0, 2.0))),
    model("cylinder", "a cylinder", Source::Shape(|| shapes::cylinder(1.0, 2.0))),
    model("cornell", "a room with two blocks, lit from its ceiling", Source::File(SceneFormat::X3d, CORNELL)),
    model("tesseract", "the cube of 4 dimensions", Source::Polytope(cube)),
    BuiltInModel {
        alias: "24-cell",
        ..model("cell24", "the 24-cell of 4 dimensions", Source::Polytope(cell24))
    },
    model("simplex", "the regular simplex of 4 dimensions", Source::Polytope(simplex)),
    model("cross-polytope", "the cross-polytope of 4 dimensions", Source::Polytope(cross_polytope)),
];

/// Returns the model of a name, in upper or lower case.
pub fn named(name: &str) -> Option<&'static BuiltInModel> {
    MODELS.iter().find(|m| {
        m.name.eq_ignore_ascii_case(name) || (!m.alias.is_empty() && m.alias.eq_ignore_ascii_case(name))
    })
}

/// Returns a line for each model, its name and what it is.
pub fn list() -> String {
    MODELS.iter().map(|m| format!("{:<16}{}\n", m.name, m.about)).collect()
}

impl BuiltInModel {
    /// Returns whether the model is a polytope of four dimensions, which the eye draws.
    pub fn is_polytope(&self) -> bool {
        matches!(self.source, Source::Polytope(_))
    }

    /// Returns the scene, as [`SceneFile::read`] does. `smoothing` applies to a model that comes
    /// from a mesh file.
    ///
    /// # Errors
    /// If `memory` has no room for it.
    pub fn load(&self, smoothing: Smoothing, mut memory: LoadMemory) -> Result<LoadedScene, String> {
        let file = match &self.source {
            Source::File(format, bytes) => {
                let source = SceneSource {
                    bytes,
                    format: *format,
                    name: self.name,
                    folder: "",
                    opener: &mut |_| None,
                    smoothing,
                    memory,
                };
                return SceneFile::read(source);
            }
            Source::Shape(make) => {
                let mesh = make().map_err(|e| e.to_string())?;
                memory.reserve_result(mesh.size_bytes() as u64).map_err(|e| format!("{}: {e}", self.name))?;
                SceneFile::Mesh { geometry: mesh.into(), is_open: false }
            }
            Source::Polytope(make) => SceneFile::Eye(Box::new(polytope(*make)?)),
        };
        Ok(LoadedScene {
            file,
            warnings: Vec::new(),
            names_outside: false,
            crc: crc32fast::hash(self.name.as_bytes()),
            held: memory.into_kept(),
        })
    }
}

/// Returns the scene around a polytope of four dimensions.
fn polytope(make: fn(usize) -> Result<Shape, PolytopeError>) -> Result<EyeScene, String> {
    let shape = make(4).map_err(|e| e.to_string())?;
    DemoScene::of_dim(shape.dim).scene(shape).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_is_found_by_its_names_and_loads() {
        for model in MODELS {
            for name in [model.name, model.alias, &model.name.to_uppercase()] {
                assert_eq!(named(name).map(|m| m.name), (!name.is_empty()).then_some(model.name), "{name}");
            }
            let loaded = model.load(Smoothing::Automatic, LoadMemory::unlimited()).expect(model.name);
            assert!(loaded.warnings.is_empty(), "{}: {:?}", model.name, loaded.warnings);
            assert!(list().contains(model.about));
        }
        assert!(named("pot").is_none() && named("").is_none());
    }

    #[test]
    fn a_model_is_the_mesh_that_the_shapes_make() {
        let loaded = named("teapot").expect("listed").load(Smoothing::Automatic, LoadMemory::unlimited());
        let Ok(LoadedScene { file: SceneFile::Mesh { geometry, .. }, .. }) = loaded else {
            panic!("a teapot is a mesh");
        };
        assert_eq!(geometry.mesh, shapes::teapot(DEFAULT_TEAPOT_LEVEL).expect("a level"));
    }

    #[test]
    fn a_model_that_has_no_room_is_refused() {
        let memory = || LoadMemory::new(&fbptr_core::memory::MemoryBudget::new(1000), u64::MAX);
        for name in ["teapot", "suzanne", "cornell"] {
            assert!(named(name).expect("listed").load(Smoothing::Automatic, memory()).is_err(), "{name}");
        }
    }
}
