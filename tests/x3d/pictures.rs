//! Small golden pictures of every scene, looked at once and held since: BLESS=1 writes them anew.

use crate::files::readable;
use crate::support::{data, draw, load};
use fbptr::save::golden::{Tolerance, assert_golden};

#[test]
fn every_scene_looks_as_it_did() {
    for name in readable() {
        let memory = draw(&load(name).unwrap().at(0.0), 120, 90);
        assert_golden(&memory, data().join("golden").join(name.replace('/', "-").replace(".x3d", ".png")), Tolerance::EXACT);
    }
}

#[test]
fn animations_look_as_they_did_at_their_times() {
    for (name, times) in [
        ("x3d-cpp/demos/anim_color.x3d", [1.0, 2.5]),
        ("x3d-cpp/demos/anim_dvd.x3d", [1.0, 2.5]),
        ("x3d-cpp/demos/anim_orientation.x3d", [1.0, 2.5]),
        ("x3d-cpp/demos/anim_position.x3d", [1.0, 2.5]),
    ] {
        for time in times {
            let memory = draw(&load(name).unwrap().at(time), 120, 90);
            let file = format!("{}-at-{time}.png", name.replace('/', "-").replace(".x3d", ""));
            assert_golden(&memory, data().join("golden").join(file), Tolerance::EXACT);
        }
    }
}
