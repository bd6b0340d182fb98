//! Gives the linker of the boards' programs the memory map. Other targets need no arguments.

use std::env;

use bootloader::{HEADER_SIZE, layout::STM32F427};

/// The program that the bootloader starts. All others run without it, from the start of the flash.
const IN_SLOT: &str = "actuator-board";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../../memory.x");
    let for_board = env::var("CARGO_FEATURE_BOARD").is_ok();
    let on_bare_metal = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !(for_board && on_bare_metal) {
        return;
    }
    let manifest = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-link-search={manifest}/../../..");
    let slot = &STM32F427.slot;
    for (symbol, value) in [
        ("_flash_start", slot.start() + HEADER_SIZE),
        ("_flash_size", slot.size() - HEADER_SIZE),
    ] {
        println!("cargo::rustc-link-arg-bin={IN_SLOT}=--defsym={symbol}={value:#x}");
    }
    // Without --nmagic the linker aligns sections to pages, which flash does not have.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
