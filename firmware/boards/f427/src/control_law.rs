//! The control law in a loop, so that an emulator can count its instructions.
//!
//! `stimulus` and [`control_law`] alternate; `virtual-board/benches/c_reference/control_law.c` does
//! the same in C with the same inputs.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "symbols for the emulator, and a panic handler that does not link"
)]

use core::sync::atomic::{AtomicI32, Ordering::Relaxed};

use cortex_m_rt::entry;
use model_core::{
    control::{
        cascade::{CascadeState, Coefficients},
        encoder_word::{EncoderCount, EncoderWord, Magnet},
        parameters::ControlParameters,
        pwm_timer::Modulator,
        units::Angle,
    },
    time::CONTROL_PERIOD_S,
};
// Links the interrupt vectors.
use stm32f4xx_hal as _;

/// The defaults except for the anti-windup gain: the integrator follows the limited output within
/// one period, as in a recurrence that continues from its limited output.
const PARAMETERS: ControlParameters = ControlParameters {
    anti_windup_gain: 1.0 / CONTROL_PERIOD_S,
    ..ControlParameters::DEFAULT
};

const COEFFICIENTS: Coefficients = match Coefficients::try_new(&PARAMETERS) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the parameters are within their ranges"),
};

/// The last compare value.
#[unsafe(no_mangle)]
static COMPARE: AtomicI32 = AtomicI32::new(0);

/// The function whose instructions are counted: encoder word and command to compare value.
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

/// Inputs of a step: the shaft moves over 400 counts in a triangle of 500 steps, across zero; the
/// command alternates between 20 and -20 deg every 200 steps.
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
