//! `fbptr config`: the options by which a compiler finds headers and libraries of GLUT and OpenGL,
//! as far as `fbptr run` serves them. They travel in this program, and are written to a folder of
//! the user's cache once.

#[cfg(fbptr_preload)]
use super::super::output;
use super::super::{Status, say_as_program};
use clap::Args;
#[cfg(fbptr_preload)]
use std::path::{Path, PathBuf};

/// Print the options that compile a program of GLUT without GL: g++ main.cpp $(fbptr config --cflags --libs)
#[derive(Debug, Args)]
pub struct Config {
    /// Print the compiler's options
    #[arg(long)]
    cflags: bool,
    /// Print the linker's options
    #[arg(long)]
    libs: bool,
    /// Print lines for a shell, for programs with a Makefile: eval "$(fbptr config --env)" && make
    #[arg(long)]
    env: bool,
}

/// Headers, and the paths below `include` at which they are written.
#[cfg(fbptr_preload)]
macro_rules! headers {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../../clients/c/include/", $name)))),*]
    };
}

#[cfg(fbptr_preload)]
const HEADERS: &[(&str, &str)] = headers! {
    "GL/gl.h" "GL/glu.h" "GL/glut.h" "GL/freeglut.h" "GL/glew.h" "GL/freeglut_std.h" "GL/freeglut_ext.h" "GLUT/glut.h"
    "OpenGL/gl.h" "OpenGL/glu.h" "windows.h" "Windows.h" "conio.h" "Math.h" "Stdlib.h"
};

/// Names by which programs link the library: those of GLUT and OpenGL, of the libraries below them,
/// and those of another system.
#[cfg(fbptr_preload)]
const LINKS: [&str; 12] =
    ["glut", "GL", "GLU", "freeglut", "X11", "Xi", "Xmu", "Xext", "opengl32", "glu32", "glut32", "GLEW"];

impl Config {
    /// Prints the options.
    pub(in super::super) fn run(self) -> Status {
        #[cfg(fbptr_preload)]
        match folder() {
            Ok(folder) => {
                output::print(self.text(&folder));
                output::ended(Status::Success)
            }
            Err(error) => {
                say_as_program(error);
                Status::Failed
            }
        }
        #[cfg(not(fbptr_preload))]
        {
            say_as_program("config: GLUT is served on Linux with the GNU C library only");
            Status::Failed
        }
    }

    #[cfg(fbptr_preload)]
    fn text(&self, folder: &Path) -> String {
        let (include, lib) = (folder.join("include"), folder.join("lib"));
        let mut words = Vec::new();
        if self.cflags {
            words.push(format!("-I{}", include.display()));
        }
        if self.libs {
            words.push(format!("-L{} -lglut -lGLU -lGL", lib.display()));
        }
        let mut text = words.join(" ");
        if !text.is_empty() {
            text.push('\n');
        }
        if self.env {
            for (name, value) in [("CPATH", include), ("LIBRARY_PATH", lib)] {
                text += &format!("export {name}='{}'\"${{{name}:+:${name}}}\"\n", value.display());
            }
        }
        if text.is_empty() { format!("{}\n", folder.display()) } else { text }
    }
}

/// Returns the folder with `include` and `lib`, written if it is not there.
///
/// # Errors
/// The path that cannot be written.
#[cfg(fbptr_preload)]
pub fn folder() -> Result<PathBuf, String> {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".cache"));
    let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = cache.or_else(home).unwrap_or_else(std::env::temp_dir).join("fbptr");
    let library = crate::fbdev::preload_library(true).map_err(|e| e.to_string())?;
    let mut sum = crc32fast::Hasher::new();
    sum.update(&library);
    HEADERS.iter().for_each(|(name, text)| [name, text].iter().for_each(|part| sum.update(part.as_bytes())));
    let folder = cache.join(format!("glut-{}-{:08x}", env!("CARGO_PKG_VERSION"), sum.finalize()));
    if folder.is_dir() {
        return Ok(folder);
    }
    // Written beside its place and renamed: it is whole, or not there.
    let new = cache.join(format!("glut-{}", std::process::id()));
    write(&new, &library).map_err(|e| format!("{}: {e}", new.display()))?;
    match std::fs::rename(&new, &folder) {
        Ok(()) => Ok(folder),
        // Another process has written it meanwhile.
        Err(_) if folder.is_dir() => {
            let _ = std::fs::remove_dir_all(&new);
            Ok(folder)
        }
        Err(e) => Err(format!("{}: {e}", folder.display())),
    }
}

#[cfg(fbptr_preload)]
fn write(folder: &Path, library: &[u8]) -> std::io::Result<()> {
    for (name, text) in HEADERS {
        let path = folder.join("include").join(name);
        std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
        std::fs::write(path, text)?;
    }
    let lib = folder.join("lib");
    std::fs::create_dir_all(&lib)?;
    std::fs::write(lib.join("libglut.so.3"), library)?;
    LINKS
        .iter()
        .try_for_each(|name| std::os::unix::fs::symlink("libglut.so.3", lib.join(format!("lib{name}.so"))))
}
