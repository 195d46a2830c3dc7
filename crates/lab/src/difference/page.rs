//! A difference as one HTML page: both pictures, the wrong pixels in the colours of their classes,
//! and for each class some places, magnified.

use super::{Class, Finding, WrongPixels};
use crate::write::{escape, png_base64};
use std::fmt::Write as _;

/// Pixels to each side of a magnified one.
const AROUND: i64 = 6;
/// Size of a magnified pixel on the page.
const MAGNIFIED: i64 = 14;

/// Colour of a class.
fn color(class: Class) -> [u8; 4] {
    const COLORS: [[u8; 3]; 13] = [
        [255, 0, 255],
        [255, 80, 0],
        [140, 70, 0],
        [255, 200, 0],
        [200, 255, 0],
        [0, 200, 120],
        [0, 220, 255],
        [60, 120, 255],
        [255, 60, 120],
        [170, 110, 255],
        [255, 255, 255],
        [150, 150, 150],
        [200, 0, 0],
    ];
    let [r, g, b] = COLORS[class as usize];
    [r, g, b, 255]
}

fn image(out: &mut String, what: &str, width: u32, rgba: &[u8], on_page: i64) {
    let png = png_base64(width, rgba);
    let _ = write!(
        out,
        "<figure><img alt=\"{what}\" width=\"{on_page}\" src=\"data:image/png;base64,{png}\"/><figcaption>{what}\
         </figcaption></figure>"
    );
}

/// Returns the beginning of a page of differences, up to its title as a heading.
pub fn page_head(title: &str) -> String {
    let title = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\n<style>\
         body{{font:16px sans-serif;margin:2em;background:#222;color:#ddd}}a{{color:#9cf}}\
         img{{image-rendering:pixelated;border:1px solid #666}}figure{{display:inline-block;margin:0 1em 1em 0}}\
         i{{display:inline-block;width:1em;height:1em;margin-right:.5em}}</style>\n<h1>{title}</h1>\n"
    )
}

impl WrongPixels {
    /// Returns the page; `names` are those of the drawn and the exact picture.
    pub fn page(&self, names: [&str; 2]) -> String {
        page_head(&format!("{} and {}", names[0], names[1])) + &self.section(names) + "</html>\n"
    }

    /// Returns the part of a page below its heading.
    pub fn section(&self, names: [&str; 2]) -> String {
        let [mine, exact] = names.map(escape);
        let mut out = String::new();
        let text = self.to_string();
        let first = text.lines().next().unwrap_or("");
        let _ = writeln!(out, "<p>{}</p>", escape(first));
        if self.size != self.exact_size || self.size[0] == 0 {
            return out;
        }
        let width = self.size[0];
        let on_page = i64::from(width) * (900 / i64::from(width)).clamp(1, 8);
        image(&mut out, &mine, width, &self.mine, on_page);
        image(&mut out, &exact, width, &self.exact, on_page);
        image(&mut out, "wrong pixels by class", width, &self.map(), on_page);
        for finding in &self.findings {
            self.finding(&mut out, finding);
        }
        out
    }

    /// Returns the exact picture, darkened, with the wrong pixels in the colours of their classes.
    fn map(&self) -> Vec<u8> {
        let exact = self.exact.as_chunks::<4>().0.iter();
        exact
            .zip(&self.classes)
            .flat_map(|([r, g, b, _], class)| class.map_or([r / 5, g / 5, b / 5, 255], color))
            .collect()
    }

    fn finding(&self, out: &mut String, finding: &Finding) {
        let [r, g, b, _] = color(finding.class);
        let _ = writeln!(
            out,
            "<h2><i style=\"background:rgb({r},{g},{b})\"></i>{} ({})</h2>\n<p>{}</p>",
            finding.pixels,
            finding.class.name(),
            escape(&finding.text)
        );
        for &[x, y] in &finding.examples {
            let side = 2 * AROUND + 1;
            for (what, rgba) in [("mine", &self.mine), ("exact", &self.exact)] {
                let what = format!("{what}, ({x}, {y}) in the middle");
                image(out, &what, side as u32, &self.part(rgba, [x, y]), side * MAGNIFIED);
            }
        }
    }

    /// Returns the pixels around a place; those outside are grey.
    fn part(&self, rgba: &[u8], [x, y]: [u32; 2]) -> Vec<u8> {
        let [w, h] = self.size.map(i64::from);
        let rows = -AROUND..=AROUND;
        let places =
            rows.flat_map(|dy| (-AROUND..=AROUND).map(move |dx| (i64::from(x) + dx, i64::from(y) + dy)));
        places
            .flat_map(|(x, y)| match (0..w).contains(&x) && (0..h).contains(&y) {
                true => rgba.as_chunks::<4>().0[(y * w + x) as usize],
                false => [90, 90, 90, 255],
            })
            .collect()
    }
}
