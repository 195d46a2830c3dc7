//! The Python package that sheets of the Python framework need: found before anything is run.

use super::watch::{self, End, Limits, Said};
use std::ffi::OsStr;
use std::process::{Command, Stdio};
use std::time::Duration;

const LIMITS: Limits = Limits {
    time: Duration::from_secs(30),
    memory: 1 << 30,
    processes: 64,
    output: 1 << 12,
    ends_by_output: false,
    said: Said::Last,
};
/// Prints the first module that is missing.
const FIND: &str = "\
import sys
from importlib.util import find_spec
for name in sys.argv[1:]:
    if find_spec(name) is None:
        print(name)
        break
";

/// Checks that an interpreter has what the framework's programs are run by, and where there are textures
/// what reads them.
///
/// # Errors
/// The package that is missing, and the command that installs it.
pub fn check(python: &OsStr, has_textures: bool) -> Result<(), String> {
    let name = python.display();
    let mut command = Command::new(python);
    command.args(["-c", FIND, "fbptr", "fbptr.course", "numpy"]).stdin(Stdio::null());
    if has_textures {
        command.arg("PIL");
    }
    let watched = watch::run(&mut command, LIMITS).map_err(|e| format!("{name}: {e}"))?;
    let missing = String::from_utf8_lossy(&watched.stdout).trim().to_owned();
    let is_good = matches!(watched.end, End::Exited(status) if status.success());
    match (is_good, missing.as_str()) {
        (true, "") => Ok(()),
        (true, "PIL") => {
            Err(format!("the sheet has textures, and {name} has no Pillow: {name} -m pip install pillow"))
        }
        (true, _) => Err(format!(
            "the sheet needs the Python package fbptr with numpy, and {name} has no {missing}: {name} -m pip install \
             'fbptr[numpy]' (from its sources: './python[numpy]')"
        )),
        (false, _) => Err(format!("{name}: it is no Python 3 that runs")),
    }
}
