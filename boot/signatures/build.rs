//! Gives the linker of the programs their memory map. Other targets need none.

use std::env;

/// Bytes of flash: more than those of the bootloader, in which one of them does not fit.
const SIZE: u32 = 64 << 10;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        let manifest = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
        println!("cargo::rustc-link-search={manifest}/../..");
        println!("cargo::rustc-link-arg-bins=--defsym=_flash_size={SIZE:#x}");
        for argument in ["--nmagic", "-Tlink.x"] {
            println!("cargo::rustc-link-arg-bins={argument}");
        }
    }
}
