//! Gives the linker of the boards' programs the memory map. Other targets need no arguments.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../../memory.x");
    let for_board = std::env::var("CARGO_FEATURE_BOARD").is_ok();
    let on_bare_metal = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !(for_board && on_bare_metal) {
        return;
    }
    let manifest = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-link-search={manifest}/../../..");
    // Without --nmagic the linker aligns sections to pages, which flash does not have.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
