//! The course's dialect: scenes of two dimensions in pixels, y down.

use crate::support::{draw, parse};
use fbptr::load::x3d::{Dialect, Reading};

/// Returns the picture of a scene in pixels, a letter a pixel: the colour's channels at their full
/// strength, or `.` where there is none.
fn picture(nodes: &str, size: [u32; 2]) -> Vec<String> {
    let mut document = parse(&format!("<X3D><Scene>{nodes}</Scene></X3D>")).unwrap();
    document.set_reading(Reading { dialect: Dialect::Renderizador, ..Reading::default() });
    let memory = draw(&document.at_size(0.0, size), size[0], size[1]);
    let letter = |pixel: &[u8]| match pixel {
        [255, 0, 0, _] => 'r',
        [0, 255, 0, _] => 'g',
        [0, 0, 255, _] => 'b',
        [0, 0, 0, _] => '.',
        _ => '?',
    };
    let rows = memory.bytes().chunks(size[0] as usize * 4);
    rows.map(|row| row.chunks(4).map(letter).collect()).collect()
}

fn shape(color: &str, geometry: &str) -> String {
    format!("<Shape>{geometry}<Appearance><Material emissiveColor='{color}'/></Appearance></Shape>")
}

#[test]
fn coordinates_are_pixels_and_y_runs_down() {
    let line = shape("1 0 0", "<Polyline2D lineSegments='1.5 1.5  6.5 1.5  6.5 4.5'/>");
    let point = shape("0 1 0", "<Polypoint2D point='0 0  3.2 5.9'/>");
    let viewpoint = "<Viewpoint position='14 9 24'/><DirectionalLight/><Background skyColor='1 1 1'/>";
    assert_eq!(
        picture(&format!("{viewpoint}{line}{point}"), [9, 6]),
        ["g........", ".rrrrrr..", "......r..", "......r..", "......r..", "...g....."]
    );
}

#[test]
fn later_shapes_are_over_earlier_ones_from_either_side() {
    let below = shape("0 0 1", "<TriangleSet2D vertices='0 0  6 0  6 6  0 0  6 6  0 6'/>");
    let over = shape("1 0 0", "<TriangleSet2D vertices='2 2  2 4  4 4  2 2  4 4  4 2'/>");
    let moved = format!("<Transform translation='1 -1 0'>{over}</Transform>");
    assert_eq!(
        picture(&format!("{below}{moved}"), [6, 5]),
        ["bbbbbb", "bbbrrb", "bbbrrb", "bbbbbb", "bbbbbb"]
    );
    assert_eq!(picture(&format!("{moved}{below}"), [6, 5]), ["bbbbbb"; 5]);
}

/// The lines of the course's algorithm: ends are pixels, and both belong to the line.
#[test]
fn ends_of_lines_in_whole_numbers_are_pixels() {
    let line = |ends: &str| shape("1 0 0", &format!("<Polyline2D lineSegments='{ends}'/>"));
    let diagonal = ["r.....", ".r....", "..r...", "...r.."];
    assert_eq!(picture(&line("0 0  3 3"), [6, 4]), diagonal);
    assert_eq!(picture(&line("3 3  0 0"), [6, 4]), diagonal);
    assert_eq!(picture(&line("5 0  0 2"), [6, 3]), ["....rr", "..rr..", "rr...."]);
    let larger = format!("<Transform scale='2 2 1'>{}</Transform>", line("0 0  2 2"));
    assert_eq!(picture(&larger, [6, 4]), diagonal);
}
