//! Compresses the script of the tour, which the program carries, and compiles the preload library of
//! `fbptr run` (`preload/lib.rs`) for Linux with the GNU C library, which it carries too. Elsewhere
//! nothing is compiled. The cfg `fbptr_preload` says that there is one; crates above read it as
//! `DEP_FBPTR_PRELOAD_IS_BUILT`.

use std::env;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=preload");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(fbptr_preload)");
    let script = "src/viewer/tour/steps.fbs";
    println!("cargo::rerun-if-changed={script}");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    pack(Path::new(script), &out.join("steps.fbs.gz"));
    let set = |name: &str| env::var(name).unwrap_or_default();
    let is_known = ["x86_64", "aarch64", "riscv64"].contains(&&*set("CARGO_CFG_TARGET_ARCH"));
    // Without a linker for another architecture the program cannot be linked either, only checked.
    let is_linked = set("TARGET") == set("HOST") || env::var_os("RUSTC_LINKER").is_some();
    if !is_linked
        || set("CARGO_CFG_TARGET_OS") != "linux"
        || set("CARGO_CFG_TARGET_ENV") != "gnu"
        || !is_known
    {
        return;
    }
    compile(&out.join("fbptr_preload.so"), &[]);
    // The name by which the loader knows a library that a program was linked with.
    compile(&out.join("fbptr_glut.so"), &["--cfg", "glut", "-C", "link-arg=-Wl,-soname,libglut.so.3"]);
    println!("cargo::rustc-cfg=fbptr_preload");
    println!("cargo::metadata=is_built=1");
}

/// Compiles the preload library, with options for one of its variants.
fn compile(out: &Path, options: &[&str]) {
    let mut rustc = Command::new(env::var_os("RUSTC").expect("cargo sets it"));
    rustc.args(["--edition", "2024", "--crate-type", "cdylib", "--crate-name", "fbptr_preload"]);
    let target = env::var("TARGET").unwrap_or_default();
    rustc
        .args(["--target", &target, "--check-cfg", "cfg(glut)", "preload/lib.rs", "-o"])
        .arg(out)
        .args(options);
    // All of `core` is optimized with it, which leaves 110 kB and no symbol of Rust's runtime.
    for option in ["panic=abort", "opt-level=2", "lto=fat", "codegen-units=1", "debuginfo=0", "strip=symbols"]
    {
        rustc.args(["-C", option]);
    }
    if let Some(linker) = env::var_os("RUSTC_LINKER") {
        let mut option = std::ffi::OsString::from("linker=");
        option.push(linker);
        rustc.arg("-C").arg(option);
    }
    let status = rustc.status().expect("rustc starts");
    assert!(status.success(), "the preload library does not compile: {status}");
    pack(out, &out.with_extension("so.gz"));
}

/// Writes a file's contents as gzip.
fn pack(file: &Path, packed: &Path) {
    let contents = std::fs::read(file).expect("the file is there");
    let packed = std::fs::File::create(packed).expect("a file in the build's folder");
    let mut packer = flate2::write::GzEncoder::new(packed, flate2::Compression::best());
    packer.write_all(&contents).and_then(|()| packer.finish()).expect("a compressed file");
}
