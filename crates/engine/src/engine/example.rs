//! The worked example of `CONTRIBUTING.md`, which adds a verb: the engine runs it by the
//! dispatch that its row makes.

use super::dispatch::verbs::run_commands;
use super::*;
use crate::command::example::{self, Command, example_verbs};
use crate::error::Fault;
use crate::server::Audience;

/// Makes the dispatch of the example's rows.
macro_rules! dispatch_example {
    (nested $nested:tt; $group:ident $encoding:ident Figure $rows:tt) => {
        run_commands! { dispatch_example_command is_example_job $nested }
    };
}
example_verbs! { dispatch_example }

#[test]
fn the_examples_row_runs_its_function_on_the_engine() {
    let mut engine = Engine::new(16, 12).expect("a small frame");
    let mut session = Session::new(1, Audience::Owner);
    let mut replies = Vec::new();
    let command = example::command_of("CROSS 8 6 3 red");
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
