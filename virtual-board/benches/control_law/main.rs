//! Instructions of the control law beside the same cascade in C around CMSIS-DSP's `arm_pid_f32`,
//! compiled by `arm-none-eabi-gcc -O3`, with the same inputs on the same emulator.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

mod instructions;

use cross_build::control_law_elf;
use instructions::{Counted, count};

/// Four seconds of control periods.
const STEPS: usize = 1000;

/// Counts of 56,000 that the decisions may be apart: a half that one rounds up and the other down.
const FURTHEST: u32 = 1;

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
    compare(&ours.compares, &theirs.compares);
}

/// Both decide the same, but for what single precision rounds: its 24 bits are 0.003 counts of a
/// full duty, the integrator sums some of them up, and where the modulator's remainder is near a
/// half, its count comes a step earlier or later.
fn compare(ours: &[i32], theirs: &[i32]) {
    let apart = || ours.iter().zip(theirs).map(|(a, b)| a.abs_diff(*b));
    let equal = apart().filter(|apart| *apart == 0).count();
    let (worst, total) = (apart().max().unwrap_or(0), apart().count());
    let spread = ours.iter().map(|compare| compare.abs()).max().unwrap_or(0);
    println!(
        "compare values up to {spread}: {equal} of {total} equal, {worst} counts apart at most"
    );
    assert!(
        total >= STEPS && worst <= FURTHEST,
        "they are not the same law"
    );
}
