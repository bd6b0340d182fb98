//! Where the paper contradicts itself, each in a few words, and how it is read here.

/// How fast the motor is: equation (2) against the measured rates.
pub const MOTOR_GAIN: &str = "Equation (2) as printed, 2.836/(s + 7.586), has a steady gain of 0.374 (deg/s)/%, \
    which is 37.4 deg/s at full duty; the paper measures +240 and -350 deg/s. The reading `consistent` \
    keeps the loop F G = 28.36/s, which all printed digits give, and takes G = 2.836/(1 + 0.1318 s): \
    283.6 deg/s, between the two limits. `as-printed` leaves the duty unlimited, `as-printed-strict` \
    limits it to 100 % and stays at 37.4 deg/s.";

/// What the ten of the controller is.
pub const STEADY_GAIN: &str = "Equation (1) is said to have a steady-state gain of ten. A PI controller has none: as \
    printed, ten is its proportional gain. `consistent` reads F = 10 (1 + 0.1318 s)/s. Either way the zero \
    cancels the motor's pole exactly, 0.13182 s = 1/(7.586 1/s), and F G is the same.";

/// Both gains taken literally.
pub const LITERAL_GAINS: &str = "The numbers 2.836 and 10 cannot both be meant literally, as (deg/s)/% and %/(deg/s): \
    sampled at 250 Hz with a full period of delay that loop is unstable. With the 1 ms of this board the \
    linear loop keeps 3 dB; what one sees then is a limit cycle between the duty limits that the \
    encoder's counts set off.";

/// One bandwidth for two models.
pub const BANDWIDTHS: &str = "The paper gives 4.775 Hz, 30 rad/s, for both black boxes. Black box 1 has its -3 dB \
    point there. Of black box 2 it is the natural frequency: with its damping of 0.90 the gain has fallen \
    by 3 dB at 3.56 Hz, and at 4.775 Hz it stands at -5.1 dB and -90 deg before the delay.";

/// Gains that do not belong to one actuator.
pub const SPEEDS: &str = "The outer gain of 8 does not go with a pole of 30 rad/s: black box 2 is the grey box's linear \
    loop at about twice its speed, and no reading of the grey box gives 30 rad/s with a gain of 8. \
    `as-measured-retuned` takes 16.67 and an inner loop of 54 rad/s.";

/// The delay that was seen by eye.
pub const DELAY: &str = "The delay of 17.5 ms was matched by eye to a log of 50 Hz. A fitted delay absorbs the lag of the \
    motor: a first-order fit to a motor that lags by 18.5 ms behind 17.5 ms returns 35 ms. Here it is one \
    transport delay on the command, outside every loop.";

/// The lag of the ramp tells the black boxes apart.
pub const RAMP_LAG: &str = "Two models of one bandwidth would lag alike. Behind the delay black box 1 lags by 1/p = 33 ms, \
    black box 2 by B/A = 60 ms.";

/// Approaching and leaving.
pub const RATE_LIMITS: &str = "The limits are given as +240 deg/s approaching the step and -350 deg/s leaving it. For a \
    positive pulse that is the same as the sign of the rate, and so it is read: by the sign of the rate. \
    Why they differ the paper leaves open; in `asymmetric` and `as-measured` unequal motor gains do it.";

/// The encoder's name and resolution.
pub const ENCODER: &str =
    "The encoder A5045 with 0.0875 deg is read as the AS5045 with 12 bits: 360/4096 = 0.0879 deg.";

/// No estimator was run.
pub const IDENTIFICATION: &str = "The paper speaks of output-error identification, but each of its models was matched \
    visually. Nothing on this page was fitted to a recording.";

/// What cannot overshoot.
pub const OVERSHOOT: &str = "The paper says that black box 1 overshoots the actuator. A first-order lag cannot overshoot its \
    command; it can only lie above the data, which do not follow where the steps are too large.";

#[cfg(test)]
/// All of them.
pub const ALL: [&str; 11] = [
    MOTOR_GAIN,
    STEADY_GAIN,
    LITERAL_GAINS,
    BANDWIDTHS,
    SPEEDS,
    DELAY,
    RAMP_LAG,
    RATE_LIMITS,
    ENCODER,
    IDENTIFICATION,
    OVERSHOOT,
];
