//! Fear: a recipe of the protocol's page is refused, or shows nothing.

use fbptr::server::{Audience, Budget, Engine, Output, Stream};
use std::path::Path;

/// Returns the recipes of the page, with the paragraph before each.
fn recipes() -> Vec<(String, String)> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/protocol.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let (_, rest) = page.split_once("\n## Recipes\n").expect("it has recipes");
    let (recipes, _) = rest.split_once("\n## ").expect("and more after them");
    let parts: Vec<&str> = recipes.split("```").collect();
    let of = |pair: &[&str]| {
        let code = pair[1].strip_prefix("text\n").expect("a block of text");
        let text = pair[0].trim().rsplit("\n\n").next().unwrap_or("");
        (text.to_owned(), code.to_owned())
    };
    parts.chunks(2).filter(|pair| pair.len() == 2).map(of).collect()
}

#[test]
fn every_recipe_of_the_page_draws_what_it_says() {
    let recipes = recipes();
    assert!(recipes.len() >= 5, "{recipes:?}");
    for idea in ["Two dimensions", "Three dimensions", "A texture", "An animation", "Reading back"] {
        let (_, code) = recipes.iter().find(|(text, _)| text.starts_with(idea)).expect(idea);
        let mut engine = Engine::new(640, 480).expect("a frame");
        let mut stream = Stream::new(&engine, 1, Audience::Owner);
        let mut out = Output::default();
        let mut rest = code.as_bytes();
        // A pause ends a part of the stream.
        while !rest.is_empty() {
            let (used, _) = stream.feed(&mut engine, rest, &mut out, Budget::NONE);
            rest = &rest[used..];
        }
        assert_eq!(out.notices, [], "{idea}");
        let pixels = engine.memory().bytes().as_chunks::<4>().0;
        let mut colors: Vec<_> = pixels.to_vec();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() >= 2, "{idea}: one colour");
        match idea {
            "Three dimensions" => {
                assert!(code.lines().count() == 4 && colors.len() > 50, "{}", colors.len());
                let lit = pixels.iter().filter(|pixel| **pixel != [0, 0, 0, 255]).count();
                assert!(lit > 640 * 480 / 10, "{lit}");
            }
            "A texture" => {
                let has = |near: [u8; 3]| colors.iter().any(|c| (0..3).all(|k| c[k].abs_diff(near[k]) < 110));
                assert!(has([255, 160, 0]) && has([40, 0, 80]), "both colours");
            }
            "Reading back" => {
                let replies = String::from_utf8_lossy(&out.replies).into_owned();
                assert!(replies.starts_with("PX 10 10 ff8000\nREAD 10 10 1 1 :4\n"), "{replies}");
                assert!(replies.ends_with("SYNC done\n"), "{replies}");
            }
            _ => {}
        }
    }
}
