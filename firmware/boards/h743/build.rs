//! Gives the linker of the board's program its memory map. Other targets need no arguments.
//!
//! The map has a script of its own: the script of cortex-m-rt includes `memory.x`, which a linker
//! finds in the workspace's folder first, where that of the STM32F427 is.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=h743.x");
    let for_board = env::var("CARGO_FEATURE_BOARD").is_ok();
    let on_bare_metal = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !(for_board && on_bare_metal) {
        return;
    }
    let manifest = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    // Without --nmagic the linker aligns sections to pages, which flash does not have.
    for argument in ["--nmagic", &format!("-T{manifest}/h743.x"), "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
