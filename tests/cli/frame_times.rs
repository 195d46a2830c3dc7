//! Tests of `--frame-times`: one line on standard error, as many frames as there were.

use crate::play::{err, out, run};

/// Returns the numbers of a line of times: frames, median, 99th percentile, longest, first.
fn numbers(line: &str) -> Vec<f64> {
    line.split([' ', ';', ':']).filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn play_prints_the_times_between_presents() {
    let stream = format!("AUTO off\n{}CRC\n", "CLEAR navy\nFILLCIRCLE 30 20 9 gold\nPRESENT\n".repeat(5));
    let plain = run(&["play", "--headless", "--size", "64x48"], stream.as_bytes());
    let timed = run(&["play", "--headless", "--size", "64x48", "--frame-times"], stream.as_bytes());
    assert_eq!(out(&timed), out(&plain), "replies and pictures stay");
    let found = numbers(err(&timed));
    let [frames, median, p99, longest, first] = found[..] else { panic!("{}", err(&timed)) };
    assert_eq!(frames, 4.0);
    assert!(0.0 <= median && median <= p99 && p99 <= longest && first >= 0.0, "{found:?}");
    for (presents, line) in [(0, "there were no frames"), (1, "one frame: ")] {
        let stream = "PRESENT\n".repeat(presents);
        let timed = run(&["play", "--headless", "--frame-times"], stream.as_bytes());
        assert!(timed.status.success() && err(&timed).contains(line), "{}", err(&timed));
    }
}

#[test]
fn view_prints_the_times_of_drawing() {
    let path = "tests/data/meshes/suzanne-sphere/monkey_head2.obj";
    let arguments = ["view", path, "--size", "64x48", "--turntable", "--frames", "6", "--frame-times"];
    let timed = run(&[&arguments[..], &["--headless"]].concat(), b"");
    assert!(timed.status.success(), "{}", err(&timed));
    let line = err(&timed).lines().find(|line| line.contains("frames: ")).expect("the line of times");
    assert_eq!(numbers(line)[0], 5.0, "{line}");
    assert!(!line.contains("the first"), "{line}");
    let web = run(&[&arguments[..], &["--headless", "--web", ":0"]].concat(), b"");
    assert!(web.status.code() == Some(2) && err(&web).contains("--web"), "{}", err(&web));
    // One frame alone, and a stream without motion.
    for (path, frames) in [(path, "1"), ("demos/ball.fbs", "4")] {
        let arguments = ["view", path, "--size", "64x48", "--headless", "--frames", frames, "--frame-times"];
        let still = run(&arguments, b"");
        assert!(
            still.status.success() && err(&still).contains("no frames to time"),
            "{path}: {}",
            err(&still)
        );
    }
    // In a window the frames wait for the clock.
    let refused = run(&arguments, b"");
    assert!(refused.status.code() == Some(2) && err(&refused).contains("--headless"), "{}", err(&refused));
}
