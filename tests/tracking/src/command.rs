//! Commands.

use core::f64::consts::TAU;

use model_core::excitation::catalogue::Input;
use model_core::time::ticks;

/// A sine of this amplitude and frequency, deg.
pub fn sine(amplitude_deg: f64, frequency_hz: f64) -> impl FnMut(f64) -> f64 {
    move |time_s| amplitude_deg * (TAU * frequency_hz * time_s).sin()
}

/// A standard input, with its default parameters, deg.
///
/// # Panics
/// If no input has this name.
pub fn standard(name: &str) -> impl FnMut(f64) -> f64 {
    let input = Input::named(name).and_then(|input| input.excitation().ok());
    let input = input.expect("a standard input");
    move |time_s| input.command(ticks(time_s)).to_f64()
}
