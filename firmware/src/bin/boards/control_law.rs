//! The control law alone, over and over, so that its instructions can be counted on an emulator.
//!
//! `stimulus` and [`control_law`] follow each other; `virtual-board/benches/rival/control_law.c` does the same with
//! the same inputs.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "two symbols for the emulator, and a panic handler that does not link"
)]

use core::sync::atomic::{AtomicI32, Ordering::Relaxed};

use cortex_m_rt::entry;
use model_core::{
    control::{
        cascade::{CascadeState, Coefficients},
        encoder_word::{EncoderCount, EncoderWord, Magnet},
        parameters::ControlParameters,
        units::Angle,
    },
    plant::pwm_timer::Modulator,
};
// The vectors of its interrupts.
use stm32f4xx_hal as _;

/// The defaults, but for the anti-windup: what the limits cut off is taken back within one period, as
/// by a recurrence that goes on from its limited output.
const PARAMETERS: ControlParameters = ControlParameters {
    anti_windup_gain: 250.0,
    ..ControlParameters::DEFAULT
};

const COEFFICIENTS: Coefficients = match Coefficients::try_new(&PARAMETERS) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("they are within their ranges"),
};

/// The last decision, counts of the timer.
#[unsafe(no_mangle)]
static COMPARE: AtomicI32 = AtomicI32::new(0);

/// What is being counted: an encoder's word and a command to a compare value.
#[unsafe(no_mangle)]
#[inline(never)]
fn control_law(
    (state, modulator): &mut (CascadeState, Modulator),
    word: EncoderWord,
    command: Angle,
) -> i32 {
    let count = word.read().ok().map(|reading| reading.count);
    state.observe(&COEFFICIENTS, count);
    let step = state.regulate(&COEFFICIENTS, command);
    modulator.next(step.duty).get()
}

/// Inputs of a step: the shaft turns to and fro by 400 counts in 2 s, over its zero; the command jumps
/// between 20 and -20 deg every 0.8 s.
#[unsafe(no_mangle)]
#[inline(never)]
fn stimulus(step: u32) -> (EncoderWord, Angle) {
    let phase = step % 500;
    let count = if phase < 250 { phase } else { 500 - phase } as u16;
    let word = EncoderWord::of(
        EncoderCount::new((count * 8 / 5).wrapping_sub(200)),
        Magnet::Steady,
    );
    let command = Angle::from_int(if (step / 200).is_multiple_of(2) {
        20
    } else {
        -20
    });
    (word, command)
}

#[entry]
fn main() -> ! {
    let mut state = Default::default();
    let mut step = 0u32;
    loop {
        let (word, command) = stimulus(step);
        COMPARE.store(control_law(&mut state, word, command), Relaxed);
        step = step.wrapping_add(1);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn a_path_to_a_panic_remains() -> !;
    }
    a_path_to_a_panic_remains()
}
