//! Help texts: examples under every `--help`, the man pages and the shells' completions, all
//! generated from the description of the arguments that also parses them.

use super::view::keys_help;
use super::{Cli, Status, output, say_as_program};
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Examples at the end of a subcommand's `--help`; a test parses each line.
const EXAMPLES: &[(&str, &str)] = &[
    (
        "tour",
        "  fbptr tour
  fbptr tour --headless --movie tour.apng --snap last.png
  fbptr tour --headless --movie - | ffmpeg -i - tour.mp4",
    ),
    (
        "play",
        "  fbptr play demos/tour.fbs
  fbptr play demos/tour.fbs --headless --snap tour.png
  fbptr play demos/tour.fbs --headless --movie tour.apng --movie-fps 10
  fbptr play demos/tour.fbs --headless --expect tour.png
  printf 'CLEAR navy\\nLINE 0 0 99 49 gold\\n' | fbptr play - --size 100x50",
    ),
    (
        "draw",
        "  fbptr draw
  fbptr draw picture.fbs --size 320x200
  printf 'CIRCLE 32 24 20 gold\\nsnap a.png\\n' | fbptr draw --headless --size 64x48",
    ),
    (
        "serve",
        "  fbptr serve --size 640x480
  fbptr serve --listen :1234 --listen :1235 --unix /tmp/fb.sock --headless
  fbptr serve --shm /dev/shm/fb --snap-dir pictures --record session.fbs
  fbptr serve --headless --movie - | ffmpeg -i - session.mp4",
    ),
    (
        "run",
        "  fbptr run --size 800x600 -- ./my-gui --fullscreen
  fbptr run --headless --after 2s --expect start.png -- ./my-gui
  fbptr run --headless --format rgb565 --snap out.png -- ./my-gui
  fbptr run --movie demo.gif -- links2 -g -driver fb page.html
  fbptr run --size 640x200 --crt -- python3 demos/fb/text_mode.py
  fbptr run --headless --crt=files --snap tube.png -- ./my-gui",
    ),
    (
        "mygl",
        "  fbptr mygl student
  fbptr mygl student --headless --after still --snap out.png -- model.obj",
    ),
    (
        "grade",
        "  fbptr grade --list
  fbptr grade T1 --show
  fbptr grade T1 --page result.html -- student
  fbptr grade T1 -- python3 main.py {memory}
  fbptr grade homework.sheet --json -- ./student",
    ),
    (
        "config",
        "  g++ main.cpp $(fbptr config --cflags --libs) && fbptr run -- ./a.out
  eval \"$(fbptr config --env)\" && make && fbptr run -- ./student",
    ),
    (
        "render",
        "  fbptr render scene.x3d -o scene.png --size 1280x720 --explain
  fbptr render model.obj -o model.png --shade gouraud --depth-out model.pfm
  fbptr render scene.x3d -o turn.gif --frames 50 --fps 25
  fbptr render scene.x3d -o - --frames 250 | ffmpeg -i - turn.mp4
  fbptr render scene.x3d -o frames/turn.png --frames 1000 --shard 0/4
  fbptr render t.json -o turn.gif --frames 100 --turn 0,3,360 --turn 1,2,180
  fbptr render scene.x3d --size 12x10 --trace 5,4
  fbptr render scene.x3d --size 640x480 --expect mine.png",
    ),
    (
        "playground",
        "  fbptr playground
  fbptr playground --port 8000 --open",
    ),
    (
        "batch",
        "  fbptr batch check frames
  fbptr batch check frames --merge
  fbptr batch movie frames -o turn.gif
  fbptr batch movie frames -o - | ffmpeg -i - turn.mp4",
    ),
    (
        "compare",
        "  fbptr compare mine.png exact.png
  fbptr compare mine.png lines.fbs --page wrong.html
  fbptr compare mine.ppm scene.x3d --tolerance 1 --json",
    ),
    (
        "view",
        "  fbptr view model.obj
  fbptr view scene.x3d --time 1.5 --fps 30
  fbptr eye --make tesseract > t.json && fbptr view t.json
  fbptr view scene.x3d --headless --frames 50 --movie turn.gif
  fbptr view scene.x3d --headless --frames 250 --movie - | ffmpeg -i - turn.mp4",
    ),
    (
        "snap",
        "  fbptr snap 127.0.0.1:1234 picture.png
  fbptr snap /tmp/fb.sock picture.ppm",
    ),
    (
        "send",
        "  fbptr send :1234 demos/ball.fbs
  printf 'FILLCIRCLE 99 99 50 tomato\\n' | fbptr send :1234",
    ),
    (
        "bench",
        "  fbptr bench W1 W5 --threads 2
  fbptr bench W4_tex_nearest --simd portable --frames 10
  fbptr bench W6 --size 320x240 --frames 5
  fbptr bench scenes --threads 2
  fbptr bench --json",
    ),
    (
        "report",
        "  fbptr report --scene model.obj --out report
  fbptr report --scene model.obj --size 1280x720 --max-error 8
  fbptr report --quick
  fbptr report --out report
  fbptr report --hard",
    ),
    (
        "man",
        "  fbptr man | man -l -
  fbptr man --out man",
    ),
    (
        "completions",
        "  fbptr completions bash > /etc/bash_completion.d/fbptr
  fbptr completions fish > ~/.config/fish/completions/fbptr.fish",
    ),
];

/// Examples at the end of the program's own `--help`.
const EXAMPLES_OF_ALL: &str = "Examples:
  fbptr                                     the tour: what this is, step by step
  fbptr play demos/tour.fbs                 a stream of commands, in a window
  fbptr serve                               a video memory that other programs draw into
  fbptr render model.obj -o model.png       a file as a picture
  fbptr view model.obj                      the same from everywhere, in a window";

const EXIT_STATUS: &str = "  0    all went well
  1    a command or a file failed
  2    the arguments are no use, or name files that are not there
  130  `play` was ended by a signal; `serve` ends with 0, as it is meant to end so
  `run` ends with the status of the program that it runs, 128 + n if signal n ended it";

#[cfg(feature = "wayland")]
const ENVIRONMENT: &str = "  NO_COLOR                  no colours on the terminal, if it is set and not empty
  DISPLAY, WAYLAND_DISPLAY  where the window opens; without them nothing is shown";
#[cfg(not(feature = "wayland"))]
const ENVIRONMENT: &str = "  NO_COLOR  no colours on the terminal, if it is set and not empty
  DISPLAY   where the window opens; without it nothing is shown";

/// Returns the description of the arguments, with examples.
pub(super) fn command() -> Command {
    let foot = format!("{EXAMPLES_OF_ALL}\n\nExit status:\n{EXIT_STATUS}\n\nEnvironment:\n{ENVIRONMENT}");
    // A number below zero is a value, which its option refuses or takes, and no option.
    let all = Cli::command().after_help(foot).mut_subcommands(|c| c.allow_negative_numbers(true));
    EXAMPLES.iter().fold(all, |command, (name, examples)| {
        let keys = if *name == "view" { format!("\n\n{}", keys_help()) } else { String::new() };
        command.mut_subcommand(*name, |c| c.after_help(format!("Examples:\n{examples}{keys}")))
    })
}

/// Print the manual as a man page, or write one page a subcommand.
#[derive(Debug, Args)]
pub struct Man {
    /// The folder to write fbptr.1, fbptr-play.1 and so on into; without one fbptr.1 goes to standard output
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Man {
    /// Writes the pages, and returns the exit status.
    pub(super) fn run(self) -> Status {
        let mut command = command().disable_help_subcommand(true);
        command.build();
        match self.out {
            None => ended("the page", page(&command).map(output::print)),
            Some(folder) => ended(&folder.display().to_string(), write_pages(&command, &folder)),
        }
    }
}

/// Writes a man page for the program and each subcommand into `folder`.
fn write_pages(command: &Command, folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for command in command.get_subcommands().chain([command]) {
        let name = clap_mangen::Man::new(command.clone()).get_filename();
        let page = page(command)?;
        crate::save::replace(&folder.join(name), |out| out.write_all(&page)).map_err(io::Error::other)?;
    }
    Ok(())
}

/// Renders a man page: clap's sections, and those at the end of `--help` under the usual headings.
fn page(command: &Command) -> io::Result<Vec<u8>> {
    let man = clap_mangen::Man::new(command.clone());
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    let foot = command.get_after_help().map(|foot| foot.to_string()).unwrap_or_default();
    let common = [("Exit status", EXIT_STATUS), ("Environment", ENVIRONMENT)];
    let own = foot.split("\n\n").filter_map(|part| part.split_once(":\n"));
    let own = own.filter(|(heading, _)| common.iter().all(|c| c.0 != *heading));
    for (heading, lines) in own.chain(common) {
        // Verbatim: not filled, and no line interpreted as a request.
        writeln!(page, ".SH {}\n.nf", heading.to_uppercase())?;
        for line in lines.lines() {
            writeln!(page, "\\&{}", line.replace('\\', "\\e").replace('-', "\\-").replace('\'', "\\(aq"))?;
        }
        writeln!(page, ".fi")?;
    }
    Ok(page)
}

/// Print the completions of a shell.
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    /// Prints the completions, and returns the exit status.
    pub(super) fn run(self) -> Status {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut command(), "fbptr", &mut text);
        output::print(text);
        Status::Success
    }
}

fn ended(place: &str, outcome: io::Result<()>) -> Status {
    match outcome {
        Ok(()) => Status::Success,
        Err(e) => {
            say_as_program(format_args!("{place}: {e}"));
            Status::Failed
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_description_is_sound() {
        command().debug_assert();
    }

    #[test]
    fn every_subcommand_has_examples_and_every_example_is_taken() {
        let command = command();
        let mut count = 0;
        for sub in command.get_subcommands().filter(|s| s.get_name() != "help") {
            let help = sub
                .get_after_help()
                .unwrap_or_else(|| panic!("{} has no examples", sub.get_name()))
                .to_string();
            let lines: Vec<&str> = help.lines().filter(|l| l.contains("fbptr ")).collect();
            assert!(!lines.is_empty(), "{}: {help}", sub.get_name());
            for line in lines {
                // Arguments of other programs, pipes and files are not parsed.
                for ours in line.split('|').map(str::trim).filter(|part| part.starts_with("fbptr ")) {
                    let words = ours.split('>').next().unwrap_or(ours).split_whitespace();
                    let parsed = command.clone().try_get_matches_from(words);
                    assert!(parsed.is_ok(), "{ours}: {}", parsed.unwrap_err());
                    count += 1;
                }
            }
        }
        assert!(count > 15, "{count} examples");
    }

    /// The unit file that starts a server outside of a shell, and the page about it.
    const UNIT: &str = include_str!("../../docs/deploy/fbptr.service");
    const DOCKERFILE: &str = include_str!("../../Dockerfile");
    const WALL: &str = include_str!("../../docs/run-a-wall.md");

    fn assert_taken(words: &[String]) {
        let parsed = command().try_get_matches_from(words);
        assert!(parsed.is_ok(), "{words:?}: {}", parsed.unwrap_err());
    }

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn the_service_and_the_container_start_with_flags_that_there_are() {
        let whole = UNIT.replace("\\\n", " ");
        let lines: Vec<&str> = whole.lines().filter_map(|line| line.strip_prefix("ExecStart=")).collect();
        assert_eq!(lines.len(), 1);
        assert!(lines[0].starts_with("/usr/local/bin/fbptr serve --headless "), "{}", lines[0]);
        assert_taken(&words(lines[0]));
        let list = |key: &str| -> Vec<String> {
            let json: Vec<&str> = DOCKERFILE.lines().filter_map(|line| line.strip_prefix(key)).collect();
            assert_eq!(json.len(), 1, "{key}");
            serde_json::from_str(json[0]).expect("a list of words")
        };
        let program = list("ENTRYPOINT ");
        assert_eq!(program, ["/usr/local/bin/fbptr"]);
        assert_taken(&[program, list("CMD ")].concat());
    }

    #[test]
    fn the_page_about_walls_shows_commands_that_there_are() {
        let mut count = 0;
        for part in WALL.replace("\\\n", " ").lines().flat_map(|line| line.split('|')) {
            let line = part.split('#').next().unwrap_or("").trim().trim_matches('`').replace(" ...", "");
            if line.starts_with("fbptr ") {
                assert_taken(&words(&line));
                count += 1;
            }
        }
        assert!(count >= 5, "{count} commands");
        let flags = words(WALL).into_iter().filter(|word| word.starts_with("`--"));
        let command = command();
        let serve = command.find_subcommand("serve").expect("there is serve");
        for flag in flags {
            let name: String =
                flag[3..].chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '-').collect();
            let is_known = serve.get_arguments().any(|argument| argument.get_long() == Some(&name));
            assert!(is_known || ["network", "no-default-features"].contains(&&*name), "--{name}");
        }
        assert!(WALL.lines().count() <= 120);
    }

    #[test]
    fn manual_and_completions_name_every_subcommand() {
        let page = String::from_utf8(page(&command()).expect("to memory")).expect("UTF-8");
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut command(), "fbptr", &mut text);
            let text = String::from_utf8(text).expect("UTF-8");
            for sub in command().get_subcommands() {
                assert!(text.contains(sub.get_name()), "{shell}: {}", sub.get_name());
                assert!(page.contains(&format!("fbptr\\-{}", sub.get_name())), "{}", sub.get_name());
            }
        }
    }
}
