//! Angles that begin again after a turn, and commands that are whole turns from them.

/// Change from sample to sample above which an angle has wrapped around.
const WRAP_DEG: f64 = 270.0;
/// Distance of a jump from a whole turn, deg, and in the fastest other motion from sample to
/// sample, within which it is a wrap and not a motion.
const NEAR_DEG: f64 = 20.0;
const NEAR: f64 = 2.0;
/// Range of an angle that begins again after a turn, with noise at both ends.
const TURN_DEG: f64 = 370.0;
/// One value in this number may be bad at either end of the range.
const BAD_SHARE: usize = 200;

/// Unwraps an angle. Returns the first wrap and the number of wraps.
pub fn unwrap(angle_deg: &mut [f64]) -> Option<(usize, usize)> {
    if !is_within_a_turn(angle_deg) {
        return None;
    }
    let (mut first, mut times) = (None, 0);
    let (mut offset_deg, mut before) = (0.0, f64::NAN);
    let present = angle_deg.iter().filter(|angle| !angle.is_nan());
    let moves = present
        .clone()
        .zip(present.skip(1))
        .map(|(a, b)| (b - a).abs());
    let fastest = moves.filter(|moved| *moved <= WRAP_DEG).fold(0.0, f64::max);
    let near_deg = NEAR_DEG + NEAR * fastest;
    for (index, angle) in angle_deg.iter_mut().enumerate() {
        if angle.is_nan() {
            continue;
        }
        let raw = *angle;
        let jump = (raw - before).abs();
        // The first sample has no predecessor.
        if jump > WRAP_DEG && (360.0 - jump).abs() < near_deg {
            offset_deg -= 360.0 * ((raw - before) / 360.0).round();
            first = first.or(Some(index));
            times += 1;
        }
        before = raw;
        *angle = raw + offset_deg;
    }
    first.map(|first| (first, times))
}

/// A command moved by the whole turns that bring it closest to the angle, its mean distance, and
/// the turns.
pub fn nearest(command_deg: &[f64], angle_deg: &[f64]) -> (Vec<f64>, f64, f64) {
    let distance = |turns: f64| {
        let pairs = command_deg.iter().zip(angle_deg);
        let differences = pairs.map(|(command, angle)| (command + 360.0 * turns - angle).abs());
        let present = differences.filter(|difference| !difference.is_nan());
        let (sum, count) = present.fold((0.0, 0.0), |(sum, n), d| (sum + d, n + 1.0));
        sum / count
    };
    let turns = [0.0, -1.0, 1.0].into_iter();
    let best = turns.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let turns = best.unwrap_or(0.0);
    let moved = command_deg.iter().map(|command| command + 360.0 * turns);
    (moved.collect(), distance(turns), turns)
}

/// Whether the values, but for a few bad ones, are those of an angle that begins again after a
/// turn.
fn is_within_a_turn(angle_deg: &[f64]) -> bool {
    let present = angle_deg.iter().copied().filter(|angle| !angle.is_nan());
    let mut sorted: Vec<f64> = present.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let bad = sorted.len() / BAD_SHARE;
    let inner = &sorted[bad..sorted.len() - bad];
    let range_deg = inner.last().unwrap_or(&0.0) - inner.first().unwrap_or(&0.0);
    range_deg < TURN_DEG
}
