//! Scenes read with their defaults; every mistake is an error with its path.

use super::*;
use crate::error::Code;

const GOOD: &str = r#"{"dim": 3, "pixels": [4], "d": 1, "S": [2], "aperture_tan": [0.5], "I_d": 0.2,
        "view": {"k": 2, "n": 1}, "background": [1, 2, 3], "eye": {"position": [0, 0, 1], "rotations": [[0, 2, 45]]},
        "lights": [{"type": "parallel", "direction": [0, -1, 0], "k": 1, "n": 0, "color": [1, 0.5, 0]},
                   {"type": "radial", "position": [1, 2, 3]},
                   {"type": "parallel", "direction": [0, 0, 2], "point": [0, 0, 5], "n": 1}],
        "facets": [{"v": [[1, 0, 0], [1, 1, 0], [1, 0, 1]], "color": [200, 100, 50]}]}"#;

fn error_of(text: &str) -> String {
    EyeScene::from_json(text.as_bytes()).expect_err(text).to_string()
}

#[test]
fn a_scene_is_read_with_its_defaults_and_written_back() {
    let scene = EyeScene::from_json(GOOD.as_bytes()).unwrap();
    assert_eq!(scene.lights[0].falloff, Falloff { k: 1.0, n: 0.0 });
    assert_eq!(scene.lights[1].falloff, Falloff { k: 4.0, n: 2.0 });
    assert_eq!(scene.lights[2].falloff, Falloff { k: 2.0, n: 1.0 });
    assert_eq!(scene.lights[1].color, [1.0; 3]);
    assert_eq!((scene.screen_dim(), scene.hidden_dim()), (1, 1));
    assert_eq!(EyeScene::from_json(scene.to_value().to_string().as_bytes()).unwrap(), scene);
    let short = r#"{"dim": 2, "pixels": [1], "d": 1, "S": [1], "facets": []}"#;
    let scene = EyeScene::from_json(short.as_bytes()).unwrap();
    assert_eq!((scene.view, scene.diffuse, scene.background), (Falloff::OFF, [0.0; 3], [0.0; 3]));
}

#[test]
fn colours_may_be_words() {
    let read = |text: String| EyeScene::from_json(text.as_bytes());
    let scene = read(
        GOOD.replacen("0.2", "\"#33\"", 1)
            .replacen("[1, 2, 3], \"eye", "\"Tomato\", \"eye", 1)
            .replacen("[1, 0.5, 0]", "\"0033FF\"", 1)
            .replacen("[200, 100, 50]", "\"#c86432\"", 1),
    )
    .unwrap();
    assert_eq!((scene.diffuse, scene.background), ([0.2; 3], [255.0, 99.0, 71.0]));
    assert_eq!((scene.lights[0].color, scene.facets[0].color), ([0.0, 0.2, 1.0], [200.0, 100.0, 50.0]));
    for word in ["reddish", "#red", "", "#", "##ff", "ff000080", "transparent"] {
        assert_eq!(
            error_of(&GOOD.replacen("[200, 100, 50]", &format!("{word:?}"), 1)),
            format!(
                "facets[0].color: expected three numbers, a CSS colour name, or gg or rrggbb in hex, found {word:?}"
            )
        );
    }
    assert!(error_of(&GOOD.replacen("0.2", "true", 1)).starts_with("I_d: expected three numbers, a CSS"));
}

#[test]
fn every_mistake_is_refused_with_its_place() {
    for (from, to, want) in [
        (r#""dim": 3"#, r#""dim": 9"#, "dim: expected a whole number from 0 to 8, found 9"),
        (r#""dim": 3"#, r#""dim": 1"#, "dim: expected a whole number from 2 to 8, found 1"),
        (r#""dim": 3, "#, "", "dim: missing"),
        (r#""dim": 3"#, r#""dim": 2.5"#, "dim: expected a whole number from 0 to 8, found 2.5"),
        ("[4]", "[]", "pixels: expected 1 to 2 (one a screen axis) entries, found 0"),
        ("[4]", "[0]", "pixels[0]: expected a whole number from 1, found 0"),
        ("[4]", "[4000000000]", "pixels: 4000000000 is over the limit of 67108864"),
        (r#""d": 1"#, r#""d": 0"#, "d: expected a finite number over 0, found 0"),
        (r#""S": [2]"#, r#""S": [2, 2]"#, "S: expected 1 entries, found 2"),
        ("[0.5], ", "[0.5, 0.5], ", "aperture_tan: expected 1 entries, found 2"),
        ("[0.5], ", "[-0.5], ", "aperture_tan[0]: expected a finite tangent of at least 0, found -0.5"),
        (r#""aperture_tan": [0.5], "#, "", "aperture_tan: missing"),
        (
            r#""aperture_tan": [0.5]"#,
            r#""aperture_deg": [90]"#,
            "aperture_deg[0]: expected an angle from 0 to below 90, found 90",
        ),
        (
            r#""aperture_tan": [0.5]"#,
            r#""aperture_tan": [0.5], "aperture_deg": [30]"#,
            "aperture_deg: expected either aperture_tan or aperture_deg, found both",
        ),
        (r#""I_d": 0.2"#, r#""I_d": 1.2"#, "I_d[0]: expected 0 to 1, found 1.2"),
        (r#""I_d": 0.2"#, r#""I_d": [0, 1]"#, "I_d: expected 3 entries, found 2"),
        (r#""n": 1}, "b"#, r#""m": 1}, "b"#, "view.m: unknown field, expected one of k, n"),
        (r#""k": 2"#, r#""k": -2"#, "view.k: expected a finite number of at least 0, found -2"),
        ("[0, 0, 1], \"r", "[0, 1], \"r", "eye.position: expected 3 entries, found 2"),
        ("[0, 2, 45]", "[0, 3, 45]", "eye.rotations[0][1]: expected a whole number from 0 to 2, found 3"),
        ("[0, 2, 45]", "[2, 2, 45]", "eye.rotations[0][1]: expected another axis than the first, found 2"),
        (
            "[0, 2, 45]",
            "[0, 2]",
            "eye.rotations[0]: expected 3 (two axes and an angle in degrees) entries, found 2",
        ),
        ("\"parallel\"", "\"spot\"", r#"lights[0].type: expected "parallel" or "radial", found "spot""#),
        ("[0, -1, 0]", "[0, 0, 0]", "lights[0].direction: expected a vector that is not zero, found 0"),
        (
            "\"n\": 0,",
            "\"n\": 2,",
            "lights[0].n: expected 0 (a parallel light without a point is infinitely far), found 2",
        ),
        ("[1, 0.5, 0]", "[1, 2, 0]", "lights[0].color[1]: expected 0 to 1, found 2"),
        (
            "[1, 2, 3]}",
            "[1, 2, 3], \"point\": 0}",
            "lights[1].point: unknown field, expected one of type, position, k, n, color",
        ),
        ("[1, 1, 0], ", "", "facets[0].v: expected 3 entries, found 2"),
        ("[1, 1, 0]", "[1, 1]", "facets[0].v[1]: expected 3 entries, found 2"),
        ("[1, 1, 0]", "[1, null, 0]", "facets[0].v[1][1]: expected a finite number, found null"),
        ("[200, 100, 50]", "[200, 256, 50]", "facets[0].color[1]: expected 0 to 255, found 256"),
        (", \"color\": [200, 100, 50]", "", "facets[0].color: missing"),
        (
            "\"facets\"",
            "\"faces\"",
            "faces: unknown field, expected one of dim, pixels, d, S, aperture_tan, aperture_deg, I_d, view, background, eye, lights, facets",
        ),
        ("[1, 1, 0]", "[1, 1e999, 0]", "line 6 column 46: number out of range"),
        ("[1, 1, 0]", "[1, NaN, 0]", "line 6 column 42: expected value"),
    ] {
        assert!(GOOD.contains(from), "{from}");
        assert_eq!(error_of(&GOOD.replacen(from, to, 1)), want);
    }
    assert_eq!(error_of("[]"), "the scene: expected an object, found an array of 0");
    let case = format!(r#"{{"about": "x", "scene": {}}}"#, GOOD.replacen("[1, 1, 0]", "[1, 1]", 1));
    assert_eq!(error_of(&case), "scene.facets[0].v[1]: expected 3 entries, found 2");
    let huge = GOOD.replacen("[4]", "[4000000000]", 1);
    assert_eq!(EyeScene::from_json(huge.as_bytes()).unwrap_err().code(), Code::TooBig);
}

#[test]
fn apertures_in_degrees_are_tangents_of_their_angles() {
    for (degrees, tangent) in [("0", 0.0), ("45", 1.0), ("30", 1.0 / 3f64.sqrt()), ("80", 5.671281819617709)]
    {
        let text = GOOD.replacen(r#""aperture_tan": [0.5]"#, &format!(r#""aperture_deg": [{degrees}]"#), 1);
        let parts = EyeScene::from_json(text.as_bytes()).unwrap().into_parts();
        assert!((parts.aperture_tan[0] - tangent).abs() <= 1e-15 * tangent, "{degrees}: {parts:?}");
    }
}
