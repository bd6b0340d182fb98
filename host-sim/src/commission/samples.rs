//! The records of a board as samples of its motor: what the board has computed of them is undone.

use firmware::capture::Signal;
use firmware::measure::Ripple;
use model_core::control::pwm_timer::{
    BACK_EMF_INSTANT, CurrentInstant, Modulator, PWM_COUNTS, PwmCompare, TIMER_CLOCK_HZ,
    TIMER_DIVIDER,
};
use model_core::control::units::percent;
use model_core::sensors::dividers::back_emf_gain;
use model_core::time::PWM_PERIODS_PER_UPDATE;

use super::winding::{Driven, Winding};
use super::{CommissionError, Step, refuse};
use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};
use crate::can::names::{self, Value};

/// The signals of a recording, in the order of [`samples`].
pub const SIGNALS: [Signal; 7] = [
    Signal::Angle,
    Signal::Current,
    Signal::BackEmf,
    Signal::Compare,
    Signal::Supply,
    Signal::Temperature,
    Signal::Command,
];

/// Parts of a mA in which the excess of a sample is computed; 16.5 V times that are below 2^31.
const FINE: i32 = 1000;

/// A sample of the motor at the begin of a control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Measured angle, deg.
    pub angle_deg: f64,
    /// Commanded angle, mdeg.
    pub command_mdeg: i32,
    /// Current as it was sampled, A.
    pub sampled_a: f64,
    /// What has driven the winding when it was sampled.
    pub driven: Driven,
    /// Back-EMF at the scan, V.
    pub back_emf_v: f64,
    /// Compare value that is decided in this control period.
    pub compare: i32,
    /// Temperature of the board, deg C.
    pub temperature_deg_c: f64,
}

/// What the board computes with.
pub struct Board {
    ripple: Ripple,
    /// The winding of 2011h.
    pub assumed: Winding,
    /// Current that is measured of a motor at rest that is off, A.
    pub offset_a: f64,
    /// Back-EMF that is measured of it, V.
    pub offset_v: f64,
}

impl Board {
    /// The board of this client, with the motor parameters of 2011h.
    pub fn of(client: &mut Client) -> Result<Self, CommissionError> {
        if PWM_PERIODS_PER_UPDATE > 1 {
            // The models of winding and twin are those of the default rates.
            return refuse(
                Step::Wiring,
                "a board at the second set of rates is not commissioned",
            );
        }
        let resistance_ohm = real(client, "2011:1")?;
        let inductance_h = real(client, "2011:8")?;
        Ok(Self {
            ripple: Ripple::of(resistance_ohm as f32, inductance_h as f32),
            assumed: Winding {
                resistance_ohm,
                inductance_h,
            },
            offset_a: 0.0,
            offset_v: 0.0,
        })
    }

    /// Writes a resistance that was found, by which the board computes from now on.
    pub fn set_resistance(
        &mut self,
        client: &mut Client,
        resistance_ohm: f64,
    ) -> Result<(), ClientError> {
        client.write("2011:1", &resistance_ohm.to_string())?;
        let inductance_h = self.assumed.inductance_h as f32;
        self.ripple = Ripple::of(resistance_ohm as f32, inductance_h);
        Ok(())
    }

    /// The samples of a recording of [`SIGNALS`] in each control period, but for the first, the
    /// compare value before which is not known.
    pub fn samples(&self, capture: &Capture) -> Vec<Sample> {
        let pairs = capture.records.windows(2);
        pairs.map(|pair| self.sample(&pair[0], &pair[1])).collect()
    }

    fn sample(&self, before: &[i32], now: &[i32]) -> Sample {
        // The board has subtracted from the sample by how much it exceeds the mean, and has
        // truncated the difference to a mA: what it has cut off is half a mA in the mean.
        let fine = self
            .ripple
            .over_period(0, of_counts(before[3]), now[4] * FINE);
        let excess_ma = -f64::from(fine.mean_ma) / f64::from(FINE);
        let sampled_ma = f64::from(now[1]) + 0.5 * f64::from(now[1].signum()) + excess_ma;
        let volts = |millivolts: i32| f64::from(millivolts) * 1e-3;
        let back_emf_v = |record: &[i32]| (volts(record[2]) - self.offset_v) / back_emf_gain();
        let (earlier_v, back_emf_v) = (back_emf_v(before), back_emf_v(now));
        // The legs are sampled after the current.
        let instant = CurrentInstant::of_on_time(before[3].unsigned_abs());
        let cycles = f64::from(BACK_EMF_INSTANT * TIMER_DIVIDER - instant.sampled_cycles());
        let share = cycles / f64::from(TIMER_CLOCK_HZ) / super::PERIOD_S;
        Sample {
            angle_deg: f64::from(now[0]) * 1e-3,
            command_mdeg: now[6],
            sampled_a: sampled_ma * 1e-3 - self.offset_a,
            driven: Driven {
                compare: before[3],
                supply_v: volts(now[4]),
                back_emf_v: back_emf_v - (back_emf_v - earlier_v) * share,
            },
            back_emf_v,
            compare: now[3],
            temperature_deg_c: f64::from(now[5]) * 1e-3,
        }
    }
}

/// A compare value of these counts.
fn of_counts(counts: i32) -> PwmCompare {
    let duty = percent(f64::from(counts) / f64::from(PWM_COUNTS) * 100.0);
    Modulator::default().next(duty)
}

/// The real number in an object.
pub fn real(client: &mut Client, object: &str) -> Result<f64, CommissionError> {
    match client.get(names::find(object).map_err(ClientError::from)?)? {
        Value::Real(value) => Ok(value.into()),
        _ => refuse(Step::Wiring, format!("{object} is not a real number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compare_value_is_that_of_its_counts() {
        for counts in -PWM_COUNTS..=PWM_COUNTS {
            assert_eq!(of_counts(counts).get(), counts);
        }
    }

    /// What the board makes of a sample, and back: half a mA is open by the truncation.
    #[test]
    fn a_sample_is_what_the_converter_saw() {
        let board = Board {
            ripple: Ripple::of(7.7, 1e-3),
            assumed: Winding {
                resistance_ohm: 7.7,
                inductance_h: 1e-3,
            },
            offset_a: 0.0,
            offset_v: 0.0,
        };
        for (compare, sampled_ma) in [(11_200, 423), (-28_000, -601), (0, 17), (45_000, 700)] {
            let current = board
                .ripple
                .over_period(sampled_ma, of_counts(compare), 6000);
            let before = [0, 0, 0, compare, 6000, 25_000, 0];
            let now = [0, current.mean_ma, 0, compare, 6000, 25_000, 0];
            let found_ma = board.sample(&before, &now).sampled_a * 1e3;
            assert!(
                (found_ma - f64::from(sampled_ma)).abs() < 0.51,
                "{compare}: {found_ma} mA"
            );
        }
    }
}
