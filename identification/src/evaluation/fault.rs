//! What may be wrong with a recording, or with the assumptions of its fit.

use model_core::sensors::noise::Noise;

use crate::recording::Recording;

/// What is wrong with a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// The command is held at 250 Hz and changes with every sample.
    HeldSmoothCommand,
    /// Three readings of zero.
    ZeroReadings,
    /// One reading that is off by 40 deg.
    Glitch,
    /// One percent of the readings have noise of 20 deg.
    Outliers,
    /// The noise has Student's distribution with three degrees of freedom.
    HeavyTails,
    /// The angle repeats for 300 ms.
    Frozen,
    /// 350 ms are missing.
    Gap,
    /// The instants of the samples have an error of 1 ms that is not recorded.
    Jitter,
    /// The clock of the angle is 2 % fast.
    Drift,
    /// The angle is in rad and not in deg.
    Radians,
    /// The angle counts in the other direction.
    Sign,
    /// The instants of the samples have an error of 5 ms that is not recorded.
    LargeJitter,
    /// The sensor stops within the range of the motion.
    SensorStop,
    /// The drive limits the command, and the recording does not show it.
    ClippedCommand,
    /// The angle is a random walk, whatever the command.
    RandomWalk,
    /// The delay is longer than the model can have.
    BeyondBound,
    /// The column of the command contains the time.
    TimeAsCommand,
    /// One search from one poor starting point.
    PoorStart,
    /// 50 Hz, with steps of the command between the samples.
    Asynchronous,
    /// A motor without a load, of which only ratios are observable.
    UnloadedMotor,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 21] = [
        Self::None,
        Self::HeldSmoothCommand,
        Self::ZeroReadings,
        Self::Glitch,
        Self::Outliers,
        Self::HeavyTails,
        Self::Frozen,
        Self::Gap,
        Self::Jitter,
        Self::Drift,
        Self::Radians,
        Self::Sign,
        Self::LargeJitter,
        Self::SensorStop,
        Self::ClippedCommand,
        Self::RandomWalk,
        Self::BeyondBound,
        Self::TimeAsCommand,
        Self::PoorStart,
        Self::Asynchronous,
        Self::UnloadedMotor,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::HeldSmoothCommand => "chirp or multisine, held at 250 Hz",
            Self::ZeroReadings => "three readings of zero",
            Self::Glitch => "one reading off by 40 deg",
            Self::Outliers => "1 % of readings with noise of 20 deg",
            Self::HeavyTails => "Student noise, three degrees of freedom",
            Self::Frozen => "angle frozen for 300 ms",
            Self::Gap => "gap of 350 ms",
            Self::Jitter => "unrecorded jitter of 1 ms",
            Self::Drift => "clock of the angle 2 % fast",
            Self::Radians => "angle in rad",
            Self::Sign => "angle of opposite sign",
            Self::LargeJitter => "unrecorded jitter of 5 ms",
            Self::SensorStop => "sensor stops within the motion",
            Self::ClippedCommand => "command limited in the drive",
            Self::RandomWalk => "random walk",
            Self::BeyondBound => "delay beyond its bound",
            Self::TimeAsCommand => "time as command",
            Self::PoorStart => "one search from a poor start",
            Self::Asynchronous => "steps between samples at 50 Hz",
            Self::UnloadedMotor => "unloaded motor: ratios",
        }
    }
}

/// A number from `low` to `high`.
pub fn uniform(noise: &mut Noise, low: f64, high: f64) -> f64 {
    // The fraction of a wide gaussian is uniform.
    low + (high - low) * noise.gaussian(1e3).rem_euclid(1.0)
}

/// Puts a fault into the samples.
pub fn spoil(run: &mut Recording, fault: Fault, noise: &mut Noise) {
    let count = run.len();
    // Where the angle is far from zero, and where it moves.
    let size = |i: &usize| run.angle_deg[*i].abs();
    let greatest = (0..count).map(|i| size(&i)).fold(0.0, f64::max);
    let far: Vec<usize> = (0..count).filter(|i| size(i) > 0.5 * greatest).collect();
    let any = |noise: &mut Noise, of: usize| uniform(noise, 0.0, of as f64) as usize % of;
    match fault {
        Fault::ZeroReadings => {
            for _ in 0..3 {
                let place = far[any(noise, far.len())];
                run.angle_deg[place] = 0.0;
            }
        }
        Fault::Glitch => run.angle_deg[any(noise, count)] += 40.0,
        Fault::Outliers => {
            for _ in 0..count / 100 {
                run.angle_deg[any(noise, count)] += noise.gaussian(20.0);
            }
        }
        Fault::Frozen => {
            let from = any(noise, count - 75);
            let kept = run.angle_deg[from];
            run.angle_deg[from..from + 75].fill(kept);
        }
        Fault::Gap => {
            let from = any(noise, count - 90);
            for column in [&mut run.time_s, &mut run.command_deg, &mut run.angle_deg] {
                column.drain(from..from + 87);
            }
        }
        Fault::Radians => run.angle_deg.iter_mut().for_each(|a| *a = a.to_radians()),
        Fault::Sign => run.angle_deg.iter_mut().for_each(|a| *a = -*a),
        Fault::SensorStop => {
            let stop = uniform(noise, 0.4, 0.9) * greatest;
            run.angle_deg
                .iter_mut()
                .for_each(|a| *a = a.clamp(-stop, stop));
        }
        Fault::RandomWalk => {
            let step_deg = uniform(noise, 0.1, 1.0);
            let mut at = 0.0;
            for angle in &mut run.angle_deg {
                at += noise.gaussian(step_deg);
                *angle = at;
            }
        }
        Fault::BeyondBound => {
            let late = count / 4;
            run.angle_deg.rotate_right(late);
            let first = run.angle_deg[late];
            run.angle_deg[..late].fill(first);
        }
        Fault::TimeAsCommand => run.command_deg.clone_from(&run.time_s),
        _ => {}
    }
}
