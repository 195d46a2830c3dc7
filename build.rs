//! Says whether the program carries the preload library of `fbptr run`, which `fbptr-desktop` builds.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(fbptr_preload)");
    if std::env::var_os("DEP_FBPTR_PRELOAD_IS_BUILT").is_some() {
        println!("cargo::rustc-cfg=fbptr_preload");
    }
}
