//! Instructions of the control law, compared with the same cascade in C with CMSIS-DSP's
//! `arm_pid_f32`, compiled by `arm-none-eabi-gcc -O3`, with the same inputs on the same emulator.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

#[path = "../instructions.rs"]
mod instructions;

use cross_build::control_law_elf;
use instructions::{Counted, count};

/// Control periods in four seconds.
const STEPS: usize = 1000;

/// Tolerance of the compare values, counts of 56,000: a half that is rounded in different
/// directions.
const TOLERANCE_COUNTS: u32 = 1;

fn c_program() -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/c_reference");
    let elf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c-reference.elf");
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
    let rust = count(control_law_elf(), symbols, "COMPARE", STEPS);
    let c = count(&c_program(), symbols, "COMPARE", STEPS);
    println!("instructions of a control law, {STEPS} steps:");
    report("  model-core, Rust, 64-bit fixed point", &rust);
    report("  C, CMSIS-DSP's recurrence, single precision", &c);
    compare(&rust.results, &c.results);
}

/// Asserts that both give the same compare values, except for the rounding of single precision: its
/// 24 bits are 0.003 counts of a full duty, the integrator accumulates some of them, and if the
/// modulator's remainder is near a half, a count may occur a step earlier or later.
fn compare(rust: &[i32], c: &[i32]) {
    let differences = || rust.iter().zip(c).map(|(a, b)| a.abs_diff(*b));
    let equal = differences().filter(|difference| *difference == 0).count();
    let (worst, total) = (differences().max().unwrap_or(0), differences().count());
    let spread = rust.iter().map(|compare| compare.abs()).max().unwrap_or(0);
    println!(
        "compare values up to {spread}: {equal} of {total} equal, {worst} counts of difference at most"
    );
    assert!(
        total >= STEPS && worst <= TOLERANCE_COUNTS,
        "the control laws differ"
    );
}
