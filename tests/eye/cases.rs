//! Verifies pictures of the N-dimensional eye against the worked cases.

use fbptr::eye::{EyePicture, EyeScene, render};
use serde_json::Value;
use std::fs;
use std::path::Path;

#[test]
fn every_worked_case_is_reproduced() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/nd-cases");
    let mut seen = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "json") {
            continue;
        }
        let text = fs::read(&path).unwrap();
        let case: Value = serde_json::from_slice(&text).unwrap();
        let scene = EyeScene::from_json(&text).unwrap();
        let expected = EyePicture::from_value(&case["expected"], &scene).unwrap();
        let fragile: Vec<usize> = case["expected"]["fragile"]
            .as_array()
            .unwrap()
            .iter()
            .map(|i| i.as_u64().unwrap() as usize)
            .collect();
        let picture = render(&scene);
        let differences = picture.differences(&expected, &fragile);
        assert!(differences.are_none(), "{}: {differences:?}", path.display());
        assert_eq!(
            EyePicture::from_value(&serde_json::from_str(&picture.to_json()).unwrap(), &scene).unwrap(),
            picture
        );
        seen += 1;
    }
    assert!(seen >= 8, "only {seen} cases found");
}

#[test]
fn a_picture_of_another_form_is_refused_at_its_place() {
    let scene = EyeScene::from_json(
        br#"{"dim": 2, "pixels": [2], "d": 1, "S": [2], "I_d": 0.2, "facets": [{"v": [[2, -1], [2, 1]], "color": [9, 9, 9]}],
            "lights": [{"type": "parallel", "direction": [1, 0], "color": [1, 1, 1]}]}"#,
    )
    .unwrap();
    let good = render(&scene).to_json();
    assert_eq!(
        EyePicture::from_value(&serde_json::from_str(&good).unwrap(), &scene).unwrap(),
        render(&scene)
    );
    let error = |from: &str, to: &str| {
        assert!(good.contains(from), "{from} in {good}");
        let value = serde_json::from_str(&good.replacen(from, to, 1)).unwrap();
        EyePicture::from_value(&value, &scene).unwrap_err().to_string()
    };
    for (from, to, expected) in [
        ("\"facet\":[0,0]", "\"facet\":[0]", "expected.facet: expected 2 entries, found 1"),
        ("\"lit\":[[true],[true]]", "\"lit\":[[true],[]]", "expected.lit[1]: expected 1 entries, found 0"),
        ("[true]", "[1]", "expected.lit[0][0]: expected true or false, found 1"),
        ("\"dist\"", "\"distance\"", "expected.distance: unknown field"),
    ] {
        let found = error(from, to);
        assert!(found.starts_with(expected), "{found}");
    }
}
