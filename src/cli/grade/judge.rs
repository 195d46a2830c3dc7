//! The points of an item: what a program has made beside what is right.
//!
//! Points are whole if no more pixels are wrong than the sheet allows, and none otherwise, unless it
//! has points for partly right pictures: then they are those of the right share of what is drawn.
//! Drawn is a pixel that differs from the exact picture's background, the commonest colour, in
//! either picture: so an empty picture has no share, whatever its size.
//!
//! A sheet may say that several pictures are right: by other options, or with several samples a
//! pixel. Then a program's is compared with the one that it resembles most.

use super::super::compare::{Exact, Reading};
use super::super::mesh_args::MeshArgs;
use super::super::render_args::RenderArgs;
use super::calls::{Called, at_centres, in_white, plain};
use super::program::{Made, Program, Ran};
use super::sheet::{Item, Wanted, base64};
use crate::measure::difference::WrongPixels;
use crate::measure::pixels;
use crate::memory::VideoMemory;
use clap::Parser;
use std::fs;
use std::path::{Path, PathBuf};

/// Options of an item's exact picture.
#[derive(Debug, Parser)]
#[command(name = "options", no_binary_name = true)]
struct Options {
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

/// An item that was graded.
pub struct Graded<'a> {
    pub item: &'a Item,
    pub points: f64,
    /// The reason of the points.
    pub text: String,
    /// The program's text on standard error.
    pub said: Vec<String>,
    pub difference: Option<WrongPixels>,
}

impl<'a> Graded<'a> {
    /// Returns an item without points.
    pub fn lost(item: &'a Item, text: String) -> Graded<'a> {
        Graded { item, points: 0.0, text, said: Vec::new(), difference: None }
    }
}

/// Right answer of an item.
pub struct Right {
    exact: Option<Exact>,
    /// Words that tell the exact picture from the sheet's, if it is another one.
    name: String,
    /// Pictures that are right as well, each with the words that tell it from the exact one.
    others: Vec<(String, Exact)>,
    /// The exact picture's file.
    file: Option<PathBuf>,
}

impl Right {
    /// Reads or draws what is right, before a program is run. `beside` is the sheet's folder, and
    /// `folder` the item's, where its files are written.
    ///
    /// # Errors
    /// Reason why the sheet is refused.
    pub fn read(item: &Item, beside: &Path, folder: &Path) -> Result<Right, String> {
        for (name, text) in &item.files {
            // A picture is written in base64.
            let picture = if name.ends_with(".png") { base64(text) } else { None };
            let bytes = picture.unwrap_or_else(|| text.clone().into_bytes());
            fs::write(folder.join(name), bytes).map_err(|e| format!("{name}: {e}"))?;
        }
        let file = match &item.exact {
            Wanted::Missing | Wanted::Numbers(_) => None,
            Wanted::Text(text) => {
                let name = if text.trim_start().starts_with('<') { "exact.x3d" } else { "exact.fbs" };
                let path = folder.join(name);
                fs::write(&path, text).map_err(|e| format!("exact: {e}"))?;
                Some(path)
            }
            Wanted::File(name) => match item.files.iter().any(|(other, _)| other == name) {
                true => Some(folder.join(name)),
                false => Some(beside.join(name)),
            },
        };
        let mut right = Right { exact: None, name: String::new(), others: Vec::new(), file };
        if let Some(file) = &right.file {
            right.exact = Some(draw(item, &item.options, file)?);
            right.others = others(item, file, folder)?;
        }
        if let Some(exact) = &right.exact {
            let (w, h) = (exact.memory.width(), exact.memory.height());
            if (w, h) != item.size.into() {
                return Err(format!("exact: it has {w}x{h} pixels, and the item {}", item.size));
            }
            if pixels::is_all(&exact.memory, pixels::commonest(&exact.memory)) {
                return Err("exact: nothing is drawn in it".to_owned());
            }
            if let Some([x, y, rw, rh]) = item.region
                && (u64::from(x) + u64::from(rw) > w.into() || u64::from(y) + u64::from(rh) > h.into())
            {
                return Err(format!("region: it is not inside of {w}x{h} pixels"));
            }
        }
        Ok(right)
    }

    /// Runs a program for an item and gives it its points.
    pub fn grade<'a>(&self, item: &'a Item, program: &Program, folder: &Path) -> Graded<'a> {
        let lost = |text: String| Graded::lost(item, text);
        let own = match program.called.as_ref().map(|called| self.as_called(item, called, folder)) {
            Some(Err(text)) => return lost(text),
            Some(Ok(own)) => own,
            None => None,
        };
        let Ran { made, said } = program.run(item, folder, self.file.as_deref());
        let graded = match made {
            Err(text) => lost(text),
            Ok(Made::Numbers(found)) => match &item.exact {
                Wanted::Numbers(wanted) => numbers(item, wanted, &found),
                _ => lost(String::new()),
            },
            Ok(Made::Picture(mine)) => match &own {
                Some((right, true)) => right.picture(item, pixels::black_and_white(*mine)),
                Some((right, false)) => right.picture(item, *mine),
                None => self.picture(item, *mine),
            },
            Ok(Made::Stream(path)) => match draw(item, &item.options, &path) {
                Ok(mine) => self.picture(item, mine.memory),
                Err(e) => {
                    let e = e.replace(&path.display().to_string(), "the program's output");
                    lost(format!("no stream of commands: {e}"))
                }
            },
        };
        Graded { said, ..graded }
    }

    /// Returns what is right for functions that take whole coordinates, or no colour: then `true`,
    /// as they are graded by what is lit. `None` if the sheet's picture is right.
    fn as_called(
        &self,
        item: &Item,
        called: &Called,
        folder: &Path,
    ) -> Result<Option<(Right, bool)>, String> {
        let Wanted::Text(stream) = &item.exact else {
            return Err("the program's functions are called, which draw streams alone".to_owned());
        };
        let plain = plain(stream);
        if let Some(text) = called.missing(&plain) {
            return Err(text);
        }
        let whole = called.in_whole(&plain);
        let colorless = called.colorless(&plain);
        if whole.is_none() && colorless.is_none() {
            return Ok(None);
        }
        let is_whole = whole.is_some();
        let mut stream = whole.unwrap_or(plain);
        if let Some(function) = colorless {
            stream = in_white(&stream).ok_or_else(|| format!("{function} takes no colour"))?;
        }
        let drawn = |name: &str, text: &str| {
            let file = folder.join(name);
            fs::write(&file, text).map_err(|e| format!("exact: {e}"))?;
            Ok::<_, String>((draw(item, &item.options, &file)?, file))
        };
        let (exact, file) = drawn("called.fbs", &stream)?;
        let mut right =
            Right { exact: Some(exact), name: String::new(), others: Vec::new(), file: Some(file) };
        if is_whole {
            right.name = "with rounded corners".to_owned();
            let name = "with rounded corners, at the centres of pixels".to_owned();
            right.others.push((name, drawn("centres.fbs", &at_centres(&stream))?.0));
        }
        Ok(Some((right, colorless.is_some())))
    }

    fn picture<'a>(&self, item: &'a Item, mut mine: VideoMemory) -> Graded<'a> {
        let Some(exact) = &self.exact else {
            return Graded::lost(item, String::new());
        };
        let size = |m: &VideoMemory| [m.width(), m.height()];
        if let (Some(region), true) = (item.region, size(&mine) == size(&exact.memory)) {
            pixels::take_outside(&mut mine, &exact.memory, region);
        }
        // The first of several that are as near.
        let pictures = std::iter::once((self.name.as_str(), exact))
            .chain(self.others.iter().map(|(n, e)| (n.as_str(), e)));
        let allowed = item.tolerance.per_channel;
        let nearest = pictures.min_by_key(|(_, exact)| pixels::count_wrong(&mine, &exact.memory, allowed));
        let (name, exact) = nearest.unwrap_or((&self.name, exact));
        let difference = exact.difference(&mine, allowed);
        let (points, text) = match difference.size == difference.exact_size {
            false => (0.0, difference.to_string().trim_end().to_owned()),
            true => points(item, &difference, &mine, &exact.memory),
        };
        let text = if name.is_empty() { text } else { format!("{name}: {text}") };
        Graded { item, points, text, said: Vec::new(), difference: Some(difference) }
    }
}

/// Draws a picture by options.
fn draw(item: &Item, options: &[String], path: &Path) -> Result<Exact, String> {
    draw_at(item, options, path, 1)
}

/// Draws a picture that is so many times as large as the item's.
fn draw_at(item: &Item, options: &[String], path: &Path, times: u32) -> Result<Exact, String> {
    let Options { meshes, drawing } = &Options::try_parse_from(options).map_err(|e| {
        let text = e.render().to_string();
        format!("options: {}", text.lines().next().unwrap_or("").trim_start_matches("error: "))
    })?;
    let size = Some([item.size.width * times, item.size.height * times]);
    Exact::read(path, Reading { size, time: 0.0, load_dir: None, meshes: Some(meshes), drawing })
}

/// Draws what is right beside the exact picture: by other options, and with several samples.
fn others(item: &Item, file: &Path, folder: &Path) -> Result<Vec<(String, Exact)>, String> {
    let mut others = Vec::new();
    for options in &item.or {
        let exact = draw(item, options, file).map_err(|e| format!("or: {e}"))?;
        others.push((format!("as by {}", options.join(" ")), exact));
    }
    if item.samples < 2 {
        return Ok(others);
    }
    let text = fs::read_to_string(file).map_err(|e| format!("samples: {e}"))?;
    if !text.trim_start().starts_with('<') {
        return Err("samples: an X3D scene is expected".to_owned());
    }
    let large = folder.join("large.x3d");
    fs::write(&large, enlarged(&text, item.samples)).map_err(|e| format!("samples: {e}"))?;
    let with = format!("with {0}x{0} samples a pixel", item.samples);
    for (at, options) in std::iter::once(&item.options).chain(&item.or).enumerate() {
        let scene = if is_in_pixels(&text, options) { &large } else { file };
        let exact = draw_at(item, options, scene, item.samples)?;
        let memory = pixels::mean(&exact.memory, item.samples).map_err(|e| e.to_string())?;
        let by = if at == 0 { String::new() } else { format!("as by {}, ", options.join(" ")) };
        others.push((by + &with, Exact::of_pixels(memory)));
    }
    Ok(others)
}

/// Returns whether a scene is drawn in pixels by some options.
fn is_in_pixels(text: &str, options: &[String]) -> bool {
    let reading = Options::try_parse_from(options).ok().and_then(|options| options.meshes.reading());
    let document = crate::load::x3d::parse(text.as_bytes(), "exact.x3d", &mut |_| None);
    let (Some(reading), Ok(mut document)) = (reading, document) else { return false };
    document.set_reading(reading);
    document.is_in_pixels()
}

/// Returns a scene in pixels for a larger picture: shapes are so many times as large. Comments and
/// texts may have what looks like its beginning or end.
fn enlarged(scene: &str, times: u32) -> String {
    let (mut out, mut rest) = (String::new(), scene);
    while let Some(at) = rest.find('<') {
        let (before, tag) = rest.split_at(at);
        out += before;
        let len = tag_len(tag);
        let (tag, behind) = tag.split_at(len);
        let name = tag[1..].split(|c: char| c.is_whitespace() || c == '>').next().unwrap_or("");
        match name {
            "Scene" => out += &format!("{tag}<Transform scale='{times} {times} 1'>"),
            "/Scene" => out += &format!("</Transform>{tag}"),
            _ => out += tag,
        }
        rest = behind;
    }
    out + rest
}

/// Returns the length of the tag, comment or section of text that begins here.
fn tag_len(tag: &str) -> usize {
    for (open, close) in [("<!--", "-->"), ("<![CDATA[", "]]>")] {
        if tag.starts_with(open) {
            return tag.find(close).map_or(tag.len(), |at| at + close.len());
        }
    }
    let mut quote = None;
    for (at, c) in tag.char_indices() {
        match (quote, c) {
            (None, '>') => return at + 1,
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if open == c => quote = None,
            _ => {}
        }
    }
    tag.len()
}

/// Returns the points of a picture of the right size, and the reason.
fn points(item: &Item, difference: &WrongPixels, mine: &VideoMemory, exact: &VideoMemory) -> (f64, String) {
    let wrong = difference.wrong;
    let text = difference.to_string().trim_end().to_owned();
    if wrong <= item.tolerance.pixels {
        let text = match wrong {
            0 => "right".to_owned(),
            n => format!("right: wrong pixels, as many as are allowed: {n}"),
        };
        return (item.points, text);
    }
    let background = pixels::commonest(exact);
    if pixels::is_all(mine, background) {
        return (0.0, format!("nothing is drawn: {}", text.lines().next().unwrap_or("")));
    }
    let drawn = pixels::count_drawn(mine, exact, background);
    let share = (1.0 - wrong as f64 / drawn.max(1) as f64).max(0.0);
    match item.partly {
        // Down to tenths of a point: a wrong pixel is seen in the points.
        Some(least) if share >= least => (
            (item.points * share * 10.0).floor() / 10.0,
            format!("{:.1} % right: {text}", floor_percent(share)),
        ),
        Some(least) => {
            (0.0, format!("{:.1} % right, {:.0} % are needed: {text}", floor_percent(share), least * 100.0))
        }
        None => (0.0, text),
    }
}

fn floor_percent(share: f64) -> f64 {
    (share * 1000.0).floor() / 10.0
}

/// Compares numbers in their order.
fn numbers<'a>(item: &'a Item, wanted: &[f64], found: &[f64]) -> Graded<'a> {
    let is_right = |(wanted, found): (&f64, &f64)| (wanted - found).abs() <= item.within;
    let right = wanted.iter().zip(found).filter(|(w, f)| is_right((*w, *f))).count();
    let (points, text) = match (found.len() == wanted.len(), right == wanted.len()) {
        (true, true) => (item.points, "right".to_owned()),
        (false, _) => (0.0, format!("{} numbers are expected, {} were printed", wanted.len(), found.len())),
        (true, false) => {
            let first = wanted.iter().zip(found).position(|(w, f)| !is_right((w, f))).unwrap_or(0);
            let text = format!(
                "{} of {} numbers are wrong; the first is number {}: {} is expected, {} was printed{}",
                wanted.len() - right,
                wanted.len(),
                first + 1,
                wanted[first],
                found[first],
                cause(item, wanted, found)
            );
            (0.0, text)
        }
    };
    Graded { item, points, text, said: Vec::new(), difference: None }
}

/// Returns a cause that all numbers have in common, where there is one.
fn cause(item: &Item, wanted: &[f64], found: &[f64]) -> &'static str {
    let all =
        |value: &dyn Fn(usize) -> f64| (0..wanted.len()).all(|i| (value(i) - found[i]).abs() <= item.within);
    if wanted.len() == 16 && all(&|i| wanted[i % 4 * 4 + i / 4]) {
        return "; it is the transposed matrix";
    }
    if all(&|i| -wanted[i]) {
        return "; all have the other sign";
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::super::sheet::Sheet;
    use super::*;

    #[test]
    fn a_scene_in_pixels_is_enlarged_where_it_begins_and_ends() {
        let scene = "<X3D><!-- <Scene> --><Scene DEF='a>b'>\n<Shape><Polyline2D/><Text string='\"</Scene> 2D \"'/>\
                     </Shape></Scene></X3D>";
        let large = enlarged(scene, 2);
        let expected = scene.replace("<Scene DEF='a>b'>", "<Scene DEF='a>b'><Transform scale='2 2 1'>");
        assert_eq!(large, expected.replace("</Shape></Scene>", "</Shape></Transform></Scene>"));
        assert_eq!(enlarged("<!-- <Scene>", 2), "<!-- <Scene>");
        let options = ["--dialect", "renderizador"].map(str::to_owned);
        let flat = scene.replace("<Text string='\"</Scene> 2D \"'/>", "");
        assert!(
            is_in_pixels(&flat, &options) && !is_in_pixels(&flat, &[]) && !is_in_pixels("<X3D", &options)
        );
        let both =
            "<X3D><Scene><Shape><Polyline2D/></Shape><Shape><Text string='\"2D \"'/></Shape></Scene></X3D>";
        assert!(!is_in_pixels(both, &options));
    }

    #[test]
    fn numbers_are_compared_in_their_order_and_a_transposed_matrix_is_named() {
        let sheet = Sheet::parse(
            "item: m\npoints: 2\nwithin: 0.01\nnumbers: 1 2 3 4  5 6 7 8  9 10 11 12  13 14 15 16\n",
        )
        .unwrap();
        let item = &sheet.items[0];
        let Wanted::Numbers(wanted) = &item.exact else { panic!() };
        let near: Vec<f64> = wanted.iter().map(|n| n + 0.009).collect();
        assert_eq!(numbers(item, wanted, &near).points, 2.0);
        let turned: Vec<f64> = (0..16).map(|i| wanted[i % 4 * 4 + i / 4]).collect();
        let graded = numbers(item, wanted, &turned);
        assert_eq!(graded.points, 0.0);
        assert!(graded.text.contains("12 of 16") && graded.text.contains("transposed"), "{}", graded.text);
        let mut broken = near;
        broken[4] = f64::NAN;
        assert!(numbers(item, wanted, &broken).text.contains("number 5: 5 is expected, NaN"));
        assert!(numbers(item, wanted, &[1.0]).text.contains("1 were printed"));
    }
}
