//! Sheets: what is read, and the line of what is wrong; and the numbers of the sheet of the pipeline.

use super::builtin;
use super::sheet::{By, Input, Sheet, Wanted};
use std::time::Duration;

const SHEET: &str = "\
# a comment
title: two
> for all
size: 8x6
time: 2s

item: first
> for one
points: 2.5
input: exact
partly: 90%
exact:
    PX 1 1 ff0000

      LINE 0 0 3 3 red
file a.txt:
\tx
\t y
item: second
by: stdout
arguments: {item} -v
numbers: 1 -2.5
";

#[test]
fn a_sheet_is_read_with_its_defaults_and_blocks() {
    let sheet = Sheet::parse(SHEET).unwrap();
    assert_eq!((sheet.title.as_str(), sheet.text.len(), sheet.items.len()), ("two", 1, 2));
    let [first, second] = &sheet.items[..] else { panic!() };
    assert_eq!((first.name.as_str(), first.line, first.points), ("first", 7, 2.5));
    assert_eq!(first.text, ["for one"]);
    assert_eq!((first.size.width, first.time), (8, Duration::from_secs(2)));
    assert_eq!((first.input.clone(), first.partly), (Input::Exact, Some(0.9)));
    assert_eq!(first.exact, Wanted::Text("PX 1 1 ff0000\n\n  LINE 0 0 3 3 red\n".into()));
    assert_eq!(first.files, [("a.txt".to_owned(), "x\n y\n".to_owned())]);
    // The first item's own settings are not the second's.
    assert_eq!((second.points, second.by, second.partly), (1.0, By::Stdout, None));
    assert_eq!(second.exact, Wanted::Numbers(vec![1.0, -2.5]));
    assert_eq!(second.arguments, ["{item}", "-v"]);
}

#[test]
fn a_line_that_is_wrong_is_named() {
    let wrong = |text: &str| {
        let error = Sheet::parse(text).unwrap_err();
        (error.line, error.message)
    };
    assert_eq!(wrong("").1, "the sheet has no item");
    for (text, line, word) in [
        ("size: 1x1\nnonsense\n", 2, "key: value"),
        ("item: a\npointz: 3\n", 2, "\"pointz\" is no key"),
        ("item: a\npoints: -1\n", 2, "points: a number"),
        ("item: a\npoints: nan\n", 2, "points: a number"),
        ("item: a\nexact: x.png\nitem: a\n", 3, "no other item"),
        ("title: t\nitem: a\npoints: 1\n", 2, "no exact picture"),
        ("item: a\nexact: x.png\ninput: exact\n", 1, "needs a stream"),
        ("item: a\npartly: 50\n", 2, "90% is expected"),
        ("item: a\nregion: 1 2 3\n", 2, "left, upper"),
        ("item: a\nnumbers: 1 two\n", 2, "\"two\" is no number"),
        ("item: a\ntime: 5\n", 2, "10s or 500ms"),
        ("item: a\nafter: soon\n", 2, "still"),
        ("item: a\nby: magic\n", 2, "renderizador is expected"),
        ("item: a\nfile ../x:\n  y\n", 2, "a name of letters"),
        ("item: a\nfile x.png:\n  y!\n", 2, "base64"),
        ("item: a\nsamples: 0\n", 2, "samples: a whole number"),
        ("item: a\nsamples: 1.5\n", 2, "samples: a whole number"),
        ("item: a\nframes: 2.5\n", 2, "frames: a whole number from 1 to 1000"),
        ("item: a\nsize:\n    8x6\n", 2, "same line"),
        ("  exact: x\n", 1, "key: value"),
    ] {
        let (at, message) = wrong(text);
        assert!(at == line && message.contains(word), "{text:?}: {at}: {message}");
    }
}

#[test]
fn pictures_are_written_in_base64_and_options_may_be_others() {
    assert_eq!(super::sheet::base64("iVBO\nRw0K Gg==").unwrap(), b"\x89PNG\r\n\x1a");
    let sheet = Sheet::parse("or: --a b\nitem: one\nexact: x\nor:\nsamples: 2\nitem: two\nexact: y\n");
    let error = sheet.unwrap_err();
    assert!(error.message.contains("same line"), "{error:?}");
    let sheet =
        Sheet::parse("or: --a b\nitem: one\nexact: x\nor: c\nsamples: 2\nitem: two\nexact: y\n").unwrap();
    assert_eq!((sheet.items[0].or.len(), sheet.items[0].samples), (2, 2));
    assert_eq!((sheet.items[1].or.len(), sheet.items[1].samples), (1, 1));
}

#[test]
fn what_is_no_sheet_does_no_harm() {
    let whole = builtin::named("T2").unwrap();
    for len in (0..whole.len()).filter(|len| whole.is_char_boundary(*len)) {
        let _ = Sheet::parse(&whole[..len]);
    }
    for text in
        ["\u{e9}: \u{e9}\n\t\u{e9}\n \u{e9}", "item:\n\n\n", ">", "::::", "exact:\n \u{3000}x\n\u{a0}y"]
    {
        let _ = Sheet::parse(text);
    }
}

#[test]
fn the_sheets_that_come_with_the_program_are_sheets_named_by_their_titles() {
    let list = builtin::list();
    assert_eq!(list.lines().count(), 12);
    for line in list.lines() {
        let name = line.split(' ').next().unwrap();
        let sheet = Sheet::parse(builtin::named(name).unwrap()).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        assert_eq!(sheet.title, line);
        assert!(sheet.items.iter().map(|item| item.points).sum::<f64>() >= 9.0, "{name}");
    }
    assert!(builtin::named("t1B").is_some() && builtin::named("T9").is_none());
}

/// The numbers of the sheet of the pipeline, by its own formulas.
#[test]
fn the_numbers_of_the_pipeline_are_those_of_its_formulas() {
    use glam::DVec3;
    let sheet = Sheet::parse(builtin::named("T2").unwrap()).unwrap();
    let item = |name: &str| sheet.items.iter().find(|item| item.name == name).unwrap();
    let numbers = |name: &str| match &item(name).exact {
        Wanted::Numbers(numbers) => numbers.clone(),
        other => panic!("{other:?}"),
    };
    let (eye, d, [w, h]) = (DVec3::new(2.0, 1.5, 4.0), 2.0, [512.0, 512.0]);
    let z = eye.normalize();
    let x = DVec3::Y.cross(z).normalize();
    let y = z.cross(x);
    let view = numbers("view");
    for (row, axis) in [x, y, z].iter().enumerate() {
        let exact = [axis.x, axis.y, axis.z, -axis.dot(eye)];
        let found = &view[4 * row..4 * row + 4];
        assert!(exact.iter().zip(found).all(|(e, f)| (e - f).abs() < 1e-5), "{exact:?} {found:?}");
    }
    let screen = |p: DVec3| {
        let scale = -d / z.dot(p - eye);
        let canonical = [x.dot(p - eye) * scale, y.dot(p - eye) * scale];
        [(canonical[0] + 1.0) * (w - 1.0) / 2.0, (1.0 - canonical[1]) * (h - 1.0) / 2.0]
    };
    let (_, model) = &item("screen").files[0];
    let vertices: Vec<DVec3> = model
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| DVec3::from_slice(&line.split(' ').map(|v| v.parse().unwrap()).collect::<Vec<f64>>()))
        .collect();
    let places: Vec<[f64; 2]> = vertices.iter().map(|v| screen(*v)).collect();
    for (exact, found) in places.iter().flatten().zip(numbers("screen")) {
        assert!((exact - found).abs() < 0.005, "{exact} {found}");
    }
    let Wanted::Text(lines) = &item("wire").exact else { panic!() };
    let pixels: Vec<[i32; 2]> = places.iter().map(|p| p.map(|v| (v + 0.5).floor() as i32)).collect();
    assert_eq!(lines.lines().count(), 12);
    for line in lines.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let end = |at: usize| [words[at].parse().unwrap(), words[at + 1].parse().unwrap()];
        assert!(pixels.contains(&end(1)) && pixels.contains(&end(3)), "{line}");
    }
}
