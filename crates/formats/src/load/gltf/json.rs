//! Values of a glTF file's JSON, each with its pointer, so that an error names its place.

use crate::load::{FilePosition, LoadError, LoadErrorKind, LoadWarning};
use serde_json::Value;

/// A value of the file, or the lack of one, with its JSON pointer.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    value: Option<&'a Value>,
    pointer: String,
    file: &'a str,
}

impl<'a> Json<'a> {
    /// Returns the root of a file.
    pub(super) fn root(value: &'a Value, file: &'a str) -> Self {
        Json { value: Some(value), pointer: String::new(), file }
    }

    /// Returns a member of an object; a value that is no object has none.
    pub(super) fn member(&self, name: &str) -> Json<'a> {
        let value = self.value.and_then(|v| v.get(name));
        Json { value, pointer: format!("{}/{name}", self.pointer), file: self.file }
    }

    /// Returns an object of `extensions`.
    pub(super) fn extension(&self, name: &str) -> Json<'a> {
        self.member("extensions").member(name)
    }

    pub(super) fn is_there(&self) -> bool {
        self.value.is_some()
    }

    /// Returns whether there is a value that is an object.
    pub(super) fn is_object(&self) -> bool {
        self.value.is_some_and(Value::is_object)
    }

    pub(super) fn place(&self) -> FilePosition {
        FilePosition::json(self.file, &self.pointer)
    }

    pub(super) fn refuse(&self, kind: LoadErrorKind) -> LoadError {
        LoadError::new(self.place(), kind)
    }

    /// Returns the error that something else was expected here.
    pub(super) fn wrong(&self, expected: impl Into<String>) -> LoadError {
        let found = match self.value {
            None => "nothing".to_owned(),
            Some(value) => {
                // A long value is not written out.
                let text = match value {
                    Value::Array(items) => format!("a list of {}", items.len()),
                    Value::Object(_) => "an object".to_owned(),
                    Value::String(text) => text.clone(),
                    other => other.to_string(),
                };
                text.chars().take(60).collect()
            }
        };
        self.refuse(LoadErrorKind::Syntax { expected: expected.into(), found })
    }

    pub(super) fn warning(&self, message: impl Into<String>) -> LoadWarning {
        LoadWarning { place: self.place(), message: message.into() }
    }

    /// Returns the items of a list; none without a value.
    pub(super) fn items(&self) -> Result<Vec<Json<'a>>, LoadError> {
        let items = match self.value {
            None => return Ok(Vec::new()),
            Some(Value::Array(items)) => items,
            Some(_) => return Err(self.wrong("a list")),
        };
        let item = |(i, value)| Json {
            value: Some(value),
            pointer: format!("{}/{i}", self.pointer),
            file: self.file,
        };
        Ok(items.iter().enumerate().map(item).collect())
    }

    /// Returns the number of items of a list.
    pub(super) fn count(&self) -> usize {
        self.value.and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// Returns an item of a list.
    pub(super) fn item(&self, i: usize) -> Json<'a> {
        let value = self.value.and_then(|v| v.get(i));
        Json { value, pointer: format!("{}/{i}", self.pointer), file: self.file }
    }

    pub(super) fn text(&self) -> Result<Option<&'a str>, LoadError> {
        match self.value {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(_) => Err(self.wrong("a text")),
        }
    }

    pub(super) fn bool_or(&self, default: bool) -> Result<bool, LoadError> {
        match self.value {
            None => Ok(default),
            Some(Value::Bool(value)) => Ok(*value),
            Some(_) => Err(self.wrong("true or false")),
        }
    }

    pub(super) fn number(&self) -> Result<f64, LoadError> {
        let number = self.value.and_then(Value::as_f64).filter(|n| n.is_finite());
        number.ok_or_else(|| self.wrong("a number"))
    }

    pub(super) fn number_or(&self, default: f64) -> Result<f64, LoadError> {
        if self.is_there() { self.number() } else { Ok(default) }
    }

    /// Returns a list of `N` numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Result<Option<[f64; N]>, LoadError> {
        if !self.is_there() {
            return Ok(None);
        }
        if self.count() != N {
            return Err(self.wrong(format!("a list of {N} numbers")));
        }
        let mut numbers = [0.0; N];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = self.item(i).number()?;
        }
        Ok(Some(numbers))
    }

    /// Returns a whole number, not negative.
    pub(super) fn whole(&self) -> Result<u64, LoadError> {
        let whole = self.value.and_then(|v| match v.as_u64() {
            Some(n) => Some(n),
            // Some exporters write 3.0.
            None => v.as_f64().filter(|n| (0.0..1e15).contains(n) && n.fract() == 0.0).map(|n| n as u64),
        });
        whole.ok_or_else(|| self.wrong("a whole number that is not negative"))
    }

    pub(super) fn whole_or(&self, default: u64) -> Result<u64, LoadError> {
        if self.is_there() { self.whole() } else { Ok(default) }
    }

    /// Returns the index of one of `count` things, which `what` names.
    pub(super) fn index(&self, what: &'static str, count: usize) -> Result<usize, LoadError> {
        let index = self.whole()?;
        match usize::try_from(index).ok().filter(|i| *i < count) {
            Some(index) => Ok(index),
            None => {
                let index = i64::try_from(index).unwrap_or(i64::MAX);
                Err(self.refuse(LoadErrorKind::Index { what, index, count: count as u64 }))
            }
        }
    }

    /// [`Json::index`], or `None` without a value.
    pub(super) fn index_if_there(
        &self,
        what: &'static str,
        count: usize,
    ) -> Result<Option<usize>, LoadError> {
        if self.is_there() { self.index(what, count).map(Some) } else { Ok(None) }
    }
}

/// Returns an upper bound of the bytes for the values of a JSON text: each list and object, member
/// and item, in vectors and trees that have up to twice the room, and each item's pointer.
pub(super) fn value_bytes(text: &[u8]) -> u64 {
    let bytes = text.iter().map(|byte| match byte {
        // A tree's first leaf has room for eleven members.
        b'{' => 900,
        b'[' => 160,
        b',' => 320,
        b':' => 120,
        _ => 3,
    });
    bytes.sum()
}
