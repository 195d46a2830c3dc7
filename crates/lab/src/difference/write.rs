//! A difference as text and as JSON.

use super::{Class, WrongPixels};
use serde_json::{Value, json};
use std::fmt;

impl fmt::Display for WrongPixels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([w, h], [ew, eh]) = (self.size, self.exact_size);
        if self.size != self.exact_size {
            return writeln!(f, "the picture has {w}x{h} pixels, the exact one {ew}x{eh}");
        }
        let all = u64::from(w) * u64::from(h);
        match self.wrong {
            0 => write!(f, "equal: no pixel of {all} is wrong")?,
            1 => write!(f, "1 pixel of {all} is wrong, by {} of 255", self.largest)?,
            n => write!(f, "{n} pixels of {all} are wrong, by {} of 255 at most", self.largest)?,
        }
        if self.ties > 0 {
            write!(f, "; {} more differ and are right: the ideal line passes midway", self.ties)?;
        }
        writeln!(f)?;
        for finding in &self.findings {
            let places: Vec<_> = finding.examples.iter().map(|[x, y]| format!("({x}, {y})")).collect();
            let more = if finding.pixels > places.len() as u64 { " ..." } else { "" };
            writeln!(f, "{:>7}  {}", finding.pixels, finding.text)?;
            writeln!(f, "         at {}{more}", places.join(" "))?;
        }
        Ok(())
    }
}

impl WrongPixels {
    /// Returns the difference as JSON.
    pub fn json(&self) -> Value {
        let findings: Vec<Value> = self
            .findings
            .iter()
            .map(|f| json!({ "class": f.class.name(), "pixels": f.pixels, "text": f.text, "first": f.examples }))
            .collect();
        json!({
            "size": self.size,
            "exact_size": self.exact_size,
            "equal": self.is_equal(),
            "wrong": self.wrong,
            "ties": self.ties,
            "largest": self.largest,
            "findings": findings,
        })
    }

    /// Returns the number of wrong pixels of a class.
    pub fn count(&self, class: Class) -> u64 {
        self.findings.iter().find(|f| f.class == class).map_or(0, |f| f.pixels)
    }
}
