//! The viewer's overlay, drawn over the window's pixels: text in two corners, the inspector's
//! enlarged pixels, and below the picture the list of keys or the plan.

use super::overlay::{Canvas, Corner, box_size, draw_box, draw_lines};
use super::scanout::word;
use crate::viewer::{Overlay, Zoom};
use fbptr_core::draw2d::font::CELL;
use fbptr_core::draw2d::look::PAPER;

/// Margin around the boxes, in pixels.
const EDGE: usize = 4;
/// Number of characters between two columns of a list that does not fit one column.
const GAP: usize = 3;
/// Separates the parts of a status line.
const BAR: &str = " | ";
/// Width in pixels from which a window has text at twice the font's size.
const ENLARGED_FROM: usize = 960;
/// Least side of an enlarged pixel.
const SMALLEST_CELL: usize = 4;
/// Colour of the inspector's pixels outside the frame.
const OFF_FRAME: u32 = 0x0030_0030;

/// A list arranged below the picture.
pub struct ListPanel {
    lines: Vec<String>,
    scale: usize,
    /// Rows of the window that the list takes.
    pub height: usize,
}

impl ListPanel {
    /// Arranges `list` in columns for a window of `width` x `height`, over two fifths of its rows at
    /// most: at twice the font's size if there is room. A window too small for all lines gets the
    /// first ones. An empty list takes no rows.
    pub fn new(list: &[String], [width, height]: [usize; 2]) -> ListPanel {
        let most = height * 2 / 5;
        if list.is_empty() {
            return ListPanel { lines: Vec::new(), scale: 1, height: 0 };
        }
        let arranged = |scale: usize, columns: usize| {
            let lines = in_columns(list, columns);
            let [w, h] = box_size(&lines, scale);
            (w <= width && h <= most).then_some(ListPanel { lines, scale, height: h })
        };
        let choices = (1..=2).rev().flat_map(|scale| (1..=4).map(move |columns| (scale, columns)));
        choices.into_iter().find_map(|(scale, columns)| arranged(scale, columns)).unwrap_or_else(|| {
            let lines = beginning(list, width, most);
            let height = box_size(&lines, 1)[1].min(height);
            ListPanel { lines, scale: 1, height }
        })
    }

    /// Draws the list on the lowest rows of the canvas.
    fn draw(&self, canvas: &mut Canvas<'_>) {
        let top = canvas.height.saturating_sub(self.height);
        canvas.words[top * canvas.width..].fill(word(PAPER));
        let left = canvas.width.saturating_sub(box_size(&self.lines, self.scale)[0]) / 2;
        draw_lines(canvas, [left, top], &self.lines, self.scale);
    }
}

/// Draws all of `overlay` that fits: `panel`, its list, on the lowest rows, the rest on the picture
/// above them. The lower text is placed in a corner where it covers little of
/// the picture, and none of `captions`, rectangles of the canvas (left, top, right, bottom):
/// `corner` is the previous one, and is updated.
pub fn draw(
    canvas: &mut Canvas<'_>,
    overlay: &Overlay,
    panel: &ListPanel,
    captions: &[[usize; 4]],
    corner: &mut Corner,
) {
    panel.draw(canvas);
    let (width, height) = (canvas.width, canvas.height.saturating_sub(panel.height));
    let canvas = &mut Canvas { words: &mut canvas.words[..width * height], width, height };
    draw_over_picture(canvas, overlay, captions, corner);
}

/// Draws the texts of the corners and the inspector.
fn draw_over_picture(
    canvas: &mut Canvas<'_>,
    overlay: &Overlay,
    captions: &[[usize; 4]],
    corner: &mut Corner,
) {
    let bottom = fitting(&overlay.bottom, canvas.width, canvas.height);
    let [_, bottom_height] = box_size(&bottom.0, bottom.1);
    let mut top = [0; 2];
    if !overlay.top.is_empty() {
        let room = canvas.height.saturating_sub(bottom_height + 3 * EDGE);
        let (lines, scale) = fitting(&overlay.top, canvas.width, room);
        draw_box(canvas, [EDGE, EDGE], &lines, scale);
        top = box_size(&lines, scale).map(|side| side + EDGE);
    }
    if !bottom.0.is_empty() {
        // The upper corners are available unless the other text or the inspector is shown.
        let is_top_free = overlay.top.is_empty() && overlay.zoom.is_none();
        let mut corners = vec![Corner::BottomLeft, Corner::BottomRight];
        corners.extend(is_top_free.then_some([Corner::TopLeft, Corner::TopRight]).into_iter().flatten());
        let (lines, scale) = (&bottom.0, bottom.1);
        // Where there is no room for all lines, the last ones are left out: they are the status.
        let mut place = |count: usize| {
            let size = box_size(&lines[..count], scale);
            place_beside(captions, &corners, size, canvas, top[1], corner).map(|at| (at, count))
        };
        if let Some((at, count)) = (1..=lines.len()).rev().find_map(&mut place) {
            draw_box(canvas, at, &lines[..count], scale);
        }
    }
    if let Some(zoom) = &overlay.zoom {
        draw_zoom(canvas, zoom, top, bottom_height + 2 * EDGE);
    }
}

/// Returns the upper left corner of a box of `size` that covers no caption: in one of `corners`,
/// otherwise above the captions on the left, not above row `top`. `None` if there is no room.
fn place_beside(
    captions: &[[usize; 4]],
    corners: &[Corner],
    size: [usize; 2],
    canvas: &Canvas<'_>,
    top: usize,
    corner: &mut Corner,
) -> Option<[usize; 2]> {
    let canvas_size = [canvas.width, canvas.height];
    let covered = |[x, y]: [usize; 2]| {
        let meets = |c: &&[usize; 4]| x <= c[2] && c[0] <= x + size[0] && y <= c[3] && c[1] <= y + size[1];
        captions.iter().find(meets)
    };
    let is_clear = |corner: &Corner| covered(corner.place(canvas_size, size)).is_none();
    let clear: Vec<Corner> = corners.iter().copied().filter(is_clear).collect();
    // The fourth part of a split screen has no picture.
    if !captions.is_empty() && clear.contains(&Corner::BottomRight) {
        *corner = Corner::BottomRight;
        return Some(corner.place(canvas_size, size));
    }
    if !clear.is_empty() {
        *corner = Corner::choose(Some(*corner), &clear, canvas, size);
        return Some(corner.place(canvas_size, size));
    }
    let mut at = Corner::BottomLeft.place(canvas_size, size);
    while let Some(caption) = covered(at) {
        at[1] = caption[1].checked_sub(size[1] + 1)?;
    }
    (at[1] >= top).then_some(at)
}

/// Lays out lines for a box of `width` x `height`. Returns them and their scale: twice the font's
/// size if there is room, in columns if one column does not fit.
fn fitting(lines: &[String], width: usize, height: usize) -> (Vec<String>, usize) {
    let fits = |lines: &[String], scale: usize| {
        let [w, h] = box_size(lines, scale);
        w + 2 * EDGE <= width && h <= height
    };
    // Depends on the window, not on the text, so that a growing line does not shrink.
    let letters = width.saturating_sub(box_size(&[], 2)[0] + 2 * EDGE) / (2 * CELL);
    let broken: Vec<String> = lines.iter().flat_map(|line| broken(line, letters)).collect();
    if width >= ENLARGED_FROM && fits(&broken, 2) {
        return (broken, 2);
    }
    for columns in 1..=3 {
        let laid = in_columns(lines, columns);
        if fits(&laid, 1) {
            return (laid, 1);
        }
    }
    (beginning(lines, width, height), 1)
}

/// Returns what fits of lines that are too many for a box of `width` x `height`, with a last line
/// that says how many are left out.
fn beginning(lines: &[String], width: usize, height: usize) -> Vec<String> {
    let [line_height, margins] =
        [box_size(&[String::new()], 1)[1] - box_size(&[], 1)[1], box_size(&[], 1)[1]];
    let rows = height.saturating_sub(margins) / line_height;
    if lines.len() <= rows {
        // Too wide, which no choice of lines changes.
        return lines.to_vec();
    }
    let begun = |columns: usize| {
        let shown = (rows.saturating_sub(1) * columns).min(lines.len());
        let mut laid = in_columns(&lines[..shown], columns);
        laid.push(format!("... {} more in a larger window", lines.len() - shown));
        laid
    };
    let fits = |laid: &Vec<String>| box_size(laid, 1)[0] + 2 * EDGE <= width;
    (1..=3).rev().map(begun).find(fits).unwrap_or_else(|| begun(1))
}

/// Breaks a line of parts with bars between them into lines of at most `letters` letters; a part
/// that is longer stays whole.
fn broken(line: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in line.split(BAR) {
        match lines.last_mut() {
            Some(last) if last.chars().count() + BAR.len() + part.chars().count() <= letters => {
                *last += BAR;
                *last += part;
            }
            _ => lines.push(part.to_owned()),
        }
    }
    lines
}

/// Arranges the lines in this many columns, filled from top to bottom.
fn in_columns(lines: &[String], columns: usize) -> Vec<String> {
    let rows = lines.len().div_ceil(columns);
    let widths: Vec<usize> =
        lines.chunks(rows.max(1)).map(|c| c.iter().map(|l| l.chars().count()).max().unwrap_or(0)).collect();
    let row = |i: usize| {
        let cells =
            lines.chunks(rows).zip(&widths).filter_map(|(column, width)| Some((column.get(i)?, *width)));
        let text: String = cells.map(|(line, width)| format!("{line:<0$}", width + GAP)).collect();
        text.trim_end().to_owned()
    };
    (0..rows).map(row).collect()
}

/// Draws the enlarged pixels with their text below, in a corner away from the pointer: an upper one,
/// or, where the upper text reaches to it, `above_end` pixels above the lower end, enlarged less if
/// they would cover the text. `top` is the lower right corner of the upper text's box.
fn draw_zoom(canvas: &mut Canvas<'_>, zoom: &Zoom, top: [usize; 2], above_end: usize) {
    let [text_width, text_height] = box_size(&zoom.lines, 1);
    let place = |cell: usize| {
        let width = (zoom.side * cell).max(text_width);
        let x = if zoom.belongs_left { EDGE } else { canvas.width.saturating_sub(width + EDGE) };
        let low = canvas.height.checked_sub(above_end + zoom.side * cell + text_height);
        [x, low.filter(|_| x < top[0]).unwrap_or(EDGE)]
    };
    let is_clear = |cell: &usize| matches!(place(*cell), [x, y] if x >= top[0] || y >= top[1]);
    let largest = (canvas.height / 3 / zoom.side).clamp(SMALLEST_CELL, 16);
    let cell = (SMALLEST_CELL..=largest).rev().find(is_clear).unwrap_or(SMALLEST_CELL);
    let [x, y] = place(cell);
    let side = zoom.side * cell;
    let height = side + text_height;
    if x + side > canvas.width || y + height > canvas.height {
        // No room for the pixels: only their text.
        return draw_box(canvas, [x.min(canvas.width), EDGE], &zoom.lines, 1);
    }
    for (i, color) in zoom.colors.iter().enumerate() {
        let (left, top) = (x + i % zoom.side * cell, y + i / zoom.side * cell);
        let words = color.map_or(OFF_FRAME, word);
        for row in top..top + cell {
            canvas.words[row * canvas.width + left..][..cell].fill(words);
        }
    }
    // A border around the middle pixel, black in white, visible on any colour.
    let (left, top) = (x + zoom.side / 2 * cell, y + zoom.side / 2 * cell);
    outline(canvas, [left - 1, top - 1, cell + 2], 0x00ff_ffff);
    outline(canvas, [left, top, cell], 0);
    draw_box(canvas, [x, y + side], &zoom.lines, 1);
}

/// Draws the border of a square.
fn outline(canvas: &mut Canvas<'_>, [x, y, side]: [usize; 3], color: u32) {
    for i in 0..side {
        for at in [y * canvas.width + x + i, (y + side - 1) * canvas.width + x + i] {
            canvas.words[at] = color;
        }
        for at in [(y + i) * canvas.width + x, (y + i) * canvas.width + x + side - 1] {
            canvas.words[at] = color;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::help_lines;

    /// Draws the overlay with its list.
    fn draw_all(canvas: &mut Canvas<'_>, overlay: &Overlay, captions: &[[usize; 4]], corner: &mut Corner) {
        let panel = ListPanel::new(&overlay.list, [canvas.width, canvas.height]);
        draw(canvas, overlay, &panel, captions, corner);
    }

    #[test]
    fn long_lists_stand_in_columns() {
        let lines: Vec<String> = (0..7).map(|i| format!("line {i}")).collect();
        assert_eq!(in_columns(&lines, 2)[0], "line 0   line 4");
        assert_eq!(in_columns(&lines, 2)[3], "line 3");
        assert_eq!(in_columns(&lines, 1), lines);
        assert!(in_columns(&[], 3).is_empty());
    }

    #[test]
    fn a_status_line_breaks_at_its_bars_and_keeps_its_size() {
        let line = "monkey_head2.obj | as given | cull front | hide none | F1 help".to_owned();
        let (lines, scale) = fitting(std::slice::from_ref(&line), 960, 720);
        assert_eq!(lines, ["monkey_head2.obj | as given | cull front | hide none", "F1 help"]);
        assert!(scale == 2 && box_size(&lines, scale)[0] + 2 * EDGE <= 960);
        assert_eq!(fitting(std::slice::from_ref(&line), 1280, 720), (vec![line.clone()], 2));
        assert_eq!(fitting(std::slice::from_ref(&line), 640, 480), (vec![line], 1));
        // What cannot be broken is small.
        assert_eq!(fitting(&["x".repeat(80)], 960, 720).1, 1);
    }

    #[test]
    fn every_key_is_listed_below_the_picture_in_the_usual_windows() {
        for size @ [width, height] in [[640, 480], [800, 600], [960, 720], [1280, 960], [1920, 1080]] {
            for is_nd in [false, true] {
                let keys = help_lines(is_nd);
                let panel = ListPanel::new(&keys, size);
                assert!(box_size(&panel.lines, panel.scale)[0] <= width && panel.height <= height * 2 / 5);
                assert!(panel.lines[1].split("   ").filter(|cell| !cell.is_empty()).count() >= 2);
                for key in &keys {
                    assert!(panel.lines.iter().any(|line| line.contains(key.trim_end())), "{size:?}: {key}");
                }
            }
        }
    }

    #[test]
    fn a_small_window_says_how_many_keys_it_leaves_out() {
        for is_nd in [false, true] {
            let keys = help_lines(is_nd);
            for size @ [width, height] in [[320, 240], [360, 120], [310, 300]] {
                let panel = ListPanel::new(&keys, size);
                let [w, h] = box_size(&panel.lines, panel.scale);
                assert!(w <= width && h <= height * 2 / 5, "{width}x{height}: {w}x{h}");
                let (last, shown) = panel.lines.split_last().unwrap();
                let shown = keys.iter().filter(|key| shown.iter().any(|line| line.contains(key.trim_end())));
                assert_eq!(*last, format!("... {} more in a larger window", keys.len() - shown.count()));
            }
        }
    }

    #[test]
    fn the_list_covers_nothing_of_the_picture() {
        let (width, height) = (640, 480);
        let overlay = Overlay { list: help_lines(false), ..Overlay::default() };
        let panel = ListPanel::new(&overlay.list, [width, height]);
        let mut words = vec![0x0012_3456; width * height];
        draw(
            &mut Canvas { words: &mut words, width, height },
            &overlay,
            &panel,
            &[],
            &mut Corner::BottomLeft,
        );
        let (picture, list) = words.split_at(width * (height - panel.height));
        assert!(picture.iter().all(|w| *w == 0x0012_3456) && list.iter().all(|w| *w != 0x0012_3456));
        assert!(list.contains(&word(fbptr_core::draw2d::look::TEXT)));
    }

    #[test]
    fn the_inspector_covers_no_text() {
        let (width, height) = (960, 720);
        // As wide as the window allows at twice the size, and as high as a plan.
        let top: Vec<String> = (0..21).map(|_| "x".repeat(55)).collect();
        let lines = vec!["x 1 y 2".into(); 12];
        let text = |zoom: Option<Zoom>| {
            let mut words = vec![0; width * height];
            let overlay = Overlay { top: top.clone(), zoom, ..Overlay::default() };
            draw_all(
                &mut Canvas { words: &mut words, width, height },
                &overlay,
                &[],
                &mut Corner::BottomLeft,
            );
            let [w, h] = box_size(&top, 2);
            let inside = |i: &usize| (i % width) < EDGE + w && i / width < EDGE + h;
            (0..words.len()).filter(inside).map(|i| words[i]).collect::<Vec<u32>>()
        };
        for belongs_left in [false, true] {
            let colors = vec![Some([9, 9, 9, 255]); 121];
            let zoom = Zoom { side: 11, colors, lines: lines.clone(), belongs_left };
            assert!(text(Some(zoom)) == text(None), "left: {belongs_left}");
        }
    }

    #[test]
    fn the_lower_text_makes_room_for_a_caption() {
        let (width, height) = (200, 100);
        let overlay = Overlay { bottom: vec!["a status line".into()], ..Overlay::default() };
        let lit = |words: &[u32], rows: std::ops::Range<usize>| {
            words[rows.start * width..rows.end * width].contains(&word(fbptr_core::draw2d::look::TEXT))
        };
        let (mut blank, mut corner) = (vec![0; width * height], Corner::BottomLeft);
        draw_all(&mut Canvas { words: &mut blank, width, height }, &overlay, &[], &mut corner);
        assert!(lit(&blank, 70..100) && !lit(&blank, 0..70));
        // Grey stripes over the entire foot of the picture.
        let word = |i: usize| if i / width > 80 { (i as u32 % 2) * 0x0080_8080 } else { 0 };
        let mut captioned: Vec<u32> = (0..width * height).map(word).collect();
        draw_all(&mut Canvas { words: &mut captioned, width, height }, &overlay, &[], &mut corner);
        assert!(lit(&captioned, 0..30) && !lit(&captioned, 70..100));
        assert!(
            captioned[81 * width..].iter().enumerate().all(|(i, w)| *w == word(81 * width + i)),
            "all is there"
        );
    }

    #[test]
    fn the_lower_text_covers_no_caption_in_a_window_of_any_size() {
        let lines = ["not drawn: why", "a_model.obj | Phong | cull back | hide zbuffer | F1 help"];
        let mut sizes_without = 0;
        for has_top in [false, true] {
            let top = if has_top { vec!["10.0 frames/s".to_owned(); 3] } else { Vec::new() };
            let bottom = lines.map(str::to_owned).to_vec();
            let overlay = Overlay { top, bottom, ..Overlay::default() };
            for (width, height) in [(1280, 720), (640, 360), (480, 270), (320, 180), (200, 112), (96, 54)] {
                // As on a split screen: below three pictures, and at the top of the fourth part.
                let (w, h) = (width / 2, height / 2);
                let captions = [
                    [8, h - h / 8, w - 8, h - 8],
                    [w, h - h / 8, width - 8, h - 8],
                    [8, height - h / 8, w - 8, height - 8],
                    [w, h, width - 8, height - h / 2],
                ];
                let mut words = vec![0; width * height];
                let mut canvas = Canvas { words: &mut words, width, height };
                let alone = Overlay { bottom: Vec::new(), ..overlay.clone() };
                draw_all(&mut canvas, &alone, &captions, &mut Corner::BottomLeft);
                let before = words.clone();
                let mut canvas = Canvas { words: &mut words, width, height };
                draw_all(&mut canvas, &overlay, &captions, &mut Corner::BottomLeft);
                sizes_without += usize::from(words == before);
                for [left, top, right, bottom] in captions {
                    for y in top..bottom {
                        let row = y * width + left..y * width + right;
                        assert!(words[row.clone()] == before[row], "{width}x{height} {has_top}");
                    }
                }
            }
        }
        assert_eq!(sizes_without, 0);
    }

    #[test]
    fn any_overlay_fits_any_canvas_without_harm() {
        let zoom = |belongs_left| Zoom {
            side: 11,
            colors: (0..121).map(|i| (i % 3 > 0).then_some([i as u8, 0, 0, 255])).collect(),
            lines: vec!["x 1 y 2".into(), "FBptr[4]".into()],
            belongs_left,
        };
        for (width, height) in [(1, 1), (30, 20), (64, 48), (200, 90), (640, 480)] {
            for belongs_left in [false, true] {
                let overlay = Overlay {
                    list: help_lines(true),
                    top: vec!["10.0 frames/s".into()],
                    bottom: vec!["a status line of some length".into()],
                    zoom: Some(zoom(belongs_left)),
                    captions: Vec::new(),
                };
                let mut words = vec![0x0012_3456; width * height];
                let mut canvas = Canvas { words: &mut words, width, height };
                draw_all(&mut canvas, &overlay, &[], &mut Corner::BottomLeft);
                assert!(width < 30 || words.iter().any(|&w| w != 0x0012_3456));
            }
        }
    }
}
