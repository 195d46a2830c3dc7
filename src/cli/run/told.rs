//! Lines for the user about requests of programs that were refused.

use super::super::say_as_program;
use crate::fbdev::Device;
use std::collections::HashSet;

/// Most programs without the device that are told.
const PROGRAMS: usize = 64;

/// The refusals told so far.
#[derive(Debug, Default)]
pub struct Told {
    /// Number of refused requests.
    requests: u32,
    /// Number of programs without the device, and the lines about them.
    programs: u32,
    lines: HashSet<String>,
}

impl Told {
    /// Tells which programs cannot have the device, each once, and which requests it does not have
    /// if that is wanted.
    pub fn tell(&mut self, device: &Device, is_verbose: bool) {
        for line in device.unserved_programs(&mut self.programs) {
            if self.lines.len() < PROGRAMS && self.lines.insert(line.clone()) {
                say_as_program(line);
            }
        }
        if is_verbose {
            device.refused_requests(&mut self.requests).into_iter().for_each(say_as_program);
        }
    }
}
