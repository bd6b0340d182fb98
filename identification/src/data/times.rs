//! Times as loggers write them: without a unit, and by a clock that is coarser than the samples.

use crate::statistics::slots::median_step_s;

/// Fewest samples that tell the unit.
const FEWEST: usize = 50;
/// Shortest step, s, that is too long for the motion of an actuator.
const TOO_LONG_S: f64 = 0.5;
/// Longest step of samples of a motion, s.
const LONGEST_S: f64 = 0.25;
/// Units of times below a second, with their factors.
const UNITS: [(&str, f64); 3] = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
/// Share of rows with the time of the row before from which the clock is coarse.
const COARSE: f64 = 0.2;

/// The unit of times whose steps are too long for seconds: the longest with which they are not.
///
/// 5,000 samples of a motion a second apart are milliseconds.
pub fn unit(column: &[f64]) -> Option<(&'static str, f64)> {
    let times: Vec<f64> = column
        .iter()
        .copied()
        .filter(|time| time.is_finite())
        .collect();
    let (first, last) = (times.first()?, times.last()?);
    // The median ignores gaps, the mean a clock that rests.
    let mean = (last - first) / times.len() as f64;
    let step = median_step_s(&times)?.min(mean);
    if times.len() < FEWEST || step < TOO_LONG_S {
        return None;
    }
    let is_plausible = |(_, factor): &(&str, f64)| step * factor < LONGEST_S;
    UNITS.into_iter().find(is_plausible)
}

/// Spreads samples with equal times evenly up to the next time, if they are many and the angle
/// changes between them. Returns how many have the time of the row before.
pub fn spread(times: &mut [f64], angle: &[f64]) -> Option<usize> {
    let repeats = (1..times.len()).filter(|&i| times[i] == times[i - 1]);
    let repeats: Vec<usize> = repeats.collect();
    let moves = |&&i: &&usize| angle.get(i) != angle.get(i - 1);
    let moved = repeats.iter().filter(moves).count();
    if (repeats.len() as f64) < COARSE * times.len() as f64 || 2 * moved < repeats.len() {
        return None;
    }
    let mut start = 0;
    let mut step = 0.0;
    while start < times.len() {
        let equal = times[start..]
            .iter()
            .take_while(|time| **time == times[start]);
        let end = start + equal.count().max(1);
        if let Some(next) = times.get(end) {
            step = (next - times[start]) / (end - start) as f64;
        }
        for (place, time) in times[start..end].iter_mut().enumerate() {
            *time += step * place as f64;
        }
        start = end;
    }
    Some(repeats.len())
}
