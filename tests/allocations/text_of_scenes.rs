//! The stated memory of reading an eye scene against the memory that is taken.
//!
//! Guards against a text made of one kind of character alone (brackets, braces, commas, letters)
//! that takes more than was stated for it.

use crate::TURN;
use crate::counting::most_held_here;
use fbptr::eye::{EyeScene, json_bytes};
use std::fmt::Write;
use std::sync::PoisonError;

/// Returns a scene of R^3 with this many facets, whose numbers are as short as possible.
fn scene(facets: usize) -> String {
    let mut text = String::from(r#"{"dim":3,"pixels":[4,4],"d":1,"S":[1,1],"I_d":1,"facets":["#);
    for i in 0..facets {
        let comma = if i == 0 { "" } else { "," };
        write!(text, r#"{comma}{{"v":[[2,0,0],[2,1,0],[2,0,1]],"color":[1,2,3]}}"#).unwrap();
    }
    text + "]}"
}

#[test]
fn no_text_takes_more_than_is_stated_for_it() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let many = 20_000;
    let about = |value: &str| format!(r#"{{"about":{value},"scene":{}}}"#, scene(1));
    let cases = [
        ("a scene", scene(many), true),
        ("a small scene", scene(3), true),
        ("empty arrays", about(&format!("[{}[]]", "[],".repeat(many))), false),
        ("arrays of one", about(&format!("[{}[0]]", "[0],".repeat(many))), false),
        ("arrays in arrays", about(&format!("[{}{}]", "[[[[[[1]]]]]],".repeat(many), 1)), false),
        ("objects of one", about(&format!(r#"[{}{{"a":0}}]"#, r#"{"a":0},"#.repeat(many))), false),
        ("empty objects", about(&format!("[{}{{}}]", "{},".repeat(many))), false),
        ("numbers", about(&format!("[{}0]", "0,".repeat(many))), false),
        ("one string", about(&format!(r#""{}""#, "a".repeat(many))), false),
        ("strings", about(&format!(r#"[{}"a"]"#, r#""a","#.repeat(many))), false),
    ];
    for (name, text, is_scene) in cases {
        let stated = json_bytes(text.as_bytes());
        let (read, held) = most_held_here(|| EyeScene::from_json(text.as_bytes()).is_ok());
        println!("{name}: {} bytes of text, {stated} stated, {held} held", text.len());
        assert!(held <= stated, "{name}: {held} bytes held, {stated} stated");
        // A statement far above the memory taken would refuse texts that could be read.
        assert!(stated < 12 * held + (64 << 10), "{name}: {held} bytes held, {stated} stated");
        assert!(read || !is_scene, "{name}");
    }
}
