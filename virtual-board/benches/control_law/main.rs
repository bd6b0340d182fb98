//! Instructions of the control law beside the same cascade in C around CMSIS-DSP's `arm_pid_f32`,
//! compiled by `arm-none-eabi-gcc -O3`, with the same inputs on the same emulator.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

#[path = "../../../tests/src/board_elf.rs"]
#[allow(dead_code)]
mod board_elf;
mod instructions;

use board_elf::control_law_elf;
use instructions::{Counted, count};

/// Four seconds of control periods.
const STEPS: usize = 1000;

fn rival() -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/rival");
    let elf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rival.elf");
    let status = Command::new("arm-none-eabi-gcc")
        .args([
            "-O3",
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-ffreestanding",
            "-nostdlib",
        ])
        .args([
            "-mcpu=cortex-m4",
            "-mthumb",
            "-mfloat-abi=hard",
            "-mfpu=fpv4-sp-d16",
            "-T",
        ])
        .args([source.join("link.ld"), source.join("control_law.c")])
        .arg("-lgcc")
        .arg("-o")
        .arg(&elf)
        .status()
        .expect("arm-none-eabi-gcc (apt install gcc-arm-none-eabi)");
    assert!(status.success(), "the C program does not build");
    elf
}

fn report(name: &str, counted: &Counted) {
    let all = &counted.instructions;
    let mean = all.iter().sum::<u64>() as f64 / all.len() as f64;
    println!(
        "{name}: {} at most, {mean:.0} on average",
        all.iter().max().expect("a pass")
    );
}

fn main() {
    let symbols = ["control_law", "stimulus"];
    let ours = count(control_law_elf(), symbols, STEPS);
    let theirs = count(&rival(), symbols, STEPS);
    println!("instructions of a control law, {STEPS} steps:");
    report("  model-core, Rust, 64-bit fixed point", &ours);
    report("  C, CMSIS-DSP's recurrence, single precision", &theirs);
}
