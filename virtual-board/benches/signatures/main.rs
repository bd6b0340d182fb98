//! Flash and instructions of a check of a signature, Ed25519, by `salty` and by `ed25519-dalek`, in
//! programs that do nothing else, built as the bootloader is.
//!
//!     cargo bench -p virtual-board --bench signatures --ignore-rust-version

use std::path::Path;

use cross_build::signature_checks_elf;
use object::{Object as _, ObjectSection as _};

#[path = "../instructions.rs"]
mod instructions;

use instructions::{Counted, count};

/// The signed message and another one, twice.
const PASSES: usize = 4;

/// Bytes of code and constants, without the vectors.
fn flash_bytes(elf: &Path) -> u64 {
    let bytes = std::fs::read(elf).expect("the program");
    let file = object::File::parse(&*bytes).expect("an ELF");
    let sections = [".text", ".rodata", ".data"].map(|name| file.section_by_name(name));
    sections
        .iter()
        .flatten()
        .map(|section| section.size())
        .sum()
}

fn main() {
    for library in ["salty", "dalek"] {
        let elf = signature_checks_elf(library);
        let Counted {
            instructions,
            results,
        } = count(&elf, ["verify", "next_message"], "DECISION", PASSES);
        assert_eq!(results, [1, 0, 1, 0], "{library}");
        println!(
            "{library}: {} bytes of flash, {} instructions",
            flash_bytes(&elf),
            instructions.iter().max().expect("a pass")
        );
    }
}
