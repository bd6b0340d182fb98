//! Contradictions within the paper, or between the paper and measurement. Each has a title and a
//! short text: the printed text, its consequence, and the interpretation of this project.

use crate::page::Block;

/// A contradiction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contradiction {
    /// Its subject, as a question.
    pub title: &'static str,
    /// The printed text, its consequence, and the interpretation.
    pub text: &'static str,
}

impl From<&Contradiction> for Block {
    fn from(contradiction: &Contradiction) -> Self {
        Self::Warning(contradiction.title.into(), contradiction.text.into())
    }
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

/// The speed of the motor.
pub const MOTOR_GAIN: Contradiction = Contradiction {
    title: "37.4 or 240 deg/s?",
    text: "Equation (2) as printed, 2.836/(s + 7.586), has a steady-state gain of 0.374 (deg/s)/%: \
        37.4 deg/s at full duty, but the paper measured +240 and −350 deg/s. `consistent` keeps \
        the loop F G = 28.36/s, which follows from all printed digits, and interprets G as \
        2.836/(1 + 0.1318 s): 283.6 deg/s, which is between the two. `as-printed` leaves the duty \
        unlimited; `as-printed-strict` limits it to 100 % and therefore to 37.4 deg/s.",
};

/// The meaning of the ten of the controller.
pub const STEADY_GAIN: Contradiction = Contradiction {
    title: "A steady-state gain of ten?",
    text: "A PI controller has no finite steady-state gain: the ten of equation (1) as printed is \
        its proportional gain. `consistent` interprets F as 10 (1 + 0.1318 s)/s. In both cases the \
        zero cancels the motor's pole, 0.13182 s = 1/(7.586 1/s), and F G is the same.",
};

/// Both gains taken literally.
pub const LITERAL_GAINS: Contradiction = Contradiction {
    title: "2.836 and 10 both literally?",
    text: "They cannot both be meant as (deg/s)/% and %/(deg/s): sampled at 250 Hz with a delay of \
        a full period, that loop is unstable. With the 1 ms of this board the linear loop has a \
        gain margin of 3 dB, and the encoder quantization causes a limit cycle that reaches both \
        limits of the duty.",
};

/// One bandwidth for two models.
pub const BANDWIDTHS: Contradiction = Contradiction {
    title: "4.775 Hz for both?",
    text: "The paper gives both black boxes this bandwidth, 30 rad/s. It is the −3 dB frequency of \
        black box 1, but the natural frequency of black box 2: with a damping of 0.90 the gain of \
        black box 2 is −3 dB at 3.56 Hz, and −5.1 dB with a phase of −90 deg at 4.775 Hz.",
};

/// Gains that do not belong to one actuator.
pub const SPEEDS: Contradiction = Contradiction {
    title: "A position gain of 8 and a pole of 30 rad/s?",
    text: "No interpretation of the grey box with a position gain of 8 gives 30 rad/s: black box 2 \
        is its linear loop at about twice the speed. `as-measured-retuned` uses the gains that \
        black box 2 implies, a position gain of 16.67 and an inner loop of 54 rad/s.",
};

/// The delay that was matched by eye.
pub const DELAY: Contradiction = Contradiction {
    title: "17.5 ms of what?",
    text: "The delay was matched by eye to a log of 50 Hz. A fitted delay includes the lag of the \
        motor: a first-order fit to a motor with a lag of 18.5 ms and a delay of 17.5 ms gives \
        35 ms. Here it is one transport delay of the command, outside all loops.",
};

/// The lag on the ramp, which distinguishes the black boxes.
pub const RAMP_LAG: Contradiction = Contradiction {
    title: "Similar dynamics?",
    text: "Two models with the same bandwidth should have a similar lag. In addition to the delay \
        black box 1 lags by 1/p = 33 ms, black box 2 by B/A = 60 ms.",
};

/// The directions of the rate limits.
pub const RATE_LIMITS: Contradiction = Contradiction {
    title: "Approaching or rising?",
    text: "The limits are given as +240 deg/s approaching the step and −350 deg/s leaving it. For \
        a positive pulse that is the same as moving up and down; here the sign of the rate \
        decides. The paper does not explain the difference. `asymmetric` and `as-measured` model \
        it with different motor gains up and down.",
};

/// The encoder's name and resolution.
pub const ENCODER: Contradiction = Contradiction {
    title: "A5045, 0.0875 deg?",
    text: "Interpreted as the AS5045 with its 12 bits, 360/4096 = 0.0879 deg. The spikes in the \
        duty of the boards are single counts of it.",
};

/// No estimator was used.
pub const IDENTIFICATION: Contradiction = Contradiction {
    title: "Identified or matched?",
    text: "The paper mentions output-error identification, but matched each of its models \
        visually. No model in this report was fitted to a recording.",
};

/// The overshoot of a first-order lag.
pub const OVERSHOOT: Contradiction = Contradiction {
    title: "Black box 1 overshoots?",
    text: "The paper says that it overshoots the actuator's output. A first-order lag cannot \
        overshoot its command; it can only be ahead of an actuator that does not follow as far.",
};
