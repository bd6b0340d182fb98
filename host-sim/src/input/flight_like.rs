//! A command as a flight controller gives it.

use std::f64::consts::PI;

use model_core::sensors::noise::Noise;

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
