//! Where the paper contradicts itself or measurement: a title, and in a few words what is printed,
//! what it comes to, and how it is read here.

/// A contradiction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contradiction {
    /// What it is about.
    pub title: &'static str,
    /// What is printed, what it comes to, how it is read.
    pub text: &'static str,
}

/// All of them.
pub const ALL: [Contradiction; 11] = [
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

/// How fast the motor is.
pub const MOTOR_GAIN: Contradiction = Contradiction {
    title: "37.4 or 240 deg/s?",
    text: "Equation (2) as printed, 2.836/(s + 7.586), has a steady gain of 0.374 (deg/s)/%: 37.4 \
        deg/s at full duty, where the paper measures +240 and −350 deg/s. `consistent` keeps the \
        loop F G = 28.36/s, which all printed digits give, and reads G as 2.836/(1 + 0.1318 s): \
        283.6 deg/s, between the two. `as-printed` leaves the duty unlimited; `as-printed-strict` \
        limits it to 100 % and stays at 37.4 deg/s.",
};

/// What the ten of the controller is.
pub const STEADY_GAIN: Contradiction = Contradiction {
    title: "A steady-state gain of ten?",
    text: "A PI controller has no finite one: the ten of equation (1) as printed is its \
        proportional gain. `consistent` reads F as 10 (1 + 0.1318 s)/s. Either way the zero \
        cancels the motor's pole, 0.13182 s = 1/(7.586 1/s), and F G is the same.",
};

/// Both gains taken literally.
pub const LITERAL_GAINS: Contradiction = Contradiction {
    title: "2.836 and 10 both literally?",
    text: "As (deg/s)/% and %/(deg/s) they cannot both be meant. Sampled at 250 Hz with a full \
        period of delay that loop is unstable. With the 1 ms of this board the linear loop keeps \
        3 dB; what is seen then is a limit cycle of the encoder's counts, which reaches both \
        limits of the duty.",
};

/// One bandwidth for two models.
pub const BANDWIDTHS: Contradiction = Contradiction {
    title: "4.775 Hz for both?",
    text: "The paper gives both black boxes this bandwidth, 30 rad/s. Black box 1 has its −3 dB \
        point there. Of black box 2 it is the natural frequency: with a damping of 0.90 its gain \
        has fallen by 3 dB at 3.56 Hz already, and at 4.775 Hz stands at −5.1 dB and −90 deg.",
};

/// Gains that do not belong to one actuator.
pub const SPEEDS: Contradiction = Contradiction {
    title: "A position gain of 8 and a pole of 30 rad/s?",
    text: "No reading of the grey box with a position gain of 8 gives 30 rad/s: black box 2 is its \
        linear loop at about twice the speed. `as-measured-retuned` takes what black box 2 says, \
        16.67 and an inner loop of 54 rad/s.",
};

/// The delay that was seen by eye.
pub const DELAY: Contradiction = Contradiction {
    title: "17.5 ms of what?",
    text: "The delay was matched by eye to a log of 50 Hz. A fitted delay absorbs the lag of a \
        motor: a first-order fit to one that lags by 18.5 ms behind 17.5 ms returns 35 ms. Here it \
        is one transport delay on the command, outside every loop.",
};

/// The lag of the ramp tells the black boxes apart.
pub const RAMP_LAG: Contradiction = Contradiction {
    title: "Similar dynamics?",
    text: "Of two models with the same bandwidth one expects the same lag. Behind the delay black \
        box 1 lags by 1/p = 33 ms, black box 2 by B/A = 60 ms.",
};

/// Approaching and leaving.
pub const RATE_LIMITS: Contradiction = Contradiction {
    title: "Approaching or rising?",
    text: "The limits are given as +240 deg/s approaching the step and −350 deg/s leaving it. For \
        a positive pulse that is the same as going up and going down; here the sign of the rate \
        decides. Why they differ the paper leaves open. In `asymmetric` and `as-measured` unequal \
        motor gains do it.",
};

/// The encoder's name and resolution.
pub const ENCODER: Contradiction = Contradiction {
    title: "A5045, 0.0875 deg?",
    text: "Read as the AS5045 with its 12 bits, 360/4096 = 0.0879 deg. The teeth in the duty of \
        the boards are single counts of it.",
};

/// No estimator was run.
pub const IDENTIFICATION: Contradiction = Contradiction {
    title: "Identified or matched?",
    text: "The paper speaks of output-error identification, but matched each of its models \
        visually. Nothing on this page was fitted to a recording.",
};

/// What cannot overshoot.
pub const OVERSHOOT: Contradiction = Contradiction {
    title: "Black box 1 overshoots?",
    text: "So the paper says, of the actuator's output. A first-order lag cannot overshoot its \
        command; it can only lie beyond data that do not follow so far.",
};
