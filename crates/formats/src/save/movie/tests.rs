use super::*;
use fbptr_core::memory::Rgba;
use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use std::io::Cursor;
use std::time::Duration;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("fbptr-movie-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("temporary folder");
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Returns frame `i` of a movie with few colours, or with many.
fn picture(i: u32, has_many_colors: bool) -> VideoMemory {
    let mut memory = VideoMemory::new(40, 30).expect("small");
    for y in 0..30 {
        for x in 0..40 {
            let many = [(x * 6) as u8, (y * 8) as u8, (x * y) as u8, 9];
            let few = [(x / 8 * 50) as u8, (y / 6 * 50) as u8, 77, 255];
            memory.put_pixel(x, y, if has_many_colors { many } else { few });
        }
    }
    for k in 0..5 {
        memory.put_pixel(i as i32 + k, 10 + i as i32 / 3, [255, 0, i as u8, 255]);
    }
    memory
}

fn rgb(bytes: &[u8]) -> Vec<[u8; 3]> {
    bytes.as_chunks::<4>().0.iter().map(|p: &Rgba| [p[0], p[1], p[2]]).collect()
}

/// Decodes every frame of a movie file, with its duration.
fn decode(path: &Path) -> Vec<(Vec<[u8; 3]>, Duration)> {
    let bytes = fs::read(path).expect("the movie");
    let frames = match MovieFormat::of_path(path).expect("an ending") {
        MovieFormat::Gif => {
            GifDecoder::new(Cursor::new(bytes)).expect("a GIF").into_frames().collect_frames()
        }
        _ => {
            let decoder = PngDecoder::new(Cursor::new(bytes)).expect("a PNG");
            assert!(decoder.is_apng().expect("a head"));
            decoder.apng().expect("an APNG").into_frames().collect_frames()
        }
    };
    let frames = frames.expect("every frame is whole");
    frames.iter().map(|f| (rgb(f.buffer().as_raw()), Duration::from(f.delay()))).collect()
}

#[test]
fn every_frame_comes_back_after_every_push() {
    let folder = Folder::new("roundtrip");
    for name in ["a.gif", "a.apng"] {
        let path = folder.0.join(name);
        fs::write(&path, b"something else").expect("an old file");
        let mut movie = Movie::create(&path, 40, 30, 25.0).expect("a movie");
        for i in 0..12 {
            movie.push(&picture(i, false)).expect("pushed");
            let shown = decode(&path);
            assert_eq!(shown.len(), i as usize + 1, "{name}");
            for (k, (pixels, time)) in shown.iter().enumerate() {
                assert!(*pixels == rgb(picture(k as u32, false).bytes()), "{name} frame {k} of {i}");
                assert_eq!(*time, Duration::from_millis(40));
            }
        }
    }
}

#[test]
fn an_apng_keeps_every_colour_and_a_gif_comes_near() {
    let folder = Folder::new("colours");
    for (name, mean) in [("a.gif", 8), ("a.apng", 0)] {
        let path = folder.0.join(name);
        let mut movie = Movie::create(&path, 40, 30, 10.0).expect("a movie");
        (0..3).for_each(|i| movie.push(&picture(i, true)).expect("pushed"));
        for (k, (pixels, _)) in decode(&path).iter().enumerate() {
            let wanted = rgb(picture(k as u32, true).bytes());
            let off =
                pixels.iter().zip(&wanted).flat_map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))));
            let total: u32 = off.sum();
            assert!(total <= mean * 3 * 40 * 30, "{name} frame {k} is off by {total}");
        }
    }
}

#[test]
fn a_still_picture_is_one_long_frame_and_time_never_drifts() {
    let folder = Folder::new("still");
    for name in ["a.gif", "a.apng"] {
        let path = folder.0.join(name);
        let mut movie = Movie::create(&path, 40, 30, 30.0).expect("a movie");
        for i in [0, 0, 0, 1, 2, 2] {
            movie.push(&picture(i, false)).expect("pushed");
        }
        // The duration added below exceeds the largest delay of a single frame.
        let shown = decode(&path);
        assert_eq!(shown.len(), 3, "{name}");
        let total: Duration = shown.iter().map(|(_, time)| *time).sum();
        assert_eq!((shown[0].1, total), (Duration::from_millis(100), Duration::from_millis(200)), "{name}");
        for _ in 0..30 * 700 {
            movie.push(&picture(2, false)).expect("pushed");
        }
        let total: Duration = decode(&path).iter().map(|(_, time)| *time).sum();
        assert_eq!(total, Duration::from_millis(700_200), "{name}");
    }
}

#[test]
fn a_file_cut_in_the_middle_of_a_frame_still_shows_those_before() {
    // A killed program leaves the frame's bytes after the end marker, which has not been moved yet.
    let folder = Folder::new("cut");
    for name in ["a.gif", "a.apng"] {
        let path = folder.0.join(name);
        let mut movie = Movie::create(&path, 40, 30, 25.0).expect("a movie");
        movie.push(&picture(0, false)).expect("pushed");
        movie.push(&picture(1, false)).expect("pushed");
        let before = fs::read(&path).expect("the movie");
        movie.push(&picture(2, false)).expect("pushed");
        let after = fs::read(&path).expect("the movie");
        for cut in [before.len() + 1, before.len() + 9, after.len() - 1] {
            let mut torn = before.clone();
            torn.extend_from_slice(&after[before.len()..cut]);
            fs::write(&path, &torn).expect("written");
            assert_eq!(decode(&path).len(), 2, "{name} cut at {cut}");
        }
    }
}

#[test]
fn numbered_pngs_and_y4m_grow_by_whole_frames() {
    let folder = Folder::new("others");
    let (pngs, y4m) = (folder.0.join("p.png"), folder.0.join("v.y4m"));
    let mut numbered = Movie::create(&pngs, 40, 30, 25.0).expect("a movie");
    let mut stream = Movie::create(&y4m, 40, 30, 12.5).expect("a movie");
    let header = b"YUV4MPEG2 W40 H30 F25:2 Ip A1:1 C444\n".len();
    for i in 0..3 {
        numbered.push(&picture(i, true)).expect("pushed");
        stream.push(&picture(i, true)).expect("pushed");
        let one = image::open(folder.0.join(format!("p-{i:04}.png"))).expect("a PNG").to_rgba8();
        assert!(one.as_raw() == picture(i, true).bytes());
        let bytes = fs::read(&y4m).expect("the stream");
        assert_eq!(bytes.len(), header + (i as usize + 1) * (6 + 40 * 30 * 3));
    }
    assert_eq!((numbered.frames(), numbered.path()), (3, pngs.as_path()));
}

#[test]
fn names_and_rates_that_make_no_movie_are_refused() {
    assert_eq!(MovieFormat::of_path(Path::new("-")).expect("stdout"), MovieFormat::Y4m);
    for name in ["a.mp4", "a", "", "gif"] {
        assert!(Movie::create(Path::new(name), 4, 4, 25.0).is_err(), "{name}");
    }
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 60.0] {
        let error = Movie::create(Path::new("a.gif"), 4, 4, rate).expect_err("no rate for a GIF");
        assert!(error.to_string().contains("frames a second"), "{error}");
    }
    assert!(Movie::create(Path::new("a.gif"), 70_000, 1, 25.0).is_err());
}

#[test]
fn the_changed_box_holds_every_changed_pixel_and_no_row_more() {
    let before = picture(0, true);
    assert_eq!(changed_box(before.bytes(), before.bytes(), 40), None);
    let mut after = picture(0, true);
    after.put_pixel(7, 20, [1, 2, 3, 4]);
    assert_eq!(changed_box(before.bytes(), after.bytes(), 40), Some([7, 20, 1, 1]));
    after.put_pixel(3, 22, [1, 2, 3, 4]);
    after.put_pixel(39, 21, [1, 2, 3, 4]);
    assert_eq!(changed_box(before.bytes(), after.bytes(), 40), Some([3, 20, 37, 3]));
    let mut alpha = picture(0, true);
    alpha.bytes_mut()[3] ^= 1;
    assert_eq!(changed_box(before.bytes(), alpha.bytes(), 40), None, "alpha is not seen");
}
