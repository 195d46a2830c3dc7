//! Small golden pictures of every scene, inspected once and compared since: BLESS=1 rewrites them.

use crate::files::readable;
use crate::support::{data, draw, load};
use fbptr::save::golden::{Mode, Tolerance, check};

/// Animated scenes, and the times at which they are drawn beside the start.
const MOVING: [&str; 4] = ["color", "dvd", "orientation", "position"];
const TIMES: [f64; 2] = [1.0, 2.5];

#[test]
fn every_scene_looks_as_it_did() {
    let still = readable().map(|name| (name.to_string(), 0.0));
    let moving = MOVING.iter().flat_map(|n| TIMES.map(|t| (format!("x3d-cpp/demos/anim_{n}.x3d"), t)));
    let failures: Vec<String> = still
        .chain(moving)
        .filter_map(|(name, time)| {
            let memory = draw(&load(&name).unwrap().at(time), 120, 90);
            let file = format!("{}-at-{time}.png", name.replace('/', "-").replace(".x3d", ""));
            check(&memory, data().join("golden").join(file), Tolerance::EXACT, Mode::from_env()).err()
        })
        .map(|e| e.to_string())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
