//! A JSON value with its path, and typed accessors whose errors say what they expected.

use crate::eye::EyeError;
use crate::memory::parse_color;
use serde_json::{Map, Value};

/// A JSON value and its path.
pub(in crate::eye) struct Node<'a> {
    pub(in crate::eye) value: &'a Value,
    pub(in crate::eye) path: String,
}

impl<'a> Node<'a> {
    /// Returns the path of a field.
    pub(super) fn at(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Returns the error that this value is not of the expected type.
    pub(super) fn not(&self, expected: &str) -> EyeError {
        let text = match self.value {
            Value::Array(list) => format!("an array of {}", list.len()),
            Value::Object(_) => "an object".to_owned(),
            other => other.to_string(),
        };
        let found = text.chars().take(40).collect();
        let path = if self.path.is_empty() { "the scene".to_owned() } else { self.path.clone() };
        EyeError::Type { path, expected: expected.to_owned(), found }
    }

    /// Returns the object, or an error if it has other fields than `fields`.
    pub(in crate::eye) fn object(&self, fields: &[&str]) -> Result<&'a Map<String, Value>, EyeError> {
        let map = self.value.as_object().ok_or_else(|| self.not("an object"))?;
        match map.keys().find(|key| !fields.contains(&key.as_str())) {
            Some(key) => Err(EyeError::Unknown { path: self.at(key), expected: fields.join(", ") }),
            None => Ok(map),
        }
    }

    /// Returns a field, or `None` if it is missing.
    pub(in crate::eye) fn optional(&self, key: &str) -> Option<Node<'a>> {
        self.value.get(key).map(|value| Node { value, path: self.at(key) })
    }

    /// Returns a field, or an error if it is missing.
    pub(in crate::eye) fn field(&self, key: &str) -> Result<Node<'a>, EyeError> {
        self.optional(key).ok_or_else(|| EyeError::Missing { path: self.at(key) })
    }

    /// Returns the entries of an array.
    pub(in crate::eye) fn array(&self) -> Result<Vec<Node<'a>>, EyeError> {
        let list = self.value.as_array().ok_or_else(|| self.not("an array"))?;
        let node = |(i, value)| Node { value, path: format!("{}[{i}]", self.path) };
        Ok(list.iter().enumerate().map(node).collect())
    }

    /// Returns a finite number.
    pub(in crate::eye) fn number(&self) -> Result<f64, EyeError> {
        self.value.as_f64().filter(|x| x.is_finite()).ok_or_else(|| self.not("a finite number"))
    }

    /// Returns an integer from 0 to `most`.
    pub(in crate::eye) fn integer(&self, most: u64) -> Result<u64, EyeError> {
        let found = self.number()?;
        if (0.0..=most as f64).contains(&found) && found.trunc() == found {
            Ok(found as u64)
        } else {
            let expected = format!("a whole number from 0 to {most}");
            Err(EyeError::Range { path: self.path.clone(), expected, found })
        }
    }

    /// Returns the entries of an array of finite numbers.
    pub(in crate::eye) fn numbers(&self) -> Result<Vec<f64>, EyeError> {
        // No path is built for valid entries: there are many facets.
        let list = self.value.as_array().ok_or_else(|| self.not("an array of numbers"))?;
        let read = |(i, value): (usize, &'a Value)| match value {
            Value::Number(_) => Node { value, path: String::new() }.number(),
            _ => Node { value, path: format!("{}[{i}]", self.path) }.number(),
        };
        list.iter().enumerate().map(read).collect()
    }

    /// Returns a colour: R, G, B as three numbers, or the name of a CSS colour or hex, scaled so
    /// that ff is `full`.
    pub(super) fn color(&self, full: f64) -> Result<[f64; 3], EyeError> {
        const EXPECTED: &str = "three numbers, a CSS colour name, or gg or rrggbb in hex";
        let word = match self.value {
            Value::String(word) => word,
            Value::Array(_) => return self.triple(),
            _ => return Err(self.not(EXPECTED)),
        };
        let hex = word.strip_prefix('#').unwrap_or(word);
        match parse_color(hex.as_bytes()) {
            Some([r, g, b, 255]) if hex.len() == word.len() || hex.bytes().all(|b| b.is_ascii_hexdigit()) => {
                Ok([r, g, b].map(|c| f64::from(c) * full / 255.0))
            }
            _ => Err(self.not(EXPECTED)),
        }
    }

    /// Returns an array of three finite numbers.
    pub(in crate::eye) fn triple(&self) -> Result<[f64; 3], EyeError> {
        let list = self.numbers()?;
        list.as_slice().try_into().map_err(|_| EyeError::Length {
            path: self.path.clone(),
            expected: "3".into(),
            found: list.len(),
        })
    }
}
