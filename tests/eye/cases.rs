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
