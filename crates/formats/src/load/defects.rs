//! Defects that a parser passes over: counted by kind, and reported once for each kind.
//!
//! In: the error that each defect would have been. Out: one warning at the first one, with the
//! number of the others; or that error, if nothing was left to draw.

use super::{LoadError, LoadWarning};

/// Defects of one kind in one file.
#[derive(Clone, Debug, Default)]
pub(super) struct Defects {
    first: Option<LoadError>,
    count: u64,
}

impl Defects {
    /// Counts a defect; the error is made of the first one alone.
    pub(super) fn note(&mut self, error: impl FnOnce() -> LoadError) {
        self.count += 1;
        self.first.get_or_insert_with(error);
    }

    /// Returns the first defect as the error that it would have been.
    pub(super) fn first(&self) -> Option<&LoadError> {
        self.first.as_ref()
    }

    /// Returns the warning that all of them are passed over; `done` says what that means.
    pub(super) fn warning(&self, done: &str) -> Option<LoadWarning> {
        let first = self.first.as_ref()?;
        let count = match self.count {
            1 => String::new(),
            count => format!(", {count} times in all"),
        };
        let message = format!("{}: {done}{count}", first.kind);
        Some(LoadWarning { place: first.place.clone(), message })
    }
}

/// Returns the earliest of the errors that these defects would have been.
pub(super) fn earliest<'a>(all: impl IntoIterator<Item = &'a Defects>) -> Option<LoadError> {
    all.into_iter().filter_map(Defects::first).min_by_key(|error| error.place.line).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::{FilePosition, LoadErrorKind};

    #[test]
    fn defects_of_a_kind_are_one_warning_with_their_number() {
        let error = |line, index| {
            let kind = LoadErrorKind::Index { what: "position", index, count: 3 };
            move || LoadError::new(FilePosition::line("a.obj", line), kind)
        };
        let mut defects = Defects::default();
        assert_eq!((defects.warning("left out"), earliest([&defects])), (None, None));
        defects.note(error(4, 9));
        let text = "a.obj:4: warning: position index 9 names none of the 3 there are: left out";
        assert_eq!(defects.warning("left out").unwrap().to_string(), text);
        defects.note(error(7, 8));
        let twice = format!("{text}, 2 times in all");
        assert_eq!(defects.warning("left out").unwrap().to_string(), twice);
        let mut others = Defects::default();
        others.note(error(2, 5));
        assert_eq!(earliest([&defects, &others]).unwrap().place.line, 2);
    }
}
