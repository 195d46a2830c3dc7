//! Says whether the program carries the preload library of `fbptr run`, which `fbptr-desktop` builds,
//! and compresses the playground's page for it.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(fbptr_preload)");
    if std::env::var_os("DEP_FBPTR_PRELOAD_IS_BUILT").is_some() {
        println!("cargo::rustc-cfg=fbptr_preload");
    }
    #[cfg(feature = "cli")]
    pack_page();
}

#[cfg(feature = "cli")]
fn pack_page() {
    use std::io::Write;

    let page = "docs/playground/index.html";
    println!("cargo::rerun-if-changed={page}");
    let text = std::fs::read(page).expect("the page is there");
    let out = std::env::var("OUT_DIR").expect("cargo sets it");
    let packed = std::fs::File::create(format!("{out}/playground.html.gz")).expect("a file in its folder");
    let mut packer = flate2::write::GzEncoder::new(packed, flate2::Compression::best());
    packer.write_all(&text).and_then(|()| packer.finish()).expect("a compressed file");
}
