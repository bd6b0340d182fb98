//! The control step as functions that are not inlined into others, so that each exists in the
//! compiler's intermediate code, from which `assurance/proofs/overflow/` proves that nothing
//! overflows.
//!
//! They are compiled for the board, so that the digits of the Cortex-M4's product are what is
//! proved.

#![no_std]
#![forbid(unsafe_code)]

use model_core::control::{
    cascade::{CascadeState, CascadeStep, Coefficients, Setpoint},
    encoder_word::{EncoderCount, EncoderError, EncoderReading, EncoderWord},
    pwm_timer::Modulator,
    units::{Percent, Rate},
};

/// The state of a start.
pub fn start() -> CascadeState {
    CascadeState::default()
}

/// The default coefficients.
pub fn defaults() -> Coefficients {
    Coefficients::DEFAULT
}

/// [`Coefficients::set`].
pub fn set(coefficients: &mut Coefficients, row: usize, bits: u32) -> bool {
    coefficients.set(row, f32::from_bits(bits))
}

/// [`Coefficients::get`], as bits; zero beyond the last row.
pub fn get(coefficients: &Coefficients, row: usize) -> u32 {
    coefficients.get(row).unwrap_or(0.0).to_bits()
}

/// [`EncoderWord::read`].
pub fn read(bits: u32) -> Result<EncoderReading, EncoderError> {
    EncoderWord::new(bits).read()
}

/// [`CascadeState::observe`].
pub fn observe(state: &mut CascadeState, gains: &Coefficients, count: Option<EncoderCount>) {
    state.observe(gains, count);
}

/// [`CascadeState::observe`] of any count.
pub fn observe_count(state: &mut CascadeState, gains: &Coefficients, count: u16) {
    observe(state, gains, Some(EncoderCount::new(count)));
}

/// [`CascadeState::regulate`].
pub fn regulate(state: &mut CascadeState, gains: &Coefficients, to: Setpoint) -> CascadeStep {
    state.regulate(gains, to)
}

/// [`CascadeState::decelerate`].
pub fn decelerate(state: &mut CascadeState, gains: &Coefficients, rate: Rate) -> CascadeStep {
    state.decelerate(gains, rate)
}

/// [`CascadeState::retune`].
pub fn retune(state: &mut CascadeState, old: &Coefficients, new: &Coefficients) {
    state.retune(old, new);
}

/// [`CascadeState::miss`].
pub fn miss(state: &mut CascadeState, periods: u16) {
    state.miss(periods);
}

/// [`CascadeState::release`].
pub fn release(state: &mut CascadeState) {
    state.release();
}

/// [`CascadeState::reset_position`].
pub fn reset_position(state: &mut CascadeState) {
    state.reset_position();
}

/// The measured angle in steps of 2^-32 deg.
pub fn measured_angle(state: &CascadeState) -> i64 {
    state.angle().to_bits()
}

/// The estimated rate in steps of 2^-32 deg/s.
pub fn measured_rate(state: &CascadeState) -> i64 {
    state.rate().to_bits()
}

/// The modulator at a start.
pub fn modulator() -> Modulator {
    Modulator::default()
}

/// [`Modulator::next`].
pub fn compare(modulator: &mut Modulator, duty: Percent) -> i32 {
    modulator.next(duty).get()
}
