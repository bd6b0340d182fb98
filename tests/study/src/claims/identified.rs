//! Claims about numbers: poles, gains, limits, delay.

use host_sim::analysis::{
    frequency::{Response, bandwidth_hz},
    linear_models::{black_box_1, black_box_2},
};

use super::{Case, Claim, Evaluate, LOADED, MAIN, PRINTED, Verdict};
use crate::{
    figures::{BLACK_BOX_1, file},
    host::TRUE_DELAY_S,
    models::Fitted,
    runs::SampleRate::{Hz50, Hz250},
    test_bench::{BLACK_BOX_2, LOAD_NM},
};

/// The claims of this module.
pub(super) const CLAIMS: &[Evaluate] = &[
    pole,
    delay,
    limits,
    limits_loaded,
    second_order,
    bandwidths,
    similar,
    motor,
    by_eye,
];

/// Whether a value agrees with one of the paper, which has two digits or was matched visually.
fn near(value: f64, expected: f64, percent: f64) -> bool {
    (value / expected - 1.0).abs() <= percent / 100.0
}

fn fit<'a>(case: &Case<'a>, condition: usize, input: &str, model: usize) -> Option<&'a Fitted> {
    case.study.fit(condition, Hz250, input, model)
}

fn pole(case: &Case<'_>) -> Option<Claim> {
    let value = |condition, input| Some(fit(case, condition, input, 0)?.value("pole_rad_s"));
    let (pulse, chirp) = (value(MAIN, "pulse")?, value(MAIN, "chirp")?);
    let printed = value(PRINTED, "pulse")?;
    Some(Claim {
        text: "The pole of the first-order system is 30 rad/s.",
        section: "III.A",
        verdict: Verdict::contradicted_unless(near(printed, BLACK_BOX_1, 20.0)),
        evidence: format!(
            "The loop that the paper prints, P = 8, gives {printed:.1} rad/s for the pulse. The \
             loop retuned to black box 2 gives {pulse:.1} rad/s for the pulse and {chirp:.1} \
             rad/s for the chirp: a single pole is a compromise that depends on the input."
        ),
        figure: file(9, PRINTED),
    })
}

fn delay(case: &Case<'_>) -> Option<Claim> {
    let of = |rate, model| Some(case.study.fit(MAIN, rate, "pulse", model)?.value("delay_s") * 1e3);
    let (first, second, grey) = (of(Hz50, 0)?, of(Hz50, 1)?, of(Hz50, 2)?);
    let true_ms = TRUE_DELAY_S * 1e3;
    Some(Claim {
        text: "The delay of the test setup is 17.5 ms, matched with the black box.",
        section: "III",
        verdict: Verdict::contradicted_unless(near(first, true_ms, 20.0)),
        evidence: format!(
            "The true delay is {true_ms:.0} ms. Fitted to the pulse at 50 Hz: black box 1 \
             {first:.1} ms, black box 2 {second:.1} ms, grey box {grey:.1} ms: the delay of a \
             black box includes lag of the motor, so that a matched value is not the delay of \
             the setup."
        ),
        figure: file(9, MAIN),
    })
}

fn limit_pair(case: &Case<'_>, condition: usize) -> Option<(f64, f64)> {
    let fitted = fit(case, condition, "pulse", 0)?;
    let of = |name| fitted.value(name);
    Some((of("rate_limit_up_deg_s"), of("rate_limit_down_deg_s")))
}

fn limits(case: &Case<'_>) -> Option<Claim> {
    let (up, down) = limit_pair(case, MAIN)?;
    Some(Claim {
        text: "Unloaded, the rate limits are 240 deg/s to the step and 350 deg/s back.",
        section: "III.A",
        verdict: Verdict::not_reproduced_unless(down / up > 1.2),
        evidence: format!(
            "{up:.0} and {down:.0} deg/s: a brushed motor with an H-bridge has the same limit in \
             both directions. The unloaded actuator as the paper models it does not explain the \
             difference."
        ),
        figure: file(9, MAIN),
    })
}

fn limits_loaded(case: &Case<'_>) -> Option<Claim> {
    let (up, down) = limit_pair(case, LOADED)?;
    Some(Claim {
        text: "The limits differ by direction; why is not entirely understood.",
        section: "III.A",
        verdict: Verdict::not_reproduced_unless(down / up > 1.2),
        evidence: format!(
            "A constant torque of {LOAD_NM} Nm gives {up:.0} and {down:.0} deg/s with a ratio of \
             {:.2}; the paper's ratio is 1.46. A torque on the shaft is sufficient to explain \
             the difference.",
            down / up
        ),
        figure: file(9, LOADED),
    })
}

fn second_order(case: &Case<'_>) -> Option<Claim> {
    let of = |condition, input| {
        let fitted = fit(case, condition, input, 1)?;
        let value = |name| fitted.value(name);
        Some((value("position_gain_per_s2"), value("rate_gain_per_s")))
    };
    let (chirp, pulse, printed) = (
        of(MAIN, "chirp")?,
        of(MAIN, "pulse")?,
        of(PRINTED, "chirp")?,
    );
    let holds = near(printed.0, BLACK_BOX_2.0, 30.0) && near(printed.1, BLACK_BOX_2.1, 30.0);
    Some(Claim {
        text: "The second-order system has A = 900 and B = 54.",
        section: "III.B",
        verdict: Verdict::contradicted_unless(holds),
        evidence: format!(
            "The printed loop has A = {:.0}, B = {:.1} on the chirp. The retuned loop, designed \
             for 900 and 54, has {:.0} and {:.1} on the chirp, and {:.0} and {:.1} on the pulse: \
             one pole at A/B = {:.1} and {:.1} rad/s, as in black box 1, and a second one that \
             the recordings do not determine. During the pulse the duty limit determines the \
             motion, not these gains.",
            printed.0,
            printed.1,
            chirp.0,
            chirp.1,
            pulse.0,
            pulse.1,
            chirp.0 / chirp.1,
            pulse.0 / pulse.1
        ),
        figure: file(11, PRINTED),
    })
}

fn bandwidths(_: &Case<'_>) -> Option<Claim> {
    let (a, b) = BLACK_BOX_2;
    let first = bandwidth_hz(&black_box_1(BLACK_BOX_1))?;
    let second = bandwidth_hz(&black_box_2(a, b))?;
    Some(Claim {
        text: "Both black boxes have a bandwidth of 4.775 Hz.",
        section: "IV, figure 11",
        verdict: Verdict::contradicted_unless(near(second, first, 5.0)),
        evidence: format!(
            "With the paper's numbers the gain is -3 dB at {first:.3} Hz and at {second:.3} Hz; \
             4.775 Hz is the natural frequency of black box 2."
        ),
        figure: file(11, MAIN),
    })
}

fn similar(case: &Case<'_>) -> Option<Claim> {
    let (first, second) = (fit(case, MAIN, "chirp", 0)?, fit(case, MAIN, "chirp", 1)?);
    let grid: Vec<f64> = (1..=48).map(|i| f64::from(i) * 0.1).collect();
    let one = Response::of(&black_box_1(first.value("pole_rad_s")), &grid);
    let a = second.value("position_gain_per_s2");
    let two = Response::of(&black_box_2(a, second.value("rate_gain_per_s")), &grid);
    let pairs = one.gain_db.iter().zip(&two.gain_db);
    let apart_db = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (x, y) = (first.quality.fit_percent, second.quality.fit_percent);
    Some(Claim {
        text: "In the Bode plot both capture similar dynamics.",
        section: "IV, figure 11",
        verdict: Verdict::contradicted_unless(apart_db < 3.0),
        evidence: format!(
            "Fitted to the chirp, their gains are at most {apart_db:.1} dB apart up to 4.8 Hz; they \
             fit it to {x:.1} and {y:.1} %."
        ),
        figure: file(11, MAIN),
    })
}

fn motor(case: &Case<'_>) -> Option<Claim> {
    let fitted = fit(case, MAIN, "variable-step", 2)?;
    let value = |name| fitted.value(name);
    let gain = 0.5 * (value("motor_gain_up") + value("motor_gain_down"));
    let pole = 1.0 / value("motor_time_constant_s");
    Some(Claim {
        text: "The motor is 2.836/(s + 7.586) from PWM (%) to deg/s.",
        section: "III.C, eq. (2)",
        verdict: Verdict::contradicted_unless(near(gain * pole, 2.836, 20.0)),
        evidence: format!(
            "The grey box finds {gain:.3} (deg/s)/% and a pole of {pole:.2} rad/s: {:.1}/(s + \
             {pole:.2}). As printed, the motor reaches 37.4 deg/s at full duty; the simulated \
             one, with the torque of the data sheet, reaches the measured rates.",
            gain * pole
        ),
        figure: file(12, MAIN),
    })
}

fn by_eye(case: &Case<'_>) -> Option<Claim> {
    let fitted = fit(case, MAIN, "pulse", 0)?.quality.fit_percent;
    let (measured, printed) = (&case.pulse.mean_deg, &case.pulse.printed_deg[0]);
    let quality = identification::statistics::Quality::of(measured, printed)?;
    Some(Claim {
        text: "Output error determines the parameters, which are visually matched.",
        section: "III, III.A to III.C",
        verdict: Verdict::Contradicted,
        evidence: format!(
            "The paper states both. Black box 1 with the paper's numbers fits the pulse of the \
             retuned loop to {:.1} %, least squares to {fitted:.1} %.",
            quality.fit_percent
        ),
        figure: file(9, MAIN),
    })
}
