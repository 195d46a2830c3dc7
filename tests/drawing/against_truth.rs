//! Draws a case by the pipeline and by the reference, and reports the differences.

use fbptr::measure::{Drawn, draw_case};
use fbptr::scene::Object;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::Case;
use fbptr::truth::{TruthPicture, render};

/// Returns the pixels at which PICK would return another face than the only right answer.
fn picks_off(drawn: &Drawn, truth: &TruthPicture) -> Vec<(u32, u32)> {
    let pixels = (0..truth.height()).flat_map(|y| (0..truth.width()).map(move |x| (x, y)));
    pixels
        .filter(|&(x, y)| {
            let states = truth.states(x, y);
            let right = states[0].depth_owner.map(|key| (truth.face(key).object, truth.face(key).triangle));
            states.len() == 1 && !truth.is_free(x, y) && drawn.ids.get(x as i32, y as i32) != right
        })
        .collect()
}

/// Draws a case both ways; returns a description of what is wrong, if anything.
pub fn fault_of(case: &Case) -> Option<String> {
    let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
    let drawn = draw_case(case);
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    // The pick buffer numbers triangles; the truth numbers lines and points, too.
    let has_triangles_alone =
        |o: &Object| o.geometry.mesh.lines.is_empty() && o.geometry.mesh.points.is_empty();
    let picks = match case.scene.objects.iter().all(has_triangles_alone) {
        true => picks_off(&drawn, &truth),
        false => Vec::new(),
    };
    if report.is_right() && picks.is_empty() {
        return None;
    }
    let s = &case.settings;
    Some(format!(
        "{}: {report}  picks off: {picks:?}\n  {s:?} {:?} {}x{}\n  {:?}",
        case.name, case.format, case.width, case.height, case.scene.camera
    ))
}
