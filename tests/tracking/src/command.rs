//! Commands.

use core::f64::consts::{PI, TAU};

use model_core::excitation::catalogue::Input;
use model_core::sensors::noise::Noise;
use model_core::time::ticks;

/// A flight-like command, deg: moves by half a cosine within 0.4 to 0.8 s to angles of up to
/// 20 deg, held for up to 0.4 s. The motor can follow it: at most 157 deg/s and 1,234 deg/s^2.
pub fn flight_like(seed: u64) -> impl FnMut(f64) -> f64 {
    let mut chance = Noise::new(seed, 5);
    let (mut from_deg, mut to_deg) = (0.0, 0.0);
    let (mut start_s, mut moves_s, mut holds_s) = (0.0, 0.1, 0.0);
    move |time_s| {
        while time_s >= start_s + moves_s + holds_s {
            let mut uniform = || (chance.gaussian(1.0) / 3.0).clamp(-1.0, 1.0);
            start_s += moves_s + holds_s;
            from_deg = to_deg;
            to_deg = 20.0 * uniform();
            moves_s = 0.4 + 0.4 * uniform().abs();
            holds_s = 0.4 * uniform().abs();
        }
        let share = ((time_s - start_s) / moves_s).min(1.0);
        from_deg + (to_deg - from_deg) * (1.0 - (PI * share).cos()) / 2.0
    }
}

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
