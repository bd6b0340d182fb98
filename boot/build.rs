//! Gives the linker of the bootloader its memory map, and the program its public key. Other targets
//! need neither.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The file of the public key: 64 hexadecimal digits.
const KEY: &str = "ACTUATOR_PUBLIC_KEY";

/// Bytes of flash for the bootloader: sectors 0 and 1.
const SIZE: u32 = 32 << 10;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../memory.x");
    println!("cargo::rerun-if-env-changed={KEY}");
    let for_board = env::var("CARGO_FEATURE_BOARD").is_ok();
    let on_bare_metal = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !(for_board && on_bare_metal) {
        return;
    }
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let key = match env::var_os("CARGO_FEATURE_DEVELOPMENT_KEY") {
        Some(_) => "bootloader::DEVELOPMENT_KEY".to_owned(),
        None => own_key(),
    };
    fs::write(folder.join("key.rs"), key).expect("the folder is cargo's");
    let manifest = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-link-search={manifest}/..");
    println!("cargo::rustc-link-arg-bins=--defsym=_flash_size={SIZE:#x}");
    for argument in ["--nmagic", "-Tlink.x"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}

/// The public key that the environment names, as an expression.
fn own_key() -> String {
    let Some(path) = env::var_os(KEY) else {
        panic!(
            "the bootloader needs the public key of its images: make a pair with `cargo run -- \
             image key FILE` and set {KEY} to FILE.pub, or build for development with `--features \
             development-key`, whose key is public"
        );
    };
    println!("cargo::rerun-if-changed={}", Path::new(&path).display());
    let text = fs::read_to_string(&path);
    let text = text.unwrap_or_else(|error| panic!("{KEY}: {}: {error}", path.display()));
    let digits = text.trim();
    let development = "772cb4770411c62d72ef1fed6f56e33eea185491c952a37d07c659d7f3133b93";
    assert!(
        digits != development,
        "{}: that is the development key, which is public",
        path.display()
    );
    let byte = |at: usize| {
        let pair = digits.get(2 * at..2 * at + 2);
        pair.and_then(|pair| u8::from_str_radix(pair, 16).ok())
    };
    let bytes: Option<Vec<u8>> = (0..32).map(byte).collect();
    let bytes = bytes.filter(|_| digits.len() == 64).unwrap_or_else(|| {
        panic!(
            "{}: no key, which has 64 hexadecimal digits",
            path.display()
        )
    });
    format!("bootloader::Key({bytes:?})")
}
