//! The bootloader on the emulated board, with images whose programs are a few instructions.

use std::sync::OnceLock;

use bootloader::layout::STM32F427;
use bootloader::{ACTUATOR_BOARD, HEADER_SIZE, Header, State, Version};
use cross_build::{board_elf, boot_elf};
use program_image::signed::{Description, development_key, sign, sign_elf};
use virtual_board::run::{Finished, Firmware, Options, Script, View, run};

/// Where the programs of the images write their mark.
pub const MARK: u64 = 0x2002_0000;

/// The marks of the old and the new program.
pub const OLD: u32 = 0x0001_d0d0;
/// The mark of the new program.
pub const NEW: u32 = 0x0002_e0e0;

/// The bootloader.
///
/// # Panics
/// If it does not build.
pub fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(boot_elf()).expect("an ELF file"))
}

/// Runs the bootloader with this script, and asserts that the emulation had no gap.
///
/// # Panics
/// If it had one, or the run fails.
pub fn run_boot<S: Script + 'static>(options: Options, script: S) -> Finished<S> {
    let finished = run(firmware(), options, script).expect("the run succeeds");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    finished
}

/// A program that writes its mark and then waits for a watchdog to reset it; `padding` words follow
/// it.
pub fn program(mark: u32, padding: usize) -> Vec<u8> {
    let entry = STM32F427.slot.start() + HEADER_SIZE + 8;
    let code: [u32; 7] = [
        0x2000_1000, // initial stack pointer
        entry | 1,
        0x4903_4802, // ldr r0, [pc, #8]; ldr r1, [pc, #12]
        0xbf30_6001, // str r1, [r0]; wfi
        0xbf00_e7fd, // b to the wfi; nop
        MARK as u32,
        mark,
    ];
    let padding = (0..padding).map(|word| (word as u32).wrapping_mul(0x9e37_79b9));
    let words = code.into_iter().chain(padding);
    words.flat_map(u32::to_le_bytes).collect()
}

/// A signed image of this program.
///
/// # Panics
/// If the version is none.
pub fn image(program: &[u8], version: &str) -> Vec<u8> {
    sign(program, &description(version), &development_key())
}

fn description(version: &str) -> Description {
    Description {
        hardware: ACTUATOR_BOARD,
        version: Version::parse(version).expect("a version"),
        replaces: None,
    }
}

/// Contents of a board with an old image that runs, and a new one whose installation is requested.
///
/// # Panics
/// If the new image is none.
pub fn requested(old: &[u8], new: &[u8]) -> Vec<(u64, Vec<u8>)> {
    let identity = Header::read(new).expect("an image").identity();
    let old_version = Header::read(old).map_or(Version::default(), |header| header.version);
    let idle = State {
        floor: old_version,
        ..State::FIRST
    };
    let records = [idle.words(0), idle.request(identity).words(1)];
    let records = records.as_flattened().iter();
    vec![
        (STM32F427.slot.start().into(), old.to_vec()),
        (STM32F427.staging.start().into(), new.to_vec()),
        (
            STM32F427.records[0].start.into(),
            records.flat_map(|word| word.to_le_bytes()).collect(),
        ),
    ]
}

/// Whether the slot holds this image.
pub fn slot_holds(view: &mut View<'_>, image: &[u8]) -> bool {
    let start = u64::from(STM32F427.slot.start());
    let words = image.as_chunks::<4>().0.iter();
    (start..)
        .step_by(4)
        .zip(words)
        .all(|(address, word)| view.word(address) == Some(u32::from_le_bytes(*word)))
}

/// A signed image of the actuator's program, as it is flashed.
///
/// # Panics
/// If the program does not build, or is not linked for the slot.
pub fn actuator_image(version: &str) -> Vec<u8> {
    let elf = std::fs::read(board_elf()).expect("it is built");
    sign_elf(board_elf(), elf, &description(version), &development_key())
        .expect("linked for the slot")
}

/// Contents of a board whose confirmed image is this one.
///
/// # Panics
/// If it is no image.
pub fn installed(image: &[u8]) -> Vec<(u64, Vec<u8>)> {
    let mut contents = requested(image, image);
    contents.remove(1);
    contents[1].1.truncate(32);
    contents
}
