//! Difference between the drawn and the exact picture, magnified until it is visible.
//!
//! In: two pictures. Out: |a - b| for each channel, times the factor that makes the largest 255.
//! The exact picture takes long, so it is computed on a separate thread, one at a time; a result
//! that is out of date when it arrives is discarded.

use fbptr_core::memory::VideoMemory;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Difference between two pictures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Difference {
    /// Magnified difference, RGBA.
    pub rgba: Vec<u8>,
    /// Number of pixels that differ.
    pub pixels: usize,
    /// Largest difference of a channel.
    pub largest: u8,
    /// Magnification factor.
    pub factor: u32,
}

impl Difference {
    /// Compares a picture with the least and the largest correct byte of each channel, as returned
    /// by `right` for a pixel's index.
    pub fn new(found: &[u8], right: impl Fn(usize) -> [[u8; 3]; 2]) -> Self {
        let pixels = found.as_chunks::<4>().0;
        let off = |i: usize| {
            let [least, largest] = right(i);
            [0, 1, 2]
                .map(|c| least[c].saturating_sub(pixels[i][c]).max(pixels[i][c].saturating_sub(largest[c])))
        };
        let all: Vec<[u8; 3]> = (0..pixels.len()).map(off).collect();
        let largest = all.iter().flatten().copied().max().unwrap_or(0);
        let factor = if largest == 0 { 1 } else { 255 / u32::from(largest) };
        let shown = |d: u8| (u32::from(d) * factor).min(255) as u8;
        Difference {
            rgba: all.iter().flat_map(|&[r, g, b]| [shown(r), shown(g), shown(b), 255]).collect(),
            pixels: all.iter().filter(|d| **d != [0; 3]).count(),
            largest,
            factor,
        }
    }

    /// Compares two pictures of the same size.
    pub fn of_bytes(found: &[u8], exact: &[u8]) -> Self {
        let exact = exact.as_chunks::<4>().0;
        Difference::new(found, |i| {
            let [r, g, b, _] = exact[i];
            [[r, g, b]; 2]
        })
    }

    /// Returns a line for the overlay; `exact` names the exact picture.
    pub fn line(&self, exact: &str) -> String {
        match self.pixels {
            0 => format!("no pixel differs from {exact}"),
            n => {
                let all = self.rgba.len() / 4;
                format!(
                    "{n} of {all} pixels differ from {exact}, by {} at most; shown x{}",
                    self.largest, self.factor
                )
            }
        }
    }

    /// Copies the magnified difference into a frame of the same size.
    pub fn paint(&self, memory: &mut VideoMemory) {
        memory.bytes_mut().copy_from_slice(&self.rgba);
    }
}

/// Work that computes an exact picture and the difference to it.
pub(super) type Work = Box<dyn FnOnce() -> Result<Difference, String> + Send>;

/// The exact picture of one moment, running or finished.
#[derive(Default)]
pub(super) struct Exact {
    running: Option<(u64, Receiver<Result<Difference, String>>)>,
    done: Option<(u64, Result<Difference, String>)>,
}

impl Exact {
    /// Returns the difference of picture `version`, if it is finished.
    pub fn of(&self, version: u64) -> Option<&Result<Difference, String>> {
        self.done.as_ref().filter(|(v, _)| *v == version).map(|(_, d)| d)
    }

    /// Returns whether work for `version` can start: it is not finished, and no work is running.
    pub fn wants(&self, version: u64) -> bool {
        self.running.is_none() && self.of(version).is_none()
    }

    /// Starts the work for picture `version` on a thread of its own.
    pub fn begin(&mut self, version: u64, work: Work) {
        let (sender, receiver) = channel();
        let job = move || {
            // The receiver is gone if the viewer was closed.
            let _ = sender.send(work());
        };
        match std::thread::Builder::new().name("exact picture".into()).spawn(job) {
            Ok(_) => self.running = Some((version, receiver)),
            Err(e) => self.done = Some((version, Err(format!("no thread to work on: {e}")))),
        }
    }

    /// Takes a finished result. Returns whether there was one.
    pub fn poll(&mut self) -> bool {
        let Some((version, receiver)) = &self.running else { return false };
        match receiver.try_recv() {
            Err(TryRecvError::Empty) => return false,
            Ok(result) => self.done = Some((*version, result)),
            Err(TryRecvError::Disconnected) => {
                self.done = Some((*version, Err("the exact picture met a defect".to_owned())));
            }
        }
        self.running = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_becomes_white_and_none_is_black() {
        let found = [10, 20, 30, 255, 1, 1, 1, 0];
        let d = Difference::of_bytes(&found, &[10, 20, 33, 255, 1, 0, 1, 255]);
        assert_eq!((d.pixels, d.largest, d.factor), (2, 3, 85));
        assert_eq!(d.rgba, [0, 0, 255, 255, 0, 85, 0, 255]);
        let none = Difference::of_bytes(&found, &found);
        assert_eq!((none.pixels, none.largest), (0, 0));
        assert!(none.line("it").starts_with("no pixel differs"));
        let range = Difference::new(&found, |_| [[9, 19, 29], [11, 21, 31]]);
        assert_eq!(range.pixels, 1, "what lies within the right answers does not differ");
    }

    #[test]
    fn work_in_flight_is_not_begun_twice_and_a_defect_is_told() {
        let mut exact = Exact::default();
        assert!(exact.wants(7));
        exact.begin(7, Box::new(|| Ok(Difference::of_bytes(&[1, 2, 3, 4], &[1, 2, 3, 4]))));
        assert!(!exact.wants(8));
        while !exact.poll() {
            std::thread::yield_now();
        }
        assert!(exact.of(7).is_some() && exact.of(8).is_none() && exact.wants(8));
        exact.begin(8, Box::new(|| panic!("a defect")));
        while !exact.poll() {
            std::thread::yield_now();
        }
        assert!(exact.of(8).is_some_and(|r| r.is_err()));
    }
}
