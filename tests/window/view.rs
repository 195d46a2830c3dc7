//! The viewer on a real X server: every key of the overlay's list, pressed once, changes the
//! picture, saves a file or ends the program; key presses during a slow frame are not lost; all of
//! it works after a resize.

use crate::folder::Folder;
use crate::screen::{Guard, Screen, wait_for};
use fbptr::eye::EyeScene;
use fbptr::viewer::{Action, BINDINGS, Key};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

const KNOT: &str = "MESH k KNOT 60 12\nLOOKAT 1 2 9 0 0 0 0 1 0\nLIGHT 0 DIR -1 -1 -2 1 1 1\nAMBIENT .2 .2 .2\nDRAW k\nPRESENT\n\
    ROTATE 0 1 0 .5\nCLEAR\nDRAW k\nPRESENT\nFILLRECT 5 5 90 40 ff8800\n";

const SPINNING: &str = r#"<?xml version="1.0"?><X3D version="3.3" profile="Interchange"><Scene>
<Viewpoint position="0 0 6"/><TimeSensor DEF="T" cycleInterval="8" loop="true"/>
<OrientationInterpolator DEF="O" key="0 .5 1" keyValue="0 1 0 .4 0 1 0 3.5 0 1 0 6.6"/>
<Transform DEF="X"><Shape><Appearance><Material diffuseColor="1 .5 .2" emissiveColor=".1 .1 .1"/></Appearance><Sphere/></Shape>
<Transform translation="1.2 0 1"><Shape><Appearance><Material diffuseColor=".2 .5 1" emissiveColor=".1 .1 .1"/></Appearance><Box size="1 1 1"/></Shape></Transform></Transform>
<ROUTE fromNode="T" fromField="fraction_changed" toNode="O" toField="set_fraction"/>
<ROUTE fromNode="O" fromField="value_changed" toNode="X" toField="set_rotation"/></Scene></X3D>"#;

/// Returns xdotool's name of a key.
fn keysym(key: Key) -> String {
    let name = match key {
        Key::Zero => "0",
        Key::One => "1",
        Key::Two => "2",
        Key::Three => "3",
        Key::Four => "4",
        Key::Five => "5",
        Key::Space => "space",
        Key::Period => "period",
        Key::Comma => "comma",
        Key::PageUp => "Prior",
        Key::PageDown => "Next",
        Key::Equal => "equal",
        Key::Minus => "minus",
        Key::LeftBracket => "bracketleft",
        Key::RightBracket => "bracketright",
        Key::Backspace => "BackSpace",
        other => {
            let name = format!("{other:?}");
            return if name.len() == 1 { name.to_lowercase() } else { name };
        }
    };
    name.to_owned()
}

/// Starts `fbptr view` on the screen; returns the process and its window.
fn view(screen: &Screen, folder: &Path, file: &str, size: &str) -> (Guard, String) {
    start(screen, folder, &["view", file, "--size", size])
}

/// Starts the program on the screen; returns the process and its window.
fn start(screen: &Screen, folder: &Path, arguments: &[&str]) -> (Guard, String) {
    let child = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(arguments)
        .current_dir(folder)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the viewer starts");
    let guard = Guard(child);
    let id = screen.window();
    // Keys go to the window under the pointer.
    let [x, y, w, h] = screen.place(&id);
    screen.xdotool(&["mousemove", &(x + w / 2).to_string(), &(y + h / 2).to_string()]);
    (guard, id)
}

/// Returns the pixels of a window.
fn shown(screen: &Screen, id: &str) -> Vec<[u8; 3]> {
    let [x, y, w, h] = screen.place(id);
    screen.pixels(x, y, w, h)
}

/// Returns the pixels of a window, once they stay the same for a while.
fn settled(screen: &Screen, id: &str) -> Vec<[u8; 3]> {
    let mut before = shown(screen, id);
    wait_for("a picture that stays", || {
        std::thread::sleep(Duration::from_millis(120));
        let now = shown(screen, id);
        let is_same = now == before;
        before = now;
        is_same.then(|| before.clone())
    })
}

fn files(folder: &Path) -> usize {
    let names = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name());
    names.filter(|n| n.to_string_lossy().starts_with("fbptr-")).count()
}

/// Presses every key once, on one file; `is_nd` selects the keys of the N-dimensional viewer.
fn press_every_key(screen: &Screen, folder: &Path, file: &str, is_nd: bool) {
    let (mut viewer, id) = view(screen, folder, file, "320x240");
    let lit = || shown(screen, &id).iter().filter(|p| **p != [0; 3]).count() > 1000;
    wait_for("the first picture", || lit().then_some(()));
    screen.xdotool(&["key", "space"]);
    let quits = |action| matches!(action, Action::Quit);
    for binding in BINDINGS.iter().filter(|b| !quits(b.action)) {
        let help = if is_nd { binding.help_nd } else { binding.help };
        if help.is_empty() {
            continue;
        }
        if binding.action == Action::Reset {
            // The keys before it undid their changes: there must be a change to reset.
            screen.xdotool(&["key", "w"]);
        }
        let place = screen.place(&id);
        if binding.action == Action::Scaling {
            // If the picture fits a whole number of times, this key changes nothing.
            screen.xdotool(&["windowsize", "--sync", &id, "900", "700"]);
            wait_for("the larger window", || (screen.place(&id)[2..] == [900, 700]).then_some(()));
        }
        let (before, files_before) = (settled(screen, &id), files(folder));
        screen.xdotool(&["key", &keysym(binding.key)]);
        wait_for(&format!("{file}: {} ({help}) to do something", binding.name), || {
            let is_seen = shown(screen, &id) != before || files(folder) > files_before;
            (is_seen || viewer.0.try_wait().expect("a child").is_some()).then_some(())
        });
        assert!(viewer.0.try_wait().expect("a child").is_none(), "{file}: {} ended the viewer", binding.name);
        if matches!(
            binding.action,
            Action::Help
                | Action::Depth
                | Action::Difference
                | Action::Plan
                | Action::Status
                | Action::Pause
                | Action::Fullscreen
                | Action::Scaling
                | Action::Crt
                | Action::Ground
                | Action::Turntable
        ) {
            // The second press switches the effect off again, before the next key.
            if !matches!(binding.action, Action::Pause | Action::Turntable) {
                // With time running the picture never settles.
                settled(screen, &id);
            }
            screen.xdotool(&["key", &keysym(binding.key)]);
        }
        if binding.action == Action::Scaling {
            screen.xdotool(&["windowsize", "--sync", &id, &place[2].to_string(), &place[3].to_string()]);
        }
        if matches!(binding.action, Action::Scaling | Action::Fullscreen) {
            wait_for("the window as it was", || (screen.place(&id)[2..] == place[2..]).then_some(()));
        }
    }
    screen.xdotool(&["key", "Escape"]);
    let status = wait_for("Esc to end the viewer", || viewer.0.try_wait().expect("a child"));
    assert!(status.success(), "{status}");
}

#[test]
fn every_key_does_something_to_every_kind_of_file() {
    let folder = Folder::new("view-keys");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let here = |name: &str| folder.0.join(name);
    std::fs::write(here("knot.fbs"), KNOT).expect("written");
    std::fs::write(here("spin.x3d"), SPINNING).expect("written");
    let suzanne = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes/suzanne-sphere/monkey_head2.obj");
    std::fs::copy(suzanne, here("suzanne.obj")).expect("copied");
    let made = Command::new(env!("CARGO_BIN_EXE_fbptr"))
        .args(["eye", "--make", "tesseract", "--pixels", "80x60"])
        .output()
        .expect("a scene");
    std::fs::write(here("tesseract.json"), made.stdout).expect("written");
    for (file, is_nd) in
        [("suzanne.obj", false), ("spin.x3d", false), ("tesseract.json", true), ("knot.fbs", false)]
    {
        press_every_key(&screen, &folder.0, file, is_nd);
    }
    // The files that F9, F12 and J saved can be read back.
    let saved: Vec<_> =
        std::fs::read_dir(&folder.0).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    let ending = |wanted: &str| {
        saved.iter().filter(|p| p.extension().is_some_and(|e| e == wanted)).collect::<Vec<_>>()
    };
    assert_eq!((ending("png").len(), ending("gif").len()), (4, 4), "{saved:?}");
    for path in ending("png").into_iter().chain(ending("gif")) {
        assert!(image::open(path).is_ok(), "{}", path.display());
    }
    let views: Vec<_> =
        ending("json").into_iter().filter(|p| p.to_string_lossy().contains("fbptr-0")).collect();
    assert_eq!(views.len(), 1);
    let text = std::fs::read(views[0]).expect("the view");
    assert_eq!(EyeScene::from_json(&text).expect("a scene").dim, 4);
}

#[test]
fn taps_are_not_lost_and_all_works_after_a_resize() {
    let folder = Folder::new("view-taps");
    let Some(screen) = Screen::start(&folder.0) else { return };
    std::fs::write(folder.0.join("knot.fbs"), KNOT).expect("written");
    let (mut viewer, id) = view(&screen, &folder.0, "knot.fbs", "320x240");
    screen.xdotool(&["key", "space", "F2"]);
    let home = settled(&screen, &id);
    // Seven times left at once, faster than pictures are drawn, and as many right: the camera is
    // back.
    let there = ["key", "--delay", "1", "Left", "Left", "Left", "Left", "Left", "Left", "Left"];
    let back = there.map(|key| if key == "Left" { "Right" } else { key });
    screen.xdotool(&there);
    wait_for("the orbit", || (shown(&screen, &id) != home).then_some(()));
    let away = settled(&screen, &id);
    screen.xdotool(&back);
    // A rotation and its inverse agree up to the last bits of f64, which show in a handful of
    // pixels at most.
    wait_for("the way back", || {
        let off = shown(&screen, &id).iter().zip(&home).filter(|(a, b)| a != b).count();
        (off < 40).then_some(())
    });
    assert!(away != home);
    screen.xdotool(&["key", "r"]);
    wait_for("R to come home", || (shown(&screen, &id) == home).then_some(()));
    let size = |w: &str, h: &str| {
        screen.xdotool(&["windowmove", "--sync", &id, "0", "0"]);
        screen.xdotool(&["windowsize", "--sync", &id, w, h]);
        let wanted = [w, h].map(|n| n.parse::<usize>().expect("a size"));
        wait_for("the new size", || (screen.place(&id)[2..] == wanted).then_some(()));
        screen.xdotool(&["mousemove", "20", "20"]);
    };
    for (w, h) in [("700", "500"), ("200", "333"), ("1000", "900")] {
        size(w, h);
        let plain = settled(&screen, &id);
        for key in ["1", "b", "0", "b"] {
            screen.xdotool(&["key", key]);
        }
        screen.xdotool(&["key", "F1"]);
        wait_for("F1 after a resize", || (shown(&screen, &id) != plain).then_some(()));
        screen.xdotool(&["key", "F1"]);
        wait_for("the picture again", || (shown(&screen, &id) == plain).then_some(()));
    }
    screen.xdotool(&["windowsize", &id, "1", "1"]);
    screen.xdotool(&["key", "1"]);
    assert!(viewer.0.try_wait().expect("a child").is_none());
    size("320", "240");
    screen.xdotool(&["key", "q"]);
    assert!(wait_for("Q", || viewer.0.try_wait().expect("a child")).success());
}

#[test]
fn a_drag_orbits_the_wheel_zooms_and_a_changed_file_is_shown() {
    let folder = Folder::new("view-mouse");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let file = folder.0.join("knot.fbs");
    std::fs::write(&file, KNOT).expect("written");
    let (_viewer, id) = view(&screen, &folder.0, "knot.fbs", "320x240");
    screen.xdotool(&["key", "space", "F2"]);
    for (button, what) in [("1", "orbit"), ("3", "pan")] {
        let before = settled(&screen, &id);
        screen.xdotool(&["mousedown", button]);
        std::thread::sleep(Duration::from_millis(100));
        screen.xdotool(&["mousemove_relative", "30", "12"]);
        wait_for(what, || (shown(&screen, &id) != before).then_some(()));
        screen.xdotool(&["mouseup", button]);
    }
    let before = settled(&screen, &id);
    screen.xdotool(&["click", "4"]);
    wait_for("the wheel", || (shown(&screen, &id) != before).then_some(()));
    let before = settled(&screen, &id);
    std::fs::write(&file, KNOT.replace("KNOT 60 12", "TEAPOT 6")).expect("written");
    wait_for("the new file", || (shown(&screen, &id) != before).then_some(()));
}

#[test]
fn without_a_command_the_tour_opens_and_keys_lead_through_it() {
    let folder = Folder::new("tour");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (mut tour, id) = start(&screen, &folder.0, &[]);
    assert_eq!(screen.place(&id)[2..], [960, 540]);
    // Time stands still, so that only keys lead on.
    screen.xdotool(&["key", "space", "R"]);
    let first = settled(&screen, &id);
    screen.xdotool(&["key", "Right"]);
    wait_for("the second step", || (shown(&screen, &id) != first).then_some(()));
    let second = settled(&screen, &id);
    screen.xdotool(&["key", "Left"]);
    wait_for("the first step again", || (shown(&screen, &id) == first).then_some(()));
    screen.xdotool(&["key", "Right"]);
    wait_for("the second step again", || (shown(&screen, &id) == second).then_some(()));
    screen.xdotool(&["key", "Escape"]);
    let status = wait_for("the end", || tour.0.try_wait().expect("a status"));
    assert!(status.success(), "{status}");
    assert!(!folder.0.join("tour.png").exists(), "nothing is saved where there is a window");
}

#[test]
fn without_a_display_view_says_so_and_draws_its_frames() {
    let folder = Folder::new("view-no-display");
    std::fs::write(folder.0.join("spin.x3d"), SPINNING).expect("written");
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_fbptr"))
            .args(["view", "spin.x3d", "--size", "80x60"])
            .args(arguments)
            .current_dir(&folder.0)
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .expect("the viewer runs")
    };
    let output = run(&["--frames", "3", "--snap", "last.png", "--movie", "all.png"]);
    assert!(output.status.success(), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("headless"), "{output:?}");
    let picture = |name: &str| image::open(folder.0.join(name)).expect("a picture").to_rgba8();
    assert!(
        picture("last.png") == picture("all-0002.png") && picture("all-0000.png") != picture("all-0001.png")
    );
    // The same frame, chosen by its time.
    assert!(run(&["--time", "0.08", "--headless", "--snap", "at.png"]).status.success());
    assert!(picture("at.png") == picture("last.png"));
    for bad in [&["--snap", "a.gif"][..], &["--movie", "a.mp4"], &["--fps", "0"], &["--frames", "0"]] {
        assert_eq!(run(bad).status.code(), Some(2), "{bad:?}");
    }
}
