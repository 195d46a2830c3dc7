//! Tests with small workloads: each is within its bound, and wrong pictures are refused.

use super::*;
use fbptr_core::scene::Filter;

fn small() -> BenchOptions {
    let size = Size { width: 96, height: 54, divisor: 5_000 };
    BenchOptions {
        render: RenderOptions::default(),
        depth_format: Default::default(),
        air: Default::default(),
        size,
        frames: 2,
        budget: Duration::from_millis(50),
    }
}

#[test]
fn every_workload_is_held_to_its_truth_and_then_timed() {
    for workload in
        Workload::ALL.into_iter().chain(["teapot", "Cornell"].map(|name| Workload::named(name)[0]))
    {
        let row = run(workload, &small()).unwrap_or_else(|refusal| panic!("{refusal}"));
        assert!(
            row.frames == 2 && row.min_ms > 0.0 && row.median_ms >= row.min_ms && row.p99_ms >= row.median_ms,
            "{row:?}"
        );
        assert!(row.check.covered > 200, "{row:?}");
        assert_eq!(
            row.twin.is_some(),
            workload.name().starts_with("W6") || workload.name().starts_with("W7")
        );
        let json: serde_json::Value = serde_json::from_str(&row.json()).expect("one object");
        assert_eq!((&json["peer"], &json["wl"]), (&"fbptr".into(), &workload.name().into()));
        assert!(json["p99_ms"].as_f64() >= json["med_ms"].as_f64(), "{json}");
        assert_eq!(row.scaling.is_some(), scenes::steps(workload).is_some());
        if let Some(scaling) = &row.scaling {
            let list = json[format!("{}_min_ms", scaling.what)].as_array().expect("a list of steps");
            assert_eq!(list.len(), scaling.steps.len());
            assert_eq!(scaling.exponent.is_some(), json["exponent"].is_f64());
        }
        let fields = ["{\"peer\":", ",\"cfg\":\"1T\",\"wl\":", ",\"med_ms\":", ",\"min_ms\":"];
        let places = fields.map(|f| row.json().find(f).expect("a field of all peers"));
        assert!(places.is_sorted(), "{}", row.json());
    }
}

#[test]
fn other_depths_and_fog_are_held_to_their_truth_too() {
    for depth_format in DepthFormat::ALL {
        for (workload, air) in [
            (Workload::Phong70k, Air::Clear),
            (Workload::Fill20, Air::Fog),
            (Workload::Textured(Filter::Bilinear), Air::Fog),
            (Workload::Layers64, Air::Fog),
            (Workload::Hidden, Air::Clear),
        ] {
            let row = run(workload, &BenchOptions { depth_format, air, ..small() });
            let row = row.unwrap_or_else(|refusal| panic!("{depth_format:?}, {air:?}: {refusal}"));
            assert!(row.check.covered > 200, "{row:?}");
            let json: serde_json::Value = serde_json::from_str(&row.json()).expect("one object");
            assert_eq!(
                (&json["depth"], &json["fog"]),
                (&depth_format.as_str().into(), &(air == Air::Fog).into())
            );
        }
    }
}

#[test]
fn exported_meshes_are_the_knot() {
    let files = export(&small());
    assert_eq!(files.iter().map(|f| f.0).collect::<Vec<_>>(), ["knot70k.bin", "knot1m.bin", "texture.rgba"]);
    let word = |b: &[u8], i: usize| u32::from_le_bytes(b[4 * i..4 * i + 4].try_into().unwrap());
    let (knot, texture) = (&files[0].1, &files[2].1);
    // 16 steps along, 70 around, and a seam each way; two triangles per step.
    let (vertices, triangles) = (word(knot, 0) as usize, word(knot, 1) as usize);
    assert_eq!((vertices, triangles), (17 * 71, 2 * 16 * 70));
    assert_eq!(knot.len(), 8 + vertices * 32 + triangles * 12);
    assert!((0..3 * triangles).all(|i| (word(knot, 2 + 8 * vertices + i) as usize) < vertices));
    // Row 0 is t = 0: r = x ^ y, squares of 32, b = 3 x + 5 y.
    assert_eq!(texture[4 * (1024 * 32 + 3)..][..4], [35, 224, 169, 255]);
}

#[test]
fn names_and_their_beginnings_are_known() {
    for w in Workload::ALL {
        assert_eq!(Workload::named(w.name()), [w]);
        assert_eq!(Workload::named(&w.name().to_lowercase()), [w]);
    }
    assert_eq!(Workload::named("w4").len(), 3);
    assert_eq!(Workload::named("W6_lines").len(), 2);
    assert_eq!(Workload::named("S3").len(), 2);
    assert_eq!(Workload::named("scenes").len(), 8);
    for wrong in ["", "W", "W8", "W4_", "W4_tex_t", "W1_phong70k_", "ä"] {
        assert_eq!(Workload::named(wrong), [], "{wrong}");
    }
}

/// Workload that draws the pictures that a test specifies.
struct Fake {
    frames: Vec<[u8; 4]>,
    drawn: usize,
    shown: [u8; 4],
}

impl BenchRun for Fake {
    fn frame(&mut self) {
        self.shown = self.frames[self.drawn.min(self.frames.len() - 1)];
        self.drawn += 1;
    }
    fn bytes(&self) -> &[u8] {
        &self.shown
    }
    fn spoil(&mut self) {
        self.shown = [0; 4];
    }
    fn truth(&mut self) -> VideoMemory {
        VideoMemory::new(1, 1).unwrap()
    }
    fn check(&mut self) -> Check {
        Check::of_bytes(&self.shown, &[100, 100, 100, 255], [0, 0, 0, 255])
    }
    fn threads(&self) -> usize {
        1
    }
    fn simd(&self) -> &'static str {
        "none"
    }
}

#[test]
fn a_picture_outside_its_bound_has_no_time() {
    let run = |workload, frames: &[[u8; 4]]| {
        measure(workload, &mut Fake { frames: frames.to_vec(), drawn: 0, shown: [0; 4] }, &small())
    };
    let [near, off, gone] = [[101, 99, 100, 255], [100, 102, 100, 255], [0, 0, 0, 255]];
    assert!(run(Workload::Phong70k, &[near]).is_ok());
    assert!(run(Workload::Textured(Filter::Nearest), &[off]).is_ok());
    for (workload, picture, reason) in [
        (Workload::Phong70k, off, "2/255 from the truth, 1/255 allowed"),
        (Workload::LinesLong, near, "1/255 from the truth, 0/255 allowed"),
        (Workload::Fill20, gone, "1 pixels are off in coverage"),
    ] {
        let refusal = run(workload, &[picture]).unwrap_err();
        assert!(refusal.to_string().contains(reason), "{refusal}");
    }
    // Correct at first; later frames skip work.
    let refusal =
        run(Workload::Phong70k, &[near, near, near, near, near, near, near, near, off]).unwrap_err();
    assert!(refusal.reason.contains("a later frame differs"), "{refusal}");
}

#[test]
fn nearest_may_take_either_texel_at_a_border_and_no_other() {
    let mut run_of = space::Space::new(Workload::Textured(Filter::Nearest), &small());
    run_of.frame();
    assert_eq!(run_of.check().within(Workload::Textured(Filter::Nearest)), Ok(()));
    // A fiftieth of a texel is not borderline.
    run_of.frame_shifted(0.02);
    assert!(run_of.check().max_error_steps > 2);
}

#[test]
fn a_scene_with_one_thing_out_of_place_has_no_time() {
    for workload in Workload::named("scenes") {
        let step = scenes::steps(workload).map_or(1, |(_, steps)| steps[0]);
        let mut run_of = scenes::Scenes::new(workload, &small(), step);
        run_of.frame();
        assert_eq!(run_of.check().within(workload), Ok(()), "{}", workload.name());
        run_of.frame_moved(glam::DVec3::splat(0.02));
        assert!(run_of.check().within(workload).is_err(), "{}", workload.name());
    }
}

/// Checks the workload's frame with one pixel changed.
fn verdict_with(
    run_of: &mut space::Space,
    workload: Workload,
    index: usize,
    color: impl FnOnce([u8; 4]) -> [u8; 4],
    z: impl FnOnce(f64) -> f64,
) -> Result<(), String> {
    run_of.frame_changed(|memory, depth| {
        let pixel = &mut memory.bytes_mut().as_chunks_mut().0[index];
        *pixel = color(*pixel);
        let z = z(depth.format().decode(depth.word(index)));
        depth.set_word(index, depth.format().encode(z, 1.0 - z));
    });
    run_of.check().within(workload)
}

#[test]
fn one_wrong_pixel_is_refused_and_one_of_two_right_ones_is_not() {
    let workload = Workload::Phong70k;
    let size = Size { width: 480, height: 270, divisor: 20 };
    let mut run_of = space::Space::new(workload, &BenchOptions { size, ..small() });
    let pixels: Vec<[u32; 2]> =
        (0..size.width * size.height).map(|i| [i % size.width, i / size.width]).collect();
    let truth = run_of.reference(&pixels);
    let states = |i: usize| truth.states(pixels[i][0], pixels[i][1]);
    let is_drawn = |i: &usize| states(*i).iter().all(|s| s.drawn.is_some());
    let spread = |i: &usize| (states(*i)[0].z[1] - states(*i)[0].z[0]).to_f64();
    let inside = (0..pixels.len()).find(|i| is_drawn(i) && states(*i).len() == 1 && spread(i) == 0.0);
    let inside = inside.expect("nearly every pixel has one right answer");
    let same = |z: f64| z;
    let keep = |c: [u8; 4]| c;
    // From a pixel within a step of the reference, three steps further.
    let brighter = |c: [u8; 4]| c.map(|v| if v == 255 { v } else { v.saturating_add(3).min(254) });
    assert_eq!(verdict_with(&mut run_of, workload, inside, keep, same), Ok(()));
    let refused = verdict_with(&mut run_of, workload, inside, brighter, same).unwrap_err();
    assert!(refused.contains("a colour is"), "{refused}");
    for (off, is_right) in [(1e-7, true), (1e-6, false), (-1e-6, false)] {
        let verdict = verdict_with(&mut run_of, workload, inside, keep, |z| z + off);
        assert_eq!(verdict.is_ok(), is_right, "{off} {verdict:?}");
    }
    let refused = verdict_with(&mut run_of, workload, inside, keep, |_| 1.0).unwrap_err();
    assert!(refused.contains("coverage"), "{refused}");
    // If the centre lies outside the true face, both ends are accepted, and values beyond them are
    // not.
    let outside: Vec<usize> = (0..pixels.len())
        .filter(|i| is_drawn(i) && states(*i).len() == 1 && spread(i) > 2e-6)
        .take(3)
        .collect();
    assert!(!outside.is_empty(), "some centres lie outside");
    for i in outside {
        let [near, far] = states(i)[0].z.map(|z| z.to_f64());
        for (z, is_right) in [(near, true), (far, true), (near - 1e-6, false), (far + 1e-6, false)] {
            let verdict = verdict_with(&mut run_of, workload, i, keep, |_| z);
            assert_eq!(verdict.is_ok(), is_right, "{:?} {near} {far} {z} {verdict:?}", pixels[i]);
        }
        let refused = verdict_with(&mut run_of, workload, i, brighter, same).unwrap_err();
        assert!(refused.contains("a colour is"), "{refused}");
    }
    // A picture that is wrong everywhere is refused without consulting the reference.
    run_of.frame_changed(|memory, _| {
        memory.bytes_mut().as_chunks_mut::<4>().0.iter_mut().for_each(|c| *c = brighter(*c))
    });
    assert!(run_of.check().within(workload).is_err());
}
