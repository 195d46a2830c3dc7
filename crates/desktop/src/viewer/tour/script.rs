//! The tour's steps, as text: each is a stream of commands with a title and a caption.
//!
//! In: `steps.fbs`. A line that begins with `#= ` starts a step and is its title; `#: `
//! is a line of its caption, `#size WxH` the frame's size (640x480 otherwise), `#hold N` the frames
//! of the tour for which each frame of the step is shown (1 otherwise), and `#each N` stands before
//! lines that are repeated N times, with a `PRESENT` after each. `#short TEXT` is shown in place of
//! all commands that follow in the step. Everything else is the stream itself, payloads included. Out: [`Step`]s.
//!
//! Verified by: tests of a small script, and of the real one, of which every step must play without
//! an error and change the picture.

/// Frames per second that the numbers of a script are meant for.
pub const FRAMES_PER_SECOND: f64 = 50.0;
/// Size of the picture area in pixels, and of a step's frame unless the step chooses its own.
pub const PICTURE: [u32; 2] = [640, 480];
/// Frames for which the last picture of a still step stays, so that it can be read.
const STAY: u64 = 150;
/// Frames for which the last picture of an animation stays; its text was there from the beginning.
const STAY_AFTER_MOTION: u64 = 50;

/// A step of the tour.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    pub title: String,
    /// One or two lines that explain the step.
    pub caption: Vec<String>,
    /// Size of the step's frame in pixels; [`PICTURE`] is a multiple of it.
    pub size: [u32; 2],
    /// The commands as they are played.
    pub stream: Vec<u8>,
    /// The commands as they are shown and can be typed: a payload that is no text stands as `< FILE`.
    pub lines: Vec<String>,
    /// Number of frames that the stream presents, at least 1.
    presents: u64,
    /// Frames of the tour for which each of them is shown.
    hold: u64,
}

impl Step {
    /// Returns the number of the tour's frames that the step takes.
    pub fn frames(&self) -> u64 {
        self.motion() + if self.presents > 1 { STAY_AFTER_MOTION } else { STAY }
    }

    /// Returns the number of the tour's frames for which each presented frame is shown.
    pub fn hold(&self) -> u64 {
        self.hold
    }

    /// Returns the number of frames before the last picture stays.
    pub fn motion(&self) -> u64 {
        self.presents * self.hold
    }

    /// Returns the number of presented frames of the stream that belong to frame `frame` of the
    /// step, counted from 0.
    pub fn presents_at(&self, frame: u64) -> u64 {
        (frame / self.hold).min(self.presents - 1) + 1
    }
}

/// Parses a script.
///
/// # Errors
/// Returns the number of the line that is no step's, or whose directive is invalid.
pub fn parse(script: &[u8]) -> Result<Vec<Step>, String> {
    let mut steps: Vec<Builder> = Vec::new();
    let (mut rest, mut number) = (script, 0);
    while !rest.is_empty() {
        number += 1;
        let line = take_line(&mut rest);
        let text = String::from_utf8_lossy(line).trim_end().to_owned();
        if let Some(title) = text.strip_prefix("#= ") {
            steps.push(Builder::new(title));
            continue;
        }
        let Some(step) = steps.last_mut() else {
            return Err(format!("line {number}: a step begins with `#= TITLE`, got {text:?}"));
        };
        let known = match text.strip_prefix('#') {
            Some(directive) => step.directive(directive),
            None => step.command(&text, line, &mut rest),
        };
        known.ok_or_else(|| format!("line {number}: no such directive or payload: {text:?}"))?;
    }
    Ok(steps.into_iter().map(Builder::step).collect())
}

/// Removes the first line, with its end, from `rest`, and returns it.
fn take_line<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let length = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |i| i + 1);
    let (line, after) = rest.split_at(length);
    *rest = after;
    line
}

/// A step that is being read.
struct Builder {
    step: Step,
    /// Number of repetitions, and the position in the stream of the lines that are repeated.
    repeated: Option<(u64, usize)>,
    /// Number of shown lines that stay, and those that stand for the others.
    short: Option<(usize, Vec<String>)>,
}

impl Builder {
    fn new(title: &str) -> Self {
        let step = Step {
            title: title.to_owned(),
            caption: Vec::new(),
            size: PICTURE,
            stream: Vec::new(),
            lines: Vec::new(),
            presents: 0,
            hold: 1,
        };
        Builder { step, repeated: None, short: None }
    }

    /// Reads a line that begins with `#`. Returns `None` if it is invalid.
    fn directive(&mut self, text: &str) -> Option<()> {
        let (word, value) = text.split_once(' ')?;
        let number = || value.parse::<u64>().ok().filter(|&n| n > 0);
        match word {
            ":" => self.step.caption.push(value.to_owned()),
            "short" => {
                let stays = self.step.lines.len();
                self.short.get_or_insert_with(|| (stays, Vec::new())).1.push(value.to_owned());
            }
            "hold" => self.step.hold = number()?,
            "size" => {
                let (width, height) = value.split_once('x')?;
                let size = [width.parse().ok()?, height.parse().ok()?];
                let fits = |i: usize| size[i] > 0 && PICTURE[i].is_multiple_of(size[i]);
                self.step.size = (fits(0) && fits(1)).then_some(size)?;
            }
            "each" => {
                self.repeated = Some((number()?, self.step.stream.len()));
                self.step.lines.push(format!("# then {value} times:"));
            }
            _ => return None,
        }
        Some(())
    }

    /// Reads a command, and its payload from `rest`. Returns `None` if the payload is cut.
    fn command(&mut self, text: &str, line: &[u8], rest: &mut &[u8]) -> Option<()> {
        if text.is_empty() {
            return Some(());
        }
        self.step.stream.extend_from_slice(line);
        self.step.presents += u64::from(text == "PRESENT");
        let counted = text.rsplit_once(" :").and_then(|(head, n)| Some((head, n.parse::<usize>().ok()?)));
        let Some((head, length)) = counted else {
            self.step.lines.push(text.to_owned());
            return Some(());
        };
        let (payload, after) = rest.split_at_checked(length)?;
        *rest = after;
        self.step.stream.extend_from_slice(payload);
        if text.starts_with("TEXT ") {
            self.step.lines.extend([text.to_owned(), String::from_utf8_lossy(payload).into_owned()]);
        } else {
            let ending = match head.split(' ').next() {
                Some("MESH") => "obj",
                Some("EYE") => "json",
                _ => "png",
            };
            let name = head.split(' ').nth(1).unwrap_or("file");
            self.step.lines.push(format!("{head} < {name}.{ending}"));
        }
        Some(())
    }

    /// Returns the finished step: repeated lines are written out.
    fn step(self) -> Step {
        let mut step = self.step;
        if let Some((times, from)) = self.repeated {
            let body = step.stream.split_off(from);
            for _ in 0..times {
                step.stream.extend_from_slice(&body);
                step.stream.extend_from_slice(b"PRESENT\n");
            }
            step.lines.push("PRESENT".to_owned());
            step.presents = times;
        }
        if let Some((stays, short)) = self.short {
            step.lines.truncate(stays);
            step.lines.extend(short);
        }
        step.presents = step.presents.max(1);
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_is_streams_with_titles() {
        let script = b"#= One\n#: first\n#: second\n#size 40x30\nPX 1 2 red\nTEXT 0 0 red :3\na\nb\n\
            #= Two\n#hold 4\nTEX t :2\n\0\xff\n#each 3\nDRAW t\n";
        let steps = parse(script).expect("a script");
        assert_eq!(steps.len(), 2);
        assert_eq!(
            (steps[0].title.as_str(), steps[0].caption.as_slice()),
            ("One", &["first".into(), "second".into()][..])
        );
        assert_eq!(steps[0].size, [40, 30]);
        assert_eq!(steps[0].stream, b"PX 1 2 red\nTEXT 0 0 red :3\na\nb");
        assert_eq!(steps[0].lines, ["PX 1 2 red", "TEXT 0 0 red :3", "a\nb"]);
        assert_eq!((steps[0].motion(), steps[0].presents_at(1_000)), (1, 1));
        assert_eq!(steps[1].stream, b"TEX t :2\n\0\xffDRAW t\nPRESENT\nDRAW t\nPRESENT\nDRAW t\nPRESENT\n");
        assert_eq!(steps[1].lines, ["TEX t < t.png", "# then 3 times:", "DRAW t", "PRESENT"]);
        assert_eq!(steps[1].motion(), 12);
        let presents = [0, 3, 4, 11, 12, 500].map(|frame| steps[1].presents_at(frame));
        assert_eq!(presents, [1, 1, 2, 3, 3, 3]);
    }

    #[test]
    fn short_lines_stand_for_the_commands_behind_them() {
        let script = b"#= One\nCLEAR red\n#short # a line for each edge\n#short # and so on\nLINE 0 0 1 1 red\nPX 1 1 red\n";
        let step = parse(script).expect("a script").remove(0);
        assert_eq!(step.lines, ["CLEAR red", "# a line for each edge", "# and so on"]);
        assert_eq!(step.stream, b"CLEAR red\nLINE 0 0 1 1 red\nPX 1 1 red\n");
    }

    #[test]
    fn an_invalid_line_is_named() {
        for (script, line) in [
            ("PX 0 0 red\n", "line 1"),
            ("#= a\n#size 7x5\n", "line 2"),
            ("#= a\n#each 0\n", "line 2"),
            ("#= a\nPX 0 0 red\n#dance 3\n", "line 3"),
            ("#= a\nTEXT 0 0 red :9\nabc", "line 2"),
        ] {
            let error = parse(script.as_bytes()).expect_err(script);
            assert!(error.starts_with(line), "{script:?}: {error}");
        }
    }
}
