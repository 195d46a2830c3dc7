//! Feeds arbitrary bytes to the readers of glTF, STL and PLY. They must not panic nor take more than
//! their budget, must refuse with a place, and what they read must have no index out of range.
#![no_main]

use fbptr::load::{LoadContext, LoadError, LoadMemory, MeshFormat, Smoothing, gltf};
use fbptr::memory::MemoryBudget;
use fbptr::scene::{Mesh, NONE};
use libfuzzer_sys::fuzz_target;

/// Memory that a reader may take.
const BUDGET: u64 = 64 << 20;

fn check_mesh(mesh: &Mesh) {
    let inside = |i: u32, n: usize| i == NONE || (i as usize) < n;
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    for c in &mesh.corners {
        assert!((c.position as usize) < mesh.positions.len());
        assert!(inside(c.normal, mesh.normals.len()) && inside(c.texcoord, mesh.texcoords.len()));
        assert!(inside(c.color, mesh.colors.len()));
    }
    for i in mesh.triangles.iter().flatten().chain(mesh.lines.iter().flatten()).chain(&mesh.points) {
        assert!((*i as usize) < mesh.corners.len());
    }
}

fn check_error(error: &LoadError) {
    let text = error.to_string();
    assert!(text.starts_with('f') && text.len() < 2000 && !text.contains('\n'), "{text}");
}

fuzz_target!(|input: &[u8]| {
    let memory = &mut LoadMemory::new(&MemoryBudget::new(BUDGET), u64::MAX);
    let format = MeshFormat::of(input);
    if format != MeshFormat::Obj {
        match format.parse(input, &mut |_| None, "f", memory, Smoothing::Angle(1.0)) {
            Ok(loaded) => check_mesh(&loaded.geometry.mesh),
            Err(error) => check_error(&error),
        }
        return;
    }
    // Any name is a file of 256 bytes.
    let opener = &mut |_: &str| Some((0..=255).collect());
    match gltf::parse_in(input, "f", LoadContext { folder: "", opener, memory }) {
        Ok(document) => {
            for time in [0.0, 0.7, 1e9] {
                document.at(time, 1.5).objects.iter().for_each(|o| check_mesh(&o.geometry.mesh));
            }
        }
        Err(error) => check_error(&error),
    }
});
