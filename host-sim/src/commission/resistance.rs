//! The second step: resistance and inductance of the cold winding, from short pulses of torque in
//! both directions.
//!
//! ```text
//! sample = (V x(on time, L/R) - e)/R
//! ```
//!
//! The back-EMF `e` of the shaft that begins to turn is measured and subtracted. `x` is the share
//! of the voltage that the current has reached at the instant of its sample; pulses of three
//! torques have three on times, which separate `R` and `L`.

use std::time::Duration;

use super::runs::Run;
use super::samples::{Board, SIGNALS, Sample};
use super::winding::Winding;
use super::winding_fit::fit;
use super::{CommissionError, Estimate, GAIN_ERROR, Limits, Step, record, refuse, uniform};
use crate::can::client::{Client, ClientError};

const STEP: Step = Step::Resistance;

/// Time of a pulse: ten control periods.
const PULSE: Duration = Duration::from_millis(40);

/// Divisors of the highest current of the pairs of pulses. The second pulse of each pair stops the
/// shaft, and the next pair turns it back.
const SHARES: [i32; 6] = [4, 2, 1, 1, 1, 1];

/// Travel that ends a pulse, mdeg.
const TRAVEL_MDEG: i64 = 3_000;

/// Time at rest before the pulses, in which the offset of the current is measured, and after them.
const REST: Duration = Duration::from_millis(200);

/// Largest current that is measured of a motor that is off: 1 % of the range of the amplifier, A.
const OFFSET_A: f64 = 0.03;

/// Largest back-EMF that is measured of a motor at rest: dividers of resistors of 1 % at half of
/// 16 V, V.
const OFFSET_V: f64 = 0.15;

/// Largest decrease of the supply: the samples of supply and current are those of one instant, the
/// mean of the on time differs by a part of the decrease.
const SAG: f64 = 0.1;

/// Factor within which the resistance must be that of 2011h: motors of one type are within a third.
const PLAUSIBLE: f64 = 2.0;

/// Rise of the resistance of copper, 1/K, and the temperature of 2011h:1, deg C.
pub const COPPER_K: f64 = 0.0039;
pub const COLD_DEG_C: f64 = 25.0;

/// Largest error of the temperature of the winding, K: that of the NTC, and of the model by which
/// it has warmed since.
pub const TEMPERATURE_K: f64 = 2.0;

/// What the pulses give.
#[derive(Debug, Clone, Copy)]
pub struct Cold {
    /// Resistance at 25 deg C, ohm.
    pub resistance_ohm: Estimate,
    /// The winding at the temperature of the pulses.
    pub winding: Winding,
}

/// Pulses in both directions.
pub fn measure(
    client: &mut Client,
    limits: &Limits,
    board: &mut Board,
) -> Result<Cold, CommissionError> {
    client.quick_stop()?;
    let (capture, waited) = record(client, &SIGNALS, |client| client.pause(REST))?;
    waited?;
    let at_rest = board.samples(&capture);
    let mean = |value: fn(&Sample) -> f64| {
        at_rest.iter().map(value).sum::<f64>() / at_rest.len().max(1) as f64
    };
    board.offset_a = mean(|sample| sample.sampled_a);
    if board.offset_a.abs() > OFFSET_A {
        let why = format!(
            "the current measurement shows {:.0} mA of a motor that is off, expected 0 within 30 \
             mA: its offset is wrong",
            board.offset_a * 1e3
        );
        return refuse(STEP, why);
    }
    board.offset_v = mean(|sample| sample.back_emf_v);
    if board.offset_v.abs() > OFFSET_V {
        let why = format!(
            "the back-EMF is {:.0} mV of a motor that is off, expected 0 within 150 mV: the shaft \
             turns, or the dividers of the legs differ",
            board.offset_v * 1e3
        );
        return refuse(STEP, why);
    }
    let rest_v = mean(|sample| sample.driven.supply_v);
    let warm_k = winding_deg_c(client)? - COLD_DEG_C;
    client.write("6071", "0")?;
    client.enable(4)?;
    let (capture, moved) = record(client, &SIGNALS, |client| {
        for (pair, share) in SHARES.into_iter().enumerate() {
            let permille = i32::from(limits.permille) / share * [1, -1][pair % 2];
            pulse(client, permille)?;
            pulse(client, -permille)?;
        }
        client.write("6071", "0")?;
        client.enable(1)?;
        client.pause(REST)
    })?;
    moved?;
    let mut pairs = driven(&board.samples(&capture));
    let sag = under_load(&mut pairs, rest_v)?;
    let (winding, warm) = of_measured(&pairs, &board.assumed)?;
    let cold = warm.over(1.0 + COPPER_K * warm_k);
    // Current and supply are measured with resistors each.
    let gains = uniform(GAIN_ERROR).hypot(uniform(GAIN_ERROR));
    let common = gains
        .hypot(uniform(COPPER_K * TEMPERATURE_K))
        .hypot(uniform(sag / 2.0));
    let resistance_ohm = Estimate {
        standard_error: cold.standard_error.hypot(cold.value * common),
        ..cold
    };
    plausible(resistance_ohm, board)?;
    Ok(Cold {
        resistance_ohm,
        winding,
    })
}

/// Sets the supply to the middle between that at rest and that at the sample: within the on time it
/// decreases from the one to the other. Returns the mean decrease as a share; refuses a large one.
fn under_load(pairs: &mut [[Sample; 2]], rest_v: f64) -> Result<f64, CommissionError> {
    let count = pairs.len() as f64;
    let (mut sum, mut least_v) = (0.0, rest_v);
    for [_, sample] in pairs {
        let supply_v = &mut sample.driven.supply_v;
        least_v = least_v.min(*supply_v);
        sum += (rest_v - *supply_v).abs() / rest_v;
        *supply_v = supply_v.midpoint(rest_v);
    }
    if least_v >= rest_v * (1.0 - SAG) {
        return Ok(sum / count);
    }
    let why = format!(
        "the supply sags from {rest_v:.2} to {least_v:.2} V in the pulses, expected a decrease of \
         less than 10 %: a stronger supply, or a smaller --current"
    );
    refuse(STEP, why)
}

/// Refuses a resistance far from that of 2011h. A wrong gain of the current measurement changes
/// resistance, friction and inertia alike, so that nothing else contradicts it.
fn plausible(found: Estimate, board: &Board) -> Result<(), CommissionError> {
    let known_ohm = board.assumed.resistance_ohm;
    let (least, most) = (known_ohm / PLAUSIBLE, known_ohm * PLAUSIBLE);
    if (least..=most).contains(&found.value) {
        return Ok(());
    }
    let why = format!(
        "{:.3} ohm, expected {least:.3} to {most:.3} ohm, half to twice 2011h:1: the gain of the \
         current measurement is wrong, or 2011h:1 is of another motor; write the value of its data \
         sheet",
        found.value
    );
    refuse(STEP, why)
}

/// Refuses a resistance that the samples of the runs contradict: their current is that of the
/// difference between supply and back-EMF, in which an error of either is larger than in the
/// pulses.
pub fn check(cold: &Cold, runs: &[Run]) -> Result<(), CommissionError> {
    let Cold {
        resistance_ohm,
        winding,
    } = cold;
    let (mut products, mut squares, mut error_v) = (0.0, 0.0, 0.0);
    for sample in runs.iter().flat_map(|run| &run.samples) {
        let model_a = winding.current(sample.driven).sampled_a;
        products += model_a * sample.sampled_a;
        squares += model_a * model_a;
        // Each of the two voltages has its dividers.
        let back_emf_v = sample.driven.back_emf_v;
        let driving_v = model_a * winding.resistance_ohm + back_emf_v;
        error_v += model_a.abs() * uniform(GAIN_ERROR) * driving_v.hypot(back_emf_v);
    }
    // At the same time constant all currents are in inverse proportion to the resistance.
    let found_ohm = winding.resistance_ohm * squares / products;
    let error_ohm = found_ohm * error_v / (squares * winding.resistance_ohm);
    let error_ohm = error_ohm.hypot(resistance_ohm.standard_error);
    let difference_ohm = found_ohm - winding.resistance_ohm;
    // Not true for NaN either.
    let agrees = products > 0.0 && difference_ohm.abs() <= 3.0 * error_ohm;
    if agrees {
        return Ok(());
    }
    let why = format!(
        "{:.3} ohm in the pulses and {found_ohm:.3} ohm in the runs at constant rate contradict \
         each other, expected a difference of less than {:.3} ohm: the back-EMF, the supply or the \
         current is measured with a wrong gain",
        winding.resistance_ohm,
        3.0 * error_ohm
    );
    refuse(STEP, why)
}

/// The temperature of the winding by the model of the board, deg C.
pub fn winding_deg_c(client: &mut Client) -> Result<f64, ClientError> {
    Ok(client.integer("2009")? as f64 * 0.1)
}

/// A pulse of torque, which ends early where the shaft has moved far.
fn pulse(client: &mut Client, permille: i32) -> Result<(), ClientError> {
    let begin = client.integer("6064")?;
    client.write("6071", &permille.to_string())?;
    let step = Duration::from_millis(4);
    for _ in 0..PULSE.as_millis() / step.as_millis() {
        client.pause(step)?;
        if (client.integer("6064")? - begin).abs() > TRAVEL_MDEG {
            break;
        }
    }
    Ok(())
}

/// The samples before which the drive has had the same sign for two control periods, each with the
/// one before it.
fn driven(samples: &[Sample]) -> Vec<[Sample; 2]> {
    let sign = |sample: &Sample| sample.driven.compare.signum();
    let pairs = samples.windows(2).map(|pair| [pair[0], pair[1]]);
    let lasting = pairs.filter(|[before, now]| sign(now) != 0 && sign(before) == sign(now));
    lasting.collect()
}

/// Selections of the samples until they are those of the winding that they give. A slower winding
/// than that of the object carries its current longer.
const SELECTIONS: usize = 6;

/// The winding of the samples whose back-EMF is between two scans behind which it carries no
/// current.
fn of_measured(
    pairs: &[[Sample; 2]],
    start: &Winding,
) -> Result<(Winding, Estimate), CommissionError> {
    let mut winding = *start;
    let mut selected = Vec::new();
    for _ in 0..SELECTIONS {
        let is_measured = |sample: &Sample| winding.current(sample.driven).shows_back_emf();
        let measured = pairs.iter().map(|pair| pair.iter().all(is_measured));
        let before = std::mem::replace(&mut selected, measured.collect());
        let samples = pairs.iter().zip(&selected).filter(|(_, is)| **is);
        let samples: Vec<Sample> = samples.map(|([_, sample], _)| *sample).collect();
        if 2 * samples.len() < pairs.len() {
            let why = format!(
                "in {} of {} control periods the winding carries its current until the scan of the \
                 back-EMF, expected less than half: a smaller --current",
                pairs.len() - samples.len(),
                pairs.len()
            );
            return refuse(STEP, why);
        }
        let found = fit(&samples, &winding)?;
        if before == selected {
            return Ok(found);
        }
        (winding, _) = found;
    }
    let why = "the samples that show the back-EMF change with each fit: a smaller --current";
    refuse(STEP, why)
}

#[cfg(test)]
mod tests {
    use super::super::runs::ConstantRate;
    use super::super::winding::Driven;
    use super::*;

    const COLD: Cold = Cold {
        resistance_ohm: Estimate {
            value: 7.7,
            standard_error: 0.08,
        },
        winding: Winding {
            resistance_ohm: 7.7,
            inductance_h: 1e-3,
        },
    };

    /// A run at 2.4 V whose back-EMF is measured with this gain.
    fn run(gain: f64) -> Run {
        let driven = Driven {
            compare: 24_000,
            supply_v: 6.0,
            back_emf_v: 2.4,
        };
        let sample = Sample {
            angle_deg: 0.0,
            command_mdeg: 0,
            sampled_a: COLD.winding.current(driven).sampled_a,
            driven: Driven {
                back_emf_v: 2.4 * gain,
                ..driven
            },
            back_emf_v: 2.4 * gain,
            compare: driven.compare,
            temperature_deg_c: 25.0,
        };
        Run {
            mean: ConstantRate {
                rate_rad_s: 2.0,
                back_emf_v: 2.4 * gain,
                back_emf_change_v_s: 0.0,
                current_a: 0.0,
            },
            samples: vec![sample; 20],
        }
    }

    #[test]
    fn a_wrong_gain_of_the_back_emf_contradicts_the_pulses() {
        for gain in [0.98, 1.0, 1.02] {
            check(&COLD, &[run(gain)]).expect("within the resistors");
        }
        for gain in [0.9, 1.1, -1.0] {
            let error = check(&COLD, &[run(gain)])
                .expect_err("a wrong gain")
                .to_string();
            assert!(error.contains("contradict each other"), "{error}");
        }
    }
}
