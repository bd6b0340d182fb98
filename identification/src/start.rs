//! Starting values from the recordings.
//!
//! The lag of the angle behind the command is the shift at which a straight line through command
//! and angle fits best; that line gives gain and offset. The rate limits are slopes at which a
//! tenth of the whole path is travelled, after a running median of five samples: neither a bad
//! reading nor one steep sample moves them. The lag is divided between delay and dynamics: half
//! each in a first-order model.

use super::experiment::Experiment;

/// Properties of recordings that a regression finds without a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataSummary {
    /// Steady angle per command.
    pub gain: f64,
    /// Steady angle at a command of zero, deg.
    pub offset_deg: f64,
    /// Lag of the angle behind the command, s.
    pub lag_s: f64,
    /// Delay of a first-order model, s.
    pub delay_s: f64,
    /// Its pole, rad/s.
    pub pole_rad_s: f64,
    /// Delay of a second-order model, s.
    pub second_order_delay_s: f64,
    /// Its undamped natural frequency, rad/s.
    pub natural_frequency_rad_s: f64,
    /// Its damping ratio.
    pub damping: f64,
    /// A steep slope upward, deg/s.
    pub rate_up_deg_s: f64,
    /// A steep slope downward, deg/s.
    pub rate_down_deg_s: f64,
    /// Angle at the first sample of the first recording, deg.
    pub initial_angle_deg: f64,
    /// Rate there, deg/s.
    pub initial_rate_deg_s: f64,
}

/// Shifts that are tried, s: finer in the range of servos.
const LAGS: usize = 40;
const LONGEST_LAG_S: f64 = 0.6;

/// Samples that are used of each recording.
const MOST_SAMPLES: usize = 2000;

/// The largest magnitude of a measured angle, deg.
pub fn greatest_angle_deg(experiments: &[Experiment]) -> f64 {
    let angles = experiments.iter().flat_map(|e| &e.recording.angle_deg);
    angles.fold(0.0, |greatest: f64, angle| greatest.max(angle.abs()))
}

impl DataSummary {
    /// The summary of at least one recording.
    pub fn of(experiments: &[Experiment]) -> Self {
        let points: Vec<Vec<Point>> = experiments.iter().map(points).collect();
        let lags = (0..LAGS).map(|i| LONGEST_LAG_S * (i as f64 / (LAGS - 1) as f64).powi(2));
        let lines = lags.map(|lag_s| (lag_s, line(experiments, &points, lag_s)));
        let best = lines.min_by(|a, b| a.1.error.total_cmp(&b.1.error));
        let (lag_s, line) = best.unwrap_or((0.0, Line::default()));
        let lag_s = lag_s.max(4e-3);
        let (up, down) = steep(&points);
        let first = points.first().and_then(|p| p.first());
        Self {
            gain: line.gain,
            offset_deg: line.offset_deg,
            lag_s,
            delay_s: 0.5 * lag_s,
            pole_rad_s: 2.0 / lag_s,
            second_order_delay_s: 0.3 * lag_s,
            // The lag of an oscillator is 2 zeta/wn.
            natural_frequency_rad_s: 2.0 * 0.9 / (0.7 * lag_s),
            damping: 0.9,
            rate_up_deg_s: up,
            rate_down_deg_s: down,
            initial_angle_deg: first.map_or(0.0, |p| p.angle_deg),
            initial_rate_deg_s: 0.0,
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Point {
    time_ns: i64,
    angle_deg: f64,
}

/// Samples that have an angle while the motor is on, evenly thinned.
fn points(run: &Experiment) -> Vec<Point> {
    let recording = &run.recording;
    let is_on = |i: &usize| recording.motor_on.as_ref().is_none_or(|on| on[*i] != 0.0);
    let point = |i: usize| Point {
        time_ns: run.time_ns[i],
        angle_deg: median_around(&recording.angle_deg, i),
    };
    let has_angle = |i: &usize| !recording.angle_deg[*i].is_nan();
    let all = || (0..run.len()).filter(is_on).filter(has_angle);
    let every = all().count().div_ceil(MOST_SAMPLES).max(1);
    all().step_by(every).map(point).collect()
}

/// The median of an angle, two before and two after it, which keeps ramps and edges and drops one
/// or two bad readings; fewer at the ends. NaN where the angle is missing.
fn median_around(angle_deg: &[f64], i: usize) -> f64 {
    if angle_deg[i].is_nan() {
        return f64::NAN;
    }
    // As many on either side, so that a ramp is kept.
    let side = i.min(angle_deg.len() - 1 - i).min(2);
    let around = &angle_deg[i - side..=i + side];
    let mut numbers = [0.0; 5];
    let mut count = 0;
    for angle in around.iter().filter(|a| !a.is_nan()) {
        numbers[count] = *angle;
        count += 1;
    }
    let numbers = &mut numbers[..count];
    numbers.sort_unstable_by(f64::total_cmp);
    // Of an even number, the one that is nearer to the angle itself.
    let middle = [numbers[(count - 1) / 2], numbers[count / 2]];
    if (middle[0] - angle_deg[i]).abs() < (middle[1] - angle_deg[i]).abs() {
        middle[0]
    } else {
        middle[1]
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Line {
    gain: f64,
    offset_deg: f64,
    error: f64,
}

/// The line through shifted command and angle with the least squares.
fn line(experiments: &[Experiment], points: &[Vec<Point>], lag_s: f64) -> Line {
    let lag_ns = (lag_s * 1e9) as i64;
    let (mut n, mut c, mut a, mut cc, mut ca, mut aa) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (run, points) in experiments.iter().zip(points) {
        let mut command = run.commands();
        for point in points {
            let u = command.at(point.time_ns - lag_ns);
            let y = point.angle_deg;
            n += 1.0;
            c += u;
            a += y;
            cc += u * u;
            ca += u * y;
            aa += y * y;
        }
    }
    let (var_c, cov, var_a) = (cc - c * c / n, ca - c * a / n, aa - a * a / n);
    let gain = if var_c > 1e-12 * cc.max(1e-12) {
        cov / var_c
    } else {
        1.0
    };
    Line {
        gain,
        offset_deg: (a - gain * c) / n,
        error: var_a - 2.0 * gain * cov + gain * gain * var_c,
    }
}

/// The time over which slopes are taken, s: they are those of the servo and not of encoder noise.
const SLOPE_S: f64 = 0.02;

/// Share of the path that is travelled at a rate limit or faster.
const STEEP: f64 = 0.1;

/// Steep slopes up and down, deg/s; the steeper one for both where only one direction moves.
fn steep(points: &[Vec<Point>]) -> (f64, f64) {
    let (mut up, mut down) = (Vec::new(), Vec::new());
    for points in points {
        let mut from = 0;
        for to in points {
            let width_s = |from: usize| (to.time_ns - points[from].time_ns) as f64 * 1e-9;
            while from + 1 < points.len() && width_s(from + 1) >= SLOPE_S {
                from += 1;
            }
            if width_s(from) >= SLOPE_S {
                let slope = (to.angle_deg - points[from].angle_deg) / width_s(from);
                match slope > 0.0 {
                    true => up.push(slope),
                    false => down.push(-slope),
                }
            }
        }
    }
    let (up, down) = (exceeded_on_the_path(up), exceeded_on_the_path(down));
    let most = up.max(down).max(1.0);
    let or_steepest = |slope: f64| if slope < 0.05 * most { most } else { slope };
    (or_steepest(up), or_steepest(down))
}

/// The slope that is exceeded on a tenth of the path.
fn exceeded_on_the_path(mut slopes: Vec<f64>) -> f64 {
    slopes.sort_unstable_by(|a, b| b.total_cmp(a));
    let mut left = STEEP * slopes.iter().sum::<f64>();
    let steep = slopes.iter().find(|slope| {
        left -= **slope;
        left <= 0.0
    });
    steep.copied().unwrap_or(0.0)
}
