//! The parts of a frame: the time of each piece of work that threads can share, and of what runs on one
//! thread between them.
//!
//! In: the events of a renderer whose pool has one thread, so that pieces run one after the other. Out:
//! the steps of a frame in their order.

use fbptr_core::executor::{PieceEvent, PieceObserver};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Part of a frame; times are in seconds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Runs on one thread.
    Serial(f64),
    /// Pieces that may run in parallel, in order.
    Pieces(Vec<f64>),
}

/// Records the steps of a frame.
#[derive(Debug)]
pub(super) struct PieceRecorder(Mutex<Open>);

#[derive(Debug)]
struct Open {
    steps: Vec<Step>,
    /// Regions that have begun and not ended. Those within a piece are part of that piece.
    depth: usize,
    /// Time when the last step, or this region, began.
    since: Instant,
    piece_since: Instant,
    pieces: Vec<f64>,
    /// Pieces that have begun within pieces.
    inner: usize,
}

impl PieceRecorder {
    /// Creates a recorder; the frame begins now.
    pub fn new() -> Self {
        PieceRecorder(Mutex::new(Open::new()))
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets what was recorded; a frame begins now.
    pub fn begin(&self) {
        *self.open() = Open::new();
    }

    /// Returns the steps of the frame, which ends now.
    pub fn end(&self) -> Vec<Step> {
        let mut open = self.open();
        open.close_serial();
        std::mem::take(&mut open.steps)
    }
}

impl Open {
    fn new() -> Self {
        let now = Instant::now();
        Open { steps: Vec::new(), depth: 0, since: now, piece_since: now, pieces: Vec::new(), inner: 0 }
    }

    /// Ends what ran on one thread; the next step begins.
    fn close_serial(&mut self) {
        let now = Instant::now();
        self.steps.push(Step::Serial(now.duration_since(self.since).as_secs_f64()));
        self.since = now;
    }

    /// Ends a region. What its threads did between pieces is shared out over them.
    fn close_region(&mut self) {
        let now = Instant::now();
        let whole = now.duration_since(self.since).as_secs_f64();
        self.since = now;
        let mut pieces = std::mem::take(&mut self.pieces);
        if pieces.is_empty() {
            return self.steps.push(Step::Serial(whole));
        }
        let between = (whole - pieces.iter().sum::<f64>()).max(0.0) / pieces.len() as f64;
        pieces.iter_mut().for_each(|piece| *piece += between);
        self.steps.push(Step::Pieces(pieces));
    }
}

impl PieceObserver for PieceRecorder {
    fn note(&self, event: PieceEvent) {
        let mut open = self.open();
        match event {
            PieceEvent::RegionBegins => {
                if open.depth == 0 {
                    open.close_serial();
                }
                open.depth += 1;
            }
            PieceEvent::RegionEnds => {
                open.depth -= 1;
                if open.depth == 0 {
                    open.close_region();
                }
            }
            PieceEvent::PieceBegins => {
                open.inner += 1;
                if open.inner == 1 {
                    open.piece_since = Instant::now();
                }
            }
            PieceEvent::PieceEnds => {
                open.inner -= 1;
                if open.inner == 0 {
                    let took = open.piece_since.elapsed().as_secs_f64();
                    open.pieces.push(took);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::Executor;
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn a_frame_is_its_serial_parts_and_its_pieces_and_those_within_pieces_are_part_of_them() {
        let recorder = Arc::new(PieceRecorder::new());
        let executor = Executor::default().observed(Some(recorder.clone()));
        let wait = |ms| std::thread::sleep(Duration::from_millis(ms));
        recorder.begin();
        wait(3);
        executor.chunks(&mut [0; 3], 1, |i, _| {
            wait(1 + i as u64);
            executor.chunks(&mut [0; 2], 1, |_, _| wait(2));
        });
        let steps = recorder.end();
        let [Step::Serial(before), Step::Pieces(pieces), Step::Serial(after)] = &steps[..] else {
            panic!("{steps:?}");
        };
        assert!(*before >= 0.003 && *after < *before && pieces.len() == 3, "{steps:?}");
        assert!((0..3).all(|i| pieces[i] >= 0.005 + 0.001 * i as f64), "{pieces:?}");
    }
}
