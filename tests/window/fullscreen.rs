//! Fullscreen display: on over the whole screen and off again, with the server's addresses and
//! rates as an overlay.

use crate::folder::Folder;
use crate::screen::{Screen, wait_for};
use crate::serve::serve;

fn whole_screen(screen: &Screen) -> [usize; 4] {
    let size = screen.xdotool(&["getdisplaygeometry"]);
    let mut sides = size.split_whitespace().map(|side| side.parse().expect("a number"));
    [0, 0, sides.next().expect("a width"), sides.next().expect("a height")]
}

#[test]
fn f11_fills_the_screen_and_goes_back() {
    let folder = Folder::new("fullscreen");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (_server, _) = serve(&screen, &[]);
    let id = screen.window();
    let before = screen.place(&id);
    let whole = whole_screen(&screen);
    screen.xdotool(&["mousemove", &(before[0] + 50).to_string(), &(before[1] + 50).to_string()]);
    for _ in 0..2 {
        screen.xdotool(&["key", "F11"]);
        wait_for("the whole screen", || (screen.place(&id) == whole).then_some(()));
        screen.xdotool(&["key", "F11"]);
        wait_for("the window as it was", || (screen.place(&id) == before).then_some(()));
    }
}

#[test]
fn a_wall_opens_over_the_whole_screen_with_its_overlay() {
    let folder = Folder::new("wall");
    let Some(screen) = Screen::start(&folder.0) else { return };
    let (_server, address) = serve(&screen, &["--fullscreen", "--overlay", "--scaling", "fit"]);
    let id = screen.window();
    let whole = whole_screen(&screen);
    wait_for("the whole screen", || (screen.place(&id) == whole).then_some(()));
    let [_, _, w, h] = whole;
    let lit = || screen.pixels(0, 0, w, h).iter().filter(|pixel| **pixel != [0; 3]).count();
    wait_for("the overlay over the black frame", || (lit() > 100).then_some(()));
    let mut wire = std::net::TcpStream::connect(&address).expect("the server listens");
    let mut draw = |command: &[u8]| std::io::Write::write_all(&mut wire, command).expect("a command");
    // Once something was seen, the window says no longer how to draw.
    draw(b"CLEAR ff0000\n");
    wait_for("a red frame", || (lit() > 1280 * 400).then_some(()));
    draw(b"CLEAR black\n");
    screen.xdotool(&["mousemove", "600", "500", "key", "F3"]);
    wait_for("F3 to hide it", || (lit() == 0).then_some(()));
    draw(b"CLEAR ff0000\n");
    // 320x200 on a screen 1280 pixels wide: exactly four times, centred vertically.
    let shown = 1280 * 800;
    wait_for("the frame over the screen's width", || (lit() == shown).then_some(()));
    screen.xdotool(&["key", "F10"]);
    wait_for("whole factors, which are the same here", || (lit() == shown).then_some(()));
}
