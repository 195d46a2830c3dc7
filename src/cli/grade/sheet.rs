//! Sheets: what an assignment asks for, in lines of text that a teacher writes and a student reads.
//!
//! In: text. Out: a [`Sheet`], or the line that is wrong and why. A line is empty, a comment (`#`),
//! a line for the student (`>`), or `key: value`; a key without a value has the indented lines that
//! follow as its value. Keys before the first `item` hold for all items. Right is: what is no key,
//! and a value that a key does not take, are refused with their line.

use super::super::FrameSize;
use super::super::bytes::ByteSize;
use super::super::expect::parse_tolerance;
use super::super::run::{After, time_of};
use crate::save::golden::Tolerance;
use std::time::Duration;

/// Largest number of items of a sheet.
const MAX_ITEMS: usize = 1000;

/// An assignment.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    pub title: String,
    /// Lines for the student.
    pub text: Vec<String>,
    pub items: Vec<Item>,
}

/// One task of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    pub name: String,
    /// The line of the sheet that it begins at.
    pub line: usize,
    pub text: Vec<String>,
    pub points: f64,
    pub by: By,
    pub size: FrameSize,
    /// Words after the program's own.
    pub arguments: Vec<String>,
    pub input: Input,
    /// Files that lie in the item's folder: names and contents.
    pub files: Vec<(String, String)>,
    pub exact: Wanted,
    /// Options of drawing, as `fbptr compare` takes them.
    pub options: Vec<String>,
    /// Other options by which the exact picture is right as well.
    pub or: Vec<Vec<String>>,
    /// Samples a side of a pixel, of which the mean is right as well as one sample.
    pub samples: u32,
    /// Left, upper, width, height of the part that is compared.
    pub region: Option<[u32; 4]>,
    pub tolerance: Tolerance,
    /// Difference that a number may have.
    pub within: f64,
    /// Share of the pixels from which on there are points for a partly right picture.
    pub partly: Option<f64>,
    pub after: String,
    /// Frames that the Python framework renders; the last one counts.
    pub frames: u32,
    pub time: Duration,
    pub memory: u64,
}

/// Ways in which a program gives its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum By {
    /// In the framebuffer device, or a memory that GLUT shows
    Run,
    /// As a stream of commands on standard output
    Stdout,
    /// In the shared file whose path stands for {memory}
    Memory,
    /// By the Python framework: the program is the student's folder
    Renderizador,
}

/// Standard input of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    Text(String),
    /// The stream of the exact picture itself.
    Exact,
}

/// Right answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// Nothing was given yet.
    Missing,
    /// A picture, stream, scene or mesh by its name.
    File(String),
    /// A stream, or an X3D scene.
    Text(String),
    /// Numbers that the program prints.
    Numbers(Vec<f64>),
}

/// A line that is no line of a sheet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetError {
    pub line: usize,
    pub message: String,
}

impl Item {
    fn new() -> Item {
        Item {
            name: String::new(),
            line: 0,
            text: Vec::new(),
            points: 1.0,
            by: By::Run,
            size: FrameSize::DEFAULT,
            arguments: Vec::new(),
            input: Input::Text(String::new()),
            files: Vec::new(),
            exact: Wanted::Missing,
            options: Vec::new(),
            or: Vec::new(),
            samples: 1,
            region: None,
            tolerance: Tolerance::EXACT,
            within: 0.001,
            partly: None,
            after: "still".to_owned(),
            frames: 1,
            time: Duration::from_secs(10),
            memory: 1 << 30,
        }
    }

    /// Sets what a line says.
    fn set(&mut self, key: &str, value: &str, is_block: bool) -> Result<(), String> {
        if let Some(name) = key.strip_prefix("file ") {
            return self.add_file(name.trim(), value);
        }
        if is_block && !matches!(key, "exact" | "input" | "numbers") {
            return Err(format!("{key}: a value is expected on the same line"));
        }
        match key {
            "points" => self.points = real(key, value, 0.0..=1e6)?,
            "by" => {
                self.by = <By as clap::ValueEnum>::from_str(value, false).map_err(|_| {
                    format!("by: run, stdout, memory or renderizador is expected, not {value:?}")
                })?
            }
            "size" => self.size = value.parse().map_err(|e| format!("size: {e}"))?,
            "arguments" => self.arguments = words(value),
            "options" => self.options = words(value),
            "or" => self.or.push(words(value)),
            "samples" => self.samples = whole(key, value, 1..=8)?,
            "input" if value == "exact" && !is_block => self.input = Input::Exact,
            "input" => self.input = Input::Text(value.to_owned()),
            "exact" if is_block => self.exact = Wanted::Text(value.to_owned()),
            "exact" => self.exact = Wanted::File(value.to_owned()),
            "numbers" => self.exact = Wanted::Numbers(numbers(value)?),
            "within" => self.within = real(key, value, 0.0..=f64::MAX)?,
            "region" => self.region = Some(region(value)?),
            "tolerance" => {
                self.tolerance = parse_tolerance(value).map_err(|e| e.replace("--tolerance", "tolerance"))?;
            }
            "partly" => {
                let number = value
                    .strip_suffix('%')
                    .ok_or_else(|| format!("partly: 90% is expected, not {value:?}"))?;
                self.partly = Some(real(key, number, 0.0..=100.0)? / 100.0);
            }
            "after" => {
                self.after = value
                    .parse::<After>()
                    .map(|_| value.to_owned())
                    .map_err(|e| e.replace("--after", key))?;
            }
            "frames" => self.frames = whole(key, value, 1..=1000)?,
            "time" => {
                self.time =
                    time_of(value).ok_or_else(|| format!("time: 10s or 500ms is expected, not {value:?}"))?;
            }
            "memory" => self.memory = value.parse::<ByteSize>().map_err(|e| format!("memory: {e}"))?.0,
            _ => return Err(format!("{key:?} is no key of a sheet")),
        }
        Ok(())
    }

    fn add_file(&mut self, name: &str, value: &str) -> Result<(), String> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(format!(
                "file: a name of letters, digits, points and lines is expected, not {name:?}"
            ));
        }
        if name.ends_with(".png") && base64(value).is_none() {
            return Err(format!("file {name}: a picture in base64 is expected"));
        }
        self.files.retain(|(other, _)| other != name);
        self.files.push((name.to_owned(), value.to_owned()));
        Ok(())
    }

    /// Checks an item whose lines are all read.
    fn check(&self) -> Result<(), String> {
        match &self.exact {
            Wanted::Missing => Err(format!("item {}: it has no exact picture and no numbers", self.name)),
            Wanted::File(_) | Wanted::Numbers(_) if self.input == Input::Exact => {
                Err(format!("item {}: input: exact needs a stream in the sheet", self.name))
            }
            _ => Ok(()),
        }
    }
}

impl Sheet {
    /// Reads a sheet.
    ///
    /// # Errors
    /// The first line that is wrong.
    pub fn parse(text: &str) -> Result<Sheet, SheetError> {
        let (mut title, mut lead) = (String::new(), Vec::new());
        let mut defaults = Item::new();
        let mut items: Vec<Item> = Vec::new();
        let mut lines = text.lines().enumerate().peekable();
        while let Some((at, line)) = lines.next() {
            let refuse = |message: String| SheetError { line: at + 1, message };
            let line = line.trim_end();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if let Some(said) = line.strip_prefix('>') {
                let list = items.last_mut().map_or(&mut lead, |item| &mut item.text);
                list.push(said.strip_prefix(' ').unwrap_or(said).to_owned());
                continue;
            }
            let expected =
                || refuse(format!("key: value is expected, or a line for the student after >, not {line:?}"));
            let (key, value) = line
                .split_once(':')
                .filter(|_| !line.starts_with(char::is_whitespace))
                .ok_or_else(expected)?;
            let (key, value) = (key.trim(), value.trim());
            let block = match value.is_empty() {
                true => Some(block(&mut lines)),
                false => None,
            };
            let value = block.as_deref().unwrap_or(value);
            match key {
                "title" => title = value.trim().to_owned(),
                "item" if items.len() == MAX_ITEMS => {
                    return Err(refuse(format!("more than {MAX_ITEMS} items")));
                }
                "item" => {
                    let name = value.trim().to_owned();
                    if name.is_empty() || items.iter().any(|item| item.name == name) {
                        return Err(refuse(format!(
                            "item: a name that no other item has is expected, not {name:?}"
                        )));
                    }
                    items.push(Item { name, line: at + 1, ..defaults.clone() });
                }
                _ => items
                    .last_mut()
                    .unwrap_or(&mut defaults)
                    .set(key, value, block.is_some())
                    .map_err(refuse)?,
            }
        }
        for item in &items {
            item.check().map_err(|message| SheetError { line: item.line, message })?;
        }
        match items.is_empty() {
            true => Err(SheetError {
                line: text.lines().count().max(1),
                message: "the sheet has no item".to_owned(),
            }),
            false => Ok(Sheet { title, text: lead, items }),
        }
    }
}

/// Takes the indented lines that follow, without the first one's indentation.
fn block<'a>(lines: &mut std::iter::Peekable<impl Iterator<Item = (usize, &'a str)>>) -> String {
    let (mut text, mut indent, mut empty) = (String::new(), None, 0);
    while let Some((_, line)) =
        lines.next_if(|(_, line)| line.starts_with([' ', '\t']) || line.trim().is_empty())
    {
        if line.trim().is_empty() {
            empty += 1;
            continue;
        }
        // Empty lines inside a block belong to it, those behind it do not.
        if !text.is_empty() {
            (0..empty).for_each(|_| text.push('\n'));
        }
        empty = 0;
        let own = line.len() - line.trim_start().len();
        let indent = *indent.get_or_insert(own);
        text += line.get(indent.min(own)..).unwrap_or("");
        text.push('\n');
    }
    text
}

/// Returns the bytes of a text in base64.
pub fn base64(text: &str) -> Option<Vec<u8>> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut bytes, mut bits, mut count) = (Vec::new(), 0_u32, 0);
    for byte in text.bytes().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'=') {
        let digit = DIGITS.iter().position(|other| *other == byte)? as u32;
        bits = (bits << 6 | digit) & 0xffff;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

fn words(value: &str) -> Vec<String> {
    value.split_whitespace().map(str::to_owned).collect()
}

fn real(key: &str, value: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let number = value.trim().parse().ok().filter(|n| range.contains(n));
    number.ok_or_else(|| {
        format!("{key}: a number from {} to {} is expected, not {value:?}", range.start(), range.end())
    })
}

fn whole(key: &str, value: &str, range: std::ops::RangeInclusive<u32>) -> Result<u32, String> {
    let number = value.trim().parse().ok().filter(|n| range.contains(n));
    number.ok_or_else(|| {
        let (first, last) = (range.start(), range.end());
        format!("{key}: a whole number from {first} to {last} is expected, not {value:?}")
    })
}

fn region(value: &str) -> Result<[u32; 4], String> {
    let numbers: Option<Vec<u32>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
    let region =
        numbers.and_then(|numbers| <[u32; 4]>::try_from(numbers).ok()).filter(|r| r[2] > 0 && r[3] > 0);
    region.ok_or_else(|| format!("region: left, upper, width and height are expected, not {value:?}"))
}

fn numbers(value: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| word.parse::<f64>().ok().filter(|n| n.is_finite());
    let all: Vec<f64> = value
        .split_whitespace()
        .map(|word| number(word).ok_or_else(|| format!("numbers: {word:?} is no number")))
        .collect::<Result<_, _>>()?;
    match all.is_empty() {
        true => Err("numbers: at least one is expected".to_owned()),
        false => Ok(all),
    }
}
