//! A record: the line of a manifest that tells of one frame.
//!
//! ```text
//! {"frame":7,"of":50,"crc":"5d4c0a81","files":[{"name":"turn-0007.png","bytes":4711,"crc":"0b1d9e3f"}],
//!  "size":[640,480],"fps":25,"seconds":0.0123,"time":"2026-11-23T23:01:02Z","host":"node7",
//!  "version":"0.1.0","recipe":"9c2f81aa"}
//! ```
//!
//! `crc` is that of the frame's R, G, B, A bytes, the value that `CRC` replies: equal on every machine
//! and in every file format. `files` has the length and the CRC of each file's bytes, so that a
//! file is verified without decoding it. `recipe` is a checksum of the scene and the arguments.

use serde_json::Value;
use std::time::SystemTime;

/// A file of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRecord {
    /// Name within the batch's folder.
    pub name: String,
    /// Length in bytes.
    pub bytes: u64,
    /// CRC-32 of the file's bytes.
    pub crc: u32,
}

/// A frame that was drawn and written.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// Number of frames of the whole animation.
    pub of: u32,
    /// CRC-32 of the frame's R, G, B, A bytes.
    pub crc: u32,
    /// The picture, and the depth if it was written.
    pub files: Vec<FileRecord>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub fps: f64,
    /// Seconds that drawing and writing took.
    pub seconds: f64,
    /// Time at which the frame was written: UTC, ISO 8601, in seconds.
    pub time: String,
    /// Name of the machine.
    pub host: String,
    /// Version of the program.
    pub version: String,
    /// Checksum of the scene's files and of the arguments that change a frame.
    pub recipe: u32,
}

impl Record {
    /// Returns the line, with its end.
    pub fn to_line(&self) -> String {
        let quoted = |text: &str| Value::from(text).to_string();
        let file = |file: &FileRecord| {
            format!(
                "{{\"name\":{},\"bytes\":{},\"crc\":\"{:08x}\"}}",
                quoted(&file.name),
                file.bytes,
                file.crc
            )
        };
        let files: Vec<String> = self.files.iter().map(file).collect();
        format!(
            "{{\"frame\":{},\"of\":{},\"crc\":\"{:08x}\",\"files\":[{}],\"size\":[{},{}],\"fps\":{},\
             \"seconds\":{:.6},\"time\":{},\"host\":{},\"version\":{},\"recipe\":\"{:08x}\"}}\n",
            self.frame,
            self.of,
            self.crc,
            files.join(","),
            self.size[0],
            self.size[1],
            Value::from(self.fps),
            self.seconds,
            quoted(&self.time),
            quoted(&self.host),
            quoted(&self.version),
            self.recipe
        )
    }

    /// Parses a line; `None` if it is torn or of another kind. Names that lead out of the folder
    /// are none of a batch.
    pub fn from_line(line: &str) -> Option<Record> {
        let value: Value = serde_json::from_str(line).ok()?;
        let number = |value: &Value| value.as_u64().and_then(|n| u32::try_from(n).ok());
        let crc = |value: &Value| {
            let text = value.as_str().filter(|text| text.len() == 8)?;
            u32::from_str_radix(text, 16).ok()
        };
        let text = |key: &str| value.get(key)?.as_str().map(str::to_owned);
        let file = |file: &Value| {
            let name = file.get("name")?.as_str().filter(|name| is_plain_name(name))?.to_owned();
            Some(FileRecord { name, bytes: file.get("bytes")?.as_u64()?, crc: crc(file.get("crc")?)? })
        };
        let files = value.get("files")?.as_array()?.iter().map(file).collect::<Option<Vec<_>>>()?;
        let size = value.get("size")?.as_array()?;
        let [width, height] = size.as_slice() else { return None };
        let finite = |key: &str| value.get(key)?.as_f64().filter(|n| n.is_finite());
        let record = Record {
            frame: number(value.get("frame")?)?,
            of: number(value.get("of")?)?,
            crc: crc(value.get("crc")?)?,
            files,
            size: [number(width)?, number(height)?],
            fps: finite("fps")?,
            seconds: finite("seconds")?,
            time: text("time")?,
            host: text("host")?,
            version: text("version")?,
            recipe: crc(value.get("recipe")?)?,
        };
        (record.frame < record.of && !record.files.is_empty()).then_some(record)
    }

    /// Returns what all frames of one batch share: records of another scene, of other arguments or
    /// of another version are not counted with it.
    pub fn identity(&self) -> (u32, &str) {
        (self.recipe, &self.version)
    }
}

/// Returns whether a name is that of a file in the folder itself.
fn is_plain_name(name: &str) -> bool {
    !name.is_empty() && name != "." && name != ".." && !name.contains(['/', '\\', '\0'])
}

/// Returns a time as `2026-11-23T23:01:02Z`.
pub fn iso_utc(time: SystemTime) -> String {
    let [year, month, day, hour, minute, second] = crate::server::utc_fields(time);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Returns the machine's name.
pub fn host() -> String {
    #[cfg(unix)]
    let name = rustix::system::uname().nodename().to_string_lossy().into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_default();
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, UNIX_EPOCH};

    fn record() -> Record {
        let file = |name: &str| FileRecord { name: name.into(), bytes: 4711, crc: 0x0b1d_9e3f };
        Record {
            frame: 7,
            of: 50,
            crc: 0x5d4c_0a81,
            files: vec![file("a \"b\"-0007.png"), file("d-0007.pfm")],
            size: [640, 480],
            fps: 12.5,
            seconds: 0.25,
            time: "2026-11-23T23:01:02Z".into(),
            host: "node7".into(),
            version: "0.1.0".into(),
            recipe: 0xa,
        }
    }

    #[test]
    fn lines_are_read_as_they_were_written_and_torn_ones_never() {
        let line = record().to_line();
        assert_eq!(Record::from_line(&line), Some(record()));
        let body = line.trim_end();
        for end in (0..body.len()).filter(|&end| body.is_char_boundary(end)) {
            assert_eq!(Record::from_line(&body[..end]), None, "{}", &body[..end]);
        }
    }

    #[test]
    fn names_that_lead_out_of_the_folder_are_refused() {
        for name in ["", ".", "..", "../a.png", "/etc/passwd", "a\\b", "a\0"] {
            let mut record = record();
            record.files[0].name = name.into();
            assert_eq!(Record::from_line(&record.to_line()), None, "{name:?}");
        }
        assert_eq!(Record::from_line(&Record { frame: 50, ..record() }.to_line()), None, "frame 50 of 50");
        assert_eq!(Record::from_line("[]"), None);
    }

    #[test]
    fn times_are_iso_8601() {
        assert_eq!(iso_utc(UNIX_EPOCH + Duration::from_secs(951_782_400)), "2000-02-29T00:00:00Z");
    }
}
