//! The frequency response of an actuator, measured with a sum of sines.
//!
//! The sines are at multiples of 0.25 Hz, so that one period of 4 s settles and one is evaluated.
//! All have the same amplitude up to 1 Hz; above, it falls with the frequency, so that no sine
//! requires more rate than the one at 1 Hz.

use model_core::actuator::Actuator;
use model_core::evaluation::frequency_response::{
    FrequencyResponse, Multisine, Point, Sine, half_power_hz,
};
use model_core::time::CONTROL_RATE_HZ;
use serde::Serialize;

use crate::scenario::{Error, Scenario};

/// The period of the command, s: the inverse of the frequency of which all sines are multiples.
const PERIOD_S: u32 = 4;

/// The sines as multiples of it: 0.25 Hz to 25 Hz, spaced about evenly on a logarithmic axis.
const MULTIPLES: [u16; 23] = [
    1, 2, 3, 4, 5, 6, 7, 9, 11, 13, 16, 19, 23, 27, 32, 38, 45, 53, 61, 70, 80, 90, 100,
];

/// The corner above which the amplitude falls, as a multiple of the base frequency.
const EVEN_UNTIL: f64 = 4.0;

/// Measures the response of the actuator of a scenario, whose input is not used.
///
/// # Errors
/// [`Error::Parameter`] for parameters that exclude each other.
pub fn measure(scenario: &Scenario) -> Result<FrequencyResponse<23>, Error> {
    let settings = &scenario.run.settings;
    let command = Multisine {
        control_periods: PERIOD_S * CONTROL_RATE_HZ,
        sines: MULTIPLES.map(|multiple| Sine {
            multiple,
            amplitude_deg: scenario.amplitude_deg * f64::min(1.0, EVEN_UNTIL / f64::from(multiple)),
        }),
    };
    Ok(command.measure(Actuator::try_new(settings)?, settings.setup.delay_s))
}

/// A response by name, as JSON. A value that does not exist is `null`.
pub fn to_json(response: &FrequencyResponse<23>) -> String {
    let column = |of: fn(&Point) -> f64| response.points.iter().map(of).collect();
    crate::json(&Columns {
        frequency_hz: column(|point| point.frequency_hz),
        gain_db: column(|point| point.gain_db),
        phase_deg: column(|point| point.phase_deg),
        linear_share: response.linear_share,
        bandwidth_hz: half_power_hz(&response.points),
    })
}

#[derive(Serialize)]
struct Columns {
    frequency_hz: Vec<f64>,
    gain_db: Vec<f64>,
    phase_deg: Vec<f64>,
    linear_share: f64,
    bandwidth_hz: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use host_sim::analysis::frequency::Response;
    use host_sim::report::small_signal::SmallSignal;

    fn response(text: &str) -> FrequencyResponse<23> {
        measure(&Scenario::parse(text).unwrap()).unwrap()
    }

    fn bandwidth_hz(text: &str) -> f64 {
        half_power_hz(&response(text).points).unwrap()
    }

    #[test]
    fn the_first_order_model_has_the_gain_and_phase_of_its_pole_and_delay() {
        for delay_s in [0.0, 0.0175, 0.3] {
            let response = response(&format!("model=black-box-1&delay_s={delay_s}"));
            for point in &response.points {
                let s = point.frequency_hz * TAU / 30.0;
                // The command is held for a tick, which adds half a tick of delay.
                let delay_deg = 360.0 * point.frequency_hz * (delay_s + 25e-6);
                let phase_deg = -s.atan().to_degrees() - delay_deg;
                let gain_db = -10.0 * (1.0 + s * s).log10();
                assert!((point.gain_db - gain_db).abs() < 1e-3, "{point:?}");
                assert!((point.phase_deg - phase_deg).abs() < 0.01, "{point:?}");
            }
            // No limit is active, and the transient has decayed to e^(-30*4).
            assert!((response.linear_share - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_black_boxes_are_down_by_3_db_at_4_775_and_3_56_hz() {
        assert!((bandwidth_hz("model=black-box-1") - 4.775).abs() < 0.02);
        assert!((bandwidth_hz("model=black-box-2") - 3.56).abs() < 0.02);
    }

    #[test]
    fn the_board_with_its_encoder_stays_near_the_linear_loop() {
        // P 28.36 / (s^2 + 28.36 s + 8*28.36): 1.68 Hz without the sampling and the rate filter.
        let apart = (bandwidth_hz("") / bandwidth_hz("model=grey-box")).ln();
        assert!(apart.abs() < 0.05, "{apart}");
        let share = response("").linear_share;
        assert!(share > 0.99, "{share}");
    }

    #[test]
    fn points_of_the_board_that_the_encoder_hides_are_null_and_the_others_are_correct() {
        for (amplitude_deg, fewest, most) in [(0.3, 10, 14), (1.0, 14, 18), (3.0, 16, 20)] {
            let text = format!("amplitude_deg={amplitude_deg}");
            let settings = Scenario::parse(&text).unwrap().run.settings;
            let linear = SmallSignal::of(&settings).unwrap().unwrap().closed;
            let found = response(&text);
            let frequency_hz = found.points.map(|point| point.frequency_hz);
            let computed = Response::of(&linear, &frequency_hz);
            let mut valid = 0;
            for (i, point) in found.points.iter().enumerate() {
                assert_eq!(point.gain_db.is_nan(), point.phase_deg.is_nan());
                if point.gain_db.is_nan() {
                    continue;
                }
                valid += 1;
                // The largest errors that a motion of a third of the size causes.
                let delay_deg = 360.0 * point.frequency_hz * settings.setup.delay_s;
                let phase_error = point.phase_deg + delay_deg - computed.phase_deg[i];
                let gain_error = point.gain_db - computed.gain_db[i];
                assert!(phase_error.abs() < 19.5, "{point:?} {phase_error}");
                assert!(gain_error.abs() < 3.5, "{point:?} {gain_error}");
            }
            assert!(
                (fewest..=most).contains(&valid),
                "{amplitude_deg} deg: {valid}"
            );
        }
    }

    #[test]
    fn an_amplitude_beyond_the_limits_lowers_the_linear_share() {
        let share = response("model=black-box-1&amplitude_deg=60").linear_share;
        assert!(share < 0.99, "{share}");
    }

    #[test]
    fn an_actuator_that_does_not_move_has_no_response_and_no_bandwidth() {
        let json = to_json(&response("model=black-box-1&pole_rad_s=0"));
        assert!(json.contains(r#""gain_db":[null,"#), "{json}");
        assert!(
            json.ends_with(r#""linear_share":null,"bandwidth_hz":null}"#),
            "{json}"
        );
    }
}
