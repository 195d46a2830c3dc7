//! Verifies that files from other projects are drawn as the specification says.
//!
//! Every OBJ and X3D file of the test data that loads is drawn by the pipeline and by the
//! reference, faces only (lines and points have tests of their own), in two sizes and depth
//! formats, and compared by the limits of `truth::compare`.

use crate::against_truth::fault_of;
use fbptr::load::{SandboxDir, obj, x3d};
use fbptr::memory::DepthFormat;
use fbptr::scene::{Geometry, Light, Scene, ShadeMode, TransparencyOrder};
use fbptr::truth::scenes::{Case, object};
use fbptr::truth::{Settings, Transparency};
use glam::DVec3;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn files(dir: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => files(&path, extension, found),
            false if path.extension().is_some_and(|e| e == extension) => found.push(path),
            false => {}
        }
    }
}

/// Returns the cases of a scene's faces, from its own camera or from one that frames it.
fn cases_of(path: &Path, mut scene: Scene) -> Vec<Case> {
    for o in &mut scene.objects {
        if !o.geometry.mesh.lines.is_empty() || !o.geometry.mesh.points.is_empty() {
            let mut geometry = Geometry::clone(&o.geometry);
            geometry.mesh.lines.clear();
            geometry.mesh.points.clear();
            o.geometry = Arc::new(geometry);
        }
    }
    if scene.camera.is_none() {
        let bounds = scene.bounds().unwrap_or((DVec3::ZERO, DVec3::ONE));
        scene.camera = Some(fbptr::scene::frame(bounds, 4.0 / 3.0));
    }
    let modes =
        [(48, 36, DepthFormat::F32, ShadeMode::Phong), (31, 40, DepthFormat::U24, ShadeMode::Gouraud)];
    let case = |(width, height, format, shade): (u32, u32, DepthFormat, ShadeMode)| Case {
        name: format!("{} {}", path.display(), shade.as_str()),
        scene: scene.clone(),
        settings: Settings {
            shade,
            transparency: Transparency::AfterOpaque(TransparencyOrder::FileOrder),
            ..Settings::default()
        },
        format,
        width,
        height,
    };
    modes.map(case).to_vec()
}

fn check(cases: &[Case]) {
    let faults: Vec<String> = cases.iter().filter_map(fault_of).collect();
    assert!(faults.is_empty(), "{} of {} pictures are off:\n{}", faults.len(), cases.len(), faults.concat());
}

#[test]
fn every_obj_file_agrees_with_the_truth() {
    let mut paths = Vec::new();
    files(Path::new("tests/data/meshes"), "obj", &mut paths);
    let mut cases = Vec::new();
    for path in &paths {
        let folder = path.parent().unwrap();
        let mut side = |name: &str| fs::read(folder.join(name)).ok();
        let Ok(loaded) = obj::parse(&fs::read(path).unwrap(), &mut side, "mesh.obj") else { continue };
        let mut o = object("mesh", Default::default());
        o.geometry = Arc::new(loaded.geometry);
        let light = Light::directional(DVec3::new(-0.3, -0.5, -1.0), DVec3::splat(0.9));
        let scene =
            Scene { ambient: DVec3::splat(0.2), lights: vec![light], objects: vec![o], ..Scene::default() };
        cases.extend(cases_of(path, scene));
    }
    assert!(cases.len() >= 40, "only {} pictures", cases.len());
    check(&cases);
}

#[test]
fn every_x3d_file_agrees_with_the_truth() {
    let mut paths = Vec::new();
    files(Path::new("tests/data/x3d"), "x3d", &mut paths);
    let mut cases = Vec::new();
    for path in &paths {
        let folder = SandboxDir::open(path.parent().unwrap()).unwrap();
        let name = path.display().to_string();
        let mut side = |n: &str| folder.read(n, 1 << 26).ok();
        let Ok(document) = x3d::parse(&fs::read(path).unwrap(), &name, &mut side) else { continue };
        for time in [0.0, 0.3] {
            if time == 0.0 || document.is_animated() {
                cases.extend(cases_of(path, document.at(time)));
            }
        }
    }
    assert!(cases.len() >= 40, "only {} pictures", cases.len());
    check(&cases);
}
