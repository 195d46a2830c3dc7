//! The worked example of `CONTRIBUTING.md`, which adds a verb: the engine runs a figure by the
//! dispatch that a row makes.

use super::dispatch::verbs::run_commands;
use super::*;
use crate::Audience;
use fbptr_command::DrawFigure;
use fbptr_core::draw2d::{DrawError, FigureTarget};
use fbptr_core::error::Fault;

/// The figure of the example's row: centre, reach and colour.
pub(crate) struct Cross([i32; 2], i32, Rgba);

impl DrawFigure for Cross {
    fn draw(&self, target: &mut FigureTarget<'_>) -> Result<(), DrawError> {
        let Cross([x, y], r, color) = *self;
        target.line([x - r, y], [x + r, y], color.into());
        target.line([x, y - r], [x, y + r], color.into());
        Ok(())
    }
}

/// The commands of a table that has this row alone.
pub(crate) enum Command {
    Figure(Cross),
}

run_commands! { dispatch_example_command is_example_job [Figure(Cross) = fn figure] }

#[test]
fn the_examples_row_runs_its_function_on_the_engine() {
    let mut engine = Engine::new(16, 12).expect("a small frame");
    let mut session = Session::new(1, Audience::Owner);
    let mut replies = Vec::new();
    let command = Command::Figure(Cross([8, 6], 3, [255, 0, 0, 255]));
    assert!(!is_example_job(&command));
    let mut call = Call { session: &mut session, replies: &mut replies };
    let progress = engine.dispatch_example_command(&mut call, command).expect("it draws");
    assert!(matches!(progress, Progress::Done(Effect::Done)) && replies.is_empty());

    let is_red = |x, y| engine.memory().get_pixel(x, y) == Ok([255, 0, 0, 255]);
    let red = (0..16).flat_map(|x| (0..12).map(move |y| (x, y))).filter(|(x, y)| is_red(*x, *y));
    let expected = (5..12).map(|x| (x, 6)).chain((3..10).map(|y| (8, y)));
    let [red, expected]: [std::collections::BTreeSet<(i32, i32)>; 2] = [red.collect(), expected.collect()];
    assert_eq!(red, expected);
}
