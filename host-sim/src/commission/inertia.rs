//! The last measurement: two excitations around the centre of the range give inertia and delay,
//! each for itself. The second one validates the first: what it contradicts is reported, and is not
//! stored.

use std::time::Duration;

use super::comparison::Comparison;
use super::excite::excite;
use super::friction::Friction;
use super::motor_fit::{Fitted, Fitting, Motor, Start, timing};
use super::resistance::{COLD_DEG_C, Cold, winding_deg_c};
use super::samples::{Board, SIGNALS, real};
use super::{CommissionError, Estimate};
use crate::can::client::Client;

/// An excitation: the values of the sub-indices of 2020h for a scale of its amplitude.
type Excitation = fn(f64) -> Vec<(u8, i32)>;

/// A chirp over the band of the position loop, within 5 deg.
const CHIRP: Excitation = |scale| {
    let amplitude_mdeg = (5e3 * scale) as i32;
    vec![
        (3, 5),
        (4, amplitude_mdeg),
        (5, 300),
        (6, 4_000),
        (7, 4_000),
        (12, 1),
    ]
};

/// Cosines at eight odd multiples of 0.4 Hz, to 6 Hz, of 2 deg each, twice.
const MULTISINE: Excitation = |scale| {
    let amplitude_mdeg = (2e3 * scale) as i32;
    vec![(3, 9), (4, amplitude_mdeg), (5, 400), (11, 8), (12, 2)]
};

/// Their names.
const NAMES: (&str, &str) = ("the chirp", "the multisine");

/// Relative standard error of the inertia above which the chirp is repeated with a greater
/// amplitude: most motors have 3 % by resistance, gains and magnet.
const WANTED: f64 = 0.05;

/// The greatest scale of the amplitudes.
const MOST_SCALE: f64 = 3.0;

/// What the multisine moves at most, and its distance to the ends of the range, deg.
const REACH_DEG: f64 = 16.0;
const DISTANCE_DEG: f64 = 5.0;

/// Standard errors from the middle of an interval of 95 % to its ends.
const INTERVAL: f64 = 2.0;

/// What the excitations give.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Dynamics {
    /// Inertia at the output, kg m^2.
    pub inertia_kg_m2: Estimate,
    /// Time from the control period that decides a duty to that which measures its first effect, s:
    /// mean of the chirp and of the board's timing.
    pub delay_s: Estimate,
    /// Free play of the output, deg: mean of the fits by their standard errors; `None` if they do
    /// not determine it.
    pub backlash_deg: Option<Estimate>,
    /// Two measurements of one parameter whose intervals do not overlap.
    pub contradictions: Vec<Contradiction>,
    /// The chirp against its fit.
    #[serde(skip)]
    pub identification: Comparison,
    /// The multisine against the motor of the chirp.
    #[serde(skip)]
    pub validation: Comparison,
}

/// Two measurements of one parameter whose intervals do not overlap.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Contradiction {
    /// The parameter.
    pub parameter: Parameter,
    /// The values, as a sentence.
    pub text: String,
}

/// A parameter that is measured twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// Inertia.
    Inertia,
    /// Delay.
    Delay,
    /// Coulomb friction.
    Coulomb,
}

/// Excites around the centre of this range, mdeg, and fits.
pub fn measure(
    client: &mut Client,
    (low, high): (i32, i32),
    board: &Board,
    (cold, constant, friction): (&Cold, Estimate, &Friction),
) -> Result<Dynamics, CommissionError> {
    let centre_mdeg = low.midpoint(high);
    let coulomb = friction
        .upward
        .coulomb_nm
        .mean(friction.downward.coulomb_nm);
    let start = Start {
        inertia_kg_m2: real(client, "2011:4")?,
        coulomb_nm: coulomb.value.max(0.0),
    };
    let half_deg = f64::from(high - low) * 0.5e-3;
    let most = ((half_deg - DISTANCE_DEG) / REACH_DEG).clamp(1.0, MOST_SCALE);
    let mut excited = |excitation: Excitation, scale: f64| {
        let samples = board.samples(&excite(
            client,
            centre_mdeg,
            (&SIGNALS, Duration::ZERO),
            &excitation(scale),
        )?);
        let warm_k = winding_deg_c(client)? - COLD_DEG_C;
        Ok::<_, CommissionError>((samples, Motor::of(cold, constant, warm_k)))
    };
    let mut scale = 1.0;
    let one = loop {
        let (samples, motor) = excited(CHIRP, scale)?;
        match Fitted::of(&samples, &motor, &start) {
            Ok(one) if one.inertia_kg_m2.whole().relative() <= WANTED => break one,
            fitted if scale >= most => break fitted?,
            _ => scale = most,
        }
    };
    let (samples, motor) = excited(MULTISINE, scale)?;
    let other = Fitted::of(&samples, &motor, &start)?;
    let validation = one.predict(&samples, &motor)?;
    let of_excitations = |parameter, name: &str, (one, other): (Fitting, Fitting)| {
        let values = (one.against_another(), other.against_another());
        contradiction((parameter, name), NAMES, values)
    };
    let of_delays = |delays| of_excitations(Parameter::Delay, "delay, s", delays);
    let of_timing = |of_chirp: Fitting| {
        let name = (Parameter::Delay, "delay, s");
        let sources = (NAMES.0, "the timing of the board");
        contradiction(name, sources, (of_chirp.whole(), timing()))
    };
    let of_runs = |of_chirp: Fitting| {
        let name = (Parameter::Coulomb, "Coulomb friction, Nm");
        contradiction(name, (NAMES.0, "the runs"), (of_chirp.whole(), coulomb))
    };
    let contradictions = [
        of_excitations(
            Parameter::Inertia,
            "inertia, kg m^2",
            (one.inertia_kg_m2, other.inertia_kg_m2),
        ),
        one.delay_s.zip(other.delay_s).and_then(of_delays),
        one.delay_s.and_then(of_timing),
        one.coulomb_nm.and_then(of_runs),
    ];
    Ok(Dynamics {
        inertia_kg_m2: one.inertia_kg_m2.whole(),
        delay_s: weighted([one.delay_s.map(Fitting::whole), Some(timing())]),
        backlash_deg: (one.backlash_deg.or(other.backlash_deg))
            .map(|_| weighted([one.backlash_deg, other.backlash_deg])),
        contradictions: contradictions.into_iter().flatten().collect(),
        identification: one.comparison,
        validation,
    })
}

/// The mean of what is known, weighted by the standard errors; 0 without any.
fn weighted(values: [Option<Estimate>; 2]) -> Estimate {
    let weighted = values.into_iter().flatten().map(|estimate| {
        let weight = estimate.standard_error.powi(-2);
        (weight, weight * estimate.value)
    });
    let (weights, sum) = weighted.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    Estimate {
        value: if weights > 0.0 { sum / weights } else { 0.0 },
        standard_error: weights.powf(-0.5),
    }
}

/// The contradiction of two values whose intervals of 95 % do not overlap.
fn contradiction(
    (parameter, name): (Parameter, &str),
    sources: (&str, &str),
    (one, other): (Estimate, Estimate),
) -> Option<Contradiction> {
    let reach = INTERVAL * (one.standard_error + other.standard_error);
    // Not true for NaN either.
    let overlap = (one.value - other.value).abs() <= reach;
    (!overlap).then(|| Contradiction {
        parameter,
        text: format!(
            "{name}: {:.4e} +- {:.1e} of {}, {:.4e} +- {:.1e} of {}",
            one.value, one.standard_error, sources.0, other.value, other.standard_error, sources.1
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_contradict_each_other_where_their_intervals_do_not_overlap() {
        let of = |value| Estimate {
            value,
            standard_error: 0.01,
        };
        let found = |other| {
            let name = (Parameter::Inertia, "inertia, kg m^2");
            contradiction(name, ("the chirp", "the multisine"), (of(1.0), of(other)))
        };
        assert!(found(1.039).is_none() && found(0.961).is_none());
        for other in [1.041, 0.959, f64::NAN] {
            let text = found(other).expect("a contradiction").text;
            assert!(
                text.starts_with("inertia, kg m^2: 1.0000e0 +- 1.0e-2 of the chirp"),
                "{text}"
            );
        }
    }
}
