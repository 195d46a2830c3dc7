//! Messages of viewers, and what they ask of the render thread.
//!
//! In: messages that a viewer has sent. Out: its rights, its lines and events on their way to the
//! server, notes to it. Promises: before a viewer has shown a token it can do nothing but join; one
//! that only watches drives nothing; where all places are taken, who drives gets one.

use super::super::commands::send_line;
use super::super::rights::Rights;
use super::super::socket::Disconnected;
use super::super::tiles::TILE;
use super::super::wire::Request;
use super::super::{MAX_VIEWERS, WebTarget};
use super::{Connection, EventLoop, Member};
use crate::message::Message;
use std::time::Instant;

/// The depth of a pixel for a viewer.
pub(super) struct Depth {
    token: usize,
    at: (u32, u32),
    z: Option<f64>,
}

impl EventLoop {
    /// Takes the depths that the render thread has looked up.
    pub(super) fn take_depths(&mut self) {
        while let Ok(Depth { token, at: (x, y), z }) = self.depths.1.try_recv() {
            if let Some(Member { connection: Connection::Viewer(viewer), .. }) = self.members.get_mut(&token)
            {
                viewer.is_probing = false;
                let z = z.map_or("-".to_owned(), |z| z.to_string());
                viewer.note(format!("depth {x} {y} {z}"));
            }
        }
    }

    /// Reads a viewer's messages and acts on them.
    pub(super) fn read_requests(&mut self, token: usize, now: Instant) -> Result<(), Disconnected> {
        let Some(Member { connection: Connection::Viewer(viewer), .. }) = self.members.get_mut(&token) else {
            return Ok(());
        };
        if let (Some(bytes), Some(commands)) = (viewer.stalled.take(), &viewer.commands) {
            viewer.stalled = commands.send(bytes);
        }
        let requests = viewer.read(now)?;
        for request in requests {
            self.handle(token, request, now)?;
        }
        self.probe(token);
        Ok(())
    }

    fn handle(&mut self, token: usize, request: Request, now: Instant) -> Result<(), Disconnected> {
        let hello = self.hello();
        let has_joined = self.members.get(&token).is_some_and(Member::has_joined);
        let has_place = match &request {
            Request::Join(word) if !has_joined => self.make_place(self.options.tokens.rights(word), now),
            _ => true,
        };
        let Some(Member { connection: Connection::Viewer(viewer), .. }) = self.members.get_mut(&token) else {
            return Err(Disconnected);
        };
        match (viewer.rights, request) {
            (None, Request::Join(word)) => {
                let Some(rights) = self.options.tokens.rights(&word) else {
                    viewer.close("the link has no token, or an old one");
                    return Err(Disconnected);
                };
                if !has_place {
                    viewer.close("there are as many viewers as are allowed");
                    return Err(Disconnected);
                }
                viewer.rights = Some(rights);
                let word = if rights == Rights::Drive { "drive" } else { "watch" };
                viewer.note(format!("hello {}", hello.replace("RIGHTS", word)));
                self.title.iter().for_each(|title| viewer.note(format!("title {title}")));
                viewer.note(format!("listeners {}", u8::from(self.listeners)));
            }
            (None, _) | (Some(_), Request::Join(_)) => return Err(Disconnected),
            (Some(_), Request::Ack(sequence)) => viewer.acknowledge(sequence, now),
            (Some(_), Request::Probe(x, y)) => viewer.probe = Some((x, y)),
            (Some(Rights::Watch), Request::Line(_) | Request::Event(_)) => viewer.note("denied".to_owned()),
            (Some(Rights::Drive), Request::Event(event)) => self.target.send(&self.feed, event),
            (Some(Rights::Drive), Request::Line(line)) => send_line(viewer, line, &self.target, &self.feed),
        }
        Ok(())
    }

    /// Makes sure that there is a place for one more viewer: where all are taken, one that does not
    /// keep up gives way, and for who may drive the one that watches since the shortest time. Returns
    /// whether there is one.
    fn make_place(&mut self, rights: Option<Rights>, now: Instant) -> bool {
        let Some(rights) = rights else { return false };
        let viewers: Vec<(usize, Instant, bool, bool)> = (self.members.iter())
            .filter_map(|(token, member)| match &member.connection {
                Connection::Viewer(viewer) if viewer.rights.is_some() => {
                    let watches = viewer.rights == Some(Rights::Watch);
                    Some((*token, member.since, watches, viewer.is_behind(now)))
                }
                _ => None,
            })
            .collect();
        if viewers.len() < MAX_VIEWERS {
            return true;
        }
        let behind = viewers.iter().filter(|(.., is_behind)| *is_behind).min_by_key(|v| v.1);
        let newest = viewers.iter().filter(|(_, _, watches, _)| *watches).max_by_key(|v| v.1);
        let gives_way = behind.or(newest.filter(|_| rights == Rights::Drive)).map(|v| v.0);
        if let Some(Member { connection: Connection::Viewer(viewer), .. }) =
            gives_way.and_then(|token| self.members.get_mut(&token))
        {
            viewer.close("another viewer took this place");
        }
        gives_way.inspect(|token| self.remove(*token)).is_some()
    }

    /// Returns the JSON of the first message to a page, with a place for its rights.
    fn hello(&self) -> String {
        let display = self.feed.display();
        serde_json::json!({
            "width": display.width(),
            "height": display.height(),
            "tile": TILE,
            "rights": "RIGHTS",
            "commands": matches!(self.target, WebTarget::Thread { .. }),
            "version": env!("CARGO_PKG_VERSION"),
        })
        .to_string()
    }

    /// Asks the render thread for the depth that a viewer wants, one at a time.
    fn probe(&mut self, token: usize) {
        let answers = self.depths.0.clone();
        let Some(Member { connection: Connection::Viewer(viewer), .. }) = self.members.get_mut(&token) else {
            return;
        };
        if viewer.is_probing {
            return;
        }
        let Some(at) = viewer.probe.take() else { return };
        match &self.target {
            WebTarget::Program => drop(answers.try_send(Depth { token, at, z: None })),
            WebTarget::Thread { link, .. } => {
                let feed = self.feed.clone();
                let (Ok(x), Ok(y)) = (i32::try_from(at.0), i32::try_from(at.1)) else { return };
                let look = Message::Do(Box::new(move |engine| {
                    let z = engine.depth().and_then(|depth| depth.z(x, y));
                    let _ = answers.try_send(Depth { token, at, z });
                    feed.wake_web();
                }));
                viewer.is_probing = link.messages.try_send(look).is_ok();
            }
        }
    }
}
