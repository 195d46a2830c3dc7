//! Loads and draws scenes for the tests.

use fbptr::load::x3d::{self, X3dDocument};
use fbptr::load::{LoadError, SandboxDir};
use fbptr::memory::VideoMemory;
use fbptr::pipeline::{SceneOptions, Target, draw_scene};
use fbptr::scene::{Mesh, NONE, Object, Scene};
use glam::DVec3;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the folder of the test scenes.
pub fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/x3d")
}

/// Loads a test scene by its path in that folder, which is also its name in messages.
pub fn load(name: &str) -> Result<X3dDocument, LoadError> {
    let path = data().join(name);
    let folder = SandboxDir::open(path.parent().unwrap()).unwrap();
    x3d::parse(&fs::read(&path).unwrap(), name, &mut |file| folder.read(file, 1 << 20).ok())
}

/// Parses a text that refers to no other files.
pub fn parse(text: &str) -> Result<X3dDocument, LoadError> {
    x3d::parse(text.as_bytes(), "t.x3d", &mut |_| None)
}

/// Parses a document of these nodes; panics on a warning.
pub fn document(nodes: &str) -> X3dDocument {
    let document =
        parse(&format!("<X3D><Scene>{nodes}</Scene></X3D>")).unwrap_or_else(|e| panic!("{e}\n{nodes}"));
    assert_eq!(warnings(&document), [] as [String; 0], "{nodes}");
    document
}

/// Returns the scene of these nodes at time 0.
pub fn scene(nodes: &str) -> Scene {
    let scene = document(nodes).at(0.0);
    check(&scene);
    scene
}

/// Returns the object of one shape.
pub fn shape(appearance: &str, geometry: &str) -> Object {
    let mut scene = scene(&format!("<Shape>{appearance}{geometry}</Shape>"));
    assert_eq!(scene.objects.len(), 1, "{geometry}");
    scene.objects.remove(0)
}

/// Returns the mesh of one geometry without an appearance.
pub fn mesh(geometry: &str) -> Mesh {
    shape("", geometry).geometry.mesh.clone()
}

pub fn warnings(document: &X3dDocument) -> Vec<String> {
    document.warnings().iter().map(|w| w.to_string()).collect()
}

pub fn close(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-12, "{a} is not {b}");
}

/// Verifies that every number of a scene is finite and every index is in range.
pub fn check(scene: &Scene) {
    for object in &scene.objects {
        assert!(object.model.is_finite(), "{}", object.name);
        assert!(!object.name.is_empty() && !object.name.contains(char::is_whitespace), "{:?}", object.name);
        let mesh = &object.geometry.mesh;
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.normals.iter().all(|p| p.is_finite()));
        assert!(mesh.texcoords.iter().all(|p| p.is_finite()));
        let inside = |i: u32, n: usize| i == NONE || (i as usize) < n;
        for c in &mesh.corners {
            assert!((c.position as usize) < mesh.positions.len());
            assert!(inside(c.normal, mesh.normals.len()) && inside(c.texcoord, mesh.texcoords.len()));
            assert!(inside(c.color, mesh.colors.len()));
        }
        for i in mesh.triangles.iter().flatten().chain(mesh.lines.iter().flatten()).chain(&mesh.points) {
            assert!((*i as usize) < mesh.corners.len());
        }
        assert!(object.lights.iter().flatten().all(|l| (*l as usize) < scene.lights.len()));
        let m = &object.material;
        assert!((0.0..=1.0).contains(&m.transparency) && m.n >= 0.0 && m.kd.is_finite() && m.ka.is_finite());
    }
}

/// Draws a scene on black.
pub fn draw(scene: &Scene, width: u32, height: u32) -> VideoMemory {
    let mut memory = VideoMemory::new(width, height).unwrap();
    let options = SceneOptions::new(width, height);
    let mut depth = None;
    let depth_format = fbptr::memory::DepthFormat::F32;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    draw_scene(&mut target, scene, &options).unwrap();
    memory
}

/// Returns the signed volume that a mesh encloses; positive if its faces look outwards.
pub fn volume(mesh: &Mesh) -> f64 {
    let p = |i: u32| mesh.positions[mesh.corners[i as usize].position as usize];
    mesh.triangles.iter().map(|[a, b, c]| p(*a).dot(p(*b).cross(p(*c)))).sum::<f64>() / 6.0
}

/// Returns the sum of the areas of a mesh's triangles, as a vector.
pub fn area(mesh: &Mesh) -> DVec3 {
    let p = |i: u32| mesh.positions[mesh.corners[i as usize].position as usize];
    mesh.triangles.iter().map(|[a, b, c]| (p(*b) - p(*a)).cross(p(*c) - p(*a))).sum::<DVec3>() / 2.0
}
