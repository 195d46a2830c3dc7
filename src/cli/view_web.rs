//! `fbptr view --web`: the viewer's pictures in the browser, and its keys and pointer from there.
//!
//! In: a viewer after each of its pictures. Out: pictures on the page's feed; events of those who
//! may drive, as the viewer's own input. Requests to save a file are not served: the page saves
//! what it shows by itself.

use super::web::{PreparedWeb, WebPage};
use crate::input::InputEvent;
use crate::server::{Input, WebFeed};
use crate::viewer::{Key, Request, Viewer};
use std::sync::Arc;

/// The page of a viewer.
pub(super) struct ViewerPage {
    feed: Arc<WebFeed>,
    _page: WebPage,
    /// Number of the newest picture, and whether it is still to be put on the feed.
    frame: u64,
    is_pending: bool,
}

impl ViewerPage {
    /// Serves the page.
    pub fn start(mut web: PreparedWeb, viewer: &Viewer) -> Result<ViewerPage, String> {
        let feed = web.feed(viewer.shown().width(), viewer.shown().height());
        Ok(ViewerPage { feed, _page: web.serve_program()?, frame: 0, is_pending: true })
    }

    /// Passes on the picture if it is new, and handles the events since the last call. Returns
    /// whether the viewer is to end.
    pub fn step(&mut self, viewer: &mut Viewer, is_new: bool) -> bool {
        self.is_pending |= is_new;
        if self.is_pending && self.feed.is_requested() {
            self.is_pending = false;
            self.frame += 1;
            let memory = viewer.shown();
            self.feed.display().publish(memory, 0..memory.height(), self.frame, None);
            self.feed.note_frame();
        }
        let events = self.feed.display().inputs();
        let mut quits = false;
        while let Ok(input) = events.try_recv() {
            if let Input::Event(event) = input {
                quits |= feed(viewer, &event) == Some(Request::Quit);
            }
        }
        quits
    }
}

fn feed(viewer: &mut Viewer, event: &InputEvent) -> Option<Request> {
    match event {
        InputEvent::Key { name, down } => return viewer.key(key(name)?, *down),
        InputEvent::Mouse { x, y, buttons } => {
            // The pixel's centre.
            viewer.pointer(Some([f64::from(*x) + 0.5, f64::from(*y) + 0.5]), *buttons);
        }
        InputEvent::Wheel { dy, .. } if *dy != 0 => viewer.wheel(f64::from(dy.signum())),
        _ => {}
    }
    None
}

/// Returns the viewer's key of a name in `EVENT` lines.
fn key(name: &str) -> Option<Key> {
    Some(match name {
        "escape" => Key::Escape,
        "f1" => Key::F1,
        "f2" => Key::F2,
        "f3" => Key::F3,
        "0" | "numpad0" => Key::Zero,
        "1" | "numpad1" => Key::One,
        "2" | "numpad2" => Key::Two,
        "3" | "numpad3" => Key::Three,
        "4" | "numpad4" => Key::Four,
        "5" | "numpad5" => Key::Five,
        "a" => Key::A,
        "b" => Key::B,
        "c" => Key::C,
        "d" => Key::D,
        "e" => Key::E,
        "g" => Key::G,
        "h" => Key::H,
        "i" => Key::I,
        "k" => Key::K,
        "n" => Key::N,
        "o" => Key::O,
        "p" => Key::P,
        "q" => Key::Q,
        "r" => Key::R,
        "s" => Key::S,
        "t" => Key::T,
        "u" => Key::U,
        "v" => Key::V,
        "w" => Key::W,
        "z" => Key::Z,
        "space" => Key::Space,
        "period" | "numpaddot" => Key::Period,
        "comma" => Key::Comma,
        "left" => Key::Left,
        "right" => Key::Right,
        "up" => Key::Up,
        "down" => Key::Down,
        "pageup" => Key::PageUp,
        "pagedown" => Key::PageDown,
        "equal" | "numpadplus" => Key::Equal,
        "minus" | "numpadminus" => Key::Minus,
        "leftbracket" => Key::LeftBracket,
        "rightbracket" => Key::RightBracket,
        "tab" => Key::Tab,
        "backspace" => Key::Backspace,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_names_of_event_lines() {
        assert_eq!(
            (key("left"), key("1"), key("f12"), key("")),
            (Some(Key::Left), Some(Key::One), None, None)
        );
    }
}
