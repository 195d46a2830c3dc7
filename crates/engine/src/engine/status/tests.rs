//! Tests of the outputs that `STATS` names.

use super::*;
use crate::engine::{Event, FrameView, Observer};
use crate::{Audience, Session};
use fbptr_command::Command;

/// An output that no part of the server knows.
#[derive(Debug)]
struct Projector;

impl Observer for Projector {
    fn event(&mut self, _: &Event<'_>, _: FrameView<'_>) {}

    fn output(&self, frame: FrameView<'_>) -> Option<OutputStatus> {
        let figures = vec![("projector_lamps", 3), ("projector_rows", frame.memory.height().into())];
        Some(OutputStatus { name: "projector", state: OutputState::On, figures })
    }
}

fn stats(engine: &mut Engine) -> String {
    let mut replies = Vec::new();
    let mut session = Session::new(1, Audience::Owner);
    engine.run(&mut session, Command::Stats, &mut replies).map(drop).unwrap();
    String::from_utf8(replies).unwrap()
}

#[test]
fn stats_name_the_outputs_that_are_offered_or_reported_and_no_others() {
    let mut engine = Engine::new(4, 3).unwrap();
    let line = stats(&mut engine);
    assert!(["shm", "record", "projector"].iter().all(|name| !line.contains(&format!(" {name}"))), "{line}");
    let off = |name| OutputStatus { name, ..OutputStatus::default() };
    engine.offer_output(off("projector"));
    engine.offer_output(off("plotter"));
    assert!(stats(&mut engine).contains(" projector=off plotter=off "), "{}", stats(&mut engine));
    engine.attach(Projector);
    let expected = " projector=ok projector_lamps=3 projector_rows=3 plotter=off ";
    assert!(stats(&mut engine).contains(expected), "{}", stats(&mut engine));
    assert_eq!(engine.status().output("projector").figure("projector_lamps"), 3);
    assert_eq!(engine.status().output("printer").state, OutputState::Off);
}
