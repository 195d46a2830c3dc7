//! Fear: an X3D file that somebody has is refused without need, shows nothing, or is refused without saying why.
use fbptr::load::x3d;
use std::fs;
use std::path::{Path, PathBuf};

fn files(dir: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => files(&path, found),
            false if path.extension().is_some_and(|e| e == "x3d") => found.push(path),
            false => {}
        }
    }
}

#[test]
fn every_file() {
    let mut found = Vec::new();
    files(Path::new("tests/data/x3d"), &mut found);
    for path in found {
        let bytes = fs::read(&path).unwrap();
        let folder = fbptr::load::Folder::open(path.parent().unwrap()).unwrap();
        let result = x3d::parse(&bytes, &path.display().to_string(), &mut |n| folder.read(n, 1 << 26).ok());
        match result {
            Ok(d) => {
                let s = d.at(0.0);
                println!(
                    "{}: {} objects, {} lights, {:?}",
                    path.display(),
                    s.objects.len(),
                    s.lights.len(),
                    s.fog
                );
                for o in &s.objects {
                    println!(
                        "   {} {} faces {} lines {} points {:?}",
                        o.name,
                        o.geometry.mesh.polygons.len(),
                        o.geometry.mesh.lines.len(),
                        o.geometry.mesh.points.len(),
                        o.material.model
                    );
                }
                for w in d.warnings() {
                    println!("   {w}");
                }
            }
            Err(e) => println!("REFUSED {e}"),
        }
    }
}
