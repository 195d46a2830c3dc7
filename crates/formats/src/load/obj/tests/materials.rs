//! MTL files and their textures, each with the materials, or the error with its place, that it must
//! give.

use super::*;
use fbptr_core::memory::MemoryBudget;
use fbptr_core::scene::{LightingModel, Material};

/// Returns a file with one face of each named material.
fn faces_of(names: &[&str]) -> String {
    let faces: String = names.iter().map(|n| format!("usemtl {n}\nf 1 2 3\n")).collect();
    format!("mtllib  my lib.mtl \n{TRIANGLE}{faces}")
}

#[test]
fn materials_are_read_from_their_files() {
    let mtl = "# c\nnewmtl plain\n\nnewmtl full name\n\tKa .1 .2 .3 # c\nKd 0.5\nKs 1 2 3\nKe 0 0 4\nNs 96.5\nd 0.25\nTr 0.9\nillum 2\nNi 1.5\n\
               newmtl glass\nTr 0.75\nillum 1\nKs 1 1 1\nnewmtl flat\nKd 1 0 0\nillum 0\nnewmtl full name\nKd 1 1 1\n\
               newmtl over\nd 7\nNs -3\nKd 1 1 1 0.5\nKs spectral x.rfl\n";
    let names = ["plain", "full name", "glass", "flat", "over", "none", "full name"];
    let loaded = load_with(faces_of(&names), &[("my lib.mtl", mtl.as_bytes())]).unwrap();
    let m = &loaded.geometry.mesh;
    assert_eq!(m.polygons.iter().map(|p| p.material).collect::<Vec<_>>(), [0, 1, 2, 3, 4, NONE, 1]);
    assert_eq!(loaded.geometry.textures.len(), 5);
    let [plain, full, glass, flat, over] = &m.materials[..] else { panic!("{:?}", m.materials) };
    let defaults = Material::default();
    assert_eq!((plain.ka, plain.kd, plain.ks, plain.n), (DVec3::ZERO, defaults.kd, DVec3::ZERO, 1.0));
    assert_eq!((plain.model, plain.transparency), (LightingModel::Blinn, 0.0));
    assert_eq!((full.ka, full.kd), (DVec3::new(0.1, 0.2, 0.3), DVec3::splat(0.5)));
    assert_eq!(
        (full.ks, full.emissive, full.n),
        (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.0, 4.0), 96.5)
    );
    assert_eq!((full.transparency, full.name.as_str()), (0.75, "full name"), "d counts, not Tr");
    assert_eq!((glass.transparency, glass.ks), (0.75, DVec3::ZERO));
    assert_eq!((flat.model, flat.emissive), (LightingModel::Unlit, DVec3::X));
    assert_eq!((over.transparency, over.n, over.kd), (0.0, 0.0, DVec3::ONE));
    assert_eq!(
        warnings(&loaded),
        [
            "my lib.mtl:24: warning: \"d\" 7.0 is out of range: 1.0 is taken",
            "my lib.mtl:25: warning: \"Ns\" -3.0 is out of range: 0.0 is taken",
            "my lib.mtl:26: warning: \"Kd\" has more than 3 numbers: the first 3 are used",
            "my lib.mtl:27: warning: \"Ks\" is skipped: only red, green and blue are used",
            "my lib.mtl:21: warning: material \"full name\" is defined again: the first one counts",
            "m.obj:15: warning: material \"none\" is not defined: the faces keep the draw's material",
        ]
    );
}

#[test]
fn several_material_files_are_found_and_the_first_definition_counts() {
    let files: [(&str, &[u8]); 3] = [
        ("a.mtl", b"newmtl x\nKd 1 0 0\n"),
        ("sub/b.mtl", b"newmtl x\nKd 0 1 0\nnewmtl y\nKd 0 0 1"),
        ("c.mtl", b"\xef\xbb\xbfnewmtl caf\xe9\r\nKd 1 1 1\r\n"),
    ];
    let obj = [
        b"mtllib a.mtl sub\\b.mtl\nmtllib c.mtl\n",
        TRIANGLE.as_bytes(),
        b"usemtl x\nf 1 2 3\nusemtl y\nf 1 2 3\nusemtl caf\xe9\nf 1 2 3",
    ]
    .concat();
    let loaded = load_with(obj, &files).unwrap();
    let kd: Vec<DVec3> = loaded.geometry.mesh.materials.iter().map(|m| m.kd).collect();
    assert_eq!(kd, [DVec3::X, DVec3::Z, DVec3::ONE]);
    assert_eq!(loaded.warnings, []);
}

#[test]
fn textures_are_found_by_names_with_blanks_and_options() {
    let png = {
        let mut out = Vec::new();
        image::ImageEncoder::write_image(
            image::codecs::png::PngEncoder::new(&mut out),
            &[1, 2, 3, 4],
            1,
            1,
            image::ExtendedColorType::Rgba8,
        )
        .unwrap();
        out
    };
    let mtl = "newmtl a\nmap_Kd my picture.png\nnewmtl b\nmap_Kd -clamp on -s 1 1 1 -o 0.5 -bm 1 dir\\p q.png\n\
               newmtl c\nKd 1 0 0\nmap_Kd gone.png\nnewmtl d\nmap_Kd -mm 0 1 7\nnewmtl e\nmap_Kd -odd.png";
    let obj = faces_of(&["a", "b", "c", "d", "e"]).replace("my lib", "lib/my");
    let files: [(&str, &[u8]); 4] =
        [("lib/my.mtl", mtl.as_bytes()), ("lib/my picture.png", &png), ("dir/p q.png", &png), ("7", &png)];
    let loaded = load_with(&obj, &files).unwrap();
    let names: Vec<_> =
        loaded.geometry.mesh.materials.iter().map(|m| m.texture.as_deref().unwrap()).collect();
    assert_eq!(names, ["my picture.png", "dir\\p q.png", "gone.png", "7", "-odd.png"]);
    let found: Vec<bool> = loaded.geometry.textures.iter().map(Option::is_some).collect();
    assert_eq!(found, [true, true, false, true, false]);
    assert_eq!(
        (loaded.geometry.mesh.materials[0].kd, loaded.geometry.mesh.materials[2].kd),
        (DVec3::ONE, DVec3::X)
    );
    assert!(
        warnings(&loaded)
            .contains(&"lib/my.mtl:7: warning: texture \"gone.png\" cannot be found: it is left out".into())
    );
    // A file that exists and is no picture is left out, too; a limit of memory is an error.
    let broken: [(&str, &[u8]); 2] = [("lib/my.mtl", mtl.as_bytes()), ("lib/my picture.png", b"no")];
    let loaded = load_with(&obj, &broken).unwrap();
    let start = "lib/my.mtl:2: warning: texture \"my picture.png\" cannot be read (not a readable picture: ";
    let said = warnings(&loaded);
    assert!(said.iter().any(|w| w.starts_with(start) && w.ends_with("): it is left out")), "{said:?}");
    let memory = &mut LoadMemory::new(&MemoryBudget::new(60_000), u64::MAX);
    let mut find = |name: &str| files.iter().find(|f| f.0 == name).map(|f| f.1.to_vec());
    let error = parse_within(obj.as_bytes(), &mut find, "m.obj", memory).unwrap_err();
    assert_eq!((error.code(), error.place.file.as_str()), (Code::Quota, "lib/my picture.png"), "{error}");
    // File names are shown relative to the reader of the OBJ file, as its own name is.
    let mut find = |name: &str| (name == "lib/my.mtl").then(|| b"newmtl a\nKd x".to_vec());
    let said = warnings(&parse(obj.as_bytes(), &mut find, "there/m.obj").unwrap());
    assert!(said[0].starts_with("there/lib/my.mtl:2: warning: a colour"), "{said:?}");
}

#[test]
fn a_malformed_statement_of_a_material_is_left_out_with_its_line() {
    for (mtl, reason) in [
        ("newmtl a\nKd 1 1", "l.mtl:2: a colour has 3 numbers, or 1 for a grey, found \"1 1\""),
        ("newmtl a\nKd", "l.mtl:2: a colour has 3 numbers, or 1 for a grey, found \"\""),
        ("newmtl a\n\nKs 1 x 1", "l.mtl:3: a colour must be a finite number, found \"x\""),
        ("newmtl a\nKa nan nan nan", "l.mtl:2: a colour must be a finite number, found \"nan\""),
        ("newmtl a\nKe 1e999 0 0", "l.mtl:2: a colour must be a finite number, found \"1e999\""),
        ("newmtl a\nNs", "l.mtl:2: an exponent must be a finite number, found \"\""),
        ("newmtl a\nNs inf", "l.mtl:2: an exponent must be a finite number, found \"inf\""),
        ("newmtl a\nd x", "l.mtl:2: an opacity must be a finite number, found \"x\""),
        ("newmtl a\nd -halo", "l.mtl:2: an opacity must be a finite number, found \"\""),
        ("newmtl a\nTr -", "l.mtl:2: a transparency must be a finite number, found \"-\""),
        ("newmtl a\nillum 99", "l.mtl:2: illum is a whole number from 0 to 10, found \"99\""),
        ("newmtl a\nillum", "l.mtl:2: illum is a whole number from 0 to 10, found \"\""),
        ("newmtl a\nillum 2.5", "l.mtl:2: illum is a whole number from 0 to 10, found \"2.5\""),
        ("newmtl a\nillum -1", "l.mtl:2: illum is a whole number from 0 to 10, found \"-1\""),
        ("newmtl a\nKd 1,0 0 0", "l.mtl:2: a colour must be a finite number, found \"1,0\""),
        ("newmtl a\nNs abc", "l.mtl:2: an exponent must be a finite number, found \"abc\""),
    ] {
        let obj = faces_of(&["a"]).replace("my lib", "l");
        let loaded = load_with(obj, &[("l.mtl", mtl.as_bytes())]).unwrap();
        let (line, reason) = reason.split_once(": ").expect("a place");
        let expected = format!("{line}: warning: {reason}: the statement is left out");
        assert_eq!(warnings(&loaded).last(), Some(&expected));
        assert_eq!(loaded.geometry.mesh.materials.len(), 1);
    }
}

#[test]
fn a_black_material_shows_its_texture_and_map_d_its_opacity() {
    let pnm = |rgb: &[u8]| [b"P6 1 1 255\n", rgb].concat();
    let (red, grey) = (pnm(&[255, 0, 0]), pnm(&[128, 128, 128]));
    let read = |mtl: &str| {
        let obj = faces_of(&["a"]).replace("my lib", "l");
        let files: [(&str, &[u8]); 3] = [("l.mtl", mtl.as_bytes()), ("red.ppm", &red), ("t/grey.ppm", &grey)];
        let loaded = load_with(obj, &files).unwrap();
        let texels = loaded.geometry.textures[0].as_ref().map(|t| t.bytes().to_vec());
        (loaded.geometry.mesh.materials[0].kd, texels, warnings(&loaded))
    };
    let (kd, _, said) = read("newmtl a\rKd 0 0 0\rmap_Kd red.ppm\r");
    assert_eq!(kd, DVec3::ONE);
    let black = "l.mtl:3: warning: Kd 0 0 0 of material \"a\" is read as 1 1 1: its texture would be black";
    assert_eq!(said, [black]);
    // Without its picture the material is what it says.
    assert_eq!(read("newmtl a\nKd 0 0 0\nmap_Kd gone.ppm\n").0, DVec3::ZERO);
    let (_, texels, said) = read("newmtl a\nmap_Kd red.ppm\nmap_d -imfchan l t\\grey.ppm\n");
    assert_eq!((texels, said.len()), (Some(vec![255, 0, 0, 128]), 1));
    let (_, texels, said) = read("newmtl a\nmap_d C:\\work\\t\\grey.ppm\n");
    assert_eq!(texels, Some(vec![255, 255, 255, 128]));
    let elsewhere = "l.mtl:2: warning: the path \"C:\\\\work\\\\t\\\\grey.ppm\" is of another machine: \
        \"t/grey.ppm\" is read";
    assert_eq!(said, [elsewhere]);
    assert_eq!(read("newmtl a\nmap_Kd red.ppm\nmap_d red.ppm\n").1, Some(vec![255, 0, 0, 255]));
}

#[test]
fn statements_that_name_no_file_are_left_out_with_a_warning() {
    let obj = format!("mtllib \n{}", faces_of(&["a"]).replace("my lib", "l"));
    let mtl = b"newmtl a\nKd 1 0 0\nmap_Kd\nmap_Kd -clamp on \n";
    let loaded = load_with(obj, &[("l.mtl", mtl)]).unwrap();
    assert_eq!(
        warnings(&loaded),
        [
            "m.obj:1: warning: \"mtllib\" names no file: it is left out",
            "l.mtl:3: warning: \"map_Kd\" names no file: it is left out",
        ]
    );
    assert_eq!(loaded.geometry.mesh.materials[0].kd, DVec3::X);
    assert!(loaded.geometry.textures.iter().all(Option::is_none));
}

/// Returns the materials of an MTL file that are used by one face each, and the warnings.
fn materials_of(mtl: &str, names: &[&str]) -> (Vec<Material>, Vec<String>) {
    let obj = faces_of(names).replace("my lib", "l");
    let loaded = load_with(obj, &[("l.mtl", mtl.as_bytes())]).unwrap();
    (loaded.geometry.mesh.materials.clone(), warnings(&loaded))
}

#[test]
fn tr_of_one_alone_is_an_opacity() {
    let mtl = "newmtl a\nTr 0.25\nTr 1.0\nnewmtl b\nTr 7\nnewmtl c\nTr 0.75\nnewmtl d\nTr 1\nd 0\n\
        newmtl e\nd 0.5\nTr 1\nnewmtl f\nTr -1\n";
    let (materials, said) = materials_of(mtl, &["a", "b", "c", "d", "e", "f"]);
    let transparency: Vec<f64> = materials.iter().map(|m| m.transparency).collect();
    assert_eq!(transparency, [0.0, 0.0, 0.75, 1.0, 0.5, 0.0]);
    assert_eq!(
        said,
        [
            "l.mtl:15: warning: \"Tr\" -1.0 is out of range: 0.0 is taken",
            "l.mtl:3: warning: Tr 1 of material \"a\" and 1 more is read as opaque: some programs write the \
             opacity there (d has one meaning)",
        ]
    );
}

#[test]
fn an_exponent_below_one_is_no_highlight() {
    let mtl = "newmtl a\nNs 0\nKs 1 1 1\nnewmtl b\nKs .5 0 0\nNs 0.5\nnewmtl c\nNs 1\nKs 1\n\
        newmtl d\nNs 0\nKs 0 0 0\nnewmtl e\nNs 0\nKs 1\nillum 1\nnewmtl f\nKs 1\n";
    let (materials, said) = materials_of(mtl, &["a", "b", "c", "d", "e", "f"]);
    let ks: Vec<f64> = materials.iter().map(|m| m.ks.x).collect();
    assert_eq!(ks, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let one = "l.mtl:2: warning: Ns below 1 of material \"a\" and 1 more is read as no highlight, without Ks: \
        some programs write 0 for that";
    assert_eq!(said, [one]);
}

#[test]
fn a_material_may_have_an_empty_name_and_a_real_illum() {
    let mtl = "newmtl \nKd 1 0 0\nillum 2.0\nKs 1\nnewmtl b\nKs 1\nillum 1.0\n";
    let (materials, said) = materials_of(mtl, &["", "b"]);
    assert_eq!(
        materials.iter().map(|m| (m.name.as_str(), m.ks.x)).collect::<Vec<_>>(),
        [("", 1.0), ("b", 0.0)]
    );
    assert_eq!((materials[0].kd, said), (DVec3::X, vec![]));
}

#[test]
fn pictures_are_placed_by_their_options() {
    let mtl = "newmtl a\nmap_Kd -s 2 3 -o 0.5 -colorspace sRGB -clamp on p.png\nnewmtl b\nmap_Kd -clamp off -s 1 1 1 p.png";
    let obj = format!(
        "mtllib l.mtl\n{TRIANGLE}vt 0 0\nvt 1 0\nvt 0.25 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\n"
    );
    let loaded = load_with(obj, &[("l.mtl", mtl.as_bytes())]).unwrap();
    let mesh = &loaded.geometry.mesh;
    let at = |p: usize| {
        mesh.polygon_corners(p)
            .iter()
            .map(|c| mesh.texcoords[c.texcoord as usize].to_array())
            .collect::<Vec<_>>()
    };
    // The offset's second number is 0 unless given.
    assert_eq!(at(0), [[0.5, 0.0], [2.5, 0.0], [1.0, 3.0]]);
    assert_eq!(at(1), [[0.0, 0.0], [1.0, 0.0], [0.25, 1.0]]);
    let said = warnings(&loaded);
    assert!(said.iter().all(|w| !w.contains("colorspace") && !w.contains("is not used")), "{said:?}");
}

#[test]
fn an_empty_map_kd_keeps_the_picture_before_it_and_its_placement() {
    let mtl = b"newmtl a\nmap_Kd -s 2 2 p.png\nmap_Kd\n";
    let obj = format!("mtllib l.mtl\n{TRIANGLE}vt 0 0\nvt 1 0\nvt 0.25 1\nusemtl a\nf 1/1 2/2 3/3\n");
    let loaded = load_with(&obj, &[("l.mtl", mtl)]).unwrap();
    let mesh = &loaded.geometry.mesh;
    let texcoord = mesh.texcoords[mesh.polygon_corners(0)[1].texcoord as usize];
    assert_eq!(texcoord.to_array(), [2.0, 0.0]);
    let said = warnings(&loaded);
    assert!(said.iter().any(|w| w == "l.mtl:3: warning: \"map_Kd\" names no file: it is left out"));
    assert!(said.iter().any(|w| w.contains("p.png")), "the picture is looked for: {said:?}");
}

/// Reads an OBJ file, and counts how often each file beside it is read.
fn reads(obj: &str, files: &[(&str, &[u8])]) -> (LoadedMesh, Vec<(String, usize)>) {
    let mut counts = std::collections::BTreeMap::new();
    let mut find = |name: &str| {
        let bytes = files.iter().find(|f| f.0 == name).map(|f| f.1.to_vec())?;
        *counts.entry(name.to_owned()).or_insert(0) += 1;
        Some(bytes)
    };
    let loaded = parse(obj.as_bytes(), &mut find, "m.obj").expect("loads");
    (loaded, counts.into_iter().collect())
}

#[test]
fn a_file_is_read_once_however_often_it_is_named() {
    let mtl: String = (0..100).map(|i| format!("newmtl m{i}\nmap_Kd p.ppm\n")).collect();
    let faces: String = (0..100).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let mentions = "mtllib a.mtl\nmtllib gone.mtl\nmtllib a.mtl a.mtl gone.mtl\n".repeat(300);
    let files: [(&str, &[u8]); 2] = [("a.mtl", mtl.as_bytes()), ("p.ppm", b"P6 1 1 255\n\x01\x02\x03")];
    let (loaded, counts) = reads(&format!("{mentions}{TRIANGLE}{faces}"), &files);
    let counts: Vec<_> = counts.iter().map(|(name, count)| (name.as_str(), *count)).collect();
    // The second spelling of the names, several on a line, is looked for once more.
    assert!(matches!(counts[..], [("a.mtl", 1 | 2), ("p.ppm", 1)]), "{counts:?}");
    assert_eq!(
        warnings(&loaded),
        ["m.obj:2: warning: material file \"gone.mtl\" cannot be found: it is left out"]
    );
    let textures = &loaded.geometry.textures;
    assert_eq!(textures.iter().flatten().count(), 100);
    assert!(textures.iter().flatten().all(|t| Arc::ptr_eq(t, textures[0].as_ref().unwrap())));
    // The same file by another spelling gives no material a second time.
    let (loaded, _) = reads(
        &format!("mtllib a.mtl\nmtllib ./a.mtl\n{TRIANGLE}usemtl m1\nf 1 2 3\n"),
        &[files[0], ("./a.mtl", files[0].1), files[1]],
    );
    assert_eq!(loaded.warnings, []);
}

#[test]
fn a_cancelled_load_reads_no_further_material_file() {
    let cancel = fbptr_core::cancel::CancelToken::new();
    let mut memory = LoadMemory::unlimited().until(cancel.clone());
    let names: String = (0..50).map(|i| format!("mtllib {i}.mtl\n")).collect();
    let mut read = 0;
    let mut find = |_: &str| {
        read += 1;
        cancel.cancel();
        Some(b"newmtl a\n".to_vec())
    };
    let error = parse_within(format!("{names}{TRIANGLE}").as_bytes(), &mut find, "m.obj", &mut memory);
    assert!(matches!(error.expect_err("is cancelled").kind, LoadErrorKind::Cancelled));
    assert_eq!(read, 1);
}
